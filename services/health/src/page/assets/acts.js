"use strict";
// Operator actions: a button opens the dialog, the dialog sends, the stream shows the result.

let whoAmI = null;
/** Whoever shows a token is called as it is: the field for the name then holds that, and nothing else. */
async function sign(input) {
  whoAmI ??= fetch("/api/v1/identity").then((answer) => (answer.ok ? answer.json() : {}), () => ({}));
  const { name } = await whoAmI;
  if (!name) return;
  input.value = name;
  input.readOnly = true;
}

{
  const get = (id) => document.getElementById(id);
  const dialog = get("act-dialog");
  let asked = null;

  function remembered() {
    try {
      return localStorage.getItem("by") || "";
    } catch {
      return "";
    }
  }

  function remember(by) {
    try {
      localStorage.setItem("by", by);
    } catch {
      // Without storage the name is asked for again.
    }
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-act]");
    if (!button) return;
    const entry = button.closest(".alert");
    asked = { act: button.dataset.act, alert: button.dataset.alert };
    const words = W.act[asked.act];
    get("act-title").textContent = words.title;
    get("act-what").textContent = `${entry.querySelector(".where").textContent}: ${entry.querySelector(".reason").textContent}`;
    get("act-send").textContent = words.send;
    get("act-note-name").textContent = words.note;
    get("act-note").required = asked.act === "silence";
    get("act-note").value = "";
    get("act-silence").hidden = asked.act !== "silence";
    get("act-error").textContent = "";
    get("act-by").value = remembered();
    sign(get("act-by"));
    dialog.showModal();
    (get("act-by").value ? get("act-note") : get("act-by")).focus();
  });

  get("act-cancel").addEventListener("click", () => dialog.close());

  function body() {
    const by = get("act-by").value.trim();
    const note = get("act-note").value.trim();
    if (asked.act === "silence") return { by, why: note, duration_s: Number(get("act-for").value) };
    return note ? { by, note } : { by };
  }

  /** Why the service refused, in words and with a way out. */
  async function refusal(answer) {
    const problem = await answer.json().catch(() => ({}));
    const detail = problem.detail || problem.title || W.act.status(answer.status);
    if (answer.status === 401) return W.act.loggedOut(detail);
    if (answer.status === 403) return W.act.mayOnlyRead(detail);
    return W.act.refused(detail);
  }

  dialog.addEventListener("submit", async (event) => {
    event.preventDefault();
    get("act-send").disabled = true;
    try {
      const headers = { "content-type": "application/json" };
      const answer = await fetch(`/api/v1/alerts/${asked.alert}/${asked.act}`, { method: "POST", headers, body: JSON.stringify(body()) });
      if (answer.ok) {
        remember(get("act-by").value.trim());
        dialog.close();
        announce(W.act[asked.act].done);
      } else {
        get("act-error").textContent = await refusal(answer);
      }
    } catch {
      get("act-error").textContent = W.act.unreachable;
    } finally {
      get("act-send").disabled = false;
    }
  });
}

"use strict";
// Changes a threshold: a button opens the dialog, the dialog sends, the page loads again with what the file now says.

/** Posts a change; the page loads again if it was taken, else the reason is shown. */
async function sendChange(path, request, button, error) {
  button.disabled = true;
  try {
    const headers = { "content-type": "application/json" };
    const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(request) });
    if (answer.ok) {
      location.reload();
      return;
    }
    const said = await answer.json().catch(() => ({}));
    const detail = said.detail || W.act.status(answer.status);
    error.textContent = answer.status === 403 ? W.act.mayOnlyRead(detail) : W.act.refused(detail);
  } catch {
    error.textContent = W.act.unreachable;
  } finally {
    button.disabled = false;
  }
}

{
  const get = (id) => document.getElementById(id);
  const dialog = get("setting-dialog");
  let key = null;

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-setting]");
    if (!button || !dialog) return;
    key = button.dataset.setting;
    get("setting-what").textContent = key;
    get("setting-value").value = button.dataset.value;
    get("setting-why").value = "";
    get("setting-error").textContent = "";
    sign(get("setting-by"));
    dialog.showModal();
    get("setting-value").focus();
  });

  if (dialog) {
    get("setting-cancel").addEventListener("click", () => dialog.close());
    dialog.addEventListener("submit", (event) => {
      event.preventDefault();
      const request = { key, value: Number(get("setting-value").value), why: get("setting-why").value.trim() };
      const by = get("setting-by").value.trim();
      if (by) request.by = by;
      sendChange("/api/v1/settings", request, get("setting-send"), get("setting-error"));
    });
  }
}

"use strict";
// Notes on a vehicle: reads them, and sends what somebody writes down.
{
  const list = document.getElementById("notes");
  const form = document.getElementById("note-form");
  const get = (id) => document.getElementById(id);
  const path = () => `/api/v1/wagons/${list.dataset.wagon}/notes`;

  function entry(note) {
    const item = document.createElement("li");
    const when = document.createElement("time");
    when.dateTime = note.at;
    when.textContent = clock.full(Date.parse(note.at) / 1000);
    const who = document.createElement("b");
    who.textContent = note.by;
    const words = [note.kind === "pads_changed" ? W.notes.pads : "", note.text || ""].filter(Boolean).join(" ");
    item.append(when, " ", who, ": ", words);
    return item;
  }

  function show(answer) {
    if (answer.notes.length === 0) {
      const calm = document.createElement("p");
      calm.className = "calm";
      calm.textContent = W.notes.none;
      list.replaceChildren(calm);
      return;
    }
    const all = document.createElement("ul");
    all.className = "notes";
    all.append(...answer.notes.map(entry));
    list.replaceChildren(all);
  }

  async function problem(answer) {
    const said = await answer.json().catch(() => ({}));
    const detail = said.detail || said.title || W.act.status(answer.status);
    if (answer.status === 401) return W.act.loggedOut(detail);
    if (answer.status === 403) return W.act.mayOnlyRead(detail);
    return W.act.refused(detail);
  }

  async function load() {
    try {
      const answer = await fetch(path());
      if (answer.ok) show(await answer.json());
      else list.textContent = await problem(answer);
    } catch {
      list.textContent = W.notes.unreachable;
    }
  }

  async function send(event) {
    event.preventDefault();
    const by = get("note-by").value.trim();
    const text = get("note-text").value.trim();
    const pads = get("note-pads").checked;
    const request = { kind: pads ? "pads_changed" : "note", text: text || (pads ? W.notes.newPads : "") };
    if (by) request.by = by;
    get("note-error").textContent = "";
    try {
      const headers = { "content-type": "application/json" };
      const answer = await fetch(path(), { method: "POST", headers, body: JSON.stringify(request) });
      if (!answer.ok) {
        get("note-error").textContent = await problem(answer);
        return;
      }
      show(await answer.json());
      get("note-text").value = "";
      get("note-pads").checked = false;
      get("note-text").focus();
    } catch {
      get("note-error").textContent = W.act.unreachable;
    }
  }

  if (list && form) {
    form.addEventListener("submit", send);
    form.addEventListener("focusin", () => sign(get("note-by")), { once: true });
    load();
  }
}

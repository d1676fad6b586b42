// Adds, changes or removes a receiver of alerts. What is left open stays as the file has it.
{
  const get = (name) => document.getElementById("receiver-" + name);
  const dialog = get("dialog");
  const FIELDS = ["url", "host", "port", "topic", "ca_file"];
  const PORTS = { plain: "1883", tls: "8883" };
  let asked = null;

  /** Shows the fields that belong to what is done and to the way. */
  function arrange() {
    const kind = asked.act === "add" ? get("kind").value : asked.kind;
    const shown = asked.act === "remove" ? [] : [asked.act, "grade"];
    if (asked.act !== "remove") {
      if (asked.secret) shown.push("kept");
      else shown.push(kind);
      if (kind === "mqtt") shown.push("topic");
      if (kind === "mqtt" && !asked.secret && get("tls").checked) shown.push("tls");
    }
    for (const part of dialog.querySelectorAll("[data-for]")) part.hidden = !shown.includes(part.dataset.for);
    get("url").required = asked.act === "add" && kind === "webhook";
    get("host").required = asked.act === "add" && kind === "mqtt";
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-receiver]");
    if (!button || !dialog) return;
    const { receiver, kind, grade, address, topic, secret, tls, ca, remove } = button.dataset;
    const act = receiver === "" ? "add" : remove === undefined ? "change" : "remove";
    asked = { act, kind, secret: secret !== undefined };
    get("title").textContent = get("title").dataset[act];
    get("send").textContent = get("title").dataset[act];
    get("name").value = receiver;
    get("name").readOnly = act !== "add";
    get("kind").value = kind || "webhook";
    get("grade").value = grade || "watch";
    for (const field of FIELDS) get(field).value = "";
    // An address may carry a secret in its path, so that only its host is known here.
    get("url").placeholder = kind === "webhook" ? address + "/…" : "https://";
    const [host, port] = kind === "mqtt" ? [address.slice(0, address.lastIndexOf(":")), address.slice(address.lastIndexOf(":") + 1)] : ["", PORTS.plain];
    get("host").value = host;
    get("port").value = port;
    get("topic").value = topic || "";
    get("tls").checked = tls !== undefined;
    get("ca_file").value = ca || "";
    get("kept").textContent = W.receivers.kept(address);
    get("why").value = "";
    get("error").textContent = "";
    arrange();
    sign(get("by"));
    dialog.showModal();
    get(act === "add" ? "name" : "why").focus();
  });

  if (dialog) {
    get("kind").addEventListener("change", arrange);
    get("tls").addEventListener("change", () => {
      const [before, after] = get("tls").checked ? [PORTS.plain, PORTS.tls] : [PORTS.tls, PORTS.plain];
      if (get("port").value === before) get("port").value = after;
      arrange();
    });
    get("cancel").addEventListener("click", () => dialog.close());
    dialog.addEventListener("submit", (event) => {
      event.preventDefault();
      const request = { name: get("name").value.trim(), why: get("why").value.trim() };
      const by = get("by").value.trim();
      if (by) request.by = by;
      if (asked.act === "remove") request.remove = true;
      else {
        request.grade = get("grade").value;
        if (asked.act === "add") request.kind = get("kind").value;
        for (const field of FIELDS) {
          const input = get(field);
          if (input.closest("[hidden]") || !input.value) continue;
          request[field] = field === "port" ? Number(input.value) : input.value.trim();
        }
        const tls = get("tls");
        if (!tls.closest("[hidden]")) {
          request.tls = tls.checked;
          // Empty is a choice: the public authorities.
          if (tls.checked) request.ca_file = get("ca_file").value.trim();
        }
      }
      sendChange("/api/v1/settings/receivers", request, get("send"), get("error"));
    });
  }
}

"use strict";
// Keeps the page live: puts in place the parts that the service sends, says how the connection is, lets ages grow while
// nothing arrives. Renders nothing itself.

const SILENCE_MS = 4000; // a second passes between two events; after this the connection counts as lost
const PATIENCE_MS = 15000; // a connection that is being made may take so long: on a slow machine it does
const GRACE_MS = 5000; // the page that has just come is as fresh as its connection would be
const HIDDEN_MS = 60000; // a page that nobody sees gives its connection back: browsers allow six to a service
const RETRY_MS = [500, 1000, 2000, 3000, 5000];

const byId = (id) => document.getElementById(id);
const link = { source: null, heard: performance.now(), tries: 0, timer: 0, live: false, greeted: false, version: null, unseen: 0 };

/** Makes `old` like `fresh` and touches only what differs, so that focus, selection and listeners stay. */
function morph(old, fresh) {
  if (old.isEqualNode(fresh)) return;
  if (old.nodeType !== fresh.nodeType || old.nodeName !== fresh.nodeName) {
    old.replaceWith(fresh);
    return;
  }
  if (old.nodeType !== Node.ELEMENT_NODE) {
    old.nodeValue = fresh.nodeValue;
    return;
  }
  // What the reader has unfolded stays unfolded.
  const own = old.nodeName === "DETAILS" ? "open" : "";
  for (const { name } of [...old.attributes]) if (!fresh.hasAttribute(name) && name !== own) old.removeAttribute(name);
  for (const { name, value } of fresh.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  morphChildren(old, fresh);
}

/** Children with an `id` keep their identity when others come and go; those without are paired by place. */
function morphChildren(old, fresh) {
  const named = new Map([...old.children].filter((child) => child.id).map((child) => [child.id, child]));
  let place = old.firstChild;
  for (const child of [...fresh.childNodes]) {
    const twin = child.id ? named.get(child.id) : place && !place.id && place;
    if (!twin) {
      old.insertBefore(child, place);
      continue;
    }
    if (twin === place) place = place.nextSibling;
    else old.insertBefore(twin, place);
    morph(twin, child);
  }
  while (place) {
    const gone = place;
    place = place.nextSibling;
    gone.remove();
  }
}

/** Instants in the reader's own time zone; the service writes UTC. */
function localise(root) {
  for (const time of root.querySelectorAll("time[datetime]")) {
    const date = new Date(time.getAttribute("datetime"));
    if (!Number.isNaN(date.getTime())) time.textContent = clock.instant(date);
  }
}

function place(parts) {
  const before = new Set([...document.querySelectorAll("[data-alert]")].map((item) => item.dataset.alert));
  const focused = document.activeElement?.closest("li[data-alert]")?.id;
  const template = document.createElement("template");
  for (const [id, html] of Object.entries(parts)) {
    const old = byId(id);
    if (!old) continue;
    template.innerHTML = html;
    localise(template.content);
    morph(old, template.content.firstElementChild);
  }
  if (focused && document.activeElement === document.body) stay(focused);
  flag();
  announceNew(before);
  document.dispatchEvent(new Event("renewed"));
}

/** An alert that moved to another list takes the focus along. */
function stay(id) {
  const alert = byId(id);
  (alert?.querySelector("button[data-act]") ?? alert?.querySelector("a") ?? byId("main")).focus({ preventScroll: true });
}

/** The tab shows the alarms: their number in the title, the worst grade as the icon. */
function flag() {
  const { act, watch } = byId("alert-count").dataset;
  const count = Number(act) + Number(watch);
  const title = document.title.replace(/^\(\d+\) /, "");
  const wanted = count > 0 ? `(${count}) ${title}` : title;
  if (document.title !== wanted) document.title = wanted;
  const icon = byId("icon");
  const href = icon.dataset[Number(act) > 0 ? "act" : count > 0 ? "watch" : "ok"];
  if (icon.getAttribute("href") !== href) icon.setAttribute("href", href);
}

function announce(text) {
  byId("announcer").textContent = text;
}

/** Says new alerts aloud; figures that move are not worth interrupting anybody. */
function announceNew(before) {
  if (before.size === 0 && !link.live) return;
  const all = document.querySelectorAll("li.alert.a-active, .rest.a-active a[data-alert]");
  const fresh = [...all].filter((item) => !before.has(item.dataset.alert));
  if (fresh.length === 0) return;
  const short = (item) => `${item.textContent}. ${item.closest(".rest").querySelector("b").textContent}`;
  const whole = (item) => `${item.querySelector(".line").textContent}. ${item.querySelector(".reason").textContent}`;
  const texts = fresh.slice(0, 3).map((item) => (item.matches("a") ? short(item) : whole(item)));
  const more = fresh.length - texts.length;
  announce(W.newAlert(texts.join(" ") + (more > 0 ? ` ${W.more(more)}` : "")));
}

function say(state, text) {
  const pill = byId("link");
  if (pill.dataset.state !== state) pill.dataset.state = state;
  if (pill.textContent !== text) pill.textContent = text;
}

function heard() {
  link.heard = performance.now();
  if (link.live) return;
  const again = link.tries > 0;
  Object.assign(link, { live: true, tries: 0, greeted: true });
  document.body.classList.remove("is-lost");
  byId("lost").hidden = true;
  say("live", W.live);
  if (again) announce(W.back);
}

function connect() {
  clearTimeout(link.timer);
  if (link.source) link.source.close();
  const source = new EventSource(`/live?page=${document.documentElement.dataset.page}&lang=${document.documentElement.lang}`);
  link.source = source;
  link.opened = performance.now();
  source.addEventListener("hello", (event) => {
    const { version } = JSON.parse(event.data);
    if (link.version && link.version !== version) location.reload();
    link.version = version;
    heard();
  });
  source.addEventListener("parts", (event) => {
    place(JSON.parse(event.data));
    heard();
  });
  source.addEventListener("beat", heard);
  source.onerror = () => {
    if (link.source !== source) return;
    retry();
    askForLogin();
  };
}

/** A stream does not say why it was refused; if it was for want of a login, the reader is led there. */
async function askForLogin() {
  try {
    const answer = await fetch("/api/v1/train", { headers: { accept: "application/json" } });
    if (answer.status === 401) location.assign(`/login?next=${encodeURIComponent(location.pathname + location.search)}`);
  } catch {
    // Nobody answers: the connection is lost, and that is said already.
  }
}

function retry() {
  if (link.source) link.source.close();
  link.source = null;
  clearTimeout(link.timer);
  link.live = false;
  link.timer = setTimeout(connect, RETRY_MS[Math.min(link.tries, RETRY_MS.length - 1)]);
  link.tries += 1;
  tick();
}

/** Nobody looks: lets go of the connection; looking again brings it back at once. */
function rest() {
  clearTimeout(link.timer);
  if (link.source) link.source.close();
  Object.assign(link, { source: null, live: false });
}

function words(seconds) {
  if (seconds < 1) return W.age.less;
  if (seconds < 120) return W.age.s(Math.round(seconds));
  if (seconds < 7200) return W.age.min(Math.floor(seconds / 60));
  if (seconds < 172800) return W.age.h(Math.floor(seconds / 3600));
  return W.age.days(Math.floor(seconds / 86400));
}

/** Once a second: is the connection alive, and how old is what stands here? */
function tick() {
  const silent_ms = performance.now() - link.heard;
  const patience_ms = link.live ? SILENCE_MS : PATIENCE_MS;
  if (link.source && silent_ms > patience_ms && performance.now() - link.opened > patience_ms) return retry();
  if (link.live) return;
  const silent_s = silent_ms / 1000;
  if (silent_ms < (link.greeted ? 2000 : GRACE_MS)) return say("connecting", W.connecting);
  say("lost", W.notConnected(words(silent_s)));
  document.body.classList.add("is-lost");
  const banner = byId("lost");
  // Said once by a screen reader; the seconds count in a place of their own.
  if (banner.hidden) {
    banner.textContent = `${W.lost} `;
    banner.append(Object.assign(document.createElement("b"), { className: "since-when", ariaHidden: "true" }));
    banner.hidden = false;
  }
  banner.querySelector(".since-when").textContent = W.lastData(words(silent_s));
  for (const age of document.querySelectorAll("[data-age]")) age.textContent = words(Number(age.dataset.age) + silent_s);
}

/** Paper says where it came from, with the range of the charts. */
addEventListener("beforeprint", () => {
  const line = byId("printed-from");
  const address = typeof view === "undefined" || !byId("trends") ? location.href : view.link();
  if (line) line.textContent = W.printed(document.documentElement.dataset.train, `${clock.full(Date.now() / 1000)} (${clock.zone()})`, address);
});

/** The address of this view in another language. */
function languages() {
  for (const switcher of document.querySelectorAll("a[data-lang]")) {
    switcher.addEventListener("click", () => {
      const address = new URL(location.href);
      address.searchParams.set("lang", switcher.dataset.lang);
      switcher.href = address.href;
    });
  }
}

localise(document);
languages();
flag();
byId("zone").textContent = clock.zone();
setInterval(tick, 1000);
addEventListener("online", connect);
addEventListener("pagehide", () => link.source && link.source.close());
addEventListener("pageshow", (event) => event.persisted && connect());
document.addEventListener("visibilitychange", () => {
  clearTimeout(link.unseen);
  if (document.hidden) link.unseen = setTimeout(rest, HIDDEN_MS);
  else if (!link.source || !link.live) connect();
});
connect();

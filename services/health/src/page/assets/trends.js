"use strict";
// The trends of a wagon: its stored indicators over a range of time, renewed while the page is open.
{
  const section = document.getElementById("trends");
  const STEPS = { 900: 3, 3600: 10, 21600: 60, 86400: 300, 604800: 1800, 2592000: 7200 };
  const state = { range: 3600, charts: null, timer: 0, asked: 0 };
  const limits = (text, factor = 1) => (text || "").split(" ").map((end) => (end === "" ? null : factor * Number(end)));
  const wheelsets = () => Array.from({ length: Number(section.dataset.wheelsets) || 2 }, (_, index) => index + 1);

  /** What is drawn: title, limits and lines, each line a field of the history. */
  function specs() {
    const limit = JSON.parse(section.dataset.limits || "{}");
    const each = (field, name) => wheelsets().map((n) => ({ name: `${name} ${n}`, field: `wheelset_${n}.${field}` }));
    const with95 = (line) => ({ ...line, band: "interval" });
    const extremes = (line) => ({ ...line, band: "extremes", bandName: "extreme" });
    const percent = { factor: 100, digits: 1, unit: "%", floor: 0 };
    return [
      { title: "Pad friction", about: "mean over braking; band: 95 % interval", limits: limits(limit.brake_friction), lines: each("brake_friction", "wheelset").map(with95) },
      { title: "Front minus rear", about: "over their mean; band: 95 % interval", ...percent, floor: undefined, limits: limits(limit.asymmetry, 100),
        lines: [with95({ name: "asymmetry", field: "asymmetry" })] },
      { title: "Adhesion", about: "available: a lower bound unless a wheelset slides; band: 95 % interval", floor: 0,
        lines: [with95({ name: "available", field: "adhesion_available" }), { name: "used", field: "adhesion_utilised" }] },
      { title: "Pad friction at standard conditions", about: "band: 95 % interval", limits: limits(limit.brake_friction),
        lines: [with95({ name: "wagon", field: "brake_friction_standard" })] },
      { title: "Drag when released", about: "beyond running resistance; band: 95 % interval", factor: 1e-3, digits: 1, unit: "kN", limits: limits(limit.dragging_n, 1e-3),
        lines: [with95({ name: "drag", field: "dragging_n" })] },
      { title: "Brake builds up in", about: "to 90 % of its force", digits: 1, unit: "s", floor: 0, limits: limits(limit.response_s),
        lines: [{ name: "time", field: "response_s", band: "interval", bandName: "spread" }] },
      { title: "Low or very low rail", about: "probability", ...percent, ceiling: 100, lines: [{ name: "low", field: "rail_low" }, { name: "very low", field: "rail_very_low" }] },
      { title: "Braking with slide protection", about: "share of the latest braking; band: extremes", ...percent, limits: limits(limit.wsp_share, 100),
        lines: [extremes({ name: "share", field: "wsp_share" })] },
      { title: "Slide energy", about: "of all slides so far", factor: 1e-6, digits: 2, unit: "MJ", floor: 0, lines: each("slide_energy_j", "wheelset") },
      { title: "Faulty sensor values", about: "share missing or refused; band: extremes", ...percent, limits: limits(limit.sensors, 100),
        lines: [extremes({ name: "share", field: "sensors" })] },
      { title: "Filter", about: "mean normalised innovation squared, 1 is ideal; band: extremes", digits: 2, floor: 0, limits: limits(limit.filter),
        lines: [extremes({ name: "NIS", field: "filter" })] },
    ];
  }

  function columns(spec, history) {
    const factor = spec.factor || 1;
    const scaled = (values) => values.map((value) => (value === null || value === undefined ? null : factor * value));
    const empty = history.unix_s.map(() => null);
    const found = [history.unix_s];
    for (const line of spec.lines) {
      const series = history.indicators[line.field];
      found.push(series ? scaled(series.value) : empty);
      if (line.band === "interval") found.push(scaled(series?.low || empty), scaled(series?.high || empty));
      if (line.band === "extremes") found.push(scaled(series?.min || empty), scaled(series?.max || empty));
    }
    return found;
  }

  function tell(text, bad = false) {
    const line = document.getElementById("trend-state");
    line.classList.toggle("loud", bad);
    if (line.textContent !== text) line.textContent = text;
  }

  function draw(history) {
    if (!state.charts) {
      const host = document.getElementById("charts");
      state.charts = specs().map((spec) => ({ spec, chart: charts.make(host, { ...spec, sync: "trends" }) }));
    }
    for (const { spec, chart } of state.charts) chart.update(columns(spec, history));
    const filled = history.samples.filter((count) => count > 0).length;
    const share = Math.round((100 * filled) / Math.max(1, history.samples.length));
    tell(filled === 0
      ? "No history for this range: the train was off, or it has just started. The first figures appear within a minute."
      : `Steps of ${history.step_s} s. Data for ${share} % of the range; shaded: no data.`);
  }

  async function load() {
    clearTimeout(state.timer);
    const asked = ++state.asked;
    const step = STEPS[state.range];
    const to = Math.ceil(Date.now() / 1000 / step) * step;
    const fields = [...new Set(specs().flatMap((spec) => spec.lines.map((line) => line.field)))];
    const url = `/api/v1/wagons/${section.dataset.wagon}/history?from=${to - state.range}&to=${to}&step=${step}&fields=${fields.join(",")}`;
    try {
      const answer = await fetch(url, { headers: { accept: "application/json" } });
      const body = await answer.json();
      if (asked !== state.asked) return;
      if (answer.ok) draw(body);
      else tell(`No history: ${body.detail || body.title || answer.status}`, true);
    } catch {
      if (asked === state.asked) tell("The history cannot be loaded: the service does not answer. Retrying…", true);
    }
    if (asked === state.asked) state.timer = setTimeout(() => (document.hidden ? wait() : load()), Math.min(60, Math.max(5, step)) * 1000);
  }

  /** Nobody looks: goes on when somebody does. */
  function wait() {
    document.addEventListener("visibilitychange", load, { once: true });
  }

  const OUTLOOK_MS = 60000;
  const EVENTS_MS = 15000;

  /** Calls `work` now and again and again, but not while nobody looks. */
  function again(work, period) {
    const round = async () => {
      try {
        await work();
      } catch {
        // The connection is lost: the banner says so, the next round tries again.
      }
      setTimeout(() => (document.hidden ? document.addEventListener("visibilitychange", round, { once: true }) : round()), period);
    };
    round();
  }

  /** The table of trends comes rendered. */
  async function outlook() {
    const answer = await fetch(`/wagons/${section.dataset.wagon}/outlook`);
    if (answer.ok) return place({ outlook: await answer.text() });
    const problem = await answer.json().catch(() => ({}));
    document.getElementById("outlook").replaceChildren(line("p", "calm", `No trends: ${problem.detail || answer.status}`));
  }

  function line(kind, name, text) {
    return Object.assign(document.createElement(kind), { className: name, textContent: text });
  }

  async function events() {
    const host = document.getElementById("events");
    const answer = await fetch(`/api/v1/events?wagon=${section.dataset.wagon}&limit=12`, { headers: { accept: "application/json" } });
    const body = await answer.json().catch(() => ({}));
    if (!answer.ok) return host.replaceChildren(line("p", "calm", `No events: ${body.detail || answer.status}`));
    const list = line("ul", "course", "");
    for (const event of body.events) {
      const item = document.createElement("li");
      const time = line("time", "", event.at);
      time.setAttribute("datetime", event.at);
      const set = event.wheelset ? `wheelset ${event.wheelset}: ` : "";
      item.append(time, ` ${set}${event.text}`);
      list.append(item);
    }
    localise(list);
    host.replaceChildren(body.events.length ? list : line("p", "calm", "No events for this wagon yet."));
  }

  function choose(button) {
    state.range = Number(button.dataset.range);
    for (const other of section.querySelectorAll("[data-range]")) other.setAttribute("aria-pressed", String(other === button));
    load();
  }

  if (section) {
    section.addEventListener("click", (event) => {
      const button = event.target.closest("[data-range]");
      if (button) choose(button);
    });
    load();
    again(outlook, OUTLOOK_MS);
    if (document.getElementById("events")) again(events, EVENTS_MS);
  }
}

"use strict";
// The trends of a wagon: its stored indicators over a range of time, beside those of other wagons, renewed while the page
// is open.
{
  const section = document.getElementById("trends");
  const own = Number(section?.dataset.wagon);
  const MOST_BESIDE = 4;
  const USUAL = ["pad", "adhesion"];
  const COARSER_S = [60, 3600];
  const get = (id) => document.getElementById(id);
  const narrow = matchMedia("(max-width: 40rem)");
  const fold = get("trends-fold");
  const state = { charts: new Map(), timer: 0, asked: 0, shown: null };
  const limits = (text, factor = 1) => (text || "").split(" ").map((end) => (end === "" ? null : factor * Number(end)));

  /** What can be drawn: limits and lines, each line a field of the history. */
  function specs() {
    const limit = JSON.parse(section.dataset.limits || "{}");
    const wheelsets = Array.from({ length: Number(section.dataset.wheelsets) || 2 }, (_, index) => index + 1);
    const each = (field, band) => wheelsets.map((n) => ({ name: W.chart.wheelset(n), field: `wheelset_${n}.${field}`, band }));
    const one = (name, field, band) => [{ name, field, band }];
    const percent = { factor: 100, digits: 1, unit: "%", floor: 0 };
    const all = {
      pad: { limits: limits(limit.brake_friction), lines: each("brake_friction", "interval"), also: ["brake_friction"] },
      asymmetry: { ...percent, floor: undefined, limits: limits(limit.asymmetry, 100), lines: one(LINES.asymmetry, "asymmetry", "interval") },
      adhesion: { floor: 0, lines: [...one(LINES.available, "adhesion_available", "interval"), ...one(LINES.used, "adhesion_utilised")] },
      standard: { limits: limits(limit.brake_friction), lines: one(LINES.wagon, "brake_friction_standard", "interval") },
      drag: { factor: 1e-3, digits: 1, unit: "kN", limits: limits(limit.dragging_n, 1e-3), lines: one(LINES.drag, "dragging_n", "interval") },
      response: { digits: 1, unit: "s", floor: 0, limits: limits(limit.response_s), lines: one(LINES.time, "response_s", "interval") },
      rail: { ...percent, ceiling: 100, lines: [...one(LINES.low, "rail_low"), ...one(LINES.veryLow, "rail_very_low")], also: ["rail"] },
      wsp: { ...percent, limits: limits(limit.wsp_share, 100), lines: one(LINES.share, "wsp_share", "extremes") },
      slides: { factor: 1e-6, digits: 2, unit: "MJ", floor: 0, lines: each("slide_energy_j"), also: ["slides"] },
      flat: { factor: 1e3, digits: 2, unit: "‰", floor: 0, limits: limits(limit.wheel_flat, 1e3), lines: each("wheel_flat", "interval"), also: ["wheel_flat"] },
      sensors: { ...percent, limits: limits(limit.sensors, 100), lines: one(LINES.share, "sensors", "extremes") },
      disc: { digits: 0, unit: "K", floor: 0, lines: each("disc_rise_k", "interval") },
      filter: { digits: 2, floor: 0, limits: limits(limit.filter), lines: one(LINES.nis, "filter", "extremes"), also: ["model"] },
    };
    return Object.entries(all).map(([key, spec]) => ({ key, title: CHARTS[key][0], about: CHARTS[key][1], axis: CHARTS[key][2], ...spec }));
  }

  /** The charts that are shown: as chosen, else those of what is wrong with the wagon, else the usual ones. */
  function chosen() {
    if (view.now.charts) return view.now.charts;
    const wrong = (section.dataset.first || "").split(" ").filter(Boolean);
    const shows = (spec, field) => spec.also?.includes(field) || spec.lines.some((line) => line.field === field);
    const keys = wrong.map((field) => specs().find((spec) => shows(spec, field))?.key).filter(Boolean);
    return [...new Set([...keys, ...USUAL])].slice(0, narrow.matches ? 1 : 2);
  }

  const beside = () => view.now.beside.filter((id) => id !== own && id <= Number(section.dataset.wagons)).slice(0, MOST_BESIDE);

  /** Lines of all wagons that are compared: a colour a wagon, a dash a line; only this wagon keeps its bands. */
  function compared(spec, wagons) {
    if (wagons.length === 1) return spec.lines.map((line) => ({ ...line, wagon: own }));
    const inks = ["accent", "c2", "c3", "c4", "c5"];
    return wagons.flatMap((wagon, at) => spec.lines.map((line, dash) => ({
      ...line, wagon, dash, ink: inks[at % inks.length], band: wagon === own ? line.band : undefined,
      name: spec.lines.length > 1 ? `${W.chart.wagon(wagon)}, ${line.name}` : W.chart.wagon(wagon),
    })));
  }

  function columns(spec, histories) {
    const factor = spec.factor || 1;
    const times = histories.get(own).unix_s;
    const scaled = (values) => times.map((_, i) => (plot.known(values?.[i]) ? factor * values[i] : null));
    const found = [times];
    for (const line of spec.lines) {
      const series = histories.get(line.wagon)?.indicators[line.field];
      found.push(scaled(series?.value));
      if (line.band === "interval") found.push(scaled(series?.low), scaled(series?.high));
      if (line.band === "extremes") found.push(scaled(series?.min), scaled(series?.max));
    }
    return found;
  }

  function tell(text, bad = false) {
    const line = get("trend-state");
    line.classList.toggle("loud", bad);
    if (line.textContent !== text) line.textContent = text;
  }

  const stepWords = (s) => (s < 60 ? W.age.s(s) : s < 3600 ? W.age.min(s / 60) : s < 86400 ? W.age.h(s / 3600) : W.age.days(s / 86400));

  /** Makes the charts anew when other ones are chosen or other wagons are compared. */
  function prepare() {
    const wagons = [own, ...beside()];
    const keys = chosen();
    const shape = `${keys.join()}|${wagons.join()}`;
    if (state.shown === shape) return;
    state.shown = shape;
    for (const { remove } of state.charts.values()) remove();
    state.charts.clear();
    const source = () => {
      const { from_s, to_s } = view.asked();
      const others = wagons.map((id) => `, ${W.chart.wagon(id)}`).join("");
      return W.chart.from(document.documentElement.dataset.train, others, `${clock.span(from_s, to_s)} (${clock.zone()})`);
    };
    for (const key of keys) {
      const spec = specs().find((one) => one.key === key);
      if (!spec) continue;
      const lines = compared(spec, wagons);
      state.charts.set(key, charts.make(get("charts"), { ...spec, lines, sync: "trends", source, onZoom: view.zoom, onBack: () => history.back() }));
    }
    marks();
  }

  /** Buttons say what is chosen. */
  function marks() {
    const keys = chosen();
    for (const pick of get("picks").children) pick.setAttribute("aria-pressed", String(keys.includes(pick.dataset.chart)));
    for (const button of section.querySelectorAll("[data-range]")) {
      button.setAttribute("aria-pressed", String(!view.now.fixed && Number(button.dataset.range) === view.now.range_s));
    }
    const field = get("beside");
    if (field && document.activeElement !== field) field.value = beside().join(", ");
  }

  function draw(histories, asked) {
    for (const chart of state.charts.values()) chart.update(columns(chart.spec, histories));
    const first = histories.get(own);
    const filled = first.samples.filter((count) => count > 0).length;
    const span = clock.span(asked.from_s, asked.to_s);
    if (filled === 0) {
      const stored = first.stored_from ? W.trends.stored(clock.full(Date.parse(first.stored_from) / 1000)) : W.trends.nothingYet;
      return tell(W.trends.empty(span, stored));
    }
    const share = Math.round((100 * filled) / Math.max(1, first.samples.length));
    tell([W.trends.steps(stepWords(first.step_s), share, span), share < 100 ? W.trends.shaded : ""].filter(Boolean).join(" "));
    get("trend-hint").textContent = matchMedia("(pointer: fine)").matches ? W.trends.hint : "";
  }

  async function historyOf(wagon, { from_s, to_s, step_s }, fields) {
    const url = `/api/v1/wagons/${wagon}/history?from=${from_s}&to=${to_s}&step=${step_s}&fields=${fields.join(",")}`;
    const answer = await fetch(url, { headers: { accept: "application/json" } });
    const body = await answer.json();
    if (!answer.ok) throw Object.assign(new Error(body.detail || body.title || answer.status), { refused: true });
    return body;
  }

  /**
   * What every wagon has for the range; where the fine steps are gone by age, coarser ones. A range that ends now has lost
   * nothing to age: where it is empty, the train is young, and a whole minute would stand for its first seconds.
   */
  async function fetched(asked) {
    const fields = [...new Set([...state.charts.values()].flatMap(({ spec }) => spec.lines.map((line) => line.field)))];
    const first = await historyOf(own, asked, fields);
    const coarser_s = COARSER_S.find((step_s) => step_s > asked.step_s);
    const old = asked.to_s < Date.now() / 1000 - coarser_s;
    if (!first.samples.some((count) => count > 0) && old && (asked.to_s - asked.from_s) / coarser_s >= 2) {
      const again = { step_s: coarser_s, from_s: Math.floor(asked.from_s / coarser_s) * coarser_s, to_s: Math.ceil(asked.to_s / coarser_s) * coarser_s };
      const found = await fetched(again);
      if (found.get(own).samples.some((count) => count > 0)) return found;
    }
    const others = beside();
    const rest = await Promise.all(others.map((wagon) => historyOf(wagon, asked, fields)));
    return new Map([[own, first], ...others.map((wagon, i) => [wagon, rest[i]])]);
  }

  async function load() {
    clearTimeout(state.timer);
    if (!fold.open) return;
    prepare();
    const mine = ++state.asked;
    const asked = view.asked();
    try {
      const histories = await fetched(asked);
      if (mine !== state.asked) return;
      draw(histories, asked);
    } catch (error) {
      if (mine === state.asked) tell(error.refused ? W.trends.refused(error.message) : W.trends.unreachable, true);
    }
    // A range that lies in the past does not change any more.
    const over = view.now.fixed && view.now.fixed.to_s < Date.now() / 1000 - 120;
    if (mine === state.asked && !over) state.timer = setTimeout(() => (document.hidden ? wait() : load()), Math.min(60, Math.max(5, asked.step_s)) * 1000);
  }

  /** Nobody looks: goes on when somebody does. */
  function wait() {
    document.addEventListener("visibilitychange", load, { once: true });
  }

  function pick(key) {
    const keys = chosen();
    const next = keys.includes(key) ? keys.filter((one) => one !== key) : [...keys, key];
    view.choose(next.length ? next : [key]);
  }

  /** `2, 5` as wagons to compare with. */
  function compare(text) {
    const count = Number(section.dataset.wagons);
    const ids = text.split(/[\s,;]+/).filter(Boolean).map(Number);
    const wrong = ids.some((id) => !Number.isInteger(id) || id < 1 || id > count);
    get("beside-wrong").textContent = wrong ? W.trends.noWagon(text, count) : "";
    if (!wrong) view.compare([...new Set(ids.filter((id) => id !== own))].slice(0, MOST_BESIDE));
  }

  async function copy() {
    const link = view.link();
    try {
      await navigator.clipboard.writeText(link);
      get("copied").textContent = W.trends.copied;
    } catch {
      history.replaceState(null, "", link);
      get("copied").textContent = W.trends.notCopied;
    }
  }

  if (section) {
    // On a phone the charts wait for a finger, unless a link leads to them.
    fold.open = !narrow.matches || location.hash === "#trends" || location.search !== "";
    fold.addEventListener("toggle", load);
    for (const { key, title } of specs()) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: title });
      button.dataset.chart = key;
      get("picks").append(button);
    }
    const act = { range: (value) => view.follow(Number(value)), chart: pick, move: (by) => view.move({ by: Number(by) }), times: (times) => view.move({ times: Number(times) }), copy };
    section.addEventListener("click", (event) => {
      const button = event.target.closest("button[data-range], button[data-chart], button[data-move], button[data-times], button[data-copy]");
      const [name, value] = Object.entries(button?.dataset ?? {})[0] ?? [];
      act[name]?.(value);
    });
    get("beside")?.addEventListener("change", (event) => compare(event.target.value));
    view.listen(() => {
      marks();
      load();
    });
    load();
  }
}

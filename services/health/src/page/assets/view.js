"use strict";
// What the charts of a wagon show: the range of time, the wagons beside each other, the charts. All of it stands in the
// address, so that a link leads to exactly this view, and the browser's "back" undoes a zoom.
const view = (() => {
  const USUAL_S = 3600;
  const RANGES_S = [900, 3600, 21600, 86400, 604800, 2592000];
  const LEAST_S = 20;
  const MOST_S = 3653 * 86400;
  const STEPS_S = [1, 2, 5, 10, 30, 60, 300, 600, 1800, 3600, 10800, 21600, 43200, 86400];
  const POINTS = 400;
  const listeners = [];

  /** Unix seconds from an address: RFC 3339 or seconds. */
  const instant = (text) => (/^\d+(\.\d+)?$/.test(text) ? Number(text) : Date.parse(text) / 1000);

  function read() {
    const query = new URLSearchParams(location.search);
    const [from_s, to_s] = ["from", "to"].map((name) => instant(query.get(name) ?? ""));
    const range_s = Number(query.get("range"));
    return {
      fixed: from_s < to_s ? { from_s, to_s } : null,
      range_s: RANGES_S.includes(range_s) ? range_s : USUAL_S,
      beside: (query.get("with") ?? "").split(",").map(Number).filter((id) => Number.isInteger(id) && id > 0),
      charts: query.get("charts")?.split(",").filter((key) => key in CHARTS) ?? null,
    };
  }

  let now = read();

  /** The address of a view; with `still`, one that stays where it is while time goes on. */
  function address(wanted, still = false) {
    const query = new URLSearchParams();
    const fixed = wanted.fixed ?? (still ? ends(wanted) : null);
    if (fixed) {
      query.set("from", clock.iso(Math.round(fixed.from_s)));
      query.set("to", clock.iso(Math.round(fixed.to_s)));
    } else if (wanted.range_s !== USUAL_S) query.set("range", wanted.range_s);
    if (wanted.beside.length) query.set("with", wanted.beside.join(","));
    if (wanted.charts) query.set("charts", wanted.charts.join(","));
    const text = query.toString().replaceAll("%3A", ":").replaceAll("%2C", ",");
    return location.pathname + (text ? `?${text}` : "") + location.hash;
  }

  function ends({ fixed, range_s }) {
    if (fixed) return fixed;
    const to_s = Date.now() / 1000;
    return { from_s: to_s - range_s, to_s };
  }

  /** The span with a step that gives enough points and not too many. */
  function asked() {
    const { from_s, to_s } = ends(now);
    const step_s = STEPS_S.find((step) => (to_s - from_s) / step <= POINTS) ?? STEPS_S.at(-1);
    return { from_s: Math.floor(from_s / step_s) * step_s, to_s: Math.ceil(to_s / step_s) * step_s, step_s };
  }

  function set(change) {
    now = { ...now, ...change };
    const next = address(now);
    if (next !== location.pathname + location.search + location.hash) history.pushState(null, "", next);
    listeners.forEach((listen) => listen(Object.keys(change)));
  }

  function zoom(from_s, to_s) {
    const middle = (from_s + to_s) / 2;
    const half = Math.min(Math.max(to_s - from_s, LEAST_S), MOST_S) / 2;
    set({ fixed: { from_s: middle - half, to_s: middle + half } });
  }

  /** By so many widths to the right, or so many times as wide. */
  function move({ by = 0, times = 1 }) {
    const { from_s, to_s } = ends(now);
    const [width, middle] = [to_s - from_s, (from_s + to_s) / 2 + by * (to_s - from_s)];
    zoom(middle - (times * width) / 2, middle + (times * width) / 2);
  }

  addEventListener("popstate", () => {
    now = read();
    listeners.forEach((listen) => listen(["fixed", "range_s", "beside", "charts"]));
  });

  return {
    get now() { return now; },
    asked, zoom, move,
    follow: (range_s) => set({ fixed: null, range_s }),
    compare: (beside) => set({ beside }),
    choose: (keys) => set({ charts: keys }),
    listen: (listener) => listeners.push(listener),
    link: () => location.origin + address(now, true),
  };
})();

"use strict";
// Adhesion along the track: the median with its 95 % band over the kilometre, low stretches shaded.
{
  // The page of meanings has a heading of that name.
  const host = document.querySelector("#map[data-library]");
  const LOW_FROM = 0.5;
  const state = { chart: null, cells: [], timer: 0 };

  /** Shades what is low, behind the axes' labels and over nothing else. */
  function shade(u, colour) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.fillStyle = colour("watch", 0.3);
    for (const cell of state.cells) {
      if (cell.low_probability < LOW_FROM) continue;
      const [left, right] = [cell.from_m, cell.to_m].map((m) => u.valToPos(m / 1000, "x", true));
      const [a, b] = [Math.max(left, bbox.left), Math.min(right, bbox.left + bbox.width)];
      if (b > a) ctx.fillRect(a, bbox.top, b - a, bbox.height);
    }
    ctx.restore();
  }

  function spec() {
    const [title, about, axis, xLabel] = CHARTS.map;
    const source = () => W.chart.from(document.documentElement.dataset.train, "", clock.full(Date.now() / 1000));
    return { key: "map", title, about, axis, xLabel, positions: true, floor: 0, lines: [{ name: LINES.available, band: true }], draw: [shade], source };
  }

  /** Fetches what draws; the page itself does without. */
  async function drawing() {
    for (const src of [host.dataset.library, host.dataset.charts]) {
      await new Promise((done, failed) => {
        document.head.append(Object.assign(document.createElement("script"), { src, onload: done, onerror: failed }));
      });
    }
    return charts.make(host, spec(), 190);
  }

  /** Columns with a hole wherever nobody passed. */
  function columns(view) {
    const found = [[], [], [], []];
    let end = null;
    for (const cell of view.cells) {
      if (end !== null && cell.from_m - end > 0.5 * view.cell_m) [end / 1000, null, null, null].forEach((value, i) => found[i].push(value));
      [(cell.from_m + cell.to_m) / 2000, cell.adhesion, cell.low, cell.high].forEach((value, i) => found[i].push(value));
      end = cell.to_m;
    }
    return found;
  }

  async function load() {
    clearTimeout(state.timer);
    try {
      const answer = await fetch("/api/v1/train/adhesion-map", { headers: { accept: "application/json" } });
      const view = await answer.json();
      if (answer.ok && view.cells.length > 1) {
        state.cells = view.cells;
        state.chart ??= await drawing();
        state.chart.update(columns(view));
      }
    } catch {
      // The banner of the connection says so already; the next round tries again.
    }
    state.timer = setTimeout(() => (document.hidden ? document.addEventListener("visibilitychange", load, { once: true }) : load()), 5000);
  }

  if (host) load();
}

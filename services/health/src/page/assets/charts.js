"use strict";
// Charts: lines with their 95 % band, gaps as gaps, limits as dashed lines with a word, a summary for those who listen and a
// table for those who want figures. uPlot draws; this tells it what.
const charts = (() => {
  const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]];
  const probe = document.createElement("span");
  probe.hidden = true;
  document.body.append(probe);

  /** A colour of the style sheet as the canvas takes it, in the theme of the moment. */
  function colour(name, alpha = 1) {
    probe.style.color = `color-mix(in srgb, var(--${name}) ${100 * alpha}%, transparent)`;
    return getComputedStyle(probe).color;
  }

  const known = (value) => value !== null && value !== undefined;
  const format = (value, spec) => (known(value) ? value.toFixed(spec.digits ?? 3).replace("-", "−") + (spec.unit ? ` ${spec.unit}` : "") : "–");

  /** The span that shows the data and, of the limits, those nearest to them. */
  function span(spec, data) {
    let [low, high] = [Infinity, -Infinity];
    for (const column of data.slice(1)) {
      for (const value of column) {
        if (!known(value)) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    if (low > high) [low, high] = spec.empty || [0, 1];
    const [, watchLow, watchHigh] = spec.limits || [];
    if (known(watchLow)) low = Math.min(low, watchLow);
    if (known(watchHigh)) high = Math.max(high, watchHigh);
    if (known(spec.floor)) low = Math.min(low, spec.floor);
    if (known(spec.ceiling)) high = Math.max(high, spec.ceiling);
    const room = (high - low || Math.abs(high) || 1) * 0.07;
    return [low === spec.floor ? low : low - room, high + room];
  }

  /** Places without data, shaded, so that a gap is seen as one. */
  function drawGaps(u, spec) {
    const { ctx, bbox } = u;
    const times = u.data[0];
    if (times.length === 0 || spec.positions) return;
    const step = times.length > 1 ? times[1] - times[0] : 1;
    ctx.save();
    ctx.fillStyle = colour("unknown", 0.14);
    let from = null;
    for (let i = 0; i <= times.length; i += 1) {
      const empty = i < times.length && u.data.slice(1).every((column) => !known(column[i]));
      if (empty && from === null) from = i;
      if (!empty && from !== null) {
        const left = u.valToPos(times[from] - step / 2, "x", true);
        const right = u.valToPos(times[i - 1] + step / 2, "x", true);
        const [a, b] = [Math.max(left, bbox.left), Math.min(right, bbox.left + bbox.width)];
        if (b > a) ctx.fillRect(a, bbox.top, b - a, bbox.height);
        if (b - a > 70 * devicePixelRatio) write(ctx, "no data", (a + b) / 2, bbox.top + 14 * devicePixelRatio, "center", colour("soft"));
        from = null;
      }
    }
    ctx.restore();
  }

  function write(ctx, text, x, y, align, fill) {
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = align;
    ctx.fillStyle = fill;
    ctx.fillText(text, x, y);
  }

  function drawLimits(u, spec) {
    const { ctx, bbox } = u;
    const names = ["act", "watch", "watch", "act"];
    ctx.save();
    ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.lineWidth = 1.5 * devicePixelRatio;
    (spec.limits || []).forEach((limit, index) => {
      if (!known(limit)) return;
      const y = u.valToPos(limit, "y", true);
      if (y < bbox.top || y > bbox.top + bbox.height) return;
      ctx.strokeStyle = colour(names[index]);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      const below = index < 2;
      const text = below ? `${names[index]} below` : `${names[index]} above`;
      write(ctx, text, bbox.left + bbox.width - 4 * devicePixelRatio, y + (below ? 12 : -4) * devicePixelRatio, "right", colour(`${names[index]}-text`));
    });
    ctx.restore();
  }

  /** Columns for uPlot: of each line its value, and the ends of its band if it has one. */
  function layout(spec) {
    const series = [{ label: spec.positions ? "km" : "Time" }];
    const bands = [];
    spec.lines.forEach((line, index) => {
      const ink = line.colour || ["accent", "c2", "c3", "c4"][index % 4];
      const paint = { stroke: () => colour(ink), width: 2, dash: DASHES[index % DASHES.length], spanGaps: false };
      series.push({ label: line.name, ...paint, points: { show: false }, value: (_, value) => format(value, spec) });
      if (!line.band) return;
      const edge = { stroke: () => colour(ink, 0.35), width: 0.5, points: { show: false }, spanGaps: false };
      const name = line.bandName || "95 %";
      series.push({ label: `${name} low`, ...edge, value: (_, value) => format(value, spec) });
      series.push({ label: `${name} high`, ...edge, value: (_, value) => format(value, spec) });
      bands.push({ series: [series.length - 1, series.length - 2], fill: () => colour(ink, 0.17) });
    });
    return { series, bands };
  }

  function options(spec, width, height) {
    const axis = { stroke: () => colour("soft"), grid: { stroke: () => colour("line"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 },
      font: "12px system-ui, sans-serif" };
    const values = (u, splits) => splits.map((value) => (known(value) ? `${+value.toPrecision(6)}`.replace("-", "−") : ""));
    return {
      width, height, ...layout(spec),
      scales: { x: { time: !spec.positions }, y: { range: (u) => span(spec, u.data) } },
      axes: [{ ...axis, ...(spec.positions ? { values, label: spec.xLabel, labelSize: 20, size: 36 } : {}) }, { ...axis, size: 56, values }],
      cursor: { sync: spec.sync ? { key: spec.sync } : undefined, drag: { x: false, y: false } },
      legend: { live: true },
      hooks: { drawClear: [(u) => drawGaps(u, spec)], draw: [(u) => drawLimits(u, spec), ...(spec.draw || []).map((draw) => (u) => draw(u, colour))] },
    };
  }

  /** What the chart shows, in a sentence. */
  function summary(spec, data) {
    const parts = [];
    let column = 1;
    for (const line of spec.lines) {
      const values = data[column].filter(known);
      column += line.band ? 3 : 1;
      if (values.length === 0) parts.push(`${line.name}: no data`);
      else parts.push(`${line.name}: last ${format(values.at(-1), spec)}, lowest ${format(Math.min(...values), spec)}, highest ${format(Math.max(...values), spec)}`);
    }
    const gaps = data[0].filter((_, i) => data.slice(1).every((values) => !known(values[i]))).length;
    const share = data[0].length ? Math.round((100 * gaps) / data[0].length) : 100;
    return `${spec.title}. ${parts.join("; ")}. ${share} % of the range has no data.`;
  }

  function fillTable(host, spec, data) {
    const every = Math.max(1, Math.ceil(data[0].length / 60));
    const table = document.createElement("table");
    const head = table.createTHead().insertRow();
    const names = [spec.positions ? spec.xLabel : "Time", ...layout(spec).series.slice(1).map((series) => series.label)];
    for (const name of names) head.append(Object.assign(document.createElement("th"), { textContent: name, scope: "col" }));
    const body = table.createTBody();
    for (let i = 0; i < data[0].length; i += every) {
      const row = body.insertRow();
      const first = spec.positions ? `${data[0][i]}` : new Date(1000 * data[0][i]).toLocaleString();
      [first, ...data.slice(1).map((column) => format(column[i], spec))].forEach((text) => { row.insertCell().textContent = text; });
    }
    host.replaceChildren(table);
  }

  /** A chart in `host`; gives what renews it. */
  function make(host, spec, height = 210) {
    const figure = document.createElement("figure");
    figure.className = "chart";
    const caption = document.createElement("figcaption");
    caption.textContent = spec.title;
    if (spec.about) caption.append(Object.assign(document.createElement("small"), { textContent: spec.about }));
    const plot = Object.assign(document.createElement("div"), { className: "plot" });
    plot.setAttribute("role", "img");
    const details = document.createElement("details");
    const table = document.createElement("div");
    details.append(Object.assign(document.createElement("summary"), { textContent: "As a table" }), table);
    figure.append(caption, plot, details);
    host.append(figure);
    let data = [[], ...layout(spec).series.slice(1).map(() => [])];
    const u = new uPlot(options(spec, Math.max(240, plot.clientWidth), height), data, plot);
    const watch = new ResizeObserver(() => {
      const width = plot.clientWidth;
      if (width > 0 && width !== u.width) u.setSize({ width, height });
    });
    watch.observe(plot);
    const redraw = () => u.redraw(false);
    document.addEventListener("themechange", redraw);
    details.addEventListener("toggle", () => details.open && fillTable(table, spec, data));
    return {
      figure,
      update(fresh) {
        data = fresh;
        u.setData(data);
        plot.setAttribute("aria-label", summary(spec, data));
        if (details.open) fillTable(table, spec, data);
      },
    };
  }

  return { make, colour, known };
})();

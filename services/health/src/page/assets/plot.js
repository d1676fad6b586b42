"use strict";
// What uPlot is told: lines with their 95 % band, gaps as gaps, limits with a word that nothing crosses.
const plot = (() => {
  const DASHES = [[], [7, 4], [2, 3], [10, 3, 2, 3]];
  const INKS = ["accent", "c2", "c3", "c4", "c5"];
  /** Of the span of the lines, or of the band's usual width, so much of the band is shown: the rest would flatten the lines. */
  const MOST_BAND = 0.5;
  const probe = document.createElement("span");
  probe.hidden = true;
  document.body.append(probe);

  /** A colour of the style sheet as the canvas takes it, in the theme of the moment. */
  function colour(name, alpha = 1) {
    probe.style.color = `color-mix(in srgb, var(--${name}) ${100 * alpha}%, transparent)`;
    return getComputedStyle(probe).color;
  }

  const known = (value) => value !== null && value !== undefined;
  const point = document.documentElement.lang === "de" ? "," : ".";
  const minus = (text) => text.replace("-", "−").replace(".", point);
  const format = (value, spec) => (known(value) ? minus(value.toFixed(spec.digits ?? 3)) + (spec.unit ? ` ${spec.unit}` : "") : W.chart.nothing);

  function extremes(columns) {
    let [low, high] = [Infinity, -Infinity];
    for (const column of columns) {
      for (const value of column) {
        if (!known(value)) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    return [low, high];
  }

  /** Width of the bands in the middle of all. */
  function usualWidth(spec, data) {
    const widths = [];
    let column = 1;
    for (const line of spec.lines) {
      if (line.band) data[column + 1].forEach((low, i) => known(low) && known(data[column + 2][i]) && widths.push(data[column + 2][i] - low));
      column += line.band ? 3 : 1;
    }
    return widths.sort((a, b) => a - b)[widths.length >> 1] ?? 0;
  }

  /** The span that shows the lines and, of the limits, those nearest to them; of a band only what leaves the lines legible. */
  function span(spec, data) {
    let column = 1;
    const lines = spec.lines.map((line) => {
      const own = data[column];
      column += line.band ? 3 : 1;
      return own;
    });
    let [low, high] = extremes(lines);
    const [bandLow, bandHigh] = extremes(data.slice(1));
    const [, watchLow, watchHigh] = spec.limits || [];
    if (low > high) [low, high] = [watchLow ?? 0, watchHigh ?? (watchLow ?? 0) + 1];
    const room = MOST_BAND * Math.max(high - low, usualWidth(spec, data));
    if (known(watchLow)) low = Math.min(low, watchLow);
    if (known(watchHigh)) high = Math.max(high, watchHigh);
    if (bandLow < low) low = Math.max(bandLow, low - room);
    if (bandHigh > high) high = Math.min(bandHigh, high + room);
    if (known(spec.floor)) low = Math.min(low, spec.floor);
    if (known(spec.ceiling)) high = Math.max(high, spec.ceiling);
    const edge = (high - low || Math.abs(high) || 1) * 0.07;
    return [low === spec.floor ? low : low - edge, high === spec.ceiling ? high : high + edge];
  }

  /** Writes on a plate, so that no line runs through the words. */
  function write(ctx, text, x, y, align, ink) {
    const px = devicePixelRatio;
    ctx.font = `${11 * px}px system-ui, sans-serif`;
    ctx.textAlign = align;
    ctx.textBaseline = "middle";
    const width = ctx.measureText(text).width + 6 * px;
    const left = align === "right" ? x - width : x - width / 2;
    ctx.fillStyle = colour("card");
    ctx.fillRect(left, y - 7 * px, width, 14 * px);
    ctx.fillStyle = ink;
    ctx.fillText(text, align === "right" ? x - 3 * px : x, y);
  }

  /** Heights of the limits that are in sight, from the top. */
  function limitsInSight(u, spec) {
    const names = ["act", "watch", "watch", "act"];
    const all = (spec.limits || []).map((limit, index) => ({ limit, grade: names[index], below: index < 2 }));
    const { top, height } = u.bbox;
    return all.filter(({ limit }) => known(limit)).map((one) => ({ ...one, y: u.valToPos(one.limit, "y", true) }))
      .filter(({ y }) => y >= top && y <= top + height);
  }

  function drawLimits(u, spec) {
    const { ctx, bbox } = u;
    const px = devicePixelRatio;
    const seen = limitsInSight(u, spec);
    ctx.save();
    ctx.lineWidth = 1.5 * px;
    ctx.setLineDash([6 * px, 4 * px]);
    for (const { y, grade } of seen) {
      ctx.strokeStyle = colour(grade);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    // On the side where it holds; where two would meet, the second moves to the left.
    const taken = [];
    for (const { y, grade, below } of seen) {
      const at = Math.min(Math.max(y + (below ? 10 : -10) * px, bbox.top + 8 * px), bbox.top + bbox.height - 8 * px);
      const beside = taken.filter((other) => Math.abs(other - at) < 15 * px).length;
      const text = below ? W.chart.below(W.chart.grades[grade]) : W.chart.above(W.chart.grades[grade]);
      write(ctx, text, bbox.left + bbox.width - (4 + 90 * beside) * px, at, "right", colour(`${grade}-text`));
      taken.push(at);
    }
    ctx.restore();
  }

  /** Stretches without any figure, as ends in pixels of the canvas. */
  function gaps(u) {
    const [times, ...columns] = u.data;
    const { left, width } = u.bbox;
    const step = times.length > 1 ? times[1] - times[0] : 1;
    const found = [];
    let from = null;
    for (let i = 0; i <= times.length; i += 1) {
      const empty = i < times.length && columns.every((column) => !known(column[i]));
      if (empty && from === null) from = i;
      if (empty || from === null) continue;
      const a = Math.max(u.valToPos(times[from] - step / 2, "x", true), left);
      const b = Math.min(u.valToPos(times[i - 1] + step / 2, "x", true), left + width);
      if (b > a) found.push([a, b]);
      from = null;
    }
    return found;
  }

  function drawGaps(u, spec) {
    if (spec.positions || u.data[0].length === 0) return;
    const { ctx, bbox } = u;
    const px = devicePixelRatio;
    ctx.save();
    for (const [a, b] of gaps(u)) {
      ctx.fillStyle = colour("unknown", 0.14);
      ctx.fillRect(a, bbox.top, b - a, bbox.height);
      if (b - a < 70 * px) continue;
      const taken = limitsInSight(u, spec).flatMap(({ y, below }) => [y, y + (below ? 10 : -10) * px]);
      const places = [0.5, 0.3, 0.7, 0.12, 0.88].map((share) => bbox.top + share * bbox.height);
      const free = places.find((y) => taken.every((other) => Math.abs(other - y) > 16 * px)) ?? places[0];
      write(ctx, W.chart.noData, (a + b) / 2, free, "center", colour("soft"));
    }
    ctx.restore();
  }

  const ink = (line, index) => line.ink || INKS[index % INKS.length];
  const dash = (line, index) => line.dash ?? index % DASHES.length;

  /** Columns for uPlot: of each line its value, and the ends of its band if it has one. */
  function layout(spec) {
    const series = [{}];
    const bands = [];
    spec.lines.forEach((line, index) => {
      const own = ink(line, index);
      series.push({ label: line.name, line: index, stroke: () => colour(own), width: 2, dash: DASHES[dash(line, index)], spanGaps: false, points: { show: false } });
      if (!line.band) return;
      const edge = { line: index, stroke: () => colour(own, 0.35), width: 0.5, points: { show: false }, spanGaps: false };
      series.push({ label: `${line.name}, ${W.chart.low}`, ...edge }, { label: `${line.name}, ${W.chart.high}`, ...edge });
      bands.push({ series: [series.length - 1, series.length - 2], fill: () => colour(own, 0.17) });
    });
    return { series, bands };
  }

  function options(spec, width, height) {
    const axis = { stroke: () => colour("soft"), grid: { stroke: () => colour("line"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 },
      font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 18 };
    const values = (u, splits) => splits.map((value) => (known(value) ? minus(`${+value.toPrecision(6)}`) : ""));
    const times = (u, splits, _, __, step) => clock.marks(splits, step);
    const x = spec.positions ? { ...axis, values, label: spec.xLabel, size: 34 } : { ...axis, values: times, label: W.chart.time(clock.zone()), size: 44 };
    const zoom = (u) => {
      const { left, width: wide } = u.select;
      if (wide > 4) spec.onZoom(u.posToVal(left, "x"), u.posToVal(left + wide, "x"));
      u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    };
    const shared = { key: spec.sync, scales: ["x", null], filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } };
    return {
      width, height, ...layout(spec),
      scales: { x: { time: !spec.positions }, y: { range: (u) => span(spec, u.data) } },
      axes: [x, { ...axis, size: 50, values, label: spec.axis }],
      cursor: { sync: spec.sync ? shared : undefined, drag: { x: Boolean(spec.onZoom), y: false, setScale: false, dist: 5 },
        bind: { dblclick: () => () => spec.onBack?.() } },
      legend: { show: false },
      hooks: { drawClear: [(u) => drawGaps(u, spec)], draw: [(u) => drawLimits(u, spec), ...(spec.draw || []).map((draw) => (u) => draw(u, colour))],
        setSelect: spec.onZoom ? [zoom] : [], setCursor: [(u) => spec.onCursor?.(u.cursor.idx)] },
    };
  }

  return { colour, known, format, layout, options, ink, dash, span };
})();

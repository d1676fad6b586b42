"use strict";
// A chart as a figure: caption, plot, legend whose lines can be switched, a summary for those who listen, a table for those
// who want figures, and what is shown as a file.
const charts = (() => {
  const { known, format } = plot;
  const el = (kind, className, text) => Object.assign(document.createElement(kind), { className, textContent: text ?? "" });

  function button(name, label, act) {
    const made = el("button", "quiet", name);
    made.type = "button";
    made.setAttribute("aria-label", label);
    made.addEventListener("click", act);
    return made;
  }

  /** What the chart shows, in a sentence. */
  function summary(spec, data) {
    const parts = [];
    let column = 1;
    for (const line of spec.lines) {
      const values = data[column].filter(known);
      column += line.band ? 3 : 1;
      const said = [values.at(-1), Math.min(...values), Math.max(...values)].map((value) => format(value, spec));
      parts.push(values.length === 0 ? W.chart.saysNothing(line.name) : W.chart.says(line.name, ...said));
    }
    const gaps = data[0].filter((_, i) => data.slice(1).every((values) => !known(values[i]))).length;
    const share = data[0].length ? Math.round((100 * gaps) / data[0].length) : 100;
    return `${spec.title}. ${parts.join("; ")}. ${W.chart.gaps(share)}`;
  }

  const first = (spec, value) => (spec.positions ? `${value}` : clock.full(value));
  const names = (spec) => plot.layout(spec).series.slice(1).map((series) => series.label);

  function fillTable(host, spec, data) {
    const every = Math.max(1, Math.ceil(data[0].length / 60));
    const table = document.createElement("table");
    const head = table.createTHead().insertRow();
    for (const name of [spec.positions ? spec.xLabel : W.chart.time(clock.zone()), ...names(spec)]) head.append(Object.assign(el("th", "", name), { scope: "col" }));
    const body = table.createTBody();
    for (let i = 0; i < data[0].length; i += every) {
      const row = body.insertRow();
      [first(spec, data[0][i]), ...data.slice(1).map((column) => format(column[i], spec))].forEach((text) => { row.insertCell().textContent = text; });
    }
    host.replaceChildren(table);
  }

  function save(name, blob) {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  const fileName = (spec, data, end) => {
    const from = spec.positions || data[0].length === 0 ? "" : `-${clock.iso(data[0][0]).replace(/[:Z]/g, "")}`;
    return `${[document.documentElement.dataset.page, spec.key].join("-")}${from}.${end}`;
  };

  /** What is shown, RFC 4180: times in UTC, units in the head, what is unknown left empty. */
  function csv(spec, data) {
    const quote = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const head = [spec.positions ? spec.xLabel : "time_utc", ...names(spec).map((name) => `${spec.title}, ${name}${spec.unit ? `, ${spec.unit}` : ""}`)];
    const rows = data[0].map((at, i) => [spec.positions ? `${at}` : clock.iso(at), ...data.slice(1).map((column) => (known(column[i]) ? `${column[i]}` : ""))]);
    return `${[head, ...rows].map((row) => row.map(quote).join(",")).join("\r\n")}\r\n`;
  }

  /** The plot with its title, its lines and where it comes from, on the ground of the page. */
  function picture(spec, u, shown) {
    const px = devicePixelRatio;
    const source = u.ctx.canvas;
    const canvas = Object.assign(document.createElement("canvas"), { width: source.width, height: source.height + 92 * px });
    const ctx = canvas.getContext("2d");
    const text = (words, x, y, ink, font) => {
      ctx.font = `${font.replace(/\d+/, (size) => size * px)} system-ui, sans-serif`;
      ctx.fillStyle = plot.colour(ink);
      ctx.fillText(words, x * px, y * px);
      return ctx.measureText(words).width / px;
    };
    ctx.fillStyle = plot.colour("card");
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    text(spec.title, 12, 20, "text", "600 15px");
    text(spec.about || "", 12, 38, "soft", "12px");
    ctx.drawImage(source, 0, 46 * px);
    const below = 46 + source.height / px;
    let x = 12;
    spec.lines.forEach((line, index) => {
      if (!shown[index]) return;
      ctx.strokeStyle = plot.colour(plot.ink(line, index));
      ctx.lineWidth = 2 * px;
      ctx.setLineDash([[], [7, 4], [2, 3], [10, 3, 2, 3]][plot.dash(line, index)].map((part) => part * px));
      ctx.beginPath();
      ctx.moveTo(x * px, (below + 12) * px);
      ctx.lineTo((x + 24) * px, (below + 12) * px);
      ctx.stroke();
      x += 40 + text(line.name, x + 30, below + 16, "text", "12px");
    });
    text(spec.source?.() ?? "", 12, below + 36, "soft", "11px");
    return canvas;
  }

  /** Lines with their value under the crosshair; each can be hidden. */
  function legend(spec, shown, change) {
    const list = el("ul", "lines");
    const at = el("li", "at");
    if (!spec.positions) list.append(at);
    const values = spec.lines.map((line, index) => {
      const item = el("li", "");
      const toggle = button("", W.chart.toggle(line.name), () => {
        shown[index] = !shown[index];
        toggle.setAttribute("aria-pressed", String(shown[index]));
        change(index, shown[index]);
      });
      toggle.className = "line-of";
      toggle.setAttribute("aria-pressed", "true");
      const value = el("b", "");
      toggle.append(el("i", `swatch ink-${plot.ink(line, index)} dash-${plot.dash(line, index)}`), ` ${line.name} `, value);
      item.append(toggle);
      list.append(item);
      return value;
    });
    return { list, at, values };
  }

  /** A chart in `host`; gives what renews and removes it. */
  function make(host, spec, height = 195) {
    const figure = el("figure", "chart");
    const caption = el("figcaption", "");
    const title = el("span", "", spec.title);
    if (spec.about) title.append(el("small", "", spec.about));
    const area = el("div", "plot");
    area.setAttribute("role", "img");
    area.setAttribute("aria-label", spec.title);
    const table = el("div", "figures");
    table.hidden = true;
    table.tabIndex = 0;
    table.setAttribute("role", "region");
    table.setAttribute("aria-label", W.chart.as(W.chart.table, spec.title));
    let data = [[], ...plot.layout(spec).series.slice(1).map(() => [])];
    const shown = spec.lines.map(() => true);
    const lines = legend(spec, shown, (index, show) => {
      u.series.forEach((series, place) => place > 0 && series.line === index && u.setSeries(place, { show }));
    });
    const tools = el("span", "tools");
    const open = button(W.chart.table, W.chart.as(W.chart.table, spec.title), () => {
      table.hidden = !table.hidden;
      open.setAttribute("aria-expanded", String(!table.hidden));
      if (!table.hidden) fillTable(table, spec, data);
    });
    open.setAttribute("aria-expanded", "false");
    tools.append(open, button(W.chart.csv, W.chart.as(W.chart.csv, spec.title), () => save(fileName(spec, data, "csv"), new Blob([csv(spec, data)], { type: "text/csv" }))),
      button(W.chart.png, W.chart.as(W.chart.png, spec.title), () => picture(spec, u, shown).toBlob((blob) => save(fileName(spec, data, "png"), blob))));
    caption.append(title, tools);
    figure.append(caption, area, lines.list, table);
    host.append(figure);
    const tell = (i) => {
      lines.at.textContent = known(i) && known(data[0][i]) ? first(spec, data[0][i]) : "";
      let column = 1;
      spec.lines.forEach((line, index) => {
        const text = known(i) ? format(data[column][i], spec) : "";
        const ends = line.band && known(i) && known(data[column + 1][i]) ? ` (${format(data[column + 1][i], { ...spec, unit: "" })} – ${format(data[column + 2][i], spec)})` : "";
        lines.values[index].textContent = text + ends;
        column += line.band ? 3 : 1;
      });
    };
    const u = new uPlot(plot.options({ ...spec, onCursor: tell }, Math.max(240, area.clientWidth), height), data, area);
    const watch = new ResizeObserver(() => {
      const width = area.clientWidth;
      if (width > 0 && width !== u.width) u.setSize({ width, height });
    });
    watch.observe(area);
    const redraw = () => u.redraw(false);
    document.addEventListener("themechange", redraw);
    // As wide as a page of A4 between its margins.
    const onPaper = () => u.setSize({ width: 680, height: 170 });
    const onScreen = () => u.setSize({ width: area.clientWidth, height });
    addEventListener("beforeprint", onPaper);
    addEventListener("afterprint", onScreen);
    return {
      figure, spec, u,
      csv: () => csv(spec, data),
      picture: () => picture(spec, u, shown),
      update(fresh) {
        data = fresh;
        u.setData(data);
        area.setAttribute("aria-label", summary(spec, data));
        if (!table.hidden) fillTable(table, spec, data);
      },
      remove() {
        watch.disconnect();
        document.removeEventListener("themechange", redraw);
        removeEventListener("beforeprint", onPaper);
        removeEventListener("afterprint", onScreen);
        u.destroy();
        figure.remove();
      },
    };
  }

  return { make, colour: plot.colour, known };
})();

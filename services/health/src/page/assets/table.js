"use strict";
// The table of wagons: what is wrong first, then what is unknown, then what is well, folded; sorted by any column and filtered.
{
  const table = document.querySelector("table.wagons");
  const RANK = { act: 0, watch: 1, unknown: 2, ok: 3 };
  const state = { column: null, down: false, text: "", open: false };
  const bodies = table && [...table.tBodies];
  const rows = () => [...table.querySelectorAll("tbody tr[data-grade]")];
  const number = (row) => Number(row.id.slice(2));

  /** What a cell is sorted by: its figure if it has one, else its words; what is unknown comes last. */
  function key(row, column) {
    if (column === 0) return number(row);
    if (column === 1) return RANK[row.dataset.grade];
    const text = row.cells[column].textContent.trim().replace("−", "-").replace(/^≥\s*/, "").replace(/(\d),(\d)/, "$1.$2");
    return text === W.chart.nothing ? null : Number.isNaN(parseFloat(text)) ? text : parseFloat(text);
  }

  function order(a, b) {
    if (state.column === null) return RANK[a.dataset.grade] - RANK[b.dataset.grade] || number(a) - number(b);
    const [x, y] = [key(a, state.column), key(b, state.column)];
    if (x === null || y === null) return (x === null) - (y === null) || number(a) - number(b);
    return (x < y ? -1 : x > y ? 1 : number(a) - number(b)) * (state.down ? -1 : 1);
  }

  /** Puts every row where it belongs; rows that are there already are not touched, so that focus and selection stay. */
  function arrange() {
    const [first, well] = bodies;
    const sorted = rows().sort(order);
    const apart = state.column === null && !state.text;
    const homes = new Map([[first, []], [well, []]]);
    for (const row of sorted) homes.get(apart && row.dataset.grade === "ok" ? well : first).push(row);
    let shown = 0;
    for (const [home, its] of homes) {
      its.forEach((row, at) => home.rows[at] !== row && home.insertBefore(row, home.rows[at] ?? null));
    }
    for (const row of sorted) {
      const fits = !state.text || row.textContent.toLowerCase().includes(state.text);
      row.hidden = !fits;
      shown += fits ? 1 : 0;
    }
    const count = homes.get(well).length;
    const fold = document.getElementById("fold");
    fold.closest("p").hidden = count === 0;
    well.hidden = !state.open;
    fold.textContent = `${count === 1 ? W.table.one : W.table.well(count)}: ${state.open ? W.table.hide : W.table.show}`;
    fold.setAttribute("aria-expanded", String(state.open));
    document.getElementById("filtered").textContent = !state.text ? "" : shown ? W.table.shown(shown) : W.table.none;
    table.tHead.hidden = homes.get(first).length === 0 && !state.open;
  }

  function sort(button) {
    const column = button.closest("th").cellIndex;
    if (state.column !== column) Object.assign(state, { column, down: false });
    else if (!state.down) state.down = true;
    else state.column = null;
    for (const head of table.tHead.rows[0].cells) {
      if (head.cellIndex === state.column) head.setAttribute("aria-sort", state.down ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    }
    arrange();
  }

  if (table) {
    table.tHead.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button) sort(button);
    });
    document.getElementById("filter").addEventListener("input", (event) => {
      state.text = event.target.value.trim().toLowerCase();
      arrange();
    });
    document.getElementById("fold").addEventListener("click", () => {
      state.open = !state.open;
      arrange();
    });
    document.addEventListener("renewed", arrange);
    arrange();
  }
}

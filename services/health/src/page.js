"use strict";
// Renews the page from /api/v1/stream. Ages grow here between events, so that silence shows.
const heard = new Map();
const byId = (id) => document.getElementById(id);
const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));

function slides(row) {
  if (row.wsp_active === null) return "–";
  if (row.wsp_active) return "WSP acts";
  return row.sliding ? "slides" : "rolls";
}

function renew(row) {
  const line = document.querySelector(`tr[data-wagon="${row.id}"]`);
  if (!line) return;
  heard.set(row.id, { at: performance.now(), age: row.age_s, row });
  const bound = row.adhesion_available_is_lower_bound && row.adhesion_available !== null ? "≥ " : "";
  const speed = row.v_m_s === null ? null : 3.6 * row.v_m_s;
  const texts = [
    row.grade, number(speed, 0), number(row.adhesion_utilised, 3), bound + number(row.adhesion_available, 3),
    row.condition === null ? "–" : row.condition.replace("_", " "), number(row.brake_friction, 3), slides(row),
    number(row.age_s, 1), row.reason,
  ];
  line.className = row.state;
  [...line.querySelectorAll("td")].forEach((cell, index) => {
    if (cell.textContent !== texts[index]) cell.textContent = texts[index];
  });
  line.querySelector("td").className = "grade " + row.grade;
}

function alertLine(alert) {
  const item = document.createElement("li");
  item.dataset.alert = alert.id;
  const grade = document.createElement("span");
  grade.className = "grade " + alert.grade;
  grade.textContent = alert.grade;
  const wheelset = alert.wheelset === null ? "" : `, wheelset ${alert.wheelset}`;
  const cause = alert.cause.replaceAll("_", " ");
  item.append(grade, ` wagon ${alert.wagon}${wheelset}: ${cause} – ${alert.reason}. ${alert.advice}`);
  return item;
}

function listen() {
  const source = new EventSource("/api/v1/stream");
  const link = byId("link");
  source.addEventListener("wagons", (event) => JSON.parse(event.data).forEach(renew));
  source.addEventListener("train", (event) => {
    const train = JSON.parse(event.data);
    link.textContent = "as of " + train.generated_at;
    link.className = "";
    byId("verdict").textContent = `${train.grade}: ${train.reason}`;
    byId("verdict").className = "grade " + train.grade;
  });
  source.addEventListener("alert", (event) => {
    const alert = JSON.parse(event.data);
    const old = document.querySelector(`li[data-alert="${alert.id}"]`);
    if (old) old.remove();
    if (alert.active) byId("alerts").prepend(alertLine(alert));
  });
  source.onerror = () => {
    link.textContent = "The connection is lost; what you see is old. Trying again.";
    link.className = "lost";
  };
}

setInterval(() => {
  for (const [id, { at, age }] of heard) {
    if (age === null) continue;
    const cell = document.querySelector(`tr[data-wagon="${id}"] td:nth-last-child(2)`);
    const seconds = age + (performance.now() - at) / 1000;
    if (seconds > 3) cell.textContent = seconds.toFixed(0);
  }
}, 1000);
listen();

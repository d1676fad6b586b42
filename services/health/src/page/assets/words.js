"use strict";
// Every sentence that the scripts write: one place, so that another language is another table.
const W = {
  live: "live", connecting: "connecting", notConnected: (age) => `not connected ${age}`,
  lost: "Connection lost. This page shows old data. Reconnecting… ", lastData: (age) => `Last data ${age} ago.`,
  back: "The connection is back; the page is live again.",
  newAlert: (texts, more) => `New alert: ${texts.join(" ")}${more > 0 ? ` And ${more} more.` : ""}`,
  age: { less: "< 1 s", s: (n) => `${n} s`, min: (n) => `${n} min`, h: (n) => `${n} h`, days: (n) => `${n} days` },
  theme: { system: "◐ Auto", light: "☀ Light", dark: "☾ Dark", label: (name) => `Theme: ${name}; change it` },
  act: {
    acknowledge: { title: "Acknowledge this alert", send: "Acknowledge", note: "Note (optional)", done: "Acknowledged." },
    unacknowledge: { title: "Take the acknowledgement back", send: "Take back", note: "Note (optional)", done: "Acknowledgement taken back." },
    silence: { title: "Silence this alert", send: "Silence", note: "Why", done: "Silenced." },
    unsilence: { title: "End the silence of this alert", send: "End silence", note: "Note (optional)", done: "No longer silenced." },
    loggedOut: (detail) => `Not logged in any more; open /login in another tab, then send again. (${detail})`,
    mayOnlyRead: (detail) => `Your login may only read. (${detail})`,
    refused: (detail) => `Refused: ${detail}`, unreachable: "The service cannot be reached; nothing was changed. Try again.",
  },
  table: { well: (n) => (n === 1 ? "1 wagon is well" : `${n} wagons are well`), show: "show", hide: "hide", none: "No wagon fits the filter.", shown: (n) => `${n} wagons shown.` },
  chart: {
    nothing: "–", noData: "no data", below: (grade) => `${grade} below`, above: (grade) => `${grade} above`, time: (zone) => `time, ${zone}`,
    low: "low", high: "high", table: "Table", csv: "CSV", png: "PNG", as: (what, title) => `${what} of ${title}`,
    toggle: (name) => `Show or hide ${name}`, from: (train, wagons, span) => `railgrip, train ${train}${wagons}, ${span}`,
    says: (name, last, low, high) => `${name}: last ${last}, lowest ${low}, highest ${high}`, saysNothing: (name) => `${name}: no data`,
    gaps: (share) => `${share} % of the range has no data.`, wheelset: (n) => `wheelset ${n}`, wagon: (n) => `wagon ${n}`,
  },
  printed: (train, when, address) => `railgrip, train ${train}, printed ${when}: ${address}`,
  trends: {
    steps: (step, share, span) => `${span}, in steps of ${step}. Data for ${share} % of the range.`,
    shaded: " Grey: no data.", hint: " Drag across a chart to zoom; a double click goes back.", empty: (span, stored) => `Nothing is stored for ${span}. ${stored}`,
    stored: (from) => `The history goes back to about ${from}.`, nothingYet: "Nothing is stored yet: the first figures appear within a minute.",
    refused: (detail) => `No history: ${detail}`, unreachable: "The history cannot be loaded: the service does not answer. Retrying…",
    noWagon: (text, count) => `“${text}” is no list of wagons 1 to ${count}, for example 2, 5.`, outlook: (detail) => `No trends: ${detail}`,
    events: (detail) => `No events: ${detail}`, noEvents: "No events for this wagon yet.", copied: "The link to this view is copied.",
    notCopied: "The address bar holds the link to this view.",
  },
};
/** What the charts of a wagon are called. */
const CHARTS = {
  pad: ["Pad friction", "mean over braking; band: 95 % interval", "friction, pad on disc"],
  asymmetry: ["Front minus rear", "over their mean; band: 95 % interval", "of the mean, %"],
  adhesion: ["Adhesion", "available: a lower bound unless a wheelset slides; band: 95 % interval", "adhesion, force over load"],
  standard: ["Pad friction, standardised", "at standard conditions; band: 95 % interval", "friction, pad on disc"],
  drag: ["Drag when released", "beyond running resistance; band: 95 % interval", "force, kN"],
  response: ["Build-up of the brake", "time to 90 % of its force; band: spread", "time, s"],
  rail: ["Rail", "probability that it is low or very low", "probability, %"],
  wsp: ["Slide protection", "share of the latest braking in which it acted; band: extremes", "share, %"],
  slides: ["Slide energy", "of all slides so far", "energy, MJ"],
  sensors: ["Sensors", "share of their values that is missing or refused; band: extremes", "share, %"],
  filter: ["Filter", "mean normalised innovation squared, 1 is ideal; band: extremes", "ratio"],
  map: ["Adhesion available by track position", "median; band: 95 % interval; shaded: probably low", "adhesion, force over load", "track position, km"],
};
const LINES = { wheelset: "wheelset", asymmetry: "asymmetry", available: "available", used: "used", wagon: "wagon", drag: "drag", time: "time", low: "low",
  veryLow: "very low", share: "share", nis: "NIS" };

"use strict";
// Every sentence that the scripts write. The service puts the strings in double quotes into the language of the page, by the
// table of messages; what is filled in stands as {0}, {1}.
const fill = (text) => (...given) => text.replace(/\{(\d)\}/g, (_, i) => given[i]);
const W = {
  live: "live", connecting: "connecting", notConnected: fill("not connected {0}"),
  lost: "Connection lost. This page shows old data. Reconnecting…", lastData: fill("Last data {0} ago."),
  back: "The connection is back; the page is live again.",
  newAlert: fill("New alert: {0}"), more: fill("And {0} more."), to: fill("{0} to {1}"),
  age: { less: "< 1 s", s: fill("{0} s"), min: fill("{0} min"), h: fill("{0} h"), days: fill("{0} days") },
  theme: { system: "◐ Auto", light: "☀ Light", dark: "☾ Dark", names: { system: "automatic", light: "light", dark: "dark" }, label: fill("Theme: {0}; change it") },
  act: {
    acknowledge: { title: "Acknowledge this alert", send: "Acknowledge", note: "Note (optional)", done: "Acknowledged." },
    unacknowledge: { title: "Take the acknowledgement back", send: "Take back", note: "Note (optional)", done: "Acknowledgement taken back." },
    silence: { title: "Silence this alert", send: "Silence", note: "Reason", done: "Silenced." },
    unsilence: { title: "End the silence of this alert", send: "End silence", note: "Note (optional)", done: "No longer silenced." },
    loggedOut: fill("Not logged in any more; open /login in another tab, then send again. ({0})"),
    mayOnlyRead: fill("Your login may not do this. ({0})"), status: fill("status {0}"),
    refused: fill("Refused: {0}"), unreachable: "The service cannot be reached; nothing was changed. Try again.",
  },
  receivers: { kept: fill("It is sent a secret, so its address {0} and its TLS are changed in the file only.") },
  notes: { pads: "Brake pads changed.", newPads: "New pads.", none: "Nobody has written anything down.", unreachable: "The service cannot be reached." },
  table: { one: "1 wagon is well", well: fill("{0} wagons are well"), show: "show", hide: "hide", none: "No wagon fits the filter.", shown: fill("{0} wagons shown.") },
  chart: {
    nothing: "–", noData: "no data", grades: { act: "act", watch: "watch" }, below: fill("{0} below"), above: fill("{0} above"), time: fill("time, {0}"),
    low: "low", high: "high", table: "Table", csv: "CSV", png: "PNG", as: fill("{0} of {1}"),
    toggle: fill("Show or hide {0}"), from: fill("railgrip, train {0}{1}, {2}"),
    says: fill("{0}: last {1}, lowest {2}, highest {3}"), saysNothing: fill("{0}: no data"),
    gaps: fill("{0} % of the range has no data."), wheelset: fill("wheelset {0}"), wagon: fill("wagon {0}"),
  },
  printed: fill("railgrip, train {0}, printed {1}: {2}"),
  trends: {
    steps: fill("{2}, in steps of {0}. Data for {1} % of the range."),
    shaded: "Grey: no data.", hint: "Drag across a chart to zoom; a double click goes back.", empty: fill("Nothing is stored for {0}. {1}"),
    stored: fill("The history goes back to about {0}."), nothingYet: "Nothing is stored yet: the first figures appear within a minute.",
    refused: fill("No history: {0}"), unreachable: "The history cannot be loaded: the service does not answer. Retrying…",
    noWagon: fill("“{0}” is no list of wagons 1 to {1}, for example 2, 5."), outlook: fill("No trends: {0}"),
    events: fill("No events: {0}"), noEvents: "No events for this wagon yet.", copied: "The link to this view is copied.",
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
  response: ["Brake builds up in", "time to 90 % of its force; band: spread", "time, s"],
  rail: ["Rail", "probability that it is low or very low", "probability, %"],
  wsp: ["Braking with slide protection", "share of the latest braking in which it acted; band: extremes", "share, %"],
  slides: ["Slide energy", "of all slides so far", "energy, MJ"],
  flat: ["Wheel flat", "variation of the speed over a turn; band: 95 % interval", "share of the speed, ‰"],
  sensors: ["Faulty sensor values", "share of their values that is missing or refused; band: extremes", "share, %"],
  disc: ["Disc above ambient", "worked out from braking power; band: 95 % interval", "above ambient, K"],
  filter: ["Filter", "mean normalised innovation squared, 1 is ideal; band: extremes", "ratio"],
  map: ["Adhesion available by track position", "median; band: 95 % interval; shaded: probably low", "adhesion, force over load", "track position, km"],
};
const LINES = { wheelset: "wheelset", asymmetry: "Front minus rear", available: "available", used: "used", wagon: "wagon", drag: "drag", time: "time", low: "low",
  veryLow: "very low", share: "share", nis: "NIS" };

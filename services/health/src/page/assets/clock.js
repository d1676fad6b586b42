"use strict";
// Instants as people read them: 24 hours, in the zone of whoever looks, and the zone is said.
const clock = (() => {
  const locale = document.documentElement.lang === "en" ? "en-GB" : document.documentElement.lang;
  const format = (options) => new Intl.DateTimeFormat(locale, { hourCycle: "h23", ...options });
  const hm = format({ hour: "2-digit", minute: "2-digit" });
  const hms = format({ hour: "2-digit", minute: "2-digit", second: "2-digit" });
  const day = format({ day: "numeric", month: "short" });
  const full = format({ day: "numeric", month: "short", year: "numeric", hour: "2-digit", minute: "2-digit", second: "2-digit" });
  const date = (unix_s) => new Date(1000 * unix_s);
  const same = (a, b) => a.toDateString() === b.toDateString();

  /** `Europe/Berlin, UTC+1`, or `UTC` alone. */
  function zone(at = new Date()) {
    const name = Intl.DateTimeFormat().resolvedOptions().timeZone;
    const part = format({ timeZoneName: "shortOffset" }).formatToParts(at).find(({ type }) => type === "timeZoneName");
    const offset = (part?.value ?? "UTC").replace("GMT", "UTC").replace(/[+−-]0$/, "");
    return offset === "UTC" && /^(UTC|Etc\/)/.test(name) ? "UTC" : `${name}, ${offset}`;
  }

  /** The time, with its day unless that is today. */
  const instant = (at) => (same(at, new Date()) ? "" : `${day.format(at)} `) + hm.format(at);

  /** `22 Nov 06:10 to 06:40`. */
  function span(from_s, to_s) {
    const [from, to] = [date(from_s), date(to_s)];
    const short = to_s - from_s < 600 ? hms : hm;
    return W.to(`${day.format(from)} ${short.format(from)}`, `${same(from, to) ? "" : `${day.format(to)} `}${short.format(to)}`);
  }

  /** Marks of an axis: the day stands under the first of each day. */
  function marks(splits, step_s) {
    const short = step_s >= 60 ? hm : hms;
    return splits.map((unix_s, i) => {
      const at = date(unix_s);
      if (step_s >= 86400) return day.format(at);
      return short.format(at) + (i === 0 || !same(at, date(splits[i - 1])) ? `\n${day.format(at)}` : "");
    });
  }

  const iso = (unix_s) => date(unix_s).toISOString().replace(".000Z", "Z");
  return { zone, instant, span, marks, iso, full: (unix_s) => full.format(date(unix_s)), second: (unix_s) => hms.format(date(unix_s)) };
})();

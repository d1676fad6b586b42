"use strict";
// What a page of a wagon fetches once it is open: trends in words, and the latest events.
{
  const OUTLOOK_MS = 60000;
  const EVENTS_MS = 15000;
  const host = document.getElementById("events");
  const line = (kind, className, textContent) => Object.assign(document.createElement(kind), { className, textContent });

  /** Calls `work` now and again and again, but not while nobody looks. */
  function again(work, period) {
    const round = async () => {
      try {
        await work();
      } catch {
        // The connection is lost: the banner says so, the next round tries again.
      }
      setTimeout(() => (document.hidden ? document.addEventListener("visibilitychange", round, { once: true }) : round()), period);
    };
    round();
  }

  /** The table of trends comes rendered. */
  async function outlook() {
    const answer = await fetch(`/wagons/${host.dataset.wagon}/outlook`);
    if (answer.ok) return place({ outlook: await answer.text() });
    const problem = await answer.json().catch(() => ({}));
    document.getElementById("outlook").replaceChildren(line("p", "calm", W.trends.outlook(problem.detail || answer.status)));
  }

  async function events() {
    const answer = await fetch(`/api/v1/events?wagon=${host.dataset.wagon}&limit=12`, { headers: { accept: "application/json", "accept-language": document.documentElement.lang } });
    const body = await answer.json().catch(() => ({}));
    if (!answer.ok) return host.replaceChildren(line("p", "calm", W.trends.events(body.detail || answer.status)));
    const list = line("ul", "course", "");
    for (const event of body.events) {
      const item = document.createElement("li");
      const time = line("time", "", event.at);
      time.setAttribute("datetime", event.at);
      item.append(time, ` ${event.wheelset ? `${W.chart.wheelset(event.wheelset)}: ` : ""}${event.text}`);
      list.append(item);
    }
    localise(list);
    host.replaceChildren(body.events.length ? list : line("p", "calm", W.trends.noEvents));
  }

  if (host) {
    again(outlook, OUTLOOK_MS);
    again(events, EVENTS_MS);
  }
}

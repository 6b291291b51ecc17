/** How long until the vehicle takes control back, and how fresh the words are. */
import { byId, mark, write, writeCut } from "./dom.js";
import { age, num } from "./format.js";

const AMBER_S = 2.5;
const RED_S = 4;

/** @param {number} s @param {number} amber @param {number} red */
const tone = (s, amber, red) => (!(s < red) ? "bad" : s < amber ? "good" : "warn");

export class Countdown {
  /** @param {import("./main.js").Shown} shown */
  draw({ state, about, link, live, clock, dive }) {
    this.dog(state, about.watchdog_s > 0 ? about.watchdog_s : 5, live && (link === "lost" || link === "quiet"));
    const trip = state.beat?.round_trip_s;
    const deaf = state.beat?.refreshed - state.beat?.acknowledged > 1.5;
    write(byId("trip"), deaf ? "no answer" : trip >= 0 ? (trip < 1 ? `${Math.round(trip * 1000)} ms` : num(trip, 1, "s")) : "–");
    mark(byId("gauge-trip"), "tone", deaf ? "bad" : trip >= 1 ? "warn" : "");
    const gap = state.beat?.worst_gap_s;
    write(byId("gap"), gap > 0 ? num(gap, 1, "s") : "–");
    mark(byId("gauge-gap"), "tone", gap > 0 && gap >= AMBER_S ? tone(gap, AMBER_S, RED_S) : "");
    const nav = state.t - state.navigated;
    const ended = clock.live && clock.following && dive.over;
    write(byId("nav-age"), ended ? "–" : Number.isFinite(nav) ? age(nav) + " old" : "none yet");
    mark(byId("gauge-nav"), "tone", ended ? "" : tone(nav, 1.5, 3));
    const integrity = state.integrity;
    writeCut(byId("integrity"), integrity && !integrity.ok ? integrity.text || "implausible" : "steady", 80);
    mark(byId("gauge-integrity"), "tone", integrity && !integrity.ok ? "bad" : "good");
    writeCut(byId("status"), state.status ?? "nothing yet", 80);
    for (const id of ["integrity", "status"]) mark(byId(id), "long", (byId(id).textContent ?? "").length > 16 ? "yes" : "no");
  }

  /** @param {any} state @param {number} watchdog @param {boolean} deaf nothing is heard of the run now */
  dog(state, watchdog, deaf) {
    const steers = Boolean(state.steering?.owner);
    const since = state.t - (state.beat?.refreshed ?? NaN);
    const on = steers && Number.isFinite(since) && !deaf;
    const text = deaf ? "not known now" : !on ? (steers ? "no command yet" : "no lease") : since >= watchdog
      ? `${age(since)} – the vehicle takes control back`
      : `${num(Math.max(0, since), 1, "s")} of ${num(watchdog, 1, "s")}`;
    write(byId("dog-text"), text);
    const bar = byId("dog-bar");
    mark(bar, "tone", on ? tone(since, AMBER_S, RED_S) : "");
    const part = on ? Math.min(1, Math.max(0, since / watchdog)) : 0;
    byId("dog-fill").style.width = (part * 100).toFixed(1) + "%";
    byId("dog-amber").style.left = (AMBER_S / watchdog) * 100 + "%";
    byId("dog-red").style.left = (RED_S / watchdog) * 100 + "%";
    bar.setAttribute("aria-valuemax", String(watchdog));
    bar.setAttribute("aria-valuenow", on ? since.toFixed(1) : "0");
    bar.setAttribute("aria-valuetext", text);
  }
}

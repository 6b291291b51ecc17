/** What must not be overlooked: held, not connected, not recorded, looking back. */
import { byId, mark, show, write, writeCut } from "./dom.js";
import { age, hms } from "./format.js";

/** @typedef {import("./main.js").Shown} Shown */

export class Banners {
  /** @param {Shown} shown */
  draw({ dive, about, clock, link, silence, state, loading, trouble }) {
    const now = clock.live && !dive.over;
    const hold = now ? dive.held.operator.last : state.operator;
    const held = Boolean(hold?.held);
    show(byId("banner-held"), held);
    document.body.classList.toggle("held-on", held);
    if (held) {
      writeCut(byId("held-text"), `by ${hold.who || hold.by || "the operator"} since ${hms(hold.t)}. Plugins do not steer.`, 120);
    }
    this.lost(link, silence, dive, trouble);
    const recording = now ? dive.held.recording.last : undefined;
    const unwritten = recording?.written === false;
    show(byId("banner-log"), unwritten);
    if (unwritten) writeCut(byId("log-text"), `The dive has not been recorded since ${hms(recording.t)}: ${recording.text}.`, 200);
    const back = clock.live && !clock.following && !dive.over;
    show(byId("banner-back"), back);
    if (back) write(byId("back-text"), `at ${hms(state.t)}, ${hms(clock.end - state.t)} ago. This is not now.`);
    this.note(dive, loading);
    this.title(held ? "HELD" : document.body.classList.contains("stale") ? "NOT CONNECTED" : "", about);
  }

  /** For a tab in the background. @param {string} word @param {any} about */
  title(word, about) {
    const title = `${word ? word + " – " : ""}${String(about.mission ?? "dive").slice(0, 60)} – console`;
    if (document.title !== title) document.title = title;
  }

  /** @param {string} link @param {number} silence @param {any} dive @param {string} trouble */
  lost(link, silence, dive, trouble) {
    const words = this.words(link, silence, dive, trouble);
    show(byId("banner-lost"), Boolean(words));
    document.body.classList.toggle("stale", Boolean(words) && link !== "paused");
    if (!words) return;
    write(byId("lost-word"), words[0]);
    write(byId("lost-text"), words[1]);
    mark(byId("banner-lost"), "tone", link === "lost" || link === "quiet" || trouble ? "bad" : "warn");
  }

  /** @param {string} link @param {number} silence @param {any} dive @param {string} trouble @returns {[string, string]|undefined} */
  words(link, silence, dive, trouble) {
    if (trouble) return ["NO ANSWER", trouble];
    const ago = Number.isFinite(silence) ? `Nothing came for ${age(silence / 1000)}.` : "";
    if (link === "lost") return ["NOT CONNECTED", `${ago} All you see is old, up to ${hms(dive.end)}. Trying again.`];
    if (link === "quiet") return ["NOTHING NEW", `The program answers, but no word from the run. ${ago} What you see is old.`];
    if (link === "paused") return ["PAUSED", "The simulation stands still."];
    if (link === "connecting") return ["CONNECTING", "What you see is what happened before."];
    return undefined;
  }

  /** @param {any} dive @param {number} loading */
  note(dive, loading) {
    const parts = [];
    if (loading < 1) parts.push(`Loading what happened before${loading ? `: ${Math.round(loading * 100)} %` : "…"}`);
    show(byId("banner-note"), parts.length > 0);
    write(byId("note-text"), parts.join(". "));
    const bad = byId("bad-lines");
    show(bad, dive.malformed > 0);
    write(bad, `${dive.malformed} bad ${dive.malformed === 1 ? "line" : "lines"} left out`);
  }
}

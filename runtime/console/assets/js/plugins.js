/** A card for each plugin. */
import { byId, make, mark, show, terms, write, writeCut } from "./dom.js";
import { hms, num } from "./format.js";
import { tint, tintName } from "./theme.js";
import { arr, fin, obj, pick, str } from "./read.js";

/** @type {Record<string, string>} */
const TONES = { running: "good", restarting: "warn", failed: "bad", quarantined: "bad" };
const COUNTS = [["rejected", "refused"], ["sent", "sent"], ["accepted", "accepted"], ["failed", "failed"]];

export class Plugins {
  constructor() {
    /** @type {Map<string, Record<string, HTMLElement>>} */
    this.cards = new Map();
    /** @type {HTMLElement[]} */
    this.counts = COUNTS.map(([, word]) => {
      const box = make("div");
      const value = make("p", "value", "–");
      box.append(make("h3", "", word), value);
      byId("counts").append(box);
      return value;
    });
  }

  clear() {
    this.cards.clear();
    byId("cards").replaceChildren();
  }

  /** @param {unknown} limits of the run */
  limits(limits) {
    /** @type {[string, string][]} */
    const rows = Object.entries(obj(limits)).slice(0, 40).map(([key, value]) => [key.replaceAll("_", " "), str(value, 60)]);
    show(byId("limits-title"), rows.length > 0);
    byId("limits").replaceChildren(terms(rows));
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, dive, about }) {
    let rank = 0;
    for (const [name, story] of dive.plugins) {
      rank += 1;
      const of = arr(about.plugins, 64).map(obj).find((plugin) => plugin.name === name) ?? {};
      this.card(this.cards.get(name) ?? this.build(name), name, rank, of, story, state);
    }
    const counts = state.counts ?? {};
    COUNTS.forEach(([key], i) => write(this.counts[i], fin(counts[key]) === undefined ? "–" : String(counts[key])));
  }

  /** @param {string} name */
  build(name) {
    const card = make("article", "card");
    const head = make("header");
    const title = make("h3");
    writeCut(title, name, 24);
    /** @type {Record<string, HTMLElement>} */
    const parts = { card, state: make("span", "chip"), leads: make("span", "chip"), grants: make("span", "grants"),
      trouble: make("p", "words refusal"), words: make("p", "words"), refusal: make("p", "words refusal"),
      sums: make("p", "sums"), fuel: make("div", "fuel") };
    head.append(title, parts.state, parts.leads, parts.grants);
    const bar = make("div", "bar");
    parts.fill = make("div");
    parts.room = make("span");
    bar.append(parts.fill);
    parts.bar = bar;
    parts.fuel.append(make("span", "", "Fuel left at worst"), bar, parts.room);
    card.append(head, parts.trouble, parts.words, parts.refusal, parts.sums, parts.fuel);
    byId("cards").append(card);
    this.cards.set(name, parts);
    return parts;
  }

  /**
   * @param {Record<string, HTMLElement>} parts @param {string} name @param {number} rank
   * @param {Record<string, unknown>} of @param {import("./dive.js").PluginStory} story @param {any} state
   */
  card(parts, name, rank, of, story, state) {
    const t = state.t;
    const now = /** @type {any} */ (story.state.at(t));
    parts.card.style.setProperty("--tint", tint(tintName("plugin:" + name)));
    write(parts.state, now?.state ?? "not begun");
    mark(parts.state, "tone", pick(TONES, now?.state) ?? "");
    const leads = state.who?.key === "plugin:" + name;
    const flown = state.who?.key === "insert" && state.who.owner === name;
    show(parts.leads, leads || flown);
    write(parts.leads, leads ? "steers now" : "its insert is flown");
    parts.card.classList.toggle("leads", leads || flown);
    writeCut(parts.grants, `${rank}. may ${arr(of.grants, 12).map((g) => str(g, 20)).join(", ") || "nothing"}`, 60);
    parts.grants.title = str(of.component, 200);
    const failures = now?.failures ?? 0;
    show(parts.trouble, failures > 0 || Boolean(now?.text));
    writeCut(parts.trouble, `${failures ? `Failed ${failures === 1 ? "once" : failures + " times"}` : ""}${lastText(story, t)}`, 200);
    const said = /** @type {any} */ (story.words.at(t));
    writeCut(parts.words, said ? `${hms(said.t)} says: ${said.text}` : "has said nothing", 220);
    const refusal = /** @type {any} */ (story.refusal.at(t));
    show(parts.refusal, Boolean(refusal));
    if (refusal) writeCut(parts.refusal, `${hms(refusal.t)} ${refusal.kind} ${refusal.word}: ${refusal.reason || "no reason given"}`, 240);
    const sums = /** @type {any} */ (story.tally.at(t)) ?? { refused: 0, failed: 0, flown: 0 };
    write(parts.sums, `refused ${sums.refused} · failed ${sums.failed} · inserts flown ${sums.flown}`);
    this.fuel(parts, /** @type {any} */ (story.headroom.at(t)));
  }

  /** @param {Record<string, HTMLElement>} parts @param {any} room */
  fuel(parts, room) {
    show(parts.fuel, room?.fuel !== undefined);
    if (room?.fuel === undefined) return;
    const left = Math.max(0, 1 - room.fuel);
    parts.fill.style.width = (left * 100).toFixed(1) + "%";
    mark(parts.bar, "tone", left < 0.1 ? "bad" : left < 0.3 ? "warn" : "");
    mark(parts.fuel, "tone", left < 0.1 ? "bad" : "");
    write(parts.room, `${num(left * 100, left > 0.99 && left < 1 ? 1 : 0)} % · ${room.steps ?? "–"} steps`);
  }
}

/** The words of the last failure. @param {import("./dive.js").PluginStory} story @param {number} t */
function lastText(story, t) {
  for (let i = story.state.index(t); i >= 0; i--) {
    const state = /** @type {any} */ (story.state.v[i]);
    if (state.text) return `, at ${hms(state.t)}: ${state.text}`;
  }
  return "";
}

/** The store: takes items, and knows what the state was at any time. */
import { Columns, Series } from "./series.js";
import { Events } from "./events.js";
import { Steerer } from "./steer.js";
import { takers } from "./kinds.js";
import { str } from "./read.js";

const MAX_NAMES = 64;
const NAVIGATION = ["lat", "lon", "depth_m", "altitude_m", "heading_deg", "roll_deg", "pitch_deg",
  "speed_mps", "course_deg", "yaw_rate_dps", "gps", "who"];
const BEAT = ["refreshed", "worst_gap_s", "round_trip_s", "acknowledged", "heard", "navigated"];

export class PluginStory {
  constructor() {
    this.state = new Series();
    this.words = new Series(20000);
    this.refusal = new Series(20000);
    this.tally = new Series();
    this.headroom = new Series();
    this.sums = { asked: 0, refused: 0, failed: 0, flown: 0 };
  }
}

export class Dive {
  /** @param {any} about */
  constructor(about) {
    this.about = about;
    this.lastN = 0;
    this.count = 0;
    this.malformed = 0;
    this.unknown = 0;
    this.end = 0;
    this.over = false;
    this.navigation = new Columns(NAVIGATION, 0.95);
    this.beat = new Columns(BEAT, 0.4);
    this.reach = new Columns(["lat", "lon", "ahead_lat", "ahead_lon", "radius_m"], 0.9);
    this.swaths = new Columns(["lat", "lon", "heading_deg", "port_m", "starboard_m"], 0.9);
    /** @type {Series<import("./waterfall.js").Ping>} */
    this.pings = new Series(60000);
    /** @type {Map<string, Series<any>>} */
    this.contacts = new Map();
    this.truth = new Columns(["lat", "lon", "depth_m", "water_depth_m"], 0.95);
    /** @type {Record<string, Series<any>>} values that hold until the next */
    this.held = {};
    for (const name of ["status", "control", "steering", "mission", "element", "counts", "integrity", "recording",
      "operator", "who", "pace", "map:plan", "map:inserts", "map:requests", "end"]) {
      this.held[name] = new Series();
    }
    /** @type {Map<string, PluginStory>} */
    this.plugins = new Map();
    /** @type {Map<string, {plugin: string, name: string, unit: string, values: Columns}>} */
    this.measures = new Map();
    /** @type {Map<string, Series<any>>} */
    this.sensors = new Map();
    /** @type {Map<string, Series<any>>} */
    this.sonars = new Map();
    this.events = new Events();
    this.steerer = new Steerer();
    /** @type {string[]} keys of who steered, by number */
    this.keys = ["nobody"];
    for (const plugin of Array.isArray(about.plugins) ? about.plugins.slice(0, MAX_NAMES) : []) {
      this.plugin(str(plugin?.name, 80));
    }
    this.setWho(0);
  }

  /** @param {string} name @returns {PluginStory|undefined} */
  plugin(name) {
    return this.named(this.plugins, name, () => new PluginStory());
  }

  /**
   * @template V
   * @param {Map<string, V>} map
   * @param {string} name
   * @param {() => V} create
   * @returns {V|undefined}
   */
  named(map, name, create) {
    let found = map.get(name);
    if (!found && name && map.size < MAX_NAMES) {
      found = create();
      map.set(name, found);
    }
    return found;
  }

  /** Takes an item of the feed or of the history. @param {any} item */
  take(item) {
    if (!item || typeof item !== "object" || typeof item.kind !== "string"
      || !Number.isFinite(item.t) || !Number.isFinite(item.n)) {
      this.malformed += 1;
      return;
    }
    if (item.n <= this.lastN) return;
    this.lastN = item.n;
    this.count += 1;
    const taker = takers.get(item.kind);
    if (!taker) {
      this.unknown += 1;
      return;
    }
    if (item.t > this.end) this.end = item.t;
    if (this.steerer.take(item)) this.setWho(item.t);
    taker(this, item);
  }

  /** @param {number} t */
  setWho(t) {
    const who = this.steerer.who;
    const old = this.held.who.last;
    if (old && old.key === who.key && old.why === who.why && old.label === who.label) return;
    this.held.who.push(t, who);
    this.held.element.push(t, this.steerer.element);
    if (!this.keys.includes(who.key)) this.keys.push(who.key);
    this.key = this.keys.indexOf(who.key);
  }

  /** @param {string} name @param {number} t @returns {any} */
  at(name, t) {
    return this.held[name].at(t);
  }

  /**
   * The beat at a time. A later beat may tell of a refresh that was before that time.
   * @param {number} t
   */
  beatAt(t) {
    const i = this.beat.index(t);
    const row = this.beat.row(i);
    const next = this.beat.row(i + 1);
    if (!row || !next) return row;
    for (const name of ["refreshed", "acknowledged", "heard", "navigated"]) {
      if (next[name] <= t) row[name] = next[name];
    }
    return row;
  }

  /** All that the views need of a moment. @param {number} t */
  stateAt(t) {
    const beat = this.beatAt(t);
    const navigation = this.navigation.at(t);
    const words = [beat?.heard, navigation?.t].filter((s) => s !== undefined && Number.isFinite(s));
    const heard = words.length ? Math.max(.../** @type {number[]} */ (words)) : NaN;
    return {
      t, beat, navigation, heard,
      navigated: navigation ? Math.max(navigation.t, beat?.navigated || 0) : NaN,
      who: this.at("who", t), status: this.at("status", t), control: this.at("control", t),
      steering: this.at("steering", t), mission: this.at("mission", t), element: this.at("element", t),
      counts: this.at("counts", t), integrity: this.at("integrity", t), operator: this.at("operator", t),
      truth: this.truth.at(t),
    };
  }
}

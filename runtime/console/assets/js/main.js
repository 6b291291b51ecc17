/** Puts the page together: one store, one clock, and views that draw the time shown. */
import { Banners } from "./banners.js";
import { Clock } from "./clock.js";
import { Countdown } from "./countdown.js";
import { Dive } from "./dive.js";
import { byId } from "./dom.js";
import { EventList } from "./event_list.js";
import { Feed } from "./feed.js";
import { loadHistory, takeSafely } from "./history.js";
import { startKeys } from "./keys.js";
import { MapView } from "./map.js";
import { Measures } from "./measures.js";
import { Operator } from "./operator.js";
import { Player } from "./player.js";
import { Plugins } from "./plugins.js";
import { Profile } from "./profile.js";
import { Scrubber } from "./scrubber.js";
import { Strip } from "./strip.js";
import { goTo, startTabs } from "./tabs.js";
import { startTheme, toggleTheme } from "./theme.js";
import { Vehicle } from "./vehicle.js";
import { Waterfall } from "./waterfall.js";

/**
 * What views draw.
 * @typedef {{state: any, dive: Dive, about: any, clock: Clock, live: boolean, link: string, silence: number,
 *   loading: number, trouble: string, seeked: boolean}} Shown
 */

const DRAW_MS = 100;

class Page {
  constructor() {
    /** @type {any} */
    this.about = { kind: "recorded", plugins: [], began_ns: "" };
    this.dive = new Dive(this.about);
    this.clock = new Clock(() => this.dive);
    this.loading = 0;
    this.trouble = "";
    this.seeked = true;
    this.drawnAt = 0;
    /** @type {Set<unknown>} views that failed once */
    this.failed = new Set();
    const seek = (/** @type {number} */ t) => this.seek(t);
    const current = () => this.shown();
    startTheme();
    startTabs();
    this.map = new MapView(seek, current);
    this.strip = new Strip();
    this.countdown = new Countdown();
    this.vehicle = new Vehicle();
    this.profile = new Profile(seek);
    this.measures = new Measures(seek);
    this.waterfall = new Waterfall(seek);
    this.plugins = new Plugins();
    this.scrubber = new Scrubber(seek, current);
    this.list = new EventList(seek);
    this.banners = new Banners();
    this.operator = new Operator(() => Boolean(this.dive.held.operator.last?.held));
    this.player = new Player(this.clock, () => { this.seeked = true; });
    this.feed = new Feed({
      after: () => this.dive.lastN,
      items: (items) => this.take(items),
      reset: () => { void this.load(); },
      check: () => this.check(),
    });
    this.keys();
    const frame = () => {
      this.tick();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  keys() {
    const { clock } = this;
    const step = (/** @type {number} */ way) => (/** @type {KeyboardEvent} */ e) => this.seek(clock.shown + way * (e.shiftKey ? 60 : 10));
    /** @type {Record<string, (e: KeyboardEvent) => void>} */
    const acts = {
      " ": () => byId("play").click(), ArrowLeft: step(-1), ArrowRight: step(1),
      Home: () => this.seek(0), End: () => this.seek(clock.end), "[": () => this.scrubber.toMark(-1), "]": () => this.scrubber.toMark(1),
      l: () => { clock.goLive(); this.seeked = true; },
      f: () => byId("follow").click(), g: () => this.map.fit(), h: () => byId("hold").click(), t: toggleTheme,
      "+": () => this.map.zoom(1), "=": () => this.map.zoom(1), "-": () => this.map.zoom(-1),
      "/": () => { goTo(4); byId("search").focus(); },
    };
    for (const n of [1, 2, 3, 4]) acts[String(n)] = () => goTo(n);
    startKeys(acts);
  }

  /** @param {number} t */
  seek(t) {
    this.clock.seek(t);
    this.seeked = true;
  }

  /** @returns {Shown} */
  shown() {
    const { dive, about, clock, loading, trouble, seeked } = this;
    const paused = Boolean(about.pace) && clock.times === 0;
    const over = dive.over || !clock.live;
    const link = over ? "fresh" : this.feed.state(paused);
    const silence = performance.now() - this.feed.itemAt;
    return { state: dive.stateAt(clock.shown), dive, about, clock, live: clock.live && clock.following, link, silence, loading, trouble, seeked };
  }

  tick() {
    const now = performance.now();
    this.clock.tick();
    if (!this.seeked && now - this.drawnAt < DRAW_MS) return;
    this.drawnAt = now;
    const shown = this.shown();
    this.seeked = false;
    for (const view of [this.banners, this.strip, this.countdown, this.vehicle, this.map, this.profile, this.waterfall, this.measures, this.plugins, this.scrubber, this.list]) {
      this.drawOne(view, shown);
    }
    this.player.draw();
    this.operator.draw(Boolean(this.dive.held.operator.last?.held));
    this.drawMs = performance.now() - now;
  }

  /** A view that fails must not take the others with it. @param {{draw: (shown: Shown) => void}} view @param {Shown} shown */
  drawOne(view, shown) {
    try {
      view.draw(shown);
    } catch (error) {
      if (this.failed.has(view)) return;
      this.failed.add(view);
      console.error(error);
    }
  }

  /** @param {unknown[]} items */
  take(items) {
    for (const item of items) takeSafely(this.dive, item);
    if (items.length) this.clock.hear(this.dive.end);
    const pace = this.dive.held.pace.last;
    if (pace !== undefined && pace !== this.clock.times) this.player.set(pace);
    if (this.dive.over) this.feed.stop();
  }

  /** @returns {Promise<any>} */
  async fetchAbout() {
    const answer = await fetch("api/about", { cache: "no-store", signal: AbortSignal.timeout(5000) });
    if (!answer.ok) throw new Error("about: " + answer.status);
    return answer.json();
  }

  /** Whether the same run still goes on; another run is loaded anew. */
  async check() {
    try {
      const about = await this.fetchAbout();
      if (about.run === this.about.run && about.began_ns === this.about.began_ns && about.kind === this.about.kind) {
        if (Number.isFinite(about.now)) this.clock.hear(about.now);
        return true;
      }
      this.feed.stop();
      void this.load();
      return false;
    } catch {
      return false;
    }
  }

  /** Fetches what the run is and what happened; then the feed begins. */
  async load() {
    this.loading = 0;
    for (let tries = 0; ; tries++) {
      try {
        this.about = await this.fetchAbout();
        this.begin();
        await loadHistory(this.dive, (done, total) => this.told(done, total));
        break;
      } catch (error) {
        this.trouble = `The program does not answer (${String(error).slice(0, 80)}). Trying again.`;
        await new Promise((go) => setTimeout(go, Math.min(3000, 500 * (tries + 1))));
      }
    }
    this.loading = 1;
    this.clock.hear(this.dive.end);
    // A recorded dive begins when the vehicle is known, not with empty figures.
    const known = this.dive.navigation;
    if (!this.clock.live && !this.clock.following && this.clock.t === 0 && known.length > 3) this.clock.t = known.t[3];
    this.seeked = true;
    if (this.clock.live && !this.dive.over) this.feed.start();
  }

  begin() {
    this.trouble = "";
    const was = { following: this.clock.following, t: this.clock.t, same: this.clock.live && this.about.began_ns + this.about.run === this.began };
    this.began = this.about.began_ns + this.about.run;
    this.dive = new Dive(this.about);
    this.clock.begin(this.about);
    if (was.same && !was.following) Object.assign(this.clock, { following: false, t: was.t });
    this.map.begin(this.about);
    this.measures.clear();
    this.plugins.clear();
    this.plugins.limits(this.about.limits);
    this.list.reset();
    this.list.edits = -1;
    this.player.begin(this.about);
    this.operator.begin(this.about.operator === true && this.clock.live);
    this.seeked = true;
  }

  /** @param {number} done @param {number} total */
  told(done, total) {
    this.loading = total ? Math.min(0.99, done / total) : 0;
    this.clock.hear(this.dive.end);
    this.seeked = true;
  }
}

const page = new Page();
void page.load();
// For tests and the curious; holds no token.
Object.assign(window, { page });

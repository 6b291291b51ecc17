/** Which time is shown, and what the time of the run is now. */

export class Clock {
  /** @param {() => import("./dive.js").Dive} dive */
  constructor(dive) {
    this.dive = dive;
    this.live = false;
    this.real = false;
    this.times = 1;
    this.anchor = { t: 0, at: performance.now() };
    this.following = true;
    this.t = 0;
    this.playing = false;
    this.speed = 1;
    this.ticked = performance.now();
  }

  /** @param {any} about */
  begin(about) {
    this.live = about.kind !== "recorded";
    this.real = about.kind === "live";
    this.times = about.pace?.times ?? 1;
    this.following = this.live;
    this.anchor = { t: about.now ?? 0, at: performance.now() };
    if (!this.live) this.t = 0;
  }

  /** The newest time that was heard of. @param {number} t */
  hear(t) {
    if (!Number.isFinite(t)) return;
    if (this.real && t < this.now() && this.now() - t < 60) return;
    this.anchor = { t, at: performance.now() };
  }

  /**
   * The time of the run now. A real run goes on by the browser's own clock since the newest item; a
   * simulation is only as far as it has told.
   */
  now() {
    const dive = this.dive();
    if (!this.live || dive.over) return dive.end;
    return this.anchor.t + (this.real ? (performance.now() - this.anchor.at) / 1000 : 0);
  }

  /** The end of the time line. */
  get end() {
    return Math.max(1, this.live ? this.now() : this.dive().end);
  }

  /** The time that is shown. */
  get shown() {
    return this.following ? this.now() : this.t;
  }

  /** @param {number} t */
  seek(t) {
    const end = this.end;
    this.t = Math.min(end, Math.max(0, t));
    this.following = this.live && t >= end;
    if (this.following) this.playing = false;
  }

  /** @param {number} by seconds */
  step(by) {
    this.seek(this.shown + by);
  }

  goLive() {
    if (!this.live) return this.seek(this.end);
    this.following = true;
    this.playing = false;
  }

  toggle() {
    if (this.following && this.live && !this.dive().over) {
      this.t = this.now();
      this.following = false;
      this.playing = false;
      return;
    }
    if (!this.playing && this.shown >= this.end - 0.01) this.seek(0);
    this.following = false;
    this.playing = !this.playing;
  }

  /** Moves the shown time on while it plays. */
  tick() {
    const now = performance.now();
    const since = Math.min(0.5, (now - this.ticked) / 1000);
    this.ticked = now;
    if (!this.playing || this.following) return;
    this.t += since * this.speed;
    if (this.t >= this.end) {
      this.t = this.end;
      this.playing = false;
      if (this.live) this.following = true;
    }
  }
}

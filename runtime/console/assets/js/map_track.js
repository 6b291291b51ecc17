/** The track, coloured by who steered, up to the time shown; what comes later is faint. */
import * as L from "../vendor/leaflet/leaflet.js";
import { tint, tintName } from "./theme.js";

const CHUNK = 400;
const MAX_POINTS = 24000;

/** @typedef {{from: number, to: number, key: number, points: [number, number][], times: number[], line: any, cut: boolean}} Chunk */

export class Track {
  /** @param {any} map @param {any} renderer @param {(e: any, t: number, key: string) => void} clicked */
  constructor(map, renderer, clicked) {
    this.map = map;
    this.renderer = renderer;
    this.clicked = clicked;
    this.gap = 1;
    /** @type {Chunk[]} */
    this.chunks = [];
    this.taken = 0;
    this.points = 0;
    this.shownTo = -1;
    this.futureAt = -1;
    /** @type {any} */
    this.future = undefined;
    this.clear();
  }

  clear() {
    for (const chunk of this.chunks) chunk.line.remove();
    this.chunks = [];
    this.taken = 0;
    this.points = 0;
    this.shownTo = -1;
    this.future?.remove();
    this.future = L.polyline([], { renderer: this.renderer, color: tint("c-nobody"), weight: 1.5, opacity: 0.5, interactive: false }).addTo(this.map);
    this.futureAt = -1;
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t @param {boolean} following */
  draw(dive, t, following) {
    const added = this.take(dive);
    if (this.points > MAX_POINTS) {
      this.gap *= 2;
      this.clear();
      this.take(dive);
    }
    if (added || t !== this.shownTo) this.cutAt(t);
    this.shownTo = t;
    this.drawFuture(dive, t, following);
    return added;
  }

  /** Takes the settled rows of navigation. @param {import("./dive.js").Dive} dive */
  take(dive) {
    const nav = dive.navigation;
    const before = this.chunks.length;
    for (; this.taken < nav.length - 1; this.taken++) {
      const i = this.taken;
      const key = nav.c.who[i] || 0;
      let chunk = this.chunks[this.chunks.length - 1];
      const point = /** @type {[number, number]} */ ([nav.c.lat[i], nav.c.lon[i]]);
      if (!chunk || chunk.key !== key || chunk.points.length >= CHUNK) chunk = this.next(chunk, key, dive.keys[key] ?? "nobody", nav.t[i], point);
      else if (far(chunk.points[chunk.points.length - 1], point) < this.gap && nav.t[i] - chunk.to < 20 * this.gap) continue;
      chunk.points.push(point);
      chunk.times.push(nav.t[i]);
      chunk.to = nav.t[i];
      chunk.cut = true;
      this.points += 1;
    }
    return this.chunks.length !== before;
  }

  /** @param {Chunk|undefined} last @param {number} key @param {string} name @param {number} t @param {[number, number]} point */
  next(last, key, name, t, point) {
    const near = last && far(last.points[last.points.length - 1], point) < 100;
    const start = near ? last.points[last.points.length - 1] : point;
    const line = L.polyline([], { renderer: this.renderer, color: tint(tintName(name)), weight: 4, opacity: 0.95, smoothFactor: 1 });
    /** @type {Chunk} */
    const chunk = { from: t, to: t, key, points: [start], times: [near ? last.to : t], line, cut: true };
    line.on("click", (/** @type {any} */ e) => this.clicked(e, this.nearest(chunk, e.latlng), name));
    this.chunks.push(chunk);
    return chunk;
  }

  /** @param {Chunk} chunk @param {any} at */
  nearest(chunk, at) {
    let best = 0;
    chunk.points.forEach((p, i) => {
      if (far(p, [at.lat, at.lng]) < far(chunk.points[best], [at.lat, at.lng])) best = i;
    });
    return chunk.times[best];
  }

  /** @param {number} t */
  cutAt(t) {
    for (const chunk of this.chunks) {
      if (chunk.from > t) {
        if (this.map.hasLayer(chunk.line)) chunk.line.remove();
        continue;
      }
      const whole = chunk.to <= t;
      if (!whole || chunk.cut) {
        const n = whole ? chunk.points.length : chunk.times.findIndex((s) => s > t);
        chunk.line.setLatLngs(chunk.points.slice(0, n));
        chunk.cut = !whole;
      }
      if (!this.map.hasLayer(chunk.line)) chunk.line.addTo(this.map);
    }
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t @param {boolean} following */
  drawFuture(dive, t, following) {
    const want = following || t >= dive.end - 1 ? 0 : this.points;
    if (want === this.futureAt) return;
    if (want && this.futureAt > 0 && want - this.futureAt < 30) return;
    this.futureAt = want;
    this.future.setLatLngs(want ? this.chunks.flatMap((chunk) => chunk.points) : []);
    this.future.bringToBack();
  }

  restyle(/** @type {string[]} */ keys) {
    for (const chunk of this.chunks) chunk.line.setStyle({ color: tint(tintName(keys[chunk.key] ?? "nobody")) });
    this.future.setStyle({ color: tint("c-nobody") });
  }
}

/** Metres, roughly. @param {[number, number]} a @param {[number, number]} b */
function far(a, b) {
  return Math.hypot((a[0] - b[0]) * 111320, (a[1] - b[1]) * 111320 * Math.cos((a[0] * Math.PI) / 180));
}

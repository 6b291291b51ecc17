/** The sidescan: a line a ping, the newest at the top, port on the left. */
import { byId, fit, show, write } from "./dom.js";
import { hms, num } from "./format.js";

/** Values of each side. */
export const BINS = 128;
const ROWS = 240;
/** A ping that came longer ago than this is not shown as the newest, seconds. */
const OLD = 30;

/** The bytes of hexadecimal digits, or nothing. @param {unknown} text @returns {Uint8Array|undefined} */
export function bytes(text) {
  if (typeof text !== "string" || text.length !== 2 * BINS || !/^[0-9a-f]*$/.test(text)) return undefined;
  return Uint8Array.from({ length: BINS }, (_, i) => parseInt(text.slice(2 * i, 2 * i + 2), 16));
}

/** @typedef {{t: number, port: Uint8Array|undefined, starboard: Uint8Array|undefined, range: number}} Ping */

export class Waterfall {
  /** @param {(t: number) => void} seek */
  constructor(seek) {
    this.canvas = /** @type {HTMLCanvasElement} */ (byId("waterfall-canvas"));
    this.mark = "";
    /** @type {Ping[]} */
    this.rows = [];
    const off = document.createElement("canvas");
    off.width = 2 * BINS;
    off.height = ROWS;
    this.off = off;
    this.canvas.addEventListener("click", (e) => {
      const row = this.rows[Math.floor((e.offsetY / this.canvas.clientHeight) * ROWS)];
      if (row) seek(row.t);
    });
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, dive }) {
    const { pings } = dive;
    show(byId("waterfall"), pings.t.length > 0);
    if (!pings.t.length) return;
    const last = pings.index(state.t);
    const old = last < 0 || state.t - pings.t[last] > OLD;
    const mark = `${last} ${old} ${pings.t.length > last + 1} ${this.canvas.clientWidth}`;
    if (mark === this.mark) return;
    this.mark = mark;
    this.rows = last < 0 || old ? [] : pings.v.slice(Math.max(0, last + 1 - ROWS), last + 1).reverse();
    this.paint();
    const first = this.rows[0];
    const end = this.rows[this.rows.length - 1];
    write(byId("waterfall-range"), first
      ? `${num(first.range, 0, "m")} to each side, ${hms(end.t)} to ${hms(first.t)}` : "no ping for 30 s");
  }

  paint() {
    const context = this.off.getContext("2d");
    const canvas = fit(this.canvas);
    if (!context || !canvas) return;
    const image = context.createImageData(2 * BINS, ROWS);
    const flat = [this.levels("port"), this.levels("starboard")];
    this.rows.forEach((row, y) => {
      for (let i = 0; i < BINS; i++) {
        this.dot(image.data, (y * 2 * BINS + BINS - 1 - i) * 4, row.port, i, flat[0]);
        this.dot(image.data, (y * 2 * BINS + BINS + i) * 4, row.starboard, i, flat[1]);
      }
    });
    context.putImageData(image, 0, 0);
    canvas.ctx.imageSmoothingEnabled = true;
    canvas.ctx.drawImage(this.off, 0, 0, canvas.w, canvas.h);
  }

  /**
   * What is usual at each range: echoes fade with it, and the picture shows what differs.
   * @param {"port"|"starboard"} side
   */
  levels(side) {
    const sums = new Float64Array(BINS);
    let n = 0;
    for (const row of this.rows) {
      const values = row[side];
      if (!values) continue;
      n += 1;
      for (let i = 0; i < BINS; i++) sums[i] += values[i];
    }
    return sums.map((sum) => sum / Math.max(1, n));
  }

  /** @param {Uint8ClampedArray} data @param {number} at @param {Uint8Array|undefined} values @param {number} i @param {Float64Array} flat */
  dot(data, at, values, i, flat) {
    const value = values ? Math.max(0, Math.min(1, 0.42 + (values[i] - flat[i]) / 70)) : 0;
    data[at] = 255 * Math.min(1, 1.25 * value);
    data[at + 1] = 205 * value;
    data[at + 2] = 110 * value * value;
    data[at + 3] = 255;
  }
}

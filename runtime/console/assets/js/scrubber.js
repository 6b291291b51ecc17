/** The time line: who steered as a band, marks of what happened, and the time shown. */
import { byId, fit, mark, show, write } from "./dom.js";
import { cut, hms } from "./format.js";
import { onTheme, tint, tintName } from "./theme.js";

/** @typedef {import("./main.js").Shown} Shown */

/** @type {Record<string, [string, number]>} colour and lane of each type of mark */
const MARKS = {
  lease: ["soft", 0], integrity: ["unsure", 1], lost: ["warn-fill", 1], operator: ["held", 1], refused: ["refused", 2], failed: ["bad-fill", 2],
};
const BAND_Y = 34;

export class Scrubber {
  /** @param {(t: number) => void} seek @param {() => Shown} current */
  constructor(seek, current) {
    this.seek = seek;
    this.current = current;
    this.box = byId("scrubber");
    this.canvas = /** @type {HTMLCanvasElement} */ (byId("scrub-canvas"));
    this.drawn = 0;
    this.mark = "";
    onTheme(() => { this.mark = ""; });
    new ResizeObserver(() => { this.mark = ""; }).observe(this.box);
    this.box.addEventListener("pointerdown", (e) => {
      this.box.setPointerCapture(e.pointerId);
      this.seek(this.timeAt(e));
    });
    this.box.addEventListener("pointermove", (e) => {
      if (e.buttons & 1) this.seek(this.timeAt(e));
      this.tip(e);
    });
    this.box.addEventListener("pointerup", (e) => {
      if (e.pointerType !== "mouse") show(byId("scrub-tip"), false);
    });
    this.box.addEventListener("pointerleave", () => show(byId("scrub-tip"), false));
  }

  /** @param {PointerEvent} e */
  timeAt(e) {
    const box = this.box.getBoundingClientRect();
    const part = (e.clientX - box.left) / box.width;
    const end = this.current().clock.end;
    const t = Math.min(1, Math.max(0, part)) * end;
    return part > 0.997 ? end : t;
  }

  /** @param {PointerEvent} e */
  tip(e) {
    const { dive, clock } = this.current();
    const t = this.timeAt(e);
    const reach = (clock.end / this.box.clientWidth) * 5;
    const near = dive.events.marks.filter((m) => Math.abs(m.t - t) <= reach).slice(0, 4);
    const tip = byId("scrub-tip");
    write(tip, [hms(t), ...near.map((m) => cut(m.text, 90))].join(" · "));
    const half = Math.min(165, this.box.clientWidth / 2);
    tip.style.left = Math.min(this.box.clientWidth - half, Math.max(half, e.clientX - this.box.getBoundingClientRect().left)) + "px";
    show(tip, true);
  }

  /** @param {Shown} shown */
  draw({ state, dive, clock }) {
    const end = clock.end;
    const now = performance.now();
    const sign = `${end.toFixed(0)} ${dive.events.marks.length} ${dive.held.who.t.length}`;
    if (sign !== this.mark && (now - this.drawn > 900 || this.mark === "" || !clock.live)) {
      this.mark = sign;
      this.drawn = now;
      this.paint(dive, end);
    }
    byId("scrub-now").style.left = (Math.min(1, state.t / end) * 100).toFixed(3) + "%";
    this.box.setAttribute("aria-valuemax", end.toFixed(0));
    this.box.setAttribute("aria-valuenow", state.t.toFixed(0));
    this.box.setAttribute("aria-valuetext", `${hms(state.t)} of ${hms(end)}`);
    write(byId("scrub-time"), `${hms(state.t)} / ${hms(end)}`);
    mark(this.box, "following", String(clock.following));
  }

  /** @param {import("./dive.js").Dive} dive @param {number} end */
  paint(dive, end) {
    const area = fit(this.canvas);
    if (!area) return;
    const { ctx, w, h } = area;
    const x = (/** @type {number} */ t) => (t / end) * w;
    ctx.fillStyle = tint("button");
    ctx.fillRect(0, 0, w, h);
    const who = dive.held.who;
    for (let i = 0; i < who.t.length; i++) {
      const from = x(who.t[i]);
      const to = i + 1 < who.t.length ? x(who.t[i + 1]) : x(Math.min(end, dive.end));
      ctx.fillStyle = tint(tintName(who.v[i].key));
      ctx.globalAlpha = who.v[i].key === "nobody" ? 0.35 : 1;
      ctx.fillRect(from, BAND_Y, Math.max(1, to - from), h - BAND_Y);
    }
    ctx.globalAlpha = 1;
    /** @type {Set<string>} */
    const there = new Set();
    for (const event of dive.events.marks) {
      const [name, lane] = MARKS[event.type] ?? ["soft", 0];
      const px = Math.round(x(event.t));
      if (there.has(px + name)) continue;
      there.add(px + name);
      ctx.fillStyle = tint(name);
      this.shape(ctx, event.type, px, 2 + lane * 11);
    }
  }

  /** Each type has its own shape, not only its colour. @param {CanvasRenderingContext2D} ctx @param {string} type @param {number} x @param {number} y */
  shape(ctx, type, x, y) {
    ctx.beginPath();
    if (type === "lease") ctx.rect(x - 1, y, 2, 32);
    else if (type === "failed") ctx.rect(x - 4, y, 8, 8);
    else if (type === "operator") ctx.arc(x, y + 4, 5, 0, 7);
    else if (type === "refused") {
      ctx.moveTo(x - 5, y);
      ctx.lineTo(x + 5, y);
      ctx.lineTo(x, y + 9);
    } else {
      ctx.moveTo(x, y - 1);
      ctx.lineTo(x + 5, y + 4);
      ctx.lineTo(x, y + 9);
      ctx.lineTo(x - 5, y + 4);
    }
    ctx.fill();
  }

  /** To the next or the last mark. @param {number} way 1 or -1 */
  toMark(way) {
    const { state, dive } = this.current();
    const times = dive.events.marks.map((m) => m.t);
    const found = way > 0 ? times.find((t) => t > state.t + 0.5) : times.findLast((t) => t < state.t - 0.5);
    if (found !== undefined) this.seek(found);
  }
}

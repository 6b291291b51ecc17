/** What plugins measure, as small plots, and what sensors and sonars say. */
import { byId, fit, make, mark, terms, write, writeCut } from "./dom.js";
import { age, short } from "./format.js";
import { tint, tintName } from "./theme.js";
import { cut } from "./format.js";

const SPAN_S = 600;
const MAX_PLOTS = 24;

export class Measures {
  /** @param {(t: number) => void} seek */
  constructor(seek) {
    this.seek = seek;
    /** @type {Map<string, {value: HTMLElement, range: HTMLElement, canvas: HTMLCanvasElement}>} */
    this.parts = new Map();
    this.drawn = 0;
    this.shownAt = NaN;
    /** @type {[number, number]} */
    this.span = [0, SPAN_S];
  }

  clear() {
    this.parts.clear();
    byId("measures").replaceChildren();
    byId("sensors").replaceChildren();
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, dive, clock }) {
    const now = performance.now();
    if (now - this.drawn < 450 && Math.abs(state.t - this.shownAt) < 2) return;
    this.drawn = now;
    this.shownAt = state.t;
    const to = Math.min(clock.end, Math.max(SPAN_S, state.t + (clock.following ? 0 : SPAN_S / 5)));
    this.span = [Math.max(0, to - SPAN_S), to];
    for (const [key, measure] of [...dive.measures].slice(0, MAX_PLOTS)) this.one(key, measure, state.t);
    this.sensors(dive, state.t);
  }

  /** @param {string} key @param {any} measure @param {number} t */
  one(key, measure, t) {
    const part = this.parts.get(key) ?? this.build(key, measure);
    const i = measure.values.index(t);
    write(part.value, i < 0 ? "–" : `${short(measure.values.c.value[i])} ${cut(measure.unit, 8)}`);
    this.plot(part, measure, t);
  }

  /** @param {string} key @param {any} measure */
  build(key, measure) {
    const box = make("div", "measure");
    const head = make("h3");
    const name = make("span");
    writeCut(name, measure.name, 24);
    const range = make("span", "soft");
    head.append(name, range);
    const value = make("p", "value");
    const canvas = document.createElement("canvas");
    canvas.addEventListener("click", (e) => {
      const [a, b] = this.span;
      this.seek(a + (e.offsetX / canvas.clientWidth) * (b - a));
    });
    box.title = `${cut(measure.name, 80)} of ${cut(measure.plugin, 80)}, 10 minutes`;
    box.append(head, value, canvas);
    byId("measures").append(box);
    const part = { value, range, canvas };
    this.parts.set(key, part);
    return part;
  }

  /** @param {any} part @param {any} measure @param {number} t */
  plot(part, measure, t) {
    const area = fit(part.canvas);
    if (!area) return;
    const { ctx, w, h } = area;
    const [from, to] = this.span;
    const values = measure.values;
    const first = Math.max(0, values.index(from));
    const last = values.index(to);
    let low = Infinity;
    let high = -Infinity;
    for (let i = first; i <= last; i++) {
      low = Math.min(low, values.c.value[i]);
      high = Math.max(high, values.c.value[i]);
    }
    if (low > high) return;
    write(part.range, `${short(low)} … ${short(high)}`);
    const x = (/** @type {number} */ s) => ((s - from) / (to - from)) * w;
    const y = (/** @type {number} */ v) => h - 3 - ((v - low) / (high - low || 1)) * (h - 6);
    ctx.strokeStyle = tint(tintName("plugin:" + measure.plugin));
    ctx.lineWidth = 1.8;
    ctx.beginPath();
    let before = -Infinity;
    for (let i = first; i <= last; i++) {
      const gap = values.t[i] - before > 15;
      before = values.t[i];
      ctx[gap ? "moveTo" : "lineTo"](x(before), y(values.c.value[i]));
    }
    ctx.stroke();
    ctx.fillStyle = tint("ink");
    ctx.fillRect(x(t) - 1, 0, 2, h);
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t */
  sensors(dive, t) {
    const boxes = [];
    for (const [name, series] of dive.sensors) {
      const now = series.at(t);
      if (!now) continue;
      boxes.push(this.box(name, age(t - now.t) + " ago", terms(now.data.map((/** @type {[string, any]} */ [key, value]) => (
        [key.replaceAll("_", " "), typeof value === "number" ? short(value) : value])))));
    }
    for (const [name, series] of dive.sonars) {
      const now = series.at(t);
      if (!now) continue;
      const box = this.box("sonar " + name, now.ok ? "ok" : "not ok", terms([["says", now.text]]));
      mark(box, "tone", now.ok ? "" : "bad");
      boxes.push(box);
    }
    byId("sensors").replaceChildren(...boxes);
  }

  /** @param {string} name @param {string} aside @param {HTMLElement} body */
  box(name, aside, body) {
    const box = make("div", "sensor");
    const head = make("h3");
    head.append(make("span", "", cut(name, 40)), make("span", "soft", aside));
    box.append(head, body);
    return box;
  }
}

/** Depth and ground over time, with the fence's limits. */
import uPlot from "../vendor/uplot/uplot.js";
import { byId, make } from "./dom.js";
import { hms } from "./format.js";
import { fenceLimits } from "./fence.js";
import { onTheme, tint } from "./theme.js";

const BINS = 500;

export class Profile {
  /** @param {(t: number) => void} seek */
  constructor(seek) {
    this.box = byId("profile");
    this.span = /** @type {HTMLSelectElement} */ (byId("profile-span"));
    this.line = make("div", "now");
    this.made = 0;
    this.mark = "";
    /** @type {[number, number]} */
    this.range = [0, 1];
    this.plot = this.build(seek);
    this.plot.over.append(this.line);
    new ResizeObserver(() => this.size()).observe(this.box);
    onTheme(() => this.plot.redraw(false));
  }

  size() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (width && height) this.plot.setSize({ width, height });
  }

  /** @param {(t: number) => void} seek */
  build(seek) {
    const axis = { stroke: () => tint("soft"), grid: { stroke: () => tint("line"), width: 1 }, ticks: { show: false }, font: "13px system-ui", size: 26 };
    const dashed = (/** @type {string} */ name) => ({ stroke: () => tint(name), width: 2, dash: [6, 5], points: { show: false } });
    const plot = new uPlot({
      width: 300, height: 170, padding: [6, 24, 0, 0], legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false } },
      scales: { x: { time: false, range: () => this.range }, y: { dir: -1, range: (_u, min, max) => [Math.min(0, min ?? 0), (max ?? 10) * 1.08 + 1] } },
      axes: [
        { ...axis, values: (_u, ticks) => ticks.map(hms), space: 76, incrs: [1, 5, 10, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400] },
        { ...axis, size: 44, values: (_u, ticks) => ticks.map((v) => v + " m"), space: 30 },
      ],
      series: [{},
        { stroke: () => tint("ground"), fill: () => tint("ground-fill"), fillTo: (u) => u.scales.y.max ?? 0, width: 2, points: { show: false } },
        dashed("warn"), dashed("bad"),
        { stroke: () => tint("depth"), width: 2.5, points: { show: false } }],
    }, [[0], [null], [null], [null], [null]], this.box);
    plot.over.addEventListener("click", () => {
      const left = plot.cursor.left ?? -1;
      if (left >= 0) seek(plot.posToVal(left, "x"));
    });
    return plot;
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, dive, about, clock }) {
    const span = Number(this.span.value);
    const end = clock.end;
    const to = span ? Math.min(end, Math.max(span, state.t + span * 0.2)) : end;
    const from = span ? Math.max(0, to - span) : 0;
    const now = performance.now();
    const mark = `${from.toFixed(0)} ${to.toFixed(0)} ${span}`;
    if (mark !== this.mark && (now - this.made > 900 || !clock.following)) {
      this.mark = mark;
      this.made = now;
      this.range = [from, Math.max(from + 1, to)];
      this.plot.setData(this.data(dive, fenceLimits(about.fence), from, to));
    }
    const left = this.plot.valToPos(state.t, "x");
    this.line.style.transform = `translateX(${(left - 1).toFixed(1)}px)`;
    this.line.hidden = state.t < this.range[0] || state.t > this.range[1];
  }

  /**
   * Thinned to the deepest and the shallowest of each bin.
   * @param {import("./dive.js").Dive} dive @param {any} limits @param {number} from @param {number} to
   */
  data(dive, limits, from, to) {
    const nav = dive.navigation;
    const first = Math.max(0, nav.index(from));
    const last = nav.index(to);
    const step = Math.max(1, Math.ceil((last - first + 1) / BINS));
    /** @type {(number|null)[][]} */
    const out = [[], [], [], [], []];
    const put = (/** @type {number} */ i) => {
      const depth = nav.c.depth_m[i];
      const ground = depth + nav.c.altitude_m[i];
      out[0].push(nav.t[i]);
      out[1].push(Number.isFinite(ground) ? ground : null);
      out[2].push(Number.isFinite(ground) && limits.altitudeMin !== undefined ? ground - limits.altitudeMin : null);
      out[3].push(limits.depthMax ?? null);
      out[4].push(Number.isFinite(depth) ? depth : null);
    };
    for (let i = first; i <= last; i += step) {
      let low = i;
      let high = i;
      for (let k = i; k < Math.min(i + step, last + 1); k++) {
        if (nav.c.depth_m[k] < nav.c.depth_m[low]) low = k;
        if (nav.c.depth_m[k] > nav.c.depth_m[high]) high = k;
      }
      put(Math.min(low, high));
      if (low !== high) put(Math.max(low, high));
    }
    return /** @type {any} */ (out);
  }
}

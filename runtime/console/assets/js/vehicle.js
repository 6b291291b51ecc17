/** The vehicle's figures, beside what is wanted of it. */
import { byId, make, mark, write, writeCut } from "./dom.js";
import { heading, latitude, longitude, num } from "./format.js";
import { fenceLimits } from "./fence.js";

const FIGURES = [["depth", "Depth"], ["altitude", "Above ground"], ["speed", "Speed"], ["heading", "Heading"],
  ["pitch", "Pitch / roll"], ["course", "Course"], ["position", "Position", "wide"]];

export class Vehicle {
  constructor() {
    /** @type {Record<string, {box: HTMLElement, value: HTMLElement, wanted: HTMLElement}>} */
    this.parts = {};
    const figures = byId("figures");
    for (const [name, title, extra] of FIGURES) {
      const box = make("div", "figure " + (extra ?? ""));
      const value = make("p", "value", "–");
      const wanted = make("p", "wanted");
      value.id = "figure-" + name;
      box.append(make("h3", "", title), value, wanted);
      figures.append(box);
      this.parts[name] = { box, value, wanted };
    }
  }

  /** @param {string} name @param {string} value @param {string} [wanted] @param {string} [tone] */
  put(name, value, wanted = "", tone = "") {
    const part = this.parts[name];
    write(part.value, value);
    write(part.wanted, wanted);
    mark(part.box, "tone", tone);
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, about }) {
    writeCut(byId("vehicle-name"), typeof about.vehicle === "string" ? about.vehicle : "", 40);
    const nav = state.navigation ?? {};
    const asked = state.steering?.owner ? state.steering : {};
    const limits = fenceLimits(about.fence);
    mark(byId("figures"), "old", state.t - state.navigated < 3 ? "" : "yes");
    const want = (/** @type {number|undefined} */ x, /** @type {string} */ text) => (x === undefined ? "" : "wanted " + text);
    this.put("depth", num(nav.depth_m, 1, "m"), want(asked.depth_m, num(asked.depth_m, 1, "m")) || `limit ${num(limits.depthMax, 0, "m")}`,
      nav.depth_m > (limits.depthMax ?? Infinity) ? "bad" : "");
    this.put("altitude", num(nav.altitude_m, 1, "m"), want(asked.altitude_m, num(asked.altitude_m, 1, "m")) || `least ${num(limits.altitudeMin, 0, "m")}`,
      nav.altitude_m < (limits.altitudeMin ?? -Infinity) ? "bad" : "");
    this.put("speed", num(nav.speed_mps, 2, "m/s"), want(asked.speed_mps, num(asked.speed_mps, 2, "m/s")));
    this.put("heading", heading(nav.heading_deg), want(asked.heading_deg, heading(asked.heading_deg)));
    this.put("pitch", `${num(nav.pitch_deg, 0)}° / ${num(nav.roll_deg, 0)}°`, `turns ${num(nav.yaw_rate_dps, 1)}°/s`);
    this.put("course", heading(nav.course_deg), "over ground");
    const truth = state.truth;
    const off = truth && nav.lat !== undefined ? Math.hypot((truth.lat - nav.lat) * 111320,
      (truth.lon - nav.lon) * 111320 * Math.cos(nav.lat * Math.PI / 180)) : NaN;
    this.put("position", `${latitude(nav.lat)}  ${longitude(nav.lon)}`,
      (nav.gps ? "GPS fix" : "dead reckoning") + (off >= 0 ? `, ${num(off, 1)} m off the truth` : ""));
  }
}

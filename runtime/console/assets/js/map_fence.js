/** The fence on the map: zones, margins, names, limits. */
import * as L from "../vendor/leaflet/leaflet.js";
import { make, terms } from "./dom.js";
import { cut, num } from "./format.js";
import { inForce, offset, zones } from "./fence.js";
import { tint } from "./theme.js";

/** @typedef {import("./fence.js").Zone} Zone */

/** @param {Zone} zone */
const shutsOut = (zone) => zone.kind !== "keep-in";

/** @param {Zone} zone @returns {[string, string][]} */
function rows(zone) {
  /** @type {[string, string][]} */
  const list = [["kind", zone.kind], ["margin", num(zone.margin, 0, "m")]];
  if (zone.depthMax !== undefined) list.push(["deepest", num(zone.depthMax, 1, "m")]);
  if (zone.depthMin !== undefined) list.push(["shallowest", num(zone.depthMin, 1, "m")]);
  if (zone.altitudeMin !== undefined) list.push(["above ground at least", num(zone.altitudeMin, 1, "m")]);
  if (zone.from) list.push(["from", zone.from]);
  if (zone.until) list.push(["until", zone.until]);
  return list;
}

export class FenceLayer {
  /** @param {any} map @param {any} renderer @param {(at: any, title: string, rows: [string, string][]) => void} tell */
  constructor(map, renderer, tell) {
    this.map = map;
    this.renderer = renderer;
    this.tell = tell;
    /** @type {{zone: Zone, shape: any, margin: any}[]} */
    this.parts = [];
    this.forced = "";
    this.group = L.layerGroup().addTo(map);
  }

  /** @param {any} fence */
  build(fence) {
    this.group.clearLayers();
    this.forced = "";
    this.parts = zones(fence).map((zone) => {
      const out = shutsOut(zone);
      const shape = L.polygon(zone.ring, { renderer: this.renderer, bubblingMouseEvents: false, fill: out });
      const margin = L.polygon(zone.margin ? offset(zone.ring, out ? zone.margin : -zone.margin) : [],
        { renderer: this.renderer, interactive: false, fill: false });
      shape.on("click", (/** @type {any} */ e) => this.tell(e.latlng, zone.name || "zone", rows(zone)));
      const tip = make("div");
      tip.append(make("strong", "", cut(zone.name || "zone", 60)), terms(rows(zone)));
      shape.bindTooltip(tip, { sticky: true });
      this.group.addLayer(shape).addLayer(margin);
      this.name(zone, out);
      return { zone, shape, margin };
    });
    this.restyle();
  }

  /** @param {Zone} zone @param {boolean} out */
  name(zone, out) {
    if (!zone.name) return;
    const at = out
      ? L.latLngBounds(zone.ring).getCenter()
      : zone.ring.reduce((best, p) => (p[0] - p[1] > best[0] - best[1] ? p : best));
    const label = make("span", "", cut(zone.name, 30));
    this.group.addLayer(L.tooltip({ permanent: true, direction: out ? "center" : "right", className: "zone", interactive: false, offset: out ? [0, 0] : [0, 12] })
      .setLatLng(at).setContent(label));
  }

  /** Zones that are not in force are faint. @param {number} ms */
  at(ms) {
    const forced = this.parts.map(({ zone }) => (inForce(zone, ms) ? "1" : "0")).join("");
    if (forced === this.forced) return;
    this.forced = forced;
    this.restyle();
  }

  restyle() {
    this.parts.forEach(({ zone, shape, margin }, i) => {
      const on = this.forced[i] !== "0";
      const color = tint(shutsOut(zone) ? "keepout" : "keepin");
      shape.setStyle({ color, weight: 2.5, opacity: on ? 1 : 0.4, fillColor: color, fillOpacity: on ? 0.16 : 0.04 });
      margin.setStyle({ color, weight: 1.5, opacity: on ? 0.9 : 0.3, dashArray: "6 6" });
    });
  }

  /** @returns {any} bounds, not valid when there is no fence */
  bounds() {
    return L.latLngBounds(this.parts.flatMap(({ zone }) => zone.ring));
  }
}

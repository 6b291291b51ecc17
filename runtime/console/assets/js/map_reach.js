/** Where the live modify can lead until the vehicle notices silence and turns away: all places within a radius of a line. */
import * as L from "../vendor/leaflet/leaflet.js";
import { num } from "./format.js";
import { tint } from "./theme.js";

/** Metres in a degree of latitude. */
const DEGREE = 111195;
/** A reach that was last told longer ago than this is not drawn, seconds. */
const OLD = 3;

export class Reach {
  /**
   * @param {any} map @param {any} renderer
   * @param {(at: any, title: string, rows: [string, string][]) => void} tell
   */
  constructor(map, renderer, tell) {
    this.map = map;
    /** @type {Record<string, number>|undefined} */
    this.shown = undefined;
    this.area = L.polygon([], { renderer, weight: 2, dashArray: "3 5", fill: true, fillOpacity: 0.14, bubblingMouseEvents: false });
    this.area.on("click", (/** @type {any} */ e) => tell(e.latlng, "reach of the modify", [
      ["what", "where the vehicle may come before it notices silence and turns away; the safety monitor judges all of it"],
      ["within", `${num(this.shown?.radius_m, 0)} m of the line ahead`],
    ]));
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t */
  draw(dive, t) {
    const row = dive.reach.at(t);
    if (!row || !(row.radius_m > 0) || t - row.t > OLD) {
      this.area.remove();
      return;
    }
    if (row.t === this.shown?.t && this.map.hasLayer(this.area)) return;
    this.shown = row;
    this.area.setLatLngs(outline(row));
    this.restyle();
    if (!this.map.hasLayer(this.area)) this.area.addTo(this.map);
  }

  restyle() {
    this.area.setStyle({ color: tint("reach"), fillColor: tint("reach") });
  }
}

/** @param {Record<string, number>} row @returns {[number, number][]} */
export function outline({ lat, lon, ahead_lat, ahead_lon, radius_m }) {
  const squeeze = Math.max(0.01, Math.cos((lat * Math.PI) / 180));
  const bearing = Math.atan2((ahead_lon - lon) * squeeze, ahead_lat - lat);
  /** @type {[number, number][]} */
  const places = [];
  for (const [y, x, first] of [[ahead_lat, ahead_lon, -Math.PI / 2], [lat, lon, Math.PI / 2]]) {
    for (let side = 0; side <= 18; side += 1) {
      const angle = bearing + first + (Math.PI * side) / 18;
      places.push([y + (radius_m * Math.cos(angle)) / DEGREE, x + (radius_m * Math.sin(angle)) / (DEGREE * squeeze)]);
    }
  }
  return places;
}

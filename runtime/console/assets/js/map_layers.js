/** Plan, inserts and refused requests on the map, from GeoJSON that came from outside. */
import * as L from "../vendor/leaflet/leaflet.js";
import { arr, fin, obj, pick, str } from "./read.js";
import { tint } from "./theme.js";

const MAX_FEATURES = 1500;
const MAX_POINTS = 20000;

/** @type {Record<string, string>} colours of inserts by state */
const STATES = {
  sent: "open", pending: "open", accepted: "open", open: "open", started: "flown", flown: "flown", ended: "over", over: "over",
  cancelled: "over", rejected: "refused", refused: "refused", failed: "refused", "timed-out": "refused", unknown: "unsure",
};

/** @param {unknown} x @returns {[number, number][]} */
function positions(x) {
  /** @type {[number, number][]} */
  const out = [];
  for (const p of arr(x, MAX_POINTS)) {
    const lon = fin(arr(p, 3)[0]);
    const lat = fin(arr(p, 3)[1]);
    if (lat !== undefined && lon !== undefined && Math.abs(lat) <= 90 && Math.abs(lon) <= 540) out.push([lat, lon]);
  }
  return out;
}

/** @param {any} g geometry @returns {{shape: "point"|"line"|"area", points: [number, number][]}[]} */
function shapes(g) {
  const at = obj(g);
  switch (at.type) {
    case "Point": return [{ shape: "point", points: positions([at.coordinates]) }];
    case "MultiPoint": return positions(at.coordinates).map((p) => ({ shape: "point", points: [p] }));
    case "LineString": return [{ shape: "line", points: positions(at.coordinates) }];
    case "MultiLineString": return arr(at.coordinates, 500).map((c) => ({ shape: "line", points: positions(c) }));
    case "Polygon": return arr(at.coordinates, 50).map((c) => ({ shape: "area", points: positions(c) }));
    default: return [];
  }
}

export class FeatureLayer {
  /**
   * @param {any} map @param {any} renderer @param {string} name plan, inserts or requests
   * @param {(at: any, title: string, rows: [string, string][]) => void} tell
   */
  constructor(map, renderer, name, tell) {
    this.renderer = renderer;
    this.name = name;
    this.tell = tell;
    /** @type {any} */
    this.shown = undefined;
    this.group = L.featureGroup().addTo(map);
  }

  /** @param {any} layer as the store keeps it @returns {boolean} whether something changed */
  draw(layer) {
    if (layer === this.shown) return false;
    this.shown = layer;
    this.build();
    return true;
  }

  build() {
    this.group.clearLayers();
    for (const feature of arr(this.shown?.features, MAX_FEATURES)) {
      const p = obj(obj(feature).properties);
      for (const { shape, points } of shapes(obj(feature).geometry)) {
        if (points.length) this.group.addLayer(this.one(shape, points, p));
      }
    }
  }

  /** The colours of the states that are on the map. @returns {Set<string>} */
  get states() {
    return new Set(arr(this.shown?.features, MAX_FEATURES).map((f) => pick(STATES, obj(obj(f).properties).state) ?? "unsure"));
  }

  /** @param {string} shape @param {[number, number][]} points @param {Record<string, unknown>} p */
  one(shape, points, p) {
    const style = { renderer: this.renderer, bubblingMouseEvents: false, ...this.style(p) };
    const layer = shape === "point" ? L.circleMarker(points[0], { ...style, radius: 6, fill: true, fillOpacity: 0.9 })
      : shape === "area" ? L.polygon(points, { ...style, fill: true, fillOpacity: 0.1 })
        : L.polyline(points, style);
    layer.on("click", (/** @type {any} */ e) => this.tell(e.latlng, this.title(p), this.rows(p)));
    return layer;
  }

  /** @param {Record<string, unknown>} p */
  style(p) {
    if (this.name === "plan") return { color: tint("c-plan"), fillColor: tint("c-plan"), weight: 2, dashArray: "2 7", opacity: 0.95 };
    const color = tint(this.name === "requests" ? "refused" : pick(STATES, p.state) ?? "unsure");
    const faint = this.name === "requests" || pick(STATES, p.state) === "over";
    return { color, fillColor: color, weight: 4, opacity: faint ? 0.75 : 1, dashArray: this.name === "requests" ? "10 6" : undefined };
  }

  /** @param {Record<string, unknown>} p */
  title(p) {
    const kind = str(p.kind, 40) || "item";
    if (this.name === "plan") return `${kind} ${str(p.number, 20)} of the plan`;
    if (this.name === "requests") return `${kind}: ${p.state === "rejected" ? "refused" : str(p.state, 20)}`;
    return `insert: ${kind}`;
  }

  /** @param {Record<string, unknown>} p @returns {[string, string][]} */
  rows(p) {
    return Object.entries(p).slice(0, 20)
      .filter(([, value]) => ["string", "number", "boolean"].includes(typeof value))
      .map(([key, value]) => [key.replaceAll("_", " "), str(value, 300)]);
  }
}

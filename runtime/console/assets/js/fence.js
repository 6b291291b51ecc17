/** The fence: zones read from GeoJSON, their margins and limits. */
import { arr, fin, obj, str } from "./read.js";

/**
 * @typedef {{name: string, kind: string, margin: number, depthMax?: number, depthMin?: number, altitudeMin?: number,
 *   from: string, until: string, ring: [number, number][]}} Zone ring as [lat, lon]
 */

/** @type {WeakMap<object, Zone[]>} */
const known = new WeakMap();

/** @param {any} fence @returns {Zone[]} */
export function zones(fence) {
  if (!fence || typeof fence !== "object") return [];
  let found = known.get(fence);
  if (!found) {
    found = arr(obj(fence).features, 500).flatMap(readZones);
    known.set(fence, found);
  }
  return found;
}

/** @param {unknown} feature @returns {Zone[]} */
function readZones(feature) {
  const p = obj(obj(feature).properties);
  const g = obj(obj(feature).geometry);
  const polygons = g.type === "MultiPolygon" ? arr(g.coordinates, 100) : g.type === "Polygon" ? [g.coordinates] : [];
  return polygons.map((polygon) => ({
    name: str(p.name, 80), kind: str(p.kind, 40), margin: Math.max(0, fin(p.margin_m) ?? 0),
    depthMax: fin(p.depth_max_m), depthMin: fin(p.depth_min_m), altitudeMin: fin(p.altitude_min_m),
    from: str(p.from, 40), until: str(p.until, 40), ring: readRing(arr(polygon, 1)[0]),
  })).filter((zone) => zone.ring.length >= 3);
}

/** @param {unknown} ring @returns {[number, number][]} without the closing point */
function readRing(ring) {
  /** @type {[number, number][]} */
  const points = [];
  for (const point of arr(ring, 5000)) {
    const lon = fin(arr(point, 3)[0]);
    const lat = fin(arr(point, 3)[1]);
    if (lon !== undefined && lat !== undefined && Math.abs(lat) <= 90 && Math.abs(lon) <= 540) points.push([lat, lon]);
  }
  const n = points.length;
  if (n > 1 && points[0][0] === points[n - 1][0] && points[0][1] === points[n - 1][1]) points.pop();
  return points;
}

/** The limits of the zones the vehicle must stay in. @param {any} fence */
export function fenceLimits(fence) {
  const inside = zones(fence).filter((zone) => zone.kind === "keep-in");
  const depths = inside.map((z) => z.depthMax ?? Infinity);
  const altitudes = inside.map((z) => z.altitudeMin ?? -Infinity);
  const depthMax = Math.min(Infinity, ...depths);
  const altitudeMin = Math.max(-Infinity, ...altitudes);
  return {
    depthMax: Number.isFinite(depthMax) ? depthMax : undefined,
    altitudeMin: Number.isFinite(altitudeMin) ? altitudeMin : undefined,
  };
}

/** Whether a zone is in force. @param {Zone} zone @param {number} ms milliseconds since 1970 */
export function inForce(zone, ms) {
  const from = Date.parse(zone.from);
  const until = Date.parse(zone.until);
  return !(ms < from) && !(ms > until);
}

/**
 * The ring moved by so many metres, outwards if positive. An approximation: corners are mitred and
 * what would cross itself is not mended.
 * @param {[number, number][]} ring
 * @param {number} metres
 * @returns {[number, number][]}
 */
export function offset(ring, metres) {
  const [lat0, lon0] = ring[0];
  const kx = 111320 * Math.cos((lat0 * Math.PI) / 180);
  const ky = 110574;
  const points = ring.map(([lat, lon]) => [(lon - lon0) * kx, (lat - lat0) * ky]);
  const n = points.length;
  let area = 0;
  for (let i = 0; i < n; i++) {
    const [x1, y1] = points[i];
    const [x2, y2] = points[(i + 1) % n];
    area += x1 * y2 - x2 * y1;
  }
  const side = area > 0 ? 1 : -1;
  const normal = (/** @type {number[]} */ a, /** @type {number[]} */ b) => {
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    return [(side * (b[1] - a[1])) / length, (-side * (b[0] - a[0])) / length];
  };
  return points.map((point, i) => {
    const [ax, ay] = normal(points[(i + n - 1) % n], point);
    const [bx, by] = normal(point, points[(i + 1) % n]);
    const scale = metres / Math.max(0.25, 1 + ax * bx + ay * by);
    return [lat0 + (point[1] + (ay + by) * scale) / ky, lon0 + (point[0] + (ax + bx) * scale) / kx];
  });
}

/** Reads properties of items that came from outside. */

export const MAX_TEXT = 2000;

/** @param {unknown} x @returns {string} */
export function str(x, max = MAX_TEXT) {
  if (typeof x === "number" || typeof x === "boolean") return String(x);
  return typeof x === "string" ? x.slice(0, max) : "";
}

/** @param {unknown} x @returns {number|undefined} */
export function fin(x) {
  return typeof x === "number" && Number.isFinite(x) ? x : undefined;
}

/** @param {unknown} x @returns {Record<string, unknown>} */
export function obj(x) {
  return x && typeof x === "object" && !Array.isArray(x) ? /** @type {Record<string, unknown>} */ (x) : {};
}

/**
 * Looks up a word that came from outside; only the table's own words count.
 * @template V
 * @param {Record<string, V>} table @param {unknown} key @returns {V|undefined}
 */
export function pick(table, key) {
  return typeof key === "string" && Object.hasOwn(table, key) ? table[key] : undefined;
}

/** @param {unknown} x @returns {unknown[]} */
export function arr(x, max = 10000) {
  return Array.isArray(x) ? x.slice(0, max) : [];
}

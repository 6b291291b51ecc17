/** How numbers, times and positions are written. */

/** @param {number} s seconds @returns {string} h:mm:ss */
export function hms(s) {
  if (!Number.isFinite(s)) return "–:––:––";
  const sign = s < 0 ? "-" : "";
  const whole = Math.floor(Math.abs(s));
  const mm = String(Math.floor(whole / 60) % 60).padStart(2, "0");
  const ss = String(whole % 60).padStart(2, "0");
  return `${sign}${Math.floor(whole / 3600)}:${mm}:${ss}`;
}

/** @param {string} beganNs @returns {number} milliseconds since 1970 */
export function beganMs(beganNs) {
  try {
    return Number(BigInt(beganNs) / 1000000n);
  } catch {
    return NaN;
  }
}

/** @param {number} ms @param {number} t @returns {string} UTC as h:mm:ss */
export function utc(ms, t) {
  const date = new Date(ms + t * 1000);
  return Number.isNaN(date.getTime()) ? "" : date.toISOString().slice(11, 19);
}

/** @param {number} ms @param {number} t @returns {string} UTC date */
export function utcDay(ms, t) {
  const date = new Date(ms + t * 1000);
  return Number.isNaN(date.getTime()) ? "" : date.toISOString().slice(0, 10);
}

/** @param {number|undefined} x @param {number} digits @param {string} [unit] */
export function num(x, digits, unit = "") {
  if (x === undefined || !Number.isFinite(x)) return "–";
  const text = x.toFixed(digits);
  return (Number(text) === 0 ? (0).toFixed(digits) : text) + (unit && " " + unit);
}

/** A number with as many digits as are of use. @param {number} x */
export function short(x) {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size !== 0 && (size < 0.001 || size >= 1e6)) return x.toExponential(2);
  return x.toFixed(size >= 1000 ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 3);
}

/** @param {number|undefined} x degrees @returns {string} three digits */
export function heading(x) {
  if (x === undefined || !Number.isFinite(x)) return "–";
  return String(Math.round(((x % 360) + 360) % 360) % 360).padStart(3, "0") + "°";
}

/** @param {number} s seconds since something @returns {string} */
export function age(s) {
  if (!Number.isFinite(s)) return "–";
  const size = Math.max(0, s);
  if (size < 10) return size.toFixed(1) + " s";
  return size < 60 ? Math.floor(size) + " s" : hms(size);
}

/** @param {number} value degrees @param {string} plus @param {string} minus @param {number} digits */
function minutes(value, plus, minus, digits) {
  const size = Math.abs(value);
  let whole = Math.floor(size);
  let rest = ((size - whole) * 60).toFixed(digits);
  if (Number(rest) >= 60) {
    whole += 1;
    rest = (0).toFixed(digits);
  }
  return `${whole}°${rest.padStart(digits ? digits + 3 : 2, "0")}′${value < 0 ? minus : plus}`;
}

/** @param {number} x @param {number} [digits] */
export const latitude = (x, digits = 3) => (Number.isFinite(x) ? minutes(x, "N", "S", digits) : "–");
/** @param {number} x @param {number} [digits] */
export const longitude = (x, digits = 3) => (Number.isFinite(x) ? minutes(x, "E", "W", digits) : "–");

/** @param {string} text @param {number} max */
export function cut(text, max) {
  return text.length > max ? text.slice(0, max - 1) + "…" : text;
}

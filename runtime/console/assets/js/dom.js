/** Small helpers for the page. Text goes in as text only, never as markup. */
import { cut } from "./format.js";

/** @param {string} id @returns {HTMLElement} */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error("no element " + id);
  return found;
}

/**
 * @param {string} tag
 * @param {string} [className]
 * @param {string} [text]
 * @returns {HTMLElement}
 */
export function make(tag, className = "", text = "") {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text) node.textContent = text;
  return node;
}

/** Writes only what changed. @param {Element} node @param {string} text */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Cuts long text, the whole stays in the title. @param {HTMLElement} node @param {string} text @param {number} max */
export function writeCut(node, text, max) {
  write(node, cut(text, max));
  const title = text.length > max ? cut(text, 1000) : "";
  if (node.title !== title) node.title = title;
}

/** @param {HTMLElement} node @param {string} name @param {string} value */
export function mark(node, name, value) {
  if (node.dataset[name] !== value) node.dataset[name] = value;
}

/** @param {HTMLElement} node @param {boolean} shown */
export function show(node, shown) {
  if (node.hidden === shown) node.hidden = !shown;
}

/** A list of terms and what they are. @param {[string, string][]} rows */
export function terms(rows) {
  const list = make("dl", "terms");
  for (const [term, text] of rows) {
    const value = make("dd");
    writeCut(value, text, 200);
    list.append(make("dt", "", cut(term, 40)), value);
  }
  return list;
}

/** A colour of the page's theme. @param {string} name */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
}

/**
 * Fits a canvas to its element.
 * @param {HTMLCanvasElement} canvas
 * @returns {{ctx: CanvasRenderingContext2D, w: number, h: number}|null}
 */
export function fit(canvas) {
  const w = canvas.clientWidth;
  const h = canvas.clientHeight;
  const ctx = canvas.getContext("2d");
  if (!w || !h || !ctx) return null;
  const ratio = Math.min(3, window.devicePixelRatio || 1);
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
  }
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, w, h);
  return { ctx, w, h };
}

export const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

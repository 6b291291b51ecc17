/** Light or dark: by the system's wish, or as toggled. Kept nowhere. */
import { byId, colour } from "./dom.js";

const dark = matchMedia("(prefers-color-scheme: dark)");
/** @type {string|undefined} */
let chosen;
/** @type {Set<() => void>} */
const listeners = new Set();

/** @param {() => void} listener */
export function onTheme(listener) {
  listeners.add(listener);
}

function apply() {
  document.documentElement.dataset.theme = chosen ?? (dark.matches ? "dark" : "light");
  palette.clear();
  for (const listener of listeners) listener();
}

export function toggleTheme() {
  chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  apply();
}

/** @type {Map<string, string>} */
const palette = new Map();

/** @param {string} name @returns {string} */
export function tint(name) {
  let found = palette.get(name);
  if (!found) {
    found = colour(name);
    palette.set(name, found);
  }
  return found;
}

/** @type {Map<string, number>} plugins by the number of their colour */
const numbers = new Map();

/** The name of the colour of who steers. @param {string} key */
export function tintName(key) {
  if (!key.startsWith("plugin:")) return "c-" + (["plan", "insert", "operator"].includes(key) ? key : "nobody");
  if (!numbers.has(key)) numbers.set(key, numbers.size);
  return "c-plugin" + ((numbers.get(key) ?? 0) % 6);
}

export function startTheme() {
  apply();
  dark.addEventListener("change", apply);
  byId("theme").addEventListener("click", toggleTheme);
}

/** Keys, and the list of them. */
import { byId, make } from "./dom.js";

/** @type {[string[], string][]} */
const LIST = [
  [["Space"], "play or pause"], [["←", "→"], "10 seconds back or on; with Shift a minute"], [["Home", "End"], "begin, end"],
  [["[", "]"], "mark before, mark after"], [["L"], "live, or the end"], [["F"], "follow the vehicle"], [["G"], "fit the map"], [["+", "−"], "zoom"],
  [["H"], "hold, or release while it is held"], [["/"], "search the events"], [["1", "2", "3", "4"], "map, vehicle, plugins, events"], [["T"], "light or dark"], [["?"], "these keys"],
];

/** @param {EventTarget|null} target */
function typing(target) {
  const node = /** @type {HTMLElement|null} */ (target);
  return Boolean(node?.closest?.("input, textarea, select, dialog"));
}

/** @param {Record<string, (e: KeyboardEvent) => void>} acts by key */
export function startKeys(acts) {
  const dialog = /** @type {HTMLDialogElement} */ (byId("keys-dialog"));
  const list = make("div", "keys");
  for (const [keys, text] of LIST) {
    const cell = make("span");
    cell.append(...keys.map((key) => make("kbd", "", key)));
    list.append(cell, make("span", "", text));
  }
  byId("keys-list").append(list);
  const help = () => dialog.showModal();
  byId("help").addEventListener("click", help);
  byId("keys-close").addEventListener("click", () => dialog.close());
  const all = /** @type {Map<string, (e: KeyboardEvent) => void>} */ (new Map(Object.entries({ ...acts, "?": help })));
  document.addEventListener("keydown", (e) => {
    if (e.key === "Escape" && /** @type {HTMLElement} */ (e.target).id === "search") /** @type {HTMLElement} */ (e.target).blur();
    // Hold comes before the list of keys.
    const first = dialog.open && e.key.toLowerCase() === "h";
    if (first) dialog.close();
    if (e.ctrlKey || e.metaKey || e.altKey || (!first && typing(e.target)) || document.querySelector("dialog[open]")) return;
    if (e.key === " " && /** @type {HTMLElement} */ (e.target).closest?.("button")) return;
    const act = all.get(e.key.length === 1 ? e.key.toLowerCase() : e.key);
    if (!act) return;
    e.preventDefault();
    act(e);
  });
}

/** On small screens vehicle, plugins and events share a place. */
import { byId } from "./dom.js";

const TABS = ["vehicle", "plugins", "events"];
const PANELS = ["panel-map", "panel-vehicle", "panel-plugins", "events"];

/** @param {string} name */
export function choose(name) {
  /** @type {HTMLElement} */ (document.querySelector("main")).dataset.tab = name;
  for (const tab of TABS) {
    const button = byId("tab-" + tab);
    button.setAttribute("aria-selected", String(tab === name));
    button.tabIndex = tab === name ? 0 : -1;
  }
}

/** Goes to panel 1, 2, 3 or 4. @param {number} number */
export function goTo(number) {
  if (number > 1) choose(TABS[number - 2]);
  byId(PANELS[number - 1]).focus();
}

export function startTabs() {
  TABS.forEach((tab, i) => {
    const button = byId("tab-" + tab);
    button.addEventListener("click", () => choose(tab));
    button.addEventListener("keydown", (e) => {
      if (e.key !== "ArrowRight" && e.key !== "ArrowLeft") return;
      const next = TABS[(i + (e.key === "ArrowRight" ? 1 : TABS.length - 1)) % TABS.length];
      choose(next);
      byId("tab-" + next).focus();
      e.preventDefault();
      e.stopPropagation();
    });
  });
  choose("vehicle");
}

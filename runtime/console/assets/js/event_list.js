/** The list of events near the time shown, with filters. */
import { byId, make, mark, write, writeCut } from "./dom.js";
import { hms } from "./format.js";
import { LEVELS } from "./events.js";

const ROWS = 90;
const SIGNS = /** @type {Record<string, string>} */ ({
  refused: "▼", failed: "■", lease: "│", lost: "◆", operator: "●", integrity: "◆", request: "+", mission: "›", plugin: "◇", control: "✓", sonar: "~", end: "■",
});

export class EventList {
  /** @param {(t: number) => void} seek */
  constructor(seek) {
    this.seek = seek;
    this.box = byId("event-list");
    this.level = 1;
    this.who = "";
    this.text = "";
    /** @type {import("./events.js").Event[]} */
    this.found = [];
    this.taken = 0;
    this.edits = 0;
    this.shift = 0;
    this.sign = "";
    this.whos = 0;
    this.drawn = 0;
    this.buttons = LEVELS.map((level, i) => {
      const button = make("button", "", i === 0 ? "all" : i === 3 ? level : level + "+");
      button.addEventListener("click", () => this.filter({ level: i }));
      byId("levels").append(button);
      return button;
    });
    const search = /** @type {HTMLInputElement} */ (byId("search"));
    search.addEventListener("input", () => this.filter({ text: search.value.toLowerCase() }));
    const who = /** @type {HTMLSelectElement} */ (byId("event-who"));
    who.addEventListener("change", () => this.filter({ who: who.value }));
    this.box.addEventListener("click", (e) => this.clicked(e));
    this.box.addEventListener("keydown", (e) => this.keyed(e));
    new ResizeObserver(() => { this.sign = ""; }).observe(this.box);
    this.filter({});
  }

  /** @param {{level?: number, who?: string, text?: string}} by */
  filter(by) {
    Object.assign(this, by);
    this.buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(i === this.level)));
    this.reset();
  }

  reset() {
    this.found = [];
    this.taken = 0;
    this.shift = 0;
    this.sign = "";
  }

  /** @param {Event} e */
  clicked(e) {
    const row = /** @type {HTMLElement} */ (e.target).closest("button");
    if (!row) return;
    if (row.dataset.t) this.seek(Number(row.dataset.t));
    if (row.dataset.shift) {
      this.shift += Number(row.dataset.shift);
      this.sign = "";
    }
  }

  /** Up and down go through the rows. @param {KeyboardEvent} e */
  keyed(e) {
    if (e.key !== "ArrowDown" && e.key !== "ArrowUp") return;
    const rows = [...this.box.querySelectorAll("button")];
    const at = rows.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    const next = at < 0 ? rows.length - 1 : at + (e.key === "ArrowDown" ? 1 : -1);
    rows[next]?.focus();
    e.preventDefault();
  }

  /** @param {import("./events.js").Events} events */
  take(events) {
    if (events.edits !== this.edits) {
      this.edits = events.edits;
      this.found = [];
      this.taken = 0;
    }
    for (; this.taken < events.list.length; this.taken++) {
      const event = events.list[this.taken];
      if (LEVELS.indexOf(event.level) < this.level) continue;
      if (this.who && event.who !== this.who) continue;
      if (this.text && !event.text.toLowerCase().includes(this.text) && !event.who.toLowerCase().includes(this.text)) continue;
      this.found.push(event);
    }
  }

  /** @param {import("./main.js").Shown} shown */
  draw({ state, dive, clock, seeked }) {
    if (seeked) this.shift = 0;
    const now = performance.now();
    if (!seeked && this.sign && now - this.drawn < 250) return;
    this.drawn = now;
    this.take(dive.events);
    this.people(dive.events.whos);
    let at = this.found.length - 1;
    while (at >= 0 && this.found[at].t > state.t) at -= 1;
    const middle = Math.min(this.found.length, Math.max(0, at + this.shift));
    const from = Math.max(0, Math.min(middle - ROWS * 0.7, this.found.length - ROWS)) | 0;
    const to = Math.min(this.found.length, from + ROWS);
    const sign = `${from} ${to} ${at} ${this.found.length} ${dive.events.edits}`;
    if (sign === this.sign) return;
    this.sign = sign;
    this.paint(from, to, at, clock.following || seeked || !this.box.matches(":hover, :focus-within"));
    const dropped = dive.events.dropped ? `, ${dive.events.dropped} oldest dropped` : "";
    write(byId("event-count"), `${this.found.length} of ${dive.events.list.length}${dropped}`);
  }

  /** @param {number} from @param {number} to @param {number} at @param {boolean} scroll */
  paint(from, to, at, scroll) {
    const focused = /** @type {HTMLElement|null} */ (document.activeElement)?.dataset?.row;
    const top = this.box.scrollTop;
    const rows = [];
    if (from > 0) rows.push(this.more(`${from} earlier`, -ROWS));
    for (let i = from; i < to; i++) rows.push(this.row(this.found[i], i, at));
    if (to < this.found.length) rows.push(this.more(`${this.found.length - to} later`, ROWS));
    if (!rows.length) rows.push(make("p", "soft", "Nothing to show."));
    this.box.replaceChildren(...rows);
    this.box.scrollTop = top;
    const current = /** @type {HTMLElement|null} */ (this.box.querySelector(".current"));
    if (scroll && current) this.box.scrollTop = current.offsetTop - this.box.offsetTop - this.box.clientHeight + current.offsetHeight + 4;
    if (focused) /** @type {HTMLElement|null} */ (this.box.querySelector(`[data-row="${Number(focused)}"]`))?.focus({ preventScroll: true });
  }

  /** @param {string} text @param {number} shift */
  more(text, shift) {
    const button = make("button", "more", text);
    button.dataset.shift = String(shift);
    return button;
  }

  /** @param {import("./events.js").Event} event @param {number} i @param {number} at */
  row(event, i, at) {
    const row = make("button", "event" + (i > at ? " future" : i === at ? " current" : ""));
    row.dataset.t = String(event.t);
    row.dataset.row = String(i);
    mark(row, "level", event.level);
    const who = make("span", "who");
    writeCut(who, event.who, 30);
    const text = make("span", "text");
    writeCut(text, event.text, 240);
    row.append(make("span", "time", hms(event.t)), make("span", "sign", SIGNS[event.type] ?? ""), who, text);
    return row;
  }

  /** @param {Set<string>} whos */
  people(whos) {
    if (whos.size === this.whos) return;
    this.whos = whos.size;
    const select = /** @type {HTMLSelectElement} */ (byId("event-who"));
    const options = [...whos].sort().map((who) => {
      const option = /** @type {HTMLOptionElement} */ (make("option", "", who.slice(0, 40)));
      option.value = who;
      return option;
    });
    select.replaceChildren(select.options[0], ...options);
    select.value = this.who;
  }
}

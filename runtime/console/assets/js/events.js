/** The list of what happened, for the time line and its marks. */

/**
 * @typedef {{t: number, level: string, who: string, text: string, type: string, same?: [string, string]}} Event
 * type: line, request, refused, failed, lease, lost, control, operator, integrity, plugin, mission, sonar, end
 */

export const LEVELS = ["debug", "info", "warn", "error"];
export const MARKED = ["refused", "failed", "lease", "lost", "operator", "integrity"];
const CAP = 60000;

export class Events {
  constructor() {
    /** @type {Event[]} */
    this.list = [];
    /** @type {Event[]} those with a mark on the time line */
    this.marks = [];
    this.dropped = 0;
    /** rises when the list is cut or a kept event changes */
    this.edits = 0;
    /** @type {Set<string>} */
    this.whos = new Set();
  }

  /** @param {Event} event */
  add(event) {
    if (this.sameAsBefore(event)) return;
    const n = this.list.length;
    if (n && event.t < this.list[n - 1].t) event.t = this.list[n - 1].t;
    this.list.push(event);
    if (event.who && this.whos.size < 60) this.whos.add(event.who);
    if (MARKED.includes(event.type)) this.marks.push(event);
    if (this.list.length > CAP) {
      this.list.splice(0, CAP / 4);
      this.dropped += CAP / 4;
      this.edits += 1;
    }
    if (this.marks.length > CAP) this.marks.splice(0, CAP / 4);
  }

  /**
   * The runtime says some things twice: as an item and as a line. They are shown once.
   * @param {Event} event
   */
  sameAsBefore(event) {
    for (let i = this.list.length - 1; i >= Math.max(0, this.list.length - 12); i--) {
      const old = this.list[i];
      if (event.t - old.t > 0.3) return false;
      if ((old.type === "line") === (event.type === "line")) continue;
      if (!same(old, event)) continue;
      if (event.type !== "line") {
        old.type = event.type;
        old.who = event.who;
        if (MARKED.includes(event.type)) this.marks.push(old);
        if (event.who && this.whos.size < 60) this.whos.add(event.who);
      }
      const told = event.type === "line" ? old : event;
      if (told.same) old.text = told.text;
      else if (event.text.length > old.text.length) old.text = event.text;
      if (event.same) old.same = event.same;
      if (LEVELS.indexOf(event.level) > LEVELS.indexOf(old.level)) old.level = event.level;
      this.edits += 1;
      return true;
    }
    return false;
  }
}

/** Whether a line and an item tell the same. @param {Event} a @param {Event} b */
function same(a, b) {
  const [line, item] = a.type === "line" ? [a, b] : [b, a];
  if (item.same) {
    const text = line.text.toLowerCase();
    return text.startsWith(item.same[0].toLowerCase()) && text.includes(item.same[1]);
  }
  if (Math.min(line.text.length, item.text.length) < 6) return false;
  return line.text.startsWith(item.text) || item.text.startsWith(line.text);
}

/** Who steers: worked out from leases, inserts, the plan and the mission. */
import { fin, str } from "./read.js";

/**
 * @typedef {{key: string, label: string, why: string, owner: string}} Who
 * key: "plan", "insert", "operator", "nobody" or "plugin:NAME".
 */

const OVER = /^(complete|abort|wrapping|stop|idle|fail|end)/i;

export class Steerer {
  constructor() {
    this.owner = "";
    this.ended = "";
    /** @type {Map<number, {kind: string, owner: string}>} */
    this.inserts = new Map();
    /** @type {Map<number, string>} */
    this.behaviors = new Map();
    this.mission = "";
    this.over = false;
  }

  /** @param {any} item @returns {boolean} whether the answer may have changed */
  take(item) {
    switch (item.kind) {
      case "steering": return this.steering(item);
      case "mission":
        this.mission = str(item.status, 200);
        if (OVER.test(this.mission)) this.behaviors.clear();
        return true;
      case "behavior": return this.behavior(item);
      case "request": return this.request(item);
      case "end":
        this.over = true;
        return true;
      default: return false;
    }
  }

  /** @param {any} item */
  steering(item) {
    const owner = str(item.owner, 80);
    if (!owner && this.owner) this.ended = `${this.owner} no longer steers${item.reason ? ": " + str(item.reason, 300) : ""}`;
    const changed = owner !== this.owner;
    this.owner = owner;
    return changed;
  }

  /** @param {any} item */
  behavior(item) {
    const number = fin(item.number) ?? -1;
    if (item.began) this.behaviors.set(number, str(item.behavior, 80));
    else this.behaviors.delete(number);
    if (this.behaviors.size > 100) this.behaviors.clear();
    return true;
  }

  /** @param {any} item */
  request(item) {
    if (item.request_kind === "modify") return false;
    const number = fin(item.request) ?? -1;
    if (item.state === "started") {
      this.inserts.set(number, { kind: str(item.request_kind, 80), owner: str(item.owner, 80) });
      if (this.inserts.size > 100) this.inserts.clear();
      return true;
    }
    return ["ended", "failed", "cancelled", "timed-out", "unknown", "rejected"].includes(item.state)
      && this.inserts.delete(number);
  }

  /** The element of the plan that runs, in words. */
  get element() {
    const last = [...this.behaviors].pop();
    return last ? `${last[1]} ${last[0]}` : "";
  }

  /** @returns {Who} */
  get who() {
    if (this.over) return { key: "nobody", label: "nobody", why: "the run is over", owner: "" };
    if (this.owner === "operator") return { key: "operator", label: "operator", why: "the operator steers", owner: "" };
    if (this.owner) return { key: "plugin:" + this.owner, label: this.owner, why: "plugin with a lease", owner: this.owner };
    const insert = [...this.inserts.values()].pop();
    if (insert) {
      return { key: "insert", label: "insert", why: `${insert.kind} that ${insert.owner || "somebody"} asked for`, owner: insert.owner };
    }
    const running = this.behaviors.size > 0 || (this.mission !== "" && !OVER.test(this.mission));
    if (running) {
      const why = this.element ? `its plan: ${this.element}` : "its plan";
      return { key: "plan", label: "front seat", why: this.ended ? `${why}; ${this.ended}` : why, owner: "" };
    }
    return { key: "nobody", label: "nobody", why: this.mission ? `mission ${this.mission}` : "no mission has begun", owner: "" };
  }
}

/** The top strip: who steers and why, control, mission, time. */
import { byId, mark, write, writeCut } from "./dom.js";
import { age, beganMs, heading, hms, num, utc, utcDay } from "./format.js";
import { tint, tintName } from "./theme.js";

/** @typedef {import("./main.js").Shown} Shown */

const WHO = { plan: "front seat", insert: "insert", operator: "operator", nobody: "nobody" };

export class Strip {
  constructor() {
    this.said = "";
  }

  /** @param {Shown} shown */
  draw({ state, about, live, clock, dive }) {
    const who = state.who;
    const plugin = who?.key.startsWith("plugin:");
    const label = plugin ? who.label : WHO[/** @type {keyof typeof WHO} */ (who?.key)] ?? "–";
    writeCut(byId("who"), label, 40);
    writeCut(byId("who-why"), (who?.why ?? "") + (who?.owner && state.steering?.owner ? this.wants(state.steering) : ""), 160);
    byId("fact-who").style.borderLeftColor = tint(tintName(who?.key ?? ""));
    byId("who").style.color = tint(tintName(who?.key ?? ""));
    this.control(state);
    const mission = state.mission ?? "not begun";
    writeCut(byId("mission"), mission, 60);
    mark(byId("mission"), "long", mission.length > 13 ? "yes" : "no");
    writeCut(byId("element"), state.element || "no element of the plan runs", 80);
    mark(byId("fact-mission"), "tone", /^(abort|fail)/i.test(mission) ? "bad" : "");
    // The last figures of a run that is over are not those of now.
    const ended = clock.live && clock.following && dive.over;
    write(byId("armed"), about.armed === undefined ? "–" : about.armed ? "yes" : "no");
    write(byId("armed-why"), about.armed === undefined ? "not recorded" : about.armed ? "may steer" : "only watches");
    mark(byId("fact-armed"), "tone", ended || about.armed === undefined ? "" : about.armed ? "good" : "warn");
    const heard = state.t - state.heard;
    write(byId("heard"), Number.isFinite(heard) ? age(heard) : "never");
    write(byId("heard-why"), "ago");
    mark(byId("fact-heard"), "tone", ended ? "" : !(heard < 5) ? "bad" : heard < 2.5 ? "good" : "warn");
    if (ended) this.ended();
    this.time(state.t, about, live, clock, dive);
    this.announce(`${label} steers`, live);
  }

  /** Nobody steers any more. */
  ended() {
    for (const [id, why] of [["control", "control-why"], ["armed", "armed-why"], ["heard", "heard-why"]]) {
      write(byId(id), "–");
      write(byId(why), "the run is over");
    }
    mark(byId("fact-control"), "tone", "");
  }

  /** What the lease asks for. @param {any} asked */
  wants(asked) {
    const parts = [[asked.heading_deg, heading(asked.heading_deg)], [asked.depth_m, num(asked.depth_m, 1, "m")],
      [asked.altitude_m, num(asked.altitude_m, 1, "m above ground")], [asked.speed_mps, num(asked.speed_mps, 1, "m/s")]];
    const words = parts.filter(([x]) => x !== undefined).map(([, word]) => word);
    return words.length ? ": wants " + words.join(", ") : "";
  }

  /** @param {any} state */
  control(state) {
    const control = state.control;
    const granted = control?.granted === true;
    write(byId("control"), control ? (granted ? "yes" : "no") : "no");
    const why = granted ? "the runtime may steer" : control?.reason || state.status || "the vehicle has not given it";
    writeCut(byId("control-why"), why, 120);
    mark(byId("fact-control"), "tone", granted ? "good" : "warn");
  }

  /** @param {number} t @param {any} about @param {boolean} live @param {any} clock @param {any} dive */
  time(t, about, live, clock, dive) {
    const began = beganMs(about.began_ns);
    write(byId("since"), hms(t));
    write(byId("utc"), `${utc(began, t)} UTC`);
    write(byId("day"), utcDay(began, t));
    const badge = byId("badge");
    const word = dive.over && clock.live ? "over" : about.kind;
    write(badge, String(word).toUpperCase().slice(0, 12));
    mark(badge, "kind", word);
    void live;
  }

  /** Tells a screen reader when somebody else steers. @param {string} text @param {boolean} live */
  announce(text, live) {
    if (!live || text === this.said) return;
    this.said = text;
    write(byId("announce"), text);
  }
}

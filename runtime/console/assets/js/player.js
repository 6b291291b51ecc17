/** Play, speed, live, and the pace of a simulation. */
import { byId, make, mark, show } from "./dom.js";

const SPEEDS = [1, 2, 5, 10, 30, 60, 200];
/** A pace of 10000 or more means as fast as can be. */
export const MAX_PACE = 10000;
/** @type {[string, number][]} */
const PACES = [["pause", 0], ["1×", 1], ["10×", 10], ["100×", 100], ["max", MAX_PACE]];

export class Player {
  /** @param {import("./clock.js").Clock} clock @param {() => void} changed */
  constructor(clock, changed) {
    this.clock = clock;
    const speed = /** @type {HTMLSelectElement} */ (byId("speed"));
    for (const times of SPEEDS) {
      const option = /** @type {HTMLOptionElement} */ (make("option", "", times + "×"));
      option.value = String(times);
      speed.append(option);
    }
    speed.addEventListener("change", () => { clock.speed = Number(speed.value) || 1; });
    byId("play").addEventListener("click", () => {
      clock.toggle();
      changed();
    });
    for (const id of ["live", "golive"]) {
      byId(id).addEventListener("click", () => {
        clock.goLive();
        changed();
      });
    }
    this.paced = false;
    this.paces = PACES.map(([word, times]) => {
      const button = make("button", "", word);
      button.addEventListener("click", () => this.pace(times));
      byId("pace").append(button);
      return { button, times };
    });
  }

  /** @param {any} about */
  begin(about) {
    this.paced = Boolean(about.pace);
    show(byId("live"), this.clock.live);
    const speed = /** @type {HTMLSelectElement} */ (byId("speed"));
    speed.value = this.clock.live ? "1" : "10";
    this.clock.speed = Number(speed.value);
    this.set(about.pace?.times ?? 1);
  }

  /** @param {number} times */
  set(times) {
    this.clock.times = times;
    for (const pace of this.paces) pace.button.setAttribute("aria-pressed", String(pace.times === Math.min(times, MAX_PACE)));
  }

  /** @param {number} times */
  async pace(times) {
    try {
      const answer = await fetch("api/pace", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ times }) });
      if (answer.ok) this.set(times);
    } catch {
      // The banner tells when the program does not answer.
    }
  }

  draw() {
    const { clock } = this;
    show(byId("pace"), this.paced && !clock.dive().over);
    const moving = clock.playing || (clock.following && clock.live && !clock.dive().over);
    const play = byId("play");
    if (play.dataset.moving === String(moving)) return;
    mark(play, "moving", String(moving));
    play.setAttribute("aria-label", moving ? "Pause" : "Play");
    const sign = play.firstElementChild;
    if (sign) sign.textContent = moving ? "❚❚" : "▶";
  }
}

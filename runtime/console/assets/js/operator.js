/** Hold and release. The name and the token stay in this module's memory only. */
import { byId, mark, show, write } from "./dom.js";

const WAIT_MS = 6000;
/** @type {{who: string, token: string}|undefined} */
let known;

/** @type {Record<string, {title: string, what: string, done: string}>} */
const ACTS = {
  hold: {
    title: "Hold?", what: "The runtime stops steering at once and stays silent. The vehicle flies its own plan until somebody releases.",
    done: "Done. The runtime holds.",
  },
  release: {
    title: "Release?", what: "Plugins may steer again as soon as the vehicle gives control.",
    done: "Done. The runtime may steer again.",
  },
};

/** @param {string} id */
const input = (id) => /** @type {HTMLInputElement} */ (byId(id));

export class Operator {
  /** @param {() => boolean} held whether it is held now */
  constructor(held) {
    this.held = held;
    this.act = "hold";
    this.busy = false;
    this.able = false;
    this.dialog = /** @type {HTMLDialogElement} */ (byId("operator-dialog"));
    byId("hold").addEventListener("click", () => this.ask(this.held() ? "release" : "hold"));
    byId("release").addEventListener("click", () => this.ask("release"));
    byId("operator-cancel").addEventListener("click", () => this.dialog.close());
    byId("operator-other").addEventListener("click", () => {
      known = undefined;
      this.fill();
    });
    byId("operator-form").addEventListener("submit", (e) => {
      e.preventDefault();
      this.send();
    });
  }

  /** @param {boolean} able */
  begin(able) {
    this.able = able;
    show(byId("hold"), able);
    show(byId("release"), able);
  }

  /** @param {boolean} held */
  draw(held) {
    const button = byId("hold");
    if (button.dataset.held === String(held)) return;
    mark(button, "held", String(held));
    button.firstChild?.replaceWith(held ? "Release " : "Hold ");
  }

  /** @param {string} act */
  ask(act) {
    if (!this.able || this.busy || this.dialog.open) return;
    this.act = act;
    this.say("", "");
    this.fill();
    this.dialog.showModal();
    (known ? byId("operator-go") : byId("operator-name")).focus();
  }

  fill() {
    const words = ACTS[this.act];
    write(byId("operator-title"), words.title);
    write(byId("operator-what"), words.what);
    write(byId("operator-go"), this.act === "hold" ? "Hold" : "Release");
    show(byId("operator-creds"), !known);
    show(byId("operator-as"), Boolean(known));
    write(byId("operator-as-name"), known ? `As ${known.who}.` : "");
    input("operator-token").value = "";
  }

  /** @param {string} text @param {string} tone */
  say(text, tone) {
    write(byId("operator-answer"), text);
    mark(byId("operator-answer"), "tone", tone);
  }

  async send() {
    if (this.busy) return;
    const creds = known ?? { who: input("operator-name").value.trim(), token: input("operator-token").value.trim() };
    if (!creds.who || !creds.token) return this.say("Name and token are needed.", "bad");
    if (/[^\x21-\x7e]/.test(creds.token)) return this.say("The token has signs that no token has.", "bad");
    this.busy = true;
    /** @type {HTMLButtonElement} */ (byId("operator-go")).disabled = true;
    this.say("Asking…", "");
    try {
      await this.post(creds);
    } catch {
      this.say("No answer from the program. It may be that nothing was done.", "bad");
    }
    this.busy = false;
    /** @type {HTMLButtonElement} */ (byId("operator-go")).disabled = false;
  }

  /** @param {{who: string, token: string}} creds */
  async post(creds) {
    const answer = await fetch("api/operator", {
      method: "POST", headers: { Authorization: "Bearer " + creds.token, "Content-Type": "application/json" },
      body: JSON.stringify({ act: this.act, who: creds.who }), signal: AbortSignal.timeout(15000),
    });
    if (answer.status === 202 || answer.status === 409) {
      known = creds;
      if (answer.status === 409) {
        this.fill();
        return this.say("Not possible now: " + await reason(answer), "bad");
      }
      this.fill();
      return this.confirm();
    }
    if (answer.status === 401) {
      known = undefined;
      this.fill();
      this.say("Wrong token. Nothing was done.", "bad");
      byId("operator-token").focus();
    } else this.say(`Nothing was done: ${await reason(answer)}`, "bad");
  }

  /** Done only when the runtime itself says so in the feed. */
  async confirm() {
    const want = this.act === "hold";
    this.say("The program took it. Waiting for the runtime's word…", "");
    const until = performance.now() + WAIT_MS;
    while (performance.now() < until) {
      if (this.held() === want) {
        this.say(ACTS[this.act].done, "good");
        setTimeout(() => {
          if (!this.busy) this.dialog.close();
        }, 900);
        return;
      }
      await new Promise((go) => setTimeout(go, 100));
    }
    this.say("The program took it, but the runtime has not said so. Watch the strip.", "bad");
  }
}

/** @param {Response} answer */
async function reason(answer) {
  try {
    return String((await answer.json()).error || answer.status).slice(0, 200);
  } catch {
    return `answer ${answer.status}`;
  }
}

/** The live feed, which connects again by itself. */

const SILENCE_MS = 3000;
const PAUSES_MS = [300, 700, 1500, 3000];

export class Feed {
  /**
   * @param {{after: () => number, items: (items: unknown[]) => void, reset: () => void, check: () => Promise<boolean>}} on
   * check: asks whether the program still runs the same run; false when it does not answer.
   */
  constructor(on) {
    this.on = on;
    this.open = false;
    this.frameAt = -Infinity;
    this.itemAt = -Infinity;
    this.tries = 0;
    this.stopped = false;
    this.lives = 0;
    /** @type {WebSocket|undefined} */
    this.socket = undefined;
    setInterval(() => this.watch(), 500);
  }

  start() {
    this.stopped = false;
    this.lives += 1;
    this.connect(this.lives);
  }

  /** Stops for good, or until start() is called again. */
  stop() {
    this.stopped = true;
    this.lives += 1;
    this.drop();
  }

  drop() {
    const old = this.socket;
    this.socket = undefined;
    this.open = false;
    old?.close();
  }

  /** @param {number} life */
  connect(life) {
    if (this.stopped || life !== this.lives) return;
    const url = new URL("api/feed", location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    url.searchParams.set("after", String(this.on.after()));
    const socket = new WebSocket(url);
    this.socket = socket;
    this.begunAt = performance.now();
    socket.onopen = () => { this.open = socket === this.socket; };
    socket.onmessage = (message) => {
      if (socket === this.socket) this.frame(message.data);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.again();
    };
  }

  /** @param {unknown} data */
  frame(data) {
    this.frameAt = performance.now();
    this.tries = 0;
    let items;
    try {
      items = JSON.parse(String(data));
    } catch {
      items = [undefined];
    }
    if (!Array.isArray(items)) items = [items];
    if (items.some((item) => item?.kind === "reset")) {
      this.stop();
      this.on.reset();
      return;
    }
    if (items.length) this.itemAt = this.frameAt;
    this.on.items(items);
  }

  /** Tries again after a while, if the program answers. */
  again() {
    if (this.stopped) return;
    this.drop();
    const life = ++this.lives;
    const pause = PAUSES_MS[Math.min(this.tries++, PAUSES_MS.length - 1)];
    setTimeout(async () => {
      if (life !== this.lives) return;
      if (await this.on.check()) this.connect(life);
      else if (life === this.lives) this.again();
    }, pause);
  }

  /** A socket that is open but silent for long is given up. */
  watch() {
    if (this.stopped || !this.socket) return;
    const since = performance.now() - Math.max(this.frameAt, this.begunAt ?? 0);
    if (since > 3 * SILENCE_MS) this.again();
  }

  /** Milliseconds since anything came. */
  get silence() {
    return performance.now() - this.frameAt;
  }

  /** @param {boolean} paused @returns {"fresh"|"paused"|"quiet"|"lost"|"connecting"} */
  state(paused) {
    const now = performance.now();
    if (this.frameAt === -Infinity && this.tries < 2) return "connecting";
    if (!this.open || now - this.frameAt > SILENCE_MS) {
      return now - this.frameAt > SILENCE_MS || this.tries > 1 ? "lost" : "fresh";
    }
    if (paused) return "paused";
    return now - this.itemAt > SILENCE_MS ? "quiet" : "fresh";
  }
}

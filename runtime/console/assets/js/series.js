/** Values over time, in order of time, found by binary search. */

/**
 * Index of the last of the first `n` elements of `a` that is at most `x`, or -1.
 * @param {ArrayLike<number>} a
 * @param {number} n
 * @param {number} x
 */
export function lastAt(a, n, x) {
  let low = 0;
  let high = n;
  while (low < high) {
    const mid = (low + high) >> 1;
    if (a[mid] <= x) low = mid + 1;
    else high = mid;
  }
  return low - 1;
}

/** @template V */
export class Series {
  constructor(cap = 200000) {
    /** @type {number[]} */
    this.t = [];
    /** @type {V[]} */
    this.v = [];
    this.cap = cap;
  }

  /** @param {number} t @param {V} value */
  push(t, value) {
    const n = this.t.length;
    if (n && t < this.t[n - 1]) t = this.t[n - 1];
    if (n >= this.cap) {
      this.t.splice(0, n >> 2);
      this.v.splice(0, n >> 2);
    }
    this.t.push(t);
    this.v.push(value);
  }

  /** @param {number} t */
  index(t) {
    return lastAt(this.t, this.t.length, t);
  }

  /** @param {number} t @returns {V|undefined} */
  at(t) {
    return this.v[this.index(t)];
  }

  /** @returns {V|undefined} */
  get last() {
    return this.v[this.v.length - 1];
  }
}

/** Columns of numbers over time; what is absent is NaN. */
export class Columns {
  /** @param {string[]} names @param {number} [step] values nearer in time than this are thinned */
  constructor(names, step = 0) {
    this.names = names;
    this.step = step;
    this.length = 0;
    this.room = 1024;
    this.t = new Float64Array(this.room);
    /** @type {Record<string, Float64Array>} */
    this.c = {};
    for (const name of names) this.c[name] = new Float64Array(this.room);
  }

  /**
   * Adds a row. The newest row is always kept; the one before it gives way if it is too near to
   * the one before that.
   * @param {number} t
   * @param {Record<string, unknown>} row
   */
  push(t, row) {
    const n = this.length;
    if (n && t < this.t[n - 1]) t = this.t[n - 1];
    const thin = n >= 2 && this.t[n - 1] - this.t[n - 2] < this.step;
    const at = thin ? n - 1 : n;
    if (at >= this.room) this.grow();
    this.t[at] = t;
    for (const name of this.names) {
      const value = row[name];
      this.c[name][at] = typeof value === "number" ? value : NaN;
    }
    this.length = at + 1;
  }

  grow() {
    this.room *= 2;
    const wider = (/** @type {Float64Array} */ old) => {
      const made = new Float64Array(this.room);
      made.set(old);
      return made;
    };
    this.t = wider(this.t);
    for (const name of this.names) this.c[name] = wider(this.c[name]);
  }

  /** @param {number} t */
  index(t) {
    return lastAt(this.t, this.length, t);
  }

  /** @param {number} i @returns {Record<string, number>|undefined} */
  row(i) {
    if (i < 0 || i >= this.length) return undefined;
    /** @type {Record<string, number>} */
    const row = { t: this.t[i] };
    for (const name of this.names) row[name] = this.c[name][i];
    return row;
  }

  /** @param {number} t */
  at(t) {
    return this.row(this.index(t));
  }
}

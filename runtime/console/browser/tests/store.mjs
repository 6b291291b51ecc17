/** Checks the store without a browser: node tests/store.mjs */
import { Dive } from "../../assets/js/dive.js";
import { Columns, lastAt } from "../../assets/js/series.js";
import { fenceLimits, inForce, offset, zones } from "../../assets/js/fence.js";
import { age, heading, hms, latitude, longitude, num, short } from "../../assets/js/format.js";
import { takeLine } from "../../assets/js/history.js";
import { Clock } from "../../assets/js/clock.js";
import { check, finish, test } from "./lib.mjs";

const same = (a, b) => check(JSON.stringify(a) === JSON.stringify(b), `${JSON.stringify(a)} is not ${JSON.stringify(b)}`);
const about = { kind: "recorded", plugins: [{ name: "a" }] };
/** A dive of the items, numbered. */
const dive = (...items) => {
  const made = new Dive(about);
  items.forEach((item, i) => made.take({ n: i + 1, ...item }));
  return made;
};

await test("binary search", async () => {
  const a = [1, 2, 2, 5];
  same([0, 1, 2, 4, 5, 9].map((x) => lastAt(a, 4, x)), [-1, 0, 2, 2, 3, 3]);
});
await test("columns thin all but the newest", async () => {
  const c = new Columns(["x"], 0.95);
  for (let i = 0; i <= 5000; i++) c.push(i / 10, { x: i });
  check(c.length >= 500 && c.length <= 505, "rows " + c.length);
  check(c.t[c.length - 1] === 500 && c.c.x[c.length - 1] === 5000, "the newest is kept");
  for (let i = 1; i < c.length; i++) check(c.t[i] > c.t[i - 1], "order");
});
await test("who steers", async () => {
  const d = dive(
    { t: 1, kind: "mission", status: "Running /logs/stopover" }, { t: 1, kind: "behavior", number: 2, behavior: "trackline", began: true },
    { t: 5, kind: "steering", owner: "a" }, { t: 6, kind: "steering", owner: "a", heading_deg: 3 }, { t: 9, kind: "steering", reason: "why not" },
    { t: 10, kind: "request", request: 4, owner: "a", request_kind: "trackline", state: "started" }, { t: 20, kind: "request", request: 4, owner: "a", request_kind: "trackline", state: "ended" },
    { t: 30, kind: "steering", owner: "operator" }, { t: 31, kind: "steering" }, { t: 40, kind: "mission", status: "Aborted" }, { t: 50, kind: "end" });
  const who = (t) => d.stateAt(t).who.key;
  same([0, 2, 5, 7, 9.5, 10, 25, 30, 35, 45].map(who), ["nobody", "plan", "plugin:a", "plugin:a", "plan", "insert", "plan", "operator", "plan", "nobody"]);
  same(d.stateAt(9.5).who.why, "its plan: trackline 2; a no longer steers: why not");
  same(d.stateAt(7).steering.heading_deg, 3);
});
await test("what the runtime says twice is shown once", async () => {
  const d = dive(
    { t: 1, kind: "control", granted: false, reason: "the vehicle has control" },
    { t: 1, kind: "line", level: "warn", who: "runtime", text: "no control: the vehicle has control; it gives it later" },
    { t: 2, kind: "line", level: "warn", who: "plugin a", text: "Modify 7 (a, tag 1) rejected: too deep" },
    { t: 2, kind: "request", request: 7, owner: "a", request_kind: "modify", state: "rejected", reason: "too deep" },
    { t: 3, kind: "line", level: "info", who: "x", text: "control" }, { t: 3, kind: "sonar", name: "s", text: "" });
  same(d.events.list.map((e) => e.text), ["no control: the vehicle has control; it gives it later", "modify 7 refused: too deep", "control", ""]);
  same(d.events.marks.map((e) => e.type), ["lost", "refused"]);
});
await test("a later beat tells of what was before", async () => {
  const d = dive({ t: 1, kind: "beat", refreshed: 0.5, heard: 0.9 }, { t: 2, kind: "beat", refreshed: 1.3, heard: 1.9 });
  same([d.beatAt(1.4).refreshed, d.beatAt(1.4).heard, d.beatAt(1.2).refreshed], [1.3, 0.9, 0.5]);
});
await test("odd lines are counted, old numbers and unknown kinds left out", async () => {
  const d = new Dive(about);
  for (const line of ["oops", "[]", "7", "null", '{"n":1,"t":1,"kind":"line","text":"x"}', '{"n":1,"t":1,"kind":"line","text":"again"}', '{"n":2,"t":2,"kind":"new"}', ""]) takeLine(d, line);
  same([d.malformed, d.count, d.unknown, d.events.list.length], [4, 2, 1, 1]);
});
await test("lists stay bounded", async () => {
  const d = new Dive(about);
  for (let i = 1; i <= 70000; i++) d.take({ n: i, t: i, kind: "line", who: "w" + i, text: "x" + i, level: "info" });
  check(d.events.list.length <= 60000 && d.events.dropped > 0 && d.events.whos.size <= 60, "bounds");
  for (let i = 1; i <= 200; i++) d.take({ n: 70000 + i, t: 70000, kind: "measure", plugin: "p", name: "m" + i, value: 1 });
  check(d.measures.size === 64, "measures " + d.measures.size);
});
await test("state at any time is as if only the items until then were there", async () => {
  const items = [];
  let seed = 7;
  const random = (n) => (seed = (seed * 16807) % 2147483647) % n;
  for (let i = 0; i < 3000; i++) {
    const t = i / 2;
    items.push([
      { t, kind: "status", text: "s" + random(5) }, { t, kind: "control", granted: random(2) === 1 }, { t, kind: "mission", status: "Running " + random(3) },
      { t, kind: "steering", owner: ["a", "b", undefined][random(3)] }, { t, kind: "counts", sent: random(100) }, { t, kind: "integrity", ok: random(2) === 1, text: "i" },
    ][random(6)]);
  }
  const whole = dive(...items);
  for (let k = 0; k < 40; k++) {
    const t = random(3000) / 2 + 0.25;
    const part = dive(...items.filter((item) => item.t <= t));
    same(whole.stateAt(t), part.stateAt(t));
  }
});
await test("fence: limits, times, margins", async () => {
  const square = [[0, 0], [0.01, 0], [0.01, 0.01], [0, 0.01], [0, 0]];
  const fence = { features: [{ properties: { name: "in", kind: "keep-in", margin_m: 20, depth_max_m: 40, altitude_min_m: 3 }, geometry: { type: "Polygon", coordinates: [square] } },
    { properties: { kind: "keep-out", from: "2026-06-01T08:00:00Z", until: "2026-06-01T09:00:00Z" }, geometry: { type: "Polygon", coordinates: [[...square].reverse()] } }, null, { geometry: 5 }] };
  same(fenceLimits(fence), { depthMax: 40, altitudeMin: 3 });
  const [a, b] = zones(fence);
  same([zones(fence).length, a.ring.length], [2, 4]);
  same([inForce(b, Date.parse("2026-06-01T08:30:00Z")), inForce(b, Date.parse("2026-06-01T09:30:00Z")), inForce(a, 0)], [true, false, true]);
  for (const ring of [a.ring, b.ring]) {
    const lats = offset(ring, 111).map((p) => p[0]);
    check(Math.abs(Math.max(...lats) - 0.011) < 2e-5 && Math.abs(Math.min(...lats) + 0.001) < 2e-5, "outwards " + lats);
    check(Math.max(...offset(ring, -111).map((p) => p[0])) < 0.00901, "inwards");
  }
});
await test("words and numbers", async () => {
  same([hms(3725.9), hms(-5), hms(NaN), age(3.14), age(75), num(-0.04, 1), heading(359.7), heading(undefined), short(0.00001)],
    ["1:02:05", "-0:00:05", "–:––:––", "3.1 s", "0:01:15", "0.0", "000°", "–", "1.00e-5"]);
  same([latitude(42.35), longitude(-70.7152892), longitude(-0.99999999)], ["42°21.000′N", "70°42.917′W", "1°00.000′W"]);
});
await test("clock: follows, looks back, never goes on in a simulation by itself", async () => {
  const d = dive({ t: 50, kind: "status", text: "x" });
  const clock = new Clock(() => d);
  clock.begin({ kind: "simulated", pace: { times: 20 } });
  clock.hear(50);
  await new Promise((go) => setTimeout(go, 30));
  same([clock.now(), clock.shown, clock.following], [50, 50, true]);
  clock.step(-10);
  same([clock.shown, clock.following], [40, false]);
  clock.goLive();
  same(clock.following, true);
  clock.begin({ kind: "live", now: 70 });
  clock.hear(60);
  await new Promise((go) => setTimeout(go, 30));
  check(clock.now() > 70.02 && clock.now() < 70.5, "a real run goes on from what about says");
});
finish();

/** What the store does with each kind of item. Kinds that are not here are ignored. */
import { Columns, Series } from "./series.js";
import { LEVELS } from "./events.js";
import { arr, fin, obj, pick, str } from "./read.js";
import { bytes } from "./waterfall.js";

/** Contacts that are shown at most. */
const MAX_CONTACTS = 500;

/** @typedef {import("./dive.js").Dive} Dive */

/**
 * @param {Dive} dive @param {any} item @param {string} type @param {string} level @param {string} who @param {string} text
 * @param {[string, string]} [same] how the runtime's own line about it begins, and what else is in it
 */
function event(dive, item, type, level, who, text, same) {
  dive.events.add({ t: item.t, type, level, who, text, same });
}

/** @param {string} owner */
const asWho = (owner) => (owner === "operator" ? "operator" : owner ? "plugin " + owner : "runtime");

/** @param {Dive} dive @param {any} item */
function navigation(dive, item) {
  if (fin(item.lat) === undefined || fin(item.lon) === undefined) {
    dive.malformed += 1;
    return;
  }
  dive.navigation.push(item.t, { ...item, gps: item.gps ? 1 : 0, who: dive.key });
}

/** @param {Dive} dive @param {any} item */
function control(dive, item) {
  const reason = str(item.reason, 300);
  dive.held.control.push(item.t, { granted: item.granted === true, reason });
  if (item.granted) event(dive, item, "control", "info", "runtime", "control granted");
  else event(dive, item, "lost", "warn", "runtime", "no control" + (reason ? ": " + reason : ""));
}

/** @param {Dive} dive @param {any} item */
function steering(dive, item) {
  const before = dive.held.steering.last;
  const owner = str(item.owner, 80);
  const reason = str(item.reason, 300);
  dive.held.steering.push(item.t, {
    owner, reason, heading_deg: fin(item.heading_deg), depth_m: fin(item.depth_m),
    altitude_m: fin(item.altitude_m), speed_mps: fin(item.speed_mps),
  });
  if (owner && owner !== before?.owner) event(dive, item, "lease", "info", asWho(owner), `${owner} steers`);
  if (!owner && before?.owner) {
    event(dive, item, "lease", "info", asWho(before.owner), `${before.owner} no longer steers${reason ? ": " + reason : ""}`);
  }
}

/** @type {Record<string, string>} */
const WORDS = {
  rejected: "refused", sent: "sent", pending: "waits at the vehicle", accepted: "accepted", started: "is flown now",
  ended: "over", failed: "failed", "timed-out": "had no answer", cancelled: "cancelled", unknown: "may or may not be there",
};
/** @type {Record<string, [string, string]>} */
const TYPES = {
  rejected: ["refused", "warn"], failed: ["failed", "error"], "timed-out": ["failed", "error"], unknown: ["failed", "warn"],
};

/** @param {Dive} dive @param {any} item */
function request(dive, item) {
  const owner = str(item.owner, 80);
  const state = str(item.state, 40);
  const kind = str(item.request_kind, 40);
  const reason = str(item.reason, 500);
  const story = owner === "operator" ? undefined : dive.plugin(owner);
  if (story) {
    const sums = story.sums;
    if (state === "sent") sums.asked += 1;
    else if (state === "rejected") sums.refused += 1;
    else if (state === "failed" || state === "timed-out") sums.failed += 1;
    else if (state === "ended" && kind !== "modify") sums.flown += 1;
    story.tally.push(item.t, { ...sums });
    if (pick(TYPES, state)) story.refusal.push(item.t, { t: item.t, state, word: pick(WORDS, state), kind, reason });
  }
  const [type, level] = pick(TYPES, state) ?? ["request", "info"];
  const word = pick(WORDS, state) ?? state;
  event(dive, item, type, level, asWho(owner),
    `${kind} ${str(item.request, 20)} ${word}${reason ? ": " + reason : ""}`,
    [`${kind} ${str(item.request, 20)} (`, ") " + state]);
}

/** @param {Dive} dive @param {any} item */
function plugin(dive, item) {
  const name = str(item.plugin, 80);
  const state = str(item.state, 40);
  const text = str(item.text, 500);
  dive.plugin(name)?.state.push(item.t, { t: item.t, state, text, failures: fin(item.failures) });
  const bad = state === "failed" || state === "quarantined";
  event(dive, item, bad ? "failed" : "plugin", bad ? "error" : "info", asWho(name),
    `plugin ${name} ${state}${text ? ": " + text : ""}`);
}

/** @param {Dive} dive @param {any} item */
function line(dive, item) {
  const who = str(item.who, 80);
  const level = LEVELS.includes(item.level) ? item.level : "info";
  const text = str(item.text);
  if (who.startsWith("plugin ")) dive.plugin(who.slice(7))?.words.push(item.t, { t: item.t, level, text });
  event(dive, item, "line", level, who, text);
}

/** @param {Dive} dive @param {any} item */
function measure(dive, item) {
  if (fin(item.value) === undefined) return;
  const plugin = str(item.plugin, 80);
  const name = str(item.name, 80);
  const found = dive.named(dive.measures, plugin + "\n" + name, () => (
    { plugin, name, unit: str(item.unit, 20), values: new Columns(["value"], 0.45) }));
  found?.values.push(item.t, item);
}

/** @param {Dive} dive @param {any} item */
function sensor(dive, item) {
  const data = Object.entries(obj(item.data)).slice(0, 24)
    .map(([key, value]) => [key.slice(0, 60), typeof value === "number" ? value : str(value, 60)]);
  const found = dive.named(dive.sensors, str(item.name, 80), () => new Series(60000));
  found?.push(item.t, { t: item.t, data });
}

/** @param {Dive} dive @param {any} item */
function sonar(dive, item) {
  const name = str(item.name, 80) || "controller";
  const ok = item.ok !== false;
  const text = str(item.text, 300);
  dive.named(dive.sonars, name, () => new Series())?.push(item.t, { t: item.t, ok, text });
  event(dive, item, "sonar", ok ? "info" : "warn", "sonar " + name, text);
}

/** @param {Dive} dive @param {any} item */
function ping(dive, item) {
  const port = bytes(item.port);
  const starboard = bytes(item.starboard);
  if (port || starboard) dive.pings.push(item.t, { t: item.t, port, starboard, range: fin(item.range_m) ?? 0 });
}

/** @param {Dive} dive @param {any} item */
function contact(dive, item) {
  const lat = fin(item.lat);
  const lon = fin(item.lon);
  const name = str(item.name, 40);
  if (lat === undefined || lon === undefined || Math.abs(lat) > 90 || Math.abs(lon) > 540) return;
  const plugin = str(item.plugin, 80);
  const text = str(item.text, 300);
  const word = ["confirmed", "rejected"].find((each) => text.includes(each)) ?? "";
  const key = plugin + "\n" + name;
  // A plugin can tell of many.
  if (!dive.contacts.has(key) && dive.contacts.size < MAX_CONTACTS) dive.contacts.set(key, new Series(1000));
  dive.contacts.get(key)?.push(item.t, { t: item.t, plugin, name, lat, lon, text, word });
}

/** @param {Dive} dive @param {any} item */
function map(dive, item) {
  const layer = dive.held["map:" + str(item.layer, 20)];
  const features = arr(obj(item.geojson).features, 3000);
  if (layer) layer.push(item.t, { features });
}

/** @param {Dive} dive @param {any} item */
function operator(dive, item) {
  const act = str(item.act, 20);
  const who = str(item.who, 80);
  const by = str(item.by, 40);
  const before = dive.held.operator.last;
  const held = act === "hold" ? true : act === "release" ? false : before?.held ?? false;
  dive.held.operator.push(item.t, { t: item.t, act, who, by, held });
  /** @type {Record<string, string>} */
  const words = { hold: "holds", release: "releases", stop: "stops the run" };
  // A simulation ends itself with the same word as SIGTERM.
  if (act === "stop" && !who) return event(dive, item, "operator", "info", "runtime", "stops");
  event(dive, item, "operator", "warn", "operator",
    `${who || "operator"} ${pick(words, act) ?? act}${by ? ` (${by})` : ""}`);
}

/** @type {Map<string, (dive: Dive, item: any) => void>} */
export const takers = new Map(Object.entries({
  navigation, control, steering, request, plugin, line, measure, sensor, sonar, ping, contact, map, operator,
  /** @type {(dive: Dive, item: any) => void} */
  beat: (dive, item) => dive.beat.push(item.t, item),
  /** @type {(dive: Dive, item: any) => void} */
  reach: (dive, item) => dive.reach.push(item.t, item),
  /** @type {(dive: Dive, item: any) => void} */
  swath: (dive, item) => dive.swaths.push(item.t, item),
  /** @type {(dive: Dive, item: any) => void} */
  truth: (dive, item) => dive.truth.push(item.t, item),
  /** @type {(dive: Dive, item: any) => void} */
  status: (dive, item) => dive.held.status.push(item.t, str(item.text, 300)),
  /** @type {(dive: Dive, item: any) => void} */
  pace: (dive, item) => dive.held.pace.push(item.t, fin(item.times) ?? 1),
  /** @type {(dive: Dive, item: any) => void} */
  counts(dive, item) {
    const { proposed, rejected, sent, accepted, failed } = item;
    dive.held.counts.push(item.t, { proposed: fin(proposed), rejected: fin(rejected), sent: fin(sent), accepted: fin(accepted), failed: fin(failed) });
  },
  /** @type {(dive: Dive, item: any) => void} */
  headroom: (dive, item) => dive.plugin(str(item.plugin, 80))?.headroom.push(item.t, { fuel: fin(item.fuel), steps: fin(item.steps) }),
  /** @type {(dive: Dive, item: any) => void} */
  mission(dive, item) {
    const status = str(item.status, 200);
    dive.held.mission.push(item.t, status);
    event(dive, item, "mission", /^(abort|fail)/i.test(status) ? "error" : "info", "vehicle", "mission " + status);
  },
  /** @type {(dive: Dive, item: any) => void} */
  behavior(dive, item) {
    event(dive, item, "mission", "info", "vehicle",
      `${str(item.behavior, 80)} ${str(item.number, 20)} of the plan ${item.began ? "began" : "ended"}`);
  },
  /** @type {(dive: Dive, item: any) => void} */
  integrity(dive, item) {
    const ok = item.ok === true;
    const text = str(item.text, 300);
    dive.held.integrity.push(item.t, { t: item.t, ok, text });
    event(dive, item, "integrity", ok ? "info" : "error", "runtime", text);
  },
  /** @type {(dive: Dive, item: any) => void} */
  recording(dive, item) {
    const written = item.written === true;
    const text = str(item.text, 300);
    dive.held.recording.push(item.t, { t: item.t, written, text });
    event(dive, item, "line", written ? "warn" : "error", "runtime", text);
  },
  /** @type {(dive: Dive, item: any) => void} */
  end(dive, item) {
    dive.over = true;
    dive.held.end.push(item.t, str(item.text, 300));
    event(dive, item, "end", "info", "runtime", str(item.text, 300) || "the run is over");
  },
}));

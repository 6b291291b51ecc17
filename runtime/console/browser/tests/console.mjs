/** Checks the page against the mock server. Run: node tests/console.mjs [words of a test's name] */
import { check, expectText, finish, launch, loaded, mock, open, test, text } from "./lib.mjs";

const only = process.argv[2] ?? "";
const browser = await launch();
const servers = [];
const serve = async (args, port) => {
  const server = await mock(args, port);
  servers.push(server);
  return server;
};
const t = (name, body) => (name.includes(only) ? test(name, body) : undefined);
/** Opens a page, does the body and looks that nothing went wrong in it. */
const withPage = (server, options, body) => async () => {
  const { page, trouble, close } = await open(browser, (await server).url, options);
  try {
    await loaded(page);
    await body(page);
    check(trouble.length === 0, "trouble in the page: " + trouble.join("; "));
  } finally {
    await close();
  }
};
const seek = (page, s) => page.evaluate((at) => window.page.seek(at), s).then(() => page.waitForTimeout(150));
const operate = async (page, token) => {
  await page.keyboard.press("h");
  if (await page.locator("#operator-name").isVisible()) {
    await page.fill("#operator-name", "Ada");
    await page.fill("#operator-token", token);
  }
  await page.click("#operator-go");
};

const recorded = serve(["--invent", "--malformed"], 8311);
await t("recorded: strip tells who steers and why at any time", withPage(recorded, {}, async (page) => {
  const at = async (s, id, pattern) => { await seek(page, s); await expectText(page, id, pattern); };
  await at(5, "who", /nobody/);
  await at(30, "who", /front seat/);
  await at(30, "element", /waypoint 1/);
  await at(200, "who", /isobath/);
  await at(200, "control", /yes/);
  await at(350, "who", /insert/);
  await at(350, "who-why", /trackcircle that hotspot asked for/);
  await at(770, "control", /no/);
  await at(770, "control-why", /navigation is implausible/);
  await at(770, "integrity", /jumped 84 m/);
  await at(1800, "who-why", /waypoint 3; isobath no longer steers: a behavior ended/);
  await at(1960, "mission", /Completed/);
  await at(912, "since", /0:15:12/);
  await expectText(page, "utc", /08:15:12 UTC/);
  await expectText(page, "badge", /RECORDED/);
  await expectText(page, "armed", /yes/);
  check(await page.locator("#hold").isHidden(), "hold is shown in a recorded dive");
  check(await page.locator("#banner-lost").isHidden(), "a recorded dive says it is not connected");
}));
await t("recorded: countdown, vehicle, profile, measures, sensors", withPage(recorded, {}, async (page) => {
  await seek(page, 912);
  await expectText(page, "dog-text", /0\.\d s of 5\.0 s/);
  await expectText(page, "figure-depth", /8\.0 m/);
  await expectText(page, "figure-altitude", /2[12]\.\d m/);
  await expectText(page, "figure-heading", /08\d°/);
  await expectText(page, "figure-position", /42°21\.\d{3}′N {2}70°42\.\d{3}′W/);
  await expectText(page, "measures", /contour_offset.*|chlorophyll.*/);
  check(await page.locator(".measure").count() === 3, "three measures");
  await expectText(page, "sensors", /BFCTD.*temperature.*salinity.*sonar sidescan/s);
  check(await page.locator("#profile canvas").count() === 1, "profile is drawn");
  const box = await page.locator("#profile .u-over").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + 40);
  await expectText(page, "since", /0:16:2\d/);
  await seek(page, 350);
  await expectText(page, "dog-text", /no lease/);
}));
await t("recorded: the sidescan's waterfall, what it has seen, and contacts", withPage(recorded, {}, async (page) => {
  await seek(page, 60);
  await page.waitForTimeout(1200);
  await expectText(page, "waterfall-range", /no ping/);
  await seek(page, 560);
  await page.waitForTimeout(1200);
  await expectText(page, "waterfall-range", /60 m to each side, 0:03:1\d to 0:09:(19|20)/);
  await expectText(page, "legend", /seen by the sidescan/);
  // Water is dark, the seabed is not, and ripples differ from each other.
  const tones = await page.evaluate(() => {
    const canvas = document.querySelector("#waterfall-canvas");
    const { width, height } = canvas;
    const tone = (share, y) => canvas.getContext("2d").getImageData(Math.floor(share * (width - 1)), Math.floor(y * height), 1, 1).data[0];
    const seabed = Array.from({ length: 40 }, (_, i) => tone(0.7 + i * 0.007, 0.1));
    return { low: Math.min(...seabed), high: Math.max(...seabed), drawn: canvas.width > 100 };
  });
  check(tones.drawn && tones.high - tones.low > 20, "no picture: " + JSON.stringify(tones));
  const strips = () => page.evaluate(() => window.page.map.sonar.area.getLatLngs().length);
  check(await strips() > 100, "strips: " + await strips());
  const contacts = () => page.evaluate(() => window.page.map.sonar.contacts.getLayers().map((l) => [l.getLatLng().lat, l.getTooltip().getContent(), l.options.color]));
  const [[lat, name, colour], ...others] = await contacts();
  check(lat === 42.3515 && name === "1" && others.length === 0, "a contact");
  await seek(page, 730);
  await page.waitForTimeout(1200);
  const later = await contacts();
  check(later.length === 2 && later[0][0] === 42.3516 && later[0][2] !== colour, "a contact that is confirmed moves and changes: " + JSON.stringify(later));
  await page.evaluate(() => window.page.map.sonar.contacts.getLayers()[0].fire("click", { latlng: [42.3516, -70.7121] }));
  check(/contact 1.*plugin hotspot.*confirmed/s.test(await page.locator(".leaflet-popup").textContent()), "a click tells");
  // A click in the picture goes to that ping.
  const box = await page.locator("#waterfall-canvas").boundingBox();
  await page.locator("#waterfall-canvas").click({ position: { x: box.width / 2, y: box.height - 2 } });
  await expectText(page, "since", /0:06:\d\d/);
}));
await t("recorded: plugin cards", withPage(recorded, {}, async (page) => {
  await seek(page, 912);
  const cards = await text(page, "cards");
  for (const pattern of [/isobath.*running.*steers now.*1\. may modify/s, /following the 30 m contour/, /hotspot.*may modify, insert/s,
    /Failed 2 times, at 0:15:00: trap: index out of bounds/, /trackcircle had no answer: no answer within 30 s/, /refused 2 · failed 2 · inserts flown 1/, /0 % · \d+ steps/]) {
    check(pattern.test(cards), "cards lack " + pattern);
  }
  await seek(page, 350);
  check(/its insert is flown/.test(await text(page, "cards")), "leads by its insert");
  await seek(page, 1600);
  check(/quarantined/.test(await text(page, "cards")), "quarantined");
}));
await t("recorded: untrusted text stays text, long words are cut, bad lines are counted", withPage(recorded, {}, async (page) => {
  await page.click("#levels button >> nth=0");
  await seek(page, 702);
  await expectText(page, "event-list", /<img src=x onerror/);
  check(await page.locator("#event-list img, #cards img, #cards b").count() === 0, "markup was made of text");
  check(!(await page.title()).includes("broken"), "script of the feed ran");
  await seek(page, 706);
  const row = page.locator(".event .text", { hasText: "WWWW" }).first();
  check((await row.textContent()).length <= 240 && (await row.getAttribute("title")).length === 600, "long text is cut with the whole in its title");
  await expectText(page, "bad-lines", /3 bad lines left out/);
  check(await page.evaluate(() => window.page.dive.unknown) === 1, "unknown kind is ignored");
}));
await t("recorded: events filter, search, click", withPage(recorded, {}, async (page) => {
  await page.keyboard.press("/");
  await page.keyboard.type("keep-out");
  await expectText(page, "event-count", /^1 of/);
  await page.click("#event-list button.event");
  await expectText(page, "since", /0:09:20/);
  await page.fill("#search", "");
  await page.click("#levels button >> nth=3");
  await page.waitForTimeout(300);
  const levels = await page.locator(".event").evaluateAll((rows) => [...new Set(rows.map((r) => r.dataset.level))]);
  check(levels.length === 1 && levels[0] === "error", "only errors");
  await page.click("#levels button >> nth=1");
  await page.selectOption("#event-who", "vehicle");
  await page.waitForTimeout(400);
  const whos = await page.locator(".event .who").allTextContents();
  check(whos.length > 3 && whos.every((w) => w === "vehicle"), "only the vehicle");
  await page.selectOption("#event-who", "");
  await page.waitForTimeout(400);
  for (const words of ["no control: the vehicle has control", "speed 2.60", "control granted", "the log ends here"]) {
    await page.fill("#search", words);
    await page.waitForTimeout(400);
    check(await page.locator(".event").count() === (words === "control granted" ? 2 : 1), "twice the same event: " + words);
  }
}));
await t("recorded: scrubber, marks, play and keys", withPage(recorded, {}, async (page) => {
  const box = await page.locator("#scrubber").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + 20);
  await expectText(page, "since", /0:16:2\d/);
  check(/0:16:2\d of 0:32:44/.test(await page.locator("#scrubber").getAttribute("aria-valuetext")), "slider tells its value");
  await page.keyboard.press("ArrowRight");
  await expectText(page, "since", /0:16:3\d/);
  await page.keyboard.press("Shift+ArrowLeft");
  await expectText(page, "since", /0:15:3\d/);
  await page.keyboard.press("]");
  await expectText(page, "since", /0:18:22/);
  await page.keyboard.press("[");
  await expectText(page, "since", /0:15:00/);
  await page.selectOption("#speed", "30");
  await page.locator("#panel-map").focus();
  await page.keyboard.press(" ");
  await page.waitForTimeout(1000);
  await page.keyboard.press(" ");
  const played = await page.evaluate(() => window.page.clock.t);
  check(played > 920 && played < 960, "played to " + played);
  await page.keyboard.press("Home");
  await expectText(page, "since", /0:00:00/);
  await page.keyboard.press("End");
  await expectText(page, "since", /0:32:44/);
  await page.keyboard.press("?");
  check(await page.locator("#keys-dialog").evaluate((d) => d.open), "? lists the keys");
  await page.keyboard.press("Escape");
  await page.keyboard.press("3");
  check(await page.evaluate(() => document.activeElement.id) === "panel-plugins", "3 goes to the plugins");
  await page.keyboard.press("f");
  check(await page.locator("#follow").getAttribute("aria-pressed") === "true", "F follows");
}));
await t("recorded: map has zones, track by who steers, tells on click", withPage(recorded, {}, async (page) => {
  await seek(page, 1700);
  const map = await page.evaluate(() => {
    const { map: view, dive } = window.page;
    return { zones: view.fence.parts.length, chunks: view.track.chunks.map((c) => dive.keys[c.key]), points: view.track.points, inserts: view.inserts.group.getLayers().length, refused: view.requests.group.getLayers().length };
  });
  check(map.zones === 4, "zones");
  for (const key of ["plan", "insert", "plugin:isobath"]) check(map.chunks.includes(key), "no track of " + key);
  check(map.inserts === 6 && map.refused === 1, `inserts ${map.inserts}, refused ${map.refused}`);
  check((await page.locator(".leaflet-tooltip.zone").allTextContents()).join() === "shelf,wreck,cable area,mooring", "names of the zones");
  await page.locator(".vehicle-icon path").click({ force: true });
  check(/steers/.test(await page.locator(".leaflet-popup-content").textContent()), "vehicle tells about itself");
  const at = await page.evaluate(() => {
    const p = window.page.map.map.latLngToContainerPoint([42.3402771, -70.6939326]);
    const box = document.getElementById("map").getBoundingClientRect();
    return [box.x + p.x, box.y + p.y];
  });
  await page.mouse.click(at[0] + 1, at[1] - 1);
  check(/wreck/.test(await page.locator(".leaflet-popup-content").textContent()), "zone tells about itself");
}));
await t("recorded: a fitted map stays fitted when its place changes", withPage(recorded, {}, async (page) => {
  const zoom = () => page.evaluate(() => window.page.map.map.getZoom());
  const before = await zoom();
  await page.setViewportSize({ width: 1900, height: 1100 });
  await page.waitForTimeout(400);
  const wide = await zoom();
  check(wide > before, `zoom ${before} then ${wide}`);
  await page.locator("#panel-map").focus();
  await page.keyboard.press("+");
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.waitForTimeout(400);
  check(Math.abs(await zoom() - wide - 1) < 0.01, "a zoom by the person is kept");
}));
await t("light and dark", withPage(recorded, { colorScheme: "dark" }, async (page) => {
  const bg = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await bg();
  await page.keyboard.press("t");
  check(await bg() !== dark, "toggle changes the colours");
  check(await page.evaluate(() => localStorage.length + sessionStorage.length) === 0, "something is stored");
}));
for (const [w, h] of [[1024, 768], [800, 1000], [768, 1024]]) {
  await t(`tablet ${w}x${h}: nothing sticks out, targets are large, tabs`, withPage(recorded, { viewport: { width: w, height: h }, hasTouch: true, isMobile: true }, async (page) => {
    check(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth && document.documentElement.scrollHeight <= innerHeight), "page scrolls");
    const small = await page.locator("button:visible, select:visible, input:visible, a.leaflet-control-zoom-in").evaluateAll((all) => all
      .map((n) => [n.id || n.textContent, n.getBoundingClientRect()]).filter(([, b]) => b.height < 43.5 || b.width < 43.5).map(([name, b]) => `${name} ${b.width}x${b.height}`));
    check(small.length === 0, "small targets: " + small.slice(0, 4));
    const outside = await page.locator("header *:visible, #timeline *:visible").evaluateAll((all) => all.filter((n) => n.getBoundingClientRect().right > innerWidth + 1).length);
    check(outside === 0, "outside of the page: " + outside);
    await page.tap("#tab-events");
    check(await page.locator("#event-list").isVisible() && await page.locator("#panel-vehicle").isHidden(), "tab shows events");
  }));
}
await (await recorded).stop();

await t("runs under a stricter policy, without inline styles", async () => {
  const server = await serve(["--invent", "--strict"], 8316);
  await withPage(server, {}, async (page) => {
    await seek(page, 900);
    await page.locator(".vehicle-icon path").click({ force: true });
    await page.waitForTimeout(300);
  })();
  await server.stop();
});
await t("10 hours: paints and loads fast, seeks in under 100 ms", async () => {
  const server = await serve(["--invent", "--hours", "10"], 8312);
  const { page, trouble, close } = await open(browser, server.url);
  const begun = Date.now();
  await page.waitForFunction(() => window.page?.dive.navigation.length > 0);
  const first = Date.now() - begun;
  await loaded(page);
  const whole = Date.now() - begun;
  const seeks = await page.evaluate(async () => {
    const p = window.page;
    const out = [];
    for (const part of [0.1, 0.9, 0.5, 0.99, 0.2, 0.7]) {
      p.seek(part * p.clock.end);
      p.tick();
      out.push(Math.round(p.drawMs));
      await new Promise((go) => setTimeout(go, 120));
    }
    return { out, items: p.dive.count, points: p.map.track.points, end: p.clock.end };
  });
  const paint = await page.evaluate(() => Math.round(performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? 9999));
  console.log(`        first paint after ${paint} ms, first data after ${first} ms, all ${seeks.items} items after ${whole} ms, seeks ${seeks.out} ms, ${seeks.points} points`);
  check(paint < 1000, "first paint after " + paint);
  check(seeks.end > 35000, "ten hours");
  check(Math.max(...seeks.out) < 100, "seeks: " + seeks.out);
  check(trouble.length === 0, trouble.join("; "));
  await close();
  await server.stop();
});

const live = serve(["--mode", "live", "--invent", "--at", "500"], 8313);
await t("live: moves on, looks back, returns with L", withPage(live, {}, async (page) => {
  await expectText(page, "badge", /LIVE/);
  await expectText(page, "heard", /^[01]\.\d s$/);
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  const before = await text(page, "since");
  await page.waitForTimeout(1300);
  check(await text(page, "since") !== before, "time stands still");
  await expectText(page, "dog-text", /[01]\.\d s of 5\.0 s/);
  await page.keyboard.press("Shift+ArrowLeft");
  await page.waitForTimeout(200);
  check(await page.locator("#banner-back").isVisible(), "looking back is not told");
  const there = await text(page, "since");
  await page.waitForTimeout(800);
  check(await text(page, "since") === there, "looking back does not stand still");
  await page.keyboard.press("l");
  await page.waitForTimeout(250);
  check(await page.locator("#banner-back").isHidden(), "L returns to live");
  check(await page.locator("#banner-log").isHidden(), "a dive that is recorded says that it is not");
}));
await t("live: wrong token, hold, release", withPage(live, {}, async (page) => {
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  await operate(page, "wrong");
  await expectText(page, "operator-answer", /Wrong token\. Nothing was done\./);
  check(await page.locator("#banner-held").isHidden(), "held with a wrong token");
  await page.fill("#operator-name", "Ada");
  await page.fill("#operator-token", "secret");
  await page.keyboard.press("Enter");
  await expectText(page, "operator-answer", /Done\. The runtime holds\./);
  await expectText(page, "held-text", /by Ada since/);
  check((await page.locator("#banner-held strong").evaluate((n) => parseFloat(getComputedStyle(n).fontSize))) >= 40, "HELD is small");
  await expectText(page, "who", /front seat/);
  await expectText(page, "control-why", /the operator's hold is set/);
  await page.waitForFunction(() => !document.getElementById("operator-dialog").open);
  await operate(page, "not asked again");
  await expectText(page, "operator-answer", /may steer again/);
  await page.waitForFunction(() => document.getElementById("banner-held").hidden);
  await expectText(page, "who", /isobath/, 8000);
  check(await page.evaluate(() => localStorage.length + sessionStorage.length + document.cookie.length) === 0, "token stored");
  check(!page.url().includes("secret"), "token in the URL");
}));
await t("live: a dive that is not recorded says so", async () => {
  const full = serve(["--mode", "live", "--invent", "--at", "1610"], 8317);
  await withPage(full, {}, async (page) => {
    await page.waitForFunction(() => !document.body.classList.contains("stale"));
    await expectText(page, "log-text", /not been recorded since .*: the log ends here, the run continues: No space left on device\./);
    check(await page.locator("#banner-log").isVisible(), "the end of the log is not told");
  })();
  await (await full).stop();
});
await t("live: not possible now", withPage(live, {}, async (page) => {
  const act = async (name) => fetch((await live).url + "api/operator", { method: "POST", headers: { Authorization: "Bearer secret" }, body: JSON.stringify({ act: name, who: "Bob" }) });
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  await page.keyboard.press("h");
  await page.fill("#operator-name", "Ada");
  await page.fill("#operator-token", "secret");
  await act("hold");
  await page.click("#operator-go");
  await expectText(page, "operator-answer", /Not possible now: it is held already/);
  await expectText(page, "held-text", /by Bob/);
  await act("release");
}));
await t("live: odd items do no harm", withPage(live, {}, async (page) => {
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  const odd = [{ kind: "constructor" }, { kind: "navigation", lat: "x" }, { kind: "request", owner: "__proto__", state: "constructor", request_kind: {} },
    { kind: "plugin", plugin: "__proto__", state: "toString" }, { kind: "map", layer: "inserts", geojson: { features: [null, 7, { geometry: { type: "Point", coordinates: ["a"] } },
      { geometry: { type: "Polygon", coordinates: [[[999, 999]]] }, properties: { state: "constructor" } }] } }, { kind: "sensor", name: "x", data: [1] },
    { kind: "measure", plugin: "p", name: "n", value: "NaN" }, { kind: "steering", owner: { a: 1 } }, { kind: "line", who: 5, text: { b: 2 }, level: "loud" }, { kind: "beat", refreshed: "now" }, { kind: 9 }, { t: "soon", kind: "line" }];
  for (const item of odd) await (await live).post("mock/item", item);
  await page.waitForFunction(() => window.page.dive.malformed >= 2);
  await page.waitForTimeout(500);
  const before = await text(page, "since");
  await page.waitForTimeout(1200);
  check(await text(page, "since") !== before, "the page stands still");
}));
await t("live: too many tries", withPage(live, {}, async (page) => {
  for (let i = 0; i < 5; i++) await (await live).post("api/operator", { act: "hold", who: "x" });
  await operate(page, "wrong");
  await expectText(page, "operator-answer", /Nothing was done: too many tries/);
}));
await t("live: silence is told within 3.5 s, then it recovers", withPage(live, {}, async (page) => {
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  await (await live).post("mock/stall", { on: true });
  await page.waitForFunction(() => document.body.classList.contains("stale"), null, { timeout: 4500 });
  await expectText(page, "lost-word", /NOT CONNECTED/);
  await expectText(page, "dog-text", /not known now/);
  await (await live).post("mock/stall", { on: false });
  await page.waitForFunction(() => !document.body.classList.contains("stale"), null, { timeout: 6000 });
}));
await t("live: feed reset fetches the history again", withPage(live, {}, async (page) => {
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  await page.evaluate(() => { window.old = window.page.dive; });
  await (await live).post("mock/reset", {});
  await page.waitForFunction(() => window.page.dive !== window.old && window.page.loading === 1);
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  check(await page.evaluate(() => window.page.dive.navigation.length) > 400, "history is there again");
}));
await t("live: connects again when the program was killed and started anew", async () => {
  let server = await serve(["--mode", "live", "--invent", "--at", "500"], 8314);
  const { page, trouble, close } = await open(browser, server.url);
  await loaded(page);
  await page.waitForFunction(() => !document.body.classList.contains("stale"));
  await server.stop();
  await page.waitForFunction(() => document.body.classList.contains("stale"), null, { timeout: 5000 });
  await expectText(page, "lost-text", /Nothing came for \d/);
  await operate(page, "secret");
  await expectText(page, "operator-answer", /No answer from the program/);
  await page.keyboard.press("Escape");
  server = await serve(["--mode", "live", "--invent", "--at", "300"], 8314);
  await page.waitForFunction(() => !document.body.classList.contains("stale"), null, { timeout: 15000 });
  await expectText(page, "since", /0:05:/);
  check(trouble.length === 0, trouble.join("; "));
  await close();
  await server.stop();
});
await (await live).stop();

const plain = serve(["--mode", "live", "--kind", "simulated", "--invent", "--at", "200", "--times", "10", "--no-operator"], 8315);
await t("simulated: pace can be set, no operator no buttons", withPage(plain, {}, async (page) => {
  await expectText(page, "badge", /SIMULATED/);
  check(await page.locator("#hold").isHidden(), "hold without an operator");
  await page.click("#pace button >> nth=0");
  await expectText(page, "lost-word", /PAUSED/);
  await page.waitForTimeout(300);
  const stood = await text(page, "since");
  await page.waitForTimeout(3500);
  check(await text(page, "since") === stood, "pause does not pause");
  await expectText(page, "lost-word", /PAUSED/);
  await page.click("#pace button >> nth=3");
  await page.waitForTimeout(1500);
  check(await page.evaluate(() => window.page.clock.now()) > 300, "100 times is slow");
  check(await page.locator("#banner-lost").isHidden(), "still paused");
  await page.click("#pace button >> nth=4");
  await expectText(page, "badge", /OVER/, 15000);
  check(await page.locator("#banner-lost").isHidden(), "over is told as not connected");
  // What is over does not look new.
  for (const id of ["armed", "control", "heard", "nav-age"]) check(await text(page, id) === "–", `${id} after the end`);
  check(await page.locator("#pace").isHidden(), "a pace after the end");
}));
await (await plain).stop();
await browser.close();
for (const server of servers) await (await server).stop();
finish();

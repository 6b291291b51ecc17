/** Takes the screenshots. */
import path from "node:path";
import { launch, loaded, mock, open, SHOTS } from "./lib.mjs";

const only = process.argv[2] ?? "";
const browser = await launch();
const shoot = async (name, url, options, act) => {
  if (!name.includes(only)) return;
  const { page, trouble, close } = await open(browser, url, options);
  await loaded(page);
  await page.waitForTimeout(600);
  await act?.(page);
  await page.waitForTimeout(400);
  await page.screenshot({ path: path.join(SHOTS, name + ".png") });
  if (trouble.length) console.log(name, trouble);
  await close();
};
const tablet = { viewport: { width: 1024, height: 768 }, hasTouch: true };
const recorded = await mock(["--invent", "--malformed"], 8301);
const seek = (t) => (page) => page.evaluate((s) => window.page.seek(s), t);
await shoot("recorded-light", recorded.url, {}, seek(912));
await shoot("recorded-dark", recorded.url, { colorScheme: "dark" }, seek(912));
await shoot("recorded-tablet", recorded.url, tablet, seek(912));
await shoot("recorded-popup-dark", recorded.url, { colorScheme: "dark" }, async (page) => {
  await seek(1400)(page);
  await page.selectOption("#profile-span", "600");
  await page.evaluate(() => {
    const { map } = window.page;
    map.requests.group.getLayers()[0].fire("click", { latlng: [42.3412, -70.6925] });
  });
  const box = await page.locator("#scrubber").boundingBox();
  await page.mouse.move(box.x + box.width * 0.31, box.y + 20);
});
await shoot("recorded-wide", recorded.url, { viewport: { width: 1920, height: 1080 } }, seek(1400));
await recorded.stop();
const live = await mock(["--mode", "live", "--invent", "--at", "560"], 8302);
await shoot("live-light", live.url, {}, async (page) => { await page.keyboard.press("f"); await page.waitForTimeout(1500); });
await shoot("live-tablet-dark", live.url, { ...tablet, colorScheme: "dark" }, async (page) => { await page.keyboard.press("3"); await page.waitForTimeout(1000); });
await shoot("live-tablet-events", live.url, tablet, async (page) => { await page.keyboard.press("4"); await page.waitForTimeout(1000); });
await shoot("live-800", live.url, { viewport: { width: 800, height: 1000 } });
await shoot("keys", live.url, { colorScheme: "dark" }, (page) => page.keyboard.press("?"));
await shoot("live-hold", live.url, {}, async (page) => {
  await page.keyboard.press("h");
  await page.fill("#operator-name", "Ada");
  await page.fill("#operator-token", "secret");
  await page.screenshot({ path: path.join(SHOTS, "live-hold-dialog.png") });
  await page.keyboard.press("Enter");
  await page.waitForTimeout(2500);
});
await shoot("live-lost", live.url, {}, async (page) => { await live.stop(); await page.waitForTimeout(4500); });
await live.stop().catch(() => {});
const unrecorded = await mock(["--mode", "live", "--invent", "--at", "1610"], 8304);
await shoot("live-no-log", unrecorded.url, {}, (page) => page.waitForTimeout(1500));
await unrecorded.stop();
const sim = await mock(["--mode", "live", "--kind", "simulated", "--invent", "--at", "1200", "--times", "10"], 8303);
await shoot("simulated-back-dark", sim.url, { colorScheme: "dark" }, seek(765));
await sim.stop();
await browser.close();

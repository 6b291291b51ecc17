/** Measures the page with a long recorded dive, as `backseat log view` serves it: how soon something is painted, how soon all is
 * there, and how long a seek takes until the new instant is drawn. Fails if something is not drawn, never because of a time. */
import { spawn } from "node:child_process";
import { check, launch, loaded, open } from "./lib.mjs";

const SEEKS = 60;
const program = spawn(process.env.CONSOLE_PROGRAM ?? "backseat", ["log", "view", process.env.CONSOLE_LONG_LOG, "--listen", "127.0.0.1:0"], { stdio: ["ignore", "pipe", "inherit"] });
let said = "";
const url = await new Promise((done, fail) => {
  program.stdout.on("data", (bytes) => {
    said += bytes;
    const found = /http:\/\/[0-9.:]+/.exec(said);
    if (found) done(found[0]);
  });
  program.once("exit", (code) => fail(new Error(`log view ended with ${code}: ${said}`)));
});
const browser = await launch();
const { page, trouble, close } = await open(browser, url);
await page.waitForFunction(() => performance.getEntriesByName("first-contentful-paint").length > 0);
const painted = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0].startTime);
await loaded(page);
const all = await page.evaluate(() => performance.now());
const end = await page.evaluate(() => window.page.clock.end);
const pseudorandom = (n) => (n * 0.6180339887) % 1;
const times = [];
for (let n = 1; n <= SEEKS; n++) {
  const at = pseudorandom(n) * end;
  const [ms, shown] = await page.evaluate(async (t) => {
    const begun = performance.now();
    window.page.seek(t);
    // The page draws in its own frame callback; the one after that begins when the browser has painted.
    await new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)));
    return [performance.now() - begun, window.page.clock.shown];
  }, at);
  check(Math.abs(shown - at) < 1, `sought ${at} s, shown ${shown} s`);
  times.push(ms);
}
times.sort((a, b) => a - b);
check(trouble.length === 0, "trouble in the page: " + trouble.join("; "));
console.log(`a dive of ${(end / 3600).toFixed(1)} h: first paint ${painted.toFixed(0)} ms, all there ${(all / 1000).toFixed(1)} s, a seek ${times[SEEKS / 2].toFixed(0)} ms (half), ${times[SEEKS - 1].toFixed(0)} ms (longest of ${SEEKS})`);
await close();
await browser.close();
program.removeAllListeners("exit");
program.kill();

/** Starts the mock server and Chromium for the tests. */
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";
import path from "node:path";

const HERE = path.dirname(fileURLToPath(import.meta.url));
const PYTHON = process.env.CONSOLE_PYTHON ?? "python3";
const MODULES = process.env.CONSOLE_MODULES ?? HERE;
const { chromium } = createRequire(path.join(MODULES, "x.js"))("playwright-core");
export const SHOTS = process.env.CONSOLE_SHOTS ?? path.join(HERE, "shots");

/** @param {string[]} args @param {number} port */
export async function mock(args, port) {
  const child = spawn(PYTHON, [path.join(HERE, "..", "mock", "server.py"), "--port", String(port), ...args], { stdio: ["ignore", "pipe", "inherit"] });
  await new Promise((done, fail) => {
    child.stdout.once("data", done);
    child.once("exit", (code) => fail(new Error("mock ended: " + code)));
  });
  const url = `http://127.0.0.1:${port}/`;
  const post = (name, body) => fetch(url + name, { method: "POST", body: JSON.stringify(body) });
  return {
    url, post,
    stop: () => new Promise((done) => {
      if (child.exitCode !== null || child.signalCode !== null) return done(undefined);
      child.removeAllListeners("exit");
      child.once("exit", done);
      child.kill("SIGKILL");
    }),
  };
}

export const launch = () => chromium.launch({ executablePath: process.env.CONSOLE_CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });

/** A page that notes every error, refused content and request elsewhere. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
  const page = await context.newPage();
  const trouble = [];
  page.on("pageerror", (error) => trouble.push("error: " + (error.stack ?? error.message)));
  page.on("console", (message) => {
    if (message.type() === "error" && !/WebSocket connection|Failed to load resource|ERR_CONNECTION|ERR_INVALID_HTTP/.test(message.text())) trouble.push(message.text());
  });
  page.on("request", (request) => {
    const host = new URL(request.url()).host;
    if (host && host !== new URL(url).host) trouble.push("request elsewhere: " + request.url());
  });
  await page.goto(url);
  return { page, trouble, close: () => context.close() };
}

export const text = (page, id) => page.locator("#" + id).textContent();
export const loaded = (page) => page.waitForFunction(() => window.page?.loading === 1, null, { timeout: 30000 });
/** @param {any} page @param {string} id @param {RegExp} pattern */
export async function expectText(page, id, pattern, timeout = 5000) {
  const until = Date.now() + timeout;
  let seen = "";
  while (Date.now() < until) {
    seen = (await text(page, id)) ?? "";
    if (pattern.test(seen)) return seen;
    await page.waitForTimeout(50);
  }
  throw new Error(`#${id} is "${seen}", wanted ${pattern}`);
}

let failed = 0;
let passed = 0;
/** @param {string} name @param {() => Promise<unknown>} body */
export async function test(name, body) {
  try {
    await body();
    passed += 1;
    console.log("ok      " + name);
  } catch (error) {
    failed += 1;
    console.log("FAILED  " + name + "\n        " + String(error.stack ?? error).split("\n").slice(0, 4).join("\n        "));
  }
}
export function check(truth, what) {
  if (!truth) throw new Error(what);
}
export function finish() {
  console.log(`${passed} passed, ${failed} failed`);
  process.exitCode = failed ? 1 : 0;
}

/** Reads what happened until now: NDJSON, parsed as it comes. */

const SLICE_MS = 30;

/**
 * @param {import("./dive.js").Dive} dive
 * @param {(done: number, total: number) => void} told called now and then while it loads
 * @param {AbortSignal} [signal]
 */
export async function loadHistory(dive, told, signal) {
  const answer = await fetch("api/history", { cache: "no-store", signal });
  if (!answer.ok || !answer.body) throw new Error("history: " + answer.status);
  const total = Number(answer.headers.get("Content-Length")) || 0;
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  let done = 0;
  let slice = performance.now();
  const breathe = async () => {
    if (performance.now() - slice < SLICE_MS) return;
    told(done, total);
    await new Promise((go) => setTimeout(go, 0));
    slice = performance.now();
  };
  for (;;) {
    const part = await reader.read();
    if (part.done) break;
    done += part.value.length;
    const lines = (rest + part.value).split("\n");
    rest = lines.pop() ?? "";
    for (let i = 0; i < lines.length; i++) {
      takeLine(dive, lines[i]);
      if (i % 500 === 499) await breathe();
    }
    await breathe();
  }
  takeLine(dive, rest);
}

/** @param {import("./dive.js").Dive} dive @param {string} line */
export function takeLine(dive, line) {
  if (line.trim() === "") return;
  let item;
  try {
    item = JSON.parse(line);
  } catch {
    dive.malformed += 1;
    return;
  }
  takeSafely(dive, item);
}

/** One odd item must not stop the page. @param {import("./dive.js").Dive} dive @param {unknown} item */
export function takeSafely(dive, item) {
  try {
    dive.take(item);
  } catch {
    dive.malformed += 1;
  }
}

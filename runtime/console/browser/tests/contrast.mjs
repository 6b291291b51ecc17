/** Checks the contrast of the colours in style.css: WCAG AA for text, 3:1 for lines. */
import { readFileSync } from "node:fs";

const css = readFileSync(new URL("../../assets/style.css", import.meta.url), "utf8");
const themes = [...css.matchAll(/:root(\[data-theme="dark"\])? \{([^}]*)\}/g)].slice(0, 2).map((m) => Object.fromEntries([...m[2].matchAll(/--([\w-]+): (#\w+)/g)].map((v) => [v[1], v[2]])));
const light = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)).reduce((s, c, i) => s + c * [0.2126, 0.7152, 0.0722][i], 0);
const ratio = (a, b) => {
  const [hi, lo] = [light(a), light(b)].sort((x, y) => y - x);
  return (hi + 0.05) / (lo + 0.05);
};
const texts = [["ink", "panel"], ["ink", "bg"], ["ink", "button"], ["ink", "sea"], ["soft", "panel"], ["soft", "bg"], ["good", "panel"], ["warn", "panel"], ["warn", "button"], ["bad", "panel"], ["bad", "button"],
  ["panel", "accent"], ["held-ink", "held"], ["panel", "good"], ["panel", "warn"], ["panel", "bad"], ["grid-ink", "sea"], ["soft", "button"],
  ...["plan", "insert", "operator", "nobody", ...[0, 1, 2, 3, 4, 5].map((n) => "plugin" + n)].map((n) => ["c-" + n, "panel"])];
const lines = [["keepin", "sea"], ["keepout", "sea"], ["open", "sea"], ["flown", "sea"], ["over", "sea"], ["refused", "sea"], ["unsure", "sea"], ["c-plan", "sea"], ["c-insert", "sea"], ["c-plugin0", "sea"], ["c-plugin1", "sea"], ["focus", "panel"], ["focus", "bg"], ["depth", "panel"]];
let bad = 0;
themes.forEach((theme, i) => {
  for (const [list, least] of [[texts, 4.5], [lines, 3]]) {
    for (const [a, b] of list) {
      const r = ratio(theme[a], theme[b]);
      if (!(r >= least)) {
        bad += 1;
        console.log(`FAILED  ${i ? "dark" : "light"} ${a} on ${b}: ${r.toFixed(2)} < ${least}`);
      }
    }
  }
});
console.log(bad ? `${bad} failed` : "ok      contrast in light and dark");
process.exitCode = bad ? 1 : 0;

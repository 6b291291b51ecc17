/** The sea: a graticule with labels, drawn behind the map. */
import { latitude, longitude } from "./format.js";
import { fit } from "./dom.js";
import { onTheme, tint } from "./theme.js";

/** Steps in minutes of arc. */
const STEPS = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800];

/** @param {number} degrees of the view @param {number} lines wanted at most */
function step(degrees, lines) {
  return (STEPS.find((s) => (degrees * 60) / s <= lines) ?? 3600) / 60;
}

/** The buttons + and - and the scale lie over the map's lower left corner, this high, pixels. */
const CORNER = 140;
/** The length of a label, pixels. */
const LABEL = 90;

export class Grid {
  /** @param {any} map */
  constructor(map) {
    this.map = map;
    this.canvas = document.createElement("canvas");
    this.canvas.className = "grid";
    this.canvas.setAttribute("aria-hidden", "true");
    map.getContainer().prepend(this.canvas);
    map.on("move zoom resize viewreset", () => this.draw());
    onTheme(() => this.draw());
  }

  draw() {
    const area = fit(this.canvas);
    if (!area) return;
    const { ctx, w, h } = area;
    const bounds = this.map.getBounds();
    const tools = /** @type {HTMLElement|null} */ (document.querySelector(".map-tools"));
    const right = (tools?.offsetLeft ?? w) - LABEL;
    ctx.strokeStyle = tint("grid");
    ctx.fillStyle = tint("grid-ink");
    ctx.lineWidth = 1;
    ctx.font = "12px system-ui, sans-serif";
    this.lines(ctx, bounds.getWest(), bounds.getEast(), Math.max(2, w / 150), (lon, digits) => {
      const x = Math.round(this.map.latLngToContainerPoint([bounds.getCenter().lat, lon]).x) + 0.5;
      ctx.moveTo(x, 0);
      ctx.lineTo(x, h);
      if (x < right) ctx.fillText(longitude(lon, digits), x + 4, 14);
    });
    this.lines(ctx, bounds.getSouth(), bounds.getNorth(), Math.max(2, h / 110), (lat, digits) => {
      const y = Math.round(this.map.latLngToContainerPoint([lat, bounds.getCenter().lng]).y) + 0.5;
      ctx.moveTo(0, y);
      ctx.lineTo(w, y);
      if (y > 16 && y < h - CORNER) ctx.fillText(latitude(lat, digits), 6, y - 4);
    });
  }

  /**
   * @param {CanvasRenderingContext2D} ctx @param {number} from @param {number} to @param {number} most
   * @param {(at: number, digits: number) => void} one
   */
  lines(ctx, from, to, most, one) {
    const by = step(to - from, most);
    const digits = by * 60 >= 1 ? 0 : by * 60 >= 0.1 ? 1 : by * 60 >= 0.01 ? 2 : 3;
    ctx.beginPath();
    for (let k = Math.ceil(from / by), n = 0; k * by <= to && n < 60; k++, n++) one(k * by, digits);
    ctx.stroke();
  }
}

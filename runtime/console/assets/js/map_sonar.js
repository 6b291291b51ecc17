/** What the sidescan has seen of the seabed, and the contacts of which plugins tell. */
import * as L from "../vendor/leaflet/leaflet.js";
import { cut } from "./format.js";
import { tint } from "./theme.js";

/** Metres in a degree of latitude. */
const DEGREE = 111195;
/** Two swaths farther apart in time than this are not joined, seconds. */
const APART = 6;
/** Strips that are drawn at most. */
const STRIPS = 4000;
/** The area is built at most this often, milliseconds. */
const EVERY = 900;

/** The ends of a swath: port, starboard. @param {Record<string, number>} row @returns {[[number, number], [number, number]]} */
function ends(row) {
  const beam = (row.heading_deg * Math.PI) / 180;
  const east = Math.cos(beam) / (DEGREE * Math.cos((row.lat * Math.PI) / 180));
  const north = -Math.sin(beam) / DEGREE;
  return [[row.lat - row.port_m * north, row.lon - row.port_m * east], [row.lat + row.starboard_m * north, row.lon + row.starboard_m * east]];
}

export class SonarLayer {
  /**
   * @param {any} map @param {any} renderer
   * @param {(at: any, title: string, rows: [string, string][], t?: number) => void} tell
   */
  constructor(map, renderer, tell) {
    this.renderer = renderer;
    this.tell = tell;
    this.mark = "";
    this.made = 0;
    this.area = L.polygon([], { renderer, stroke: false, fill: true, fillOpacity: 0.22, fillRule: "nonzero", interactive: false }).addTo(map);
    this.area.bringToBack();
    this.contacts = L.featureGroup().addTo(map);
    this.shown = "";
    this.restyle();
  }

  restyle() {
    this.area.setStyle({ fillColor: tint("seen") });
    this.shown = "";
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t @returns {boolean} whether there is a swath */
  draw(dive, t) {
    this.drawContacts(dive, t);
    const last = dive.swaths.index(t);
    const mark = `${last}`;
    const now = performance.now();
    if (mark !== this.mark && now - this.made > EVERY) {
      this.mark = mark;
      this.made = now;
      this.area.setLatLngs(this.strips(dive.swaths, last));
      this.area.bringToBack();
    }
    return dive.swaths.length > 0;
  }

  /** @param {import("./series.js").Columns} swaths @param {number} last */
  strips(swaths, last) {
    const step = Math.max(1, Math.ceil(last / STRIPS));
    const strips = [];
    let before = swaths.row(0);
    for (let i = step; i <= last; i += step) {
      const row = swaths.row(i);
      if (before && row && row.t - before.t < APART * step) {
        const [port, starboard] = ends(before);
        const [nextPort, nextStarboard] = ends(row);
        strips.push([[port, nextPort, nextStarboard, starboard]]);
      }
      before = row;
    }
    return strips;
  }

  /** @param {import("./dive.js").Dive} dive @param {number} t */
  drawContacts(dive, t) {
    const now = [...dive.contacts.values()].map((series) => series.at(t)).filter((contact) => contact !== undefined);
    const shown = now.map((contact) => `${contact.name} ${contact.t}`).join();
    if (shown === this.shown) return;
    this.shown = shown;
    this.contacts.clearLayers();
    for (const contact of now) {
      const color = tint(contact.word === "confirmed" ? "flown" : contact.word === "rejected" ? "over" : "unsure");
      const marker = L.circleMarker([contact.lat, contact.lon], { renderer: this.renderer, radius: 9, weight: 3, color, fill: true, fillOpacity: 0.15, bubblingMouseEvents: false });
      marker.bindTooltip(cut(contact.name, 12), { permanent: true, direction: "right", offset: [8, 0], className: "contact" });
      marker.on("click", (/** @type {any} */ e) => this.tell(e.latlng, "contact " + contact.name, [["by", "plugin " + contact.plugin], ["says", contact.text]], contact.t));
      this.contacts.addLayer(marker);
    }
  }
}

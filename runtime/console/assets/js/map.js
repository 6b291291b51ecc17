/** The map: sea, fence, plan, inserts, track and vehicle. */
import * as L from "../vendor/leaflet/leaflet.js";
import { byId, calm, make, mark, terms } from "./dom.js";
import { beganMs, cut, heading, hms, latitude, longitude, num } from "./format.js";
import { Grid } from "./map_grid.js";
import { Track } from "./map_track.js";
import { FenceLayer } from "./map_fence.js";
import { FeatureLayer } from "./map_layers.js";
import { Reach } from "./map_reach.js";
import { SonarLayer } from "./map_sonar.js";
import { onTheme, tint, tintName } from "./theme.js";

/** @typedef {import("./main.js").Shown} Shown */

/** @type {[string, string][]} words and colours of the states of inserts */
const INSERTS = [["open", "open"], ["flown", "flown"], ["over", "over"], ["refused or failed", "refused"], ["unknown", "unsure"]];

/** @param {string} [path] */
function arrow(path = "M0,-17 L11,14 L0,8 L-11,14 Z") {
  const box = make("div");
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("width", "1");
  svg.setAttribute("height", "1");
  const shape = document.createElementNS("http://www.w3.org/2000/svg", "path");
  shape.setAttribute("d", path);
  svg.append(shape);
  box.append(svg);
  return { box, shape };
}

export class MapView {
  /** @param {(t: number) => void} seek @param {() => Shown} current */
  constructor(seek, current) {
    this.current = current;
    this.seek = seek;
    this.following = false;
    this.fitted = "";
    this.legendKeys = "";
    /** whether the map shows all since it was fitted */
    this.whole = false;
    this.fitting = false;
    this.map = L.map(byId("map"), {
      attributionControl: false, keyboard: false, zoomControl: false, zoomSnap: 0.1, zoomDelta: 0.75, zoomAnimation: false, markerZoomAnimation: false,
      fadeAnimation: false, inertia: !calm(), minZoom: 2, maxZoom: 22, worldCopyJump: false,
    }).setView([0, 0], 3);
    const renderer = L.canvas({ tolerance: 8, padding: 0.2 });
    const tell = this.tell.bind(this);
    L.control.scale({ imperial: false, maxWidth: 140 }).addTo(this.map);
    L.control.zoom({ position: "bottomleft" }).addTo(this.map);
    this.grid = new Grid(this.map);
    this.fence = new FenceLayer(this.map, renderer, tell);
    this.sonar = new SonarLayer(this.map, renderer, tell);
    this.plan = new FeatureLayer(this.map, renderer, "plan", tell);
    this.reach = new Reach(this.map, renderer, tell);
    this.track = new Track(this.map, renderer, (e, t, key) => this.tellTrack(e, t, key));
    this.inserts = new FeatureLayer(this.map, renderer, "inserts", tell);
    this.requests = new FeatureLayer(this.map, renderer, "requests", tell);
    this.truth = L.circleMarker([0, 0], { renderer, radius: 6, weight: 2, fill: false, interactive: false });
    const { box, shape } = arrow();
    this.shape = shape;
    this.vehicle = L.marker([0, 0], {
      icon: L.divIcon({ html: box, className: "vehicle-icon", iconSize: [1, 1] }), keyboard: false, zIndexOffset: 1000, title: "the vehicle",
    });
    this.vehicle.on("click", () => this.tellVehicle());
    this.map.on("dragstart", () => this.follow(false));
    this.map.on("dragstart zoomstart", () => { this.whole = this.fitting; });
    byId("fit").addEventListener("click", () => this.fit());
    byId("follow").addEventListener("click", () => this.follow(!this.following));
    new ResizeObserver(() => this.resized()).observe(byId("map"));
    onTheme(() => this.restyle());
  }

  /** @param {any} about */
  begin(about) {
    this.fence.build(about.fence);
    this.track.clear();
    this.fitted = "";
  }

  restyle() {
    this.fence.restyle();
    this.track.restyle(this.current().dive.keys);
    for (const layer of [this.plan, this.inserts, this.requests]) layer.build();
    this.reach.restyle();
    this.sonar.restyle();
    this.legendKeys = "";
    this.truth.setStyle({ color: tint("bad") });
  }

  /** @param {Shown} shown */
  draw({ state, dive, about, clock }) {
    this.plan.draw(dive.at("map:plan", state.t));
    this.reach.draw(dive, state.t);
    const added = this.track.draw(dive, state.t, clock.following);
    const changed = this.inserts.draw(dive.at("map:inserts", state.t));
    const more = this.requests.draw(dive.at("map:requests", state.t));
    if (added || changed || more) {
      this.inserts.group.bringToFront();
      this.requests.group.bringToFront();
    }
    this.fence.at(beganMs(about.began_ns) + state.t * 1000);
    this.drawVehicle(state);
    const seen = this.sonar.draw(dive, state.t);
    this.legend(dive, this.inserts.states, seen);
    this.firstFit(dive);
  }

  /** @param {any} state */
  drawVehicle(state) {
    const nav = state.navigation;
    if (!nav) {
      this.vehicle.remove();
      return;
    }
    this.vehicle.setLatLng([nav.lat, nav.lon]);
    this.shape.setAttribute("transform", `rotate(${(nav.heading_deg || 0).toFixed(1)})`);
    if (!this.map.hasLayer(this.vehicle)) this.vehicle.addTo(this.map);
    const truth = state.truth;
    if (truth && Number.isFinite(truth.lat)) {
      this.truth.setLatLng([truth.lat, truth.lon]).setStyle({ color: tint("bad") });
      if (!this.map.hasLayer(this.truth)) this.truth.addTo(this.map);
    }
    if (!this.following) return;
    const at = this.map.latLngToContainerPoint([nav.lat, nav.lon]);
    if (at.distanceTo(this.map.getSize().divideBy(2)) > 24) this.map.panTo([nav.lat, nav.lon], { animate: false });
  }

  /** @param {import("./dive.js").Dive} dive @param {Set<string>} inserts @param {boolean} seen whether a sidescan has seen something */
  legend(dive, inserts, seen) {
    const keys = dive.keys.join("\n") + [...inserts].join() + seen;
    if (keys === this.legendKeys) return;
    this.legendKeys = keys;
    const entry = (/** @type {string} */ word, /** @type {string} */ name) => {
      const span = make("span", "", cut(word, 20));
      span.style.setProperty("--tint", tint(name));
      return span;
    };
    const track = make("div");
    track.append(make("b", "", "Track "), ...dive.keys.slice(0, 12).map((key) => (
      entry(key === "plan" ? "front seat's plan" : key.replace(/^plugin:/, ""), tintName(key)))));
    byId("legend").replaceChildren(track);
    if (seen) {
      const sonar = make("div");
      sonar.append(make("b", "", "Sonar "), entry("seen by the sidescan", "seen"));
      byId("legend").append(sonar);
    }
    if (!inserts.size) return;
    const states = make("div");
    states.append(make("b", "", "Inserts "), ...INSERTS.filter(([, name]) => inserts.has(name)).map(([word, name]) => entry(word, name)));
    byId("legend").append(states);
  }

  /** Fits once there is something, and once more when the history is whole. @param {import("./dive.js").Dive} dive */
  firstFit(dive) {
    const want = this.fence.parts.length ? "fence" : dive.navigation.length > 1 ? "track" : "";
    if (!want || this.fitted) return;
    this.fitted = want;
    this.fit();
  }

  fit() {
    this.follow(false);
    const bounds = this.fence.bounds();
    if (this.plan.group.getLayers().length) bounds.extend(this.plan.group.getBounds());
    const { dive } = this.current();
    const nav = dive.navigation;
    const step = Math.max(1, Math.floor(nav.length / 500));
    for (let i = 0; i < nav.length; i += step) bounds.extend([nav.c.lat[i], nav.c.lon[i]]);
    if (!bounds.isValid()) return;
    this.fitting = true;
    this.map.fitBounds(bounds, { paddingTopLeft: [24, 62], paddingBottomRight: [24, 62], animate: false, maxZoom: 19 });
    this.fitting = false;
    this.whole = true;
  }

  /** A map that shows all goes on to show all. */
  resized() {
    const { whole } = this;
    this.map.invalidateSize({ animate: false });
    if (whole && !this.following) this.fit();
  }

  /** @param {boolean} on */
  follow(on) {
    this.following = on;
    byId("follow").setAttribute("aria-pressed", String(on));
    mark(byId("follow"), "on", String(on));
    if (on && this.map.getZoom() < 15.5) this.map.setZoom(15.5, { animate: false });
  }

  /** @param {number} by */
  zoom(by) {
    this.map.setZoom(this.map.getZoom() + by, { animate: false });
  }

  /** @param {any} at @param {string} title @param {[string, string][]} rows @param {number} [t] */
  tell(at, title, rows, t) {
    const box = make("div");
    box.append(make("h3", "", cut(title, 80)), terms(rows));
    if (t !== undefined) {
      const go = make("button", "", "Go to " + hms(t));
      go.addEventListener("click", () => {
        this.map.closePopup();
        this.seek(t);
      });
      box.append(go);
    }
    L.popup({ minWidth: 230, maxWidth: 320, autoPan: true }).setLatLng(at).setContent(box).openOn(this.map);
  }

  /** @param {any} e @param {number} t @param {string} key */
  tellTrack(e, t, key) {
    const { dive } = this.current();
    const nav = dive.navigation.at(t);
    const who = key === "plan" ? "the front seat's plan" : key.replace(/^plugin:/, "plugin ");
    this.tell(e.latlng, "Track at " + hms(t), [["steered by", who], ["depth", num(nav?.depth_m, 1, "m")], ["speed", num(nav?.speed_mps, 2, "m/s")]], t);
  }

  tellVehicle() {
    const { state } = this.current();
    const nav = state.navigation;
    if (!nav) return;
    this.tell([nav.lat, nav.lon], "Vehicle at " + hms(state.t), [["steers", state.who?.label ?? "–"], ["heading", heading(nav.heading_deg)],
      ["depth", num(nav.depth_m, 1, "m")], ["speed", num(nav.speed_mps, 2, "m/s")], ["position", `${latitude(nav.lat)} ${longitude(nav.lon)}`]]);
  }
}

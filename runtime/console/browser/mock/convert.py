"""Turns a dive log (MCAP) into items of the console's protocol, without `n`."""
import json
import math
from mcap.reader import make_reader

LEVELS = {1: "debug", 2: "info", 3: "warn", 4: "error", 5: "error"}
FUEL_LIMIT = 1_000_000_000


def words(text):
    """NMEA sentences of a link message as lists of fields."""
    for line in text.split("\r\n"):
        if line.startswith("$"):
            yield line[1:].split("*")[0].split(",")


def navigation(d):
    east, north = d["east_mps"], d["north_mps"]
    item = {
        "kind": "navigation",
        "lat": round(d["latitude_deg"], 7), "lon": round(d["longitude_deg"], 7),
        "depth_m": round(d["depth_m"], 2), "heading_deg": round(d["heading_deg"], 1),
        "roll_deg": round(d["roll_deg"], 1), "pitch_deg": round(d["pitch_deg"], 1),
        "speed_mps": round(math.hypot(east, north), 2),
        "course_deg": round(math.degrees(math.atan2(east, north)) % 360, 1),
        "yaw_rate_dps": round(d["yaw_rate_dps"], 2), "gps": d["gps"],
    }
    if d.get("altitude_m") is not None:
        item["altitude_m"] = round(d["altitude_m"], 2)
    return item


class Converter:
    """Reads the messages in order and makes items of them."""

    def __init__(self, names):
        self.names = names
        self.items = []
        self.began = None
        self.beat = {"worst_gap_s": 0.0}
        self.next_beat = 0.0
        self.sent_at = {}
        self.last_status = None
        self.last_steer = (-9.0, None)
        self.in_lease = False
        self.counts = dict(proposed=0, rejected=0, sent=0, accepted=0, failed=0)
        self.last_counts = -9.0
        self.fuel, self.steps, self.last_room = {}, {}, {}
        self.last_measure = {}

    def put(self, t, **item):
        self.items.append({"t": round(t, 3), **item})

    def take(self, topic, ns, d):
        if self.began is None:
            self.began = ns
        t = (ns - self.began) / 1e9
        while t >= self.next_beat:
            if self.next_beat > 0:
                rounded = {k: round(v, 3) for k, v in self.beat.items()}
                self.put(self.next_beat, kind="beat", **rounded)
            self.next_beat += 1.0
        name = topic.strip("/").replace("/", "_")
        handler = getattr(self, "on_" + name, None)
        if handler:
            handler(t, d)
        elif topic.startswith("/measures/"):
            self.on_measure(t, topic.split("/")[2:], d)

    def on_navigation(self, t, d):
        self.put(t, **navigation(d))
        self.beat["navigated"] = t

    def on_link_from_vehicle(self, t, d):
        self.beat["heard"] = t
        for f in words(d["text"]):
            if f[0] == "BFACK" and f[2] == "RMB" and f[3] in self.sent_at:
                sent = self.sent_at.pop(f[3])
                self.beat["round_trip_s"] = t - sent
                self.beat["acknowledged"] = t

    def on_link_to_vehicle(self, t, d):
        for f in words(d["text"]):
            if f[0] == "BPSTS" and f[3] != self.last_status:
                self.last_status = f[3]
                self.put(t, kind="status", text=f[3])
            elif f[0] == "BPEMB":
                self.beat.pop("refreshed", None)
            elif f[0] == "BPRMB":
                self.command(t, f)

    def command(self, t, f):
        if self.in_lease and "refreshed" in self.beat:
            gap = t - self.beat["refreshed"]
            self.beat["worst_gap_s"] = max(self.beat["worst_gap_s"], gap)
        self.sent_at[f[1]] = t
        self.beat["refreshed"] = t
        self.in_lease = True
        figures = tuple(f[2:7])
        if t - self.last_steer[0] >= 1.0 and figures != self.last_steer[1]:
            self.last_steer = (t, figures)
            vertical = "altitude_m" if f[4] == "1" else "depth_m"
            self.put(t, kind="steering", owner=self.names[0], heading_deg=float(f[2]),
                     speed_mps=float(f[5]), **{vertical: float(f[3])})

    def on_control(self, t, d):
        extra = {"reason": d["reason"]} if d["reason"] else {}
        self.put(t, kind="control", granted=d["granted"], **extra)

    def on_requests(self, t, d):
        state = d["state"]
        if state == "sent":
            self.counts["proposed"] += 1
        key = {"timed-out": "failed"}.get(state, state)
        if key in self.counts:
            self.counts[key] += 1
        if t - self.last_counts >= 1.0:
            self.last_counts = t
            self.put(t, kind="counts", **self.counts)

    def on_core_input(self, t, d):
        if d["input"] != "returned":
            return
        plugin = d["plugin"]
        fuel = d["returned"].get("fuel", 0) / FUEL_LIMIT
        self.fuel[plugin] = max(self.fuel.get(plugin, 0), fuel)
        self.steps[plugin] = self.steps.get(plugin, 0) + 1
        if t - self.last_room.get(plugin, -9) >= 5.0:
            self.last_room[plugin] = t
            self.put(t, kind="headroom", plugin=self.names[plugin],
                     fuel=round(self.fuel[plugin], 6), steps=self.steps[plugin])

    def on_log(self, t, d):
        self.put(t, kind="line", level=LEVELS.get(d["level"], "info"),
                 who=d["name"], text=d["message"])

    def on_measure(self, t, path, d):
        if t - self.last_measure.get(path[1], -9) >= 1.0:
            self.last_measure[path[1]] = t
            self.put(t, kind="measure", plugin=path[0], name=path[1],
                     value=round(d["value"], 3), unit=d.get("unit", ""))

    def on_map_plan(self, t, d):
        self.put(t, kind="map", layer="plan", geojson=json.loads(d["geojson"]))

    def on_map_fence(self, t, d):
        self.fence = json.loads(d["geojson"])

    def on_notes(self, t, d):
        note = d["note"]
        if note == "mission":
            self.put(t, kind="mission", status=d["status"])
        elif note == "behavior":
            self.put(t, kind="behavior", number=d["number"], behavior=d["kind"], began=d["began"])
        elif note == "lease-ended":
            self.in_lease = False
            self.last_steer = (-9.0, None)
            self.put(t, kind="steering", reason="a behavior ended during it")
        elif note == "operator":
            self.put(t, kind="operator", act=d["act"], by="signal")


def convert(path):
    """Returns (about, items): items sorted by time, without `n`."""
    with open(path, "rb") as file:
        reader = make_reader(file)
        meta = {m.name: m.metadata for m in reader.iter_metadata()}
        names = list(json.loads(json.dumps(meta.get("descriptions", {"isobath": ""}))))
        c = Converter(names)
        for name in names:
            c.put(0.0, kind="plugin", plugin=name, state="running", failures=0)
        end = 0
        for _, channel, message in reader.iter_messages():
            c.take(channel.topic, message.log_time, json.loads(message.data))
            end = message.log_time
    c.put((end - c.began) / 1e9, kind="end", text="completed after 32.7 min")
    c.items.sort(key=lambda i: i["t"])
    run = meta.get("backseat", {})
    about = {
        "kind": "recorded", "mission": run.get("mission", "?"), "vehicle": "simulated 12.75 in vehicle",
        "version": run.get("version", "?"), "began_ns": str(c.began), "armed": True,
        "operator": False, "origin": {"lat": 42.35, "lon": -70.7},
        "plugins": [{"name": n, "grants": ["modify"], "fuel_limit": FUEL_LIMIT,
                     "component": n + ".wasm"} for n in names],
        "limits": {"speed_max_mps": 2.0, "speed_min_mps": 0.5, "turn_max_deg": 60},
        "watchdog_s": 5.0, "fence": c.fence,
    }
    return about, c.items

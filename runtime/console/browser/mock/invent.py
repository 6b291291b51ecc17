"""Invented items, so that every panel of the page has something to show."""
import math

PLUGIN = "hotspot"


def circle(lat, lon, radius, **props):
    ring = []
    for k in range(25):
        a = 2 * math.pi * k / 24
        ring.append([lon + radius * math.sin(a) / (111320 * math.cos(math.radians(lat))),
                     lat + radius * math.cos(a) / 111320])
    return {"type": "Feature", "properties": props,
            "geometry": {"type": "LineString", "coordinates": ring}}


def line(a, b, **props):
    return {"type": "Feature", "properties": props,
            "geometry": {"type": "LineString", "coordinates": [a, b]}}


def inserts(*states):
    """The layer of inserts, with the state of each of the six."""
    shapes = [
        lambda **p: circle(42.3515, -70.7120, 60, **p),
        lambda **p: line([-70.7080, 42.3530], [-70.7030, 42.3545], **p),
        lambda **p: line([-70.7010, 42.3470], [-70.6990, 42.3450], **p),
        lambda **p: circle(42.3560, -70.6960, 45, **p),
        lambda **p: line([-70.6900, 42.3550], [-70.6860, 42.3565], **p),
        lambda **p: circle(42.3480, -70.6870, 40, **p),
    ]
    kinds = ["trackcircle", "trackline", "trackline", "trackcircle", "trackline", "station"]
    features = [make(kind=kinds[k], state=state, plugin=PLUGIN, tag=k + 1, identifier=900 + k)
                for k, (make, state) in enumerate(zip(shapes, states)) if state]
    return {"kind": "map", "layer": "inserts",
            "geojson": {"type": "FeatureCollection", "features": features}}


def request(number, kind, state, tag, **more):
    return {"kind": "request", "request": 9000 + number, "owner": more.pop("owner", PLUGIN),
            "request_kind": kind, "state": state, "tag": tag, **more}


def plugin(state, failures, text=None):
    item = {"kind": "plugin", "plugin": PLUGIN, "state": state, "failures": failures}
    if text:
        item["text"] = text
    return item


def say(level, who, text):
    return {"kind": "line", "level": level, "who": who, "text": text}


REFUSED_LINE = "passes 14.2 m inside the margin (30 m) of keep-out zone wreck at leg 2 of 5"
SCRIPT = [
    (0.05, plugin("running", 0)),
    (20, say("info", "plugin hotspot", "looking for chlorophyll above 4.0 ug/l")),
    (118, say("info", "plugin hotspot", "hot spot 60 m ahead: 5.1 ug/l, asking for a circle")),
    (120, request(1, "trackcircle", "sent", 1)), (120.4, request(1, "trackcircle", "pending", 1)),
    (121, request(1, "trackcircle", "accepted", 1, identifier=900)),
    (121.1, inserts("accepted")),
    (300, {"kind": "steering", "reason": "an insert began"}),
    (300.1, request(1, "trackcircle", "started", 1, identifier=900)), (300.2, inserts("started")),
    (420, request(1, "trackcircle", "ended", 1, identifier=900)),
    (420.1, inserts("ended", "accepted")),
    (410, request(2, "trackline", "sent", 2)), (411, request(2, "trackline", "accepted", 2, identifier=901)),
    (500, request(3, "modify", "rejected", 3, reason="speed 2.60 m/s is 0.60 m/s above the limit of 2.00 m/s")),
    (500.02, say("warn", "plugin hotspot", "Modify 9003 (hotspot, tag 3) rejected: speed 2.60 m/s is 0.60 m/s above the limit of 2.00 m/s")),
    (560, request(4, "trackline", "rejected", 4, reason=REFUSED_LINE)),
    (560.1, {"kind": "map", "layer": "requests", "geojson": {"type": "FeatureCollection", "features": [
        line([-70.6960, 42.3420], [-70.6890, 42.3405], kind="trackline", state="rejected", plugin=PLUGIN, reason=REFUSED_LINE)]}}),
    (620, request(5, "trackline", "sent", 5)), (622, request(5, "trackline", "failed", 5, reason="the vehicle answered 4: no such depth")),
    (622.1, inserts("ended", "accepted", "failed")),
    (640, plugin("failed", 1, "ran out of fuel in step 1280 after 1000000000 instructions")),
    (640.5, plugin("restarting", 1)), (645, plugin("running", 1)),
    (645.1, say("warn", "runtime", "plugin hotspot started again after its failure; it has lost its memory")),
    (700, say("debug", "plugin hotspot", "<img src=x onerror=\"document.title='broken'\"> <b>not bold</b>")),
    (705, say("info", "plugin hotspot", "W" * 600)),
    (760, {"kind": "integrity", "ok": False, "text": "position jumped 84 m in 1.0 s at 1.5 m/s"}),
    (760.1, {"kind": "control", "granted": False, "reason": "navigation is implausible"}),
    (760.15, {"kind": "steering", "reason": "navigation is implausible"}),
    (760.2, {"kind": "status", "text": "navigation is implausible"}),
    (790, {"kind": "integrity", "ok": True, "text": "navigation is steady again for 30 s"}),
    (790.1, {"kind": "control", "granted": True}), (790.2, {"kind": "status", "text": "steering"}),
    (850, request(6, "trackcircle", "sent", 6)), (880, request(6, "trackcircle", "timed-out", 6, reason="no answer within 30 s")),
    (880.1, inserts("ended", "accepted", "failed", "timed-out")),
    (900, plugin("failed", 2, "trap: index out of bounds in step 410")), (900.5, plugin("restarting", 2)), (910, plugin("running", 2)),
    (1000, {"kind": "sonar", "name": "sidescan", "text": "no answer from the sonar for 10 s", "ok": False}),
    (1040, {"kind": "sonar", "name": "sidescan", "text": "pinging at 900 kHz, 50 m range", "ok": True}),
    (30, {"kind": "sonar", "name": "sidescan", "text": "pinging at 900 kHz, 50 m range", "ok": True}),
    (1100, request(7, "gps-hit", "sent", 7)), (1101, request(7, "gps-hit", "accepted", 7, identifier=904)),
    (1101.1, inserts("ended", "accepted", "failed", "timed-out", "unknown")),
    (1102, request(7, "gps-hit", "unknown", 7, identifier=904, reason="the vehicle restarted its plan")),
    (1200, request(8, "station", "sent", 8)), (1201, request(8, "station", "cancelled", 8, reason="the plugin withdrew it")),
    (1201.1, inserts("ended", "accepted", "failed", "timed-out", "unknown", "cancelled")),
    (1300, request(9, "surface", "rejected", 9, reason="the grant 'surface' is not given to hotspot")),
    (1500, plugin("failed", 3, "trap: unreachable in step 220")), (1500.2, plugin("quarantined", 3, "failed 3 times; it is not started again")),
    (350, {"kind": "contact", "plugin": PLUGIN, "name": "1", "lat": 42.3515, "lon": -70.7120, "text": "contact 1: 1.2 m high at 42.3515 -70.7120"}),
    (700.5, {"kind": "contact", "plugin": PLUGIN, "name": "1", "lat": 42.3516, "lon": -70.7121, "text": "contact 1 confirmed at 42.3516 -70.7121 by 8 of 8 aspects"}),
    (720, {"kind": "contact", "plugin": PLUGIN, "name": "2", "lat": 42.3470, "lon": -70.7010, "text": "contact 2: 0.7 m high at 42.3470 -70.7010"}),
    (721, {"kind": "contact", "plugin": PLUGIN, "name": "3", "lat": 142.0, "lon": -70.7010, "text": "contact 3 of nowhere"}),
    (1600, {"kind": "recording", "written": False, "text": "the log ends here, the run continues: No space left on device"}),
    (60, {"kind": "future-kind", "anything": [1, 2]}),
]
SILENT = [(300, 420), (760, 790)]  # isobath does not steer then


def silent(t):
    return any(a <= t < b for a, b in SILENT)


def mend(item):
    """An item of the log made to agree with the invented ones, or None."""
    t, kind = item["t"], item["kind"]
    if kind == "steering" and silent(t):
        return None
    if kind == "beat" and silent(t - 0.5):
        return {k: v for k, v in item.items() if k != "refreshed"}
    return item


def side(t, sign):
    """A side of a ping: a seabed with ripples that fades, dark water before it, and a bright target now and then."""
    water = 22 + 4 * math.sin(t / 60)
    values = []
    for k in range(128):
        value = 8 if k < water else 150 - 0.6 * k + 14 * math.sin(k / 4 + t / 9 * sign)
        if int(t) % 97 < 4 and 60 <= k < 64:
            value += 60
        values.append(max(0, min(255, round(value))))
    return bytes(values).hex()


def each_second(items, simulated):
    last = -9
    for item in items:
        if item["kind"] != "navigation" or item["t"] - last < 1.0:
            continue
        last = t = item["t"]
        z = item["depth_m"]
        yield {"t": t, "kind": "sensor", "name": "BFCTD", "data": {
            "temperature_c": round(14.2 - z * 0.35 + 0.1 * math.sin(t / 40), 3),
            "conductivity_s_m": round(3.82 - z * 0.02, 4), "salinity_psu": round(31.4 + z * 0.03, 3),
            "sound_mps": round(1498.3 - z * 0.9, 2), "state": "ok"}}
        if t > 20 and t < 1500:
            yield {"t": t, "kind": "measure", "plugin": PLUGIN, "name": "chlorophyll", "unit": "ug/l",
                   "value": round(2.5 + 2 * math.sin(t / 90) + 0.4 * math.sin(t / 7), 3)}
        if simulated:
            yield {"t": t, "kind": "truth", "lat": round(item["lat"] + 0.00003 * min(1, t / 900), 7),
                   "lon": round(item["lon"] + 0.00004 * min(1, t / 900), 7), "depth_m": z,
                   "water_depth_m": round(z + item.get("altitude_m", 0) + 0.2, 2)}
        if 100 < t < 1600:
            yield {"t": t, "kind": "ping", "sensor": 0, "port": side(t, -1), "starboard": side(t, 1), "range_m": 60.0}
            if int(t) % 2 == 0:
                yield {"t": t, "kind": "swath", "lat": item["lat"], "lon": item["lon"], "heading_deg": item["heading_deg"],
                       "port_m": 52.5, "starboard_m": 50.0}
        if int(t) % 5 == 0 and t < 1500:
            yield {"t": t, "kind": "headroom", "plugin": PLUGIN, "fuel": 0.62 if t < 640 else 1.0, "steps": int(t * 2)}


ZONES = [
    {"type": "Feature", "properties": {"name": "cable area", "kind": "keep-out", "margin_m": 15,
                                       "from": "2026-06-01T08:00:00Z", "until": "2026-06-01T08:20:00Z"},
     "geometry": {"type": "Polygon", "coordinates": [[[-70.7190, 42.3580], [-70.7130, 42.3600], [-70.7120, 42.3590], [-70.7180, 42.3570], [-70.7190, 42.3580]]]}},
    {"type": "Feature", "properties": {"name": "mooring", "kind": "no-go-depth", "margin_m": 10, "depth_min_m": 12, "depth_max_m": 40},
     "geometry": {"type": "Polygon", "coordinates": [[[-70.6820, 42.3450], [-70.6790, 42.3450], [-70.6790, 42.3475], [-70.6820, 42.3475], [-70.6820, 42.3450]]]}},
]


def embellish(about, items, simulated=False):
    """The log's items together with the invented ones."""
    about = dict(about)
    about["plugins"] = about["plugins"] + [{"name": PLUGIN, "grants": ["modify", "insert"],
                                            "fuel_limit": 1_000_000_000, "component": "hotspot.wasm"}]
    about["fence"] = {"type": "FeatureCollection", "features": about["fence"]["features"] + ZONES}
    out = [m for m in map(mend, items) if m]
    out += [{"t": t, **item} for t, item in SCRIPT]
    out += list(each_second(items, simulated))
    out.sort(key=lambda i: i["t"])
    return about, out


def lengthen(items, hours):
    """The same dive again and again, for a dive of many hours."""
    end = items[-1]["t"] + 1
    out, lap = [], 0
    while lap * end < hours * 3600:
        for item in items:
            if item["kind"] == "end":
                continue
            new = {**item, "t": round(item["t"] + lap * end, 3)}
            if item["kind"] in ("navigation", "truth"):
                new["lat"] = round(item["lat"] + lap * 0.0004, 7)
            for key in ("refreshed", "acknowledged", "heard", "navigated"):
                if item["kind"] == "beat" and key in item:
                    new[key] = round(item[key] + lap * end, 3)
            out.append(new)
        lap += 1
    return out

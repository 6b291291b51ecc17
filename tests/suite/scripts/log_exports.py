"""Opens what `backseat log export` writes with readers that others wrote, and compares every figure.

    cargo run -p backseat-log-export --example dive -- FOLDER [LOG]
    python3 log_exports.py FOLDER

Needs mcap, pandas, pyarrow, shapely, fastkml, xarray, scipy and compliance-checker; `cargo xtask exports` installs them and runs both. What is expected
comes from the log itself, read by the package mcap, and shares nothing with this project's crates.
"""

import base64
import csv
import datetime
import json
import math
import os
import re
import sys
import tempfile
from pathlib import Path

import fastkml
import numpy
import pandas
import pyarrow
import pyarrow.parquet
import shapely
import shapely.geometry
import xarray
from mcap.reader import make_reader

EVERY_S = 10
GX = "{http://www.google.com/kml/ext/2.2}"
KML = "{http://www.opengis.net/kml/2.2}"
NUMBERS = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


def check(condition, *what):
    if not condition:
        sys.exit("differs: " + ", ".join(str(part)[:300] for part in what))


def equal(a, b):
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b))


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class Log:
    """The log's messages by topic, each with its time in nanoseconds."""

    def __init__(self, path):
        self.channels = {}
        self.order = []
        with open(path, "rb") as file:
            reader = make_reader(file)
            self.run = next(record.metadata for record in reader.iter_metadata() if record.name == "backseat")
            self.start = int(self.run["utc_at_start_ns"])
            attached = {record.name: record.data for record in reader.iter_attachments()}
            self.fence = json.loads(attached["fence.geojson"])
            for channel in reader.get_summary().channels.values():
                self.channels[channel.topic] = []
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                if channel.message_encoding == "json":
                    value = json.loads(message.data)
                else:
                    try:
                        value = {"text": message.data.decode()}
                    except UnicodeDecodeError:
                        value = {"base64": base64.b64encode(message.data).decode()}
                self.channels[channel.topic].append((message.log_time, value))
                self.order.append((channel.topic, value))

    def seconds(self, time):
        return (time - self.start) / 1e9

    def layer(self, name):
        """The GeoJSON of a layer's messages."""
        return [(time, json.loads(value["geojson"])) for time, value in self.channels.get(f"/map/{name}", [])]


def flat(value, path=""):
    """A message's values by their paths. Arrays are left whole."""
    for name, member in value.items():
        name = f"{path}.{name}" if path else name
        if isinstance(member, dict):
            yield from flat(member, name)
        elif member is not None:
            yield name, member


def expected_rows(messages, columns):
    """For each message what the columns of its table must hold: values of any type, where arrays of numbers are apart."""
    for time, value in messages:
        row = {}
        for name, member in flat(value):
            if isinstance(member, list) and name not in columns:
                row |= {f"{name}.{number}": element for number, element in enumerate(member)}
            else:
                row[name] = member
        # A table has two columns of these names already.
        for name in ("time", "t_s"):
            if name in row:
                row[f"message.{name}"] = row.pop(name)
        check(set(row) <= set(columns), "columns are missing", set(row) - set(columns))
        yield time, row


def same_value(found, value, kind):
    """Whether a cell of a type has the value of a message."""
    if kind == "string":
        if isinstance(value, str):
            return found == value
        return json.loads(found) == value
    if kind == "number":
        return equal(float(found), float(NUMBERS.get(value, value)))
    return type(found) is type(value) and found == value


def tables(log, folder):
    index = json.loads((folder / "csv" / "tables.json").read_text())
    other = json.loads((folder / "parquet" / "tables.json").read_text())
    check({table["topic"] for table in index["tables"]} == set(log.channels), "topics")
    check(index["complete"] is True and index["run"] == log.run, "index", index["run"])
    rows = cells = 0
    for table, twin in zip(index["tables"], other["tables"]):
        where, messages = table["topic"], log.channels[table["topic"]]
        check(table["columns"] == twin["columns"] and table["rows"] == len(messages), where, "index")
        kinds = {column["name"]: column["type"] for column in table["columns"]}
        arrow = pyarrow.parquet.read_table(folder / "parquet" / twin["file"])
        check(arrow.column_names == list(kinds), where, "columns of parquet", arrow.column_names)
        check(arrow.schema.field("time").type == pyarrow.timestamp("ns", "UTC"), where, arrow.schema.field("time").type)
        types = {"string": "string", "number": "double", "integer": "int64", "boolean": "bool"}
        for name, kind in list(kinds.items())[1:]:
            check(str(arrow.schema.field(name).type) == types[kind], where, name, arrow.schema.field(name).type)
        columns = {name: arrow[name].to_pylist() for name in list(kinds)[1:]}
        times = arrow["time"].cast(pyarrow.int64()).to_pylist()
        with open(folder / "csv" / table["file"], newline="", encoding="utf-8") as file:
            lines = list(csv.reader(file))
        check(lines[0] == list(kinds), where, "columns of csv", lines[0])
        check(len(lines) - 1 == len(messages) == arrow.num_rows, where, "rows", len(lines), len(messages), arrow.num_rows)
        for number, ((time, row), line) in enumerate(zip(expected_rows(messages, list(kinds)[2:]), lines[1:])):
            check(times[number] == time, where, number, "time of parquet", times[number], time)
            check(pandas.Timestamp(line[0]).value == time and line[0].endswith("Z"), where, number, "time of csv", line[0])
            seconds = log.seconds(time)
            check(columns["t_s"][number] == seconds == float(line[1]), where, number, "t_s", line[1], seconds)
            for (name, kind), text in zip(list(kinds.items())[2:], line[2:]):
                found = columns[name][number]
                if name not in row:
                    check(found is None and text == "", where, number, name, found, text)
                    continue
                value = row[name]
                cells += 1
                check(same_value(found, value, kind), where, number, name, found, value)
                read = {"boolean": lambda: {"true": True, "false": False}[text], "integer": lambda: int(text)}
                check(same_value(read.get(kind, lambda: text)(), value, kind), where, number, name, text, value)
        rows += len(messages)
        # As users open it.
        frame = pandas.read_csv(folder / "csv" / table["file"], parse_dates=["time"], low_memory=False)
        check(len(frame) == len(messages), where, "pandas", len(frame))
        if len(frame):
            check(str(frame["time"].dtype).startswith("datetime64[") and frame["time"].dt.tz is not None, where, frame["time"].dtype)
    return f"{len(index['tables'])} tables, {rows} rows, {cells} cells in both forms"


def fixes(log, topic):
    """The positions of a track: time, longitude, latitude, depth, and what navigation or truth say beside them."""
    if topic == "/navigation" and log.channels.get("/position"):
        described = dict(log.channels[topic])
        for time, value in log.channels["/position"]:
            yield time, value["longitude"], value["latitude"], -value["altitude"], described[time]
        return
    for time, value in log.channels.get(topic, []):
        place = value.get("position", value)
        yield time, place["longitude_deg"], place["latitude_deg"], value["depth_m"], value


def gaps(log):
    return [time for time, value in log.channels["/core/input"] if value["input"] == "gap"]


def parts(log, topic):
    """A track's positions, apart at gaps."""
    out, ends = [[]], gaps(log)
    for fix in fixes(log, topic):
        if any(end <= fix[0] for end in ends):
            ends = [end for end in ends if end > fix[0]]
            out.append([])
        out[-1].append(fix)
    return [part for part in out if part]


def points(log, topic):
    """The first position of each period."""
    period = None
    for fix in fixes(log, topic):
        now = math.floor(log.seconds(fix[0]) / EVERY_S)
        if period is None or now > period:
            period = now
            yield fix


def rfc3339(time):
    seconds, nanos = divmod(time, 10**9)
    moment = datetime.datetime.fromtimestamp(seconds, datetime.UTC)
    return f"{moment:%Y-%m-%dT%H:%M:%S}.{nanos:09}Z"


def changing(log, name, key):
    """The last state of each feature of a layer, in the order in which they came."""
    states = []
    for _, layer in log.layer(name):
        taken = set()
        # A request has no number at first. What has one is looked up first.
        for feature in sorted(layer.get("features", [layer]), key=lambda feature: key not in feature["properties"]):
            told = feature["properties"]
            told.pop("style", None)
            number, shown = told.get(key), (told.get("plugin"), told.get("tag"), json.dumps(feature["geometry"]))
            free = [(place, *states[place][:2]) for place in reversed(range(len(states))) if place not in taken]
            same = [place for place, old, _ in free if number is not None and old == number]
            same += [place for place, old, old_shown in free if None in (number, old) and old_shown == shown]
            if not same:
                states.append(None)
            place = same[0] if same else len(states) - 1
            taken.add(place)
            states[place] = (number, shown, feature)
    return [feature for _, _, feature in states]


def standing(log, name):
    """Every feature that a layer had, with whether it stood at the end."""
    known = []
    for _, layer in log.layer(name):
        new = list(layer.get("features", [layer]))
        for feature in new:
            feature["properties"].pop("style", None)
        for entry in known:
            if entry[1]:
                entry[1] = entry[0] in new
                if entry[1]:
                    new.remove(entry[0])
        known += [[feature, True] for feature in new]
    return known


def refused(log):
    """Requests whose last state is a refusal, and that have no geometry of their own."""
    last, place, last_fix = {}, {}, None
    has_position = bool(log.channels.get("/position"))
    for topic, value in log.order:
        if topic == "/position":
            last_fix = (value["longitude"], value["latitude"])
        elif topic == "/navigation" and not has_position:
            last_fix = (value["longitude_deg"], value["latitude_deg"])
        elif topic == "/requests":
            last[value["request"]], place[value["request"]] = value, last_fix
    drawn = {feature["properties"].get("request") for feature in changing(log, "requests", "request")}
    states = ("rejected", "failed", "timed-out")
    return {n: place[n] for n, value in last.items() if value["state"] in states and n not in drawn and place[n]}


def geojson(log, path):
    document = json.loads(path.read_text())
    check(document["type"] == "FeatureCollection" and document["name"] == log.run["mission"], path, "document")
    layers = {}
    for feature in document["features"]:
        shape = shapely.geometry.shape(feature["geometry"])
        check(shape.is_valid and not shape.is_empty, path, shape)
        layers.setdefault(feature["properties"]["layer"], []).append((feature, shape))
    figures = 0
    for layer, topic in (("track", "/navigation"), ("truth", "/truth")):
        found = layers.pop(layer, [])
        lines = [shape for _, shape in found if shape.geom_type == "LineString"]
        expected = [part for part in parts(log, topic) if len(part) > 1]
        check(len(lines) == len(expected), path, layer, "lines", len(lines), len(expected))
        for line, part in zip(lines, expected):
            coordinates = [(longitude, latitude, -depth) for _, longitude, latitude, depth, _ in part]
            check(line.has_z and list(line.coords) == coordinates, path, layer, "coordinates")
            figures += 3 * len(coordinates)
        dots = [(feature, shape) for feature, shape in found if shape.geom_type == "Point"]
        expected = list(points(log, topic))
        check(len(dots) == len(expected), path, layer, "points", len(dots), len(expected))
        for (feature, shape), (time, longitude, latitude, depth, value) in zip(dots, expected):
            check((shape.x, shape.y, shape.z) == (longitude, latitude, -depth), path, layer, shape)
            told = feature["properties"]
            check(told["time"] == rfc3339(time) and told["t_s"] == log.seconds(time), path, layer, told)
            for name, member in flat(value):
                if not name.endswith(("latitude_deg", "longitude_deg")):
                    check(told[name] == member, path, layer, name, told[name], member)
                    figures += 1
    fence = [layer for _, layer in log.layer("fence")][:1] or [log.fence]
    check(len(layers["fence"]) == len(fence[0]["features"]), path, "zones")
    for (found, shape), zone in zip(layers.pop("fence"), fence[0]["features"]):
        check(shape.equals(shapely.geometry.shape(zone["geometry"])), path, "zone", shape)
        check(zone["properties"].items() <= found["properties"].items(), path, "zone", found["properties"])
        figures += 2 * len(shapely.get_coordinates(shape))
    for layer, expected in (("plan", standing(log, "plan")), ("inserts", changing(log, "inserts", "identifier"))):
        found = layers.pop(layer, [])
        check(len(found) == len(expected), path, layer, len(found), len(expected))
        for (feature, shape), entry in zip(found, expected):
            entry, stands = entry if layer == "plan" else (entry, True)
            check(shape.equals(shapely.geometry.shape(entry["geometry"])), path, layer, shape)
            check((entry["properties"] or {}).items() <= feature["properties"].items(), path, layer, feature["properties"])
            check(stands == ("until" not in feature["properties"]), path, layer, "until", feature["properties"])
            figures += 2 * len(shapely.get_coordinates(shape))
    found = layers.pop("requests", [])
    own, others = changing(log, "requests", "request"), refused(log)
    check(len(found) == len(own) + len(others), path, "requests", len(found), len(own), len(others))
    for (feature, shape), entry in zip(found, own):
        check(shape.equals(shapely.geometry.shape(entry["geometry"])), path, "request", shape)
        check(entry["properties"].items() <= feature["properties"].items(), path, "request", feature["properties"])
    for feature, shape in found[len(own) :]:
        check((shape.x, shape.y) == others[feature["properties"]["request"]], path, "refused", feature["properties"])
        check(feature["properties"].get("reason"), path, "reason", feature["properties"])
    check(not layers, path, "other layers", list(layers))
    return f"{len(document['features'])} features, {figures} figures"


def kml(log, path):
    text = path.read_text()
    document = next(iter(fastkml.KML.parse(path, strict=False, validate=False).features))
    check(document.name.startswith(log.run["mission"]), path, "name", document.name)
    folders = {folder.name: list(folder.features) for folder in document.features}
    figures = placemarks = 0
    tracks = [(folder, part) for folder, topic in (("Track", "/navigation"), ("True track", "/truth")) for part in parts(log, topic)]
    # fastkml reads the tracks too, but leaves out decimals of seconds.
    from lxml import etree

    found = etree.fromstring(text.encode()).iter(f"{GX}Track")
    for (folder, part), track in zip(tracks, found, strict=True):
        check(track.findtext(f"{KML}altitudeMode") == "clampToGround", path, "altitude mode")
        shown, last = [], None
        for fix in part:
            second = math.floor(log.seconds(fix[0]))
            if second != last:
                shown.append(fix)
                last = second
        whens = [element.text for element in track.iter(f"{KML}when")]
        check(whens == [rfc3339(fix[0]) for fix in shown], path, folder, "times")
        coordinates = [tuple(float(number) for number in element.text.split()) for element in track.iter(f"{GX}coord")]
        check(coordinates == [(fix[1], fix[2], -fix[3]) for fix in shown], path, folder, "coordinates")
        figures += 3 * len(shown)
    for title, topic in (("Track", "/navigation"), ("True track", "/truth")):
        contents = folders.pop(title, [])
        expected = list(points(log, topic))
        dots = [mark for inner in contents if isinstance(inner, fastkml.Folder) for mark in inner.features]
        check(len(dots) == len(expected), path, title, "points", len(dots), len(expected))
        placemarks += len(contents) - 1 + len(dots) if contents else 0
        for mark, (time, longitude, latitude, depth, value) in zip(dots, expected):
            check(mark.geometry.coords[0] == (longitude, latitude, -depth), path, title, mark.geometry)
            check(abs(mark.time_stamp.dt.timestamp() - time / 1e9) < 1e-5, path, title, mark.time_stamp)
            told = {data.name: data.value for data in mark.extended_data.elements}
            for name, member in flat(value):
                if is_number(member) and not name.endswith(("latitude_deg", "longitude_deg")):
                    check(float(told[name]) == member, path, title, name, told[name], member)
                    figures += 1
    fence = ([layer for _, layer in log.layer("fence")][:1] or [log.fence])[0]["features"]
    expected = {
        "Fence": fence,
        "Plan": [feature for feature, _ in standing(log, "plan")],
        "Inserts": changing(log, "inserts", "identifier"),
        "Requests": changing(log, "requests", "request"),
    }
    for title, features in expected.items():
        marks = folders.pop(title, [])
        more = len(refused(log)) if title == "Requests" else 0
        check(len(marks) == len(features) + more, path, title, len(marks), len(features))
        placemarks += len(marks)
        for mark, feature in zip(marks, features):
            shape = shapely.geometry.shape(feature["geometry"])
            check(shapely.geometry.shape(mark.geometry).equals(shape), path, title, mark.geometry)
            figures += 2 * len(shapely.get_coordinates(shape))
            told = {data.name: data.value for data in mark.extended_data.elements}
            for name, member in (feature["properties"] or {}).items():
                same = float(told[name]) == member if is_number(member) else not isinstance(member, str) or told[name] == member
                check(same, path, title, name, told[name], member)
    check(not folders, path, "other folders", list(folders))
    return f"{placemarks} placemarks, {figures} figures"


NAMES = {
    "NAV_X": "east_m",
    "NAV_Y": "north_m",
    "NAV_LAT": "latitude_deg",
    "NAV_LONG": "longitude_deg",
    "NAV_DEPTH": "depth_m",
    "NAV_ALTITUDE": "altitude_m",
    "NAV_HEADING": "heading_deg",
}


def alog(log, path):
    lines = path.read_text().splitlines()
    check(re.fullmatch(r"%% LOG FILE: +log\.alog", lines[1]), path, lines[1])
    start = datetime.datetime.strptime(lines[2].removeprefix("%% FILE OPENED ON  "), "%a %b %d %H:%M:%S %Y")
    check(start.replace(tzinfo=datetime.UTC).timestamp() == log.start // 10**9, path, lines[2])
    check(lines[3].startswith("%% LOGSTART ") and math.isclose(float(lines[3].split()[2]), log.start / 1e9, rel_tol=1e-15), path, lines[3])
    series, last = {}, -math.inf
    for line in lines:
        if line.startswith("%"):
            continue
        time, variable, source, value = line.split(None, 3)
        check(float(time) >= last, path, "not sorted", line)
        last = float(time)
        series.setdefault(variable, []).append((last, value, source))
    figures = 0

    def compare(variable, expected):
        nonlocal figures
        found = series.pop(variable, [])
        check(len(found) == len(expected), path, variable, len(found), len(expected))
        # Those of one time may have another order.
        for (time, value, _), (moment, right) in zip(found, expected):
            check(abs(time - moment) <= 1e-6, path, variable, time, moment)
            if is_number(right):
                check(float(value) == right, path, variable, value, right)
            else:
                right = "true" if right is True else "false" if right is False else " ".join(right.split())
                check(value == right, path, variable, value, right)
            figures += 1

    navigation = [(log.seconds(time), value) for time, value in log.channels["/navigation"]]
    for variable, name in NAMES.items():
        compare(variable, [(time, value[name]) for time, value in navigation if value.get(name) is not None])
    speeds = [(time, math.sqrt(value["east_mps"] * value["east_mps"] + value["north_mps"] * value["north_mps"])) for time, value in navigation]
    compare("NAV_SPEED", speeds)
    desired = modifies(log)
    for variable in [name for name in series if name.startswith("DESIRED_")]:
        compare(variable, desired.pop(variable))
    check(not desired, path, "wishes are missing", list(desired))
    lease = series.pop("BACKSEAT_LEASE", [])
    check([value for _, value, _ in lease] == ["true", "false"] * (len(lease) // 2) + ["true"] * (len(lease) % 2), path, "lease")
    for topic, messages in log.channels.items():
        if topic.startswith(("/link/", "/core/", "/map/", "/position")):
            continue
        expected = {}
        for time, value in messages:
            for name, member in flat(value):
                own = topic == "/navigation" and name in NAMES.values()
                if not own and not isinstance(member, list) and member != "" and not name.startswith("timestamp."):
                    variable = re.sub("[^A-Z0-9]", "_", f"BACKSEAT{topic}.{name}".upper())
                    expected.setdefault(variable, []).append((log.seconds(time), member))
        for variable, values in expected.items():
            compare(variable, sorted(values, key=lambda entry: entry[0]))
    check(not series, path, "other variables", list(series))
    return f"{figures} figures"


def modifies(log):
    """What the BPRMB asked for: heading, depth or altitude, speed."""
    out, stream = {}, ""
    for time, value in log.channels["/link/to_vehicle"]:
        data = value["text"] if "text" in value else base64.b64decode(value["base64"]).decode("latin-1")
        stream += data
        *lines, stream = stream.split("\n")
        for line in lines:
            fields = line.strip().split("*")[0].split(",")
            if fields[0] != "$BPRMB":
                continue
            horizontal, vertical, mode, speed, unit, way = fields[2:8]
            names = (
                (horizontal, {"0": "DESIRED_HEADING", "1": "DESIRED_RUDDER"}.get(way)),
                (vertical, {"0": "DESIRED_DEPTH", "1": "DESIRED_ALTITUDE", "2": "DESIRED_PITCH", "3": "DESIRED_ELEVATOR"}.get(mode)),
                (speed, {"0": "DESIRED_RPM", "1": "DESIRED_SPEED"}.get(unit)),
            )
            for text, name in names:
                if text and name:
                    out.setdefault(name, []).append((log.seconds(time), float(text)))
    return out


# What each variable of NetCDF has: channel, property, the log's unit in the file's.
SERIES = {
    "altitude": ("/navigation", "altitude_m", 1),
    "heading": ("/navigation", "heading_deg", 1),
    "pitch": ("/navigation", "pitch_deg", 1),
    "roll": ("/navigation", "roll_deg", 1),
    "yaw_rate": ("/navigation", "yaw_rate_dps", 1),
    "platform_eastward_velocity": ("/navigation", "east_mps", 1),
    "platform_northward_velocity": ("/navigation", "north_mps", 1),
    "platform_downward_velocity": ("/navigation", "down_mps", 1),
    "pressure": ("/sensors/BFCTD", "pressure_kpa", 10),
    "temperature": ("/sensors/BFCTD", "temperature_c", 1),
    "conductivity": ("/sensors/BFCTD", "conductivity_us_per_cm", 10_000),
    "sound_speed": ("/sensors/BFSVS", "sound_velocity_mps", 1),
    "speed_through_water": ("/sensors/BFRVL", "water_speed_mps", 1),
    "thruster_speed": ("/sensors/BFRVL", "thruster_rpm", 1),
    "true_latitude": ("/truth", "position.latitude_deg", 1),
    "true_longitude": ("/truth", "position.longitude_deg", 1),
    "true_depth": ("/truth", "depth_m", 1),
    "water_depth": ("/truth", "water_depth_m", 1),
}
NO_NUMBERS = {"trajectory", "platform", "instrument_ctd", "crs"}
STEERING = ["nobody", "plan", "modify", "insert"]


def nearest(log, times, topic, name):
    """For each row the last measurement of those that have no nearer row, if it is within a second of the row."""
    column = numpy.full(len(times), numpy.nan)
    for time, value in log.channels.get(topic, []):
        value = dict(flat(value)).get(name)
        value = NUMBERS.get(value, value)
        at = log.start / 1e9 + log.seconds(time)
        apart = numpy.abs(times - at)
        # Of two rows as near as each other it is the later one.
        row = len(times) - 1 - int(numpy.argmin(apart[::-1]))
        if value is not None and math.isfinite(value) and apart[row] <= 1:
            column[row] = value
    return column


def states(log, times, topic, state, before):
    """For each row the last state until then."""
    changes = sorted((log.start / 1e9 + log.seconds(time), number) for number, (time, _) in enumerate(log.channels.get(topic, [])))
    found = numpy.searchsorted([time for time, _ in changes], times, side="right")
    return [state(log.channels[topic][changes[place - 1][1]][1]) if place else before for place in found]


def netcdf(log, path):
    with xarray.open_dataset(path, engine="scipy", mask_and_scale=True, decode_times=False) as file:
        data = file.load()
    check(data.attrs["featureType"] == "trajectory" and data.attrs["Conventions"].startswith("CF-1.8"), path, data.attrs)
    check(data["trajectory"].item().decode() == data.attrs["id"], path, "trajectory", data["trajectory"].item())
    check(data.attrs["backseat_mission"] == log.run["mission"], path, "mission")
    rows = []
    for time, value in log.channels["/navigation"]:
        at = log.start / 1e9 + value.get("time_s", log.seconds(time))
        if not rows or at > rows[-1][0]:
            rows.append((at, value))
    times = numpy.array([time for time, _ in rows])
    check(list(data["time"].values) == list(times), path, "times", len(data["time"]), len(times))
    decoded = xarray.decode_cf(data)["time"].values.astype("datetime64[ns]").astype("int64")
    check(numpy.abs(decoded / 1e9 - times).max() < 1e-6, path, "decoded times")
    figures, left = 2 * len(rows), set(data.data_vars) - NO_NUMBERS

    def compare(name, expected, divisor=1):
        nonlocal figures
        found, expected = data[name].values, numpy.array(expected, dtype=float) / divisor
        check(numpy.array_equal(found, expected, equal_nan=True), path, name, found[:5], expected[:5])
        figures += int(numpy.isfinite(found).sum())
        left.discard(name)

    for name, member in (("lat", "latitude_deg"), ("lon", "longitude_deg"), ("depth", "depth_m")):
        check(name in data.coords, path, name, "is no coordinate")
        compare(name, [value[member] for _, value in rows])
    for name, (topic, member, divisor) in SERIES.items():
        if topic == "/navigation":
            column = [value.get(member, math.nan) for _, value in rows]
        else:
            column = nearest(log, times, topic, member)
        if name in data:
            compare(name, column, divisor)
        else:
            check(not numpy.isfinite(column).any(), path, name, "is missing")
    for topic in (topic for topic in log.channels if topic.startswith("/measures/")):
        name = re.sub("[^A-Za-z0-9]", "_", topic.removeprefix("/").replace("measures", "measure", 1))
        if name in data:
            compare(name, nearest(log, times, topic, "value"))
    compare("gps", [value.get("gps", math.nan) for _, value in rows])
    compare("control", states(log, times, "/control", lambda value: value["granted"], False))
    if "steering" in data:
        compare("steering", states(log, times, "/truth", lambda value: STEERING.index(value["steering"]), math.nan))
    speeds = [math.hypot(value["east_mps"], value["north_mps"]) for _, value in rows]
    check(numpy.allclose(data["platform_speed"], speeds, rtol=1e-15), path, "speeds")
    # The scale's own values are in a test of the crate; here that it is there and of sea water.
    salinity = data["salinity"].values if "salinity" in data else numpy.array([])
    check(((salinity > 2) & (salinity < 42) | numpy.isnan(salinity)).all(), path, "salinity")
    left -= {"platform_speed", "salinity"}
    check(not left, path, "other variables", left)
    passed = conventions(path)
    # A checker that finds nothing in any file proves nothing.
    with tempfile.TemporaryDirectory() as folder:
        spoilt = Path(folder) / "spoilt.nc"
        spoilt.write_bytes(path.read_bytes().replace(b"height_above_sea_floor", b"height_above_sea_flaws"))
        faults = conventions(spoilt, expected=False)
    check(faults, path, "a wrong standard name is not found")
    return f"{figures} figures, {passed}; a wrong standard name is found"


def conventions(path, expected=True):
    """What compliance-checker says of CF 1.8. It has CF's table of names with it, and gets no other."""
    # Whatever it would fetch fails.
    os.environ |= {name: "http://127.0.0.1:9" for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY")}
    from compliance_checker.runner import CheckSuite, ComplianceChecker

    CheckSuite.load_all_available_checkers()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report.json"
        _, failed = ComplianceChecker.run_checker(str(path), ["cf:1.8"], 0, "strict", output_filename=str(out), output_format="json")
        report = json.loads(out.read_text())["cf:1.8"]
    check(not failed, path, "compliance-checker failed")
    entries = [entry for priority in ("high", "medium", "low") for entry in report[f"{priority}_priorities"]]
    # Some that pass have a message too.
    messages = [message for entry in entries if entry["value"][0] != entry["value"][1] for message in entry["msgs"]]
    if not expected:
        return messages
    check(not messages and report["scored_points"] == report["possible_points"], path, "cf:1.8", messages)
    return f"cf:1.8 {report['scored_points']} of {report['possible_points']} points"


def main(folder):
    log = Log(folder / "log.mcap")
    for name, result in (
        ("csv, parquet", tables(log, folder)),
        ("map.geojson", geojson(log, folder / "map.geojson")),
        ("map.kml", kml(log, folder / "map.kml")),
        ("log.alog", alog(log, folder / "log.alog")),
        ("track.nc", netcdf(log, folder / "track.nc")),
    ):
        print(f"{name}: {result}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))

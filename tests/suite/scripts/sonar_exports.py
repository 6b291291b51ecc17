"""Opens what `backseat s7k export` writes with readers that others wrote, and compares every figure.

    cargo run -p backseat-s7k-tools --example survey -- FOLDER
    python3 sonar_exports.py FOLDER

Needs segyio, pyxtf and rasterio; `cargo xtask exports` installs them and runs both. What is expected comes from
`s7k_reader.py` in the same folder, which shares nothing with this project's crates.
"""

import csv
import datetime
import math
import sys
import warnings
from pathlib import Path

import numpy as np
import pyxtf
import rasterio
import rasterio.warp
import segyio
from s7k_compare import compare
from s7k_reader import read

QUALITY = (
    "latitude longitude speed depth altitude roll pitch yaw northing_rate easting_rate depth_rate altitude_rate "
    "roll_rate pitch_rate yaw_rate position_time attitude_time"
).split()
# The survey: see runtime/s7k-tools/examples/survey/compose.rs.
BLOCK_S, BLOCK_ACROSS_M, BLOCK_HEIGHT_M = 30.0, 20.0, 1.5


def check(condition, *what):
    if not condition:
        sys.exit("differs: " + ", ".join(str(part) for part in what))


def near(a, b, tolerance, *what):
    check(abs(a - b) <= tolerance, *what, a, b)


class Survey:
    """The recording, by the independent reader."""

    def __init__(self, path):
        self.records, damage = read(path.read_bytes())
        check(not damage, "the survey is damaged", damage)
        self.frames = []
        for record in self.of(3100):
            names = [name for name, _ in record.parts]
            for number, (name, values) in enumerate(record.parts):
                if name in ("navigation", "environment"):
                    index = (number - 2) // 2
                    check(names[number - 1] == "frame", "a frame has no header")
                    self.frames.append((record, index, name, record.parts[number - 1][1], values))
        track = [(frame_seconds(header), values) for _, _, name, header, values in self.frames if name == "navigation"]
        self.times = np.array([seconds for seconds, _ in track])
        self.track = np.array([values for _, values in track], dtype=float)

    def of(self, record_type, device=None):
        return [r for r in self.records if r.type == record_type and device in (None, r.device)]

    def at(self, seconds, column):
        """A column of Table 12 at a time, linear between frames, and held at the ends."""
        return np.interp(seconds, self.times, self.track[:, column])


def frame_seconds(header):
    from s7k_reader import TIME, seconds_of

    return seconds_of(TIME.unpack(header[5]))


def calendar(seconds):
    return datetime.datetime(1970, 1, 1) + datetime.timedelta(seconds=seconds)


def segy(survey, path, signal):
    traces = survey.of(3001)
    with segyio.open(path, ignore_geometry=True) as file:
        check(file.tracecount == len(traces), path, "traces", file.tracecount, len(traces))
        check(int(file.format) == 5, path, "sample format", int(file.format))
        check(file.bin[segyio.BinField.SEGYRevision] in (1, 0x0100), path, "revision", file.bin[segyio.BinField.SEGYRevision])
        interval = traces[0].parts[1][1][8]
        check(file.bin[segyio.BinField.Interval] == interval, path, "interval")
        text = file.text[0].decode()
        check("SEG Y REV1" in text and "DEVICE 11000, CHANNEL 0, 120 TRACES" in text, path, "text", text)
        for number, record in enumerate(traces):
            pairs = np.array(record.samples[0], dtype=float)
            expected = np.hypot(pairs[:, 0], pairs[:, 1]) if signal == "envelope" else pairs[:, 0]
            found = file.trace[number]
            check(len(found) == len(expected), path, number, "samples", len(found), len(expected))
            check(np.allclose(found, expected, rtol=1e-6, atol=1e-3), path, number, "samples differ")
            header = file.header[number]
            field = segyio.TraceField
            seconds = record.seconds()
            when = calendar(seconds)
            for name, value in (
                (field.TRACE_SEQUENCE_FILE, number + 1),
                (field.FieldRecord, record.parts[0][1][1]),
                (field.TraceIdentificationCode, 1),
                (field.TRACE_SAMPLE_COUNT, len(expected)),
                (field.TRACE_SAMPLE_INTERVAL, interval),
                (field.YearDataRecorded, when.year),
                (field.DayOfYear, record.time[1]),
                (field.HourOfDay, when.hour),
                (field.MinuteOfHour, when.minute),
                (field.SecondOfMinute, when.second),
                (field.TimeBaseCode, 4),
                (field.TraceWeightingFactor, 9),
                (field.CoordinateUnits, 2),
            ):
                check(header[name] == value, path, number, name, header[name], value)
            # Seconds of arc, divided by the scalar.
            scale = -header[field.SourceGroupScalar]
            for name, column in ((field.SourceX, 2), (field.SourceY, 1), (field.CDP_X, 2), (field.CDP_Y, 1)):
                expected = math.degrees(survey.at(seconds, column)) * 3600
                near(header[name] / scale, expected, 0.0006, path, number, name)
            depth = survey.at(seconds, 4)
            near(header[field.SourceDepth] / -header[field.ElevationScalar], depth, 0.006, path, number, "depth")
            water = depth + survey.at(seconds, 5)
            near(header[field.SourceWaterDepth] / -header[field.ElevationScalar], water, 0.006, path, number, "water")
    return f"{len(traces)} traces"


def xtf(survey, path, device):
    pings = survey.of(3000, device)
    header, packets = pyxtf.xtf_read(str(path))
    check(header.FileFormat == 0x7B and header.NumberOfSonarChannels == 2, path, "file header")
    check(header.NavUnits == 3, path, "units of positions", header.NavUnits)
    kinds = [(info.TypeOfChannel, info.BytesPerSample, info.SampleFormat, info.UniPolar) for info in header.ChanInfo[:2]]
    check(kinds == [(1, 2, 3, 1), (2, 2, 3, 1)], path, "channels", kinds)
    check([info.ChannelName for info in header.ChanInfo[:2]] == [b"port", b"starboard"], path, "names")
    check(set(packets) == {pyxtf.XTFHeaderType.sonar}, path, "packets", set(packets))
    packets = packets[pyxtf.XTFHeaderType.sonar]
    check(len(packets) == len(pings), path, "pings", len(packets), len(pings))
    for packet, record in zip(packets, pings):
        where = (path, record.offset)
        check(packet.PingNumber == record.parts[0][1][1], *where, "ping number")
        seconds = record.seconds()
        found = packet.get_time().astype("datetime64[ms]").astype(float) / 1000
        near(found, seconds, 0.0101, *where, "time")
        check(packet.JulianDay == record.time[1], *where, "day of the year")
        for name, column in (("SensorYcoordinate", 1), ("SensorXcoordinate", 2)):
            near(getattr(packet, name), math.degrees(survey.at(seconds, column)), 1e-8, *where, name)
        near(packet.ShipYcoordinate, packet.SensorYcoordinate, 0, *where, "ship and sensor")
        near(packet.SensorHeading, math.degrees(survey.at(seconds, 8)), 1e-4, *where, "heading")
        near(packet.SensorDepth, survey.at(seconds, 4), 1e-4, *where, "depth")
        near(packet.SensorPrimaryAltitude, survey.at(seconds, 5), 1e-4, *where, "altitude")
        near(packet.SensorPitch, math.degrees(survey.at(seconds, 7)), 1e-4, *where, "pitch")
        near(packet.SensorRoll, math.degrees(survey.at(seconds, 6)), 1e-4, *where, "roll")
        near(packet.SensorSpeed * 1852 / 3600, survey.at(seconds, 3), 1e-4, *where, "speed")
        near(packet.SoundVelocity, 750, 1e-3, *where, "half the speed of sound")
        for number, (data, expected) in enumerate(zip(packet.data, record.samples)):
            check(np.array_equal(data.astype(int), np.abs(expected)), *where, "samples", number)
            channel = packet.ping_chan_headers[number]
            header = record.parts[1 + number][1]
            check(channel.ChannelNumber == number and channel.NumSamples == header[6], *where, "channel", number)
            near(channel.SlantRange, header[6] * header[8] * 1e-6 * 750, 1e-3, *where, "slant range")
            near(channel.TimeDuration, header[6] * header[8] * 1e-6, 1e-6, *where, "duration")
            check(channel.Weight == 12, *where, "weight", channel.Weight)
    return f"{len(pings)} pings"


def table(survey, path, kind):
    frames = [frame for frame in survey.frames if frame[2] == kind]
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    check(len(rows) == len(frames), path, "rows", len(rows), len(frames))
    names = [name for name in rows[0] if name.endswith("_valid")]
    check(names == [f"{name}_valid" for name in (QUALITY if kind == "navigation" else ["sound_speed"])], path, names)
    for row, (record, index, _, header, values) in zip(rows, frames):
        where = (path, record.offset, index)
        check(int(row["record_offset"]) == record.offset and int(row["frame"]) == index, *where, "place")
        check(int(row["record_count"]) == record.count and int(row["device"]) == record.device, *where, "record")
        when = datetime.datetime.fromisoformat(row["frame_utc"].rstrip("Z"))
        near((when - datetime.datetime(1970, 1, 1)).total_seconds(), frame_seconds(header), 2e-6, *where, "time")
        check(int(row["frame_checksum"], 16) == header[6], *where, "checksum")
        columns = [name for name in list(row)[10:] if not name.endswith("_valid")]
        values = values if kind == "navigation" else values[:2]
        check(len(columns) == len(values), *where, "columns", columns)
        for name, value in zip(columns, values):
            # 32-bit numbers are written with as many digits as tell them apart.
            found = float(row[name])
            check(found == value or np.float32(found) == np.float32(value), *where, name, found, value)
        bits = [int(row[name]) for name in names]
        check(bits == [values[0] >> bit & 1 for bit in range(len(names))], *where, "quality bits")
    return f"{len(rows)} rows"


def block(survey):
    """Where the block's face and the middle of its shadow are: position, heading, metres to starboard."""
    start = survey.of(3100)[0].seconds()
    seconds = start + BLOCK_S
    altitude = survey.at(seconds, 5)
    far = (BLOCK_ACROSS_M + 1) * altitude / (altitude - BLOCK_HEIGHT_M)
    position = [math.degrees(survey.at(seconds, column)) for column in (1, 2)]
    return position, survey.at(seconds, 8), (BLOCK_ACROSS_M + 0.5, (BLOCK_ACROSS_M + 1 + far) / 2), seconds


def beside(position, heading, metres):
    """A position so many metres to starboard, on a sphere: good to centimetres over 20 m."""
    bearing = heading + math.pi / 2
    latitude = position[0] + math.degrees(metres * math.cos(bearing) / 6_370_000)
    longitude = position[1] + math.degrees(metres * math.sin(bearing) / (6_378_137 * math.cos(math.radians(position[0]))))
    return latitude, longitude


def mosaic(survey, path, crs, resolution, drop):
    with rasterio.open(path) as file:
        check(file.crs.to_epsg() == crs, path, "coordinates", file.crs)
        check(file.nodata == 0 and file.dtypes == ("uint8",), path, "type", file.nodata, file.dtypes)
        cells = file.read(1)
        size = (file.transform.a, -file.transform.e)
        position, heading, across, _ = block(survey)
        degree = 111_120
        expected = (resolution,) * 2 if crs != 4326 else (resolution / degree / math.cos(math.radians(position[0])), resolution / degree)
        check(np.allclose(size, expected, rtol=5e-3), path, "cell", size, expected)
        shades = []
        for metres in (0, *across, -BLOCK_ACROSS_M):
            latitude, longitude = beside(position, heading, metres)
            (x,), (y,) = rasterio.warp.transform("EPSG:4326", file.crs, [longitude], [latitude])
            row, column = file.index(x, y)
            shades.append(cells[row, column])
        nadir, face, shadow, other = shades
        check(face == 255 and 1 <= shadow < 25 and 40 < other < 220, path, "block, shadow, seabed", shades)
        check((nadir == 0) == drop, path, "below the vehicle", nadir)
        # The centre of what is white lies on the block.
        white = np.argwhere(cells == 255)
        middle = np.median(white, axis=0)
        x, y = file.xy(*middle)
        (longitude,), (latitude,) = rasterio.warp.transform(file.crs, "EPSG:4326", [x], [y])
        off = (np.array([latitude, longitude]) - beside(position, heading, across[0])) * (degree, degree * math.cos(math.radians(position[0])))
        near(float(np.hypot(*off)), 0, 1.0, path, "metres from block to brightest cells")
        # The swath is 100 m by 85 m without its pause of 4.7 m: no cell in it is empty.
        area = float((cells > 0).sum()) * resolution**2
        width = 2 * math.sqrt(50.25**2 - 10**2) - (2 * 0.3 * 10 if drop else 0)
        near(area / (width * (59.875 - 3.125) * 1.5), 1, 0.03, path, "area")
    return f"{cells.shape[1]} x {cells.shape[0]} cells"


def picture(survey, path, ground):
    pings = survey.of(3000, 11002)
    with warnings.catch_warnings(action="ignore"), rasterio.open(path) as file:
        # A picture is not georeferenced.
        cells = file.read(1)
    check(cells.shape == (len(pings), 2000), path, "size", cells.shape)
    _, _, across, seconds = block(survey)
    altitude = survey.at(seconds, 5)
    row = len(pings) - 1 - next(i for i, ping in enumerate(pings) if ping.seconds() >= seconds)
    columns = [metres if ground else math.hypot(metres, altitude) for metres in (*across, BLOCK_ACROSS_M)]
    face, shadow, port = (int(1000 + metres / 0.05025) for metres in columns)
    around = lambda column: float(np.median(cells[row - 4 : row + 5, column - 4 : column + 5]))
    shades = around(face), around(shadow), around(1999 - port)
    check(shades[0] == 255 and shades[1] < 25 and 60 < shades[2] < 160, path, "block, shadow, seabed", shades)
    return f"{cells.shape[1]} x {cells.shape[0]} pixels"


def main(folder):
    survey = Survey(folder / "survey.s7k")
    results = {name: compare(folder / f"{name}.s7k", folder / f"{name}.jsonl") for name in ("survey", "damaged")}
    results["envelope.sgy"] = segy(survey, folder / "envelope.sgy", "envelope")
    results["real.sgy"] = segy(survey, folder / "real.sgy", "real")
    results["high.xtf"] = xtf(survey, folder / "high.xtf", 11002)
    results["low.xtf"] = xtf(survey, folder / "low.xtf", 11001)
    results["navigation.csv"] = table(survey, folder / "navigation.csv", "navigation")
    results["environment.csv"] = table(survey, folder / "environment.csv", "environment")
    results["utm.tif"] = mosaic(survey, folder / "utm.tif", 32619, 0.25, drop=False)
    results["degrees.tif"] = mosaic(survey, folder / "degrees.tif", 4326, 0.5, drop=True)
    results["slant.png"] = picture(survey, folder / "slant.png", ground=False)
    results["ground.png"] = picture(survey, folder / "ground.png", ground=True)
    for name, result in results.items():
        print(f"{name}: {result}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))

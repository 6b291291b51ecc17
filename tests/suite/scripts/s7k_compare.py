"""Compares what `backseat s7k dump --samples` writes with what an independent reader finds: every field and sample.

    python3 s7k_compare.py RECORDING.s7k DUMP.jsonl

Standard library only. Prints one line with the counts, or stops at the first difference.
"""

import json
import struct
import sys
from pathlib import Path

from s7k_reader import TIME, read

# Names that stand for codes in the dump, by the field that they are in.
CODES = {
    "data_format": {"envelope": 0, "complex": 1, "raw": 2, "real_part": 3, "pixel": 4, "navigation": 0, "environment": 1},
    "data_type": {"navigation": 1, "environment": 2},
    "side": {"port": 0, "starboard": 1},
    "range_kind": {"slant": 0, "ground": 1},
    "polarity": {"bipolar": 0, "unipolar": 1},
    "trigger": {"internal": 0, "external": 1},
    "coordinate_units": {"length": 1, "seconds_of_arc": 2},
    "correlated": {"no": 1, "yes": 2},
    "command": {"generic": 0, "logging": 1, "switch": 2, "path": 3, "version": 4},
    "action": {"unspecified": 0, "set": 1, "get": 2},
    "status": {"rejected": 0, "accepted": 1, "unknown": 2},
    "message": {"status": 0, "alarm": 1},
    "mode": {"unspecified": -1, "clear": 0, "active": 1},
}


def check(condition, *what):
    if not condition:
        sys.exit("differs: " + ", ".join(str(part) for part in what))


def single(value):
    """A number as 32 bits hold it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def code(name, value):
    if isinstance(value, dict) and set(value) == {"other"}:
        return value["other"]
    return CODES[name][value] if isinstance(value, str) and name in CODES else value


def compare_part(where, name, ours, theirs):
    """`ours`: an object of the dump, whose fields are in the order of the bytes. `theirs`: the reader's values."""
    check(len(ours) == len(theirs), where, name, "number of fields", len(ours), len(theirs))
    for (field, value), expected in zip(ours.items(), theirs):
        value = code(field, value)
        if isinstance(value, dict):
            expected = TIME.unpack(expected)
            value = tuple(value.values())
            check(single(value[2]) == expected[2], where, name, field, value, expected)
            value = value[:2] + (expected[2],) + value[3:]
        elif isinstance(expected, bytes):
            # Text, or reserved bytes in hexadecimal digits, empty if they are all zero.
            reserved = field.startswith(("reserved", "unused", "rs232"))
            value = bytes.fromhex(value) if reserved else value.encode()
            expected = expected if reserved and any(expected) else expected.split(b"\0")[0]
        elif isinstance(expected, int) and isinstance(value, str):
            # Reserved bytes that the reader takes for a number.
            value, expected = int.from_bytes(bytes.fromhex(value), "little"), expected
        elif isinstance(expected, float) and value != expected:
            value = single(value)
        check(value == expected, where, name, field, value, expected)
    return len(theirs)


def objects(record):
    """The parts of a dumped record, in the order of the bytes."""
    yield record["header"]
    for key in ("channels", "devices", "entries", "frames"):
        for entry in record.get(key, []):
            yield entry.get("header", entry)
            for kind in ("navigation", "environment"):
                if kind in entry:
                    # The set of valid fields is shown by name; its bits are beside it.
                    yield entry[kind] | {"quality": entry["quality_bits"]}
    if record.get("catalog"):
        yield record["catalog"]
    optional = record.get("optional") or {}
    yield from optional.get("side_scan", []) + optional.get("segy", [])


def compare(recording, dump):
    records, damage = read(Path(recording).read_bytes())
    lines = [json.loads(line) for line in Path(dump).read_text().splitlines()]
    places = [(line["offset"], line["bytes"]) for line in lines if "bytes" in line]
    check(places == damage, "damaged places", places, damage)
    lines = [line for line in lines if "bytes" not in line]
    check(len(lines) == len(records), "number of records", len(lines), len(records))
    fields = samples = 0
    for line, record in zip(lines, records):
        where = f"record {record.type} at byte {record.offset}"
        check(line["offset"] == record.offset, where, "offset", line["offset"])
        fields += compare_part(where, "frame", line["frame"], record.frame)
        check(line["checksum"]["stored"] == record.checksum, where, "checksum", line["checksum"], record.checksum)
        right = record.checksum == record.sum
        state = ("valid" if right else "wrong") if record.flags & 1 else f"unclaimed_{'right' if right else 'wrong'}"
        check(line["checksum"]["state"] == state, where, "checksum's state", line["checksum"], state)
        parts = list(objects(line["record"]))
        check(len(parts) == len(record.parts), where, "number of parts", len(parts), len(record.parts))
        for ours, (name, theirs) in zip(parts, record.parts):
            fields += compare_part(where, name, ours, theirs)
        if record.padding is not None:
            layout = {0: "spec", 12: "padded"}[record.padding]
            check(line["record"]["layout"] == layout, where, "layout", line["record"]["layout"], layout)
        if record.text is not None:
            check(line["record"]["text"] == record.text, where, "text", line["record"]["text"], record.text)
        for channel, theirs in zip(line["record"].get("channels", []), record.samples):
            ours = [tuple(sample) if isinstance(sample, list) else sample for sample in channel["samples"]]
            check(ours == theirs, where, "samples")
            samples += len(theirs)
    return f"{len(records)} records, {len(damage)} damaged places, {fields} fields and {samples} samples are equal"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    print(compare(*sys.argv[1:]))

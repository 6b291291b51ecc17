"""Reads .s7k files with Python's standard library alone.

Written from the documents: SeaBat 7k Data Format, Volume III 0.53, its appendices A and B, and the framing of Volume I.
It shares nothing with the crates of this project, so that a mistake in them does not pass unseen. Field names are those
of the documents.
"""

import struct

SYNC = 0x0000FFFF

# Data record frame, 64 bytes.
DRF = struct.Struct("<HHIIII10sHIIHHIHHIII")
DRF_NAMES = (
    "protocol version", "offset", "sync pattern", "size", "optional data offset", "optional data identifier", "7KTIME",
    "record version", "record type identifier", "device identifier", "reserved", "system enumerator", "record count",
    "flags", "reserved", "reserved", "fragment total", "fragment number",
)  # fmt: skip

# Tables 3 and 5, 4 and 6.
IMAGERY = struct.Struct("<IIIII")
CHANNEL = struct.Struct("<BBBBB3sIIIff16s20s")
# Tables 7, 11, 12, 14.
BLUEFIN = struct.Struct("<IIII16s")
BLUEFIN_FRAME = struct.Struct("<IHHII10sIH")
NAVIGATION = struct.Struct("<Iddfddffffffffffdd")
ENVIRONMENT = struct.Struct("<If88s")
# Appendix A.
SIDE_SCAN = struct.Struct("<HHIHHIIIhHHHHHHHIhHHHHhhhhhIh10s")
SEGY = struct.Struct("<iIII12sh4shhh32siiiih24sHIHhhHHH8sHH12shhhhhhh2shhhhhhHhhhhhhhIHhh6siHhh14s")
# Tables 8, 9, 10.
COMMAND = struct.Struct("<iIII")
ACKNOWLEDGE = struct.Struct("<IiI")
MESSAGE = struct.Struct("<iiiI")
# Volume I: 7200, 7300, 7400.
FILE_HEADER = struct.Struct("<QQHHQQII64s16s64s128s")
FILE_DEVICE = struct.Struct("<IH")
CATALOG_PLACE = struct.Struct("<IQ")
CATALOG = struct.Struct("<IHII")
CATALOG_ENTRY = struct.Struct("<IQHHH10sI16s")
TIME_MESSAGE = struct.Struct("<bBHIQ")
TIME = struct.Struct("<HHfBB")

for part, size in (
    (DRF, 64), (IMAGERY, 20), (CHANNEL, 64), (BLUEFIN, 32), (BLUEFIN_FRAME, 32), (NAVIGATION, 96), (ENVIRONMENT, 96),
    (SIDE_SCAN, 80), (SEGY, 240), (COMMAND, 16), (ACKNOWLEDGE, 12), (MESSAGE, 16), (FILE_HEADER, 316), (FILE_DEVICE, 6),
    (CATALOG, 14), (CATALOG_ENTRY, 48), (TIME_MESSAGE, 16), (TIME, 10),
):  # fmt: skip
    assert part.size == size, (part.format, part.size, size)


class Record:
    """A record: its place, its frame, and its parts."""

    def __init__(self, data, offset):
        self.offset = offset
        self.frame = DRF.unpack_from(data, offset)
        (self.version, record_at, _, self.size, self.optional_at, self.optional_id, time, _, self.type, self.device) = (
            self.frame[:10]
        )
        self.enumerator, self.count, self.flags = self.frame[11], self.frame[12], self.frame[13]
        self.time = TIME.unpack(time)
        whole = data[offset : offset + self.size]
        self.checksum = struct.unpack_from("<I", whole, self.size - 4)[0]
        self.sum = sum(whole[:-4]) & 0xFFFFFFFF
        end = self.optional_at or self.size - 4
        # The offset counts from the sync pattern; one sender counts from the frame's start.
        self.body = whole[64 if record_at == 64 else record_at + 4 : end]
        self.optional = whole[end : self.size - 4]
        # Lists of the parts in their order: (name, values).
        self.parts = []
        # The samples of each channel, as numbers or as pairs.
        self.samples = []
        self.padding = None
        self.text = None
        read = {3000: self.imagery, 3001: self.imagery, 3100: self.bluefin, 7200: self.file_header, 7300: self.catalog}
        read |= {7400: self.time_message, 11000: self.command, 11001: self.acknowledge, 11002: self.message}
        read.get(self.type, lambda: None)()

    def add(self, name, part, at, data=None):
        values = part.unpack_from(self.body if data is None else data, at)
        self.parts.append((name, values))
        return values

    def seconds(self):
        """Seconds since 1970."""
        return seconds_of(self.time)

    def imagery(self):
        _, _, channels, _, data_format = self.add("imagery", IMAGERY, 0)
        # The header has 20 bytes, or 32: the channels must fill the record exactly.
        self.padding = next(pad for pad in (0, 12) if self.channels_end(20 + pad, channels) == len(self.body))
        at = 20 + self.padding
        for _ in range(channels):
            header = self.add("channel", CHANNEL, at)
            polarity, width, count = header[3], header[4], header[6]
            data = self.body[at + 64 : at + 64 + width * count]
            if data_format == 1 and width == 4:
                numbers = struct.unpack(f"<{2 * count}h", data)
                self.samples.append(list(zip(numbers[::2], numbers[1::2])))
            else:
                code = {1: "b", 2: "h", 4: "i"}[width]
                self.samples.append(list(struct.unpack(f"<{count}{code.upper() if polarity == 1 else code}", data)))
            at += 64 + width * count
        part, name = {1: (SIDE_SCAN, "side scan"), 2: (SEGY, "SEG-Y")}.get(self.optional_id, (None, None))
        if part and self.optional_at:
            for at in range(0, len(self.optional), part.size):
                self.add(name, part, at, self.optional)

    def channels_end(self, at, channels):
        for _ in range(channels):
            if at + 64 > len(self.body):
                return None
            header = CHANNEL.unpack_from(self.body, at)
            at += 64 + header[4] * header[6]
        return at

    def bluefin(self):
        _, frames, size, _, _ = self.add("Bluefin data", BLUEFIN, 0)
        for number in range(frames):
            at = 32 + number * size
            header = self.add("frame", BLUEFIN_FRAME, at)
            part = {1: NAVIGATION, 2: ENVIRONMENT}[header[3]]
            self.add("navigation" if header[3] == 1 else "environment", part, at + header[2])

    def file_header(self):
        devices = self.add("file header", FILE_HEADER, 0)[7]
        for number in range(devices):
            self.add("device", FILE_DEVICE, 316 + 6 * number)
        if self.optional_id == 7300 and CATALOG_PLACE.unpack(self.optional)[1] > 0:
            self.add("catalogue's place", CATALOG_PLACE, 0, self.optional)

    def catalog(self):
        entries = self.add("catalogue", CATALOG, 0)[2]
        for number in range(entries):
            self.add("entry", CATALOG_ENTRY, 14 + 48 * number)

    def time_message(self):
        self.add("time message", TIME_MESSAGE, 0)

    def command(self):
        length = self.add("command", COMMAND, 0)[3]
        self.text = self.body[16 : 16 + length].split(b"\0")[0].decode()

    def acknowledge(self):
        self.add("acknowledge", ACKNOWLEDGE, 0)

    def message(self):
        length = self.add("message", MESSAGE, 0)[3]
        self.text = self.body[16 : 16 + length].split(b"\0")[0].decode()


def seconds_of(time):
    year, day, seconds, hours, minutes = time
    leaps = lambda y: y // 4 - y // 100 + y // 400
    days = (year - 1970) * 365 + leaps(year - 1) - leaps(1969) + day - 1
    return ((days * 24 + hours) * 60 + minutes) * 60 + seconds


def begins(data, at):
    """Whether a whole record may begin here."""
    if at + 68 > len(data):
        return False
    version, _, sync, size = struct.unpack_from("<HHII", data, at)
    return sync == SYNC and version in (4, 5) and 68 <= size <= len(data) - at


def read(data):
    """The records of a file, and its damaged places as (offset, bytes)."""
    records, damage, at = [], [], 0
    while at < len(data):
        if begins(data, at):
            records.append(Record(data, at))
            at += records[-1].size
            continue
        start = at
        while at < len(data) and not begins(data, at):
            at = data.find(b"\xff\xff\x00\x00", at + 5) - 4
            if at < 0:
                at = len(data)
        damage.append((start, at - start))
    return records, damage

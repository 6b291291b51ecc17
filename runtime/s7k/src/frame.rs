//! Data record frames (DRF): what encloses each record, in files and on the wire.

use crate::checksum::byte_sum;
use crate::device::DeviceId;
use crate::layout::{Range, layouts};
use crate::time::Time7k;
use crate::wire::Reserved;

/// The pattern at byte 4 of each frame.
pub const SYNC: u32 = 0x0000_FFFF;

/// The longest record that is read unless a limit is set, bytes.
pub const FRAME_LIMIT: usize = 16 << 20;

layouts! {
    /// The header of a data record frame.
    "Volume I, data record frame" FrameHeader frame_header {
        /// Protocol version. Version 4 is that of the data format 0.51 and later; 5 came with 0.54.
        version: u16, "protocol version", Range::new(4.0, 5.0);
        /// Bytes from the sync pattern to the record type header: 60. Some senders count from the frame's start and
        /// write 64; both are read as 60.
        offset: u16, "bytes", Range::new(60.0, 65_535.0);
        /// [`SYNC`].
        sync: u32, "pattern", Range::new(65_535.0, 65_535.0);
        /// Length of the whole frame, from the version through the checksum.
        size: u32, "bytes", Range::new(68.0, 4_294_967_295.0);
        /// Offset of the optional data from the frame's start; 0 if there are none.
        optional_offset: u32, "bytes", Range::ANY;
        /// Format of the optional data: 1 EdgeTech sidescan headers, 2 EdgeTech SEG-Y headers, 7300 file catalogue.
        optional_id: u32, "identifier", Range::ANY;
        /// Time of the record, UTC.
        time: Time7k, "UTC", Range::ANY;
        /// Version of the record type. Reserved in protocol version 4, 1 in version 5.
        record_version: u16, "record version", Range::ANY;
        /// Record type: 3000, 3001, 3100, 7200, 7300, 7400, 11000, 11001, 11002, or another.
        record_type: u32, "record type", Range::ANY;
        /// The device that the record is from.
        device: DeviceId, "device identifier", Range::ANY;
        /// Reserved.
        reserved_1: Reserved<2>, "reserved", Range::ANY;
        /// Tells apart several devices of one kind.
        enumerator: u16, "system enumerator", Range::ANY;
        /// Counts the records of this type and device.
        record_count: u32, "count", Range::ANY;
        /// Bit 0: the checksum is valid. Bit 15, in version 5: the record was recorded before.
        flags: u16, "bit field", Range::ANY;
        /// Reserved.
        reserved_2: Reserved<2>, "reserved", Range::ANY;
        /// Reserved.
        reserved_3: Reserved<4>, "reserved", Range::ANY;
        /// Number of fragments of a record that is split into several frames; 0 if it is not.
        fragment_total: u32, "count", Range::ANY;
        /// Number of this fragment, from 0.
        fragment_number: u32, "index", Range::ANY;
    }
}

/// Bytes of the checksum at the end of each frame.
const CHECKSUM: usize = 4;

/// Bytes from the frame's start to the flags.
const FLAGS_AT: usize = 48;

/// Bytes from the frame's start to the sync pattern, from which `offset` counts.
const SYNC_AT: usize = 4;

impl FrameHeader {
    /// The shortest frame, bytes: a header and a checksum.
    pub const FRAME_MIN: usize = Self::SIZE + CHECKSUM;

    /// The bit of `flags` that says that the checksum is valid.
    pub const CHECKSUM_VALID: u16 = 1;

    /// The bit of `flags` that says, in version 5, that the record was recorded before.
    pub const RECORDED: u16 = 1 << 15;

    /// A header in protocol version 4, without time, whose checksum will be valid.
    #[must_use]
    pub const fn new(record_type: u32, device: DeviceId) -> Self {
        Self {
            version: 4,
            offset: 60,
            sync: SYNC,
            size: 0,
            optional_offset: 0,
            optional_id: 0,
            time: Time7k::NONE,
            record_version: 0,
            record_type,
            device,
            reserved_1: Reserved([0; 2]),
            enumerator: 0,
            record_count: 0,
            flags: Self::CHECKSUM_VALID,
            reserved_2: Reserved([0; 2]),
            reserved_3: Reserved([0; 4]),
            fragment_total: 0,
            fragment_number: 0,
        }
    }

    /// The same header at a time.
    #[must_use]
    pub const fn at(mut self, time: Time7k) -> Self {
        self.time = time;
        self
    }

    /// The same header with a record count.
    #[must_use]
    pub const fn counted(mut self, record_count: u32) -> Self {
        self.record_count = record_count;
        self
    }

    /// The same header in protocol version 5.
    #[must_use]
    pub const fn version_5(mut self) -> Self {
        self.version = 5;
        self.record_version = 1;
        self
    }

    /// Bytes from the frame's start to the record type header.
    fn record_at(&self) -> usize {
        match usize::from(self.offset) {
            // Counted from the frame's start, as one public sender does.
            Self::SIZE => Self::SIZE,
            offset => offset + SYNC_AT,
        }
    }
}

/// Why bytes are no data record frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// The bytes end before the frame does.
    #[error("the frame ends after {found} of {needed} bytes")]
    Incomplete {
        /// Bytes that there are.
        found: usize,
        /// Bytes that the frame, or its header, needs.
        needed: usize,
    },
    /// There is no sync pattern at byte 4.
    #[error("no frame starts here: the sync pattern is {found:#010x} instead of 0x0000ffff")]
    Sync {
        /// The four bytes as a number.
        found: u32,
    },
    /// The protocol version is neither 4 nor 5.
    #[error("frame field version: protocol version {version} is not supported, only 4 and 5 are{}", era(*version))]
    Version {
        /// The version found.
        version: u16,
    },
    /// The size is less than a header and a checksum, or above the limit.
    #[error("frame field size: {size} bytes is outside {} to {limit}", FrameHeader::FRAME_MIN)]
    Size {
        /// The size found, bytes.
        size: u32,
        /// The limit that the reader was given, bytes.
        limit: usize,
    },
    /// The record type header would begin inside the frame's header or behind its end.
    #[error("frame field offset: {offset} does not point into the record of {size} bytes")]
    Offset {
        /// The offset found, bytes.
        offset: u16,
        /// The frame's size, bytes.
        size: u32,
    },
    /// The optional data would begin before the record's own data or behind their end.
    #[error("frame field optional_offset: {offset} is outside {first} to {last}")]
    OptionalOffset {
        /// The offset found, bytes.
        offset: u32,
        /// The first place where optional data may begin.
        first: usize,
        /// The last one.
        last: usize,
    },
}

/// What is known of a protocol version that is not read.
fn era(version: u16) -> &'static str {
    match version {
        1 => " (version 1 is of data formats 0.1 to 0.31)",
        2 => " (version 2 is of data formats 0.32 to 0.47, with frame headers of 70 bytes)",
        3 => " (version 3 is of data formats 0.48 to 0.50, with frame headers of 52 bytes)",
        _ => "",
    }
}

/// What a frame's checksum is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checksum {
    /// It is claimed, and right.
    Valid,
    /// It is claimed, and wrong.
    Wrong {
        /// The checksum in the frame.
        stored: u32,
        /// The checksum of the bytes.
        computed: u32,
    },
    /// Flag bit 0 is clear: the frame claims none. Some senders fill in a right one all the same.
    Unclaimed {
        /// Whether it would be right.
        right: bool,
    },
}

/// A record in its frame, borrowed from the bytes that it was read from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    header: FrameHeader,
    bytes: &'a [u8],
}

/// The optional data of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Optional<'a> {
    /// Their format: the frame's `optional_id`.
    pub id: u32,
    /// The data.
    pub bytes: &'a [u8],
}

impl<'a> Frame<'a> {
    /// Reads the frame at the start of `bytes`, of at most `limit` bytes. The checksum is not judged here.
    ///
    /// # Errors
    /// [`FrameError`]; `Incomplete` says how many bytes to bring.
    pub fn read(bytes: &'a [u8], limit: usize) -> Result<Self, FrameError> {
        let header = read_header(bytes, limit)?;
        let size = header.size as usize;
        let Some(bytes) = bytes.get(..size) else {
            return Err(FrameError::Incomplete {
                found: bytes.len(),
                needed: size,
            });
        };
        Ok(Self { header, bytes })
    }

    /// The frame's header.
    #[must_use]
    pub const fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// The whole frame as it was read.
    #[must_use]
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The record type header and the record's data.
    ///
    /// # Errors
    /// [`FrameError::OptionalOffset`] if the optional data do not begin inside the frame.
    pub fn body(&self) -> Result<&'a [u8], FrameError> {
        let end = self.optional_at()?.unwrap_or(self.end());
        Ok(&self.bytes[self.header.record_at()..end])
    }

    /// The record type header and all that follows it up to the checksum, wherever the optional data begin.
    #[must_use]
    pub fn payload(&self) -> &'a [u8] {
        &self.bytes[self.header.record_at()..self.end()]
    }

    /// The optional data, if there are any.
    ///
    /// # Errors
    /// [`FrameError::OptionalOffset`] if they do not begin inside the frame.
    pub fn optional(&self) -> Result<Option<Optional<'a>>, FrameError> {
        let optional = |at: usize| Optional {
            id: self.header.optional_id,
            bytes: &self.bytes[at..self.end()],
        };
        Ok(self.optional_at()?.map(optional))
    }

    /// Compares the checksum with the bytes, which takes a pass over them.
    #[must_use]
    pub fn checksum(&self) -> Checksum {
        let stored = self.stored_checksum();
        let computed = byte_sum(&self.bytes[..self.end()]);
        if self.header.flags & FrameHeader::CHECKSUM_VALID == 0 {
            Checksum::Unclaimed {
                right: stored == computed,
            }
        } else if stored == computed {
            Checksum::Valid
        } else {
            Checksum::Wrong { stored, computed }
        }
    }

    /// Appends the frame as it stands in a recording: in version 5 with [`FrameHeader::RECORDED`], and with a checksum
    /// that counts this bit.
    pub fn write_recorded(&self, out: &mut Vec<u8>) {
        let (start, flags) = (out.len(), self.header.flags);
        out.extend_from_slice(self.bytes);
        if self.header.version != 5 || flags & FrameHeader::RECORDED != 0 {
            return;
        }
        let at = start + FLAGS_AT;
        out[at..at + 2].copy_from_slice(&(flags | FrameHeader::RECORDED).to_le_bytes());
        if flags & FrameHeader::CHECKSUM_VALID != 0 {
            let [_, high] = FrameHeader::RECORDED.to_le_bytes();
            let checksum = self.stored_checksum().wrapping_add(u32::from(high));
            let at = start + self.end();
            out[at..].copy_from_slice(&checksum.to_le_bytes());
        }
    }

    /// The checksum in the frame, claimed or not.
    #[must_use]
    pub fn stored_checksum(&self) -> u32 {
        self.bytes.last_chunk().map_or(0, |last| u32::from_le_bytes(*last))
    }

    /// Where the checksum begins.
    const fn end(&self) -> usize {
        self.bytes.len() - CHECKSUM
    }

    fn optional_at(&self) -> Result<Option<usize>, FrameError> {
        let offset = self.header.optional_offset;
        let (first, last) = (self.header.record_at(), self.end());
        match usize::try_from(offset) {
            Ok(0) => Ok(None),
            Ok(at) if (first..=last).contains(&at) => Ok(Some(at)),
            _ => Err(FrameError::OptionalOffset { offset, first, last }),
        }
    }
}

/// Reads and checks the header of the frame at the start of `bytes`, whether the rest of the frame is there or not.
///
/// # Errors
/// [`FrameError`]: all but a frame that is not complete.
pub fn read_header(bytes: &[u8], limit: usize) -> Result<FrameHeader, FrameError> {
    let incomplete = FrameError::Incomplete {
        found: bytes.len(),
        needed: FrameHeader::SIZE,
    };
    // An older version's header is shorter, and its error names the version: look at the first eight bytes first.
    let start = bytes.first_chunk::<8>().ok_or(incomplete)?;
    let [v0, v1, _, _, s0, s1, s2, s3] = *start;
    let sync = u32::from_le_bytes([s0, s1, s2, s3]);
    if sync != SYNC {
        return Err(FrameError::Sync { found: sync });
    }
    let version = u16::from_le_bytes([v0, v1]);
    if !matches!(version, 4 | 5) {
        return Err(FrameError::Version { version });
    }
    let header = FrameHeader::read(bytes).map_err(|_| incomplete)?;
    let size = header.size as usize;
    if size < FrameHeader::FRAME_MIN || size > limit {
        return Err(FrameError::Size {
            size: header.size,
            limit,
        });
    }
    let record_at = header.record_at();
    if record_at < FrameHeader::SIZE || record_at > size - CHECKSUM {
        return Err(FrameError::Offset {
            offset: header.offset,
            size: header.size,
        });
    }
    Ok(header)
}

/// A record that is longer than a frame can say, or than a limit allows. Nothing was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a frame of {size} bytes is longer than {limit}")]
pub struct TooLong {
    /// The frame's length, bytes.
    pub size: usize,
    /// The longest one allowed, bytes.
    pub limit: usize,
}

/// Writes one frame: header, the record's bytes, optional data, checksum.
///
/// The frame's size, the place of its optional data and its checksum are filled in by [`Self::finish`].
#[derive(Debug)]
pub struct FrameWriter<'o> {
    header: FrameHeader,
    out: &'o mut Vec<u8>,
    start: usize,
}

impl<'o> FrameWriter<'o> {
    /// Begins a frame at the end of `out`.
    pub fn begin(header: FrameHeader, out: &'o mut Vec<u8>) -> Self {
        let start = out.len();
        let header = FrameHeader {
            offset: 60,
            sync: SYNC,
            optional_offset: 0,
            ..header
        };
        header.write(out);
        Self { header, out, start }
    }

    /// Where the record's bytes, or the optional data, are appended.
    pub fn bytes(&mut self) -> &mut Vec<u8> {
        self.out
    }

    /// Ends the record's own bytes: what follows is optional data in the format `id`.
    pub fn begin_optional(&mut self, id: u32) {
        self.header.optional_id = id;
        // Too long a frame is refused at its end.
        self.header.optional_offset = u32::try_from(self.out.len() - self.start).unwrap_or(u32::MAX);
    }

    /// Fills in what depends on the whole frame. The checksum is computed if the header's flags claim one, else it is 0.
    ///
    /// # Errors
    /// [`TooLong`] if the frame has more than `limit` bytes; then `out` is as it was before.
    pub fn finish(self, limit: usize) -> Result<FrameHeader, TooLong> {
        let Self { mut header, out, start } = self;
        let size = out.len() - start + CHECKSUM;
        let limit = limit.min(u32::MAX as usize);
        match u32::try_from(size) {
            Ok(fits) if size <= limit => header.size = fits,
            _ => {
                out.truncate(start);
                return Err(TooLong { size, limit });
            }
        }
        let mut bytes = Vec::with_capacity(FrameHeader::SIZE);
        header.write(&mut bytes);
        out[start..start + FrameHeader::SIZE].copy_from_slice(&bytes);
        let claimed = header.flags & FrameHeader::CHECKSUM_VALID != 0;
        let checksum = if claimed { byte_sum(&out[start..]) } else { 0 };
        out.extend_from_slice(&checksum.to_le_bytes());
        Ok(header)
    }
}

#[cfg(test)]
mod tests;

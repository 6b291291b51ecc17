//! What a client sent that cannot be used, by cause.

use core::fmt;

use backseat_s7k::{FrameError, NetworkError, StreamError};

/// What of a client's input was not used since the last event about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ignored {
    /// Bytes that were skipped: those that are no record, and those of records that are refused by their frame.
    pub bytes: u64,
    /// Records that are not what their type says, or that no client sends.
    pub records: u64,
    /// Records that claim a checksum which is not that of their bytes.
    pub checksums: u64,
    /// The first of them: its record type, the checksum of its bytes, and the one found in it.
    pub checksum: Option<(u32, u32, u32)>,
    /// Records and packets of another protocol version than 4 and 5.
    pub versions: u64,
    /// The first of them: `true` for a packet's network frame, `false` for a data record frame, and the version.
    pub version: Option<(bool, u16)>,
    /// Records and packets that are longer than the limit.
    pub too_long: u64,
    /// The first of them: its length and the limit, bytes.
    pub length: Option<(u32, usize)>,
}

/// The greatest number at the place of a network frame's version that is taken for one: garbage has any.
const VERSION_MAX: u16 = 15;

impl Ignored {
    pub(super) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Counts what the stream's reader skipped; the bytes are counted by the reader itself.
    pub(super) fn skipped(&mut self, why: &StreamError) {
        match *why {
            StreamError::Frame(FrameError::Version { version }) => self.version(false, version),
            StreamError::Packet(NetworkError::Version { version }) if version <= VERSION_MAX => {
                self.version(true, version);
            }
            StreamError::Frame(FrameError::Size { size, limit }) if size as usize > limit => {
                self.length(size, limit);
            }
            StreamError::Packet(NetworkError::Size { packet_size, limit }) if packet_size as usize > limit => {
                self.length(packet_size, limit);
            }
            StreamError::Frame(_)
            | StreamError::Packet(_)
            | StreamError::NoBeginning { .. }
            | StreamError::Abandoned { .. } => {}
        }
    }

    fn version(&mut self, network: bool, version: u16) {
        self.versions += 1;
        self.version.get_or_insert((network, version));
    }

    fn length(&mut self, size: u32, limit: usize) {
        self.too_long += 1;
        self.length.get_or_insert((size, limit));
    }

    pub(super) fn wrong_checksum(&mut self, record_type: u32, expected: u32, found: u32) {
        self.checksums += 1;
        self.checksum.get_or_insert((record_type, expected, found));
    }
}

impl fmt::Display for Ignored {
    /// The causes, those that there are.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        let mut next = |f: &mut fmt::Formatter<'_>| f.write_str(core::mem::replace(&mut between, ", "));
        if let Some((record_type, expected, found)) = self.checksum {
            next(f)?;
            let count = self.checksums;
            write!(
                f,
                "{count} with a wrong checksum (record {record_type}: expected {expected:#010x}, found {found:#010x})"
            )?;
        }
        if let Some((network, version)) = self.version {
            next(f)?;
            let frame = if network { "network frame" } else { "data record frame" };
            let count = self.versions;
            write!(
                f,
                "{count} of another protocol version ({frame} of version {version}; only 4 and 5 are read)"
            )?;
        }
        if let Some((size, limit)) = self.length {
            next(f)?;
            write!(f, "{} too long ({size} bytes, at most {limit})", self.too_long)?;
        }
        if self.records > 0 {
            next(f)?;
            write!(f, "{} that cannot be used", self.records)?;
        }
        if self.bytes > 0 {
            next(f)?;
            write!(f, "{} bytes skipped", self.bytes)?;
        }
        Ok(())
    }
}

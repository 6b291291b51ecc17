//! What begins at a place of a stream, and how long something is that is refused there.

use super::PATTERN;
use crate::frame::{FrameError, FrameHeader, read_header};
use crate::network::{NetworkError, NetworkHeader};

/// The shortest frame of any version, bytes: the header of version 3 and a checksum.
const FOREIGN_MIN: usize = 56;

/// The greatest protocol version that is taken for one while looking for a beginning in other bytes.
const VERSION_MAX: u16 = 15;

/// Where the size is in the headers of frames, and of packets. That the versions which are not read have it there too is
/// a guess; the worst of it is a length that is wrong, as any sender may write one.
const FRAME_SIZE_AT: usize = 8;
const PACKET_SIZE_AT: usize = 12;

/// What is at a place that cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Start {
    /// The next bytes decide.
    Waits,
    /// A record or a packet that is refused, of so many bytes by its own word.
    Refused(usize),
    /// No beginning.
    Nothing,
}

impl Start {
    /// The length of what is refused, 0 if nothing is.
    pub(super) const fn length(self) -> usize {
        match self {
            Self::Refused(length) => length,
            Self::Waits | Self::Nothing => 0,
        }
    }
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_le_bytes(*bytes))
}

fn size_at(bytes: &[u8], at: usize) -> Option<usize> {
    bytes
        .get(at..)?
        .first_chunk()
        .map(|bytes| u32::from_le_bytes(*bytes) as usize)
}

/// What is where a frame with its sync pattern cannot be read.
pub(super) fn refused_frame(bytes: &[u8], error: &FrameError) -> Start {
    match *error {
        FrameError::Size { size, .. } if size as usize >= FrameHeader::FRAME_MIN => Start::Refused(size as usize),
        FrameError::Offset { size, .. } => Start::Refused(size as usize),
        FrameError::Version { .. } => match size_at(bytes, FRAME_SIZE_AT) {
            None => Start::Waits,
            Some(size) if size >= FOREIGN_MIN => Start::Refused(size),
            Some(_) => Start::Nothing,
        },
        FrameError::Incomplete { .. }
        | FrameError::Sync { .. }
        | FrameError::Size { .. }
        | FrameError::OptionalOffset { .. } => Start::Nothing,
    }
}

/// What is where a packet cannot be read. Only an offset that is right tells its header from other bytes.
pub(super) fn refused_packet(bytes: &[u8], error: &NetworkError) -> Start {
    if u16_at(bytes, 2) != Some(NetworkHeader::SIZE as u16) {
        return Start::Nothing;
    }
    let version = match *error {
        NetworkError::Size { .. } => 4,
        NetworkError::Version { version } => version,
        NetworkError::Incomplete { .. } | NetworkError::Offset { .. } => return Start::Nothing,
    };
    match size_at(bytes, PACKET_SIZE_AT) {
        Some(size) if size > NetworkHeader::SIZE && (1..=VERSION_MAX).contains(&version) => Start::Refused(size),
        _ => Start::Nothing,
    }
}

/// Whether a packet begins here, in front of a sync pattern: one that is read, or one that is refused.
pub(super) fn starts_packet(bytes: &[u8], limit: usize) -> bool {
    match NetworkHeader::check(bytes, limit) {
        Ok(_) => true,
        Err(NetworkError::Version { .. }) => {
            let refused = NetworkHeader::SIZE + 1..=limit.saturating_add(NetworkHeader::SIZE);
            let error = NetworkError::Version {
                version: u16_at(bytes, 0).unwrap_or(0),
            };
            refused.contains(&refused_packet(bytes, &error).length())
        }
        Err(error) => refused_packet(bytes, &error).length() > 0,
    }
}

/// Whether a frame begins here, at its sync pattern: one that is read, or one that is refused. `None`: the next bytes
/// decide.
pub(super) fn starts_frame(bytes: &[u8], limit: usize) -> Option<bool> {
    debug_assert_eq!(bytes.get(4..8), Some(&PATTERN[..]));
    match read_header(bytes, limit) {
        Ok(_) => Some(true),
        Err(FrameError::Incomplete { .. }) => None,
        Err(error @ FrameError::Version { version }) => match refused_frame(bytes, &error) {
            Start::Waits => None,
            Start::Refused(size) => Some((1..=VERSION_MAX).contains(&version) && size <= limit),
            Start::Nothing => Some(false),
        },
        Err(error @ FrameError::Size { .. }) => {
            let offset = u16_at(bytes, 2).map(usize::from);
            let usual = [Some(FrameHeader::SIZE), Some(FrameHeader::SIZE - 4)];
            Some(usual.contains(&offset) && refused_frame(bytes, &error).length() > 0)
        }
        Err(error) => Some(refused_frame(bytes, &error).length() > 0),
    }
}

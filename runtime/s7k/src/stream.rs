//! Records out of a byte stream: network frames taken apart, fragments put together, damage skipped.

mod start;

use core::ops::Range;

use memchr::memmem::Finder;

use crate::device::DeviceId;
use crate::frame::{FRAME_LIMIT, Frame, FrameError, SYNC, read_header};
use crate::network::{NetworkError, NetworkHeader};
use start::{Start, refused_frame, refused_packet, starts_frame, starts_packet};

/// Puts records together from a stream of network frames, as it comes from a payload controller or from a client.
///
/// Push what was received, then take items until there are none. A packet may hold one record, a part of one, or
/// several; fragments of several transmissions may alternate. Records without network frames are accepted as well.
///
/// Sizes are believed in this order: the packet's size, then the size in the record's own frame. Packet counts and
/// sequence numbers are used only where they agree with these, because public senders fill them in differently.
///
/// A record or a packet that is longer than the limit, or of another protocol version, is refused whole: as many bytes
/// as it says that it has are dropped unread, so that nothing inside it is taken for a record. If its length is a lie,
/// what it covers is lost, and then reading goes on where the next packet or record begins. No more than
/// [`Self::SKIP_MAX`] bytes are dropped so; a longer length is believed no further, and [`Self::is_astray`] says so.
///
/// Memory is bounded: at most twice the limit, and what was pushed at once.
#[derive(Debug)]
pub struct StreamReader {
    limit: usize,
    buffer: Vec<u8>,
    /// Where reading goes on in `buffer`.
    at: usize,
    /// The packet whose data are being read, and where they end in `buffer`.
    packet: Option<(NetworkHeader, usize)>,
    /// What was wrong where reading failed, while it looks for the next start; and the first place in the rest where that
    /// may be.
    lost: Option<(StreamError, usize)>,
    /// How many bytes of a refused record or packet are still to come.
    skip: usize,
    astray: bool,
    transmissions: Vec<Transmission>,
    /// The last record that was put together from fragments.
    assembled: Vec<u8>,
    counts: StreamCounts,
}

/// Fragments of one record so far.
#[derive(Debug)]
struct Transmission {
    source: (DeviceId, u16, u16),
    next_sequence: u32,
    bytes: Vec<u8>,
    /// The record is refused: none of its bytes is kept, and so many are still to come.
    refused: Option<usize>,
}

/// What a [`StreamReader`] has met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StreamCounts {
    /// Network frames.
    pub packets: u64,
    /// Records given out.
    pub records: u64,
    /// Records that came without a network frame.
    pub bare_records: u64,
    /// Records that were put together from several packets.
    pub fragmented_records: u64,
    /// Bytes that belong to no record that could be read.
    pub skipped_bytes: u64,
    /// Fragmented records that were given up because a fragment was missing, or because others took their room.
    pub abandoned_records: u64,
}

/// What comes out of a [`StreamReader`].
#[derive(Debug, PartialEq)]
pub enum StreamItem<'a> {
    /// A whole record.
    Record(Frame<'a>),
    /// Bytes that could not be read as a record. They are counted and left out.
    Skipped {
        /// How many bytes.
        bytes: usize,
        /// What was wrong with the first of them.
        why: StreamError,
    },
}

/// Why bytes of a stream were skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamError {
    /// They are no network frame.
    #[error(transparent)]
    Packet(#[from] NetworkError),
    /// They are no data record frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A packet continues a record whose beginning did not arrive.
    #[error("packet {sequence} continues a record whose beginning did not arrive")]
    NoBeginning {
        /// The packet's sequence number.
        sequence: u32,
    },
    /// A fragmented record was given up.
    #[error("a fragmented record was given up: {reason}")]
    Abandoned {
        /// Why.
        reason: &'static str,
    },
}

/// What a step found, without borrowing.
enum Found {
    Buffered(Range<usize>),
    Assembled,
    Skipped(usize, StreamError),
}

/// What happened to a packet's data.
enum Taken {
    /// Nothing that could be given out: go on.
    Nothing,
    Found(Found),
}

/// How many fragmented records may be under way at once.
const TRANSMISSIONS: usize = 16;

/// The bytes of [`SYNC`].
const PATTERN: [u8; 4] = SYNC.to_le_bytes();

/// How many bytes before a sync pattern a packet may begin: its header, and the four bytes of the frame.
const BEFORE_SYNC: usize = NetworkHeader::SIZE + 4;

impl Default for StreamReader {
    fn default() -> Self {
        Self::new(FRAME_LIMIT)
    }
}

impl StreamReader {
    /// The most bytes of a refused record or packet that are dropped because it says that it has so many; more only if
    /// the limit is.
    pub const SKIP_MAX: usize = 64 << 20;

    /// A reader of records of at most `limit` bytes.
    #[must_use]
    pub const fn new(limit: usize) -> Self {
        Self {
            limit,
            buffer: Vec::new(),
            at: 0,
            packet: None,
            lost: None,
            skip: 0,
            astray: false,
            transmissions: Vec::new(),
            assembled: Vec::new(),
            counts: StreamCounts {
                packets: 0,
                records: 0,
                bare_records: 0,
                fragmented_records: 0,
                skipped_bytes: 0,
                abandoned_records: 0,
            },
        }
    }

    /// Takes in what was received.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.at > 0 {
            self.buffer.drain(..self.at);
            if let Some((_, end)) = &mut self.packet {
                *end -= self.at;
            }
            self.at = 0;
        }
        self.buffer.extend_from_slice(bytes);
    }

    /// Whether a record or a packet said that it has more bytes than are ever dropped for one: see [`Self::SKIP_MAX`].
    /// Behind these the reader looks for the next beginning, which may lie inside of what it refused. A reader that
    /// obeys what it reads closes the connection instead.
    #[must_use]
    pub const fn is_astray(&self) -> bool {
        self.astray
    }

    /// What has been met so far.
    #[must_use]
    pub const fn counts(&self) -> &StreamCounts {
        &self.counts
    }

    /// The next item; `None` until more is pushed.
    #[expect(clippy::should_implement_trait, reason = "items borrow from the reader")]
    pub fn next(&mut self) -> Option<StreamItem<'_>> {
        let bytes = match self.advance()? {
            Found::Buffered(range) => &self.buffer[range],
            Found::Assembled => &self.assembled[..],
            Found::Skipped(bytes, why) => {
                self.counts.skipped_bytes += bytes as u64;
                return Some(StreamItem::Skipped { bytes, why });
            }
        };
        match Frame::read(bytes, self.limit) {
            Ok(frame) => {
                self.counts.records += 1;
                Some(StreamItem::Record(frame))
            }
            Err(error) => Some(StreamItem::Skipped {
                bytes: bytes.len(),
                why: error.into(),
            }),
        }
    }

    fn advance(&mut self) -> Option<Found> {
        loop {
            if self.skip > 0 {
                let here = self.skip.min(self.buffer.len() - self.at);
                (self.at, self.skip) = (self.at + here, self.skip - here);
                self.counts.skipped_bytes += here as u64;
            }
            match self.packet {
                Some((_, end)) if self.at >= end => self.packet = None,
                Some((header, end)) => {
                    if let Taken::Found(found) = self.packet_data(&header, end) {
                        return Some(found);
                    }
                }
                None => {
                    if let Taken::Found(found) = self.boundary()? {
                        return Some(found);
                    }
                }
            }
        }
    }

    /// Reads at a place where a packet, or a record without one, should begin. `None` waits for more bytes.
    fn boundary(&mut self) -> Option<Taken> {
        if let Some((why, from)) = self.lost {
            return self.find_start(why, from);
        }
        let rest = &self.buffer[self.at..];
        let start = rest.first_chunk::<8>()?;
        let offset = u16::from_le_bytes([start[2], start[3]]);
        if start[4..] == PATTERN && usize::from(offset) != NetworkHeader::SIZE {
            return match Frame::read(rest, self.limit) {
                Ok(frame) => {
                    self.counts.bare_records += 1;
                    let range = self.at..self.at + frame.bytes().len();
                    self.at = range.end;
                    Some(Taken::Found(Found::Buffered(range)))
                }
                Err(FrameError::Incomplete { .. }) => None,
                Err(error) => match refused_frame(rest, &error) {
                    Start::Waits => None,
                    Start::Refused(declared) => Some(self.refuse(declared, error.into())),
                    Start::Nothing => self.find_start(error.into(), 1),
                },
            };
        }
        match NetworkHeader::check(rest, self.limit) {
            Ok(header) => {
                let packet = rest.get(..header.packet_size as usize)?;
                self.counts.packets += 1;
                self.packet = Some((header, self.at + packet.len()));
                self.at += usize::from(header.offset);
                Some(Taken::Nothing)
            }
            Err(NetworkError::Incomplete { .. }) => None,
            Err(error) => match refused_packet(rest, &error) {
                Start::Waits => None,
                Start::Refused(declared) => Some(self.refuse(declared, error.into())),
                Start::Nothing => self.find_start(error.into(), 1),
            },
        }
    }

    /// Drops as many bytes as a record or a packet says that it has, those that are still to come too.
    fn refuse(&mut self, declared: usize, why: StreamError) -> Taken {
        let declared = self.believed(declared);
        let here = declared.min(self.buffer.len() - self.at);
        self.at += here;
        self.skip = declared - here;
        Taken::Found(Found::Skipped(here, why))
    }

    /// How much of a length is believed.
    fn believed(&mut self, declared: usize) -> usize {
        let most = Self::SKIP_MAX.max(self.limit);
        self.astray |= declared > most;
        declared.min(most)
    }

    /// Skips to the next place where a packet or a record begins, `from` bytes on or later. Only a sync pattern shows such
    /// a place, so that what is found does not depend on how much was received at once.
    fn find_start(&mut self, why: StreamError, from: usize) -> Option<Taken> {
        let rest = &self.buffer[self.at..];
        self.lost = Some((why, from));
        let mut skipped = None;
        for sync in Finder::new(&PATTERN).find_iter(rest) {
            let packet = sync.checked_sub(BEFORE_SYNC).filter(|at| *at >= from);
            let packet = packet.filter(|at| starts_packet(&rest[*at..], self.limit));
            let frame = sync.checked_sub(4).filter(|at| *at >= from);
            match (packet, frame.map(|at| starts_frame(&rest[at..], self.limit))) {
                (Some(at), _) => skipped = Some(at),
                (None, Some(Some(true))) => skipped = frame,
                // The next bytes decide.
                (None, Some(None)) => return None,
                (None, Some(Some(false)) | None) => continue,
            }
            break;
        }
        let bytes = match skipped {
            Some(bytes) => {
                self.lost = None;
                bytes
            }
            // A pattern may still begin in the last bytes, and its packet as far before it.
            None => {
                let bytes = rest.len().saturating_sub(BEFORE_SYNC + PATTERN.len() - 1);
                self.lost = Some((why, from.saturating_sub(bytes)));
                bytes
            }
        };
        self.at += bytes;
        match (bytes, self.lost) {
            (0, Some(_)) => None,
            (0, None) => Some(Taken::Nothing),
            _ => Some(Taken::Found(Found::Skipped(bytes, why))),
        }
    }

    /// Reads the next record, or part of one, from a packet's data.
    fn packet_data(&mut self, header: &NetworkHeader, end: usize) -> Taken {
        let source = (header.source_device, header.source_enumerator, header.transmission);
        let data = &self.buffer[self.at..end];
        if let Some(index) = self.transmissions.iter().position(|known| known.source == source) {
            let numbered = header.total_packets > 1;
            if let Some(left) = self.transmissions[index].refused {
                return self.drop_refused(index, left, header, end);
            }
            let begins = self.begins(data);
            if (numbered && header.sequence == self.transmissions[index].next_sequence) || !(numbered || begins) {
                return self.append(index, end);
            }
            return self.abandon(
                index,
                if begins {
                    "another record began"
                } else {
                    "a packet is missing"
                },
            );
        }
        // By its own numbers this packet continues one record, whatever its bytes look like.
        let at_start = self.at + header.packet_size as usize == end + usize::from(header.offset);
        if at_start && header.total_packets > 1 && header.total_records <= 1 && header.sequence > 0 {
            let skipped = end - self.at;
            self.at = end;
            let sequence = header.sequence;
            return Taken::Found(Found::Skipped(skipped, StreamError::NoBeginning { sequence }));
        }
        match Frame::read(data, self.limit) {
            Ok(frame) => {
                let range = self.at..self.at + frame.bytes().len();
                self.at = range.end;
                Taken::Found(Found::Buffered(range))
            }
            Err(FrameError::Incomplete { .. }) if data.len() < 8 || self.begins(data) => {
                let bytes = data.to_vec();
                self.at = end;
                self.transmissions.push(Transmission {
                    source,
                    next_sequence: header.sequence.wrapping_add(1),
                    bytes,
                    refused: None,
                });
                self.make_room()
            }
            Err(error) => {
                let why = match error {
                    FrameError::Sync { .. } if header.sequence > 0 => StreamError::NoBeginning {
                        sequence: header.sequence,
                    },
                    FrameError::Incomplete { .. }
                    | FrameError::Sync { .. }
                    | FrameError::Version { .. }
                    | FrameError::Size { .. }
                    | FrameError::Offset { .. }
                    | FrameError::OptionalOffset { .. } => error.into(),
                };
                // The packet's own size says where the next packet begins. Further packets may continue the record.
                let skipped = end - self.at;
                let declared = refused_frame(data, &error).length();
                self.at = end;
                if header.total_packets != 1 && declared > skipped {
                    let left = self.believed(declared) - skipped;
                    self.transmissions.push(Transmission {
                        source,
                        next_sequence: header.sequence.wrapping_add(1),
                        bytes: Vec::new(),
                        refused: Some(left),
                    });
                    if self.transmissions.len() > TRANSMISSIONS {
                        self.transmissions.remove(0);
                        self.counts.abandoned_records += 1;
                    }
                }
                Taken::Found(Found::Skipped(skipped, why))
            }
        }
    }

    /// Drops a packet's data that belong to a refused record.
    fn drop_refused(&mut self, index: usize, left: usize, header: &NetworkHeader, end: usize) -> Taken {
        let transmission = &mut self.transmissions[index];
        if header.total_packets > 1 && header.sequence != transmission.next_sequence {
            // The record ended before its length: what this packet is, its own header says.
            self.transmissions.remove(index);
            return Taken::Nothing;
        }
        let here = left.min(end - self.at);
        transmission.next_sequence = transmission.next_sequence.wrapping_add(1);
        transmission.refused = Some(left - here);
        if left == here {
            self.transmissions.remove(index);
        }
        self.at += here;
        self.counts.skipped_bytes += here as u64;
        Taken::Nothing
    }

    /// Whether the data begin with a frame, as far as they go.
    fn begins(&self, data: &[u8]) -> bool {
        match read_header(data, self.limit) {
            Ok(_) | Err(FrameError::Size { .. }) => true,
            Err(FrameError::Incomplete { .. }) => data.get(4..8) == Some(&PATTERN),
            Err(
                FrameError::Sync { .. }
                | FrameError::Version { .. }
                | FrameError::Offset { .. }
                | FrameError::OptionalOffset { .. },
            ) => false,
        }
    }

    /// Appends a packet's data to a record under way, as far as they belong to it.
    fn append(&mut self, index: usize, end: usize) -> Taken {
        let transmission = &mut self.transmissions[index];
        let had = transmission.bytes.len();
        let data = &self.buffer[self.at..end];
        transmission.bytes.extend_from_slice(data);
        transmission.next_sequence = transmission.next_sequence.wrapping_add(1);
        match Frame::read(&transmission.bytes, self.limit) {
            Ok(frame) => {
                let length = frame.bytes().len();
                let mut bytes = self.transmissions.remove(index).bytes;
                bytes.truncate(length);
                self.assembled = bytes;
                self.counts.fragmented_records += 1;
                // The rest of the packet may hold further records.
                self.at += length.saturating_sub(had);
                Taken::Found(Found::Assembled)
            }
            Err(FrameError::Incomplete { .. }) => {
                self.at = end;
                self.make_room()
            }
            Err(error) => {
                let skipped = transmission.bytes.len();
                let declared = refused_frame(&transmission.bytes, &error).length();
                transmission.bytes = Vec::new();
                if declared > skipped {
                    let left = self.believed(declared) - skipped;
                    self.transmissions[index].refused = Some(left);
                } else {
                    self.transmissions.remove(index);
                }
                self.at = end;
                Taken::Found(Found::Skipped(skipped, error.into()))
            }
        }
    }

    /// Gives up the oldest record under way if there are too many, or if they take too much memory.
    fn make_room(&mut self) -> Taken {
        let bytes: usize = self
            .transmissions
            .iter()
            .map(|transmission| transmission.bytes.len())
            .sum();
        if self.transmissions.len() <= TRANSMISSIONS && bytes <= self.limit {
            return Taken::Nothing;
        }
        self.abandon(0, "too many fragmented records are under way")
    }

    fn abandon(&mut self, index: usize, reason: &'static str) -> Taken {
        let bytes = self.transmissions.remove(index).bytes.len();
        self.counts.abandoned_records += 1;
        Taken::Found(Found::Skipped(bytes, StreamError::Abandoned { reason }))
    }
}

#[cfg(test)]
mod tests;

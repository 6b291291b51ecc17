//! Network frames (NF): what encloses records on the wire, and never in files.

use crate::device::DeviceId;
use crate::layout::{Range, layouts};

layouts! {
    /// The header of a network frame. A record travels in one or more of them, all but the last of the same size.
    "Volume I, network frame" NetworkHeader network_header {
        /// Protocol version.
        version: u16, "protocol version", Range::new(4.0, 5.0);
        /// Bytes from the packet's start to its data: 36.
        offset: u16, "bytes", Range::new(36.0, 65_535.0);
        /// Number of packets that the record is split into. A public sender writes 0.
        total_packets: u32, "count", Range::ANY;
        /// Number of records in the packets of this transmission.
        total_records: u16, "count", Range::new(1.0, 65_535.0);
        /// Tells transmissions of a sender apart.
        transmission: u16, "identifier", Range::ANY;
        /// Length of this packet, with this header.
        packet_size: u32, "bytes", Range::new(36.0, 4_294_967_295.0);
        /// Length of all packets of the transmission, without their headers.
        total_size: u32, "bytes", Range::ANY;
        /// Number of this packet in its transmission, from 0. A public sender counts records instead.
        sequence: u32, "index", Range::ANY;
        /// The device that the packet is for; 0 for none in particular.
        destination_device: DeviceId, "device identifier", Range::ANY;
        /// Tells apart several destinations of one kind.
        destination_enumerator: u16, "system enumerator", Range::ANY;
        /// Tells apart several sources of one kind.
        source_enumerator: u16, "system enumerator", Range::ANY;
        /// The device that the packet is from.
        source_device: DeviceId, "device identifier", Range::ANY;
    }
}

/// Why bytes are no network frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// The bytes end before the packet does.
    #[error("the packet ends after {found} of {needed} bytes")]
    Incomplete {
        /// Bytes that there are.
        found: usize,
        /// Bytes that the packet, or its header, needs.
        needed: usize,
    },
    /// The protocol version is neither 4 nor 5.
    #[error("network frame field version: protocol version {version} is not supported, only 4 and 5 are")]
    Version {
        /// The version found.
        version: u16,
    },
    /// The data would begin inside the header or behind the packet's end.
    #[error("network frame field offset: {offset} does not point into the packet of {packet_size} bytes")]
    Offset {
        /// The offset found, bytes.
        offset: u16,
        /// The packet's size, bytes.
        packet_size: u32,
    },
    /// The packet is shorter than its header or longer than the limit.
    #[error(
        "network frame field packet_size: {packet_size} bytes is outside {} to {limit}",
        NetworkHeader::SIZE
    )]
    Size {
        /// The size found, bytes.
        packet_size: u32,
        /// The limit that the reader was given, bytes.
        limit: usize,
    },
}

impl NetworkHeader {
    /// The header of a transmission from a device to nobody in particular, in version 4.
    #[must_use]
    pub const fn new(source: DeviceId, transmission: u16) -> Self {
        Self {
            version: 4,
            offset: 36,
            total_packets: 1,
            total_records: 1,
            transmission,
            packet_size: 36,
            total_size: 0,
            sequence: 0,
            destination_device: DeviceId::UNSPECIFIED,
            destination_enumerator: 0,
            source_enumerator: 0,
            source_device: source,
        }
    }

    /// Reads and checks the header of the packet at the start of `bytes`, whether the rest of it is there or not.
    ///
    /// # Errors
    /// [`NetworkError`].
    pub fn check(bytes: &[u8], limit: usize) -> Result<Self, NetworkError> {
        let incomplete = NetworkError::Incomplete {
            found: bytes.len(),
            needed: Self::SIZE,
        };
        let header = Self::read(bytes).map_err(|_| incomplete)?;
        if !matches!(header.version, 4 | 5) {
            return Err(NetworkError::Version {
                version: header.version,
            });
        }
        let packet = header.packet_size as usize;
        if packet < Self::SIZE || packet > limit.saturating_add(Self::SIZE) {
            return Err(NetworkError::Size {
                packet_size: header.packet_size,
                limit,
            });
        }
        let offset = usize::from(header.offset);
        if offset < Self::SIZE || offset > packet {
            return Err(NetworkError::Offset {
                offset: header.offset,
                packet_size: header.packet_size,
            });
        }
        Ok(header)
    }

    /// Appends the record in as many packets as it needs, of at most `packet_max` bytes each with their headers.
    /// This header says who sends it; sizes and counts are filled in. `packet_max` below 37 counts as 37.
    ///
    /// # Errors
    /// [`crate::TooLong`] if the record has more bytes than the header can say; then nothing is appended.
    pub fn enclose(&self, record: &[u8], packet_max: usize, out: &mut Vec<u8>) -> Result<(), crate::TooLong> {
        let limit = u32::MAX as usize - Self::SIZE;
        let too_long = crate::TooLong {
            size: record.len(),
            limit,
        };
        let total_size = u32::try_from(record.len()).map_err(|_| too_long)?;
        let data_max = packet_max.clamp(Self::SIZE + 1, limit) - Self::SIZE;
        let total_packets = u32::try_from(record.len().div_ceil(data_max)).map_err(|_| too_long)?;
        for (sequence, data) in (0..).zip(record.chunks(data_max)) {
            let packet_size = u32::try_from(Self::SIZE + data.len()).map_err(|_| too_long)?;
            Self {
                offset: 36,
                total_packets,
                packet_size,
                total_size,
                sequence,
                ..*self
            }
            .write(out);
            out.extend_from_slice(data);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_split_into_packets_of_one_size_but_for_the_last() {
        let record: Vec<u8> = (0..100).collect();
        let mut out = Vec::new();
        NetworkHeader::new(DeviceId(7), 5)
            .enclose(&record, 36 + 40, &mut out)
            .unwrap();
        let mut rest = out.as_slice();
        let mut back = Vec::new();
        for (sequence, data) in [(0, 40), (1, 40), (2, 20)] {
            let header = NetworkHeader::check(rest, 1000).unwrap();
            assert_eq!(
                (header.total_packets, header.total_size, header.sequence),
                (3, 100, sequence)
            );
            assert_eq!((header.packet_size, header.transmission), (36 + data, 5));
            let (packet, behind) = rest.split_at(header.packet_size as usize);
            back.extend_from_slice(&packet[36..]);
            rest = behind;
        }
        assert_eq!((back, rest.len()), (record, 0));
    }

    #[test]
    fn what_is_wrong_with_a_packet_is_named() {
        let mut good = Vec::new();
        NetworkHeader::new(DeviceId(7), 0)
            .enclose(b"abcd", 1000, &mut good)
            .unwrap();
        let changed = |at: usize, bytes: &[u8]| {
            let mut packet = good.clone();
            packet[at..at + bytes.len()].copy_from_slice(bytes);
            NetworkHeader::check(&packet, 100).unwrap_err()
        };
        assert_eq!(changed(0, &[3]), NetworkError::Version { version: 3 });
        assert_eq!(
            changed(2, &[35]),
            NetworkError::Offset {
                offset: 35,
                packet_size: 40
            }
        );
        assert_eq!(
            changed(2, &[41]),
            NetworkError::Offset {
                offset: 41,
                packet_size: 40
            }
        );
        assert_eq!(
            changed(12, &[35]),
            NetworkError::Size {
                packet_size: 35,
                limit: 100
            }
        );
        assert_eq!(
            changed(12, &[137]),
            NetworkError::Size {
                packet_size: 137,
                limit: 100
            }
        );
        let short = NetworkHeader::check(&good[..35], 100).unwrap_err();
        assert_eq!(short, NetworkError::Incomplete { found: 35, needed: 36 });
    }
}

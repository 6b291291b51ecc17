//! The two checksums of the format.

/// The checksum of a data record frame: the sum of all bytes as unsigned numbers, modulo 2^32.
#[must_use]
pub fn byte_sum(bytes: &[u8]) -> u32 {
    // No block's sum can overflow, so the compiler turns it into vector additions.
    bytes
        .chunks(4096)
        .map(|block| block.iter().map(|byte| u32::from(*byte)).sum::<u32>())
        .fold(0, u32::wrapping_add)
}

/// How the checksum of a Bluefin frame is computed, which Volume III leaves open (Table 11: "CRC32").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BluefinChecksum {
    /// IEEE CRC-32 over the whole packet with the checksum's own four bytes as zeros.
    #[default]
    WholePacket,
    /// IEEE CRC-32 over the data that follow the frame's header.
    DataOnly,
    /// None: zero is written, and none is checked.
    None,
}

/// IEEE CRC-32 (polynomial 0x04C11DB7, reflected, as in zip).
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for part in parts {
        hasher.update(part);
    }
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_sum_wraps_and_counts_bytes_as_unsigned() {
        assert_eq!(byte_sum(&[]), 0);
        assert_eq!(byte_sum(&[255, 255, 1]), 511);
        // 16,843,010 times 255 is 254 more than 2^32.
        assert_eq!(byte_sum(&vec![255; 16_843_010]), 254);
    }

    #[test]
    fn a_setting_names_the_checksum() {
        let kinds = [
            ("\"whole_packet\"", BluefinChecksum::WholePacket),
            ("\"data_only\"", BluefinChecksum::DataOnly),
            ("\"none\"", BluefinChecksum::None),
        ];
        for (text, kind) in kinds {
            assert_eq!(serde_json::from_str::<BluefinChecksum>(text).unwrap(), kind);
            assert_eq!(serde_json::to_string(&kind).unwrap(), text);
        }
    }

    #[test]
    fn the_crc_is_the_one_of_zip() {
        assert_eq!(crc32(&[b"1234", b"56789"]), 0xCBF4_3926);
    }
}

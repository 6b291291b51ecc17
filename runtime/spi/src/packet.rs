use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::codes::FrameReceivedStatus;
use crate::hex;

/// One frame of an acoustic packet, as the modem received it (SPI 9.3). The data are serialised as hexadecimal digits.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReceivedFrame {
    /// How it was received; unset if there is no such frame.
    pub status: FrameReceivedStatus,
    /// Its bytes; empty if there is no such frame.
    #[serde(with = "hex")]
    pub data: Box<[u8]>,
}

/// The frames of an acoustic packet to send: 1 to 8 frames, none of them empty (SPI 9.4).
///
/// The modem limits how long a frame may be; all frames together must fit into [`crate::MAX_LINE`]. Serialised as a
/// list of strings of hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FrameData(Box<[Box<[u8]>]>);

/// Why frames cannot make a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameDataError {
    /// There are no frames, or more than a packet holds.
    #[error("{count} frames: expected 1 to {}", FrameData::MAX_FRAMES)]
    Count {
        /// How many there are.
        count: usize,
    },
    /// A frame has no bytes.
    #[error("frame {index} is empty")]
    Empty {
        /// Which frame, from 0.
        index: usize,
    },
}

impl FrameData {
    /// How many frames a packet holds.
    pub const MAX_FRAMES: usize = 8;

    /// Makes a packet's frames from the bytes of each.
    ///
    /// # Errors
    /// [`FrameDataError`] if there are none, more than [`FrameData::MAX_FRAMES`], or if one is empty.
    pub fn new(frames: impl IntoIterator<Item: Into<Box<[u8]>>>) -> Result<Self, FrameDataError> {
        // Takes at most one frame too many, so that an endless iterator ends.
        let frames: Box<[Box<[u8]>]> = frames.into_iter().take(Self::MAX_FRAMES + 1).map(Into::into).collect();
        if !(1..=Self::MAX_FRAMES).contains(&frames.len()) {
            return Err(FrameDataError::Count { count: frames.len() });
        }
        match frames.iter().position(|frame| frame.is_empty()) {
            Some(index) => Err(FrameDataError::Empty { index }),
            None => Ok(Self(frames)),
        }
    }

    /// The bytes of each frame.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &[u8]> + '_ {
        self.0.iter().map(|frame| &**frame)
    }

    /// How many frames there are, 1 to 8.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }
}

impl Serialize for FrameData {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.frames().map(hex::Digits))
    }
}

impl<'de> Deserialize<'de> for FrameData {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Frame(#[serde(with = "hex")] Box<[u8]>);
        let frames = Vec::<Frame>::deserialize(deserializer)?;
        Self::new(frames.into_iter().map(|frame| frame.0)).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_holds_one_to_eight_frames_that_are_not_empty() {
        assert_eq!(FrameData::new([[1u8; 4]; 8]).unwrap().count(), 8);
        assert_eq!(FrameData::new([[1u8; 4]; 9]), Err(FrameDataError::Count { count: 9 }));
        assert_eq!(
            FrameData::new(<[[u8; 1]; 0]>::default()),
            Err(FrameDataError::Count { count: 0 })
        );
        assert_eq!(
            FrameData::new([vec![1], vec![]]),
            Err(FrameDataError::Empty { index: 1 })
        );
        assert_eq!(
            FrameData::new(std::iter::repeat([0u8])),
            Err(FrameDataError::Count { count: 9 })
        );
    }

    #[test]
    fn frames_are_serialised_as_digits_and_checked_when_read_back() {
        let frames = FrameData::new([vec![0x0a, 0xff], vec![7]]).unwrap();
        assert_eq!(serde_json::to_string(&frames).unwrap(), r#"["0AFF","07"]"#);
        assert_eq!(serde_json::from_str::<FrameData>(r#"["0aFf","07"]"#).unwrap(), frames);
        for bad in [
            "[]",
            r#"[""]"#,
            r#"["0"]"#,
            r#"["0G"]"#,
            r#"["é"]"#,
            r#"["0A","0A","0A","0A","0A","0A","0A","0A","0A"]"#,
        ] {
            assert!(serde_json::from_str::<FrameData>(bad).is_err(), "{bad}");
        }
        let frame = ReceivedFrame {
            status: FrameReceivedStatus::Good,
            data: [0xabu8].into(),
        };
        assert_eq!(
            serde_json::to_string(&frame).unwrap(),
            r#"{"status":"good","data":"AB"}"#
        );
    }
}

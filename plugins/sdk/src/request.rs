use crate::{Packet, Request, StepInput, Window};

/// The longest text of a request, bytes. A longer text is a failure of the plugin.
pub const TEXT_BYTES: usize = 256;
/// The most frames in a [`Packet`] (SPI 9.4). More frames are a failure of the plugin.
pub const FRAMES: usize = 8;
/// The longest frame in a [`Packet`], bytes. A longer frame is a failure of the plugin. The modem's mode may allow
/// less.
pub const FRAME_BYTES: usize = 1024;

/// Whether a text can be sent in a sentence: printable ASCII without comma, asterisk and dollar (SPI 4.2), at most
/// [`TEXT_BYTES`] bytes. The runtime rejects a [`Topside`](crate::Topside) with any other text, and also one whose text
/// contains a command's three letters in upper case or has more than 200 bytes.
#[must_use]
pub fn is_plain(text: &str) -> bool {
    text.len() <= TEXT_BYTES
        && text
            .bytes()
            .all(|byte| matches!(byte, b' '..=b'~') && !b",*$".contains(&byte))
}

impl Request {
    /// The request's own tag, which its outcomes carry too. `None` for a request without outcomes, and for a cancel,
    /// which carries the tag of the request to cancel.
    #[must_use]
    pub const fn tag(&self) -> Option<u64> {
        match self {
            Self::Modify(asked) => Some(asked.tag),
            Self::Trackline(asked) => Some(asked.tag),
            Self::Trackcircle(asked) => Some(asked.tag),
            Self::GpsHit(asked) => Some(asked.tag),
            Self::Topside(asked) => Some(asked.tag),
            Self::DvlTrigger(asked) => Some(asked.tag),
            Self::Silent(asked) => Some(asked.tag),
            Self::Trim(tag) | Self::Buoyancy(tag) => Some(*tag),
            Self::Packet(asked) => Some(asked.tag),
            Self::Station(asked) => Some(asked.tag),
            Self::SonarAngle(asked) => Some(asked.tag),
            Self::Camera(asked) => Some(asked.tag),
            Self::Light(asked) => Some(asked.tag),
            Self::SonarSet(asked) => Some(asked.tag),
            Self::SonarLog(asked) => Some(asked.tag),
            Self::EndModify | Self::Cancel(_) | Self::Message(_) | Self::EndStation | Self::Timer(_) => None,
        }
    }
}

impl Packet {
    /// Splits data into a packet of frames of `frame_bytes` bytes each; the last frame may be shorter. Returns `None`
    /// if `data` is empty, if `frame_bytes` is 0 or above [`FRAME_BYTES`], or if more than [`FRAMES`] frames would be
    /// needed.
    #[must_use]
    pub fn of(tag: u64, destination: u32, mode: i32, data: &[u8], frame_bytes: usize) -> Option<Self> {
        if data.is_empty() || !(1..=FRAME_BYTES).contains(&frame_bytes) || data.len().div_ceil(frame_bytes) > FRAMES {
            return None;
        }
        Some(Self {
            tag,
            destination,
            mode,
            acknowledge: false,
            frames: data.chunks(frame_bytes).map(<[u8]>::to_vec).collect(),
        })
    }
}

impl Window {
    /// Whether the window is still open at this step.
    #[must_use]
    pub const fn is_open(&self, input: &StepInput) -> bool {
        input.now_ns < self.until_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_has_at_most_eight_frames() {
        let packet = Packet::of(1, 2, 0, &[7; 70], 32).unwrap();
        let lengths: Vec<usize> = packet.frames.iter().map(Vec::len).collect();
        assert_eq!(lengths, [32, 32, 6]);
        assert!(Packet::of(1, 2, 0, &[7; 256], 32).is_some());
        assert_eq!(Packet::of(1, 2, 0, &[7; 257], 32), None);
        assert_eq!(Packet::of(1, 2, 0, &[], 32), None);
        assert_eq!(Packet::of(1, 2, 0, &[7], 0), None);
        assert_eq!(Packet::of(1, 2, 0, &[7], FRAME_BYTES + 1), None);
    }

    #[test]
    fn only_plain_text_can_be_sent_in_a_sentence() {
        assert!(is_plain("depth 12.5 m: steady"));
        for text in ["12,5", "a*4E", "$BPABT", "two\nlines", "caf\u{e9}", &"x".repeat(257)] {
            assert!(!is_plain(text), "{text}");
        }
    }

    #[test]
    fn a_window_is_open_until_its_end() {
        let window = Window {
            until_ns: 5,
            address: 1,
            device: "WHOI".into(),
        };
        let at = |now_ns| StepInput {
            now_ns,
            ..StepInput::default()
        };
        assert!(window.is_open(&at(4)));
        assert!(!window.is_open(&at(5)));
    }
}

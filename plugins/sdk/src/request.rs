use crate::{Packet, Request, StepInput, Window};

/// The longest text of a request, bytes. A longer one is a failure of the plugin.
pub const TEXT_BYTES: usize = 256;
/// The most frames of a [`Packet`] (SPI 9.4). More are a failure of the plugin.
pub const FRAMES: usize = 8;
/// The longest frame of a [`Packet`], bytes. A longer one is a failure of the plugin; the modem's mode may take less.
pub const FRAME_BYTES: usize = 1024;

/// Whether a text can stand in a sentence: printable ASCII without comma, asterisk and dollar (SPI 4.2), at most
/// [`TEXT_BYTES`]. A [`Topside`](crate::Topside) with any other is rejected, as is one with a command's three letters in
/// upper case or of more than 200 bytes.
#[must_use]
pub fn is_plain(text: &str) -> bool {
    text.len() <= TEXT_BYTES
        && text
            .bytes()
            .all(|byte| matches!(byte, b' '..=b'~') && !b",*$".contains(&byte))
}

impl Request {
    /// The plugin's name for it, which its outcomes carry. None for what has no outcome, and for a cancel, whose tag is
    /// that of what it cancels.
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
            Self::EndModify | Self::Cancel(_) | Self::Message(_) | Self::EndStation | Self::Timer(_) => None,
        }
    }
}

impl Packet {
    /// A packet of data, in as many frames of `frame_bytes` as it takes; the last one may be shorter. None where there is
    /// no data, a frame would be empty or longer than [`FRAME_BYTES`], or there would be more than [`FRAMES`].
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
    /// Whether it is still open in a step.
    #[must_use]
    pub const fn is_open(&self, input: &StepInput) -> bool {
        input.now_ns < self.until_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_has_no_more_frames_than_there_are() {
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
    fn only_plain_text_can_stand_in_a_sentence() {
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

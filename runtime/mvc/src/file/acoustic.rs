use serde::Deserialize;

use crate::error::{MvcError, check};

/// How many bytes the frames of a packet may have together: BFCPR carries them as digits on one line.
const PACKET_BYTES_MAX: usize = 8 * 256;

/// The `[acoustic]` section: the payload's use of the acoustic modem (SPI 9).
///
/// The use of windows "must first be worked out with Bluefin": without a period there are none, and every BPCPD fails
/// because it is outside a window.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AcousticConfig {
    /// Whether the payload may use the modem ("supported only on certain vehicles"). Otherwise every BPCPD fails.
    pub equipped: bool,
    /// The modem.
    pub device: AcousticDevice,
    /// The address of the vehicle's modem.
    pub address: u32,
    /// When the first window opens, seconds after the start, 0 to 1e6.
    pub first_s: f64,
    /// From the opening of one window to that of the next, seconds, 1 to 86400; `None` for no windows.
    pub period_s: Option<f64>,
    /// How long a window is open, seconds, 0.1 or more and at least 0.1 less than the period.
    pub length_s: f64,
    /// How many packets of the payload may wait, 1 to 256. More fail.
    pub queue_max: u32,
    /// From the moment that the modem takes a packet to its first sound, seconds, 0 to 60.
    pub latency_s: f64,
    /// How long one frame sounds, seconds, 0.01 to 60.
    pub frame_s: f64,
    /// The speed of sound with which travel times are computed, metres a second, 1000 to 2000.
    pub sound_speed_mps: f64,
    /// How long the other modem takes to begin its acknowledgement, seconds, 0 to 60.
    pub turnaround_s: f64,
    /// How long an acknowledgement sounds, seconds, 0 to 60.
    pub ack_s: f64,
    /// How long after the packet the modem waits for an acknowledgement, seconds, 0.1 to 600.
    pub ack_timeout_s: f64,
    /// How likely a packet or an acknowledgement is not heard at all, 0 to 1.
    pub loss_chance: f64,
    /// How likely a received frame has a wrong byte, 0 to 1.
    pub corrupted_chance: f64,
    /// How likely a received frame cannot be decoded, 0 to 1.
    pub undecodable_chance: f64,
    /// How likely BFCPS is not sent (SPI 9.2: "a status message may not be generated for every request"), 0 to 1.
    pub status_lost_chance: f64,
    /// From one packet of the vehicle's own to the next, seconds, 1 to 86400; `None` for no packets. They stay out of
    /// the payload's windows, and BFCPS reports them too (SPI 9.2).
    pub own_period_s: Option<f64>,
    /// The identifier of the vehicle's first own packet. The next ones count up.
    pub own_request_first: u32,
    /// Other vehicles with a modem.
    pub peers: Vec<PeerConfig>,
}

/// The modems that the specification names (SPI 9.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum AcousticDevice {
    /// Sonardyne, sixth generation.
    Sonardyne6G,
    /// WHOI Micro-Modem with frequency-shift keying.
    #[serde(rename = "WHOI")]
    Whoi,
    /// WHOI Micro-Modem with phase-shift keying.
    #[default]
    #[serde(rename = "WHOIPSK")]
    WhoiPsk,
}

impl AcousticDevice {
    /// Its name in BFCMA.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sonardyne6G => "Sonardyne6G",
            Self::Whoi => "WHOI",
            Self::WhoiPsk => "WHOIPSK",
        }
    }

    /// The greatest number of frames of a packet in a telemetry mode, and the greatest number of bytes of a frame;
    /// `None` if the device does not have the mode.
    ///
    /// The WHOI modes are the packet types of the Micro-Modem's documentation. Each of Sonardyne's eight telemetry
    /// schemes carries one message; its length here is an assumption.
    #[must_use]
    pub const fn frames(self, mode: i32) -> Option<(usize, usize)> {
        match (self, mode) {
            (Self::Sonardyne6G, 0..=7) => Some((1, 128)),
            (Self::Whoi | Self::WhoiPsk, 0) => Some((1, 32)),
            (Self::WhoiPsk, 1 | 2) => Some((3, 64)),
            (Self::WhoiPsk, 3 | 4) => Some((2, 256)),
            (Self::WhoiPsk, 5) => Some((8, 256)),
            (Self::WhoiPsk, 6) => Some((6, 32)),
            (Self::Sonardyne6G | Self::Whoi | Self::WhoiPsk, _) => None,
        }
    }
}

/// Another vehicle with a modem: it hears packets, acknowledges them, and sends its own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PeerConfig {
    /// The address of its modem.
    pub address: u32,
    /// Where it is at the start, metres east in the world's frame.
    pub east_m: f64,
    /// Where it is at the start, metres north in the world's frame.
    pub north_m: f64,
    /// Its depth, metres.
    #[serde(default)]
    pub depth_m: f64,
    /// Its velocity towards the frame's east, metres a second.
    #[serde(default)]
    pub east_mps: f64,
    /// Its velocity towards the frame's north, metres a second.
    #[serde(default)]
    pub north_mps: f64,
    /// Whether it acknowledges packets that ask for it.
    #[serde(default = "yes")]
    pub acknowledges: bool,
    /// The packets that it sends.
    #[serde(default)]
    pub packets: Vec<PeerPacket>,
}

/// A packet that a peer sends, once or again and again.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PeerPacket {
    /// When it first begins to sound, seconds after the start.
    pub first_s: f64,
    /// From one time to the next, seconds, 1 to 86400; `None` to send it once.
    #[serde(default)]
    pub period_s: Option<f64>,
    /// The address of the modem that it is for; `None` for this vehicle's.
    #[serde(default)]
    pub destination: Option<u32>,
    /// Its telemetry mode; -1 is unknown (SPI 9.3).
    #[serde(default)]
    pub mode: i32,
    /// Its frames, 1 to 8: each is a text of pairs of hexadecimal digits.
    pub frames: Vec<String>,
}

const fn yes() -> bool {
    true
}

impl Default for AcousticConfig {
    fn default() -> Self {
        Self {
            equipped: true,
            device: AcousticDevice::default(),
            address: 1,
            first_s: 30.0,
            period_s: None,
            length_s: 20.0,
            queue_max: 16,
            latency_s: 0.5,
            frame_s: 1.0,
            sound_speed_mps: 1500.0,
            turnaround_s: 0.5,
            ack_s: 1.0,
            ack_timeout_s: 8.0,
            loss_chance: 0.0,
            corrupted_chance: 0.0,
            undecodable_chance: 0.0,
            status_lost_chance: 0.0,
            own_period_s: None,
            own_request_first: 1_000_000_000,
            peers: Vec::new(),
        }
    }
}

impl AcousticConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let period = self.period_s.unwrap_or(86_400.0);
        for (key, value, least, most, expected) in [
            ("acoustic.first_s", self.first_s, 0.0, 1e6, "0 to 1e6 s"),
            ("acoustic.period_s", period, 1.0, 86_400.0, "1 to 86400 s"),
            (
                "acoustic.own_period_s",
                self.own_period_s.unwrap_or(1.0),
                1.0,
                86_400.0,
                "1 to 86400 s",
            ),
            (
                "acoustic.length_s",
                self.length_s,
                0.1,
                period - 0.1,
                "0.1 s to 0.1 s less than the period",
            ),
            ("acoustic.queue_max", f64::from(self.queue_max), 1.0, 256.0, "1 to 256"),
            ("acoustic.latency_s", self.latency_s, 0.0, 60.0, "0 to 60 s"),
            ("acoustic.frame_s", self.frame_s, 0.01, 60.0, "0.01 to 60 s"),
            (
                "acoustic.sound_speed_mps",
                self.sound_speed_mps,
                1000.0,
                2000.0,
                "1000 to 2000 m/s",
            ),
            ("acoustic.turnaround_s", self.turnaround_s, 0.0, 60.0, "0 to 60 s"),
            ("acoustic.ack_s", self.ack_s, 0.0, 60.0, "0 to 60 s"),
            ("acoustic.ack_timeout_s", self.ack_timeout_s, 0.1, 600.0, "0.1 to 600 s"),
            ("acoustic.loss_chance", self.loss_chance, 0.0, 1.0, "0 to 1"),
            ("acoustic.corrupted_chance", self.corrupted_chance, 0.0, 1.0, "0 to 1"),
            (
                "acoustic.undecodable_chance",
                self.undecodable_chance,
                0.0,
                1.0,
                "0 to 1",
            ),
            (
                "acoustic.status_lost_chance",
                self.status_lost_chance,
                0.0,
                1.0,
                "0 to 1",
            ),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        for (index, peer) in self.peers.iter().enumerate() {
            let own = peer.address == self.address;
            let twice = self.peers[..index].iter().any(|other| other.address == peer.address);
            let expected = "an address of its own";
            check(
                !own && !twice,
                "acoustic.peers.address",
                f64::from(peer.address),
                expected,
            )?;
            peer.validate()?;
        }
        Ok(())
    }
}

impl PeerConfig {
    fn validate(&self) -> Result<(), MvcError> {
        for (key, value, most, expected) in [
            ("acoustic.peers.east_m", self.east_m, 50_000.0, "within 50 km"),
            ("acoustic.peers.north_m", self.north_m, 50_000.0, "within 50 km"),
            ("acoustic.peers.east_mps", self.east_mps, 20.0, "within 20 m/s"),
            ("acoustic.peers.north_mps", self.north_mps, 20.0, "within 20 m/s"),
        ] {
            check(value.abs() <= most, key, value, expected)?;
        }
        let depth = self.depth_m;
        check(
            (0.0..=12_000.0).contains(&depth),
            "acoustic.peers.depth_m",
            depth,
            "0 to 12000 m",
        )?;
        for packet in &self.packets {
            let first = packet.first_s;
            check(
                (0.0..=1e6).contains(&first),
                "acoustic.peers.packets.first_s",
                first,
                "0 to 1e6 s",
            )?;
            let period = packet.period_s.unwrap_or(1.0);
            let ok = (1.0..=86_400.0).contains(&period);
            check(ok, "acoustic.peers.packets.period_s", period, "1 to 86400 s")?;
            let mode = packet.mode;
            check(mode >= -1, "acoustic.peers.packets.mode", f64::from(mode), "-1 or more")?;
            if packet.bytes().is_none() {
                return Err(MvcError::Value {
                    key: "acoustic.peers.packets.frames",
                    value: format!("{:?}", packet.frames),
                    expected: "1 to 8 frames of 1 to 256 bytes as pairs of hexadecimal digits",
                });
            }
        }
        Ok(())
    }
}

impl PeerPacket {
    /// The bytes of its frames; `None` if a packet cannot hold them or the digits are wrong.
    pub(crate) fn bytes(&self) -> Option<Vec<Box<[u8]>>> {
        let frames: Option<Vec<Box<[u8]>>> = self.frames.iter().map(|digits| hexadecimal(digits)).collect();
        frames.filter(|frames| {
            let total: usize = frames.iter().map(|frame| frame.len()).sum();
            (1..=8).contains(&frames.len())
                && frames.iter().all(|frame| (1..=256).contains(&frame.len()))
                && total <= PACKET_BYTES_MAX
        })
    }
}

fn hexadecimal(digits: &str) -> Option<Box<[u8]>> {
    let digits = digits.as_bytes();
    if !digits.len().is_multiple_of(2) {
        return None;
    }
    let nibble = |digit: u8| char::from(digit).to_digit(16);
    digits
        .chunks(2)
        .map(|pair| Some((nibble(pair[0])? * 16 + nibble(pair[1])?) as u8))
        .collect()
}

//! What the controller's sonars need from outside: what a ping hears.

use backseat_s7k::DeviceId;
use backseat_units::{EastNorth, Timestamp};
use serde::{Deserialize, Serialize};

/// A sensor that the controller can have in its run list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SensorKind {
    /// The sub-bottom profiler, device 11000.
    SubBottom,
    /// The sidescan's low frequency, device 11001.
    SidescanLow,
    /// The sidescan's high frequency, device 11002.
    SidescanHigh,
    /// The vehicle: no sonar, but the source of the records 3100, device 11100.
    Bluefin,
}

impl SensorKind {
    /// All kinds, in the order of their devices.
    pub const ALL: [Self; 4] = [Self::SubBottom, Self::SidescanLow, Self::SidescanHigh, Self::Bluefin];

    /// The device identifier in the frames of its records.
    #[must_use]
    pub const fn device(self) -> DeviceId {
        match self {
            Self::SubBottom => DeviceId::SUB_BOTTOM,
            Self::SidescanLow => DeviceId::SIDESCAN_LOW,
            Self::SidescanHigh => DeviceId::SIDESCAN_HIGH,
            Self::Bluefin => DeviceId::BLUEFIN,
        }
    }

    /// The type of its records.
    #[must_use]
    pub const fn record_type(self) -> u32 {
        match self {
            Self::SidescanLow | Self::SidescanHigh => 3000,
            Self::SubBottom => 3001,
            Self::Bluefin => 3100,
        }
    }

    /// The number of the module that serves it, as command 16 names it.
    #[must_use]
    pub const fn module(self) -> i32 {
        match self {
            Self::SubBottom => 1,
            Self::SidescanLow | Self::SidescanHigh => 2,
            Self::Bluefin => 3,
        }
    }

    /// EdgeTech's number of the subsystem: 0 sub-bottom, 20 low and 21 high frequency.
    #[must_use]
    pub const fn subsystem(self) -> u16 {
        match self {
            Self::SubBottom | Self::Bluefin => 0,
            Self::SidescanLow => 20,
            Self::SidescanHigh => 21,
        }
    }

    /// Whether it is a sonar: whether it pings.
    #[must_use]
    pub const fn is_sonar(self) -> bool {
        !matches!(self, Self::Bluefin)
    }
}

impl core::fmt::Display for SensorKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::SubBottom => "sub-bottom profiler",
            Self::SidescanLow => "sidescan, low frequency",
            Self::SidescanHigh => "sidescan, high frequency",
            Self::Bluefin => "Bluefin vehicle",
        })
    }
}

/// Where the vehicle truly is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Its place in the world's frame.
    pub at: EastNorth,
    /// Its depth, m.
    pub depth_m: f64,
    /// Its heading clockwise from the frame's north, degrees.
    pub heading_deg: f64,
    /// Its pitch, degrees, bow up.
    pub pitch_deg: f64,
    /// Its roll, degrees, starboard down.
    pub roll_deg: f64,
    /// Its velocity over ground to the east, m/s.
    pub east_mps: f64,
    /// Its velocity over ground to the north, m/s.
    pub north_mps: f64,
    /// Its velocity downwards, m/s.
    pub down_mps: f64,
}

impl Pose {
    /// The pose so much later, at the same velocity and attitude; at most a second later, because a driver that gives
    /// no truth for longer knows no velocity either.
    #[must_use]
    pub fn after(self, seconds: f64) -> Self {
        let seconds = seconds.clamp(0.0, 1.0);
        Self {
            at: self.at + EastNorth::new(self.east_mps * seconds, self.north_mps * seconds),
            depth_m: self.depth_m + self.down_mps * seconds,
            ..self
        }
    }
}

/// The pulse of a ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Its number in the list of the sensor's pulses, from 0.
    pub id: u16,
    /// The first frequency of its sweep, Hz.
    pub start_hz: f64,
    /// The last frequency of its sweep, Hz.
    pub end_hz: f64,
    /// Its length, s.
    pub length_s: f64,
}

/// One ping of a sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ping {
    /// Its number by the sonar, from 1.
    pub number: u32,
    /// When it leaves the transducer.
    pub time: Timestamp,
    /// The vehicle's true pose at that time.
    pub pose: Pose,
    /// The slant range of the last sample, m.
    pub range_m: f64,
    /// The pulse.
    pub pulse: Pulse,
    /// The part of full power, 0 to 100 %.
    pub power_percent: f64,
    /// The receiver's gain, in the sonar's own steps.
    pub gain_steps: i32,
    /// How many samples a channel has, 1 to 65535.
    pub samples: usize,
    /// The time from sample to sample, microseconds. The first sample is at the time of the ping.
    pub sample_interval_us: u32,
    /// The speed of sound by which the sonar computes ranges, m/s.
    pub sound_speed_mps: f64,
}

/// The acoustics of the sonars. Implementations are deterministic: the same calls give the same samples.
///
/// The buffers are empty at the call. The controller fills up with zeros what is missing of [`Ping::samples`], and drops
/// what is beyond.
pub trait Sonar {
    /// The envelope that a sidescan hears to port and to starboard, in steps of its converter, 0 to 65535. `sensor` is
    /// [`SensorKind::SidescanLow`] or [`SensorKind::SidescanHigh`].
    fn side_scan(&mut self, sensor: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>);

    /// What the sub-bottom profiler hears, behind its matched filter: in-phase and quadrature, in steps of its
    /// converter.
    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>);
}

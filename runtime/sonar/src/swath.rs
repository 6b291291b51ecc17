//! The achieved swath: how wide a strip of the seabed a sidescan ping shows.
//!
//! The slant range R of a side and the altitude h span a right triangle, so the side reaches `sqrt(R² - h²)` over ground
//! on a level seabed. The altitude is the vehicle's own bottom track at the ping; without bottom lock it is the first
//! return in the imagery. A side whose channel is already in ground range reaches that range.
//!
//! First return: the samples of the side become 256 bins of their maximum. The bins within 3 % of the range belong to the
//! transmission and are left out. The bottom is at the first bin of the rest that reaches a quarter of the rest's
//! maximum, if the bin behind it reaches an eighth: one bin alone is a fish or noise. The nearer side counts, because a
//! slope or a target on one side only makes the way longer. The resolution is the range divided by 256.
//!
//! What the method does not see: a signal that fades before the end of its range, layers in the water that bend sound,
//! and slopes. So the swath is an upper bound.

use backseat_s7k::SensorIndex;
use backseat_s7k::record::{Channel, ChannelSide, Imagery, RangeKind, Samples};
use serde::Serialize;

use crate::decimation::{Decimation, decimate};
use crate::ping::{range_m, readable};

const BINS: usize = 256;
/// The bins of the transmission: 3 %.
const BLANKED: usize = 8;

/// How wide the seabed is seen on both sides of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Swath {
    /// The sensor.
    pub sensor: SensorIndex,
    /// The ping's number, by the sonar.
    pub ping: u32,
    /// To port, metres over ground; 0 if there is no such side, or if the range does not reach the seabed.
    pub port_m: f64,
    /// To starboard, metres over ground.
    pub starboard_m: f64,
    /// The altitude of which it was computed, metres; `None` if both sides are in ground range.
    pub altitude_m: Option<f64>,
    /// Where the altitude comes from.
    pub source: AltitudeSource,
}

/// Where the altitude of a swath comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AltitudeSource {
    /// The vehicle's bottom track.
    BottomLock,
    /// The first return in the imagery.
    FirstReturn,
    /// None is needed: the sonar gives ground range.
    GroundRange,
}

impl std::fmt::Display for Swath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            sensor,
            port_m,
            starboard_m,
            ..
        } = self;
        write!(
            f,
            "sensor {sensor} sees {port_m:.1} m to port and {starboard_m:.1} m to starboard"
        )?;
        match self.altitude_m {
            Some(altitude_m) => write!(f, ", {altitude_m:.1} m above the seabed"),
            None => Ok(()),
        }
    }
}

/// The swath of a sidescan ping; `None` if no side can be read, or if nothing tells the altitude.
pub(crate) fn swath(
    sensor: SensorIndex,
    imagery: &Imagery<'_>,
    bottom_lock_m: Option<f64>,
    sound_speed_mps: f64,
    bins: &mut Vec<f32>,
) -> Option<Swath> {
    let slant = |channel: &Channel<'_>| channel.header.range_kind != RangeKind::Ground;
    let first_return = |bins: &mut Vec<f32>| {
        let returns = readable(imagery)
            .filter(|(_, channel, _)| slant(channel))
            .filter_map(|(_, channel, samples)| first_return_m(&channel, &samples, sound_speed_mps, bins));
        returns.min_by(f64::total_cmp)
    };
    let (altitude_m, source) = if !readable(imagery).any(|(_, channel, _)| slant(&channel)) {
        (None, AltitudeSource::GroundRange)
    } else if let Some(altitude_m) = bottom_lock_m {
        (Some(altitude_m), AltitudeSource::BottomLock)
    } else {
        (Some(first_return(bins)?), AltitudeSource::FirstReturn)
    };
    let (mut port_m, mut starboard_m, mut sides) = (0.0_f64, 0.0_f64, 0);
    for (_, channel, _) in readable(imagery) {
        let range_m = range_m(&channel, sound_speed_mps);
        let reach_m = if slant(&channel) {
            let altitude_m = altitude_m.unwrap_or(0.0);
            (range_m * range_m - altitude_m * altitude_m).max(0.0).sqrt()
        } else {
            range_m
        };
        match channel.header.side {
            ChannelSide::Port => port_m = port_m.max(reach_m),
            ChannelSide::Starboard => starboard_m = starboard_m.max(reach_m),
            ChannelSide::Other(_) => continue,
        }
        sides += 1;
    }
    (sides > 0).then_some(Swath {
        sensor,
        ping: imagery.header.ping,
        port_m,
        starboard_m,
        altitude_m,
        source,
    })
}

/// The slant range at which the seabed begins, metres.
fn first_return_m(
    channel: &Channel<'_>,
    samples: &Samples<'_>,
    sound_speed_mps: f64,
    bins: &mut Vec<f32>,
) -> Option<f64> {
    bins.clear();
    decimate(samples, BINS, Decimation::Maximum, bins);
    let rest = bins.get(BLANKED * bins.len() / BINS..)?;
    let greatest = rest.iter().copied().fold(0.0_f32, f32::max);
    if greatest <= 0.0 {
        return None;
    }
    let found = rest
        .windows(2)
        .position(|pair| pair[0] >= greatest / 4.0 && pair[1] >= greatest / 8.0)?;
    let bin = bins.len() - rest.len() + found;
    let end_m = range_m(channel, sound_speed_mps);
    let start_m = (f64::from(channel.header.start_us) * 1e-6 * sound_speed_mps / 2.0).min(end_m);
    #[expect(clippy::cast_precision_loss, reason = "at most 256")]
    let part = bin as f64 / bins.len() as f64;
    Some(start_m + (end_m - start_m) * part)
}

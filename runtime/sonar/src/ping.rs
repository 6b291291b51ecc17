//! Pings for plugins: typed, and decimated to what their grants allow.

use backseat_s7k::record::{Channel, ChannelSide, Imagery, RangeKind, Samples};
use backseat_s7k::{DeviceId, SensorIndex};
use backseat_units::{Timestamp, Utc};
use serde::{Deserialize, Serialize};

use crate::decimation::{Decimation, decimate};
use crate::vehicle::VehicleNavigation;

/// How many channels of a record are read.
pub const CHANNELS_MAX: usize = 4;
/// How many grants there may be.
pub(crate) const GRANTS_MAX: usize = 16;
/// The most samples of a channel that a grant may have.
pub(crate) const SAMPLES_MAX: usize = 4096;

/// That plugins may see the pings of a sensor, and how finely.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PingGrant {
    /// The sensor.
    pub sensor: i32,
    /// How many samples of each channel are passed on at most, 1 to 4096.
    pub samples: u16,
    /// How several samples become one.
    pub decimation: Decimation,
}

/// A sidescan or sub-bottom ping, decimated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SonarPing {
    /// Which grant it is for: its place in [`crate::Start::grants`].
    pub grant: usize,
    /// The sensor, as it is configured.
    pub sensor: SensorIndex,
    /// The device in the record's frame.
    pub device: DeviceId,
    /// Whether it is a sub-bottom profile (record 3001) and no sidescan (record 3000).
    pub sub_bottom: bool,
    /// The ping's number, by the sonar.
    pub ping: u32,
    /// When it was, on our clock.
    pub time: Utc,
    /// Where the time comes from.
    pub time_source: PingTime,
    /// When the record arrived.
    pub arrived: Timestamp,
    /// How several samples became one.
    pub decimation: Decimation,
    /// The channels, at most [`CHANNELS_MAX`].
    pub channels: Vec<PingChannel>,
    /// The last solution of the vehicle that was not later than the ping, as the driver gave it; `None` if it gave none
    /// in the last seconds. Nothing is interpolated: `time` less `solution` is its age.
    pub navigation: Option<VehicleNavigation>,
}

/// Where the time of a ping comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PingTime {
    /// The controller's time, less the measured offset of its clock.
    Measured,
    /// The controller's time as it is: the offset of its clock is not measured yet.
    Controller,
    /// Our time at the arrival of the record: the controller gave no time.
    Arrival,
}

/// One channel of a ping.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PingChannel {
    /// The side that it looks to.
    pub side: ChannelSide,
    /// What its samples are spaced along.
    pub range_kind: RangeKind,
    /// Slant range or ground range of the last sample, metres. The sonar's, or that of the sound's travel at the last
    /// told speed of sound if the sonar's is not positive.
    pub range_m: f64,
    /// Time of the begin of the first bin after the ping, microseconds.
    pub start_us: u32,
    /// Time from the begin of a bin to that of the next, microseconds; a mean, because bins differ by one sample.
    pub bin_us: f64,
    /// How many samples the record has.
    pub recorded: u32,
    /// One step of a sample in volts, 2^-N by EdgeTech's weighting factor; `None` if the record does not have it. It can
    /// differ from ping to ping.
    pub volts_per_step: Option<f32>,
    /// The amplitudes of the bins, in steps.
    pub samples: Vec<f32>,
}

/// Range and travel time of a channel.
pub(crate) fn range_m(channel: &Channel<'_>, sound_speed_mps: f64) -> f64 {
    let header = &channel.header;
    let range_m = f64::from(header.range_m);
    if range_m.is_finite() && range_m > 0.0 {
        return range_m;
    }
    let travel_us = f64::from(header.start_us) + f64::from(header.samples) * f64::from(header.sample_interval_us);
    travel_us * 1e-6 * sound_speed_mps / 2.0
}

/// The channels of a record whose samples can be read, with their samples; at most [`CHANNELS_MAX`].
pub(crate) fn readable<'a>(imagery: &Imagery<'a>) -> impl Iterator<Item = (usize, Channel<'a>, Samples<'a>)> {
    let imagery = *imagery;
    imagery
        .channels()
        .take(CHANNELS_MAX)
        .enumerate()
        .map(move |(index, channel)| (index, channel, imagery.samples(&channel)))
        .filter(|(_, _, samples)| !matches!(samples, Samples::Raw { .. }))
}

/// The channels for a grant.
pub(crate) fn channels(imagery: &Imagery<'_>, grant: &PingGrant, sound_speed_mps: f64) -> Vec<PingChannel> {
    let count = readable(imagery).count();
    let mut channels = Vec::with_capacity(count);
    for (index, channel, samples) in readable(imagery) {
        let mut bins = Vec::new();
        decimate(&samples, usize::from(grant.samples), grant.decimation, &mut bins);
        let duration_us = f64::from(channel.header.samples) * f64::from(channel.header.sample_interval_us);
        #[expect(clippy::cast_precision_loss, reason = "at most 4096")]
        let bin_us = if bins.is_empty() {
            0.0
        } else {
            duration_us / bins.len() as f64
        };
        channels.push(PingChannel {
            side: channel.header.side,
            range_kind: channel.header.range_kind,
            range_m: range_m(&channel, sound_speed_mps),
            start_us: channel.header.start_us,
            bin_us,
            recorded: channel.header.samples,
            volts_per_step: weighting(imagery, index).and_then(volts_per_step),
            samples: bins,
        });
    }
    channels
}

fn weighting(imagery: &Imagery<'_>, channel: usize) -> Option<i16> {
    let side_scan = imagery
        .side_scan_headers()
        .nth(channel)
        .map(|header| header.weighting_factor);
    let segy = imagery
        .segy_headers()
        .nth(channel)
        .map(|header| header.weighting_factor);
    side_scan.or(segy)
}

/// 2^-N, exactly; `None` if an `f32` has no such number.
fn volts_per_step(weighting: i16) -> Option<f32> {
    let exponent = 127 - i32::from(weighting);
    let exponent = u32::try_from(exponent)
        .ok()
        .filter(|exponent| (1..=254).contains(exponent))?;
    Some(f32::from_bits(exponent << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weighting_factor_is_a_power_of_two() {
        assert_eq!(volts_per_step(0), Some(1.0));
        assert_eq!(volts_per_step(15), Some(1.0 / 32768.0));
        assert_eq!(volts_per_step(-3), Some(8.0));
        assert_eq!(volts_per_step(i16::MAX), None);
        assert_eq!(volts_per_step(i16::MIN), None);
    }
}

//! Sidescan as pictures need it: both sides of a ping along range, corrected and of even brightness.

mod bottom;
mod gain;
mod line;
mod row;

pub use bottom::AltitudeFrom;
pub(crate) use gain::Gain;
pub use gain::GainBy;
pub(crate) use line::{Line, PingPlace, device};
pub(crate) use row::{Grid, fill};

use backseat_s7k::record::{Channel, ChannelSide, Imagery, RangeKind};

/// One side of a ping.
#[derive(Clone, Debug, Default)]
pub(crate) struct Side {
    /// Amplitudes in steps of the converter; empty if the ping has no such side.
    pub(crate) amplitudes: Vec<f32>,
    /// Range of the first sample.
    pub(crate) first_m: f64,
    /// Range from sample to sample.
    pub(crate) step_m: f64,
    /// Whether the range is along the seabed already.
    pub(crate) ground: bool,
}

/// Both sides of a ping: port, starboard.
pub(crate) type Sides = [Side; 2];

/// The sides in their order.
pub(crate) const SIDES: [ChannelSide; 2] = [ChannelSide::Port, ChannelSide::Starboard];

/// The channel of a side.
pub(crate) fn channel<'a>(imagery: &Imagery<'a>, side: ChannelSide) -> Option<Channel<'a>> {
    imagery.channels().find(|channel| channel.header.side == side)
}

/// Reads both sides of a ping.
pub(crate) fn read_sides(imagery: &Imagery<'_>, sound_speed_mps: f64, sides: &mut Sides) {
    for (side, out) in SIDES.into_iter().zip(sides) {
        out.amplitudes.clear();
        let Some(channel) = channel(imagery, side) else {
            continue;
        };
        let header = &channel.header;
        imagery.samples(&channel).amplitudes(&mut out.amplitudes);
        let us_to_m = sound_speed_mps / 2.0 * 1e-6;
        out.ground = header.range_kind == RangeKind::Ground;
        let by_range = f64::from(header.range_m) / f64::from(header.samples.max(1));
        if out.ground || header.sample_interval_us == 0 {
            (out.first_m, out.step_m) = (0.0, by_range);
        } else {
            out.first_m = f64::from(header.start_us) * us_to_m;
            out.step_m = f64::from(header.sample_interval_us) * us_to_m;
        }
        // Without interval and range nothing says where a sample is.
        if !(out.step_m > 0.0 && out.step_m.is_finite()) {
            out.amplitudes.clear();
        }
    }
}

/// The range of the last sample of either side, metres.
pub(crate) fn reach_m(sides: &Sides) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "below 2^32 samples")]
    let reach = |side: &Side| {
        if side.amplitudes.is_empty() {
            0.0
        } else {
            side.first_m + side.step_m * side.amplitudes.len() as f64
        }
    };
    sides.iter().map(reach).fold(0.0, f64::max)
}

/// Whether the ranges of a ping are along the seabed already.
pub(crate) fn is_ground(imagery: &Imagery<'_>) -> bool {
    imagery
        .channels()
        .all(|channel| channel.header.range_kind == RangeKind::Ground)
}

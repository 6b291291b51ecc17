use serde::{Deserialize, Serialize};

use super::look::{Band, gap_m};
use super::noise::NoiseFloor;
use crate::{SonarChannel, SonarPing, SonarSide};

/// Bins are judged in groups of at least this length along the ground or the slant, metres, because the amplitude of a
/// single one is Rayleigh distributed: it says little.
const GROUP_M: f64 = 2.0;

/// What makes a part of a side's image good.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Half of the angle straight below the vehicle in which the image is no good, degrees.
    pub nadir_deg: f64,
    /// The least power of the seabed over that of the noise, decibels. Used where the noise is known.
    pub signal_min_db: f64,
    /// What is seen ends where the signal is missing for more than this, metres over the ground. Shadows of objects are
    /// shorter.
    pub hole_max_m: f64,
}

/// The mean square amplitude of some successive pings, bin by bin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PingStack {
    pings: u32,
    port: Option<Side>,
    starboard: Option<Side>,
}

/// What both sides see, by a stack of pings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StackedLook {
    /// To port; empty without a port channel.
    pub port: Band,
    /// To starboard.
    pub starboard: Band,
}

/// The bins of a side: sums in a stack, means in a [`NoiseFloor`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Side {
    is_ground: bool,
    range_m: f64,
    /// The part of the range before the first bin, 0 to 1.
    blank: f64,
    /// Squares of volts, or of steps where the ping has no volts.
    pub(super) power: Vec<f32>,
}

impl PingStack {
    /// How many pings it has.
    #[must_use]
    pub const fn pings(&self) -> u32 {
        self.pings
    }

    /// Takes in a ping. If its bins are not at the same ranges as those of the pings before, it begins anew with this
    /// one. A ping without a channel to port or starboard is ignored.
    pub fn add(&mut self, ping: &SonarPing) {
        let side = |side: SonarSide| {
            ping.channels
                .iter()
                .find(|channel| channel.side == side)
                .and_then(Side::of)
        };
        let (port, starboard) = (side(SonarSide::Port), side(SonarSide::Starboard));
        if port.is_none() && starboard.is_none() {
            return;
        }
        let like = |one: &Option<Side>, other: &Option<Side>| match (one, other) {
            (Some(one), Some(other)) => one.is_like(other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if self.pings > 0 && like(&self.port, &port) && like(&self.starboard, &starboard) {
            for (sum, new) in [(&mut self.port, &port), (&mut self.starboard, &starboard)] {
                if let (Some(sum), Some(new)) = (sum, new) {
                    sum.power.iter_mut().zip(&new.power).for_each(|(sum, new)| *sum += new);
                }
            }
            self.pings += 1;
        } else {
            *self = Self {
                pings: 1,
                port,
                starboard,
            };
        }
    }

    /// What both sides see, from an altitude over a level bottom, metres. `None` without pings.
    #[must_use]
    pub fn look(&self, altitude_m: f64, quality: &Quality, noise: Option<&NoiseFloor>) -> Option<StackedLook> {
        let band = |side: &Option<Side>, is_port: bool| {
            side.as_ref().map_or_else(Band::default, |side| {
                let noise = noise.and_then(|noise| noise.bins(is_port, side));
                side.band(f64::from(self.pings), altitude_m, quality, noise)
            })
        };
        (self.pings > 0).then(|| StackedLook {
            port: band(&self.port, true),
            starboard: band(&self.starboard, false),
        })
    }

    /// Forgets all pings.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn mean_sides(&self) -> (Option<Side>, Option<Side>) {
        let mean = |side: &Option<Side>| {
            side.clone().map(|mut side| {
                side.power
                    .iter_mut()
                    .for_each(|power| *power /= self.pings.max(1) as f32);
                side
            })
        };
        (mean(&self.port), mean(&self.starboard))
    }
}

impl Side {
    fn of(channel: &SonarChannel) -> Option<Self> {
        let sampled_ns = channel.sample_ns * channel.samples.len() as f64;
        let blank = channel.start_ns as f64 / (channel.start_ns as f64 + sampled_ns);
        let is_sound = channel.range.is_finite() && channel.range > 0.0 && (0.0..1.0).contains(&blank);
        let step = channel.volts_per_step.unwrap_or(1.0);
        is_sound.then(|| Self {
            is_ground: channel.ground_range,
            range_m: channel.range,
            blank,
            power: channel
                .samples
                .iter()
                .map(|sample| (sample * step) * (sample * step))
                .collect(),
        })
    }

    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.power.len() == other.power.len()
            && self.is_ground == other.is_ground
            && (self.range_m - other.range_m).abs() <= 1e-3 * self.range_m
            && (self.blank - other.blank).abs() <= 1e-3
    }

    /// Distance over the ground at which a bin begins, metres; 0 in the water column.
    fn ground_m(&self, bin: usize, altitude_m: f64) -> f64 {
        let part = self.blank + (1.0 - self.blank) * bin as f64 / self.power.len() as f64;
        let range_m = self.range_m * part;
        if self.is_ground {
            range_m
        } else {
            (range_m * range_m - altitude_m * altitude_m).max(0.0).sqrt()
        }
    }

    fn band(&self, pings: f64, altitude_m: f64, quality: &Quality, noise: Option<&[f32]>) -> Band {
        let inner_m = gap_m(altitude_m, quality.nadir_deg);
        let mut outer_m = inner_m;
        let bins = self.power.len();
        let bin_m = self.range_m * (1.0 - self.blank) / bins as f64;
        let group = ((GROUP_M / bin_m).ceil() as usize).clamp(1, bins.max(1));
        let least = backseat_units::math::exp(quality.signal_min_db * core::f64::consts::LN_10 / 10.0);
        let sum = |values: &[f32]| values.iter().map(|value| f64::from(*value)).sum::<f64>();
        for from in (0..bins).step_by(group) {
            let to = (from + group).min(bins);
            let end_m = self.ground_m(to, altitude_m);
            if end_m <= inner_m {
                continue;
            }
            let heard = sum(&self.power[from..to]) / pings;
            let silent = noise.map_or(0.0, |noise| sum(&noise[from..to]));
            // What is heard has the noise in it too. NaN is no signal.
            if heard > 0.0 && heard - silent >= least * silent {
                outer_m = end_m;
            } else if end_m - outer_m > quality.hole_max_m {
                break;
            }
        }
        Band { inner_m, outer_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Decimation, PingTime};

    const QUALITY: Quality = Quality {
        nadir_deg: 45.0,
        signal_min_db: 3.0,
        hole_max_m: 10.0,
    };

    /// A ping of 100 bins over a range of 100 m; amplitude by the middle of the bin.
    fn ping(amplitude: impl Fn(f64) -> f64) -> SonarPing {
        let channel = |side| SonarChannel {
            side,
            ground_range: false,
            range: 100.0,
            start_ns: 0,
            sample_ns: 1e6,
            recorded: 1000,
            volts_per_step: Some(0.5),
            samples: (0..100).map(|bin| amplitude(f64::from(bin) + 0.5) as f32).collect(),
        };
        SonarPing {
            age_ns: 0,
            time_source: PingTime::Measured,
            sensor: 2,
            number: 1,
            decimation: Decimation::Mean,
            channels: vec![channel(SonarSide::Port), channel(SonarSide::Starboard)],
            navigation: None,
        }
    }

    fn stack(pings: &[SonarPing]) -> PingStack {
        let mut stack = PingStack::default();
        pings.iter().for_each(|ping| stack.add(ping));
        stack
    }

    #[test]
    fn a_range_at_which_only_noise_comes_back_does_not_count() {
        // Noise grows with range; the seabed begins at the altitude, and is as strong as the noise at 80 m.
        let noise = |slant_m: f64| 0.001 * slant_m * slant_m;
        let seabed = |slant_m: f64| if slant_m < 30.0 { 0.0 } else { 6.4 };
        let heard = |slant_m: f64| (noise(slant_m) * noise(slant_m) + seabed(slant_m) * seabed(slant_m)).sqrt();
        let floor = NoiseFloor::of(&stack(&[ping(noise), ping(noise)])).unwrap();
        let stack = stack(&[ping(heard), ping(heard), ping(heard)]);
        let look = stack.look(30.0, &QUALITY, Some(&floor)).unwrap();
        // 3 dB of signal over noise are at 80 m less the fourth root of 2: 67.2 m along the slant.
        assert!(
            (look.port.outer_m - (67.0f64 * 67.0 - 900.0).sqrt()).abs() < 3.0,
            "{look:?}"
        );
        assert!((look.port.inner_m - 30.0).abs() < 1e-9 && look.starboard == look.port);
        let whole = stack.look(30.0, &QUALITY, None).unwrap();
        assert!(
            (whole.port.outer_m - 9100.0f64.sqrt()).abs() < 1e-6,
            "without a noise floor all that is heard counts"
        );
    }

    #[test]
    fn a_shadow_is_seen_past_and_silence_is_not() {
        let shadow = ping(|slant_m| if (60.0..66.0).contains(&slant_m) { 0.0 } else { 5.0 });
        let look = stack(&[shadow]).look(20.0, &QUALITY, None).unwrap();
        assert!((look.port.outer_m - 9600.0f64.sqrt()).abs() < 1e-6, "{look:?}");
        let ridge = ping(|slant_m| if (60.0..80.0).contains(&slant_m) { 0.0 } else { 5.0 });
        let look = stack(&[ridge]).look(20.0, &QUALITY, None).unwrap();
        assert!((look.port.outer_m - 3200.0f64.sqrt()).abs() < 1e-6, "{look:?}");
        let silent = stack(&[ping(|_| 0.0)]).look(20.0, &QUALITY, None).unwrap();
        assert_eq!(silent.port.width_m(), 0.0);
        let broken = stack(&[ping(|_| f64::NAN)]).look(20.0, &QUALITY, None).unwrap();
        assert_eq!(broken.starboard.width_m(), 0.0);
        assert_eq!(PingStack::default().look(20.0, &QUALITY, None), None);
    }

    #[test]
    fn pings_of_another_range_begin_a_new_stack() {
        let near = ping(|_| 1.0);
        let mut far = near.clone();
        far.channels.iter_mut().for_each(|channel| channel.range = 150.0);
        let mut stack = stack(&[near.clone(), near.clone()]);
        assert_eq!(stack.pings(), 2);
        let floor = NoiseFloor::of(&stack).unwrap();
        stack.add(&far);
        assert_eq!(stack.pings(), 1);
        // The noise of another range is not used.
        assert!((stack.look(10.0, &QUALITY, Some(&floor)).unwrap().port.outer_m - 22_400.0f64.sqrt()).abs() < 1e-6);
        let mut deaf = near;
        deaf.channels.clear();
        stack.add(&deaf);
        assert_eq!(stack.pings(), 1);
    }

    #[test]
    fn ground_range_and_a_late_first_bin_are_taken_as_they_are() {
        let mut flat = ping(|_| 1.0);
        flat.channels.iter_mut().for_each(|channel| channel.ground_range = true);
        assert_eq!(stack(&[flat]).look(30.0, &QUALITY, None).unwrap().port.outer_m, 100.0);
        // The first bin begins at half of the range.
        let mut late = ping(|slant_m| if slant_m < 50.0 { 1.0 } else { 0.0 });
        late.channels
            .iter_mut()
            .for_each(|channel| channel.start_ns = 100_000_000);
        let look = stack(&[late]).look(0.0, &QUALITY, None).unwrap();
        assert!((look.port.outer_m - 75.0).abs() < 2.1, "{look:?}");
    }
}

//! What depends on the settings and the slant range alone: kept from ping to ping, because settings rarely change.

use crate::absorption::Water;
use crate::beam::EQUIVALENT;
use crate::level::{decibels, noise_db, power_of};
use crate::settings::SideScanSettings;

/// Length of the array, metres: it makes the beam 0.9 degrees wide at 120 kHz and 0.26 at 410 kHz.
const APERTURE_M: f64 = 0.7;
/// Level of the source at full power, decibels relative to 1 µPa at 1 m.
const SOURCE_DB: f64 = 220.0;
/// The level, after the gains, that is a sample of 1: decibels relative to 1 µPa.
pub(super) const COUNT_DB: f64 = 94.0;
/// The gain that grows with time grows no further than this, decibels.
const TVG_MAX_DB: f64 = 120.0;
/// Spreading is counted from this distance on, metres: nearer than that the field is that of the array, not of a point.
const NEAREST_M: f64 = 0.1;
/// Width of the beam in the vertical, radians, for the noise that it lets in.
pub(super) const VERTICAL_RAD: f64 = 0.96;

#[derive(Clone, Debug)]
pub(super) struct Ranging {
    pub(super) settings: SideScanSettings,
    /// Slant range of one sample, metres.
    pub(super) sample_m: f64,
    /// What a pulse covers along the slant, metres, and at least one sample.
    pub(super) pulse_m: f64,
    /// The same in samples.
    pub(super) pulse_samples: usize,
    /// Width of the beam along track, radians.
    pub(super) along_rad: f64,
    /// Width of the rectangle that has the same area as the beam, transmitting and receiving, radians.
    pub(super) equivalent_rad: f64,
    /// For each sample, the square of what a target of 1 m² on the axis of the beam gives.
    pub(super) scale: Vec<f32>,
    /// For each sample, the mean square of the noise.
    pub(super) noise: Vec<f32>,
}

impl Ranging {
    pub(super) fn new(settings: &SideScanSettings, water: &Water) -> Self {
        let absorption = water.absorption_db_per_m(settings.frequency_hz);
        let sample_m = settings.sample_m();
        let resolution_m = 0.5 * settings.sound_speed_mps * settings.pulse_s;
        // The half-power width of an even line array: 0.88 wavelengths over its length.
        let along_rad = 0.88 * settings.sound_speed_mps / settings.frequency_hz / APERTURE_M;
        let source_db = SOURCE_DB + decibels(settings.power) + settings.gain_db - COUNT_DB;
        // The receiver listens to the band of its pulse, and to the directions of its beam.
        let directivity_db = decibels(4.0 * core::f64::consts::PI / (along_rad * VERTICAL_RAD)).max(0.0);
        let noise_db =
            noise_db(settings.frequency_hz) - decibels(settings.pulse_s) - directivity_db + settings.gain_db - COUNT_DB;
        let slants = (0..settings.samples).map(|sample| settings.slant_m(sample));
        let scale = slants.clone().map(|slant_m| {
            let lost_db = 4.0 * decibels(slant_m.max(NEAREST_M)) + 2.0 * absorption * slant_m;
            power_of(source_db + tvg_db(absorption, slant_m) - lost_db) as f32
        });
        let noise = slants.map(|slant_m| power_of(noise_db + tvg_db(absorption, slant_m)) as f32);
        Self {
            settings: *settings,
            sample_m,
            pulse_m: resolution_m.max(sample_m),
            pulse_samples: (resolution_m / sample_m)
                .round()
                .clamp(1.0, f64::from(settings.samples)) as usize,
            along_rad,
            equivalent_rad: EQUIVALENT * along_rad,
            scale: if settings.power > 0.0 {
                scale.collect()
            } else {
                vec![0.0; settings.samples as usize]
            },
            noise: noise.collect(),
        }
    }

    /// The samples whose slant ranges are at least `least_m` and below `most_m`.
    pub(super) fn samples(&self, least_m: f64, most_m: f64) -> core::ops::Range<usize> {
        let index = |slant_m: f64| (slant_m / self.sample_m - 0.5).ceil().max(0.0) as usize;
        let count = self.scale.len();
        index(least_m).min(count)..index(most_m).min(count)
    }
}

/// The gain that grows with time, decibels, for an absorption in decibels a metre.
pub(super) fn tvg_db(absorption_db_per_m: f64, slant_m: f64) -> f64 {
    let spreading = 3.0 * decibels(slant_m.max(1.0));
    (spreading + 2.0 * absorption_db_per_m * slant_m).min(TVG_MAX_DB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_fall_as_spreading_and_absorption_say() {
        let settings = SideScanSettings {
            frequency_hz: 4e5,
            range_m: 200.0,
            pulse_s: 1e-4,
            power: 0.5,
            gain_db: 0.0,
            samples: 4000,
            sound_speed_mps: 1500.0,
        };
        let water = Water {
            temperature_c: 10.0,
            salinity: 35.0,
            depth_m: 30.0,
        };
        let absorption = water.absorption_db_per_m(4e5);
        let ranging = Ranging::new(&settings, &water);
        let raw_db = |sample: u32| {
            let slant_m = settings.slant_m(sample);
            decibels(f64::from(ranging.scale[sample as usize])) - tvg_db(absorption, slant_m)
        };
        // Between 20 m and 160 m: 40 log 8 and 280 m of absorption.
        let fall_db = raw_db(400) - raw_db(3200);
        let (near_m, far_m) = (settings.slant_m(400), settings.slant_m(3200));
        let expected = 4.0 * decibels(far_m / near_m) + 2.0 * absorption * (far_m - near_m);
        assert!((fall_db - expected).abs() < 1e-4, "{fall_db} {expected}");
        let quiet = Ranging::new(&SideScanSettings { power: 0.0, ..settings }, &water);
        assert!(quiet.scale.iter().all(|scale| *scale == 0.0));
        assert_eq!(quiet.noise, ranging.noise);
        let full = Ranging::new(&SideScanSettings { power: 1.0, ..settings }, &water);
        assert!((full.scale[900] / ranging.scale[900] - 2.0).abs() < 1e-4);
    }

    #[test]
    fn samples_are_those_whose_middle_is_in_the_interval() {
        let settings = SideScanSettings {
            frequency_hz: 4e5,
            range_m: 10.0,
            pulse_s: 1e-4,
            power: 1.0,
            gain_db: 0.0,
            samples: 10,
            sound_speed_mps: 1500.0,
        };
        let water = Water {
            temperature_c: 10.0,
            salinity: 35.0,
            depth_m: 30.0,
        };
        let ranging = Ranging::new(&settings, &water);
        assert_eq!(ranging.samples(2.5, 4.5), 2..4);
        assert_eq!(ranging.samples(2.6, 2.7), 3..3);
        assert_eq!(ranging.samples(-4.0, 0.6), 0..1);
        assert_eq!(ranging.samples(8.0, 99.0), 8..10);
        assert_eq!((ranging.pulse_m, ranging.pulse_samples), (1.0, 1));
    }
}

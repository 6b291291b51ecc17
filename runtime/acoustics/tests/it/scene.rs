//! Worlds and settings for the tests, and what they measure.

use backseat_acoustics::{Pose, SideScan, SideScanSettings};
use backseat_units::{EastNorth, math};
use backseat_world::World;

/// A world with the given text after its origin.
pub(crate) fn world(text: &str, seed: u64) -> World {
    let text = format!("[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.9\n{text}");
    World::new(&toml::from_str(&text).expect("it is a world"), seed).expect("it can be drawn")
}

/// A level seabed 40 m deep.
pub(crate) const LEVEL: &str = "[seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\n";

pub(crate) const SETTINGS: SideScanSettings = SideScanSettings {
    frequency_hz: 410e3,
    range_m: 100.0,
    pulse_s: 50e-6,
    power: 1.0,
    gain_db: 0.0,
    samples: 2000,
    sound_speed_mps: 1500.0,
};

/// Heading north at an altitude.
pub(crate) fn pose(world: &World, at: EastNorth, altitude_m: f64) -> Pose {
    Pose {
        at,
        depth_m: world.water_depth_m(at) - altitude_m,
        altitude_m,
        heading_deg: 0.0,
        pitch_deg: 0.0,
        roll_deg: 0.0,
    }
}

/// The mean square of each sample over many pings, port and starboard: speckle averages out.
pub(crate) fn mean_squares(
    sonar: &mut SideScan,
    world: &World,
    pose: &Pose,
    settings: &SideScanSettings,
    pings: u32,
) -> [Vec<f64>; 2] {
    let mut sums = [
        vec![0.0; settings.samples as usize],
        vec![0.0; settings.samples as usize],
    ];
    let (mut port, mut starboard) = (Vec::new(), Vec::new());
    for ping in 0..pings {
        sonar.ping(world, pose, settings, ping, &mut port, &mut starboard);
        for (sum, side) in sums.iter_mut().zip([&port, &starboard]) {
            assert_eq!(side.len(), sum.len());
            for (sum, sample) in sum.iter_mut().zip(side) {
                *sum += f64::from(*sample) * f64::from(*sample) / f64::from(pings);
            }
        }
    }
    sums
}

/// The mean over the samples whose slant ranges are within an interval, metres.
pub(crate) fn between(levels: &[f64], settings: &SideScanSettings, from_m: f64, to_m: f64) -> f64 {
    let inside: Vec<f64> = (0..settings.samples)
        .filter(|sample| (from_m..to_m).contains(&settings.slant_m(*sample)))
        .map(|sample| levels[sample as usize])
        .collect();
    assert!(!inside.is_empty());
    inside.iter().sum::<f64>() / inside.len() as f64
}

pub(crate) fn decibels(ratio: f64) -> f64 {
    10.0 / std::f64::consts::LN_10 * math::ln(ratio)
}

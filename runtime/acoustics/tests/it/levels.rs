//! How strong echoes are.

use backseat_acoustics::{SideScan, SideScanSettings, Water};
use backseat_units::{EastNorth, math};

use crate::scene::{LEVEL, SETTINGS, between, decibels, mean_squares, pose, world};

/// The mean level at a slant range without the gain that grows with time, decibels.
fn raw_db(sonar: &SideScan, levels: &[f64], settings: &SideScanSettings, slant_m: f64) -> f64 {
    let level = between(levels, settings, slant_m - 2.0, slant_m + 2.0);
    decibels(level) - sonar.tvg_db(settings, slant_m)
}

#[test]
fn the_seabed_fades_as_spreading_absorption_and_lambert_say() {
    let world = world(LEVEL, 1);
    let absorption = Water::of(&world).absorption_db_per_m(SETTINGS.frequency_hz);
    let mut sonar = SideScan::new(&world, 1, "test");
    // A gain keeps the figures above the steps of one.
    let settings = SideScanSettings {
        gain_db: 20.0,
        ..SETTINGS
    };
    let altitude_m = 10.0;
    // The beam's axis points at neither range: roll is such that both are equally far off it.
    let mut pose = pose(&world, EastNorth::default(), altitude_m);
    let (near_m, far_m) = (30.0f64, 80.0f64);
    let depression = |slant_m: f64| math::asin(altitude_m / slant_m).to_degrees();
    pose.roll_deg = 0.5 * (depression(near_m) + depression(far_m)) - 30.0;
    let [_, starboard] = mean_squares(&mut sonar, &world, &pose, &settings, 400);
    let fall_db = raw_db(&sonar, &starboard, &settings, near_m) - raw_db(&sonar, &starboard, &settings, far_m);
    // 40 log r for the echo, less 10 log r for the width of the beam, and 20 log of the sines for Lambert's law; the
    // length of a pulse on the seabed goes with 1 / cos of the grazing angle.
    let cos = |slant_m: f64| math::cos(depression(slant_m).to_radians());
    let expected = 3.0 * decibels(far_m / near_m)
        + 2.0 * absorption * (far_m - near_m)
        + 2.0 * decibels(far_m / near_m)
        + decibels(cos(far_m) / cos(near_m));
    assert!((fall_db - expected).abs() < 0.3, "{fall_db} {expected}");
}

#[test]
fn gain_and_power_are_in_decibels() {
    let world = world(LEVEL, 1);
    let pose = pose(&world, EastNorth::default(), 10.0);
    let mut sonar = SideScan::new(&world, 1, "test");
    let mut level_db = |settings: SideScanSettings| {
        let [port, _] = mean_squares(&mut sonar, &world, &pose, &settings, 60);
        decibels(between(&port, &settings, 20.0, 30.0))
    };
    let plain = level_db(SETTINGS);
    let louder = level_db(SideScanSettings {
        gain_db: 12.0,
        ..SETTINGS
    });
    let weaker = level_db(SideScanSettings { power: 0.1, ..SETTINGS });
    assert!((louder - plain - 12.0).abs() < 0.05, "{}", louder - plain);
    assert!((plain - weaker - 10.0).abs() < 0.05, "{}", plain - weaker);
    let deaf = level_db(SideScanSettings { power: 0.0, ..SETTINGS });
    assert!(deaf < plain - 20.0, "without power there is noise alone: {deaf}");
}

#[test]
fn noise_grows_with_the_gain_that_grows_with_time() {
    let world = world(LEVEL, 1);
    let pose = pose(&world, EastNorth::default(), 10.0);
    let mut sonar = SideScan::new(&world, 1, "test");
    let settings = SideScanSettings {
        power: 0.0,
        gain_db: 30.0,
        ..SETTINGS
    };
    let [port, starboard] = mean_squares(&mut sonar, &world, &pose, &settings, 200);
    for levels in [&port, &starboard] {
        let grown_db = raw_db(&sonar, levels, &settings, 90.0) - raw_db(&sonar, levels, &settings, 50.0);
        assert!(grown_db.abs() < 0.3, "{grown_db}");
    }
}

#[test]
fn lambert_holds_on_a_slope_too() {
    // To port the bed rises by 0.2 and to starboard it falls by 0.2: at the same slant range the angles differ.
    let world = world(
        "[seabed]\ndepth_m = 80\nslope = 0.2\ndownslope_deg = 90\nmeanders = 0\n",
        1,
    );
    let mut sonar = SideScan::new(&world, 1, "test");
    let settings = SideScanSettings {
        gain_db: 20.0,
        ..SETTINGS
    };
    let (altitude_m, slope, slant_m) = (20.0f64, 0.2f64, 60.0f64);
    // Outwards y and below z with z = altitude + s y and y² + z² = r²; s is the slope outwards.
    let grazing = |s: f64| {
        let (a, b, c) = (1.0 + s * s, altitude_m * s, altitude_m * altitude_m - slant_m * slant_m);
        let y = (-b + (b * b - a * c).sqrt()) / a;
        let z = altitude_m + s * y;
        let sin = (z - s * y) / (slant_m * a.sqrt());
        (math::atan2(z, y).to_degrees(), sin)
    };
    let (port, starboard) = (grazing(-slope), grazing(slope));
    // Roll both beams so that this place is on the axis: one ping for each side.
    let mut pose = pose(&world, EastNorth::default(), altitude_m);
    pose.roll_deg = 30.0 - port.0;
    let [to_port, _] = mean_squares(&mut sonar, &world, &pose, &settings, 300);
    pose.roll_deg = starboard.0 - 30.0;
    let [_, to_starboard] = mean_squares(&mut sonar, &world, &pose, &settings, 300);
    let level = |levels: &[f64]| between(levels, &settings, slant_m - 0.5, slant_m + 0.5);
    let found = decibels(level(&to_port) / level(&to_starboard));
    // Lambert's law, and the length of the pulse along the bed.
    let cos = |sin: f64| (1.0 - sin * sin).sqrt();
    let expected = 2.0 * decibels(port.1 / starboard.1) + decibels(cos(starboard.1) / cos(port.1));
    assert!((found - expected).abs() < 0.3, "{found} {expected}");
}

#[test]
fn one_ping_is_speckled_as_a_rayleigh_envelope() {
    let world = world(LEVEL, 1);
    let pose = pose(&world, EastNorth::default(), 10.0);
    let mut sonar = SideScan::new(&world, 1, "test");
    let settings = SideScanSettings {
        gain_db: 10.0,
        ..SETTINGS
    };
    let (mut port, mut starboard) = (Vec::new(), Vec::new());
    let mut samples = Vec::new();
    for ping in 0..200 {
        sonar.ping(&world, &pose, &settings, ping, &mut port, &mut starboard);
        // From 25 m to 26 m the mean hardly changes.
        samples.extend(
            port[500..520]
                .iter()
                .chain(&starboard[500..520])
                .map(|sample| f64::from(*sample)),
        );
    }
    let count = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let deviation = (samples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count).sqrt();
    assert!((mean / deviation - 1.913).abs() < 0.06, "{}", mean / deviation);
}

#[test]
fn the_surface_is_seen_if_asked_for() {
    let world = world(LEVEL, 1);
    let mut pose = pose(&world, EastNorth::default(), 34.0);
    pose.depth_m = 6.0;
    let level = |sonar: SideScan| {
        let mut sonar = sonar;
        let [port, _] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 60);
        (between(&port, &SETTINGS, 5.0, 5.9), between(&port, &SETTINGS, 6.0, 8.0))
    };
    let without = level(SideScan::new(&world, 1, "test"));
    let with = level(SideScan::new(&world, 1, "test").with_surface(-20.0));
    assert_eq!(with.0, without.0);
    assert!(with.1 > 10.0 * without.1.max(1.0), "{with:?} {without:?}");
}

//! Where echoes of the seabed are.

use backseat_acoustics::{SideScan, SideScanSettings};
use backseat_units::{EastNorth, math};

use crate::scene::{LEVEL, SETTINGS, between, decibels, mean_squares, pose, world};

/// Slant range at which the mean level first exceeds ten times that of the water column.
fn first_return_m(levels: &[f64], settings: &SideScanSettings) -> f64 {
    let column = between(levels, settings, 0.5, 4.0).max(1.0);
    let first = levels
        .iter()
        .position(|level| *level > 100.0 * column)
        .expect("there is a bed");
    settings.slant_m(first as u32)
}

#[test]
fn the_first_return_is_at_the_altitude_and_the_water_above_is_dark() {
    let world = world(LEVEL, 1);
    let mut sonar = SideScan::new(&world, 1, "test");
    for altitude_m in [6.0, 12.5, 30.0] {
        let pose = pose(&world, EastNorth::new(30.0, -20.0), altitude_m);
        for levels in mean_squares(&mut sonar, &world, &pose, &SETTINGS, 50) {
            let found_m = first_return_m(&levels, &SETTINGS);
            assert!(
                (found_m - altitude_m).abs() <= 2.0 * SETTINGS.sample_m(),
                "{altitude_m} {found_m}"
            );
            let column = between(&levels, &SETTINGS, 0.3 * altitude_m, 0.98 * altitude_m);
            let bed = between(&levels, &SETTINGS, altitude_m, 1.02 * altitude_m);
            assert!(decibels(bed / column.max(0.25)) > 40.0, "{bed} {column}");
        }
    }
}

#[test]
fn the_altitude_counts_and_not_the_depth_on_the_chart() {
    // High water: the vehicle is as deep as before, and further above the bed.
    let world = world(LEVEL, 1);
    let mut sonar = SideScan::new(&world, 1, "test");
    let mut pose = pose(&world, EastNorth::default(), 10.0);
    pose.altitude_m = 12.0;
    let [port, _] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 50);
    assert!((first_return_m(&port, &SETTINGS) - 12.0).abs() < 0.1);
}

#[test]
fn on_a_slope_the_first_return_comes_from_beside_the_vehicle() {
    let slope = 0.3;
    let world = world(
        "[seabed]\ndepth_m = 60\nslope = 0.3\ndownslope_deg = 90\nmeanders = 0\n",
        1,
    );
    let mut sonar = SideScan::new(&world, 1, "test");
    let pose = pose(&world, EastNorth::default(), 20.0);
    let [port, starboard] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 50);
    // Heading north on a bed that falls to the east: to port the bed rises, and its nearest point is at the perpendicular.
    let perpendicular_m = 20.0 / (1.0f64 + slope * slope).sqrt();
    let port_m = first_return_m(&port, &SETTINGS);
    assert!((port_m - perpendicular_m).abs() < 0.2, "{port_m} {perpendicular_m}");
    let starboard_m = first_return_m(&starboard, &SETTINGS);
    assert!((starboard_m - 20.0).abs() < 0.1, "{starboard_m}");
}

#[test]
fn a_bank_hides_the_seabed_behind_it() {
    let text = "[seabed]\ndepth_m = 60\nslope = 0\nmeanders = 0\nbanks = 1\nbank_height_m = 12\nbank_radius_m = 20\n\
                bank_east_m = 60\nbank_north_m = 0\n";
    let world = world(text, 1);
    let mut sonar = SideScan::new(&world, 1, "test");
    let settings = SideScanSettings {
        frequency_hz: 120e3,
        range_m: 200.0,
        ..SETTINGS
    };
    let pose = pose(&world, EastNorth::default(), 14.0);
    let [port, starboard] = mean_squares(&mut sonar, &world, &pose, &settings, 20);
    // The ray over the top, 60 m out and some 2 m below the sonar, meets the bed far beyond 200 m.
    let (open, hidden) = (
        between(&port, &settings, 100.0, 180.0),
        between(&starboard, &settings, 100.0, 180.0),
    );
    assert!(decibels(open / hidden) > 6.0, "{open} {hidden}");
    let (face, level) = (
        between(&starboard, &settings, 30.0, 50.0),
        between(&port, &settings, 30.0, 50.0),
    );
    assert!(
        face > level,
        "the face of the bank is steeper, and brighter: {face} {level}"
    );
}

#[test]
fn roll_turns_one_beam_down_and_the_other_up() {
    let world = world(LEVEL, 1);
    let mut sonar = SideScan::new(&world, 1, "test");
    let mut pose = pose(&world, EastNorth::default(), 15.0);
    pose.roll_deg = 15.0;
    let [port, starboard] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 50);
    // Starboard is down: its axis is at 45 degrees, and that of port at 15.
    let near = |levels: &[f64]| between(levels, &SETTINGS, 15.5, 18.0);
    let far = |levels: &[f64]| between(levels, &SETTINGS, 70.0, 90.0);
    assert!(near(&starboard) > 4.0 * near(&port));
    assert!(far(&port) > 1.5 * far(&starboard));
}

#[test]
fn pitch_tilts_the_plane_and_looks_further_ahead() {
    let world = world(
        &format!(
            "{LEVEL}[[seabed.patches]]\nbottom = \"rock\"\neast_m = 0\nnorth_m = 50\nlength_m = 80\nwidth_m = 400\n"
        ),
        1,
    );
    let mut sonar = SideScan::new(&world, 1, "test");
    let mut pose = pose(&world, EastNorth::default(), 20.0);
    let level = |sonar: &mut SideScan, pitch_deg: f64, pose: &mut backseat_acoustics::Pose| {
        pose.pitch_deg = pitch_deg;
        let [port, _] = mean_squares(sonar, &world, pose, &SETTINGS, 50);
        (first_return_m(&port, &SETTINGS), between(&port, &SETTINGS, 30.0, 40.0))
    };
    let (straight_m, silent) = level(&mut sonar, 0.0, &mut pose);
    let (tilted_m, loud) = level(&mut sonar, 35.0, &mut pose);
    // The bow is up, so the plane meets the bed 20 m · tan 35° ahead, on the rock, and 1 / cos 35° further away.
    assert!((straight_m - 20.0).abs() < 0.1);
    assert!(
        (tilted_m - 20.0 / math::cos(35f64.to_radians())).abs() < 0.1,
        "{tilted_m}"
    );
    assert!(decibels(loud / silent) > 8.0, "{loud} {silent}");
}

//! Patches of other textures.

use backseat_acoustics::SideScan;
use backseat_units::EastNorth;

use crate::scene::{LEVEL, SETTINGS, between, decibels, mean_squares, pose, world};

/// Mud with a patch of gravel from 30 m to 50 m east.
const PATCH: &str = "[seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\nbottom = \"mud\"\n[[seabed.patches]]\nbottom = \"gravel\"\n\
                     east_m = 40\nnorth_m = 0\nlength_m = 400\nwidth_m = 20\n";

#[test]
fn a_patch_begins_and_ends_where_it_lies() {
    let altitude_m = 10.0f64;
    let world = world(PATCH, 1);
    let mut sonar = SideScan::new(&world, 1, "test");
    let pose = pose(&world, EastNorth::default(), altitude_m);
    let [port, starboard] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 200);
    let slant_m = |out_m: f64| (out_m * out_m + altitude_m * altitude_m).sqrt();
    for (edge_m, brighter_beyond) in [(30.0, true), (50.0, false)] {
        let edge_m = slant_m(edge_m);
        let (inner, outer) = (
            between(&starboard, &SETTINGS, edge_m - 0.15, edge_m),
            between(&starboard, &SETTINGS, edge_m, edge_m + 0.15),
        );
        let step_db = if brighter_beyond {
            decibels(outer / inner)
        } else {
            decibels(inner / outer)
        };
        // 17 dB lie between mud and gravel.
        assert!((step_db - 17.0).abs() < 1.0, "{edge_m}: {step_db}");
    }
    let middle = |levels: &[f64]| between(levels, &SETTINGS, slant_m(35.0), slant_m(45.0));
    let over_db = decibels(middle(&starboard) / middle(&port));
    assert!((over_db - 17.0).abs() < 0.3, "port has no patch: {over_db}");
}

#[test]
fn backscatter_is_as_written() {
    let level_db = |line: &str| {
        let world = world(&format!("{LEVEL}{line}"), 1);
        let mut sonar = SideScan::new(&world, 1, "test");
        let pose = pose(&world, EastNorth::default(), 10.0);
        let [port, _] = mean_squares(&mut sonar, &world, &pose, &SETTINGS, 100);
        decibels(between(&port, &SETTINGS, 20.0, 30.0))
    };
    let sand_db = level_db("");
    assert!((level_db("bottom = \"gravel\"\n") - sand_db - 7.0).abs() < 0.1);
    assert!((level_db("backscatter_db = -37\n") - sand_db + 10.0).abs() < 0.1);
}

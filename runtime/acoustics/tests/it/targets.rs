//! Targets: highlight and shadow.

use backseat_acoustics::{SideScan, SideScanSettings};
use backseat_units::EastNorth;
use backseat_world::World;

use crate::scene::{LEVEL, SETTINGS, between, mean_squares, pose, world};

const ALTITUDE_M: f64 = 10.0;

/// A box 20 m long across the beam, so that it fills it, on a level bed.
fn with_box(east_m: f64, width_m: f64, height_m: f64) -> World {
    let text = format!(
        "{LEVEL}[[targets]]\nkind = \"box\"\neast_m = {east_m}\nnorth_m = 0\nlength_m = 20\nwidth_m = {width_m}\n\
         height_m = {height_m}\nstrength_db = 15\n"
    );
    world(&text, 1)
}

fn levels(world: &World, north_m: f64, settings: &SideScanSettings) -> [Vec<f64>; 2] {
    let mut sonar = SideScan::new(world, 1, "test");
    let pose = pose(world, EastNorth::new(0.0, north_m), ALTITUDE_M);
    mean_squares(&mut sonar, world, &pose, settings, 100)
}

#[test]
fn a_target_is_at_its_slant_range_on_its_side() {
    for (east_m, side) in [(40.0, 1), (-55.0, 0)] {
        let text = format!("{LEVEL}[[targets]]\nkind = \"point\"\neast_m = {east_m}\nnorth_m = 0\nstrength_db = -15\n");
        let found = levels(&world(&text, 1), 0.0, &SETTINGS);
        let slant_m = (east_m * east_m + ALTITUDE_M * ALTITUDE_M).sqrt();
        let brightest = |levels: &[f64]| {
            let beyond = 600..levels.len();
            let sample = beyond
                .max_by(|one, other| levels[*one].total_cmp(&levels[*other]))
                .unwrap();
            (SETTINGS.slant_m(sample as u32), levels[sample])
        };
        let (at_m, level) = brightest(&found[side]);
        assert!((at_m - slant_m).abs() <= SETTINGS.sample_m(), "{at_m} {slant_m}");
        let bed = between(&found[side], &SETTINGS, slant_m + 1.0, slant_m + 5.0);
        assert!(level > 300.0 * bed, "{level} {bed}");
        assert!(
            level > 300.0 * brightest(&found[1 - side]).1,
            "the other side does not see it"
        );
    }
}

#[test]
fn a_shadow_has_the_length_that_height_and_altitude_give_it() {
    let settings = SETTINGS;
    for (east_m, width_m, height_m) in [(30.0, 1.0, 2.0), (45.0, 3.0, 1.0), (-50.0, 2.0, 3.0)] {
        let found = levels(&with_box(east_m, width_m, height_m), 0.0, &settings);
        let open = levels(&world(LEVEL, 1), 0.0, &settings);
        let side = usize::from(east_m > 0.0);
        // The last place that sound reaches is the far edge of the top.
        let far_m = f64::abs(east_m) + 0.5 * width_m;
        let below_m = ALTITUDE_M - height_m;
        let apex_m = (far_m * far_m + below_m * below_m).sqrt();
        let expected_m = height_m * apex_m / (ALTITUDE_M - height_m);
        let dark: Vec<f64> = (0..settings.samples)
            .filter(|sample| found[side][*sample as usize] < 0.5 * open[side][*sample as usize])
            .map(|sample| settings.slant_m(sample))
            .filter(|slant_m| *slant_m > apex_m - 1.0)
            .collect();
        let (first_m, last_m) = (dark[0], dark[dark.len() - 1]);
        let tolerance_m = 2.0 * settings.sample_m();
        assert!((first_m - apex_m).abs() <= tolerance_m, "{east_m}: {first_m} {apex_m}");
        assert!(
            (last_m - first_m - expected_m).abs() <= tolerance_m,
            "{east_m}: {} {expected_m}",
            last_m - first_m
        );
        // All of it is dark, and the seabed behind is as it was.
        let missing = (expected_m / settings.sample_m()) as usize - dark.len();
        assert!(missing <= 3, "{missing}");
        let (behind, before) = (
            between(&found[side], &settings, last_m + 0.2, last_m + 4.0),
            between(&open[side], &settings, last_m + 0.2, last_m + 4.0),
        );
        assert!((behind / before - 1.0).abs() < 0.02, "{behind} {before}");
    }
}

#[test]
fn the_highlight_comes_before_the_shadow_and_the_top_before_the_foot() {
    let found = levels(&with_box(30.0, 1.0, 2.0), 0.0, &SETTINGS);
    let open = levels(&world(LEVEL, 1), 0.0, &SETTINGS);
    let bright: Vec<f64> = (400..SETTINGS.samples)
        .filter(|sample| found[1][*sample as usize] > 4.0 * open[1][*sample as usize])
        .map(|sample| SETTINGS.slant_m(sample))
        .collect();
    // The near edge of the top is the first, the foot or the far edge of the top the last.
    let top_m = (29.5f64 * 29.5 + 64.0).sqrt();
    let last_m = (29.5f64 * 29.5 + 100.0).sqrt().max((30.5f64 * 30.5 + 64.0).sqrt());
    assert!((bright[0] - top_m).abs() < 0.1, "{} {top_m}", bright[0]);
    let end_m = bright[bright.len() - 1];
    assert!((end_m - last_m).abs() < 0.1, "{end_m} {last_m}");
}

#[test]
fn a_target_smears_along_track_with_its_range() {
    let settings = SideScanSettings {
        frequency_hz: 120e3,
        ..SETTINGS
    };
    // How far from abeam the level has fallen to a quarter: half of the beam, which is transmitted and received.
    let half_m = |east_m: f64| {
        let text = format!("{LEVEL}[[targets]]\nkind = \"point\"\neast_m = {east_m}\nnorth_m = 0\nstrength_db = -25\n");
        let world = world(&text, 1);
        let slant_m = (east_m * east_m + ALTITUDE_M * ALTITUDE_M).sqrt();
        let level = |north_m: f64| {
            between(
                &levels(&world, north_m, &settings)[1],
                &settings,
                slant_m - 0.05,
                slant_m + 0.05,
            )
        };
        let abeam = level(0.0);
        (1..200)
            .map(|step| 0.02 * f64::from(step))
            .find(|north_m| level(*north_m) < 0.25 * abeam)
            .unwrap()
    };
    let width_rad = 0.88 * 1500.0 / 120e3 / 0.7;
    for east_m in [20.0, 60.0] {
        let found_m = half_m(east_m);
        let expected_m = 0.5 * width_rad * (east_m * east_m + ALTITUDE_M * ALTITUDE_M).sqrt();
        assert!(
            (found_m - expected_m).abs() < 0.1 * expected_m + 0.03,
            "{east_m}: {found_m} {expected_m}"
        );
    }
}

#[test]
fn length_width_and_heading_turn_with_the_target() {
    // A cylinder 12 m long and 1 m thick: abeam of its middle, and 4 m further on.
    let cylinder = |heading_deg: f64| {
        let text = format!(
            "{LEVEL}[[targets]]\nkind = \"cylinder\"\neast_m = 40\nnorth_m = 0\nlength_m = 12\nwidth_m = 1\nheight_m = 1\n\
             heading_deg = {heading_deg}\nstrength_db = 20\n"
        );
        let world = world(&text, 1);
        [0.0, 4.0].map(|north_m| between(&levels(&world, north_m, &SETTINGS)[1], &SETTINGS, 33.0, 50.0))
    };
    let along = cylinder(0.0);
    assert!(
        along[1] > 0.7 * along[0],
        "it lies along the track, and is as bright at its end: {along:?}"
    );
    let across = cylinder(90.0);
    assert!(across[1] < 0.1 * across[0], "it lies across the track: {across:?}");
}

#[test]
fn a_target_in_the_shadow_of_another_is_dark() {
    let text = |height_m: f64| {
        format!(
            "{LEVEL}[[targets]]\nkind = \"box\"\neast_m = 30\nnorth_m = 0\nlength_m = 10\nwidth_m = 1\nheight_m = {height_m}\n\
             strength_db = -40\n[[targets]]\nkind = \"rock\"\neast_m = 35\nnorth_m = 0\nheight_m = 0.5\nstrength_db = 10\n"
        )
    };
    let level = |height_m: f64| {
        between(
            &levels(&world(&text(height_m), 1), 0.0, &SETTINGS)[1],
            &SETTINGS,
            35.8,
            36.6,
        )
    };
    assert!(level(0.0) > 100.0 * level(3.0), "{} {}", level(0.0), level(3.0));
}

#[test]
fn a_small_target_hides_a_part_of_a_wide_beam_only() {
    let settings = SideScanSettings {
        frequency_hz: 60e3,
        ..SETTINGS
    };
    let text = format!(
        "{LEVEL}[[targets]]\nkind = \"box\"\neast_m = 50\nnorth_m = 0\nlength_m = 0.8\nwidth_m = 0.8\nheight_m = 2\nstrength_db = -60\n"
    );
    let found = levels(&world(&text, 1), 0.0, &settings);
    let open = levels(&world(LEVEL, 1), 0.0, &settings);
    let shadow = |levels: &[f64]| between(levels, &settings, 54.0, 60.0);
    let left = shadow(&found[1]) / shadow(&open[1]);
    // The beam is 0.88 · 0.025 m / 0.7 m wide: 1.58 m at the far edge of the top, 51.0 m away.
    let expected = 1.0 - 0.8 / (0.88 * 0.025 / 0.7 * (50.4f64 * 50.4 + 64.0).sqrt());
    assert!((left - expected).abs() < 0.03, "{left} {expected}");
}

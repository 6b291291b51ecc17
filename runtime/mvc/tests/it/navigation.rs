use backseat_mvc::{Sensor, SensorFailure};
use backseat_units::{EastNorth, Heading, utm_convergence_deg};

use crate::files::{CALM, LIVELY};
use crate::payload::Payload;
use crate::sentences::{field, off, place, seconds, with};

#[test]
fn navigation_comes_at_ten_hertz_in_pairs_with_the_same_time() {
    let mut payload = Payload::connected(CALM, 1, &["NVG", "NVR"]);
    payload.until(2.0);
    let heard = payload.heard();
    assert_eq!(heard.len(), 40);
    for (tick, pair) in heard.chunks(2).enumerate() {
        let millis = (tick + 1) * 100;
        let stamp = format!("0800{:02}.{:03}", millis / 1000, millis % 1000);
        assert!(pair[0].starts_with(&format!("$BFNVG,{stamp},")) && pair[0].ends_with(&format!(",{stamp}")));
        assert!(pair[1].starts_with(&format!("$BFNVR,{stamp},")));
    }
}

#[test]
fn the_heading_counts_from_grid_north() {
    let mut payload = Payload::connected(LIVELY, 1, &["NVG"]);
    payload.until(60.0);
    let heard = payload.heard();
    let line = heard.last().expect("navigation");
    let truth = payload.mvc.truth();
    // 66.1 W is 2.9 degrees east of its zone's meridian: nearly two degrees of convergence.
    let convergence_deg = utm_convergence_deg(truth.position);
    assert!(convergence_deg.abs() > 1.5, "{convergence_deg}");
    let expected = Heading::from_deg(truth.heading_deg)
        .unwrap()
        .to_grid(convergence_deg)
        .as_deg();
    let off_deg = backseat_units::math::wrap_180(field(line, 9) - expected);
    assert!(off_deg.abs() < 0.3, "{line} {expected}");
}

#[test]
fn quality_is_one_on_the_surface_and_none_below() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    payload.until(1.0);
    assert!(payload.heard().iter().all(|line| field(line, 6) == 1.0));
    payload.until(60.0);
    assert!(payload.heard().last().is_some_and(|line| field(line, 6) == 0.0));
}

#[test]
fn altitude_without_bottom_lock_reads_zero() {
    let text = CALM.replace("[sensors]", "[sensors]\naltitude_range_m = 55").replace(
        "altitude_dropouts_per_h = 0",
        "altitude_dropouts_per_h = 300\naltitude_dropout_s = 2",
    );
    let mut payload = Payload::connected(&text, 1, &["NVG"]);
    payload.until(1.0);
    assert!(
        payload
            .heard()
            .iter()
            .all(|line| line.split(',').nth(7) == Some("0.000")),
        "60 m is out of range"
    );
    payload.until(60.0);
    payload.heard();
    payload.until(180.0);
    let readings: Vec<f64> = payload.heard().iter().map(|line| field(line, 7)).collect();
    let lost = readings.iter().filter(|metres| **metres == 0.0).count();
    assert!((50..600).contains(&lost), "{lost} of {}", readings.len());
    assert!(
        readings
            .iter()
            .all(|metres| *metres == 0.0 || (metres - 50.0).abs() < 0.3)
    );
}

#[test]
fn the_ctd_measures_the_plume() {
    let mut payload = Payload::connected(LIVELY, 2, &["CTD"]);
    payload.until(400.0);
    let mut heard = payload.heard();
    heard.retain(|line| line.starts_with("$BFCTD"));
    assert!((398..=401).contains(&heard.len()), "{}", heard.len());
    let truth = payload.mvc.truth();
    let line = heard.last().expect("a reading");
    let expected = payload
        .mvc
        .world()
        .temperature_c(truth.local, truth.depth_m, payload.now);
    assert!((field(line, 3) - expected).abs() < 0.1, "{line} {expected}");
    assert!(
        (field(line, 4) - 101.325 - 10.052 * truth.depth_m).abs() < 3.0,
        "{line}"
    );
}

#[test]
fn position_drifts_under_water_and_stays_near_the_truth() {
    let mut payload = Payload::connected(LIVELY, 5, &["NVG"]);
    payload.until(300.0);
    let line = payload.heard().pop().expect("navigation");
    let off_m = off(&payload, &line).distance_m(EastNorth::default());
    assert!(off_m > 0.001 && off_m < 8.0, "{off_m}");
}

/// SPI 6.1: the errors of the position by their sources, with 60 seeds. The vehicle is deep and goes at a steady 2 m/s
/// for 1000 s.
#[test]
fn with_bottom_lock_the_error_is_a_share_of_the_distance_and_a_walk() {
    let spread = |keys: &[(&str, &str)]| {
        let mut text = far();
        for (section, key) in keys {
            text = with(&text, section, key);
        }
        let off: Vec<EastNorth> = (0..60).map(|seed| flown(&text, seed, 1000.0)).collect();
        let (first, last) = (flown(&text, 0, 500.0), off[0]);
        (
            deviation(&off, |off| off.east_m),
            deviation(&off, |off| off.north_m),
            first,
            last,
        )
    };
    // With perfect sensors the position is exact, to the millimetres to which the message rounds.
    let (across, along, ..) = spread(&[]);
    assert!(across < 0.02 && along < 0.02, "{across} {along}");
    // 0.2 % of 1990 m and more, only along the track, and the same share of each part of the way.
    let (across, along, half, whole) = spread(&[("sensors.dvl", "scale_error = 0.002")]);
    assert!((3.0..5.2).contains(&along) && across < 0.1, "{across} {along}");
    assert!((whole.north_m / half.north_m - 2.0).abs() < 0.1, "{half:?} {whole:?}");
    // The angle between DVL and inertial system, and the error of the heading, lead across the track.
    for key in [
        ("sensors.dvl", "misalignment_deg = 0.1"),
        ("sensors.ins", "heading_bias_deg = 0.1"),
    ] {
        let (across, along, ..) = spread(&[key]);
        assert!((2.5..4.5).contains(&across) && along < 0.1, "{across} {along}");
    }
    // 6 m per root hour: 3.2 m each way after 1000 s.
    let (across, along, ..) = spread(&[("sensors", "position_drift_m_per_sqrt_h = 6")]);
    assert!(
        (2.4..4.0).contains(&across) && (2.4..4.0).contains(&along),
        "{across} {along}"
    );
}

#[test]
fn the_default_sensors_have_modest_errors() {
    let (before, after) = far()
        .split_once("[sensors]")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .expect("sensors");
    let (_, after) = after.split_once("[mission]").expect("a mission");
    let text = with(&format!("{before}[mission]{after}"), "vehicle", "tick_hz = 2");
    let off: Vec<f64> = (0..60)
        .map(|seed| flown(&text, seed, 1200.0).distance_m(EastNorth::default()))
        .collect();
    let rms = (off.iter().map(|metres| metres * metres).sum::<f64>() / 60.0).sqrt();
    assert!((1.5..4.8).contains(&rms), "{rms}");
    assert!(off.iter().all(|metres| *metres < 13.0), "{off:?}");
}

/// Out of the DVL's reach the velocity itself is wrong, so that the position's error grows faster than with bottom
/// lock.
#[test]
fn without_bottom_lock_the_error_grows_with_the_time_to_the_power_of_three_halves() {
    let text = with(&far(), "sensors", "altitude_range_m = 10");
    let text = with(&text, "sensors.ins", "velocity_walk_mps_per_sqrt_s = 0.01");
    let spread = |seconds| {
        let off: Vec<EastNorth> = (0..60).map(|seed| flown(&text, seed, seconds)).collect();
        (deviation(&off, |off| off.east_m), deviation(&off, |off| off.north_m))
    };
    // The integral of a random walk: 0.01 times the root of a third of t cubed.
    for (seconds, expected) in [(200.0, 16.3), (800.0, 130.6)] {
        let (east, north) = spread(seconds);
        let share = (east * east + north * north).sqrt() / (expected * 2.0_f64.sqrt());
        assert!((0.75..1.25).contains(&share), "{seconds} {east} {north}");
    }
}

#[test]
fn without_bottom_lock_navigation_by_water_is_wrong_by_the_change_of_the_current() {
    let text = far().replace(
        "[sensors]",
        "[current]\nspeed_mps = 0.4\ntowards_deg = 90\ndecay_depth_m = 5\n[sensors]",
    );
    let text = with(&text, "sensors", "altitude_blanking_m = 58");
    let text = with(&text, "sensors.ins", "velocity_walk_mps_per_sqrt_s = 0");
    let by_water = with(&text, "sensors.ins", "without_lock = \"water\"");
    // At the last lock, 2 m down, the current was five times that at 10 m: 0.21 m/s more.
    let off = flown(&by_water, 1, 300.0);
    let per_s = off.east_m / 280.0;
    assert!((0.17..0.24).contains(&per_s), "{off:?}");
    assert!(flown(&text, 1, 300.0).distance_m(EastNorth::default()) < 0.1);
}

#[test]
fn gps_is_in_the_solution_only_on_the_surface_and_after_its_acquisition() {
    let text =
        surfacing("acquisition_s = 20").replace("position_drift_m_per_sqrt_h = 0", "position_drift_m_per_sqrt_h = 30");
    let mut payload = Payload::connected(&text, 3, &["NVG"]);
    assert!(payload.until_that(300.0, |truth| truth.depth_m > 4.0));
    assert!(payload.until_that(300.0, |truth| truth.depth_m < 0.3));
    let up_s = payload.now.as_secs_f64();
    payload.until(up_s + 60.0);
    let heard = payload.heard();
    let quality = |line: &str| field(line, 6);
    // At the surface, before its dive, the vehicle has GPS in the solution; under water it has none.
    assert_eq!(quality(&heard[0]), 1.0);
    for line in heard.iter().filter(|line| field(line, 8) > 0.31) {
        assert_eq!(quality(line), 0.0, "{line}");
    }
    let back = heard
        .iter()
        .rposition(|line| quality(line) == 0.0)
        .expect("under water")
        + 1;
    let after_s = seconds(&heard[back]) - 8.0 * 3600.0 - up_s;
    assert!((19.95..20.15).contains(&after_s), "{after_s}");
    // The solution jumps to the fix.
    let jump_m = place(&payload, &heard[back]).distance_m(place(&payload, &heard[back - 1]));
    let after_m = off(&payload, heard.last().expect("navigation")).distance_m(EastNorth::default());
    assert!(jump_m > 1.0 && after_m < 0.1, "{jump_m} {after_m}");
    let log = payload.log();
    assert_eq!(
        log.iter().filter(|line| line.contains("navigation uses GPS")).count(),
        1
    );
    assert_eq!(
        log.iter()
            .filter(|line| line.contains("navigation no longer uses GPS"))
            .count(),
        1
    );
}

#[test]
fn a_receiver_that_fails_gives_no_fix_on_the_surface() {
    let text = with(CALM, "mission", "starts_after_s = 100");
    let mut payload = Payload::connected(&text, 1, &["NVG"]);
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Gps, true));
    payload.until(0.5);
    assert!(payload.heard().iter().all(|line| field(line, 6) == 0.0));
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Gps, false));
    // The receiver acquires again: 5 s from the first step at which it works, at 0.6 s.
    payload.until(5.55);
    assert!(payload.heard().iter().all(|line| field(line, 6) == 0.0));
    payload.until(5.65);
    assert!(payload.heard().iter().all(|line| field(line, 6) == 1.0));
}

#[test]
fn fixes_have_the_spread_of_the_receiver() {
    let text = with(&surfacing("acquisition_s = 0"), "sensors.gps", "error_m = 2");
    let off: Vec<EastNorth> = (0..100)
        .map(|seed| {
            let mut payload = Payload::connected(&text, seed, &["NVG"]);
            payload.until(0.5);
            let line = payload.heard().pop().expect("navigation");
            off(&payload, &line)
        })
        .collect();
    for each_way in [deviation(&off, |off| off.east_m), deviation(&off, |off| off.north_m)] {
        assert!((1.5..2.5).contains(&each_way), "{each_way}");
    }
}

/// SPI 6.1, 6.2: what clients have subscribed to does not influence a reading.
#[test]
fn other_subscriptions_change_no_byte_of_the_navigation() {
    let run = |before: &[&str], later: &[&str]| {
        let mut payload = Payload::connected(LIVELY, 9, before);
        payload.until(50.0);
        for message in later {
            payload.say(&format!("$BPLOG,{message},ON"));
        }
        payload.until(200.0);
        let heard = payload.heard();
        let of = |name: &str| -> Vec<String> {
            heard
                .iter()
                .filter(|line| line.starts_with(name) && seconds(line) > 86_399.0 - 30.0)
                .cloned()
                .collect()
        };
        (of("$BFNVG"), of("$BFNVR"), of("$BFDVL"), of("$BFCTD"))
    };
    let (navigation, velocity, ..) = run(&["NVG", "NVR"], &[]);
    assert!(navigation.len() > 200);
    let (same, same_velocity, dvl, ctd) = run(&["ALL"], &[]);
    assert!(navigation == same && velocity == same_velocity);
    let (same, same_velocity, late_dvl, late_ctd) = run(&["CTL"], &["ALL"]);
    assert!(navigation == same && velocity == same_velocity);
    // For the other sensors it does not matter either since when they are subscribed.
    assert!(dvl == late_dvl && ctd == late_ctd && dvl.len() > 100 && ctd.len() > 20);
}

#[test]
fn frozen_navigation_repeats_its_solution_and_goes_on() {
    let mut payload = Payload::connected(LIVELY, 1, &["NVG", "NVR"]);
    payload.until(30.0);
    let before = payload.heard();
    payload.mvc.fail_sensor(SensorFailure::Frozen(true));
    payload.until(35.0);
    let frozen = payload.heard();
    assert_eq!(frozen.len(), 100);
    let tail = |line: &str| line[17..].to_owned();
    for (index, line) in frozen.iter().enumerate() {
        // Everything but the time of the message is repeated: the solution's time and the values too.
        assert_eq!(tail(line), tail(&before[before.len() - 2 + index % 2]));
    }
    assert!(frozen[98].starts_with("$BFNVG,235905.000,") && frozen[98].ends_with(",235900.000"));
    payload.mvc.fail_sensor(SensorFailure::Frozen(false));
    payload.until(35.1);
    let line = payload.heard().swap_remove(0);
    assert!(line.ends_with(",235905.100"), "{line}");
    assert!(off(&payload, &line).distance_m(EastNorth::default()) < 5.0);
}

#[test]
fn the_vehicle_follows_a_jump_of_its_navigation_and_navigation_can_fall_silent() {
    let mut payload = Payload::connected(CALM, 1, &["NVG", "NVR"]);
    payload.until(100.0);
    payload.heard();
    payload.mvc.fail_sensor(SensorFailure::Jump(EastNorth::new(8.0, 0.0)));
    payload.until(100.1);
    let line = payload.heard().swap_remove(0);
    assert!((off(&payload, &line).east_m - 8.0).abs() < 0.01);
    // The vehicle steers the solution back to the line, and is itself 8 m beside it.
    payload.until(160.0);
    let east_m = payload.mvc.truth().local.east_m;
    assert!((east_m + 8.0).abs() < 1.5, "{east_m}");
    payload.heard();
    payload.mvc.fail_sensor(SensorFailure::Silent(true));
    payload.until(165.0);
    assert!(payload.heard().is_empty());
    payload.mvc.fail_sensor(SensorFailure::Silent(false));
    payload.until(165.5);
    assert_eq!(payload.heard().len(), 10);
}

#[test]
fn heading_and_depth_are_held_as_the_vehicle_reads_them() {
    let text = with(
        &with(CALM, "sensors.ins", "heading_bias_deg = 5"),
        "sensors.depth",
        "bias_kpa = 5",
    );
    let mut payload = Payload::connected(&text, 4, &["NVG"]);
    payload.until(20.0);
    while payload.now.as_secs_f64() < 80.0 {
        payload.say("$BPRMB,080000.000,45,10,0,2,1,0");
        let next = payload.now.as_secs_f64() + 2.0;
        payload.until(next);
    }
    let line = payload.heard().pop().expect("navigation");
    let truth = payload.mvc.truth();
    let grid_deg = 45.0 - utm_convergence_deg(truth.position);
    assert!((field(&line, 9) - grid_deg).abs() < 0.1, "{line} {grid_deg}");
    assert!((truth.heading_deg - 45.0).abs() > 0.5, "{truth:?}");
    assert!(
        (field(&line, 8) - 10.0).abs() < 0.05 && (truth.depth_m - 10.0).abs() > 0.05,
        "{line} {truth:?}"
    );
}

#[test]
fn a_failed_sensor_takes_its_part_out_of_the_navigation() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    payload.until(5.0);
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Depth, true));
    payload.heard();
    payload.until(20.0);
    let heard = payload.heard();
    assert!(heard.iter().all(|line| field(line, 8) == field(&heard[0], 8)));
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Altimeter, true));
    payload.until(21.0);
    assert!(
        payload
            .heard()
            .iter()
            .all(|line| line.split(',').nth(7) == Some("0.000"))
    );
    assert!(!payload.log().iter().any(|line| line.contains("bottom lock lost")));
    payload
        .mvc
        .fail_sensor(SensorFailure::Dropout(Sensor::Altimeter, false));
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Dvl, true));
    payload.until(22.0);
    assert!(
        payload
            .heard()
            .iter()
            .all(|line| line.split(',').nth(7) == Some("0.000"))
    );
    assert!(payload.log().iter().any(|line| line.contains("bottom lock lost")));
}

/// A plan that begins at the surface, dives to 6 m, and comes up again.
fn surfacing(gps: &str) -> String {
    let plan = "[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 60\ndepth_m = 6\nspeed_mps = 1.5\n\
        [[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 400\ndepth_m = 0\nspeed_mps = 1.5\n";
    let (before, _) = CALM.split_once("[[plan]]").expect("a plan");
    with(&format!("{before}{plan}"), "sensors.gps", gps)
}

/// The calm sea, in which the vehicle goes north at 2 m/s all the time.
fn far() -> String {
    let plan = "[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 3000\ndepth_m = 10\nspeed_mps = 2\n";
    let (before, _) = CALM.split_once("[[plan]]").expect("a plan");
    // Two steps a second: the statistics of minutes need no more.
    with(&format!("{before}{plan}"), "vehicle", "tick_hz = 2")
}

/// The error of the navigation this many seconds after the start, without the noise of the reading itself.
fn flown(text: &str, seed: u64, seconds: f64) -> EastNorth {
    let mut payload = Payload::connected(text, seed, &[]);
    payload.until(seconds - 0.6);
    payload.say("$BPLOG,NVG,ON");
    payload.until(seconds);
    let line = payload.heard().pop().expect("navigation");
    off(&payload, &line)
}

fn deviation(off: &[EastNorth], of: impl Fn(&EastNorth) -> f64) -> f64 {
    (off.iter().map(|off| of(off) * of(off)).sum::<f64>() / off.len() as f64).sqrt()
}

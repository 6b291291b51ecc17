//! `vehicle.model = "6-dof"`: the same missions and requests, flown by a body with six degrees of freedom.

use backseat_mvc::{Activity, Truth, WorldFile};
use backseat_units::EastNorth;
use backseat_units::math::{hypot, wrap_180};

use crate::files::CALM;
use crate::payload::{ME, Payload, course, done};
use crate::sentences::{field, heard, with};

fn body(text: &str) -> String {
    format!("{text}\n[vehicle]\nmodel = \"6-dof\"\n")
}

/// [`CALM`] with another plan.
fn planned(plan: &str) -> String {
    let (before, _) = CALM.split_once("[[plan]]").expect("the file has a plan");
    body(&format!("{before}{plan}"))
}

/// Sends a modify each second, from the 30th second up to another, and returns the payload then.
fn modified(text: &str, fields: &str, until: u32) -> Payload {
    let mut payload = Payload::connected(text, 1, &["NVG", "NVR", "ERC", "RVL"]);
    for second in 30..until {
        payload.until(f64::from(second));
        payload.say(&format!("$BPRMB,070000.000,{fields}"));
    }
    payload.until(f64::from(until));
    payload
}

fn newest(payload: &mut Payload, name: &str) -> String {
    let lines = payload.heard();
    let start = format!("$BF{name},");
    let line = lines.iter().rfind(|line| line.starts_with(&start));
    line.expect("the message is on").clone()
}

/// SPI 6.1, 6.2, 6.9, 6.10.
#[test]
fn the_plan_is_flown_as_planned_and_reported_as_always() {
    let mut payload = Payload::connected(&body(CALM), 1, &["MBS", "MBE", "MIS"]);
    // On the line, once the dive has settled.
    let (mut off_m, mut off_depth_m, mut off_mps) = (0.0_f64, 0.0_f64, 0.0_f64);
    for second in 60..190 {
        payload.until(f64::from(second));
        let truth = payload.mvc.truth();
        assert_eq!(truth.activity, Activity::Plan { number: 1 });
        off_m = off_m.max(truth.local.east_m.abs());
        off_depth_m = off_depth_m.max((truth.depth_m - 10.0).abs());
        off_mps = off_mps.max((truth.speed_mps - 2.0).abs());
    }
    assert!(
        off_m < 0.5 && off_depth_m < 0.3 && off_mps < 0.05,
        "{off_m} {off_depth_m} {off_mps}"
    );
    done(&mut payload);
    let heard = payload.heard();
    assert_eq!(course(&heard), ["+1", "-1", "+2", "-2"]);
    assert!(heard.iter().any(|line| line.contains(",Completed,")), "{heard:?}");
    // The vehicle floats up.
    let over_s = payload.now.as_secs_f64();
    payload.until(over_s + 150.0);
    assert!(payload.mvc.truth().depth_m < 0.3);
}

/// SPI 6.1, 6.2: attitude and rates are the body's; BFNVR's north and east are over ground.
#[test]
fn navigation_reports_the_bodys_motion() {
    let mut payload = Payload::connected(&body(CALM), 1, &["NVG", "NVR"]);
    let (mut steepest_deg, mut rolled_deg) = (0.0_f64, 0.0_f64);
    let mut before_deg = None;
    for tenth in 20..600 {
        payload.until(f64::from(tenth) * 0.1 + 0.01);
        let truth = payload.mvc.truth();
        let lines = payload.heard();
        let (navigation, rates) = (&lines[lines.len() - 2], &lines[lines.len() - 1]);
        assert!(
            (field(navigation, 8) - truth.depth_m).abs() < 0.001,
            "{navigation} {truth:?}"
        );
        let (roll_deg, pitch_deg) = (field(navigation, 10), field(navigation, 11));
        steepest_deg = steepest_deg.min(pitch_deg);
        rolled_deg = rolled_deg.max(roll_deg.abs());
        // The rate of pitch agrees with the pitch that BFNVG reports.
        if let Some((pitch_before_deg, rate_before_dps)) = before_deg.replace((pitch_deg, field(rates, 5))) {
            let mean_dps = 0.5 * (rate_before_dps + field(rates, 5));
            assert!(
                (pitch_deg - pitch_before_deg - 0.1 * mean_dps).abs() < 0.2,
                "{navigation} {rates}"
            );
        }
        assert!((field(rates, 3) - truth.north_mps).abs() < 0.002 || (field(rates, 2) - truth.north_mps).abs() < 0.002);
    }
    // The vehicle dives nose down, and its propeller makes it heel.
    assert!(steepest_deg < -8.0 && steepest_deg > -30.0, "{steepest_deg}");
    assert!(rolled_deg > 0.5 && rolled_deg < 15.0, "{rolled_deg}");
}

#[test]
fn a_circle_is_flown_round() {
    let text = planned(
        "[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 0, north_m = 120 }\nradius_m = 40\norbits = 1.5\n\
         depth_m = 8\nspeed_mps = 1.6\n",
    );
    let mut payload = Payload::connected(&text, 1, &["MBS", "MBE"]);
    let centre = EastNorth::new(0.0, 120.0);
    let (mut nearest_m, mut furthest_m, mut swept_deg) = (f64::INFINITY, 0.0_f64, 0.0);
    let mut before_deg = None;
    for second in 100..400 {
        payload.until(f64::from(second));
        let truth = payload.mvc.truth();
        if truth.activity != (Activity::Plan { number: 1 }) {
            break;
        }
        let out_m = centre.distance_m(truth.local);
        // By then the vehicle has reached the rim.
        if second > 125 {
            (nearest_m, furthest_m) = (nearest_m.min(out_m), furthest_m.max(out_m));
        }
        let bearing_deg = centre.bearing_deg(truth.local);
        if let Some(before_deg) = before_deg.replace(bearing_deg) {
            swept_deg += wrap_180(bearing_deg - before_deg);
        }
    }
    assert!(nearest_m > 39.0 && furthest_m < 41.0, "{nearest_m} {furthest_m}");
    // The first part of the circle was before the 100th second.
    assert!(swept_deg > 300.0 && swept_deg < 540.0, "{swept_deg}");
    done(&mut payload);
    assert_eq!(course(&payload.heard()), ["+1", "-1"]);
}

/// SPI 7.12: heading, depth and speed. 5 s after the last modify the vehicle goes back to its line by itself.
#[test]
fn heading_depth_and_speed_are_flown_until_they_lapse() {
    let mut payload = modified(&body(CALM), "90,15,0,1.5,1,0", 90);
    let truth = payload.mvc.truth();
    assert!(wrap_180(truth.heading_deg - 90.0).abs() < 1.0, "{truth:?}");
    assert!(
        (truth.depth_m - 15.0).abs() < 0.3 && (truth.speed_mps - 1.5).abs() < 0.03,
        "{truth:?}"
    );
    assert!(truth.local.east_m > 50.0);
    // The last modify was at 89 s.
    payload.until(93.9);
    assert!(matches!(payload.mvc.truth().activity, Activity::Modified { .. }));
    payload.until(94.0);
    assert_eq!(payload.mvc.truth().activity, Activity::Plan { number: 1 });
    payload.until(230.0);
    let truth = payload.mvc.truth();
    assert!(
        truth.local.east_m.abs() < 2.0 && (truth.depth_m - 10.0).abs() < 0.3,
        "{truth:?}"
    );
}

/// SPI 7.12: "0 signifies the previous field is a thruster RPM"; 6.7 reports the thruster's own RPM.
#[test]
fn a_requested_thruster_rpm_is_held() {
    let mut payload = modified(&body(CALM), "0,10,0,1000,0,0", 120);
    let line = newest(&mut payload, "RVL");
    assert!((field(&line, 2) - 1000.0).abs() < 1.0, "{line}");
    // The published 2.5 m/s at 1525 rpm make 1.64 m/s at 1000 rpm, at the same advance ratio.
    let truth = payload.mvc.truth();
    assert!((truth.speed_mps - 1.64).abs() < 0.08, "{truth:?}");
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("depth 10.00 m, 1000 rpm"))
    );
}

/// SPI 7.12: a rudder and an elevator adjustment, here taken as the angles themselves; 6.12 reports the angles and
/// their targets.
#[test]
fn fins_are_held_at_the_requested_angles_and_reported() {
    let mut payload = modified(&body(CALM), "6,10,0,1.6,1,1", 90);
    let line = newest(&mut payload, "ERC");
    assert!(
        (field(&line, 3) - 6.0).abs() < 0.01 && (field(&line, 5) - 6.0).abs() < 0.01,
        "{line}"
    );
    let before_deg = payload.mvc.truth().heading_deg;
    payload.until(92.0);
    let turned_dps = wrap_180(payload.mvc.truth().heading_deg - before_deg) / 2.0;
    assert!((0.8..4.0).contains(&turned_dps), "{turned_dps}");
    // The nose goes up with a positive elevator.
    let mut payload = modified(&body(CALM), "0,3,3,1.6,1,0", 33);
    let line = newest(&mut payload, "ERC");
    assert!(
        (field(&line, 2) - 3.0).abs() < 0.2 && (field(&line, 4) - 3.0).abs() < 0.01,
        "{line}"
    );
    let depth_m = payload.mvc.truth().depth_m;
    payload.until(34.9);
    assert!(payload.mvc.truth().depth_m < depth_m - 0.1);
}

/// A fin has a target that it follows, and a stop.
#[test]
fn a_fin_follows_its_target_and_does_not_pass_its_stop() {
    let text = with(&body(CALM), "interpretation", "modify_beyond = \"refuse\"");
    for (fields, status) in [
        ("15,10,0,1.6,1,1", "2"),
        ("16,10,0,1.6,1,1", "1"),
        ("90,10,0,0.9,1,0", "1"),
    ] {
        let mut payload = Payload::connected(&text, 1, &["ACK"]);
        payload.until(30.0);
        payload.say(&format!("$BPRMB,070000.000,{fields}"));
        let heard = payload.heard();
        assert!(
            heard[0].contains(&format!(",RMB,070000.000,0,{status},")),
            "{fields} {heard:?}"
        );
    }
    let (_, lines) = heard(&body(CALM), 1, "ERC", 2.0, 60.0);
    let mut lags = 0;
    for line in &lines {
        for angle in 2..=5 {
            assert!(field(line, angle).abs() <= 15.0, "{line}");
        }
        lags += u32::from((field(line, 2) - field(line, 4)).abs() > 0.01);
    }
    assert!(lags > 10, "{lags}");
}

/// SPI 7.16: the abort's wrap-up is a powered ascent; then the vehicle drifts with the water.
#[test]
fn an_abort_brings_the_vehicle_up_and_it_drifts_with_the_current() {
    let text = with(&body(CALM), "mission", "wrap_up = \"surface\"");
    let text = format!("{text}\n[current]\nspeed_mps = 0.3\ntowards_deg = 90\n");
    let mut payload = Payload::connected(&text, 1, &["MIS", "NVR"]);
    payload.until(60.0);
    let truth = payload.mvc.truth();
    assert!(truth.depth_m > 9.0 && truth.local.east_m.abs() < 2.0, "{truth:?}");
    payload.say("$BPABT,070000.000,leak,1");
    assert_eq!(payload.mvc.truth().activity, Activity::WrappingUp);
    assert!(payload.until_that(200.0, |truth| truth.activity == Activity::Stopped));
    let heard = payload.heard();
    assert!(heard.iter().any(|line| line.contains("Aborted")));
    let from = payload.now.as_secs_f64();
    payload.until(from + 120.0);
    let before = payload.mvc.truth();
    payload.until(from + 180.0);
    let after = payload.mvc.truth();
    let drifted = after.local - before.local;
    assert!(
        (drifted.east_m - 18.0).abs() < 0.5 && drifted.north_m.abs() < 0.5,
        "{drifted:?}"
    );
    assert!(after.depth_m < 0.3 && after.speed_mps.abs() < 0.05, "{after:?}");
    // Without its autopilot the propeller stands still (6.7).
    payload.say("$BPLOG,RVL,ON");
    payload.until(from + 182.0);
    assert!(field(&newest(&mut payload, "RVL"), 2).abs() < 0.01);
}

/// In a current abeam the vehicle stays on a line by heading into the current. On a fixed heading it drifts (SPI 5.3).
#[test]
fn the_vehicle_crabs_along_a_line_and_drifts_on_a_heading() {
    let text = format!("{}\n[current]\nspeed_mps = 0.4\ntowards_deg = 90\n", body(CALM));
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(120.0);
    let truth = payload.mvc.truth();
    assert!(
        truth.local.east_m.abs() < 1.0 && wrap_180(truth.heading_deg) < -8.0,
        "{truth:?}"
    );
    let truth = modified(&text, "0,10,0,2,1,0", 100).mvc.truth();
    assert!(
        truth.local.east_m > 15.0 && (truth.east_mps - 0.4).abs() < 0.05,
        "{truth:?}"
    );
}

/// SPI 7.24: buoyancy floats the vehicle up, or lets it sink, when nothing drives it.
#[test]
fn buoyancy_lifts_or_sinks_a_vehicle_adrift() {
    // A modify to 0 rpm stops the thruster.
    let drift = |newtons: f64| {
        let text = format!("{}\n[adjustment]\nbuoyancy_n = {newtons}\n", body(CALM));
        let mut payload = modified(&text, ",,,0,0,", 60);
        let before_m = payload.mvc.truth().depth_m;
        for second in 60..90 {
            payload.until(f64::from(second));
            payload.say("$BPRMB,070000.000,,,,0,0,");
        }
        payload.mvc.truth().depth_m - before_m
    };
    // The vehicle's 0.1 m/s at the nominal 20 N, for 29 s.
    let (rise_m, sink_m) = (drift(20.0), drift(-20.0));
    assert!((rise_m + 2.9).abs() < 0.6, "{rise_m}");
    assert!((sink_m - 2.9).abs() < 0.6, "{sink_m}");
}

/// Whatever the payload asks, the vehicle stays off the bottom, within its depth and its speed (SPI 7.12).
#[test]
fn the_body_keeps_its_own_limits() {
    let text = body(CALM).replace("slope = 0", "slope = 0.1\ndownslope_deg = 270");
    for fields in [
        "90,5000,0,20,1,0",
        "90,-20,2,20,1,0",
        "90,-15,3,5000,0,0",
        "15,0,1,2,1,1",
    ] {
        let mut payload = Payload::connected(&text, 1, &[]);
        for second in 10..250 {
            payload.until(f64::from(second));
            payload.say(&format!("$BPRMB,070000.000,{fields}"));
            let truth = payload.mvc.truth();
            assert!(truth.altitude_m > 1.0 && truth.speed_mps <= 2.45, "{fields} {truth:?}");
        }
    }
}

#[test]
fn a_file_with_what_the_body_cannot_fly_is_refused() {
    let fault = |text: &str| WorldFile::from_toml(text).unwrap_err().to_string();
    assert_eq!(
        fault(&format!("{}class = \"hovering\"\n", body(CALM))),
        "vehicle.model is \"6-dof\", expected \"kinematic\" with the class \"hovering\": the body of 6-dof is a \
         torpedo"
    );
    let slow = body(CALM).replacen("speed_mps = 2", "speed_mps = 0.8", 1);
    assert_eq!(fault(&slow), "plan element 1: speed_mps is 0.8, expected 1 to 2.4");
    let wrong = body(CALM).replace("6-dof", "5-dof");
    assert!(fault(&wrong).contains("unknown variant `5-dof`, expected `kinematic` or `6-dof`"));
    // An insert that is too slow for the body (SPI 7.5) is refused, like one that is too slow for any vehicle.
    let mut payload = Payload::connected(&body(CALM), 1, &["ACK"]);
    payload.until(30.0);
    payload.say("$BPRTK,070000.000,7,4218.10,N,07054.00,W,4218.20,N,07054.00,W,0,10,0.8,0,0");
    let heard = payload.heard();
    assert!(heard[0].contains(",RTK,070000.000,7,1,"), "{heard:?}");
}

/// The same run gives the same bits, and the body's steps are 20 ms whatever the vehicle's are.
#[test]
fn the_same_file_gives_the_same_bytes_and_the_tick_rate_hardly_matters() {
    let run = |text: &str| {
        let mut payload = Payload::connected(text, 3, &["NVG", "NVR", "ERC", "IMU"]);
        payload.until(30.0);
        payload.say("$BPRMB,070000.000,60,14,0,1.5,1,0");
        payload.until(100.0);
        (payload.heard(), payload.mvc.truth())
    };
    let (lines, truth) = run(&body(CALM));
    assert_eq!(run(&body(CALM)).0, lines);
    let (_, finer) = run(&format!("{}tick_hz = 50\n", body(CALM)));
    let apart = |a: Truth, b: Truth| hypot(a.local.distance_m(b.local), a.depth_m - b.depth_m);
    assert!(apart(truth, finer) < 0.3, "{truth:?} {finer:?}");
}

/// After a long time adrift no value is NaN.
#[test]
fn a_vehicle_adrift_for_hours_moves_only_with_the_water() {
    let mut payload = Payload::new(&body(CALM), 1);
    payload.connect(ME);
    payload.until(60.0);
    payload.say("$BPKIL,070000.000,enough");
    payload.until(7200.0);
    let truth = payload.mvc.truth();
    assert!(truth.local.east_m.abs() < 2.0 && truth.depth_m < 0.3, "{truth:?}");
    assert!(
        truth.speed_mps.abs() < 1e-3 && truth.heading_deg.is_finite(),
        "{truth:?}"
    );
}

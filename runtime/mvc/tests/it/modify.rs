use backseat_mvc::Activity;

use crate::files::CALM;
use crate::payload::{ME, Payload};

fn modified(payload: &Payload) -> bool {
    matches!(
        payload.mvc.truth().activity,
        Activity::Modified {
            number: Some(1),
            id: None
        }
    )
}

#[test]
fn a_modify_lapses_five_seconds_after_the_last_one_even_between_two_steps() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(10.0);
    payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    payload.until(13.04);
    payload.say("$BPRMB,070000.001,90,15,0,1.5,1,0");
    payload.until(18.0);
    assert!(modified(&payload));
    payload.until(18.1);
    assert!(!modified(&payload));
    assert_eq!(payload.mvc.truth().activity, Activity::Plan { number: 1 });
    let log = payload.log();
    assert!(
        log.contains(
            &"10.000 s: client 1 modifies the behavior: heading 90.0 deg, depth 15.00 m, speed 1.50 m/s".into()
        )
    );
    assert!(
        log.contains(&"18.040 s: modify ended: 5 s without a refresh".into()),
        "{log:?}"
    );
}

#[test]
fn a_modify_lapses_even_without_its_client() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(10.0);
    payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    payload.mvc.disconnect(payload.now, ME);
    payload.until(14.9);
    assert!(modified(&payload));
    payload.until(15.0);
    assert!(!modified(&payload));
}

#[test]
fn a_late_refresh_finds_the_modify_lapsed() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(10.0);
    payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    // The driver woke late: the refresh comes before any timeout was handled.
    payload.now = backseat_units::Timestamp::from_millis(15_050);
    payload.say("$BPRMB,070000.001,90,15,0,1.5,1,0");
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line == "15.000 s: modify ended: 5 s without a refresh")
    );
}

#[test]
fn heading_depth_and_speed_are_flown_and_empty_fields_inherit() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    for second in 10..60 {
        payload.until(f64::from(second));
        payload.say(&format!("$BPRMB,0700{second:02}.000,90,20,0,1.2,1,0"));
    }
    let truth = payload.mvc.truth();
    assert!((truth.heading_deg - 90.0).abs() < 0.5, "{truth:?}");
    assert!(
        (truth.depth_m - 20.0).abs() < 0.2 && (truth.speed_mps - 1.2).abs() < 0.02,
        "{truth:?}"
    );
    for second in 60..100 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,,40,1,,,");
    }
    let truth = payload.mvc.truth();
    // The altitude is 40 m in 60 m of water, the speed is the plan's again, and the vehicle heads back to its line.
    assert!(
        (truth.altitude_m - 40.0).abs() < 0.2 && (truth.speed_mps - 2.0).abs() < 0.02,
        "{truth:?}"
    );
    assert!(truth.heading_deg > 270.0 || truth.heading_deg < 10.0, "{truth:?}");
}

#[test]
fn end_modify_ends_it_at_once_and_the_vehicle_returns_to_its_line() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    for second in 10..40 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,45,20,0,2,1,0");
    }
    assert!(payload.mvc.truth().local.east_m > 30.0);
    payload.say("$BPEMB,070000.000");
    assert!(!modified(&payload));
    payload.until(110.0);
    let truth = payload.mvc.truth();
    assert!(
        truth.local.east_m.abs() < 1.5 && (truth.depth_m - 10.0).abs() < 0.2,
        "{truth:?}"
    );
}

#[test]
fn the_vehicle_stays_within_its_own_limits() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    for second in 10..150 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,90,5000,0,20,1,0");
        let truth = payload.mvc.truth();
        assert!(truth.altitude_m > 1.5 && truth.speed_mps <= 2.5, "{truth:?}");
    }
    assert!(payload.mvc.truth().depth_m > 55.0);
}

#[test]
fn the_behavior_under_a_modify_ends_by_its_own_progress() {
    let mut payload = Payload::connected(CALM, 1, &["MBE", "CTL"]);
    let mut ended = None;
    for second in 10..400 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,30,10,0,2,1,0");
        let heard = payload.heard();
        if let Some(line) = heard.iter().find(|line| line.starts_with("$BFMBE")) {
            assert!(line.ends_with(",survey.dive,1,,trackline"), "{line}");
            assert!(
                heard
                    .iter()
                    .any(|line| line.starts_with("$BFCTL") && line.ends_with(",0"))
            );
            ended = Some(payload.mvc.truth());
            break;
        }
    }
    let truth = ended.expect("the line ends although the vehicle is far off it");
    assert!(
        truth.local.east_m > 150.0 && (truth.local.north_m - 400.0).abs() < 5.0,
        "{truth:?}"
    );
    // The next behavior allows no dynamic requests: the modify ended with control.
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("modify ended: control was taken back"))
    );
}

#[test]
fn limits_on_duration_and_deviation_end_the_behavior_or_the_modify() {
    for (limit, what, next) in [
        ("modify_total_s = 20", "behavior", Activity::Plan { number: 2 }),
        ("modify_deviation_m = 15", "behavior", Activity::Plan { number: 2 }),
        ("modify_deviation_m = 15", "modify", Activity::Plan { number: 1 }),
    ] {
        let mission = format!("[mission]\n{limit}\nmodify_limit = \"{what}\"");
        let mut payload = Payload::connected(&CALM.replace("[mission]", &mission), 1, &["ACK"]);
        for second in 20..45 {
            payload.until(f64::from(second));
            payload.say("$BPRMB,070000.000,90,10,0,2,1,0");
        }
        assert_eq!(payload.mvc.truth().activity, next, "{limit} {what}");
        let heard = payload.heard();
        assert!(
            heard.last().is_some_and(|line| line.contains(",RMB,070000.000,0,1,0,")),
            "{heard:?}"
        );
    }
}

#[test]
fn without_control_a_modify_is_refused() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080000.000,RMB,070000.000,0,1,0,dynamic requests are not allowed now"]
    );
}

#[test]
fn the_heading_frame_is_a_setting() {
    // At 70.9 W the UTM grid's north differs from true north by 1.27 degrees: zone 19 is centred on 69 W.
    for (frame, heading_deg) in [("true", 90.0), ("grid", 90.0 - 1.279)] {
        let text = format!("{CALM}\n[interpretation]\nmodify_heading = \"{frame}\"");
        let mut payload = Payload::connected(&text, 1, &[]);
        for second in 10..60 {
            payload.until(f64::from(second));
            payload.say("$BPRMB,070000.000,90,10,0,2,1,0");
        }
        let truth = payload.mvc.truth();
        assert!(
            (truth.heading_deg - heading_deg).abs() < 0.1,
            "{frame} {}",
            truth.heading_deg
        );
    }
}

/// Sends a modify each second, from the 10th second up to another, and returns the vehicle's truth then.
fn flown(text: &str, fields: &str, until: u32) -> backseat_mvc::Truth {
    let mut payload = Payload::connected(text, 1, &[]);
    for second in 10..until {
        payload.until(f64::from(second));
        payload.say(&format!("$BPRMB,070000.000,{fields}"));
    }
    payload.until(f64::from(until));
    payload.mvc.truth()
}

/// SPI 7.12: "1 signifies a rudder adjustment", "2 signifies the previous field is a pitch; 3 ... an elevator adjustment",
/// "0 signifies the previous field is a thruster RPM".
#[test]
fn rudder_pitch_elevator_and_rpm_are_flown() {
    let heading = |seconds| flown(CALM, "10,,,,,1", seconds).heading_deg;
    // Half of the greatest rudder at full speed gives half of the fastest turn: 5 degrees a second, to starboard.
    let turned = backseat_units::math::wrap_180(heading(30) - heading(20));
    assert!((turned - 50.0).abs() < 2.0, "{turned}");
    let port = backseat_units::math::wrap_180(
        flown(CALM, "-10,,,,,1", 30).heading_deg - flown(CALM, "-10,,,,,1", 20).heading_deg,
    );
    assert!((port + 50.0).abs() < 2.0, "{port}");
    // 10 degrees down at 1.5 m/s for 40 s: 0.26 m/s.
    let dive = |fields| flown(CALM, fields, 70).depth_m - flown(CALM, fields, 30).depth_m;
    let pitched = dive(",-10,2,1.5,1,");
    assert!((pitched - 10.4).abs() < 0.5, "{pitched}");
    // 8 of 20 degrees of elevator make 10 of 25 degrees of pitch.
    let lifted = dive(",-8,3,1.5,1,");
    assert!((lifted - pitched).abs() < 0.1, "{lifted}");
    let speed_mps = flown(CALM, ",,,450,0,", 60).speed_mps;
    assert!((speed_mps - 1.5).abs() < 0.01, "{speed_mps}");
}

/// SPI 7.12 calls rudder and elevator values adjustments, and does not say of what.
#[test]
fn fin_values_may_be_changes_of_what_the_behavior_steers() {
    let text = format!("{CALM}\n[interpretation]\nmodify_fins = \"change\"");
    // On its line to the north the vehicle has the rudder a little to starboard: it settles to the east of the line and
    // goes on north.
    let truth = flown(&text, "2,-1,3,,,1", 150);
    assert!(truth.local.east_m > 0.5 && truth.local.east_m < 40.0, "{truth:?}");
    assert!(
        backseat_units::math::wrap_180(truth.heading_deg).abs() < 10.0,
        "{truth:?}"
    );
    assert!(truth.depth_m > 10.1 && truth.depth_m < 14.0, "{truth:?}");
}

/// SPI 7.12: "this message can not be used to command the vehicle beyond its safe operating parameters".
#[test]
fn beyond_the_safe_limits_a_modify_is_clipped_or_refused() {
    let cases = [
        ",201,0,,,",
        ",-1,0,,,",
        ",1.9,1,,,",
        ",26,2,,,",
        ",21,3,,,",
        ",,,2.6,1,",
        ",,,0.4,1,",
        ",,,900,0,",
        "21,,,,,1",
    ];
    for (reading, status) in [("clip", "2"), ("refuse", "1")] {
        let text = format!("{CALM}\n[interpretation]\nmodify_beyond = \"{reading}\"");
        for fields in cases {
            let mut payload = Payload::connected(&text, 1, &["ACK"]);
            payload.until(10.0);
            payload.say("$BPRMB,070000.000,,200,0,2.5,1,");
            payload.say(&format!("$BPRMB,070000.001,{fields}"));
            let heard = payload.heard();
            assert!(
                heard[0].contains(",0,2,0,"),
                "the limits themselves are safe: {heard:?}"
            );
            assert!(
                heard[1].contains(&format!(",RMB,070000.001,0,{status},0,")),
                "{reading} {fields}: {heard:?}"
            );
            // The modify in force stays, and so do its 5 s.
            payload.until(14.9);
            assert!(modified(&payload));
            payload.until(15.0);
            assert!(!modified(&payload));
        }
    }
}

/// SPI 7.22 to 7.24 ask for a mission that is "executing but the tailcone is not spinning": a payload can stop it.
#[test]
fn the_thruster_may_be_stopped_whatever_happens_to_values_beyond_the_limits() {
    for reading in ["clip", "refuse"] {
        let text = format!("{CALM}\n[interpretation]\nmodify_beyond = \"{reading}\"");
        for fields in [",,,0,1,", ",,,0,0,"] {
            let mut payload = Payload::connected(&text, 1, &["ACK"]);
            payload.until(30.0);
            payload.say(&format!("$BPRMB,070000.000,{fields}"));
            assert_eq!(
                payload.heard(),
                ["$BFACK,080030.000,RMB,070000.000,0,2,0,"],
                "{reading} {fields}"
            );
            payload.until(34.9);
            assert!(payload.mvc.truth().speed_mps < 1.3, "{:?}", payload.mvc.truth());
        }
    }
}

/// SPI 7.12 modifies "the current behavior", and does not say what happens to the modify when that ends.
#[test]
fn a_modify_goes_on_with_the_next_behavior_or_ends_with_its_own() {
    let text = CALM.replace("kind = \"waypoint\"", "kind = \"waypoint\"\ndynamic = true");
    for (survives, log) in [("true", None), ("false", Some("modify ended: its behavior ended"))] {
        let text = format!("{text}\n[interpretation]\nmodify_survives = {survives}");
        let mut payload = Payload::connected(&text, 1, &[]);
        payload.until(20.0);
        payload.say("$BPRMB,070000.000,90,,,,,");
        payload.say("$BPRCB,070000.000,0");
        let activity = payload.mvc.truth().activity;
        let ended = payload.log().iter().find(|line| line.contains("modify ended")).cloned();
        if survives == "true" {
            assert_eq!(
                activity,
                Activity::Modified {
                    number: Some(2),
                    id: None
                }
            );
        } else {
            assert_eq!(activity, Activity::Plan { number: 2 });
        }
        assert_eq!(
            ended
                .as_deref()
                .map(|line| line.split_once(": ").map_or("", |(_, text)| text)),
            log
        );
        // Either way the payload may modify the next behavior.
        payload.say("$BPRMB,070000.000,90,,,,,");
        assert_eq!(
            payload.mvc.truth().activity,
            Activity::Modified {
                number: Some(2),
                id: None
            }
        );
    }
}

/// SPI 7.12: "must be sent at least every 5 seconds", to the nanosecond, from the last one received.
#[test]
fn the_five_seconds_are_exact() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(10.0);
    payload.now = backseat_units::Timestamp::from_nanos(10_012_345_678);
    payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    payload
        .mvc
        .handle_timeout(backseat_units::Timestamp::from_nanos(15_012_345_677));
    assert!(modified(&payload), "just before");
    payload
        .mvc
        .handle_timeout(backseat_units::Timestamp::from_nanos(15_012_345_678));
    assert!(!modified(&payload), "just after");
}

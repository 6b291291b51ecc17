//! The empty fields of BPRMB (SPI 7.12), and what the vehicle says of a modify that it clips or refuses.

use crate::files::CALM;
use crate::payload::Payload;

const ALTITUDE: (&str, &str) = (
    "depth_m = 10\nspeed_mps = 2\ndynamic",
    "altitude_m = 40\nspeed_mps = 2\ndynamic",
);

/// The answer to a modify at 30 s, and the line of the vehicle's log about it.
fn answer(text: &str, fields: &str) -> (String, Option<String>) {
    let mut payload = Payload::connected(text, 1, &["ACK"]);
    payload.until(30.0);
    payload.log();
    payload.say(&format!("$BPRMB,070000.000,{fields}"));
    let heard = payload.heard();
    assert_eq!(heard.len(), 1, "{fields}: {heard:?}");
    let line = payload.log().into_iter().find(|line| line.contains("modif"));
    let (_, outcome) = heard[0].split_once(",RMB,070000.000,0,").unwrap_or(("", &heard[0]));
    (outcome.to_owned(), line)
}

/// Where a modify that is repeated from 10 s on has brought the vehicle after two minutes: depth and speed.
fn flown(text: &str, fields: &str) -> (f64, f64) {
    let mut payload = Payload::connected(text, 1, &[]);
    for second in 10..120 {
        payload.until(f64::from(second));
        payload.say(&format!("$BPRMB,070000.000,{fields}"));
    }
    let truth = payload.mvc.truth();
    (truth.depth_m, truth.speed_mps)
}

fn near(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 0.3
}

// SPI 7.12: "Not all of the fields are required; any empty fields do not modify that aspect of the current behavior."
// Depth mode: "May be empty." Speed mode: "May be empty."
#[test]
fn every_field_may_be_empty() {
    let fields = ["90", "15", "0", "1.5", "1", "0"];
    for kept in 0..64_u32 {
        let values: Vec<&str> = (0..6)
            .map(|index| if kept & (1 << index) == 0 { "" } else { fields[index] })
            .collect();
        let (outcome, _) = answer(CALM, &values.join(","));
        assert_eq!(outcome, "2,0,", "{values:?}");
    }
}

// "Any empty fields do not modify that aspect of the current behavior": with an empty mode a value is what it is in the
// current behavior.
#[test]
fn a_value_without_a_mode_is_what_it_is_in_the_current_behavior() {
    let (depth_m, speed_mps) = flown(CALM, ",15,,1.5,,");
    assert!(near(depth_m, 15.0) && near(speed_mps, 1.5), "{depth_m} {speed_mps}");
    // The seabed is 60 m deep, and the plan keeps an altitude of 40 m.
    let by_altitude = CALM.replacen(ALTITUDE.0, ALTITUDE.1, 1);
    let (depth_m, speed_mps) = flown(&by_altitude, ",35,,1.5,,");
    assert!(near(depth_m, 25.0) && near(speed_mps, 1.5), "{depth_m} {speed_mps}");
    // An inserted line whose speed is given in rpm: 450 rpm are 1.5 m/s.
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(10.0);
    payload.say("$BPRTK,070000.000,4,4218.00,N,07054.00,W,4218.40,N,07054.00,W,0,10,600,1,4");
    assert!(payload.heard()[0].contains(",RTK,070000.000,4,2,0,"));
    for second in 10..60 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,,,,450,,");
    }
    assert!(near(payload.mvc.truth().speed_mps, 1.5), "{:?}", payload.mvc.truth());
}

// The specification does not say what a value is whose mode is empty, so the two other readings are settings.
#[test]
fn the_meaning_of_an_empty_mode_is_a_setting() {
    let with = |reading| format!("{CALM}\n[interpretation]\nmodify_empty_mode = \"{reading}\"");
    // As mode 0: a depth, and turns of the thruster.
    let by_altitude = with("zero").replacen(ALTITUDE.0, ALTITUDE.1, 1);
    let (depth_m, speed_mps) = flown(&by_altitude, ",35,,450,,");
    assert!(near(depth_m, 35.0) && near(speed_mps, 1.5), "{depth_m} {speed_mps}");
    assert_eq!(
        answer(&with("refuse"), ",15,,,,").0,
        "0,0,vertical_mode: required with a depth or altitude"
    );
    assert_eq!(
        answer(&with("refuse"), ",,,1.5,,").0,
        "0,0,speed_mode: required with a speed"
    );
    // A mode without a value asks for nothing.
    assert_eq!(answer(&with("refuse"), "90,,,,,").0, "2,0,");
}

// SPI 7.12: "this message can not be used to command the vehicle beyond its safe operating parameters"; 6.21: the text
// describes the "acknowledgement of success ... in possibly more detail".
#[test]
fn the_acknowledgement_says_what_was_clipped() {
    for (fields, text) in [
        ("90,15,0,1.5,1,0", ""),
        (
            ",5000,0,20,1,",
            "depth 5000 m clipped to 58.0 m; speed 20 m/s clipped to 2.5 m/s",
        ),
        // The seabed is 60 m deep, and the vehicle stays 2 m above it.
        (",59,0,,,", "depth 59 m clipped to 58.0 m"),
        (",-1,0,,,", "depth -1 m clipped to 0.0 m"),
        (",1,1,,,", "altitude 1 m clipped to 2.0 m"),
        (",30,2,,,", "pitch 30 deg clipped to 25.0 deg"),
        (",-21,3,,,", "elevator -21 deg clipped to -20.0 deg"),
        ("25,,,,,1", "rudder 25 deg clipped to 20.0 deg"),
        (",,,900,0,", "speed 900 rpm clipped to 750.0 rpm"),
        (",,,0.1,1,", "speed 0.1 m/s clipped to 0.5 m/s"),
        (",,,0,1,", ""),
    ] {
        assert_eq!(answer(CALM, fields).0, format!("2,0,{text}"), "{fields}");
    }
}

// SPI 7.12: without "allowDynamicRequests" "the request will be ignored, or acknowledged with a failure response if
// acknowledgements are enabled". The vehicle's own log has the refusal either way, once for all repetitions.
#[test]
fn a_refused_modify_is_in_the_log_though_acknowledgements_are_off() {
    let text = CALM.replace(
        "dynamic = true",
        "dynamic = true\ndynamic_from_s = 20\ndynamic_for_s = 20",
    );
    let mut payload = Payload::connected(&text, 1, &[]);
    for second in 5..60 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,90,15,0,1.5,1,0");
    }
    assert_eq!(payload.heard(), Vec::<String>::new());
    let refused: Vec<String> = payload
        .log()
        .into_iter()
        .filter(|line| line.contains("refused"))
        .collect();
    let line = |at| format!("{at}: modify of client 1 refused: dynamic requests are not allowed now");
    assert_eq!(refused, [line("5.000 s"), line("41.000 s")]);
}

// SPI 7.7, surface mode 2: "manual (no automatic surfacing)". Nobody brings the vehicle up.
#[test]
fn a_manual_gps_hit_without_a_fix_says_so() {
    let text = CALM.replace("[mission]", "[mission]\ngps_within_s = 60");
    let mut payload = Payload::connected(&text, 1, &["MBE"]);
    payload.until(10.0);
    payload.say("$BPRGP,070000.000,7,4218.06,N,07053.95,W,120,5,2");
    payload.say("$BPRCB,070000.000,0");
    payload.until(400.0);
    assert!(payload.heard().iter().any(|line| line.ends_with(",,,7,gps")));
    let log = payload.log();
    let end = log
        .iter()
        .position(|line| line.contains("inserted gps 7 ended"))
        .expect("it ends");
    assert!(
        log[end - 1].ends_with(": no gps fix of insert 7: its time is over"),
        "{log:?}"
    );
    assert!(
        !log.iter()
            .any(|line| line.contains("gps fix of insert 7") && !line.contains("no gps fix"))
    );
}

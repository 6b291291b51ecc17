//! What external triggering does to the DVL itself: it measures when the payload's line pulses (SPI 5.6, 7.4).

use crate::fields::{number, of, seconds};
use crate::files::CALM;
use crate::payload::Payload;

fn with(dvl: &str) -> String {
    CALM.replace("[spi]", &format!("[dvl]\n{dvl}\n[spi]"))
}

/// A payload that asks at 29 s and may trigger from 30.0 s on.
fn permitted(dvl: &str, messages: &[&str]) -> Payload {
    let mut payload = Payload::connected(&with(dvl), 1, messages);
    payload.until(29.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(30.0);
    assert_eq!(of(&payload.heard(), "BFDVT"), ["$BFDVT,080030.000,1"]);
    payload
}

/// How many readings came between two times, and the greatest time between two of them.
fn readings(lines: &[String], from_s: f64, to_s: f64) -> usize {
    of(lines, "BFDVL")
        .iter()
        .filter(|line| seconds(line) > from_s + 1e-6 && seconds(line) < to_s - 1e-6)
        .count()
}

// "If the payload does not trigger the DVL for a set amount of time while in external trigger mode (5 seconds by
// default), the DVL will revert to internal trigger mode."
#[test]
fn without_a_pulse_the_dvl_is_silent_for_five_seconds_and_then_triggers_itself() {
    let mut payload = permitted("", &["DVL", "NVG", "NVR"]);
    // The payload was told to begin, and does nothing.
    payload.until(45.0);
    let lines = payload.heard();
    assert_eq!(readings(&lines, 30.0, 35.0), 0, "{:?}", of(&lines, "BFDVL"));
    assert!((49..=51).contains(&readings(&lines, 35.0, 45.0)));
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.starts_with("35.000 s") && line.ends_with("the payload did not trigger it"))
    );
    // Without pings there is no lock, and so no altitude. Navigation goes on.
    let altitudes = |from_s: f64, to_s: f64| -> Vec<f64> {
        of(&lines, "BFNVG")
            .iter()
            .filter(|line| seconds(line) > from_s && seconds(line) < to_s)
            .map(|line| number(line, 7))
            .collect()
    };
    assert!(altitudes(30.05, 34.95).iter().all(|metres| *metres == 0.0));
    assert_eq!(altitudes(30.05, 34.95).len(), 49);
    assert!(
        altitudes(35.15, 44.95)
            .iter()
            .all(|metres| (*metres - 50.0).abs() < 1.0)
    );
    assert!(of(&lines, "BFNVR").len() > 145);
}

// "When it is safe to begin external triggering, the Bluefin vehicle will send a BFDVT message to the payload telling
// it to commence triggering." BPDVR "must be sent any time either of its fields would change value".
#[test]
fn the_payloads_pulses_are_the_dvls_readings() {
    for (dvl, count) in [("", 50), ("pulse_period_s = 1", 10), ("pulse_period_s = 0.5", 20)] {
        let mut payload = permitted(dvl, &["DVL"]);
        payload.say("$BPDVR,070001.000,1,1");
        payload.until(50.0);
        let lines = payload.heard();
        let found = readings(&lines, 35.0, 45.0);
        assert!((count - 1..=count + 1).contains(&found), "{dvl}: {found}");
        assert!(of(&lines, "BFDVT").is_empty(), "{dvl}");
        // The payload ends it, and the DVL triggers itself again.
        payload.say("$BPDVR,070002.000,0,0");
        payload.until(60.0);
        assert!((48..=51).contains(&readings(&payload.heard(), 50.0, 60.0)), "{dvl}");
    }
}

// "The former will elicit a stop triggering command from the Bluefin vehicle after which the payload should respond
// with a request=0, triggering=0 message."
#[test]
fn a_payload_that_pauses_and_a_dead_line_stop_the_readings() {
    // It says that it has stopped, and begins again within the 5 s.
    let mut payload = permitted("", &["DVL"]);
    payload.say("$BPDVR,070001.000,1,1");
    payload.until(40.0);
    payload.say("$BPDVR,070002.000,1,0");
    payload.until(43.0);
    payload.say("$BPDVR,070003.000,1,1");
    payload.until(50.0);
    let lines = payload.heard();
    assert_eq!(readings(&lines, 40.0, 43.0), 0);
    assert!(readings(&lines, 43.0, 50.0) > 33 && readings(&lines, 30.0, 40.0) > 47);
    // The line is dead for 3 s, and later for longer.
    let faults = "line_faults = [{ at_s = 40, for_s = 3 }, { at_s = 60, for_s = 20 }]";
    let mut payload = permitted(faults, &["DVL"]);
    payload.say("$BPDVR,070001.000,1,1");
    payload.until(80.0);
    let lines = payload.heard();
    assert_eq!((readings(&lines, 40.0, 43.0), readings(&lines, 60.0, 64.8)), (0, 0));
    assert!(readings(&lines, 43.1, 60.0) > 80 && readings(&lines, 65.0, 80.0) > 70);
}

#[test]
fn pulses_slower_than_the_time_limit_are_refused() {
    let fault = |dvl| {
        backseat_mvc::WorldFile::from_toml(&with(dvl))
            .expect_err("it is refused")
            .to_string()
    };
    assert_eq!(
        fault("pulse_period_s = 5"),
        "dvl.pulse_period_s is 5, expected 0.01 s to less than dvl.timeout_s"
    );
}

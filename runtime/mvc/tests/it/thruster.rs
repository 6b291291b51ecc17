//! Thruster, rudder and elevator: what BFRVL and BFERC say, what silent mode checks, and what a payload commanded are
//! the same (SPI 6.7, 6.12, 7.12, 7.22).

use crate::fields::{number, of, seconds};
use crate::files::CALM;
use crate::payload::Payload;
use crate::sentences::with;

/// A vehicle that has flown at 2 m/s for a minute, and whose thruster is ordered to stop at 60 s.
fn stopping(text: &str, messages: &[&str]) -> Payload {
    let mut payload = Payload::connected(text, 1, messages);
    payload.until(60.0);
    payload.heard();
    payload.say("$BPRMB,070000.000,,,,0,0,");
    payload
}

/// Lets the time pass and keeps the thruster stopped.
fn stopped_until(payload: &mut Payload, seconds: u32) {
    for second in (payload.now.as_secs_f64() as u32 + 1)..=seconds {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,,,,0,0,");
    }
}

fn silence(text: &str, key: &str) -> String {
    with(text, "silence", key)
}

// SPI 6.7: "thruster rotation (RPM)", and the velocity "as estimated from thruster RPM".
#[test]
fn the_rotation_is_the_thrusters_and_not_the_waters() {
    let mut payload = stopping(&silence(CALM, "spin_down_s = 2"), &["RVL"]);
    stopped_until(&mut payload, 66);
    let lines = of(&payload.heard(), "BFRVL");
    let at = |since: f64| {
        lines
            .iter()
            .find(|line| seconds(line) >= 60.0 + since)
            .unwrap_or_else(|| panic!("{lines:?}"))
    };
    assert!((500.0..600.0).contains(&number(at(0.0), 2)), "{}", at(0.0));
    let (soon, later) = (number(at(0.6), 2), number(at(1.4), 2));
    assert!((200.0..500.0).contains(&soon) && later < soon - 100.0, "{soon} {later}");
    assert_eq!((number(at(2.2), 2), number(at(2.2), 3)), (0.0, 0.0), "{}", at(2.2));
    // The vehicle itself needs longer to stop.
    assert!(payload.mvc.truth().speed_mps > 0.3, "{:?}", payload.mvc.truth());
    // Before a mission it stands, and in one it holds what was commanded.
    let waiting = CALM.replace("starts_after_s = 1", "starts_after_s = 50");
    let mut payload = Payload::connected(&waiting, 1, &["RVL"]);
    payload.until(40.0);
    assert!(of(&payload.heard(), "BFRVL").iter().all(|line| number(line, 2) == 0.0));
}

// SPI 7.22: "Before the deferred acknowledgement is sent, the current state of the tailcone is checked to see if it has
// stopped." What BFRVL says when it is sent is that state.
#[test]
fn silence_begins_only_when_the_rotation_is_zero() {
    for (text, spins_s, outcome) in [
        (CALM.to_owned(), 1.0, ",2,0,"),
        (CALM.to_owned(), 3.5, ",2,0,"),
        (CALM.to_owned(), 30.0, ",1,0,the tailcone is still spinning"),
        (with(CALM, "vehicle", "model = \"6-dof\""), 1.0, ",2,0,"),
    ] {
        let text = silence(&silence(&text, &format!("spin_down_s = {spins_s}")), "settle_s = 1.9");
        let mut payload = stopping(&text, &["RVL", "ACK"]);
        // The first acknowledgement is in order: the thruster's target state is checked, and it is off.
        payload.until(61.0);
        payload.say("$BPRMB,070000.000,,,,0,0,");
        payload.until(61.1);
        payload.heard();
        payload.say("$BPSIL,070001.000,1");
        payload.until(63.0);
        payload.say("$BPRMB,070000.000,,,,0,0,");
        payload.until(65.2);
        let lines = payload.heard();
        let end = lines
            .iter()
            .rposition(|line| line.contains(",SIL,070001.000,0,"))
            .expect("an outcome");
        assert!(lines[end].contains(outcome), "{spins_s}: {}", lines[end]);
        let before = lines[..end]
            .iter()
            .rfind(|line| line.starts_with("$BFRVL"))
            .expect("a reading");
        let after = lines[end..].iter().find(|line| line.starts_with("$BFRVL"));
        let turns = number(before, 2).max(after.map_or(0.0, |line| number(line, 2)));
        if outcome == ",2,0," {
            assert!(
                number(before, 2) < 60.0 && after.is_none_or(|line| number(line, 2) == 0.0),
                "{before} {after:?}"
            );
        } else {
            assert!(turns > 100.0, "{spins_s}: {turns}");
        }
    }
}

// SPI 6.12: "the target angles to which the tailcone has been commanded"; 7.12: "1 signifies a rudder adjustment", "3
// signifies ... an elevator adjustment".
#[test]
fn the_targets_of_the_fins_are_what_was_commanded() {
    // Fields: elevator, rudder, target of the elevator, target of the rudder.
    for (fields, target) in [
        ("10,,,,,1", (5, 10.0)),
        ("-7.5,,,,,1", (5, -7.5)),
        (",-8,3,,,", (4, -8.0)),
        (",3,3,,,", (4, 3.0)),
        // The stop is at 20 degrees.
        ("25,,,,,1", (5, 20.0)),
    ] {
        let mut payload = Payload::connected(CALM, 1, &["ERC"]);
        for second in 30..36 {
            payload.until(f64::from(second));
            payload.say(&format!("$BPRMB,070000.000,{fields}"));
        }
        payload.until(36.0);
        let lines = of(&payload.heard(), "BFERC");
        let line = lines.last().expect("angles");
        let (field, expected) = target;
        assert!((number(line, field) - expected).abs() < 0.001, "{fields}: {line}");
        // After some seconds the fin is there.
        assert!((number(line, field - 2) - expected).abs() < 0.6, "{fields}: {line}");
    }
}

//! A vehicle that stops in its plan: a setpoint with `speed_mps = 0`. It is how a mission reaches trim, buoyancy and
//! silence, which are "only accepted if the vehicle is either not currently in a mission, or if a mission is executing
//! but the tailcone is not spinning" (SPI 7.22 to 7.24).

use backseat_mvc::WorldFile;

use crate::fields::{number, of};
use crate::files::CALM;
use crate::payload::{Payload, course, done};

/// A stop of two minutes at 20 m, after a way there and before a line.
fn stop() -> String {
    let (head, plan) = CALM.split_once("[[plan]]").expect("the file has a plan");
    let head = head.replace("[start]", "[start]\ndepth_m = 20");
    format!(
        "{head}[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = 0, north_m = 40 }}\ndepth_m = 20\nspeed_mps = 1\n\
         [[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 120\ndepth_m = 20\nspeed_mps = 0\n[[plan]]{}",
        plan.replace("north_m = 20 }", "north_m = 80 }")
    )
}

fn stopped(messages: &[&str]) -> Payload {
    let mut payload = Payload::connected(&stop(), 1, &[&["MBS", "MBE"], messages].concat());
    let stops = |payload: &mut Payload| payload.heard().iter().any(|line| line.ends_with(",2,,setpoint"));
    while !stops(&mut payload) {
        assert!(payload.now.as_secs_f64() < 200.0, "it stops");
        payload.until(payload.now.as_secs_f64() + 0.1);
    }
    payload
}

#[test]
fn a_stop_is_flown_for_its_time_and_the_mission_goes_on() {
    let mut payload = stopped(&["RVL"]);
    let from = payload.now.as_secs_f64();
    payload.until(from + 60.0);
    let truth = payload.mvc.truth();
    assert!(truth.speed_mps < 0.05, "{truth:?}");
    let turns = of(&payload.heard(), "BFRVL");
    assert_eq!(number(turns.last().expect("a reading"), 2), 0.0);
    // A torpedo without speed floats up.
    assert!((10.0..19.0).contains(&truth.depth_m), "{truth:?}");
    payload.until(from + 119.0);
    assert_eq!(course(&payload.heard()), Vec::<String>::new());
    payload.until(from + 150.0);
    assert_eq!(course(&payload.heard()), ["-2", "+3"]);
    assert!(payload.mvc.truth().speed_mps > 1.0);
    done(&mut payload);
}

// SPI 7.22.
#[test]
fn a_stopped_vehicle_becomes_silent_within_its_mission() {
    let mut payload = stopped(&["ACK"]);
    let from = payload.now.as_secs_f64();
    payload.until(from + 5.0);
    payload.say("$BPSIL,070000.000,1");
    payload.until(from + 8.0);
    let heard = payload.heard();
    assert!(
        heard[0].ends_with(",SIL,070000.000,0,3,0,") && heard[1].ends_with(",SIL,070000.000,0,2,0,"),
        "{heard:?}"
    );
}

// SPI 7.23, 7.24: "BFMBS and BFMBE messages will be transmitted at the beginning and end" of the adjustment.
#[test]
fn a_stopped_vehicle_trims_and_adjusts_its_buoyancy_within_its_mission() {
    for (command, status) in [("BPTRM", "TRM"), ("BPBOY", "BOY")] {
        let mut payload = stopped(&["ACK", status]);
        let from = payload.now.as_secs_f64();
        payload.until(from + 5.0);
        payload.heard();
        payload.say(&format!("${command},070000.000"));
        payload.until(from + 115.0);
        let heard = payload.heard();
        assert!(
            heard
                .iter()
                .any(|line| line.contains(&format!(",{status},070000.000,0,2,0,"))),
            "{command}: {heard:?}"
        );
        let said = of(&heard, &format!("BF{status}"));
        assert!(!said.is_empty(), "{command}");
    }
}

#[test]
fn only_a_setpoint_may_stop_the_vehicle() {
    let fault = |from: &str, to: &str| {
        let text = stop().replacen(from, to, 1);
        WorldFile::from_toml(&text).expect_err(to).to_string()
    };
    assert_eq!(
        fault("speed_mps = 1\n", "speed_mps = 0\n"),
        "plan element 1: speed_mps is 0, expected 0.5 to 2.5"
    );
    assert_eq!(
        fault("speed_mps = 0\n", "speed_mps = 0.2\n"),
        "plan element 2: speed_mps is 0.2, expected 0.5 to 2.5, or 0"
    );
    assert_eq!(
        fault("speed_mps = 0\n", "speed_mps = -1\n"),
        "plan element 2: speed_mps is -1, expected 0.5 to 2.5, or 0"
    );
}

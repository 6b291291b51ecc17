use backseat_mvc::Activity;
use backseat_spi::BehaviorId;

use crate::files::CALM;
use crate::payload::{Payload, course, done, line};

/// Three elements, all dynamic: a line in two behaviors, a line, a waypoint.
const ELEMENTS: &str = "
[[plan]]
kind = \"trackline\"
start = { east_m = 0, north_m = 60 }
end = { east_m = 0, north_m = 400 }
separate_transit = true
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"trackline\"
start = { east_m = 60, north_m = 400 }
end = { east_m = 60, north_m = 200 }
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"waypoint\"
at = { east_m = 100, north_m = 200 }
depth_m = 10
speed_mps = 2
dynamic = true
";

fn elements() -> String {
    let (head, _) = CALM.split_once("[[plan]]").expect("the file has a plan");
    format!("{head}{ELEMENTS}")
}

/// SPI 7.10: "premature termination of the currently-executing behavior. Control passes immediately to the next
/// behavior"; 7.11: the same for the "Planner-level mission element". A case has what the payload says at which second,
/// and the sequence of behaviors that must follow.
#[test]
fn a_behavior_and_an_element_are_cancelled_and_the_next_begins_at_once() {
    type Case = (&'static str, &'static [(u32, &'static str)], &'static [&'static str]);
    const RCB: &str = "$BPRCB,070000.000,0";
    const RCE: &str = "$BPRCE,070000.000,";
    let cases: &[Case] = &[
        ("nothing", &[], &["+1", "-1", "+2", "-2", "+3", "-3", "+4", "-4"]),
        (
            "7.10 the way to a line",
            &[(10, RCB)],
            &["+1", "-1", "+2", "-2", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.11 ends its line too",
            &[(10, RCE)],
            &["+1", "-1", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.11 twice",
            &[(10, RCE), (12, RCE)],
            &["+1", "-1", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.11 the last ends the mission",
            &[(10, RCE), (12, RCE), (14, RCE)],
            &["+1", "-1", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.10 passes on to a waiting insert",
            &[(60, "INSERT"), (70, RCB)],
            &["+1", "-1", "+2", "-2", "+i7", "-i7", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.10 ends an insert",
            &[(60, "INSERT"), (70, RCB), (75, RCB)],
            &["+1", "-1", "+2", "-2", "+i7", "-i7", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.11 takes the inserts of its element with it",
            &[(60, "INSERT"), (70, RCE)],
            &["+1", "-1", "+2", "-2", "+3", "-3", "+4", "-4"],
        ),
        (
            "7.11 ends a running insert and its element",
            &[(60, "INSERT"), (70, RCB), (75, RCE)],
            &["+1", "-1", "+2", "-2", "+i7", "-i7", "+3", "-3", "+4", "-4"],
        ),
    ];
    for (what, said, expected) in cases {
        let mut payload = Payload::connected(&elements(), 1, &["MBS", "MBE", "ACK"]);
        let mut heard = Vec::new();
        for (second, sentence) in *said {
            payload.until(f64::from(*second));
            heard.append(&mut payload.heard());
            let before = payload.mvc.truth().activity;
            if *sentence == "INSERT" {
                payload.say(&line(7, 20, 0));
            } else {
                payload.say(sentence);
                assert_ne!(payload.mvc.truth().activity, before, "{what}: at once");
            }
            let answered = payload.heard();
            let success = |line: &String| line.starts_with("$BFACK") && line.contains(",2,0,");
            assert!(answered.iter().any(success), "{what}: {answered:?}");
            heard.extend(answered);
        }
        done(&mut payload);
        heard.append(&mut payload.heard());
        assert_eq!(course(&heard), *expected, "{what}");
    }
}

/// SPI 7.10, 7.11: after a cancelled insert the vehicle goes on with the next element or resumes the interrupted one,
/// and skips none.
#[test]
fn a_cancelled_interruption_goes_on_or_resumes() {
    for (reading, expected) in [
        ("next", ["+1", "-1", "+i4", "-i4", "+2", "-2"].as_slice()),
        ("resume", ["+1", "-1", "+i4", "-i4", "+1", "-1", "+2", "-2"].as_slice()),
    ] {
        let text = format!("{CALM}\n[interpretation]\nafter_interrupt = \"{reading}\"");
        let mut payload = Payload::connected(&text, 1, &["MBS", "MBE"]);
        payload.until(30.0);
        payload.say(&line(4, 30, 4));
        payload.until(40.0);
        payload.say("$BPRCB,070000.000,0");
        done(&mut payload);
        assert_eq!(course(&payload.heard()), expected, "{reading}");
    }
}

/// SPI 7.10, 7.11: "Reserved for future specification. Must be empty or 0"; "dynamic requests are enabled by setting the
/// onboard allowDynamicRequests parameter to true".
#[test]
fn cancels_fail_without_control_and_with_a_reserved_field_that_is_set() {
    let text = CALM.replace("dynamic = true", "dynamic = true\ndynamic_from_s = 10");
    for name in ["RCB", "RCE"] {
        let mut payload = Payload::connected(&text, 1, &["ACK"]);
        let mut answer = |second: f64, said: &str| {
            payload.until(second);
            payload.heard();
            payload.say(said);
            payload.heard().swap_remove(0)
        };
        assert_eq!(
            answer(0.5, &format!("$BP{name},070000.123,0")),
            format!("$BFACK,080000.500,{name},070000.123,0,1,0,no mission is running")
        );
        assert_eq!(
            answer(10.9, &format!("$BP{name},070000.123,0")),
            format!("$BFACK,080010.900,{name},070000.123,0,1,0,dynamic requests are not allowed now"),
            "just before the window"
        );
        let reserved = answer(10.9, &format!("$BP{name},070000.123,5"));
        assert!(
            reserved.starts_with(&format!("$BFACK,080010.900,{name},070000.123,0,0,0,")),
            "{reserved}"
        );
        assert_eq!(
            answer(11.0, &format!("$BP{name},070000.123,0")),
            format!("$BFACK,080011.000,{name},070000.123,0,2,0,"),
            "just after it opened"
        );
    }
}

/// SPI 6.24: BFCTL becomes 0 when allowDynamicRequests becomes false, also because of a cancel.
#[test]
fn control_follows_a_cancel_at_once() {
    let mut payload = Payload::connected(CALM, 1, &["CTL"]);
    payload.until(20.04);
    payload.say("$BPRCE,070000.000,0");
    assert_eq!(payload.heard(), ["$BFCTL,080001.000,1", "$BFCTL,080020.040,0"]);
}

/// SPI 6.24: "Alternatively, the vehicle can be configured to hand control to the backseat when the mission starts and
/// returned to the frontseat at mission stop."
#[test]
fn control_may_last_as_long_as_the_mission() {
    let text = CALM.replace("[mission]", "[mission]\ncontrol = \"mission\"");
    let mut payload = Payload::connected(&text, 1, &["CTL", "MIS"]);
    done(&mut payload);
    let heard: Vec<String> = payload
        .heard()
        .iter()
        .map(|line| line.replacen(&line[7..17], "T", 1))
        .collect();
    assert_eq!(
        heard,
        [
            "$BFMIS,T,survey.dive,Running /logs/survey,",
            "$BFCTL,T,1",
            "$BFCTL,T,0",
            "$BFMIS,T,survey.dive,Completed,",
        ]
    );
}

/// SPI 7.16: "causes the current mission to end, and its wrapup behavior executed (such as a powered ascent to the
/// surface)"; "Abort with errors (1) is the default". 6.11: the statuses and their details.
#[test]
fn an_abort_wraps_up_with_control_or_without() {
    for (second, wrap_up, said, statuses) in [
        (
            30.0,
            "surface",
            "$BPABT,070000.000,leak in bay 2,1",
            ["Aborting,leak in bay 2", "Aborted,leak in bay 2"].as_slice(),
        ),
        (
            30.0,
            "surface",
            "$BPABT,070000.000,leak",
            ["Aborting,leak", "Aborted,leak"].as_slice(),
        ),
        (
            30.0,
            "surface",
            "$BPABT,070000.000,all done,0",
            ["WrappingUp,all done", "Completed,all done"].as_slice(),
        ),
        (30.0, "none", "$BPABT,070000.000,leak,1", ["Aborted,leak"].as_slice()),
        (30.0, "none", "$BPABT,070000.000,,0", ["Completed,"].as_slice()),
        // The second element gives no control.
        (
            220.0,
            "surface",
            "$BPABT,070000.000,leak,1",
            ["Aborting,leak", "Aborted,leak"].as_slice(),
        ),
    ] {
        let text = CALM.replace("[mission]", &format!("[mission]\nwrap_up = \"{wrap_up}\""));
        let mut payload = Payload::connected(&text, 1, &["ACK", "MIS", "MBE", "CTL"]);
        payload.until(second);
        assert_eq!(payload.mvc.truth().control, second < 100.0);
        payload.heard();
        payload.say(said);
        let at_once = payload.heard();
        assert!(at_once[0].ends_with(",ABT,070000.000,0,2,0,"), "{at_once:?}");
        assert!(at_once.iter().any(|line| line.starts_with("$BFMBE")), "{at_once:?}");
        assert!(!payload.mvc.truth().control);
        assert_eq!(
            payload.mvc.truth().activity == Activity::WrappingUp,
            wrap_up == "surface"
        );
        payload.say("$BPABT,070000.000,again,1");
        let again = payload.heard();
        let why = if wrap_up == "surface" {
            "the mission is already ending"
        } else {
            "no mission is running"
        };
        assert!(again[0].ends_with(&format!(",1,0,{why}")), "{again:?}");
        done(&mut payload);
        let mut told: Vec<String> = at_once;
        told.append(&mut payload.heard());
        let mission: Vec<&str> = told
            .iter()
            .filter_map(|line| line.strip_prefix("$BFMIS,"))
            .filter_map(|rest| rest.split_once("survey.dive,").map(|(_, status)| status))
            .collect();
        assert_eq!(mission, statuses, "{said}");
        if wrap_up == "surface" {
            assert!(payload.mvc.truth().depth_m < 0.5);
        }
    }
}

/// SPI 7.17: "causes the current mission to end, and all vehicle movement to stop. The vehicle will drift."
#[test]
fn a_kill_stops_the_thruster_and_the_vehicle_drifts_up() {
    let text = CALM.replace("[seabed]", "[current]\nspeed_mps = 0.3\ntowards_deg = 90\n[seabed]");
    let text = text.replace("[mission]", "[mission]\nwrap_up = \"surface\"");
    let mut payload = Payload::connected(&text, 1, &["ACK", "MIS", "CTL"]);
    payload.until(60.0);
    payload.heard();
    payload.say("$BPKIL,070000.000,leak in bay 2");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080100.000,KIL,070000.000,0,2,0,",
            "$BFCTL,080100.000,0",
            "$BFMIS,080100.000,survey.dive,Stopped,leak in bay 2",
        ]
    );
    assert!(payload.mvc.mission_over());
    let before = payload.mvc.truth();
    payload.until(200.0);
    let truth = payload.mvc.truth();
    assert_eq!(truth.activity, Activity::Stopped);
    assert!(
        truth.speed_mps < 0.01 && truth.depth_m < before.depth_m - 5.0,
        "{truth:?}"
    );
    assert!(truth.local.east_m > before.local.east_m + 30.0, "{truth:?}");
    payload.say("$BPKIL,070000.000,again");
    payload.say("$BPRMP,070000.000");
    payload.say(&line(4, 30, 0));
    payload.say("$BPRMB,070000.000,90,3,0,1.5,1,0");
    payload.until(203.0);
    let heard = payload.heard();
    for (name, why) in [
        ("KIL", "no mission is running"),
        ("RMP", "no mission is running"),
        ("RTK", "dynamic requests are not allowed now"),
        ("RMB", "dynamic requests are not allowed now"),
    ] {
        let failed = heard
            .iter()
            .any(|line| line.contains(&format!(",{name},")) && line.ends_with(&format!(",1,0,{why}")));
        assert!(failed, "{name}: {heard:?}");
    }
}

/// SPI 7.17 "all vehicle movement": the wrap-up's too.
#[test]
fn a_kill_ends_a_wrap_up() {
    let text = CALM.replace("[mission]", "[mission]\nwrap_up = \"surface\"");
    let mut payload = Payload::connected(&text, 1, &["MIS"]);
    payload.until(60.0);
    payload.say("$BPABT,070000.000,a,1");
    payload.until(62.0);
    payload.heard();
    payload.say("$BPKIL,070000.000,b");
    assert_eq!(payload.heard(), ["$BFMIS,080102.000,survey.dive,Stopped,b"]);
}

/// SPI 7.20: "The vehicle must be specially configured to allow empty missions"; "After a mission is started, the payload
/// can use the modify current behavior command"; "Must be finalized with end, abort, or kill mission".
#[test]
fn an_empty_mission_does_what_the_payload_asks_and_nothing_else() {
    let text = CALM.replace("starts_after_s = 1", "starts_after_s = 50\nempty_allowed = true");
    let mut payload = Payload::connected(&text, 1, &["ACK", "MIS", "CTL", "MBS"]);
    payload.until(2.0);
    payload.say("$BPSEM,070000.000,10,1");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080002.000,SEM,070000.000,0,2,0,",
            "$BFMIS,080002.000,,Running /logs/survey,",
            "$BFMBS,080002.000,,,,setpoint",
            "$BFCTL,080002.000,1",
        ]
    );
    payload.say("$BPRMP,070000.000");
    payload.until(5.0);
    assert!(
        payload.heard()[1].ends_with(",RMP,070000.000,0,2,0,0 elements"),
        "6.20: an empty plan"
    );
    for second in 5..60 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,90,10,0,1.5,1,0");
    }
    let truth = payload.mvc.truth();
    assert!(
        (truth.depth_m - 10.0).abs() < 0.3 && (truth.speed_mps - 1.5).abs() < 0.05,
        "{truth:?}"
    );
    assert!(truth.local.east_m > 50.0);
    assert_eq!(truth.activity, Activity::Modified { number: None, id: None });
    // When the payload is silent, the vehicle drifts to the surface. The mission that was loaded has not started.
    payload.until(250.0);
    let truth = payload.mvc.truth();
    assert!(truth.speed_mps < 0.01 && truth.depth_m < 0.1, "{truth:?}");
    assert_eq!(truth.activity, Activity::Plan { number: 0 });
    // Inserts are flown as they come.
    payload.heard();
    payload.say(&line(4, 10, 0));
    assert_eq!(
        payload.mvc.truth().activity,
        Activity::Insert { id: BehaviorId::new(4) }
    );
    for sentence in ["$BPRCE,070000.000,0", "$BPSEM,070000.000,10,1"] {
        payload.heard();
        payload.say(sentence);
        assert!(payload.heard()[0].contains(",1,0,"), "{sentence}");
    }
    payload.say("$BPRCB,070000.000,0");
    assert_eq!(payload.mvc.truth().activity, Activity::Plan { number: 0 });
    payload.heard();
    payload.say("$BPRCB,070000.000,0");
    assert!(payload.heard()[0].ends_with(",1,0,no behavior is running"));
    payload.say("$BPABT,070000.000,done,0");
    assert_eq!(payload.heard()[2], "$BFMIS,080410.000,,Completed,done");
}

/// SPI 7.20: "Maximum mission duration (hours, minutes or seconds)".
#[test]
fn an_empty_mission_has_a_maximum_duration_and_is_refused_with_a_reason() {
    let allowed = CALM.replace("[mission]", "[mission]\nempty_allowed = true");
    let cases = [
        (
            CALM,
            0.5,
            "$BPSEM,070000.000,1,0",
            "1,0,empty missions are not allowed on this vehicle",
        ),
        (&allowed, 5.0, "$BPSEM,070000.000,1,0", "1,0,a mission is running"),
        (
            &allowed,
            0.5,
            "$BPSEM,070000.000,0,0",
            "0,0,duration 0: expected above 0 and at most a year",
        ),
        (
            &allowed,
            0.5,
            "$BPSEM,070000.000,-3,0",
            "0,0,duration -3: expected above 0 and at most a year",
        ),
        (&allowed, 0.5, "$BPSEM,070000.000,1e9,2", "0,0,"),
        (&allowed, 0.5, "$BPSEM,070000.000,1,3", "0,0,unit 3: expected 0 to 2"),
    ];
    for (text, second, said, answer) in cases {
        let mut payload = Payload::connected(text, 1, &["ACK"]);
        payload.until(second);
        payload.say(said);
        let heard = payload.heard();
        assert!(
            heard[0].contains(",SEM,") && heard[0].contains(&format!(",{answer}")),
            "{said}: {heard:?}"
        );
    }
    for (said, seconds) in [("30,2", 30.0), ("0.5,1", 30.0), ("0.01,0", 36.0)] {
        let mut payload = Payload::connected(&allowed, 1, &["MIS"]);
        payload.say(&format!("$BPSEM,070000.000,{said}"));
        payload.until(seconds - 0.1);
        assert!(!payload.mvc.mission_over(), "{said}: just before");
        payload.until(seconds);
        assert!(payload.mvc.mission_over(), "{said}: just after");
        assert!(
            payload
                .heard()
                .last()
                .is_some_and(|line| line.ends_with(",,Aborted,time limit"))
        );
    }
}

/// SPI 7.20 "Must be finalized with end, abort, or kill": a second mission may follow, and may use the identifiers
/// again.
#[test]
fn an_empty_mission_may_follow_another_mission() {
    let text = CALM.replace("[mission]", "[mission]\nempty_allowed = true");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(4, 20, 4));
    payload.say("$BPKIL,070000.000,x");
    payload.say("$BPSEM,070000.000,1,0");
    payload.heard();
    payload.say(&line(4, 20, 0));
    assert!(payload.heard()[0].ends_with(",4,2,0,"));
    assert!(!payload.mvc.mission_over());
}

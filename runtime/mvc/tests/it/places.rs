use crate::files::CALM;
use crate::payload::{Payload, course, done, line};

/// A waypoint, a waypoint, a line, a setpoint, a waypoint; control throughout.
const PLAN: &str = "
[[plan]]
kind = \"waypoint\"
at = { east_m = 0, north_m = 100 }
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"waypoint\"
at = { east_m = 0, north_m = 150 }
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"trackline\"
start = { east_m = 0, north_m = 160 }
end = { east_m = 0, north_m = 300 }
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"setpoint\"
heading_deg = 90
duration_s = 30
depth_m = 10
speed_mps = 2
dynamic = true
[[plan]]
kind = \"waypoint\"
at = { east_m = 100, north_m = 300 }
depth_m = 10
speed_mps = 2
dynamic = true
";

fn plan(interpretation: &str) -> String {
    let (head, _) = CALM.split_once("[[plan]]").expect("the file has a plan");
    format!("{head}{PLAN}\n[interpretation]\n{interpretation}")
}

fn flown(interpretation: &str, said: &[(f64, String)]) -> String {
    let mut payload = Payload::connected(&plan(interpretation), 1, &["MBS", "MBE"]);
    for (second, sentence) in said {
        payload.until(*second);
        payload.say(sentence);
    }
    done(&mut payload);
    course(&payload.heard()).join(" ")
}

/// SPI 7.5, sentence by sentence: when each insert is asked for, whether it interrupts, and what is flown.
#[test]
fn inserts_have_the_place_that_the_section_says() {
    // What the section says, the settings, each insert's second, identifier and interrupt code, and what is flown.
    type Case = (&'static str, &'static str, &'static [(f64, u32, u32)], &'static str);
    let cases: &[Case] = &[
        (
            "\"at the end of the current planned (not dynamic) survey leg or trackcircle\"",
            "",
            &[(120.0, 5, 0)],
            "+1 -1 +2 -2 +3 -3 +i5 -i5 +4 -4 +5 -5",
        ),
        (
            "\"or before the beginning of the next one\"",
            "",
            &[(10.0, 5, 0)],
            "+1 -1 +2 -2 +i5 -i5 +3 -3 +4 -4 +5 -5",
        ),
        (
            "the other reading of the same",
            "insert_place = \"current\"",
            &[(10.0, 5, 0)],
            "+1 -1 +i5 -i5 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "no leg comes any more: after the current behavior",
            "",
            &[(165.0, 5, 0)],
            "+1 -1 +2 -2 +3 -3 +4 -4 +i5 -i5 +5 -5",
        ),
        (
            "\"subsequent dynamically-inserted behaviors will be appended at the end of the set\"",
            "",
            &[(10.0, 9, 0), (20.0, 5, 0), (60.0, 7, 0), (85.0, 6, 0)],
            "+1 -1 +2 -2 +i9 -i9 +i5 -i5 +i7 -i7 +i6 -i6 +3 -3 +4 -4 +5 -5",
        ),
        (
            "\"proceed to the next behavior following to the interrupted behavior\"",
            "",
            &[(10.0, 5, 4)],
            "+1 -1 +i5 -i5 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "\"if the first was specified as interrupting, the remaining ones will be completed as well\"",
            "",
            &[(10.0, 5, 4), (11.0, 6, 0), (12.0, 7, 0)],
            "+1 -1 +i5 -i5 +i6 -i6 +i7 -i7 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "\"it is an error to attempt to insert another dynamic behavior that interrupts\"",
            "",
            &[(10.0, 5, 4), (11.0, 6, 4)],
            "+1 -1 +i5 -i5 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "the whole set is the interruption",
            "",
            &[(10.0, 5, 4), (11.0, 6, 0), (215.0, 7, 4)],
            "+1 -1 +i5 -i5 +i6 -i6 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "the interrupting insert alone is the interruption",
            "interruption = \"behavior\"",
            &[(10.0, 5, 4), (11.0, 6, 0), (215.0, 7, 4), (216.0, 8, 4)],
            "+1 -1 +i5 -i5 +i6 -i6 +i7 -i7 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "and all that was interrupted is resumed, the last first",
            "interruption = \"behavior\"\nafter_interrupt = \"resume\"",
            &[(10.0, 5, 4), (11.0, 6, 0), (215.0, 7, 4)],
            "+1 -1 +i5 -i5 +i6 -i6 +i7 -i7 +i6 -i6 +1 -1 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "\"before finally returning to the interrupted behavior\"",
            "after_interrupt = \"resume\"",
            &[(10.0, 5, 4), (11.0, 6, 0)],
            "+1 -1 +i5 -i5 +i6 -i6 +1 -1 +2 -2 +3 -3 +4 -4 +5 -5",
        ),
        (
            "an insert that has not interrupted may be interrupted",
            "",
            &[(10.0, 5, 0), (85.0, 6, 4)],
            "+1 -1 +2 -2 +i5 -i5 +i6 -i6 +3 -3 +4 -4 +5 -5",
        ),
        (
            "and be resumed, after the set",
            "after_interrupt = \"resume\"",
            &[(10.0, 5, 0), (11.0, 8, 0), (85.0, 6, 4), (86.0, 7, 0)],
            "+1 -1 +2 -2 +i5 -i5 +i6 -i6 +i8 -i8 +i7 -i7 +i5 -i5 +3 -3 +4 -4 +5 -5",
        ),
    ];
    for (what, interpretation, asked, expected) in cases {
        let said: Vec<(f64, String)> = asked
            .iter()
            .map(|(second, id, interrupt)| (*second, line(*id, 10 + id, *interrupt)))
            .collect();
        assert_eq!(flown(interpretation, &said), *expected, "{what}");
    }
}

/// SPI 6.20: "the sequence of waypoints contained in a series of BFPLN messages will accurately describe a mission's
/// planned course": the plan has an insert where the vehicle will fly it.
#[test]
fn the_plan_has_an_insert_at_its_place() {
    for (second, interpretation, expected) in [
        (10.0, "", "1 2 i5 i5 3 3 4 5"),
        (10.0, "insert_place = \"current\"", "1 i5 i5 2 3 3 4 5"),
        (120.0, "", "1 2 3 3 i5 i5 4 5"),
    ] {
        let mut payload = Payload::connected(&plan(interpretation), 1, &[]);
        payload.until(second);
        payload.say(&line(5, 15, 0));
        payload.say("$BPRMP,070000.000");
        payload.until(second + 2.0);
        let told: Vec<String> = payload
            .heard()
            .iter()
            .map(|line| {
                let fields: Vec<&str> = line.split(',').collect();
                if fields[3].is_empty() {
                    fields[2].to_owned()
                } else {
                    format!("i{}", fields[3])
                }
            })
            .collect();
        assert_eq!(told.join(" "), expected, "{second} {interpretation}");
    }
}

/// SPI 7.8: "If the behavior has already begun executing, it is not possible to cancel it": also one that waits to be
/// resumed.
#[test]
fn an_interrupted_insert_cannot_be_cancelled_either() {
    let mut payload = Payload::connected(&plan("after_interrupt = \"resume\""), 1, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(5, 15, 0));
    payload.until(85.0);
    payload.say(&line(6, 16, 4));
    payload.heard();
    payload.say("$BPRCN,070000.000,5");
    assert!(payload.heard()[0].ends_with(",RCN,070000.000,5,1,0,the behavior has begun"));
}

/// SPI 7.8 does not say whose behaviors BPRCN cancels.
#[test]
fn cancel_accepts_the_insert_of_any_client_or_only_its_own() {
    for (scope, answer) in [("all", "2,0,"), ("own", "1,0,the behavior is another client's")] {
        let mut payload = Payload::connected(&plan(&format!("cancel_scope = \"{scope}\"")), 1, &["ACK"]);
        let other = backseat_mvc::ClientId(2);
        payload.connect(other);
        payload.until(10.0);
        payload.say_as(other, &line(5, 15, 0));
        payload.say("$BPRCN,070000.000,5");
        assert!(
            payload.heard()[0].ends_with(&format!(",RCN,070000.000,5,{answer}")),
            "{scope}"
        );
        payload.say("$BPRCN,070000.000,6");
        assert!(payload.heard()[0].ends_with(",6,1,0,no such behavior is waiting"));
    }
}

/// SPI 7.8: the request to cancel may come while the insert is still pending: both are decided in their order.
#[test]
fn a_pending_insert_is_cancelled_after_it_was_accepted() {
    let text = plan("").replace("acknowledge = \"immediate\"", "pending_s = [0.1, 1.9]");
    let mut payload = Payload::connected(&text, 3, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(5, 15, 0));
    payload.say("$BPRCN,070000.000,5");
    payload.until(12.0);
    let ends: Vec<String> = payload.heard().iter().map(|line| line[18..].to_owned()).collect();
    assert_eq!(
        ends,
        [
            "RTK,070005.000,5,3,0,",
            "RCN,070000.000,5,3,0,",
            "RTK,070005.000,5,2,0,",
            "RCN,070000.000,5,2,0,",
        ]
    );
    done(&mut payload);
    let log = payload.log();
    assert_eq!(
        log.iter().filter(|line| line.contains("insert 5 cancelled")).count(),
        1,
        "{log:?}"
    );
}

/// SPI 7.19: "this command will always return an immediate, initial pending acknowledgement, followed by the BFPLN
/// messages, followed by the final success/failure": each request gets its own, in order.
#[test]
fn two_requests_for_the_plan_are_both_answered() {
    let mut payload = Payload::connected(&plan(""), 1, &["ACK"]);
    payload.until(10.0);
    payload.say("$BPRMP,070000.001");
    payload.say("$BPRMP,070000.002");
    payload.until(12.0);
    let heard: Vec<String> = payload
        .heard()
        .iter()
        .map(|line| {
            if line.starts_with("$BFPLN") {
                "PLN".to_owned()
            } else {
                line[22..].to_owned()
            }
        })
        .collect();
    let mut expected = vec!["070000.001,0,3,0,".to_owned(), "070000.002,0,3,0,".to_owned()];
    for request in ["070000.001", "070000.002"] {
        expected.extend(std::iter::repeat_n("PLN".to_owned(), 6));
        expected.push(format!("{request},0,2,0,6 elements"));
    }
    assert_eq!(heard, expected);
}

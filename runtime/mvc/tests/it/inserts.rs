use backseat_mvc::Activity;
use backseat_spi::BehaviorId;

use crate::files::CALM;
use crate::payload::{ME, Payload, course, done, line};

#[test]
fn inserts_are_flown_in_order_after_the_current_leg_and_then_the_plan_goes_on() {
    let mut payload = Payload::connected(CALM, 1, &["MBS", "MBE"]);
    payload.until(10.0);
    for id in [7, 5, 6] {
        payload.say(&line(id, 20 + id, 0));
    }
    done(&mut payload);
    assert_eq!(
        course(&payload.heard()),
        ["+1", "-1", "+i7", "-i7", "+i5", "-i5", "+i6", "-i6", "+2", "-2"]
    );
}

#[test]
fn an_interrupt_starts_at_once_and_the_next_element_follows() {
    let mut payload = Payload::connected(CALM, 1, &["MBS", "MBE", "ACK"]);
    payload.until(10.0);
    payload.say(&line(3, 20, 0));
    payload.say(&line(4, 21, 4));
    assert_eq!(
        payload.mvc.truth().activity,
        Activity::Insert { id: BehaviorId::new(4) }
    );
    payload.say(&line(5, 22, 4));
    assert!(
        payload
            .heard()
            .last()
            .is_some_and(|line| line.ends_with(",5,1,0,an interrupting insert is running"))
    );
    payload.say(&line(6, 22, 0));
    done(&mut payload);
    assert_eq!(
        course(&payload.heard()),
        ["-i4", "+i3", "-i3", "+i6", "-i6", "+2", "-2"]
    );
}

#[test]
fn an_interrupted_element_may_be_resumed_where_it_was_left() {
    let text = format!("{CALM}\n[interpretation]\nafter_interrupt = \"resume\"");
    let mut payload = Payload::connected(&text, 1, &["MBS", "MBE"]);
    payload.until(60.0);
    payload.say(&line(4, 8, 4));
    done(&mut payload);
    assert_eq!(
        course(&payload.heard()),
        ["+1", "-1", "+i4", "-i4", "+1", "-1", "+2", "-2"]
    );
}

#[test]
fn an_inserted_line_has_its_lead_in_and_lead_out() {
    // The line runs from 0 to 96 m east; with 40 m before and after it, from -40 to 136.
    let text = format!("{CALM}\n[interpretation]\nlead_in_m = 40");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(10.0);
    payload.say(&line(4, 30, 0));
    let id = BehaviorId::new(4);
    assert!(payload.until_that(500.0, |truth| truth.activity == Activity::Insert { id }));
    let (mut west, mut east) = (0.0_f64, 0.0_f64);
    while payload.mvc.truth().activity == (Activity::Insert { id }) {
        payload.until(payload.now.as_secs_f64() + 0.1);
        let truth = payload.mvc.truth();
        west = west.min(truth.local.east_m);
        east = east.max(truth.local.east_m);
    }
    assert!((-60.0..=-35.0).contains(&west), "{west}");
    assert!((135.0..=138.0).contains(&east), "{east}");
}

#[test]
fn cancel_works_before_the_begin_and_fails_after_it() {
    let mut payload = Payload::connected(CALM, 1, &["ACK", "MBS"]);
    payload.until(10.0);
    payload.say(&line(4, 30, 0));
    payload.say(&line(5, 31, 0));
    payload.say("$BPRCN,070000.000,5");
    assert!(
        payload
            .heard()
            .last()
            .is_some_and(|line| line.ends_with(",RCN,070000.000,5,2,0,"))
    );
    assert!(payload.until_that(500.0, |truth| truth.activity
        == Activity::Insert { id: BehaviorId::new(4) }));
    payload.heard();
    payload.say("$BPRCN,070000.000,4");
    assert!(payload.heard()[0].ends_with(",RCN,070000.000,4,1,0,the behavior has begun"));
    done(&mut payload);
    assert_eq!(course(&payload.heard()), ["+2"]);
}

#[test]
fn cancel_all_cancels_the_inserts_of_every_client_or_only_its_own() {
    for (scope, left) in [("all", 0), ("own", 1)] {
        let text = format!("{CALM}\n[interpretation]\ncancel_all_scope = \"{scope}\"");
        let mut payload = Payload::connected(&text, 1, &["ACK"]);
        let other = backseat_mvc::ClientId(2);
        payload.connect(other);
        payload.until(10.0);
        payload.say(&line(4, 30, 0));
        payload.say_as(other, &line(5, 31, 0));
        payload.heard();
        payload.say("$BPRCA,070000.000");
        assert!(
            payload.heard()[0].ends_with(&format!("{} cancelled", 2 - left)),
            "{scope}"
        );
    }
}

#[test]
fn a_pending_request_is_decided_within_two_seconds_in_order() {
    let text = CALM.replace("acknowledge = \"immediate\"", "pending_s = [0.0, 1.9]");
    for seed in 0..20 {
        let mut payload = Payload::connected(&text, seed, &["ACK"]);
        payload.until(10.05);
        for id in 1..=5 {
            payload.say(&line(id, 20 + id, 0));
        }
        payload.say("$BPRCN,070000.000,5");
        let pending = payload.heard();
        assert_eq!(pending.len(), 6);
        assert!(pending.iter().all(|line| line.ends_with(",3,0,")), "{pending:?}");
        payload.until(12.05);
        let outcomes = payload.heard();
        let got: Vec<&str> = outcomes
            .iter()
            .map(|line| line.split(',').nth(4).unwrap_or(""))
            .collect();
        assert_eq!(got, ["1", "2", "3", "4", "5", "5"]);
        assert!(outcomes.iter().all(|line| line.ends_with(",2,0,")), "{outcomes:?}");
    }
}

#[test]
fn a_request_outlives_its_connection_and_its_answer_does_not() {
    let text = CALM.replace("acknowledge = \"immediate\"", "pending_s = 1");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(1, 20, 0));
    payload.mvc.disconnect(payload.now, ME);
    payload.connect(ME);
    payload.say("$BPLOG,ACK,ON");
    payload.heard();
    payload.until(13.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.say("$BPRMP,070000.000");
    payload.until(15.0);
    assert!(
        payload
            .heard()
            .iter()
            .any(|line| line.starts_with("$BFPLN") && line.contains(",,1,0,1,"))
    );
}

#[test]
fn cancel_all_also_cancels_what_is_still_pending() {
    let text = CALM.replace("acknowledge = \"immediate\"", "pending_s = 1");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(1, 20, 0));
    payload.say("$BPRCA,070000.000");
    payload.until(12.0);
    let heard = payload.heard();
    assert!(heard[1].ends_with(",RCA,070000.000,0,2,0,1 cancelled"), "{heard:?}");
    assert!(
        heard[2].ends_with(",1,1,0,cancelled before it was decided"),
        "{heard:?}"
    );
}

#[test]
fn inserts_outlive_control_or_are_dropped() {
    // Control ends 60 s into the first line.
    let text = CALM.replace("dynamic = true", "dynamic = true\ndynamic_for_s = 60");
    for (reading, flown) in [
        ("fly", ["+1", "-1", "+i4", "-i4", "+2", "-2"].as_slice()),
        ("drop", ["+1", "-1", "+2", "-2"].as_slice()),
    ] {
        let text = format!("{text}\n[interpretation]\ninserts_after_control = \"{reading}\"");
        let mut payload = Payload::connected(&text, 1, &["MBS", "MBE", "CTL"]);
        payload.until(10.0);
        payload.say(&line(4, 30, 0));
        payload.until(61.0);
        assert!(!payload.mvc.truth().control);
        done(&mut payload);
        assert_eq!(course(&payload.heard()), flown, "{reading}");
    }
}

#[test]
fn an_insert_without_control_is_refused() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.say(&line(4, 30, 0));
    assert!(payload.heard()[0].ends_with(",4,1,0,dynamic requests are not allowed now"));
    // A refused identifier is not used up: it may come again.
    payload.until(10.0);
    payload.say(&line(4, 30, 0));
    assert!(payload.heard()[0].ends_with(",4,2,0,"));
}

#[test]
fn a_circle_is_flown_round_its_rim() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(10.0);
    payload.say("$BPRTC,070000.000,9,4218.3,N,07054.0,W,50,-2,0,10,2,0,90,0");
    let id = BehaviorId::new(9);
    assert!(payload.until_that(500.0, |truth| truth.activity == Activity::Insert { id }));
    let centre = backseat_units::EastNorth::new(0.0, 555.4);
    // By then the vehicle has left the way to the entry point behind it.
    payload.until(payload.now.as_secs_f64() + 130.0);
    let mut seconds = 0.0;
    while payload.mvc.truth().activity == (Activity::Insert { id }) {
        payload.until(payload.now.as_secs_f64() + 0.1);
        seconds += 0.1;
        let off_m = payload.mvc.truth().local.distance_m(centre) - 50.0;
        assert!(off_m.abs() < 2.5, "{off_m}");
    }
    // Two turns of 314 m at 2 m/s.
    assert!((200.0..=320.0).contains(&seconds), "{seconds}");
}

#[test]
fn the_plan_is_sent_with_its_inserts_at_their_place() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(10.0);
    payload.say(&line(4, 30, 0));
    payload.say("$BPRTC,070000.000,9,4218.3,N,07054.0,W,50,1,0,10,2,0,90,0");
    payload.heard();
    payload.say("$BPRMP,070000.500");
    payload.until(12.0);
    let heard = payload.heard();
    assert_eq!(heard[0], "$BFACK,080010.000,RMP,070000.500,0,3,0,");
    let last = heard.last().expect("the outcome comes last");
    assert!(last.contains(",RMP,070000.500,0,2,0,30 elements"), "{last}");
    let elements: Vec<String> = heard[1..heard.len() - 1]
        .iter()
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!((fields[0], fields.len()), ("$BFPLN", 13));
            format!("{}/{}/{}/{}", fields[2], fields[3], fields[4], fields[5])
        })
        .collect();
    assert_eq!(elements[..5], ["1//0/1", "1//1/2", "/4/0/1", "/4/1/2", "/9/0/3"]);
    assert_eq!(elements[28..], ["/9/24/3", "2//0/0"]);
}

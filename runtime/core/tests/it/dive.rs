//! SR-025: a plan serves only the dive that it was sent for. What the vehicle's messages make core send and log is
//! bounded.

use std::time::Duration;

use backseat_core::Note;
use backseat_core::plugin::{Request, RequestState, Rule};
use backseat_spi::{AckStatus, BehaviorBegin, FromVehicle, MissionCommand, MissionStatus, Text};
use backseat_units::Timestamp;

use crate::course::{good_line, line, modify};
use crate::scene::refused_for;
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

fn status_of(trial: &Trial, dive: &str) -> FromVehicle {
    let message = MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(dive),
        status: Text::cleaned("Running"),
        details: Text::cleaned(""),
    };
    message.into()
}

fn begin_of(trial: &Trial, dive: &str, number: u32) -> FromVehicle {
    let message = BehaviorBegin {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(dive),
        number: Some(number),
        identifier: None,
        kind: Text::cleaned("trackline"),
    };
    message.into()
}

fn plans(trial: &Trial, since: Timestamp) -> usize {
    trial.sent_since("RMP", since).len()
}

#[test]
fn sr_025_another_dive_ends_the_lease_and_nothing_steers_until_its_plan_is_whole() {
    for by_status in [true, false] {
        let mut trial = Trial::steering();
        trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
        let first = if by_status {
            status_of(&trial, "survey.dive")
        } else {
            begin_of(&trial, "survey", 1)
        };
        trial.hear_now([first]);
        trial.run_for(1.0);
        assert!(trial.core.is_steering());
        // The other dive's plan does not come for a while.
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        let at = trial.now;
        let other = if by_status {
            status_of(&trial, "other.dive")
        } else {
            begin_of(&trial, "other", 1)
        };
        trial.hear_now([other]);
        assert!(!trial.core.is_steering() && !trial.core.has_control());
        assert_eq!(trial.sent_since("EMB", at).len(), 1);
        trial.run_for(8.0);
        assert_eq!(trial.sent_since("RMB", at).len(), 0, "by status {by_status}");
        trial.ask(1, [good_line(2)]);
        trial.run_for(0.3);
        assert!(
            trial.rejection(2).contains("the plan of this dive is not known yet"),
            "{:?}",
            trial.states(2)
        );
        trial.vehicle.replies.remove("RMP");
        trial.run_for(20.0);
        assert!(trial.core.is_steering(), "{:?}", trial.states(1).last());
    }
}

#[test]
fn sr_025_a_behavior_belongs_to_the_dive_that_its_begin_names() {
    let mut trial = Trial::under_way();
    let first = begin_of(&trial, "survey", 1);
    trial.hear_now([first]);
    trial.run_for(1.0);
    let other = begin_of(&trial, "other", 1);
    trial.hear_now([other]);
    trial.run_for(5.0);
    // Core knows what the vehicle flies of the other dive, and has that dive's plan.
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

/// Core asks for the plan at once a few times in a minute only.
const A_MINUTE_S: f64 = 60.0;

/// The vehicle has flown the dive a, and begins the dive b. Its BFMIS for b is lost, its BFMBS comes, and so does the
/// plan of b.
fn in_a_second_dive() -> Trial {
    let mut trial = Trial::under_way();
    let first = [status_of(&trial, "dives/a.dive"), begin_of(&trial, "a", 1)];
    trial.hear_now(first);
    trial.run_for(A_MINUTE_S);
    let second = begin_of(&trial, "b", 1);
    trial.hear_now([second]);
    trial.run_for(5.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    trial
}

#[test]
fn sr_025_the_status_of_a_third_dive_is_not_taken_for_the_lost_one_of_the_second() {
    let mut trial = in_a_second_dive();
    let at = trial.now;
    let third = status_of(&trial, "dives/c.dive");
    trial.hear_now([third]);
    assert!(!trial.core.is_steering() && !trial.core.has_control());
    assert_eq!((trial.sent_since("EMB", at).len(), plans(&trial, at)), (1, 1));
    // The behavior of the third dive may be the first word of a fourth one: core asks once more.
    let begun = begin_of(&trial, "c", 1);
    trial.hear_now([begun]);
    trial.run_for(10.0);
    assert!(trial.core.has_control());
    assert_eq!(plans(&trial, at), 2);
}

/// BFMIS names the dive b, and its plan comes. Long after that the first BFMBS names it too, so core asks again. Before the
/// answer comes, BFMIS names the dive c: that answer is b's plan, and not c's.
#[test]
fn sr_025_a_plan_that_was_asked_for_before_the_vehicle_named_the_dive_does_not_serve_it() {
    for by_status in [true, false] {
        let mut trial = Trial::under_way();
        let first = [status_of(&trial, "dives/a.dive"), begin_of(&trial, "a", 1)];
        trial.hear_now(first);
        trial.run_for(A_MINUTE_S);
        let by = |trial: &Trial, status, dive: &str| match status {
            true => status_of(trial, &format!("dives/{dive}.dive")),
            false => begin_of(trial, dive, 1),
        };
        let second = by(&trial, by_status, "b");
        trial.hear_now([second]);
        trial.run_for(5.0);
        let slow = Reply::Late(Duration::from_secs(1), AckStatus::Succeeded);
        trial.vehicle.replies.insert("RMP", slow);
        let at = trial.now;
        let second = by(&trial, !by_status, "b");
        trial.hear_now([second]);
        trial.run_for(0.5);
        assert_eq!(plans(&trial, at), 1, "by status {by_status}");
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        let third = by(&trial, by_status, "c");
        trial.hear_now([third]);
        trial.run_for(3.0);
        assert_eq!(plans(&trial, at), 2, "by status {by_status}");
        assert!(
            !trial.core.has_control(),
            "by status {by_status}: b's plan is taken for c's"
        );
        trial.vehicle.replies.remove("RMP");
        trial.run_for(20.0);
        assert!(trial.core.has_control(), "by status {by_status}");
    }
}

/// Core cannot know that a status which comes so late names the same dive. It asks for the plan once.
#[test]
fn sr_025_a_late_status_of_the_same_dive_costs_one_request_for_the_plan() {
    let mut trial = in_a_second_dive();
    let at = trial.now;
    for _ in 0..5 {
        let late = [status_of(&trial, "dives/b.dive"), begin_of(&trial, "b", 1)];
        trial.hear_now(late);
        trial.run_for(5.0);
    }
    assert_eq!(plans(&trial, at), 1);
    assert!(trial.core.has_control());
}

#[test]
fn sr_025_an_empty_or_repeated_dive_name_changes_nothing() {
    let mut trial = Trial::steering();
    trial.run_for(0.2);
    let at = trial.now;
    for dive in ["survey.dive", "", " survey.dive ", "survey.dive"] {
        let said = status_of(&trial, dive);
        trial.hear_now([said]);
    }
    trial.run_for(1.0);
    assert!(trial.core.is_steering() && trial.lease_ends().is_empty());
    assert_eq!(plans(&trial, at), 0);
}

#[test]
fn sr_025_a_behavior_missing_from_a_fresh_plan_is_not_modified_and_causes_one_plan_request() {
    let mut trial = Trial::under_way();
    let at = trial.now;
    let unknown = begin_of(&trial, "", 77);
    trial.hear_now([unknown]);
    trial.run_for(5.0);
    assert_eq!(plans(&trial, at), 1);
    for _ in 0..5 {
        let unknown = begin_of(&trial, "", 77);
        trial.hear_now([unknown]);
        trial.run_for(3.0);
    }
    assert_eq!(plans(&trial, at), 1, "the plan is kept, and not asked for again");
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).starts_with("plan: "), "{:?}", trial.states(1));
    let known = begin_of(&trial, "", 2);
    trial.hear_now([known]);
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2))[0], "sent", "{:?}", trial.states(2));
}

#[test]
fn sr_025_a_flood_of_unknown_behaviors_causes_few_plan_requests() {
    let mut trial = Trial::under_way();
    let at = trial.now;
    for number in 100..1100 {
        let unknown = begin_of(&trial, "", number);
        trial.hear_now([unknown]);
        trial.run_for(0.1);
    }
    let asked = plans(&trial, at);
    assert!((6..=24).contains(&asked), "{asked} in 100 s");
    assert!(trial.core.has_control());
}

#[test]
fn sr_013_a_flood_of_mission_commands_is_logged_in_part_and_counted() {
    let mut trial = Trial::under_way();
    let created = trial.vehicle.clock(trial.now);
    let command = |text: String| {
        FromVehicle::from(MissionCommand {
            created,
            text: Text::cleaned(&text),
        })
    };
    for number in 0..5000 {
        trial.hear_now([command(format!("flood {number}"))]);
        trial.run_for(0.001);
    }
    trial.run_for(2.0);
    let lines = |part: &str| {
        let said = |(_, note): &(Timestamp, Note)| matches!(note, Note::Text { text } if text.contains(part));
        trial.notes().iter().filter(|note| said(note)).count()
    };
    let told = lines("mission command: flood");
    assert!((100..=160).contains(&told), "{told} lines in 5 s");
    assert!(lines("more lines about what the vehicle said were left out") >= 4);
}

#[test]
fn sr_019_requests_over_a_plugins_rate_are_counted_and_not_logged_one_by_one() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| {
        let requests = (0..40).map(|tag| Request::Modify(modify(tag))).collect();
        (Duration::from_millis(1), Ok(requests))
    });
    trial.run_for(10.0);
    let over = |(_, note): &(Timestamp, Note)| match note {
        Note::Request(transition) => {
            matches!(&transition.state, RequestState::Rejected(refusal) if refusal.rule() == Rule::Rate)
        }
        _ => false,
    };
    let told = trial.notes().iter().filter(|note| over(note)).count();
    assert!((8..=14).contains(&told), "{told}");
    let counted = |(_, note): &(Timestamp, Note)| match note {
        Note::Text { text } => text.contains("more requests of first were over its rate"),
        _ => false,
    };
    assert!(trial.notes().iter().any(counted));
    let rejected = trial.core.request_counts().rejected;
    assert!(rejected > 3000, "all are in the ledger: {rejected}");
}

#[test]
fn sr_002_sr_025_inserts_that_waited_in_the_old_dive_are_in_doubt_until_the_plan_comes() {
    for kept in [true, false] {
        let mut trial = Trial::under_way();
        let first = status_of(&trial, "survey.dive");
        trial.hear_now([first]);
        trial.ask(0, [good_line(1)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
        if !kept {
            trial.vehicle.inserted.clear();
        }
        let other = status_of(&trial, "other.dive");
        trial.hear_now([other]);
        let begun = begin_of(&trial, "other", 1);
        trial.hear_now([begun]);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "unknown"]);
        trial.run_for(5.0);
        let told = if kept { "accepted" } else { "failed" };
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "unknown", told]);
    }
}

#[test]
fn sr_002_sr_025_an_insert_answered_after_a_change_of_dive_may_belong_to_the_old_dive() {
    let mut trial = Trial::under_way();
    let first = status_of(&trial, "survey.dive");
    trial.hear_now([first]);
    let late = Reply::Late(Duration::from_secs(1), AckStatus::Succeeded);
    trial.vehicle.replies.insert("RTK", late);
    trial.ask(0, [Request::Trackline(line(1, (800.0, -300.0), (800.0, -1500.0)))]);
    trial.run_for(0.2);
    let other = status_of(&trial, "other.dive");
    trial.hear_now([other]);
    let begun = begin_of(&trial, "other", 1);
    trial.hear_now([begun]);
    trial.vehicle.replies.remove("RTK");
    trial.run_for(3.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    // The wreck bars the way from the leg to the start of this insert, but not the way from the end of the first
    // insert.
    let behind = Request::Trackline(line(2, (0.0, -1500.0), (500.0, -1500.0)));
    refused_for(&mut trial, behind, 2, "wreck");
}

/// The vehicle refuses the plan of the dive that it has just named.
#[test]
fn sr_025_a_plan_that_is_refused_is_asked_for_at_most_six_times_a_minute() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RMP", Reply::Refuse);
    let at = trial.now;
    for dive in ["a", "b"] {
        let begun = BehaviorBegin {
            created: trial.vehicle.clock(trial.now),
            dive_file: Text::cleaned(dive),
            number: Some(1),
            identifier: None,
            kind: Text::cleaned("trackline"),
        };
        trial.hear_now([begun.into()]);
    }
    trial.run_for(300.0);
    let asked = trial.sent_since("RMP", at);
    assert!(asked.len() >= 20, "{asked:?}");
    for pair in asked.windows(7) {
        assert!(pair[6].since(pair[0]) >= Duration::from_secs(60), "{asked:?}");
    }
}

/// The vehicle's clock is set forward, another dive begins, and the clock is set back. What begins then belongs to the new dive.
#[test]
fn a_clock_that_is_set_forth_and_back_around_another_dive_hides_no_begin() {
    let mut trial = Trial::under_way();
    trial.hear_now([status_of(&trial, "survey.dive")]);
    trial.run_for(1.0);
    trial.vehicle.clock_nanos += 42_000_000_000;
    trial.run_for(2.0);
    trial.hear_now([status_of(&trial, "other.dive")]);
    trial.run_for(0.2);
    trial.vehicle.clock_nanos -= 42_000_000_000;
    trial.run_for(3.0);
    trial.hear_now([begin_of(&trial, "other", 1)]);
    trial.run_for(15.0);
    // An insert needs a begin that was heard.
    trial.ask(0, [good_line(1)]);
    trial.run_for(1.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

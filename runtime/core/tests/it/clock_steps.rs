//! The clock of an honest vehicle is set back and forth, or its messages are damaged. Core goes on after that, and ignores no order.

use backseat_core::plugin::Request;
use backseat_core::{Condition, ControlHook, Operator, Order, Policy, Settings};
use backseat_spi::{MissionCommand, Text};

use crate::course::{good_line, interrupting, modify};
use crate::scene::{begin_of, end_of, status_of};
use crate::trial::{Setup, Trial, settings};

const SECOND: i64 = 1_000_000_000;

fn says(trial: &mut Trial, text: &str) {
    let command = MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    };
    trial.hear_now([command.into()]);
    trial.run_for(0.5);
}

/// The clock goes forward by 42 s, another dive begins, and the clock goes back.
fn other_dive_between_steps() -> Trial {
    let mut trial = Trial::under_way();
    let first = [
        status_of(&trial, "a.dive", "Running"),
        begin_of(&trial, "a", Some(1), None, "trackline"),
    ];
    trial.hear_now(first);
    trial.run_for(3.0);
    trial.vehicle.clock_nanos += 42 * SECOND;
    trial.run_for(0.01);
    let other = [
        status_of(&trial, "b.dive", "Running"),
        begin_of(&trial, "b", Some(1), None, "trackline"),
    ];
    trial.hear_now(other);
    trial.run_for(0.12);
    trial.vehicle.clock_nanos -= 42 * SECOND;
    trial
}

fn state(trial: &Trial) -> String {
    let notes: Vec<_> = trial.notes().into_iter().rev().take(14).collect();
    format!(
        "{:?}\n{:?}\n{notes:#?}",
        trial.core.uncontrolled(),
        trial.core.open_request_states()
    )
}

#[test]
fn steers_after_a_dive_between_two_clock_steps() {
    let mut trial = other_dive_between_steps();
    trial.run_for(30.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(trial.core.is_steering(), "{:?} {}", trial.states(1), state(&trial));
}

/// A behavior begins 30 s later and lasts long.
#[test]
fn inserts_after_a_begin_between_clock_steps() {
    let mut trial = other_dive_between_steps();
    trial.run_for(30.0);
    let next = begin_of(&trial, "b", Some(2), None, "trackline");
    trial.hear_now([next]);
    trial.run_for(90.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
    trial.ask(0, [good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.sent("RTK").len(), 1, "{:?} {}", trial.states(2), state(&trial));
}

/// For comparison: it begins 70 s later.
#[test]
fn inserts_after_a_later_begin() {
    let mut trial = other_dive_between_steps();
    trial.run_for(70.0);
    let next = begin_of(&trial, "b", Some(2), None, "trackline");
    trial.hear_now([next]);
    trial.run_for(20.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.sent("RTK").len(), 1, "{:?} {}", trial.states(2), state(&trial));
}

/// The begin and the end of an insert, and the begin of what follows, come while the clock is set.
fn insert_flown_unheard(request: Request) -> Trial {
    let mut trial = other_dive_between_steps();
    trial.run_for(15.0);
    trial.ask(0, [request]);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 1, "{:?} {}", trial.states(2), state(&trial));
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(10.0);
    trial.vehicle.inserted.clear();
    let end = end_of(&trial, None, Some(1), "trackline");
    trial.hear_now([end]);
    let next = begin_of(&trial, "b", Some(1), None, "trackline");
    trial.hear_now([next]);
    trial
}

fn flies_on(trial: &mut Trial) {
    for number in [2, 1, 2, 1] {
        trial.run_for(150.0);
        let next = begin_of(trial, "b", Some(number), None, "trackline");
        trial.hear_now([next]);
    }
    trial.run_for(150.0);
    assert_eq!(trial.core.open_requests(), 0, "{:?} {}", trial.states(2), state(trial));
}

#[test]
fn an_insert_flown_between_clock_steps_is_over() {
    flies_on(&mut insert_flown_unheard(good_line(2)));
}

#[test]
fn an_interrupting_insert_flown_between_clock_steps_is_over() {
    flies_on(&mut insert_flown_unheard(interrupting(2)));
}

/// Without clock steps: the begin and the end of the insert are damaged (`heard_end`: only the begin).
fn insert_flown_damaged(heard_end: bool) {
    let mut trial = Trial::under_way();
    let first = [
        status_of(&trial, "b.dive", "Running"),
        begin_of(&trial, "b", Some(1), None, "trackline"),
    ];
    trial.hear_now(first);
    trial.run_for(3.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 1);
    trial.hear_bytes(b"$BFMBS,081025.987,0*00\r\n");
    trial.run_for(10.0);
    trial.vehicle.inserted.clear();
    if heard_end {
        let end = end_of(&trial, None, Some(1), "trackline");
        trial.hear_now([end]);
    } else {
        trial.hear_bytes(b"$BFMBE,081025.987,0*00\r\n");
    }
    let next = begin_of(&trial, "b", Some(1), None, "trackline");
    trial.hear_now([next]);
    flies_on(&mut trial);
}

#[test]
fn an_insert_flown_with_damaged_begin_and_end_is_over() {
    insert_flown_damaged(false);
}

#[test]
fn an_insert_flown_with_damaged_begin_is_over() {
    insert_flown_damaged(true);
}

/// The mission is over, another one runs, and the clock was set back in between.
#[test]
fn a_new_mission_after_the_clock_was_set_back_gets_control() {
    let mut trial = Trial::under_way();
    trial.vehicle.clock_nanos += 42 * SECOND;
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(0.12);
    trial.vehicle.clock_nanos -= 42 * SECOND;
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    let at = trial.now;
    trial.run_for(60.0);
    let begun = begin_of(&trial, "b", Some(1), None, "trackline");
    trial.hear_now([begun]);
    trial.run_for(15.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
    assert!(trial.sent_since("RMP", at).len() < 8 && trial.sent_since("LOG", at).len() < 100);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(trial.core.is_steering(), "{:?} {}", trial.states(1), state(&trial));
}

/// The clock flips between two times each second, with a flood of begins after another dive.
#[test]
fn ignored_begins_do_not_flood() {
    let mut trial = other_dive_between_steps();
    let at = trial.now;
    for number in 0..2000 {
        let next = begin_of(&trial, "b", Some(number), None, "trackline");
        trial.hear_now([next]);
        trial.run_for(0.02);
    }
    assert!(trial.sent_since("RMP", at).len() <= 8 && trial.sent_since("LOG", at).len() < 100);
    let lines = trial.notes().iter().filter(|(when, _)| *when > at).count();
    assert!(lines < 1200, "{lines}");
}

/// A release that is sent again once a minute is over works.
#[test]
fn a_release_works_after_a_minute() {
    let mut trial = with_texts(None, Vec::new());
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 300 * SECOND;
    trial.run_for(61.0);
    says(&mut trial, "release");
    trial.run_for(3.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
}

/// A third dive within a minute.
#[test]
fn a_third_dive_after_the_clock_was_set_back() {
    let mut trial = other_dive_between_steps();
    trial.run_for(15.0);
    let at = trial.now;
    let third = [
        status_of(&trial, "c.dive", "Running"),
        begin_of(&trial, "c", Some(1), None, "trackline"),
    ];
    trial.hear_now(third);
    let had_control = trial.core.has_control();
    trial.run_for(20.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(
        !trial.sent_since("RMP", at).is_empty(),
        "control {had_control}, steers {} by the plan of the second dive: {}",
        trial.core.is_steering(),
        state(&trial)
    );
}

fn with_texts(control: Option<ControlHook>, policies: Vec<Policy>) -> Trial {
    let control = control.unwrap_or(ControlHook::Bfctl);
    let mut trial = Trial::with(Setup {
        settings: Settings {
            hold_text: Some("hold".to_owned()),
            release_text: Some("release".to_owned()),
            control,
            policies,
            ..settings()
        },
        ..Setup::default()
    });
    trial.run_for(2.0);
    trial
}

/// The release is sent, and sent again.
#[test]
fn a_release_sent_again_after_the_clock_was_set_back() {
    let mut trial = with_texts(None, Vec::new());
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 42 * SECOND;
    trial.run_for(15.0);
    for _ in 0..2 {
        says(&mut trial, "release");
        trial.run_for(12.0);
    }
    assert!(trial.core.has_control(), "{}", state(&trial));
}

/// The operator takes control away by text under a hold, and releases the hold at the console.
#[test]
fn a_revocation_by_text_is_not_ignored_for_the_hold() {
    let hook = ControlHook::MissionCommand {
        grant: "go".to_owned(),
        revoke: "stop".to_owned(),
    };
    let mut trial = with_texts(Some(hook), Vec::new());
    says(&mut trial, "go");
    assert!(trial.core.has_control(), "{}", state(&trial));
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 42 * SECOND;
    trial.run_for(15.0);
    says(&mut trial, "stop");
    trial.operator(Operator::Release);
    trial.run_for(5.0);
    assert!(!trial.core.has_control(), "the revocation was ignored");
}

fn on_text(text: &str, act: Order) -> Policy {
    Policy {
        when: Condition::MissionCommand(text.to_owned()),
        order: act,
    }
}

/// The operator's abort by text, under a hold.
#[test]
fn an_abort_by_text_is_not_ignored_for_the_hold() {
    let abort = Order::Abort {
        text: "leak".to_owned(),
        errors: true,
    };
    let mut trial = with_texts(None, vec![on_text("abort now", abort)]);
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 42 * SECOND;
    trial.run_for(15.0);
    says(&mut trial, "abort now");
    trial.run_for(3.0);
    assert_eq!(trial.sent("ABT").len(), 1, "{}", state(&trial));
}

/// A second text that holds, by a policy, after the first was released at the console.
#[test]
fn a_hold_by_policy_is_not_ignored() {
    let mut trial = with_texts(None, vec![on_text("freeze", Order::Hold)]);
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 42 * SECOND;
    trial.run_for(15.0);
    trial.operator(Operator::Release);
    trial.run_for(3.0);
    assert!(trial.core.has_control(), "{}", state(&trial));
    says(&mut trial, "freeze");
    assert!(!trial.core.has_control(), "the hold was ignored");
}

/// A plugin's cancel frees the insert.
#[test]
fn a_cancel_frees_an_insert_flown_between_clock_steps() {
    let mut trial = insert_flown_unheard(good_line(2));
    trial.run_for(90.0);
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Refuse);
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(60.0);
    flies_on(&mut trial);
}

/// The second hold seems older than the first. A release from before it comes late.
#[test]
fn a_release_older_than_a_second_hold_is_ignored() {
    let mut trial = with_texts(None, Vec::new());
    says(&mut trial, "hold");
    trial.vehicle.clock_nanos -= 300 * SECOND;
    trial.run_for(40.0);
    let release = MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned("release"),
    };
    trial.run_for(10.0);
    says(&mut trial, "hold");
    trial.run_for(12.0);
    trial.hear_now([release.into()]);
    trial.run_for(3.0);
    assert!(!trial.core.has_control(), "{}", state(&trial));
}

/// Only the BFMIS of the third dive comes within a minute, and a behavior of it without a file a minute later.
#[test]
fn a_third_dive_by_status_only_after_the_clock_was_set_back() {
    let mut trial = other_dive_between_steps();
    trial.run_for(15.0);
    let third = status_of(&trial, "c.dive", "Running");
    trial.hear_now([third]);
    let at = trial.now;
    trial.run_for(80.0);
    let again = status_of(&trial, "c.dive", "Running");
    trial.hear_now([again]);
    let begun = begin_of(&trial, "", Some(1), None, "trackline");
    trial.hear_now([begun]);
    trial.run_for(20.0);
    assert!(!trial.sent_since("RMP", at).is_empty(), "{}", state(&trial));
}

/// A link loss after the steps.
#[test]
fn a_begin_on_a_new_connection_after_the_clock_was_set_back_counts() {
    let mut trial = other_dive_between_steps();
    trial.run_for(2.0);
    trial.cut();
    trial.run_for(20.0);
    let next = begin_of(&trial, "b", Some(2), None, "trackline");
    trial.hear_now([next]);
    trial.run_for(90.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.sent("RTK").len(), 1, "{:?} {}", trial.states(2), state(&trial));
}

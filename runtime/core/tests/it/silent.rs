use std::time::Duration;

use backseat_core::plugin::{EndCause, Ended, Failure};
use backseat_core::plugin::{FaultKind, Request, RequestState, SilentRequest};
use backseat_core::{Grant, Limits, Operator};
use backseat_spi::AckStatus;
use backseat_units::Timestamp;

use crate::course::limits;
use crate::trial::{Setup, Trial, granted, last_written, shorts};
use crate::vehicle::Reply;

fn silent(tag: u64) -> Request {
    Request::Silent(SilentRequest { tag, silent: true })
}

fn normal(tag: u64) -> Request {
    Request::Silent(SilentRequest { tag, silent: false })
}

fn setup() -> Setup {
    granted(&[Grant::Silent], &[])
}

const TWICE: Reply = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);

/// A vehicle that answers as the specification says.
fn under_way() -> Trial {
    under_way_with(setup())
}

fn under_way_with(setup: Setup) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    trial.vehicle.replies.insert("SIL", TWICE);
    trial
}

/// A trial in which the first plugin has made the vehicle silent under tag 1, and when it asked for that.
fn quiet() -> (Trial, Timestamp) {
    let mut trial = under_way();
    trial.ask(0, [silent(1)]);
    trial.run_for(2.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "pending", "accepted", "started"]);
    let sent = trial.sent("SIL")[0];
    (trial, sent)
}

fn run_until(trial: &mut Trial, at: Timestamp) {
    trial.run_for(at.since(trial.now).as_secs_f64());
}

fn lapsed() -> Option<RequestState> {
    Some(RequestState::Ended(Ended::Said(
        EndCause::Lapsed,
        "after 300 s".to_owned(),
    )))
}

#[test]
fn sr_018_silence_lasts_five_minutes_from_its_request() {
    let (mut trial, sent) = quiet();
    assert_eq!(last_written(&trial, "BPSIL"), ["1"]);
    run_until(&mut trial, sent + Duration::from_millis(299_990));
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
    run_until(&mut trial, sent + Duration::from_secs(300));
    assert_eq!(trial.states(1).last().cloned(), lapsed());
    assert_eq!(trial.core.open_requests(), 0);
    // The vehicle counts from when it became silent, up to 1.5 s later. Until then another request would not extend the
    // silence.
    trial.ask(0, [silent(2)]);
    trial.run_for(0.3);
    assert!(trial.rejection(2).starts_with("state: "));
    trial.run_for(2.0);
    trial.ask(0, [silent(3)]);
    trial.run_for(2.0);
    assert_eq!(shorts(&trial.states(3)).last(), Some(&"started"));
    assert_eq!(trial.sent("SIL").len(), 2);
}

#[test]
fn sr_018_the_first_acknowledgement_only_confirms_the_receipt() {
    let answers = [
        (Reply::Twice(Duration::from_secs(4), AckStatus::Succeeded), "started"),
        (Reply::Twice(Duration::from_secs(4), AckStatus::Failed), "failed"),
        (Reply::Pending(Duration::from_secs(4), AckStatus::Succeeded), "started"),
        (Reply::Pending(Duration::from_secs(4), AckStatus::Failed), "failed"),
    ];
    for (reply, state) in answers {
        let mut trial = under_way();
        trial.vehicle.replies.insert("SIL", reply);
        trial.ask(0, [silent(1)]);
        trial.run_for(3.9);
        assert_eq!(shorts(&trial.states(1)), ["sent", "pending"], "{reply:?}");
        trial.run_for(0.3);
        assert_eq!(shorts(&trial.states(1)).last(), Some(&state), "{reply:?}");
    }
}

#[test]
fn sr_009_a_refused_entry_into_silence_fails_and_can_be_requested_again() {
    for reply in [
        Reply::Refuse,
        Reply::Nak,
        Reply::Pending(Duration::from_secs(2), AckStatus::Failed),
    ] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("SIL", reply);
        trial.ask(0, [silent(1)]);
        trial.run_for(3.0);
        assert_eq!(
            trial.states(1).last(),
            Some(&RequestState::Failed(Failure::Vehicle("as told".to_owned())))
        );
        trial.vehicle.replies.insert("SIL", TWICE);
        trial.ask(0, [silent(2)]);
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(2)).last(), Some(&"started"));
    }
}

#[test]
fn sr_018_an_entry_without_both_answers_may_have_made_the_vehicle_silent() {
    // No receipt; a receipt but no second answer; a second answer that comes too late.
    for (reply, after) in [
        (Reply::Silent, 2.0),
        (Reply::PendingForEver, 6.0),
        (Reply::Ok, 6.0),
        (Reply::Pending(Duration::from_secs(8), AckStatus::Succeeded), 6.0),
    ] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("SIL", reply);
        trial.ask(0, [silent(1)]);
        trial.run_for(after - 0.1);
        assert_eq!(trial.core.open_requests(), 1, "{reply:?}");
        trial.run_for(0.4);
        assert_eq!(trial.states(1).last(), Some(&RequestState::TimedOut), "{reply:?}");
        trial.vehicle.replies.insert("SIL", TWICE);
        trial.run_for(250.0);
        trial.ask(0, [silent(2)]);
        trial.run_for(0.3);
        assert!(trial.rejection(2).contains("for "), "{reply:?}");
        trial.run_for(70.0);
        trial.ask(0, [silent(3)]);
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(3)).last(), Some(&"started"), "{reply:?}");
        assert!(!trial.states(1).contains(&RequestState::Started), "{reply:?}");
    }
}

#[test]
fn sr_018_a_plugin_whose_entry_was_not_answered_may_request_normal_mode() {
    let mut trial = under_way();
    trial.vehicle.replies.insert("SIL", Reply::Silent);
    trial.ask(0, [silent(1)]);
    trial.run_for(3.0);
    trial.vehicle.replies.insert("SIL", TWICE);
    trial.ask(0, [normal(2)]);
    trial.run_for(2.0);
    assert_eq!(shorts(&trial.states(2)), ["sent", "pending", "accepted", "ended"]);
    assert_eq!(last_written(&trial, "BPSIL"), ["0"]);
    trial.ask(0, [silent(3)]);
    trial.run_for(2.0);
    assert_eq!(shorts(&trial.states(3)).last(), Some(&"started"));
}

#[test]
fn sr_018_after_a_link_loss_during_the_entry_the_vehicle_counts_as_silent() {
    for wait in [0.05, 0.5] {
        let mut trial = under_way();
        trial.ask(0, [silent(1)]);
        trial.run_for(0.1 + wait);
        trial.cut();
        assert_eq!(trial.states(1).last(), Some(&RequestState::TimedOut));
        trial.run_for(280.0);
        assert_eq!(trial.sent("SIL").len(), 1, "the entry is never sent twice");
        trial.ask(0, [silent(2)]);
        trial.run_for(0.3);
        assert!(trial.rejection(2).contains("may be silent"));
        trial.run_for(40.0);
        trial.ask(0, [silent(3)]);
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(3)).last(), Some(&"started"));
    }
}

#[test]
fn sr_018_silence_outlives_link_control_mission_hold_and_plugin() {
    type Act = fn(&mut Trial);
    let acts: [Act; 7] = [
        |trial| trial.cut(),
        |trial| {
            trial.unreachable = true;
            trial.cut();
        },
        |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        },
        |trial| {
            let now = trial.now;
            trial.vehicle.set_status(now, "Completed");
        },
        |trial| trial.operator(Operator::Hold),
        |trial| trial.fail(0, FaultKind::Trap),
        |trial| trial.fail(0, FaultKind::Error),
    ];
    for act in acts {
        let (mut trial, sent) = quiet();
        trial.run_for(10.0);
        act(&mut trial);
        run_until(&mut trial, sent + Duration::from_millis(299_900));
        assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
        trial.run_for(0.1);
        assert_eq!(trial.states(1).last().cloned(), lapsed());
        assert_eq!(trial.sent("SIL").len(), 1);
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_018_a_plugin_can_end_its_silence_early() {
    let (mut trial, _) = quiet();
    trial.ask(0, [normal(2)]);
    trial.run_for(2.0);
    assert_eq!(last_written(&trial, "BPSIL"), ["0"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "pending", "accepted", "ended"]);
    let normal_again = RequestState::Ended(EndCause::NormalAgain.into());
    assert_eq!(trial.states(1).last(), Some(&normal_again));
    assert_eq!(trial.states(2).last(), Some(&normal_again));
    assert_eq!(trial.core.open_requests(), 0);
    trial.run_for(400.0);
    assert_eq!(trial.states(1).len(), 5, "it does not lapse as well");
}

#[test]
fn sr_018_a_refused_request_for_normal_mode_leaves_the_silence_as_it_was() {
    let (mut trial, sent) = quiet();
    trial.vehicle.replies.insert("SIL", Reply::Refuse);
    trial.ask(0, [normal(2)]);
    trial.run_for(1.0);
    assert_eq!(shorts(&trial.states(2)), ["sent", "failed"]);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
    run_until(&mut trial, sent + Duration::from_secs(300));
    assert_eq!(trial.states(1).last().cloned(), lapsed());
}

#[test]
fn sr_018_an_unanswered_request_for_normal_mode_ends_the_request_but_the_vehicle_counts_as_silent() {
    for cut in [true, false] {
        let (mut trial, _) = quiet();
        trial.vehicle.replies.insert("SIL", Reply::Silent);
        trial.ask(0, [normal(2)]);
        trial.run_for(0.5);
        if cut {
            trial.cut();
        }
        trial.run_for(6.0);
        assert_eq!(trial.states(2).last(), Some(&RequestState::TimedOut));
        let ended = RequestState::Ended(EndCause::NotNormal.into());
        assert_eq!(trial.states(1).last(), Some(&ended));
        assert_eq!(trial.core.open_requests(), 0);
        trial.vehicle.replies.insert("SIL", TWICE);
        trial.ask(0, [silent(3)]);
        trial.run_for(0.3);
        assert!(trial.rejection(3).contains("may be silent"));
        trial.run_for(300.0);
        trial.ask(0, [silent(4)]);
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(4)).last(), Some(&"started"));
    }
}

#[test]
fn sr_018_a_silence_that_lapses_during_a_request_for_normal_mode_ends_once() {
    for (reply, leave) in [
        (TWICE, "ended"),
        (Reply::Refuse, "failed"),
        (Reply::Silent, "timed out"),
    ] {
        let (mut trial, sent) = quiet();
        run_until(&mut trial, sent + Duration::from_millis(299_500));
        let reply = match reply {
            Reply::Refuse => Reply::Late(Duration::from_millis(1500), AckStatus::Failed),
            reply => reply,
        };
        trial.vehicle.replies.insert("SIL", reply);
        trial.ask(0, [normal(2)]);
        trial.run_for(5.0);
        assert_eq!(trial.states(1).last().cloned(), lapsed());
        assert_eq!(shorts(&trial.states(2)).last(), Some(&leave));
        trial.vehicle.replies.insert("SIL", TWICE);
        trial.ask(0, [silent(3)]);
        trial.run_for(2.0);
        assert_eq!(shorts(&trial.states(3)).last(), Some(&"started"));
    }
}

#[test]
fn requests_that_the_state_does_not_allow_are_rejected() {
    let mut trial = under_way();
    trial.ask(0, [normal(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).contains("is not silent"));
    // The second and the third request come before the first is answered.
    trial.ask(0, [silent(2), silent(3), normal(4)]);
    trial.run_for(2.0);
    assert!(trial.rejection(3).contains("has not answered the last BPSIL"));
    assert!(trial.rejection(4).contains("has not answered the last BPSIL"));
    trial.ask(0, [silent(5)]);
    trial.ask(1, [silent(6), normal(7)]);
    trial.run_for(0.3);
    assert!(trial.rejection(5).contains("would not extend that"));
    assert!(trial.rejection(6).contains("would not extend that"));
    assert!(trial.rejection(7).starts_with("priority: another plugin"));
    assert_eq!(shorts(&trial.states(2)).last(), Some(&"started"));
    assert_eq!(trial.sent("SIL").len(), 1);
}

#[test]
fn sr_018_silent_mode_needs_a_vehicle_that_acknowledges() {
    let mut trial = Trial::with(setup());
    for name in ["LOG", "VER", "RMP", "STS"] {
        trial.vehicle.replies.insert(name, Reply::Silent);
    }
    trial.run_for(2.0);
    trial.ask(0, [silent(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).contains("the vehicle has not answered yet"));
}

#[test]
fn sr_019_the_number_of_silences_of_a_mission_is_capped() {
    let limits = Limits {
        silences_total_max: 2,
        silent_term_s: 20.0,
        ..limits()
    };
    let mut trial = under_way_with(Setup { limits, ..setup() });
    for tag in 1..=2 {
        trial.ask(0, [silent(tag)]);
        trial.run_for(30.0);
        let ended = RequestState::Ended(Ended::Said(EndCause::Lapsed, "after 20 s".to_owned()));
        assert_eq!(
            trial.states(tag).last(),
            Some(&ended),
            "the term comes from the mission file"
        );
    }
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![silent(3)])));
    trial.run_for(60.0);
    assert!(trial.rejection(3).starts_with("cap: "));
    assert_eq!(trial.sent("SIL").len(), 2);
}

#[test]
fn sr_001_silent_mode_needs_the_grant_and_control() {
    let mut trial = Trial::under_way();
    trial.ask(0, [silent(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).contains("does not grant `silent`"));
    let (mut trial, _) = quiet();
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(0.5);
    trial.ask(0, [normal(2)]);
    trial.run_for(0.3);
    assert!(trial.rejection(2).starts_with("control: "));
}

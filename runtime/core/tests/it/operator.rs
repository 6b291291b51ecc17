use std::time::Duration;

use backseat_core::plugin::Request;
use backseat_core::{Grant, Note, Operator, Settings, Start};
use backseat_spi::{AckStatus, MissionCommand, Text};

use crate::course::{good_line, interrupting, modify};
use crate::trial::{Seen, Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

#[test]
fn sr_015_a_hold_ends_the_lease_cancels_our_inserts_and_beats_every_plugin_until_it_is_released() {
    let mut trial = Trial::steering();
    trial.ask(0, [good_line(2)]);
    trial.ask(1, [good_line(3)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    trial.ask(0, [Request::Modify(modify(4))]);
    trial.run_for(0.5);
    let held = trial.now;
    trial.operator(Operator::Hold);
    assert_eq!(trial.sent_since("EMB", held), [held]);
    assert_eq!(
        trial.commands("RCN").len(),
        1,
        "the one that has begun cannot be cancelled"
    );
    trial.script(1, |_| {
        (
            Duration::from_millis(1),
            Ok(vec![Request::Modify(modify(5)), good_line(6)]),
        )
    });
    trial.run_for(20.0);
    assert!(!trial.core.has_control());
    assert!(trial.sent_since("RMB", held).is_empty() && trial.sent_since("RTK", held).is_empty());
    trial.operator(Operator::Release);
    trial.run_for(1.0);
    assert!(trial.core.is_steering());
}

/// The vehicle is slow to answer, so an interrupting insert waits for an answer.
fn waiting() -> Trial {
    let mut trial = Trial::with_under_way(granted(&[Grant::Insert, Grant::Interrupt], &[]));
    let late = Reply::Late(Duration::from_millis(700), AckStatus::Succeeded);
    trial.vehicle.replies.insert("STS", late);
    trial.run_for(3.0);
    let beats = trial.sent("STS").len();
    while trial.sent("STS").len() == beats {
        trial.run_for(0.02);
    }
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.2);
    assert!(
        trial.commands("RTK").is_empty() && trial.states(1).is_empty(),
        "it waits"
    );
    trial
}

#[test]
fn sr_015_what_waits_for_an_answer_during_a_hold_does_not_leave_after_its_release() {
    let mut trial = waiting();
    trial.operator(Operator::Hold);
    assert!(trial.rejection(1).starts_with("control: "), "{:?}", trial.states(1));
    trial.run_for(0.1);
    trial.operator(Operator::Release);
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    assert!(trial.commands("RTK").is_empty(), "{:?}", trial.states(1));
}

#[test]
fn sr_001_what_waits_for_an_answer_when_control_is_lost_does_not_leave_once_it_is_back() {
    let mut trial = waiting();
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(0.05);
    assert!(trial.rejection(1).starts_with("control: "), "{:?}", trial.states(1));
    let now = trial.now;
    trial.vehicle.set_control(now, true);
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    assert!(trial.commands("RTK").is_empty(), "{:?}", trial.states(1));
}

#[test]
fn sr_015_a_hold_survives_a_restart() {
    let setup = Setup::default();
    let start = Start {
        held: true,
        ..setup.start
    };
    let mut trial = Trial::with(Setup { start, ..setup });
    trial.run_for(5.0);
    assert!(!trial.core.has_control());
    trial.operator(Operator::Release);
    assert!(trial.core.has_control());
}

#[test]
fn sr_015_a_hold_during_a_link_loss_cancels_our_inserts_when_the_link_is_back() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.cut();
    trial.operator(Operator::Hold);
    trial.run_for(5.0);
    assert_eq!(trial.commands("RCN").len(), 1);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "cancelled"]);
}

#[test]
fn a_stop_ends_the_lease_and_closes_the_logs() {
    let mut trial = Trial::steering();
    let stopped = trial.now;
    trial.operator(Operator::Stop);
    assert_eq!(trial.sent_since("EMB", stopped), [stopped]);
    assert!(trial.seen.iter().any(|(_, seen)| *seen == Seen::Finish));
    trial.run_for(3.0);
    assert!(trial.sent_since("RMB", stopped).is_empty());
}

/// The operator's acts as core reports them. The driver that persists a hold learns of it from these.
fn acts(trial: &Trial) -> Vec<Operator> {
    let act = |(_, note)| match note {
        Note::Operator { act } => Some(act),
        _ => None,
    };
    trial.notes().into_iter().filter_map(act).collect()
}

fn commanded(trial: &mut Trial, text: &str) {
    let command = MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    };
    trial.hear_now([command.into()]);
}

fn texts(hold: Option<&str>, release: Option<&str>) -> Setup {
    Setup {
        settings: Settings {
            hold_text: hold.map(str::to_owned),
            release_text: release.map(str::to_owned),
            ..Settings::default()
        },
        ..Setup::default()
    }
}

#[test]
fn sr_015_a_mission_command_holds_at_once_and_until_its_counterpart_releases() {
    let mut trial = Trial::with_under_way(texts(Some("backseat hold"), Some("backseat go")));
    trial.ask(0, [Request::Modify(modify(1)), good_line(2)]);
    trial.run_for(0.5);
    for near in ["backseat", "Backseat hold", "backseat hold now", "backseat  hold", ""] {
        commanded(&mut trial, near);
        assert!(trial.core.is_steering(), "`{near}` is not the text");
    }
    let held = trial.now;
    commanded(&mut trial, "backseat hold ");
    assert_eq!(trial.sent_since("EMB", held), [held]);
    assert_eq!(trial.sent_since("RCN", held), [held]);
    assert_eq!(acts(&trial), [Operator::Hold]);
    // The hold outlives the link, a new grant of control, and every plugin's request.
    trial.script(0, |_| {
        (
            std::time::Duration::from_millis(1),
            Ok(vec![Request::Modify(modify(3))]),
        )
    });
    trial.cut();
    trial.run_for(20.0);
    assert!(!trial.core.has_control() && trial.sent_since("RMB", held).is_empty());
    commanded(&mut trial, "backseat go");
    assert_eq!(acts(&trial), [Operator::Hold, Operator::Release]);
    trial.run_for(1.0);
    assert!(trial.core.is_steering());
}

#[test]
fn sr_015_a_text_releases_the_hold_only_if_the_operator_configured_one() {
    let mut trial = Trial::with_under_way(texts(Some("hold"), None));
    commanded(&mut trial, "hold");
    for text in ["release", "go", "", "hold"] {
        commanded(&mut trial, text);
    }
    trial.run_for(5.0);
    assert!(!trial.core.has_control());
    assert!(!acts(&trial).contains(&Operator::Release));
    // The operator can still release the hold in another way.
    trial.operator(Operator::Release);
    assert!(trial.core.has_control());
    // If no texts are configured, no text acts.
    let mut trial = Trial::steering();
    for text in ["hold", ""] {
        commanded(&mut trial, text);
    }
    assert!(trial.core.is_steering() && acts(&trial).is_empty());
}

#[test]
fn sr_015_a_hold_by_text_beats_a_grant_of_control_by_the_same_text() {
    let setup = texts(Some("payload"), Some("release"));
    let control = backseat_core::ControlHook::MissionCommand {
        grant: "payload".to_owned(),
        revoke: "no payload".to_owned(),
    };
    let settings = Settings {
        control,
        ..setup.settings.clone()
    };
    let mut trial = Trial::with(Setup { settings, ..setup });
    trial.run_for(2.0);
    commanded(&mut trial, "payload");
    assert!(!trial.core.has_control());
    commanded(&mut trial, "release");
    assert!(trial.core.has_control(), "control was granted during the hold");
}

use std::time::Duration;

use backseat_core::plugin::{EndCause, Failure};
use backseat_core::plugin::{Event, FaultKind, Request, RequestState, Topic, TopsideRequest, Transport};
use backseat_core::{Grant, Note, Operator, Start};
use backseat_spi::{AckStatus, Text, TopsideMessage, Transport as Way};
use backseat_units::Timestamp;

use crate::trial::{Setup, Trial, granted, last_written, shorts};
use crate::vehicle::Reply;

fn text(tag: u64, text: &str) -> Request {
    Request::Topside(TopsideRequest {
        tag,
        slowest: Transport::AcousticModem,
        text: text.to_owned(),
    })
}

fn setup() -> Setup {
    granted(&[Grant::Topside], &[Topic::Topside])
}

fn under_way() -> Trial {
    Trial::with_under_way(setup())
}

#[test]
fn a_text_is_sent_unchanged_and_ends_once_the_vehicle_has_queued_it() {
    for (reply, states) in [
        (Reply::Ok, vec!["sent", "accepted", "ended"]),
        (
            Reply::Pending(Duration::from_secs(2), AckStatus::Succeeded),
            vec!["sent", "pending", "accepted", "ended"],
        ),
    ] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("TOP", reply);
        trial.ask(0, [text(1, "contact 3: 12.5 m (good)")]);
        trial.run_for(3.0);
        assert_eq!(last_written(&trial, "BPTOP"), ["3", "contact 3: 12.5 m (good)", "0"]);
        assert_eq!(shorts(&trial.states(1)), states);
        assert_eq!(
            trial.states(1).last(),
            Some(&RequestState::Ended(EndCause::Queued.into()))
        );
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_a_refused_text_fails_and_an_unanswered_one_times_out() {
    let ends = [
        (
            Reply::Refuse,
            RequestState::Failed(Failure::Vehicle("as told".to_owned())),
        ),
        (
            Reply::Pending(Duration::from_secs(1), AckStatus::Failed),
            RequestState::Failed(Failure::Vehicle("as told".to_owned())),
        ),
        (Reply::Nak, RequestState::Failed(Failure::Vehicle("as told".to_owned()))),
        (Reply::Silent, RequestState::TimedOut),
        (Reply::PendingForEver, RequestState::TimedOut),
        // A late answer changes nothing.
        (
            Reply::Late(Duration::from_secs(3), AckStatus::Succeeded),
            RequestState::TimedOut,
        ),
    ];
    for (reply, end) in ends {
        let mut trial = under_way();
        trial.vehicle.replies.insert("TOP", reply);
        trial.ask(0, [text(1, "hello")]);
        trial.run_for(8.0);
        assert_eq!(trial.states(1).last(), Some(&end), "{reply:?}");
        assert_eq!(trial.sent("TOP").len(), 1);
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_a_text_whose_answer_was_lost_with_the_link_times_out_and_is_not_sent_again() {
    for reply in [Reply::Silent, Reply::PendingForEver] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("TOP", reply);
        trial.ask(0, [text(1, "hello")]);
        trial.run_for(0.5);
        trial.cut();
        assert_eq!(trial.states(1).last(), Some(&RequestState::TimedOut));
        trial.vehicle.replies.clear();
        trial.run_for(10.0);
        assert!(trial.core.has_control());
        assert_eq!(trial.sent("TOP").len(), 1);
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn a_repeated_answer_changes_nothing() {
    let mut trial = under_way();
    trial
        .vehicle
        .replies
        .insert("TOP", Reply::Twice(Duration::from_millis(200), AckStatus::Failed));
    trial.ask(0, [text(1, "hello")]);
    trial.run_for(2.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
}

#[test]
fn a_text_that_cannot_be_sent_unchanged_is_rejected_and_not_altered() {
    let mut trial = under_way();
    let long = "x".repeat(201);
    let bad = [
        ("a,b", "','"),
        ("a*b", "'*'"),
        ("a$b", "'$'"),
        ("a\r\n$BPKIL", "'\\r'"),
        ("größe", "'ö'"),
        ("a\u{0}b", "not allowed"),
        ("", "empty"),
        ("  ", "empty"),
        (&long, "text is 201; expected at most 200 bytes"),
        ("do RMB now", "RMB at byte 3"),
        ("BPABT", "ABT"),
    ];
    for (tag, (bad, why)) in (1..).zip(bad) {
        trial.ask(0, [text(tag, bad)]);
        trial.run_for(0.2);
        let reason = trial.rejection(tag);
        assert!(
            reason.starts_with("text: ") && reason.contains(why),
            "{bad:?}: {reason}"
        );
        assert!(!reason.contains(['\n', '\r']));
    }
    assert!(trial.sent("TOP").is_empty());
    // The rejected texts do not count under the limit of a minute.
    trial.ask(0, [text(20, &"x".repeat(200)), text(21, "0123456789ABCDEF")]);
    trial.run_for(0.2);
    assert_eq!(trial.sent("TOP").len(), 2);
}

#[test]
fn sr_019_the_number_of_texts_a_minute_is_capped() {
    let mut trial = under_way();
    for plugin in 0..2 {
        trial.script(plugin, |_| (Duration::from_millis(1), Ok(vec![text(1, "again")])));
    }
    trial.run_for(150.0);
    let sent = trial.sent("TOP");
    assert_eq!(sent.len(), 18);
    let spans = sent.windows(7).map(|seven| seven[6].since(seven[0]));
    assert!(spans.min() >= Some(Duration::from_secs(60)));
    assert!(trial.rejection(1).starts_with("rate: "));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_001_a_text_needs_the_grant_control_and_an_armed_runtime() {
    let mut plain = Trial::under_way();
    plain.ask(0, [text(1, "hello")]);
    plain.run_for(0.3);
    assert!(plain.rejection(1).contains("does not grant `topside`"));

    let start = Start {
        armed: false,
        ..Setup::default().start
    };
    let mut unarmed = Trial::with_under_way(Setup { start, ..setup() });
    unarmed.ask(0, [text(1, "hello")]);
    unarmed.run_for(0.3);
    assert!(unarmed.rejection(1).contains("not armed"));

    let mut held = under_way();
    held.operator(Operator::Hold);
    held.ask(0, [text(1, "hello")]);
    held.run_for(0.3);
    assert!(held.rejection(1).contains("the operator's hold is set"));
    for trial in [plain, unarmed, held] {
        assert!(trial.sent("TOP").is_empty());
    }
}

#[test]
fn a_sent_text_gets_its_outcome_even_if_control_or_its_plugin_is_lost() {
    type Act = fn(&mut Trial);
    let acts: [Act; 3] = [
        |trial| trial.operator(Operator::Hold),
        |trial| trial.fail(0, FaultKind::Trap),
        |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        },
    ];
    for act in acts {
        let mut trial = under_way();
        let reply = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);
        trial.vehicle.replies.insert("TOP", reply);
        trial.ask(0, [text(1, "hello")]);
        trial.run_for(0.5);
        act(&mut trial);
        trial.run_for(3.0);
        assert_eq!(shorts(&trial.states(1)), ["sent", "pending", "accepted", "ended"]);
    }
}

#[test]
fn a_message_from_the_topside_reaches_the_subscribed_plugins_and_the_log() {
    let mut setup = setup();
    setup.plugins[1].description.topics.clear();
    let mut trial = Trial::with_under_way(setup);
    for (way, said) in [(Way::AcousticModem, "come home"), (Way::Other(9), "")] {
        let message = TopsideMessage {
            created: trial.vehicle.clock(trial.now),
            transport: way,
            text: Text::cleaned(said),
        };
        trial.hear_now([message.into()]);
    }
    trial.run_for(0.3);
    let heard: Vec<Event> = trial
        .events(0)
        .into_iter()
        .filter(|event| matches!(event, Event::TopsideMessage { .. }))
        .collect();
    let expected = |transport, text: &str| Event::TopsideMessage {
        transport,
        text: text.to_owned(),
    };
    assert_eq!(
        heard,
        [
            expected(Some(Transport::AcousticModem), "come home"),
            expected(None, "")
        ]
    );
    let other = trial.events(1);
    assert!(!other.iter().any(|event| matches!(event, Event::TopsideMessage { .. })));
    let noted = |(_, note): (Timestamp, Note)| {
        note == Note::Text {
            text: "message from the topside: come home".to_owned(),
        }
    };
    assert!(trial.notes().into_iter().any(noted));
}

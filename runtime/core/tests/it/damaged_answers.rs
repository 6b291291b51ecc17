//! What holds although a line to the vehicle was damaged on its way, or an answer does not say what it answers.

use std::time::Duration;

use backseat_core::plugin::{Request, RequestState};
use backseat_core::{Limits, Operator, Order, RequestKind};
use backseat_spi::{AckStatus, Acknowledgement, CommandName, EchoedTime, FromVehicle, Text, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::course::{good_line, interrupting, limits, modify};
use crate::scene::begins;
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::{Reply, name_of};

/// The answer to a line that the vehicle cannot read. It does not say which line that was.
fn nak(trial: &mut Trial) {
    let now = trial.now;
    let nak = ("NAK", TimeOfDay::MIDNIGHT, None, AckStatus::Invalid);
    trial.vehicle.acknowledge(now, nak);
}

fn subscribed(trial: &Trial, message: &str) -> Vec<Timestamp> {
    let of = |(at, command)| match command {
        ToVehicle::LoggingControl(logging) if logging.message.as_str() == message => Some(at),
        _ => None,
    };
    trial.commands("LOG").into_iter().filter_map(of).collect()
}

fn cancelled(trial: &Trial) -> Vec<u32> {
    let commands = trial.commands("RCN").into_iter();
    commands.filter_map(|(_, command)| name_of(&command).1).collect()
}

/// The line of a subscription is damaged on its way. Whether the vehicle then says nothing or that it has not understood
/// something, the acknowledgements do not say which message they are for.
#[test]
fn sr_003_a_subscription_that_is_damaged_on_its_way_is_sent_again_until_the_vehicle_has_it() {
    for message in ["MIS", "NVG", "NVR", "MBS", "MBE", "CTD"] {
        for naks in [true, false] {
            let mut trial = Trial::new();
            trial.vehicle.damaged_subscription = Some(message);
            trial.vehicle.naks_damage = naks;
            trial.run_for(3.0);
            assert!(trial.vehicle.subscribed.contains(message), "{message} {naks}");
            // Until navigation is steady.
            trial.run_for(12.0);
            trial.ask(0, [Request::Modify(modify(1))]);
            trial.run_for(0.5);
            assert!(trial.core.is_steering(), "{message} {naks}: {:?}", trial.states(1));
            let settled = trial.sent("LOG").len();
            trial.run_for(60.0);
            assert_eq!(
                trial.sent("LOG").len(),
                settled,
                "{message} {naks}: all are acknowledged"
            );
        }
    }
}

/// The heartbeat subscribes to acknowledgements again, and the answer to that is taken for the one that is missing.
#[test]
fn sr_003_the_answer_to_a_later_subscription_does_not_stand_for_a_missing_one() {
    let mut trial = Trial::new();
    for name in ["VER", "STS", "RMB", "RMP"] {
        trial.vehicle.replies.insert(name, Reply::Silent);
    }
    trial.vehicle.damaged_subscription = Some("MBE");
    trial.vehicle.naks_damage = false;
    trial.run_for(1.9);
    assert!(trial.vehicle.damaged_subscription.is_none());
    trial.vehicle.damaged_subscription = Some("MBE");
    trial.run_for(1.0);
    assert!(trial.vehicle.damaged_subscription.is_none() && !trial.vehicle.subscribed.contains("MBE"));
    trial.run_for(20.0);
    assert!(
        trial.vehicle.subscribed.contains("MBE"),
        "{:?}",
        subscribed(&trial, "MBE")
    );
}

/// A vehicle that never acknowledges one of the subscriptions is asked for it, and for those whose acknowledgement may
/// have been meant for it, at growing intervals.
#[test]
fn a_subscription_that_is_never_acknowledged_does_not_fill_the_link() {
    for naks in [true, false] {
        let mut trial = Trial::new();
        trial.vehicle.naks_damage = naks;
        for _ in 0..3000 {
            trial.vehicle.damaged_subscription = Some("CTD");
            trial.run_for(0.1);
        }
        assert!(trial.core.has_control());
        let sent = subscribed(&trial, "CTD");
        let at: Vec<u64> = sent.iter().map(|at| at.since(sent[0]).as_secs()).collect();
        assert_eq!(at[..7], [0, 2, 6, 14, 30, 62, 94], "NAK: {naks}");
        let all = trial.sent("LOG").len();
        assert!(all <= 9 * sent.len(), "NAK: {naks}: {all}");
    }
}

/// An insert is under way to a vehicle that accepts it; a NAK that belongs to another line comes before its answer.
fn accepted_after_a_nak(setup: Setup, request: Request) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    let late = Reply::Late(Duration::from_millis(400), AckStatus::Succeeded);
    trial.vehicle.replies.insert("RTK", late);
    trial.ask(0, [request]);
    trial.run_for(0.3);
    assert_eq!(trial.commands("RTK").len(), 1);
    nak(&mut trial);
    trial.run_for(0.7);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    trial.vehicle.replies.clear();
    trial.vehicle.inserted.insert(1);
    trial
}

#[test]
fn sr_010_an_insert_accepted_after_a_nak_is_not_interrupted_by_another() {
    let mut trial = accepted_after_a_nak(Setup::default(), interrupting(1));
    trial.ask(0, [interrupting(2)]);
    trial.run_for(1.5);
    assert_eq!(trial.commands("RTK").len(), 1, "{:?}", trial.states(2));
}

#[test]
fn sr_015_a_hold_takes_back_an_insert_accepted_after_a_nak() {
    let mut trial = accepted_after_a_nak(Setup::default(), good_line(1));
    trial.operator(Operator::Hold);
    trial.run_for(1.0);
    assert_eq!(cancelled(&trial), [1]);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"cancelled"));
}

fn one_at_a_time() -> Setup {
    let limits = Limits {
        inserts_open_max: 1,
        ..limits()
    };
    Setup {
        limits,
        ..Setup::default()
    }
}

#[test]
fn sr_019_an_insert_accepted_after_a_nak_counts_under_the_caps() {
    let mut trial = accepted_after_a_nak(one_at_a_time(), good_line(1));
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(trial.commands("RTK").len(), 1, "{:?}", trial.states(2));
}

/// A refusal without the time of its command may be meant for any command.
#[test]
fn sr_009_an_insert_that_may_not_have_been_understood_times_out_and_is_called_back() {
    for name in ["NAK", "RTK"] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", Reply::Silent);
        trial.ask(0, [good_line(1), good_line(2)]);
        trial.run_for(0.3);
        let now = trial.now;
        let unread = (name, TimeOfDay::MIDNIGHT, None, AckStatus::Invalid);
        trial.vehicle.acknowledge(now, unread);
        trial.run_for(0.2);
        assert_eq!(shorts(&trial.states(1)), ["sent"], "{name}");
        trial.run_for(3.0);
        for tag in [1, 2] {
            assert_eq!(shorts(&trial.states(tag)), ["sent", "timed out"], "{name}");
        }
        assert_eq!(cancelled(&trial), [1, 2], "{name}");
        let counts = trial.core.request_counts();
        assert_eq!((counts.sent, counts.unanswered, counts.undecided), (2, 2, 0), "{name}");
        assert!(counts.add_up(), "{name}: {counts:?}");
    }
}

/// The vehicle answers an insert with a refusal and then accepts it, each with the command's time.
fn accepted_after_a_refusal(setup: Setup, request: Request, status: AckStatus, after_s: f64) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [request]);
    trial.run_for(0.3 + after_s);
    assert_eq!(shorts(&trial.states(1)), ["sent", "failed"]);
    let created = trial.commands("RTK")[0].1.created().unwrap();
    let now = trial.now;
    trial.vehicle.acknowledge(now, ("RTK", created, Some(1), status));
    trial.run_for(0.2);
    trial.vehicle.inserted.insert(1);
    trial.vehicle.replies.clear();
    trial
}

#[test]
fn sr_009_sr_019_an_insert_accepted_after_its_refusal_counts_under_the_caps_and_keeps_its_outcome() {
    for status in [AckStatus::Succeeded, AckStatus::Pending] {
        let mut trial = accepted_after_a_refusal(one_at_a_time(), good_line(1), status, 0.0);
        trial.ask(0, [good_line(2)]);
        trial.run_for(0.5);
        assert_eq!(trial.commands("RTK").len(), 1, "{status:?}: {:?}", trial.states(2));
        assert_eq!(shorts(&trial.states(1)), ["sent", "failed"], "{status:?}");
        let counts = trial.core.request_counts();
        assert_eq!((counts.sent, counts.failed), (1, 1), "{status:?}");
        assert!(counts.add_up(), "{status:?}: {counts:?}");
        // The runtime cancels it, because the plugin takes it for refused, and then another may be sent.
        trial.run_for(5.0);
        assert!(trial.vehicle.inserted.is_empty(), "{status:?}");
        trial.ask(0, [good_line(3)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{status:?}");
    }
}

#[test]
fn sr_010_an_insert_accepted_after_its_refusal_is_not_interrupted_by_another() {
    let mut trial = accepted_after_a_refusal(Setup::default(), interrupting(1), AckStatus::Succeeded, 0.0);
    trial.ask(0, [interrupting(2)]);
    trial.run_for(1.5);
    assert_eq!(trial.commands("RTK").len(), 1, "{:?}", trial.states(2));
}

#[test]
fn sr_015_a_hold_takes_back_an_insert_accepted_after_its_refusal() {
    for after_s in [0.0, 9.0] {
        let mut trial = accepted_after_a_refusal(Setup::default(), good_line(1), AckStatus::Succeeded, after_s);
        assert_eq!(cancelled(&trial), [1], "at once");
        trial.operator(Operator::Hold);
        trial.run_for(5.0);
        assert!(trial.vehicle.inserted.is_empty(), "{after_s}: {:?}", cancelled(&trial));
        // Nothing is left of it: the plan goes on, and other inserts are admitted.
        trial.operator(Operator::Release);
        begins(&mut trial, Some(1), None);
        trial.ask(0, [interrupting(2)]);
        trial.run_for(1.5);
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{after_s}");
    }
}

/// Core asked for the plan before the vehicle accepted the insert, so it shows nothing that the plan lacks it.
#[test]
fn sr_019_a_plan_from_before_the_acceptance_does_not_settle_an_insert_accepted_after_its_refusal() {
    let mut trial = Trial::with_under_way(one_at_a_time());
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    let slow = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);
    trial.vehicle.replies.insert("RMP", slow);
    trial.ask(0, [good_line(1)]);
    trial.run_for(7.5);
    let asked = trial.sent("RMP").len();
    // Another payload's insert, which core does not know.
    begins(&mut trial, None, Some(77));
    assert_eq!(trial.sent("RMP").len(), asked + 1);
    let created = trial.commands("RTK")[0].1.created().unwrap();
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RTK", created, Some(1), AckStatus::Succeeded));
    trial.run_for(2.0);
    begins(&mut trial, Some(1), None);
    trial.vehicle.replies.remove("RTK");
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(trial.commands("RTK").len(), 1, "{:?}", trial.states(2));
}

#[test]
fn an_insert_of_a_mission_that_is_over_is_not_remembered_as_refused() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.3);
    let created = trial.commands("RTK")[0].1.created().unwrap();
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(0.1);
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RTK", created, Some(1), AckStatus::Succeeded));
    trial.run_for(5.0);
    assert!(cancelled(&trial).is_empty());
}

#[test]
fn sr_015_a_cancel_that_is_damaged_on_its_way_is_sent_again() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.vehicle.replies.insert("RCN", Reply::Nak);
    trial.operator(Operator::Hold);
    trial.run_for(0.5);
    assert_eq!(cancelled(&trial), [1]);
    trial.vehicle.replies.clear();
    trial.run_for(5.0);
    assert_eq!(cancelled(&trial), [1, 1]);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"cancelled"));
}

#[test]
fn sr_012_an_abort_or_kill_that_is_damaged_on_its_way_is_sent_again() {
    let text = || "x".to_owned();
    for (letters, kind, order) in [
        ("KIL", RequestKind::Kill, Order::Kill { text: text() }),
        (
            "ABT",
            RequestKind::Abort,
            Order::Abort {
                text: text(),
                errors: true,
            },
        ),
    ] {
        let mut trial = Trial::steering();
        trial.vehicle.replies.insert(letters, Reply::Nak);
        trial.operator(Operator::Order(order));
        trial.run_for(0.5);
        assert_eq!(trial.sent(letters).len(), 1);
        trial.vehicle.replies.clear();
        trial.run_for(10.0);
        assert_eq!(trial.sent(letters).len(), 2, "{kind:?}");
    }
}

/// The echoes of this vehicle have two decimals (SPI 6.21) and no identifier.
#[test]
fn sr_015_two_inserts_of_one_instant_are_told_apart_by_echoes_with_two_decimals() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [good_line(1)]);
    trial.ask(1, [good_line(2)]);
    trial.run_for(0.3);
    let sent = trial.commands("RTK").into_iter();
    let created: Vec<TimeOfDay> = sent.map(|(_, command)| command.created().unwrap()).collect();
    assert_eq!(created.len(), 2);
    for (of, status) in [
        (0, AckStatus::Pending),
        (1, AckStatus::Succeeded),
        (0, AckStatus::Failed),
    ] {
        let ack: FromVehicle = Acknowledgement {
            created: trial.vehicle.clock(trial.now),
            command: CommandName::new("RTK").unwrap(),
            command_created: EchoedTime::with_decimals(created[of], 2),
            behavior: None,
            status,
            text: Text::cleaned(""),
        }
        .into();
        trial.hear_now([ack]);
        trial.run_for(0.1);
    }
    assert_eq!(shorts(&trial.states(1)), ["sent", "pending", "failed"]);
    assert_eq!(trial.states(2).last(), Some(&RequestState::Accepted));
    trial.vehicle.inserted.insert(2);
    trial.vehicle.replies.clear();
    trial.operator(Operator::Hold);
    trial.run_for(5.0);
    assert_eq!(cancelled(&trial), [2]);
}

/// The vehicle acknowledges no BPLOG, and sends no velocities. Core subscribes to them anew every ten seconds.
#[test]
fn sr_012_sr_015_subscriptions_that_are_not_acknowledged_leave_room_for_what_the_operator_orders() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("LOG", Reply::Silent);
    trial.vehicle.bend = Some(Box::new(|_, _, _| false));
    let a_minute = |trial: &mut Trial| {
        let at = trial.now;
        trial.run_for(60.0);
        trial.sent_since("LOG", at).len()
    };
    let first = a_minute(&mut trial);
    trial.run_for(3600.0);
    let after_an_hour = a_minute(&mut trial);
    assert!(after_an_hour <= first, "{first} and then {after_an_hour} a minute");
    let text = "leak".to_owned();
    trial.operator(Operator::Order(Order::Kill { text }));
    trial.run_for(0.5);
    assert_eq!(trial.commands("KIL").len(), 1, "{:?}", trial.notes().last());
}

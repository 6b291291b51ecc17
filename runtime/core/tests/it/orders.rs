//! What only the operator may order, by word or by a policy: cancels, abort and kill, an empty mission.

use std::time::Duration;

use backseat_core::plugin::{FaultKind, Request, RequestState};
use backseat_core::{
    Condition, FailAction, Note, Operator, Order, Owner, PluginSetup, Policy, RequestKind, Settings, Start,
};
use backseat_spi::{AckStatus, MissionCommand, Text, ToVehicle};
use backseat_units::Timestamp;

use crate::course::{good_line, interrupting, line, modify, plugin};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

fn abort() -> Order {
    Order::Abort {
        text: "leak, in BAY 2 RMB".to_owned(),
        errors: true,
    }
}

fn kill() -> Order {
    Order::Kill {
        text: "nets".to_owned(),
    }
}

fn order(trial: &mut Trial, order: Order) {
    trial.operator(Operator::Order(order));
}

/// The states of the orders of a kind, in one list.
fn states(trial: &Trial, kind: RequestKind) -> Vec<RequestState> {
    let notes = trial.notes().into_iter();
    notes
        .filter_map(|(_, note)| match note {
            Note::Request(transition) if transition.kind == kind => {
                assert_eq!(transition.owner, Owner::Operator);
                Some(transition.state)
            }
            _ => None,
        })
        .collect()
}

fn rejection(trial: &Trial, kind: RequestKind) -> String {
    match states(trial, kind).pop() {
        Some(RequestState::Rejected(text)) => text,
        other => panic!("{kind:?} was not rejected: {other:?}"),
    }
}

fn wire(command: &ToVehicle) -> String {
    let mut bytes = Vec::new();
    command.encode(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let body = text.strip_suffix("\r\n").unwrap();
    let (body, sum) = body.split_once('*').unwrap();
    let xor = body[1..].bytes().fold(0, |sum, byte| sum ^ byte);
    assert_eq!(sum, format!("{xor:02X}"));
    let mut fields: Vec<&str> = body.split(',').collect();
    assert_eq!(fields.remove(1).len(), "hhmmss.sss".len(), "{text}");
    fields.join(",")
}

fn unarmed() -> Setup {
    let setup = Setup::default();
    let start = Start {
        armed: false,
        ..setup.start
    };
    Setup { start, ..setup }
}

fn with_policies(policies: Vec<Policy>) -> Setup {
    Setup {
        settings: Settings {
            policies,
            ..Settings::default()
        },
        ..Setup::default()
    }
}

fn say_command(trial: &mut Trial, text: &str) {
    let now = trial.now;
    let message = MissionCommand {
        created: trial.vehicle.clock(now),
        text: Text::cleaned(text),
    };
    trial.vehicle.say(now, message);
    trial.run_for(0.1);
}

#[test]
fn an_abort_ends_the_lease_first_and_takes_the_helm_from_the_plugins() {
    let mut trial = Trial::steering();
    let at = trial.now;
    trial.script(1, |_| {
        (
            Duration::from_millis(1),
            Ok(vec![Request::Modify(modify(9)), good_line(8)]),
        )
    });
    order(&mut trial, abort());
    assert_eq!(trial.names_since(at), ["EMB", "ABT"]);
    trial.run_for(5.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,leak  in bay 2 rmb,1");
    assert!(trial.sent_since("RMB", at).is_empty() && trial.sent_since("RTK", at).is_empty());
    // The mission is over, and the next one is another matter.
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborted");
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn a_kill_and_a_successful_end_say_so_on_the_wire() {
    let mut trial = Trial::under_way();
    order(&mut trial, kill());
    order(
        &mut trial,
        Order::Abort {
            text: "done".to_owned(),
            errors: false,
        },
    );
    trial.run_for(1.0);
    assert_eq!(wire(&trial.commands("KIL")[0].1), "$BPKIL,nets");
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,done,0");
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_014_an_abort_needs_no_control_but_an_armed_runtime() {
    let mut trial = Trial::under_way();
    trial.operator(Operator::Hold);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.vehicle.navigates = false;
    trial.run_for(3.0);
    order(&mut trial, abort());
    trial.run_for(1.0);
    assert_eq!(trial.commands("ABT").len(), 1);

    let mut trial = Trial::with(unarmed());
    trial.run_for(2.0);
    for (made, kind) in [
        (abort(), RequestKind::Abort),
        (kill(), RequestKind::Kill),
        (Order::CancelAll, RequestKind::CancelAll),
        (Order::CancelCurrent, RequestKind::CancelCurrent),
        (Order::CancelElement, RequestKind::CancelElement),
        (
            Order::StartEmptyMission { duration_s: 60 },
            RequestKind::StartEmptyMission,
        ),
    ] {
        order(&mut trial, made);
        assert_eq!(rejection(&trial, kind), "control: the runtime is not armed");
    }
    trial.run_for(2.0);
    for name in ["ABT", "KIL", "RCA", "RCB", "RCE", "SEM"] {
        assert!(trial.commands(name).is_empty(), "{name}");
    }
}

#[test]
fn an_unanswered_abort_is_sent_five_times_each_with_its_own_stamp_and_a_refused_one_once() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    let at = trial.now;
    order(&mut trial, abort());
    order(&mut trial, abort());
    assert!(rejection(&trial, RequestKind::Abort).contains("under way already"));
    trial.run_for(20.0);
    let sent: Vec<Duration> = trial.sent("ABT").iter().map(|sent| sent.since(at)).collect();
    assert_eq!(sent, (0..5).map(Duration::from_secs).collect::<Vec<_>>());
    let mut stamps: Vec<_> = trial
        .commands("ABT")
        .iter()
        .map(|(_, command)| command.created())
        .collect();
    stamps.dedup();
    assert_eq!(stamps.len(), 5);
    assert_eq!(states(&trial, RequestKind::Abort).last(), Some(&RequestState::TimedOut));
    // Plugins stay silent all the same until they are released.
    assert!(!trial.core.has_control());
    trial.operator(Operator::Release);
    assert!(trial.core.has_control());

    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Refuse);
    order(&mut trial, abort());
    trial.run_for(10.0);
    assert_eq!(trial.commands("ABT").len(), 1);
    assert_eq!(shorts(&states(&trial, RequestKind::Abort)), ["sent", "failed"]);
    assert!(!trial.core.has_control());
}

#[test]
fn an_abort_is_not_sent_again_once_the_vehicle_shows_that_it_ends_its_mission() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    trial.vehicle.replies.insert("KIL", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborting");
    trial.run_for(0.2);
    assert_eq!(
        states(&trial, RequestKind::Abort).last(),
        Some(&RequestState::Ended("the mission is Aborting".to_owned()))
    );
    // What wraps up moves: a kill goes on until the vehicle has stopped.
    order(&mut trial, kill());
    trial.run_for(2.5);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (1, 3));
    let now = trial.now;
    trial.vehicle.set_status(now, "Stopped");
    trial.run_for(5.0);
    assert_eq!(trial.commands("KIL").len(), 3);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_kill_takes_the_place_of_an_abort_that_is_not_answered() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    order(&mut trial, kill());
    trial.run_for(10.0);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (1, 1));
    assert_eq!(shorts(&states(&trial, RequestKind::Abort)), ["sent", "timed out"]);

    // The same while nothing can be sent.
    let mut trial = Trial::under_way();
    trial.unreachable = true;
    trial.cut();
    order(&mut trial, abort());
    order(&mut trial, kill());
    trial.unreachable = false;
    trial.run_for(15.0);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (0, 1));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn an_abort_that_finds_no_link_is_kept_for_two_minutes_and_no_longer() {
    for (seconds, sent) in [(100.0, 1), (130.0, 0)] {
        let mut trial = Trial::under_way();
        trial.unreachable = true;
        trial.cut();
        order(&mut trial, abort());
        trial.run_for(seconds);
        trial.unreachable = false;
        trial.run_for(30.0);
        assert_eq!(trial.commands("ABT").len(), sent, "{seconds} s");
        assert_eq!(trial.core.open_requests(), 0);
        if sent == 0 {
            assert!(rejection(&trial, RequestKind::Abort).contains("order it again"));
        } else {
            let up = trial.names_since(trial.sent("VER").last().copied().unwrap());
            let acks = up.iter().position(|name| *name == "LOG").unwrap();
            let abort = up.iter().position(|name| *name == "ABT").unwrap();
            assert!(acks < abort && !up[..abort].contains(&"RMB"));
        }
    }
}

#[test]
fn sr_009_an_abort_whose_answer_was_lost_with_the_link_is_sent_again_when_it_is_back() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    trial.vehicle.replies.clear();
    trial.cut();
    trial.run_for(5.0);
    assert_eq!(trial.commands("ABT").len(), 2);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "unknown", "accepted", "ended"]
    );

    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    trial.unreachable = true;
    trial.cut();
    trial.run_for(200.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "unknown", "timed out"]
    );
    trial.unreachable = false;
    trial.run_for(30.0);
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn answers_twice_or_late_to_an_abort_change_nothing() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("ABT", Reply::Late(Duration::from_millis(2500), AckStatus::Failed));
    order(&mut trial, abort());
    trial.run_for(1.2);
    trial.vehicle.replies.clear();
    trial.run_for(10.0);
    // The first two were answered too late, the third in time.
    assert_eq!(trial.commands("ABT").len(), 3);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "accepted", "ended"]
    );
}

#[test]
fn a_cancel_of_all_cancels_our_inserts_that_have_not_begun_and_asks_for_the_plan() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(11), good_line(12)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.3);
    let plans = trial.commands("RMP").len();
    order(&mut trial, Order::CancelAll);
    trial.run_for(0.5);
    assert_eq!(wire(&trial.commands("RCA")[0].1), "$BPRCA");
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelAll)),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"started"));
    assert_eq!(shorts(&trial.states(12)).last(), Some(&"cancelled"));
    assert_eq!(trial.commands("RMP").len(), plans + 1);
}

#[test]
fn a_cancel_of_all_that_is_refused_not_answered_or_lost_leaves_the_inserts() {
    for (reply, end) in [(Reply::Refuse, "failed"), (Reply::Silent, "timed out")] {
        for lost in [false, true] {
            let mut trial = Trial::under_way();
            trial.ask(0, [good_line(11)]);
            trial.run_for(0.5);
            trial
                .vehicle
                .replies
                .insert("RCA", if lost { Reply::Silent } else { reply });
            order(&mut trial, Order::CancelAll);
            trial.run_for(0.5);
            if lost {
                trial.cut();
            }
            trial.run_for(4.0);
            let end = if lost { "timed out" } else { end };
            assert_eq!(shorts(&states(&trial, RequestKind::CancelAll)), ["sent", end]);
            assert_eq!(shorts(&trial.states(11)), ["sent", "accepted"]);
            assert_eq!(trial.commands("RCA").len(), 1);
        }
    }
}

#[test]
fn cancels_need_control() {
    for prepare in [
        |trial: &mut Trial| trial.operator(Operator::Hold),
        |trial: &mut Trial| trial.cut(),
        |trial: &mut Trial| trial.vehicle.navigates = false,
    ] {
        let mut trial = Trial::under_way();
        prepare(&mut trial);
        trial.unreachable = true;
        trial.run_for(3.0);
        for (made, kind) in [
            (Order::CancelAll, RequestKind::CancelAll),
            (Order::CancelCurrent, RequestKind::CancelCurrent),
            (Order::CancelElement, RequestKind::CancelElement),
        ] {
            order(&mut trial, made);
            assert!(rejection(&trial, kind).starts_with("control: "), "{kind:?}");
        }
    }
}

#[test]
fn the_current_behaviour_is_cancelled_only_where_it_is_an_insert_of_ours() {
    let mut trial = Trial::under_way();
    let attempt = |trial: &mut Trial| {
        order(trial, Order::CancelCurrent);
        trial.run_for(0.3);
        trial.commands("RCB").len()
    };
    assert_eq!(attempt(&mut trial), 0, "a planned behaviour is current");
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not known to be an insert of ours"));
    trial.ask(0, [interrupting(11)]);
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(4_000_000));
    trial.run_for(0.2);
    assert_eq!(attempt(&mut trial), 0, "another payload's");
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not ours"));
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    assert_eq!(attempt(&mut trial), 1);
    assert_eq!(wire(&trial.commands("RCB")[0].1), "$BPRCB,0");
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelCurrent)[2..]),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"started"), "its BFMBE ends it");
    let now = trial.now;
    trial.vehicle.end(now, None, Some(1));
    trial.run_for(0.2);
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"ended"));
    assert_eq!(attempt(&mut trial), 1, "it has ended");
}

#[test]
fn what_the_vehicle_flies_is_not_known_after_a_reconnect() {
    let mut trial = Trial::under_way();
    trial.ask(0, [interrupting(11)]);
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    trial.cut();
    trial.run_for(3.0);
    order(&mut trial, Order::CancelCurrent);
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not known to be an insert of ours"));
}

#[test]
fn sr_002_sr_020_the_way_from_a_cancelled_behaviour_to_what_comes_next_is_judged() {
    // The vehicle stands north of the wreck, its next insert begins south of it.
    for (next_start, clear) in [((0.0, -1400.0), false), ((900.0, -400.0), true)] {
        let mut trial = Trial::new();
        trial.vehicle.start = backseat_units::EastNorth::new(-10.0, -600.0);
        trial.run_for(2.0);
        let (east_m, north_m) = next_start;
        trial.ask(
            0,
            [
                Request::Trackline(line(11, (900.0, -500.0), (1200.0, -500.0))),
                Request::Trackline(line(12, (1200.0, -700.0), (1200.0, -1000.0))),
            ],
        );
        trial.run_for(0.3);
        trial.ask(
            0,
            [
                Request::Trackline(line(13, (east_m + 60.0, north_m), (east_m + 160.0, north_m))),
                Request::Cancel(12),
            ],
        );
        trial.run_for(0.3);
        assert_eq!(
            shorts(&trial.states(13)),
            ["sent", "accepted"],
            "{:?}",
            trial.states(13)
        );
        let now = trial.now;
        trial.vehicle.begin(now, None, Some(1));
        trial.run_for(0.2);
        order(&mut trial, Order::CancelCurrent);
        if clear {
            assert_eq!(shorts(&states(&trial, RequestKind::CancelCurrent))[0], "sent");
        } else {
            let text = rejection(&trial, RequestKind::CancelCurrent);
            assert!(text.starts_with("exclusion: inside exclusion 'wreck'"), "{text}");
            assert!(trial.commands("RCB").is_empty());
        }
    }
}

#[test]
fn a_cancel_of_the_element_is_sent_as_the_operator_says() {
    for (reply, end) in [
        (Reply::Ok, "ended"),
        (Reply::Refuse, "failed"),
        (Reply::Silent, "timed out"),
    ] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RCE", reply);
        order(&mut trial, Order::CancelElement);
        trial.run_for(4.0);
        assert_eq!(wire(&trial.commands("RCE")[0].1), "$BPRCE,0");
        assert_eq!(shorts(&states(&trial, RequestKind::CancelElement)).last(), Some(&end));
    }
}

fn ready() -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.status = "Ready";
    trial.run_for(2.0);
    trial
}

#[test]
fn an_empty_mission_starts_where_none_runs_and_ends_when_bfmis_says_running() {
    for (duration_s, said) in [
        (5400, "90,1"),
        (7200, "2,0"),
        (45, "45,2"),
        (999_999_999, "999999999,2"),
    ] {
        let mut trial = ready();
        order(&mut trial, Order::StartEmptyMission { duration_s });
        trial.run_for(1.0);
        assert_eq!(wire(&trial.commands("SEM")[0].1), format!("$BPSEM,{said}"));
        assert_eq!(
            shorts(&states(&trial, RequestKind::StartEmptyMission)),
            ["sent", "accepted"]
        );
        let now = trial.now;
        trial.vehicle.set_status(now, "Running");
        trial.run_for(2.0);
        assert_eq!(
            shorts(&states(&trial, RequestKind::StartEmptyMission)),
            ["sent", "accepted", "started", "ended"]
        );
        trial.run_for(60.0);
        assert!(trial.core.has_control());
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn an_empty_mission_that_is_refused_not_answered_not_started_or_cut_off_ends_so() {
    let ends = |reply: Option<Reply>, cut: bool, status: Option<&'static str>| {
        let mut trial = ready();
        if let Some(reply) = reply {
            trial.vehicle.replies.insert("SEM", reply);
        }
        order(&mut trial, Order::StartEmptyMission { duration_s: 60 });
        trial.run_for(0.5);
        if cut {
            if let Some(status) = status {
                trial.vehicle.status = status;
            }
            trial.cut();
        }
        trial.run_for(40.0);
        assert_eq!(trial.core.open_requests(), 0);
        assert_eq!(trial.commands("SEM").len(), 1);
        shorts(&states(&trial, RequestKind::StartEmptyMission)).split_off(1)
    };
    assert_eq!(ends(Some(Reply::Refuse), false, None), ["failed"]);
    assert_eq!(ends(Some(Reply::Silent), false, None), ["timed out"]);
    assert_eq!(ends(None, false, None), ["accepted", "timed out"]);
    assert_eq!(ends(Some(Reply::Silent), true, None), ["unknown", "timed out"]);
    assert_eq!(
        ends(Some(Reply::Silent), true, Some("Running")),
        ["unknown", "started", "ended"]
    );
    assert_eq!(ends(None, true, Some("Running")), ["accepted", "started", "ended"]);
}

#[test]
fn an_empty_mission_needs_that_none_runs_a_link_a_duration_and_no_hold() {
    let rejected = |trial: &mut Trial, duration_s| {
        order(trial, Order::StartEmptyMission { duration_s });
        rejection(trial, RequestKind::StartEmptyMission)
    };
    assert!(rejected(&mut Trial::under_way(), 60).contains("a mission is running"));
    assert!(rejected(&mut ready(), 0).contains("more than 0 s"));
    assert!(rejected(&mut Trial::new(), 60).contains("the link is down"));
    let mut held = ready();
    held.operator(Operator::Hold);
    assert!(rejected(&mut held, 60).contains("the operator holds"));
    let mut ending = ready();
    let now = ending.now;
    ending.vehicle.set_status(now, "WrappingUp");
    ending.run_for(0.5);
    assert!(rejected(&mut ending, 60).contains("a mission is ending"));
    let now = ending.now;
    ending.vehicle.set_status(now, " ");
    ending.run_for(0.5);
    assert!(rejected(&mut ending, 60).contains("has not said whether a mission runs"));
    let mut silent = Trial::new();
    silent.vehicle.replays = false;
    silent.run_for(2.0);
    assert!(rejected(&mut silent, 60).contains("has not said whether a mission runs"));
    let mut twice = ready();
    order(&mut twice, Order::StartEmptyMission { duration_s: 60 });
    assert!(rejected(&mut twice, 60).contains("being started already"));
}

#[test]
fn sr_015_hold_and_release_can_be_ordered_and_are_told_as_the_operators_acts() {
    let policies = vec![
        Policy {
            when: Condition::MissionCommand("payload hold".to_owned()),
            order: Order::Hold,
        },
        Policy {
            when: Condition::MissionCommand("payload release".to_owned()),
            order: Order::Release,
        },
    ];
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.ask(0, [Request::Modify(modify(11))]);
    trial.run_for(0.5);
    say_command(&mut trial, "payload hold ");
    assert!(!trial.core.is_steering() && !trial.core.has_control());
    // Drivers keep the hold across restarts by this.
    assert!(
        trial
            .notes()
            .iter()
            .any(|(_, note)| *note == Note::Operator { act: Operator::Hold })
    );
    say_command(&mut trial, "payload holder");
    say_command(&mut trial, "payload release");
    assert!(trial.core.has_control());
}

#[test]
fn sr_012_policies_act_in_the_order_of_the_file_on_the_exact_text() {
    let command = || Condition::MissionCommand("payload abort".to_owned());
    let policies = vec![
        Policy {
            when: command(),
            order: Order::CancelAll,
        },
        Policy {
            when: Condition::MissionCommand("payload kill".to_owned()),
            order: kill(),
        },
        Policy {
            when: command(),
            order: abort(),
        },
    ];
    let mut trial = Trial::with_under_way(with_policies(policies.clone()));
    let at = trial.now;
    for text in ["Payload abort", "payload abort now", "payload", ""] {
        say_command(&mut trial, text);
    }
    assert!(trial.names_since(at).is_empty(), "{:?}", trial.names_since(at));
    say_command(&mut trial, "payload abort");
    let names = trial.names_since(at);
    assert_eq!(names[..2], ["RCA", "ABT"], "{names:?}");
    assert!(trial.commands("KIL").is_empty());

    // Unarmed, it is told that it was not carried out.
    let setup = with_policies(policies);
    let start = Start {
        armed: false,
        ..setup.start
    };
    let mut trial = Trial::with(Setup { start, ..setup });
    trial.run_for(2.0);
    say_command(&mut trial, "payload abort");
    assert_eq!(
        rejection(&trial, RequestKind::Abort),
        "control: the runtime is not armed"
    );
    assert!(trial.commands("ABT").is_empty());
}

fn stale_policy(seconds: f64, order: Order) -> Policy {
    Policy {
        when: Condition::NavigationStaleForS(seconds),
        order,
    }
}

#[test]
fn a_policy_on_stale_navigation_acts_once_in_each_stale_time() {
    let policies = vec![stale_policy(20.0, abort()), stale_policy(5.0, Order::Hold)];
    let mut trial = Trial::with_under_way(with_policies(policies));
    let holds = |trial: &Trial| -> Vec<Timestamp> {
        let notes = trial.notes().into_iter();
        notes
            .filter(|(_, note)| *note == Note::Operator { act: Operator::Hold })
            .map(|(at, _)| at)
            .collect()
    };
    let stopped = trial.now;
    trial.vehicle.navigates = false;
    trial.run_for(15.0);
    let [held] = holds(&trial)[..] else {
        panic!("{:?}", holds(&trial))
    };
    // A second after the last sample it is stale, five seconds later the policy acts.
    let after = held.since(stopped).as_secs_f64();
    assert!((5.8..6.2).contains(&after), "{after}");
    assert!(trial.commands("ABT").is_empty());
    trial.vehicle.navigates = true;
    trial.run_for(5.0);
    trial.operator(Operator::Release);
    trial.vehicle.navigates = false;
    trial.run_for(60.0);
    assert_eq!(holds(&trial).len(), 2);
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn a_policy_on_stale_navigation_waits_for_the_first_connection_and_takes_no_nonsense_for_a_time() {
    let policies = vec![stale_policy(5.0, Order::Hold)];
    let mut trial = Trial::with(with_policies(policies));
    trial.unreachable = true;
    trial.run_for(60.0);
    let held = |trial: &Trial| {
        trial
            .notes()
            .iter()
            .any(|(_, note)| matches!(note, Note::Operator { .. }))
    };
    assert!(!held(&trial));
    trial.unreachable = false;
    trial.vehicle.navigates = false;
    trial.run_for(20.0);
    assert!(held(&trial), "connected, and no navigation");

    let nonsense = [f64::NAN, f64::INFINITY, -1.0, 1e300];
    let policies = nonsense.map(|seconds| stale_policy(seconds, Order::Hold)).to_vec();
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.vehicle.navigates = false;
    trial.run_for(60.0);
    assert!(!held(&trial));
}

#[test]
fn a_policy_on_quarantine_and_a_plugins_fail_action_abort_once() {
    let failing = PluginSetup {
        on_failure: FailAction::Abort,
        ..plugin("first")
    };
    let mut trial = Trial::with_under_way(Setup {
        plugins: vec![failing, plugin("second")],
        ..Setup::default()
    });
    trial.ask(1, [Request::Modify(modify(11))]);
    trial.run_for(0.5);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(0.5);
    assert_eq!(trial.commands("ABT").len(), 1);
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,a plugin failed,1");
    assert!(!trial.core.is_steering());

    // The vehicle wraps up: another failure, or a policy, does not abort that; the operator's own word would.
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborting");
    trial.run_for(5.0);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(0.5);
    assert_eq!(
        rejection(&trial, RequestKind::Abort),
        "state: the mission is ending already"
    );
    assert_eq!(trial.commands("ABT").len(), 1);
    order(&mut trial, abort());
    trial.run_for(0.5);
    assert_eq!(trial.commands("ABT").len(), 2);

    let policies = vec![Policy {
        when: Condition::PluginQuarantined,
        order: kill(),
    }];
    let mut trial = Trial::with_under_way(with_policies(policies));
    trial.restart_fails = Some(FaultKind::Start);
    trial.fail(0, FaultKind::Trap);
    trial.run_for(120.0);
    assert_eq!(trial.commands("KIL").len(), 1);
}

#[test]
fn the_link_of_a_cancel_is_not_the_link_of_the_next() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RCE", Reply::Silent);
    order(&mut trial, Order::CancelElement);
    trial.run_for(0.2);
    let asked = trial.commands("RCE")[0].1.created().unwrap();
    trial.cut();
    trial.run_for(5.0);
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RCE", asked, None, AckStatus::Succeeded));
    trial.run_for(1.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelElement)),
        ["sent", "timed out"]
    );
    assert_eq!(trial.commands("RCE").len(), 1);
}

#[test]
fn orders_have_tags_of_their_own() {
    let mut trial = Trial::under_way();
    order(&mut trial, Order::CancelElement);
    order(&mut trial, Order::CancelElement);
    trial.run_for(1.0);
    let mut tags: Vec<u64> = trial
        .notes()
        .into_iter()
        .filter_map(|(_, note)| match note {
            Note::Request(transition) if transition.owner == Owner::Operator => Some(transition.tag),
            _ => None,
        })
        .collect();
    tags.sort_unstable();
    tags.dedup();
    assert_eq!(tags, [1, 2]);
}

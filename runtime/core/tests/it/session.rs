use std::time::Duration;

use backseat_core::plugin::{FaultKind, Request, TopsideRequest, Transport};
use backseat_core::{Core, Grant, Input, Note, Output, Settings, StatusCondition};
use backseat_spi::{AckStatus, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::course::{self, good_line, modify};
use crate::scene::{accepted, begins};
use crate::trial::{Seen, Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

fn subscriptions(trial: &Trial, since: Timestamp) -> Vec<String> {
    let of = |(at, command)| match command {
        backseat_spi::ToVehicle::LoggingControl(logging) if at >= since => Some(logging.message.as_str().to_owned()),
        _ => None,
    };
    trial.commands("LOG").into_iter().filter_map(of).collect()
}

#[test]
fn the_version_is_sent_first_and_control_is_the_first_subscription() {
    let trial = Trial::under_way();
    let names = trial.names_since(Timestamp::ZERO);
    assert_eq!(names[..2], ["VER", "LOG"]);
    let subscribed = subscriptions(&trial, Timestamp::ZERO);
    assert_eq!(subscribed[0], "CTL");
    for message in ["ACK", "MIS", "NVG", "NVR", "MBS", "MBE", "CTD"] {
        assert!(subscribed.iter().any(|other| other == message), "{message}");
    }
}

#[test]
fn a_new_connection_renews_all_subscriptions() {
    let mut trial = Trial::under_way();
    let first = subscriptions(&trial, Timestamp::ZERO);
    let cut = trial.now;
    trial.cut();
    trial.run_for(3.0);
    assert_eq!(subscriptions(&trial, cut), first);
    assert!(trial.core.has_control());
}

#[test]
fn connections_are_retried_with_growing_pauses() {
    let mut trial = Trial::new();
    trial.unreachable = true;
    trial.run_for(120.0);
    let pauses: Vec<Duration> = trial
        .seen
        .iter()
        .filter_map(|(_, seen)| match seen {
            Seen::Connect(after) => Some(*after),
            _ => None,
        })
        .skip(1)
        .collect();
    assert!((10..60).contains(&pauses.len()), "{pauses:?}");
    assert!(pauses[0] <= Duration::from_secs(1) && pauses.iter().all(|pause| *pause <= Duration::from_secs(10)));
    let long = &pauses[5..];
    assert!(
        long.iter().all(|pause| *pause >= Duration::from_secs(5)) && long.windows(2).all(|pair| pair[0] != pair[1])
    );
    trial.unreachable = false;
    trial.run_for(20.0);
    assert!(trial.core.has_control());
}

#[test]
fn an_unanswered_subscription_is_sent_again() {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("LOG", Reply::Silent);
    trial.run_for(1.0);
    let before = subscriptions(&trial, Timestamp::ZERO).len();
    trial.run_for(2.0);
    let again = subscriptions(&trial, Timestamp::ZERO).len();
    assert!(again > before);
    trial.vehicle.replies.clear();
    trial.run_for(5.0);
    let settled = trial.now;
    trial.run_for(10.0);
    assert!(
        subscriptions(&trial, settled).is_empty(),
        "answered subscriptions are not sent again"
    );
}

#[test]
fn without_navigation_core_subscribes_again_after_5_s_and_resets_the_connection_after_15_s() {
    let mut trial = Trial::under_way();
    trial.vehicle.navigates = false;
    let silent = trial.now;
    trial.run_for(5.1);
    let anew = subscriptions(&trial, silent);
    assert!(anew.iter().any(|message| message == "NVG"), "{anew:?}");
    assert!(!trial.seen.iter().any(|(_, seen)| *seen == Seen::Reset));
    trial.run_for(10.0);
    let reset = trial
        .seen
        .iter()
        .find(|(_, seen)| *seen == Seen::Reset)
        .expect("a reset")
        .0;
    assert!((14.5..15.1).contains(&reset.since(silent).as_secs_f64()), "{reset}");
}

#[test]
fn acknowledgements_do_not_count_as_navigation() {
    let mut trial = Trial::under_way();
    trial.vehicle.navigates = false;
    let silent = trial.now;
    for _ in 0..160 {
        let stamp = trial.vehicle.clock(trial.now);
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("LOG", stamp, None, backseat_spi::AckStatus::Succeeded));
        trial.run_for(0.1);
    }
    assert!(!trial.core.has_control());
    let reset = trial
        .seen
        .iter()
        .find(|(_, seen)| *seen == Seen::Reset)
        .expect("a reset")
        .0;
    assert!(reset.since(silent) < Duration::from_millis(15_100));
}

#[test]
fn a_vehicle_that_missed_the_first_subscriptions_is_subscribed_again() {
    let mut trial = Trial::new();
    trial.vehicle.deaf_to_subscriptions = 9;
    trial.run_for(10.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_013_garbage_unknown_and_malformed_sentences_are_counted_and_harm_nothing() {
    let mut trial = Trial::steering();
    trial.hear_bytes(b"\xff\xfe\x00no sentence at all\r\n\n$BFNVG,081025.987*00\r\n");
    trial.hear_bytes(b"$BFXYZ,1,2,3*5B\r\n$BFNVG,abc*41\r\n");
    let mut many = Vec::new();
    for number in 0..15 {
        let body = format!("BFCTD,{number}");
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        many.extend_from_slice(format!("${body}*{sum:02X}\r\n").as_bytes());
    }
    trial.hear_bytes(&many);
    trial.hear_bytes(&vec![b'x'; 1_000_000]);
    trial.run_for(2.0);
    // One of them may have been a begin: the lease ends, and nothing else does.
    assert!(!trial.core.is_steering() && trial.core.has_control());
    begins(&mut trial, Some(1), None);
    accepted(&mut trial, Request::Modify(modify(2)), 2);
    let counts: Vec<u64> = trial
        .notes()
        .into_iter()
        .filter_map(|(_, note)| match note {
            Note::Malformed { count, .. } => Some(count),
            _ => None,
        })
        .collect();
    assert_eq!(counts, [1, 10]);
    trial.cut();
    let counted = trial.notes().into_iter().rev().find_map(|(_, note)| match note {
        Note::LinkDown { counts, .. } => Some(counts),
        _ => None,
    });
    assert!(counted.unwrap().noise_bytes > 1_000_000);
}

#[test]
fn sentences_may_arrive_in_pieces_of_any_size() {
    for size in [1, 7, 64] {
        let mut trial = Trial::new();
        trial.read_max = size;
        trial.run_for(2.0);
        assert!(trial.core.has_control(), "reads of {size} bytes");
    }
}

#[test]
fn a_burst_after_a_stall_of_4_s_is_read_completely() {
    let mut trial = Trial::under_way();
    trial.stalled_until = trial.now + Duration::from_secs(4);
    trial.run_for(6.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_023_a_good_status_is_sent_every_second() {
    let mut trial = Trial::under_way();
    trial.run_for(58.0);
    let statuses = trial.commands("STS");
    assert_eq!(statuses.len(), 61);
    for pair in statuses.windows(2) {
        assert_eq!(pair[1].0.since(pair[0].0), Duration::from_secs(1));
    }
    for (_, status) in statuses {
        assert!(matches!(status, backseat_spi::ToVehicle::PayloadStatus(status) if status.ok));
    }
}

#[test]
fn the_first_bytes_of_a_connection_are_those_of_the_specification() {
    let setup = Setup::default();
    let mut core = Core::new(
        setup.settings,
        course::envelope(setup.limits),
        setup.plugins,
        setup.start,
    );
    core.handle(Timestamp::from_millis(250), Input::LinkUp);
    let mut lines = String::new();
    while let Some(output) = core.poll_output() {
        if let Output::Send(bytes) = output {
            lines.push_str(std::str::from_utf8(&bytes).unwrap());
        }
    }
    let expected = "$BPVER,221320.250,1.12*56\r\n$BPLOG,CTL,ON*0C\r\n$BPLOG,ACK,ON*1E\r\n$BPLOG,MIS,ON*00\r\n";
    assert!(lines.starts_with(expected), "{lines}");
    assert!(lines.contains("$BPRMP,221320.250*68\r\n"), "{lines}");
}

#[test]
fn the_vehicles_version_is_logged() {
    let trial = Trial::under_way();
    let versions: Vec<_> = trial
        .notes()
        .into_iter()
        .filter(|(_, note)| matches!(note, Note::VehicleVersion { version } if version == "1.11"))
        .collect();
    assert_eq!(versions.len(), 1);
}

/// An acknowledgement of a BPLOG as real vehicles write it, with this name and text.
fn log_ack(trial: &mut Trial, name: &str, status: u8, text: &str) {
    let (hour, minute, second, nanos) = trial.vehicle.clock(trial.now).hms_nano();
    let millis = nanos / 1_000_000;
    let body = format!("BFACK,{hour:02}{minute:02}{second:02}.{millis:03},{name},000000.000,0,{status},0,{text}");
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    trial.hear_bytes(format!("${body}*{sum:02X}\r\n").as_bytes());
}

/// Connected to a vehicle that says nothing by itself.
fn connected() -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.navigates = false;
    trial.vehicle.replays = false;
    trial.vehicle.replies.insert("LOG", Reply::Silent);
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.run_for(0.5);
    trial
}

fn refused_subscriptions(trial: &Trial) -> Vec<String> {
    let refused = |(_, note): (Timestamp, Note)| {
        let text = note.to_string();
        let message = text.strip_prefix("the vehicle refused the subscription to ")?;
        Some(message.split(':').next()?.to_owned())
    };
    trial.notes().into_iter().filter_map(refused).collect()
}

#[test]
fn a_subscription_can_be_acknowledged_by_its_short_or_its_long_name() {
    for name in ["LOG", "BPLOG"] {
        let mut trial = connected();
        let sent = subscriptions(&trial, Timestamp::ZERO).len();
        for _ in 1..sent {
            log_ack(&mut trial, name, 2, "log set");
        }
        trial.run_for(4.0);
        assert_eq!(subscriptions(&trial, Timestamp::ZERO).len(), sent, "{name}");
    }
}

#[test]
fn a_refused_subscription_is_identified_and_sent_again_only_if_core_needs_it() {
    for (unasked, refused) in [(false, "CTD"), (true, "CTD"), (false, "MIS"), (true, "MIS")] {
        let mut trial = Trial::new();
        trial.vehicle.navigates = false;
        trial.vehicle.replays = false;
        trial.vehicle.answers_unasked = unasked;
        trial.vehicle.replies.insert("LOG", Reply::Silent);
        trial.run_for(0.5);
        let sent = subscriptions(&trial, Timestamp::ZERO);
        let answered = if unasked { &sent[..] } else { &sent[1..] };
        for message in answered {
            log_ack(&mut trial, "LOG", if message == refused { 1 } else { 2 }, "as it is");
        }
        trial.run_for(4.0);
        assert_eq!(
            refused_subscriptions(&trial),
            [format!("BF{refused}")],
            "unasked: {unasked}"
        );
        let again = &subscriptions(&trial, Timestamp::ZERO)[sent.len()..];
        assert_eq!(
            again.iter().any(|message| message == refused),
            refused == "MIS",
            "{again:?}"
        );
        assert!(refused == "MIS" || again.is_empty(), "{again:?}");
    }
}

#[test]
fn an_acknowledgement_that_names_its_subscription_counts_in_any_order() {
    let mut trial = connected();
    let mut sent = subscriptions(&trial, Timestamp::ZERO);
    sent.remove(0);
    sent.reverse();
    for message in sent {
        let status = if message == "NVR" { 1 } else { 2 };
        log_ack(&mut trial, "LOG", status, &format!("{message} logging is ON"));
    }
    trial.run_for(0.1);
    assert_eq!(refused_subscriptions(&trial), ["BFNVR"]);
}

#[test]
fn an_arriving_message_confirms_its_subscription_and_the_others_are_repeated_with_growing_pauses() {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("LOG", Reply::Silent);
    trial.run_for(120.0);
    assert!(trial.core.has_control());
    let first = trial.commands("LOG")[0].0;
    let times = |message: &str| -> Vec<u64> {
        let of = |(at, command)| match command {
            ToVehicle::LoggingControl(logging) if logging.message.as_str() == message => Some(at),
            _ => None,
        };
        let sent = trial.commands("LOG").into_iter().filter_map(of);
        sent.map(|at: Timestamp| at.since(first).as_secs()).collect()
    };
    assert_eq!(times("NVG"), [0]);
    assert_eq!(times("MIS"), [0]);
    assert_eq!(times("MBE"), [0, 2, 6, 14, 30, 62, 94]);
}

#[test]
fn a_connection_that_is_back_within_100_ms_gets_all_subscriptions() {
    let mut trial = Trial::under_way();
    let first = subscriptions(&trial, Timestamp::ZERO);
    trial.feed(Input::LinkDown);
    trial.run_for(0.08);
    let back = trial.now;
    trial.vehicle.connected(back);
    trial.feed(Input::LinkUp);
    assert_eq!(subscriptions(&trial, back), first);
}

#[test]
fn a_vehicle_that_forgets_the_subscriptions_is_subscribed_until_it_answers() {
    let mut trial = Trial::under_way();
    trial.vehicle.subscribed.clear();
    trial.vehicle.deaf_to_subscriptions = 4;
    let forgotten = trial.now;
    trial.run_for(10.0);
    assert!(trial.core.has_control());
    let again = subscriptions(&trial, forgotten);
    assert!(
        again.iter().filter(|message| *message == "ACK").count() >= 2,
        "{again:?}"
    );
}

#[test]
fn status_reports_a_failure_only_for_the_conditions_that_the_operator_listed() {
    let cases: [(Vec<StatusCondition>, bool, bool); 4] = [
        (vec![], true, true),
        (vec![StatusCondition::NavigationStale], false, true),
        (vec![StatusCondition::PluginQuarantined], true, false),
        (
            vec![StatusCondition::NavigationStale, StatusCondition::PluginQuarantined],
            false,
            false,
        ),
    ];
    let last_ok = |trial: &Trial| match trial.commands("STS").pop() {
        Some((_, ToVehicle::PayloadStatus(status))) => status.ok,
        other => panic!("{other:?}"),
    };
    for (listed, ok_when_stale, ok_when_quarantined) in cases {
        let setup = || Setup {
            settings: Settings {
                status_failed_when: listed.clone(),
                ..Settings::default()
            },
            ..Setup::default()
        };
        let mut trial = Trial::with_under_way(setup());
        trial.run_for(10.0);
        assert!(last_ok(&trial), "{listed:?}: all is well");
        trial.vehicle.navigates = false;
        trial.run_for(10.0);
        assert_eq!(last_ok(&trial), ok_when_stale, "{listed:?}: stale");
        let mut trial = Trial::with_under_way(setup());
        trial.restart_fails = Some(FaultKind::Start);
        trial.fail(1, FaultKind::Trap);
        trial.run_for(120.0);
        assert_eq!(last_ok(&trial), ok_when_quarantined, "{listed:?}: quarantined");
    }
}

#[test]
fn sr_009_a_late_answer_changes_nothing_and_confirms_no_later_command() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RMB", Reply::Late(Duration::from_millis(2500), AckStatus::Succeeded));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.15);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    // This is the pause after a BPRMB without an answer.
    trial.run_for(1.0);
    trial.vehicle.replies.insert("RMB", Reply::Silent);
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(0.9);
    assert_eq!(
        shorts(&trial.states(2)),
        ["sent"],
        "the answer to the first came meanwhile"
    );
    trial.run_for(1.0);
    assert_eq!(shorts(&trial.states(2)), ["sent", "timed out"]);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
}

#[test]
fn an_answer_without_a_name_belongs_to_the_oldest_command() {
    let mut trial = Trial::with_under_way(granted(&[Grant::Topside], &[]));
    trial.vehicle.replies.insert("TOP", Reply::Silent);
    let topside = |tag| {
        Request::Topside(TopsideRequest {
            tag,
            slowest: Transport::AcousticModem,
            text: "here".to_owned(),
        })
    };
    trial.ask(0, [topside(1), topside(2)]);
    trial.run_for(0.3);
    let now = trial.now;
    let nak = ("NAK", TimeOfDay::MIDNIGHT, None, AckStatus::Invalid);
    trial.vehicle.acknowledge(now, nak);
    trial.run_for(0.1);
    assert_eq!(shorts(&trial.states(1)), ["sent", "failed"]);
    assert_eq!(shorts(&trial.states(2)), ["sent"]);
}

#[test]
fn an_answer_belongs_to_the_behavior_that_it_names() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [good_line(1), good_line(2)]);
    trial.run_for(0.3);
    let sent = trial.commands("RTK");
    let stamps: Vec<_> = sent.iter().map(|(_, command)| command.created().unwrap()).collect();
    assert_ne!(stamps[0], stamps[1], "no two commands of one name have the same time");
    let now = trial.now;
    // The time of the first with the identifier of the second names neither.
    trial
        .vehicle
        .acknowledge(now, ("RTK", stamps[0], Some(2), AckStatus::Failed));
    trial
        .vehicle
        .acknowledge(now, ("RTK", stamps[1], Some(2), AckStatus::Pending));
    trial
        .vehicle
        .acknowledge(now, ("RTK", stamps[1], Some(2), AckStatus::Pending));
    trial
        .vehicle
        .acknowledge(now, ("RTK", stamps[1], Some(2), AckStatus::Succeeded));
    trial
        .vehicle
        .acknowledge(now, ("RTK", stamps[1], Some(2), AckStatus::Failed));
    trial.run_for(0.1);
    assert_eq!(shorts(&trial.states(1)), ["sent"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "pending", "accepted"]);
}

#[test]
fn control_that_changes_ten_times_a_second_takes_effect_each_time_and_does_not_fill_the_log() {
    let mut trial = Trial::under_way();
    let begun = trial.now;
    for turn in 0..600 {
        let granted = turn % 2 == 1;
        let now = trial.now;
        trial.vehicle.set_control(now, granted);
        trial.run_for(0.05);
        assert_eq!(trial.core.has_control(), granted);
        trial.run_for(0.05);
    }
    let told = |trial: &Trial| -> Vec<bool> {
        let control = |(at, note): (Timestamp, Note)| match note {
            Note::Control { granted, .. } if at >= begun => Some(granted),
            _ => None,
        };
        trial.notes().into_iter().filter_map(control).collect()
    };
    assert!((8..40).contains(&told(&trial).len()), "{} notes", told(&trial).len());
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(11.0);
    assert_eq!(
        told(&trial).last(),
        Some(&false),
        "the log has the current state within ten seconds"
    );
    let more = trial
        .notes()
        .into_iter()
        .filter(|(_, note)| note.to_string().contains("more times"));
    assert!(more.count() >= 3);
}

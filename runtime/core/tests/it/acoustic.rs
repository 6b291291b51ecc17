use std::time::Duration;

use backseat_core::plugin::Failure;
use backseat_core::plugin::{Ended, FrameOutcome};
use backseat_core::plugin::{
    Event, FaultKind, PacketRequest, ReceivedFrame, Request, RequestState, SilentRequest, Topic, Window,
};
use backseat_core::{Grant, Identifiers, Limits, Operator, Start};
use backseat_spi::{
    AckStatus, FrameReceivedStatus, FrameSentStatus, FromVehicle, MediumAccess, PacketReceived, PacketSent,
    ReceivedFrame as Slot, Text, ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::course::{good_line, limits};
use crate::trial::{Setup, Trial, granted, last_written, short, shorts};
use crate::vehicle::Reply;

fn packet(tag: u64, frames: &[&[u8]]) -> Request {
    Request::Packet(PacketRequest {
        tag,
        destination: 3,
        mode: 1,
        acknowledge: true,
        frames: frames.iter().map(|frame| frame.to_vec()).collect(),
    })
}

fn small(tag: u64) -> Request {
    packet(tag, &[b"Hello", &[0, 255]])
}

fn setup() -> Setup {
    granted(&[Grant::Acoustic, Grant::Silent], &[Topic::Acoustic])
}

fn window(trial: &Trial, seconds: f64) -> MediumAccess {
    let at = |seconds| trial.vehicle.clock(trial.now + Duration::from_secs_f64(seconds));
    MediumAccess {
        created: at(0.0),
        until: at(seconds),
        address: 7,
        device: Text::cleaned("WHOIPSK"),
    }
}

fn open_window(trial: &mut Trial, seconds: f64) {
    let window = window(trial, seconds);
    trial.vehicle.say(trial.now, window);
    trial.run_for(0.1);
}

/// A trial inside an acoustic window of ten minutes.
fn in_window() -> Trial {
    let mut trial = Trial::with_under_way(setup());
    open_window(&mut trial, 600.0);
    trial
}

/// The vehicle reports with a BFCPS on the packet with the identifier `request`.
fn report(trial: &mut Trial, request: u32, statuses: &[FrameSentStatus]) {
    let mut all = [FrameSentStatus::Unset; 8];
    all[..statuses.len()].copy_from_slice(statuses);
    let message = PacketSent {
        created: trial.vehicle.clock(trial.now),
        sent: trial.vehicle.clock(trial.now),
        request,
        frames: u32::try_from(statuses.len()).unwrap(),
        statuses: all,
    };
    trial.vehicle.say(trial.now, message);
    trial.run_for(0.1);
}

/// Core hears a sentence that its own table of messages would not write.
fn hear_line(trial: &mut Trial, body: &str) {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    trial.hear_bytes(format!("${body}*{sum:02X}\r\n").as_bytes());
}

fn windows(trial: &Trial) -> Vec<Window> {
    let of = |event| match event {
        Event::Window(window) => Some(window),
        _ => None,
    };
    trial.events(0).into_iter().filter_map(of).collect()
}

const ACKED: &[FrameSentStatus] = &[FrameSentStatus::Acked, FrameSentStatus::Unacknowledged];
fn acked_once() -> RequestState {
    RequestState::Ended(Ended::Frames(vec![FrameOutcome::Acked, FrameOutcome::Unacknowledged]))
}

#[test]
fn a_packet_is_sent_in_its_window_and_ends_with_its_report() {
    for (reply, states) in [
        (Reply::Ok, vec!["sent", "accepted", "ended"]),
        (
            Reply::Pending(Duration::from_millis(500), AckStatus::Succeeded),
            vec!["sent", "pending", "accepted", "ended"],
        ),
    ] {
        let mut trial = in_window();
        trial.vehicle.replies.insert("CPD", reply);
        trial.ask(0, [small(1)]);
        trial.run_for(10.0);
        let fields = ["1", "3", "1", "1", "2", "48656C6C6F", "00FF", "", "", "", "", "", ""];
        assert_eq!(last_written(&trial, "BPCPD"), fields);
        assert_eq!(trial.core.open_requests(), 1);
        report(&mut trial, 1, ACKED);
        assert_eq!(shorts(&trial.states(1)), states);
        assert_eq!(trial.states(1).last(), Some(&acked_once()));
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_a_refused_packet_fails_and_a_later_report_changes_nothing() {
    for reply in [
        Reply::Refuse,
        Reply::Nak,
        Reply::Pending(Duration::from_millis(500), AckStatus::Failed),
    ] {
        let mut trial = in_window();
        trial.vehicle.replies.insert("CPD", reply);
        trial.ask(0, [small(1)]);
        trial.run_for(2.0);
        report(&mut trial, 1, ACKED);
        trial.run_for(60.0);
        assert_eq!(
            trial.states(1).last(),
            Some(&RequestState::Failed(Failure::Vehicle("as told".to_owned())))
        );
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_an_unacknowledged_packet_ends_with_its_report_or_after_a_minute() {
    for reply in [Reply::Silent, Reply::PendingForEver] {
        for reported in [true, false] {
            let mut trial = in_window();
            trial.vehicle.replies.insert("CPD", reply);
            trial.ask(0, [small(1)]);
            trial.run_for(20.0);
            if reported {
                report(&mut trial, 1, ACKED);
                assert_eq!(trial.states(1).last(), Some(&acked_once()));
            }
            let sent = trial.sent("CPD")[0];
            trial.run_for(sent.as_secs_f64() + 60.0 - trial.now.as_secs_f64() - 0.01);
            assert_eq!(trial.core.open_requests(), usize::from(!reported));
            trial.run_for(0.02);
            assert_eq!(trial.core.open_requests(), 0);
            report(&mut trial, 1, ACKED);
            let end = if reported { "ended" } else { "timed out" };
            assert_eq!(shorts(&trial.states(1)).last(), Some(&end));
        }
    }
}

#[test]
fn sr_009_an_accepted_packet_without_a_report_times_out() {
    let mut trial = in_window();
    trial.ask(0, [small(1)]);
    trial.run_for(70.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "timed out"]);
}

#[test]
fn sr_009_a_packet_in_doubt_after_a_link_loss_ends_with_its_report_or_after_a_minute() {
    for (reply, doubt) in [(Reply::Silent, "unknown"), (Reply::Ok, "accepted")] {
        for reported in [true, false] {
            let mut trial = in_window();
            trial.vehicle.replies.insert("CPD", reply);
            trial.ask(0, [small(1)]);
            trial.run_for(0.5);
            trial.cut();
            assert_eq!(shorts(&trial.states(1)).last(), Some(&doubt));
            trial.run_for(20.0);
            if reported {
                report(&mut trial, 1, ACKED);
            }
            trial.run_for(41.0);
            let end = if reported { "ended" } else { "timed out" };
            assert_eq!(shorts(&trial.states(1))[1..], [doubt, end]);
            assert_eq!(trial.sent("CPD").len(), 1, "the packet is never sent twice");
            assert_eq!(trial.core.open_requests(), 0);
        }
    }
}

#[test]
fn sr_016_no_packet_leaves_outside_a_window() {
    let mut trial = Trial::with_under_way(setup());
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).starts_with("window: "));
    open_window(&mut trial, 10.0);
    let end = windows(&trial)[0].until;
    // The plugin asks in every step, and the limit of packets a minute is too high to stop it.
    let limits = Limits {
        packets_per_min: 1000,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup { limits, ..setup() });
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![small(2)])));
    trial.run_for(1.0);
    let from = trial.now;
    open_window(&mut trial, 10.0);
    trial.run_for(20.0);
    let sent = trial.sent("CPD");
    assert!(sent.len() > 50, "{}", sent.len());
    assert!(sent[0] >= from);
    // Even with the longest allowed link delay, each packet arrives before the window ends.
    let last = *sent.last().unwrap() + Duration::from_secs(1);
    assert!(last < from + Duration::from_secs(10), "{last} {end}");
    assert!(trial.rejection(2).starts_with("window: "));
}

#[test]
fn sr_016_a_window_runs_on_the_vehicles_clock_from_its_creation_even_across_midnight() {
    let mut trial = Trial::with(setup());
    // The trial starts at 22:13:20; after 5 s it is five seconds to midnight on the vehicle's clock.
    trial.vehicle.clock_nanos = (106 * 60 + 40 - 10) * 1_000_000_000;
    trial.run_for(5.0);
    assert_eq!(trial.vehicle.clock(trial.now).hms_nano(), (23, 59, 55, 0));
    let said = trial.now;
    let late = window(&trial, 30.0);
    trial.run_for(4.0);
    trial.hear_now([late.into()]);
    trial.run_for(0.3);
    let until = windows(&trial)[0].until;
    let true_end = said + Duration::from_secs(30);
    let off = true_end.as_nanos().abs_diff(until.as_nanos());
    assert!(off < 10_000_000, "{until} for {true_end}");
    assert_eq!(
        (windows(&trial)[0].address, windows(&trial)[0].device.as_str()),
        (7, "WHOIPSK")
    );
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert_eq!(short(&trial.states(1)[0]), "sent");
    trial.run_for(23.5);
    trial.ask(0, [small(2)]);
    trial.run_for(0.3);
    assert!(trial.rejection(2).starts_with("window: "));
}

#[test]
fn sr_016_an_unusable_window_closes_the_old_one_and_the_newest_window_counts() {
    let nonsense = [-5.0, 0.0, 3601.0, 40_000.0, 1.5];
    for seconds in nonsense {
        let mut trial = in_window();
        let mut bad = window(&trial, 0.0);
        let nanos = (seconds * 1e9) as i64;
        let day = 86_400_000_000_000;
        let until = (i64::try_from(bad.created.as_nanos()).unwrap() + nanos).rem_euclid(day);
        bad.until = TimeOfDay::from_nanos(u64::try_from(until).unwrap()).unwrap();
        trial.hear_now([bad.into()]);
        trial.ask(0, [small(1)]);
        trial.run_for(0.3);
        assert!(trial.rejection(1).starts_with("window: "), "{seconds}");
        assert_eq!(windows(&trial).len(), 1, "{seconds}: no event");
        let noted = format!("{:?}", trial.notes());
        assert!(noted.contains("an acoustic window until"), "{seconds}");
    }
    let mut trial = in_window();
    open_window(&mut trial, 10.0);
    trial.run_for(9.0);
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert!(
        trial.rejection(1).starts_with("window: "),
        "the newest window is shorter, and counts"
    );
}

#[test]
fn sr_016_a_window_read_late_counts_as_old_as_the_pause_in_reading() {
    let mut trial = Trial::with_under_way(setup());
    trial.run_for(1.0);
    trial.asleep_until = trial.now + Duration::from_secs(18);
    trial.run_for(1.0);
    // The vehicle's clock is ahead for a while, so that its messages look newer than they are.
    trial.vehicle.clock_nanos += 30_000_000_000;
    trial.run_for(1.0);
    let said = window(&trial, 30.0);
    let true_end = trial.now + Duration::from_secs(30);
    let now = trial.now;
    trial.vehicle.say(now, said);
    trial.run_for(1.0);
    trial.vehicle.clock_nanos -= 30_000_000_000;
    trial.run_for(20.0);
    let until = windows(&trial)[0].until;
    assert!(until <= true_end, "{until} for {true_end}");
}

#[test]
fn sr_016_a_window_closes_with_the_link() {
    let mut trial = in_window();
    trial.cut();
    trial.run_for(5.0);
    assert!(trial.core.has_control());
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).starts_with("window: "));
    open_window(&mut trial, 100.0);
    trial.ask(0, [small(2)]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
}

#[test]
fn sr_016_a_packet_needs_the_subscription_to_its_report() {
    let mut trial = Trial::with(setup());
    trial.vehicle.replies.insert("LOG", Reply::Refuse);
    trial.run_for(2.0);
    open_window(&mut trial, 100.0);
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert!(
        trial.rejection(1).contains("the subscription to BFCPS"),
        "{}",
        trial.rejection(1)
    );
}

#[test]
fn an_invalid_packet_is_rejected_and_uses_no_identifier() {
    let mut trial = in_window();
    let whole: &[u8] = &[7; 256];
    let bad = [
        (packet(1, &[]), "0 frames"),
        (packet(2, &[b"a".as_slice(); 9]), "9 frames"),
        (packet(3, &[b"a".as_slice(), b""]), "frame 1 is empty"),
        (packet(4, &[&[1; 5000]]), "size of a packet's frames is 5000"),
        (
            packet(5, &[whole, whole, whole, whole, whole, whole, whole, &[7; 384]]),
            "BPCPD",
        ),
        (
            Request::Packet(PacketRequest {
                tag: 6,
                destination: 3,
                mode: -1,
                acknowledge: false,
                frames: vec![vec![1]],
            }),
            "telemetry mode is -1",
        ),
    ];
    for (tag, (request, why)) in (1..).zip(bad) {
        trial.ask(0, [request]);
        trial.run_for(0.2);
        let reason = trial.rejection(tag);
        assert!(reason.contains(why), "{reason}");
    }
    trial.ask(0, [packet(10, &[whole; 8])]);
    trial.run_for(0.2);
    assert_eq!(last_written(&trial, "BPCPD")[0], "1");
    assert_eq!(trial.sent("CPD").len(), 1);
}

#[test]
fn packets_and_inserts_share_identifiers_which_are_reserved_on_disk_first() {
    let mut trial = in_window();
    trial.ask(0, [good_line(1), small(2), good_line(3), small(4)]);
    trial.run_for(0.5);
    let of = |(_, command): (Timestamp, ToVehicle)| match command {
        ToVehicle::Packet(packet) => packet.request,
        ToVehicle::Trackline(line) => line.identifier.get(),
        other => panic!("{other:?}"),
    };
    let numbers = |name| -> Vec<u32> { trial.commands(name).into_iter().map(of).collect() };
    assert_eq!((numbers("RTK"), numbers("CPD")), (vec![1, 3], vec![2, 4]));

    let lost = Start {
        identifiers: None,
        ..Setup::default().start
    };
    let later = Start {
        identifiers: Some(Identifiers {
            next: 70,
            reserved: 80,
            first: 70,
            ..Identifiers::default()
        }),
        ..Setup::default().start
    };
    for (start, first) in [(lost, None), (later, Some(70))] {
        let mut trial = Trial::with_under_way(Setup { start, ..setup() });
        open_window(&mut trial, 100.0);
        trial.ask(0, [small(1)]);
        trial.run_for(0.3);
        match first {
            None => assert!(trial.rejection(1).starts_with("identifier: ")),
            Some(first) => assert_eq!(last_written(&trial, "BPCPD")[0], first.to_string()),
        }
    }
}

#[test]
fn sr_019_the_number_of_packets_a_minute_is_capped() {
    let mut trial = in_window();
    for plugin in 0..2 {
        trial.script(plugin, |_| (Duration::from_millis(1), Ok(vec![small(1)])));
    }
    trial.run_for(130.0);
    let sent = trial.sent("CPD");
    assert_eq!(sent.len(), 36);
    let spans = sent.windows(13).map(|some| some[12].since(some[0]));
    assert!(spans.min() >= Some(Duration::from_secs(60)));
    assert!(trial.rejection(1).starts_with("rate: "));
}

#[test]
fn unrelated_and_repeated_reports_change_nothing_and_early_ones_count() {
    let mut trial = in_window();
    trial
        .vehicle
        .replies
        .insert("CPD", Reply::Late(Duration::from_millis(900), AckStatus::Failed));
    trial.ask(0, [small(1), small(2)]);
    trial.run_for(0.3);
    report(&mut trial, 77, ACKED);
    assert_eq!(trial.core.open_requests(), 2, "the report is on another packet");
    report(&mut trial, 2, ACKED);
    report(&mut trial, 2, &[FrameSentStatus::FailedToSend]);
    trial.run_for(3.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "failed"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "ended"]);
    assert_eq!(trial.states(2)[1], acked_once());
}

#[test]
fn the_outcome_lists_the_status_of_each_frame() {
    use FrameSentStatus as S;
    let texts: [(&[S], &str); 4] = [
        (&[S::Acked], "1 frame: acked"),
        (&[], "no frame was sent"),
        (
            &[S::FailedToSend; 8],
            "8 frames, 8 not sent: failed to send, failed to send",
        ),
        (
            &[S::FailedToSend, S::Unset, S::Other(9)],
            "3 frames, 1 not sent: failed to send, unset, status 9",
        ),
    ];
    for (statuses, text) in texts {
        let mut trial = in_window();
        trial.ask(0, [small(1)]);
        trial.run_for(0.3);
        if statuses.is_empty() {
            // The table of messages never writes this form, but core reads it.
            hear_line(&mut trial, "BFCPS,221322.000,221322.000,1,0,0,0,0,0,0,0,0,0");
        } else {
            report(&mut trial, 1, statuses);
        }
        match trial.states(1).last() {
            Some(RequestState::Ended(said)) => assert!(said.to_string().starts_with(text), "{said}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_sent_packet_gets_its_outcome_even_if_control_or_its_plugin_is_lost() {
    type Act = fn(&mut Trial);
    let acts: [Act; 4] = [
        |trial| trial.operator(Operator::Hold),
        |trial| trial.fail(0, FaultKind::Trap),
        |trial| trial.fail(0, FaultKind::Error),
        |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        },
    ];
    for (number, act) in acts.into_iter().enumerate() {
        let mut trial = in_window();
        trial.ask(0, [small(1)]);
        trial.run_for(0.3);
        act(&mut trial);
        trial.run_for(1.0);
        trial.ask(1, [small(2)]);
        trial.run_for(0.3);
        let control = matches!(number, 1 | 2);
        assert_eq!(trial.sent("CPD").len(), if control { 2 } else { 1 });
        report(&mut trial, 1, ACKED);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
    }
}

#[test]
fn no_packet_is_sent_while_a_plugin_keeps_the_vehicle_silent() {
    let mut trial = in_window();
    let reply = Reply::Pending(Duration::from_millis(500), AckStatus::Succeeded);
    trial.vehicle.replies.insert("SIL", reply);
    let silent = |silent| Request::Silent(SilentRequest { tag: 1, silent });
    trial.ask(0, [silent(true)]);
    trial.run_for(1.0);
    trial.ask(1, [small(2)]);
    trial.run_for(0.3);
    assert!(trial.rejection(2).starts_with("state: the vehicle is in silent mode"));
    trial.ask(0, [silent(false)]);
    trial.run_for(1.0);
    trial.ask(1, [small(3)]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"]);
}

#[test]
fn subscribed_plugins_receive_packets_with_the_announced_number_of_frames() {
    let mut setup = setup();
    setup.plugins[1].description.topics.clear();
    let mut trial = Trial::with_under_way(setup);
    let slot = |status, data: &[u8]| Slot {
        status,
        data: data.into(),
    };
    let mut data: [Slot; 8] = Default::default();
    data[0] = slot(FrameReceivedStatus::Good, b"ab");
    data[1] = slot(FrameReceivedStatus::Corrupted, b"x");
    data[3] = slot(FrameReceivedStatus::Good, b"beyond");
    let now = trial.now;
    let message = PacketReceived {
        created: trial.vehicle.clock(now),
        arrived: trial.vehicle.clock(now - Duration::from_millis(700)),
        source: 3,
        destination: 9,
        mode: -1,
        frames: 3,
        data,
    };
    trial.hear_now([FromVehicle::from(message)]);
    // No frame at all, nine frames, and a list of frames that ends in the middle.
    hear_line(&mut trial, "BFCPR,221322.000,221322.000,3,7,4,0");
    hear_line(&mut trial, "BFCPR,221322.000,221322.000,3,7,4,9,1,AA");
    hear_line(&mut trial, "BFCPR,221322.000,221322.000,3,7,4,2,1,AA");
    trial.run_for(0.3);
    let packets: Vec<_> = trial
        .events(0)
        .into_iter()
        .filter_map(|event| match event {
            Event::Packet(packet) => Some(packet),
            _ => None,
        })
        .collect();
    let frame = |good, data: &[u8]| ReceivedFrame {
        good,
        data: data.to_vec(),
    };
    assert_eq!(packets.len(), 3, "core drops the packet of nine frames");
    let first = &packets[0];
    assert_eq!((first.source, first.destination, first.mode), (3, 9, None));
    assert_eq!(
        first.frames,
        [frame(true, b"ab"), frame(false, b"x"), frame(false, b"")]
    );
    let ago = now.since(first.arrived);
    assert!(
        ago.abs_diff(Duration::from_millis(700)) < Duration::from_millis(20),
        "{ago:?}"
    );
    assert!(packets[1].frames.is_empty() && packets[1].mode == Some(4));
    assert_eq!(packets[2].frames, [frame(true, &[0xaa]), frame(false, b"")]);
    assert!(!trial.events(1).iter().any(|event| matches!(event, Event::Packet(_))));
}

#[test]
fn sr_001_a_packet_needs_the_grant() {
    let mut trial = Trial::with_under_way(granted(&[], &[Topic::Acoustic]));
    open_window(&mut trial, 100.0);
    trial.ask(0, [small(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(1).contains("does not grant `acoustic`"));
    assert_eq!(windows(&trial).len(), 1, "it may still listen without the grant");
}

#[test]
fn sr_016_the_windows_end_moves_nearer_when_the_vehicles_clock_is_found_to_be_ahead() {
    let mut trial = Trial::with(setup());
    trial.vehicle.clock_nanos -= 6_000_000_000;
    trial.run_for(3.0);
    open_window(&mut trial, 20.0);
    // As if late messages had made the vehicle's clock look behind until now.
    trial.vehicle.clock_nanos += 6_000_000_000;
    // Navigation has to be steady again.
    trial.run_for(11.5);
    trial.ask(0, [small(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1))[..1], ["sent"], "{:?}", trial.states(1));
    trial.run_for(5.0);
    trial.ask(0, [small(2)]);
    trial.run_for(0.5);
    assert!(trial.rejection(2).starts_with("window: "), "{:?}", trial.states(2));
}

use std::time::Duration;

use backseat_core::Note;
use backseat_units::Timestamp;

use crate::trial::{Seen, Trial};
use crate::vehicle::Reply;

fn subscriptions(trial: &Trial, since: Timestamp) -> Vec<String> {
    let of = |(at, command)| match command {
        backseat_spi::ToVehicle::LoggingControl(logging) if at >= since => Some(logging.message.as_str().to_owned()),
        _ => None,
    };
    trial.commands("LOG").into_iter().filter_map(of).collect()
}

#[test]
fn the_version_is_said_first_and_control_is_subscribed_before_all_else() {
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
fn everything_is_subscribed_anew_on_a_new_connection() {
    let mut trial = Trial::under_way();
    let first = subscriptions(&trial, Timestamp::ZERO);
    let cut = trial.now;
    trial.cut();
    trial.run_for(3.0);
    assert_eq!(subscriptions(&trial, cut), first);
    assert!(trial.core.has_control());
}

#[test]
fn connections_are_tried_again_with_growing_pauses() {
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
    assert!(pauses[0] <= Duration::from_secs(1) && pauses.iter().all(|pause| *pause <= Duration::from_secs(15)));
    trial.unreachable = false;
    trial.run_for(20.0);
    assert!(trial.core.has_control());
}

#[test]
fn a_subscription_without_answer_is_sent_again() {
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
        "answered ones are left alone"
    );
}

#[test]
fn without_navigation_it_subscribes_anew_after_5_s_and_resets_the_connection_after_15_s() {
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
fn acknowledgements_are_no_navigation() {
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
fn a_vehicle_that_was_deaf_to_us_is_heard_after_a_while() {
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
        let body = format!("BFCTL,{number}");
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        many.extend_from_slice(format!("${body}*{sum:02X}\r\n").as_bytes());
    }
    trial.hear_bytes(&many);
    trial.hear_bytes(&vec![b'x'; 1_000_000]);
    trial.run_for(2.0);
    assert!(trial.core.is_steering() && trial.core.has_control());
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
fn sentences_come_in_any_split() {
    for size in [1, 7, 64] {
        let mut trial = Trial::new();
        trial.read_max = size;
        trial.run_for(2.0);
        assert!(trial.core.has_control(), "reads of {size} bytes");
    }
}

#[test]
fn a_burst_of_half_a_minute_in_one_read_is_read_whole() {
    let mut trial = Trial::under_way();
    trial.stalled_until = trial.now + Duration::from_secs(4);
    trial.run_for(6.0);
    assert!(trial.core.has_control());
}

#[test]
fn status_goes_out_every_ten_seconds_and_is_good() {
    let mut trial = Trial::under_way();
    trial.run_for(58.0);
    let statuses = trial.commands("STS");
    assert_eq!(statuses.len(), 6, "{statuses:?}");
    for pair in statuses.windows(2) {
        assert_eq!(pair[1].0.since(pair[0].0), Duration::from_secs(10));
    }
    for (_, status) in statuses {
        assert!(matches!(status, backseat_spi::ToVehicle::PayloadStatus(status) if status.ok));
    }
}

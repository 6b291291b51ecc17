//! Logs that were changed after they were written.

use backseat_recorder::Message;
use backseat_replay::{Configs, Difference, Refused, Report};
use backseat_test_support::mission;

use crate::flight::{Flight, Log, unchanged};

fn log() -> Log {
    Flight::of(mission("isobath")).seconds(300).log()
}

/// Replays a log of which the first message for which `pick` holds was changed.
fn replay_changed(log: &Log, pick: impl Fn(&Message) -> bool, change: impl Fn(&mut Message)) -> (Report, u32) {
    let mut changed = None;
    let report = log.replay_with(Vec::new(), Configs::default(), &mut |mut message| {
        if changed.is_none() && pick(&message) {
            change(&mut message);
            changed = Some(message.sequence);
        }
        vec![message]
    });
    (report.unwrap(), changed.unwrap())
}

#[test]
fn a_byte_of_an_output_that_was_changed_is_the_first_difference() {
    let log = log();
    for topic in [
        "/link/to_vehicle",
        "/core/output",
        "/notes",
        "/requests",
        "/control",
        "/measures/isobath/slope",
    ] {
        let late = |message: &Message| *message.topic == *topic && message.now.as_secs_f64() > 40.0;
        let (report, sequence) = replay_changed(&log, late, |message| {
            // A digit, so that it stays JSON, or else any byte.
            let place = message.data.iter().rposition(u8::is_ascii_digit);
            let byte = &mut message.data[place.unwrap_or(2)];
            *byte = if *byte == b'1' { b'2' } else { b'1' };
        });
        assert_eq!(report.identical, Some(false), "{topic}");
        assert_eq!(report.outputs_different, 1, "{topic}");
        let Some(Difference::Output(first)) = &report.first_difference else {
            panic!("{topic}: {:#?}", report.first_difference);
        };
        assert_eq!((first.message, first.channel.as_str()), (Some(sequence), topic));
        assert_ne!(first.recorded, first.replayed);
        assert!(!first.changes.is_empty(), "{first:?}");
        assert!(report.plugins.iter().all(|plugin| plugin.different == 0));
    }
}

#[test]
fn what_a_plugin_returned_is_compared_with_what_it_returns() {
    let returned =
        |message: &Message| message.data.starts_with(br#"{"input":"returned""#) && message.now.as_secs_f64() > 100.0;
    let (report, sequence) = replay_changed(&log(), returned, |message| {
        let text = String::from_utf8(message.data.clone()).unwrap();
        let (before, after) = text.split_once(r#""fuel":"#).unwrap();
        message.data = format!(r#"{before}"fuel":1{after}"#).into_bytes();
    });
    let Some(Difference::Step(first)) = &report.first_difference else {
        panic!("{:#?}", report.first_difference);
    };
    assert_eq!((first.message, first.plugin.as_str()), (sequence, "isobath"));
    assert_eq!(first.differs, ["fuel"]);
    assert!(
        first.input.contains("depth") && first.input.contains("control"),
        "{}",
        first.input
    );
    assert_eq!(report.identical, Some(false));
}

#[test]
fn an_output_that_is_missing_or_too_many_is_a_difference() {
    let log = log();
    // Sequence numbers stay whole, as if another program had written the log.
    let mut dropped = 0;
    let report = log
        .replay_with(Vec::new(), Configs::default(), &mut |mut message| {
            message.sequence -= dropped;
            if dropped == 0 && *message.topic == *"/link/to_vehicle" && message.now.as_secs_f64() > 60.0 {
                dropped = 1;
                return Vec::new();
            }
            vec![message]
        })
        .unwrap();
    let Some(Difference::Output(first)) = &report.first_difference else {
        panic!("{:#?}", report.first_difference);
    };
    assert!(first.replayed.is_some(), "{first:?}");

    let mut added = 0;
    let report = log
        .replay_with(Vec::new(), Configs::default(), &mut |mut message| {
            message.sequence += added;
            if added == 0 && *message.topic == *"/link/to_vehicle" && message.now.as_secs_f64() > 60.0 {
                added = 1;
                let mut twice = message.clone();
                twice.sequence += 1;
                return vec![message, twice];
            }
            vec![message]
        })
        .unwrap();
    let Some(Difference::Output(first)) = &report.first_difference else {
        panic!("{:#?}", report.first_difference);
    };
    assert!(first.recorded.is_some(), "{first:?}");
}

#[test]
fn messages_that_are_missing_end_a_replay_and_are_named() {
    let mut kept = 0;
    let report = log()
        .replay_with(Vec::new(), Configs::default(), &mut |message| {
            kept += 1;
            if (2000..2010).contains(&message.sequence) {
                return Vec::new();
            }
            vec![message]
        })
        .unwrap();
    assert!(
        matches!(
            report.refused,
            Some(Refused::Missing {
                from: 2000,
                until: 2010,
                ..
            })
        ),
        "{:?}",
        report.refused
    );
    assert_eq!(report.identical, None);
    assert!(kept < 2100, "nothing after it is read");
    assert!(
        report
            .refused
            .unwrap()
            .line()
            .starts_with("messages 2000 to 2009 are missing at ")
    );
}

#[test]
fn a_gap_ends_a_replay_and_says_where() {
    let report = log()
        .replay_with(Vec::new(), Configs::default(), &mut |mut message| {
            if message.sequence == 3000 {
                message.topic = "/core/input".into();
                message.data = br#"{"input":"gap","since_s":12.5,"records":57}"#.to_vec();
            }
            vec![message]
        })
        .unwrap();
    let Some(Refused::Gap { since_s, records, .. }) = report.refused else {
        panic!("{:?}", report.refused);
    };
    assert_eq!((since_s, records, report.identical), (12.5, 57, None));
    assert!(report.outputs > 100 && report.outputs_different == 0);
}

#[test]
fn a_log_whose_attachment_was_changed_is_refused() {
    let mut log = log();
    log.edit_attachment("components/isobath.wasm", |mut record| {
        let middle = record.len() / 2;
        record[middle] ^= 1;
        // Without a checksum of the attachment itself.
        let end = record.len() - 4;
        record[end..].fill(0);
        Some(record)
    });
    let error = log
        .replay_with(Vec::new(), Configs::default(), &mut unchanged)
        .err()
        .unwrap();
    assert!(
        error
            .to_string()
            .contains("components/isobath.wasm has another SHA-256"),
        "{error}"
    );
}

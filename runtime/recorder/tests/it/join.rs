//! The parts of a log are one log again.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;

use backseat_recorder::{JoinError, Rate, Record, Recorder, join, read};
use backseat_units::Timestamp;

use crate::sample::{header, inputs, start};

/// The opcode of a chunk of messages in an MCAP file.
const CHUNK: u8 = 6;

/// Inputs of every kind, in parts that begin before the input of these places. The log that was never split comes last.
fn recorded(folder: &tempfile::TempDir, turns: &[usize]) -> Vec<PathBuf> {
    let components = [("isobath".to_owned(), vec![7; 1000])];
    let header = header(Rate::Deployed, &components);
    let name = |part: usize| folder.path().join(format!("{part}.mcap"));
    let mut parts = vec![name(0)];
    let mut split = Recorder::create(&name(0), &header).unwrap();
    let mut whole = Recorder::create(&name(99), &header).unwrap();
    split.start(&start()).unwrap();
    whole.start(&start()).unwrap();
    for (index, input) in inputs().iter().enumerate() {
        let now = Timestamp::from_millis(100 * index as u64);
        if turns.contains(&index) {
            let next = name(parts.len());
            split
                .turn(BufWriter::new(File::create(&next).unwrap()), next.display().to_string())
                .unwrap();
            parts.push(next);
        }
        split.input(now, input).unwrap();
        whole.input(now, input).unwrap();
    }
    split.finish().unwrap();
    whole.finish().unwrap();
    parts.push(name(99));
    parts
}

#[test]
fn the_parts_of_a_log_are_one_log_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut parts = recorded(&folder, &[3, 4, 9]);
    let whole = read(&parts.pop().unwrap()).unwrap();
    for (place, part) in parts.iter().enumerate() {
        let log = read(part).unwrap();
        assert!(log.complete);
        assert_eq!(log.run.part, place as u64 + 1);
        assert_eq!(log.run.components, whole.run.components);
        assert_eq!(log.attachment("components/isobath.wasm").is_some(), place == 0);
        assert_eq!(log.attachment("mission.toml"), whole.attachment("mission.toml"));
    }
    // In any order.
    parts.rotate_left(1);
    let joined_path = folder.path().join("joined.mcap");
    let joined = join(&parts, &joined_path).unwrap();
    assert_eq!((joined.parts, joined.missing), (4, 0));
    let log = read(&joined_path).unwrap();
    assert_eq!((&log.run, &log.attachments), (&whole.run, &whole.attachments));
    let records = |log: &backseat_recorder::Log| -> Vec<(Timestamp, Record)> {
        log.entries
            .iter()
            .map(|entry| (entry.now, entry.record.clone()))
            .collect()
    };
    assert_eq!(records(&log), records(&whole));
    let refused = join(&parts, &joined_path).unwrap_err().to_string();
    assert!(
        refused.contains("cannot create log") && refused.contains("is there already"),
        "{refused}"
    );
    assert_eq!(read(&joined_path).unwrap(), log, "a file that exists is not touched");
}

#[test]
fn what_a_part_has_lost_is_a_gap_and_a_part_that_is_missing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut parts = recorded(&folder, &[5, 8]);
    let whole = read(&parts.pop().unwrap()).unwrap();
    let out = folder.path().join("joined.mcap");
    assert!(matches!(join(&parts[1..], &out), Err(JoinError::Missing { part: 1 })));
    let without = [parts[0].clone(), parts[2].clone()];
    assert!(matches!(join(&without, &out), Err(JoinError::Missing { part: 2 })));
    let twice = [parts[0].clone(), parts[0].clone()];
    assert!(matches!(join(&twice, &out), Err(JoinError::Twice { part: 1, .. })));
    assert!(!out.exists(), "nothing is left of a log that cannot be made");
    // The second part is cut in its only chunk of messages.
    let bytes = fs::read(&parts[1]).unwrap();
    let mut at = 8;
    while bytes[at] != CHUNK {
        at += 9 + usize::try_from(u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap())).unwrap();
    }
    fs::write(&parts[1], &bytes[..at + 100]).unwrap();
    let joined = join(&parts, &out).unwrap();
    assert!(joined.missing > 0);
    let log = read(&out).unwrap();
    assert!(log.complete);
    let gaps: Vec<_> = log
        .entries
        .iter()
        .filter(|entry| matches!(entry.record, Record::Gap { .. }))
        .collect();
    assert_eq!(gaps.len(), 1, "{gaps:?}");
    assert_eq!(
        gaps[0].record,
        Record::Gap {
            since_s: log.entries[5].now.as_secs_f64(),
            records: joined.missing
        }
    );
    assert_eq!(log.entries.last().unwrap().record, whole.entries.last().unwrap().record);
}

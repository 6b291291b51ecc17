//! An independent reader, in Python and written from the documents alone, finds the same as `dump`.

use std::path::Path;
use std::process::Command;

use backseat_s7k_tools::{Selection, Source, dump};

use crate::compose;
use crate::tools::recording;

fn compared(bytes: &[u8]) -> String {
    let (folder, path) = recording(bytes);
    let lines = folder.path().join("dump.jsonl");
    let mut out = Vec::new();
    dump(&Source::open(&path).unwrap(), &Selection::default(), true, &mut out).unwrap();
    std::fs::write(&lines, out).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/suite/scripts/s7k_compare.py");
    let output = Command::new("python3")
        .arg("-B")
        .arg(script)
        .arg(&path)
        .arg(&lines)
        .output();
    let output = output.unwrap_or_else(|error| panic!("python3 is needed (its standard library is enough): {error}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_reader_that_shares_nothing_with_ours_finds_every_field_and_sample() {
    assert_eq!(
        compared(&compose::clean()),
        "890 records, 0 damaged places, 104337 fields and 1488000 samples are equal\n"
    );
}

#[test]
fn it_finds_the_same_damage() {
    assert_eq!(
        compared(&compose::damaged().0),
        "888 records, 3 damaged places, 97106 fields and 1487200 samples are equal\n"
    );
}

//! The tools for recordings of the sonar: exit codes, outputs, and one line for what cannot be used.

#[expect(dead_code, reason = "the tests of the tools use all of it")]
#[path = "../../../../runtime/s7k-tools/examples/survey/compose.rs"]
mod compose;

use std::path::PathBuf;

use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// The survey, whole and damaged, beside a mission that nothing needs.
struct Dive {
    mission: Mission,
    whole: PathBuf,
    damaged: PathBuf,
}

impl Dive {
    fn new() -> Self {
        let mission = Mission::steady();
        let (whole, damaged) = (mission.beside("dive.s7k"), mission.beside("damaged.s7k"));
        std::fs::write(&whole, compose::clean()).unwrap();
        std::fs::write(&damaged, compose::damaged().0).unwrap();
        Self {
            mission,
            whole,
            damaged,
        }
    }
}

fn s7k(command: &str, file: &PathBuf) -> Backseat {
    Backseat::new().args(["s7k", command]).arg(file)
}

#[test]
fn the_program_for_sea_has_the_tools() {
    let dive = Dive::new();
    let info = s7k("info", &dive.whole).for_sea().arg("--json").run().exit(0);
    let object: Value = serde_json::from_str(&info.stdout).unwrap();
    assert_eq!((&object["records"], info.stderr.as_str()), (&890.into(), ""), "{info}");
    assert_eq!(object["catalogue"]["state"], "matches");
}

#[test]
fn verify_ends_with_1_where_there_is_a_fault() {
    let dive = Dive::new();
    let right = s7k("verify", &dive.whole).run().exit(0);
    assert_eq!(
        (right.stdout.as_str(), right.stderr.as_str()),
        ("", "890 records: nothing wrong\n")
    );
    let wrong = s7k("verify", &dive.damaged).run().exit(1);
    assert_eq!(wrong.stdout.lines().count(), 6, "{wrong}");
    assert!(wrong.stderr.starts_with("888 records: 3 damaged places, "), "{wrong}");
    let objects = s7k("verify", &dive.damaged).arg("--json").run().exit(1);
    let first: Value = serde_json::from_str(objects.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(first["kind"], "checksum");
}

#[test]
fn dump_and_cut_take_types_devices_and_times() {
    let dive = Dive::new();
    let selected = [
        "--type",
        "3000,3001",
        "--device",
        "11000,11001",
        "--from",
        "2026-327T14:00:10",
        "--to",
    ];
    let dumped = s7k("dump", &dive.whole)
        .args(selected)
        .arg("2026-11-23T14:00:12Z")
        .run()
        .exit(0);
    assert_eq!(dumped.stdout.lines().count(), 2 * (4 + 2), "{dumped}");
    let out = dive.mission.beside("cut.s7k");
    let cut = s7k("cut", &dive.whole)
        .args(selected)
        .arg("2026-11-23T14:00:12Z")
        .arg("--out")
        .arg(&out)
        .run()
        .exit(0);
    assert!(cut.stdout.is_empty() && cut.stderr.starts_with("12 records, "), "{cut}");
    let verified = s7k("verify", &out).run().exit(0);
    // The selection has left the navigation out.
    assert!(
        verified
            .stderr
            .starts_with("14 records: nothing wrong; warning: the pings have no navigation"),
        "{verified}"
    );
    let wrong = s7k("dump", &dive.whole).args(["--from", "yesterday"]).run().exit(2);
    assert!(
        wrong
            .stderr
            .contains("expected a time in UTC, such as 2026-11-23T14:05:07.25Z"),
        "{wrong}"
    );
}

#[test]
fn export_writes_every_format() {
    let dive = Dive::new();
    for (format, device, begin) in [
        ("segy", "11000", &b"\xC3\x40\xF1"[..]),
        ("png", "11002", b"\x89PNG"),
        ("geotiff", "11001", b"II*\0"),
        ("csv", "11100", b"record_offset,"),
        ("xtf", "11001", b"\x7B\x01backseat"),
    ] {
        let out = dive.mission.beside("out");
        let done = s7k("export", &dive.whole)
            .args(["--to", format, "--device", device, "--out"])
            .arg(&out)
            .run()
            .exit(0);
        assert!(done.stdout.is_empty() && done.stderr.lines().count() == 1, "{done}");
        assert!(std::fs::read(&out).unwrap().starts_with(begin), "{format}");
        std::fs::remove_file(&out).unwrap();
    }
}

#[test]
fn what_cannot_be_used_is_one_line_that_says_what_to_do() {
    let dive = Dive::new();
    let out = dive.mission.beside("out");
    let path = |path: &PathBuf| path.display().to_string();
    let export = |arguments: &[&str]| {
        s7k("export", &dive.whole)
            .args(arguments.iter().copied())
            .arg("--out")
            .arg(&out)
    };
    for (command, parts) in [
        (
            s7k("info", &out),
            vec![path(&out), "cannot read: No such file or directory".to_owned()],
        ),
        (
            s7k("info", &dive.mission.path().to_owned()),
            vec!["is a folder: give a recording (.s7k) in it".to_owned()],
        ),
        (
            export(&["--to", "xtf"]),
            vec![
                path(&dive.whole),
                "choose one of 11001 (240 records), 11002 (456 records) with --device".to_owned(),
            ],
        ),
        (
            export(&["--to", "csv", "--ground"]),
            vec!["invalid --ground: it is an option of --to png only".to_owned()],
        ),
        (
            export(&[
                "--to",
                "geotiff",
                "--device",
                "11002",
                "--resolution",
                "0.01",
                "--memory",
                "1",
            ]),
            vec!["over the limit of 1 MiB: set --resolution to ".to_owned()],
        ),
        (
            // As on a disk that becomes full.
            export(&["--to", "xtf", "--device", "11002"]).file_max_kib(64),
            vec![path(&out), "cannot write: ".to_owned(), "free some space".to_owned()],
        ),
    ] {
        let line = command.run().refusal();
        for part in parts {
            assert!(line.contains(&part), "{part}: {line}");
        }
    }
    // Nothing is left of what was not finished.
    assert!(!out.exists() && !dive.mission.beside("out.part").exists());
}

/// An output that is the input, by whatever name, would destroy the recording.
#[test]
fn an_output_is_never_the_recording_that_is_read() {
    let dive = Dive::new();
    let before = std::fs::read(&dive.whole).unwrap();
    let (soft, hard, dotted) = (
        dive.mission.beside("soft.s7k"),
        dive.mission.beside("hard.s7k"),
        dive.whole.parent().unwrap().join("./dive.s7k"),
    );
    std::os::unix::fs::symlink(&dive.whole, &soft).unwrap();
    std::fs::hard_link(&dive.whole, &hard).unwrap();
    for out in [&dive.whole, &soft, &hard, &dotted] {
        let cut = s7k("cut", &dive.whole).arg("--out").arg(out).run().exit(2);
        let export = s7k("export", &dive.whole)
            .args(["--to", "csv", "--out"])
            .arg(out)
            .run()
            .exit(2);
        for refused in [cut, export] {
            assert!(
                refused
                    .stderr
                    .ends_with("is the recording that is read: choose another name with --out\n"),
                "{refused}"
            );
            assert_eq!(refused.stderr.lines().count(), 1, "{refused}");
        }
    }
    // The name that the output has until it is whole is a file too.
    let part = dive.mission.beside("x.s7k.part");
    std::fs::rename(&hard, &part).unwrap();
    let out = dive.mission.beside("x.s7k");
    let refused = s7k("cut", &part).arg("--out").arg(out).run().exit(2);
    assert!(refused.stderr.contains("is the recording that is read"), "{refused}");
    assert!(std::fs::read(&dive.whole).unwrap() == before && part.is_file());
}

#[test]
fn several_files_of_one_recording_are_one() {
    let dive = Dive::new();
    let (first, second) = (dive.mission.beside("a.s7k"), dive.mission.beside("b.s7k"));
    let middle = "2026-11-23T14:00:30";
    for (out, limits) in [(&first, ["--until", middle]), (&second, ["--from", middle])] {
        let _done = s7k("cut", &dive.whole).args(limits).arg("--out").arg(out).run().exit(0);
    }
    let (joined, whole) = (dive.mission.beside("joined"), dive.mission.beside("whole"));
    for format in ["csv", "png", "geotiff", "segy", "xtf"] {
        let device = match format {
            "csv" => "11100",
            "segy" => "11000",
            _ => "11001",
        };
        let selected = ["--to", format, "--device", device, "--out"];
        // In any order.
        let of_two = s7k("export", &second)
            .arg(&first)
            .args(selected)
            .arg(&joined)
            .run()
            .exit(0);
        let of_one = s7k("export", &dive.whole).args(selected).arg(&whole).run().exit(0);
        assert_eq!(of_two.stderr, of_one.stderr, "{format}");
        if ["png", "geotiff"].contains(&format) {
            assert!(
                std::fs::read(&joined).unwrap() == std::fs::read(&whole).unwrap(),
                "{format}"
            );
        }
    }
    let done = s7k("cut", &second).arg(&first).arg("--out").arg(&joined).run().exit(0);
    assert!(done.stderr.starts_with("888 records, "), "{done}");
    let twice = s7k("cut", &first).arg(&first).arg("--out").arg(&joined).run().exit(2);
    assert!(twice.stderr.ends_with("a.s7k: is given twice\n"), "{twice}");
}

#[test]
fn an_export_of_nothing_says_what_there_is_and_one_of_a_damaged_file_what_it_left_out() {
    let dive = Dive::new();
    let out = dive.mission.beside("out");
    for (format, device) in [
        ("segy", "11000"),
        ("png", "11002"),
        ("geotiff", "11001"),
        ("csv", "11100"),
        ("xtf", "11001"),
    ] {
        let late = s7k("export", &dive.whole)
            .args(["--to", format, "--from", "2030-01-01T00:00", "--out"])
            .arg(&out)
            .run()
            .exit(2);
        assert!(
            late.stderr.contains(" matches: there is device ")
                && late.stderr.contains(device)
                && late.stderr.contains(", from 2026-11-23T14:00:0"),
            "{late}"
        );
        let damaged = s7k("export", &dive.damaged)
            .args(["--to", format, "--device", device, "--out"])
            .arg(&out)
            .run()
            .exit(0);
        assert!(
            damaged.stderr.contains("bytes that are not a record, in 3 places"),
            "{damaged}"
        );
    }
    let mixed = s7k("export", &dive.whole)
        .args(["--from", "2026-11-23T14:00:10", "--to", "2026-11-23T14:00:12", "--out"])
        .arg(&out)
        .run()
        .exit(2);
    assert!(mixed.stderr.contains("use --until"), "{mixed}");
}

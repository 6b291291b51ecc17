//! `backseat log judge`: judges a recorded run, and reports what is wrong with it.

#![expect(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a log that cannot be written again fails its test, and records that are not judged are left out"
)]

use std::path::{Path, PathBuf};

use backseat_core::Output;
use backseat_recorder::{Header, Log, LoggedInput, Record, Recorder, Sources, read};
use backseat_suite::{Backseat, Finished, Mission};
use backseat_units::Timestamp;
use serde_json::Value;

/// A simulated run's log.
fn flown(mission: &Mission) -> Log {
    let path = mission.beside("flown.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&path)
        .mission(mission)
        .run();
    assert!(matches!(report.code, Some(0 | 1)), "{report}");
    assert_eq!(report.json()["violations"], serde_json::json!([]), "{report}");
    read(&path).expect("the log can be read")
}

fn judge(path: &Path, arguments: &[&str]) -> Finished {
    Backseat::new().args(["log", "judge"]).arg(path).args(arguments).run()
}

/// A record of a log, its time, and the sentence of ours in it, without checksum and line end.
struct Line<'a> {
    at: Timestamp,
    record: &'a Record,
    body: Option<&'a str>,
}

/// A body with its dollar sign, checksum and line end.
fn sentence(body: &str) -> Record {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    Record::Sent(format!("${body}*{sum:02X}\r\n").into_bytes())
}

fn body_of(record: &Record) -> Option<&str> {
    let Record::Sent(bytes) = record else { return None };
    let text = std::str::from_utf8(bytes).ok()?;
    Some(text.strip_prefix('$')?.split_once('*')?.0)
}

/// The same log with each record as `change` returns it; `None` leaves it as it is.
fn rewritten(log: &Log, path: PathBuf, change: impl FnMut(&Line<'_>) -> Option<Vec<Record>>) -> PathBuf {
    let fence = std::str::from_utf8(log.attachment("fence.geojson").unwrap()).unwrap();
    fenced(log, path, fence, change)
}

/// The same, with another fence.
fn fenced(log: &Log, path: PathBuf, fence: &str, mut change: impl FnMut(&Line<'_>) -> Option<Vec<Record>>) -> PathBuf {
    let text = |name: &str| std::str::from_utf8(log.attachment(name).unwrap()).unwrap();
    let header = Header {
        utc_at_start: log.run.utc_at_start,
        rate: log.run.rate,
        mission: &log.run.mission,
        seed: log.run.seed,
        resolved_mission: text("mission.toml"),
        fence,
        origin: log.run.origin,
        world: None,
        components: &[],
        version: &log.run.version,
        sources: Sources::default(),
    };
    let mut recorder = Recorder::create(&path, &header).unwrap();
    for entry in &log.entries {
        let line = Line {
            at: entry.now,
            record: &entry.record,
            body: body_of(&entry.record),
        };
        for record in change(&line).unwrap_or_else(|| vec![entry.record.clone()]) {
            let at = entry.now;
            match record {
                Record::Start(start) => recorder.start(&start),
                Record::Input(input) => recorder.input(at, &input.as_input()),
                Record::Sent(bytes) => recorder.output(at, &Output::Send(bytes)),
                Record::Gap { since_s, records } => {
                    let since = Timestamp::from_millis((since_s * 1000.0) as u64);
                    recorder.gap(at, since, records)
                }
                Record::Truth(json) => recorder.truth(at, &json),
                // None of that is judged.
                _ => Ok(()),
            }
            .unwrap();
        }
    }
    recorder.finish().unwrap();
    path
}

/// The same log with one sentence of ours changed: the first for which `change` returns something.
fn changed(mission: &Mission, log: &Log, change: impl Fn(Timestamp, &str) -> Option<Vec<String>>) -> PathBuf {
    let mut done = false;
    let path = rewritten(log, mission.beside("changed.mcap"), |line| {
        let bodies = change(line.at, line.body?).filter(|_| !done)?;
        done = true;
        Some(bodies.iter().map(|body| sentence(body)).collect())
    });
    assert!(done, "no sentence was changed");
    path
}

/// Requires that this rule is broken by a sentence that begins with this text; returns the finding.
#[track_caller]
fn breaks(path: &Path, rule: &str, begins: &str) -> Value {
    let finished = judge(path, &["--json"]).exit(1);
    let report = finished.json();
    assert_eq!(report["passed"], false);
    let broken = report["broken"].as_array().unwrap();
    let found = broken.iter().find(|found| found["rule"] == rule);
    let found = found.unwrap_or_else(|| panic!("{rule}: {broken:#?}"));
    if !begins.is_empty() {
        let sentence = found["sentence"].as_str().unwrap_or_default();
        assert!(sentence.starts_with(begins), "{found}");
    }
    let row = report["rules"]
        .as_array()
        .unwrap()
        .iter()
        .find(|row| row["rule"] == rule);
    assert!(row.unwrap()["broken"].as_u64() > Some(0));
    let told = judge(path, &[]).exit(1);
    let text = found["text"].as_str().unwrap();
    assert!(
        told.stdout
            .lines()
            .any(|line| line.contains(rule) && line.contains(text)),
        "{told}"
    );
    found.clone()
}

fn after(at: Timestamp, seconds: u64) -> bool {
    at > Timestamp::from_secs(seconds)
}

/// The time in a heartbeat, if the sentence is one.
fn beat(body: &str) -> Option<&str> {
    body.strip_prefix("BPSTS,")?.split(',').next()
}

#[test]
fn several_logs_are_judged_and_shown_with_the_worst_exit_code() {
    let mission = Mission::steady();
    drop(flown(&mission));
    let (good, bad) = (mission.beside("flown.mcap"), mission.beside("bad.mcap"));
    std::fs::write(&bad, "not a log").unwrap();
    for command in ["judge", "info"] {
        let run = |files: &[&Path]| Backseat::new().args(["log", command]).args(files).run();
        let both = run(&[&good, &good]).exit(0).stdout;
        assert_eq!(both.matches("flown.mcap: steady").count(), 2, "{both}");
        let finished = run(&[&bad, &good]).exit(2);
        assert!(finished.stdout.contains("flown.mcap: steady"), "{finished}");
        assert!(finished.stderr.contains("bad.mcap"), "{finished}");
    }
}

#[test]
fn a_log_of_the_first_format_is_refused_in_one_line() {
    let mission = Mission::steady();
    drop(flown(&mission));
    let path = mission.beside("flown.mcap");
    let mut bytes = std::fs::read(&path).unwrap();
    let format = b"\x06\0\0\0format\x01\0\0\0";
    let at = bytes.windows(format.len()).position(|window| window == format).unwrap() + format.len();
    bytes[at] = b'1';
    std::fs::write(&path, bytes).unwrap();
    for command in ["info", "show", "judge"] {
        let line = Backseat::new().args(["log", command]).arg(&path).run().refusal();
        assert_eq!(
            line,
            format!(
                "error: log {} has format \"1\", and this version reads format 2 only",
                path.display()
            )
        );
    }
}

#[test]
fn the_lines_of_a_log_are_shown_and_those_of_one_plugin() {
    let mission = Mission::steady();
    drop(flown(&mission));
    let show = |arguments: &[&str]| {
        let log = mission.beside("flown.mcap");
        Backseat::new().args(["log", "show"]).arg(log).args(arguments).run()
    };
    let all = show(&[]).exit(0).stdout;
    assert!(all.contains(" control granted"), "{all}");
    let pilot = show(&["--plugin", "pilot"]).exit(0).stdout;
    assert!(pilot.lines().count() > 10, "{pilot}");
    assert!(pilot.lines().all(|line| line.contains("pilot")), "{pilot}");
    assert!(
        show(&["--plugin", "nobody"])
            .refusal()
            .contains("its plugins are: pilot")
    );
}

#[test]
fn a_clean_log_held_and_says_what_could_not_be_judged() {
    let mission = Mission::steady();
    let log = flown(&mission);
    let finished = judge(&mission.beside("flown.mcap"), &["--all"]).exit(0);
    assert_eq!(finished.stderr, "");
    for (rule, fared) in [
        ("no-control", "held in all 599 cases"),
        ("end-missing", "held in the one case"),
        ("cancel-foreign", "not judged: no case of it occurred"),
        ("truth-fence", "not judged: no true position is recorded"),
        (
            "stale-delivery",
            "not judged: the record does not say when our sentences arrived",
        ),
    ] {
        let line = finished
            .stdout
            .lines()
            .find(|line| line.split_whitespace().any(|word| word == rule));
        assert!(line.is_some_and(|line| line.contains(fared)), "{rule}: {finished}");
    }
    let brief = judge(&mission.beside("flown.mcap"), &[]).exit(0).stdout;
    assert!(!brief.contains("not judged"), "{brief}");
    assert!(
        brief.contains("rules had no case or need a simulation: --all shows them"),
        "{brief}"
    );
    let report = judge(&mission.beside("flown.mcap"), &["--json"]).exit(0).json();
    assert_eq!(
        (&report["passed"], &report["complete"]),
        (&Value::Bool(true), &Value::Bool(true))
    );
    assert_eq!(report["broken"], serde_json::json!([]));
    // A log that is written again without a change gives the same result.
    let path = rewritten(&log, mission.beside("same.mcap"), |_| None);
    let same = judge(&path, &["--json"]).exit(0).json();
    assert_eq!(same["rules"], report["rules"]);
}

#[test]
fn one_modify_that_is_changed_is_named() {
    let mission = Mission::steady();
    let log = flown(&mission);
    let modify = |body: &'static str| {
        move |at: Timestamp, sent: &str| {
            let time = sent.strip_prefix("BPRMB,")?.split(',').next()?;
            after(at, 60).then(|| vec![body.replace("{t}", time)])
        }
    };
    for (body, rule) in [
        ("BPRMB,{t},90,8,0,2.6,1,0", "request-speed"),
        ("BPRMB,{t},90,41,0,1.5,1,0", "request-vertical"),
        ("BPRMB,{t},90,8,0,,1,0", "modify-inherits"),
        ("BPRMB,{t},90,8,0,1.5,1,0,7", "malformed"),
    ] {
        let found = breaks(&changed(&mission, &log, modify(body)), rule, "$BPRMB,0801");
        assert!(
            (60e9..62e9).contains(&found["at"].as_f64().unwrap()),
            "a minute after the start: {found}"
        );
    }
}

/// The plan leads along the middle, from 600 m in the west; 45 s before it reaches the middle, the vehicle is 67 m away
/// from it.
#[test]
fn a_modify_that_leads_out_of_the_attached_fence_is_named() {
    let mission = Mission::steady();
    let log = flown(&mission);
    let fence = mission.read("fence.geojson").replace("-70.6818", "-70.7000");
    let path = fenced(&log, mission.beside("fenced.mcap"), &fence, |_| None);
    let margin = breaks(&path, "modify-margin", "$BPRMB");
    let out = breaks(&path, "refresh-fence", "$BPRMB");
    assert!((380e9..402e9).contains(&margin["at"].as_f64().unwrap()), "{margin}");
    assert!((390e9..405e9).contains(&out["at"].as_f64().unwrap()), "{out}");
}

#[test]
fn what_is_said_where_it_may_not_be_is_named() {
    let mission = Mission::steady();
    let log = flown(&mission);
    // The vehicle takes control back at 602 s.
    let beat_becomes = |seconds: u64, body: &'static str| {
        move |at: Timestamp, sent: &str| {
            let time = beat(sent)?;
            after(at, seconds).then(|| vec![body.replace("{t}", time)])
        }
    };
    let modify = "BPRMB,{t},90,8,0,1.5,1,0";
    breaks(
        &changed(&mission, &log, beat_becomes(604, modify)),
        "no-control",
        "$BPRMB",
    );
    breaks(
        &changed(&mission, &log, beat_becomes(604, "BPEMB,{t}")),
        "end-surplus",
        "$BPEMB",
    );
    breaks(
        &changed(&mission, &log, beat_becomes(60, "BPABT,{t},because,1")),
        "operator-only",
        "$BPABT",
    );
    breaks(
        &changed(&mission, &log, beat_becomes(60, "BPRCN,{t},5")),
        "cancel-foreign",
        "$BPRCN",
    );
    let outside = "BPRTK,{t},5,4220.000000,N,07042.000000,W,4220.100000,N,07042.000000,W,0,20,1.5,0,0";
    breaks(
        &changed(&mission, &log, beat_becomes(60, outside)),
        "request-fence",
        "$BPRTK",
    );
    let unended = |_: Timestamp, sent: &str| sent.starts_with("BPEMB").then(Vec::new);
    breaks(&changed(&mission, &log, unended), "lease-outlives", "");
}

#[test]
fn an_identifier_that_is_used_twice_is_named() {
    let mission = Mission::copy("plume");
    let log = flown(&mission);
    let path = changed(&mission, &log, |_, sent| {
        sent.contains(",2,")
            .then(|| sent.strip_prefix("BPRTK,"))
            .flatten()
            .map(|rest| vec![format!("BPRTK,{}", rest.replacen(",2,", ",1,", 1))])
    });
    breaks(&path, "identifier-repeated", "$BPRTK");
}

#[test]
fn what_steers_under_the_operators_hold_is_named() {
    let mission = Mission::steady().edit(
        "mission.toml",
        "[limits]",
        "[session]\nhold_text = \"payload hold\"\n\n[limits]",
    );
    let world = mission.read("world.toml") + "\n[[mission.commands]]\nat_s = 60\ntext = \"payload hold\"\n";
    let mission = mission.write("world.toml", world);
    let log = flown(&mission);
    let _clean = judge(&mission.beside("flown.mcap"), &[]).exit(0);
    let mut done = false;
    // Here the note with the source of the hold matters.
    let path = rewritten(&log, mission.beside("changed.mcap"), |line| {
        if let Record::Note(note) = line.record {
            let hold = note["note"] == "operator";
            return hold.then(|| vec![Record::Input(LoggedInput::Operator(backseat_core::Operator::Hold))]);
        }
        let time = beat(line.body?).filter(|_| after(line.at, 70) && !done)?;
        done = true;
        Some(vec![sentence(&format!("BPRMB,{time},90,8,0,1.5,1,0"))])
    });
    breaks(&path, "operator-hold", "$BPRMB");
}

/// Control is taken at 602 s and the lease ends; a disk that accepted neither record hides both.
#[test]
fn past_a_gap_nothing_is_claimed_that_hangs_on_what_was_before() {
    let mission = Mission::steady();
    let log = flown(&mission);
    let (since, until) = (Timestamp::from_secs(601), Timestamp::from_secs(603));
    let mut gap_written = false;
    let mut modified = false;
    let path = rewritten(&log, mission.beside("gap.mcap"), |line| {
        if line.at < since {
            return None;
        }
        if line.at < until {
            return Some(Vec::new());
        }
        let mut records = Vec::new();
        if !std::mem::replace(&mut gap_written, true) {
            records.push(Record::Gap {
                since_s: 601.0,
                records: 77,
            });
        }
        match line.body.and_then(beat).filter(|_| !modified) {
            Some(time) => {
                // It cannot be known who has control.
                modified = true;
                records.push(sentence(&format!("BPRMB,{time},90,8,0,1.5,1,0")));
                records.push(sentence(&format!("BPEMB,{time}")));
            }
            None => records.push(line.record.clone()),
        }
        Some(records)
    });
    let report = judge(&path, &["--json"]).exit(0).json();
    assert!(modified);
    assert_eq!(report["gaps"][0]["records"], 77, "{}", report["gaps"]);
    let told = judge(&path, &[]).exit(0);
    assert!(
        told.stdout
            .contains("gap: 77 records are missing from 601.000 s to 603."),
        "{told}"
    );
    assert!(
        told.stdout.contains("not judged until the log states it again"),
        "{told}"
    );
}

#[test]
fn what_is_no_log_is_refused_with_the_file_and_what_was_expected() {
    let mission = Mission::steady();
    for (arguments, expected) in [
        (vec!["log", "judge", "nowhere.mcap"], ["nowhere.mcap", "log of a run"]),
        (
            vec!["log", "judge", "steady/world.toml"],
            ["world.toml", "log of a run"],
        ),
    ] {
        let folder = mission.path().parent().unwrap();
        let line = Backseat::new().args(arguments).in_folder(folder).run().refusal();
        for word in expected {
            assert!(line.contains(word), "{line}");
        }
    }
}

//! `backseat sim` with sonars: the mock payload controller over the simulated seabed, and its client beside core.

use backseat_core::FromSonar;
use backseat_recorder::{Entry, Log, LoggedInput, Record, read};
use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// The steady mission, shortened, with a sidescan that pings.
fn with_sonar() -> Mission {
    Mission::steady()
        .edit(
            "world.toml",
            "timeout_s = 600",
            "timeout_s = 230\npayload_message = \"line 1\"",
        )
        .append(
            "mission.toml",
            r#"
[sonar]
health_period_s = 2

[[sonar.sensor]]
index = 1
device = 11001
records = [3000]
period_ms = 200
ping = true

[[plugin.ping]]
sensor = 1
samples = 64
decimation = "maximum"
"#,
        )
        .append(
            "world.toml",
            r#"
[plc]
[plc.sidescan_low]
start_s = 5
sample_interval_us = 200
"#,
        )
}

fn fault(entry: &str) -> Mission {
    with_sonar().append("world.toml", &format!("\n[[plc.fault]]\n{entry}\n"))
}

fn fly(mission: &Mission, seed: &str) -> (Value, Log) {
    let path = mission.beside("run.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--seed", seed, "--log"])
        .arg(&path)
        .mission(mission)
        .run()
        .exit(0)
        .json();
    (report, read(&path).expect("the log can be read"))
}

/// When the runtime wrote which sentence to the vehicle. The text of BPSTS, which says how the sonars are, is left out.
fn steered(log: &Log) -> Vec<(u64, String)> {
    let ours = log.link().filter(|(_, from_vehicle, _)| !from_vehicle);
    ours.map(|(at, _, bytes)| (at.as_nanos(), String::from_utf8_lossy(bytes).into_owned()))
        .filter(|(_, line)| !line.starts_with("$BPSTS"))
        .collect()
}

/// The lines of the log about the sonars, each with its time, seconds.
fn told(log: &Log) -> Vec<(f64, String)> {
    let line = |entry: &Entry| {
        let Record::Note(note) = &entry.record else { return None };
        let text = note["text"].as_str().unwrap_or_default();
        (note["note"] == "sonar").then(|| (entry.now.as_secs_f64(), text.to_owned()))
    };
    log.entries.iter().filter_map(line).collect()
}

fn has(log: &Log, text: &str) -> bool {
    told(log).iter().any(|(_, line)| line.contains(text))
}

fn pings(log: &Log) -> Vec<f64> {
    let ping = |entry: &Entry| {
        let is_ping = matches!(&entry.record, Record::Input(LoggedInput::Sonar(FromSonar::Ping(..))));
        is_ping.then(|| entry.now.as_secs_f64())
    };
    log.entries.iter().filter_map(ping).collect()
}

/// The last text of BPSTS.
fn status(log: &Log) -> String {
    let ours = log.link().filter(|(_, from_vehicle, _)| !from_vehicle);
    let lines = ours.map(|(_, _, bytes)| String::from_utf8_lossy(bytes).into_owned());
    lines
        .filter(|line| line.starts_with("$BPSTS"))
        .last()
        .unwrap_or_default()
}

#[test]
fn a_run_with_sonars_is_repeated_byte_for_byte() {
    let mission = with_sonar();
    let (first, log) = fly(&mission, "3");
    let (again, _) = fly(&mission, "3");
    let (other, _) = fly(&mission, "4");
    assert_eq!(first["digest"], again["digest"]);
    assert_ne!(first["digest"], other["digest"]);
    // A sidescan that pings five times a second after it has started.
    let pings = pings(&log);
    assert!(
        pings.len() > 1000 && pings[0] > 5.0,
        "{} {:?}",
        pings.len(),
        pings.first()
    );
    assert!(has(&log, "the payload controller is ready"), "{:?}", told(&log));
    assert!(status(&log).contains("sonar ready; logging"), "{}", status(&log));
}

#[test]
fn sr_022_whatever_the_payload_controller_does_the_vehicle_is_steered_as_before() {
    let (_, well) = fly(&with_sonar(), "3");
    let well = steered(&well);
    let modifies = well.iter().filter(|(_, line)| line.starts_with("$BPRMB")).count();
    assert!(modifies > 200, "{modifies}");
    for (entry, line) in [
        ("at_s = 60\nfor_s = 60\nkind = \"stall\"", "it does not answer"),
        ("at_s = 60\nfor_s = 60\nkind = \"link_closed\"", "no connection"),
        (
            "at_s = 60\nfor_s = 60\nkind = \"flood\"\nrecords_per_s = 2000",
            "not used",
        ),
        (
            "at_s = 60\nfor_s = 60\nkind = \"garbage\"\nbytes_per_s = 100000",
            "bytes skipped",
        ),
        (
            "at_s = 60\nfor_s = 60\nkind = \"sensor_dies\"\nsensor = \"sidescan_low\"",
            "unhealthy",
        ),
        (
            "at_s = 60\nfor_s = 60\nkind = \"checksums_wrong\"\nchance = 0.5",
            "wrong checksums",
        ),
    ] {
        let (report, log) = fly(&fault(entry), "3");
        assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{entry}");
        assert!(steered(&log) == well, "{entry} changed what was sent to the vehicle");
        assert!(has(&log, line), "{entry}: {:?}", told(&log));
        // What has ended is over.
        assert!(status(&log).contains("sonar ready"), "{entry}: {}", status(&log));
    }
}

#[test]
fn logging_follows_the_vehicle() {
    let begins = |log: &Log| {
        let mut lines = log.link().filter(|(_, from_vehicle, _)| *from_vehicle);
        let began = lines.find(|(_, _, bytes)| String::from_utf8_lossy(bytes).contains("$BFBDL,"));
        began.expect("the vehicle says when to log").0.as_secs_f64()
    };
    let (_, log) = fly(&with_sonar(), "3");
    let lines = told(&log);
    let on = lines.iter().find(|(_, line)| line.starts_with("logging is on"));
    let on_s = on.unwrap_or_else(|| panic!("{lines:?}")).0;
    assert!((0.0..1.0).contains(&(on_s - begins(&log))), "{on_s} {}", begins(&log));

    let alone = with_sonar().edit("mission.toml", "[sonar]", "[sonar]\nlog_with_vehicle = false");
    let (_, log) = fly(&alone, "3");
    assert!(begins(&log) > 0.0 && !has(&log, "logging is on"), "{:?}", told(&log));
}

/// A recording of a simulated survey is whole: it ends with its catalogue, as if the controller had been shut down.
#[test]
fn sim_keeps_the_recording_of_the_survey() {
    let mission = with_sonar().edit("world.toml", "[plc]", "[plc]\nauto_start = true");
    let folder = mission.beside("recordings");
    let _ = Backseat::new()
        .args(["sim", "--s7k"])
        .arg(&folder)
        .mission(&mission)
        .run()
        .exit(0);
    let entries = std::fs::read_dir(&folder).expect("the folder is there");
    let recordings: Vec<_> = entries
        .map(|entry| entry.expect("the folder can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "s7k"))
        .collect();
    let [file] = &recordings[..] else {
        panic!("not one recording: {recordings:?}");
    };
    let verified = Backseat::new().args(["s7k", "verify"]).arg(file).run().exit(0);
    assert!(verified.stdout.is_empty(), "{verified}");
    let info = Backseat::new().args(["s7k", "info", "--json"]).arg(file).run().exit(0);
    assert!(verified.stdout.is_empty(), "{verified}");
    let info = info.json();
    assert_eq!(info["catalogue"]["state"], "matches", "{info}");
    assert!(info["records"].as_u64() > Some(1000), "{info}");
}

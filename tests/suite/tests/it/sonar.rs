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
    // Another run would have files of the same names: it is refused, and the first one stays.
    let again = Backseat::new().args(["sim", "--s7k"]).arg(&folder).mission(&mission);
    let refused = again.run().exit(2);
    assert!(
        refused.stderr.contains("the folder has recordings of another run (")
            && refused.stderr.contains("empty folder"),
        "{refused}"
    );
    let _still = Backseat::new().args(["s7k", "verify"]).arg(file).run().exit(0);
}

#[test]
fn a_recording_that_cannot_be_written_fails_the_run() {
    let mission = with_sonar().edit("world.toml", "[plc]", "[plc]\nauto_start = true");
    let folder = mission.beside("recordings");
    // Files grow to 64 KiB here, and the recording is longer.
    let run = Backseat::new().args(["sim", "--s7k"]).arg(&folder).mission(&mission);
    let run = run.file_max_kib(64).run().exit(1);
    assert!(run.stderr.contains("the recording is not whole: "), "{run}");
}

#[test]
fn a_folder_for_recordings_needs_a_controller_and_must_be_a_folder() {
    let none = Mission::steady();
    let folder = none.beside("recordings");
    let run = Backseat::new()
        .args(["sim", "--s7k"])
        .arg(&folder)
        .mission(&none)
        .run()
        .exit(2);
    assert!(
        run.stderr.contains("has no [plc]") && run.stderr.contains("add [plc]"),
        "{run}"
    );
    assert!(!folder.exists());
    let mission = with_sonar();
    let file = mission.path().join("world.toml");
    for arguments in [["sim", "--s7k"], ["plc", "--folder"]] {
        let run = Backseat::new()
            .args(arguments)
            .arg(&file)
            .mission(&mission)
            .run()
            .exit(2);
        assert!(run.stderr.contains("world.toml: is not a folder"), "{run}");
    }
    let run = Backseat::new()
        .args(["plc", "--listen", "17999"])
        .mission(&mission)
        .run()
        .exit(2);
    assert!(run.stderr.contains("--listen 17999: expected ADDRESS:PORT"), "{run}");
    let run = Backseat::new()
        .args(["check", "--set", "sonar.port=70000"])
        .mission(&mission)
        .run()
        .exit(2);
    assert!(run.stderr.contains("expected 1 to 65535"), "{run}");
}

/// What the controller would reject at sea, or never send, without a word to the plugin.
#[test]
fn check_and_sim_compare_the_settings_with_the_controller() {
    let wrong = with_sonar()
        .edit(
            "mission.toml",
            "period_ms = 200",
            "period_ms = 5\nrange_m = 600\npulse = \"CW\"\ngain = 61",
        )
        .edit(
            "mission.toml",
            "device = 11001\nrecords = [3000]",
            "device = 11002\nrecords = [3000, 3001]",
        )
        .append(
            "mission.toml",
            "\n[[sonar.sensor]]\nindex = 7\ndevice = 11000\nrecords = [3001]\n",
        );
    let checked = Backseat::new().arg("check").mission(&wrong).run();
    for line in [
        "sensor 1: device is 11002, and sensor 1 of [plc] in world.toml is sidescan, low frequency, device 11001",
        "sensor 1: records is 3001, and sidescan, low frequency sends 3000",
        "sensor 1: range_m is 600, and the sonar of world.toml takes 10 to 500 m",
        "sensor 1: pulse is \"CW\", and the sonar of world.toml has \"FM 110-130 kHz 8 ms\"",
        "sensor 1: gain is 61, and the sonar of world.toml takes 0 to 60",
        "sensor 1: period_ms is 5, and the sonar of world.toml takes 10 to 60000 ms",
        "sensor.index is 7, and the run list of [plc] in world.toml has 4 sensors, counted from 0",
    ] {
        assert!(
            checked.stdout.contains(&format!("warning: sonar: {line}")),
            "{line}: {checked}"
        );
    }
    let right = Backseat::new().arg("check").mission(&with_sonar()).run();
    assert!(!right.stdout.contains("warning: sonar"), "{right}");
    let flown = Backseat::new().arg("sim").mission(&wrong).run();
    assert!(flown.stderr.contains("range_m is 600"), "{flown}");
    let deaf = Mission::copy("reinspect").edit(
        "mission.toml",
        "[[plugin.ping]]\nsensor = 0\nsamples = 1000\ndecimation = \"mean\"",
        "",
    );
    let checked = Backseat::new().arg("check").mission(&deaf).run();
    assert!(
        checked
            .stdout
            .contains("warning: plugin reinspect: listens to the sidescan, and gets no ping"),
        "{checked}"
    );
}

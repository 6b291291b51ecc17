//! `backseat replay`: the log of a run again, and what another plugin would have asked for.

use std::fs;
use std::path::{Path, PathBuf};

use backseat_suite::{Backseat, Finished, Mission};
use backseat_test_support::plugins;

/// The opcode of a chunk of messages in an MCAP file.
const CHUNK: u8 = 6;

/// A mission that the plugin `isobath` flies for a few minutes, and its log.
fn flown() -> (Mission, PathBuf) {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 120");
    let log = mission.beside("dive.mcap");
    let flown = Backseat::new()
        .args(["sim", "--seed", "7", "--log"])
        .arg(&log)
        .mission(&mission)
        .run();
    assert!(matches!(flown.code, Some(0 | 1)), "{flown}");
    (mission, log)
}

fn replay(log: &Path, arguments: &[&str]) -> Finished {
    Backseat::new().arg("replay").arg(log).args(arguments).run()
}

/// The file with the first place of some bytes changed by hand, and the checksum of its chunk taken out.
fn changed(log: &Path, find: &[u8], to: &[u8]) -> PathBuf {
    changed_from(log, find, |place| place[..to.len()].copy_from_slice(to))
}

/// The file with the first message that begins like this replaced.
fn replaced(log: &Path, begins: &[u8], message: &[u8]) -> PathBuf {
    changed_from(log, begins, |place| {
        // The opcode of the next message follows.
        let end = place.windows(2).position(|pair| pair == b"}\x05");
        let end = end.map_or(place.len(), |end| end + 1);
        assert!(end >= message.len(), "the message is too short");
        place[..end].fill(b' ');
        place[..message.len()].copy_from_slice(message);
    })
}

fn changed_from(log: &Path, find: &[u8], change: impl FnOnce(&mut [u8])) -> PathBuf {
    let mut bytes = fs::read(log).expect("the log can be read");
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 9) {
        let length = head[1..]
            .iter()
            .rev()
            .fold(0, |length, byte| length << 8 | usize::from(*byte));
        let (opcode, end) = (head[0], at + 9 + length);
        if opcode == CHUNK {
            let place = bytes[at..end].windows(find.len()).position(|part| part == find);
            if let Some(place) = place {
                change(&mut bytes[at + place..end]);
                // After the times and the size.
                bytes[at + 9 + 24..at + 9 + 28].fill(0);
                let path = log.with_extension("changed.mcap");
                fs::write(&path, bytes).expect("the log can be written");
                return path;
            }
        }
        at = end;
    }
    panic!("{} is not in the log", String::from_utf8_lossy(find));
}

#[test]
fn a_recorded_run_is_replayed_to_the_same_bytes() {
    let (mission, log) = flown();
    let map = mission.beside("replay.svg");
    let text = replay(&log, &["--map", map.to_str().unwrap_or_default()]).exit(0);
    for part in [
        "steady, seed 7",
        "outputs of",
        "all identical",
        "  identical\n",
        "x real time",
    ] {
        assert!(text.stdout.contains(part), "{part}: {text}");
    }
    assert_eq!(text.stderr, "");
    let picture = fs::read_to_string(map).expect("the map is drawn");
    assert!(
        picture.contains("replay of steady") && picture.contains("front-seat"),
        "{picture}"
    );
    for program in [Backseat::new(), Backseat::new().for_sea()] {
        let report = program.args(["replay", "--json"]).arg(&log).run().exit(0).json();
        assert_eq!(report["identical"], true, "{report}");
        assert!(report["first_difference"].is_null(), "{report}");
        assert_eq!((&report["mission"], &report["seed"]), (&"steady".into(), &7.into()));
        assert_eq!((&report["complete"], &report["processes"]), (&true.into(), &1.into()));
        assert!(report["outputs"].as_u64() > Some(500), "{report}");
        assert!(report["plugins"][0]["steps"].as_u64() > Some(50), "{report}");
    }
}

#[test]
fn a_byte_that_was_changed_is_named() {
    let (_mission, log) = flown();
    let changed = changed(&log, b"$BPRMB,", b"$BPRMX,");
    let text = replay(&changed, &[]).exit(1);
    for part in [
        "1 of ",
        "differ",
        "first difference: at ",
        "(message ",
        "/link/to_vehicle) core does something else than recorded",
        "recorded: {\"text\":\"$BPRMX,",
        "replayed: {\"text\":\"$BPRMB,",
        "  not identical\n",
    ] {
        assert!(text.stdout.contains(part), "{part}: {text}");
    }
    let report = replay(&changed, &["--json"]).exit(1).json();
    assert_eq!(report["identical"], false, "{report}");
    let first = &report["first_difference"];
    assert_eq!(
        (&first["kind"], &first["channel"]),
        (&"output".into(), &"/link/to_vehicle".into())
    );
    assert!(first["message"].is_u64() && first["at_s"].is_f64(), "{report}");
}

#[test]
fn another_plugin_is_compared_step_by_step() {
    let (mission, log) = flown();
    let name = Backseat::new()
        .args(["replay", "--json"])
        .arg(&log)
        .run()
        .exit(0)
        .json()["plugins"][0]["name"]
        .as_str()
        .map(str::to_owned)
        .expect("the mission has a plugin");
    let template = plugins().join("template.wasm");
    let config = mission.beside("template.toml");
    fs::write(&config, "heading_deg = 123.0\ndepth_m = 9.5\nspeed_mps = 1.5\n").expect("the folder can be written");
    let (plugin, config) = (
        format!("{name}={}", template.display()),
        format!("{name}={}", config.display()),
    );
    let map = mission.beside("apart.svg");
    let map_text = map.to_str().unwrap_or_default();
    let arguments = ["--plugin", &plugin, "--config", &config];
    // At first there is no control, and the template asks for nothing.
    let text = replay(
        &log,
        &[arguments.as_slice(), &["--steps", "60", "--map", map_text]].concat(),
    )
    .exit(1);
    for part in [
        "all identical",
        "template.wasm, version ",
        " with another config: ",
        "first difference: at ",
        "it knew: ",
        "now: modify ",
        "heading 123.000°, depth 9.500 m",
        "core, of the recorded one: ",
        "the monitor, of the one now: modify ",
        "not identical",
    ] {
        assert!(text.stdout.contains(part), "{part}: {text}");
    }
    let picture = fs::read_to_string(map).expect("the map is drawn");
    assert!(
        picture.contains("asked-now") && picture.contains("asked now instead"),
        "{picture}"
    );
    let report = replay(&log, &[arguments.as_slice(), &["--steps", "2", "--json"]].concat())
        .exit(1)
        .json();
    let plugin = &report["plugins"][0];
    assert_eq!(report["outputs_different"], 0, "core is replayed by what was recorded");
    assert_eq!(plugin["component"]["other"], true, "{plugin}");
    assert_eq!(plugin["different_steps"].as_array().map(Vec::len), Some(2), "{plugin}");
    assert_eq!(report["first_difference"]["kind"], "step", "{report}");
    assert_eq!(report["first_difference"]["differs"][0], "requests", "{report}");
}

#[test]
fn what_cannot_be_replayed_is_refused_in_one_line() {
    let (mission, log) = flown();
    let refused = |log: &Path, arguments: &[&str]| replay(log, arguments).refusal();
    let says = |line: String, parts: &[&str]| {
        for part in parts {
            assert!(line.contains(part), "{part}: {line}");
        }
    };
    says(
        refused(&mission.path().join("mission.toml"), &[]),
        &["expected the log of a run", "mission.toml is no MCAP file"],
    );
    says(refused(Path::new("/nowhere.mcap"), &["--json"]), &["/nowhere.mcap"]);
    says(
        refused(&log, &["--plugin", "nobody=/nowhere.wasm"]),
        &["--plugin nobody=/nowhere.wasm"],
    );
    let template = plugins().join("template.wasm");
    let template = template.display();
    says(
        refused(&log, &["--plugin", &format!("nobody={template}")]),
        &["--plugin nobody: the run had no plugin of this name; it had "],
    );
    says(
        refused(&log, &["--set", "limits.speed_max_mps=1"]),
        &["expected plugin.NAME.config.KEY=VALUE"],
    );
    // The plugin's config comes from these options, and its grants from the run.
    let config = mission.beside("other.toml");
    let of_file = format!("pilot={}", config.display());
    let of_file = ["--config", &of_file];
    fs::write(&config, "heading_deg = 1\nheading_deg = = 2\n").expect("the folder can be written");
    says(refused(&log, &of_file), &["other.toml, line 2: "]);
    fs::write(&config, "heading_deg = inf\n").expect("the folder can be written");
    says(
        refused(&log, &of_file),
        &[
            "config: heading_deg is inf, expected a finite number",
            "(in ",
            "other.toml)",
        ],
    );
    fs::write(&config, "faultt = \"none\"\n").expect("the folder can be written");
    says(refused(&log, &of_file), &["faultt", "other.toml)"]);
    let set = ["--set", "plugin.pilot.config.heading_deg=nan"];
    says(refused(&log, &set), &["config: heading_deg is NaN", "(in --set)"]);
    let both = ["--set", "plugin.pilot.config.heading_deg=2"];
    says(
        refused(&log, &[of_file, both].concat()),
        &["--config pilot: --set also changes the config of pilot"],
    );
    for set in [
        "plugin.pilot.config.heading_deg=\"east\"",
        "plugin.nobody.config.heading_deg=1",
    ] {
        let line = refused(&log, &["--set", set]);
        assert!(!line.contains("cannot be replayed"), "{line}");
    }
    let empty = mission.beside("empty.wasm");
    fs::write(&empty, "").expect("the folder can be written");
    let line = refused(&log, &["--plugin", &format!("pilot={}", empty.display())]);
    assert!(
        line.contains("empty.wasm") && !line.contains("cannot be replayed"),
        "{line}"
    );
    let coverage = plugins().join("coverage.wasm");
    says(
        refused(&log, &["--plugin", &format!("pilot={}", coverage.display())]),
        &["coverage.wasm: it needs `insert`, which the run did not grant pilot"],
    );
    says(
        refused(&changed(&log, b"\"input\":\"start\"", b"\"input\":\"nonse\""), &[]),
        &["of /core/input is invalid", "nonse"],
    );

    // The log of another version.
    let mut bytes = fs::read(&log).expect("the log can be read");
    let format = b"format\x01\0\0\0";
    let place = bytes.windows(format.len()).position(|part| part == format);
    bytes[place.expect("the format is in the metadata") + format.len()] = b'9';
    let other = mission.beside("other.mcap");
    fs::write(&other, &bytes).expect("the log can be written");
    says(refused(&other, &[]), &["has format \"9\"", "reads format 2 only"]);

    // A killed process leaves a log without its end.
    let half = mission.beside("half.mcap");
    bytes = fs::read(&log).expect("the log can be read");
    fs::write(&half, &bytes[..bytes.len() * 2 / 3]).expect("the log can be written");
    let text = replay(&half, &[]).exit(0);
    assert!(text.stdout.contains("cut short: the process was killed"), "{text}");

    // One that was killed before its first input was on the disk.
    let empty = mission.beside("empty.mcap");
    fs::write(&empty, &bytes[..first_chunk(&bytes)]).expect("the log can be written");
    says(
        refused(&empty, &["--json"]),
        &["empty.mcap", "there is nothing to replay"],
    );
}

#[test]
fn damage_is_told_with_its_place_in_the_file_and_in_the_run() {
    let (mission, log) = flown();
    let mut bytes = fs::read(&log).expect("the log can be read");
    // In the last third are only chunks of messages and the index.
    let at = bytes.len() * 2 / 3;
    bytes[at] ^= 1;
    let damaged = mission.beside("damaged.mcap");
    fs::write(&damaged, &bytes).expect("the log can be written");
    let line = replay(&damaged, &[]).refusal();
    let (_, place) = line.split_once("in the record at byte ").expect("it says where");
    let (byte, after) = place.split_once(", after ").expect("it says when");
    let byte: usize = byte.parse().expect("a number");
    assert!(byte < at && bytes[byte] == CHUNK, "{line}");
    let seconds = after
        .split_once(" s of the run")
        .and_then(|(seconds, _)| seconds.parse::<f64>().ok());
    assert!(seconds.is_some_and(|seconds| (1.0..300.0).contains(&seconds)), "{line}");
}

/// The component that was not written yet is not "large".
#[test]
fn a_log_that_was_cut_in_its_header_says_so() {
    let (mission, log) = flown();
    let bytes = fs::read(&log).expect("the log can be read");
    let cut = mission.beside("cut.mcap");
    let mut said = std::collections::BTreeSet::new();
    for length in (100..first_chunk(&bytes)).step_by(997) {
        fs::write(&cut, &bytes[..length]).expect("the log can be written");
        let line = replay(&cut, &[]).refusal();
        assert!(
            line.contains("cut short") || line.contains("nothing to replay"),
            "{length}: {line}"
        );
        said.insert(line);
    }
    let of_component = "it was cut short before its components/pilot.wasm was written";
    assert!(said.iter().any(|line| line.contains(of_component)), "{said:#?}");
}

/// The place of the first chunk, which has the first messages.
fn first_chunk(bytes: &[u8]) -> usize {
    let mut at = 8;
    while bytes[at] != CHUNK {
        let length = bytes[at + 1..at + 9].iter().rev();
        at += 9 + length.fold(0, |length, byte| length << 8 | usize::from(*byte));
    }
    at
}

/// The disk was too slow: what follows cannot be replayed, and the line says where.
#[test]
fn past_a_gap_a_replay_is_refused() {
    let (_mission, log) = flown();
    let returned = br#"{"input":"returned","plugin":0"#;
    let gap = br#"{"input":"gap","since_s":0.5,"records":7}"#;
    let finished = replay(&replaced(&log, returned, gap), &[]).exit(2);
    for part in [
        "7 records are missing from 0.500 s to ",
        "nothing after that can be replayed",
    ] {
        assert!(
            finished.stdout.contains(part) && finished.stderr.contains(part),
            "{part}: {finished}"
        );
    }
    assert!(finished.stderr.contains("what comes before is identical"), "{finished}");
    let finished = replay(&replaced(&log, returned, gap), &["--json"]).exit(2);
    let report = finished.json();
    assert!(report["identical"].is_null(), "{report}");
    assert_eq!(
        (&report["refused"]["why"], &report["refused"]["records"]),
        (&"gap".into(), &7.into())
    );
}

#[test]
fn a_map_is_never_written_over_a_file_that_is_no_picture() {
    let (mission, log) = flown();
    let bytes = fs::read(&log).expect("the log can be read");
    let link = mission.beside("link.svg");
    std::os::unix::fs::symlink(&log, &link).expect("a link can be made");
    for map in [&log, &link] {
        let refused = replay(&log, &["--map", map.to_str().unwrap_or_default()]).exit(2);
        assert!(refused.stderr.contains("the file is no picture"), "{refused}");
        assert!(fs::read(&log).is_ok_and(|now| now == bytes), "the log has changed");
    }
    // Nor over the log that the run itself writes.
    let both = mission.beside("both");
    let flown = Backseat::new()
        .args(["sim", "--log"])
        .arg(&both)
        .arg("--map")
        .arg(&both)
        .mission(&mission)
        .run()
        .exit(2);
    assert!(flown.stderr.contains("the file is no picture"), "{flown}");
    assert!(fs::read(&both).is_ok_and(|log| log.starts_with(b"\x89MCAP")));
    // A picture takes the place of a picture.
    let map = mission.beside("map.svg");
    for _ in 0..2 {
        let drawn = replay(&log, &["--map", map.to_str().unwrap_or_default()]);
        assert_eq!(drawn.code, Some(0), "{drawn}");
    }
}

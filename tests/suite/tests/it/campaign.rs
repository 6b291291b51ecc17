//! `campaign`: many runs, stopped and continued, in shards, and compared.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use backseat_suite::{Backseat, Finished, eventually};
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a copy of a short mission, and a campaign of two variants, two parameters and three seeds.
fn studied() -> TempDir {
    let folder = TempDir::new().expect("there is room");
    copy(
        &backseat_test_support::workspace().join("missions/isobath"),
        &folder.path().join("isobath"),
    );
    write(
        folder.path(),
        "campaign.toml",
        "missions = [\"isobath\"]\nseeds = \"1..3\"\npoints = 2\n\
         [set]\nworld.plan.1.timeout_s = 100\n\
         [[variant]]\nname = \"slow\"\nset = { \"plugin.isobath.config.speed_mps\" = 1.2 }\n\
         [[variant]]\nname = \"fast\"\nset = { \"plugin.isobath.config.speed_mps\" = 1.8 }\n\
         [[parameter]]\nkey = \"world.sensors.altitude_noise_m\"\nfrom = 0.05\nto = 0.5\nspread = \"latin-hypercube\"\n\
         [[parameter]]\nkey = \"world.current.speed_mps\"\nfrom = 0.0\nto = 0.3\nspread = \"seed\"\n\
         [report]\nmeasure = \"contour_rms_m\"\n",
    );
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("there is room");
    for entry in fs::read_dir(from).expect("the mission is there") {
        let entry = entry.expect("it can be read");
        if entry.file_type().expect("it has a type").is_file() {
            fs::copy(entry.path(), to.join(entry.file_name())).expect("there is room");
        }
    }
}

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).expect("there is room");
}

fn campaign(folder: &TempDir, arguments: &[&str]) -> Backseat {
    Backseat::new()
        .in_folder(folder.path())
        .arg("campaign")
        .args(arguments.iter().copied())
}

/// Runs a command to its end, with this exit code.
fn ends(command: Backseat, code: i32) -> Finished {
    command.run().exit(code)
}

fn rows(folder: &TempDir, out: &str) -> Vec<u8> {
    fs::read(folder.path().join(out).join("runs.parquet")).expect("the campaign is whole")
}

fn journal(folder: &TempDir, out: &str) -> PathBuf {
    folder.path().join(out).join("journal/1-of-1.journal")
}

/// The campaigns that the page of the reference plugins names can be flown: here their first pair of runs. That of the plugin
/// in Python needs a component which `cargo xtask python` builds.
#[test]
fn the_campaigns_of_the_reference_plugins_can_be_flown() {
    let folder = TempDir::new().expect("there is room");
    let campaigns = backseat_test_support::workspace().join("missions/campaigns");
    let mut flown = 0;
    for entry in fs::read_dir(campaigns).expect("they are there") {
        let file = entry.expect("it can be read").path();
        let name = file
            .file_stem()
            .and_then(|name| name.to_str())
            .expect("a name")
            .to_owned();
        if name == "thermocline" {
            continue;
        }
        let command = Backseat::new()
            .in_folder(folder.path())
            .args(["campaign", "--shard", "1/200", "--out", &name])
            .arg(&file)
            .run();
        // Some variants are there to miss what the mission expects.
        assert!(matches!(command.code, Some(0 | 1)), "{command}");
        let journal = folder.path().join(&name).join("journal/1-of-200.journal");
        assert!(fs::metadata(journal).expect("a journal").len() > 500, "{command}");
        flown += 1;
    }
    assert_eq!(flown, 4, "as many as the page has");
}

#[test]
fn a_campaign_is_flown_compared_and_reported() {
    let folder = studied();
    // Legs of some minutes meet no expectation of the mission.
    let output = ends(campaign(&folder, &["campaign.toml", "--out", "all"]), 1);
    let text = &output.stdout;
    for part in [
        "slow",
        "fast compared with slow, seed by seed:",
        "contour rms, m",
        "report: all/report.html; rows: all/runs.parquet",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // For programs, the same figures and more: margins of safety too.
    let shown = ends(campaign(&folder, &["show", "all", "--json"]), 0);
    let shown: Value = serde_json::from_str(&shown.stdout).expect("one JSON object");
    assert_eq!(shown["variants"][1]["variant"], "fast");
    assert_eq!(shown["variants"][1]["flown"], 6);
    let has = |list: &str, key: &str, value: &str| {
        let list = shown[list].as_array().expect("a list");
        list.iter()
            .any(|entry| entry[key] == value && entry["variant"] == "fast")
    };
    assert!(has("measures", "measure", "margin.clearance"), "{shown}");
    assert!(has("comparisons", "measure", "margin.clearance"), "{shown}");
    assert!(has("comparisons", "compared_with", "slow"), "{shown}");
    let report = fs::read_to_string(folder.path().join("all/report.html")).expect("it was written");
    for part in [
        "12 runs: 1 mission x 2 variants x 2 points x 3 seeds",
        "How many runs passed",
        "Which parameter moves contour rms, m",
        "world.sensors.altitude_noise_m",
        "backseat sim isobath --seed",
        "flown: plugin steers",
    ] {
        assert!(report.contains(part), "{part}");
    }
    assert!(
        !report.contains("http://") || !report.contains("<script"),
        "it needs no network"
    );
    // The command that a row names flies the same run.
    let replay = report
        .split("<code>backseat ")
        .nth(1)
        .and_then(|rest| rest.split("</code>").next())
        .expect("the worst run has its command");
    let words: Vec<&str> = replay.split(' ').collect();
    let flown = Backseat::new().in_folder(folder.path()).args(words).arg("--json").run();
    let flown: Value = serde_json::from_str(&flown.stdout).expect("it printed a report");
    let digest = flown["digest"].as_str().expect("it has one");
    let rows = String::from_utf8_lossy(&rows(&folder, "all")).into_owned();
    assert!(rows.contains(digest), "{replay} has another digest");
}

#[test]
fn a_stopped_campaign_and_shards_give_the_same_bytes() {
    let folder = studied();
    ends(campaign(&folder, &["campaign.toml", "--out", "all"]), 1);
    let whole = rows(&folder, "all");

    // Killed after some rows, then stopped by its own time, then whole.
    let mut process = campaign(&folder, &["campaign.toml", "--out", "parts", "--workers", "1"]).spawn();
    let began = journal(&folder, "parts");
    eventually(
        Duration::from_secs(60),
        || fs::metadata(&began).ok().filter(|file| file.len() > 1500),
        || "no row was written".to_owned(),
    );
    process.kill();
    let stopped = ends(
        campaign(&folder, &["campaign.toml", "--out", "parts", "--stop-after", "0.2s"]),
        75,
    );
    assert!(
        stopped.stderr.contains("the same command goes on"),
        "{}",
        stopped.stderr
    );
    let stopped = ends(
        campaign(
            &folder,
            &["campaign.toml", "--out", "parts", "--stop-after", "0.01s", "--json"],
        ),
        75,
    );
    let result: Value = serde_json::from_str(&stopped.stdout).expect("one object");
    assert_eq!(
        (&result["stopped"], &result["runs"]),
        (&Value::from(true), &Value::from(12))
    );
    // A power loss leaves a damaged end.
    let mut damaged = fs::OpenOptions::new().append(true).open(&began).expect("it is there");
    damaged.write_all(&[7; 300]).expect("there is room");
    let went_on = ends(campaign(&folder, &["campaign.toml", "--out", "parts"]), 1);
    assert!(
        went_on
            .stderr
            .contains("the journal is damaged: its last 300 bytes are cut off"),
        "{went_on}"
    );
    assert!(rows(&folder, "parts") == whole, "the killed campaign has other bytes");

    for count in [2, 7] {
        let out = format!("in-{count}");
        for shard in 1..=count {
            let shard = format!("{shard}/{count}");
            ends(
                campaign(&folder, &["campaign.toml", "--out", &out, "--shard", &shard]),
                0,
            );
        }
        ends(campaign(&folder, &["merge", &out]), 1);
        assert!(rows(&folder, &out) == whole, "{count} shards have other bytes");
    }
}

#[test]
fn what_does_not_belong_together_is_refused_in_a_line() {
    let folder = studied();
    let refused = |arguments: &[&str], expected: &str| {
        let error = campaign(&folder, arguments).run().refusal();
        assert!(error.contains(expected), "{arguments:?}: {error}");
    };
    for shard in ["1/3", "3/3"] {
        ends(
            campaign(&folder, &["campaign.toml", "--out", "gap", "--shard", shard]),
            0,
        );
    }
    refused(&["merge", "gap"], "runs are missing: 4 of them (4..7)");
    refused(
        &["campaign.toml", "--out", "gap", "--shard", "1/2"],
        "is flown in 3 shards: give --shard I/3",
    );
    refused(&["merge", "gap", "gap"], "is given twice");
    refused(
        &["campaign.toml", "--out", "new", "--set", "world.current.speed_mps=0.1"],
        "sets world.current.speed_mps itself",
    );
    refused(
        &["campaign.toml", "--out", "gap", "--seeds", "1..4"],
        "another campaign: its seeds are 1..3",
    );
    let output = ends(
        campaign(&folder, &["campaign.toml", "--out", "new", "--shard", "4/3"]),
        2,
    );
    assert!(output.stderr.contains("expected I/N with I from 1 to N"), "{output}");
    refused(
        &["isobath/mission.toml", "--out", "new"],
        "is a mission: give its folder, isobath, or a campaign's file",
    );
    let output = ends(
        campaign(&folder, &["campaign.toml", "--out", "few", "--shard", "2/1000"]),
        0,
    );
    assert!(
        output
            .stderr
            .contains("shard 2/1000 has no runs: the campaign has 12 runs"),
        "{output}"
    );
    refused(
        &["nothing.toml", "--out", "new"],
        "expected a campaign's file or a mission's folder",
    );
    refused(
        &["isobath", "--out", "new", "--set", "limits.speed_max_mpss=1.0"],
        "did you mean `speed_max_mps`?",
    );
    refused(
        &["isobath", "--out", "new", "--set", "world.current.sped_mps=1.0"],
        "did you mean `speed_mps`?",
    );
    refused(
        &["isobath", "--out", "isobath"],
        "is not a campaign's: give a new or empty folder",
    );
    refused(&["show", "gap"], "has no runs.parquet yet");
    refused(&["merge", "isobath"], "has no manifest.json");
    // A mission that changed since, and a component.
    let world = folder.path().join("isobath/world.toml");
    let before = fs::read_to_string(&world).expect("it is there");
    fs::write(&world, format!("{before}\n# changed\n")).expect("there is room");
    refused(
        &["campaign.toml", "--out", "gap", "--shard", "2/3"],
        "world.toml of isobath, or its grid, has changed",
    );
    fs::write(&world, before).expect("there is room");
    let old = backseat_test_support::workspace().join("tests/suite/components/isobath-0.1.0.wasm");
    let plugins = folder.path().join("plugins");
    fs::create_dir(&plugins).expect("there is room");
    fs::copy(old, plugins.join("isobath.wasm")).expect("there is room");
    refused(
        &[
            "campaign.toml",
            "--out",
            "gap",
            "--shard",
            "2/3",
            "--plugins",
            "plugins",
        ],
        "the component of isobath/fast/isobath has changed",
    );
}

#[test]
fn a_run_that_cannot_be_flown_is_a_row() {
    let folder = studied();
    write(
        folder.path(),
        "range.toml",
        "missions = [\"isobath\"]\nseeds = \"1\"\n[set]\nworld.plan.1.timeout_s = 60\n\
         [[parameter]]\nkey = \"limits.turn_rate_dps\"\nvalues = [8.0, -1.0]\n",
    );
    let output = ends(campaign(&folder, &["range.toml", "--out", "range"]), 1);
    let report = fs::read_to_string(folder.path().join("range/report.html")).expect("it was written");
    assert!(
        report.contains("1 x isobath/mission.toml: limits.turn_rate_dps is -1"),
        "{report}"
    );
    assert!(output.stdout.contains("not flown"), "{}", output.stdout);
}

#[test]
fn faults_are_drawn_and_a_run_with_them_can_be_flown_alone() {
    let folder = studied();
    write(
        folder.path(),
        "faults.toml",
        "missions = [\"isobath\"]\nseeds = \"1..4\"\n[set]\nworld.plan.1.timeout_s = 600\n\
         [faults]\ncount = [3, 9]\nfrom_s = 30\nuntil_s = 500\n",
    );
    let output = campaign(&folder, &["faults.toml", "--out", "faults", "--json"]).run();
    let result: Value = serde_json::from_str(&output.stdout).expect("one object");
    assert_eq!(result["runs"], 4);
    assert_eq!(
        (&result["violations"], &result["not_flown"]),
        (&Value::from(0), &Value::from(0))
    );
    let alone = |seed: &str| {
        let arguments = [
            "sim",
            "isobath",
            "--seed",
            seed,
            "--draw-faults",
            "3..9@30..500",
            "--json",
        ];
        let output = Backseat::new()
            .in_folder(folder.path())
            .args(arguments)
            .args(["--set", "world.plan.1.timeout_s=600"])
            .run();
        let report: Value = serde_json::from_str(&output.stdout).expect("one object");
        report["digest"].as_str().expect("it has one").to_owned()
    };
    let text = String::from_utf8_lossy(&rows(&folder, "faults")).into_owned();
    for seed in ["1", "2", "3", "4"] {
        assert!(text.contains(&alone(seed)), "seed {seed} has another digest");
    }
}

#[test]
fn a_mission_that_changes_in_mid_campaign_stops_it() {
    let folder = studied();
    let process = campaign(
        &folder,
        &["campaign.toml", "--out", "changed", "--workers", "1", "--seeds", "1..8"],
    )
    .spawn();
    let began = journal(&folder, "changed");
    eventually(
        Duration::from_secs(60),
        || fs::metadata(&began).ok().filter(|file| file.len() > 1000),
        || "no row was written".to_owned(),
    );
    let world = folder.path().join("isobath/world.toml");
    let before = fs::read_to_string(&world).expect("it is there");
    fs::write(&world, before.replace("slope = [0.02", "slope = [0.03")).expect("there is room");
    let mut process = process;
    assert_eq!(process.wait(Duration::from_secs(60)), Some(2));
    assert!(
        process.stderr().contains("changed or gone while the campaign flies"),
        "{}",
        process.stderr()
    );
    fs::write(&world, before).expect("there is room");
    ends(
        campaign(&folder, &["campaign.toml", "--out", "changed", "--seeds", "1..8"]),
        1,
    );
    ends(
        campaign(&folder, &["campaign.toml", "--out", "all", "--seeds", "1..8"]),
        1,
    );
    assert!(
        rows(&folder, "changed") == rows(&folder, "all"),
        "rows are of two missions"
    );
}

#[test]
fn what_the_report_shows_can_be_corrected_afterwards() {
    let folder = studied();
    let file = folder.path().join("campaign.toml");
    let right = fs::read_to_string(&file).expect("it is there");
    fs::write(&file, right.replace("contour_rms_m", "contour_rmss")).expect("there is room");
    let error = campaign(&folder, &["campaign.toml", "--out", "all"]).run();
    assert!(error.stderr.contains("report.measure is `contour_rmss`"), "{error}");
    fs::write(&file, format!("# corrected\n{right}")).expect("there is room");
    let output = ends(campaign(&folder, &["campaign.toml", "--out", "all"]), 1);
    assert!(output.stdout.contains("report: all/report.html"), "{output}");
    assert!(!output.stderr.contains("the report lacks pictures"), "{output}");
    // Without its mission the report is written again without pictures, and says so.
    fs::rename(folder.path().join("isobath"), folder.path().join("elsewhere")).expect("it can be moved");
    let output = ends(campaign(&folder, &["report", "all"]), 0);
    assert!(output.stderr.contains("the report lacks pictures of runs"), "{output}");
}

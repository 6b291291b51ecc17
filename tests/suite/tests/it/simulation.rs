//! `backseat sim`: its report, its digest, its files, its pace, its exit code.

use backseat_recorder::{Log, read};
use backseat_suite::{Backseat, Finished, Mission};

fn fly(mission: &Mission, arguments: &[&str]) -> Finished {
    Backseat::new().arg("sim").mission(mission).args(arguments).run()
}

fn log_of(mission: &Mission, seed: &str) -> Log {
    let path = mission.beside("run.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--seed", seed, "--log"])
        .arg(&path)
        .mission(mission)
        .run();
    assert_eq!(report.code, Some(0), "{report}");
    read(&path).expect("the log can be read")
}

#[test]
fn the_seed_decides_every_byte_and_a_good_mission_exits_0() {
    let mission = Mission::copy("isobath");
    let first = fly(&mission, &["--seed", "7", "--json"]).exit(0).json();
    let again = fly(&mission, &["--seed", "7", "--json"]).exit(0).json();
    let other = fly(&mission, &["--seed", "8", "--json"]).exit(0).json();
    let digest = first["digest"].as_str().unwrap();
    assert!(
        digest.len() == 64 && digest.bytes().all(|byte| byte.is_ascii_hexdigit()),
        "{digest}"
    );
    assert_eq!(first["digest"], again["digest"]);
    assert_ne!(first["digest"], other["digest"]);
}

#[test]
fn the_json_report_has_every_key_that_is_promised() {
    let mission = Mission::steady();
    let finished = fly(&mission, &["--seed", "3", "--json"]).exit(0);
    // The seabed that this seed draws is deeper and steeper in places than the mission's limits say.
    assert!(
        finished.stderr.lines().all(|line| line.contains(" WARN world: ")),
        "a good run with --json has nothing else to say beside it: {}",
        finished.stderr
    );
    let report = finished.json();
    for key in [
        "mission",
        "seed",
        "outcome",
        "sim_seconds",
        "wall_seconds",
        "load_seconds",
        "requests",
        "violations",
        "digest",
    ] {
        assert!(
            report.get(key).is_some_and(|value| !value.is_null()),
            "{key} is missing: {report}"
        );
    }
    for key in [
        "proposed",
        "rejected",
        "replaced",
        "withdrawn",
        "waiting",
        "sent",
        "accepted",
        "failed",
        "unanswered",
        "undecided",
    ] {
        assert!(report["requests"][key].is_u64(), "requests.{key} is missing: {report}");
    }
    assert_eq!((&report["mission"], &report["seed"]), (&"steady".into(), &3.into()));
    assert_eq!(report["outcome"], "completed");
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0));
    assert!(report["sim_seconds"].as_f64().unwrap() > 600.0, "{report}");
    assert!(report["wall_seconds"].as_f64().unwrap() > 0.0 && report["load_seconds"].as_f64().unwrap() > 0.0);
    assert!(report["requests"]["accepted"].as_u64().unwrap() > 0, "{report}");
}

#[test]
fn without_json_the_report_is_for_people() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let report = fly(&mission, &["--seed", "3"]).exit(0);
    assert!(report.stdout.contains("steady, seed 3: completed"), "{report}");
    assert!(
        report.stdout.contains("no violation") && report.stdout.contains("digest "),
        "{report}"
    );
}

#[test]
fn what_a_plugin_publishes_is_reported_and_judged() {
    let mission = Mission::copy("isobath").append(
        "world.toml",
        "[[expect.measure]]\nname = \"isobath.slope\"\nat_least = 0.1\nat_most = 0.2\n\n\
         [[expect.measure]]\nname = \"contour_rms_m\"\nat_most = 100\n\n\
         [[expect.measure]]\nname = \"isobath.salinity\"\n",
    );
    let report = Backseat::new()
        .args(["sim", "--json"])
        .mission(&mission)
        .run()
        .exit(1)
        .json();
    let slope = &report["published"]["isobath.slope"];
    assert_eq!(slope["unit"], "%");
    let percent = slope["value"].as_f64().unwrap();
    assert!(percent > 0.2, "{report}");
    assert_eq!(
        report["unmet"],
        serde_json::json!([
            format!("isobath.slope is {percent:.3} %, expected at most 0.2 %"),
            "isobath.salinity was not measured"
        ])
    );
    let backward = Mission::copy("isobath").append(
        "world.toml",
        "[[expect.measure]]\nname = \"isobath.slope\"\nat_least = 2\nat_most = 1\n",
    );
    let refused = Backseat::new().args(["sim"]).mission(&backward).run().exit(2);
    assert!(
        refused
            .stderr
            .contains("expect.measure.at_most is 1, expected at_least or more"),
        "{refused}"
    );
}

#[test]
fn the_report_says_when_there_was_control_and_how_a_plugin_failed_first() {
    let mission = Mission::steady();
    let report = Backseat::new()
        .args(["sim", "--json"])
        .mission(&mission)
        .run()
        .exit(0)
        .json();
    let windows = report["control"]["windows"].as_array().unwrap();
    let (from, until) = (&windows[0]["from_s"], &windows[windows.len() - 1]["until_s"]);
    let text = fly(&mission, &[]).exit(0).stdout;
    let line = text.lines().find(|line| line.trim().starts_with("control: ")).unwrap();
    assert!(
        line.contains(&format!("{from}-")) && line.contains(&format!("-{until} s")),
        "{line}"
    );
    // A plan that lets nobody in.
    let closed = Mission::steady().edit("world.toml", "dynamic = true", "dynamic = false");
    let report = fly(&closed, &[]);
    assert!(
        report
            .stdout
            .contains("control: never; the rest of the time: the vehicle has control ("),
        "{report}"
    );
    let failing = Mission::steady().edit("mission.toml", "fault = \"none\"", "fault = \"error\"");
    let report = fly(&failing, &[]);
    let line = report.stdout.lines().find(|line| line.contains(" failed ")).unwrap();
    assert!(
        line.contains(" times, first at ") && line.ends_with(" s: faulty was told to fail"),
        "{line}"
    );
    // A plugin that could not be started again to the end is a failed run, whatever the mission expects.
    assert!(
        report.stdout.contains("plugin pilot was quarantined at ") && !report.stdout.contains("expectation not met"),
        "{report}"
    );
    let _failed = report.exit(1);
    // A panic is told with its place and its words, and not only as the trap in which it ends.
    let panicking = Mission::steady().edit("mission.toml", "fault = \"none\"", "fault = \"trap\"");
    let report = fly(&panicking, &[]);
    let line = report
        .stdout
        .lines()
        .find(|line| line.contains(" times, first at "))
        .unwrap();
    assert!(
        line.contains(" s: panicked at plugins/faulty/src/lib.rs:") && line.ends_with(": faulty was told to panic"),
        "{line}"
    );
}

#[test]
fn the_map_shows_the_fence_and_the_way() {
    let mission = Mission::steady();
    let path = mission.beside("run.svg");
    let _report = Backseat::new()
        .args(["sim", "--json", "--map"])
        .arg(&path)
        .mission(&mission)
        .run()
        .exit(0);
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(
        svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"),
        "{}",
        &svg[..200.min(svg.len())]
    );
    assert!(
        svg.contains("steady") && svg.contains("box"),
        "mission and fence are named"
    );
    assert!(svg.contains("flown: plugin steers"), "its way is in the legend");
    let unsteered = mission.edit("mission.toml", "[\"modify\"]", "[]");
    let _report = Backseat::new()
        .args(["sim", "--map"])
        .arg(&path)
        .mission(&unsteered)
        .run()
        .exit(0);
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(
        svg.contains("flown: front seat steers") && !svg.contains("flown: plugin steers"),
        "only what was flown"
    );
}

#[test]
fn the_log_is_read_back_whole() {
    let mission = Mission::steady();
    let log = log_of(&mission, "5");
    assert!(log.complete);
    assert_eq!((log.run.mission.as_str(), log.run.seed), ("steady", Some(5)));
    let mut heard = 0;
    let mut said = 0;
    for (_, from_vehicle, bytes) in log.link() {
        let text = String::from_utf8_lossy(bytes);
        let (count, name) = if from_vehicle {
            (&mut heard, "$BFNVG,")
        } else {
            (&mut said, "$BPRMB,")
        };
        *count += text.matches(name).count();
    }
    assert!(heard > 6_000, "navigation at 10 Hz for ten minutes: {heard}");
    assert!(said > 500, "a modify each second for ten minutes: {said}");
    let notes: Vec<&str> = log.notes().map(|(_, text)| text).collect();
    assert!(notes.contains(&"control granted"), "{notes:?}");
    assert!(
        notes
            .iter()
            .any(|note| note.contains("Modify") && note.contains("accepted")),
        "{notes:?}"
    );
    for name in ["mission.toml", "fence.geojson", "components/pilot.wasm"] {
        assert!(log.attachment(name).is_some_and(|data| !data.is_empty()), "{name}");
    }
    assert_eq!(
        log.attachment("fence.geojson").unwrap(),
        mission.read("fence.geojson").as_bytes()
    );
}

#[test]
fn a_log_changes_nothing() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let path = mission.beside("run.mcap");
    let with = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(path)
        .mission(&mission)
        .run()
        .exit(0)
        .json();
    let without = fly(&mission, &["--json"]).exit(0).json();
    assert_eq!(with["digest"], without["digest"]);
}

#[test]
fn a_speed_paces_the_run_and_changes_nothing() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let fastest = fly(&mission, &["--json"]).exit(0).json();
    let paced = fly(&mission, &["--json", "--speed", "50"]).exit(0).json();
    assert_eq!(fastest["digest"], paced["digest"]);
    let due_s = paced["sim_seconds"].as_f64().unwrap() / 50.0;
    let took_s = paced["wall_seconds"].as_f64().unwrap();
    assert!(took_s > 0.95 * due_s, "{took_s} s, due {due_s} s");
    assert!(took_s < 5.0 * due_s + 5.0, "{took_s} s, due {due_s} s");
}

#[test]
fn an_expectation_that_does_not_hold_exits_1() {
    let mission = Mission::steady()
        .edit("world.toml", "timeout_s = 600", "timeout_s = 60")
        .append("world.toml", "min_accepted = 100000");
    let report = fly(&mission, &["--json"]).exit(1).json();
    let unmet = report["unmet"].as_array().unwrap();
    assert!(
        unmet
            .iter()
            .any(|unmet| unmet.as_str().unwrap().contains("expected at least 100000")),
        "{report}"
    );
    let told = fly(&mission, &[]).exit(1);
    assert!(told.stdout.contains("expectation not met: "), "{told}");
}

#[test]
fn midnight_passes_inside_a_mission() {
    let mission = Mission::copy("plume");
    let log = log_of(&mission, "7");
    let mut stamps = Vec::new();
    for (_, from_vehicle, bytes) in log.link() {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let name = if from_vehicle { "$BFNVG," } else { "$BPSTS," };
        for line in text.lines().filter(|line| line.starts_with(name)) {
            stamps.push((from_vehicle, line[7..9].to_owned()));
        }
    }
    for from_vehicle in [true, false] {
        for hour in ["23", "00"] {
            assert!(
                stamps.contains(&(from_vehicle, hour.to_owned())),
                "from the vehicle {from_vehicle}, hour {hour}"
            );
        }
    }
    let late = log.entries.last().unwrap().now.as_secs_f64();
    let begun = log
        .notes()
        .filter(|(at, note)| at.as_secs_f64() > 1830.0 && note.contains("started"))
        .count();
    assert!(begun > 0, "inserts begin after midnight too; the run took {late} s");
}

#[test]
fn a_plugin_finds_objects_in_the_imagery_of_the_simulated_sonar() {
    let report = fly(&Mission::copy("reinspect"), &["--json"]).exit(0).json();
    let measure = |name: &str| report["measures"][name].as_f64().unwrap();
    assert!(measure("contacts_found") >= 4.0, "{report}");
    assert!(measure("contacts_false") <= 2.0, "{report}");
    assert!(measure("contacts_aspects") >= 4.0, "{report}");
}

/// A folder with a program `xdg-open` and nothing else.
fn viewer(script: &str) -> tempfile::TempDir {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let path = folder.path().join("xdg-open");
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("the folder is ours");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("the file is ours");
    folder
}

#[test]
fn a_map_is_opened_when_it_is_drawn_and_a_viewer_that_fails_is_no_error() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let (map, opened) = (mission.beside("run.svg"), mission.beside("opened"));
    let fly = |script: &str| {
        let viewer = viewer(script);
        Backseat::new()
            .args(["sim", "--open", "--map"])
            .arg(&map)
            .mission(&mission)
            .env("PATH", viewer.path())
            .run()
            .exit(0)
    };
    let shown = fly(&format!(
        "read -r first < \"$1\"; echo \"$1 $first\" > {}",
        opened.display()
    ));
    let told = std::fs::read_to_string(&opened).unwrap_or_else(|error| panic!("{error}: {shown}"));
    assert!(told.starts_with(&format!("{} <svg", map.display())), "{told}");
    let failed = fly("exit 3");
    assert!(
        failed.stderr.contains("WARN") && failed.stderr.contains("cannot be opened"),
        "{failed}"
    );
    let alone = Backseat::new().args(["sim", "--open"]).mission(&mission).run().exit(2);
    assert!(alone.stderr.contains("--map"), "{alone}");
}

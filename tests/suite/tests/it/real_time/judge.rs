//! The log of a real run can be judged: the runtime's side alone, by its own clock.

use std::path::PathBuf;
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Signal, Vehicle, settle};

use super::session::{SOON, runtime};

#[test]
fn the_log_of_a_real_run_is_clean() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 3, SOON);
    settle(Duration::from_secs(5));
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let logs: Vec<_> = std::fs::read_dir(mission.beside("logs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    let [log] = &logs[..] else { panic!("{logs:?}") };
    let finished = Backseat::new().args(["log", "judge", "--json"]).arg(log).run().exit(0);
    let report = finished.json();
    assert_eq!(
        (&report["seed"], &report["complete"]),
        (&serde_json::Value::Null, &serde_json::Value::Bool(true)),
        "{finished}"
    );
    let judged = |rule: &str| {
        let rules = report["rules"].as_array().unwrap();
        let row = rules.iter().find(|row| row["rule"] == rule).unwrap();
        row["judged"].as_u64().unwrap()
    };
    for rule in [
        "no-control",
        "modify-gap",
        "stale-navigation",
        "modify-margin",
        "stamp-repeated",
    ] {
        assert!(judged(rule) >= 3, "{rule}: {finished}");
    }
    assert_eq!(judged("truth-fence"), 0, "{finished}");
}

#[test]
fn a_log_in_parts_is_joined_and_is_judged_and_replayed_as_one() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm", "--log-split", "10s"]);
    runtime.says("the log goes on in", SOON);
    vehicle.receives("BPRMB", 3, SOON);
    settle(Duration::from_secs(14));
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let entries = std::fs::read_dir(mission.beside("logs")).unwrap();
    let mut parts: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    parts.sort();
    assert!(parts.len() >= 2, "{parts:?}");
    let later = &parts[1];
    for command in [&["log", "judge"][..], &["log", "report"], &["replay"]] {
        let refused = Backseat::new().args(command).arg(later).run().exit(2);
        assert!(
            refused.stderr.contains("part 2 of a log") && refused.stderr.contains("log join"),
            "{refused}"
        );
    }
    let info = Backseat::new()
        .args(["log", "info", "--json"])
        .arg(later)
        .run()
        .exit(0)
        .json();
    assert_eq!((&info["part"], &info["complete"]), (&2.into(), &true.into()), "{info}");
    let joined = mission.beside("joined.mcap");
    let made = Backseat::new()
        .args(["log", "join", "--output"])
        .arg(&joined)
        .args(&parts)
        .run()
        .exit(0);
    assert!(made.stdout.contains("parts"), "{made}");
    let judged = Backseat::new()
        .args(["log", "judge", "--json"])
        .arg(&joined)
        .run()
        .exit(0)
        .json();
    assert_eq!(
        (&judged["complete"], &judged["passed"]),
        (&true.into(), &true.into()),
        "{judged}"
    );
    let replayed = Backseat::new()
        .args(["replay", "--json"])
        .arg(&joined)
        .run()
        .exit(0)
        .json();
    assert_eq!(replayed["identical"], true, "{replayed}");
}

//! The log of a real run can be judged: the runtime's side alone, by its own clock.

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

//! The logs of real clocks and sockets are replayed to the same bytes.

use std::path::{Path, PathBuf};
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Signal, Vehicle, settle};
use serde_json::Value;

use super::session::{SOON, runtime};

#[track_caller]
fn replayed(log: &Path) -> Value {
    let finished = Backseat::new().args(["replay", "--json"]).arg(log).run().exit(0);
    let report = finished.json();
    assert_eq!(report["identical"], true, "{finished}");
    assert_eq!(
        (&report["rate"], &report["complete"]),
        (&"deployed".into(), &true.into()),
        "{finished}"
    );
    report
}

#[test]
fn the_log_of_a_dive_over_tcp_is_replayed() {
    // Beside the pilot, a plugin that traps again and again.
    let bad = "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = [\"modify\"]\n[plugin.config]\n\
               fault = \"trap\"\nafter_s = 2\n";
    let mission = Mission::steady().append("mission.toml", bad);
    let vehicle = Vehicle::start(&mission);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    let _ = vehicle.receives("BPRMB", 3, SOON);
    runtime.signal(Signal::USR1);
    settle(Duration::from_secs(2));
    runtime.signal(Signal::USR2);
    settle(Duration::from_secs(5));
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let logs: Vec<PathBuf> = std::fs::read_dir(mission.beside("logs"))
        .expect("the run has written a log")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    let [log] = &logs[..] else { panic!("{logs:?}") };
    let report = replayed(log);
    assert!(report["seed"].is_null(), "{report}");
    assert!(report["outputs"].as_u64() > Some(100), "{report}");
    let bad = &report["plugins"][1];
    assert!(
        bad["failures"].as_u64() > Some(0) && bad["restarts"].as_u64() > Some(0),
        "{report}"
    );
}

#[test]
fn the_log_of_a_flight_faster_than_life_is_replayed() {
    let mission = Mission::steady()
        .edit("world.toml", "timeout_s = 600", "timeout_s = 80")
        .edit("world.toml", "starts_after_s = 2", "starts_after_s = 5");
    let log = mission.beside("flight.mcap");
    let _ = Backseat::new()
        .args(["fly", "--speed", "20"])
        .mission(&mission)
        .arg("--log")
        .arg(&log)
        .run()
        .exit(0);
    let report = replayed(&log);
    assert!(report["plugins"][0]["steps"].as_u64() > Some(50), "{report}");
}

//! `backseat fly`: the mock vehicle and the runtime in one process, over TCP, faster than life.

use backseat_recorder::{Log, read};
use backseat_suite::{Backseat, Mission, Process, Signal, eventually};

use super::session::SOON;

/// The steady mission, over after a minute and a half.
fn short() -> Mission {
    Mission::steady()
        .edit("world.toml", "timeout_s = 600", "timeout_s = 80")
        .edit("world.toml", "starts_after_s = 2", "starts_after_s = 5")
}

fn fly(mission: &Mission, arguments: &[&str]) -> Backseat {
    Backseat::new()
        .arg("fly")
        .mission(mission)
        .args(arguments.iter().copied())
        .arg("--log")
        .arg(mission.beside("flight.mcap"))
}

fn log_of(mission: &Mission) -> Log {
    let log = read(&mission.beside("flight.mcap")).expect("the log can be read");
    assert!(log.complete, "the log has its end");
    log
}

/// When the runtime sent sentences of this name, seconds of the mission.
fn sent(log: &Log, name: &str) -> Vec<f64> {
    let sent = log.link().filter(|(_, received, _)| !received);
    sent.filter(|(_, _, bytes)| bytes.starts_with(name.as_bytes()))
        .map(|(at, _, _)| at.as_secs_f64())
        .collect()
}

#[test]
fn a_mission_is_flown_faster_than_life_and_its_log_can_be_judged() {
    let mission = short();
    let map = mission.beside("flight.svg");
    let flown = fly(&mission, &["--speed", "15", "--map", map.to_str().unwrap()])
        .run()
        .exit(0);
    assert!(
        flown.stdout.starts_with("steady, seed 1: completed after 1."),
        "it ends with its mission: {flown}"
    );
    assert!(std::fs::read_to_string(map).unwrap().starts_with("<svg"), "{flown}");

    let log = log_of(&mission);
    let modifies = sent(&log, "$BPRMB");
    assert!(modifies.len() > 40, "{} modifies: {flown}", modifies.len());
    let gaps = modifies.windows(2).map(|pair| pair[1] - pair[0]);
    let worst_s = gaps.fold(0.0, f64::max);
    assert!(worst_s < 3.0, "{worst_s:.3} s of the mission without a modify: {flown}");

    let judged = Backseat::new()
        .args(["log", "judge", "--json"])
        .arg(mission.beside("flight.mcap"))
        .run()
        .exit(0);
    let rules = judged.json()["rules"].as_array().unwrap().clone();
    let gap = rules.iter().find(|row| row["rule"] == "modify-gap").unwrap();
    assert!(gap["judged"].as_u64().unwrap() > 40, "{judged}");
}

#[test]
fn a_plugin_that_is_slow_in_life_is_not_too_slow_at_speed() {
    // Every ping and record passes two more connections here, and a plugin computes at each step.
    let mission = Mission::copy("coverage");
    let flown = fly(&mission, &["--speed", "20", "--duration", "120"]).run().exit(0);
    assert!(!flown.stderr.contains("coverage failed"), "{flown}");
    assert!(
        flown.stderr.contains("coverage says"),
        "the plugin hears the sonar: {flown}"
    );
    let _log = log_of(&mission);
}

fn ends_in_order(mission: &Mission, mut flight: Process, act: Signal) {
    flight.says("control granted", SOON);
    flight.says("steers", SOON);
    flight.signal(act);
    assert_eq!(flight.wait(SOON), Some(0), "{}", flight.stderr());
    let log = log_of(mission);
    let (modifies, ends) = (sent(&log, "$BPRMB"), sent(&log, "$BPEMB"));
    assert_eq!(ends.len(), 1, "the lease is ended: {}", flight.stderr());
    assert!(modifies.last() < ends.last(), "and not taken up again");
    assert!(
        flight.stdout().contains("steady, seed 1: unfinished after"),
        "{}",
        flight.stdout()
    );
}

#[test]
fn ctrl_c_ends_both_in_order() {
    let mission = Mission::steady();
    let flight = fly(&mission, &["--speed", "2"]).spawn();
    ends_in_order(&mission, flight, Signal::INT);
    let mission = Mission::steady();
    let flight = fly(&mission, &[]).spawn();
    ends_in_order(&mission, flight, Signal::TERM);
}

#[test]
fn a_hold_is_rehearsed_too() {
    let mission = Mission::steady();
    let state = mission.beside("state");
    let mut flight = fly(&mission, &["--speed", "4", "--state", state.to_str().unwrap()]).spawn();
    flight.says("control granted", SOON);
    flight.signal(Signal::USR1);
    let line = flight.says("no control: the operator's hold is set", SOON);
    let hold = state.join("hold");
    assert!(line.contains(hold.to_str().unwrap()), "{line}");
    // A thread of its own saves it.
    eventually(SOON, || hold.exists().then_some(()), || hold.display().to_string());
    flight.signal(Signal::USR2);
    flight.says("operator: release", SOON);
    flight.signal(Signal::INT);
    assert_eq!(flight.wait(SOON), Some(0), "{}", flight.stderr());
}

#[test]
fn a_speed_that_is_none_is_refused() {
    let mission = Mission::steady();
    for speed in ["0", "-1", "NaN", "inf", "1000", "max", ""] {
        let refused = fly(&mission, &["--speed", speed]).run().exit(2);
        assert!(
            refused.stderr.contains("--speed") && refused.stderr.contains("expected a number from 0.1 to 100"),
            "{refused}"
        );
        assert!(!mission.beside("flight.mcap").exists());
    }
    let _quick = fly(&mission, &["--speed", "100", "--duration", "5"]).run().exit(0);
    let seconds = log_of(&mission).entries.last().unwrap().now.as_secs_f64();
    assert!(seconds > 4.0, "{seconds} s");
}

#[test]
fn a_script_acts_in_a_flight_too() {
    let rules = "[[rule]]\nwhen = { received = \"BPRMB\" }\nnth = 5\ndo = \"abort\"";
    let mission = short().write("script.toml", rules);
    let script = mission.path().join("script.toml");
    let flown = fly(&mission, &["--speed", "15", "--script", script.to_str().unwrap()])
        .run()
        .exit(0);
    assert!(flown.stdout.starts_with("steady, seed 1: aborted after "), "{flown}");
    assert!(flown.stdout.contains(" no violation"), "{flown}");
    let modifies = sent(&log_of(&mission), "$BPRMB");
    assert!((5..=7).contains(&modifies.len()), "{modifies:?}");
}

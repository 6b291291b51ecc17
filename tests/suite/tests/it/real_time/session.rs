//! The mock vehicle and the runtime as two programs on one machine: who may steer, who starts first, who reconnects.

use std::time::Duration;

use backseat_suite::{Backseat, Line, Mission, Process, Signal, Vehicle, Way, eventually, free_address, settle};

/// Two debug builds that compile plugins on a busy machine are slow to start.
pub(crate) const SOON: Duration = Duration::from_secs(45);

/// The runtime, connected to an address, with a state folder of its own beside the mission.
pub(crate) fn runtime(mission: &Mission, address: &str, arguments: &[&str]) -> Process {
    command(mission, address, arguments).spawn()
}

/// The command that starts it.
pub(crate) fn command(mission: &Mission, address: &str, arguments: &[&str]) -> Backseat {
    Backseat::new()
        .args(["run", "--connect", address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .args(arguments)
        .mission(mission)
}

/// Sentences that only an armed runtime sends.
pub(crate) fn steers(line: &Line) -> bool {
    ["BPRMB", "BPRTK", "BPRTC"].iter().any(|name| line.is_received(name))
}

#[test]
fn an_armed_runtime_steers() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    let modify = vehicle.receives("BPRMB", 3, SOON);
    assert_eq!(
        (modify.field(2), modify.field(7)),
        ("90", "0"),
        "heading 90 and a heading's mode: {}",
        modify.text
    );
    vehicle.sees("an event of the modify", SOON, |line| {
        line.way == Way::Event && line.text.contains("heading 90.0 deg")
    });
    let subscribed = vehicle
        .lines()
        .into_iter()
        .find(|line| line.is_received("BPLOG"))
        .unwrap();
    assert_eq!(
        subscribed.field(1),
        "CTL",
        "the hand-over comes before all: {}",
        subscribed.text
    );
    runtime.signal(Signal::INT);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
}

#[test]
fn without_arm_nothing_is_sent_that_steers() {
    let mission = Mission::steady().edit("mission.toml", "[\"modify\"]", "[\"modify\", \"insert\"]");
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--first-identifier", "1"]);
    runtime.says("not armed", SOON);
    runtime.says("control granted", SOON);
    // Its plugin makes a request each second.
    runtime.says("the runtime is not armed", SOON);
    vehicle.receives("BPSTS", 1, SOON);
    settle(Duration::from_secs(4));
    let steering: Vec<Line> = vehicle.lines().into_iter().filter(steers).collect();
    assert!(steering.is_empty(), "{steering:?}");
}

#[test]
fn a_runtime_without_a_vehicle_tries_again_with_back_off() {
    let mission = Mission::steady();
    let address = free_address();
    let mut runtime = runtime(&mission, &address, &["--arm"]);
    let attempts = |runtime: &Process| {
        let said = runtime.stderr();
        said.lines()
            .filter(|line| line.contains("next attempt in"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let lines = eventually(
        SOON,
        || Some(attempts(&runtime)).filter(|lines| lines.len() >= 4),
        || format!("four attempts\n{}", runtime.stderr()),
    );
    let waits: Vec<f64> = lines
        .iter()
        .map(|line| {
            line.split("next attempt in ")
                .nth(1)
                .unwrap()
                .trim_end_matches(" s")
                .parse()
                .unwrap()
        })
        .collect();
    assert!(
        waits[0] <= 1.0 && waits[3] > waits[0] && waits.iter().all(|wait| *wait <= 15.0),
        "{waits:?}"
    );
    assert_eq!(runtime.ended(), None, "it does not give up");
    let said = runtime.stderr();
    assert!(said.contains(&address), "{said}");
    let about = |line: &&str| {
        let of_link = line.contains(&address) || line.contains("connect") || line.contains("attempt");
        of_link && !line.contains("armed: plugins may steer")
    };
    let told = said.lines().filter(about).count();
    assert!(told <= attempts(&runtime).len(), "one line for an attempt\n{said}");

    // A vehicle that starts later is found.
    let vehicle = Vehicle::start_at(&mission, &address);
    runtime.says("connected to the vehicle", SOON);
    vehicle.receives("BPRMB", 2, SOON);
}

#[test]
fn a_vehicle_that_restarts_is_subscribed_to_and_steered_again() {
    let mission = Mission::steady();
    let mut vehicle = Vehicle::start(&mission);
    let address = vehicle.address.clone();
    let runtime = runtime(&mission, &address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    vehicle.process.kill();
    runtime.says("next attempt in", SOON);
    let vehicle = Vehicle::start_at(&mission, &address);
    let modify = vehicle.receives("BPRMB", 2, SOON);
    let lines = vehicle.lines();
    let subscribed = lines
        .iter()
        .position(|line| line.is_received("BPLOG") && line.field(1) == "CTL");
    let steered = lines.iter().position(|line| line.is_received("BPRMB"));
    assert!(subscribed.is_some() && subscribed < steered, "{}", vehicle.story());
    for message in ["MIS", "NVG", "NVR", "ACK", "MBS", "MBE"] {
        let again = lines
            .iter()
            .any(|line| line.is_received("BPLOG") && line.field(1) == message);
        assert!(again, "{message} is not subscribed to anew\n{}", vehicle.story());
    }
    let granted = lines
        .iter()
        .find(|line| line.way == Way::Sent && line.name() == "BFCTL" && line.field(2) == "1");
    assert!(
        granted.unwrap().at_s <= modify.at_s,
        "nothing before the vehicle has handed over"
    );
}

#[test]
fn two_runtimes_logs_are_two_files_and_a_killed_ones_can_be_read() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    for _ in 0..2 {
        let mut runtime = runtime(&mission, &vehicle.address, &[]);
        runtime.says("control granted", SOON);
        settle(Duration::from_secs(6));
        runtime.kill();
    }
    let logs: Vec<_> = std::fs::read_dir(mission.beside("logs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(logs.len(), 2);
    for path in logs {
        let log = backseat_recorder::read(&path).unwrap();
        assert!(!log.complete, "it was killed");
        assert_eq!((log.run.mission.as_str(), log.run.seed), ("steady", None));
        assert!(
            log.notes().any(|(_, note)| note == "control granted"),
            "what is older than 3 s is there"
        );
    }
}

#[test]
fn a_vehicle_that_is_told_to_stop_leaves_its_log_whole() {
    let mission = Mission::steady();
    let mut vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &[]);
    runtime.says("connected to the vehicle", SOON);
    vehicle.receives("BPLOG", 1, SOON);
    vehicle.process.signal(Signal::TERM);
    assert_eq!(vehicle.process.wait(SOON), Some(0), "{}", vehicle.process.stderr());
    assert!(vehicle.log_text().ends_with('\n'), "no line is cut");
}

//! The messages to the service manager, and their absence.

use std::os::unix::net::UnixDatagram;
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Process, Signal, Vehicle, eventually, free_address, settle};

use super::session::SOON;

/// The watchdog is fed at half of this time.
const WATCHDOG: Duration = Duration::from_millis(1000);

/// The runtime, and the socket of its service manager.
fn served(mission: &Mission, address: &str, environment: &[(&str, &str)]) -> (Process, UnixDatagram) {
    let path = mission.beside("notify");
    let manager = UnixDatagram::bind(&path).expect("a socket of ours");
    manager.set_nonblocking(true).expect("a socket of ours");
    let mut command = Backseat::new()
        .args(["run", "--arm", "--connect", address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", WATCHDOG.as_micros().to_string());
    for (name, value) in environment {
        command = command.env(name, *value);
    }
    (command.mission(mission).spawn(), manager)
}

/// The messages since the last call.
fn told(manager: &UnixDatagram) -> Vec<String> {
    let mut buffer = [0; 256];
    let mut all = Vec::new();
    while let Ok(count) = manager.recv(&mut buffer) {
        all.push(String::from_utf8_lossy(&buffer[..count]).into_owned());
    }
    all
}

fn feeds(all: &[String]) -> usize {
    all.iter().filter(|state| *state == "WATCHDOG=1").count()
}

#[test]
fn sr_007_the_loop_that_serves_the_vehicle_feeds_the_watchdog_and_a_stopped_one_does_not() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let (mut runtime, manager) = served(&mission, &vehicle.address, &[]);
    let mut all = Vec::new();
    eventually(
        SOON,
        || {
            all.extend(told(&manager));
            (feeds(&all) >= 4).then_some(())
        },
        || format!("it is fed\n{}", runtime.stderr()),
    );
    assert_eq!(all[0], "READY=1", "{all:?}");
    assert_eq!(all.iter().filter(|state| *state == "READY=1").count(), 1, "{all:?}");
    vehicle.receives("BPRMB", 1, SOON);

    runtime.signal(Signal::STOP);
    settle(Duration::from_millis(100));
    told(&manager);
    settle(2 * WATCHDOG);
    assert_eq!(told(&manager), Vec::<String>::new(), "a stopped loop is a dead loop");

    runtime.signal(Signal::CONT);
    eventually(
        SOON,
        || (feeds(&told(&manager)) > 0).then_some(()),
        || "it goes on".to_owned(),
    );
    told(&manager);
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    assert_eq!(told(&manager).last().map(String::as_str), Some("STOPPING=1"));
    // It stood still for two seconds, and reports it.
    let slips = runtime.says("slips: ", SOON);
    let worst: f64 = slips
        .split("the worst ")
        .nth(1)
        .and_then(|rest| rest.trim_end_matches(" s").parse().ok())
        .unwrap_or_else(|| panic!("{slips}"));
    assert!(worst > 1.0 && slips.contains("over 500 ms"), "{slips}");
}

#[test]
fn without_a_vehicle_it_is_ready_too_and_anothers_watchdog_is_not_fed() {
    let mission = Mission::steady();
    let (runtime, manager) = served(&mission, &free_address(), &[("WATCHDOG_PID", "1")]);
    let mut all = Vec::new();
    eventually(
        SOON,
        || {
            all.extend(told(&manager));
            all.first().cloned()
        },
        || format!("it is ready\n{}", runtime.stderr()),
    );
    runtime.says("next attempt in", SOON);
    settle(WATCHDOG);
    all.extend(told(&manager));
    assert_eq!(all, ["READY=1"]);
}

#[test]
fn a_service_manager_that_is_gone_stops_nobody() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let (runtime, manager) = served(&mission, &vehicle.address, &[("NOTIFY_SOCKET", "/nonexistent/notify")]);
    drop(manager);
    vehicle.receives("BPRMB", 3, SOON);
    assert_eq!(runtime.stderr().matches("the service manager: ").count(), 1);
}

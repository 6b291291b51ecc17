//! Runtime, mock vehicle and mock payload controller as three programs over TCP: a survey with logging switched by the
//! vehicle, and a controller that is killed, stopped and started again.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use backseat_suite::{Backseat, Line, Mission, Process, Signal, Vehicle, eventually, free_address, settle};

use super::session::{SOON, runtime};

/// The steady mission with a sidescan that pings ten times a second, and a vehicle that says when to log.
fn mission(address: &str) -> Mission {
    let (host, port) = address.rsplit_once(':').expect("an address has a port");
    Mission::steady()
        .edit(
            "world.toml",
            "timeout_s = 600",
            "timeout_s = 600\npayload_message = \"line 1\"",
        )
        .append(
            "world.toml",
            "\n[plc]\n[plc.disk]\ncritical_percent = 0\n[plc.sidescan_low]\nstart_s = 0\nsample_interval_us = 12\n",
        )
        .append(
            "mission.toml",
            &format!(
                r#"
[sonar]
host = "{host}"
port = {port}
health_period_s = 1
command_timeout_s = 0.5
reconnect_max_s = 2

[[sonar.sensor]]
index = 1
device = 11001
records = [3000]
period_ms = 100
ping = true

[[plugin.ping]]
sensor = 1
samples = 4096
decimation = "maximum"
"#
            ),
        )
}

fn controller(mission: &Mission, address: &str, folder: &str) -> Process {
    let controller = Backseat::new()
        .args(["plc", "--listen", address, "--folder"])
        .arg(mission.beside(folder))
        .mission(mission)
        .spawn();
    controller.says("payload controller at ", SOON);
    controller
}

/// The longest time between two BPRMB that the vehicle received, seconds.
fn worst_gap_s(vehicle: &Vehicle) -> f64 {
    let modifies = vehicle.received("BPRMB");
    assert!(modifies.len() > 10, "{}", modifies.len());
    modifies
        .windows(2)
        .map(|pair| pair[1].at_s - pair[0].at_s)
        .fold(0.0, f64::max)
}

fn status_says(vehicle: &Vehicle, text: &str) {
    let is = |line: &Line| line.is_received("BPSTS") && line.text.contains(text);
    let from_s = vehicle.received("BPSTS").last().map_or(0.0, |line| line.at_s);
    vehicle.sees(&format!("a BPSTS with {text}"), SOON, |line| {
        is(line) && line.at_s >= from_s
    });
}

fn logs(mission: &Mission, folder: &str) -> Vec<PathBuf> {
    let mut logs: Vec<PathBuf> = fs::read_dir(mission.beside(folder))
        .expect("the controller has made its folder")
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "s7k"))
        .collect();
    logs.sort();
    logs
}

#[test]
fn sr_022_a_payload_controller_that_is_killed_or_stopped_does_not_disturb_a_survey() {
    let address = free_address();
    let mission = mission(&address);
    let vehicle = Vehicle::start(&mission);
    let mut first = controller(&mission, &address, "first");
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 3, SOON);
    status_says(&vehicle, "sonar ready; logging on");
    settle(Duration::from_secs(3));

    first.kill();
    status_says(&vehicle, "sonar not connected");
    settle(Duration::from_secs(2));
    let second = controller(&mission, &address, "second");
    // Logging goes on as the vehicle ordered it on the connection before.
    status_says(&vehicle, "sonar ready; logging on");
    settle(Duration::from_secs(3));

    second.signal(Signal::STOP);
    status_says(&vehicle, "sonar not connected");
    settle(Duration::from_secs(3));
    second.signal(Signal::CONT);
    status_says(&vehicle, "sonar ready; logging on");
    settle(Duration::from_secs(2));

    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let worst_s = worst_gap_s(&vehicle);
    assert!(worst_s < 1.5, "{worst_s} s between two BPRMB\n{}", runtime.stderr());
    println!("worst gap between two BPRMB: {worst_s:.3} s");
    assert!(
        runtime
            .stderr()
            .contains("sonar: no connection to the payload controller"),
        "{}",
        runtime.stderr()
    );
    let mut second = second;
    second.signal(Signal::TERM);
    assert_eq!(second.wait(SOON), Some(0), "{}", second.stderr());

    // The files of the controller that was killed are read up to the cut, those of the other one are whole.
    for (folder, whole) in [("first", false), ("second", true)] {
        let files = eventually(
            SOON,
            || Some(logs(&mission, folder)).filter(|logs| !logs.is_empty()),
            || format!("no log in {folder}"),
        );
        for file in files {
            let verified = Backseat::new().args(["s7k", "verify"]).arg(&file).run();
            assert!(
                verified.code == Some(0) || (!whole && verified.code == Some(1)),
                "{folder}: {verified}"
            );
        }
    }
}

#[test]
fn sr_022_a_payload_controller_that_floods_or_sends_garbage_does_not_disturb_a_survey() {
    let address = free_address();
    let mission = mission(&address).append(
        "world.toml",
        "\n[[plc.fault]]\nat_s = 8\nfor_s = 5\nkind = \"flood\"\nrecords_per_s = 2000\n\
         \n[[plc.fault]]\nat_s = 15\nfor_s = 4\nkind = \"garbage\"\nbytes_per_s = 1000000\n",
    );
    let vehicle = Vehicle::start(&mission);
    let mut controller = controller(&mission, &address, "only");
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 3, SOON);
    status_says(&vehicle, "sonar ready; logging on");
    settle(Duration::from_secs(20));
    status_says(&vehicle, "sonar ready; logging on");

    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let worst_s = worst_gap_s(&vehicle);
    assert!(worst_s < 1.5, "{worst_s} s between two BPRMB\n{}", runtime.stderr());
    println!("worst gap between two BPRMB: {worst_s:.3} s");
    let told = runtime.stderr();
    for words in ["not used", "bytes skipped"] {
        assert!(told.contains(words), "no `{words}` in\n{told}");
    }
    assert!(told.lines().count() < 200, "the operator is flooded:\n{told}");
    controller.signal(Signal::TERM);
    assert_eq!(controller.wait(SOON), Some(0), "{}", controller.stderr());
}

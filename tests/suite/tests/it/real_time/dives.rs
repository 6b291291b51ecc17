//! Dives one after the other in one process, what the seed drew, and the vehicle as it was recorded.

use std::io::{Read, Write};
use std::net::TcpStream;

use backseat_recorder::{Log, read};
use backseat_suite::{Backseat, Mission, Vehicle, Way};

use super::session::SOON;

const TWO: &str = r#"
[[dive]]
file = "broken.dive"
load_after_s = 1
invalid = "dive"

[[dive]]
file = "first.dive"
log_dir = "/logs/1"
load_after_s = 2
start_after_s = 2
end_after_s = 30

[[dive]]
file = "second.dive"
log_dir = "/logs/2"
load_after_s = 5
start_after_s = 5
end_after_s = 30

[[dive.plan]]
kind = "trackline"
start = { east_m = -500, north_m = 40 }
end = { east_m = 600, north_m = 40 }
depth_m = 8
speed_mps = 1.5
dynamic = true
"#;

fn two() -> Mission {
    Mission::steady()
        .edit("world.toml", "[expect]", &format!("{TWO}\n[expect]"))
        .edit("world.toml", "starts_after_s = 2", "online_after_s = 1")
}

fn flown(mission: &Mission, arguments: &[&str]) -> Log {
    let flown = Backseat::new()
        .arg("fly")
        .mission(mission)
        .args(["--speed", "15"])
        .args(arguments.iter().copied())
        .arg("--log")
        .arg(mission.beside("flight.mcap"))
        .run()
        .exit(0);
    assert!(flown.stdout.contains("steady, seed 1: completed after"), "{flown}");
    read(&mission.beside("flight.mcap")).expect("the log can be read")
}

/// Sentences that the runtime received (true) or sent, with their times. One record can hold several.
fn link(log: &Log, received: bool, name: &str) -> Vec<(f64, String)> {
    let mut found = Vec::new();
    for (at, _, bytes) in log.link().filter(|(_, inward, _)| *inward == received) {
        let text = String::from_utf8_lossy(bytes);
        let lines = text.lines().filter(|line| line.starts_with(name));
        found.extend(lines.map(|line| (at.as_secs_f64(), line.to_owned())));
    }
    found
}

#[test]
fn sr_025_the_runtime_steers_in_each_of_two_dives_of_one_process() {
    let log = flown(&two(), &[]);
    let statuses = link(&log, true, "$BFMIS");
    let said: Vec<String> = statuses
        .iter()
        .map(|(_, line)| line.split(',').skip(2).take(2).collect::<Vec<_>>().join(","))
        .collect();
    // The runtime subscribes while the vehicle is offline, and gets its status then.
    let from = said.iter().position(|status| status == ",Waiting").expect("Waiting");
    assert_eq!(
        said[from..],
        [
            ",Waiting",
            "broken.dive,Invalid Dive File",
            "first.dive,Ready",
            "first.dive,Running /logs/1",
            "first.dive,Completed",
            "second.dive,Ready",
            "second.dive,Running /logs/2",
            "second.dive,Completed",
        ]
    );
    let runs: Vec<f64> = statuses
        .iter()
        .filter(|(_, line)| line.contains("Running"))
        .map(|(at, _)| *at)
        .collect();
    let (plans, modifies) = (link(&log, false, "$BPRMP"), link(&log, false, "$BPRMB"));
    for run in &runs {
        let within = |at: f64| (*run..*run + 30.0).contains(&at);
        let asked = plans
            .iter()
            .find(|(at, _)| within(*at))
            .expect("the plan is asked for")
            .0;
        let steered: Vec<f64> = modifies.iter().map(|(at, _)| *at).filter(|at| within(*at)).collect();
        assert!(steered.len() > 10 && steered[0] > asked, "{steered:?}, {asked}");
    }
    let between = modifies
        .iter()
        .filter(|(at, _)| (runs[0] + 31.0..runs[1]).contains(at))
        .count();
    assert_eq!(between, 0);
}

#[test]
fn the_runtime_steers_a_vehicle_that_speaks_as_recorded() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 40");
    let log = flown(&mission, &["--profile", "sandshark"]);
    let version = link(&log, true, "$BFVER");
    assert!(version[0].1.contains(",1.11"), "{version:?}");
    // Its clock is four hours behind: the run starts at 08:00.
    assert!(version[0].1.starts_with("$BFVER,0400"), "{version:?}");
    assert!(link(&log, false, "$BPRMB").len() > 20);
    let acknowledged = link(&log, true, "$BFACK");
    let accepted = |line: &str| line.contains(",RMB,") && line.contains(",2,0,request successfully processed");
    assert!(acknowledged.iter().any(|(_, line)| accepted(line)), "{acknowledged:?}");
}

/// What a vehicle says to a client that sends these bytes, as they come.
fn said(vehicle: &Vehicle, bytes: &[u8], until: &str) -> String {
    let mut stream = TcpStream::connect(&vehicle.address).expect("the vehicle listens");
    stream.set_read_timeout(Some(SOON)).expect("a time that is not zero");
    stream.write_all(bytes).expect("the vehicle reads");
    let (mut heard, mut buffer) = (Vec::new(), [0; 4096]);
    loop {
        let count = stream.read(&mut buffer).expect("the vehicle answers");
        heard.extend_from_slice(&buffer[..count]);
        let text = String::from_utf8_lossy(&heard);
        if count == 0 || text.contains(until) {
            return text.into_owned();
        }
    }
}

#[test]
fn mvc_says_what_the_seed_drew_and_a_sandshark_answers_as_recorded() {
    let mission = Mission::steady().edit(
        "world.toml",
        "control_replay = true",
        "control_replay = \"seed\"\nafter_interrupt = \"seed\"\necho_decimals = \"seed\"\nlead_in_m = 30",
    );
    let vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &["--seed", "7"]);
    let told = vehicle.process.stderr();
    let at = told
        .find("seed 7 draws, in [interpretation]:")
        .expect("the draws are shown");
    let listens = told.find("listening on").expect("it listens");
    let drawn: Vec<&str> = told[at..listens]
        .lines()
        .filter_map(|line| line.split_once(" = "))
        .map(|(before, _)| before.rsplit(' ').next().unwrap_or(""))
        .collect();
    assert_eq!(drawn, ["after_interrupt", "control_replay", "echo_decimals"], "{told}");

    // What the profile fixes is not drawn.
    let flags = ["--seed", "7", "--profile", "sandshark"];
    let vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &flags);
    let told = vehicle.process.stderr();
    assert!(told.contains("after_interrupt = "), "{told}");
    assert!(
        !told.contains("echo_decimals") && !told.contains("control_replay"),
        "{told}"
    );
    let said = said(
        &vehicle,
        b"$BPLOG,ACK,ON\n \n$BPSTS,120000.25,1,all ok\n",
        ",STS,120000.250,0,2,0,",
    );
    for (line, begin) in said.split("\r\n\n").zip(["$BFVER,0400", "$BFACK,0400", "$BFACK,0400"]) {
        assert!(line.starts_with(begin), "{said:?}");
    }
    assert!(
        said.contains(",LOG,000000.000,0,2,0,request successfully processed*"),
        "{said:?}"
    );
    assert!(said.contains(",NAK,000000.000,0,0,0,"), "{said:?}");
    vehicle.sees("the status", SOON, |line| {
        line.way == Way::Event && line.text.contains("reports status ok")
    });
}

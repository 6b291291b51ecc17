//! The runtime is killed, hung or stopped: the vehicle steers itself again in time, by its own clock (safety
//! requirement 007), and flies the inserts that it had accepted.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::Duration;

use backseat_suite::{Line, Mission, Signal, Vehicle, Way, settle};

use super::session::{SOON, runtime};

/// A modify lapses 5 s after the last one received; the rest is one step of the vehicle.
const LAPSES_WITHIN_S: f64 = 5.2;

/// Another client that only receives navigation, so that the log shows the vehicle's course.
fn watch(vehicle: &Vehicle) {
    let mut stream = TcpStream::connect(&vehicle.address).expect("the vehicle listens");
    stream.write_all(b"$BPLOG,NVG,ON\n").expect("the connection is new");
    thread::spawn(move || {
        let mut buffer = [0; 4096];
        while stream.read(&mut buffer).is_ok_and(|read| read > 0) {}
    });
}

/// The headings that the vehicle sent, with their times.
fn headings(vehicle: &Vehicle) -> Vec<(f64, f64)> {
    let told = |line: &Line| line.way == Way::Sent && line.client == 1 && line.name() == "BFNVG";
    vehicle
        .lines()
        .into_iter()
        .filter(told)
        .map(|line| (line.at_s, line.field(9).parse().expect("a heading is a number")))
        .collect()
}

/// The time of day in a sentence, seconds.
fn created_s(line: &Line) -> f64 {
    let time = line.field(1);
    let part = |range: std::ops::Range<usize>| time[range].parse::<f64>().expect("a time is digits");
    part(0..2) * 3600.0 + part(2..4) * 60.0 + part(4..time.len())
}

#[test]
fn sr_007_a_killed_runtimes_modify_lapses_and_the_plan_is_flown_again() {
    let mission = Mission::steady().edit("mission.toml", "heading_deg = 90.0", "heading_deg = 150.0");
    let vehicle = Vehicle::start(&mission);
    watch(&vehicle);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 12, SOON);
    runtime.kill();
    let lapsed = vehicle.sees("the modify lapse", SOON, |line| {
        line.way == Way::Event && line.text.starts_with("modify ended: 5 s without a refresh")
    });
    let last = vehicle.received("BPRMB").pop().unwrap();
    assert!(
        lapsed.at_s - last.at_s <= LAPSES_WITHIN_S,
        "after {:.2} s",
        lapsed.at_s - last.at_s
    );
    let turned = headings(&vehicle)
        .into_iter()
        .filter(|(at_s, _)| *at_s <= last.at_s)
        .any(|(_, deg)| deg > 140.0);
    assert!(turned, "it had turned to the modify's heading");
    vehicle.sees("the plan's way again", SOON, |line| {
        let told = line.way == Way::Sent && line.name() == "BFNVG" && line.at_s > lapsed.at_s;
        // Back to a line to the north of it.
        told && line.field(9).parse::<f64>().unwrap() < 100.0
    });
}

#[test]
fn sr_007_a_stopped_runtime_ends_its_lease_before_anything_else_when_it_goes_on() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 3, SOON);
    runtime.signal(Signal::STOP);
    settle(Duration::from_secs(1));
    let before = vehicle.received("BPRMB");
    let last = before.last().unwrap().clone();
    settle(Duration::from_secs(7));
    assert_eq!(
        vehicle.received("BPRMB").len(),
        before.len(),
        "a stopped process sends nothing"
    );
    let lapsed = vehicle.sees("the modify lapse", SOON, |line| {
        line.text.starts_with("modify ended: 5 s without")
    });
    assert!(
        lapsed.at_s - last.at_s <= LAPSES_WITHIN_S,
        "after {:.2} s",
        lapsed.at_s - last.at_s
    );
    runtime.signal(Signal::CONT);
    settle(Duration::from_secs(6));
    let since: Vec<Line> = vehicle
        .lines()
        .into_iter()
        .filter(|line| line.at_s > last.at_s + 6.0)
        .collect();
    let steering = |line: &&Line| line.is_received("BPRMB") || line.is_received("BPEMB");
    if let Some(first) = since.iter().find(steering) {
        assert!(first.is_received("BPEMB"), "{}", first.text);
    }
    for modify in since.iter().filter(|line| line.is_received("BPRMB")) {
        let later_s = (created_s(modify) - created_s(&last)).rem_euclid(86_400.0);
        assert!(later_s > 7.0, "made before it was stopped: {}", modify.text);
    }
}

#[test]
fn an_ordered_stop_gives_the_helm_back_before_it_goes() {
    for signal in [Signal::TERM, Signal::INT] {
        let mission = Mission::steady();
        let vehicle = Vehicle::start(&mission);
        let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
        vehicle.receives("BPRMB", 2, SOON);
        runtime.signal(signal);
        assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
        vehicle.sees("the client go", SOON, |line| line.text == "client 1 disconnected");
        let lines = vehicle.lines();
        let ended = lines
            .iter()
            .rposition(|line| line.is_received("BPEMB"))
            .expect("a BPEMB");
        let gone = lines.iter().position(|line| line.text == "client 1 disconnected");
        let last = lines.iter().rposition(|line| line.is_received("BPRMB"));
        assert!(last < Some(ended) && Some(ended) < gone, "{}", vehicle.story());
        vehicle.sees("the modify's end", SOON, |line| {
            line.text == "modify ended: by the payload"
        });
        let log = std::fs::read_dir(mission.beside("logs"))
            .unwrap()
            .next()
            .unwrap()
            .unwrap()
            .path();
        assert!(backseat_recorder::read(&log).unwrap().complete, "the log has its end");
    }
}

#[test]
fn sr_007_an_accepted_insert_is_flown_without_us() {
    // About 30 m, which takes half a minute.
    let mission = Mission::steady()
        .in_legs()
        .edit("mission.toml", "[\"modify\"]", "[\"insert\", \"interrupt\"]")
        .edit(
            "mission.toml",
            "fault = \"none\"",
            "fault = \"cross_fence\"\ntarget_east_m = -565\ntarget_north_m = 0",
        );
    let vehicle = Vehicle::start(&mission);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm", "--first-identifier", "70"]);
    vehicle.sees("the insert accepted", SOON, |line| {
        line.text == "insert 70 of client 1 accepted"
    });
    runtime.kill();
    let is = |line: &Line, what: &str| {
        line.way == Way::Event && line.text.starts_with("inserted ") && line.text.contains(what)
    };
    vehicle.sees("the insert begin", SOON, |line| is(line, " 70 began"));
    let gone = vehicle.sees("the client go", SOON, |line| line.text == "client 1 disconnected");
    let ended = vehicle.sees("the insert end", Duration::from_secs(100), |line| {
        is(line, " 70 ended: ")
    });
    assert!(ended.text.ends_with("ended: done"), "{}", ended.text);
    assert!(ended.at_s > gone.at_s);
}

//! SPI identifiers are recorded on disk before they are sent, and never used twice (safety requirement 009).

use std::collections::BTreeSet;
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Process, Signal, Vehicle, free_address, settle};

use super::session::{SOON, runtime};

/// Requests a trackline each second that is flown after the current behavior.
fn inserting() -> Mission {
    Mission::steady()
        .in_legs()
        .edit("mission.toml", "[limits]", "[limits]\ninserts_open_max = 16")
        .edit("mission.toml", "[\"modify\"]", "[\"insert\"]")
        .edit(
            "mission.toml",
            "fault = \"none\"",
            "fault = \"cross_fence\"\ntarget_east_m = -520\ntarget_north_m = 0\nafter_current = true",
        )
}

fn recorded(mission: &Mission) -> u32 {
    let text = std::fs::read_to_string(mission.beside("state/identifiers")).expect("there is a record");
    text.split_whitespace()
        .next()
        .unwrap_or("")
        .parse()
        .expect("it is a number")
}

#[test]
fn without_a_record_no_insert_is_sent() {
    let mission = inserting();
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    let line = runtime.says("no record of SPI identifiers", SOON);
    assert!(
        line.contains("state/identifiers") && line.contains("--first-identifier"),
        "{line}"
    );
    runtime.says("the identifiers' state on disk is missing", SOON);
    settle(Duration::from_secs(2));
    assert!(vehicle.received("BPRTK").is_empty(), "{}", vehicle.story());
    assert!(!mission.beside("state/identifiers").exists(), "it makes none up");
}

#[test]
fn sr_009_a_killed_runtimes_identifiers_are_never_used_again() {
    // A refused request also uses up its identifier, and the next process still learns the current behavior.
    let mission = inserting().append(
        "world.toml",
        "[[faults.fault]]\nkind = \"acks_negative\"\nat_s = 0\nfor_s = 1000\ncommand = \"RTK\"",
    );
    let vehicle = Vehicle::start(&mission);
    let mut used = Vec::new();
    for round in 1..=3 {
        let first: &[&str] = if round == 1 {
            &["--arm", "--first-identifier", "500"]
        } else {
            &["--arm"]
        };
        let mut runtime = runtime(&mission, &vehicle.address, first);
        let line = vehicle.receives("BPRTK", vehicle.received("BPRTK").len() + 1, SOON);
        used.push(line.field(2).parse::<u32>().unwrap());
        assert!(
            recorded(&mission) > used[round - 1],
            "recorded before it is sent: {} and {used:?}",
            recorded(&mission)
        );
        runtime.kill();
    }
    assert_eq!(used[0], 500);
    let all: Vec<String> = vehicle
        .received("BPRTK")
        .iter()
        .map(|line| line.field(2).to_owned())
        .collect();
    let different: BTreeSet<&String> = all.iter().collect();
    assert_eq!(all.len(), different.len(), "{all:?}");
    assert!(used.is_sorted(), "{used:?}");
}

fn ends_in_order(mut runtime: Process) {
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
}

#[test]
fn an_orderly_end_records_what_was_used_and_no_more() {
    let mission = inserting();
    let record = || std::fs::read_to_string(mission.beside("state/identifiers")).unwrap();
    let nobody = free_address();
    for arguments in [&["--first-identifier", "100"][..], &["--arm"], &["--arm"]] {
        let runtime = runtime(&mission, &nobody, arguments);
        runtime.says("next attempt in", SOON);
        ends_in_order(runtime);
        assert_eq!(record().trim(), "100 100 0 0", "nothing was sent");
    }
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRTK", 2, SOON);
    ends_in_order(runtime);
    let sent = vehicle.received("BPRTK").len();
    assert_eq!(record().trim(), format!("{} 100 {sent} 0", 100 + sent));
}

#[test]
fn a_start_that_fails_begins_no_record() {
    let mission = inserting();
    let (taken, nobody) = (std::net::TcpListener::bind("127.0.0.1:0").unwrap(), free_address());
    let foxglove = format!("--foxglove={}", taken.local_addr().unwrap());
    let console = format!("--console={}", taken.local_addr().unwrap());
    std::fs::write(mission.beside("no-folder"), "").unwrap();
    for (option, logs, culprit) in [
        (foxglove.as_str(), "logs", "--foxglove"),
        ("--foxglove=192.0.2.1:8765", "logs", "--foxglove"),
        (console.as_str(), "logs", "--console"),
        ("--arm", "no-folder", "no-folder"),
    ] {
        let run = Backseat::new()
            .args(["run", option, "--first-identifier", "1", "--connect", &nobody, "--log"])
            .arg(mission.beside(logs))
            .arg("--state")
            .arg(mission.beside("state"))
            .mission(&mission)
            .run();
        // A port that another program has may become free.
        let may_pass = option.contains("=127.0.0.1");
        let refusal = if may_pass { run.refusal_for_now() } else { run.refusal() };
        assert!(refusal.contains(culprit), "{option}");
        assert!(!mission.beside("state/identifiers").exists(), "{option} {logs}");
    }
    // What was wrong is mended, and the same words begin.
    let runtime = runtime(&mission, &nobody, &["--first-identifier", "1"]);
    runtime.says("next attempt in", SOON);
    assert!(recorded(&mission) >= 1);
}

#[test]
fn two_runtimes_do_not_share_a_record() {
    let mission = inserting();
    let address = free_address();
    let mut first = runtime(&mission, &address, &["--arm", "--first-identifier", "1"]);
    first.says("next attempt in", SOON);
    let second = Backseat::new()
        .args(["run", "--arm", "--connect", &address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission);
    let line = second.run().refusal();
    assert!(line.contains("state") && line.contains("another runtime"), "{line}");
    // What a killed process leaves behind prevents nothing.
    first.kill();
    let third = runtime(&mission, &address, &["--arm"]);
    third.says("next attempt in", SOON);
}

#[test]
fn identifiers_that_cannot_be_counted_on_are_refused() {
    let mission = inserting();
    let begin = |first: &str| {
        let run = Backseat::new()
            .arg("run")
            .arg(format!("--first-identifier={first}"))
            .mission(&mission);
        run.arg("--state").arg(mission.beside("state")).run()
    };
    for first in ["0", "4294967295", "-1", "one"] {
        let finished = begin(first).exit(2);
        assert!(
            finished.stderr.contains("--first-identifier") && finished.stderr.contains(first),
            "{finished}"
        );
        assert!(!mission.beside("state/identifiers").exists(), "{first} is not recorded");
    }
}

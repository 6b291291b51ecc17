//! A full disk: what cannot be recorded is not sent, everything else continues, and each loss is reported once.

use std::fs;
use std::os::unix::fs::symlink;
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Process, Signal, Vehicle, eventually, settle};

use super::console::{address, get};
use super::session::{SOON, runtime};

/// The steady mission with a second plugin that requests a trackline ahead each second.
fn steering_and_inserting() -> Mission {
    Mission::steady().in_legs().append(
        "mission.toml",
        "[[plugin]]\nname = \"inserter\"\ncomponent = \"faulty\"\ngrants = [\"insert\", \"interrupt\"]\n\
         [plugin.config]\nfault = \"cross_fence\"\ntarget_east_m = -500.0\ntarget_north_m = 0.0\n\
         after_current = true",
    )
}

/// Writes to this name in the state folder fail as on a full disk.
fn fill(mission: &Mission, name: &str) {
    let state = mission.beside("state");
    fs::create_dir_all(&state).expect("the folder is ours");
    symlink("/dev/full", state.join(name)).expect("the folder is ours");
}

fn ends_in_order(mut runtime: Process) -> String {
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let said = runtime.stderr();
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn sr_009_no_insert_is_sent_whose_identifier_could_not_be_reserved_and_the_lease_goes_on() {
    let mission = steering_and_inserting();
    let vehicle = Vehicle::start(&mission);
    fs::create_dir(mission.beside("state")).expect("the folder is ours");
    fs::write(mission.beside("state/vehicle"), "steady").expect("the folder is ours");
    fs::write(mission.beside("state/identifiers"), "70").expect("the folder is ours");
    fill(&mission, "identifiers.new");
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    let told = runtime.says("identifiers cannot be reserved", SOON);
    assert!(told.contains("No space left on device"), "{told}");
    vehicle.receives("BPRMB", 8, SOON);
    assert!(vehicle.received("BPRTK").is_empty(), "{}", vehicle.story());
    let record = fs::read_to_string(mission.beside("state/identifiers")).expect("the record is as it was");
    assert_eq!(record, "70");
    // When there is room again, inserts are sent again.
    fs::remove_file(mission.beside("state/identifiers.new")).expect("the link is ours");
    runtime.says("inserts are sent again", SOON);
    let sent = vehicle.receives("BPRTK", 1, SOON);
    assert!(
        sent.field(2).parse::<u32>().expect("an identifier") >= 70,
        "{}",
        vehicle.story()
    );
    let said = ends_in_order(runtime);
    assert_eq!(said.matches("cannot be reserved").count(), 1, "told once\n{said}");
}

#[test]
fn sr_015_a_hold_that_cannot_be_kept_holds_all_the_same() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    fill(&mission, "hold.new");
    // There is no room for an empty file either.
    symlink(mission.beside("nowhere/hold"), mission.beside("state/hold")).expect("the folder is ours");
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    runtime.signal(Signal::USR1);
    let ended = vehicle.receives("BPEMB", 1, SOON);
    runtime.says("the operator's hold or release counts for this run only", SOON);
    settle(Duration::from_secs(3));
    let since = vehicle
        .received("BPRMB")
        .into_iter()
        .filter(|line| line.at_s > ended.at_s);
    assert_eq!(since.count(), 0, "{}", vehicle.story());
    ends_in_order(runtime);
}

#[test]
fn sr_015_a_hold_on_a_full_disk_is_kept_over_a_restart() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    fill(&mission, "hold.new");
    let mut first = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    first.signal(Signal::USR1);
    vehicle.receives("BPEMB", 1, SOON);
    settle(Duration::from_secs(1));
    first.kill();
    let before = vehicle.received("BPRMB").len();
    let second = runtime(&mission, &vehicle.address, &["--arm"]);
    settle(Duration::from_secs(5));
    assert_eq!(vehicle.received("BPRMB").len(), before, "{}", vehicle.story());
    ends_in_order(second);
}

#[test]
fn a_log_on_a_full_disk_ends_and_the_vehicle_is_steered_on() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    // The size of a log with its attachments, and a little more.
    let mut first = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 4, SOON);
    first.kill();
    let logs = fs::read_dir(mission.beside("logs")).expect("there is a log");
    let size = logs.map(|log| log.unwrap().metadata().unwrap().len()).sum::<u64>();

    let before = vehicle.received("BPRMB").len();
    let runtime = Backseat::new()
        .file_max_kib(size / 1024 + 16)
        .args([
            "run",
            "--arm",
            "--console=127.0.0.1:0",
            "--connect",
            &vehicle.address,
            "--log",
        ])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .spawn();
    vehicle.receives("BPRMB", before + 1, SOON);
    let console = address(&runtime);
    runtime.says("the log ends here, the run continues", Duration::from_secs(90));
    eventually(
        SOON,
        || {
            get(&console, "/metrics")
                .contains("\nbackseat_log_written 0")
                .then_some(())
        },
        || get(&console, "/metrics"),
    );
    let then = vehicle.received("BPRMB").len();
    vehicle.receives("BPRMB", then + 4, SOON);
    let said = ends_in_order(runtime);
    assert_eq!(said.matches("the log ends here").count(), 1, "told once\n{said}");
    let modifies = vehicle.received("BPRMB");
    let gaps = modifies[before..].windows(2).map(|pair| pair[1].at_s - pair[0].at_s);
    let worst_s = gaps.fold(0.0, f64::max);
    assert!(worst_s < 2.5, "{worst_s:.3} s without a modify");
}

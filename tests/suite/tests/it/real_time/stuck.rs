//! Something around the runtime is stuck, full or closed: its lease, the operator's acts and its end are not affected.

use std::fs::{self, File};
use std::io::{Write, pipe};
use std::process::{Command, Stdio};
use std::time::Duration;

use backseat_suite::{Backseat, Line, Mission, Process, Signal, Stopwatch, Vehicle};

use super::session::SOON;

/// A lease without a refresh for this long has nearly lapsed, seconds. (Measured on an otherwise idle machine: 1.1.)
const GAP_MAX_S: f64 = 2.5;
/// The longest that an operator may wait, including the delay of a busy machine and the vehicle's log. (Measured: 0.1
/// s.)
const OBEYED_WITHIN: Duration = Duration::from_secs(3);

/// The pilot logs 1,000 lines in each step, more than its limit.
fn talkative() -> Mission {
    Mission::steady().edit("mission.toml", "fault = \"none\"", "fault = \"log_flood\"\nafter_s = 3")
}

/// The armed runtime, which logs at every level.
fn runtime(mission: &Mission, vehicle: &Vehicle) -> Backseat {
    Backseat::new()
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .env("BACKSEAT_LOG", "trace")
        .mission(mission)
}

/// Requires that it has steered for some time without a gap, that the operator's hold and release take effect at once,
/// and that it hands back control in order.
fn is_steered_held_and_left(mission: &Mission, vehicle: &Vehicle, mut runtime: Process) {
    vehicle.receives("BPRMB", 20, SOON);
    let modifies: Vec<Line> = vehicle.received("BPRMB");
    let gaps = modifies.windows(2).map(|pair| pair[1].at_s - pair[0].at_s);
    let worst_s = gaps.fold(0.0, f64::max);
    assert!(
        worst_s < GAP_MAX_S,
        "{worst_s:.3} s without a modify\n{}",
        vehicle.story()
    );

    let held = Stopwatch::start();
    runtime.signal(Signal::USR1);
    vehicle.receives("BPEMB", 1, SOON);
    assert!(held.elapsed() < OBEYED_WITHIN, "held after {:?}", held.elapsed());

    runtime.signal(Signal::USR2);
    vehicle.receives("BPRMB", vehicle.received("BPRMB").len() + 2, SOON);
    let stopped = Stopwatch::start();
    runtime.signal(Signal::TERM);
    vehicle.receives("BPEMB", 2, SOON);
    assert!(stopped.elapsed() < OBEYED_WITHIN, "ended after {:?}", stopped.elapsed());
    assert_eq!(runtime.wait(Duration::from_secs(10)), Some(0), "{}", runtime.stderr());
    let logs = fs::read_dir(mission.beside("logs")).expect("there is a log");
    assert_eq!(logs.count(), 1);
}

#[test]
fn sr_022_standard_error_is_full() {
    let mission = talkative();
    let vehicle = Vehicle::start(&mission);
    let full = File::options().write(true).open("/dev/full").expect("a Linux has it");
    let runtime = runtime(&mission, &vehicle).stderr_to(full).spawn();
    is_steered_held_and_left(&mission, &vehicle, runtime);
}

#[test]
fn sr_022_the_reader_of_standard_error_is_gone() {
    let mission = talkative();
    let vehicle = Vehicle::start(&mission);
    let (reader, writer) = pipe().expect("a pipe can be made");
    drop(reader);
    let runtime = runtime(&mission, &vehicle).stderr_to(writer).spawn();
    is_steered_held_and_left(&mission, &vehicle, runtime);
}

#[test]
fn sr_022_nobody_reads_standard_error() {
    let mission = talkative();
    let vehicle = Vehicle::start(&mission);
    let (_reader, mut writer) = pipe().expect("a pipe can be made");
    // It holds 64 KiB, of which a page is left.
    writer.write_all(&[b'\n'; 15 << 12]).expect("there is room");
    let runtime = runtime(&mission, &vehicle).stderr_to(writer).spawn();
    is_steered_held_and_left(&mission, &vehicle, runtime);
}

/// A named pipe that no process opens, so that whoever writes the file waits for ever.
fn stall(mission: &Mission, name: &str) {
    let state = mission.beside("state");
    fs::create_dir_all(&state).expect("the folder is ours");
    let made = Command::new("mkfifo")
        .arg(state.join(name))
        .stdin(Stdio::null())
        .status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
}

#[test]
fn sr_022_the_disk_takes_neither_identifiers_nor_the_hold() {
    let mission = talkative().append(
        "mission.toml",
        "[[plugin]]\nname = \"inserter\"\ncomponent = \"faulty\"\ngrants = [\"insert\", \"interrupt\"]\n\
         [plugin.config]\nfault = \"cross_fence\"\ntarget_east_m = -500.0\ntarget_north_m = 0.0\n\
         after_current = true",
    );
    let vehicle = Vehicle::start(&mission);
    fs::create_dir(mission.beside("state")).expect("the folder is ours");
    fs::write(mission.beside("state/vehicle"), "steady").expect("the folder is ours");
    fs::write(mission.beside("state/identifiers"), "70").expect("the folder is ours");
    stall(&mission, "identifiers.new");
    stall(&mission, "hold.new");
    let runtime = runtime(&mission, &vehicle).spawn();
    is_steered_held_and_left(&mission, &vehicle, runtime);
    assert!(
        vehicle.received("BPRTK").is_empty(),
        "nothing is sent that is not reserved"
    );
}

//! A disk that hangs: calls that reach it do not return until it recovers, if ever. The lease, the operator's acts and
//! the end of the process are not affected (safety requirement 022).

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use backseat_recorder::Record;
use backseat_suite::{Backseat, Behavior, Mission, Process, Scripted, Signal, Stall, Stopwatch, Vehicle, settle};

use super::heard::{ended_after_s, worst_gap_s};
use super::session::SOON;

/// A lease without a refresh for this long has nearly lapsed, seconds. (Measured on an otherwise idle machine: 1.1.)
const GAP_MAX_S: f64 = 2.5;
/// The longest that the operator may wait for the end of the lease, seconds. (Measured: 0.01.)
const OBEYED_WITHIN_S: f64 = 1.0;
/// The end of a run gives the log 2 s and the state folder half a second.
const ENDS_WITHIN: Duration = Duration::from_secs(6);

/// The armed runtime, whose files in these folders hang during the stall.
fn runtime(mission: &Mission, address: &str, stall: &Stall, folders: &[&str]) -> Process {
    let folders: Vec<PathBuf> = folders.iter().map(|folder| mission.beside(folder)).collect();
    let folders: Vec<_> = folders.iter().map(PathBuf::as_path).collect();
    Backseat::new()
        .args(["run", "--arm", "--connect", address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(mission)
        .stalled(stall, &folders)
        .spawn()
}

/// The operator holds, and the lease ends at once.
fn is_held(vehicle: &Scripted, runtime: &Process) {
    let since_s = vehicle.now_s();
    runtime.signal(Signal::USR1);
    let held_s = ended_after_s(vehicle, since_s, SOON);
    assert!(held_s < OBEYED_WITHIN_S, "held after {held_s:.3} s");
    settle(Duration::from_millis(1500));
    assert!(vehicle.heard_since("BPRMB", since_s + held_s).is_empty());
}

/// The operator releases the hold, and the vehicle is steered again.
fn is_released(vehicle: &Scripted, runtime: &Process) {
    runtime.signal(Signal::USR2);
    vehicle.hears("BPRMB", vehicle.heard("BPRMB").len() + 2, SOON);
}

/// The lease ends at once, and the process soon and in order.
fn ends(vehicle: &Scripted, mut runtime: Process) -> String {
    let since_s = vehicle.now_s();
    let stopped = Stopwatch::start();
    runtime.signal(Signal::TERM);
    let ended_s = ended_after_s(vehicle, since_s, SOON);
    assert!(ended_s < OBEYED_WITHIN_S, "ended after {ended_s:.3} s");
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    assert!(stopped.elapsed() < ENDS_WITHIN, "gone after {:?}", stopped.elapsed());
    let said = runtime.stderr();
    assert!(!said.contains("panicked"), "{said}");
    said
}

fn steered_without_a_gap(vehicle: &Scripted, since_s: f64) {
    let gap_s = worst_gap_s(&vehicle.heard_since("BPRMB", since_s));
    assert!(gap_s < GAP_MAX_S, "{gap_s:.3} s without a modify");
}

#[test]
fn sr_022_the_log_hangs_for_eight_seconds_and_says_what_it_missed() {
    let (mission, stall) = (Mission::steady(), Stall::new());
    let vehicle = Scripted::start(Behavior::default());
    let runtime = runtime(&mission, &vehicle.address, &stall, &["logs"]);
    vehicle.hears("BPRMB", 3, SOON);
    let since_s = vehicle.now_s();
    stall.begin();
    // More than the queue holds before the disk accepts anything.
    vehicle.change(|behavior| behavior.noise_kib_per_s = 6 << 10);
    runtime.says("records are left out until it does", SOON);
    vehicle.change(|behavior| behavior.noise_kib_per_s = 0);
    while vehicle.now_s() < since_s + 8.0 {
        settle(Duration::from_millis(100));
    }
    steered_without_a_gap(&vehicle, since_s);
    is_held(&vehicle, &runtime);
    stall.end();
    runtime.says("the log has a gap of", SOON);
    is_released(&vehicle, &runtime);
    ends(&vehicle, runtime);

    assert!(stall.held()[0].starts_with("write "), "{:?}", stall.held());
    let path = fs::read_dir(mission.beside("logs")).unwrap().next().unwrap().unwrap();
    let log = backseat_recorder::read(&path.path()).expect("the log is whole");
    assert!(log.complete);
    let gaps: Vec<(usize, u64)> = log
        .entries
        .iter()
        .enumerate()
        .filter_map(|(place, entry)| {
            let Record::Gap { records, .. } = entry.record else {
                return None;
            };
            Some((place, records))
        })
        .collect();
    let [(place, records)] = gaps[..] else {
        panic!("{gaps:?}");
    };
    assert!(records > 10, "{records} were left out");
    let sent_since = log.entries[place..]
        .iter()
        .filter(|entry| matches!(&entry.record, Record::Sent(bytes) if bytes.starts_with(b"$BPRMB")));
    assert!(sent_since.count() >= 2, "the log goes on");
}

#[test]
fn sr_022_the_log_hangs_for_ever() {
    let (mission, stall) = (Mission::steady(), Stall::new());
    let vehicle = Scripted::start(Behavior::default());
    let runtime = runtime(&mission, &vehicle.address, &stall, &["logs"]);
    vehicle.hears("BPRMB", 3, SOON);
    let since_s = vehicle.now_s();
    stall.begin();
    stall.holds("write", "logs", SOON);
    vehicle.hears("BPRMB", vehicle.heard("BPRMB").len() + 6, SOON);
    steered_without_a_gap(&vehicle, since_s);
    is_held(&vehicle, &runtime);
    is_released(&vehicle, &runtime);
    let said = ends(&vehicle, runtime);
    assert!(
        said.contains("the log has no end: the disk does not accept it"),
        "{said}"
    );
}

#[test]
fn sr_022_the_state_folder_hangs_and_the_lease_goes_on_until_the_operator_ends_it() {
    let (mission, stall) = (Mission::steady(), Stall::new());
    let vehicle = Scripted::start(Behavior::default());
    let runtime = runtime(&mission, &vehicle.address, &stall, &["state"]);
    vehicle.hears("BPRMB", 3, SOON);
    let since_s = vehicle.now_s();
    stall.begin();
    stall.holds("", "state", SOON);
    vehicle.hears("BPRMB", vehicle.heard("BPRMB").len() + 4, SOON);
    steered_without_a_gap(&vehicle, since_s);
    is_held(&vehicle, &runtime);
    runtime.says(
        "until it does, the operator's hold or release counts for this run only",
        SOON,
    );
    let said = ends_held(runtime);
    assert!(said.contains("the state folder does not answer"), "{said}");
    assert!(!mission.beside("state/hold").exists(), "nothing reached the disk");
}

/// There is no lease to end.
fn ends_held(mut runtime: Process) -> String {
    let stopped = Stopwatch::start();
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    assert!(stopped.elapsed() < ENDS_WITHIN, "gone after {:?}", stopped.elapsed());
    runtime.stderr()
}

#[test]
fn sr_022_no_insert_leaves_while_the_state_folder_hangs_and_a_hold_reaches_it_when_it_thaws() {
    let mission = Mission::steady().append(
        "mission.toml",
        "[[plugin]]\nname = \"inserter\"\ncomponent = \"faulty\"\ngrants = [\"insert\", \"interrupt\"]\n\
         [plugin.config]\nfault = \"cross_fence\"\ntarget_east_m = -500.0\ntarget_north_m = 0.0\n\
         after_current = true",
    );
    let (vehicle, stall) = (Vehicle::start(&mission), Stall::new());
    fs::create_dir(mission.beside("state")).expect("the folder is ours");
    fs::write(mission.beside("state/vehicle"), "steady").expect("the folder is ours");
    fs::write(mission.beside("state/identifiers"), "70").expect("the folder is ours");
    // Only the draft hangs: if the whole folder hung, the start itself would.
    stall.begin();
    let runtime = runtime(
        &mission,
        &vehicle.address,
        &stall,
        &["state/identifiers.new", "state/hold.new"],
    );
    stall.holds("open64", "state/identifiers.new", SOON);
    vehicle.receives("BPRMB", 6, SOON);
    let held = Stopwatch::start();
    runtime.signal(Signal::USR1);
    vehicle.receives("BPEMB", 1, SOON);
    // The vehicle's log is read at intervals, and the machine may be busy.
    assert!(
        held.elapsed() < Duration::from_secs(2),
        "held after {:?}",
        held.elapsed()
    );
    assert!(vehicle.received("BPRTK").is_empty(), "{}", vehicle.story());
    assert!(!mission.beside("state/hold").exists());

    stall.end();
    runtime.says("the state folder answers again", SOON);
    backseat_suite::eventually(
        SOON,
        || mission.beside("state/hold").exists().then_some(()),
        || format!("the hold is not kept\n{}", runtime.stderr()),
    );
    runtime.signal(Signal::USR2);
    // Identifiers requested during the stall are on disk now, so whatever is sent from here on is reserved.
    let record = || fs::read_to_string(mission.beside("state/identifiers")).unwrap_or_default();
    backseat_suite::eventually(
        SOON,
        || {
            let below: u32 = record().split(' ').next()?.trim().parse().ok()?;
            (below > 70).then_some(())
        },
        || format!("nothing is reserved: {}", record()),
    );
}

#[test]
fn sr_022_a_name_that_nobody_resolves_does_not_keep_the_process() {
    let (mission, stall) = (Mission::steady(), Stall::new());
    stall.begin();
    let mut runtime = Backseat::new()
        .args(["run", "--arm", "--connect", "vehicle.invalid:29500", "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .stalled(&stall, &["/etc/hosts".as_ref()])
        .spawn();
    stall.holds("getaddrinfo", "/etc/hosts", SOON);
    let stopped = Stopwatch::start();
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    assert!(stopped.elapsed() < ENDS_WITHIN, "gone after {:?}", stopped.elapsed());
}

#[test]
fn sr_022_the_cache_of_compiled_plugins_hangs_and_the_runtime_starts_without_it() {
    let (mission, stall) = (Mission::steady(), Stall::new());
    let vehicle = Scripted::start(Behavior::default());
    let cache = mission.beside("cache");
    fs::create_dir(&cache).unwrap();
    stall.begin();
    let runtime = Backseat::new()
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .env("BACKSEAT_CACHE", &cache)
        .stalled(&stall, &[&cache])
        .spawn();
    let said = runtime.says("no cache of compiled plugins: ", SOON);
    assert!(said.contains("the disk has not answered for 5 s"), "{said}");
    vehicle.hears("BPRMB", 3, SOON);
    assert!(stall.held()[0].starts_with("open"), "{:?}", stall.held());
    ends(&vehicle, runtime);
}

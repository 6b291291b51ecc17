//! The deployed process with a vehicle that was written from the specification alone, and is late, deaf, wrong or sends
//! too much: the guarantees of core hold over TCP too.

use std::time::Duration;

use backseat_suite::{Backseat, Behavior, Heard, Mission, Process, Scripted, Signal, Stopwatch, settle};

use super::session::SOON;
use crate::viewers::viewer::{channels, check};

/// A fault of the vehicle.
type Wrong = fn(&mut Behavior);

fn steered(behavior: Behavior) -> (Mission, Scripted, Process) {
    let mission = Mission::steady();
    let vehicle = Scripted::start(behavior);
    let runtime = Backseat::new()
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .spawn();
    (mission, vehicle, runtime)
}

/// Steers under a lease for some time.
fn steering() -> (Mission, Scripted, Process) {
    let (mission, vehicle, runtime) = steered(Behavior::default());
    vehicle.hears("BPRMB", 4, SOON);
    (mission, vehicle, runtime)
}

pub(crate) fn worst_gap_s(heard: &[Heard]) -> f64 {
    heard
        .windows(2)
        .map(|pair| pair[1].at_s - pair[0].at_s)
        .fold(0.0, f64::max)
}

/// Waits for the end of the lease after a time, and returns how long that took, seconds.
pub(crate) fn ended_after_s(vehicle: &Scripted, since_s: f64, within: Duration) -> f64 {
    let watch = Stopwatch::start();
    loop {
        if let Some(ended) = vehicle.heard_since("BPEMB", since_s).first() {
            return ended.at_s - since_s;
        }
        assert!(
            watch.elapsed() < within,
            "no BPEMB within {within:?}: {:?}",
            vehicle.heard("BPRMB").last()
        );
        settle(Duration::from_millis(20));
    }
}

#[test]
fn sr_003_a_status_each_second_and_a_lease_without_a_gap() {
    let (_mission, vehicle, runtime) = steering();
    settle(Duration::from_secs(6));
    let modifies = worst_gap_s(&vehicle.heard("BPRMB"));
    let beats = worst_gap_s(&vehicle.heard("BPSTS"));
    assert!(
        modifies < 2.5 && beats < 2.5,
        "{modifies:.2} s without BPRMB, {beats:.2} s without BPSTS"
    );
    let beats = vehicle.heard("BPSTS").len();
    assert!(beats >= 7, "{beats} BPSTS\n{}", runtime.stderr());
}

#[test]
fn sr_023_words_that_are_late_from_the_first_byte_steer_nothing() {
    let late = Behavior {
        late: Duration::from_secs(3),
        ..Behavior::default()
    };
    let (_mission, vehicle, runtime) = steered(late);
    settle(Duration::from_secs(14));
    assert!(vehicle.heard("BPRMB").is_empty(), "{}", runtime.stderr());
    assert!(vehicle.heard("BPSTS").len() > 8);
}

#[test]
fn sr_023_a_link_that_becomes_late_ends_the_lease_either_way() {
    let becomes: [Wrong; 2] = [
        |behavior| behavior.late = Duration::from_secs(4),
        |behavior| behavior.slow = Duration::from_secs(4),
    ];
    for become_late in becomes {
        let (_mission, vehicle, _runtime) = steering();
        let since_s = vehicle.now_s();
        vehicle.change(become_late);
        // The vehicle receives sentences 4 s after they left.
        let ended_s = ended_after_s(&vehicle, since_s, Duration::from_secs(15));
        assert!(ended_s < 8.5, "{ended_s:.2} s");
        settle(Duration::from_secs(6));
        let last = vehicle.heard("BPRMB").last().expect("there were").at_s;
        assert!(last <= since_s + ended_s, "none after the end of the lease");
    }
}

#[test]
fn sr_023_a_vehicle_that_reads_nothing_finds_the_end_of_the_lease_when_it_reads_again() {
    let (_mission, vehicle, _runtime) = steering();
    vehicle.change(|behavior| behavior.deaf = true);
    settle(Duration::from_secs(6));
    let since_s = vehicle.now_s();
    vehicle.change(|behavior| behavior.deaf = false);
    let _ended_s = ended_after_s(&vehicle, since_s, Duration::from_secs(5));
    // Everything that waited is read at once: the lease lasted for 3 s at most, and its end comes last.
    let waited = vehicle.heard_since("BPRMB", since_s).len();
    assert!(waited <= 4, "{waited} BPRMB waited");
}

#[test]
fn sr_023_a_vehicle_that_acknowledges_nothing_is_not_steered_and_that_is_said() {
    let mute = Behavior {
        mute: true,
        ..Behavior::default()
    };
    let (_mission, vehicle, runtime) = steered(mute);
    runtime.says(
        "acknowledges nothing on this connection: it is not steered",
        Duration::from_secs(30),
    );
    assert!(vehicle.heard("BPRMB").is_empty());
}

#[test]
fn sr_024_a_position_that_creeps_and_velocities_that_stay_away_end_the_lease() {
    let wrongs: [(&str, Wrong); 2] = [
        ("creeping by 90 m/s", |behavior| behavior.creep_mps = 90.0),
        ("no BFNVR", |behavior| behavior.velocities = false),
    ];
    for (name, wrong) in wrongs {
        let (_mission, vehicle, runtime) = steering();
        let since_s = vehicle.now_s();
        vehicle.change(wrong);
        let ended_s = ended_after_s(&vehicle, since_s, Duration::from_secs(5));
        assert!(ended_s < 2.5, "{name}: {ended_s:.2} s\n{}", runtime.stderr());
        settle(Duration::from_secs(3));
        assert!(
            vehicle.heard_since("BPRMB", since_s + ended_s + 0.01).is_empty(),
            "{name}"
        );
    }
}

#[test]
fn sr_025_another_dive_is_not_steered_before_its_plan_is_told() {
    let (_mission, vehicle, runtime) = steering();
    let since_s = vehicle.now_s();
    vehicle.change(|behavior| {
        behavior.hides_plan = true;
        behavior.dive = "other.dive";
    });
    let ended_s = ended_after_s(&vehicle, since_s, Duration::from_secs(5));
    settle(Duration::from_secs(4));
    assert!(
        vehicle.heard_since("BPRMB", since_s + ended_s + 0.01).is_empty(),
        "{}",
        runtime.stderr()
    );
    assert!(!vehicle.heard_since("BPRMP", since_s).is_empty());
    vehicle.change(|behavior| behavior.hides_plan = false);
    let count = vehicle.heard("BPRMB").len();
    vehicle.hears("BPRMB", count + 2, Duration::from_secs(30));
}

#[test]
fn sr_013_floods_of_the_vehicle_move_neither_the_lease_nor_the_memory() {
    let floods: [Wrong; 2] = [
        |behavior| behavior.commands_per_s = 2000,
        |behavior| behavior.begins_per_s = 200,
    ];
    for (number, flood) in floods.into_iter().enumerate() {
        let (_mission, vehicle, mut runtime) = steering();
        let before_kib = runtime.memory_kib();
        let since_s = vehicle.now_s();
        vehicle.change(flood);
        settle(Duration::from_secs(6));
        let beats = worst_gap_s(&vehicle.heard_since("BPSTS", since_s));
        assert!(beats < 2.5, "{beats:.2} s without BPSTS");
        if number == 0 {
            let gap_s = worst_gap_s(&vehicle.heard_since("BPRMB", since_s));
            assert!(gap_s < 2.5, "{gap_s:.2} s without BPRMB");
        }
        let grown_kib = runtime.memory_kib().saturating_sub(before_kib);
        assert!(grown_kib < 48 * 1024, "{grown_kib} KiB more");
        let asked = vehicle.heard_since("BPRMP", since_s).len();
        assert!(asked <= 8, "{asked} BPRMP");
        let said = runtime.stderr();
        assert!(said.len() < 64 * 1024, "{} bytes of words", said.len());
        runtime.signal(Signal::TERM);
        assert_eq!(runtime.wait(Duration::from_secs(10)), Some(0));
    }
}

#[test]
fn sr_011_before_power_goes_the_log_is_closed_and_the_process_has_ended() {
    let (mission, vehicle, mut runtime) = steering();
    let since_s = vehicle.now_s();
    vehicle.shut_down();
    let ended_s = ended_after_s(&vehicle, since_s, Duration::from_secs(3));
    assert!(ended_s < 1.0, "{ended_s:.2} s");
    assert_eq!(runtime.wait(Duration::from_secs(10)), Some(0), "{}", runtime.stderr());
    let log = std::fs::read_dir(mission.beside("logs"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    assert!(backseat_recorder::read(&log).unwrap().complete, "the log has its end");
}

/// A reader plays a log in the order of its times, and a replay gives core the times in the order of the records.
#[test]
fn the_times_of_the_log_rise_however_busy_the_link_is() {
    let (mission, vehicle, mut runtime) = steering();
    // With so many reads, some come just before the loop's timer for something that is due already.
    vehicle.change(|behavior| behavior.noise_kib_per_s = 4 << 10);
    settle(Duration::from_secs(5));
    vehicle.change(|behavior| behavior.noise_kib_per_s = 0);
    settle(Duration::from_secs(1));
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let log = std::fs::read_dir(mission.beside("logs")).unwrap().next().unwrap();
    // This fails where a time falls, whatever the channels.
    let channels = channels(&std::fs::read(log.unwrap().path()).unwrap());
    check(&channels);
    let reads = channels["/link/from_vehicle"].messages.len();
    assert!(reads > 200, "{reads} reads");
    for topic in ["/position", "/log", "/map/fence"] {
        assert!(channels.contains_key(topic), "{:?}", channels.keys());
    }
}

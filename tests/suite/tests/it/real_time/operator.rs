//! The operator overrules every plugin, by signal, and across restarts (safety requirement 015).

use std::time::Duration;

use backseat_suite::{Backseat, Mission, Signal, Vehicle, eventually, settle};

use super::session::{SOON, runtime, steers};

#[test]
fn sr_015_a_hold_ends_the_lease_and_stands_until_it_is_released() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut first = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    first.signal(Signal::USR1);
    vehicle.receives("BPEMB", 1, SOON);
    settle(Duration::from_secs(4));
    let lines = vehicle.lines();
    let ended = lines.iter().position(|line| line.is_received("BPEMB")).unwrap();
    assert!(
        !lines[ended..].iter().any(steers),
        "nothing after the hold\n{}",
        vehicle.story()
    );
    assert_eq!(vehicle.received("BPEMB").len(), 1, "one BPEMB is enough");
    assert_eq!(first.ended(), None, "the session goes on");
    assert!(mission.beside("state/hold").exists(), "the hold is on disk");

    // A crash does not release it.
    first.kill();
    let before = vehicle.lines().iter().filter(|line| steers(line)).count();
    let mut second = runtime(&mission, &vehicle.address, &["--arm"]);
    second.says("the operator's hold is set", SOON);
    second.says("the operator's hold is set", SOON);
    settle(Duration::from_secs(4));
    assert_eq!(
        vehicle.lines().iter().filter(|line| steers(line)).count(),
        before,
        "{}",
        vehicle.story()
    );

    second.signal(Signal::USR2);
    vehicle.receives("BPRMB", before + 2, SOON);
    assert!(!mission.beside("state/hold").exists());
    second.kill();
    let steered = vehicle.received("BPRMB").len();
    let third = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", steered + 2, SOON);
    assert!(
        !third.stderr().contains("hold is set"),
        "a release outlives the process too"
    );
}

#[test]
fn one_release_undoes_any_number_of_holds() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 1, SOON);
    for _ in 0..3 {
        runtime.signal(Signal::USR1);
    }
    runtime.says("operator: hold", SOON);
    // A hold and a release that are read together count as a hold; here all three are read before.
    settle(Duration::from_millis(500));
    runtime.signal(Signal::USR2);
    let count = vehicle.received("BPRMB").len();
    vehicle.receives("BPRMB", count + 2, SOON);
}

#[test]
fn the_screen_says_why_nothing_steers_and_what_to_do_about_it() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let armed = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 1, SOON);
    armed.signal(Signal::USR1);
    let hold = mission.beside("state/hold");
    let line = armed.says("no control: the operator's hold is set", SOON);
    assert!(line.contains(&format!("delete {}", hold.display())), "{line}");
    // The reason lasts, and so does the line.
    settle(Duration::from_secs(5));
    assert_eq!(
        armed.stderr().matches("no control: the operator's hold is set").count(),
        1
    );
    std::fs::remove_file(hold).unwrap();
    let count = vehicle.received("BPRMB").len();
    vehicle.receives("BPRMB", count + 1, SOON);
    drop(armed);

    let calm = runtime(&mission, &vehicle.address, &[]);
    calm.says(
        "nothing steers: the runtime is not armed; to arm, start with --arm",
        SOON,
    );
}

#[test]
fn sr_015_a_state_folder_that_cannot_be_seen_is_a_hold() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    let (state, elsewhere) = (mission.beside("state"), mission.beside("elsewhere"));
    std::fs::rename(&state, &elsewhere).unwrap();
    let line = runtime.says("nobody can hold with it, and this is a hold", SOON);
    assert!(line.contains("state: the folder is gone"), "{line}");
    vehicle.receives("BPEMB", 1, SOON);
    let steered = vehicle.received("BPRMB").len();
    // The folder is back, and has the hold, which its file releases as always.
    std::fs::rename(&elsewhere, &state).unwrap();
    eventually(
        SOON,
        || state.join("hold").exists().then_some(()),
        || "no hold".to_owned(),
    );
    settle(Duration::from_secs(2));
    assert_eq!(vehicle.received("BPRMB").len(), steered, "{}", vehicle.story());
    std::fs::remove_file(state.join("hold")).unwrap();
    vehicle.receives("BPRMB", steered + 2, SOON);
    let said = runtime.stderr();
    assert!(said.contains("release by the file"), "{said}");
}

#[test]
fn a_vehicle_has_one_armed_runtime_whatever_its_state_folder_is() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mut first = runtime(&mission, &vehicle.address, &["--arm"]);
    first.says("armed: plugins may steer the vehicle at", SOON);
    vehicle.receives("BPRMB", 1, SOON);
    let second = |arguments: &[&str]| {
        Backseat::new()
            .args(["run", "--connect", &vehicle.address, "--log"])
            .arg(mission.beside("other-logs"))
            .arg("--state")
            .arg(mission.beside("other-state"))
            .args(arguments.iter().copied())
            .mission(&mission)
            .spawn()
    };
    let mut refused = second(&["--arm"]);
    assert_eq!(refused.wait(SOON), Some(2), "{}", refused.stderr());
    let said = refused.stderr();
    assert!(
        said.contains("another runtime on this computer is armed for this vehicle"),
        "{said}"
    );
    // Who only listens disturbs nobody.
    second(&[]).says("not armed: nothing that steers will be sent", SOON);
    // A killed runtime stands in nobody's way.
    first.kill();
    let steered = vehicle.received("BPRMB").len();
    let third = second(&["--arm"]);
    vehicle.receives("BPRMB", steered + 1, SOON);
    third.says("pilot steers", SOON);
}

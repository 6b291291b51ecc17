//! At sea nothing is needed that only simulation uses.

use backseat_suite::{Backseat, Mission, Signal, Vehicle};

use crate::real_time::session::SOON;

/// A mission whose `world.toml` was damaged or removed after the vehicle had read it.
fn spoilt(mission: Mission, world: Option<&str>) -> Mission {
    match world {
        Some(world) => mission.write("world.toml", world),
        None => mission.without("world.toml"),
    }
}

#[track_caller]
fn steers(program: Backseat, world: Option<&str>) {
    let mission = Mission::steady();
    let vehicle = Vehicle::start(&mission);
    let mission = spoilt(mission, world);
    let mut runtime = program
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .spawn();
    let _ = vehicle.receives("BPRMB", 3, SOON);
    runtime.signal(Signal::INT);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
}

#[test]
fn a_world_that_is_garbage_keeps_nobody_from_a_dive() {
    steers(Backseat::new(), Some("nonsense\n"));
}

#[test]
fn the_program_for_sea_steers_beside_a_world_that_is_garbage_or_gone() {
    steers(Backseat::new().for_sea(), Some("[seabed]\ngrid = \"nowhere.asc\"\n"));
    steers(Backseat::new().for_sea(), None);
}

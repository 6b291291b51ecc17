//! What `world.toml` adds to a check: the vehicle and the plan to simulate, and whether they are possible.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use backseat_mission::Mission;
use backseat_scenario::Scenario;

use super::front_seat::FrontSeat;
use crate::output::say;
use crate::sonar_settings::beyond_sonar;
use crate::surroundings::beyond_limits;

/// The front seat of the mission's scenario, where the mission has one.
pub(super) fn front_seat(mission: &Mission, plan: Option<&Path>, sets: &[String]) -> Result<FrontSeat> {
    let scenario = if sets.is_empty() {
        Scenario::find(mission)?
    } else {
        Some(Scenario::load_with(mission, sets)?)
    };
    let Some(scenario) = scenario else {
        return Ok(FrontSeat {
            remark: Some("no world.toml: this mission cannot be simulated"),
            ..FrontSeat::of_mission(mission, plan)?
        });
    };
    let vehicle = scenario.vehicle_of(mission);
    let plan = scenario.plan(mission, plan)?;
    // Some errors show only with a seed: a vehicle or a seabed that is not possible.
    let simulated = scenario
        .vehicle(1)
        .with_context(|| format!("{}", scenario.path.display()))?;
    let limits = beyond_limits(mission, &scenario, simulated.world());
    for line in limits.into_iter().chain(beyond_sonar(mission, &scenario)) {
        say!("warning: {line}");
    }
    let start = scenario
        .start()
        .ok_or_else(|| anyhow!("{}: origin: expected ±85 and ±180 degrees", scenario.path.display()))?;
    Ok(FrontSeat {
        vehicle: Some((vehicle.class, vehicle.limits())),
        plan: Some(plan),
        start: Some(start),
        start_depth_m: scenario.world.start.depth_m,
        starts_after_s: scenario.world.mission.starts_after_s,
        simulated_at: Some(scenario.world.start.utc),
        remark: None,
    })
}

//! The mock vehicle as a TCP server: for our own runtime and for any other SPI client.

mod connection;
mod log;
mod server;
mod status;

use anyhow::{Context, Result};
use backseat_mission::Mission;
use backseat_mvc::LinkFaults;
use backseat_scenario::{Scenario, read_faults};

use crate::cli::{Mvc, Profile};
use crate::mvc::log::Log;
use crate::mvc::server::serve;

pub(crate) fn mvc(arguments: &Mvc) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut scenario = Scenario::load(&mission)?;
    match arguments.profile {
        Some(Profile::Spec) => scenario.world.spi.profile = backseat_mvc::Profile::Spec,
        Some(Profile::Field) => scenario.world.spi.profile = backseat_mvc::Profile::Field,
        None => {}
    }
    if !arguments.iprole.is_empty() {
        scenario.world.spi.roles.clone_from(&arguments.iprole);
    }
    let mut vehicle = scenario
        .vehicle(arguments.seed)
        .with_context(|| format!("{}", scenario.path.display()))?;
    let faults = match &arguments.faults {
        Some(path) => {
            let plan = read_faults(path)?;
            vehicle.set_faults(plan.clone());
            plan
        }
        None => scenario.world.faults.plan()?,
    };
    let faults = LinkFaults::new(&faults, arguments.seed);
    let log = match &arguments.log {
        Some(path) => Some(Log::create(path)?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(serve(arguments, vehicle, faults, log))?;
    Ok(true)
}

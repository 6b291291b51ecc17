//! The mock vehicle as a TCP server: for our own runtime and for any other SPI client.

mod connection;
mod log;
mod server;
mod status;

use anyhow::{Context, Result};
use backseat_mission::Mission;
use backseat_mvc::{FaultPlan, LinkFaults};

use crate::cli::{Mvc, Profile};
use crate::mvc::log::Log;
use crate::mvc::server::serve;

pub(crate) fn mvc(arguments: &Mvc) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut world = mission.world()?.clone();
    match arguments.profile {
        Some(Profile::Spec) => world.spi.profile = backseat_mvc::Profile::Spec,
        Some(Profile::Field) => world.spi.profile = backseat_mvc::Profile::Field,
        None => {}
    }
    if !arguments.iprole.is_empty() {
        world.spi.roles.clone_from(&arguments.iprole);
    }
    let file = arguments.mission.mission.join("world.toml");
    let mut vehicle = mission
        .vehicle(&world, arguments.seed)
        .with_context(|| format!("{}", file.display()))?;
    let faults = match &arguments.faults {
        Some(path) => {
            let text = std::fs::read_to_string(path).with_context(|| format!("--faults {}", path.display()))?;
            let plan = FaultPlan::from_toml(&text).with_context(|| format!("{}", path.display()))?;
            vehicle.set_faults(plan.clone());
            plan
        }
        None => world.faults.plan()?,
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

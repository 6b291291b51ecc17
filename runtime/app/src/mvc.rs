//! The mock vehicle as a TCP server, for our own runtime and for any other SPI client.

mod connection;
pub(crate) mod log;
mod server;
mod status;

use std::path::PathBuf;

use anyhow::{Context, Result};
use backseat_mission::Mission;
use backseat_mvc::{LinkFaults, RoleConfig};
use backseat_scenario::{Scenario, read_faults};
use clap::{Args, ValueEnum};

use crate::cli::MissionArguments;
use crate::mvc::log::Log;
use crate::mvc::server::serve;
use crate::speed::Speed;

#[derive(Debug, Args)]
pub(crate) struct Mvc {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Listen on this address
    #[arg(long, default_value = "127.0.0.1:29500", value_name = "ADDR:PORT")]
    pub(crate) listen: String,
    /// Run this many times faster than real time, or `max` for as fast as the clients read, from the first client on
    #[arg(long, default_value = "1", value_name = "X|max")]
    pub(crate) speed: Speed,
    /// Which status messages are on from the start [default: as in world.toml]
    #[arg(long)]
    pub(crate) profile: Option<Profile>,
    /// Give this role to the client that connects from this address, such as 192.168.10.10::sonar. Where roles are
    /// configured, a client without one is turned away. Repeat the option, or separate roles by commas [default: the
    /// roles in world.toml]
    #[arg(long, value_name = "ADDRESS:PORT:ROLE", value_delimiter = ',')]
    pub(crate) iprole: Vec<RoleConfig>,
    /// Inject the faults of vehicle and links in this file, instead of those in world.toml
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Seed for the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write every sentence in both directions and every event to this file, with the vehicle's clock
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
    /// Also serve the mock payload controller with its sonars, for 7k clients: on this vehicle, in this world, by this
    /// clock [default address: 127.0.0.1:7000]
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:7000")]
    pub(crate) with_plc: Option<String>,
    /// Keep the payload controller's files in this folder: its logs, its run list, its settings. The disk of the folder
    /// takes the place of [plc.disk] [default: files are not kept]
    #[arg(long, value_name = "DIR", requires = "with_plc")]
    pub(crate) plc_folder: Option<PathBuf>,
    /// End after this many seconds of the vehicle's time
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Profile {
    /// As in the specification: all status messages are off
    Spec,
    /// As real vehicles do: CTL and MIS are on
    Field,
}

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
    runtime.block_on(serve(arguments, &scenario, vehicle, faults, log))?;
    Ok(true)
}

/// A duration on the command line.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=1e9).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, from 0.001 to 1e9".to_owned()),
    }
}

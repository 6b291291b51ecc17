//! The mock vehicle as a TCP server, for our own runtime and for any other SPI client.

mod connection;
mod draws;
pub(crate) mod log;
pub(crate) mod server;
pub(crate) mod status;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result};
use backseat_mission::Mission;
use backseat_mvc::{LinkFaults, RoleConfig};
use backseat_scenario::{Scenario, read_faults};
use backseat_units::Timestamp;
use clap::{Args, ValueEnum};
use tokio::signal::unix::{SignalKind, signal};

use crate::cli::MissionArguments;
use crate::clock::Clock;
use crate::mvc::log::Log;
use crate::mvc::server::Service;
use crate::mvc::status::Status;
use crate::peer::listen;
use crate::plc::controller::{Controller, Setup};
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
    #[command(flatten)]
    pub(crate) vehicle: VehicleArguments,
    /// Give this role to the client that connects from this address, such as 192.168.10.10::sonar. Where roles are
    /// configured, a client without one is turned away. Repeat the option, or separate roles by commas [default: the
    /// roles in world.toml]
    #[arg(long, value_name = "ADDRESS:PORT:ROLE", value_delimiter = ',')]
    pub(crate) iprole: Vec<RoleConfig>,
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

/// The arguments of all commands that fly the mock vehicle in real time.
#[derive(Debug, Args)]
pub(crate) struct VehicleArguments {
    /// What the vehicle's side of the interface is like, whatever world.toml says [default: as in world.toml]
    #[arg(long)]
    pub(crate) profile: Option<Profile>,
    /// Inject the faults of vehicle and links in this file, instead of those in world.toml
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Seed for the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
}

impl VehicleArguments {
    /// The vehicle of a scenario, and what goes wrong with its links.
    pub(crate) fn vehicle(&self, scenario: &mut Scenario) -> Result<(backseat_mvc::Mvc, LinkFaults)> {
        match self.profile {
            Some(Profile::Spec) => scenario.world.spi.profile = backseat_mvc::Profile::Spec,
            Some(Profile::Field) => scenario.world.spi.profile = backseat_mvc::Profile::Field,
            Some(Profile::Sandshark) => scenario.world.like_sandshark(),
            None => {}
        }
        let mut vehicle = scenario
            .vehicle(self.seed)
            .with_context(|| format!("{}", scenario.path.display()))?;
        let faults = match &self.faults {
            Some(path) => {
                let plan = read_faults(path)?;
                vehicle.set_faults(plan.clone());
                plan
            }
            None => scenario.world.faults.plan()?,
        };
        Ok((vehicle, LinkFaults::new(&faults, self.seed)))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Profile {
    /// As in the specification: all status messages are off
    Spec,
    /// As real vehicles do: CTL and MIS are on
    Field,
    /// As recordings of a Sandshark show it: BFVER 1.11, CTL and MIS on, a blank line after each sentence, NAK for broken
    /// lines, BPLOG,ALL for navigation alone, a clock hours away
    Sandshark,
}

pub(crate) fn mvc(arguments: &Mvc) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut scenario = Scenario::load(&mission)?;
    if !arguments.iprole.is_empty() {
        scenario.world.spi.roles.clone_from(&arguments.iprole);
    }
    let (vehicle, faults) = arguments.vehicle.vehicle(&mut scenario)?;
    draws::tell(&vehicle, &scenario.world.interpretation, arguments.vehicle.seed);
    let log = match &arguments.log {
        Some(path) => Some(Log::create(path)?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(serve(arguments, &scenario, vehicle, faults, log))?;
    Ok(true)
}

/// Serves until a signal arrives or the given duration is over.
async fn serve(
    arguments: &Mvc,
    scenario: &Scenario,
    vehicle: backseat_mvc::Mvc,
    faults: LinkFaults,
    log: Option<Log>,
) -> Result<()> {
    let listener = listen(&arguments.listen, "--listen").await?;
    let clock = Clock::start();
    let controller = match &arguments.with_plc {
        Some(address) => {
            let setup = Setup {
                address,
                option: "--with-plc",
                folder: arguments.plc_folder.as_deref(),
                seed: arguments.vehicle.seed,
                utc: scenario.world.start.utc,
            };
            Some(Controller::start(scenario, setup, clock).await?)
        }
        None => None,
    };
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let ended = async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    };
    let service = Service {
        listener,
        vehicle,
        faults,
        controller,
        clock,
        speed: arguments.speed,
        end: arguments
            .duration
            .map(|seconds| Timestamp::ZERO + Duration::from_secs_f64(seconds)),
        log,
        status: Status::new(),
        spectator: None,
    };
    service.serve(ended).await.map(drop)
}

/// A duration on the command line.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=1e9).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, from 0.001 to 1e9".to_owned()),
    }
}

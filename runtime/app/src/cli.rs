use std::path::PathBuf;

use backseat_mission::Layers;
use clap::{Args, Parser, Subcommand};

use crate::check::Check;
use crate::explain::Explain;
use crate::log::Log;
#[cfg(feature = "simulation")]
use crate::mvc::Mvc;
use crate::run::Run;
#[cfg(feature = "simulation")]
use crate::sim::Sim;
use crate::spi::Spi;

/// Fly adaptive-survey plugins on a Bluefin vehicle: in simulation, and at sea.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fly a mission in simulation: runtime, plugins and mock vehicle on a virtual clock
    #[cfg(feature = "simulation")]
    Sim(Sim),
    /// Fly a mission on a vehicle, over TCP; without --arm it sends nothing that steers
    Run(Run),
    /// Run the mock vehicle alone, for any SPI client
    ///
    /// It flies the front seat's plan of the mission's world.toml and serves the Standard Payload Interface over TCP to
    /// several clients at once. Nothing that a client sends harms another: at most it loses its own connection.
    ///
    /// On a terminal a status line shows the vehicle at a glance; elsewhere a line a minute. Ctrl-C or SIGTERM ends it.
    #[cfg(feature = "simulation")]
    Mvc(Mvc),
    /// Check a mission before a dive: its files, fence, plugins and plan
    Check(Check),
    /// Look at the log of a run
    #[command(subcommand)]
    Log(Log),
    /// Look at the Standard Payload Interface: its messages, recordings of it, a live vehicle
    #[command(subcommand)]
    Spi(Spi),
    /// Explain a key of a mission's files, such as turn_rate_dps
    Explain(Explain),
}

/// What all commands that read a mission share.
#[derive(Debug, Args)]
pub(crate) struct MissionArguments {
    /// The mission's folder, with mission.toml, its fence (fence.geojson, fence.plan or fence.kml) and, to simulate it,
    /// world.toml
    pub(crate) mission: PathBuf,
    /// Look for plugins given by bare name in this folder first
    #[arg(long, value_name = "DIR", value_parser = folder)]
    pub(crate) plugins: Option<PathBuf>,
    /// Set a key of mission.toml, over the file and the environment, such as limits.speed_max_mps=1.8
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

impl MissionArguments {
    pub(crate) fn layers(&self) -> Layers {
        Layers {
            set: self.set.clone(),
            environment: true,
        }
    }
}

fn folder(text: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from(text);
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err("no such folder".to_owned())
    }
}

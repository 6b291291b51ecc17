//! The mock vehicle as a TCP server, for our own runtime and for any other SPI client.

mod bar;
mod connection;
mod draws;
pub(crate) mod log;
pub(crate) mod operator;
pub(crate) mod server;
mod sketch;
pub(crate) mod status;
mod truth;
mod vehicle_clock;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_mvc::{LinkFaults, MvcEvent, RoleConfig};
use backseat_scenario::{Scenario, read_faults, read_script};
use backseat_units::Timestamp;
use clap::{Args, ValueEnum};
use tokio::signal::unix::{SignalKind, signal};
use tracing::info;

use crate::arguments::{WorldArguments, seed};
use crate::clock::Clock;
use crate::map::open;
use crate::mvc::log::Log;
use crate::mvc::operator::Lines;
use crate::mvc::server::{Service, Spectator};
use crate::mvc::sketch::Sketch;
use crate::mvc::status::Status;
use crate::mvc::truth::TruthFile;
use crate::peer::listen;
use crate::plc::controller::{Controller, Setup};
use crate::speed::Speed;

/// The most clients to wait for: `[spi] clients_max` is at most as great.
const WAIT_MAX: i64 = 1000;

#[derive(Debug, Args)]
pub(crate) struct Mvc {
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    /// Listen on this address
    #[arg(long, default_value = "127.0.0.1:29500", value_name = "ADDR:PORT")]
    pub(crate) listen: String,
    /// Run this many times faster than real time, or `max` for as fast as the clients read
    #[arg(long, default_value = "1", value_name = "X|max", allow_negative_numbers = true)]
    pub(crate) speed: Speed,
    /// Let the vehicle's clock stand until this many clients are connected [default: 0; with --speed max: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=WAIT_MAX))]
    pub(crate) wait: Option<u32>,
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
    /// Write where the vehicle truly is to this file while it runs: position, depth, altitude, attitude and speeds, a
    /// line for each second of the vehicle's time
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) truth: Option<PathBuf>,
    /// Draw a map of the run into this file at the end: seabed, plan, true track, inserts
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) map: Option<PathBuf>,
    /// Open the map when it is drawn
    #[arg(long, requires = "map")]
    pub(crate) open: bool,
    /// Also serve the mock payload controller with its sonars, for 7k clients: on this vehicle, in this world, by this
    /// clock [default address: 127.0.0.1:7000]
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:7000")]
    pub(crate) with_plc: Option<String>,
    /// Keep the payload controller's files in this folder: its logs, its run list, its settings. The disk of the folder
    /// takes the place of [plc.disk] [default: files are not kept]
    #[arg(long, value_name = "DIR", requires = "with_plc")]
    pub(crate) plc_folder: Option<PathBuf>,
    /// End after this many seconds of the vehicle's time
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
}

impl Mvc {
    /// How many clients the vehicle's clock waits for.
    fn wait(&self) -> u32 {
        self.wait.unwrap_or(u32::from(self.speed == Speed::Max))
    }
}

/// The arguments of all commands that fly the mock vehicle in real time.
#[derive(Debug, Args)]
pub(crate) struct VehicleArguments {
    /// What the vehicle's side of the interface is like, whatever world.toml says [default: as in world.toml]
    #[arg(long)]
    pub(crate) profile: Option<Profile>,
    /// When the payload has control, instead of [mission] control in world.toml
    #[arg(long)]
    pub(crate) control: Option<Control>,
    /// Inject the faults of vehicle and links in this file, instead of those in world.toml
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Follow the rules in this file, such as: 3 s after the first BPRMB take control
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) script: Option<PathBuf>,
    /// Seed for the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
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
        match self.control {
            Some(Control::Plan) => scenario.world.mission.control = backseat_mvc::ControlWindow::Plan,
            Some(Control::Mission) => scenario.world.mission.control = backseat_mvc::ControlWindow::Mission,
            None => {}
        }
        let script = self.script.as_deref().map(read_script).transpose()?;
        let mut vehicle = scenario
            .vehicle(self.seed)
            .with_context(|| format!("{}", scenario.path.display()))?;
        if let Some(script) = script {
            let path = self.script.as_deref().unwrap_or(std::path::Path::new(""));
            vehicle
                .set_script(script)
                .with_context(|| format!("{}", path.display()))?;
        }
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Control {
    /// While the plan allows it: `dynamic = true` of its elements
    Plan,
    /// From the start of the mission to its end
    Mission,
}

pub(crate) fn mvc(arguments: &Mvc) -> Result<bool> {
    let mut scenario = Scenario::open(&arguments.world.world)?;
    if !arguments.iprole.is_empty() {
        scenario.world.spi.roles.clone_from(&arguments.iprole);
    }
    let (wait, most) = (arguments.wait(), scenario.world.spi.clients_max);
    if wait > most {
        bail!(
            "--wait {wait}: {} lets only {most} clients connect: raise [spi] clients_max",
            scenario.path.display()
        );
    }
    let (vehicle, faults) = arguments.vehicle.vehicle(&mut scenario)?;
    draws::tell(&vehicle, &scenario.world.interpretation, arguments.vehicle.seed);
    let log = match &arguments.log {
        Some(path) => Some(Log::create(path)?),
        None => None,
    };
    if let Some(path) = &arguments.map {
        crate::map::begin(path)?;
    }
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
    let results = Results::of(arguments, clock, &vehicle)?;
    let service = Service {
        listener,
        vehicle,
        faults,
        controller,
        clock,
        speed: arguments.speed,
        wait: usize::try_from(arguments.wait()).unwrap_or(usize::MAX),
        end: arguments
            .duration
            .map(|seconds| Timestamp::ZERO + Duration::from_secs_f64(seconds)),
        log,
        status: Status::new(),
        spectators: vec![Box::new(results.clone())],
        operator: Lines::of_stdin(),
    };
    let (vehicle, clients) = service.serve(ended).await?;
    results.finish(arguments, scenario, clients, &vehicle)
}

/// What a run leaves besides its log.
#[derive(Clone)]
struct Results {
    truth: Option<Rc<RefCell<TruthFile>>>,
    sketch: Option<Rc<RefCell<Sketch>>>,
}

impl Results {
    fn of(arguments: &Mvc, clock: Clock, vehicle: &backseat_mvc::Mvc) -> Result<Self> {
        let truth = match &arguments.truth {
            Some(path) => Some(Rc::new(RefCell::new(TruthFile::create(path, clock, vehicle)?))),
            None => None,
        };
        Ok(Self {
            truth,
            sketch: arguments.map.as_ref().map(|_| Rc::default()),
        })
    }

    fn finish(self, arguments: &Mvc, scenario: &Scenario, clients: u32, vehicle: &backseat_mvc::Mvc) -> Result<()> {
        if let (Some(path), Some(sketch)) = (&arguments.map, &self.sketch) {
            let picture = sketch
                .borrow()
                .draw(&scenario.name(), arguments.vehicle.seed, clients, vehicle);
            crate::map::write(path, &picture)?;
            info!("map: {}", path.display());
            if arguments.open {
                open(path);
            }
        }
        match self.truth {
            Some(truth) => truth.borrow_mut().finish(),
            None => Ok(()),
        }
    }
}

impl Spectator for Results {
    fn step(&mut self, vehicle: &backseat_mvc::Mvc) {
        if let Some(truth) = &self.truth {
            truth.borrow_mut().step(vehicle);
        }
        if let Some(sketch) = &self.sketch {
            sketch.borrow_mut().step(vehicle);
        }
    }

    fn received(&mut self, line: &[u8]) {
        if let Some(sketch) = &self.sketch {
            sketch.borrow_mut().received(line);
        }
    }

    fn event(&mut self, event: &MvcEvent) {
        if let Some(sketch) = &self.sketch {
            sketch.borrow_mut().event(&event.kind);
        }
    }
}

/// A duration on the command line.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=1e9).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, from 0.001 to 1e9".to_owned()),
    }
}

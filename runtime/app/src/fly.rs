//! `backseat fly`: `mvc` and `run --arm` in one process, over TCP, on one clock that may go faster than life.

mod status;
mod watch;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use backseat_core::Start;
use backseat_mission::Mission;
use backseat_mvc::{Mvc, Status as MissionStatus};
use backseat_plugin_loader::load_plugins;
use backseat_recorder::read;
use backseat_scenario::Scenario;
use backseat_sim::{Report, judge_log, survey_map};
use backseat_units::Timestamp;
use clap::Args;
use tokio::sync::oneshot;
use tracing::warn;

use crate::arguments::MissionArguments;
use crate::cache::host;
use crate::clock::Clock;
use crate::external::Ports;
use crate::fly::status::Screen;
use crate::fly::watch::{Flight, Watch};
use crate::map::open;
use crate::mvc::operator::Lines;
use crate::mvc::server::Service;
use crate::mvc::status::Status;
use crate::mvc::{VehicleArguments, seconds};
use crate::operator::Signals;
use crate::output::say;
use crate::peer::listen;
use crate::plc::controller::{Controller, Setup};
use crate::run::shadow::Shadows;
use crate::run::{Dive, log_in, names_requests, open_log};
use crate::speed::Speed;
use crate::state::State;
use crate::surroundings::{beyond_limits, beyond_vehicle};

/// The fastest clock. More is of no use: the system's timers and the computation take about 1 ms for each step of the
/// vehicle, of which there are ten a second.
const SPEED_MAX: f64 = 100.0;
/// What a mission's end still brings is flown and logged for this long, as in `sim`.
const AFTERMATH: Duration = Duration::from_secs(10);
/// Both listen where nobody else does.
const ANY_PORT: &str = "127.0.0.1:0";

#[derive(Debug, Args)]
pub(crate) struct Fly {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Fly up to this many times faster than real time, at most 100
    #[arg(long, default_value = "1", value_name = "X", allow_negative_numbers = true, value_parser = times)]
    pub(crate) speed: f64,
    #[command(flatten)]
    pub(crate) vehicle: VehicleArguments,
    /// Write the log of the run to this file, or into this folder if the name does not end in .mcap
    #[arg(long, value_name = "DIR|FILE.mcap", default_value = "logs")]
    pub(crate) log: PathBuf,
    /// Draw a map of the flight into this file
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) map: Option<PathBuf>,
    /// Open the map when it is drawn
    #[arg(long, requires = "map")]
    pub(crate) open: bool,
    /// Keep the operator's hold and the SPI identifiers in this folder [default: one that is removed at the end]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// End after this many seconds of the mission, even if it is not over
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
    #[cfg(feature = "console")]
    #[command(flatten)]
    pub(crate) console: crate::console::ConsoleArguments,
}

/// A speed on the command line.
fn times(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(times) if (0.1..=SPEED_MAX).contains(&times) => Ok(times),
        _ => Err(format!(
            "expected a number from 0.1 to {SPEED_MAX:.0}; `backseat sim` is faster"
        )),
    }
}

/// A folder that is removed at the end.
struct Passing(PathBuf);

impl Drop for Passing {
    fn drop(&mut self) {
        // What is left of it does no harm.
        std::fs::remove_dir_all(&self.0).ok();
    }
}

pub(crate) fn fly(arguments: &Fly) -> Result<bool> {
    let mut mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut scenario = Scenario::load_with(&mission, &arguments.mission.world_sets())?;
    // The runtime's address is none of those to which the world gives roles.
    scenario.world.spi.roles.clear();
    let (vehicle, faults) = arguments.vehicle.vehicle(&mut scenario)?;
    let beyond = beyond_limits(&mission, &scenario, vehicle.world());
    for line in beyond_vehicle(&mission, &scenario).into_iter().chain(beyond) {
        warn!("{line}");
    }
    let clock = Clock::paced(arguments.speed, scenario.world.start.utc);
    let runtime = clock.runtime()?;
    let within = runtime.enter();
    let signals = Signals::new()?;
    if let Some(path) = &arguments.map {
        crate::map::begin(path)?;
    }
    #[cfg(feature = "console")]
    let console = arguments.console.open()?;
    let (ports, heard) = Ports::open(&mission.file.externals)?;
    let host = host(&arguments.mission)?;
    let loaded = load_plugins(&host, &mission, arguments.mission.plugins.as_deref())?;
    let passing = Passing(std::env::temp_dir().join(format!("backseat-fly-{}", std::process::id())));
    let state = State::open(arguments.state.as_deref().unwrap_or(&passing.0), None)?;
    let identifiers = match state.identifiers(None)? {
        None if names_requests(&mission) => {
            let first = state.identifiers(Some(1))?;
            first.iter().try_for_each(|first| state.begin_record(first))?;
            first
        }
        recorded => recorded,
    };
    let log = log_path(&arguments.log, &mission);
    let flight = clock.block_on(&runtime, async {
        // The mission begins now, whatever was slow before.
        let clock = clock.restarted();
        let controller = match &mut mission.file.sonar {
            Some(sonar) => {
                let setup = Setup {
                    address: ANY_PORT,
                    option: "[sonar]",
                    folder: None,
                    seed: arguments.vehicle.seed,
                    utc: scenario.world.start.utc,
                };
                let (controller, inbox) = Controller::start(&scenario, setup, clock).await?;
                let address = inbox.address()?;
                (sonar.host, sonar.port) = (address.ip().to_string(), address.port());
                Some((controller, inbox))
            }
            None => None,
        };
        #[cfg(feature = "console")]
        let (listener, signals) = {
            let kind = backseat_console::Kind::Simulated;
            let attached = console.attach(kind, &mission, true, clock.utc_at_start(), &state)?;
            (attached.listener, signals.or_console(attached.asked))
        };
        #[cfg(not(feature = "console"))]
        let listener = None;
        let mut recorder = open_log(
            &log,
            &mission,
            Some((arguments.vehicle.seed, &scenario.text)),
            &loaded,
            &clock,
            listener,
        )?;
        let start = Start {
            utc: clock.utc_at_start(),
            identifiers,
            armed: true,
            held: state.held(),
            jitter: arguments.vehicle.seed,
        };
        if start.held {
            warn!(
                "the operator's hold is set ({}): nothing steers",
                state.hold_path().display()
            );
        }
        recorder.record(Timestamp::ZERO, |recorder| recorder.start(&start));
        let listener = listen(ANY_PORT, "--connect").await?;
        let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
        let dive = Dive {
            mission: &mission,
            start,
            clock,
            times: arguments.speed,
            address: listener.local_addr()?.to_string(),
            host,
            loaded,
            ports,
            state,
            recorder,
            swaps: None,
            shadows: Shadows::default(),
        };
        let (driver, inbox) = dive.begin()?;
        let flight = Arc::new(Flight::default());
        let mut screen = Screen::start(Arc::clone(&flight), clock, arguments.speed)?;
        let driver = driver.watched(Box::new(Watch::new(Arc::clone(&flight), names)));
        let (end, ends) = oneshot::channel();
        let (landed, has_landed) = oneshot::channel();
        let service = Service {
            listener,
            vehicle,
            faults,
            controller,
            clock,
            speed: Speed::Times(1.0),
            wait: 0,
            end: None,
            log: None,
            status: Status::quiet(),
            spectators: vec![Box::new(spectator(Arc::clone(&flight), end, arguments.duration))],
            operator: Lines::none(),
        };
        // The runtime ends first, so that the vehicle hears its last words.
        let driven = async {
            let driven = driver.drive(inbox, heard, signals.or_end(ends)).await;
            // The vehicle waits for this, and for nothing else.
            let _gone = landed.send(());
            driven
        };
        let served = service.serve(async { drop(has_landed.await) });
        let (driven, served) = tokio::join!(driven, served);
        screen.end();
        driven?;
        Ok::<_, anyhow::Error>((served?, flight, clock.elapsed(), screen.real()))
    });
    drop(within);
    let ((vehicle, _), flight, elapsed, real) = flight?;
    let outcome = match vehicle.mission_status() {
        MissionStatus::Completed => "completed",
        MissionStatus::Aborted
        | MissionStatus::Stopped
        | MissionStatus::InvalidDiveFile
        | MissionStatus::InvalidWrapupFile => "aborted",
        MissionStatus::Offline
        | MissionStatus::Waiting
        | MissionStatus::Ready
        | MissionStatus::Running
        | MissionStatus::WrappingUp
        | MissionStatus::Aborting => "unfinished",
    };
    let mut report = Report {
        mission: mission.name.clone(),
        seed: arguments.vehicle.seed,
        outcome,
        sim_seconds: elapsed.as_secs_f64(),
        wall_seconds: real.as_secs_f64(),
        requests: flight.requests(),
        ..Report::default()
    };
    report.violations = judge_log(&read(&log)?)?.broken;
    print_report(&report, &log)?;
    if let Some(path) = &arguments.map {
        let picture = survey_map(&mission, &scenario, &report, &flight.trace(), &vehicle);
        crate::map::write(path, &picture)?;
        say!("  map: {}", path.display());
        if arguments.open {
            open(path);
        }
    }
    // A thread may still wait for a name or a disk, and nobody waits for it.
    runtime.shutdown_background();
    Ok(report.violations.is_empty())
}

fn log_path(path: &Path, mission: &Mission) -> PathBuf {
    if path.extension().is_some_and(|extension| extension == "mcap") {
        path.to_path_buf()
    } else {
        log_in(path, mission)
    }
}

/// Sees the vehicle, and ends the flight some time after its mission, or when its time is over.
fn spectator(flight: Arc<Flight>, end: oneshot::Sender<()>, duration: Option<f64>) -> impl FnMut(&Mvc) {
    let mut end = Some(end);
    let mut ends_at = duration.map(|seconds| Timestamp::ZERO + Duration::from_secs_f64(seconds));
    let mut over = false;
    move |vehicle| {
        let truth = vehicle.truth();
        if vehicle.mission_over() && !std::mem::replace(&mut over, true) {
            let aftermath = truth.time + AFTERMATH;
            ends_at = Some(ends_at.map_or(aftermath, |at| at.min(aftermath)));
        }
        if ends_at.is_some_and(|at| truth.time >= at)
            && let Some(end) = end.take()
        {
            // The runtime may have ended by itself.
            let _gone = end.send(());
        }
        flight.seen(vehicle, &truth);
    }
}

fn print_report(report: &Report, log: &Path) -> Result<()> {
    let requests = &report.requests;
    say!(
        "{}, seed {}: {} after {:.1} min",
        report.mission,
        report.seed,
        report.outcome,
        report.sim_seconds / 60.0
    );
    say!(
        "  {:.1} x real time ({:.0} s)",
        report.sim_seconds / report.wall_seconds.max(1e-9),
        report.wall_seconds
    );
    say!(
        "  requests: {} proposed, {} rejected, {} sent, {} accepted, {} failed",
        requests.proposed,
        requests.rejected,
        requests.sent,
        requests.accepted,
        requests.failed
    );
    match report.violations.len() {
        0 => say!("  no violation"),
        count => say!("  {count} violations:"),
    }
    for violation in &report.violations {
        say!("    {violation}");
    }
    say!("  log: {}", log.display());
    Ok(())
}

//! The mock payload controller as a TCP server, for our own runtime and for any other 7k client.

pub(crate) mod controller;
pub(crate) mod disk;

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use backseat_scenario::Scenario;
use backseat_units::Timestamp;
use clap::Args;
use tracing::info;

use crate::arguments::{WorldArguments, seed};
use crate::clock::Clock;
use crate::events::Events;
use crate::mvc::log::Log;
use crate::mvc::seconds;
use crate::plc::controller::{Controller, Setup};

/// How often the log is flushed: how much of it a killed process can lose.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

#[derive(Debug, Args)]
pub(crate) struct Plc {
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    /// Listen on this address
    #[arg(long, default_value = "127.0.0.1:7000", value_name = "ADDR:PORT")]
    pub(crate) listen: String,
    /// Keep the controller's files in this folder: its logs, and for the next start what clients saved: the run list
    /// (command 6) and auto start (command 22). The disk of the folder takes the place of [plc.disk] [default: files are
    /// not kept]
    #[arg(long, value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
    /// Seed for the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Write every event to this file, with the seconds since the start
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
    /// End after this many seconds
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
}

pub(crate) fn plc(arguments: &Plc) -> Result<bool> {
    let scenario = Scenario::open(&arguments.world.world)?;
    let log = match &arguments.log {
        Some(path) => Some(Log::create(path)?),
        None => None,
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(serve(arguments, &scenario, log))?;
    Ok(true)
}

/// Prints what happens, and logs it.
struct Told {
    events: Events,
    log: Option<Log>,
    flush_at: Duration,
}

impl Told {
    fn tell(&mut self, real: Duration, controller: &mut Controller) {
        while let Some((at, text)) = controller.poll_line() {
            let line = format!("{:.3} s: {text}", at.as_secs_f64());
            self.events.show(real, &line, |line| info!("{line}"));
            if let Some(log) = &mut self.log {
                log.event(at, &text);
            }
        }
        if real >= self.flush_at {
            self.flush_at = real + FLUSH_EVERY;
            if let Some(log) = &mut self.log {
                log.flush();
            }
        }
    }
}

/// Serves until a signal arrives, a client shuts the controller down, or the given duration is over.
async fn serve(arguments: &Plc, scenario: &Scenario, log: Option<Log>) -> Result<()> {
    let clock = Clock::start();
    let setup = Setup {
        address: &arguments.listen,
        option: "--listen",
        folder: arguments.folder.as_deref(),
        seed: arguments.seed,
        utc: clock.utc_at_start(),
    };
    let (mut controller, mut inbox) = Controller::start(scenario, setup, clock).await?;
    let mut told = Told {
        events: Events::default(),
        log,
        flush_at: Duration::ZERO,
    };
    let end = arguments
        .duration
        .map(|seconds| Timestamp::ZERO + Duration::from_secs_f64(seconds));
    let mut terminate = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate())?;
    let mut interrupt = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::interrupt())?;
    let mut reported = None;
    controller.truth(clock.now(), scenario.reported_pose(None));
    while !controller.is_shut_down() && end.is_none_or(|end| clock.now() < end) {
        controller.advance(clock.now());
        if controller.reported() != reported {
            reported = controller.reported();
            controller.truth(clock.now(), scenario.reported_pose(reported.as_ref()));
        }
        told.tell(clock.elapsed(), &mut controller);
        let soon = clock.now() + Duration::from_millis(100);
        let due = controller.next().map_or(soon, |due| due.min(soon));
        tokio::select! {
            biased;
            _ = interrupt.recv() => break,
            _ = terminate.recv() => break,
            message = inbox.next() => controller.take(clock.now(), message),
            () = tokio::time::sleep_until(clock.instant(due)) => {}
        }
    }
    let ended = controller.end(clock.now(), &mut inbox).await;
    told.tell(clock.elapsed(), &mut controller);
    info!(
        "{:.1} s; {} clients served",
        clock.elapsed().as_secs_f64(),
        controller.served()
    );
    let logged = told.log.map_or(Ok(()), Log::finish);
    ended.and(logged)
}

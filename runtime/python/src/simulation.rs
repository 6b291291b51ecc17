//! Flies a mission as `backseat sim` does, with the same report.

use std::path::Path;
use std::time::Instant;

use backseat_campaign::DrawnFaults;
use backseat_mission::{Layers, Mission};
use backseat_plugin_host::{Cache, Host};
use backseat_plugin_loader::Components;
use backseat_recorder::{Header, Rate, Recorder, Sources};
use backseat_scenario::{Scenario, read_faults};
use backseat_sim::{Report, Simulation};

use crate::error::Error;

/// How many events pass before the caller is asked whether to go on. Some thousand come each millisecond.
const EVENTS: u32 = 20_000;

/// How the keys of `world.toml` begin.
const WORLD: &str = "world.";

/// What to fly.
#[derive(Clone, Debug)]
pub struct Flight<'a> {
    /// The mission's folder.
    pub mission: &'a Path,
    /// Draws the world, the noise and what the specification leaves open.
    pub seed: u64,
    /// Keys of `mission.toml`, each as `limits.speed_max_mps=1.8`, and of `world.toml`, as `world.current.speed_mps=0.3`.
    /// They override the files and the environment.
    pub set: Vec<String>,
    /// A file of faults in place of those of `world.toml`.
    pub faults: Option<&'a Path>,
    /// Faults that the seed draws, as `3..9@30..800`, in place of those of `world.toml`.
    pub draw_faults: Option<&'a str>,
    /// The folder in which plugins are looked for first.
    pub plugins: Option<&'a Path>,
    /// Where to write the log.
    pub log: Option<&'a Path>,
}

/// Flies a mission to its end. `is_interrupted` is asked several times a second.
///
/// # Errors
///
/// Every [`Error`] except [`Error::Log`] and [`Error::Spi`]. A log that was begun stays, as that of a killed run.
#[expect(
    clippy::disallowed_methods,
    reason = "the caller's clock measures how long a run takes, and nothing depends on it"
)]
pub fn simulate(flight: &Flight<'_>, mut is_interrupted: impl FnMut() -> bool) -> Result<Report, Error> {
    let (of_world, of_mission) = flight
        .set
        .iter()
        .cloned()
        .partition(|set: &String| set.starts_with(WORLD));
    let layers = Layers {
        set: of_mission,
        environment: true,
    };
    let mission = Mission::load(flight.mission, &layers)?;
    let scenario = Scenario::load_with(&mission, &of_world)?;
    let faults = flight.faults.map(read_faults).transpose()?;
    let drawn = flight.draw_faults.map(str::parse::<DrawnFaults>).transpose();
    let mut drawn = drawn.map_err(Error::Faults)?.map(|faults| faults.draw(flight.seed));
    let loading = Instant::now();
    // What is wrong with the cache is no error, and compiling takes its place.
    let host = Host::new()?.with_cache(Cache::of_user(|_| {}));
    let components = Components::load(&host, &mission, flight.plugins)?;
    let loaded = components.start(&mission)?;
    let load_seconds = loading.elapsed().as_secs_f64();
    let recorder = match flight.log {
        Some(path) => Some(Recorder::create(
            path,
            &Header {
                utc_at_start: scenario.world.start.utc,
                rate: Rate::Simulation,
                mission: &mission.name,
                seed: Some(flight.seed),
                resolved_mission: &mission.resolved,
                fence: &mission.fence_text,
                origin: mission.envelope.fence().frame().origin(),
                world: Some(&scenario.text),
                components: &loaded.components,
                version: env!("CARGO_PKG_VERSION"),
                sources: Sources {
                    plan: mission.plan.as_ref().map(|plan| plan.text.as_str()),
                    fence: mission.other_fence(),
                    plugins: &loaded.setups,
                },
            },
        )?),
        None => None,
    };
    let flying = Instant::now();
    let mut simulation = Simulation::new(&mission, &scenario, flight.seed, loaded, recorder)?;
    if let Some(faults) = faults.or_else(|| drawn.as_ref().map(|drawn| drawn.plan().clone())) {
        simulation.set_faults(faults);
    }
    let mut events = 0;
    let mut advance = || match &mut drawn {
        Some(drawn) => drawn.advance(&mut simulation, || -> Result<_, Error> {
            Ok(components.start(&mission)?)
        }),
        None => Ok(simulation.advance()?),
    };
    while advance()? {
        events += 1;
        if events == EVENTS {
            events = 0;
            if is_interrupted() {
                return Err(Error::Interrupted);
            }
        }
    }
    let now = simulation.now();
    let (mut report, ..) = simulation.finish()?;
    report.faults += drawn.map_or(0, |drawn| drawn.begun(now));
    report.wall_seconds = flying.elapsed().as_secs_f64();
    report.load_seconds = load_seconds;
    Ok(report)
}

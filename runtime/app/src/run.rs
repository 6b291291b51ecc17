//! The driver at sea: core on a real clock, a TCP link, and plugins on threads of their own.

mod alone;
pub(crate) mod driver;
mod notes;
pub(crate) mod shadow;
pub(crate) mod swaps;

use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, bail};
use backseat_core::{Core, Grant, Start};
use backseat_lock::LOCK;
use backseat_mission::Mission;
use backseat_plugin_host::{Host, Origin};
use backseat_plugin_loader::{Loaded, load_plugins};
use backseat_recorder::{Header, Listener, Rate};
use backseat_units::{Timestamp, Utc};
use clap::Args;
use tokio::sync::mpsc::unbounded_channel;
use tracing::{info, warn};

use crate::arguments::MissionArguments;
use crate::cache::host;
use crate::check::machine::{implausible, is_plausible};
use crate::clock::Clock;
use crate::external::Ports;
use crate::helm::Helm;
use crate::keeper::Keeper;
use crate::lock::{Locked, read_components};
use crate::log::sources;
use crate::log_parts::{Current, Parts, Split, split};
use crate::log_room::{LogRoom, size};
use crate::operator::Signals;
use crate::owner::not_made;
use crate::plugins::Crew;
use crate::recording::Recording;
use crate::run::alone::Alone;
use crate::run::driver::{Around, Driver, Inbox};
use crate::run::shadow::Shadows;
use crate::run::swaps::Swaps;
use crate::sonar::Sonars;
use crate::state::State;
use crate::swap::named_file;

#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Connect to the vehicle at this address [default: vehicle.address of mission.toml]
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) connect: Option<String>,
    /// Steer the vehicle; without this, everything runs but no request that steers is sent
    #[arg(long)]
    pub(crate) arm: bool,
    /// Start only if nothing has changed since somebody signed the mission with the secret key of this pair (`check --sign`)
    #[arg(long, value_name = "NAME.pub")]
    pub(crate) locked: Option<PathBuf>,
    /// Write logs into this folder
    #[arg(long, value_name = "DIR", default_value = "logs")]
    pub(crate) log: PathBuf,
    /// Remove the oldest logs of this mission in that folder when all of them together are larger, such as 20GB [default:
    /// remove nothing]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub(crate) log_quota: Option<u64>,
    /// Go on in another file after this time or size, such as 1h or 500MB, or whichever comes first of several; `log join`
    /// makes one log of all [default: one file]
    #[arg(long, value_name = "TIME|SIZE", value_parser = split)]
    pub(crate) log_split: Vec<Split>,
    /// Keep SPI identifiers and the operator's hold in this folder [default: a folder of the vehicle's name in the
    /// user's state folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Start a new record of SPI identifiers at N, a number that no payload has used in this mission of the vehicle
    // 0 means none on the wire (SPI 6.21); the upper bound leaves room for every request of a mission.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=2_000_000_000))]
    pub(crate) first_identifier: Option<u32>,
    /// Step the component in FILE beside the plugin NAME, on the same inputs; what it asks for is judged and logged, and
    /// never sent
    #[arg(long = "shadow", value_name = "NAME=FILE", value_parser = named_file)]
    pub(crate) shadows: Vec<(String, PathBuf)>,
    #[cfg(feature = "console")]
    #[command(flatten)]
    pub(crate) console: crate::console::ConsoleArguments,
}

/// Grants for requests that the vehicle knows by an identifier.
const NAMED: [Grant; 3] = [Grant::Insert, Grant::Surface, Grant::Acoustic];

pub(crate) fn run(arguments: &Run) -> Result<bool> {
    // This comes before anything slow, so that the operator's signals count from the first moment. The runtime is never
    // dropped, not even in a panic: dropping would wait for a host name that is being resolved, which can take for
    // ever.
    let runtime = ManuallyDrop::new(tokio::runtime::Builder::new_current_thread().enable_all().build()?);
    let signals = {
        let _within = runtime.enter();
        Signals::new()?
    };
    if let Some(set) = arguments.mission.world_sets().first() {
        bail!("--set {set}: only simulations read world.toml: leave it out");
    }
    let mission = Arc::new(Mission::load(&arguments.mission.mission, &arguments.mission.layers())?);
    let address = match &arguments.connect {
        Some(address) => host_and_port(address, "--connect")?,
        None => host_and_port(&mission.file.vehicle.address, "mission.toml: vehicle.address")?,
    };
    #[cfg(feature = "console")]
    let console = arguments.console.open()?;
    let (ports, heard) = {
        let _within = runtime.enter();
        Ports::open(&mission.file.externals)?
    };
    let plugins = arguments.mission.plugins.as_deref();
    let locked = arguments
        .locked
        .as_ref()
        .map(|key| Locked::read(&mission, key))
        .transpose()?;
    if let Some(locked) = &locked {
        // Nothing of a component runs before this.
        let compared = locked.compare(&mission, &read_components(&mission, plugins)?, plugins);
        let settings = arguments.mission.layers().names().join(" with ");
        compared.map_err(|error| match settings.as_str() {
            "" => error,
            settings => error.context(format!("{settings} changes the mission: leave it out")),
        })?;
    } else if mission.folder.join(LOCK).exists() {
        let text = format!("{LOCK} is there: without --locked NAME.pub nothing is compared with it");
        if arguments.arm {
            warn!("{text}");
        } else {
            info!("{text}");
        }
    }
    let host = host(&arguments.mission)?;
    // The cache is read and written before the loop begins, and a disk that hangs is waited for only briefly: a runtime
    // that starts again in the middle of a dive steers again sooner.
    let loaded = load_plugins(&host, &mission, plugins)?;
    // Once more, of the bytes that were loaded.
    let signed = locked
        .as_ref()
        .map(|locked| locked.compare(&mission, &loaded.components, plugins))
        .transpose()?;
    let allowed = locked.map(Locked::allowed);
    let shadows = Shadows::start(&arguments.shadows, &host, &mission, allowed.as_ref())?;
    let folder = State::folder_of(arguments.state.as_deref(), &mission)?;
    let state = State::open(&folder, mission.file.vehicle.name.as_deref())?;
    let _alone = arguments.arm.then(|| Alone::claim(&address)).transpose()?;
    let identifiers = state.identifiers(arguments.first_identifier)?;
    let clock = Clock::start();
    look_at_clock(clock.utc_at_start(), mission.envelope.fence().changes(), arguments.arm)?;
    let log = log_in(&arguments.log, &mission);
    #[cfg(feature = "console")]
    let (listener, signals) = {
        let kind = backseat_console::Kind::Live;
        let attached = console.attach(kind, &mission, arguments.arm, clock.utc_at_start(), &state)?;
        (attached.listener, signals.or_console(attached.asked))
    };
    #[cfg(not(feature = "console"))]
    let listener = None;
    let current = Current::new(&log);
    let parts = Parts::new(
        arguments.log_split.clone(),
        current.clone(),
        &mission.name,
        clock.utc_at_start(),
    );
    let mut recorder = open_log(&log, &mission, None, &loaded, &clock, listener)?.in_parts(parts);
    if state.is_new() {
        info!(
            "state: {}, a new folder: no hold and no identifiers of an earlier run are known",
            folder.display()
        );
    } else {
        info!("state: {}", folder.display());
    }
    let cached = loaded.origins.iter().filter(|origin| **origin == Origin::Cache).count();
    LogRoom::new(current, &mission.name, arguments.log_quota).watch()?;
    info!(
        "plugins: {cached} from the cache, {} compiled",
        loaded.origins.len() - cached
    );
    if arguments.first_identifier.is_some()
        && let Some(first) = &identifiers
    {
        // The last thing that can fail: whoever mends what failed before starts with the same words again.
        state.begin_record(first)?;
    }
    if identifiers.is_none() && names_requests(&mission) {
        warn!(
            "no record of SPI identifiers at {}: tracklines, circles, GPS hits and acoustic packets are off; begin a \
             record with --first-identifier N",
            state.identifiers_path().display()
        );
    }
    let start = Start {
        utc: clock.utc_at_start(),
        identifiers,
        armed: arguments.arm,
        held: state.held(),
        jitter: u64::from(std::process::id()),
    };
    if start.held {
        warn!(
            "the operator's hold is set ({}): nothing that steers will be sent",
            state.hold_path().display()
        );
    }
    if start.armed {
        info!("armed: plugins may steer the vehicle at {address}");
    } else {
        info!("not armed: nothing that steers will be sent; to arm, use --arm");
    }
    if mission.plan.is_some() {
        info!(
            "the vehicle's plan will be compared with [plan] in its elements and places; a vehicle reports no depths and \
             no speeds, so those are not compared"
        );
    }
    recorder.record(Timestamp::ZERO, |recorder| recorder.start(&start));
    if start.held {
        let text = format!("hold: it was set before the start ({})", state.hold_path().display());
        recorder.record(Timestamp::ZERO, |recorder| recorder.asked(Timestamp::ZERO, &text));
    }
    if let Some(signed) = signed {
        info!("locked: {signed}");
        let text = format!("locked: {signed}");
        recorder.record(Timestamp::ZERO, |recorder| recorder.asked(Timestamp::ZERO, &text));
    }
    let swaps = Swaps::start(&folder, host.clone(), Arc::clone(&mission), &loaded.setups, allowed)?;
    let dive = Dive {
        mission: &mission,
        start,
        clock,
        times: 1.0,
        address,
        host,
        loaded,
        ports,
        state,
        recorder,
        swaps: Some(swaps),
        shadows,
    };
    let (driver, inbox) = dive.begin()?;
    runtime.block_on(driver.drive(inbox, heard, signals))?;
    Ok(true)
}

/// What the loop around core is made of.
pub(crate) struct Dive<'a> {
    pub(crate) mission: &'a Mission,
    pub(crate) start: Start,
    pub(crate) clock: Clock,
    /// How much faster than the operator's own time the clock goes.
    pub(crate) times: f64,
    /// The vehicle's.
    pub(crate) address: String,
    pub(crate) host: Host,
    pub(crate) loaded: Loaded,
    pub(crate) ports: Ports,
    pub(crate) state: State,
    pub(crate) recorder: Recording,
    pub(crate) swaps: Option<Swaps>,
    pub(crate) shadows: Shadows,
}

impl Dive<'_> {
    /// Starts the threads beside the loop.
    ///
    /// # Errors
    /// If one of them cannot start.
    pub(crate) fn begin(self) -> Result<(Driver, Inbox)> {
        let (start, clock, loaded) = (self.start, self.clock, self.loaded);
        let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
        let settings = self.mission.file.session.clone();
        let core = Core::new(settings, self.mission.envelope.clone(), loaded.setups, start);
        let (sender, answers) = unbounded_channel();
        let (keeps, kept) = unbounded_channel();
        let around = Around {
            crew: Crew::new(self.host, loaded.plugins, clock, sender)?,
            ports: self.ports,
            helm: Helm::new(start.armed, self.state.hold_path(), self.times),
            keeper: Keeper::start(self.state, start.held, keeps)?,
            recorder: self.recorder,
            sonars: Sonars::start(self.mission, clock)?,
            swaps: self.swaps,
            shadows: self.shadows,
        };
        let driver = Driver::new(core, clock, self.address, around, names);
        Ok((driver, Inbox { answers, kept }))
    }
}

/// Looks at a clock that cannot be right. Zones of the fence that are valid for a time depend on it, if it has any.
fn look_at_clock(now: Utc, zones_change: bool, armed: bool) -> Result<()> {
    if is_plausible(now) {
        return Ok(());
    }
    let wrong = implausible(now);
    if armed && zones_change {
        bail!(
            "this computer's clock: {wrong}; zones of the fence are valid for a time, so a run that is armed needs it"
        );
    }
    warn!("this computer's clock: {wrong}; the log has that time");
    Ok(())
}

/// Whether any plugin may make requests that need an identifier.
pub(crate) fn names_requests(mission: &Mission) -> bool {
    let mut grants = mission.file.plugins.iter().flat_map(|plugin| &plugin.grants);
    grants.any(|grant| NAMED.contains(grant))
}

/// Checks the form of an address. A host name that cannot be resolved yet is accepted, because it may be later.
pub(crate) fn host_and_port(address: &str, place: &str) -> Result<String> {
    match address.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0) => {
            Ok(address.to_owned())
        }
        _ => bail!("{place}: invalid address {address:?}: expected HOST:PORT, such as 127.0.0.1:29500"),
    }
}

/// The log of a run that begins now, in a folder.
pub(crate) fn log_in(folder: &Path, mission: &Mission) -> PathBuf {
    let began = Clock::start().utc_at_start().as_unix_nanos() / 1_000_000;
    folder.join(format!("{}-{began}.mcap", mission.name))
}

/// Creates a log, and the folder in which it is. A simulated vehicle has a seed, and a world as TOML. A listener is told
/// everything that the log has.
///
/// # Errors
/// If one of them cannot be created.
pub(crate) fn open_log(
    path: &Path,
    mission: &Mission,
    simulated: Option<(u64, &str)>,
    loaded: &Loaded,
    clock: &Clock,
    listener: Option<Listener>,
) -> Result<Recording> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| not_made(folder, error))?;
    }
    info!("log: {}", path.display());
    Recording::create(
        path,
        &Header {
            utc_at_start: clock.utc_at_start(),
            rate: Rate::Deployed,
            mission: &mission.name,
            seed: simulated.map(|(seed, _)| seed),
            resolved_mission: &mission.resolved,
            fence: &mission.fence_text,
            origin: mission.envelope.fence().frame().origin(),
            world: simulated.map(|(_, world)| world),
            components: &loaded.components,
            version: env!("CARGO_PKG_VERSION"),
            sources: sources(mission, loaded),
        },
        listener,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impossible_date_arms_nothing_whose_fence_depends_on_it() {
        let lost_power = Utc::from_unix_nanos(27_000_000_000_000);
        let right = Utc::from_unix_nanos(1_780_000_000_000_000_000);
        for (zones_change, armed) in [(false, false), (false, true), (true, false), (true, true)] {
            assert!(look_at_clock(right, zones_change, armed).is_ok());
            let looked = look_at_clock(lost_power, zones_change, armed);
            assert_eq!(looked.is_err(), zones_change && armed);
            if let Err(error) = looked {
                let text = error.to_string();
                assert!(text.contains("the time is 1970-01-01T07:30:00"), "{text}");
            }
        }
    }
}

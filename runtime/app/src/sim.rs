use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_campaign::{DrawnFaults, Interference, ToldFault};
use backseat_mission::Mission;
use backseat_mvc::FaultPlan;
use backseat_plc::{FileFailure, PlcConfig};
use backseat_plugin_loader::{Components, LoadError, Loaded};
use backseat_recorder::{Header, Rate, Recorder, read};
use backseat_scenario::{Scenario, read_faults, read_script};
use backseat_sim::{Report, Simulation, survey_map};
use backseat_units::Timestamp;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use tracing::{Level, enabled, info, warn};

use crate::arguments::{MissionArguments, seed};
use crate::cache::host;
use crate::clock::{Clock, pause};
use crate::log::{plugin_lines, sources};
use crate::map::open;
use crate::output::say;
use crate::plc::disk::{Files, Folder, file_of};
use crate::sonar_settings::beyond_sonar;
use crate::speed::Speed;
use crate::surroundings::{beyond_limits, beyond_vehicle};
use crate::terminal::tell;

#[derive(Debug, Args)]
pub(crate) struct Sim {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Seed for the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Inject the faults in this file, instead of the [faults] of world.toml
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Let the seed draw the faults, in place of [faults] in world.toml and --faults. 3..9@30..800 draws 3 to 9 faults that
    /// come between 30 s and 800 s
    #[arg(long, value_name = "3..9@30..800", conflicts_with = "faults")]
    pub(crate) draw_faults: Option<DrawnFaults>,
    /// Follow the rules in this file, such as: 3 s after the first BPRMB take control
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) script: Option<PathBuf>,
    /// Write the log to this file
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) log: Option<PathBuf>,
    /// Draw a map of the run into this file
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) map: Option<PathBuf>,
    /// Open the map when it is drawn
    #[arg(long, requires = "map")]
    pub(crate) open: bool,
    /// Keep the files of the sonars' payload controller in this folder: its logs, and its run list. The folder must
    /// have no recordings yet
    #[arg(long, value_name = "DIR")]
    pub(crate) s7k: Option<PathBuf>,
    /// Run this many times faster than real time, or `max`
    #[arg(long, default_value = "max", value_name = "X|max")]
    pub(crate) speed: Speed,
    #[cfg(feature = "console")]
    #[command(flatten)]
    pub(crate) watch: crate::console::WatchArguments,
    /// Print what the plugins log on standard error, with its time; so does BACKSEAT_LOG=debug
    #[arg(long)]
    pub(crate) verbose: bool,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

/// A log that is read once and removed, however the run ends.
struct Passing(PathBuf);

impl Passing {
    fn new() -> Self {
        Self(std::env::temp_dir().join(format!("backseat-sim-{}.mcap", std::process::id())))
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        // It may not have been created yet.
        std::fs::remove_file(&self.0).ok();
    }
}

pub(crate) fn sim(arguments: &Sim) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let scenario = Scenario::load_with(&mission, &arguments.mission.world_sets())?;
    if arguments.s7k.is_some() {
        controller_of(&scenario)?;
    }
    #[cfg(feature = "console")]
    let (console, watched) = (arguments.watch.open()?, arguments.watch.watch.is_some());
    #[cfg(not(feature = "console"))]
    let watched = false;
    let faults = arguments.faults.as_deref().map(read_faults).transpose()?;
    if let (Some(path), Some(plan)) = (&arguments.faults, &faults)
        && plan.faults.is_empty()
    {
        warn!("{}: no fault in it: expected [[fault]] tables", path.display());
    }
    let script = arguments.script.as_deref().map(read_script).transpose()?;
    #[cfg(feature = "plugin")]
    for path in mission.components(arguments.mission.plugins.as_deref())? {
        if let Some(stale) = crate::plugin::stale_file(&path) {
            warn!("{stale}");
        }
    }
    let loading = Clock::start();
    let host = host(&arguments.mission)?;
    let components = Components::load(&host, &mission, arguments.mission.plugins.as_deref())?;
    let loaded = components.start(&mission)?;
    let load_seconds = loading.elapsed().as_secs_f64();

    // The plugins' lines are read from the log.
    let verbose = arguments.verbose || enabled!(Level::DEBUG);
    let passing = ((verbose || watched) && arguments.log.is_none()).then(Passing::new);
    #[cfg_attr(not(feature = "console"), expect(unused_mut, reason = "only the console listens"))]
    let mut recorder = match arguments.log.as_ref().or(passing.as_ref().map(|passing| &passing.0)) {
        Some(path) => Some(Recorder::create(
            path,
            &Header {
                utc_at_start: scenario.world.start.utc,
                rate: Rate::Simulation,
                mission: &mission.name,
                seed: Some(arguments.seed),
                resolved_mission: &mission.resolved,
                fence: &mission.fence_text,
                origin: mission.envelope.fence().frame().origin(),
                world: Some(&scenario.text),
                components: &loaded.components,
                version: env!("CARGO_PKG_VERSION"),
                sources: sources(&mission, &loaded),
            },
        )?),
        None => None,
    };
    let speed = match arguments.speed {
        Speed::Max => None,
        Speed::Times(times) => Some(times),
    };
    #[cfg(feature = "console")]
    let pace = backseat_console::Pace::new(speed);
    #[cfg(feature = "console")]
    if let (Some(recorder), Some(listener)) = (&mut recorder, console.show(&mission, scenario.world.start.utc, &pace)?)
    {
        recorder.listen(listener);
    }
    // The page calls everything above a limit as fast as can be, so a pace that nobody can change is not taken from it.
    let times = || {
        #[cfg(feature = "console")]
        if watched {
            return pace.times();
        }
        speed.unwrap_or(f64::INFINITY)
    };
    if let Some(path) = &arguments.map {
        crate::map::begin(path)?;
    }

    if let [first, ..] = &mission.file.externals[..] {
        let all = mission.file.externals.len();
        info!(
            "external sources are not simulated: nothing listens for {} and {} more",
            first.name,
            all - 1
        );
    }
    let mut beyond = beyond_vehicle(&mission, &scenario);
    let flying = Clock::start();
    let mut simulation = Simulation::new(&mission, &scenario, arguments.seed, loaded, recorder)?;
    beyond.extend(beyond_limits(&mission, &scenario, simulation.world()));
    beyond.extend(beyond_sonar(&mission, &scenario));
    for line in &beyond {
        warn!("{line}");
    }
    let drawn = arguments.draw_faults.map(|faults| faults.draw(arguments.seed));
    let faults = match faults.or_else(|| drawn.as_ref().map(|drawn| drawn.plan().clone())) {
        Some(plan) => {
            simulation.set_faults(plan.clone());
            plan
        }
        None => scenario.world.faults.plan()?,
    };
    if let (Some(path), Some(script)) = (&arguments.script, script) {
        simulation
            .set_script(script)
            .with_context(|| format!("{}", path.display()))?;
    }
    let failed_files = match &arguments.s7k {
        Some(folder) => keep_files(&mut simulation, &scenario, folder)?,
        None => FailedFiles::default(),
    };
    let mut flight = Flight {
        simulation,
        drawn,
        reload: Box::new(|| components.start(&mission)),
    };
    let progress = progress_bar(arguments.json);
    paced(&mut flight, &times, &progress, &flying)?;
    let now = flight.simulation.now();
    let (mut report, trace, mvc) = flight.simulation.finish()?;
    report.faults += flight.drawn.as_ref().map_or(0, |drawn| drawn.begun(now));
    report.wall_seconds = flying.elapsed().as_secs_f64();
    report.load_seconds = load_seconds;
    progress.finish_and_clear();
    if let Some(path) = arguments.log.as_ref().or(passing.as_ref().map(|passing| &passing.0))
        && verbose
    {
        for (at, text) in plugin_lines(&read(path)?) {
            tell(&format!("{:9.2} s  {text}", at.as_secs_f64()));
        }
    }

    if let Some(path) = &arguments.map {
        let picture = survey_map(&mission, &scenario, &report, &trace, &mvc);
        crate::map::write(path, &picture)?;
        if arguments.open {
            open(path);
        }
    }
    if arguments.json {
        say!("{}", serde_json::to_string(&report)?);
    } else {
        print_report(&report, &told_faults(&faults, flight.drawn.as_ref()), arguments)?;
    }
    let failed_files = failed_files.borrow();
    if let Some(first) = failed_files.first() {
        tell(&format!(
            "the recording is not whole: {} files could not be written, the first one {first}",
            failed_files.len()
        ));
    }
    if watched {
        tell("the console goes on showing the run; Ctrl-C ends it");
        drop(passing);
        loop {
            std::thread::park();
        }
    }
    // Nobody has to state as expected that every plugin can be started again to the end.
    Ok(report.passed() && report.plugin_quarantines.is_empty() && failed_files.is_empty())
}

/// What could not be written, one line each.
type FailedFiles = Rc<RefCell<Vec<String>>>;

/// The payload controller whose files are to be kept.
///
/// # Errors
///
/// If the mission has none.
fn controller_of(scenario: &Scenario) -> Result<&PlcConfig> {
    scenario.plc.as_ref().with_context(|| {
        format!(
            "--s7k: {} has no [plc], so no payload controller records anything: add [plc] to it",
            scenario.path.display()
        )
    })
}

/// Has the payload controller's files written into a folder.
///
/// # Errors
///
/// In one line, if the folder cannot be used or has recordings.
fn keep_files(simulation: &mut Simulation, scenario: &Scenario, folder: &Path) -> Result<FailedFiles> {
    let plc = controller_of(scenario)?;
    let opened = Folder::open(folder, &plc.logging.folder)?;
    // A simulation begins at the same time whenever it runs, so its files have the names of the run before.
    if let Some(other) = opened.logs()?.first() {
        bail!(
            "--s7k {}: the folder has recordings of another run ({}): give an empty folder",
            folder.display(),
            other.name
        );
    }
    let mut files = Files::new(opened);
    let failed = Rc::new(RefCell::new(Vec::new()));
    let lines = Rc::clone(&failed);
    simulation.set_sonar_files(Box::new(move |effect| {
        let file = file_of(&effect);
        files.carry_out(effect).map_err(|(error, path)| {
            let line = format!("{}: {error}", path.display());
            warn!("{line}");
            lines.borrow_mut().push(line);
            (file, FileFailure::from(&error))
        })
    }));
    Ok(failed)
}

/// A simulation, with what is done to the runtime while it flies.
struct Flight<'a> {
    simulation: Simulation,
    drawn: Option<Interference>,
    /// Starts the plugins of a new process.
    reload: Box<dyn Fn() -> Result<Loaded, LoadError> + 'a>,
}

impl Flight<'_> {
    fn advance(&mut self) -> Result<bool> {
        match &mut self.drawn {
            Some(drawn) => drawn.advance(&mut self.simulation, || -> Result<_> { Ok((self.reload)()?) }),
            None => Ok(self.simulation.advance()?),
        }
    }
}

/// How often a simulation that waits looks whether it shall go on.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Runs to the end, no faster than the multiple of real time that `pace` says each time: 0 stands, and infinity is as fast as
/// can be.
fn paced(flight: &mut Flight<'_>, pace: &dyn Fn() -> f64, progress: &ProgressBar, clock: &Clock) -> Result<()> {
    let mut next_show = Timestamp::ZERO;
    // The pace, and the times of both clocks since which it has been kept.
    let (mut times, mut since, mut began) = (pace(), Duration::ZERO, Timestamp::ZERO);
    loop {
        if times > 0.0 && !flight.advance()? {
            return Ok(());
        }
        let now = flight.simulation.now();
        // Waits for its time, unless the pace changes meanwhile.
        loop {
            let wished = pace();
            if wished != times {
                (times, since, began) = (wished, clock.elapsed(), now);
            }
            let ahead = if times > 0.0 {
                // A pace so slow that the time is out of range stands still.
                let due = Duration::try_from_secs_f64(now.since(began).as_secs_f64() / times);
                due.map_or(LOOK_EVERY, |due| (since + due).saturating_sub(clock.elapsed()))
            } else {
                LOOK_EVERY
            };
            if ahead <= Duration::from_millis(5) {
                break;
            }
            pause(ahead.min(LOOK_EVERY));
        }
        if now >= next_show {
            let every = times.clamp(1.0, 60.0);
            next_show = now + Duration::from_secs_f64(every);
            show(progress, &flight.simulation, clock);
        }
    }
}

pub(crate) fn progress_bar(quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar
}

fn show(progress: &ProgressBar, simulation: &Simulation, clock: &Clock) {
    let sim_s = simulation.now().as_secs_f64();
    let wall_s = clock.elapsed().as_secs_f64().max(1e-9);
    let truth = simulation.truth();
    progress.set_message(format!(
        "{:.0} min simulated, {:.0} x real time: depth {:.1} m over {:.1} m of water, {} requests sent",
        sim_s / 60.0,
        sim_s / wall_s,
        truth.depth_m,
        truth.water_depth_m,
        simulation.request_counts().sent,
    ));
    progress.tick();
}

fn print_report(report: &Report, faults: &[ToldFault], arguments: &Sim) -> Result<()> {
    let Report {
        mission,
        seed,
        outcome,
        sim_seconds,
        wall_seconds,
        load_seconds,
        requests,
        ..
    } = report;
    say!("{mission}, seed {seed}: {outcome} after {:.1} min", sim_seconds / 60.0);
    say!(
        "  {:.0} x real time ({wall_seconds:.2} s, and {load_seconds:.2} s to load plugins)",
        sim_seconds / wall_seconds.max(1e-9)
    );
    say!("  requests: {requests}");
    say!("  control: {}", report.control);
    print_faults(faults, *sim_seconds)?;
    for reason in &report.rejections {
        say!("    rejected {reason}");
    }
    for (plugin, count) in &report.plugin_failures {
        let times = if *count == 1 {
            "once"
        } else {
            &format!("{count} times, first")
        };
        match report.plugin_first_failures.get(plugin) {
            Some(first) => say!(
                "  plugin {plugin} failed {times} at {:.1} s: {}",
                first.at_s,
                first.text
            ),
            None => say!("  plugin {plugin} failed {times}"),
        }
        if let Some(at_s) = report.plugin_quarantines.get(plugin) {
            say!("  plugin {plugin} was quarantined at {at_s:.1} s: it failed too often");
        }
    }
    for measured in report.measured() {
        say!("  {measured}");
    }
    match report.violations.len() {
        0 => say!("  no violation"),
        count => say!("  {count} violations:"),
    }
    for violation in &report.violations {
        say!("    {violation}");
    }
    for unmet in &report.unmet {
        say!("  expectation not met: {unmet}");
    }
    say!("  digest {}", report.digest);
    if let Some(path) = &arguments.log {
        say!("  log: {}", path.display());
    }
    if let Some(path) = &arguments.map {
        say!("  map: {}", path.display());
    }
    Ok(())
}

/// The faults in the order of their times, at most so many of them.
fn print_faults(faults: &[ToldFault], sim_seconds: f64) -> Result<()> {
    const SHOWN: usize = 10;
    for fault in faults.iter().take(SHOWN) {
        let at_s = fault.at.as_secs_f64();
        let lasts = match fault.lasts.as_secs_f64() {
            0.0 => String::new(),
            seconds => format!(" for {seconds} s"),
        };
        let late = if at_s > sim_seconds {
            "; it never began, because the run ended before"
        } else {
            ""
        };
        say!("  fault at {at_s} s{lasts}: {}{late}", fault.what);
    }
    if faults.len() > SHOWN {
        say!("  and {} more faults", faults.len() - SHOWN);
    }
    Ok(())
}

/// All faults of a run by time, in words: those of the vehicle and the link, and those that are done to the runtime.
fn told_faults(plan: &FaultPlan, drawn: Option<&Interference>) -> Vec<ToldFault> {
    let of_plan = plan.faults.iter().map(|fault| ToldFault {
        at: fault.at,
        lasts: fault.lasts,
        what: fault.kind.to_string(),
    });
    let of_computer = drawn.map_or(&[][..], Interference::computer).iter().cloned();
    let mut all: Vec<_> = of_plan.chain(of_computer).collect();
    all.sort_by_key(|fault| fault.at);
    all
}

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use backseat_core::Operator;
use backseat_core::plugin::{PluginId, Version};
use backseat_mission::{Layers, Mission, PluginTable};
use backseat_mvc::{FaultKind, Status};
use backseat_oracle::State;
use backseat_plugin_host::{Cache, Host};
use backseat_plugin_loader::Components;
use backseat_recorder::{Header, Rate, Recorder, Sources};
use backseat_scenario::Scenario;
use backseat_sim::{Report, Simulation, Step};
use backseat_units::Timestamp;
use sha2::{Digest as _, Sha256};
use tempfile::TempDir;

use crate::excuse::none_is_left;
use crate::fault::{Fault, SWAPS};
use crate::phase::{CALM_S, CHANCE_S, HAND_BACK_S, LEAST_S, LINK_WITHIN, LONGEST_S, LOOK_EVERY, NONE_WITHIN};
use crate::plan::{Come, Plan, Planned, until_calm};

/// The components of every mission of the hunt.
const COMPONENTS: [&str; 2] = ["prober", "faulty"];

/// The means to fly plans: the compiled plugins, and a folder for a mission's files. Each thread has its own.
pub struct Range {
    components: Arc<Components>,
    folder: TempDir,
}

/// The result of a flight.
pub struct Flight {
    /// The plan with the times at which its faults began, without faults that did not begin.
    pub resolved: Plan,
    /// Each fault that began, with the state in which it began.
    pub met: Vec<(String, State)>,
    /// The run's own report.
    pub report: Report,
    /// Everything that was wrong.
    pub failures: Vec<Failure>,
    /// The monitor's messages on navigation, with their times.
    pub navigation: Vec<(Timestamp, String)>,
    /// The vehicle's true depth once a second, metres.
    pub depths_m: Vec<(Timestamp, f64)>,
}

/// Something that must not happen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The oracle's rule, or the condition that was not reached.
    pub rule: String,
    /// A description.
    pub text: String,
    /// The time, if it has one.
    pub at: Option<Timestamp>,
}

/// The actions that become due in a flight.
enum Act {
    Begin(Fault),
    /// A plugin recovers.
    Own(usize),
    /// For long enough, no plugin has been able to steer.
    NoneSteers,
    /// The liveness phase begins.
    Calm,
    /// The link must be up.
    LinkIsUp,
    /// The operator holds for good, so that the vehicle steers itself.
    HandBack,
    /// Check whether everything of ours has ended.
    Look,
    Release,
    DiskHasRoom,
}

/// A host for the plugins of a folder, with a cache beside that folder: it is not the user's.
///
/// # Errors
///
/// If this machine cannot run WebAssembly.
pub(crate) fn host(plugins: &Path) -> Result<Host> {
    let cache = Cache::new(plugins.with_file_name("plugin-cache"), |notice| eprintln!("{notice}"));
    Ok(Host::new()?.with_cache(Some(cache)))
}

impl Range {
    /// Compiles the plugins of a folder.
    ///
    /// # Errors
    ///
    /// With the component that is missing or that the host refuses.
    pub fn new(plugins: &Path) -> Result<Self> {
        let host = host(plugins)?;
        let mut components = Components::new();
        for name in COMPONENTS {
            let path = plugins.join(format!("{name}.wasm"));
            let bytes = fs::read(&path).with_context(|| {
                format!(
                    "{}: expected the component that `cargo xtask plugins` builds",
                    path.display()
                )
            })?;
            components.insert(&host, name, &bytes)?;
        }
        Self::with(Arc::new(components))
    }

    /// Another one with the same plugins.
    ///
    /// # Errors
    ///
    /// If there is no room for its files.
    pub fn another(&self) -> Result<Self> {
        Self::with(self.components.clone())
    }

    fn with(components: Arc<Components>) -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("hunt-").tempdir()?;
        Ok(Self { components, folder })
    }

    /// Flies a plan.
    ///
    /// # Errors
    ///
    /// If the plan's mission is invalid. Anything that goes wrong in flight, including a panic, is a [`Failure`].
    pub fn fly(&self, plan: &Plan) -> Result<Flight> {
        self.fly_with(plan, None)
    }

    /// Like [`Range::fly`], and writes the whole log to a file.
    ///
    /// # Errors
    ///
    /// As for [`Range::fly`], and if the file cannot be written.
    pub fn fly_logged(&self, plan: &Plan, log: &Path) -> Result<Flight> {
        self.fly_with(plan, Some(log))
    }

    fn fly_with(&self, plan: &Plan, log: Option<&Path>) -> Result<Flight> {
        let folder = self.folder.path();
        let files = &plan.scenario;
        fs::write(folder.join("mission.toml"), &files.mission)?;
        fs::write(folder.join("fence.geojson"), &files.fence)?;
        fs::write(folder.join("world.toml"), &files.world)?;
        let mission = Mission::load(folder, &Layers::default())?;
        let scenario = Scenario::load(&mission)?;
        let flown = catch_unwind(AssertUnwindSafe(|| {
            Flown::new(&self.components, &mission, &scenario, plan, log)?.fly()
        }));
        match flown {
            Ok(flight) => flight,
            Err(panic) => {
                let text = panic
                    .downcast_ref::<String>()
                    .cloned()
                    .or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()))
                    .unwrap_or_else(|| "a panic without a message".to_owned());
                Ok(Flight {
                    resolved: plan.clone(),
                    met: Vec::new(),
                    report: Report::default(),
                    failures: vec![Failure {
                        rule: "panic".to_owned(),
                        text,
                        at: None,
                    }],
                    navigation: Vec::new(),
                    depths_m: Vec::new(),
                })
            }
        }
    }
}

/// A flight in progress.
struct Flown<'a> {
    components: &'a Components,
    mission: &'a Mission,
    plan: &'a Plan,
    simulation: Simulation,
    /// The actions to come, ordered by time.
    due: Vec<(Timestamp, Act)>,
    /// How often the run has entered each state.
    entries: [u32; State::ALL.len()],
    state: State,
    resolved: Vec<Planned>,
    met: Vec<(String, State)>,
    failures: Vec<Failure>,
    power_goes: bool,
    /// At the beginning of the liveness phase: the requests sent so far, and the seconds of control.
    at_calm: Option<(u64, f64)>,
    /// For how long the runtime had control after the last fault without sending anything, seconds.
    silent_s: Option<f64>,
    /// Whether the vehicle steers itself, and none of our requests is open.
    converged: bool,
    /// Since when all plugins trap, if nothing has replaced one of them after that.
    none_since: Option<Timestamp>,
    /// Until then the runtime is not running, and does not know what it misses.
    away_until: Timestamp,
    /// SHA-256 of the component in each slot, hexadecimal, if the flight has a log: a replay finds a swap's version by it.
    hashes: Vec<String>,
}

fn sha256(bytes: &[u8]) -> String {
    let hash = Sha256::digest(bytes);
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl<'a> Flown<'a> {
    fn new(
        components: &'a Components,
        mission: &'a Mission,
        scenario: &Scenario,
        plan: &'a Plan,
        log: Option<&Path>,
    ) -> Result<Self> {
        let loaded = components.start(mission)?;
        let recorder = match log {
            Some(path) => Some(Recorder::create(
                path,
                &Header {
                    utc_at_start: scenario.world.start.utc,
                    rate: Rate::Simulation,
                    mission: &mission.name,
                    seed: Some(plan.seed),
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
        let logged = loaded.components.iter().filter(|_| log.is_some());
        let hashes = logged.map(|(_, bytes)| sha256(bytes)).collect();
        let simulation = Simulation::new(mission, scenario, plan.seed, loaded, recorder)?;
        let mut flown = Self {
            components,
            mission,
            plan,
            state: simulation.state(),
            simulation,
            due: Vec::new(),
            entries: [0; State::ALL.len()],
            resolved: Vec::new(),
            met: Vec::new(),
            failures: Vec::new(),
            power_goes: false,
            at_calm: None,
            silent_s: None,
            converged: false,
            none_since: None,
            away_until: Timestamp::ZERO,
            hashes,
        };
        for planned in &plan.faults {
            if let Come::At(at) = planned.come {
                flown.later(at, Act::Begin(planned.fault.clone()));
            }
        }
        Ok(flown)
    }

    fn later(&mut self, at: Timestamp, act: Act) {
        let place = self.due.partition_point(|(due, _)| *due <= at);
        self.due.insert(place, (at, act));
    }

    fn fly(mut self) -> Result<Flight> {
        let calm = seconds(CALM_S);
        self.later(calm, Act::Calm);
        self.later(calm + LINK_WITHIN, Act::LinkIsUp);
        self.later(seconds(HAND_BACK_S), Act::HandBack);
        let end = self.plan.until.unwrap_or(seconds(LONGEST_S));
        loop {
            let next = self.due.first().map_or(Timestamp::MAX, |(at, _)| *at);
            match self.simulation.advance_until(next.min(end))? {
                Step::Over => break,
                Step::Went => {}
                Step::Reached => {
                    let now = self.simulation.now();
                    if now >= end {
                        break;
                    }
                    while self.due.first().is_some_and(|(at, _)| *at <= now) {
                        let (_, act) = self.due.remove(0);
                        self.act(act)?;
                    }
                    if self.converged {
                        break;
                    }
                }
            }
            self.follow();
        }
        self.finish()
    }

    /// Starts the faults that wait for the state that the run has entered.
    fn follow(&mut self) {
        let state = self.simulation.state();
        if state == self.state {
            return;
        }
        self.state = state;
        let entries = &mut self.entries[state as usize];
        *entries += 1;
        let entries = *entries;
        let now = self.simulation.now();
        for planned in &self.plan.faults {
            if let Come::In { state: at, nth, after } = planned.come
                && at == state
                && nth == entries
            {
                self.later(now + after, Act::Begin(planned.fault.clone()));
            }
        }
    }

    fn act(&mut self, act: Act) -> Result<()> {
        match act {
            Act::Begin(fault) => self.begin(fault)?,
            Act::Own(slot) => {
                self.simulation.substitute(PluginId(slot), None);
                self.none_since = None;
            }
            Act::NoneSteers => self.judge_none(),
            Act::Release => self.simulation.operate(Operator::Release),
            Act::DiskHasRoom => self.simulation.reserve_fails(false),
            Act::Calm => {
                let seen = self.simulation.statistics();
                self.at_calm = Some((self.simulation.request_counts().sent, seen.control_s));
            }
            Act::LinkIsUp => self.judge_link(),
            Act::HandBack => {
                self.judge_sending();
                self.simulation.operate(Operator::Hold);
                self.later(seconds(LEAST_S), Act::Look);
            }
            Act::Look => {
                self.converged = !self.simulation.is_steering() && self.simulation.open_requests() == 0;
                let again = self.simulation.now() + LOOK_EVERY;
                self.later(again, Act::Look);
            }
        }
        Ok(())
    }

    fn begin(&mut self, fault: Fault) -> Result<()> {
        let now = self.simulation.now();
        let left = until_calm(now);
        if left.is_zero() {
            return Ok(());
        }
        let fault = fault.at_most(left);
        if matches!(fault, Fault::Kill { .. } | Fault::Stop { .. }) || is_of_link(&fault) {
            self.away_until = self.away_until.max(now + fault.lasts() + LINK_WITHIN);
        }
        self.met.push((fault.kind(), self.simulation.state()));
        self.resolved.push(Planned {
            come: Come::At(now),
            fault: fault.clone(),
        });
        match fault {
            Fault::Vehicle(fault) => {
                self.power_goes |= matches!(fault.kind, FaultKind::Shutdown);
                self.simulation.inject(fault);
            }
            Fault::Plugin { slot, fault, lasts } => {
                let table = self.bad(slot, &fault)?;
                let understudy = self.components.start_one("faulty", &table, self.mission)?;
                self.simulation.substitute(PluginId(slot), Some(understudy));
                self.later(now + lasts, Act::Own(slot));
                self.none_since = None;
            }
            Fault::Swap { slot, to, trial_steps } => {
                self.none_since = None;
                let (table, sha256) = if to == SWAPS[0] {
                    let hash = self.hashes.get(slot).cloned().unwrap_or_default();
                    (self.mission.file.plugins[slot].clone(), hash)
                } else {
                    (self.bad(slot, "trap")?, String::new())
                };
                let ready = self.components.start_one(&to, &table, self.mission)?;
                let version = Version {
                    version: to,
                    sha256,
                    trial_steps,
                };
                self.simulation.swap(PluginId(slot), ready, version);
            }
            Fault::AllTrap { lasts } => {
                for slot in 0..self.mission.file.plugins.len() {
                    let table = self.bad(slot, "trap")?;
                    let understudy = self.components.start_one("faulty", &table, self.mission)?;
                    self.simulation.substitute(PluginId(slot), Some(understudy));
                    self.later(now + lasts, Act::Own(slot));
                }
                if lasts > NONE_WITHIN {
                    self.later(now + NONE_WITHIN, Act::NoneSteers);
                }
                self.none_since = Some(now);
            }
            Fault::Kill { away, clock_s } => {
                let loaded = self.components.start(self.mission)?;
                self.simulation.kill(away, loaded, (clock_s * 1e9) as i64);
            }
            Fault::Stop { lasts } => self.simulation.stop_for(lasts),
            Fault::Hold { lasts } => {
                self.simulation.operate(Operator::Hold);
                self.later(now + lasts, Act::Release);
            }
            Fault::DiskFull { lasts } => {
                self.simulation.reserve_fails(true);
                self.later(now + lasts, Act::DiskHasRoom);
            }
        }
        Ok(())
    }

    /// The table of a faulty plugin, which replaces one of the mission's.
    fn bad(&self, slot: usize, fault: &str) -> Result<PluginTable> {
        let mut table = self
            .mission
            .file
            .plugins
            .get(slot)
            .with_context(|| format!("the mission has no plugin {slot}"))?
            .clone();
        table.component = "faulty".to_owned();
        table.config = toml::Table::new();
        table.config.insert("fault".to_owned(), fault.into());
        Ok(table)
    }

    /// Checks that a failed plugin does not steer (safety requirement 006). If one of them recovered in the meantime,
    /// or the runtime was not running, this cannot be judged.
    fn judge_none(&mut self) {
        let steered = matches!(
            self.simulation.state(),
            State::Lease | State::LeaseInsert | State::Station
        );
        let now = self.simulation.now();
        let none = self.none_since.is_some_and(|since| since + NONE_WITHIN <= now);
        if steered && now > self.away_until && none {
            self.fail("dead-plugin-steers", || {
                format!(
                    "a lease or station keeping lives {} s after all plugins have trapped",
                    NONE_WITHIN.as_secs()
                )
            });
        }
    }

    fn judge_link(&mut self) {
        let runs = self.simulation.mission_status() == Status::Running;
        if runs && !self.power_goes && self.simulation.state() == State::Down {
            self.fail("link-stays-down", || {
                format!("no link {} s after the last fault", LINK_WITHIN.as_secs())
            });
        }
    }

    /// A runtime that had control for long enough after the last fault must have sent a request and received an answer,
    /// except where no fault was planned, because then it has nothing to recover from. Whether any plugin is left to
    /// make requests is known only at the end.
    fn judge_sending(&mut self) {
        let seen = self.simulation.statistics();
        if let Some((sent, control_s)) = self.at_calm
            && !self.plan.faults.is_empty()
            && self.simulation.request_counts().sent == sent
            && seen.control_s - control_s > CHANCE_S
        {
            self.silent_s = Some(seen.control_s - control_s);
        }
    }

    fn fail(&mut self, rule: &str, text: impl FnOnce() -> String) {
        self.failures.push(Failure {
            rule: rule.to_owned(),
            text: text(),
            at: None,
        });
    }

    fn finish(mut self) -> Result<Flight> {
        let (truth, open) = (self.simulation.truth(), self.simulation.open_request_states());
        // Silent mode and the report on a packet have time limits of their own, which may be later than the mission's
        // end.
        let has_term = |line: &String| line.starts_with("Silent ") || line.starts_with("Packet ");
        let open: Vec<String> = open.into_iter().filter(|line| !has_term(line)).collect();
        let over = self.simulation.mission_status() != Status::Running;
        // A flight that was ended early, or lost its power, has no end to check.
        if self.plan.until.is_none() && !self.power_goes && !self.converged {
            if !over {
                self.fail("never-ends", || {
                    format!("at the end {:?}, open: {}", truth.activity, open.join(", "))
                });
            } else if !open.is_empty() && self.simulation.now() > self.away_until {
                self.fail("ledger-open", || open.join(", "));
            }
        }
        let converged = self.converged;
        let (mut report, trace, _) = self.simulation.finish()?;
        let plugins = self.mission.file.plugins.iter().map(|plugin| plugin.name.as_str());
        if let Some(had_s) = self.silent_s
            && !trace.ending_ordered
            && !none_is_left(plugins, &self.resolved, &report.plugin_failures)
        {
            self.failures.push(Failure {
                rule: "never-sends-again".to_owned(),
                text: format!("{had_s:.0} s of control after the last fault, and nothing was sent"),
                at: None,
            });
        }
        let counts = &report.requests;
        // An open request may wait, or wait for its answer; an ended one does neither.
        if !counts.add_up() || counts.waiting + counts.undecided > report.requests_open as u64 {
            self.failures.push(Failure {
                rule: "requests-add-up".to_owned(),
                text: format!("{counts}; {} open", report.requests_open),
                at: None,
            });
        }
        if converged && report.outcome == "overran" {
            report.outcome = "handed back";
        }
        for violation in std::mem::take(&mut report.violations) {
            self.failures.push(Failure {
                rule: violation.rule.to_string(),
                text: violation.to_string(),
                at: Some(Timestamp::from_nanos(violation.at_ns)),
            });
        }
        Ok(Flight {
            resolved: Plan {
                faults: self.resolved,
                ..self.plan.clone()
            },
            met: self.met,
            report,
            failures: self.failures,
            navigation: trace.navigation,
            depths_m: trace.samples.iter().map(|sample| (sample.at, sample.depth_m)).collect(),
        })
    }
}

/// Whether the runtime may be unable to receive from the vehicle because of it.
fn is_of_link(fault: &Fault) -> bool {
    matches!(fault, Fault::Vehicle(fault) if matches!(fault.kind, FaultKind::Link(_)))
}

fn seconds(seconds: f64) -> Timestamp {
    Timestamp::ZERO + Duration::from_secs_f64(seconds)
}

mod connection;
mod driver;
mod interference;
pub(crate) mod judge;
mod process;
pub(crate) mod sonars;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::sync::Arc;
use std::time::Duration;

use backseat_core::plugin::Rule;
use backseat_core::{Envelope, Identifiers, RequestCounts, Reservation, Settings, Start};
use backseat_mission::Mission;
use backseat_mvc::{ClientId, FaultPlan, LinkFaults, Mvc, MvcError, Script, Status};
use backseat_oracle::{OracleError, State, Statistics};
use backseat_plc::PlcError;
use backseat_plugin_loader::Loaded;
use backseat_recorder::{Recorder, RecorderError};
use backseat_scenario::{Scenario, ScenarioError};
use backseat_sonar::ConfigError;
use backseat_sonar_bridge::SonarSettings;
use backseat_units::{Timestamp, Utc};

use crate::control::ControlTimes;
use crate::digest::Digest;
use crate::expectation;
use crate::link::Lane;
use crate::report::{FirstFailure, Published, Report, rejections};
use crate::simulation::judge::Judge;
use crate::simulation::process::{Process, Successor};
use crate::simulation::sonars::Controller;
use crate::trace::Trace;

/// The run goes on for this long after the mission is over, to see everything that is still due.
const AFTERMATH: Duration = Duration::from_secs(10);
/// A run ends when it has taken this long in virtual time.
const LONGEST: Timestamp = Timestamp::from_secs(24 * 3600);

/// Why a run cannot be made, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// The world cannot be made.
    #[error("world.toml: {0}")]
    Mvc(#[from] MvcError),
    /// The oracle cannot read the fence.
    #[error("fence.geojson, as the oracle reads it: {0}")]
    Oracle(#[from] OracleError),
    /// The log cannot be written.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// The payload controller cannot be made.
    #[error("world.toml: [plc]: {0}")]
    Controller(#[from] PlcError),
    /// The controller's sonars cannot be made.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The client of the sonars cannot be made.
    #[error("mission.toml: [sonar]: {0}")]
    Sonar(#[from] ConfigError),
}

/// How far [`Simulation::advance_until`] came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// One thing has happened; more may follow at the same time.
    Went,
    /// Nothing more happens until the limit; the virtual time is now the limit.
    Reached,
    /// The run is over.
    Over,
}

/// What is left when a process of the runtime ends.
#[derive(Debug)]
struct Disk {
    /// All SPI identifiers below this may have been used.
    reservation: Reservation,
    /// The operator's hold.
    held: bool,
    /// Nothing more can be written.
    full: bool,
}

/// A simulated run.
///
/// Between two events, the caller can do more than let it run: inject a fault, kill or stop the runtime's process, act
/// as its operator, or let another plugin take the place of one. All of this happens at [`Simulation::now`], after
/// everything that was due by then.
///
/// The log of a run goes on when the process is killed, and a note in it says so. Its inputs and outputs are those of
/// the process that runs at the time, in the run's own time. A replay starts core again where the next process began.
pub struct Simulation {
    /// `None` after a kill, until the next process begins.
    process: Option<Process>,
    successor: Option<Successor>,
    restarts: u32,
    /// Requests of the processes that were killed.
    counts_before: RequestCounts,
    disk: Disk,
    settings: Settings,
    envelope: Arc<Envelope>,
    /// The true UTC at time zero.
    utc_at_start: Utc,
    mvc: Mvc,
    oracle: Judge,
    recorder: Option<Recorder<BufWriter<File>>>,
    digest: Digest,
    trace: Trace,
    now: Timestamp,
    to_payload: Lane,
    to_vehicle: Lane,
    faults: LinkFaults,
    faults_begun: u64,
    client: ClientId,
    connected: bool,
    over_at: Option<Timestamp>,
    finished: bool,
    /// An error of a function that cannot return it. The next step returns it.
    failed: Option<SimError>,
    scratch: Vec<u8>,
    reasons: BTreeMap<(Rule, String), (u64, String)>,
    names: Vec<String>,
    plugin_failures: BTreeMap<String, u64>,
    quarantines: BTreeMap<String, f64>,
    /// When the runtime had control.
    control: ControlTimes,
    /// How each plugin failed first, by its name in the mission.
    first_failures: BTreeMap<String, FirstFailure>,
    /// The newest error that each plugin logged, by its name, and when: the first of its step, or a panic.
    last_words: BTreeMap<String, (Timestamp, String)>,
    /// The last value of each measure that plugins published, by `PLUGIN.NAME`.
    published: BTreeMap<String, Published>,
    mission: String,
    seed: u64,
    expect: backseat_mvc::Expectations,
    /// The sonars' payload controller, if the scenario has one.
    controller: Option<Controller>,
    /// What a client of it needs to know of the mission.
    sonar: Option<SonarSettings>,
}

impl Simulation {
    /// Makes a run of a mission in its scenario, with a seed and loaded plugins.
    ///
    /// # Errors
    /// [`SimError`] if this seed's world cannot be made, or if the log cannot be written.
    pub fn new(
        mission: &Mission,
        scenario: &Scenario,
        seed: u64,
        loaded: Loaded,
        mut recorder: Option<Recorder<BufWriter<File>>>,
    ) -> Result<Self, SimError> {
        let mvc = scenario.vehicle(seed)?;
        let oracle = Judge::new(mission)?;
        let utc_at_start = mvc.utc(Timestamp::ZERO);
        let disk = Disk {
            reservation: Reservation {
                below: 1,
                inserts: 0,
                gps_hits: 0,
            },
            held: false,
            full: false,
        };
        let start = Start {
            utc: utc_at_start,
            identifiers: Some(disk.identifiers()),
            armed: true,
            held: false,
            jitter: seed,
        };
        if let Some(recorder) = &mut recorder {
            recorder.start(&start)?;
        }
        let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
        let (settings, envelope) = (mission.file.session.clone(), mission.envelope.clone());
        let sonar = SonarSettings::of(mission);
        let bridge = sonar.as_ref().map(|sonar| sonar.bridge(utc_at_start)).transpose()?;
        let process = Process::new(
            Timestamp::ZERO,
            settings.clone(),
            envelope.clone(),
            loaded,
            start,
            bridge,
        );
        let mut simulation = Self {
            process: Some(process),
            successor: None,
            restarts: 0,
            counts_before: RequestCounts::default(),
            disk,
            settings,
            envelope,
            utc_at_start,
            mvc,
            oracle,
            recorder,
            digest: Digest::default(),
            trace: Trace::default(),
            now: Timestamp::ZERO,
            to_payload: Lane::new(seed, "link from the vehicle"),
            to_vehicle: Lane::new(seed, "link to the vehicle"),
            faults: LinkFaults::new(&scenario.world.faults.plan()?, seed),
            faults_begun: 0,
            client: ClientId(0),
            connected: false,
            over_at: None,
            finished: false,
            failed: None,
            scratch: Vec::new(),
            reasons: BTreeMap::new(),
            names,
            plugin_failures: BTreeMap::new(),
            quarantines: BTreeMap::new(),
            control: ControlTimes::default(),
            first_failures: BTreeMap::new(),
            last_words: BTreeMap::new(),
            published: BTreeMap::new(),
            mission: mission.name.clone(),
            seed,
            expect: scenario.world.expect.clone(),
            controller: Controller::new(scenario, seed, utc_at_start)?,
            sonar,
        };
        simulation.show_controller();
        simulation.drain_core()?;
        simulation.drain_client()?;
        Ok(simulation)
    }

    /// Replaces the faults of this run, which are those of `world.toml` at first. Call it before the first
    /// [`Simulation::advance`].
    pub fn set_faults(&mut self, plan: FaultPlan) {
        self.faults = LinkFaults::new(&plan, self.seed);
        self.mvc.set_faults(plan);
    }

    /// Gives this run a script. Call it before the first [`Simulation::advance`].
    ///
    /// # Errors
    /// [`MvcError`] with the rule's line, if it names a dive that the vehicle does not have.
    pub fn set_script(&mut self, script: Script) -> Result<(), MvcError> {
        self.mvc.set_script(script)
    }

    /// Virtual time.
    #[must_use]
    pub const fn now(&self) -> Timestamp {
        self.now
    }

    /// The true state of the vehicle.
    #[must_use]
    pub fn truth(&self) -> backseat_mvc::Truth {
        self.mvc.truth()
    }

    /// The world that only simulation knows.
    #[must_use]
    pub fn world(&self) -> &backseat_world::World {
        self.mvc.world()
    }

    /// What the run has recorded so far.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// How many requests have reached which state, in all processes of the runtime.
    #[must_use]
    pub fn request_counts(&self) -> RequestCounts {
        let mut counts = self.counts_before;
        if let Some(process) = &self.process {
            counts += process.core.request_counts();
        }
        counts
    }

    /// How many requests of the runtime's present process have not ended; 0 if there is none.
    #[must_use]
    pub fn open_requests(&self) -> usize {
        self.process.as_ref().map_or(0, |process| process.core.open_requests())
    }

    /// Whether the runtime's present process has a lease: a modify or station keeping.
    #[must_use]
    pub fn is_steering(&self) -> bool {
        self.process.as_ref().is_some_and(|process| process.core.is_steering())
    }

    /// How often a new process of the runtime has begun after one was killed.
    #[must_use]
    pub const fn restarts(&self) -> u32 {
        self.restarts
    }

    /// The state of the run, as the bytes of the link alone show it.
    #[must_use]
    pub fn state(&self) -> State {
        self.oracle.state()
    }

    /// The requests that have not ended, each in words; empty while no process runs.
    #[must_use]
    pub fn open_request_states(&self) -> Vec<String> {
        self.process
            .as_ref()
            .map_or_else(Vec::new, |process| process.core.open_request_states())
    }

    /// What the oracle has seen so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        self.oracle.statistics()
    }

    /// How many violations the oracle has found so far.
    #[must_use]
    pub fn violations_so_far(&self) -> usize {
        usize::try_from(self.oracle.statistics().violations).unwrap_or(usize::MAX)
    }

    /// The status of the vehicle's mission.
    #[must_use]
    pub fn mission_status(&self) -> Status {
        self.mvc.mission_status()
    }

    /// Goes on to the next event. Returns false when the run is over.
    ///
    /// # Errors
    /// [`SimError::Recorder`] if the log cannot be written.
    pub fn advance(&mut self) -> Result<bool, SimError> {
        Ok(self.advance_until(Timestamp::MAX)? == Step::Went)
    }

    /// Goes on by one event that is due at or before a limit; if there is none left, goes to the limit.
    ///
    /// # Errors
    /// [`SimError::Recorder`] if the log cannot be written.
    pub fn advance_until(&mut self, limit: Timestamp) -> Result<Step, SimError> {
        if let Some(failed) = self.failed.take() {
            return Err(failed);
        }
        if self.finished {
            return Ok(Step::Over);
        }
        if let Some(over_at) = self.over_at
            && self.now >= over_at + AFTERMATH
        {
            self.stop()?;
            return Ok(Step::Over);
        }
        let own = self.process.as_ref().map(Process::due).unwrap_or_default();
        let [controller_due, to_controller, to_client] =
            self.controller.as_ref().map(Controller::due).unwrap_or_default();
        // A client that is stopped reads nothing.
        let to_client = to_client.filter(|_| self.is_awake());
        // The order at the same instant: faults of the link, what arrives, plugins' answers, connecting, the vehicle,
        // core's own timers, then the sonars.
        let due = [
            self.link_fault_due(),
            self.to_vehicle.next(),
            self.to_payload.next(),
            own.answer,
            own.connect,
            self.mvc.poll_timeout(),
            own.wakes.or(self.successor.as_ref().map(|successor| successor.at)),
            controller_due,
            to_controller,
            to_client,
            own.client,
        ];
        let mut first: Option<(Timestamp, usize)> = None;
        for (index, at) in due.into_iter().enumerate() {
            if let Some(at) = at
                && first.is_none_or(|(earliest, _)| at < earliest)
            {
                first = Some((at, index));
            }
        }
        let Some((at, what)) = first.filter(|(at, _)| *at <= LONGEST) else {
            self.stop()?;
            return Ok(Step::Over);
        };
        if at > limit {
            self.now = self.now.max(limit);
            return Ok(Step::Reached);
        }
        self.now = self.now.max(at);
        match what {
            0 => self.link_fault()?,
            1 => self.arrive_at_vehicle()?,
            2 => self.arrive_at_payload()?,
            3 => self.answer()?,
            4 => self.connect()?,
            5 => {
                self.mvc.handle_timeout(self.now);
                self.show_controller();
                self.look()?;
                self.drain_mvc()?;
            }
            6 => self.wake()?,
            7 => self.controller_due()?,
            8 => self.arrive_at_controller()?,
            9 => self.arrive_at_client()?,
            _ => self.client_due()?,
        }
        Ok(Step::Went)
    }

    /// Runs to the end. `progress` is called about once a virtual minute.
    ///
    /// # Errors
    /// [`SimError::Recorder`] if the log cannot be written.
    pub fn run(&mut self, mut progress: impl FnMut(&Self)) -> Result<(), SimError> {
        let mut next = Timestamp::ZERO;
        while self.advance()? {
            if self.now >= next {
                next = self.now + Duration::from_secs(60);
                progress(self);
            }
        }
        Ok(())
    }

    /// Closes the log and judges the run. The caller adds its own clock's seconds.
    ///
    /// # Errors
    /// [`SimError::Recorder`] if the log cannot be closed.
    pub fn finish(mut self) -> Result<(Report, Trace, Mvc), SimError> {
        self.end_sonar_files();
        if let Some(recorder) = self.recorder.take() {
            recorder.finish()?;
        }
        let outcome = match self.mvc.mission_status() {
            Status::Completed => "completed",
            Status::Aborted | Status::Stopped | Status::InvalidDiveFile | Status::InvalidWrapupFile => "aborted",
            Status::Offline
            | Status::Waiting
            | Status::Ready
            | Status::Running
            | Status::WrappingUp
            | Status::Aborting => "overran",
        };
        let (requests, requests_open) = (self.request_counts(), self.open_requests());
        let seen = self.oracle.statistics();
        let violations = self.oracle.finish(self.now);
        let mut report = Report {
            mission: self.mission,
            seed: self.seed,
            outcome,
            sim_seconds: self.now.as_secs_f64(),
            wall_seconds: 0.0,
            load_seconds: 0.0,
            faults: self.faults_begun,
            requests,
            requests_open,
            rejections: rejections(self.reasons.values(), requests.rejected),
            control: self.control,
            plugin_failures: self.plugin_failures,
            plugin_first_failures: self.first_failures,
            plugin_quarantines: self.quarantines,
            violations,
            seen,
            measures: BTreeMap::new(),
            published: self.published,
            unmet: Vec::new(),
            digest: self.digest.finish(),
        };
        expectation::judge(&mut report, &self.expect, &self.trace, &self.mvc);
        Ok((report, self.trace, self.mvc))
    }
}

impl Disk {
    /// The identifiers that a process may use that begins now.
    const fn identifiers(&self) -> Identifiers {
        Identifiers {
            next: self.reservation.below,
            reserved: self.reservation.below,
            first: 1,
            inserts: self.reservation.inserts,
            gps_hits: self.reservation.gps_hits,
        }
    }
}

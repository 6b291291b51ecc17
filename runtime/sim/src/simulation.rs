use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::time::Duration;

use backseat_core::plugin::{PluginId, Returned};
use backseat_core::{
    ControlHook, Core, FailAction, Identifiers, Input, Note, Operator, Output, RequestCounts, Restarted, Start,
};
use backseat_mission::{Mission, MissionError};
use backseat_mvc::{
    Activity, ClientId, Direction as Way, FaultEdge, FaultPlan, LinkFaults, Mvc, MvcError, MvcEventKind, Status, Truth,
    WorldFile,
};
use backseat_oracle::{Oracle, OracleError};
use backseat_plugin_host::Plugin;
use backseat_recorder::{Recorder, RecorderError};
use backseat_units::Timestamp;

use crate::digest::{Digest, Direction};
use crate::expectation;
use crate::link::{DELAY_MAX, Lane};
use crate::load::Loaded;
use crate::report::Report;
use crate::trace::Trace;

/// A nanosecond for a unit of fuel: what a core of these years burns, nearly.
const FUEL_PER_SECOND: u64 = 1_000_000_000;
/// The run goes on for this long after the mission is over, so that all that is due is seen.
const AFTERMATH: Duration = Duration::from_secs(10);
/// A mission that takes longer than this in virtual time is given up.
const LONGEST: Timestamp = Timestamp::from_secs(24 * 3600);
/// A write that the vehicle has not acknowledged for so long ends the connection, as it does at sea.
const UNACKNOWLEDGED_MAX: Duration = Duration::from_secs(2);
const REASONS_MAX: usize = 20;

/// A run that cannot be made, or that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// The mission has no world.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// The world cannot be made.
    #[error("world.toml: {0}")]
    Mvc(#[from] MvcError),
    /// The oracle cannot read the fence.
    #[error("fence.geojson, as the oracle reads it: {0}")]
    Oracle(#[from] OracleError),
    /// The log cannot be written.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
}

/// A plugin's answer that is under way.
enum Answer {
    Returned(Returned),
    Restarted(Restarted),
}

/// A run.
pub struct Simulation {
    core: Core,
    mvc: Mvc,
    plugins: Vec<Plugin>,
    oracle: Oracle,
    recorder: Option<Recorder<BufWriter<File>>>,
    digest: Digest,
    trace: Trace,
    now: Timestamp,
    to_payload: Lane,
    to_vehicle: Lane,
    faults: LinkFaults,
    faults_begun: u64,
    connect_at: Option<Timestamp>,
    reset: bool,
    client: ClientId,
    connected: bool,
    answers: Vec<(Timestamp, PluginId, Answer)>,
    reserved: Option<u32>,
    over_at: Option<Timestamp>,
    recorded_navigation: Option<Timestamp>,
    finished: bool,
    scratch: Vec<u8>,
    reasons: BTreeMap<String, (u64, String)>,
    names: Vec<String>,
    plugin_failures: BTreeMap<String, u64>,
    mission: String,
    seed: u64,
    expect: backseat_mvc::Expectations,
}

impl Simulation {
    /// A run of a mission with a seed, its plugins loaded.
    ///
    /// # Errors
    /// [`SimError`] where the mission has no world, or one that cannot be made.
    pub fn new(
        mission: &Mission,
        seed: u64,
        loaded: Loaded,
        mut recorder: Option<Recorder<BufWriter<File>>>,
    ) -> Result<Self, SimError> {
        let world: &WorldFile = mission.world()?;
        let mvc = mission.vehicle(world, seed)?;
        let limits = &mission.file.limits;
        let oracle = Oracle::new(
            &mission.fence_text,
            backseat_oracle::Limits {
                speed_min_mps: limits.speed_min_mps,
                speed_max_mps: limits.speed_max_mps,
                control: match &mission.file.session.control {
                    ControlHook::Bfctl => backseat_oracle::ControlHook::BackseatControl,
                    ControlHook::Running => backseat_oracle::ControlHook::MissionRunning,
                    ControlHook::MissionCommand { grant, revoke } => backseat_oracle::ControlHook::MissionCommand {
                        grant: grant.clone(),
                        revoke: revoke.clone(),
                    },
                },
                tracking_error_m: limits.tracking_error_m,
                navigation_age_max_s: limits.navigation_age_max_s,
                operator_commands: orders(mission),
                inserts_open_max: limits.inserts_open_max,
                inserts_total_max: limits.inserts_total_max,
                inserts_duration_max_s: limits.inserts_duration_max_s,
                link_delay_s: DELAY_MAX.as_secs_f64(),
            },
        )?;
        let start = Start {
            utc: mvc.utc(Timestamp::ZERO),
            identifiers: Some(Identifiers { next: 1, reserved: 1 }),
            armed: true,
            held: false,
            jitter: seed,
        };
        if let Some(recorder) = &mut recorder {
            recorder.start(&start)?;
        }
        let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
        let core = Core::new(
            mission.file.session.clone(),
            mission.envelope.clone(),
            loaded.setups,
            start,
        );
        let mut simulation = Self {
            core,
            mvc,
            plugins: loaded.plugins,
            oracle,
            recorder,
            digest: Digest::default(),
            trace: Trace::default(),
            now: Timestamp::ZERO,
            to_payload: Lane::new(seed, "link from the vehicle"),
            to_vehicle: Lane::new(seed, "link to the vehicle"),
            faults: LinkFaults::new(&world.faults.plan()?, seed),
            faults_begun: 0,
            connect_at: None,
            reset: false,
            client: ClientId(0),
            connected: false,
            answers: Vec::new(),
            reserved: None,
            over_at: None,
            recorded_navigation: None,
            finished: false,
            scratch: Vec::new(),
            reasons: BTreeMap::new(),
            names,
            plugin_failures: BTreeMap::new(),
            mission: mission.name.clone(),
            seed,
            expect: world.expect,
        };
        simulation.drain_core()?;
        Ok(simulation)
    }

    /// Replaces what goes wrong in this run; the world's own section is what it begins with. To be called before
    /// the first [`Simulation::advance`].
    pub fn set_faults(&mut self, plan: FaultPlan) {
        self.faults = LinkFaults::new(&plan, self.seed);
        self.mvc.set_faults(plan);
    }

    /// Virtual time.
    #[must_use]
    pub const fn now(&self) -> Timestamp {
        self.now
    }

    /// The vehicle as it truly is.
    #[must_use]
    pub fn truth(&self) -> backseat_mvc::Truth {
        self.mvc.truth()
    }

    /// The world that only simulation knows.
    #[must_use]
    pub fn world(&self) -> &backseat_world::World {
        self.mvc.world()
    }

    /// What the run has left so far.
    #[must_use]
    pub const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// How many requests have come how far.
    #[must_use]
    pub fn request_counts(&self) -> RequestCounts {
        self.core.request_counts()
    }

    /// Goes on to the next event. False when the run is over.
    ///
    /// # Errors
    /// [`SimError::Recorder`] where the log cannot be written.
    pub fn advance(&mut self) -> Result<bool, SimError> {
        if self.finished {
            return Ok(false);
        }
        if let Some(over_at) = self.over_at
            && self.now >= over_at + AFTERMATH
        {
            self.stop()?;
            return Ok(false);
        }
        let answer = self
            .answers
            .iter()
            .enumerate()
            .min_by_key(|(_, (at, _, _))| *at)
            .map(|(index, (at, _, _))| (*at, index));
        // At the same instant: the link's faults, what arrives, what returns, who connects, the vehicle, then our own
        // timers.
        let due = [
            self.link_fault_due(),
            self.to_vehicle.next(),
            self.to_payload.next(),
            answer.map(|(at, _)| at),
            self.connect_at,
            self.mvc.poll_timeout(),
            self.core.poll_timeout(),
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
            return Ok(false);
        };
        self.now = self.now.max(at);
        match what {
            0 => self.link_fault()?,
            1 => self.arrive_at_vehicle()?,
            2 => self.arrive_at_payload()?,
            3 => {
                if let Some((_, index)) = answer {
                    let (_, plugin, answer) = self.answers.remove(index);
                    self.answer(plugin, answer)?;
                }
            }
            4 => self.connect()?,
            5 => {
                self.mvc.handle_timeout(self.now);
                self.look()?;
                self.drain_mvc()?;
            }
            _ => self.feed(Input::Timeout)?,
        }
        Ok(true)
    }

    /// Runs to the end. `progress` is called about once a virtual minute.
    ///
    /// # Errors
    /// [`SimError::Recorder`] where the log cannot be written.
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
    /// [`SimError::Recorder`] where the log cannot be closed.
    pub fn finish(mut self) -> Result<(Report, Trace, Mvc), SimError> {
        if let Some(recorder) = self.recorder.take() {
            recorder.finish()?;
        }
        let outcome = match self.mvc.mission_status() {
            Status::Completed => "completed",
            Status::Aborted | Status::Stopped => "aborted",
            Status::Ready | Status::Running | Status::WrappingUp | Status::Aborting => "overran",
        };
        let requests = self.core.request_counts();
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
            requests_open: self.core.open_requests(),
            rejections: self
                .reasons
                .values()
                .map(|(count, reason)| format!("{count} x {reason}"))
                .collect(),
            plugin_failures: self.plugin_failures,
            violations,
            seen,
            measures: BTreeMap::new(),
            unmet: Vec::new(),
            digest: self.digest.finish(),
        };
        expectation::judge(&mut report, &self.expect, &self.trace, &self.mvc);
        Ok((report, self.trace, self.mvc))
    }

    fn stop(&mut self) -> Result<(), SimError> {
        self.feed(Input::Operator(Operator::Stop))?;
        self.finished = true;
        Ok(())
    }

    fn feed(&mut self, input: Input<'_>) -> Result<(), SimError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.input(self.now, &input)?;
        }
        self.core.handle(self.now, input);
        if let Some(recorder) = &mut self.recorder
            && let Some(sample) = self.core.navigation()
            && self.recorded_navigation != Some(sample.solution)
        {
            self.recorded_navigation = Some(sample.solution);
            recorder.navigation(self.now, sample)?;
        }
        self.drain_core()
    }

    fn drain_core(&mut self) -> Result<(), SimError> {
        loop {
            while let Some(output) = self.core.poll_output() {
                if let Some(recorder) = &mut self.recorder {
                    recorder.output(self.now, &output)?;
                }
                self.carry_out(output);
            }
            // What the driver answers at once is an input like any other.
            if let Some(below) = self.reserved.take() {
                self.feed_quietly(Input::Reserved(below))?;
            } else if std::mem::take(&mut self.reset) {
                self.disconnect();
                self.feed_quietly(Input::LinkDown)?;
            } else {
                return Ok(());
            }
        }
    }

    /// As [`Simulation::feed`], its outputs left for the loop that called.
    fn feed_quietly(&mut self, input: Input<'_>) -> Result<(), SimError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.input(self.now, &input)?;
        }
        self.core.handle(self.now, input);
        Ok(())
    }

    fn carry_out(&mut self, output: Output) {
        match output {
            Output::Send(bytes) => {
                self.digest.write(Direction::ToVehicle, self.now, &bytes);
                self.oracle.to_vehicle(self.now, &bytes);
                self.trace.sent(&bytes);
                if self.connected {
                    self.to_vehicle.write(self.now, &bytes, |_| {});
                }
            }
            Output::Connect { after } => self.connect_at = Some(self.now + after),
            Output::ResetLink => self.reset = true,
            Output::Invoke(plugin, input) => {
                let returned = self.plugins[plugin.0].step(&input);
                let at = self.now + Duration::from_nanos(returned.fuel * (1_000_000_000 / FUEL_PER_SECOND));
                self.answers.push((at, plugin, Answer::Returned(returned)));
            }
            Output::Restart(plugin) => {
                let restarted = self.plugins[plugin.0].restart();
                let at = self.now + Duration::from_nanos(restarted.fuel * (1_000_000_000 / FUEL_PER_SECOND));
                let restarted = Restarted {
                    fuel: restarted.fuel,
                    lost_steps: restarted.lost_steps,
                    result: restarted.result,
                };
                self.answers.push((at, plugin, Answer::Restarted(restarted)));
            }
            Output::Reserve(below) => self.reserved = Some(below),
            Output::Finish => self.finished = true,
            // No driver runs in simulation: there is none to hear it.
            Output::Driver(..) => {}
            Output::Note(note) => self.note(&note),
        }
    }

    fn note(&mut self, note: &Note) {
        if let Note::PluginFailed { plugin, .. } = note
            && let Some(name) = self.names.get(plugin.0)
        {
            *self.plugin_failures.entry(name.clone()).or_default() += 1;
        }
        if let Note::Request(transition) = note
            && let backseat_core::plugin::RequestState::Rejected(reason) = &transition.state
        {
            // Reasons that differ in their figures alone are one; the first of them is told.
            let kind: String = reason.chars().filter(|char| !char.is_ascii_digit()).collect();
            let full = self.reasons.len() >= REASONS_MAX;
            match self.reasons.get_mut(&kind) {
                Some((count, _)) => *count += 1,
                None if full => {}
                None => {
                    self.reasons.insert(kind, (1, reason.clone()));
                }
            }
        }
        let position = self.core.navigation().map(|navigation| navigation.position);
        self.trace.note(self.now, note, position);
    }

    fn answer(&mut self, plugin: PluginId, answer: Answer) -> Result<(), SimError> {
        match answer {
            Answer::Returned(returned) => {
                if let Ok(requests) = &returned.result {
                    self.trace.asked(requests);
                }
                self.feed(Input::Returned(plugin, returned))
            }
            Answer::Restarted(restarted) => self.feed(Input::Restarted(plugin, restarted)),
        }
    }

    fn connect(&mut self) -> Result<(), SimError> {
        self.connect_at = None;
        self.client = ClientId(self.client.0 + 1);
        if self.faults.refuses(self.now, self.client, None) {
            return self.feed(Input::LinkDown);
        }
        if !self.faults.is_empty() {
            let link = |way| Some(self.faults.link(self.now, self.client, None, way));
            self.to_vehicle.open(link(Way::ToVehicle));
            self.to_payload.open(link(Way::FromVehicle));
        }
        self.connected = true;
        self.oracle.link(self.now, true);
        self.mvc.connect(self.now, self.client);
        self.feed(Input::LinkUp)?;
        self.drain_mvc()
    }

    fn disconnect(&mut self) {
        if self.connected {
            self.connected = false;
            self.mvc.disconnect(self.now, self.client);
            self.oracle.link(self.now, false);
            self.to_payload.cut();
            self.to_vehicle.cut();
        }
    }

    fn link_fault_due(&self) -> Option<Timestamp> {
        let unacknowledged = self.waits_since().map(|since| since + UNACKNOWLEDGED_MAX);
        [
            self.to_vehicle.next_fault(),
            self.to_payload.next_fault(),
            unacknowledged,
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// Since when a write has waited, where the connection is reset for it.
    fn waits_since(&self) -> Option<Timestamp> {
        #[cfg(feature = "switches")]
        {
            use backseat_core::switches::{Check, is_on};
            if !is_on(Check::StaleSends) {
                return None;
            }
        }
        self.to_vehicle.waits_since()
    }

    /// What faults have held back goes on its way, or the connection is gone.
    fn link_fault(&mut self) -> Result<(), SimError> {
        let now = self.now;
        let unacknowledged = self
            .waits_since()
            .is_some_and(|since| now >= since + UNACKNOWLEDGED_MAX);
        if unacknowledged || self.to_vehicle.is_cut(now) || self.to_payload.is_cut(now) {
            self.disconnect();
            return self.feed(Input::LinkDown);
        }
        self.to_vehicle.release(now, |_| {});
        let oracle = &mut self.oracle;
        self.to_payload.release(now, |bytes| oracle.from_vehicle(now, bytes));
        Ok(())
    }

    fn arrive_at_vehicle(&mut self) -> Result<(), SimError> {
        let Some(bytes) = self.to_vehicle.take() else {
            return Ok(());
        };
        self.mvc.receive(self.now, self.client, &bytes);
        self.to_vehicle.recycle(bytes);
        self.drain_mvc()
    }

    fn arrive_at_payload(&mut self) -> Result<(), SimError> {
        let Some(bytes) = self.to_payload.take() else {
            return Ok(());
        };
        self.feed(Input::Received(&bytes))?;
        self.to_payload.recycle(bytes);
        Ok(())
    }

    fn drain_mvc(&mut self) -> Result<(), SimError> {
        let mut buffer = std::mem::take(&mut self.scratch);
        while self.mvc.poll_transmit(&mut buffer).is_some() {
            self.digest.write(Direction::FromVehicle, self.now, &buffer);
            // The judge sees what is on its way to us: what a fault has swallowed we could not know.
            let (oracle, now) = (&mut self.oracle, self.now);
            self.to_payload
                .write(now, &buffer, |bytes| oracle.from_vehicle(now, bytes));
        }
        self.scratch = buffer;
        while let Some(event) = self.mvc.poll_event() {
            if let MvcEventKind::Fault(fault) = &event.kind
                && fault.edge == FaultEdge::Begin
            {
                self.faults_begun += 1;
            }
            if let Some(recorder) = &mut self.recorder {
                recorder.vehicle_event(self.now, &event.to_string())?;
            }
        }
        let mut cut = false;
        while self.mvc.poll_disconnect().is_some() {
            cut = true;
        }
        if cut && self.connected {
            self.disconnect();
            self.feed(Input::LinkDown)?;
        }
        if self.over_at.is_none() && self.mvc.mission_over() {
            self.over_at = Some(self.now);
        }
        Ok(())
    }

    /// The judge and the trace see the vehicle's step.
    fn look(&mut self) -> Result<(), SimError> {
        let truth: Truth = self.mvc.truth();
        if self.trace.truth(&truth)
            && let (Some(recorder), Some(sample)) = (&mut self.recorder, self.trace.samples.last())
        {
            recorder.truth(self.now, sample)?;
        }
        let activity = match truth.activity {
            Activity::Plan { .. } => backseat_oracle::Activity::Plan,
            Activity::Insert { id } => backseat_oracle::Activity::Insert(id.get()),
            Activity::Modified { .. } => backseat_oracle::Activity::Modified,
            Activity::Waiting | Activity::Suspended | Activity::WrappingUp | Activity::Stopped => {
                backseat_oracle::Activity::Other
            }
        };
        self.oracle.truth(&backseat_oracle::Truth {
            at: truth.time,
            position: truth.position,
            depth_m: truth.depth_m,
            altitude_m: truth.altitude_m,
            activity,
        });
        Ok(())
    }
}

/// Whether the operator of a mission has ordered anything in advance that no plugin may send.
fn orders(mission: &Mission) -> bool {
    let aborts = |plugin: &backseat_mission::PluginTable| plugin.on_failure == FailAction::Abort;
    !mission.file.policies.is_empty() || mission.file.plugins.iter().any(aborts)
}

//! The driver at sea: core on a real clock, a TCP link, and plugins on threads of their own.

use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::time::Duration;

use anyhow::{Result, bail};
use backseat_core::plugin::Rule;
use backseat_core::refusal::Uncontrolled;
use backseat_core::{Core, Grant, Input, Note, Operator, Output, Start};
use backseat_mission::Mission;
use backseat_plugin_host::Host;
use backseat_plugin_loader::load_plugins;
use backseat_recorder::{Header, Rate, Recorder, RecorderError};
use backseat_units::Timestamp;
use clap::Args;
use tokio::net::TcpStream;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tracing::{error, info, warn};

use crate::cli::MissionArguments;
use crate::clock::Clock;
use crate::external::{Heard, Ports};
use crate::helm::Helm;
use crate::keeper::{Keeper, Kept};
use crate::link::{Link, Ready, connect};
use crate::operator::Signals;
use crate::owner::explained;
use crate::plugins::{Answer, Crew};
use crate::recording::{Queue, Recording};
use crate::service::{Service, Slips};
use crate::sonar::Sonars;
use crate::state::State;

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
    /// Write logs into this folder
    #[arg(long, value_name = "DIR", default_value = "logs")]
    pub(crate) log: PathBuf,
    /// Keep SPI identifiers and the operator's hold in this folder [default: a folder of the vehicle's name in the
    /// user's state folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Start a new record of SPI identifiers at N, a number that no payload has used in this mission of the vehicle
    // 0 means none on the wire (SPI 6.21); the upper bound leaves room for every request of a mission.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=2_000_000_000))]
    pub(crate) first_identifier: Option<u32>,
}

/// Grants for requests that the vehicle knows by an identifier.
const NAMED: [Grant; 3] = [Grant::Insert, Grant::Surface, Grant::Acoustic];
const FLUSH_EVERY: Duration = Duration::from_secs(2);
/// A change of the system's UTC against its monotonic clock that is too large to be a time daemon's slewing between two
/// checks.
const UTC_STEP_MIN: Duration = Duration::from_millis(500);
/// A state folder that has not answered for this long is reported as stuck.
const STATE_WITHIN: Duration = Duration::from_secs(2);
/// Clocks that are further apart are worth a warning: zones with a time window are then closed (`monitor::envelope`).
const CLOCKS_APART_S: f64 = 60.0;
/// How long the last BPEMB may take to leave when the run ends.
const FAREWELL: Duration = Duration::from_millis(300);

pub(crate) fn run(arguments: &Run) -> Result<bool> {
    // This comes before anything slow, so that the operator's signals count from the first moment. The runtime is never
    // dropped, not even in a panic: dropping would wait for a host name that is being resolved, which can take for
    // ever.
    let runtime = ManuallyDrop::new(tokio::runtime::Builder::new_current_thread().enable_all().build()?);
    let signals = {
        let _within = runtime.enter();
        Signals::new()?
    };
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let address = match &arguments.connect {
        Some(address) => host_and_port(address, "--connect")?,
        None => host_and_port(&mission.file.vehicle.address, "mission.toml: vehicle.address")?,
    };
    let (ports, heard) = {
        let _within = runtime.enter();
        Ports::open(&mission.file.externals)?
    };
    let host = Host::new()?;
    let loaded = load_plugins(&host, &mission, arguments.mission.plugins.as_deref())?;
    let folder = State::folder_of(arguments.state.as_deref(), &mission)?;
    let state = State::open(&folder, mission.file.vehicle.name.as_deref())?;
    let identifiers = state.identifiers(arguments.first_identifier)?;
    let clock = Clock::start();
    let mut recorder = open_log(&arguments.log, &mission, &loaded.components, &clock)?;
    if identifiers.is_none() && names_requests(&mission) {
        info!(
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
    if !start.armed {
        info!("not armed: nothing that steers will be sent; to arm, use --arm");
    }
    recorder.record(Timestamp::ZERO, |recorder| recorder.start(&start));
    let names = loaded.setups.iter().map(|setup| setup.name.clone()).collect();
    let core = Core::new(
        mission.file.session.clone(),
        mission.envelope.clone(),
        loaded.setups,
        start,
    );
    let (sender, answers) = unbounded_channel();
    let (keeps, kept) = unbounded_channel();
    let around = Around {
        crew: Crew::new(host, loaded.plugins, sender),
        ports,
        keeper: Keeper::start(state, start.held, keeps)?,
        recorder,
        sonars: Sonars::start(&mission, clock)?,
    };
    let driver = Driver::new(core, clock, address, around, names);
    runtime.block_on(driver.drive(answers, kept, heard, signals))?;
    Ok(true)
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

fn open_log(folder: &Path, mission: &Mission, components: &[(String, Vec<u8>)], clock: &Clock) -> Result<Recording> {
    std::fs::create_dir_all(folder).map_err(|error| explained(folder, error))?;
    let path = folder.join(format!(
        "{}-{}.mcap",
        mission.name,
        clock.utc_at_start().as_unix_nanos() / 1_000_000
    ));
    info!("log: {}", path.display());
    Recording::create(
        &path,
        &Header {
            utc_at_start: clock.utc_at_start(),
            rate: Rate::Deployed,
            mission: &mission.name,
            seed: None,
            resolved_mission: &mission.resolved,
            fence: &mission.fence_text,
            components,
            version: env!("CARGO_PKG_VERSION"),
        },
    )
}

/// The result of an attempt to connect; waits for ever without one.
async fn connected(
    connecting: &mut Option<Pin<Box<dyn Future<Output = std::io::Result<TcpStream>>>>>,
) -> std::io::Result<TcpStream> {
    match connecting {
        Some(connecting) => connecting.await,
        None => std::future::pending().await,
    }
}

/// The parts beside the loop, which have threads or tasks of their own.
pub(crate) struct Around {
    pub(crate) crew: Crew,
    pub(crate) ports: Ports,
    pub(crate) keeper: Keeper,
    pub(crate) recorder: Recording,
    pub(crate) sonars: Option<Sonars>,
}

pub(crate) struct Driver {
    core: Core,
    clock: Clock,
    link: Link,
    address: String,
    connect_at: Option<Timestamp>,
    connecting: Option<Pin<Box<dyn Future<Output = std::io::Result<TcpStream>>>>>,
    /// When core last handled an input, and so when it judged the output of that.
    judged: Timestamp,
    crew: Crew,
    ports: Ports,
    keeper: Keeper,
    recorder: Recording,
    sonars: Option<Sonars>,
    finished: bool,
    reset: bool,
    /// The last reservation could not be written to disk.
    cannot_reserve: bool,
    /// When the oldest unanswered request to the state folder was made.
    state_asked: Option<Timestamp>,
    /// Whether that silence has been reported.
    state_silent: bool,
    /// The kind of the last refusal.
    last_refusal: Option<(Rule, String)>,
    /// Why the link was lost, until this is logged together with the next attempt to connect.
    link_lost: Option<String>,
    recorded_navigation: Option<Timestamp>,
    /// How far core believes that the system's clock was set, nanoseconds.
    utc_set_nanos: i64,
    /// The plugins' names, for messages.
    names: Vec<String>,
    helm: Helm,
}

impl Driver {
    /// A loop that has not yet connected to the vehicle at this address. `names` are the plugins' names.
    pub(crate) fn new(core: Core, clock: Clock, address: String, around: Around, names: Vec<String>) -> Self {
        let Around {
            crew,
            ports,
            keeper,
            recorder,
            sonars,
        } = around;
        Self {
            core,
            clock,
            link: Link::default(),
            address,
            connect_at: None,
            connecting: None,
            judged: Timestamp::ZERO,
            crew,
            ports,
            keeper,
            recorder,
            sonars,
            finished: false,
            reset: false,
            cannot_reserve: false,
            state_asked: None,
            state_silent: false,
            last_refusal: None,
            link_lost: None,
            recorded_navigation: None,
            utc_set_nanos: 0,
            names,
            helm: Helm::default(),
        }
    }

    /// Serves core until it has finished.
    pub(crate) async fn drive(
        mut self,
        mut answers: UnboundedReceiver<Answer>,
        mut kept: UnboundedReceiver<Kept>,
        mut heard: Heard,
        mut signals: Signals,
    ) -> Result<()> {
        let mut buffer = vec![0; 64 * 1024];
        let mut flush_at = Timestamp::ZERO + FLUSH_EVERY;
        let (mut service, mut slips) = (Service::from_environment(), Slips::default());
        self.carry_out_all();
        while !self.finished {
            service.comes_round(self.clock.now());
            let wake = [
                self.core.poll_timeout(),
                self.connect_at,
                self.link.write_deadline(),
                service.deadline(),
                Some(flush_at),
            ];
            let wake = wake.into_iter().flatten().min().unwrap_or(flush_at);
            let instant = self.clock.instant(wake);
            tokio::select! {
                // Core's timers come first: core must learn of a late wake-up before it handles the input that has
                // piled up.
                biased;
                () = tokio::time::sleep_until(instant) => self.feed(Input::Timeout),
                act = signals.next() => self.operator(act),
                Some(kept) = kept.recv() => self.kept(kept),
                Some(answer) = answers.recv() => match answer {
                    Answer::Returned(plugin, returned) => self.feed(Input::Returned(plugin, returned)),
                    Answer::Restarted(plugin, restarted) => self.feed(Input::Restarted(plugin, restarted)),
                },
                connected = connected(&mut self.connecting) => self.connected(connected),
                ready = self.link.ready(&mut buffer) => match ready {
                    Ready::Read(read) => self.feed(Input::Received(&buffer[..read])),
                    Ready::Writable => self.flush(),
                    Ready::Closed => self.lose_link("the vehicle closed the connection".to_owned()),
                },
                report = Sonars::next(&mut self.sonars) => self.feed(Input::Sonar(report)),
                // The operator's programs come last: whatever they send can wait.
                Some((source, bytes)) = heard.recv() => self.feed(Input::External(source, &bytes)),
            }
            let now = self.clock.now();
            slips.woke(wake, now);
            if self.link.write_deadline().is_some_and(|at| at <= now) {
                self.lose_link("a write has been waiting for a second".to_owned());
            }
            if self.connect_at.is_some_and(|at| at <= now) {
                self.connect_at = None;
                let address = self.address.clone();
                self.connecting = Some(Box::pin(async move { connect(&address).await }));
            }
            if flush_at <= now {
                flush_at = now + FLUSH_EVERY;
                self.record(Recorder::flush);
                self.follow_utc();
                self.watch_state(now);
            }
        }
        service.stopping();
        slips.end();
        self.farewell().await;
        // Nothing more can be sent.
        if !self.keeper.finish(self.core.used()) {
            warn!("the state folder does not answer: identifiers that were reserved and not used stay reserved");
        }
        self.recorder.finish(self.clock.now());
        Ok(())
    }

    /// Handles a result of the keeper, or an operator's act on the hold's file.
    fn kept(&mut self, kept: Kept) {
        if !matches!(kept, Kept::Act(_) | Kept::Gone) {
            self.state_asked = None;
            if std::mem::take(&mut self.state_silent) {
                info!("the state folder answers again");
            }
        }
        match kept {
            Kept::Held => {}
            Kept::Reserved(reservation) => {
                if std::mem::take(&mut self.cannot_reserve) {
                    info!("identifiers can be reserved again; inserts are sent again");
                }
                self.feed(Input::Reserved(reservation));
            }
            // Core requests it again and again; only the first failure is logged.
            Kept::NotReserved(error) => {
                if !std::mem::replace(&mut self.cannot_reserve, true) {
                    error!("identifiers cannot be reserved; no more inserts are sent: {error:#}");
                }
            }
            Kept::NotHeld(error) => {
                error!(
                    "the operator's hold or release counts for this run only, because it could not be saved: {error:#}"
                );
            }
            Kept::Act(act) => self.operator(act),
            Kept::Gone => {
                (self.cannot_reserve, self.state_silent) = (true, true);
                error!(
                    "the thread that keeps the state has panicked: the operator's hold or release counts for this run \
                     only, and no more inserts are sent"
                );
            }
        }
    }

    /// Notes that the state folder has been asked to save something.
    fn ask_state(&mut self) {
        self.state_asked.get_or_insert(self.clock.now());
    }

    /// Reports a state folder that does not answer: a disk that hangs gives no error.
    fn watch_state(&mut self, now: Timestamp) {
        let late = |asked: Timestamp| now.since(asked) >= STATE_WITHIN;
        if self.state_asked.is_some_and(late) && !std::mem::replace(&mut self.state_silent, true) {
            error!(
                "the state folder does not answer; until it does, the operator's hold or release counts for this run \
                 only, and inserts without a reserved identifier are not sent"
            );
        }
    }

    /// Tells core when the system's clock was set after the start, because zones with time windows depend on it.
    fn follow_utc(&mut self) {
        let set = self.clock.utc_set_nanos();
        if u128::from(set.abs_diff(self.utc_set_nanos)) >= UTC_STEP_MIN.as_nanos() {
            self.utc_set_nanos = set;
            if let Some(sonars) = &self.sonars {
                sonars.utc_set(set);
            }
            self.feed(Input::UtcSet(set));
        }
    }

    fn feed(&mut self, input: Input<'_>) {
        let now = self.clock.now();
        let due = self.core.poll_timeout().is_some_and(|due| due <= now);
        if due && !matches!(input, Input::Timeout) {
            // The system was suspended, and so was the timer that the loop waits for.
            self.take_in(now, Input::Timeout);
        }
        self.take_in(now, input);
    }

    fn take_in(&mut self, now: Timestamp, input: Input<'_>) {
        self.record(|recorder| recorder.input(now, &input));
        self.handle(now, input);
        if let Some(sample) = self.core.navigation().copied()
            && self.recorded_navigation != Some(sample.solution)
        {
            self.recorded_navigation = Some(sample.solution);
            self.record(|recorder| recorder.navigation(now, &sample));
        }
        self.carry_out_all();
    }

    fn handle(&mut self, now: Timestamp, input: Input<'_>) {
        self.judged = now;
        self.core.handle(now, input);
    }

    fn carry_out_all(&mut self) {
        loop {
            let now = self.clock.now();
            while let Some(output) = self.core.poll_output() {
                self.record(|recorder| recorder.output(now, &output));
                self.carry_out(now, output);
            }
            if !std::mem::take(&mut self.reset) {
                return;
            }
            self.link.reset();
            self.record(|recorder| recorder.input(now, &Input::LinkDown));
            self.handle(now, Input::LinkDown);
        }
    }

    fn carry_out(&mut self, now: Timestamp, output: Output) {
        match output {
            Output::Send(bytes) => {
                if let Some(line) = self.helm.sent(now, &bytes) {
                    info!("{line}");
                }
                if let Err(error) = self.link.send(self.judged, self.clock.now(), &bytes) {
                    self.link_lost = Some(format!("the connection failed: {error}"));
                    self.reset = self.link.is_open();
                }
            }
            Output::Connect { after } => self.connect_at = Some(now + after),
            Output::ResetLink => self.reset = true,
            Output::Invoke(plugin, input) => self.crew.step(plugin, input),
            Output::Restart(plugin) => self.crew.restart(plugin),
            Output::Sonar(wish) => {
                if let Some(sonars) = &mut self.sonars {
                    sonars.tell(wish);
                }
            }
            Output::External(source, line) => self.ports.tell(source, line),
            Output::Reserve(reservation) => {
                self.ask_state();
                self.keeper.reserve(reservation);
            }
            Output::Finish => self.finished = true,
            Output::Note(note) => {
                if let Note::Operator { act } = &note {
                    self.keep(act);
                }
                self.tell(&note);
            }
        }
    }

    fn tell(&mut self, note: &Note) {
        self.helm.noted(note);
        let told = note.describe(&self.names);
        match note {
            Note::LinkDown { retry_s, .. } => match self.link_lost.take() {
                Some(why) => warn!("{why}; next attempt in {retry_s:.1} s"),
                None => warn!("{told}"),
            },
            Note::PluginFailed { .. } | Note::Recovery { .. } | Note::Late { .. } | Note::Malformed { .. } => {
                warn!("{told}");
            }
            Note::Clock { offset_s, .. } if offset_s.abs() >= CLOCKS_APART_S => {
                warn!("{told}: set the clock of this computer");
            }
            Note::Clock { .. } => info!("{told}"),
            Note::Request(transition) => {
                use backseat_core::plugin::{EndKind, RequestState};
                match &transition.state {
                    // A plugin that repeats a refused request is reported once.
                    RequestState::Rejected(refusal) => {
                        let kind = Some((refusal.rule(), refusal.summary()));
                        if self.last_refusal != kind {
                            self.last_refusal = kind;
                            warn!("{told}");
                        }
                    }
                    RequestState::Ended(ended) if ended.kind() == EndKind::Replaced => {}
                    RequestState::Sent | RequestState::Pending => {}
                    RequestState::Accepted if transition.identifier.is_none() => {}
                    RequestState::Accepted
                    | RequestState::Failed(_)
                    | RequestState::TimedOut
                    | RequestState::Unknown
                    | RequestState::Started
                    | RequestState::Ended(_)
                    | RequestState::Cancelled => info!("{told}"),
                }
            }
            Note::LinkUp
            | Note::VehicleVersion { .. }
            | Note::Mission { .. }
            | Note::Control { .. }
            | Note::LeaseEnded { .. }
            | Note::Plan { .. }
            | Note::Behavior { .. }
            | Note::Navigation { .. }
            | Note::PluginRestarted { .. }
            | Note::PluginLog { .. }
            | Note::Sonar { .. } => info!("{told}"),
            Note::Operator { act } => match act {
                Operator::Hold => info!("operator: hold"),
                Operator::Release => info!("operator: release"),
                Operator::Stop => info!("operator: stop"),
                Operator::Order(order) => info!("operator: {order}"),
            },
            Note::Text { text } if text.starts_with(Uncontrolled::PlanDiffers.text()) => warn!("{told}"),
            Note::Text { .. } => info!("{told}"),
        }
    }

    /// Saves a hold or release of the operator or a policy, so that it outlives the process.
    fn keep(&mut self, act: &Operator) {
        let held = match act {
            Operator::Hold => true,
            Operator::Release => false,
            Operator::Stop | Operator::Order(_) => return,
        };
        self.ask_state();
        self.keeper.hold(held);
    }

    fn operator(&mut self, act: Operator) {
        self.feed(Input::Operator(act));
    }

    fn connected(&mut self, connected: std::io::Result<TcpStream>) {
        self.connecting = None;
        match connected {
            Ok(stream) => {
                self.link.open(stream);
                self.feed(Input::LinkUp);
            }
            Err(error) => {
                self.lose_link(format!("no vehicle at {}: {error}", self.address));
            }
        }
    }

    fn flush(&mut self) {
        if self.link.flush(self.clock.now()).is_err() {
            self.lose_link("the connection failed".to_owned());
        }
    }

    fn lose_link(&mut self, why: String) {
        self.link_lost = Some(why);
        self.link.reset();
        self.feed(Input::LinkDown);
    }

    /// Waits until all written bytes have left, then closes the link in order.
    async fn farewell(&mut self) {
        let until = self.clock.now() + FAREWELL;
        while self.link.write_deadline().is_some() && self.clock.now() < until {
            tokio::time::sleep(Duration::from_millis(10)).await;
            if self.link.flush(self.clock.now()).is_err() {
                return;
            }
        }
        self.link.close(FAREWELL).await;
    }

    fn record(&mut self, act: impl FnOnce(&mut Recorder<Queue>) -> Result<(), RecorderError>) {
        self.recorder.record(self.clock.now(), act);
    }
}

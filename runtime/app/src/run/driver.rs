//! The loop around core at sea.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::pin::Pin;
use std::time::Duration;

use anyhow::Result;
use backseat_core::plugin::{PluginId, Rule};
use backseat_core::{Core, Input, Note, Operator, Output};
use backseat_recorder::{Recorder, RecorderError};
use backseat_units::Timestamp;
use tokio::net::TcpStream;
use tokio::sync::mpsc::UnboundedReceiver;
use tracing::{error, info, warn};

use crate::clock::{Clock, Working};
use crate::external::{Heard, Ports};
use crate::helm::Helm;
use crate::keeper::{Keeper, Kept};
use crate::link::{Link, Ready, connect};
use crate::operator::{Asked, Signals};
use crate::plugins::{Answer, Crew};
use crate::rate::Rate;
use crate::recording::{Queue, Recording};
use crate::run::shadow::Shadows;
use crate::run::swaps::{News, Offer, Swaps};
use crate::service::{Service, Slips};
use crate::sonar::Sonars;

const FLUSH_EVERY: Duration = Duration::from_secs(1);
/// How often the reach of the live modify is recorded.
const REACH_EVERY: Duration = Duration::from_secs(1);
/// A change of the system's UTC against its monotonic clock that is too large to be a time daemon's slewing between two
/// checks.
const UTC_STEP_MIN: Duration = Duration::from_millis(500);
/// A state folder that has not answered for this long is reported as stuck.
const STATE_WITHIN: Duration = Duration::from_secs(2);
/// How long the last BPEMB may take to leave when the run ends.
const FAREWELL: Duration = Duration::from_millis(300);

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
    pub(crate) helm: Helm,
    pub(crate) swaps: Option<Swaps>,
    pub(crate) shadows: Shadows,
}

/// Where the threads beside the loop report.
pub(crate) struct Inbox {
    pub(crate) answers: UnboundedReceiver<Answer>,
    pub(crate) kept: UnboundedReceiver<Kept>,
}

/// Watches the loop, and changes nothing.
pub(crate) trait Onlooker {
    /// Core asks for this.
    fn output(&mut self, output: &Output);
    /// The loop comes round.
    fn comes_round(&mut self, core: &Core, helm: &Helm);
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
    /// The room for core's outputs.
    outputs: Vec<Output>,
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
    state_asked: Option<(Timestamp, Working)>,
    /// Whether that silence has been reported.
    state_silent: bool,
    /// The kind of the last refusal.
    pub(super) last_refusal: Option<(Rule, String)>,
    /// The plugin that steers by a lease, as the operator was told.
    pub(super) steering: Option<PluginId>,
    /// Why the link was lost, until this is logged together with the next attempt to connect.
    pub(super) link_lost: Option<String>,
    recorded_navigation: Option<Timestamp>,
    /// When the reach of the live modify was last recorded; `None` while nothing steers.
    recorded_reach: Option<Timestamp>,
    /// How far core believes that the system's clock was set, nanoseconds.
    utc_set_nanos: i64,
    /// The plugins' names, for messages.
    pub(super) names: Vec<String>,
    pub(super) helm: Helm,
    pub(super) rate: Rate,
    pub(super) swaps: Option<Swaps>,
    shadows: Shadows,
    onlooker: Option<Box<dyn Onlooker>>,
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
            helm,
            swaps,
            shadows,
        } = around;
        Self {
            core,
            clock,
            link: Link::default(),
            address,
            connect_at: None,
            connecting: None,
            judged: Timestamp::ZERO,
            outputs: Vec::new(),
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
            steering: None,
            link_lost: None,
            recorded_navigation: None,
            recorded_reach: None,
            utc_set_nanos: 0,
            names,
            helm,
            rate: Rate::default(),
            swaps,
            shadows,
            onlooker: None,
        }
    }

    /// Has somebody watch.
    #[cfg(feature = "simulation")]
    pub(crate) fn watched(mut self, onlooker: Box<dyn Onlooker>) -> Self {
        self.onlooker = Some(onlooker);
        self
    }

    /// Serves core until it has finished.
    pub(crate) async fn drive(
        mut self,
        Inbox { mut answers, mut kept }: Inbox,
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
            let clock = self.clock;
            if let Some(onlooker) = &mut self.onlooker {
                onlooker.comes_round(&self.core, &self.helm);
            }
            tokio::select! {
                // Core's timers come first: core must learn of a late wake-up before it handles the input that has
                // piled up.
                biased;
                () = clock.sleep_until(wake) => self.feed(Input::Timeout),
                asked = signals.next() => self.asked(asked),
                Some(kept) = kept.recv() => self.kept(kept),
                Some(answer) = answers.recv() => self.answered(answer),
                connected = connected(&mut self.connecting) => self.connected(connected),
                ready = self.link.ready(&mut buffer) => match ready {
                    Ready::Read(read) => self.received(&buffer[..read]),
                    Ready::Writable => self.flush(),
                    Ready::Closed => self.lose_link("the vehicle closed the connection".to_owned()),
                },
                report = Sonars::next(&mut self.sonars) => self.feed(Input::Sonar(report)),
                said = Swaps::next(&mut self.swaps) => match said {
                    News::Ready(offer) => self.swap(*offer),
                    News::Refused(why) => self.note_asked(&why),
                },
                step = self.shadows.next() => {
                    let now = self.clock.now();
                    self.record(now, |recorder| recorder.shadow(now, &step));
                }
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
                self.record(self.clock.now(), Recorder::flush);
                self.follow_utc();
                self.watch_state(now);
            }
        }
        service.stopping();
        self.shadows.sum_up();
        slips.end();
        self.farewell().await;
        // Nothing more can be sent.
        if !self.keeper.finish(self.core.used()) {
            warn!("the state folder does not answer: identifiers that were reserved and not used stay reserved");
        }
        self.recorder.finish(self.clock.now());
        Ok(())
    }

    fn received(&mut self, bytes: &[u8]) {
        let now = self.clock.now();
        self.helm.heard();
        self.feed(Input::Received(bytes));
        // This is for the screen alone, so it comes after what core does with the bytes.
        if let Some(line) = self.rate.received(now, bytes) {
            warn!("{line}");
            self.helm.clock_is_off(self.rate.is_off());
        }
    }

    fn answered(&mut self, answer: Answer) {
        self.crew.answered(&answer);
        match answer {
            Answer::Returned(plugin, returned) => self.feed(Input::Returned(plugin, returned)),
            Answer::Restarted(plugin, restarted) => self.feed(Input::Restarted(plugin, restarted)),
            Answer::Passed(plugin, version) => {
                let (name, hash) = (&self.names[plugin.0], version.sha256.get(..12).unwrap_or_default());
                let (version, steps) = (version.version, version.trial_steps);
                let text = format!("{name}: version {version} ({hash}) has passed its trial of {steps} steps");
                info!("{text}");
                self.note_asked(&text);
            }
        }
    }

    /// Has the log say what somebody asked for, or what came of it.
    fn note_asked(&mut self, text: &str) {
        let now = self.clock.now();
        self.record(now, |recorder| recorder.asked(now, text));
    }

    /// Puts a version in a plugin's place that the operator wants there.
    fn swap(&mut self, offer: Offer) {
        let now = self.clock.now();
        self.record(now, |recorder| {
            recorder.version(now, &offer.version.sha256, &offer.component)
        });
        if let Some(swaps) = &mut self.swaps {
            swaps.taken(&offer);
        }
        let Offer {
            plugin, ready, version, ..
        } = offer;
        self.crew.offer(plugin, ready, version.clone());
        self.feed(Input::Swap(plugin, version));
    }

    /// Handles a result of the keeper, or an operator's act on the hold's file.
    fn kept(&mut self, kept: Kept) {
        if !matches!(kept, Kept::Act(_) | Kept::Blind(_) | Kept::Gone) {
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
                    "the operator's hold or release counts for this run only, unless it can be saved later: {error:#}"
                );
            }
            Kept::Act(act) => {
                self.told_of(&act, "by the file");
                self.operator(act);
            }
            Kept::Blind(why) => {
                error!(
                    "the hold's file cannot be seen, so nobody can hold with it, and this is a hold: {why}; when the folder \
                     is there again, release with SIGUSR2 or by deleting the file `hold` in it"
                );
                self.note_asked(&format!("hold, because the hold's file cannot be seen: {why}"));
                self.operator(Operator::Hold);
            }
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
        let (clock, now) = (self.clock, self.clock.now());
        self.state_asked.get_or_insert_with(|| (now, clock.working()));
    }

    /// Reports a state folder that does not answer: a disk that hangs gives no error.
    fn watch_state(&mut self, now: Timestamp) {
        let late = |(asked, _): &(Timestamp, Working)| now.since(*asked) >= STATE_WITHIN;
        if self.state_asked.as_ref().is_some_and(late) && !std::mem::replace(&mut self.state_silent, true) {
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
            self.take_in(Input::Timeout);
        }
        self.take_in(input);
    }

    fn take_in(&mut self, input: Input<'_>) {
        // Each input has a time of its own, so that no time that core is given or that is recorded goes back.
        let now = self.clock.now();
        self.handle(now, &input);
        let sample = self.core.navigation().copied();
        self.act_at_once();
        // The log has the input before what follows from it.
        self.record(now, |recorder| recorder.input(now, &input));
        if let Some(sample) = sample
            && self.recorded_navigation != Some(sample.solution)
        {
            self.recorded_navigation = Some(sample.solution);
            self.record(now, |recorder| recorder.navigation(now, &sample));
        }
        self.carry_out_all();
        self.follow_reach();
    }

    /// Records each second where the live modify can lead, and once that nothing steers any more.
    fn follow_reach(&mut self) {
        let now = self.clock.now();
        match self.recorded_reach {
            None if !self.core.is_steering() => return,
            Some(recorded) if self.core.is_steering() && now.since(recorded) < REACH_EVERY => return,
            None | Some(_) => {}
        }
        let reach = self.core.reach();
        if reach.is_none() && self.recorded_reach.is_none() {
            // The vehicle keeps its station.
            return;
        }
        self.recorded_reach = reach.map(|_| now);
        self.record(now, |recorder| recorder.reach(now, reach.as_ref()));
    }

    fn handle(&mut self, now: Timestamp, input: &Input<'_>) {
        self.judged = now;
        let handled = catch_unwind(AssertUnwindSafe(|| self.core.handle(now, input.clone())));
        if let Err(panic) = handled {
            // What core panics at is the last thing in the log.
            self.record(now, |recorder| recorder.input(now, input));
            resume_unwind(panic);
        }
    }

    /// Takes core's outputs, sends what is for the vehicle, and has the plugins step on their threads. All else comes
    /// after that: records, the screen, the disk.
    fn act_at_once(&mut self) {
        let mut outputs = std::mem::take(&mut self.outputs);
        let before = outputs.len();
        outputs.extend(std::iter::from_fn(|| self.core.poll_output()));
        self.send_all(&outputs[before..]);
        for output in &outputs[before..] {
            if let Output::Invoke(plugin, input) = output {
                self.crew.step(*plugin, input.clone());
            }
        }
        self.outputs = outputs;
    }

    /// Records core's outputs, and carries out what is left of them.
    fn carry_out_all(&mut self) {
        loop {
            self.act_at_once();
            let now = self.clock.now();
            let mut outputs = std::mem::take(&mut self.outputs);
            for output in outputs.drain(..) {
                self.record(now, |recorder| recorder.output(now, &output));
                if let Some(onlooker) = &mut self.onlooker {
                    onlooker.output(&output);
                }
                self.carry_out(now, output);
            }
            self.outputs = outputs;
            if !std::mem::take(&mut self.reset) {
                return;
            }
            self.reset_link();
            self.record(now, |recorder| recorder.input(now, &Input::LinkDown));
            self.handle(now, &Input::LinkDown);
        }
    }

    /// What comes after a reset of the link belongs to no connection.
    fn send_all(&mut self, outputs: &[Output]) {
        let before_reset = outputs.iter().take_while(|output| !matches!(output, Output::ResetLink));
        for output in before_reset {
            let Output::Send(bytes) = output else { continue };
            let now = self.clock.now();
            if let Err(error) = self.link.send(self.judged, now, bytes) {
                self.link_lost = Some(format!("the connection failed: {error}"));
                self.reset = self.link.is_open();
            }
            self.rate.sent(now, bytes);
            if let Some(line) = self.helm.sent(now, bytes) {
                warn!("{line}");
            }
        }
    }

    fn carry_out(&mut self, now: Timestamp, output: Output) {
        match output {
            // See `act_at_once`.
            Output::Send(_) => {}
            Output::Connect { after } => self.connect_at = Some(now + after),
            Output::ResetLink => self.reset = true,
            Output::Invoke(plugin, input) => self.shadows.step(plugin, &input),
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
                self.tell(now, &note);
            }
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

    /// Does what a signal or somebody at the console asks for; the log has who it was.
    fn asked(&mut self, asked: Asked) {
        if let Some(who) = &asked.who {
            let text = format!("{who} at the console: {}", asked.word());
            info!("{text}");
            self.note_asked(&text);
        } else {
            self.told_of(&asked.act, "by a signal");
        }
        self.operator(asked.act);
    }

    /// Has the log say how the operator held or released.
    fn told_of(&mut self, act: &Operator, how: &str) {
        let word = match act {
            Operator::Hold => "hold",
            Operator::Release => "release",
            Operator::Stop | Operator::Order(_) => return,
        };
        let text = format!("{word} {how}");
        info!("{text}");
        self.note_asked(&text);
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
        self.reset_link();
        self.feed(Input::LinkDown);
    }

    /// Resets the connection. Round trips of another one say nothing about the next vehicle's clock.
    fn reset_link(&mut self) {
        self.link.reset();
        self.rate.reset();
        self.helm.clock_is_off(false);
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

    /// Records what happened at this time.
    fn record(&mut self, now: Timestamp, act: impl Fn(&mut Recorder<Queue>) -> Result<(), RecorderError>) {
        self.recorder.record(now, act);
    }
}

//! The driver of a trial: core, vehicle, link and plugins in virtual time, everything that core puts out with its time,
//! and a judge that compares each sentence with what the vehicle has said.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_core::plugin::{
    Event, FaultKind, PluginFault, PluginId, Request, RequestState, Returned, StepInput, Topic,
};
use backseat_core::{
    Core, Grant, Identifiers, Input, Limits, Note, Operator, Order, Output, PluginSetup, RequestKind, Reservation,
    Restarted, Settings, Start, ToSonar,
};
use backseat_fence::Fence;
use backseat_spi::{FromVehicle, Sentence, ToVehicle};
use backseat_units::{Timestamp, Utc};

use crate::course;
use crate::judge::Judge;
use crate::vehicle::{Vehicle, name_of};

/// An output of core.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Seen {
    Sent(ToVehicle),
    /// Bytes to an external source.
    Told(usize, Vec<u8>),
    /// To the client of the sonars.
    Sonar(ToSonar),
    Note(Note),
    Connect(Duration),
    Reset,
    Invoke(usize, StepInput),
    Restart(usize),
    Reserve(Reservation),
    Finish,
}

/// A plugin's behavior in a step: how long it takes and what it returns.
pub(crate) type Script = Box<dyn FnMut(&StepInput) -> (Duration, Result<Vec<Request>, PluginFault>)>;

/// Changes bytes on their way.
pub(crate) type Way = Box<dyn FnMut(Vec<u8>) -> Vec<u8>>;

enum Answer {
    Returned(Returned),
    Restarted(Restarted),
}

struct Arrival {
    at: Timestamp,
    bytes: Vec<u8>,
    said: Vec<(FromVehicle, Option<Timestamp>)>,
}

pub(crate) struct Trial {
    pub(crate) core: Core,
    pub(crate) now: Timestamp,
    pub(crate) vehicle: Vehicle,
    pub(crate) seen: Vec<(Timestamp, Seen)>,
    /// What was written to the vehicle, as it was written.
    pub(crate) written: Vec<String>,
    /// The delay from the vehicle to core, and also the other way unless `delay_to_vehicle` is set.
    pub(crate) delay: Duration,
    /// The delay from core to the vehicle.
    pub(crate) delay_to_vehicle: Option<Duration>,
    /// The vehicle reads nothing: what is sent to it waits.
    pub(crate) deaf: bool,
    /// The vehicle's messages arrive no earlier than this.
    pub(crate) stalled_until: Timestamp,
    /// Core is not called earlier than this.
    pub(crate) asleep_until: Timestamp,
    /// The most bytes that one read returns.
    pub(crate) read_max: usize,
    /// Connections fail.
    pub(crate) unreachable: bool,
    pub(crate) restart_fails: Option<FaultKind>,
    /// Changes the bytes on their way to core.
    pub(crate) way: Option<Way>,
    to_core: VecDeque<Arrival>,
    to_vehicle: VecDeque<(Timestamp, Vec<u8>)>,
    connect_at: Option<Timestamp>,
    answers: Vec<(Timestamp, PluginId, Answer)>,
    scripts: Vec<Script>,
    asked: Vec<Vec<Request>>,
    faults: Vec<Option<FaultKind>>,
    judge: Judge,
    spins: u32,
}

pub(crate) struct Setup {
    /// A fence with the frame of [`course::fence`].
    pub(crate) fence: Fence,
    pub(crate) limits: Limits,
    pub(crate) settings: Settings,
    pub(crate) plugins: Vec<PluginSetup>,
    pub(crate) start: Start,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            fence: course::fence(),
            limits: course::limits(),
            settings: settings(),
            plugins: vec![course::plugin("first"), course::plugin("second")],
            start: Start {
                utc: Utc::from_unix_nanos(1_700_000_000_000_000_000),
                identifiers: Some(Identifiers {
                    next: 1,
                    reserved: 1,
                    first: 1,
                    ..Identifiers::default()
                }),
                armed: true,
                held: false,
                jitter: 7,
            },
        }
    }
}

/// The settings for a vehicle that reads a circle's entry angle.
pub(crate) fn settings() -> Settings {
    Settings {
        trackcircle_entry_angle: Some(true),
        ..Settings::default()
    }
}

impl Setup {
    /// The start after a process that used the identifiers 1 to 9, this many of them for inserts and GPS hits under the
    /// mission's caps.
    pub(crate) fn after(self, inserts: u32, gps_hits: u32) -> Self {
        let identifiers = Some(Identifiers {
            next: 10,
            reserved: 10,
            first: 1,
            inserts,
            gps_hits,
        });
        let start = Start {
            identifiers,
            ..self.start
        };
        Self { start, ..self }
    }
}

impl Trial {
    pub(crate) fn with(setup: Setup) -> Self {
        let count = setup.plugins.len();
        let judge = Judge::new(setup.settings.control.clone(), &setup.start, &setup.limits);
        let core = Core::new(
            setup.settings,
            course::envelope_of(setup.fence, setup.limits),
            setup.plugins,
            setup.start,
        );
        let idle = || -> Script { Box::new(|_| (Duration::from_millis(1), Ok(Vec::new()))) };
        let mut trial = Self {
            core,
            now: Timestamp::ZERO,
            vehicle: Vehicle::new(),
            seen: Vec::new(),
            written: Vec::new(),
            delay: Duration::from_millis(5),
            delay_to_vehicle: None,
            deaf: false,
            stalled_until: Timestamp::ZERO,
            asleep_until: Timestamp::ZERO,
            read_max: usize::MAX,
            unreachable: false,
            restart_fails: None,
            way: None,
            to_core: VecDeque::new(),
            to_vehicle: VecDeque::new(),
            connect_at: None,
            answers: Vec::new(),
            scripts: (0..count).map(|_| idle()).collect(),
            asked: vec![Vec::new(); count],
            faults: vec![None; count],
            judge,
            spins: 0,
        };
        trial.drain();
        trial
    }

    pub(crate) fn new() -> Self {
        Self::with(Setup::default())
    }

    /// Two seconds into a dive: connected, in control, the plan known.
    pub(crate) fn under_way() -> Self {
        Self::with_under_way(Setup::default())
    }

    pub(crate) fn with_under_way(setup: Setup) -> Self {
        let mut trial = Self::with(setup);
        trial.run_for(2.0);
        assert!(trial.core.has_control(), "{:#?}", trial.notes());
        trial
    }

    /// Like [`Trial::under_way`], and the first plugin steers under tag 1.
    pub(crate) fn steering() -> Self {
        let mut trial = Self::under_way();
        trial.ask(0, [Request::Modify(course::modify(1))]);
        trial.run_for(0.5);
        assert!(trial.core.is_steering(), "{:?}", trial.states(1));
        trial
    }

    /// A plugin's next step returns these.
    pub(crate) fn ask(&mut self, plugin: usize, requests: impl IntoIterator<Item = Request>) {
        self.asked[plugin].extend(requests);
    }

    /// A plugin's next step fails.
    pub(crate) fn fail(&mut self, plugin: usize, kind: FaultKind) {
        self.faults[plugin] = Some(kind);
    }

    pub(crate) fn script(
        &mut self,
        plugin: usize,
        script: impl FnMut(&StepInput) -> (Duration, Result<Vec<Request>, PluginFault>) + 'static,
    ) {
        self.scripts[plugin] = Box::new(script);
    }

    pub(crate) fn run_for(&mut self, seconds: f64) {
        let until = self.now + Duration::from_secs_f64(seconds);
        while self.step(until) {}
        self.now = until;
    }

    /// The link breaks, and everything on its way is lost.
    pub(crate) fn cut(&mut self) {
        self.to_core.clear();
        self.to_vehicle.clear();
        self.judge.up = false;
        // Core handles a late wake-up first: its BPEMB goes into a link that core does not yet know to be broken.
        self.feed(Input::LinkDown);
        self.judge.link(false);
    }

    pub(crate) fn operator(&mut self, act: Operator) {
        match act {
            Operator::Hold | Operator::Stop | Operator::Order(Order::Hold) => self.judge.held = true,
            Operator::Release | Operator::Order(Order::Release) => self.judge.held = false,
            Operator::Order(_) => {}
        }
        self.feed(Input::Operator(act));
    }

    /// The vehicle sends these messages now, and they arrive in one read.
    pub(crate) fn hear_now(&mut self, messages: impl IntoIterator<Item = FromVehicle>) {
        let mut arrival = Arrival {
            at: self.now,
            bytes: Vec::new(),
            said: Vec::new(),
        };
        for message in messages {
            message.encode(&mut arrival.bytes).unwrap();
            arrival.said.push((message, Some(self.now)));
        }
        self.arrive(arrival);
    }

    /// These bytes arrive, whatever they are.
    pub(crate) fn hear_bytes(&mut self, bytes: &[u8]) {
        self.arrive(Arrival {
            at: self.now,
            bytes: bytes.to_vec(),
            said: Vec::new(),
        });
    }

    fn step(&mut self, until: Timestamp) -> bool {
        let awake = |at: Timestamp| at.max(self.asleep_until);
        let answer = self.answers.iter().enumerate().min_by_key(|(_, (at, ..))| *at);
        let answer = answer.map(|(index, (at, ..))| (*at, index));
        let timeout = self.core.poll_timeout().map(awake);
        let due = [
            self.to_vehicle.front().filter(|_| !self.deaf).map(|(at, _)| *at),
            self.to_core.front().map(|arrival| awake(arrival.at)),
            answer.map(|(at, _)| awake(at)),
            self.connect_at.map(awake),
            Some(self.vehicle.next()),
            timeout,
        ];
        let first = due
            .into_iter()
            .enumerate()
            .filter_map(|(what, at)| Some((at?, what)))
            .min();
        let Some((at, what)) = first.filter(|(at, _)| *at <= until) else {
            return false;
        };
        if at > self.now {
            self.spins = 0;
        }
        self.spins += 1;
        assert!(self.spins < 2000, "time stands still at {}", self.now);
        self.now = self.now.max(at);
        match what {
            0 => {
                let (_, bytes) = self.to_vehicle.pop_front().unwrap();
                self.vehicle.hear(self.now, &bytes);
            }
            1 => {
                let arrival = self.to_core.pop_front().unwrap();
                self.arrive(arrival);
            }
            2 => {
                let (_, plugin, answer) = self.answers.remove(answer.unwrap().1);
                match answer {
                    Answer::Returned(returned) => self.feed(Input::Returned(plugin, returned)),
                    Answer::Restarted(restarted) => self.feed(Input::Restarted(plugin, restarted)),
                }
            }
            3 => self.connect(),
            4 => self.speak(),
            _ => {
                self.feed(Input::Timeout);
                let next = self.core.poll_timeout();
                assert!(
                    next.is_none_or(|next| next >= self.now),
                    "the next wake-up is in the past: {next:?}"
                );
            }
        }
        true
    }

    fn connect(&mut self) {
        self.connect_at = None;
        if self.unreachable {
            return self.feed(Input::LinkDown);
        }
        self.vehicle.connected(self.now);
        self.judge.link(true);
        self.feed(Input::LinkUp);
    }

    fn speak(&mut self) {
        let said = self.vehicle.speak(self.now);
        if !self.judge.up || said.is_empty() {
            return;
        }
        let last = self.to_core.back().map_or(Timestamp::ZERO, |arrival| arrival.at);
        let at = (self.now + self.delay).max(self.stalled_until).max(last);
        let mut arrival = Arrival {
            at,
            bytes: Vec::new(),
            said: Vec::new(),
        };
        for (message, solved) in said {
            message.encode(&mut arrival.bytes).unwrap();
            arrival.said.push((message, solved));
        }
        self.to_core.push_back(arrival);
    }

    fn arrive(&mut self, arrival: Arrival) {
        for (message, solved) in &arrival.said {
            self.judge.heard(self.now, message, *solved);
        }
        let bytes = match &mut self.way {
            Some(way) => way(arrival.bytes),
            None => arrival.bytes,
        };
        for read in bytes.chunks(self.read_max) {
            self.feed(Input::Received(read));
        }
        self.judge.settled(self.now);
    }

    pub(crate) fn feed(&mut self, input: Input<'_>) {
        self.core.handle(self.now, input);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(output) = self.core.poll_output() {
            let seen = match output {
                Output::Send(bytes) => {
                    let command =
                        ToVehicle::decode(&Sentence::parse(str::from_utf8(&bytes).unwrap()).unwrap()).unwrap();
                    assert!(bytes.ends_with(b"\r\n"), "{command:?}");
                    self.written.push(String::from_utf8(bytes.clone()).unwrap());
                    self.judge.sent(self.now, &command);
                    let delay = self.delay_to_vehicle.unwrap_or(self.delay);
                    let before = self.to_vehicle.back().map_or(Timestamp::ZERO, |(at, _)| *at);
                    self.to_vehicle.push_back((before.max(self.now + delay), bytes));
                    Seen::Sent(command)
                }
                Output::Connect { after } => {
                    self.connect_at = Some(self.now + after);
                    Seen::Connect(after)
                }
                Output::ResetLink => {
                    self.seen.push((self.now, Seen::Reset));
                    self.cut();
                    continue;
                }
                Output::Invoke(plugin, input) => {
                    self.invoke(plugin, &input);
                    Seen::Invoke(plugin.0, input)
                }
                Output::Restart(plugin) => {
                    let result = match self.restart_fails {
                        Some(kind) => Err(PluginFault {
                            kind,
                            text: "no".to_owned(),
                        }),
                        None => Ok(()),
                    };
                    let restarted = Restarted {
                        fuel: 0,
                        lost_steps: 3,
                        result,
                    };
                    self.answers.push((
                        self.now + Duration::from_millis(1),
                        plugin,
                        Answer::Restarted(restarted),
                    ));
                    Seen::Restart(plugin.0)
                }
                Output::Reserve(reservation) => {
                    self.seen.push((self.now, Seen::Reserve(reservation)));
                    self.judge.reserved = reservation.below;
                    self.feed(Input::Reserved(reservation));
                    continue;
                }
                Output::Sonar(order) => Seen::Sonar(order),
                Output::External(source, bytes) => Seen::Told(source.0, bytes),
                Output::Finish => Seen::Finish,
                Output::Note(note) => Seen::Note(note),
            };
            self.seen.push((self.now, seen));
        }
    }

    fn invoke(&mut self, plugin: PluginId, input: &StepInput) {
        let under_way = self.answers.iter().any(|(_, other, _)| *other == plugin);
        assert!(!under_way, "a step of plugin {} is under way already", plugin.0);
        let (after, mut result) = self.scripts[plugin.0](input);
        if let Ok(requests) = &mut result {
            requests.append(&mut self.asked[plugin.0]);
        }
        if let Some(kind) = self.faults[plugin.0].take() {
            result = Err(PluginFault {
                kind,
                text: "as told".to_owned(),
            });
        }
        let returned = Returned {
            fuel: 1,
            measures: Vec::new(),
            log: Vec::new(),
            result,
        };
        self.answers
            .push((self.now + after, plugin, Answer::Returned(returned)));
    }

    // What a test reads from the record.

    /// When the sentences of a name such as `RMB` were sent.
    pub(crate) fn sent(&self, name: &str) -> Vec<Timestamp> {
        self.commands(name).into_iter().map(|(at, _)| at).collect()
    }

    pub(crate) fn sent_since(&self, name: &str, since: Timestamp) -> Vec<Timestamp> {
        self.sent(name).into_iter().filter(|at| *at >= since).collect()
    }

    pub(crate) fn commands(&self, name: &str) -> Vec<(Timestamp, ToVehicle)> {
        let named = |seen: &(Timestamp, Seen)| match &seen.1 {
            Seen::Sent(command) if name_of(command).0 == name => Some((seen.0, command.clone())),
            _ => None,
        };
        self.seen.iter().filter_map(named).collect()
    }

    /// The three letters of each of our sentences since then.
    pub(crate) fn names_since(&self, since: Timestamp) -> Vec<&'static str> {
        let named = |seen: &(Timestamp, Seen)| match &seen.1 {
            Seen::Sent(command) if seen.0 >= since => Some(name_of(command).0),
            _ => None,
        };
        self.seen.iter().filter_map(named).collect()
    }

    /// The states of the requests under a tag, except cancels.
    pub(crate) fn states(&self, tag: u64) -> Vec<RequestState> {
        self.states_of(tag, |kind| kind != RequestKind::Cancel)
    }

    pub(crate) fn cancel_states(&self, tag: u64) -> Vec<RequestState> {
        self.states_of(tag, |kind| kind == RequestKind::Cancel)
    }

    fn states_of(&self, tag: u64, of: impl Fn(RequestKind) -> bool) -> Vec<RequestState> {
        let state = |(_, seen): &(Timestamp, Seen)| match seen {
            Seen::Note(Note::Request(transition)) if transition.tag == tag && of(transition.kind) => {
                Some(transition.state.clone())
            }
            _ => None,
        };
        self.seen.iter().filter_map(state).collect()
    }

    pub(crate) fn rejection(&self, tag: u64) -> String {
        match self.states(tag).last() {
            Some(RequestState::Rejected(refusal)) => refusal.to_string(),
            other => panic!("request {tag} was not rejected: {other:?}"),
        }
    }

    pub(crate) fn notes(&self) -> Vec<(Timestamp, Note)> {
        let note = |(at, seen): &(Timestamp, Seen)| match seen {
            Seen::Note(note) => Some((*at, note.clone())),
            _ => None,
        };
        self.seen.iter().filter_map(note).collect()
    }

    pub(crate) fn is_connected(&self) -> bool {
        self.judge.up
    }

    pub(crate) fn lease_ends(&self) -> Vec<(Timestamp, String)> {
        let end = |(at, note)| match note {
            Note::LeaseEnded { reason, .. } => Some((at, reason.to_string())),
            _ => None,
        };
        self.notes().into_iter().filter_map(end).collect()
    }

    pub(crate) fn steps(&self, plugin: usize) -> Vec<(Timestamp, StepInput)> {
        let step = |(at, seen): &(Timestamp, Seen)| match seen {
            Seen::Invoke(of, input) if *of == plugin => Some((*at, input.clone())),
            _ => None,
        };
        self.seen.iter().filter_map(step).collect()
    }

    pub(crate) fn events(&self, plugin: usize) -> Vec<Event> {
        self.steps(plugin)
            .into_iter()
            .flat_map(|(_, input)| input.events)
            .collect()
    }
}

/// A state without its text.
pub(crate) fn short(state: &RequestState) -> &'static str {
    match state {
        RequestState::Rejected(_) => "rejected",
        RequestState::Sent => "sent",
        RequestState::Pending => "pending",
        RequestState::Accepted => "accepted",
        RequestState::Failed(_) => "failed",
        RequestState::TimedOut => "timed out",
        RequestState::Unknown => "unknown",
        RequestState::Started => "started",
        RequestState::Ended(_) => "ended",
        RequestState::Cancelled => "cancelled",
    }
}

pub(crate) fn shorts(states: &[RequestState]) -> Vec<&'static str> {
    states.iter().map(short).collect()
}

/// The usual setup, but the plugins have these grants and topics too.
pub(crate) fn granted(grants: &[Grant], topics: &[Topic]) -> Setup {
    let mut setup = Setup::default();
    for plugin in &mut setup.plugins {
        plugin.grants.extend(grants);
        plugin.description.topics.extend(topics);
    }
    setup
}

/// The fields of the last line of this name that was written, without its time of day. Checks what every line must
/// have: a time with three decimals, a checksum of two upper-case digits, CRLF.
pub(crate) fn last_written(trial: &Trial, name: &str) -> Vec<String> {
    let start = format!("${name},");
    let line = trial.written.iter().rfind(|line| line.starts_with(&start)).unwrap();
    let (body, sum) = line.strip_suffix("\r\n").unwrap().split_once('*').unwrap();
    let expected = body.bytes().skip(1).fold(0, |sum, byte| sum ^ byte);
    assert_eq!(sum, format!("{expected:02X}"), "{line}");
    let mut fields: Vec<String> = body.split(',').skip(1).map(str::to_owned).collect();
    let time = fields.remove(0);
    assert!(
        time.len() == 10 && time.bytes().enumerate().all(|(at, byte)| (at == 6) == (byte == b'.')),
        "{line}"
    );
    fields
}

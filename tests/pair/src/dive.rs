use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use backseat_core::plugin::{Event, PluginId, Request, RequestState, Returned, StepInput};
use backseat_core::{
    Core, Envelope, Grant, Identifiers, Input, Limits, Note, Operator, Output, Owner, PluginSetup, RequestKind,
    Restarted, Settings, Start,
};
use backseat_fence::Fence;
use backseat_mvc::{ClientId, Mvc, MvcEvent, WorldFile};
use backseat_units::Timestamp;

use crate::course;

/// The time that a byte takes from one side to the other.
const DELAY: Duration = Duration::from_millis(5);
/// The time that a step of the plugin takes.
const STEP: Duration = Duration::from_millis(1);

/// The settings of a dive.
pub struct Setup {
    /// Sections of `world.toml` that are appended to the course's own.
    pub world: String,
    /// A whole `world.toml` that replaces the course's own.
    pub other_world: Option<String>,
    /// Replacements in the course's own sections.
    pub replaced: Vec<(&'static str, &'static str)>,
    /// The mission's limits.
    pub limits: Limits,
    /// The mission's settings.
    pub settings: Settings,
    /// The plugin.
    pub plugin: PluginSetup,
    /// The mission's fence, as GeoJSON, instead of the course's own.
    pub fence: Option<String>,
    /// The seed of the world.
    pub seed: u64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            world: String::new(),
            other_world: None,
            replaced: Vec::new(),
            limits: course::limits(),
            settings: Settings {
                trackcircle_entry_angle: Some(true),
                ..Settings::default()
            },
            plugin: course::course_plugin(&[Grant::Modify, Grant::Insert, Grant::Interrupt, Grant::Message], &[]),
            fence: None,
            seed: 1,
        }
    }
}

enum Answer {
    Returned(Returned),
    Restarted(Restarted),
}

/// A dive of both sides; the crate's documentation explains it.
pub struct Dive {
    /// The runtime's side.
    pub core: Core,
    /// The vehicle's side.
    pub mvc: Mvc,
    /// The time of both.
    pub now: Timestamp,
    /// The notes of core.
    pub notes: Vec<(Timestamp, Note)>,
    /// The plugin's inputs.
    pub events: Vec<Event>,
    /// The vehicle's log.
    pub log: Vec<MvcEvent>,
    /// The sentences of core, with their times.
    pub sent: Vec<(Timestamp, String)>,
    /// Whether connections fail.
    pub unreachable: bool,
    /// The time that a byte takes from core to the vehicle, and from the vehicle to core. Bytes arrive in their order.
    pub delay: [Duration; 2],
    /// Sentences of core that begin with one of these are lost on the way.
    pub lost: Vec<&'static str>,
    /// Sentences of the vehicle that begin with one of these are lost on the way.
    pub unheard: Vec<&'static str>,
    client: ClientId,
    connected: bool,
    connect_at: Option<Timestamp>,
    to_core: VecDeque<(Timestamp, Vec<u8>)>,
    to_vehicle: VecDeque<(Timestamp, Vec<u8>)>,
    answers: VecDeque<(Timestamp, PluginId, Answer)>,
    asked: Vec<Request>,
    envelope: Arc<Envelope>,
    settings: Settings,
    plugin: PluginSetup,
}

impl Dive {
    /// Both sides at their start, not connected.
    ///
    /// # Panics
    ///
    /// If the setup's world is invalid, because it is the test's own.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut text = setup.other_world.unwrap_or_else(|| course::world(&setup.world));
        for (from, to) in &setup.replaced {
            assert!(text.contains(from), "{from} is not in the world");
            text = text.replace(from, to);
        }
        let file = WorldFile::from_toml(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mvc = Mvc::new(&file, setup.seed).expect("the test's world is possible");
        setup.limits.validate().expect("the test's limits are right");
        let start = Start {
            utc: mvc.utc(Timestamp::ZERO),
            identifiers: Some(Identifiers {
                next: 1,
                reserved: 1,
                first: 1,
                ..Identifiers::default()
            }),
            armed: true,
            held: false,
            jitter: setup.seed,
        };
        let fence = setup.fence.map_or_else(course::fence, |text| {
            Fence::from_geojson(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
        });
        let envelope = Arc::new(Envelope::new(fence, setup.limits));
        let core = Core::new(
            setup.settings.clone(),
            Arc::clone(&envelope),
            vec![setup.plugin.clone()],
            start,
        );
        let mut dive = Self {
            core,
            mvc,
            now: Timestamp::ZERO,
            notes: Vec::new(),
            events: Vec::new(),
            log: Vec::new(),
            sent: Vec::new(),
            unreachable: false,
            delay: [DELAY; 2],
            lost: Vec::new(),
            unheard: Vec::new(),
            client: ClientId(0),
            connected: false,
            connect_at: None,
            to_core: VecDeque::new(),
            to_vehicle: VecDeque::new(),
            answers: VecDeque::new(),
            asked: Vec::new(),
            envelope,
            settings: setup.settings,
            plugin: setup.plugin,
        };
        dive.drain();
        dive
    }

    /// A dive some seconds into the mission: connected, with control, and with a known plan.
    ///
    /// # Panics
    ///
    /// If the runtime does not get control.
    #[must_use]
    pub fn under_way(setup: Setup) -> Self {
        let mut dive = Self::new(setup);
        dive.run_for(6.0);
        assert!(dive.core.has_control(), "{:#?}", dive.notes);
        dive
    }

    /// Adds a request to what the plugin's next step returns.
    pub fn ask(&mut self, request: Request) {
        self.asked.push(request);
    }

    /// Lets the operator act.
    pub fn operator(&mut self, act: Operator) {
        self.feed(Input::Operator(act));
    }

    /// Advances the time.
    pub fn run_for(&mut self, seconds: f64) {
        let until = self.now + Duration::from_secs_f64(seconds);
        while self.step(until) {}
        self.now = until;
    }

    /// Advances the time until a condition is true. Returns false if it is not within this many seconds.
    pub fn run_until(&mut self, seconds: f64, holds: impl Fn(&Self) -> bool) -> bool {
        let until = self.now + Duration::from_secs_f64(seconds);
        while !holds(self) {
            if !self.step(until) {
                return false;
            }
        }
        true
    }

    /// Cuts the connection, and loses everything in transit.
    pub fn cut(&mut self) {
        self.to_core.clear();
        self.to_vehicle.clear();
        if core::mem::take(&mut self.connected) {
            self.mvc.disconnect(self.now, self.client);
            self.feed(Input::LinkDown);
        }
    }

    /// Kills the process. Another one replaces it, and knows that this many inserts were sent.
    pub fn kill(&mut self, sent: u32) {
        self.cut();
        let start = Start {
            utc: self.mvc.utc(self.now),
            identifiers: Some(Identifiers {
                next: 1 + sent,
                reserved: 1 + sent,
                first: 1,
                inserts: sent,
                ..Identifiers::default()
            }),
            armed: true,
            held: false,
            jitter: 1,
        };
        let plugins = vec![self.plugin.clone()];
        self.core = Core::new(self.settings.clone(), Arc::clone(&self.envelope), plugins, start);
        (self.asked, self.events, self.notes) = (Vec::new(), Vec::new(), Vec::new());
        self.answers.clear();
        self.drain();
    }

    /// The states of the plugin's request with this tag, without texts; those of cancels are left out.
    #[must_use]
    pub fn states(&self, tag: u64) -> Vec<&'static str> {
        let state = |(_, note): &(Timestamp, Note)| {
            let Note::Request(transition) = note else { return None };
            let of_plugin = matches!(transition.owner, Owner::Plugin(_)) && transition.kind != RequestKind::Cancel;
            (of_plugin && transition.tag == tag).then(|| name(&transition.state))
        };
        self.notes.iter().filter_map(state).collect()
    }

    /// The number of sentences of core that begin with this.
    #[must_use]
    pub fn count(&self, begin: &str) -> usize {
        self.sent.iter().filter(|(_, line)| line.starts_with(begin)).count()
    }

    fn step(&mut self, until: Timestamp) -> bool {
        let due = [
            self.to_vehicle.front().map(|(at, _)| *at),
            self.mvc.poll_timeout(),
            self.to_core.front().map(|(at, _)| *at),
            self.answers.front().map(|(at, ..)| *at),
            self.connect_at,
            self.core.poll_timeout(),
        ];
        let first = due
            .into_iter()
            .enumerate()
            .filter_map(|(what, at)| Some((at?, what)))
            .min();
        let Some((at, what)) = first.filter(|(at, _)| *at <= until) else {
            return false;
        };
        self.now = self.now.max(at);
        match what {
            0 => {
                if let Some((_, bytes)) = self.to_vehicle.pop_front() {
                    self.mvc.receive(self.now, self.client, &bytes);
                    self.listen();
                }
            }
            1 => {
                self.mvc.handle_timeout(self.now);
                self.listen();
            }
            2 => {
                if let Some((_, bytes)) = self.to_core.pop_front() {
                    self.feed(Input::Received(&bytes));
                }
            }
            3 => match self.answers.pop_front() {
                Some((_, plugin, Answer::Returned(returned))) => self.feed(Input::Returned(plugin, returned)),
                Some((_, plugin, Answer::Restarted(restarted))) => self.feed(Input::Restarted(plugin, restarted)),
                None => {}
            },
            4 => self.connect(),
            _ => self.feed(Input::Timeout),
        }
        true
    }

    fn connect(&mut self) {
        self.connect_at = None;
        if self.unreachable {
            self.feed(Input::LinkDown);
            return;
        }
        self.client = ClientId(self.client.0 + 1);
        self.connected = true;
        self.mvc.connect(self.now, self.client);
        self.feed(Input::LinkUp);
        self.listen();
    }

    /// Takes the vehicle's output.
    fn listen(&mut self) {
        let mut bytes = Vec::new();
        while let Some(client) = self.mvc.poll_transmit(&mut bytes) {
            if self.connected && client == self.client {
                let at = after(&self.to_core, self.now + self.delay[1]);
                let lost = |line: &&[u8]| self.unheard.iter().any(|begin| line.starts_with(begin.as_bytes()));
                let heard = bytes.split_inclusive(|byte| *byte == b'\n').filter(|line| !lost(line));
                self.to_core.push_back((at, heard.flatten().copied().collect()));
            }
        }
        while let Some(event) = self.mvc.poll_event() {
            self.log.push(event);
        }
        while let Some(client) = self.mvc.poll_disconnect() {
            if client == self.client {
                self.cut();
            }
        }
    }

    fn feed(&mut self, input: Input<'_>) {
        self.core.handle(self.now, input);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(output) = self.core.poll_output() {
            match output {
                Output::Send(bytes) => {
                    let line = String::from_utf8_lossy(&bytes).trim_end().to_owned();
                    let lost = self.lost.iter().any(|begin| line.starts_with(begin));
                    self.sent.push((self.now, line));
                    if !lost {
                        let at = after(&self.to_vehicle, self.now + self.delay[0]);
                        self.to_vehicle.push_back((at, bytes));
                    }
                }
                Output::Connect { after } => self.connect_at = Some(self.now + after),
                Output::ResetLink => self.cut(),
                Output::Invoke(plugin, input) => self.invoke(plugin, input),
                Output::Restart(plugin) => {
                    let restarted = Restarted {
                        fuel: 0,
                        lost_steps: 0,
                        result: Ok(()),
                    };
                    self.answers
                        .push_back((self.now + STEP, plugin, Answer::Restarted(restarted)));
                }
                Output::Reserve(reservation) => self.feed(Input::Reserved(reservation)),
                Output::External(..) | Output::Sonar(_) | Output::Finish => {}
                Output::Note(note) => self.notes.push((self.now, note)),
            }
        }
    }

    fn invoke(&mut self, plugin: PluginId, input: StepInput) {
        self.events.extend(input.events);
        let returned = Returned {
            fuel: 1,
            log: Vec::new(),
            measures: Vec::new(),
            result: Ok(core::mem::take(&mut self.asked)),
        };
        self.answers
            .push_back((self.now + STEP, plugin, Answer::Returned(returned)));
    }
}

/// When bytes that are due at a time arrive: not before those that are already in transit.
fn after(under_way: &VecDeque<(Timestamp, Vec<u8>)>, due: Timestamp) -> Timestamp {
    under_way.back().map_or(due, |(at, _)| due.max(*at))
}

/// A state without its text.
const fn name(state: &RequestState) -> &'static str {
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

//! Core, the model vehicle, the link between them, the plugin and the judge, in virtual time: a state that is copied.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use backseat_core::plugin::{FaultKind, PluginFault, PluginId, RequestState, Returned};
use backseat_core::{Core, Input, Note, Operator, Output, Restarted};
use backseat_units::Timestamp;
use serde::Serialize;

use crate::course;
use crate::fingerprint::{Fingerprint, anatomy, fingerprint};
use crate::front::{Answers, Fixes, Front, Place};
use crate::judge::{Broken, Judge};
use crate::kind::Kind;
use crate::wire::Line;

/// What each kind takes.
const SECOND: Duration = Duration::from_secs(1);
/// What a step of the plugin takes, and a restart.
const STEP: Duration = Duration::from_millis(10);
/// How much later core is called than it wished.
const LATE: Duration = Duration::from_millis(600);
/// So many inputs may come to core at one time, and so many outputs of one.
const AT_ONCE_MAX: u32 = 64;

/// What core may say, as far as it is counted: nothing is shown by sequences in which it says nothing.
pub const SENTENCES: [&str; 9] = [
    "BPRMB", "BPEMB", "BPRTK", "BPRCN", "BPRMP", "BPSUS", "BPCON", "BPRES", "BPVER",
];

/// What the plugin is to ask for in its next step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Ask {
    Modify,
    End,
    Insert,
    Interrupt,
    Outside,
    Cancel,
    Station,
}

/// What the plugin's host is about to answer.
#[derive(Clone, Copy, Debug, Serialize)]
enum Answer {
    Step { ask: Option<Ask>, fails: bool },
    Restarted,
}

/// A fault that a test plants, to see that it is found without any check of core's left out: core is not told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planted {
    /// BFCTL does not reach core.
    ControlUntold,
    /// The operator's hold does not reach core.
    HoldUntold,
}

/// A state of everything.
#[derive(Clone, Serialize)]
pub struct World {
    pub(crate) core: Core,
    #[serde(skip)]
    pub(crate) now: Timestamp,
    pub(crate) front: Front,
    judge: Judge,
    reachable: bool,
    connect_at: Option<Timestamp>,
    ask: Option<Ask>,
    fails: bool,
    /// How many inserts it has asked for, and the tag of the newest that does not interrupt: at first one that nothing has.
    tags: u64,
    newest: u64,
    answer: Option<(Timestamp, Answer)>,
    /// Core is not called before.
    asleep_until: Timestamp,
    /// When the plugin was called last.
    #[serde(skip)]
    pub(crate) invoked: Timestamp,
    #[serde(skip)]
    at_once: u32,
    /// A bit for each of [`SENTENCES`] that has left in the last step.
    #[serde(skip)]
    said: u16,
    #[serde(skip)]
    planted: Option<Planted>,
    /// What happens, in lines, where somebody wants to read it.
    #[serde(skip)]
    trace: Option<Vec<String>>,
}

impl World {
    pub(crate) fn new(hovers: bool) -> Self {
        let mut world = Self {
            core: core(hovers, 0),
            now: Timestamp::ZERO,
            front: Front::new(hovers),
            judge: Judge::new(1),
            reachable: true,
            connect_at: None,
            ask: None,
            fails: false,
            tags: 0,
            newest: u64::MAX,
            answer: None,
            asleep_until: Timestamp::ZERO,
            invoked: Timestamp::ZERO,
            at_once: 0,
            said: 0,
            planted: None,
            trace: None,
        };
        world.drain();
        world
    }

    /// The process is killed, and another follows it at once, which knows from disk that so many inserts were sent.
    pub(crate) fn kill(&mut self, inserts: u32) {
        self.front.disconnects();
        let now = self.now;
        self.core = core(self.front.hovers, inserts);
        self.judge = Judge::new(1 + inserts);
        (self.ask, self.fails, self.answer, self.connect_at) = (None, false, None, None);
        self.now = now;
        self.drain();
    }

    /// Plants a fault.
    pub const fn plant(&mut self, fault: Planted) {
        self.planted = Some(fault);
    }

    /// Has what happens from now on written down.
    pub fn watch(&mut self) {
        self.trace = Some(Vec::new());
    }

    /// What has been written down since [`World::watch`].
    #[must_use]
    pub fn trace(&self) -> &[String] {
        self.trace.as_deref().unwrap_or_default()
    }

    /// The vehicle hovers.
    #[must_use]
    pub const fn hovers(&self) -> bool {
        self.front.hovers
    }

    /// What tells this state from others.
    #[must_use]
    pub fn fingerprint(&self) -> Fingerprint {
        let utc = course::UTC + Duration::from_nanos(self.now.as_nanos());
        fingerprint(self, self.now, utc)
    }

    /// What the fingerprint is made of: which of [`RULES`](crate::RULES) were met, and each word with its field.
    #[must_use]
    pub fn anatomy(&self) -> (Vec<bool>, Vec<String>) {
        let utc = course::UTC + Duration::from_nanos(self.now.as_nanos());
        anatomy(self, self.now, utc)
    }

    /// Core's own words for the requests that are open, and whether it steers and has control.
    #[must_use]
    pub fn describe(&self) -> String {
        format!(
            "control {}, steers {}, open {:?}",
            self.core.has_control(),
            self.core.is_steering(),
            self.core.open_request_states()
        )
    }

    /// Which of [`SENTENCES`] have left in the last step.
    #[must_use]
    pub fn said(&self) -> [bool; SENTENCES.len()] {
        std::array::from_fn(|index| self.said & 1 << index != 0)
    }

    /// Something happens, and the time that it takes goes by.
    ///
    /// # Errors
    /// Where a safety requirement is broken, a panic included.
    pub fn step(&mut self, kind: Kind) -> Result<(), Broken> {
        self.said = 0;
        let stepped = catch_unwind(AssertUnwindSafe(|| {
            self.happens(kind);
        }));
        if let Err(panic) = stepped {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            return Err(Broken {
                rule: "SR-013 panic",
                text: text.unwrap_or_default(),
            });
        }
        self.judge.broken.take().map_or(Ok(()), Err)
    }

    fn happens(&mut self, kind: Kind) {
        if self.trace.is_some() {
            self.note(|| format!("-- {}", kind.name()));
        }
        let until = self.now + if kind == Kind::WaitTen { 10 * SECOND } else { SECOND };
        let now = self.now;
        match kind {
            Kind::Wait | Kind::WaitTen => {}
            Kind::ControlGiven => self.front.set_control(now, true),
            Kind::ControlTaken => self.front.set_control(now, false),
            Kind::MissionRuns => self.front.set_running(now, true),
            Kind::MissionAborts => self.front.set_running(now, false),
            Kind::NavigationGood => self.front.fixes = Fixes::Good,
            Kind::NavigationStale if !matches!(self.front.fixes, Fixes::Stale(_)) => {
                self.front.fixes = Fixes::Stale(now);
            }
            Kind::NavigationStale => {}
            Kind::NavigationMissing => self.front.fixes = Fixes::Missing,
            Kind::NavigationJumps => {
                self.front.place = match self.front.place {
                    Place::Line => Place::Aside,
                    Place::Aside | Place::Outside => Place::Line,
                }
            }
            Kind::NavigationOutside => self.front.place = Place::Outside,
            Kind::AnswersGood => self.front.answers = Answers::Good,
            Kind::AnswersBad => self.front.answers = Answers::Bad,
            Kind::AnswersPending => self.front.answers = Answers::Pending,
            Kind::AnswersMissing => self.front.answers = Answers::Missing,
            Kind::Deaf => self.front.answers = Answers::Deaf,
            Kind::LinkDown => {
                self.reachable = false;
                if self.front.connected {
                    self.cut();
                }
            }
            Kind::LinkUp => self.reachable = true,
            Kind::AsksModify => self.ask = Some(Ask::Modify),
            Kind::AsksEnd => self.ask = Some(Ask::End),
            Kind::AsksInsert => self.ask = Some(Ask::Insert),
            Kind::AsksInterrupt => self.ask = Some(Ask::Interrupt),
            Kind::AsksOutside => self.ask = Some(Ask::Outside),
            Kind::AsksCancel => self.ask = Some(Ask::Cancel),
            Kind::AsksStation => self.ask = Some(Ask::Station),
            Kind::PluginFails => self.fails = true,
            Kind::WakesLate => {
                if let Some(wish) = self.core.poll_timeout() {
                    self.asleep_until = wish.max(now) + LATE;
                }
            }
            Kind::Hold => self.operator(Operator::Hold),
            Kind::Release => self.operator(Operator::Release),
            Kind::BehaviorEnds => self.front.behavior_ends(now),
            Kind::OtherDive => self.front.flies_another_dive(now),
        }
        self.run_until(until.max(self.now));
    }

    fn operator(&mut self, act: Operator) {
        self.awake();
        self.judge.holds(self.now, act == Operator::Hold);
        if self.planted == Some(Planted::HoldUntold) && act == Operator::Hold {
            return self.judge.settled(self.now, false, self.judge.leases());
        }
        self.feed(Input::Operator(act));
    }

    /// Nobody tells core anything while it sleeps.
    fn awake(&mut self) {
        if self.asleep_until > self.now {
            self.run_until(self.asleep_until);
        }
    }

    fn cut(&mut self) {
        self.awake();
        self.front.disconnects();
        self.note(|| "   the connection is lost".to_owned());
        // What core says before it knows goes nowhere, and is judged by what it knows.
        self.feed(Input::LinkDown);
    }

    pub(crate) fn run_until(&mut self, until: Timestamp) {
        while self.judge.broken.is_none() && self.runs(until) {}
        self.now = self.now.max(until);
    }

    fn runs(&mut self, until: Timestamp) -> bool {
        let awake = |at: Timestamp| at.max(self.asleep_until);
        let due = [
            Some(awake(self.front.next())),
            self.answer.map(|(at, _)| awake(at)),
            self.connect_at.map(awake),
            self.core.poll_timeout().map(awake),
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
            self.at_once = 0;
        }
        self.at_once += 1;
        if self.at_once > AT_ONCE_MAX {
            let text = format!("{AT_ONCE_MAX} inputs, and time stands still");
            self.judge.stop("SR-022 spin", text);
            return false;
        }
        self.now = self.now.max(at);
        match what {
            0 => self.arrives(),
            1 => self.answers(),
            2 => self.connects(),
            _ => {
                self.feed(Input::Timeout);
                if let Some(wish) = self.core.poll_timeout().filter(|wish| *wish < self.now) {
                    let text = format!("core wishes to be called at {wish}, which is over");
                    self.judge.stop("SR-022 spin", text);
                }
            }
        }
        true
    }

    fn arrives(&mut self) {
        let lines = self.front.arrives(self.now);
        if lines.is_empty() {
            return;
        }
        let solved = match self.front.fixes {
            Fixes::Stale(since) => since,
            Fixes::Good | Fixes::Missing => self.front.solved(),
        };
        let mut bytes = String::new();
        for text in &lines {
            self.note(|| format!("   < {}", text.trim_end()));
            if let Some(line) = Line::parse(text) {
                self.judge.heard(self.now, &line, solved);
            }
            if self.planted != Some(Planted::ControlUntold) || !text.starts_with("$BFCTL") {
                bytes.push_str(text);
            }
        }
        self.feed(Input::Received(bytes.as_bytes()));
    }

    fn answers(&mut self) {
        let Some((_, answer)) = self.answer.take() else { return };
        match answer {
            Answer::Step { ask, fails } => {
                let result = if fails {
                    self.judge.plugin_fails();
                    Err(fault())
                } else {
                    if let Some(ask) = ask {
                        self.note(|| format!("   the plugin asks: {ask:?}"));
                        self.judge.asks(self.now, ask);
                    }
                    let tag = ask.map_or(0, |ask| self.tag(ask));
                    Ok(ask.map(|ask| course::request(ask, tag)).into_iter().collect())
                };
                let returned = Returned {
                    fuel: 0,
                    measures: Vec::new(),
                    log: Vec::new(),
                    result,
                };
                self.feed(Input::Returned(PluginId(0), returned));
            }
            Answer::Restarted => {
                let restarted = Restarted {
                    fuel: 0,
                    lost_steps: 0,
                    result: Ok(()),
                };
                self.feed(Input::Restarted(PluginId(0), restarted));
            }
        }
    }

    /// Each insert has a tag of its own.
    fn tag(&mut self, ask: Ask) -> u64 {
        match ask {
            Ask::Insert | Ask::Interrupt | Ask::Outside => {
                self.tags += 1;
                if ask == Ask::Insert {
                    self.newest = self.tags;
                }
                self.tags
            }
            Ask::Cancel => self.newest,
            Ask::Modify | Ask::End | Ask::Station => 0,
        }
    }

    fn connects(&mut self) {
        self.connect_at = None;
        if self.reachable {
            self.front.connects(self.now);
            self.judge.link(true);
            self.note(|| "   the connection is made".to_owned());
            self.feed(Input::LinkUp);
        } else {
            self.feed(Input::LinkDown);
        }
    }

    fn feed(&mut self, input: Input<'_>) {
        let late = self
            .core
            .poll_timeout()
            .is_some_and(|wish| self.now.since(wish) > LATE - STEP * 5);
        let before = self.judge.leases();
        let is_down = input == Input::LinkDown;
        self.core.handle(self.now, input);
        self.drain();
        if is_down {
            self.judge.link(false);
        }
        self.judge.settled(self.now, late, before);
    }

    fn drain(&mut self) {
        let mut count = 0;
        while let Some(output) = self.core.poll_output() {
            count += 1;
            match output {
                Output::Send(bytes) => self.sends(&bytes),
                // To a whole second: what jitter adds makes no other state.
                Output::Connect { after } => {
                    let seconds = after.as_secs() + u64::from(after.subsec_nanos() > 0);
                    self.connect_at = Some(self.now + Duration::from_secs(seconds));
                }
                Output::ResetLink => self.cut(),
                Output::Invoke(_, _) => {
                    self.invoked = self.now;
                    let ask = self.ask.take();
                    let fails = std::mem::take(&mut self.fails);
                    self.answer = Some((self.now + STEP, Answer::Step { ask, fails }));
                }
                Output::Restart(_) => self.answer = Some((self.now + STEP, Answer::Restarted)),
                Output::Reserve(reservation) => {
                    self.judge.reserved(reservation.below);
                    self.feed(Input::Reserved(reservation));
                }
                Output::Note(note) => self.hears_note(&note),
                Output::External(_, _) | Output::Sonar(_) | Output::Finish => {}
            }
        }
        if count > AT_ONCE_MAX {
            self.judge
                .stop("SR-013 outputs", format!("{count} outputs of one input"));
        }
    }

    fn sends(&mut self, bytes: &[u8]) {
        let text = String::from_utf8_lossy(bytes);
        self.note(|| format!("   > {}", text.trim_end()));
        let Some(line) = Line::parse(&text) else {
            return self.judge.stop("SR-013 words", format!("{text:?} is no sentence"));
        };
        if let Some(index) = SENTENCES.iter().position(|name| *name == line.name) {
            self.said |= 1 << index;
        }
        self.judge.sent(self.now, &line);
        if self.front.connected {
            self.front.hears(self.now, &line);
        }
    }

    fn hears_note(&mut self, note: &Note) {
        self.note(|| format!("   # {note}"));
        if let Note::Request(transition) = note
            && matches!(transition.state, RequestState::Rejected(_))
        {
            self.judge.refused(transition.kind);
        }
        if let Note::Request(transition) = note
            && matches!(
                transition.state,
                RequestState::Rejected(_)
                    | RequestState::Failed(_)
                    | RequestState::TimedOut
                    | RequestState::Ended(_)
                    | RequestState::Cancelled
            )
        {
            self.judge.ends(transition.request);
        }
    }

    fn note(&mut self, line: impl FnOnce() -> String) {
        if let Some(trace) = &mut self.trace {
            trace.push(format!("{:9.3} {}", self.now.as_secs_f64(), line()));
        }
    }
}

fn core(hovers: bool, inserts_before: u32) -> Core {
    Core::new(
        course::settings(),
        course::envelope(hovers),
        vec![course::plugin(hovers)],
        course::start(inserts_before),
    )
}

fn fault() -> PluginFault {
    PluginFault {
        kind: FaultKind::Trap,
        text: "as told".to_owned(),
    }
}

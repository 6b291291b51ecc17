//! Holds each sentence of core's against what the vehicle has said, the plugin asked and the operator did. It reads the
//! wire by itself, knows nothing of core's decisions, and asks core nothing.

mod sent;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

use backseat_core::RequestKind;
use backseat_units::Timestamp;
use serde::Serialize;

use crate::course;
use crate::wire::Line;
use crate::world::Ask;

/// What no BPRMB may come later than, and no BPCON.
const MODIFY_GAP: Duration = Duration::from_millis(2500);
const STATION_GAP: Duration = Duration::from_secs(1);
/// What core may take for what it must do at once.
const PROMPT: Duration = Duration::from_millis(100);
/// How long navigation must have been steady after a jump.
const STEADY: Duration = Duration::from_secs(10);
/// What became of a command (SPI 6.21).
const SUCCEEDED: &str = "2";
const PENDING: &str = "3";
/// A step of navigation that no vehicle can make, degrees.
const JUMP_DEG: f64 = 0.001;

/// A safety requirement that was broken, and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// Which, and what of it: `SR-001 control`.
    pub rule: &'static str,
    /// In a line.
    pub text: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.rule, self.text)
    }
}

/// How far one of our inserts is, as the wire tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
enum Stage {
    /// Nothing was answered.
    Sent,
    /// It is worked on, or was accepted.
    Answered,
    /// It was sent on a connection that was lost before an answer.
    Doubtful,
    /// It has begun.
    Flown,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Insert {
    interrupts: bool,
    stage: Stage,
    /// A BPRCN has left for it. Where the vehicle refuses that, core sends it again in its own time.
    taken_back: bool,
}

/// A command that no answer has come for.
#[derive(Clone, Debug, Serialize)]
struct Unanswered {
    command: String,
    /// Its time as it was written; empty where it has none.
    #[serde(skip)]
    created: String,
    sent: Timestamp,
}

#[derive(Clone, Default, Serialize)]
pub(crate) struct Judge {
    #[serde(skip)]
    pub(crate) broken: Option<Broken>,
    up: bool,
    held: bool,
    control: Option<bool>,
    running: Option<bool>,
    /// When the newest navigation was computed.
    solved: Option<Timestamp>,
    /// The same, whatever has become of the connection.
    solution: Option<Timestamp>,
    /// Where that was, latitude and longitude in degrees.
    place: Option<[f64; 2]>,
    moved: Option<Timestamp>,
    /// When the last BPRMB left that no BPEMB has ended.
    modified: Option<Timestamp>,
    last_modify: Option<Timestamp>,
    /// When the newest modify that the plugin has asked for must be over.
    term: Option<Timestamp>,
    suspended: Option<Timestamp>,
    station_term: Option<Timestamp>,
    reserved: u32,
    used: BTreeSet<u32>,
    /// How many more inserts may leave: as many as the plugin has asked for.
    asked: u32,
    inserts: BTreeMap<u32, Insert>,
    /// Our inserts that the hold is to take back, and since when.
    to_cancel: BTreeMap<u32, Timestamp>,
    /// A behavior has begun or ended, or the plugin has failed, and core has not handled it yet.
    #[serde(skip)]
    ends_lease: Option<&'static str>,
    /// The vehicle's plan has come whole, for the dive that it flies, on this connection.
    planned: bool,
    /// Our inserts that it has had so far.
    listed: BTreeSet<u32>,
    /// The dive file as BFMIS and as BFMBS have named it last.
    dive: [Option<String>; 2],
    unanswered: Vec<Unanswered>,
    /// When the command left whose answer came in time, the newest.
    answered: Option<Timestamp>,
    ended: BTreeSet<u64>,
}

impl Judge {
    pub(crate) fn new(reserved: u32) -> Self {
        Self {
            reserved,
            ..Self::default()
        }
    }

    fn broke(&mut self, rule: &'static str, text: impl Into<String>) {
        if self.broken.is_none() {
            self.broken = Some(Broken {
                rule,
                text: text.into(),
            });
        }
    }

    fn expect(&mut self, holds: bool, rule: &'static str, text: impl FnOnce() -> String) {
        if !holds {
            self.broke(rule, text());
        }
    }

    pub(crate) fn stop(&mut self, rule: &'static str, text: String) {
        self.broke(rule, text);
    }

    fn has_control(&self) -> bool {
        self.up && !self.held && self.control == Some(true) && self.running == Some(true)
    }

    /// The operator holds, or releases.
    pub(crate) fn holds(&mut self, now: Timestamp, held: bool) {
        if held && !self.held && self.up {
            let waits = |insert: &Insert| insert.stage == Stage::Answered && !insert.taken_back;
            let waiting = self.inserts.iter().filter(|(_, insert)| waits(insert));
            self.to_cancel = waiting.map(|(identifier, _)| (*identifier, now)).collect();
        }
        if !held {
            self.to_cancel.clear();
        }
        self.held = held;
    }

    /// A plugin's step has returned this.
    pub(crate) fn asks(&mut self, now: Timestamp, ask: Ask) {
        match ask {
            Ask::Modify => self.term = Some(now + course::TERM),
            Ask::Station => self.station_term = Some(now + course::TERM),
            Ask::Insert | Ask::Interrupt | Ask::Outside => self.asked += 1,
            Ask::End | Ask::Cancel => {}
        }
    }

    /// The plugin's step has failed.
    pub(crate) const fn plugin_fails(&mut self) {
        self.ends_lease = Some("SR-006 lease of a failed plugin");
    }

    /// Core has told the plugin that a request does not leave.
    pub(crate) fn refused(&mut self, kind: RequestKind) {
        if kind == RequestKind::Trackline {
            self.asked = self.asked.saturating_sub(1);
        }
        if kind == RequestKind::Modify && self.modified.is_none() {
            self.term = None;
        }
        if kind == RequestKind::Station && self.suspended.is_none() {
            self.station_term = None;
        }
    }

    pub(crate) const fn reserved(&mut self, below: u32) {
        self.reserved = below;
    }

    /// A request has come to its end.
    pub(crate) fn ends(&mut self, request: u64) {
        let first = self.ended.insert(request);
        self.expect(first, "SR-009 one outcome", || format!("request {request} ended twice"));
    }

    pub(crate) fn link(&mut self, up: bool) {
        self.up = up;
        self.unanswered.clear();
        self.to_cancel.clear();
        (self.control, self.running, self.answered) = (None, None, None);
        (self.solved, self.modified, self.suspended) = (None, None, None);
        self.planned = false;
        self.dive = [None, None];
        for insert in self.inserts.values_mut() {
            if insert.stage == Stage::Sent {
                insert.stage = Stage::Doubtful;
            }
        }
    }

    /// A sentence of the vehicle's is with core.
    pub(crate) fn heard(&mut self, now: Timestamp, line: &Line<'_>, solved: Timestamp) {
        match line.name {
            "BFCTL" => self.control = Some(line.field(1) == "1"),
            "BFMIS" => {
                self.running = Some(line.field(2).starts_with("Running"));
                self.names_dive(0, line.field(1));
            }
            "BFNVG" => self.navigates(now, line, solved),
            "BFACK" => self.answers(now, line),
            "BFMBS" => {
                self.ends_lease = Some("SR-003 lease over a behavior");
                self.names_dive(1, line.field(1));
                // One behavior is flown at a time, and what is interrupted is not taken up again (SPI 7.5).
                self.inserts.retain(|_, insert| insert.stage != Stage::Flown);
                if let Some(identifier) = line.number::<u32>(3) {
                    self.to_cancel.remove(&identifier);
                }
                if let Some(insert) = line.number(3).and_then(|identifier| self.inserts.get_mut(&identifier)) {
                    insert.stage = Stage::Flown;
                }
            }
            "BFPLN" => self.listed.extend(line.number::<u32>(2)),
            "BFMBE" => {
                self.ends_lease = Some("SR-003 lease over a behavior");
                if let Some(identifier) = line.number::<u32>(3) {
                    self.inserts.remove(&identifier);
                }
            }
            _ => {}
        }
    }

    /// Another dive means another plan, and what waited may be gone.
    fn names_dive(&mut self, of: usize, name: &str) {
        if name.is_empty() {
            return;
        }
        if self.dive[of].as_deref().is_some_and(|before| before != name) {
            self.planned = false;
            self.unanswered.retain(|command| command.command != "RMP");
            for insert in self
                .inserts
                .values_mut()
                .filter(|insert| insert.stage == Stage::Answered)
            {
                insert.stage = Stage::Doubtful;
            }
        }
        self.dive[of] = Some(name.to_owned());
    }

    fn navigates(&mut self, now: Timestamp, line: &Line<'_>, solved: Timestamp) {
        // A solution that is not new is no navigation: what it says of the place is not believed, whatever it is.
        if self.solution.is_some_and(|known| known >= solved) {
            return;
        }
        (self.solved, self.solution) = (Some(solved), Some(solved));
        if let (Some(before), Some(place)) = (self.place, line.place(1))
            && (0..2).any(|axis| (place[axis] - before[axis]).abs() > JUMP_DEG)
        {
            self.moved = Some(now);
        }
        self.place = line.place(1).or(self.place);
    }

    fn answers(&mut self, now: Timestamp, line: &Line<'_>) {
        let command = line.field(1);
        let delay_max = Duration::from_secs_f64(course::DELAY_MAX_S);
        // An answer to BPLOG does not say to which: one that left in time is as good as another.
        let answers = |sent: &Unanswered| {
            let meant = if command == "LOG" {
                now.since(sent.sent) <= delay_max
            } else {
                sent.created == line.field(2)
            };
            sent.command == command && meant
        };
        let index = self.unanswered.iter().position(answers);
        let settled = line.field(4) != PENDING;
        let mut fresh_plan = false;
        if let Some(index) = index {
            let sent = self.unanswered[index].sent;
            if now.since(sent) <= delay_max {
                self.answered = self.answered.max(Some(sent));
            }
            fresh_plan = command == "RMP" && settled && line.field(4) == SUCCEEDED;
            if settled {
                self.unanswered.remove(index);
            }
        }
        let mut listed = BTreeSet::new();
        if command == "RMP" && settled {
            listed = std::mem::take(&mut self.listed);
        }
        if fresh_plan {
            self.planned = true;
            // What the plan does not have is over; what left after it was asked for may come yet.
            for insert in self
                .inserts
                .values_mut()
                .filter(|insert| insert.stage == Stage::Doubtful)
            {
                insert.stage = Stage::Answered;
            }
            self.inserts
                .retain(|identifier, insert| insert.stage == Stage::Sent || listed.contains(identifier));
        }
        if command == "RCN"
            && line.field(4) == SUCCEEDED
            && let Some(identifier) = line.number::<u32>(3)
        {
            self.inserts.remove(&identifier);
        }
        if command == "RTK"
            && let Some(identifier) = line.number(3)
            && let Some(insert) = self.inserts.get_mut(&identifier)
        {
            match line.field(4) {
                PENDING | SUCCEEDED if insert.stage == Stage::Sent => insert.stage = Stage::Answered,
                PENDING | SUCCEEDED => {}
                _ => drop(self.inserts.remove(&identifier)),
            }
        }
    }

    /// Core has handled what it was given; `late` where it had wished to be called over half a second before.
    pub(crate) fn settled(&mut self, now: Timestamp, late: bool, before: (Option<Timestamp>, Option<Timestamp>)) {
        let waits = self.to_cancel.iter().find(|(_, since)| now.since(**since) > PROMPT);
        if let Some(identifier) = waits.map(|(identifier, _)| *identifier) {
            self.broke(
                "SR-015 hold cancels",
                format!("insert {identifier} waits under the operator's hold"),
            );
        }
        if let Some(rule) = self.ends_lease.take() {
            let stands = before.0.is_some() && self.modified == before.0;
            self.expect(!stands, rule, || {
                "the modify that stood before stands after it".to_owned()
            });
        }
        let control = self.has_control();
        let stands = |what: &str, why: String| format!("{what} stands {why}");
        if let Some(sent) = self.modified {
            self.expect(control, "SR-014 lease without control", || {
                stands("a modify", self_state(control))
            });
            let gap = now.since(sent);
            self.expect(gap <= MODIFY_GAP, "SR-003 lease gap", || {
                stands("a modify", format!("{gap:?} after its last BPRMB"))
            });
            let over = self.term.is_none_or(|term| now > term + PROMPT);
            self.expect(!over, "SR-003 lease term", || {
                stands("a modify", "after its term".to_owned())
            });
            self.expect(!(late && before.0.is_some()), "SR-003 late wake", || {
                stands("a modify", "after a late wake-up".to_owned())
            });
        }
        if let Some(sent) = self.suspended {
            self.expect(control, "SR-014 station without control", || {
                stands("station keeping", self_state(control))
            });
            let gap = now.since(sent);
            self.expect(gap <= STATION_GAP, "SR-005 station gap", || {
                stands("station keeping", format!("{gap:?} after its last word"))
            });
            let over = self.station_term.is_none_or(|term| now > term + PROMPT);
            self.expect(!over, "SR-005 station term", || {
                stands("station keeping", "after its term".to_owned())
            });
            self.expect(!(late && before.1.is_some()), "SR-003 late wake", || {
                stands("station keeping", "after a late wake-up".to_owned())
            });
        }
        if self.modified.is_some() || self.suspended.is_some() {
            let age = self.age(now);
            let fresh = age.is_some_and(|age| age <= Duration::from_secs_f64(course::AGE_MAX_S) + PROMPT);
            self.expect(fresh, "SR-008 lease on stale navigation", || {
                stands("a lease", format!("on navigation {age:?} old"))
            });
            let heard = self
                .answered
                .is_some_and(|sent| now.since(sent) <= Duration::from_secs(3) + PROMPT);
            self.expect(heard, "SR-023 lease unheard", || {
                stands("a lease", "without a round trip of the last 3 s".to_owned())
            });
            let steady = self.moved.is_none_or(|moved| now.since(moved) >= STEADY - PROMPT);
            self.expect(steady, "SR-021 lease over a jump", || {
                stands("a lease", "within 10 s of a jump".to_owned())
            });
        }
    }

    /// What stands: the last BPRMB, and the last word of station keeping.
    pub(crate) const fn leases(&self) -> (Option<Timestamp>, Option<Timestamp>) {
        (self.modified, self.suspended)
    }

    fn age(&self, now: Timestamp) -> Option<Duration> {
        self.solved.map(|solved| now.since(solved))
    }
}

fn self_state(control: bool) -> String {
    format!("and control is {control}")
}

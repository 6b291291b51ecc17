//! The model vehicle: it flies its plan and what it has accepted, and answers as it is told to.

use std::collections::BTreeSet;
use std::time::Duration;

use backseat_spi::{
    AckStatus, Acknowledgement, BackseatControl, BehaviorBegin, BehaviorEnd, BehaviorId, CartesianNavigation,
    CommandName, EchoedTime, FromVehicle, MissionStatus, Navigation, PlanElement, PlanElementKind, PositionQuality,
    RelativeNavigation, Text, VehicleVersion, VelocityAndRates,
};
use backseat_units::{Altitude, Depth, EastNorth, Heading, TimeOfDay, Timestamp, utm_convergence_deg};
use serde::Serialize;

use crate::course;
use crate::wire::Line;

/// What a sentence takes from the vehicle to core. The other way takes no time.
const DELAY: Duration = Duration::from_millis(5);
/// After this the vehicle's answer is with core.
const ANSWER: Duration = Duration::from_millis(250);
/// After this what was pending is settled.
const SETTLED: Duration = Duration::from_millis(2200);
/// The code of an insert that is flown at once (SPI 7.5).
const INTERRUPTS: &str = "4";
const FIX_EVERY: Duration = Duration::from_secs(1);

/// How commands are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Answers {
    Good,
    Bad,
    Pending,
    Missing,
    Deaf,
}

/// What navigation says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Fixes {
    Good,
    /// The solution is of this time.
    Stale(Timestamp),
    Missing,
}

/// Where the vehicle says that it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Place {
    Line,
    Aside,
    Outside,
}

/// What is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) enum Flies {
    Planned(u32),
    Insert(u32),
}

/// An answer.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Ack {
    command: [u8; 3],
    created: TimeOfDay,
    identifier: Option<u32>,
    status: AckStatus,
}

/// What the vehicle is about to say.
#[derive(Clone, Copy, Debug, Serialize)]
enum Saying {
    Version,
    Control,
    Status,
    Begin(Flies),
    End(Flies),
    Ack(Ack),
    Element { number: u32, index: u32 },
    InsertElement(u32),
}

#[derive(Clone, Serialize)]
pub(crate) struct Front {
    pub(crate) hovers: bool,
    pub(crate) connected: bool,
    subscribed: BTreeSet<String>,
    pub(crate) control: bool,
    pub(crate) running: bool,
    other_dive: bool,
    pub(crate) answers: Answers,
    pub(crate) fixes: Fixes,
    pub(crate) place: Place,
    flies: Option<Flies>,
    /// Of the plan, once our inserts are over.
    planned_next: Option<Flies>,
    /// Our inserts that wait.
    queue: Vec<u32>,
    /// What arrives at core, and when.
    due: Vec<(Timestamp, Saying)>,
    next_fix: Timestamp,
}

impl Front {
    pub(crate) const fn new(hovers: bool) -> Self {
        Self {
            hovers,
            connected: false,
            subscribed: BTreeSet::new(),
            control: true,
            running: true,
            other_dive: false,
            answers: Answers::Good,
            fixes: Fixes::Good,
            place: Place::Line,
            flies: None,
            planned_next: None,
            queue: Vec::new(),
            due: Vec::new(),
            next_fix: Timestamp::from_millis(500),
        }
    }

    pub(crate) fn connects(&mut self, now: Timestamp) {
        self.connected = true;
        self.say(now + DELAY, Saying::Version);
    }

    /// All that was under way is lost.
    pub(crate) fn disconnects(&mut self) {
        self.connected = false;
        self.subscribed.clear();
        self.due.clear();
    }

    fn say(&mut self, at: Timestamp, saying: Saying) {
        self.due.push((at, saying));
    }

    /// Says it now, to whoever has subscribed.
    fn tell(&mut self, now: Timestamp, subject: &str, saying: Saying) {
        if self.connected && self.subscribed.contains(subject) {
            self.say(now + DELAY, saying);
        }
    }

    pub(crate) fn set_control(&mut self, now: Timestamp, granted: bool) {
        self.control = granted;
        self.tell(now, "CTL", Saying::Control);
    }

    pub(crate) fn set_running(&mut self, now: Timestamp, running: bool) {
        self.running = running;
        self.tell(now, "MIS", Saying::Status);
    }

    fn begin(&mut self, now: Timestamp, next: Flies) {
        self.flies = Some(next);
        self.tell(now, "MBS", Saying::Begin(next));
    }

    /// What is flown ends; what waits comes next, else what is planned.
    pub(crate) fn behavior_ends(&mut self, now: Timestamp) {
        let planned = self.after_this();
        if let Some(ended) = self.flies.take() {
            self.tell(now, "MBE", Saying::End(ended));
        }
        if self.queue.is_empty() {
            self.planned_next = None;
            if let Some(planned) = planned {
                self.begin(now, planned);
            }
        } else {
            self.planned_next = planned;
            let insert = self.queue.remove(0);
            self.begin(now, Flies::Insert(insert));
        }
    }

    fn after_this(&self) -> Option<Flies> {
        match self.flies {
            Some(Flies::Planned(number)) => Some(Flies::Planned(number + 1)).filter(|_| number < 3),
            Some(Flies::Insert(_)) => self.planned_next,
            None => Some(Flies::Planned(1)),
        }
    }

    /// The inserts that wait are gone.
    pub(crate) fn flies_another_dive(&mut self, now: Timestamp) {
        self.other_dive = !self.other_dive;
        self.queue.clear();
        self.planned_next = None;
        self.tell(now, "MIS", Saying::Status);
        self.begin(now, Flies::Planned(1));
    }

    /// When something of the vehicle's arrives at core next.
    pub(crate) fn next(&self) -> Timestamp {
        let due = self.due.iter().map(|(at, _)| *at);
        due.fold(self.next_fix, Timestamp::min)
    }

    /// What arrives now, in one read, a sentence an element.
    pub(crate) fn arrives(&mut self, now: Timestamp) -> Vec<String> {
        let mut lines = Vec::new();
        let mut index = 0;
        while index < self.due.len() {
            if self.due[index].0 <= now {
                let (at, saying) = self.due.remove(index);
                self.encode(at, saying, &mut lines);
            } else {
                index += 1;
            }
        }
        if self.next_fix <= now {
            let at = self.next_fix;
            self.next_fix = at + FIX_EVERY;
            if self.connected && self.fixes != Fixes::Missing {
                self.fix(at, &mut lines);
            }
        }
        lines
    }

    /// When the newest solution was computed, where it is not stale.
    pub(crate) fn solved(&self) -> Timestamp {
        self.next_fix - FIX_EVERY - DELAY
    }

    /// One of our sentences arrives.
    pub(crate) fn hears(&mut self, now: Timestamp, line: &Line<'_>) {
        if self.answers == Answers::Deaf {
            return;
        }
        let command = &line.name[2..];
        let mut letters = [0; 3];
        letters.copy_from_slice(command.as_bytes());
        if command == "LOG" {
            self.subscribes(now, line.field(0));
        }
        let identifier = match command {
            "RTK" | "RTC" | "RGP" | "RCN" => line.number(1),
            _ => None,
        };
        let ack = |status| {
            Saying::Ack(Ack {
                command: letters,
                created: line.field(0).parse_time(),
                identifier,
                status,
            })
        };
        let known = self.subscribed.contains("ACK");
        let always = matches!(command, "LOG" | "STS");
        let settled = match self.answers {
            Answers::Bad if !always => {
                if known {
                    self.say(now + ANSWER, ack(AckStatus::Failed));
                }
                return;
            }
            Answers::Pending if !always => {
                if known {
                    self.say(now + ANSWER, ack(AckStatus::Pending));
                }
                SETTLED
            }
            Answers::Good | Answers::Bad | Answers::Pending | Answers::Missing | Answers::Deaf => ANSWER,
        };
        let answers = known && self.answers != Answers::Missing;
        if command == "RMP" && answers {
            self.tell_plan(now + settled);
        }
        if answers {
            self.say(now + settled, ack(AckStatus::Succeeded));
        }
        if let Some(identifier) = identifier {
            let interrupts = command == "RTK" && line.field(14) == INTERRUPTS;
            self.carries_out(now + settled, command, identifier, interrupts);
        }
    }

    fn subscribes(&mut self, now: Timestamp, subject: &str) {
        if self.subscribed.insert(subject.to_owned()) {
            match subject {
                "CTL" => self.tell(now, "CTL", Saying::Control),
                "MIS" => self.tell(now, "MIS", Saying::Status),
                _ => {}
            }
        }
    }

    fn carries_out(&mut self, at: Timestamp, command: &str, identifier: u32, interrupts: bool) {
        match command {
            "RCN" => {
                self.queue.retain(|waiting| *waiting != identifier);
                if self.flies == Some(Flies::Insert(identifier)) {
                    self.behavior_ends(at);
                }
            }
            _ if interrupts => {
                // What is interrupted is not taken up again (SPI 7.5).
                self.planned_next = self.after_this();
                self.begin(at, Flies::Insert(identifier));
            }
            _ => self.queue.push(identifier),
        }
    }

    fn tell_plan(&mut self, at: Timestamp) {
        for (number, points) in course::PLAN {
            for index in 0..points.len() as u32 {
                self.say(at, Saying::Element { number, index });
            }
        }
        let flown = match self.flies {
            Some(Flies::Insert(identifier)) => Some(identifier),
            Some(Flies::Planned(_)) | None => None,
        };
        for identifier in flown.into_iter().chain(self.queue.clone()) {
            self.say(at, Saying::InsertElement(identifier));
        }
    }

    fn encode(&self, at: Timestamp, saying: Saying, lines: &mut Vec<String>) {
        let created = clock(at - DELAY);
        let dive_file = Text::cleaned(if self.other_dive { "other.dive" } else { "survey.dive" });
        let (number, identifier) = match saying {
            Saying::Begin(Flies::Planned(number)) | Saying::End(Flies::Planned(number)) => (Some(number), None),
            Saying::Begin(Flies::Insert(identifier)) | Saying::End(Flies::Insert(identifier)) => {
                (None, Some(BehaviorId::new(identifier)))
            }
            Saying::Version
            | Saying::Control
            | Saying::Status
            | Saying::Ack(_)
            | Saying::Element { .. }
            | Saying::InsertElement(_) => (None, None),
        };
        let file = if identifier.is_some() {
            Text::cleaned("")
        } else {
            dive_file.clone()
        };
        let kind = Text::cleaned("trackline");
        let element = |number, identifier: Option<u32>, index, element, (east_m, north_m)| PlanElement {
            created,
            number,
            identifier: identifier.map(BehaviorId::new),
            index,
            element,
            position: course::frame().to_position(EastNorth::new(east_m, north_m)),
        };
        match saying {
            Saying::Version => push(
                lines,
                VehicleVersion {
                    created,
                    version: Text::cleaned("1.12"),
                },
            ),
            Saying::Control => push(
                lines,
                BackseatControl {
                    created,
                    granted: self.control,
                },
            ),
            Saying::Status => push(
                lines,
                MissionStatus {
                    created,
                    dive_file,
                    status: Text::cleaned(if self.running { "Running" } else { "Aborting" }),
                    details: Text::cleaned(""),
                },
            ),
            Saying::Begin(_) => push(
                lines,
                BehaviorBegin {
                    created,
                    dive_file: file,
                    number,
                    identifier,
                    kind,
                },
            ),
            Saying::End(_) => push(
                lines,
                BehaviorEnd {
                    created,
                    dive_file: file,
                    number,
                    identifier,
                    kind,
                },
            ),
            Saying::Ack(ack) => push(
                lines,
                Acknowledgement {
                    created,
                    command: CommandName::new(std::str::from_utf8(&ack.command).unwrap_or("NAK"))
                        .unwrap_or(CommandName::NAK),
                    command_created: EchoedTime::of(ack.created),
                    behavior: ack.identifier.map(BehaviorId::new),
                    status: ack.status,
                    text: Text::cleaned("as told"),
                },
            ),
            Saying::Element { number, index } => {
                let points = course::PLAN[number as usize - 1].1;
                let kind = match (number, index) {
                    (1, 0) => PlanElementKind::TracklineStart,
                    (1, _) => PlanElementKind::TracklineEnd,
                    _ => PlanElementKind::Waypoint,
                };
                push(lines, element(Some(number), None, index, kind, points[index as usize]));
            }
            Saying::InsertElement(identifier) => {
                let ends = [
                    (0, PlanElementKind::TracklineStart, (0.0, 200.0)),
                    (1, PlanElementKind::TracklineEnd, (300.0, 200.0)),
                ];
                for (index, kind, point) in ends {
                    push(lines, element(None, Some(identifier), index, kind, point));
                }
            }
        }
    }

    fn fix(&self, at: Timestamp, lines: &mut Vec<String>) {
        let made = at - DELAY;
        let solved = match self.fixes {
            Fixes::Stale(since) => since,
            Fixes::Good | Fixes::Missing => made,
        };
        let created = clock(made);
        let speed_mps = if self.hovers { 0.0 } else { course::SPEED_MPS };
        let north_m = match self.place {
            Place::Line => 0.0,
            Place::Aside => course::ASIDE_NORTH_M,
            Place::Outside => course::OUTSIDE_NORTH_M,
        };
        let here = EastNorth::new(course::START_EAST_M + speed_mps * solved.as_secs_f64(), north_m);
        let position = course::frame().to_position(here);
        let says = |subject| self.subscribed.contains(subject);
        let (Ok(depth), Ok(heading)) = (Depth::from_m(course::DEPTH_M), Heading::from_deg(90.0)) else {
            unreachable!("both are in range");
        };
        if says("NVG") {
            let navigation = Navigation {
                created,
                position,
                quality: PositionQuality::NoGps,
                altitude: Altitude::from_m(70.0).ok(),
                depth,
                heading: heading.to_grid(utm_convergence_deg(position)),
                roll_deg: 0.0,
                pitch_deg: 0.0,
                solution: clock(solved),
            };
            push(lines, navigation);
        }
        if says("NVR") {
            let velocity = VelocityAndRates {
                created,
                east_mps: speed_mps,
                north_mps: 0.0,
                down_mps: 0.0,
                pitch_rate_dps: 0.0,
                roll_rate_dps: 0.0,
                yaw_rate_dps: 0.0,
            };
            push(lines, velocity);
        }
        if self.hovers && says("RNV") {
            let relative = RelativeNavigation {
                created,
                horizontal_m: 0.0,
                vertical_m: 5.0,
                distance_m: 5.0,
                heading_deg: 0.0,
                depth_m: course::DEPTH_M,
                absolute_heading_deg: 0.0,
                roll_deg: 0.0,
                pitch_deg: 0.0,
                solution: clock(solved),
            };
            push(lines, relative);
        }
        if self.hovers && says("CNV") {
            let cartesian = CartesianNavigation {
                created,
                x_m: 0.0,
                y_m: 0.0,
                z_m: course::DEPTH_M,
                heading_deg: 0.0,
            };
            push(lines, cartesian);
        }
    }
}

/// The vehicle's clock, which is ours.
pub(crate) fn clock(at: Timestamp) -> TimeOfDay {
    (course::UTC + Duration::from_nanos(at.as_nanos())).time_of_day()
}

fn push(lines: &mut Vec<String>, message: impl Into<FromVehicle>) {
    let mut bytes = Vec::new();
    message
        .into()
        .encode(&mut bytes)
        .expect("the model's words can be said");
    lines.push(String::from_utf8(bytes).expect("sentences are ASCII"));
}

/// A field that is a time, or none.
trait ParseTime {
    fn parse_time(&self) -> TimeOfDay;
}

impl ParseTime for str {
    fn parse_time(&self) -> TimeOfDay {
        let part = |range: std::ops::Range<usize>| self.get(range).unwrap_or_default();
        let text = format!("{}:{}:{}", part(0..2), part(2..4), part(4..self.len().max(4)));
        text.parse().unwrap_or(TimeOfDay::MIDNIGHT)
    }
}

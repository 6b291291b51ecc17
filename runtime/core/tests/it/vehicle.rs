//! The scripted vehicle: it flies a straight course, and answers and sends what the test says.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use backseat_spi::{
    AckStatus, Acknowledgement, BackseatControl, BehaviorBegin, BehaviorEnd, BehaviorId, CartesianNavigation,
    CommandName, EchoedTime, FromVehicle, MissionStatus, Navigation, PlanElement, PlanElementKind, PositionQuality,
    RelativeNavigation, Sentence, Text, ToVehicle, VehicleVersion, VelocityAndRates, catalogue,
};
use backseat_units::{Altitude, Depth, EastNorth, Heading, TimeOfDay, Timestamp, Utc, utm_convergence_deg};

use crate::course;

/// How a command is answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reply {
    Ok,
    Refuse,
    Pending(Duration, AckStatus),
    Late(Duration, AckStatus),
    /// Pending again and again, without an end.
    PendingForEver,
    /// Success at once, and this after a while.
    Twice(Duration, AckStatus),
    Silent,
    /// The answer to a line that is no command.
    Nak,
}

/// Changes navigation before it is sent. False means that the velocities are not sent.
pub(crate) type Bend = Box<dyn FnMut(Timestamp, &mut Navigation, &mut VelocityAndRates) -> bool>;

pub(crate) struct Vehicle {
    pub(crate) bend: Option<Bend>,
    /// The vehicle's clock less the true one, in nanoseconds.
    pub(crate) clock_nanos: i64,
    pub(crate) utc: Utc,
    pub(crate) start: EastNorth,
    pub(crate) heading_deg: f64,
    pub(crate) speed_mps: f64,
    pub(crate) depth_m: f64,
    pub(crate) altitude_m: Option<f64>,
    /// The error of navigation.
    pub(crate) jump: EastNorth,
    pub(crate) navigates: bool,
    /// Since then the solution's time stands still.
    pub(crate) frozen: Option<Timestamp>,
    /// Whether a new subscriber receives the present control, mission status and behavior.
    pub(crate) replays: bool,
    pub(crate) control: bool,
    pub(crate) status: &'static str,
    pub(crate) replies: BTreeMap<&'static str, Reply>,
    /// Our inserts that its plan names.
    pub(crate) inserted: BTreeSet<u32>,
    /// Another payload's inserts that its plan names, with the place where each ends.
    pub(crate) others: Vec<(u32, (f64, f64))>,
    /// A planned behavior, and how far the vehicle's plan has it from where the course has it.
    pub(crate) moved: Option<(u32, EastNorth)>,
    pub(crate) subscribed: BTreeSet<String>,
    /// Whether the vehicle acknowledges what comes before the subscription of BFACK.
    pub(crate) answers_unasked: bool,
    /// When its clock has a leap second.
    pub(crate) leap_at: Option<Timestamp>,
    /// How many more subscriptions the vehicle does not hear.
    pub(crate) deaf_to_subscriptions: u32,
    /// The next subscription to this message is damaged on its way.
    pub(crate) damaged_subscription: Option<&'static str>,
    /// Whether the vehicle answers a damaged subscription with a NAK.
    pub(crate) naks_damage: bool,
    /// How many decimals of a command's time its acknowledgements have.
    pub(crate) echo_decimals: u8,
    due: Vec<(Timestamp, FromVehicle)>,
    next_navigation: Timestamp,
    /// Horizontal, vertical, distance: if set, the vehicle sends BFRNV.
    pub(crate) hull_m: Option<[f64; 3]>,
    /// X and y: if set, the vehicle sends BFCNV.
    pub(crate) bottom_m: Option<[f64; 2]>,
    /// Since then the solution of BFRNV stands still.
    pub(crate) hull_frozen: Option<Timestamp>,
}

impl Vehicle {
    pub(crate) fn new() -> Self {
        Self {
            bend: None,
            clock_nanos: 0,
            utc: Utc::from_unix_nanos(1_700_000_000_000_000_000),
            start: EastNorth::new(-500.0, 0.0),
            heading_deg: 90.0,
            speed_mps: 1.5,
            depth_m: 20.0,
            altitude_m: Some(70.0),
            jump: EastNorth::default(),
            navigates: true,
            frozen: None,
            replays: true,
            control: true,
            status: "Running",
            replies: BTreeMap::new(),
            inserted: BTreeSet::new(),
            others: Vec::new(),
            moved: None,
            subscribed: BTreeSet::new(),
            answers_unasked: false,
            leap_at: None,
            deaf_to_subscriptions: 0,
            damaged_subscription: None,
            naks_damage: true,
            echo_decimals: 3,
            due: Vec::new(),
            next_navigation: Timestamp::from_millis(50),
            hull_m: None,
            bottom_m: None,
            hull_frozen: None,
        }
    }

    pub(crate) fn clock(&self, now: Timestamp) -> TimeOfDay {
        let true_nanos = (self.utc + Duration::from_nanos(now.as_nanos())).as_unix_nanos();
        let nanos = true_nanos.wrapping_add_signed(self.clock_nanos);
        match self.leap_at.filter(|leap| now >= *leap) {
            None => Utc::from_unix_nanos(nanos).time_of_day(),
            Some(leap) if now.since(leap) < Duration::from_secs(1) => {
                let within = u64::try_from(now.since(leap).as_nanos()).unwrap();
                TimeOfDay::from_nanos(86_400_000_000_000 + within).unwrap()
            }
            Some(_) => Utc::from_unix_nanos(nanos - 1_000_000_000).time_of_day(),
        }
    }

    pub(crate) fn say(&mut self, at: Timestamp, message: impl Into<FromVehicle>) {
        self.due.push((at, message.into()));
    }

    pub(crate) fn connected(&mut self, now: Timestamp) {
        self.subscribed.clear();
        self.due.clear();
        self.say(
            now,
            VehicleVersion {
                created: self.clock(now),
                version: Text::cleaned("1.11"),
            },
        );
    }

    pub(crate) fn next(&self) -> Timestamp {
        self.due
            .iter()
            .map(|(at, _)| *at)
            .fold(self.next_navigation, Timestamp::min)
    }

    /// What the vehicle sends now, with the true time of the solution if it is navigation.
    pub(crate) fn speak(&mut self, now: Timestamp) -> Vec<(FromVehicle, Option<Timestamp>)> {
        let (due, later): (Vec<_>, Vec<_>) = self.due.drain(..).partition(|(at, _)| *at <= now);
        self.due = later;
        let mut said: Vec<_> = due.into_iter().map(|(_, message)| (message, None)).collect();
        if self.next_navigation <= now {
            self.next_navigation = now + Duration::from_millis(100);
            if self.navigates && self.subscribed.contains("NVG") {
                let solved = self.frozen.unwrap_or(now);
                let mut navigation = self.navigation(now, solved);
                let mut velocity = self.velocity(now);
                let complete = match &mut self.bend {
                    Some(bend) => bend(now, &mut navigation, &mut velocity),
                    None => true,
                };
                said.push((navigation.into(), Some(solved)));
                if complete && self.subscribed.contains("NVR") {
                    said.push((velocity.into(), None));
                }
            }
            said.extend(self.relative_navigation(now).map(|message| (message, None)));
        }
        said
    }

    pub(crate) fn navigation(&self, now: Timestamp, solved: Timestamp) -> Navigation {
        let frame = *course::fence().frame();
        let position = frame.to_position(self.here(now) + self.jump);
        let heading = Heading::from_deg(self.heading_deg).unwrap();
        Navigation {
            created: self.clock(now),
            position,
            quality: PositionQuality::NoGps,
            altitude: self.altitude_m.map(|m| Altitude::from_m(m).unwrap()),
            depth: Depth::from_m(self.depth_m).unwrap(),
            heading: heading.to_grid(utm_convergence_deg(position)),
            roll_deg: 0.0,
            pitch_deg: 0.0,
            solution: self.clock(solved),
        }
    }

    fn here(&self, now: Timestamp) -> EastNorth {
        self.start.offset(self.heading_deg, self.speed_mps * now.as_secs_f64())
    }

    fn velocity(&self, now: Timestamp) -> VelocityAndRates {
        let way = EastNorth::default().offset(self.heading_deg, self.speed_mps);
        VelocityAndRates {
            created: self.clock(now),
            east_mps: way.east_m,
            north_mps: way.north_m,
            down_mps: 0.0,
            pitch_rate_dps: 0.0,
            roll_rate_dps: 0.0,
            yaw_rate_dps: 0.0,
        }
    }

    /// BFRNV and BFCNV, if the vehicle sends them.
    fn relative_navigation(&self, now: Timestamp) -> impl Iterator<Item = FromVehicle> + use<> {
        let created = self.clock(now);
        let hull_m = self.hull_m.filter(|_| self.subscribed.contains("RNV"));
        let bottom_m = self.bottom_m.filter(|_| self.subscribed.contains("CNV"));
        let relative = hull_m.map(|place| RelativeNavigation {
            created,
            horizontal_m: place[0],
            vertical_m: place[1],
            distance_m: place[2],
            heading_deg: 0.0,
            depth_m: self.depth_m,
            absolute_heading_deg: 0.0,
            roll_deg: 0.0,
            pitch_deg: 0.0,
            solution: self.clock(self.hull_frozen.unwrap_or(now)),
        });
        let cartesian = bottom_m.map(|place| CartesianNavigation {
            created,
            x_m: place[0],
            y_m: place[1],
            z_m: self.depth_m,
            heading_deg: 0.0,
        });
        let relative = relative.map(FromVehicle::from).into_iter();
        relative.chain(cartesian.map(FromVehicle::from))
    }

    pub(crate) fn set_control(&mut self, now: Timestamp, granted: bool) {
        self.control = granted;
        self.say(
            now,
            BackseatControl {
                created: self.clock(now),
                granted,
            },
        );
    }

    pub(crate) fn set_status(&mut self, now: Timestamp, status: &'static str) {
        self.status = status;
        self.say(now, self.mission_status(now));
    }

    fn mission_status(&self, now: Timestamp) -> MissionStatus {
        MissionStatus {
            created: self.clock(now),
            dive_file: Text::cleaned("survey.dive"),
            status: Text::cleaned(self.status),
            details: Text::cleaned(""),
        }
    }

    pub(crate) fn begin(&mut self, now: Timestamp, number: Option<u32>, identifier: Option<u32>) {
        let message = BehaviorBegin {
            created: self.clock(now),
            dive_file: Text::cleaned(""),
            number,
            identifier: identifier.map(BehaviorId::new),
            kind: Text::cleaned("trackline"),
        };
        self.say(now, message);
    }

    pub(crate) fn end(&mut self, now: Timestamp, number: Option<u32>, identifier: Option<u32>) {
        let message = BehaviorEnd {
            created: self.clock(now),
            dive_file: Text::cleaned(""),
            number,
            identifier: identifier.map(BehaviorId::new),
            kind: Text::cleaned("trackline"),
        };
        self.say(now, message);
    }

    pub(crate) fn hear(&mut self, now: Timestamp, bytes: &[u8]) {
        let line = std::str::from_utf8(bytes).unwrap();
        let command = ToVehicle::decode(&Sentence::parse(line).unwrap()).unwrap();
        let (name, identifier) = name_of(&command);
        if let ToVehicle::LoggingControl(logging) = &command {
            if self.deaf_to_subscriptions > 0 {
                self.deaf_to_subscriptions -= 1;
                return;
            }
            if self.damaged_subscription == Some(logging.message.as_str()) {
                self.damaged_subscription = None;
                if !self.naks_damage {
                    return;
                }
                return self.acknowledge(now, ("NAK", TimeOfDay::MIDNIGHT, None, AckStatus::Invalid));
            }
            let new = self.subscribed.insert(logging.message.as_str().to_owned());
            if new && self.replays {
                match logging.message.as_str() {
                    "CTL" => self.set_control(now, self.control),
                    "MIS" => self.say(now, self.mission_status(now)),
                    "MBS" => self.begin(now, Some(1), None),
                    _ => {}
                }
            }
        }
        if !self.subscribed.contains("ACK") && !self.answers_unasked {
            return;
        }
        let created = command.created().unwrap_or(TimeOfDay::MIDNIGHT);
        let plan = matches!(command, ToVehicle::RequestPlan(_));
        let reply = match self.replies.get(name) {
            Some(reply) => *reply,
            None if plan => Reply::Pending(Duration::from_millis(100), AckStatus::Succeeded),
            None => Reply::Ok,
        };
        let ack = |status| (name, created, identifier, status);
        match reply {
            Reply::Ok => self.acknowledge(now, ack(AckStatus::Succeeded)),
            Reply::Refuse => self.acknowledge(now, ack(AckStatus::Failed)),
            Reply::Late(after, status) => self.acknowledge(now + after, ack(status)),
            Reply::Pending(after, status) => {
                self.acknowledge(now, ack(AckStatus::Pending));
                if plan && status == AckStatus::Succeeded {
                    self.say_plan(now + after / 2);
                }
                self.acknowledge(now + after, ack(status));
            }
            Reply::PendingForEver => {
                for second in 0..120 {
                    self.acknowledge(now + Duration::from_secs(second), ack(AckStatus::Pending));
                }
            }
            Reply::Twice(after, status) => {
                self.acknowledge(now, ack(AckStatus::Succeeded));
                self.acknowledge(now + after, ack(status));
            }
            Reply::Silent => {}
            Reply::Nak => self.acknowledge(now, ("NAK", TimeOfDay::MIDNIGHT, None, AckStatus::Invalid)),
        }
        if reply == Reply::Ok {
            match &command {
                ToVehicle::Trackline(insert) => self.inserted.insert(insert.identifier.get()),
                ToVehicle::Trackcircle(insert) => self.inserted.insert(insert.identifier.get()),
                ToVehicle::GpsHit(insert) => self.inserted.insert(insert.identifier.get()),
                ToVehicle::CancelBehavior(cancel) => self.inserted.remove(&cancel.identifier.get()),
                _ => false,
            };
        }
    }

    pub(crate) fn acknowledge(
        &mut self,
        at: Timestamp,
        (name, echoed, identifier, status): (&str, TimeOfDay, Option<u32>, AckStatus),
    ) {
        let message = Acknowledgement {
            created: self.clock(at),
            command: CommandName::new(name).unwrap(),
            command_created: EchoedTime::with_decimals(echoed, self.echo_decimals),
            behavior: identifier.map(BehaviorId::new),
            status,
            text: Text::cleaned("as told"),
        };
        self.say(at, message);
    }

    pub(crate) fn say_plan(&mut self, at: Timestamp) {
        for (number, points) in course::PLAN {
            for (index, (east_m, north_m)) in points.iter().enumerate() {
                let moved = self.moved.filter(|(of, _)| *of == number);
                let by = moved.map_or(EastNorth::default(), |(_, by)| by);
                self.say_element(
                    at,
                    Some(number),
                    None,
                    index,
                    (*east_m + by.east_m, *north_m + by.north_m),
                );
            }
        }
        for identifier in self.inserted.clone() {
            self.say_element(at, None, Some(identifier), 0, (0.0, 500.0));
        }
        for (identifier, place) in self.others.clone() {
            self.say_element(at, None, Some(identifier), 0, place);
        }
    }

    pub(crate) fn say_element(
        &mut self,
        at: Timestamp,
        number: Option<u32>,
        identifier: Option<u32>,
        index: usize,
        (east_m, north_m): (f64, f64),
    ) {
        let message = PlanElement {
            created: self.clock(at),
            number,
            identifier: identifier.map(BehaviorId::new),
            index: u32::try_from(index).unwrap(),
            element: match (number, index) {
                (Some(1), 0) => PlanElementKind::TracklineStart,
                (Some(1), _) => PlanElementKind::TracklineEnd,
                _ => PlanElementKind::Waypoint,
            },
            position: course::fence().frame().to_position(EastNorth::new(east_m, north_m)),
        };
        self.say(at, message);
    }
}

/// The three letters of a command, and the identifier in it.
pub(crate) fn name_of(command: &ToVehicle) -> (&'static str, Option<u32>) {
    let entry = catalogue().iter().find(|entry| entry.name == command.name());
    let name = &entry.unwrap_or_else(|| panic!("core sent {command:?}")).name[2..];
    let identifier = match command {
        ToVehicle::Trackline(insert) => Some(insert.identifier.get()),
        ToVehicle::Trackcircle(insert) => Some(insert.identifier.get()),
        ToVehicle::GpsHit(insert) => Some(insert.identifier.get()),
        ToVehicle::CancelBehavior(cancel) => Some(cancel.identifier.get()),
        _ => None,
    };
    (name, identifier)
}

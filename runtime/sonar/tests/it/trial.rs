//! A client, a controller and a link between them, in virtual time.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_sonar::{
    Event, Input, Order, Outcome, Output, PingGrant, SensorConfig, Sonar, SonarConfig, SonarPing, Start, Ticket,
    VehicleNavigation, VehicleRates,
};
use backseat_units::{Altitude, Depth, Heading, Position, Timestamp, Utc};

use crate::controller::Controller;

/// 2026-11-23T14:05:07Z.
pub(crate) const START: Utc = Utc::from_unix_nanos(1_795_442_707_000_000_000);
/// The delay of the link, each way.
pub(crate) const DELAY: Duration = Duration::from_millis(10);

pub(crate) struct Trial {
    pub(crate) sonar: Sonar,
    pub(crate) controller: Controller,
    pub(crate) now: Timestamp,
    /// Whether the controller takes connections.
    pub(crate) reachable: bool,
    pub(crate) events: Vec<(Timestamp, Event)>,
    pub(crate) pings: Vec<SonarPing>,
    /// When the client asked for a connection.
    pub(crate) connects: Vec<Timestamp>,
    pub(crate) disconnects: Vec<Timestamp>,
    pub(crate) finished: Option<Timestamp>,
    happenings: BTreeMap<(Timestamp, u64), (u32, Happening)>,
    number: u64,
    /// Counts the connections: what belongs to an old one does not arrive.
    connection: u32,
    up: bool,
    connecting: bool,
    tickets: u64,
}

#[derive(Clone, Debug)]
enum Happening {
    Connected,
    Lost,
    ToController(Vec<u8>),
    ToClient(Vec<u8>),
}

pub(crate) fn config() -> SonarConfig {
    let sensor = |index: i32, device: u32, record: u32| SensorConfig {
        index,
        device,
        records: vec![record],
        ..SensorConfig::default()
    };
    SonarConfig {
        sensor: vec![sensor(0, 11_001, 3000), sensor(1, 11_000, 3001)],
        ..SonarConfig::default()
    }
}

pub(crate) fn start(grants: Vec<PingGrant>) -> Start {
    Start {
        utc_at_start: START,
        grants,
    }
}

pub(crate) fn utc(now: Timestamp) -> Utc {
    START + Duration::from_nanos(now.as_nanos())
}

pub(crate) fn navigation(now: Timestamp) -> VehicleNavigation {
    VehicleNavigation {
        solution: utc(now),
        position: Position::from_deg(42.363_5, -71.114_1).unwrap(),
        depth: Depth::from_m(20.1).unwrap(),
        altitude: Some(Altitude::from_m(45.3).unwrap()),
        heading: Heading::from_deg(203.1).unwrap(),
        roll_deg: -3.4,
        pitch_deg: 4.5,
        rates: Some(VehicleRates {
            east_mps: -0.5864,
            north_mps: -1.3746,
            down_mps: 0.02,
            roll_rate_dps: -0.25,
            pitch_rate_dps: 0.1,
            yaw_rate_dps: 1.5,
        }),
    }
}

impl Trial {
    pub(crate) fn new() -> Self {
        Self::with(config(), Vec::new())
    }

    pub(crate) fn with(config: SonarConfig, grants: Vec<PingGrant>) -> Self {
        let mut trial = Self {
            sonar: Sonar::new(config, start(grants)).unwrap(),
            controller: Controller::default(),
            now: Timestamp::ZERO,
            reachable: true,
            events: Vec::new(),
            pings: Vec::new(),
            connects: Vec::new(),
            disconnects: Vec::new(),
            finished: None,
            happenings: BTreeMap::new(),
            number: 0,
            connection: 0,
            up: false,
            connecting: false,
            tickets: 0,
        };
        trial.drain();
        trial
    }

    /// A trial whose client is ready; what happened before is forgotten.
    pub(crate) fn ready() -> Self {
        Self::new().until_ready()
    }

    pub(crate) fn until_ready(mut self) -> Self {
        self.run_s(2.0);
        assert!(self.sonar.is_ready(), "{:?}", self.events);
        self.events.clear();
        self.controller.heard.clear();
        self
    }

    fn schedule(&mut self, after: Duration, happening: Happening) {
        self.number += 1;
        self.happenings
            .insert((self.now + after, self.number), (self.connection, happening));
    }

    /// Bytes from the controller, which arrive after the link's delay.
    pub(crate) fn send(&mut self, bytes: Vec<u8>) {
        self.schedule(DELAY, Happening::ToClient(bytes));
    }

    /// The link breaks, or the attempt to connect fails, and the driver notices at once.
    pub(crate) fn cut(&mut self) {
        self.connection += 1;
        if self.up || self.connecting {
            (self.up, self.connecting) = (false, false);
            self.handle(Input::Lost);
        }
    }

    pub(crate) fn order(&mut self, order: Order) -> Ticket {
        self.tickets += 1;
        let ticket = Ticket(self.tickets);
        self.handle(Input::Order(ticket, order));
        ticket
    }

    pub(crate) fn handle(&mut self, input: Input<'_>) {
        self.sonar.handle(self.now, input);
        self.drain();
    }

    fn drain(&mut self) {
        let mut outputs = 0;
        while let Some(output) = self.sonar.poll_output() {
            outputs += 1;
            assert!(outputs < 1000, "the client asks for too much at once");
            assert!(self.finished.is_none(), "{output:?} comes after the end");
            match output {
                Output::Connect => {
                    assert!(!self.up && !self.connecting);
                    self.connecting = true;
                    self.connects.push(self.now);
                    self.connection += 1;
                    let happening = if self.reachable {
                        Happening::Connected
                    } else {
                        Happening::Lost
                    };
                    self.schedule(DELAY, happening);
                }
                Output::Disconnect => {
                    assert!(self.up || self.connecting, "there is nothing to disconnect");
                    self.disconnects.push(self.now);
                    self.connecting = false;
                    self.connection += 1;
                    self.up = false;
                    self.schedule(Duration::ZERO, Happening::Lost);
                }
                Output::Send(bytes) => {
                    assert!(self.up, "nothing can be sent without a connection");
                    self.schedule(DELAY, Happening::ToController(bytes));
                }
                Output::Ping(ping) => self.pings.push(ping),
                Output::Event(event) => self.events.push((self.now, event)),
                Output::Finished => self.finished = Some(self.now),
            }
        }
        if let Some(next) = self.sonar.poll_timeout() {
            assert!(
                next > self.now,
                "the client wants to be called at {next}, and it is {}",
                self.now
            );
        }
    }

    /// Jumps from one thing that happens to the next, for so long.
    pub(crate) fn run_s(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        loop {
            let happening = self.happenings.keys().next().map(|(at, _)| *at);
            let timeout = self.sonar.poll_timeout().filter(|_| self.finished.is_none());
            let next = happening.into_iter().chain(timeout).min();
            let Some(next) = next.filter(|next| *next <= end) else {
                break;
            };
            self.now = next;
            if happening == Some(next) {
                let (_, (connection, happening)) = self.happenings.pop_first().unwrap();
                if connection == self.connection && self.finished.is_none() {
                    self.happen(happening);
                }
            } else {
                self.handle(Input::Timeout);
            }
        }
        self.now = end;
    }

    fn happen(&mut self, happening: Happening) {
        match happening {
            Happening::Connected => {
                (self.up, self.connecting) = (true, false);
                self.controller.connected();
                self.handle(Input::Connected);
            }
            Happening::Lost => {
                self.connecting = false;
                self.handle(Input::Lost);
            }
            Happening::ToController(bytes) => {
                for (after, answer) in self.controller.receive(utc(self.now), &bytes) {
                    self.schedule(DELAY + after, Happening::ToClient(answer));
                }
            }
            Happening::ToClient(bytes) => self.handle(Input::Received(&bytes)),
        }
    }

    /// The one outcome of an order.
    pub(crate) fn outcome(&self, ticket: Ticket) -> Outcome {
        let outcomes = self.outcomes(ticket);
        assert_eq!(outcomes.len(), 1, "{outcomes:?}");
        outcomes[0].clone()
    }

    pub(crate) fn outcomes(&self, ticket: Ticket) -> Vec<Outcome> {
        let outcome = |event: &Event| match event {
            Event::Outcome { ticket: of, outcome } if *of == ticket => Some(outcome.clone()),
            _ => None,
        };
        self.events.iter().filter_map(|(_, event)| outcome(event)).collect()
    }

    /// The lines of the log.
    pub(crate) fn log(&self) -> Vec<String> {
        self.events.iter().map(|(_, event)| event.to_string()).collect()
    }

    pub(crate) fn has(&self, line: &str) -> bool {
        self.log().iter().any(|logged| logged.contains(line))
    }
}

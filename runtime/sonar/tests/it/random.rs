//! Random inputs: nothing panics, time goes on, outputs are bounded, and each order has one outcome.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use backseat_s7k::plc::{CommandId, Generic};
use backseat_s7k::record::{AlarmMode, CommandStatus, MessageType};
use backseat_s7k::{DeviceId, FrameHeader, SensorIndex, Time7k};
use backseat_sonar::{Decimation, Event, Input, Order, Output, STATUS_CHARS, Sonar, SonarConfig, Ticket};
use backseat_units::Timestamp;
use proptest::prelude::*;

use crate::controller::{Controller, acknowledgement, enclosed, framed, message};
use crate::imagery::{Ping, grant};
use crate::trial::{config, navigation, start, utc};

#[derive(Clone, Debug)]
enum Act {
    Connected,
    Lost,
    Garbage(Vec<u8>),
    Record(u32, Vec<u8>),
    Acknowledge(u32, i32, u32),
    Message(i32, i32, i32, String),
    Ping(Vec<u16>, Option<(usize, u8)>),
    Log(bool),
    Set(f64),
    Shutdown,
    Navigation,
    Utc(i64),
    Timeout,
    Wait(u64),
    /// So many answers of an honest controller arrive.
    Answers(usize),
}

fn act() -> impl Strategy<Value = Act> {
    let texts = prop_oneof![
        "[ -~]{0,40}",
        Just("Sensors: 1, 0, 0".to_owned()),
        Just("Logging = 1, a, 1.0".to_owned()),
        Just("1.0203".to_owned()),
        Just(String::new()),
    ];
    prop_oneof![
        3 => Just(Act::Connected),
        1 => Just(Act::Lost),
        2 => proptest::collection::vec(any::<u8>(), 0..200).prop_map(Act::Garbage),
        2 => (prop_oneof![Just(3000_u32), Just(3001), Just(7400), Just(11_001), Just(11_002), any::<u32>()],
              proptest::collection::vec(any::<u8>(), 0..120)).prop_map(|(kind, body)| Act::Record(kind, body)),
        8 => (0..29_u32, -1..2_i32, 0..4_u32).prop_map(|(id, sensor, status)| Act::Acknowledge(id, sensor, status)),
        6 => (0..2_i32, -1..3_i32, -1..17_i32, texts).prop_map(|(kind, mode, id, text)| Act::Message(kind, mode, id, text)),
        2 => (proptest::collection::vec(any::<u16>(), 0..60), proptest::option::of((0..300_usize, any::<u8>())))
            .prop_map(|(samples, change)| Act::Ping(samples, change)),
        1 => any::<bool>().prop_map(Act::Log),
        1 => any::<f64>().prop_map(Act::Set),
        1 => proptest::option::weighted(0.05, Just(())).prop_map(|some| if some.is_some() { Act::Shutdown } else { Act::Timeout }),
        2 => Just(Act::Navigation),
        1 => any::<i64>().prop_map(Act::Utc),
        6 => Just(Act::Timeout),
        4 => (0..20_000_u64).prop_map(Act::Wait),
        20 => (1..30_usize).prop_map(Act::Answers),
    ]
}

/// A driver that only obeys: it reports connections when it was asked for them.
struct Driver {
    sonar: Sonar,
    now: Timestamp,
    wanted: bool,
    closing: bool,
    up: bool,
    finished: Option<Timestamp>,
    shutdown_at: Option<Timestamp>,
    outcomes: BTreeMap<Ticket, u32>,
    controller: Controller,
    /// What the controller has answered and nobody has delivered.
    answers: VecDeque<Vec<u8>>,
}

impl Driver {
    fn handle(&mut self, input: Input<'_>) {
        self.sonar.handle(self.now, input);
        let mut outputs = 0;
        while let Some(output) = self.sonar.poll_output() {
            outputs += 1;
            match output {
                Output::Connect => {
                    assert!(!self.wanted && !self.up);
                    self.wanted = true;
                }
                Output::Disconnect => {
                    assert!(self.wanted || self.up);
                    (self.wanted, self.up, self.closing) = (false, false, true);
                    self.answers.clear();
                }
                Output::Send(bytes) => {
                    assert!(self.up && bytes.len() < 4000);
                    let answers = self.controller.receive(utc(self.now), &bytes);
                    self.answers.extend(answers.into_iter().map(|(_, bytes)| bytes));
                }
                Output::Event(Event::Outcome { ticket, .. }) => *self.outcomes.entry(ticket).or_default() += 1,
                Output::Event(event) => assert!(event.to_string().len() < 10_000),
                Output::Ping(ping) => assert!(ping.channels.iter().all(|channel| channel.samples.len() <= 16)),
                Output::Finished => self.finished = Some(self.now),
            }
        }
        assert!(outputs < 150, "{outputs} outputs at once");
        let next = self.sonar.poll_timeout();
        assert!(next.is_none_or(|next| next > self.now));
        let waits_for_driver = self.wanted || self.closing || self.finished.is_some();
        assert!(next.is_some() || waits_for_driver, "nobody would ever call again");
        let status = self.sonar.status_text();
        assert!(status.len() <= STATUS_CHARS && status.is_ascii());
        if let (Some(at), None) = (self.shutdown_at, self.finished) {
            assert!(self.now.since(at) <= Duration::from_secs(10));
        }
    }

    fn act(&mut self, act: &Act, ticket: Ticket) {
        match act {
            Act::Connected if self.wanted => {
                (self.wanted, self.up) = (false, true);
                self.controller.connected();
                self.handle(Input::Connected);
            }
            Act::Lost if self.wanted || self.up || self.closing => {
                (self.wanted, self.up, self.closing) = (false, false, false);
                self.answers.clear();
                self.handle(Input::Lost);
            }
            Act::Connected | Act::Lost => {}
            Act::Garbage(bytes) => self.handle(Input::Received(bytes)),
            Act::Record(kind, body) => {
                let bytes = framed(FrameHeader::new(*kind, DeviceId(11_001)), body);
                self.handle(Input::Received(&bytes));
            }
            Act::Acknowledge(id, sensor, status) => {
                let bytes = acknowledgement(
                    Time7k::NONE,
                    CommandId::from(*id),
                    SensorIndex(*sensor),
                    CommandStatus::from(*status),
                );
                self.handle(Input::Received(&bytes));
            }
            Act::Message(kind, mode, id, text) => {
                let bytes = message(
                    Time7k::NONE,
                    MessageType::from(*kind),
                    AlarmMode::from(*mode),
                    *id,
                    text,
                );
                self.handle(Input::Received(&bytes));
            }
            Act::Ping(samples, change) => {
                let ping = Ping {
                    channels: vec![samples.clone(); 2],
                    ..Ping::default()
                };
                let mut bytes = enclosed(&ping.record());
                if let Some((at, value)) = change {
                    let at = at % bytes.len();
                    bytes[at] = *value;
                }
                self.handle(Input::Received(&bytes));
            }
            Act::Log(on) => self.order(ticket, Order::Logging { on: *on, file: None }),
            Act::Set(range_m) => self.order(
                ticket,
                Order::Set {
                    sensor: SensorIndex(0),
                    setting: Generic::Range { range_m: *range_m },
                },
            ),
            Act::Shutdown => {
                self.shutdown_at.get_or_insert(self.now);
                self.order(ticket, Order::Shutdown);
            }
            Act::Navigation => {
                let sample = navigation(self.now);
                self.handle(Input::Navigation(sample));
            }
            Act::Utc(nanos) => self.handle(Input::UtcSet(*nanos)),
            Act::Timeout => self.wake(),
            Act::Answers(count) => {
                for _ in 0..*count {
                    let Some(bytes) = self.answers.pop_front() else {
                        break;
                    };
                    self.handle(Input::Received(&bytes));
                }
            }
            Act::Wait(millis) => {
                let end = self.now + Duration::from_millis(*millis);
                while self.sonar.poll_timeout().is_some_and(|next| next <= end) {
                    self.wake();
                }
                self.now = end;
            }
        }
    }

    fn wake(&mut self) {
        if let Some(next) = self.sonar.poll_timeout() {
            self.now = next;
            self.handle(Input::Timeout);
        }
    }

    fn order(&mut self, ticket: Ticket, order: Order) {
        self.outcomes.insert(ticket, 0);
        self.handle(Input::Order(ticket, order));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_panics_and_time_goes_on(acts in proptest::collection::vec(act(), 1..300), verbose in any::<bool>()) {
        let settings = SonarConfig { verbose, frame_limit_bytes: 1 << 16, ..config() };
        let mut driver = Driver {
            sonar: Sonar::new(settings, start(vec![grant(16, Decimation::Mean)])).unwrap(),
            now: Timestamp::ZERO,
            wanted: false,
            closing: false,
            up: false,
            finished: None,
            shutdown_at: None,
            outcomes: BTreeMap::new(),
            controller: Controller::default(),
            answers: VecDeque::new(),
        };
        driver.handle(Input::Timeout);
        for (number, act) in (0..).zip(&acts) {
            driver.act(act, Ticket(number));
        }
        // In the end each order has its outcome: the time for answers is over, or the connection is.
        if driver.up || driver.wanted || driver.closing {
            driver.act(&Act::Lost, Ticket(u64::MAX));
        }
        driver.act(&Act::Wait(20_000), Ticket(u64::MAX));
        for (ticket, outcomes) in driver.outcomes {
            prop_assert_eq!(outcomes, 1, "order {:?}", ticket);
        }
    }
}

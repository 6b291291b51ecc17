//! The state machine: what comes in, what is due, and what goes out.

mod connection;
mod dialogue;
mod ending;
mod hear;
mod imagery;
mod report;
mod tell;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use backseat_s7k::plc::{CommandId, Generic, HealthEntry};
use backseat_s7k::{SensorIndex, StreamReader};
use backseat_units::{Timestamp, Utc};

use crate::alarm::Alarms;
use crate::clock::{ControllerClock, OurClock};
use crate::config::{ConfigError, SonarConfig};
use crate::counts::Counts;
use crate::exchange::{Exchanges, Late};
use crate::io::{Input, Output, Start, Ticket};
use crate::job::{Job, Unset};
use crate::logging::Logging;
use crate::order::{ORDERS_MAX, Order, Outcome};
use crate::outbox::Outbox;
use crate::ping::{GRANTS_MAX, PingGrant, SAMPLES_MAX};
use crate::record::RecordWriter;
use crate::timer::{Timer, Timers};
use crate::vehicle::Vehicle;

pub use ending::SHUTDOWN_WITHIN;

/// How long an order waits to be sent. Then it ends as [`Outcome::TimedOut`].
pub const ORDER_WAIT: Duration = Duration::from_secs(10);

/// The client of the payload controller.
///
/// Hand it what happens with [`Sonar::handle`], then drain [`Sonar::poll_output`] until it is empty, then call again at
/// [`Sonar::poll_timeout`] or when something happens, whichever is first.
#[derive(Debug)]
pub struct Sonar {
    config: SonarConfig,
    grants: Vec<PingGrant>,
    now: Timestamp,
    our_clock: OurClock,
    timers: Timers,
    outbox: Outbox,
    report: report::Report,
    counts: Counts,
    link: Link,
    /// Attempts to connect since the client was last ready.
    attempts: u32,
    /// The controller has said on this connection that it is shutting down.
    controller_ends: bool,
    reader: StreamReader,
    writer: RecordWriter,
    exchanges: Exchanges,
    /// What is still to be said on a new connection.
    setup: VecDeque<Job>,
    orders: VecDeque<Waiting>,
    /// The settings of the mission that are still to be sent on this connection.
    settings: VecDeque<Unset>,
    /// Those that were rejected, and are tried again with the next health check.
    rejected: VecDeque<Unset>,
    /// The sensors that are reported to be starting on this connection.
    starting: BTreeSet<i32>,
    /// Whether imagery that nobody wants was reported on this connection.
    not_subscribed: bool,
    due: Due,
    alarms: Alarms,
    logging: Logging,
    controller_clock: ControllerClock,
    vehicle: Vehicle,
    health: Vec<HealthEntry>,
    /// When each sensor's swath was last reported.
    swaths: BTreeMap<i32, Timestamp>,
    /// Room for the bins of the search for the seabed.
    bins: Vec<f32>,
    /// The order for the shutdown that is under way.
    ending: Option<Ticket>,
}

/// The connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    /// There is none, and the next attempt is at [`Timer::Connect`].
    Waiting,
    /// The driver tries.
    Connecting,
    /// It is up.
    Up {
        /// Everything that is said on a new connection has been said.
        ready: bool,
    },
    /// The driver was asked to reset it.
    Closing {
        /// Why.
        why: &'static str,
    },
    /// There will be none any more.
    Ended,
}

/// An order that waits for its turn.
#[derive(Clone, Debug)]
struct Waiting {
    ticket: Ticket,
    order: Order,
    until: Timestamp,
}

/// What is to be said when nothing else is.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    restore: bool,
    time_sync: bool,
    health: bool,
}

impl Sonar {
    /// A client that has received no input yet. Its first output asks for a connection.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting or grant outside its range.
    pub fn new(config: SonarConfig, start: Start) -> Result<Self, ConfigError> {
        config.check()?;
        check_grants(&config, &start.grants)?;
        let mut sonar = Self {
            reader: StreamReader::new(config.frame_limit_bytes),
            config,
            grants: start.grants,
            now: Timestamp::ZERO,
            our_clock: OurClock::new(start.utc_at_start),
            timers: Timers::default(),
            outbox: Outbox::default(),
            report: report::Report::default(),
            counts: Counts::default(),
            link: Link::Connecting,
            attempts: 0,
            controller_ends: false,
            writer: RecordWriter::default(),
            exchanges: Exchanges::default(),
            setup: VecDeque::new(),
            orders: VecDeque::new(),
            settings: VecDeque::new(),
            rejected: VecDeque::new(),
            starting: BTreeSet::new(),
            not_subscribed: false,
            due: Due::default(),
            alarms: Alarms::default(),
            logging: Logging::default(),
            controller_clock: ControllerClock::default(),
            vehicle: Vehicle::default(),
            health: Vec::new(),
            swaths: BTreeMap::new(),
            bins: Vec::new(),
            ending: None,
        };
        sonar.outbox.link(Output::Connect);
        Ok(sonar)
    }

    /// Handles something that has happened. If `now` is earlier than at the last call, the client takes the last call's.
    pub fn handle(&mut self, now: Timestamp, input: Input<'_>) {
        self.now = self.now.max(now);
        match input {
            Input::Connected => self.connected(),
            Input::Lost => self.lost(),
            Input::Received(bytes) => self.received(bytes),
            Input::Order(ticket, order) => self.ordered(ticket, order),
            Input::Navigation(navigation) => self.navigation(&navigation),
            Input::SoundSpeed(sound_speed) => self.sound_speed(&sound_speed),
            Input::UtcSet(by_nanos) => self.utc_set(by_nanos),
            Input::Timeout => {}
        }
        // No timer is set to a time that is not later than now, so this ends.
        while let Some(timer) = self.timers.expired(self.now) {
            self.expired(timer);
        }
        self.settle();
    }

    /// The next thing that the driver has to do, oldest first; `None` if there is nothing until the next input.
    #[must_use]
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outbox.pop()
    }

    /// When to call [`Sonar::handle`] with [`Input::Timeout`] if nothing happens before. It is later than the last
    /// call's time.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        self.timers.next()
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &SonarConfig {
        &self.config
    }

    /// What could not be used or was dropped since the start.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Whether everything that is said on a new connection has been said.
    #[must_use]
    pub const fn is_ready(&self) -> bool {
        matches!(self.link, Link::Up { ready: true })
    }

    fn expired(&mut self, timer: Timer) {
        match timer {
            Timer::Shutdown => {
                let sent = self.is_saying(CommandId::Shutdown);
                self.finish(Outcome::TimedOut { sent });
            }
            Timer::Connect => self.connect(),
            Timer::Command => self.answer_is_late(),
            Timer::Orders => self.orders_are_late(),
            Timer::Navigation => self.send_navigation(),
            Timer::Environment => self.send_environment(),
            Timer::Health => self.health_is_due(),
            Timer::Counts => self.end_window(),
        }
    }

    fn answer_is_late(&mut self) {
        // The answer may have come with this very call, and another command may be under way since.
        if self.exchanges.deadline().is_none_or(|deadline| deadline > self.now) {
            return;
        }
        match self.exchanges.late() {
            Some(Late::Again) => self.say_again(),
            Some(Late::Ended(end)) => self.end_step(end),
            None => {}
        }
    }

    fn orders_are_late(&mut self) {
        while self.orders.front().is_some_and(|waiting| waiting.until <= self.now) {
            if let Some(waiting) = self.orders.pop_front() {
                self.outcome(waiting.ticket, Outcome::TimedOut { sent: false });
            }
        }
    }

    /// Sends what can be sent, and sets the timers that follow from the state.
    fn settle(&mut self) {
        self.advance();
        self.timers.set_or_stop(Timer::Command, self.exchanges.deadline());
        let orders = self.orders.front().map(|waiting| waiting.until);
        self.timers.set_or_stop(Timer::Orders, orders);
        self.timers
            .set_or_stop(Timer::Navigation, self.vehicle.navigation.due());
        self.timers
            .set_or_stop(Timer::Environment, self.vehicle.environment.due());
        if self.link == Link::Ended {
            self.timers.stop_all();
        } else if self.report.is_in_use(&self.counts) {
            self.timers.set_unless_set(Timer::Counts, self.now + report::WINDOW);
        }
    }

    fn ordered(&mut self, ticket: Ticket, order: Order) {
        let refused = if self.link == Link::Ended {
            Some("the client has ended")
        } else if self.ending.is_some() {
            Some("the controller is being shut down")
        } else if self.orders.len() >= ORDERS_MAX {
            Some("too many orders wait")
        } else {
            order.check(&self.config).err()
        };
        if let Some(why) = refused {
            return self.outcome(ticket, Outcome::refused(why));
        }
        match order {
            Order::Shutdown => return self.shut_down(ticket),
            Order::Logging { on, .. } => self.logging.want(on),
            Order::SwitchFile { .. } => {}
            Order::Set { sensor, ref setting } => self.forget_setting(sensor, setting),
        }
        self.orders.push_back(Waiting {
            ticket,
            order,
            until: self.now + ORDER_WAIT,
        });
    }

    /// An order sets what a setting of the mission has not set yet.
    fn forget_setting(&mut self, sensor: SensorIndex, setting: &Generic) {
        let kind = core::mem::discriminant(setting);
        let other = |unset: &Unset| unset.sensor != sensor || core::mem::discriminant(&unset.setting) != kind;
        self.settings.retain(other);
        self.rejected.retain(other);
    }

    fn utc_set(&mut self, by_nanos: i64) {
        self.our_clock.set(by_nanos);
        self.controller_clock.forget();
        self.due.time_sync = self.config.time_sync;
    }

    fn utc(&self) -> Utc {
        self.our_clock.utc(self.now)
    }
}

fn check_grants(config: &SonarConfig, grants: &[PingGrant]) -> Result<(), ConfigError> {
    let fault = |key: String, found: String, expected: String| Err(ConfigError { key, found, expected });
    if grants.len() > GRANTS_MAX {
        return fault(
            "grants".to_owned(),
            grants.len().to_string(),
            format!("at most {GRANTS_MAX} grants"),
        );
    }
    for (number, grant) in grants.iter().enumerate() {
        let samples = usize::from(grant.samples);
        if !(1..=SAMPLES_MAX).contains(&samples) {
            let expected = format!("within 1 to {SAMPLES_MAX}");
            return fault(format!("grants[{number}].samples"), samples.to_string(), expected);
        }
        if !config.sensor.iter().any(|sensor| sensor.index == grant.sensor) {
            let expected = "the index of a configured sensor".to_owned();
            return fault(format!("grants[{number}].sensor"), grant.sensor.to_string(), expected);
        }
    }
    Ok(())
}

use std::collections::VecDeque;

use backseat_core::plugin::{PluginId, SonarEvent};
use backseat_core::{FromSonar, SonarOutcome, StatusCondition, ToSonar};
use backseat_sonar::{
    Condition, ConfigError, Event, Input, Order, Outcome, Output, PingGrant, Sonar, SonarConfig, Start, Ticket,
};
use backseat_units::{LocalFrame, Timestamp, Utc};

use crate::{from_client, to_client};

/// How many pings of a sensor reach a plugin in a second at most. A controller that floods cannot fill core's log.
pub const PINGS_PER_S_MAX: u32 = 25;
/// The ticket of orders that come from the vehicle. Requests are numbered from 1.
const OF_VEHICLE: Ticket = Ticket(0);

/// That a plugin may see the pings of a sensor, and how finely: a `[[plugin.ping]]` of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PluginPing {
    /// The plugin.
    pub plugin: PluginId,
    /// The sensor, and how finely.
    pub grant: PingGrant,
}

/// What a driver has to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// As [`Output::Connect`].
    Connect,
    /// As [`Output::Disconnect`].
    Disconnect,
    /// As [`Output::Send`].
    Send(Vec<u8>),
    /// Hand this to core.
    Report(FromSonar),
    /// As [`Output::Finished`].
    Finished,
}

/// How many pings of a grant have come in the present second.
#[derive(Clone, Copy, Debug, Default)]
struct Second {
    began: Timestamp,
    pings: u32,
}

/// The client, and the conversions between it and core.
pub struct Bridge {
    client: Sonar,
    frame: LocalFrame,
    utc_at_start: Utc,
    /// By how much our clock was set since the start, nanoseconds.
    utc_set: i64,
    pings: Vec<PluginPing>,
    seconds: Vec<Second>,
    ready: bool,
    told: (String, Vec<StatusCondition>),
    now: Timestamp,
    /// What core is to hear before the client's next output.
    waiting: VecDeque<Act>,
}

impl Bridge {
    /// A bridge with a client that has received no input yet. `frame` is the fence's.
    ///
    /// # Errors
    /// [`ConfigError`] names the first setting or grant outside its range.
    pub fn new(
        config: SonarConfig,
        pings: Vec<PluginPing>,
        frame: LocalFrame,
        utc_at_start: Utc,
    ) -> Result<Self, ConfigError> {
        let start = Start {
            utc_at_start,
            grants: pings.iter().map(|ping| ping.grant).collect(),
        };
        Ok(Self {
            client: Sonar::new(config, start)?,
            frame,
            utc_at_start,
            utc_set: 0,
            seconds: vec![Second::default(); pings.len()],
            pings,
            ready: false,
            told: (String::new(), Vec::new()),
            now: Timestamp::ZERO,
            waiting: VecDeque::new(),
        })
    }

    /// The client's settings.
    #[must_use]
    pub const fn config(&self) -> &SonarConfig {
        self.client.config()
    }

    /// What core wants of the sonars.
    pub fn tell(&mut self, now: Timestamp, wish: ToSonar) {
        let input = match wish {
            ToSonar::Order { request, order } => match to_client::order(&order) {
                Ok(order) => Input::Order(Ticket(request), order),
                Err(why) => {
                    let outcome = SonarOutcome::Failed(why.to_owned());
                    self.waiting
                        .push_back(Act::Report(FromSonar::Outcome { request, outcome }));
                    return;
                }
            },
            ToSonar::VehicleLogs(on) => Input::Order(OF_VEHICLE, Order::Logging { on, file: None }),
            ToSonar::Shutdown => Input::Order(OF_VEHICLE, Order::Shutdown),
            ToSonar::Navigation(sample, rates) => {
                Input::Navigation(to_client::navigation(&sample, rates, |at| self.utc(at)))
            }
            ToSonar::SoundSpeed {
                measured,
                sound_speed_mps,
            } => Input::SoundSpeed(backseat_sonar::VehicleSoundSpeed {
                time: self.utc(measured),
                sound_speed_mps,
            }),
        };
        self.handle(now, input);
    }

    /// What happens on the connection or to the clock, as [`Sonar::handle`] takes it.
    pub fn handle(&mut self, now: Timestamp, input: Input<'_>) {
        self.now = self.now.max(now);
        if let Input::UtcSet(by_nanos) = input {
            self.utc_set = by_nanos;
        }
        self.client.handle(now, input);
    }

    /// When to call [`Bridge::handle`] with [`Input::Timeout`] if nothing happens before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        self.client.poll_timeout()
    }

    /// The next thing that the driver has to do, oldest first; `None` if there is nothing until the next input.
    #[must_use]
    pub fn poll(&mut self) -> Option<Act> {
        loop {
            if let Some(act) = self.waiting.pop_front() {
                return Some(act);
            }
            match self.client.poll_output() {
                Some(Output::Connect) => return Some(Act::Connect),
                Some(Output::Disconnect) => return Some(Act::Disconnect),
                Some(Output::Send(bytes)) => return Some(Act::Send(bytes)),
                Some(Output::Finished) => return Some(Act::Finished),
                Some(Output::Ping(ping)) => self.pinged(&ping),
                Some(Output::Event(event)) => self.happened(&event),
                None => {
                    self.tell_status();
                    return self.waiting.pop_front();
                }
            }
        }
    }

    fn pinged(&mut self, ping: &backseat_sonar::SonarPing) {
        let (Some(to), Some(second)) = (self.pings.get(ping.grant), self.seconds.get_mut(ping.grant)) else {
            return;
        };
        if self.now.since(second.began).as_secs() >= 1 {
            *second = Second {
                began: self.now,
                pings: 0,
            };
        }
        second.pings += 1;
        if second.pings > PINGS_PER_S_MAX {
            return;
        }
        let converted = from_client::ping(ping, &self.frame, |utc| self.timestamp(utc));
        self.report(FromSonar::Ping(to.plugin, converted));
    }

    fn happened(&mut self, event: &Event) {
        if let Event::Outcome { ticket, outcome } = event {
            return self.report(if *ticket == OF_VEHICLE {
                FromSonar::Line(format!("what the vehicle asked for: {outcome}"))
            } else {
                FromSonar::Outcome {
                    request: ticket.0,
                    outcome: outcome_of(outcome),
                }
            });
        }
        // The swath comes once a second: that is for plugins alone.
        if !matches!(event, Event::Swath(_)) {
            self.report(FromSonar::Line(event.to_string()));
        }
        if matches!(event, Event::Ready | Event::Disconnected { .. }) {
            self.is_ready(matches!(event, Event::Ready));
        }
        if let Some(event) = from_client::event(event) {
            self.report(FromSonar::Event(event));
        }
    }

    fn is_ready(&mut self, ready: bool) {
        if core::mem::replace(&mut self.ready, ready) != ready {
            self.report(FromSonar::Event(SonarEvent::Ready(ready)));
        }
    }

    /// Tells core of the state of the sonars if it has changed.
    fn tell_status(&mut self) {
        let text = self.client.status_text();
        let conditions = self.client.conditions().map(|condition| match condition {
            Condition::NotReady => StatusCondition::SonarNotReady,
            Condition::Alarm => StatusCondition::SonarAlarm,
            Condition::Unhealthy => StatusCondition::SonarUnhealthy,
            Condition::NotLogging => StatusCondition::SonarNotLogging,
        });
        let state = (text, conditions.collect::<Vec<_>>());
        if self.told != state {
            self.told.clone_from(&state);
            let (text, conditions) = state;
            self.report(FromSonar::Status { text, conditions });
        }
    }

    fn report(&mut self, report: FromSonar) {
        self.waiting.push_back(Act::Report(report));
    }

    /// Our UTC, by the clock as it is set now.
    fn utc(&self, at: Timestamp) -> Utc {
        let nanos =
            i128::from(self.utc_at_start.as_unix_nanos()) + i128::from(at.as_nanos()) + i128::from(self.utc_set);
        Utc::from_unix_nanos(u64::try_from(nanos).unwrap_or(0))
    }

    /// The time on the clock of the run; its start for what was before that.
    fn timestamp(&self, utc: Utc) -> Timestamp {
        let nanos =
            i128::from(utc.as_unix_nanos()) - i128::from(self.utc_at_start.as_unix_nanos()) - i128::from(self.utc_set);
        Timestamp::from_nanos(u64::try_from(nanos).unwrap_or(0))
    }
}

fn outcome_of(outcome: &Outcome) -> SonarOutcome {
    match outcome {
        Outcome::Accepted { .. } => SonarOutcome::Accepted,
        Outcome::Unconfirmed => SonarOutcome::Unconfirmed,
        Outcome::Incomplete { .. } | Outcome::Rejected | Outcome::Unknown | Outcome::Refused { .. } => {
            SonarOutcome::Failed(outcome.to_string())
        }
        Outcome::TimedOut { .. } => SonarOutcome::TimedOut,
        Outcome::Lost => SonarOutcome::Lost,
    }
}

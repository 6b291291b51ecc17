use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, DvlTriggerRequest, DvlTriggering};
use backseat_units::Timestamp;

use super::times::times;
use crate::context::Context;
use crate::event::{ClientId, DvlTriggerEvent, MvcEventKind};
use crate::file::{DvlTriggerConfig, WorldFile};
use crate::sensors::Trigger;
use crate::server::answers::Regarding;

/// External triggering of the DVL (SPI 5.6, 7.4). While it is triggered externally, the DVL measures only when the line
/// pulses.
///
/// The mock cannot see pulses. It knows from BPDVR whether the payload triggers, and [`DvlTriggerConfig`] says what
/// happens on the trigger line.
#[derive(Debug)]
pub(crate) struct DvlTrigger {
    config: DvlTriggerConfig,
    stops: VecDeque<Timestamp>,
    state: State,
    /// The earliest time at which it is safe to begin.
    safe_from: Timestamp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Internal,
    /// Requested, but not yet safe.
    Asked {
        by: ClientId,
        safe_at: Timestamp,
    },
    External(Line),
    /// BFDVT 0 is sent, and the payload has not yet reported that it has stopped.
    Stopping(Line),
}

/// The trigger line, while the DVL is in external triggering mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Line {
    by: ClientId,
    /// Whether the payload triggers, as its last BPDVR said. "This message must be sent any time either of its fields
    /// would change value", so at first it does not.
    used: bool,
    /// Whether the payload is connected.
    connected: bool,
    last_pulse: Timestamp,
}

impl DvlTrigger {
    pub(crate) fn new(file: &WorldFile) -> Self {
        Self {
            config: file.dvl.clone(),
            stops: times(&file.dvl.stop_at_s),
            state: State::Internal,
            safe_from: Timestamp::ZERO,
        }
    }

    /// Handles the end of a connection, whose payload then no longer triggers.
    pub(crate) fn client_left(&mut self, client: ClientId) {
        match &mut self.state {
            State::External(line) | State::Stopping(line) if line.by == client => line.connected = false,
            State::Asked { by, .. } if *by == client => self.state = State::Internal,
            State::Internal | State::Asked { .. } | State::External(_) | State::Stopping(_) => {}
        }
    }

    /// What triggers the DVL now.
    pub(crate) fn trigger(&self, now: Timestamp) -> Trigger {
        match self.state {
            State::Internal | State::Asked { .. } => Trigger::Internal,
            State::External(line) | State::Stopping(line) if self.pulses(line, now) => {
                Trigger::Pulses(self.config.pulse_period_s)
            }
            State::External(_) | State::Stopping(_) => Trigger::Nothing,
        }
    }

    fn ask(&self, now: Timestamp, by: ClientId) -> State {
        let safe_at = (now + Duration::from_secs_f64(self.config.safe_after_s)).max(self.safe_from);
        State::Asked { by, safe_at }
    }

    fn pulses(&self, line: Line, now: Timestamp) -> bool {
        let now_s = now.as_secs_f64();
        let dead = |fault: &crate::file::LineFault| now_s >= fault.at_s && now_s < fault.at_s + fault.for_s;
        self.config.payload_triggers && line.used && line.connected && !self.config.line_faults.iter().any(dead)
    }
}

/// The result of a BPDVR: the state after it, the event for the log, whether to send BFDVT 0, and why it is refused, if
/// it is.
struct Answer {
    state: State,
    event: Option<DvlTriggerEvent>,
    cease: bool,
    refused: Option<&'static str>,
}

impl DvlTrigger {
    /// BPDVR (SPI 7.4).
    pub(crate) fn request(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &DvlTriggerRequest) {
        if !self.config.triggering_equipped {
            ctx.acknowledge(re, AckStatus::Failed, "no DVL triggering lines are fitted");
            return;
        }
        let answer = self.answer(ctx.now, re.client, request.external, request.triggering);
        self.state = answer.state;
        if let Some(event) = answer.event {
            ctx.note(MvcEventKind::DvlTrigger(event));
        }
        match answer.refused {
            Some(why) => ctx.acknowledge(re, AckStatus::Failed, why),
            None => ctx.acknowledge(re, AckStatus::Succeeded, ""),
        }
        if answer.cease {
            Self::tell(ctx, false);
        }
    }

    /// One step of the vehicle.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) {
        if self.stops.front().is_some_and(|at| *at <= ctx.now) {
            self.stops.pop_front();
            self.stop(ctx);
        }
        match self.state {
            State::Internal => {}
            State::Asked { by, safe_at } => {
                if ctx.now >= safe_at {
                    self.state = State::External(Line {
                        by,
                        used: false,
                        connected: true,
                        last_pulse: ctx.now,
                    });
                    ctx.note(MvcEventKind::DvlTrigger(DvlTriggerEvent::Began));
                    Self::tell(ctx, true);
                }
            }
            State::External(line) => self.watch_line(ctx, line, State::External),
            State::Stopping(line) => self.watch_line(ctx, line, State::Stopping),
        }
    }

    /// "At any time when in external triggering mode the Bluefin vehicle may initiate a stop triggering command."
    fn stop(&mut self, ctx: &mut Context<'_>) {
        let trigger = &mut *self;
        trigger.safe_from = ctx.now + Duration::from_secs_f64(trigger.config.stop_for_s);
        match trigger.state {
            State::External(line) => {
                trigger.state = State::Stopping(line);
                ctx.note(MvcEventKind::DvlTrigger(DvlTriggerEvent::StopOrdered));
                Self::tell(ctx, false);
            }
            State::Asked { by, safe_at } => {
                let safe_at = safe_at.max(trigger.safe_from);
                trigger.state = State::Asked { by, safe_at };
            }
            State::Internal | State::Stopping(_) => {}
        }
    }

    fn watch_line(&mut self, ctx: &mut Context<'_>, mut line: Line, state: fn(Line) -> State) {
        if self.pulses(line, ctx.now) {
            line.last_pulse = ctx.now;
            self.state = state(line);
            return;
        }
        if ctx.now.since(line.last_pulse).as_secs_f64() < self.config.timeout_s {
            return;
        }
        let told_to_stop = matches!(self.state, State::Stopping(_));
        self.state = State::Internal;
        ctx.note(MvcEventKind::DvlTrigger(DvlTriggerEvent::TimedOut));
        if ctx.interpretation.dvl_timeout_announced && !told_to_stop {
            Self::tell(ctx, false);
        }
    }

    fn tell(ctx: &mut Context<'_>, begin: bool) {
        let created = ctx.stamp();
        ctx.publish(None, &DvlTriggering { created, begin }.into());
    }
}

impl DvlTrigger {
    /// The whole table of SPI 7.4: for each state, what the payload wants (`external`) and does (`triggering`).
    fn answer(&self, now: Timestamp, by: ClientId, external: bool, triggering: bool) -> Answer {
        let becomes = |state, event| Answer {
            state,
            event,
            cease: false,
            refused: None,
        };
        match (self.state, external, triggering) {
            (State::Internal, true, false) => becomes(self.ask(now, by), Some(DvlTriggerEvent::Asked(by))),
            (State::Internal, false, false) | (State::Asked { .. }, true, false) => becomes(self.state, None),
            // The payload triggers but was never told to begin. The vehicle tells it to cease, and the payload has to
            // request again.
            (State::Internal | State::Asked { .. }, true, true) => Answer {
                event: Some(DvlTriggerEvent::WithoutLeave(by)),
                refused: Some("triggering not permitted"),
                ..becomes_ceasing(State::Internal)
            },
            (State::Internal, false, true) => Answer {
                event: Some(DvlTriggerEvent::StopAsked),
                ..becomes_ceasing(self.state)
            },
            (State::Asked { .. }, false, _) => Answer {
                cease: triggering,
                ..becomes(State::Internal, Some(DvlTriggerEvent::Internal))
            },
            (State::External(line), true, _) => {
                let line = Line {
                    by,
                    used: triggering,
                    connected: true,
                    ..line
                };
                becomes(State::External(line), None)
            }
            (State::External(line), false, true) => Answer {
                event: Some(DvlTriggerEvent::StopAsked),
                ..becomes_ceasing(State::Stopping(line))
            },
            (State::External(_) | State::Stopping(_), false, false) => {
                becomes(State::Internal, Some(DvlTriggerEvent::Internal))
            }
            // The payload has stopped and still wants to trigger: "the vehicle will re-enter external triggering mode
            // as soon as possible".
            (State::Stopping(_), true, false) => becomes(self.ask(now, by), Some(DvlTriggerEvent::Asked(by))),
            // The payload was told to stop, but continues.
            (State::Stopping(_), _, true) => becomes(self.state, None),
        }
    }
}

const fn becomes_ceasing(state: State) -> Answer {
    Answer {
        state,
        event: None,
        cease: true,
        refused: None,
    }
}

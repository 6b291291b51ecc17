//! The payload's part in triggering the DVL (SPI 5.6, 7.4; safety requirement 017).
//!
//! A request begins with BPDVR 1,0 and lasts until the handshake is over. While it is open, whatever its plugin asks
//! for under the same tag is a step of it. The phases are those of the handshake:
//!
//! ```text
//! Requested  --BFDVT 1-->  Allowed  --the plugin triggers: 1,1-->  Triggering
//! Triggering --the plugin pauses: 1,0-->  Allowed
//! Triggering --the plugin is about to end it: 0,1-->  Ending
//! any        --BFDVT 0-->  Ceasing  --the plugin wants it again: 1,0-->  Requested
//! any        --the plugin ends it: 0,0; or a time is over-->  no request, and the DVL triggers itself
//! ```
//!
//! The vehicle takes the DVL back 5 s after its last trigger. We do not see the triggers. So while a plugin triggers,
//! it repeats its request at least every 5 s; a repetition changes no field and is not sent. Whatever ends a request,
//! one BPDVR 0,0 says so, which needs only the link.

use std::time::Duration;

use backseat_spi::{DvlTriggerRequest as Said, DvlTriggering, ToVehicle};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::plugin::{DvlTriggerRequest, Event, PluginId, Refusal, RequestState};
use crate::refusal::{Reason, Uncontrolled};
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;
use crate::timer::Timer;

/// The vehicle takes the DVL back when it has not been triggered for this long (7.4).
const TRIGGER_WITHIN: Duration = Duration::from_secs(5);
/// How long a plugin that must stop may take to answer that it has stopped, or that it wants to go on later.
const CEASE_WITHIN: Duration = Duration::from_secs(1);
/// The vehicle allows triggering when that is safe, which can take a while. A request waits no longer than this.
const ALLOW_WITHIN: Duration = Duration::from_secs(300);
/// The least time between two answers to BFDVTs that no open request is about. A vehicle that takes the answer for a
/// request would send BFDVT again.
const ANSWER_EVERY: Duration = Duration::from_secs(1);

/// The state of the handshake.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct DvlTrigger {
    open: Option<Handshake>,
    /// When a BFDVT that no request was open for was last answered.
    answered: Option<Timestamp>,
}

/// The one open request.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Handshake {
    request: u64,
    plugin: PluginId,
    tag: u64,
    phase: Phase,
    /// When the phase ends at the latest.
    until: Timestamp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Phase {
    /// BPDVR 1,0 was sent.
    Requested,
    /// BFDVT 1 came.
    Allowed,
    /// BPDVR 1,1 was sent.
    Triggering,
    /// BPDVR 0,1 was sent; BFDVT 0 will answer it.
    Ending,
    /// BFDVT 0 came.
    Ceasing,
}

impl DvlTrigger {
    /// Whether the payload may say that it is triggering.
    pub(crate) fn may_trigger(&self) -> bool {
        self.open
            .is_some_and(|open| matches!(open.phase, Phase::Allowed | Phase::Triggering))
    }
}

impl DvlTrigger {
    /// Whether a plugin's request with this tag is open. If so, what the plugin asks for is a step of it.
    pub(crate) fn continues(&mut self, cx: &mut Context, plugin: PluginId, tag: u64) -> bool {
        if self.open.is_some_and(|open| open.until <= cx.now) {
            // Its time was over before this request came.
            self.timed_out(cx);
        }
        self.open.is_some_and(|open| open.plugin == plugin && open.tag == tag)
    }

    /// Checks a request that begins a handshake, and returns what to send.
    pub(crate) fn check(
        &self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &DvlTriggerRequest,
    ) -> Result<Dispatch, Refusal> {
        self.may_begin(plugin, asked)?;
        let message = self.message(cx, true, false);
        Ok(Dispatch::new("DVR", message, Purpose::DvlTrigger(request)))
    }

    /// The request's BPDVR was sent.
    pub(crate) fn sent(&mut self, cx: &mut Context, plugin: PluginId, request: u64, asked: &DvlTriggerRequest) {
        self.open = Some(Handshake {
            request,
            plugin,
            tag: asked.tag,
            phase: Phase::Requested,
            until: cx.now + ALLOW_WITHIN,
        });
        self.set_timer(cx);
    }

    fn may_begin(&self, plugin: PluginId, asked: &DvlTriggerRequest) -> Result<(), Refusal> {
        match self.open {
            Some(open) if open.plugin == plugin => Err(Reason::TriggerOpen.into()),
            Some(_) => Err(Reason::OtherTriggers.into()),
            None if asked.triggering => Err(not_allowed()),
            None if !asked.external => Err(Reason::NothingToEnd.into()),
            None => Ok(()),
        }
    }

    /// The plugin ends its open request. Neither the rate nor a lack of control prevents that: BPDVR 0,0 may always be
    /// sent.
    pub(crate) fn asked_end(&mut self, cx: &mut Context) {
        let reason = match self.open.map(|open| open.phase) {
            Some(Phase::Requested | Phase::Allowed | Phase::Triggering | Phase::Ending) | None => EndCause::PluginEnded,
            Some(Phase::Ceasing) => EndCause::VehicleStopped,
        };
        self.end(cx, reason);
    }

    /// Takes the next step that the plugin of the open request asks for.
    pub(crate) fn step(&mut self, cx: &mut Context, asked: &DvlTriggerRequest) -> Result<(), Refusal> {
        let Some(open) = self.open else { return Ok(()) };
        match (asked.external, asked.triggering) {
            (true, false) => match open.phase {
                Phase::Requested | Phase::Allowed => {}
                Phase::Triggering => self.say(cx, open, asked, Phase::Allowed, TRIGGER_WITHIN),
                Phase::Ceasing => self.say(cx, open, asked, Phase::Requested, ALLOW_WITHIN),
                Phase::Ending => return Err(Reason::TriggerEnding.into()),
            },
            (true, true) => match open.phase {
                Phase::Allowed => {
                    self.say(cx, open, asked, Phase::Triggering, TRIGGER_WITHIN);
                    cx.transition(open.request, RequestState::Started);
                }
                Phase::Triggering => self.enter(cx, open, Phase::Triggering, TRIGGER_WITHIN),
                Phase::Requested | Phase::Ending | Phase::Ceasing if !is_on(Check::DvlLeave) => {
                    self.say(cx, open, asked, Phase::Triggering, TRIGGER_WITHIN);
                }
                Phase::Requested | Phase::Ending | Phase::Ceasing => return Err(not_allowed()),
            },
            (false, _) => match open.phase {
                Phase::Triggering => self.say(cx, open, asked, Phase::Ending, TRIGGER_WITHIN),
                Phase::Ending => {}
                Phase::Requested | Phase::Allowed | Phase::Ceasing => return Err(not_allowed()),
            },
        }
        Ok(())
    }

    /// Sends a step of the open request, and enters the phase that follows.
    fn say(&mut self, cx: &mut Context, open: Handshake, asked: &DvlTriggerRequest, phase: Phase, within: Duration) {
        let message = self.message(cx, asked.external, asked.triggering);
        let mut command = cx.courtesy("DVR", message.created());
        command.purpose = Purpose::DvlTrigger(open.request);
        if cx.transmit_for(open.plugin.into(), &message, Some(command)) {
            self.enter(cx, open, phase, within);
        } else {
            self.end(cx, EndCause::NotSent);
        }
    }

    fn enter(&mut self, cx: &mut Context, open: Handshake, phase: Phase, within: Duration) {
        let until = cx.now + within;
        self.open = Some(Handshake { phase, until, ..open });
        self.set_timer(cx);
    }

    fn message(&self, cx: &mut Context, external: bool, triggering: bool) -> ToVehicle {
        ToVehicle::DvlTriggerRequest(Said {
            created: cx.stamper.stamp(cx.now, "DVR"),
            external,
            triggering,
        })
    }

    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        let Some(open) = self.open.filter(|open| open.request == request) else {
            return;
        };
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            // This accepts the first step. At a later step the request is past that state, and nothing changes.
            Answer::Done => cx.transition(request, RequestState::Accepted),
            Answer::Refused(text) => self.close(
                cx,
                if self.has_started(cx, request) {
                    RequestState::Ended(Ended::Said(EndCause::VehicleRefused, text.to_owned()))
                } else {
                    RequestState::Failed(Failure::Vehicle(text.to_owned()))
                },
            ),
            Answer::Missing => match open.phase {
                Phase::Requested | Phase::Triggering | Phase::Ending => self.close(
                    cx,
                    if self.has_started(cx, request) {
                        RequestState::Ended(EndCause::NotAcknowledged.into())
                    } else {
                        RequestState::TimedOut
                    },
                ),
                // The vehicle's BFDVT has already answered it.
                Phase::Allowed | Phase::Ceasing => {}
            },
        }
    }

    fn has_started(&self, cx: &Context, request: u64) -> bool {
        cx.ledger
            .get(request)
            .is_some_and(|entry| entry.state == RequestState::Started)
    }

    /// BFDVT.
    pub(crate) fn heard(&mut self, cx: &mut Context, message: &DvlTriggering) {
        cx.heard(message.created);
        let Some(open) = self.open else {
            return self.answer_unasked(cx, message.begin);
        };
        let said = match (message.begin, open.phase) {
            (true, Phase::Requested) => {
                // The vehicle counts its 5 s from when it wrote the message. A message that was held up leaves less of
                // them.
                let age = cx.vehicle.navigation.clock().age(cx.now, cx.utc(), message.created);
                let within = TRIGGER_WITHIN.saturating_sub(age.unwrap_or_default());
                self.enter(cx, open, Phase::Allowed, within);
                true
            }
            (false, Phase::Requested | Phase::Allowed | Phase::Triggering | Phase::Ending) => {
                self.enter(cx, open, Phase::Ceasing, CEASE_WITHIN);
                false
            }
            // A repetition changes nothing. A plugin that must stop asks again first.
            (true, Phase::Allowed | Phase::Triggering | Phase::Ending | Phase::Ceasing) | (false, Phase::Ceasing) => {
                return;
            }
        };
        cx.plugins.tell(open.plugin, Event::DvlTrigger(said));
    }

    /// No request is open: answers that we neither trigger nor want to.
    fn answer_unasked(&mut self, cx: &mut Context, begin: bool) {
        let recent = |at: Timestamp| cx.now.since(at) < ANSWER_EVERY;
        if self.answered.is_some_and(recent) {
            return;
        }
        self.answered = Some(cx.now);
        let what = if begin { "allows" } else { "stops" };
        cx.note(Note::Text {
            text: format!("the vehicle {what} DVL triggering, and no request for it is open"),
        });
        self.say_not_triggering(cx);
    }

    fn say_not_triggering(&mut self, cx: &mut Context) {
        let message = self.message(cx, false, false);
        let command = cx.courtesy("DVR", message.created());
        cx.transmit(&message, Some(command));
    }

    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        let Some(open) = self.open else { return };
        if !is_on(Check::DvlAnswer) {
            return;
        }
        self.end(
            cx,
            match open.phase {
                Phase::Requested => EndCause::NotAllowed,
                Phase::Allowed => EndCause::NotTriggered,
                Phase::Triggering => EndCause::NotGoingOn,
                Phase::Ending => EndCause::NotStopped,
                Phase::Ceasing => EndCause::NotCeased,
            },
        );
    }

    /// Ends the open request, if there is one: BPDVR 0,0 if the link is up.
    pub(crate) fn end(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        self.close(cx, RequestState::Ended(end.into()));
    }

    fn close(&mut self, cx: &mut Context, state: RequestState) {
        let Some(open) = self.open.take() else { return };
        self.set_timer(cx);
        self.say_not_triggering(cx);
        cx.transition(open.request, state);
    }

    /// The link is lost. The vehicle takes the DVL back by itself, 5 s after the last trigger.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        self.answered = None;
        let unanswered = |open: Handshake| {
            let state = cx.ledger.get(open.request).map(|entry| &entry.state);
            matches!(state, Some(RequestState::Sent | RequestState::Pending))
        };
        self.close(
            cx,
            if self.open.is_some_and(unanswered) {
                RequestState::TimedOut
            } else {
                RequestState::Ended(Uncontrolled::LinkDown.into())
            },
        );
    }

    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.open.is_some_and(|open| open.plugin == plugin) {
            self.end(cx, EndCause::PluginFailed);
        }
    }

    fn set_timer(&mut self, cx: &mut Context) {
        cx.monitor.permits.may_trigger = self.may_trigger();
        cx.timers.set_or_stop(Timer::Dvl, self.open.map(|open| open.until));
    }
}

fn not_allowed() -> Refusal {
    Reason::TriggeringNotAllowed.into()
}

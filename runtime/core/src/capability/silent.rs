//! Silent mode (SPI 7.22; safety requirement 018).
//!
//! The vehicle acknowledges a BPSIL twice: first the receipt, then the result, within 2 s, or within 4 s if its
//! tailcone still turns. It leaves silent mode by itself and without a message, after five minutes unless its mission
//! file sets another time. So core counts the five minutes itself. For the plugin they begin when the request was sent,
//! so that it never counts on the silence for too long. For another request they begin with the acknowledgement: as
//! long as the vehicle may be silent, no request may enter silent mode again, because that would not extend it.
//!
//! A silence outlives much of ours. It goes on over a lost link, lost control, the operator's hold, the end of the
//! mission, and the failure of the plugin that asked for it. Only that plugin may end it early.

use backseat_spi::{SilentMode, ToVehicle};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::mutations::{Check, is_on};
use crate::plugin::{PluginId, Refusal, RequestState, SilentRequest};
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Purpose, SILENT_WITHIN};
use crate::session::dispatch::Dispatch;
use crate::timer::Timer;

/// What core knows of the vehicle's silence.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Silent {
    state: State,
    /// How often this process has asked for it.
    entered: u32,
}

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum State {
    /// The vehicle is not silent at our request.
    #[default]
    Normal,
    /// BPSIL 1 was sent.
    Entering(Entry),
    /// The vehicle is silent, or may be.
    Silent(Silence),
    /// BPSIL 0 was sent, for this request.
    Leaving(Silence, u64),
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Entry {
    plugin: PluginId,
    request: u64,
    sent: Timestamp,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Silence {
    /// Who asked for it.
    plugin: PluginId,
    /// The request; `None` if it has ended or was not answered, and the vehicle may be silent all the same.
    entry: Option<u64>,
    /// When the request ends at the latest.
    until: Timestamp,
    /// When the vehicle has surely left silent mode.
    over: Timestamp,
}

impl Silent {
    /// Whether a plugin counts on the vehicle's silence.
    fn is_kept(&self) -> bool {
        match self.state {
            State::Normal => false,
            State::Entering(_) => true,
            State::Silent(silence) | State::Leaving(silence, _) => silence.entry.is_some(),
        }
    }
}

impl Silent {
    /// Checks a request and returns what to send.
    pub(crate) fn check(
        &self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &SilentRequest,
    ) -> Result<Dispatch, Refusal> {
        self.may_ask(cx, plugin, asked.silent)?;
        let message = ToVehicle::SilentMode(SilentMode {
            created: cx.stamper.stamp(cx.now, "SIL"),
            silent: asked.silent,
        });
        Ok(Dispatch::new("SIL", message, Purpose::Silent(request)))
    }

    /// The request's BPSIL was sent.
    pub(crate) fn sent(&mut self, cx: &mut Context, plugin: PluginId, request: u64, asked: &SilentRequest) {
        self.entered += u32::from(asked.silent);
        self.state = match self.state {
            State::Silent(silence) if !asked.silent => State::Leaving(silence, request),
            State::Normal | State::Entering(_) | State::Silent(_) | State::Leaving(..) => State::Entering(Entry {
                plugin,
                request,
                sent: cx.now,
            }),
        };
        cx.vehicle.silent = self.is_kept();
    }

    fn may_ask(&self, cx: &Context, plugin: PluginId, silent: bool) -> Result<(), Refusal> {
        if !cx.link.subscriptions.has("ACK") {
            return Err(Reason::AcknowledgementsOff.into());
        }
        match self.state {
            State::Entering(_) | State::Leaving(..) => Err(Reason::SilenceUnanswered.into()),
            State::Normal if silent => self.may_enter(cx),
            State::Normal => Err(Reason::VehicleNotSilent.into()),
            State::Silent(_) if silent && !is_on(Check::SilentTerm) => self.may_enter(cx),
            State::Silent(silence) if silent => Err(Refusal::Until {
                reason: Reason::AlreadySilent,
                left_s: silence.over.since(cx.now).as_secs_f64(),
            }),
            State::Silent(silence) if silence.plugin != plugin => Err(Reason::OtherSilences.into()),
            State::Silent(_) => Ok(()),
        }
    }

    fn may_enter(&self, cx: &Context) -> Result<(), Refusal> {
        let most = cx.monitor.limits().silences_total_max;
        if self.entered >= most && is_on(Check::SilencesTotal) {
            return Err(Figure::Silences.one_over(most));
        }
        Ok(())
    }

    /// An answer to a BPSIL. The first one acknowledges the receipt, and arrives as pending whatever it says.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match self.state {
            State::Entering(entry) if entry.request == request => self.entry_answered(cx, entry, answer),
            State::Leaving(silence, leave) if leave == request => self.leave_answered(cx, silence, leave, answer),
            State::Normal | State::Entering(_) | State::Silent(_) | State::Leaving(..) => {}
        }
    }

    fn entry_answered(&mut self, cx: &mut Context, entry: Entry, answer: Answer<'_>) {
        let Entry { plugin, request, sent } = entry;
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => {
                let term = cx.monitor.limits().silent_term();
                self.become_silent(
                    cx,
                    State::Silent(Silence {
                        plugin,
                        entry: Some(request),
                        until: sent + term,
                        over: cx.now + term,
                    }),
                );
                cx.transition(request, RequestState::Accepted);
                cx.transition(request, RequestState::Started);
            }
            Answer::Refused(text) => {
                self.become_silent(cx, State::Normal);
                cx.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned())));
            }
            Answer::Missing => self.entry_unanswered(cx, entry),
        }
    }

    /// The vehicle may still fall silent, and no message would say so. It counts as silent for as long as that may
    /// last.
    fn entry_unanswered(&mut self, cx: &mut Context, entry: Entry) {
        let limits = cx.monitor.limits();
        let over = cx.now + limits.link_delay_max() + SILENT_WITHIN + limits.silent_term();
        self.become_silent(
            cx,
            State::Silent(Silence {
                plugin: entry.plugin,
                entry: None,
                until: over,
                over,
            }),
        );
        cx.transition(entry.request, RequestState::TimedOut);
    }

    fn leave_answered(&mut self, cx: &mut Context, silence: Silence, leave: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(leave, RequestState::Pending),
            Answer::Done => {
                self.become_silent(cx, State::Normal);
                self.end_entry(cx, silence, EndCause::NormalAgain.into());
                cx.transition(leave, RequestState::Accepted);
                cx.transition(leave, RequestState::Ended(EndCause::NormalAgain.into()));
            }
            Answer::Refused(text) => {
                self.become_silent(cx, State::Silent(silence));
                cx.transition(leave, RequestState::Failed(Failure::Vehicle(text.to_owned())));
            }
            Answer::Missing => self.leave_unanswered(cx, silence, leave),
        }
    }

    /// The vehicle may be silent or not, so no plugin can count on its silence any more.
    fn leave_unanswered(&mut self, cx: &mut Context, silence: Silence, leave: u64) {
        self.become_silent(cx, State::Silent(Silence { entry: None, ..silence }));
        self.end_entry(cx, silence, EndCause::NotNormal.into());
        cx.transition(leave, RequestState::TimedOut);
    }

    fn end_entry(&mut self, cx: &mut Context, silence: Silence, end: Ended) {
        if let Some(entry) = silence.entry {
            cx.transition(entry, RequestState::Ended(end));
        }
    }

    /// Enters a state, and sets its timer.
    fn become_silent(&mut self, cx: &mut Context, state: State) {
        self.state = state;
        cx.vehicle.silent = self.is_kept();
        let next = match state {
            State::Normal | State::Entering(_) => None,
            State::Silent(silence) | State::Leaving(silence, _) => match silence.entry {
                Some(_) => Some(silence.until),
                None => Some(silence.over).filter(|_| matches!(state, State::Silent(_))),
            },
        };
        cx.timers.set_or_stop(Timer::Silent, next);
    }

    /// A time is over: first the request's, then the vehicle's.
    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        let (silence, next) = match self.state {
            State::Normal | State::Entering(_) => return,
            State::Silent(silence) => {
                let lapsed = Silence { entry: None, ..silence };
                let over = silence.over <= cx.now;
                (silence, if over { State::Normal } else { State::Silent(lapsed) })
            }
            // The answer will say what the vehicle is now.
            State::Leaving(silence, leave) => (silence, State::Leaving(Silence { entry: None, ..silence }, leave)),
        };
        self.become_silent(cx, next);
        let term_s = cx.monitor.limits().silent_term_s;
        self.end_entry(cx, silence, Ended::Said(EndCause::Lapsed, format!("after {term_s} s")));
    }

    /// The link is lost. A silence goes on; an unanswered BPSIL will not be answered any more.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        match self.state {
            State::Normal | State::Silent(_) => {}
            State::Entering(entry) => self.entry_unanswered(cx, entry),
            State::Leaving(silence, leave) => self.leave_unanswered(cx, silence, leave),
        }
    }
}

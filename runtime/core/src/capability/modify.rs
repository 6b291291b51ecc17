//! The modify: one plugin's BPRMB, refreshed for as long as its lease lasts (SPI 7.12, 7.13; safety requirements 003,
//! 004, 008).

use std::time::Duration;

use backseat_spi::{
    EchoedTime, EndModify, HorizontalMode, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode, ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp, utm_convergence_deg};

use crate::arbiter::LeaseKind;
use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::io::Note;
use crate::monitor::envelope::{LeaseReach, Setpoint, Vertical};
use crate::monitor::limits::HeadingFrame;
use crate::mutations::{Check, is_on};
use crate::plugin::{ModifyRequest, PluginId, Refusal, RequestState};
use crate::refusal::Reason;
use crate::session::commands::{Answer, Command, FIRST_WITHIN, Purpose};
use crate::session::name;
use crate::timer::Timer;

/// The vehicle forgets a modify after 5 s (7.12).
const REFRESH_EVERY: Duration = Duration::from_secs(1);
/// If the last BPRMB is older than this, a refresh is too late: the lease ends.
const REFRESH_AT_MOST: Duration = Duration::from_millis(2500);
/// A changed modify is sent at once, at 5 Hz at most.
const REFRESH_AT_LEAST: Duration = Duration::from_millis(200);

/// After a refused or unanswered BPRMB the next lease may begin no sooner than this, doubled at each further one.
const PAUSE_MIN: Duration = Duration::from_secs(1);
const PAUSE_MAX: Duration = Duration::from_secs(60);
/// BPRMB must be answered for this long before the pause is the shortest again.
const PAUSE_FORGIVEN_AFTER: Duration = Duration::from_secs(30);
/// Answers that are further apart than this do not belong to one lease.
const ANSWERS_APART_MAX: Duration = Duration::from_millis(1500);

/// The pause after a BPRMB that the vehicle refused or did not answer, in which no lease begins. Without it, a plugin
/// that insists would have the vehicle under a modify most of the time (safety requirement 023).
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Pause {
    until: Timestamp,
    /// The pause after the next failure.
    next: Option<Duration>,
    /// How long BPRMB has been answered since the last failure, and when it was last answered.
    answered: Duration,
    answered_at: Timestamp,
}

impl Pause {
    fn failed(&mut self, now: Timestamp) {
        let pause = self.next.unwrap_or(PAUSE_MIN);
        self.until = now + pause;
        self.next = Some((2 * pause).min(PAUSE_MAX));
        self.answered = Duration::ZERO;
    }

    fn answered(&mut self, now: Timestamp) {
        let since = now.since(self.answered_at);
        self.answered_at = now;
        if since <= ANSWERS_APART_MAX {
            self.answered += since;
        }
        if self.answered >= PAUSE_FORGIVEN_AFTER {
            self.next = None;
        }
    }

    /// How much longer no lease may begin.
    fn left(&self, now: Timestamp) -> Option<Duration> {
        (now < self.until).then(|| self.until.since(now))
    }
}

/// Who steers, and where to.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Lease {
    plugin: PluginId,
    request: u64,
    tag: u64,
    /// What the newest request asks for. The next BPRMB sends it.
    setpoint: Setpoint,
    /// What the last BPRMB has sent, for this lease or for the one that it replaced: the vehicle flies it.
    flown: Option<Setpoint>,
    /// When the last BPRMB was sent, for this lease or for the one that it replaced.
    sent: Option<Timestamp>,
    /// The times in the first and the last of these BPRMB.
    stamps: Option<(TimeOfDay, TimeOfDay)>,
}

/// The current modify, and when the next one may begin.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Modify {
    lease: Option<Lease>,
    pause: Pause,
    /// When the last BPRMB was sent, for any lease.
    sent: Option<Timestamp>,
}

impl Modify {
    /// When the last BPRMB was sent.
    pub(crate) const fn sent(&self) -> Option<Timestamp> {
        self.sent
    }

    /// Whether a modify may begin: not in the pause after a BPRMB that the vehicle refused or did not answer.
    pub(crate) fn may_begin(&self, cx: &Context) -> Result<(), Refusal> {
        let Some(left) = self.pause.left(cx.now).filter(|_| is_on(Check::LeasePause)) else {
            return Ok(());
        };
        Err(Refusal::Until {
            reason: Reason::ModifyPause,
            left_s: left.as_secs_f64(),
        })
    }

    /// Checks a request and returns what each refresh sends.
    pub(crate) fn check(&self, cx: &Context, plugin: PluginId, asked: &ModifyRequest) -> Result<Setpoint, Refusal> {
        let setpoint = cx.monitor.envelope.admit_modify(asked)?;
        cx.cap_steering(plugin, asked.duration)?;
        self.judge(cx, &setpoint)?;
        Ok(setpoint)
    }

    /// A request replaces the current lease, if there is one. Returns whether it asks for another setpoint than the
    /// vehicle flies.
    pub(crate) fn adopt(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &ModifyRequest,
        setpoint: Setpoint,
    ) -> bool {
        let (mut sent, mut stamps, mut flown) = (None, None, None);
        cx.arbiter.take(cx.now, plugin, LeaseKind::Modify);
        if let Some(lease) = self.lease.take() {
            (sent, stamps, flown) = (lease.sent, lease.stamps, lease.flown);
            if lease.plugin == plugin && lease.tag == asked.tag {
                cx.transition_quietly(lease.request, RequestState::Ended(EndCause::Replaced.into()));
            } else {
                cx.transition(lease.request, RequestState::Ended(EndCause::OtherModify.into()));
            }
        }
        self.lease = Some(Lease {
            plugin,
            request,
            tag: asked.tag,
            setpoint,
            flown,
            sent,
            stamps,
        });
        cx.timers.set(Timer::Term, cx.now + asked.duration);
        flown != Some(setpoint)
    }

    /// Sends the first BPRMB of an adopted modify, or the next one, no sooner than the rate allows.
    pub(crate) fn begin(&mut self, cx: &mut Context, changed: bool) {
        match self.lease.and_then(|lease| lease.sent) {
            // A lease that has just ended counts too: a plugin cannot evade the rate by ending its modify and asking
            // again.
            None => match self.sent.filter(|sent| cx.now.since(*sent) < refresh_at_least()) {
                Some(sent) => cx.timers.set(Timer::Refresh, sent + refresh_at_least()),
                None => self.refresh(cx),
            },
            Some(sent) if changed && cx.now.since(sent) >= refresh_at_least() => self.refresh(cx),
            Some(sent) if changed => cx.timers.set(Timer::Refresh, sent + refresh_at_least()),
            Some(sent) => cx.timers.set(Timer::Refresh, sent + refresh_every()),
        }
    }

    /// Judges a setpoint in full, with what core knows now.
    fn judge(&self, cx: &Context, setpoint: &Setpoint) -> Result<(), Refusal> {
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
            return Err(Reason::NavigationIsStale.into());
        };
        if cx.monitor.limits().modify_needs_plan && !cx.vehicle.plan.is_complete() && is_on(Check::PlanKnown) {
            return Err(Reason::PlanUnknown.into());
        }
        cx.outlook().admit_beside_gps_hit()?;
        if is_on(Check::PlanKnown) {
            cx.outlook().knows_what_is_flown()?;
        }
        let route = cx.outlook().route_of_modify();
        let lock = cx.vehicle.navigation.bottom_lock(cx.now);
        cx.monitor
            .envelope
            .judge_modify(setpoint, navigation, lock, &route, (cx.now, cx.outlook().clocks()))
            .map(|_| ())
    }

    /// Where the lease can lead from here; `None` without one, or without fresh navigation.
    pub(crate) fn reach(&self, cx: &Context) -> Option<LeaseReach> {
        let navigation = cx.vehicle.navigation.fresh(cx.now)?;
        let seen_mps = cx.outlook().route_of_modify().seen_mps;
        let envelope = &cx.monitor.envelope;
        Some(envelope.lease_reach(&self.lease?.setpoint, navigation, seen_mps, cx.now))
    }

    /// A sample of navigation is new. If what the lease can reach from here would touch the fence's margin, the lease
    /// ends now, and not only at its next refresh. A changed setpoint may wait for its turn. Until it is sent, the
    /// vehicle flies the one before, so both are judged.
    pub(crate) fn prevent(&mut self, cx: &mut Context) {
        let Some(lease) = self.lease else { return };
        if !is_on(Check::RefreshJudged) {
            return;
        }
        let flown = lease.flown.filter(|flown| *flown != lease.setpoint);
        let judged = self
            .judge(cx, &lease.setpoint)
            .and_then(|()| flown.map_or(Ok(()), |flown| self.judge(cx, &flown)));
        if let Err(refusal) = judged {
            self.end(cx, refusal);
        }
    }

    /// Judges the lease again, and sends its BPRMB. It is judged even if it was judged at this moment: a message of the
    /// same read may have changed since what core knows of the vehicle.
    pub(crate) fn refresh(&mut self, cx: &mut Context) {
        let Some(lease) = self.lease else { return };
        if let Some(sent) = lease.sent
            && cx.now.since(sent) > REFRESH_AT_MOST
            && is_on(Check::LateWake)
            && is_on(Check::RefreshCadence)
        {
            return self.end(cx, EndCause::NotRefreshed);
        }
        if is_on(Check::RefreshJudged)
            && let Err(refusal) = self.judge(cx, &lease.setpoint)
        {
            return self.end(cx, refusal);
        }
        let Some(navigation) = cx.vehicle.navigation.fresh(cx.now).copied() else {
            return self.end(cx, EndCause::NavigationStale);
        };
        let Setpoint {
            heading,
            vertical,
            speed,
        } = lease.setpoint;
        let heading_deg = match cx.settings.heading_frame {
            HeadingFrame::True => heading.as_deg(),
            HeadingFrame::Grid => heading.to_grid(utm_convergence_deg(navigation.position)).as_deg(),
        };
        let (vertical_m, vertical_mode) = match vertical {
            Vertical::Depth(depth) => (depth.as_m(), ModifyVerticalMode::Depth),
            Vertical::Altitude(altitude) => (altitude.as_m(), ModifyVerticalMode::Altitude),
        };
        let created = cx.stamper.stamp(cx.now, "RMB");
        let message = ToVehicle::ModifyBehavior(ModifyBehavior {
            created,
            horizontal: Some(heading_deg),
            vertical_m: Some(vertical_m),
            vertical_mode: Some(vertical_mode),
            speed: Some(speed.as_mps()),
            speed_mode: Some(ModifySpeedMode::MetresPerSecond),
            horizontal_mode: Some(HorizontalMode::Heading),
        });
        let command = Command {
            name: name("RMB"),
            created: Some(created),
            identifier: None,
            purpose: Purpose::Lease(lease.request),
            deadline: cx.now + FIRST_WITHIN,
            pending: false,
        };
        if !cx.transmit(&message, Some(command)) {
            return self.end(cx, EndCause::NotSent);
        }
        if let Some(lease) = &mut self.lease {
            lease.sent = Some(cx.now);
            lease.flown = Some(lease.setpoint);
            let first = lease.stamps.map_or(created, |(first, _)| first);
            lease.stamps = Some((first, created));
        }
        self.sent = Some(cx.now);
        cx.timers.set(Timer::Refresh, cx.now + refresh_every());
        cx.transition(lease.request, RequestState::Sent);
    }

    /// Ends the lease, if there is one: sends one BPEMB if a BPRMB was sent and the link is up, and nothing after it.
    pub(crate) fn end(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        let end = end.into();
        self.close(cx, end.clone(), RequestState::Ended(end));
    }

    /// As [`Self::end`], with the state in which the lease's request ends.
    pub(crate) fn close(&mut self, cx: &mut Context, end: Ended, state: RequestState) {
        let Some(lease) = self.lease.take() else { return };
        cx.arbiter.release(cx.now, LeaseKind::Modify);
        cx.timers.stop(Timer::Refresh);
        cx.timers.stop(Timer::Term);
        cx.link.commands.forget_lease();
        if lease.sent.is_some() && is_on(Check::LeaseEndSaid) {
            let created = cx.stamper.stamp(cx.now, "EMB");
            let command = cx.courtesy("EMB", Some(created));
            cx.transmit(&ToVehicle::EndModify(EndModify { created }), Some(command));
        }
        cx.transition(lease.request, state);
        cx.note(Note::LeaseEnded {
            plugin: lease.plugin,
            reason: end,
        });
    }

    /// The plugin ends its own lease.
    pub(crate) fn asked_end(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.lease.is_some_and(|lease| lease.plugin == plugin) {
            self.end(cx, EndCause::PluginEnded);
        }
    }

    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        if self.lease.is_some_and(|lease| lease.plugin == plugin) {
            self.end(cx, EndCause::PluginFailed);
        }
    }

    /// An answer to a refresh.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        let live = self.lease.is_some_and(|lease| lease.request == request);
        match answer {
            Answer::Pending => {}
            Answer::Missing if is_on(Check::LeaseAcknowledged) => self.unanswered(cx, request),
            Answer::Missing => {}
            Answer::Done => {
                self.pause.answered(cx.now);
                self.transition_once_accepted(cx, request);
            }
            Answer::Refused(text) if live => {
                self.pause.failed(cx.now);
                let end = Ended::Said(EndCause::VehicleRefused, text.to_owned());
                self.close(cx, end, RequestState::Failed(Failure::Vehicle(text.to_owned())));
            }
            // Another request has replaced the refused one. That is always so for a plugin that asks again in every
            // step: if core waited for the answer to the newest request, it would wait for ever.
            Answer::Refused(text) => {
                self.pause.failed(cx.now);
                self.end(cx, Ended::Said(EndCause::VehicleRefused, text.to_owned()));
            }
        }
    }

    fn transition_once_accepted(&mut self, cx: &mut Context, request: u64) {
        if cx
            .ledger
            .get(request)
            .is_some_and(|entry| entry.state == RequestState::Sent)
        {
            cx.transition(request, RequestState::Accepted);
        }
    }

    /// A refresh was not acknowledged in time.
    fn unanswered(&mut self, cx: &mut Context, request: u64) {
        self.pause.failed(cx.now);
        if self.lease.is_some_and(|lease| lease.request == request) {
            self.close(cx, EndCause::NotAcknowledged.into(), RequestState::TimedOut);
        } else if self.lease.is_some() {
            // The request is an older one of a lease that goes on. The vehicle has been silent for just as long.
            self.end(cx, EndCause::NotAcknowledged);
        }
    }

    /// The vehicle has refused a BPRMB, or not answered it in time, but its lease had ended before. The next lease
    /// waits all the same, or a plugin that ends each lease at once would never wait. During the pause such a BPRMB is
    /// one from before it, and does not make the pause longer. A lease whose first BPRMB has not left yet is the next
    /// lease: it ends.
    pub(crate) fn failed_after_its_end(&mut self, cx: &mut Context, answer: Answer<'_>) {
        if self.pause.left(cx.now).is_none() {
            self.pause.failed(cx.now);
        }
        if self.lease.is_some_and(|lease| lease.sent.is_none()) && is_on(Check::LeasePause) {
            match answer {
                Answer::Refused(text) => self.end(cx, Ended::Said(EndCause::VehicleRefused, text.to_owned())),
                Answer::Missing | Answer::Pending | Answer::Done => self.end(cx, EndCause::NotAcknowledged),
            }
        }
    }

    /// The vehicle refused a BPRMB that does not wait for an answer: it was answered before, or the link changed the
    /// time in it. If the echoed time lies within the life of the current lease, the vehicle can mean no other.
    pub(crate) fn refused_again(&mut self, cx: &mut Context, echo: EchoedTime, text: &str) {
        let within = |(first, last): (TimeOfDay, TimeOfDay)| {
            let time = echo.time();
            !echo.is_none() && time.nanos_since(first) >= 0 && time.nanos_since(last) <= 0
                || echo.echoes(first)
                || echo.echoes(last)
        };
        if self.lease.and_then(|lease| lease.stamps).is_some_and(within) {
            self.pause.failed(cx.now);
            self.end(cx, Ended::Said(EndCause::VehicleRefused, text.to_owned()));
        }
    }
}

/// How long after a refresh the next is due.
fn refresh_every() -> Duration {
    if is_on(Check::RefreshCadence) {
        REFRESH_EVERY
    } else {
        Duration::from_secs(4)
    }
}

/// How long after a refresh a changed modify may leave.
fn refresh_at_least() -> Duration {
    if is_on(Check::ModifyRate) {
        REFRESH_AT_LEAST
    } else {
        Duration::ZERO
    }
}

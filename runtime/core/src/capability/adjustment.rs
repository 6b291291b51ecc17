//! Trim and buoyancy adjustments, from the request to their final status (SPI 6.22, 6.23, 7.23, 7.24).
//!
//! The acknowledgement says that the adjustment has begun. Status messages (BFTRM, BFBOY) report its progress and its
//! end. They come at any time, also for adjustments that the vehicle makes by itself, and in no promised order with
//! BFMBS and the acknowledgement. So no status that comes before the acknowledgement ends a request: it may be the end
//! of another adjustment. The price is a delay: if an adjustment is over before its acknowledgement comes, its request
//! ends only when the vehicle reports idle 10 s or more after the acknowledgement.
//!
//! Only the operator's BPRCB cancels an adjustment. It goes on when its plugin fails, and when control or the link is
//! lost.

use std::time::Duration;

use backseat_spi::{
    AdjustmentError, AdjustmentStatus, BuoyancyAdjustment, BuoyancyStatus, ToVehicle, TrimAdjustment, TrimStatus,
};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::ended::{EndCause, Ended, Failure};
use crate::mutations::{Check, is_on};
use crate::plugin::{BuoyancySample, Event, Refusal, RequestState, Sample, Topic, TrimSample};
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;
use crate::timer::Timer;

/// The vehicle gives up an adjustment after typically 20 minutes (7.23, 7.24), and says so. A request without a final
/// status times out this long after its acknowledgement.
const OVER_WITHIN: Duration = Duration::from_secs(25 * 60);
/// The final status comes within this time after the end of the behavior.
const SAID_WITHIN: Duration = Duration::from_secs(30);
/// If the vehicle reports idle this long after the acknowledgement, the adjustment is over.
const IDLE_AFTER: Duration = Duration::from_secs(10);

/// What is adjusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Adjusts {
    Trim,
    Buoyancy,
}

impl Adjusts {
    const ALL: [Self; 2] = [Self::Trim, Self::Buoyancy];

    /// The letters of the command and of the status message.
    const fn letters(self) -> &'static str {
        match self {
            Self::Trim => "TRM",
            Self::Buoyancy => "BOY",
        }
    }

    /// The refusal if its status is not subscribed.
    const fn unsubscribed(self) -> Reason {
        match self {
            Self::Trim => Reason::TrimUnsubscribed,
            Self::Buoyancy => Reason::BuoyancyUnsubscribed,
        }
    }

    /// Whether a behavior of this type is such an adjustment. SPI does not list the types (6.9), so this compares the
    /// first letters.
    fn is_type(self, kind: &str) -> bool {
        let start = match self {
            Self::Trim => "trim",
            Self::Buoyancy => "buoy",
        };
        kind.get(..start.len())
            .is_some_and(|begins| begins.eq_ignore_ascii_case(start))
    }
}

/// A request that has not ended.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Adjustment {
    request: u64,
    /// An adjustment was in progress before the acknowledgement came.
    begun: bool,
    acknowledged: Option<Timestamp>,
    /// When the request times out; `None` until the acknowledgement.
    deadline: Option<Timestamp>,
}

/// What core knows of the adjustments. There is at most one of each kind at a time.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Adjustments {
    trim: Option<Adjustment>,
    buoyancy: Option<Adjustment>,
    /// How many this process has sent; the mission limits their number.
    sent: u32,
}

impl Adjustments {
    const fn of(&mut self, what: Adjusts) -> &mut Option<Adjustment> {
        match what {
            Adjusts::Trim => &mut self.trim,
            Adjusts::Buoyancy => &mut self.buoyancy,
        }
    }

    fn open(&self) -> impl Iterator<Item = Adjustment> + '_ {
        [self.trim, self.buoyancy].into_iter().flatten()
    }
}

impl Adjustments {
    /// Checks a request and returns what to send.
    pub(crate) fn check(&mut self, cx: &mut Context, request: u64, what: Adjusts) -> Result<Dispatch, Refusal> {
        self.may_ask(cx, what)?;
        let letters = what.letters();
        let created = cx.stamper.stamp(cx.now, letters);
        let message = match what {
            Adjusts::Trim => ToVehicle::TrimAdjustment(TrimAdjustment { created }),
            Adjusts::Buoyancy => ToVehicle::BuoyancyAdjustment(BuoyancyAdjustment { created }),
        };
        Ok(Dispatch::new(letters, message, Purpose::Adjustment(request)))
    }

    /// The request's command was sent.
    pub(crate) const fn sent(&mut self, request: u64, what: Adjusts) {
        self.sent += 1;
        *self.of(what) = Some(Adjustment {
            request,
            begun: false,
            acknowledged: None,
            deadline: None,
        });
    }

    fn may_ask(&mut self, cx: &Context, what: Adjusts) -> Result<(), Refusal> {
        if !cx.link.subscriptions.has(what.letters()) {
            return Err(what.unsubscribed().into());
        }
        if self.of(what).is_some() {
            return Err(Reason::AdjustmentUnderWay.into());
        }
        let most = cx.monitor.limits().adjustments_total_max;
        if self.sent >= most && is_on(Check::AdjustmentsTotal) {
            return Err(Figure::Adjustments.one_over(most));
        }
        Ok(())
    }

    /// The vehicle's answer. Success means that the adjustment has begun.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Refused(text) => self.end(cx, request, RequestState::Failed(Failure::Vehicle(text.to_owned()))),
            Answer::Missing => self.end(cx, request, RequestState::TimedOut),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                let now = cx.now;
                let mut begun = false;
                for what in Adjusts::ALL {
                    if let Some(adjustment) = self.of(what)
                        && adjustment.request == request
                    {
                        adjustment.acknowledged = Some(now);
                        adjustment.deadline = Some(now + OVER_WITHIN);
                        begun = adjustment.begun;
                    }
                }
                if begun {
                    cx.transition(request, RequestState::Started);
                }
                self.set_timer(cx);
            }
        }
    }

    /// BFTRM.
    pub(crate) fn trim_status(&mut self, cx: &mut Context, message: &TrimStatus) {
        cx.heard(message.created);
        let (pitch_deg, roll_deg) = (message.pitch_deg, message.roll_deg);
        let sample = Sample::Trim(TrimSample {
            measured: cx.when(message.created),
            adjusting: message.status == AdjustmentStatus::InProgress,
            pitch_deg,
            roll_deg,
        });
        cx.plugins.tell_wanting(Topic::Trim, &Event::Sample(sample));
        let text = format!("{}, pitch {pitch_deg} deg, roll {roll_deg} deg", message.text.as_str());
        self.heard_status(cx, Adjusts::Trim, message.status, message.error, &text);
    }

    /// BFBOY.
    pub(crate) fn buoyancy_status(&mut self, cx: &mut Context, message: &BuoyancyStatus) {
        cx.heard(message.created);
        let buoyancy_n = message.buoyancy_n;
        let sample = Sample::Buoyancy(BuoyancySample {
            measured: cx.when(message.created),
            adjusting: message.status == AdjustmentStatus::InProgress,
            buoyancy_n,
        });
        cx.plugins.tell_wanting(Topic::Buoyancy, &Event::Sample(sample));
        let text = format!("{}, buoyancy {buoyancy_n} N", message.text.as_str());
        self.heard_status(cx, Adjusts::Buoyancy, message.status, message.error, &text);
    }

    fn heard_status(
        &mut self,
        cx: &mut Context,
        what: Adjusts,
        status: AdjustmentStatus,
        error: AdjustmentError,
        text: &str,
    ) {
        let Some(Adjustment {
            request, acknowledged, ..
        }) = *self.of(what)
        else {
            return;
        };
        match status {
            AdjustmentStatus::InProgress => self.begun(cx, what),
            AdjustmentStatus::Idle => {
                let idle = || RequestState::Ended(Ended::Said(EndCause::Idle, text.to_owned()));
                match cx.ledger.get(request).map(|entry| &entry.state) {
                    Some(RequestState::Started | RequestState::Unknown) => self.end(cx, request, idle()),
                    // An earlier report may have been on its way when the adjustment began.
                    Some(RequestState::Accepted) if acknowledged.is_some_and(|at| cx.now.since(at) >= IDLE_AFTER) => {
                        self.end(cx, request, idle());
                    }
                    Some(
                        RequestState::Accepted
                        | RequestState::Rejected(_)
                        | RequestState::Sent
                        | RequestState::Pending
                        | RequestState::Failed(_)
                        | RequestState::TimedOut
                        | RequestState::Ended(_)
                        | RequestState::Cancelled,
                    )
                    | None => {}
                }
            }
            AdjustmentStatus::Completed => {
                self.over(
                    cx,
                    what,
                    RequestState::Ended(Ended::Said(EndCause::Completed, text.to_owned())),
                );
            }
            AdjustmentStatus::Failed => {
                self.over(
                    cx,
                    what,
                    RequestState::Failed(Failure::Vehicle(format!("{}: {text}", name_of(error)))),
                );
            }
            AdjustmentStatus::Other(_) => {}
        }
    }

    /// The vehicle reports that an adjustment is in progress.
    fn begun(&mut self, cx: &mut Context, what: Adjusts) {
        let Some(adjustment) = self.of(what) else {
            return;
        };
        let request = adjustment.request;
        match cx.ledger.get(request).map(|entry| &entry.state) {
            // It is ours, or one that the vehicle makes by itself; the acknowledgement will show which.
            Some(RequestState::Sent | RequestState::Pending) => adjustment.begun = true,
            Some(RequestState::Unknown) => {
                cx.transition(request, RequestState::Accepted);
                cx.transition(request, RequestState::Started);
            }
            Some(RequestState::Accepted) => cx.transition(request, RequestState::Started),
            Some(
                RequestState::Started
                | RequestState::Rejected(_)
                | RequestState::Failed(_)
                | RequestState::TimedOut
                | RequestState::Ended(_)
                | RequestState::Cancelled,
            )
            | None => {}
        }
    }

    /// A final status. It is the request's if that was acknowledged or may have been, and otherwise another
    /// adjustment's.
    fn over(&mut self, cx: &mut Context, what: Adjusts, state: RequestState) {
        let Some(adjustment) = self.of(what) else {
            return;
        };
        let request = adjustment.request;
        match cx.ledger.get(request).map(|entry| &entry.state) {
            Some(RequestState::Sent | RequestState::Pending) => adjustment.begun = false,
            Some(RequestState::Accepted | RequestState::Started | RequestState::Unknown) => {
                self.end(cx, request, state);
            }
            Some(
                RequestState::Rejected(_)
                | RequestState::Failed(_)
                | RequestState::TimedOut
                | RequestState::Ended(_)
                | RequestState::Cancelled,
            )
            | None => {}
        }
    }

    /// A behavior began or ended that has neither a number of the plan nor an identifier.
    pub(crate) fn behavior(&mut self, cx: &mut Context, began: bool, kind: &str) {
        let until = cx.now + SAID_WITHIN;
        for what in Adjusts::ALL {
            if !what.is_type(kind) {
                continue;
            }
            if began {
                self.begun(cx, what);
            } else if let Some(adjustment) = self.of(what)
                && let Some(deadline) = adjustment.deadline
                && cx
                    .ledger
                    .get(adjustment.request)
                    .is_some_and(|entry| entry.state == RequestState::Started)
            {
                adjustment.deadline = Some(deadline.min(until));
            }
        }
        self.set_timer(cx);
    }

    fn end(&mut self, cx: &mut Context, request: u64, state: RequestState) {
        for what in Adjusts::ALL {
            let open = self.of(what);
            if open.is_some_and(|adjustment| adjustment.request == request) {
                *open = None;
            }
        }
        cx.transition(request, state);
        self.set_timer(cx);
    }

    /// The mission is over, and with it the acknowledged adjustments.
    pub(crate) fn mission_over(&mut self, cx: &mut Context) {
        let open: Vec<Adjustment> = self.open().collect();
        // A request that is not acknowledged yet ends by its answer, or because no answer comes.
        for adjustment in open.into_iter().filter(|adjustment| adjustment.deadline.is_some()) {
            self.end(
                cx,
                adjustment.request,
                RequestState::Ended(EndCause::MissionOver.into()),
            );
        }
    }

    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        let open: Vec<Adjustment> = self.open().collect();
        for adjustment in open {
            if adjustment.deadline.is_some_and(|deadline| deadline <= cx.now) {
                self.end(cx, adjustment.request, RequestState::TimedOut);
            }
        }
        self.set_timer(cx);
    }

    /// The link is lost. An adjustment that was not acknowledged may have begun; its status on the next connection will
    /// show it. An acknowledged one goes on.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        let until = cx.now + OVER_WITHIN;
        for what in Adjusts::ALL {
            if let Some(adjustment) = self.of(what)
                && adjustment.deadline.is_none()
            {
                adjustment.deadline = Some(until);
                let request = adjustment.request;
                cx.transition(request, RequestState::Unknown);
            }
        }
        self.set_timer(cx);
    }

    fn set_timer(&mut self, cx: &mut Context) {
        let first = self.open().filter_map(|open| open.deadline).min();
        cx.timers.set_or_stop(Timer::Adjustment, first);
    }
}

/// The vehicle's error in words (SPI 6.22, 6.23).
const fn name_of(error: AdjustmentError) -> &'static str {
    match error {
        AdjustmentError::None => "failed without an error",
        AdjustmentError::Failed => "the operation failed",
        AdjustmentError::Canceled => "the operation was cancelled",
        AdjustmentError::AtLimit => "at the limit, or no flow",
        AdjustmentError::Idle => "an error while idle",
        AdjustmentError::Other(_) => "an error that SPI 1.12a does not define",
    }
}

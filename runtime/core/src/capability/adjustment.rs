//! Trim and buoyancy adjustments, to their final status (SPI 6.22, 6.23, 7.23, 7.24).
//!
//! The acknowledgement says that the adjustment has begun, the status messages (BFTRM, BFBOY) how it goes and how it ended.
//! Those come at any time, also of adjustments that the vehicle makes by itself, and in no promised order with BFMBS and the
//! acknowledgement. So nothing that comes before the acknowledgement ends a request: it may be the end of another one.
//! What it costs is that one which was over before its acknowledgement is known as such only when the vehicle has said for
//! a while that it is idle.
//!
//! Nothing of ours cancels an adjustment but the operator's BPRCB: it outlives its plugin, control and the link.

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

/// The vehicle gives an adjustment up after typically 20 minutes (7.23, 7.24), and says so; this long after the
/// acknowledgement nothing more is expected.
const OVER_WITHIN: Duration = Duration::from_secs(25 * 60);
/// The final status comes within this of the behavior's end.
const SAID_WITHIN: Duration = Duration::from_secs(30);
/// A vehicle that says that it is idle so long after the acknowledgement has ended what it had begun.
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

    /// Refused where its status is not subscribed.
    const fn unsubscribed(self) -> Reason {
        match self {
            Self::Trim => Reason::TrimUnsubscribed,
            Self::Buoyancy => Reason::BuoyancyUnsubscribed,
        }
    }

    /// Whether a behavior of this type is one of these adjustments: the types are not listed (6.9).
    fn is_type(self, kind: &str) -> bool {
        let start = match self {
            Self::Trim => "trim",
            Self::Buoyancy => "buoy",
        };
        kind.get(..start.len())
            .is_some_and(|begins| begins.eq_ignore_ascii_case(start))
    }
}

/// A request that is not at its end.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Adjustment {
    request: u64,
    /// It has been seen in progress before its acknowledgement.
    begun: bool,
    acknowledged: Option<Timestamp>,
    /// When it is given up; `None` while its acknowledgement is awaited.
    deadline: Option<Timestamp>,
}

/// What is known of the adjustments: one of each kind at a time.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Adjustments {
    trim: Option<Adjustment>,
    buoyancy: Option<Adjustment>,
    /// In the whole mission.
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
    /// What a request sends, where it can be sent.
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

    /// The request's command has left.
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

    /// The vehicle's answer: done is begun.
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
                    // Said at once, it may have been on its way when the adjustment began.
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

    /// The vehicle is at it.
    fn begun(&mut self, cx: &mut Context, what: Adjusts) {
        let Some(adjustment) = self.of(what) else {
            return;
        };
        let request = adjustment.request;
        match cx.ledger.get(request).map(|entry| &entry.state) {
            // Ours, or one that the vehicle makes by itself: the acknowledgement tells.
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

    /// A final status: of the request where that has been acknowledged or may have been, else of another adjustment.
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

    /// A behavior that is neither the plan's nor an identified insert has begun or ended.
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

    /// The mission is over, and what it was doing.
    pub(crate) fn mission_over(&mut self, cx: &mut Context) {
        let open: Vec<Adjustment> = self.open().collect();
        // One that is not acknowledged yet ends by its answer, or by the lack of one.
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

    /// The link is gone: one that was not acknowledged may have begun, which its status tells on the next connection. One
    /// that was goes on.
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

/// What is wrong, in words (SPI 6.22, 6.23).
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

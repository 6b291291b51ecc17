//! The start of an empty mission (SPI 7.20): one that does what the payload asks for and nothing else.

use std::time::Duration;

use backseat_spi::{DurationUnit, StartEmptyMission, ToVehicle};
use backseat_units::Timestamp;

use super::Orders;
use crate::capability::Capabilities;
use crate::context::Context;
use crate::ended::{EndCause, Failure};
use crate::ledger::RequestKind;
use crate::plugin::{Refusal, RequestState};
use crate::refusal::{Figure, Reason, Uncontrolled};
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;
use crate::vehicle::phase::Phase;

/// If BFMIS does not say `Running` within this time after the acknowledgement, the mission has not started.
const RUNS_WITHIN: Duration = Duration::from_secs(30);

/// The empty mission that is being started.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(super) struct EmptyMission {
    request: u64,
    /// When core gives it up; `None` while core waits for its acknowledgement.
    deadline: Option<Timestamp>,
}

impl EmptyMission {
    pub(super) fn deadline(self) -> Option<Timestamp> {
        self.deadline
    }
}

impl Orders {
    pub(super) fn order_empty_mission(&mut self, cx: &mut Context, capabilities: &mut Capabilities, duration_s: u32) {
        let request = cx.ledger.propose_order(RequestKind::StartEmptyMission);
        if let Err(refusal) = self.admit_empty_mission(cx, duration_s) {
            return cx.reject(request, refusal);
        }
        capabilities.end_leases(cx, EndCause::EmptyMission);
        let (duration, unit) = in_units(duration_s);
        let created = cx.stamper.stamp(cx.now, "SEM");
        let message = ToVehicle::StartEmptyMission(StartEmptyMission {
            created,
            duration: f64::from(duration),
            unit,
        });
        if cx.send_request(request, &Dispatch::new("SEM", message, Purpose::EmptyMission(request))) {
            self.empty = Some(EmptyMission {
                request,
                deadline: None,
            });
        }
    }

    fn admit_empty_mission(&self, cx: &mut Context, duration_s: u32) -> Result<(), Refusal> {
        if !cx.control.armed {
            return Err(Uncontrolled::NotArmed.into());
        }
        if !cx.link.is_up() {
            return Err(Uncontrolled::LinkDown.into());
        }
        if cx.control.held {
            return Err(Uncontrolled::OperatorHolds.into());
        }
        if cx.control.stopping {
            return Err(Uncontrolled::RunEnding.into());
        }
        if duration_s == 0 {
            return Err(Figure::EmptyMission.under(0.0, 1.0));
        }
        if self.empty.is_some() {
            return Err(Reason::EmptyMissionStarting.into());
        }
        match cx.vehicle.phase {
            Phase::Over => Ok(()),
            Phase::Running => Err(Reason::MissionRunning.into()),
            Phase::Ending => Err(Reason::MissionEnding.into()),
            Phase::Unknown => Err(Reason::MissionStateUnknown.into()),
        }
    }

    /// Handles the vehicle's answer.
    pub(crate) fn empty_answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                if let Some(empty) = self.empty.as_mut().filter(|empty| empty.request == request) {
                    empty.deadline = Some(cx.now + RUNS_WITHIN);
                    self.set_timer(cx);
                }
            }
            Answer::Refused(text) => {
                self.end_empty_mission(cx, request, RequestState::Failed(Failure::Vehicle(text.to_owned())))
            }
            Answer::Missing => self.end_empty_mission(cx, request, RequestState::TimedOut),
        }
    }

    fn end_empty_mission(&mut self, cx: &mut Context, request: u64, state: RequestState) {
        if self.empty.is_some_and(|empty| empty.request == request) {
            self.empty = None;
        }
        cx.transition(request, state);
    }

    /// BFMIS says that a mission runs. It may come before the acknowledgement or after it.
    pub(super) fn empty_mission_runs(&mut self, cx: &mut Context) {
        if let Some(empty) = self.empty.take() {
            cx.transition(empty.request, RequestState::Started);
            cx.transition(empty.request, RequestState::Ended(EndCause::Runs.into()));
        }
    }

    /// The answer is lost, but on the next connection BFMIS shows whether the mission runs.
    pub(super) fn empty_mission_link_lost(&mut self, cx: &mut Context) {
        if let Some(empty) = &mut self.empty {
            let request = empty.request;
            empty.deadline.get_or_insert(cx.now + RUNS_WITHIN);
            // If the request was accepted, it stays accepted: the ledger refuses this transition.
            cx.transition(request, RequestState::Unknown);
        }
    }

    pub(super) fn empty_mission_expired(&mut self, cx: &mut Context) {
        if let Some(empty) = self.empty
            && empty.deadline.is_some_and(|deadline| deadline <= cx.now)
        {
            self.end_empty_mission(cx, empty.request, RequestState::TimedOut);
        }
    }
}

/// A duration in the largest unit that represents it exactly.
const fn in_units(duration_s: u32) -> (u32, DurationUnit) {
    if duration_s.is_multiple_of(3600) {
        (duration_s / 3600, DurationUnit::Hours)
    } else if duration_s.is_multiple_of(60) {
        (duration_s / 60, DurationUnit::Minutes)
    } else {
        (duration_s, DurationUnit::Seconds)
    }
}

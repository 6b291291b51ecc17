use core::time::Duration;

use backseat_units::{EastNorth, Timestamp};

use super::Executive;
use crate::event::{CancelCause, EndReason, ModifyEnd, Refusal, Source, Status};
use crate::file::WrapUp;
use crate::plan::PlanItem;
use crate::vehicle::Vertical;

const NO_MISSION: &str = "no mission is running";

/// Ends behaviors, elements and missions early, and starts an empty mission.
impl Executive {
    /// BPRCB (SPI 7.10): ends the current behavior, whichever client it belongs to, and begins the next one.
    pub(crate) fn cancel_current(&mut self, now: Timestamp, at: EastNorth) -> Result<(), String> {
        self.may_cancel()?;
        if self
            .running
            .as_ref()
            .is_none_or(|running| running.behavior.source == Source::Empty)
        {
            return Err("no behavior is running".to_owned());
        }
        self.next(now, at, EndReason::Cancelled);
        self.update_control(now, at);
        Ok(())
    }

    /// BPRCE (SPI 7.11): ends the current element of the plan with all its behaviors, and with the inserts at its end,
    /// because "control passes immediately to the next element".
    pub(crate) fn cancel_element(&mut self, now: Timestamp, at: EastNorth) -> Result<(), String> {
        self.may_cancel()?;
        if self.empty {
            return Err("an empty mission has no elements".to_owned());
        }
        if self.inserts_after() == self.index + 1 {
            self.drop_queue(CancelCause::ElementCancelled, |_| true);
        }
        self.end_running(EndReason::ElementCancelled);
        self.paused.clear();
        self.interrupting = false;
        match self.plan.iter().position(|item| item.element > self.element) {
            Some(index) => self.begin_planned(index, now, at),
            None => self.end_mission(false, ""),
        }
        self.update_control(now, at);
        Ok(())
    }

    fn may_cancel(&self) -> Result<(), String> {
        if !self.is_running() {
            return Err(NO_MISSION.to_owned());
        }
        if !self.control {
            return Err(Refusal::NotAllowed.to_string());
        }
        Ok(())
    }

    /// BPABT (SPI 7.16), or a fault of the vehicle: ends the mission and begins its wrap-up, whether the payload has
    /// control or not.
    pub(crate) fn abort(&mut self, errors: bool, details: &str) -> Result<(), &'static str> {
        match self.status {
            Status::Running => {
                self.end_mission(errors, details);
                Ok(())
            }
            Status::WrappingUp | Status::Aborting => Err("the mission is already ending"),
            Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Ready
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => Err(NO_MISSION),
        }
    }

    /// BPKIL (SPI 7.17): ends the mission and all movement, also during a wrap-up.
    pub(crate) fn kill(&mut self, details: &str) -> Result<(), &'static str> {
        match self.status {
            Status::Running | Status::WrappingUp | Status::Aborting => {
                self.finish(Status::Stopped, details);
                Ok(())
            }
            Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Ready
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => Err(NO_MISSION),
        }
    }

    /// BPSEM (SPI 7.20). It replaces a mission that is loaded but has not started.
    pub(crate) fn start_empty(&mut self, now: Timestamp, at: EastNorth, most: Duration) -> Result<(), &'static str> {
        match self.status {
            Status::Running | Status::WrappingUp | Status::Aborting => return Err("a mission is running"),
            Status::Offline => return Err("the vehicle is offline"),
            Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Ready
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => {}
        }
        self.released = true;
        (self.starts_at, self.called_off_at) = (None, None);
        self.plan.clear();
        self.used.clear();
        self.empty = true;
        self.ends_at = Some(now + most);
        self.cruise = (Vertical::Depth(0.0), self.performance.speed_max_mps / 2.0);
        self.set_status(Status::Running, "");
        self.begin_wait(now, at);
        self.update_control(now, at);
        Ok(())
    }

    /// Ends everything that is flown or requested in this dive, so that another one can replace it.
    pub(crate) fn end_dive(&mut self) {
        self.end_suspension();
        self.end_running(EndReason::MissionOver);
        self.end_modify(ModifyEnd::MissionOver);
        self.paused.clear();
        self.interrupting = false;
        self.drop_queue(CancelCause::MissionOver, |_| true);
    }

    /// Call it after [`Executive::end_dive`]. Sets another plan, and begins its first behavior if the mission is
    /// running.
    pub(crate) fn begin_dive(&mut self, plan: Vec<PlanItem>, now: Timestamp, at: EastNorth) {
        self.plan = plan;
        (self.index, self.element) = (0, 0);
        if self.is_running() {
            self.begin_planned(0, now, at);
            self.update_control(now, at);
        }
    }

    /// Reports the status again.
    pub(crate) fn tell_status(&mut self) {
        let details = self.details.clone();
        self.set_status(self.status, details.as_str());
    }

    /// Ends the mission, and begins its wrap-up if it has one.
    pub(super) fn end_mission(&mut self, errors: bool, details: &str) {
        let status = match (self.limits.wrap_up, errors) {
            (WrapUp::None, false) => Status::Completed,
            (WrapUp::None, true) => Status::Aborted,
            (WrapUp::Surface, false) => Status::WrappingUp,
            (WrapUp::Surface, true) => Status::Aborting,
        };
        self.finish(status, details);
    }
}

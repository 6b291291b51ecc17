use core::time::Duration;

use backseat_units::{EastNorth, Timestamp};

use super::{Executive, Running};
use crate::course::Course;
use crate::event::{Behavior, CancelCause, EndReason, MvcEventKind, Source, Status};
use crate::file::WrapUp;
use crate::insert::Insert;

/// What comes after what.
impl Executive {
    /// Ends the running behavior and begins what comes after it: an insert, what was interrupted, the next element.
    pub(super) fn next(&mut self, now: Timestamp, at: EastNorth, reason: EndReason) {
        self.stop_mission_clock(now);
        self.end_running(reason);
        if let Some(insert) = self.queue.pop_front() {
            self.begin_insert(insert, now, at);
            return;
        }
        self.interrupting = false;
        if let Some((mut running, since)) = self.paused.take() {
            let pause = now.since(since);
            running.course.resume(pause);
            running.began = running.began + pause;
            self.begin(running);
        } else if self.index + 1 < self.plan.len() {
            self.begin_planned(self.index + 1, now, at);
        } else {
            match self.limits.wrap_up {
                WrapUp::None => self.finish(Status::Completed, "", EndReason::Done),
                WrapUp::Surface => self.finish(Status::WrappingUp, "", EndReason::Done),
            }
        }
    }

    pub(super) fn end_running(&mut self, reason: EndReason) -> Option<Running> {
        let running = self.running.take()?;
        (self.modified, self.modify_barred) = (Duration::ZERO, false);
        self.log.push(MvcEventKind::BehaviorEnded(running.behavior, reason));
        Some(running)
    }

    pub(super) fn begin_planned(&mut self, index: usize, now: Timestamp, at: EastNorth) {
        let item = self.plan[index];
        (self.index, self.element_began) = (index, now);
        self.begin(Running {
            behavior: Behavior {
                source: Source::Plan(item.number),
                kind: item.shape.kind(),
            },
            course: Course::begin(item.shape, at, now),
            vertical: item.vertical,
            speed_mps: item.speed_mps,
            began: now,
            timeout: item.timeout,
            insert: None,
        });
    }

    pub(super) fn begin_insert(&mut self, insert: Insert, now: Timestamp, at: EastNorth) {
        let shape = insert.flown(self.interpretation.lead_in_m);
        self.begin(Running {
            behavior: Behavior {
                source: Source::Insert(insert.id),
                kind: shape.kind(),
            },
            course: Course::begin(shape, at, now),
            vertical: insert.vertical,
            speed_mps: insert.speed_mps,
            began: now,
            timeout: None,
            insert: Some(insert),
        });
    }

    pub(super) fn begin(&mut self, running: Running) {
        self.log.push(MvcEventKind::BehaviorBegan(running.behavior));
        self.running = Some(running);
    }

    /// The mission leaves `Running`.
    pub(super) fn finish(&mut self, status: Status, details: &'static str, reason: EndReason) {
        self.end_suspension();
        self.end_running(reason);
        self.paused = None;
        self.drop_queue(CancelCause::MissionOver, |_| true);
        self.status = status;
        self.set_control(false);
        self.log.push(MvcEventKind::Mission { status, details });
    }

    pub(super) fn set_status(&mut self, status: Status, details: &'static str) {
        self.status = status;
        self.log.push(MvcEventKind::Mission { status, details });
    }
}

use core::time::Duration;

use backseat_spi::Text;
use backseat_units::{EastNorth, Timestamp};

use super::{Executive, Running};
use crate::event::mission::{MissionEvent, Told};
use crate::event::{Behavior, CancelCause, EndReason, ModifyEnd, MvcEventKind, Source, Status};
use crate::plan::course::Course;
use crate::plan::insert::Insert;
use crate::plan::{PayloadText, Shape};
use crate::vehicle::Vertical;

/// The order of behaviors.
impl Executive {
    /// Ends the running behavior and begins what comes after it: an insert, the interrupted behavior, or the next
    /// behavior of the plan.
    pub(super) fn next(&mut self, now: Timestamp, at: EastNorth, reason: EndReason) {
        self.stop_mission_clock(now);
        let in_set = self.end_running(reason).is_some_and(|ended| ended.insert.is_some());
        let due = in_set || self.inserts_after() == self.index + 1;
        if due && let Some(insert) = self.queue.pop_front() {
            self.begin_insert(insert, now, at);
            return;
        }
        self.interrupting = false;
        if let Some((mut running, since)) = self.paused.pop() {
            let pause = now.since(since);
            running.course.resume(pause);
            running.began = running.began + pause;
            self.begin(running);
        } else if self.empty {
            self.begin_wait(now, at);
        } else if self.index + 1 < self.plan.len() {
            self.begin_planned(self.index + 1, now, at);
        } else {
            self.end_mission(false, "");
        }
    }

    pub(super) fn end_running(&mut self, reason: EndReason) -> Option<Running> {
        let mut running = self.running.take()?;
        (self.modified, self.modify_barred) = (Duration::ZERO, false);
        // Each BFBDL is followed by its BFSDL, even if the line is not flown to its end.
        if core::mem::take(&mut running.logging)
            && let Some(message) = &running.message
        {
            let told = MissionEvent::told(message, Told::LoggingEnds);
            self.log.push(MvcEventKind::Executive(told));
        }
        self.log.push(MvcEventKind::BehaviorEnded(running.behavior, reason));
        if !self.interpretation.modify_survives {
            self.end_modify(ModifyEnd::BehaviorEnded);
        }
        Some(running)
    }

    pub(super) fn begin_planned(&mut self, index: usize, now: Timestamp, at: EastNorth) {
        let Some(item) = self.plan.get(index) else { return };
        self.index = index;
        if self.element != item.element {
            (self.element, self.element_began) = (item.element, now);
        }
        let command = item.shape == Shape::Command;
        if !command {
            let least_mps = self.performance.speed_min_mps.max(0.05);
            self.cruise = (item.vertical, item.speed_mps.max(least_mps));
        }
        let running = Running {
            behavior: Behavior {
                source: Source::Plan(item.number),
                kind: item.shape.kind(),
            },
            course: Course::begin(item.shape.with_leads(item.lead_m), at, now),
            vertical: item.vertical,
            speed_mps: item.speed_mps,
            began: now,
            timeout: item.timeout,
            insert: None,
            message: item.message.clone().or_else(|| logged(&item.shape)),
            logging: false,
        };
        let text = running.message.clone().filter(|_| command);
        self.begin(running);
        if let Some(text) = text {
            let told = MissionEvent::told(&text, Told::Command);
            self.log.push(MvcEventKind::Executive(told));
        }
    }

    pub(super) fn begin_insert(&mut self, insert: Insert, now: Timestamp, at: EastNorth) {
        let shape = insert.shape.with_leads(self.interpretation.lead_in_m);
        let logs = self.interpretation.insert_logging;
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
            message: logs.then(|| logged(&shape)).flatten(),
            logging: false,
        });
    }

    /// An empty mission waits for requests of the payload.
    pub(super) fn begin_wait(&mut self, now: Timestamp, at: EastNorth) {
        self.begin(Running {
            behavior: Behavior {
                source: Source::Empty,
                kind: Shape::Idle.kind(),
            },
            course: Course::begin(Shape::Idle, at, now),
            vertical: Vertical::Depth(0.0),
            speed_mps: 0.0,
            began: now,
            timeout: None,
            insert: None,
            message: None,
            logging: false,
        });
    }

    pub(super) fn begin(&mut self, running: Running) {
        self.log.push(MvcEventKind::BehaviorBegan(running.behavior));
        self.running = Some(running);
    }

    /// Ends the mission or its wrap-up and sets its new status.
    pub(super) fn finish(&mut self, status: Status, details: &str) {
        self.released = true;
        self.end_suspension();
        self.end_running(EndReason::MissionOver);
        self.paused.clear();
        self.interrupting = false;
        self.drop_queue(CancelCause::MissionOver, |_| true);
        self.status = status;
        self.set_control(false);
        self.details = Text::cleaned(details);
        self.set_status(status, details);
    }

    pub(super) fn set_status(&mut self, status: Status, details: &str) {
        self.status = status;
        let details = Text::cleaned(details);
        self.log.push(MvcEventKind::Mission { status, details });
    }
}

/// The text with which the payload is told to log along a trackline or trackcircle for which the plan has none: an
/// empty one, for every client. SPI 5.3: "will be sent when beginning the lead-in trackline".
fn logged(shape: &Shape) -> Option<PayloadText> {
    shape.is_leg().then(|| PayloadText {
        role: None,
        text: Text::default(),
    })
}

use backseat_units::Timestamp;

use super::Mvc;
use crate::event::MvcEventKind;
use crate::faults::timeline::{Effect, Timeline};
use crate::faults::{Fault, FaultEdge, FaultPlan, SensorFailure};

/// What goes wrong: each effect of a fault to the part of the vehicle that it is of.
impl Mvc {
    /// Breaks navigation or a sensor, or mends it.
    pub fn fail_sensor(&mut self, failure: SensorFailure) {
        self.sensors.fail(failure);
    }

    /// Replaces what goes wrong in this run: what acts ends, and what ought to act by the new plan begins at once. A
    /// fault that is over by then is left out.
    ///
    /// The driver of the link plays its faults by [`crate::LinkFaults`], made from the same plan.
    pub fn set_faults(&mut self, plan: FaultPlan) {
        let now = self.last_tick;
        for index in self.faults.acting() {
            self.fault(now, index, FaultEdge::End);
        }
        self.faults = Timeline::of(plan, now);
    }

    /// Something goes wrong from now on, whatever `fault.at` says, for as long as the fault lasts. It is counted after
    /// those that the run has had, and does what it would have done as a part of the plan, but that all that was due by
    /// now has happened before it.
    ///
    /// Of a fault of the link only begin and end are told here: its driver plays it by [`crate::LinkFaults::inject`] and
    /// [`crate::FaultyLink::inject`].
    pub fn inject(&mut self, now: Timestamp, fault: Fault) {
        self.handle_timeout(now);
        let instant = fault.lasts.is_zero();
        let index = self.faults.inject(now, fault);
        self.fault(now, index, FaultEdge::Begin);
        if instant {
            self.fault(now, index, FaultEdge::End);
        }
        self.settle(now);
    }

    /// Every fault that is due at `at`, and every acknowledgement that one has held back until then.
    pub(super) fn step_faults(&mut self, at: Timestamp) {
        while let Some((index, edge)) = self.faults.next_due(at) {
            self.fault(at, index, edge);
        }
        self.server.send_late(at);
        self.settle(at);
    }

    fn fault(&mut self, at: Timestamp, index: usize, edge: FaultEdge) {
        let (event, effect) = self.faults.act(index, edge);
        self.server.note(at, MvcEventKind::Fault(event));
        let mut parts = self.parts(at);
        match effect {
            Effect::None => {}
            Effect::Acknowledgements(index, kind, edge) => {
                self.server.fault(index, &kind, edge == FaultEdge::Begin);
            }
            Effect::Control(denied) => parts.mission.deny_control(denied),
            Effect::Sensors(failure) => parts.sensors.fail(failure),
            Effect::Untrue(index, untrue) => parts.sensors.say_untrue(index, untrue),
            Effect::AnotherDive(file, reversed) => {
                parts.mission.change_dive(&mut parts.ctx, file, reversed);
            }
            Effect::Clock(nanos) => self.server.step_clock(nanos),
            Effect::Abort => parts.mission.fail("aborted by the vehicle"),
            Effect::Shutdown(edge) => {
                if parts.services.shut_down(&mut parts.ctx, edge == FaultEdge::Begin) {
                    self.settle(at);
                }
            }
        }
    }
}

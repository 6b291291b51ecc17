use backseat_units::Timestamp;

use super::Mvc;
use crate::event::MvcEventKind;
use crate::faults::timeline::{Effect, Timeline};
use crate::faults::{Fault, FaultEdge, FaultPlan, SensorFailure};

/// Applies each effect of a fault to the part of the vehicle that it concerns.
impl Mvc {
    /// Breaks navigation or a sensor, or repairs it.
    pub fn fail_sensor(&mut self, failure: SensorFailure) {
        self.sensors.fail(failure);
    }

    /// Replaces the fault plan of this run. All faults that act now end. Faults of the new plan that should already act
    /// begin at once; faults that should already be over are left out.
    ///
    /// The driver of the link must play the faults of the link with [`crate::LinkFaults`] from the same plan.
    pub fn set_faults(&mut self, plan: FaultPlan) {
        let now = self.last_tick;
        for index in self.faults.acting() {
            self.fault(now, index, FaultEdge::End);
        }
        self.faults = Timeline::of(plan, now);
    }

    /// Begins a fault now, whatever `fault.at` says. The fault lasts as long as it says. Its number follows those of
    /// the plan and of the faults injected before. It acts as it would as part of the plan, but after everything that
    /// is due by `now`.
    ///
    /// For a fault of the link this only logs the begin and the end. The link's driver plays it with
    /// [`crate::LinkFaults::inject`] and [`crate::FaultyLink::inject`].
    pub fn inject(&mut self, now: Timestamp, fault: Fault) {
        self.handle_timeout(now);
        self.begin_now(now, fault);
        self.settle(now);
        self.fire(now);
    }

    /// Begins a fault that is not in the plan.
    pub(super) fn begin_now(&mut self, now: Timestamp, fault: Fault) {
        let instant = fault.lasts.is_zero();
        let index = self.faults.inject(now, fault);
        self.fault(now, index, FaultEdge::Begin);
        if instant {
            self.fault(now, index, FaultEdge::End);
        }
    }

    /// Carries out every begin and end of a fault that is due at `at`, and sends the acknowledgements that a fault has
    /// delayed until then.
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

//! Whether control is ours.

use super::Context;
use crate::mutations::{Check, is_on};
use crate::refusal::Uncontrolled;

impl Context {
    /// Why we have no control; `None` if it is ours.
    pub(crate) fn lost_because(&self) -> Option<Uncontrolled> {
        let expects_plan = self.settings.expected_plan.is_some();
        let reason = if !self.link.is_up() {
            Uncontrolled::LinkDown
        } else if self.control.stopping {
            Uncontrolled::RunEnding
        } else if self.control.held {
            Uncontrolled::OperatorHolds
        } else if self.control.mission_ended {
            Uncontrolled::OperatorEnded
        } else if self.control.handed_over.is_none() && is_on(Check::ControlKnown) {
            Uncontrolled::ControlUnknown
        } else if self.control.handed_over == Some(false) && is_on(Check::ControlGiven) {
            Uncontrolled::VehicleHasControl
        } else if self.control.running.is_none() && is_on(Check::ControlKnown) {
            Uncontrolled::MissionUnknown
        } else if self.control.running == Some(false) && is_on(Check::MissionRuns) {
            Uncontrolled::MissionNotRunning
        } else if let Some(reason) = self.vehicle.compared.reason().filter(|_| expects_plan) {
            reason
        } else if let Some(reason) = self.vehicle.dive.reason() {
            reason
        } else if let Some(reason) = self.unheard() {
            reason
        } else if self.vehicle.navigation.fresh(self.now).is_none() {
            Uncontrolled::NavigationStale
        } else if !self.vehicle.navigation.steady(self.now) {
            Uncontrolled::NavigationUnsteady
        } else {
            return None;
        };
        Some(reason)
    }

    /// Why we do not know that the vehicle hears us; `None` if we know it (safety requirement 023).
    pub(crate) fn unheard(&self) -> Option<Uncontrolled> {
        if self.link.heartbeat.is_heard(self.now) || !is_on(Check::Heard) {
            None
        } else if self.link.heartbeat.has_answered() {
            Some(Uncontrolled::NotAnsweredInTime)
        } else {
            Some(Uncontrolled::NotAnsweredYet)
        }
    }
}

//! Whether control is ours.

use super::Context;
use crate::switches::{Check, is_on};

impl Context {
    /// Why we have no control; `None` where it is ours.
    pub(crate) fn lost_because(&self) -> Option<&'static str> {
        let expects_plan = self.settings.expected_plan.is_some();
        let reason = if !self.link.is_up() {
            "the link is down"
        } else if self.control.stopping {
            "the run is ending"
        } else if self.control.held {
            "the operator holds"
        } else if self.control.mission_ended {
            "the operator has ended the mission"
        } else if self.control.handed_over.is_none() && is_on(Check::ControlKnown) {
            "the vehicle has not said who has control"
        } else if self.control.handed_over == Some(false) && is_on(Check::ControlGiven) {
            "the vehicle has control"
        } else if self.control.running.is_none() && is_on(Check::ControlKnown) {
            "the vehicle has not said whether its mission runs"
        } else if self.control.running == Some(false) && is_on(Check::MissionRuns) {
            "the mission is not running"
        } else if let Some(reason) = self.vehicle.compared.reason().filter(|_| expects_plan) {
            reason
        } else if let Some(reason) = self.vehicle.dive.reason() {
            reason
        } else if let Some(reason) = self.unheard() {
            reason
        } else if self.vehicle.navigation.fresh(self.now).is_none() {
            "navigation is stale"
        } else if !self.vehicle.navigation.steady(self.now) {
            "navigation has not been steady for long enough"
        } else {
            return None;
        };
        Some(reason)
    }

    /// Why the vehicle does not hear us; `None` where it does (safety requirement 023).
    pub(crate) fn unheard(&self) -> Option<&'static str> {
        if self.link.heartbeat.is_heard(self.now) || !is_on(Check::Heard) {
            None
        } else if self.link.heartbeat.has_answered() {
            Some("the vehicle does not answer in time")
        } else {
            Some("the vehicle has not answered yet")
        }
    }
}

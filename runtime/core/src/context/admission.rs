//! What every request must pass before its content is checked.

use std::time::Duration;

use super::Context;
use crate::monitor::limits::Grant;
use crate::mutations::{Check, is_on};
use crate::plugin::{PluginId, Refusal, RequestState};
use crate::refusal::{Figure, Reason, Uncontrolled};

impl Context {
    /// Whether a plugin may ask for something now: by its grants, its rate, and who has control.
    ///
    /// # Errors
    /// The first of these that refuses it.
    pub(crate) fn admit(&mut self, plugin: PluginId, grant: Grant) -> Result<(), Refusal> {
        let most = self.monitor.limits().requests_per_s;
        let own = self.plugins.limits(plugin).requests_per_s;
        let per_second = f64::from(own.map_or(most, |own| own.min(most)));
        if !self.plugins.grants(plugin).contains(&grant) {
            return Err(Refusal::NotGranted(grant));
        }
        if !self.plugins.take_request(self.now, plugin, per_second) && is_on(Check::RequestRate) {
            return Err(Figure::Requests.over(per_second + 1.0, per_second));
        }
        if grant == Grant::Sonar {
            // The sonars do not steer: their requests need no control.
            return self.admit_armed();
        }
        self.admit_standing(grant)
    }

    /// Whether a plugin's insert may interrupt what is flown.
    pub(crate) fn admit_interrupt(&self, plugin: PluginId) -> Result<(), Refusal> {
        if self.plugins.grants(plugin).contains(&Grant::Interrupt) {
            Ok(())
        } else {
            Err(Refusal::NotGranted(Grant::Interrupt))
        }
    }

    /// What every request needs when it is sent: control, an armed runtime, and a vehicle inside the fence.
    pub(crate) fn admit_standing(&self, grant: Grant) -> Result<(), Refusal> {
        let steers = matches!(
            grant,
            Grant::Modify | Grant::Insert | Grant::Interrupt | Grant::Surface | Grant::Station
        );
        if let Some(reason) = self.lost_because()
            && (steers || is_on(Check::ListWithoutControl))
        {
            return Err(reason.into());
        }
        self.admit_armed()?;
        if self.control.recovering {
            return Err(Reason::OutsideFence.into());
        }
        Ok(())
    }

    /// Whether the runtime may send anything for a plugin.
    fn admit_armed(&self) -> Result<(), Refusal> {
        if self.control.armed {
            Ok(())
        } else {
            Err(Uncontrolled::NotArmed.into())
        }
    }

    /// Whether a plugin may steer for this much longer.
    pub(crate) fn cap_steering(&self, plugin: PluginId, duration: Duration) -> Result<(), Refusal> {
        let most = self.plugins.limits(plugin).steering_max();
        self.arbiter.cap(self.now, plugin, duration, most)
    }

    /// Rejects a request. If the reason is its plugin's rate, only some of the rejections are logged.
    pub(crate) fn reject(&mut self, request: u64, refusal: Refusal) {
        let owner = self.ledger.get(request).and_then(|entry| entry.owner.plugin());
        let over_rate = refusal
            .figure_breach()
            .is_some_and(|breach| breach.figure == Figure::Requests);
        let counted = owner.is_some_and(|plugin| over_rate && !self.plugins.tells_over_rate(self.now, plugin));
        if counted {
            self.transition_unnoted(request, RequestState::Rejected(refusal));
        } else {
            self.transition(request, RequestState::Rejected(refusal));
        }
    }
}

//! What every request must pass before anything of it is looked at.

use std::time::Duration;

use super::Context;
use crate::monitor::envelope::limit;
use crate::monitor::limits::Grant;
use crate::plugin::{PluginId, Refusal, RequestState};
use crate::refusal::refused;
use crate::switches::{Check, is_on};

/// The rule by which a plugin's request is rejected that comes too soon.
const OVER_RATE: &str = "rate";

impl Context {
    /// Whether a plugin may ask for something now: by its grants, its rate, and who has control.
    ///
    /// # Errors
    /// The first of these that does not hold.
    pub(crate) fn admit(&mut self, plugin: PluginId, grant: Grant) -> Result<(), Refusal> {
        let most = self.monitor.limits().requests_per_s;
        let own = self.plugins.limits(plugin).requests_per_s;
        let per_second = f64::from(own.map_or(most, |own| own.min(most)));
        if !self.plugins.grants(plugin).contains(&grant) {
            return Err(limit(format!("the mission does not grant it {grant:?}")));
        }
        if !self.plugins.take_request(self.now, plugin, per_second) && is_on(Check::RequestRate) {
            return Err(refused(OVER_RATE, &format!("more than {per_second} requests a second")));
        }
        self.admit_standing(grant)
    }

    /// Whether a plugin's insert may interrupt what is flown.
    pub(crate) fn admit_interrupt(&self, plugin: PluginId) -> Result<(), Refusal> {
        if self.plugins.grants(plugin).contains(&Grant::Interrupt) {
            Ok(())
        } else {
            Err(refused("grant", "the mission does not grant it Interrupt"))
        }
    }

    /// What every request needs at the moment that it leaves: control, and an armed runtime inside the fence.
    pub(crate) fn admit_standing(&self, grant: Grant) -> Result<(), Refusal> {
        let steers = matches!(
            grant,
            Grant::Modify | Grant::Insert | Grant::Interrupt | Grant::Surface | Grant::Hull
        );
        if let Some(reason) = self.lost_because()
            && (steers || is_on(Check::ListWithoutControl))
        {
            return Err(refused("control", reason));
        }
        if !self.control.armed {
            return Err(refused("control", "the runtime is not armed"));
        }
        if self.control.recovering {
            return Err(refused("recovery", "the vehicle is outside the fence"));
        }
        Ok(())
    }

    /// Whether a plugin may steer for so much longer.
    pub(crate) fn cap_steering(&self, plugin: PluginId, duration: Duration) -> Result<(), Refusal> {
        let most = self.plugins.limits(plugin).steering_max();
        self.arbiter.cap(self.now, plugin, duration, most)
    }

    /// A request does not leave. One that was over its plugin's rate is told now and then.
    pub(crate) fn reject(&mut self, request: u64, refusal: Refusal) {
        let reason = format!("{}: {}", refusal.rule, refusal.text);
        let owner = self.ledger.get(request).and_then(|entry| entry.owner.plugin());
        let counted =
            owner.is_some_and(|plugin| refusal.rule == OVER_RATE && !self.plugins.tells_over_rate(self.now, plugin));
        if counted {
            self.transition_unnoted(request, RequestState::Rejected(reason));
        } else {
            self.transition(request, RequestState::Rejected(reason));
        }
    }
}

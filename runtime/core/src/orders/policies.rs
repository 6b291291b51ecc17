//! The mission's policies: orders that the operator gives in advance, by what happens.
//!
//! A condition acts when it comes to be, not while it lasts: navigation's staleness once from one fresh sample to the next.
//! Several that come to be at once act in the order of the file.

use std::time::Duration;

use backseat_units::Timestamp;

use super::{Condition, Policy};
use crate::io::Note;
use crate::machine::Core;
use crate::timer::Timer;

/// A time in which navigation is stale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stale {
    since: Timestamp,
    /// Policies that were due by then have acted.
    acted: Option<Timestamp>,
}

impl Stale {
    /// When a condition is fulfilled by the time alone that this lasts.
    fn due(self, when: &Condition) -> Option<Timestamp> {
        match when {
            Condition::NavigationStaleForS(seconds) => {
                // A figure that is no time is never reached; the mission's reader refuses it.
                let after = Duration::try_from_secs_f64(*seconds).ok()?;
                let at = self.since + after;
                self.acted.is_none_or(|acted| at > acted).then_some(at)
            }
            Condition::MissionCommand(_) | Condition::TopsideMessage(_) | Condition::PluginQuarantined => None,
        }
    }
}

impl Core {
    /// Carries out the policies whose condition an event fulfils.
    pub(crate) fn carry_out(&mut self, fulfilled: impl Fn(&Condition) -> bool) {
        let due: Vec<Policy> = self
            .cx
            .settings
            .policies
            .iter()
            .filter(|policy| fulfilled(&policy.when))
            .cloned()
            .collect();
        for Policy { when, order } in due {
            self.cx.note(Note::Text {
                text: format!("policy: {when}: {order}"),
            });
            self.order_in_advance(&order);
        }
    }

    /// Follows navigation's staleness for the policies that hang on it.
    pub(crate) fn watch_staleness(&mut self) {
        let fresh = self.cx.tracker.fresh(self.cx.now).is_some();
        if fresh || !self.orders.connected {
            self.orders.stale = None;
            return self.cx.timers.stop(Timer::Policy);
        }
        let since = self.cx.now;
        let stale = *self.orders.stale.get_or_insert(Stale { since, acted: None });
        let policies = self.cx.settings.policies.iter();
        let first = policies.filter_map(|policy| stale.due(&policy.when)).min();
        self.cx.timers.set_or_stop(Timer::Policy, first);
    }

    /// A condition that must last may have lasted for long enough.
    pub(crate) fn policies_due(&mut self) {
        let Some(stale) = self.orders.stale else { return };
        if self.cx.tracker.fresh(self.cx.now).is_some() {
            return;
        }
        let now = self.cx.now;
        self.orders.stale = Some(Stale {
            acted: Some(now),
            ..stale
        });
        self.carry_out(|when| stale.due(when).is_some_and(|at| at <= now));
    }
}

//! The mission's policies: orders that the operator gives in advance, each for a condition.
//!
//! A policy acts when its condition becomes true, not while it stays true: for stale navigation, once between two fresh
//! samples. Policies whose conditions become true at once act in the order of the file.

use std::time::Duration;

use backseat_units::Timestamp;

use super::Orders;
use crate::capability::Capabilities;
use crate::context::Context;
use crate::io::Note;
use crate::order::{Condition, Policy};
use crate::timer::Timer;

/// A time in which navigation is stale.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(super) struct Stale {
    since: Timestamp,
    /// Policies that were due by this time have acted.
    acted: Option<Timestamp>,
}

impl Stale {
    /// When a condition becomes true that depends only on how long this lasts; `None` if it is another condition, or
    /// its policy has acted.
    fn due(self, when: &Condition) -> Option<Timestamp> {
        match when {
            Condition::NavigationStaleForS(seconds) => {
                // A figure that is not a duration is never reached; the mission's reader refuses it.
                let after = Duration::try_from_secs_f64(*seconds).ok()?;
                let at = self.since + after;
                self.acted.is_none_or(|acted| at > acted).then_some(at)
            }
            Condition::MissionCommand(_) | Condition::TopsideMessage(_) | Condition::PluginQuarantined => None,
        }
    }
}

impl Orders {
    /// Carries out these policies.
    pub(crate) fn carry_out(
        &mut self,
        cx: &mut Context,
        capabilities: &mut Capabilities,
        is_due: impl Fn(&Policy) -> bool,
    ) {
        let due: Vec<Policy> = cx
            .settings
            .policies
            .iter()
            .filter(|policy| is_due(policy))
            .cloned()
            .collect();
        for Policy { when, order } in due {
            cx.note(Note::Text {
                text: format!("policy: {when}: {order}"),
            });
            self.order_in_advance(cx, capabilities, &order);
        }
    }

    /// Follows the staleness of navigation for the policies that depend on it.
    pub(crate) fn watch_staleness(&mut self, cx: &mut Context) {
        let fresh = cx.vehicle.navigation.fresh(cx.now).is_some();
        if fresh || !self.connected {
            self.stale = None;
            return cx.timers.stop(Timer::Policy);
        }
        let since = cx.now;
        let stale = *self.stale.get_or_insert(Stale { since, acted: None });
        let policies = cx.settings.policies.iter();
        let first = policies.filter_map(|policy| stale.due(&policy.when)).min();
        cx.timers.set_or_stop(Timer::Policy, first);
    }

    /// A condition may have lasted as long as its policy demands.
    pub(crate) fn policies_due(&mut self, cx: &mut Context, capabilities: &mut Capabilities) {
        let Some(stale) = self.stale else { return };
        if cx.vehicle.navigation.fresh(cx.now).is_some() {
            return;
        }
        let now = cx.now;
        self.stale = Some(Stale {
            acted: Some(now),
            ..stale
        });
        self.carry_out(cx, capabilities, |policy| {
            stale.due(&policy.when).is_some_and(|at| at <= now)
        });
    }
}

//! Who steers: one plugin at a time, by a modify or by station keeping. Plugins of higher priority come first, and no
//! plugin steers for longer than the mission lets it (safety requirement 019).

use std::time::Duration;

use backseat_units::Timestamp;

use crate::plugin::{PluginId, Refusal};
use crate::refusal::{Figure, Reason};

/// A way to steer that lasts only while it is refreshed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LeaseKind {
    /// BPRMB.
    Modify,
    /// BPSUS and what follows it.
    Station,
}

/// Who has a lease, and since when without a break.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Helm {
    plugin: PluginId,
    since: Timestamp,
}

/// Who steers, and how long each plugin has steered.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Arbiter {
    modify: Option<Helm>,
    station: Option<Helm>,
    /// How long each plugin has steered, without its current lease.
    steered: Vec<Duration>,
}

impl Arbiter {
    pub(crate) fn new(plugins: usize) -> Self {
        Self {
            modify: None,
            station: None,
            steered: vec![Duration::ZERO; plugins],
        }
    }

    /// Whether anybody steers.
    pub(crate) const fn is_steering(&self) -> bool {
        self.modify.is_some() || self.station.is_some()
    }

    /// Whether a plugin may take a lease beside the current ones. The first plugin of the mission file has the highest
    /// priority.
    pub(crate) fn arbitrate(&self, plugin: PluginId, kind: LeaseKind) -> Result<(), Refusal> {
        let steers = (self.modify, Reason::OtherSteers);
        let keeps = (self.station, Reason::OtherKeepsStation);
        let both = match kind {
            LeaseKind::Modify => [steers, keeps],
            LeaseKind::Station => [keeps, steers],
        };
        for (helm, reason) in both {
            if helm.is_some_and(|helm| helm.plugin < plugin) {
                return Err(reason.into());
            }
        }
        Ok(())
    }

    /// A plugin takes a lease: its own again, or another plugin's.
    pub(crate) fn take(&mut self, now: Timestamp, plugin: PluginId, kind: LeaseKind) {
        let before = *self.of(kind);
        let since = match before {
            Some(helm) if helm.plugin == plugin => helm.since,
            Some(_) | None => {
                self.release(now, kind);
                now
            }
        };
        *self.of(kind) = Some(Helm { plugin, since });
    }

    /// A lease is over.
    pub(crate) fn release(&mut self, now: Timestamp, kind: LeaseKind) {
        if let Some(helm) = self.of(kind).take() {
            self.steered[helm.plugin.0] += now.since(helm.since);
        }
    }

    /// Whether a plugin may steer for `duration` from now on without exceeding `most` in all. A current lease of the plugin
    /// counts up to now.
    pub(crate) fn cap(
        &self,
        now: Timestamp,
        plugin: PluginId,
        duration: Duration,
        most: Option<Duration>,
    ) -> Result<(), Refusal> {
        let Some(most) = most else { return Ok(()) };
        let standing = self
            .modify
            .or(self.station)
            .filter(|helm| helm.plugin == plugin)
            .map_or(Duration::ZERO, |helm| now.since(helm.since));
        let steered = self.steered[plugin.0] + standing;
        if steered.saturating_add(duration) <= most {
            return Ok(());
        }
        let would = steered.saturating_add(duration).as_secs_f64();
        Err(Figure::Steering.over(would, most.as_secs_f64()))
    }

    const fn of(&mut self, kind: LeaseKind) -> &mut Option<Helm> {
        match kind {
            LeaseKind::Modify => &mut self.modify,
            LeaseKind::Station => &mut self.station,
        }
    }
}

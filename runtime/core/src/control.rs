use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp};

use crate::settings::ControlHook;

/// For how long a message about control can be older than one that came before it. After that, a time of day that seems older is that of
/// another day, or the vehicle's clock was set.
const OLDER_WITHIN: Duration = Duration::from_secs(60);

/// What the vehicle, the operator and the run itself say about who steers.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Control {
    /// The operator allows this process to send messages that steer.
    pub(crate) armed: bool,
    /// Whether the backseat has control, by the last word of the configured hook.
    pub(crate) handed_over: Option<bool>,
    /// The newest message of this connection that took control away: when the vehicle made it, and when it came.
    pub(crate) revoked: Option<(TimeOfDay, Timestamp)>,
    /// BFMIS begins with `Running`.
    pub(crate) running: Option<bool>,
    /// The operator holds.
    pub(crate) held: bool,
    /// The run is ending.
    pub(crate) stopping: bool,
    /// The operator has ended the mission. Whatever comes of that order, plugins do not steer until the mission is over
    /// or the operator releases them.
    pub(crate) mission_ended: bool,
    /// The vehicle is outside the fence because of us: no plugin's request is accepted.
    pub(crate) recovering: bool,
    /// Whether control is ours, as core last reported it.
    pub(crate) granted: bool,
}

impl Control {
    /// The link is new or gone: the vehicle has said nothing about control on it.
    pub(crate) fn forget(&mut self) {
        self.handed_over = None;
        self.revoked = None;
        self.running = None;
    }

    /// A BFCTL, or a BFMSC with one of the texts for it. One that gives control does not count if the vehicle made it before the newest one that took control
    /// away: either it is late, or the vehicle's clock was set. Nobody can tell which, so it is unknown who has control.
    /// Returns whether this one counts.
    pub(crate) fn hand_over(&mut self, now: Timestamp, created: TimeOfDay, granted: bool) -> bool {
        let newest = self.revoked.filter(|(_, heard)| now.since(*heard) < OLDER_WITHIN);
        let is_older = newest.is_some_and(|(revoked, _)| created.nanos_since(revoked) < 0);
        if !granted && !is_older {
            self.revoked = Some((created, now));
        }
        let counts = !(granted && is_older);
        self.handed_over = counts.then_some(granted);
        counts
    }

    /// Whether the vehicle has told on this connection what it tells each new subscriber: who has control, and whether its
    /// mission runs.
    pub(crate) fn is_told(&self, hook: &ControlHook) -> bool {
        (*hook != ControlHook::Bfctl || self.handed_over.is_some()) && self.running.is_some()
    }

    /// A message of the vehicle that is damaged or cannot be read may have taken control away (safety requirement 001).
    /// Returns whether this one may have.
    pub(crate) fn doubt(&mut self, hook: &ControlHook, message: &str) -> bool {
        match message {
            "BFCTL" if *hook == ControlHook::Bfctl => self.handed_over = None,
            "BFMSC" if matches!(hook, ControlHook::MissionCommand { .. }) => self.handed_over = None,
            "BFMIS" => self.running = None,
            _ => return false,
        }
        true
    }
}

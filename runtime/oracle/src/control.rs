use std::time::Duration;

use backseat_units::Timestamp;

use crate::limits::ControlHook;

/// Whether the vehicle's own words give us control: on this connection, by the hook, while the mission runs.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    hook: ControlHook,
    up: bool,
    granted_by_hook: Option<bool>,
    running: Option<bool>,
    granted: bool,
    since: Timestamp,
}

/// What became of control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    None,
    Gained,
    Lost {
        /// How long it was held.
        held: Duration,
    },
}

impl Control {
    pub(crate) const fn new(hook: ControlHook) -> Self {
        Self {
            hook,
            up: false,
            granted_by_hook: None,
            running: None,
            granted: false,
            since: Timestamp::ZERO,
        }
    }

    pub(crate) const fn is_up(&self) -> bool {
        self.up
    }

    pub(crate) const fn is_granted(&self) -> bool {
        self.granted
    }

    /// Since when there is no control; `None` where there is.
    pub(crate) fn denied_since(&self) -> Option<Timestamp> {
        (!self.granted).then_some(self.since)
    }

    /// Since when there is control; `None` where there is none.
    pub(crate) fn held_since(&self) -> Option<Timestamp> {
        self.granted.then_some(self.since)
    }

    /// The link came up or went down: either way all earlier words are void.
    pub(crate) fn link(&mut self, at: Timestamp, up: bool) -> Change {
        self.up = up;
        self.granted_by_hook = None;
        self.running = None;
        self.settle(at)
    }

    pub(crate) fn backseat_control(&mut self, at: Timestamp, granted: bool) -> Change {
        if self.hook == ControlHook::BackseatControl {
            self.granted_by_hook = Some(granted);
        }
        self.settle(at)
    }

    pub(crate) fn mission_running(&mut self, at: Timestamp, running: bool) -> Change {
        self.running = Some(running);
        if self.hook == ControlHook::MissionRunning {
            self.granted_by_hook = Some(running);
        }
        self.settle(at)
    }

    pub(crate) fn mission_command(&mut self, at: Timestamp, text: &str) -> Change {
        if let ControlHook::MissionCommand { grant, revoke } = &self.hook {
            if text == revoke {
                self.granted_by_hook = Some(false);
            } else if text == grant {
                self.granted_by_hook = Some(true);
            }
        }
        self.settle(at)
    }

    fn settle(&mut self, at: Timestamp) -> Change {
        let granted = self.up && self.granted_by_hook == Some(true) && self.running == Some(true);
        if granted == self.granted {
            return Change::None;
        }
        let held = at.since(self.since);
        self.granted = granted;
        self.since = at;
        if granted { Change::Gained } else { Change::Lost { held } }
    }
}

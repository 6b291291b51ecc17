use std::time::Duration;

use crate::moment::Moment;

use crate::limits::ControlHook;

/// Whether the vehicle's own sentences give us control: on this connection, by the hook, while the mission runs.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    hook: ControlHook,
    up: bool,
    granted_by_hook: Word,
    running: Word,
    /// `None` if it is not known.
    granted: Option<bool>,
    since: Moment,
}

/// What the vehicle has said on this connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    Unsaid,
    Said(bool),
    /// The record has a gap, in which the vehicle may have said anything.
    Lost,
}

/// How control has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    None,
    Gained,
    Lost {
        /// How long we had it.
        held: Duration,
    },
    /// The oracle does not know any more whether we have control.
    Forgotten {
        /// How long we had it.
        held: Duration,
    },
}

impl Control {
    pub(crate) const fn new(hook: ControlHook) -> Self {
        Self {
            hook,
            up: false,
            granted_by_hook: Word::Unsaid,
            running: Word::Unsaid,
            granted: Some(false),
            since: Moment::ZERO,
        }
    }

    pub(crate) const fn is_up(&self) -> bool {
        self.up
    }

    pub(crate) const fn is_granted(&self) -> bool {
        matches!(self.granted, Some(true))
    }

    /// Whether the oracle knows who has control.
    pub(crate) const fn is_known(&self) -> bool {
        self.granted.is_some()
    }

    /// Since when we do not have control; `None` if we have it or the oracle does not know.
    pub(crate) fn denied_since(&self) -> Option<Moment> {
        (self.granted == Some(false)).then_some(self.since)
    }

    /// Since when we have control; `None` if we do not have it or the oracle does not know.
    pub(crate) fn held_since(&self) -> Option<Moment> {
        self.is_granted().then_some(self.since)
    }

    /// The link came up or went down. Both make all earlier sentences void.
    pub(crate) fn link(&mut self, at: Moment, up: bool) -> Change {
        self.up = up;
        self.granted_by_hook = Word::Unsaid;
        self.running = Word::Unsaid;
        self.settle(at)
    }

    /// The record has a gap until now: control is unknown until the vehicle reports it again.
    pub(crate) fn lose_sight(&mut self, at: Moment) -> Change {
        self.granted_by_hook = Word::Lost;
        self.running = Word::Lost;
        self.settle(at)
    }

    /// Bytes on the link show that it is up, whatever the record lacks.
    pub(crate) fn seems_up(&mut self, at: Moment) -> Change {
        self.up = true;
        self.settle(at)
    }

    pub(crate) fn backseat_control(&mut self, at: Moment, granted: bool) -> Change {
        if self.hook == ControlHook::BackseatControl {
            self.granted_by_hook = Word::Said(granted);
        }
        self.settle(at)
    }

    pub(crate) fn mission_running(&mut self, at: Moment, running: bool) -> Change {
        self.running = Word::Said(running);
        if self.hook == ControlHook::MissionRunning {
            self.granted_by_hook = Word::Said(running);
        }
        self.settle(at)
    }

    pub(crate) fn mission_command(&mut self, at: Moment, text: &[u8]) -> Change {
        if let ControlHook::MissionCommand { grant, revoke } = &self.hook {
            if text == revoke.as_bytes() {
                self.granted_by_hook = Word::Said(false);
            } else if text == grant.as_bytes() {
                self.granted_by_hook = Word::Said(true);
            }
        }
        self.settle(at)
    }

    fn settle(&mut self, at: Moment) -> Change {
        let granted = match (self.granted_by_hook, self.running) {
            _ if !self.up => Some(false),
            (Word::Unsaid | Word::Said(false), _) | (_, Word::Unsaid | Word::Said(false)) => Some(false),
            (Word::Said(true), Word::Said(true)) => Some(true),
            (Word::Lost, _) | (_, Word::Lost) => None,
        };
        if granted == self.granted {
            return Change::None;
        }
        let held = self.held_since().map_or(Duration::ZERO, |since| at.since(since));
        self.granted = granted;
        self.since = at;
        match granted {
            Some(true) => Change::Gained,
            Some(false) => Change::Lost { held },
            None => Change::Forgotten { held },
        }
    }
}

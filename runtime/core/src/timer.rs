use backseat_units::Timestamp;

/// Why core wants to be called again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Timer {
    /// The lease's term is over. What ends a lease comes before what refreshes it.
    Term,
    /// The oldest command without an acknowledgement is late.
    Acknowledgement,
    /// The lease is due for its next BPRMB.
    Refresh,
    /// Navigation becomes stale, or steady.
    Navigation,
    /// Navigation has not come since the link came up or since it stopped.
    Silence,
    /// The plan is due to be asked for.
    Plan,
    /// BPSTS is due.
    Status,
    /// A plugin is due: a step, one of its timers, or its restart.
    Plugins,
    /// The logs must be closed: power goes.
    Shutdown,
}

impl Timer {
    const ALL: [Self; 9] = [
        Self::Term,
        Self::Acknowledgement,
        Self::Refresh,
        Self::Navigation,
        Self::Silence,
        Self::Plan,
        Self::Status,
        Self::Plugins,
        Self::Shutdown,
    ];
}

/// When each timer expires.
#[derive(Debug, Default)]
pub(crate) struct Timers {
    at: [Option<Timestamp>; Timer::ALL.len()],
}

impl Timers {
    pub(crate) fn set(&mut self, timer: Timer, at: Timestamp) {
        self.at[timer as usize] = Some(at);
    }

    pub(crate) fn set_or_stop(&mut self, timer: Timer, at: Option<Timestamp>) {
        self.at[timer as usize] = at;
    }

    pub(crate) fn stop(&mut self, timer: Timer) {
        self.at[timer as usize] = None;
    }

    pub(crate) fn next(&self) -> Option<Timestamp> {
        self.at.iter().flatten().min().copied()
    }

    /// Takes an expired timer, in the order of the list.
    pub(crate) fn expired(&mut self, now: Timestamp) -> Option<Timer> {
        for timer in Timer::ALL {
            let at = &mut self.at[timer as usize];
            if at.is_some_and(|at| at <= now) {
                *at = None;
                return Some(timer);
            }
        }
        None
    }
}

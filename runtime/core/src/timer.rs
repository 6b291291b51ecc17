use backseat_units::Timestamp;

/// Why core wants to be called again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Timer {
    /// The logs must be closed, because the power will be cut. Nothing comes before this or after it.
    Shutdown,
    /// The lease's term is over. What ends a lease comes before what refreshes it.
    Term,
    /// The term of station keeping is over.
    StationTerm,
    /// The oldest command without an acknowledgement is late.
    Acknowledgement,
    /// The lease is due for its next BPRMB.
    Refresh,
    /// Station keeping is due for its next BPCON.
    Station,
    /// Navigation becomes stale, or steady.
    Navigation,
    /// Relative navigation becomes stale under station keeping.
    Relative,
    /// Navigation has not come since the link came up or since it stopped.
    Silence,
    /// A request that cannot be taken back has waited for long enough for an answer of the vehicle.
    Irrevocable,
    /// It is time to ask for the plan.
    Plan,
    /// BPSTS is due, and with it the heartbeat.
    Status,
    /// The newest good round trip no longer shows that the vehicle hears us, or a remedy is due.
    Heartbeat,
    /// Silent mode has lapsed by itself.
    Silent,
    /// A trim or buoyancy adjustment has taken too long.
    Adjustment,
    /// An acoustic window ends, or a packet's report is overdue.
    Acoustic,
    /// The DVL's triggering handshake is overdue.
    Dvl,
    /// An order has waited for long enough: an abort for the link, an empty mission for its start.
    Order,
    /// A policy's condition has lasted for long enough.
    Policy,
    /// The runtime sends a cancel of its own again.
    Recall,
    /// The next step of recovery is due.
    Recovery,
    /// A request to the sonars has waited too long for its outcome.
    Sonar,
    /// A plugin is due: a step, one of its timers, or its restart.
    Plugins,
}

impl Timer {
    const ALL: [Self; 23] = [
        Self::Shutdown,
        Self::Term,
        Self::StationTerm,
        Self::Acknowledgement,
        Self::Refresh,
        Self::Station,
        Self::Navigation,
        Self::Relative,
        Self::Silence,
        Self::Irrevocable,
        Self::Plan,
        Self::Status,
        Self::Heartbeat,
        Self::Silent,
        Self::Adjustment,
        Self::Acoustic,
        Self::Dvl,
        Self::Order,
        Self::Policy,
        Self::Recall,
        Self::Recovery,
        Self::Sonar,
        Self::Plugins,
    ];
}

/// When each timer expires.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Timers {
    at: [Option<Timestamp>; Timer::ALL.len()],
}

impl Timers {
    pub(crate) fn set(&mut self, timer: Timer, at: Timestamp) {
        self.at[timer as usize] = Some(at);
    }

    pub(crate) fn set_unless_set(&mut self, timer: Timer, at: Timestamp) {
        self.at[timer as usize].get_or_insert(at);
    }

    pub(crate) fn set_or_stop(&mut self, timer: Timer, at: Option<Timestamp>) {
        self.at[timer as usize] = at;
    }

    pub(crate) fn stop(&mut self, timer: Timer) {
        self.at[timer as usize] = None;
    }

    pub(crate) fn is_set(&self, timer: Timer) -> bool {
        self.at[timer as usize].is_some()
    }

    pub(crate) fn stop_all(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn next(&self) -> Option<Timestamp> {
        self.at.iter().flatten().min().copied()
    }

    /// Takes one expired timer, in the order of the list.
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

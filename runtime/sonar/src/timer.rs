use backseat_units::Timestamp;

/// Why the client wants to be called again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Timer {
    /// The time for a shutdown is over. Nothing comes after it.
    Shutdown,
    /// It is time to connect.
    Connect,
    /// The command under way is not answered in time.
    Command,
    /// The oldest order has waited too long to be sent.
    Orders,
    /// The oldest gathered navigation frame must leave.
    Navigation,
    /// The oldest gathered environment frame must leave.
    Environment,
    /// The sensors' health is due.
    Health,
    /// The counts are compared with those that were last reported, and a new quota of events begins.
    Counts,
}

impl Timer {
    const ALL: [Self; 8] = [
        Self::Shutdown,
        Self::Connect,
        Self::Command,
        Self::Orders,
        Self::Navigation,
        Self::Environment,
        Self::Health,
        Self::Counts,
    ];
}

/// When each timer expires.
#[derive(Debug, Default)]
pub(crate) struct Timers {
    at: [Option<Timestamp>; Timer::ALL.len()],
}

impl Timers {
    /// A time of [`Timestamp::MAX`] means never.
    pub(crate) fn set(&mut self, timer: Timer, at: Timestamp) {
        self.at[timer as usize] = Some(at).filter(|at| *at < Timestamp::MAX);
    }

    pub(crate) fn set_unless_set(&mut self, timer: Timer, at: Timestamp) {
        if self.at[timer as usize].is_none() {
            self.set(timer, at);
        }
    }

    pub(crate) fn set_or_stop(&mut self, timer: Timer, at: Option<Timestamp>) {
        self.at[timer as usize] = at.filter(|at| *at < Timestamp::MAX);
    }

    pub(crate) fn stop(&mut self, timer: Timer) {
        self.at[timer as usize] = None;
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

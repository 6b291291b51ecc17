use std::fmt;

/// The state of a run, by the bytes on the link alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    /// The link is down.
    Down,
    /// The link is up and we do not have control; requests of ours may be open.
    NoControl,
    /// We have control, and no request of ours is open.
    Idle,
    /// An insert was sent, and the vehicle has neither accepted nor refused it.
    Asked,
    /// The vehicle accepted an insert, which has not begun.
    Queued,
    /// The vehicle flies an insert of ours.
    Insert,
    /// A modify is alive.
    Lease,
    /// A modify is alive, and an insert of ours is open or flown.
    LeaseInsert,
    /// A suspension of a hovering vehicle's mission is alive.
    Station,
}

impl State {
    /// All states.
    pub const ALL: [Self; 9] = [
        Self::Down,
        Self::NoControl,
        Self::Idle,
        Self::Asked,
        Self::Queued,
        Self::Insert,
        Self::Lease,
        Self::LeaseInsert,
        Self::Station,
    ];

    /// The state's name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::NoControl => "no-control",
            Self::Idle => "idle",
            Self::Asked => "asked",
            Self::Queued => "queued",
            Self::Insert => "insert",
            Self::Lease => "lease",
            Self::LeaseInsert => "lease-insert",
            Self::Station => "station",
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

use core::fmt;

/// A client of the server, as the driver numbers its connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClientId(pub u32);

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "client {}", self.0)
    }
}

/// Why the server cut a client off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropReason {
    /// It does not fetch what is due to it.
    Backlog,
    /// Too many clients are connected.
    TooMany,
    /// Each role that it could have is held by another client.
    RoleHeld,
    /// No role is meant for its address.
    NoRole,
    /// The payload has no power.
    PowerOff,
}

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Backlog => "it does not fetch what is due to it",
            Self::TooMany => "too many clients",
            Self::RoleHeld => "another client holds its role",
            Self::NoRole => "no role is meant for its address",
            Self::PowerOff => "the payload has no power",
        })
    }
}

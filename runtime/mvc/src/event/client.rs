use core::fmt;

/// A client of the server. The driver numbers the connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClientId(pub u32);

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "client {}", self.0)
    }
}

/// Why the server closed a client's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropReason {
    /// It does not read what the vehicle sends.
    Backlog,
    /// Too many clients are connected.
    TooMany,
    /// Other clients hold every role that it could have.
    RoleHeld,
    /// Its address has no role.
    NoRole,
    /// The payload has no power.
    PowerOff,
}

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Backlog => "it does not read what the vehicle sends",
            Self::TooMany => "too many clients",
            Self::RoleHeld => "another client holds its role",
            Self::NoRole => "its address has no role",
            Self::PowerOff => "the payload has no power",
        })
    }
}

use std::net::SocketAddr;

use crate::event::DropReason;
use crate::file::{RoleConfig, SpiConfig, WithoutRole};

/// The roles that clients may hold, and who may hold them (SPI 4.1).
#[derive(Clone, Debug)]
pub(crate) struct Roles {
    /// The patterns: those with a port first, otherwise in the order of the file.
    patterns: Vec<(RoleConfig, usize)>,
    names: Vec<String>,
    without_role: WithoutRole,
}

/// What the roles decide about a new client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seat {
    Role(usize),
    Stranger,
    Refused(DropReason),
}

impl Roles {
    pub(crate) fn new(config: &SpiConfig) -> Self {
        let mut names: Vec<String> = Vec::new();
        let mut patterns = Vec::new();
        for pattern in &config.roles {
            let name = names.iter().position(|name| *name == pattern.role).unwrap_or_else(|| {
                names.push(pattern.role.clone());
                names.len() - 1
            });
            patterns.push((pattern.clone(), name));
        }
        // The sort is stable: the order of the file decides between equal patterns.
        patterns.sort_by_key(|(pattern, _)| pattern.port.is_none());
        Self {
            patterns,
            names,
            without_role: config.without_role,
        }
    }

    /// The role of the most specific pattern that fits and whose role is free. A client whose matching roles are all
    /// held is turned away: roles may not be duplicated, and one role allows one connection (SPI 4.1).
    pub(crate) fn seat(&self, address: Option<SocketAddr>, held: impl Fn(usize) -> bool) -> Seat {
        // A client without an address is in the same process: there is nothing to compare.
        let Some(address) = address.filter(|_| !self.patterns.is_empty()) else {
            return Seat::Stranger;
        };
        let mut fits = false;
        for (pattern, role) in &self.patterns {
            if pattern.fits(address) {
                if !held(*role) {
                    return Seat::Role(*role);
                }
                fits = true;
            }
        }
        match self.without_role {
            WithoutRole::Accept if !fits => Seat::Stranger,
            WithoutRole::Accept | WithoutRole::Refuse if fits => Seat::Refused(DropReason::RoleHeld),
            WithoutRole::Accept | WithoutRole::Refuse => Seat::Refused(DropReason::NoRole),
        }
    }

    pub(crate) fn name(&self, role: usize) -> Option<&str> {
        self.names.get(role).map(String::as_str)
    }
}

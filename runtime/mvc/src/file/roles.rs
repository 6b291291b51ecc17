use core::str::FromStr;
use std::net::{IpAddr, SocketAddr};

use serde::Deserialize;

use crate::error::MvcError;

/// One `[[spi.roles]]`: a client that connects from this address holds this role if no other client holds it (SPI 4.1).
///
/// As text it is `ADDRESS:PORT:ROLE`, where PORT may be empty: `127.0.0.1:12345:sonar`, `192.168.10.10::sonar`. Several
/// entries may have the same role.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoleConfig {
    /// The address that the client connects from.
    pub address: IpAddr,
    /// The port that the client connects from; `None` fits any port, but an entry with the client's port comes first.
    pub port: Option<u16>,
    /// The name of the role: 1 to 32 letters, digits, `_` and `-`.
    pub role: String,
}

/// What happens to a client whose address has no role, if there are roles. The specification says that its example with
/// one role "only allows a single connection" (4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WithoutRole {
    /// The vehicle turns it away.
    #[default]
    Refuse,
    /// The vehicle serves it, without a role.
    Accept,
}

/// A text that does not describe a role.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}`: expected ADDRESS:PORT:ROLE or ADDRESS::ROLE, such as 127.0.0.1:12345:sonar: {fault}")]
pub struct RoleError {
    text: String,
    fault: &'static str,
}

const NAME: &str = "a role is 1 to 32 letters, digits, _ and -";

impl RoleConfig {
    /// Whether a client with this address may hold the role.
    #[must_use]
    pub fn fits(&self, client: SocketAddr) -> bool {
        self.address.to_canonical() == client.ip().to_canonical() && self.port.is_none_or(|port| port == client.port())
    }

    /// Reads a list of roles separated by commas.
    ///
    /// # Errors
    /// [`RoleError`] with the first entry that is not a role, and what was expected.
    pub fn list(text: &str) -> Result<Vec<Self>, RoleError> {
        text.split(',').map(str::parse).collect()
    }

    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        if is_name(&self.role) {
            return Ok(());
        }
        Err(MvcError::Value {
            key: "spi.roles.role",
            value: format!("{:?}", self.role),
            expected: NAME,
        })
    }
}

fn is_name(role: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    (1..=32).contains(&role.len()) && role.bytes().all(allowed)
}

impl FromStr for RoleConfig {
    type Err = RoleError;

    fn from_str(text: &str) -> Result<Self, RoleError> {
        let fault = |fault| RoleError {
            text: text.chars().take(100).collect(),
            fault,
        };
        // Split from the end, because an IPv6 address contains colons.
        let mut parts = text.trim().rsplitn(3, ':');
        let (Some(role), Some(port), Some(address)) = (parts.next(), parts.next(), parts.next()) else {
            return Err(fault("it does not have three parts"));
        };
        let address = address.trim_start_matches('[').trim_end_matches(']');
        let port = match port {
            "" => None,
            port => Some(
                port.parse()
                    .map_err(|_| fault("the port is not a number from 0 to 65535"))?,
            ),
        };
        Ok(Self {
            address: address.parse().map_err(|_| fault("the address is not an IP address"))?,
            port,
            role: if is_name(role) {
                role.to_owned()
            } else {
                return Err(fault(NAME));
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forms_of_the_specification_are_read() {
        // SPI 4.1's own examples.
        let role: RoleConfig = "127.0.0.1:12345:foo".parse().unwrap();
        assert_eq!((role.port, role.role.as_str()), (Some(12345), "foo"));
        let list = RoleConfig::list("127.0.0.1::foo,127.0.0.1:12345:bar").unwrap();
        assert_eq!((list[0].port, list[1].port), (None, Some(12345)));
        let six: RoleConfig = "::1::foo".parse().unwrap();
        assert!(six.fits("[::1]:5".parse().unwrap()) && !six.fits("127.0.0.1:5".parse().unwrap()));
        assert!(list[0].fits("[::ffff:127.0.0.1]:9".parse().unwrap()));
    }

    #[test]
    fn an_invalid_role_is_refused_with_its_fault() {
        for (text, fault) in [
            ("127.0.0.1", "three parts"),
            ("127.0.0.1:foo", "three parts"),
            ("127.0.0.1:70000:foo", "0 to 65535"),
            ("localhost::foo", "the address is not an IP address"),
            ("127.0.0.1::", NAME),
            ("127.0.0.1::a b", NAME),
            ("", "three parts"),
        ] {
            let message = RoleConfig::list(text).unwrap_err().to_string();
            assert!(
                message.contains(fault) && message.contains("ADDRESS:PORT:ROLE"),
                "{message}"
            );
        }
    }
}

use std::fmt;
use std::str::FromStr;

use crate::error::Error;

/// The address on which a vehicle listens. The port may be omitted; it is 29500 by default (SPI 4.1).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    pub(crate) host: String,
    pub(crate) port: u16,
}

const PORT: u16 = 29_500;

impl FromStr for Address {
    type Err = Error;

    /// Parses `HOST` or `HOST:PORT`. A numeric IPv6 host with a port must be in brackets.
    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || Error::Address { text: text.to_owned() };
        let (host, port) = match text.strip_prefix('[') {
            Some(rest) => {
                let (host, rest) = rest.split_once(']').ok_or_else(wrong)?;
                let port = match rest.strip_prefix(':') {
                    Some(port) => Some(port),
                    None if rest.is_empty() => None,
                    None => return Err(wrong()),
                };
                (host, port)
            }
            None => match text.split_once(':') {
                Some((_, rest)) if rest.contains(':') => (text, None),
                Some((host, port)) => (host, Some(port)),
                None => (text, None),
            },
        };
        let port = match port.map(str::parse) {
            None => PORT,
            Some(Ok(0) | Err(_)) => return Err(wrong()),
            Some(Ok(port)) => port,
        };
        if host.is_empty() || host.contains(|c: char| c.is_whitespace() || c.is_control() || c == '/') {
            return Err(wrong());
        }
        Ok(Self {
            host: host.to_owned(),
            port,
        })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_need_not_be_given() {
        for (text, shown) in [
            ("vehicle", "vehicle:29500"),
            ("192.168.1.5:3000", "192.168.1.5:3000"),
            ("::1", "[::1]:29500"),
            ("[::1]", "[::1]:29500"),
            ("[fe80::1]:7", "[fe80::1]:7"),
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), shown);
        }
        for bad in [
            "", ":29500", "a:", "a:0", "a:65536", "a:b", "[::1", "[::1]7", "tcp://a", "a b",
        ] {
            let error = bad.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains("expected HOST or HOST:PORT"), "{bad}: {error}");
        }
    }
}

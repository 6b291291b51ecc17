//! One armed runtime for each vehicle on a computer, whatever their state folders are.

use std::io::ErrorKind;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener};

use anyhow::{Result, bail};
use tracing::debug;

/// Holds a name of Linux's that only one process has at a time, and that is free again as soon as the process has ended,
/// however it ended.
#[derive(Debug)]
pub(crate) struct Alone {
    _name: Option<UnixListener>,
}

impl Alone {
    /// Takes the name of the vehicle at this address.
    ///
    /// # Errors
    /// If another runtime on this computer is armed for it.
    pub(crate) fn claim(vehicle: &str) -> Result<Self> {
        let vehicle = vehicle.replacen("localhost", "127.0.0.1", 1);
        let bound = SocketAddr::from_abstract_name(format!("backseat/armed/{vehicle}"))
            .and_then(|name| UnixListener::bind_addr(&name));
        match bound {
            Ok(name) => Ok(Self { _name: Some(name) }),
            Err(error) if error.kind() == ErrorKind::AddrInUse => bail!(
                "{vehicle}: another runtime on this computer is armed for this vehicle, and two would steer against each \
                 other: stop that runtime first, also if it has another --state"
            ),
            Err(error) => {
                debug!("cannot tell whether another runtime is armed for {vehicle}: {error}");
                Ok(Self { _name: None })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_has_one_armed_runtime() {
        let address = format!("10.0.0.1:{}", std::process::id());
        let first = Alone::claim(&address).unwrap();
        let error = Alone::claim(&address).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{address}: another runtime")), "{error}");
        let _other = Alone::claim(&format!("10.0.0.2:{}", std::process::id())).unwrap();
        drop(first);
        Alone::claim(&address).unwrap();
    }
}

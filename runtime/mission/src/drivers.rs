use std::collections::BTreeSet;
use std::net::SocketAddr;

use backseat_core::{DriverBounds, DriverSentence, DriverSetup};
use serde::{Deserialize, Serialize};

/// A `[[driver]]` table: a program of the operator's that may send what no plugin may.
///
/// ```toml
/// [[driver]]
/// name = "usbl"
/// sends = ["BPNPU"]              # or BPCTD, BPTMR, BPRNS, BPRBO
/// listen = "127.0.0.1:29510"     # where it connects to, by TCP; the default is this machine alone
///
/// [driver.bounds]
/// fix_distance_max_m = 200.0
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DriverTable {
    /// Its name in this mission.
    pub name: String,
    /// What it may send.
    pub sends: Vec<DriverSentence>,
    /// Where it is listened for, an IP address and a port. One program at a time.
    #[serde(default = "default_listen")]
    pub listen: String,
    /// The figures that it may send, and how often.
    #[serde(default)]
    pub bounds: DriverBounds,
}

fn default_listen() -> String {
    "127.0.0.1:29510".to_owned()
}

impl DriverTable {
    /// Core's part of it.
    #[must_use]
    pub fn setup(&self) -> DriverSetup {
        DriverSetup {
            name: self.name.clone(),
            sends: self.sends.clone(),
            bounds: self.bounds.clone(),
        }
    }

    /// Where it is listened for; `None` where `listen` is no address.
    #[must_use]
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen
            .parse()
            .ok()
            .filter(|address: &SocketAddr| address.port() > 0)
    }
}

/// What is wrong with the first driver that is no good, in one line.
pub(crate) fn check_drivers(drivers: &[DriverTable]) -> Result<(), String> {
    let (mut names, mut addresses) = (BTreeSet::new(), BTreeSet::new());
    for driver in drivers {
        let name = &driver.name;
        if name.is_empty() || !names.insert(name) {
            return Err(format!(
                "driver name `{name}`: expected one that is not empty and not used twice"
            ));
        }
        let sentences: BTreeSet<_> = driver.sends.iter().collect();
        if sentences.is_empty() || sentences.len() < driver.sends.len() {
            return Err(format!(
                "driver `{name}`: sends needs one sentence at least, and none twice"
            ));
        }
        let Some(address) = driver.address() else {
            return Err(format!(
                "driver `{name}`: listen is {:?}: expected an IP address and a port, such as 127.0.0.1:29510",
                driver.listen
            ));
        };
        if !addresses.insert(address) {
            return Err(format!(
                "driver `{name}`: listen is {address}, where another driver is listened for"
            ));
        }
        driver
            .bounds
            .validate()
            .map_err(|error| format!("driver `{name}`: bounds.{error}"))?;
    }
    Ok(())
}

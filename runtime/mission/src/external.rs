use std::collections::BTreeSet;
use std::net::SocketAddr;

use backseat_core::{ExternalBounds, ExternalSentence, ExternalSetup};
use serde::{Deserialize, Serialize};

/// A `[[external]]` table: a program of the operator's that may send what no plugin may.
///
/// ```toml
/// [[external]]
/// name = "usbl"
/// sends = ["BPNPU"]              # or BPCTD, BPTMR, BPRNS, BPRBO
/// listen = "127.0.0.1:29510"     # where it connects to, by TCP; the default is this machine alone
///
/// [external.bounds]
/// fix_distance_max_m = 200.0
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ExternalTable {
    /// Its name in this mission.
    pub name: String,
    /// What it may send.
    pub sends: Vec<ExternalSentence>,
    /// Where it is listened for, an IP address and a port. One program at a time.
    #[serde(default = "default_listen")]
    pub listen: String,
    /// The figures that it may send, and how often.
    #[serde(default)]
    pub bounds: ExternalBounds,
}

fn default_listen() -> String {
    "127.0.0.1:29510".to_owned()
}

impl ExternalTable {
    /// Core's part of it.
    #[must_use]
    pub fn setup(&self) -> ExternalSetup {
        ExternalSetup {
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

/// What is wrong with the first external source that is no good, in one line.
pub(crate) fn check_externals(externals: &[ExternalTable]) -> Result<(), String> {
    let (mut names, mut addresses) = (BTreeSet::new(), BTreeSet::new());
    for source in externals {
        let name = &source.name;
        if name.is_empty() || !names.insert(name) {
            return Err(format!(
                "external source name `{name}`: expected one that is not empty and not used twice"
            ));
        }
        let sentences: BTreeSet<_> = source.sends.iter().collect();
        if sentences.is_empty() || sentences.len() < source.sends.len() {
            return Err(format!(
                "external source `{name}`: sends needs one sentence at least, and none twice"
            ));
        }
        let Some(address) = source.address() else {
            return Err(format!(
                "external source `{name}`: listen is {:?}: expected an IP address and a port, such as 127.0.0.1:29510",
                source.listen
            ));
        };
        if !addresses.insert(address) {
            return Err(format!(
                "external source `{name}`: listen is {address}, where another external source is listened for"
            ));
        }
        source
            .bounds
            .validate()
            .map_err(|error| format!("external source `{name}`: bounds.{error}"))?;
    }
    Ok(())
}

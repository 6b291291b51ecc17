use std::collections::BTreeSet;
use std::net::SocketAddr;

use backseat_core::{ExternalBounds, ExternalSentence, ExternalSetup};
use serde::{Deserialize, Serialize};

/// An `[[external]]` table: an operator's program that may send sentences that no plugin may send.
///
/// ```toml
/// [[external]]
/// name = "usbl"
/// sends = ["BPNPU"]              # or BPCTD, BPTMR, BPRNS, BPRBO
/// listen = "127.0.0.1:29510"     # the TCP address it connects to; by default reachable from this machine only
///
/// [external.bounds]
/// fix_distance_max_m = 200.0
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ExternalTable {
    /// Its name in this mission.
    pub name: String,
    /// The sentences that it may send.
    pub sends: Vec<ExternalSentence>,
    /// The IP address and port on which we listen for it. One program may be connected at a time.
    #[serde(default = "default_listen")]
    pub listen: String,
    /// The values that it may send, and how often.
    #[serde(default)]
    pub bounds: ExternalBounds,
}

fn default_listen() -> String {
    "127.0.0.1:29510".to_owned()
}

impl ExternalTable {
    /// The part of this table that core needs.
    #[must_use]
    pub fn setup(&self) -> ExternalSetup {
        ExternalSetup {
            name: self.name.clone(),
            sends: self.sends.clone(),
            bounds: self.bounds.clone(),
        }
    }

    /// The address on which we listen for it; `None` where `listen` is invalid.
    #[must_use]
    pub fn address(&self) -> Option<SocketAddr> {
        self.listen
            .parse()
            .ok()
            .filter(|address: &SocketAddr| address.port() > 0)
    }
}

/// What is wrong with the first invalid external source, in one line.
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
                "external source `{name}`: sends needs at least one sentence, and each only once"
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
                "external source `{name}`: listen is {address}, which another external source uses already"
            ));
        }
        source
            .bounds
            .validate()
            .map_err(|error| format!("external source `{name}`: bounds.{error}"))?;
    }
    Ok(())
}

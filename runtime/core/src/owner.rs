use std::fmt;

use serde::{Deserialize, Serialize};

use crate::plugin::PluginId;

/// Which external source of the mission: its place in the mission file, 0 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ExternalId(pub usize);

/// Whose a request is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Owner {
    /// A plugin's, under a grant.
    Plugin(PluginId),
    /// The operator's, by word or by a policy of the mission.
    Operator,
    /// An external source's.
    External(ExternalId),
}

impl Owner {
    /// The plugin, where it is one's.
    #[must_use]
    pub const fn plugin(self) -> Option<PluginId> {
        match self {
            Self::Plugin(plugin) => Some(plugin),
            Self::Operator | Self::External(_) => None,
        }
    }
}

impl From<PluginId> for Owner {
    fn from(plugin: PluginId) -> Self {
        Self::Plugin(plugin)
    }
}

impl From<ExternalId> for Owner {
    fn from(source: ExternalId) -> Self {
        Self::External(source)
    }
}

impl PartialEq<PluginId> for Owner {
    fn eq(&self, plugin: &PluginId) -> bool {
        self.plugin() == Some(*plugin)
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plugin(plugin) => write!(f, "plugin {}", plugin.0),
            Self::Operator => f.write_str("operator"),
            Self::External(source) => write!(f, "external source {}", source.0),
        }
    }
}

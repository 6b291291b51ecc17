use std::fmt;

use serde::{Deserialize, Serialize};

use crate::plugin::PluginId;

/// An external source of the mission, by its place in the mission file, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ExternalId(pub usize);

/// The owner of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Owner {
    /// A plugin, under a grant.
    Plugin(PluginId),
    /// The operator, who orders at once or by a policy of the mission.
    Operator,
    /// An external source.
    External(ExternalId),
}

impl Owner {
    /// The plugin, if the owner is one.
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

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::{Briefing, Description, Request, StepInput};

/// A plugin. [`export!`](crate::export!) makes a component from a type that implements this trait.
pub trait Plugin: Sized {
    /// The plugin's configuration, which is its `[plugin.config]` table in the mission file. Derive
    /// `serde::Deserialize` with `#[serde(deny_unknown_fields)]`, so that a misspelt key is an error, and put units
    /// into the names of keys (`depth_m`). Use [`NoConfig`] for a plugin without settings.
    type Config: DeserializeOwned;

    /// Returns the plugin's name, version, step period (20 ms to 60 s), the topics that it listens to beside the events
    /// that every plugin receives, and the grants that it needs.
    fn describe() -> Description;

    /// Creates an instance. Refuse invalid values here, so that the mission does not start, rather than in a step at
    /// sea.
    ///
    /// # Errors
    /// One line with the key and what was expected. The mission does not start.
    fn new(config: Self::Config) -> Result<Self, String>;

    /// Learns about the mission: fence, limits, grants and budget. Called once after [`Plugin::new`], also in a new
    /// instance after a failure. Does nothing by default.
    ///
    /// # Errors
    /// One line with what makes the mission impossible for this plugin, and what to change. The mission does not start.
    fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
        let _ = briefing;
        Ok(())
    }

    /// Runs one step: takes in what has happened since the last one, and returns the requests of now.
    ///
    /// # Errors
    /// One line for the log. An error counts as a failure of the plugin. Return one only if the plugin cannot continue,
    /// not for conditions that are to be expected at sea.
    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String>;

    /// Returns all that a new instance needs to continue from here, at most 1 MiB. The runtime calls this every few
    /// steps. Empty by default.
    fn snapshot(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Restores the state that [`Plugin::snapshot`] returned in an earlier instance. Does nothing by default.
    ///
    /// # Errors
    /// One line with what is wrong with the state. That counts as another failure: the runtime tries again with a longer
    /// pause, and gives up after the fifth restart.
    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let _ = state;
        Ok(())
    }
}

/// The configuration of a plugin without settings. Every key is an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoConfig {}

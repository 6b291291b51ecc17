use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::{Description, Request, StepInput};

/// A plugin: what [`export!`](crate::export!) makes a component of.
pub trait Plugin: Sized {
    /// The plugin's table in the mission file. Derive `serde::Deserialize` with `#[serde(deny_unknown_fields)]`, so that
    /// a misspelt key is refused by its name, and let keys carry their units (`depth_m`). [`NoConfig`] where there is
    /// nothing to set.
    type Config: DeserializeOwned;

    /// Name, version, step period (20 ms to 60 s) and the events that it wants beside those that all plugins get.
    fn describe() -> Description;

    /// A new instance. Refuse figures that make no sense here, ashore, rather than in a step.
    ///
    /// # Errors
    /// A line that names the key and what was expected. The mission does not start.
    fn new(config: Self::Config) -> Result<Self, String>;

    /// One step: what has happened, and what the plugin asks for now.
    ///
    /// # Errors
    /// A line for the log. It counts as a failure of the plugin: for what the plugin cannot go on with, not for what it
    /// may meet at sea.
    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String>;

    /// All that a new instance needs to go on where this one is, at most 1 MiB. Taken every few steps. Nothing, by default.
    fn snapshot(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Brings a new instance to where [`Plugin::snapshot`] was taken. Does nothing by default.
    ///
    /// # Errors
    /// A line that says what is wrong with the state. The plugin is then not started again.
    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let _ = state;
        Ok(())
    }
}

/// The configuration of a plugin that has nothing to set: refuses every key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoConfig {}

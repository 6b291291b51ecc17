use std::path::Path;

use backseat_mvc::{FaultPlan, Script};

use crate::error::ScenarioError;

/// Reads faults from a separate file, which replaces the faults of `world.toml`.
///
/// # Errors
///
/// [`ScenarioError`] with the file and the fault's number.
pub fn read_faults(path: &Path) -> Result<FaultPlan, ScenarioError> {
    let text = std::fs::read_to_string(path).map_err(|source| ScenarioError::Read {
        path: path.to_path_buf(),
        source,
    })?;
    FaultPlan::from_toml(&text).map_err(|source| ScenarioError::world(path, source))
}

/// Reads a script: rules that say what shall happen in a run, and when.
///
/// # Errors
///
/// [`ScenarioError`] with the file, and the line or the rule's number.
pub fn read_script(path: &Path) -> Result<Script, ScenarioError> {
    let text = std::fs::read_to_string(path).map_err(|source| ScenarioError::Read {
        path: path.to_path_buf(),
        source,
    })?;
    Script::from_toml(&text).map_err(|source| ScenarioError::world(path, source))
}

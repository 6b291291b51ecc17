use backseat_core::{Grant, Limits};
use backseat_fence::Fence;

/// What a plugin is told about its mission before its first step.
#[derive(Clone, Copy, Debug)]
pub struct Brief<'a> {
    /// Its configuration from the mission file, as JSON.
    pub config_json: &'a str,
    /// What the mission allows it to ask for.
    pub grants: &'a [Grant],
    /// The mission's fence.
    pub fence: &'a Fence,
    /// The mission's limits.
    pub limits: &'a Limits,
}

use backseat_core::plugin::{LogLine, PluginFault, Request};
use serde::Serialize;

/// A step of a plugin in the shadow of another one: it gets the same inputs, and nothing that it asks for is sent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowStep {
    /// The plugin in whose shadow it is.
    pub plugin: String,
    /// The SHA-256 of its component, hexadecimal.
    pub sha256: String,
    /// When core asked the plugin for this step, seconds of the run.
    pub step_s: f64,
    /// The fuel used.
    pub fuel: u64,
    /// The lines that it logged.
    pub log: Vec<LogLine>,
    /// What it asks for.
    pub requests: Vec<Request>,
    /// What the safety monitor says of the geometry and the figures of each, in the same order. Control, rate and
    /// priority are not judged.
    pub judged: Vec<Judged>,
    /// How it failed, if it did.
    pub fault: Option<PluginFault>,
    /// Steps before this one that it missed, because it was still at an earlier one.
    pub missed: u64,
}

/// What the safety monitor says of a request.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Whether it could be sent, as far as its geometry and its figures go.
    pub allowed: bool,
    /// The clearance in metres; `None` if it is refused or has no geometry.
    pub clearance_m: Option<f64>,
    /// Why it is refused.
    pub refusal: Option<String>,
}

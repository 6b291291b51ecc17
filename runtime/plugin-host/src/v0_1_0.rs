//! The host's side of `wit/v0.1.0`: what differs from `wit/v0.2.0`. A plugin of this version is told its configuration
//! alone, and does not say which grants it needs.

use crate::v0_2_0;

/// The types of this version: those of the later one, and the description, which has another place there.
#[allow(unreachable_pub, reason = "the generated code exports it again")]
pub mod types {
    use wasmtime::component::{ComponentType, Lift};

    pub use crate::v0_2_0::bindings::backseat::plugin::types::*;

    /// What a plugin says about itself.
    #[derive(Clone, Debug, ComponentType, Lift)]
    #[component(record)]
    pub struct Description {
        pub name: String,
        pub version: String,
        #[component(name = "step-period-ns")]
        pub step_period_ns: u64,
        pub topics: Vec<Topic>,
    }
}

#[allow(
    missing_docs,
    unreachable_pub,
    clippy::all,
    clippy::wildcard_enum_match_arm,
    reason = "generated"
)]
pub(crate) mod bindings {
    wasmtime::component::bindgen!({
        path: "../../wit/v0.1.0",
        world: "plugin",
        with: { "backseat:plugin/types": crate::v0_1_0::types },
    });
}

/// The imports that a plugin may have. The last one has names only.
pub(crate) const IMPORTS: [&str; 4] = [
    "backseat:plugin/log@0.1.0",
    "backseat:plugin/fence@0.1.0",
    "backseat:plugin/measures@0.1.0",
    "backseat:plugin/types@0.1.0",
];

/// A description as the later version has it.
pub(crate) fn described(description: types::Description) -> v0_2_0::bindings::backseat::plugin::mission::Description {
    v0_2_0::bindings::backseat::plugin::mission::Description {
        name: description.name,
        version: description.version,
        step_period_ns: description.step_period_ns,
        topics: description.topics,
        grants: Vec::new(),
    }
}

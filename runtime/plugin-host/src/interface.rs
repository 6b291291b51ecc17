//! The versions of the interface, and a plugin's functions in each of them.

use wasmtime::component::{InstancePre, Linker};
use wasmtime::{Result, Store};

use crate::instance::State;
use crate::v0_2_0::bindings::backseat::plugin::mission::{Briefing, Description};
use crate::v0_2_0::bindings::backseat::plugin::types::{Request, StepInput};
use crate::{v0_1_0, v0_2_0};

/// A version of `wit/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interface {
    /// `wit/v0.1.0`.
    V0_1_0,
    /// `wit/v0.2.0`.
    V0_2_0,
}

/// The exports that a plugin must have.
pub(crate) const EXPORTS: [&str; 5] = ["describe", "init", "step", "snapshot", "restore"];
/// What a plugin may import, as text for messages.
pub(crate) const IMPORTS_TEXT: &str = "log, fence and measures of backseat:plugin@0.2.0 or @0.1.0";

impl Interface {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::V0_1_0, Self::V0_2_0];

    /// The package's name with the version.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::V0_1_0 => "backseat:plugin@0.1.0",
            Self::V0_2_0 => "backseat:plugin@0.2.0",
        }
    }

    /// The imports that a plugin may have.
    pub(crate) const fn imports(self) -> &'static [&'static str] {
        match self {
            Self::V0_1_0 => &v0_1_0::IMPORTS,
            Self::V0_2_0 => &v0_2_0::IMPORTS,
        }
    }

    /// The version that has this import.
    pub(crate) fn of_import(import: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|interface| interface.imports().contains(&import))
    }
}

/// Defines the imports of all versions.
pub(crate) fn link(linker: &mut Linker<State>) -> Result<()> {
    Interface::ALL
        .into_iter()
        .try_for_each(|interface| v0_2_0::link(linker, interface.imports()))
}

/// A component whose imports are defined, and whose exports are known.
pub(crate) enum Linked {
    V0_1_0(v0_1_0::bindings::PluginPre<State>),
    V0_2_0(v0_2_0::bindings::PluginPre<State>),
}

/// The functions of an instance.
pub(crate) enum Exports {
    V0_1_0(v0_1_0::bindings::Plugin),
    V0_2_0(v0_2_0::bindings::Plugin),
}

impl Linked {
    pub(crate) fn new(interface: Interface, component: InstancePre<State>) -> Result<Self> {
        Ok(match interface {
            Interface::V0_1_0 => Self::V0_1_0(v0_1_0::bindings::PluginPre::new(component)?),
            Interface::V0_2_0 => Self::V0_2_0(v0_2_0::bindings::PluginPre::new(component)?),
        })
    }

    pub(crate) const fn interface(&self) -> Interface {
        match self {
            Self::V0_1_0(_) => Interface::V0_1_0,
            Self::V0_2_0(_) => Interface::V0_2_0,
        }
    }

    pub(crate) fn instantiate(&self, store: &mut Store<State>) -> Result<Exports> {
        Ok(match self {
            Self::V0_1_0(linked) => Exports::V0_1_0(linked.instantiate(store)?),
            Self::V0_2_0(linked) => Exports::V0_2_0(linked.instantiate(store)?),
        })
    }
}

impl Exports {
    pub(crate) fn describe(&self, store: &mut Store<State>) -> Result<Description> {
        match self {
            Self::V0_1_0(plugin) => plugin.call_describe(store).map(v0_1_0::described),
            Self::V0_2_0(plugin) => plugin.call_describe(store),
        }
    }

    pub(crate) fn init(
        &self,
        store: &mut Store<State>,
        briefing: &Briefing,
    ) -> Result<core::result::Result<(), String>> {
        match self {
            Self::V0_1_0(plugin) => plugin.call_init(store, &briefing.config),
            Self::V0_2_0(plugin) => plugin.call_init(store, briefing),
        }
    }

    pub(crate) fn step(
        &self,
        store: &mut Store<State>,
        input: &StepInput,
    ) -> Result<core::result::Result<Vec<Request>, String>> {
        match self {
            Self::V0_1_0(plugin) => plugin.call_step(store, input),
            Self::V0_2_0(plugin) => plugin.call_step(store, input),
        }
    }

    pub(crate) fn snapshot(&self, store: &mut Store<State>) -> Result<Vec<u8>> {
        match self {
            Self::V0_1_0(plugin) => plugin.call_snapshot(store),
            Self::V0_2_0(plugin) => plugin.call_snapshot(store),
        }
    }

    pub(crate) fn restore(&self, store: &mut Store<State>, state: &[u8]) -> Result<core::result::Result<(), String>> {
        match self {
            Self::V0_1_0(plugin) => plugin.call_restore(store, state),
            Self::V0_2_0(plugin) => plugin.call_restore(store, state),
        }
    }
}

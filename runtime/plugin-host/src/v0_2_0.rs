//! The host's side of `wit/v0.2.0`: its imports, and the conversions between its types and those of core.

use std::time::Duration;

use backseat_core::plugin as core;
use backseat_core::refusal::Reason;
use backseat_units::Timestamp;
use wasmtime::StoreContextMut;
use wasmtime::component::{Linker, WasmStr};

use crate::instance::{FENCE_FUEL, LOG_FUEL, PUBLISH_FUEL, State, charge, cut, said};

mod briefing;
mod description;
mod event;
mod outcome;
mod request;
mod sample;
mod sonar;

pub(crate) use briefing::briefing;
pub(crate) use description::{Described, description};
pub(crate) use request::requests;

#[allow(
    missing_docs,
    unreachable_pub,
    clippy::all,
    clippy::wildcard_enum_match_arm,
    reason = "generated"
)]
pub(crate) mod bindings {
    wasmtime::component::bindgen!({ path: "../../wit/v0.2.0", world: "plugin" });
}

use bindings::backseat::plugin::log::Level;
use bindings::backseat::plugin::mission as wit_mission;
use bindings::backseat::plugin::types as wit;

/// The imports that a plugin may have. The last two have names only.
pub(crate) const IMPORTS: [&str; 5] = [
    "backseat:plugin/log@0.2.0",
    "backseat:plugin/fence@0.2.0",
    "backseat:plugin/measures@0.2.0",
    "backseat:plugin/types@0.2.0",
    "backseat:plugin/mission@0.2.0",
];

/// Defines imports under these names, the first three of which have functions. Their types are the same in all versions
/// of the interface so far.
pub(crate) fn link(linker: &mut Linker<State>, imports: &[&str]) -> wasmtime::Result<()> {
    for (place, name) in imports.iter().enumerate() {
        let mut instance = linker.instance(name)?;
        match place {
            0 => instance.func_wrap("write", write)?,
            1 => instance.func_wrap("check", check)?,
            2 => instance.func_wrap("publish", publish)?,
            _ => {}
        }
    }
    Ok(())
}

/// `log.write`. The text is read from the plugin's memory only if the line is kept.
fn write(mut store: StoreContextMut<'_, State>, (level, text): (Level, WasmStr)) -> wasmtime::Result<()> {
    charge(&mut store, LOG_FUEL)?;
    if !store.data_mut().admit_line() {
        return Ok(());
    }
    let (line, bytes) = {
        let text = text.to_str(&store)?;
        (said(&text), text.len())
    };
    charge(&mut store, bytes as u64)?;
    let level = match level {
        Level::Debug => core::LogLevel::Debug,
        Level::Info => core::LogLevel::Info,
        Level::Warn => core::LogLevel::Warn,
        Level::Error => core::LogLevel::Error,
    };
    store.data_mut().write_line(level, line);
    Ok(())
}

/// `measures.publish`.
fn publish(
    mut store: StoreContextMut<'_, State>,
    (name, value, unit): (WasmStr, f64, WasmStr),
) -> wasmtime::Result<()> {
    charge(&mut store, PUBLISH_FUEL)?;
    let (name, unit, bytes) = {
        let (name, unit) = (name.to_str(&store)?, unit.to_str(&store)?);
        let bytes = name.len() + unit.len();
        (cut(&name).to_owned(), cut(&unit).to_owned(), bytes)
    };
    charge(&mut store, bytes as u64)?;
    store.data_mut().publish(&name, value, &unit);
    Ok(())
}

/// `fence.check`.
fn check(
    mut store: StoreContextMut<'_, State>,
    (request,): (wit::Request,),
) -> wasmtime::Result<(Result<f64, wit::Refusal>,)> {
    charge(&mut store, FENCE_FUEL)?;
    let state = store.data();
    let Some(step) = state.step() else {
        let refusal = core::Refusal::State(Reason::NotInStep);
        return Ok((Err(wit::Refusal::from(&refusal)),));
    };
    Ok((state
        .judge()
        .judge(&core::Request::from(request), step)
        .map_err(|refusal| wit::Refusal::from(&refusal)),))
}

/// A step's input as the guest receives it.
pub(crate) struct Input(wit::StepInput);

impl Default for Input {
    fn default() -> Self {
        Self(wit::StepInput {
            now_ns: 0,
            utc_ns: 0,
            navigation: None,
            relative: None,
            cartesian: None,
            control: false,
            events: Vec::new(),
        })
    }
}

impl Input {
    /// Replaces the previous input and reuses its allocations.
    pub(crate) fn fill(&mut self, input: &core::StepInput) -> &wit::StepInput {
        self.0.now_ns = input.now.as_nanos();
        self.0.utc_ns = input.utc.as_unix_nanos();
        self.0.control = input.control;
        self.0.navigation = input
            .navigation
            .as_ref()
            .map(|sample| sample::navigation(sample, input.now));
        self.0.relative = input
            .relative
            .as_ref()
            .map(|sample| sample::relative(sample, input.now));
        self.0.cartesian = input
            .cartesian
            .as_ref()
            .map(|sample| sample::cartesian(sample, input.now));
        self.0.events.clear();
        self.0
            .events
            .extend(input.events.iter().map(|happened| event::event(happened, input.now)));
        &self.0
    }
}

/// The age of a moment at the step, nanoseconds.
fn age_ns(then: Timestamp, now: Timestamp) -> u64 {
    nanos(now.since(then))
}

impl From<backseat_units::Position> for wit::Position {
    fn from(position: backseat_units::Position) -> Self {
        Self {
            latitude: position.latitude.as_deg(),
            longitude: position.longitude.as_deg(),
        }
    }
}

/// The nanoseconds of a duration between two timestamps, which always fit.
fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

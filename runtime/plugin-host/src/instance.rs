//! One instance of a component: its store, its limits, and the state that its imports write to.

use std::sync::Arc;

use backseat_core::plugin::{FaultKind, Judge, LogLevel, LogLine, PluginFault, StepInput};
use wasmtime::{ResourceLimiter, Store, StoreContextMut, Trap};

use crate::error::one_line;
use crate::interface::Exports;
use crate::measures::Published;
use crate::plugin::{DEADLINE, SNAPSHOT_BYTES};
use crate::{Budget, Component};

/// Fuel for a log line, plus one unit for each of its bytes.
pub const LOG_FUEL: u64 = 1_000;
/// Fuel for a published value, plus one unit for each byte of its name and unit.
pub const PUBLISH_FUEL: u64 = 500;
/// Fuel for a question to the fence.
pub const FENCE_FUEL: u64 = 10_000;

/// How many log lines of one call are kept.
const LOG_LINES: usize = 32;
/// The longest text of a log line, a fault or a message, bytes.
pub(crate) const TEXT_BYTES: usize = 256;

/// Bytes that a plugin may pass to the host in one call of an import, or return from one call, unless stated otherwise.
pub(crate) const CALL_BYTES: usize = 128 << 10;

/// A deadline that is never reached. It is not the largest number, because wasmtime adds the current epoch to it.
const NO_DEADLINE: u64 = u64::MAX / 2;

/// A live instance. It is discarded after a fault.
pub(crate) struct Instance {
    store: Store<State>,
    exports: Exports,
}

/// The result of a call.
pub(crate) struct Called<T> {
    pub(crate) fuel: u64,
    pub(crate) result: Result<T, PluginFault>,
}

/// The store's data.
pub(crate) struct State {
    limits: Limits,
    /// What the call was given, or all calls of a start together.
    fuel: (FuelOf, u64),
    judge: Arc<dyn Judge>,
    /// The step that is running, without its events; `None` in other calls.
    step: Option<StepInput>,
    log: Vec<LogLine>,
    lines_allowed: usize,
    lines_dropped: u64,
    published: Published,
}

impl Instance {
    /// Creates an instance and runs the component's own initialisation on `fuel`. The fault is [`FaultKind::Start`] if
    /// nothing was run because the exports have other types.
    pub(crate) fn new(
        component: &Component,
        budget: &Budget,
        judge: Arc<dyn Judge>,
        fuel: u64,
        deadline_ticks: Option<u64>,
    ) -> Result<Self, PluginFault> {
        let limits = Limits {
            bytes_max: budget.memory_bytes,
            bytes_left: budget.memory_bytes,
            elements_left: TABLE_ELEMENTS,
            refused: None,
        };
        let state = State {
            limits,
            fuel: (FuelOf::Start, fuel),
            judge,
            step: None,
            log: Vec::new(),
            lines_allowed: LOG_LINES,
            lines_dropped: 0,
            published: Published::default(),
        };
        let mut store = Store::new(component.engine(), state);
        store.limiter(|state| &mut state.limits);
        store.set_hostcall_fuel(CALL_BYTES);
        store.set_epoch_deadline(deadline_ticks.unwrap_or(NO_DEADLINE));
        set_fuel(&mut store, fuel);
        match component.linked().instantiate(&mut store) {
            Ok(exports) => Ok(Self { store, exports }),
            Err(error) => {
                let fault = fault(&error, store.data());
                let ran = fault.kind != FaultKind::Trap || error.is::<Trap>();
                Err(if ran {
                    fault
                } else {
                    PluginFault {
                        kind: FaultKind::Start,
                        ..fault
                    }
                })
            }
        }
    }

    /// Calls an export on `fuel`; the export may return `bytes` to the host. A fault uses up all of the fuel.
    pub(crate) fn call<T>(
        &mut self,
        (of, fuel): (FuelOf, u64),
        bytes: usize,
        deadline_ticks: Option<u64>,
        call: impl FnOnce(&Exports, &mut Store<State>) -> wasmtime::Result<T>,
    ) -> Called<T> {
        set_fuel(&mut self.store, fuel);
        self.store.data_mut().fuel = (of, fuel);
        self.call_on(bytes, deadline_ticks, call)
    }

    /// Calls an export of a start on the fuel that is left of it.
    pub(crate) fn call_on<T>(
        &mut self,
        bytes: usize,
        deadline_ticks: Option<u64>,
        call: impl FnOnce(&Exports, &mut Store<State>) -> wasmtime::Result<T>,
    ) -> Called<T> {
        let fuel = self.fuel_left();
        self.store.set_epoch_deadline(deadline_ticks.unwrap_or(NO_DEADLINE));
        self.store.set_hostcall_fuel(bytes);
        self.store.data_mut().limits.refused = None;
        match call(&self.exports, &mut self.store) {
            Ok(value) => Called {
                fuel: fuel - self.fuel_left(),
                result: Ok(value),
            },
            Err(error) => Called {
                fuel,
                result: Err(fault(&error, self.store.data())),
            },
        }
    }

    /// Sets the step from which the `fence` import answers, until this is called again.
    pub(crate) fn set_step(&mut self, step: Option<StepInput>) {
        self.store.data_mut().step = step;
    }

    /// The fuel that the last call left.
    pub(crate) fn fuel_left(&self) -> u64 {
        self.store.get_fuel().expect("the engine counts fuel")
    }

    /// The linear memory that it has, bytes. It never shrinks.
    pub(crate) fn memory_bytes(&self) -> usize {
        let limits = &self.store.data().limits;
        limits.bytes_max - limits.bytes_left
    }

    /// Sets how many lines the next calls may log, at most [`LOG_LINES`].
    pub(crate) fn allow_lines(&mut self, lines: usize) {
        self.store.data_mut().lines_allowed = lines.min(LOG_LINES);
    }

    /// The values published since they were last taken.
    pub(crate) fn published(&mut self) -> &mut Published {
        &mut self.store.data_mut().published
    }

    /// Keeps only the first lines since they were last taken, and forgets what was dropped.
    pub(crate) fn truncate_log(&mut self, lines: usize) {
        let state = self.store.data_mut();
        state.log.truncate(lines);
        state.lines_dropped = 0;
    }

    /// The lines logged since this was last called, and how many more were dropped.
    pub(crate) fn take_log(&mut self) -> (Vec<LogLine>, u64) {
        let state = self.store.data_mut();
        (std::mem::take(&mut state.log), std::mem::take(&mut state.lines_dropped))
    }
}

impl State {
    pub(crate) fn judge(&self) -> &dyn Judge {
        &*self.judge
    }

    pub(crate) fn step(&self) -> Option<&StepInput> {
        self.step.as_ref()
    }

    /// Whether another log line is kept. A line that is not kept is counted.
    pub(crate) fn admit_line(&mut self) -> bool {
        let admitted = self.log.len() < self.lines_allowed;
        self.lines_dropped += u64::from(!admitted);
        admitted
    }

    pub(crate) fn write_line(&mut self, level: LogLevel, text: String) {
        self.log.push(LogLine { level, text });
    }

    pub(crate) fn publish(&mut self, name: &str, value: f64, unit: &str) {
        self.published.publish(name, value, unit);
    }
}

/// Charges the price of an import to the plugin's fuel.
pub(crate) fn charge(store: &mut StoreContextMut<'_, State>, price: u64) -> wasmtime::Result<()> {
    let left = store.get_fuel()?.checked_sub(price);
    store.set_fuel(left.unwrap_or(0))?;
    if left.is_some() {
        Ok(())
    } else {
        Err(Trap::OutOfFuel.into())
    }
}

/// The text, cut between characters at the bound.
pub(crate) fn cut(text: &str) -> &str {
    &text[..text.floor_char_boundary(TEXT_BYTES)]
}

/// What a plugin says, in one line that drives no terminal: the end of a line becomes a space, and what would move the
/// cursor or turn the direction of writing is escaped. Otherwise a plugin could forge lines of reports. Cut at the bound.
pub(crate) fn said(text: &str) -> String {
    let text = cut(text);
    if !text.contains(forges) {
        return text.to_owned();
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        match character {
            // The message of a panic in Rust has two lines.
            '\n' | '\t' => escaped.push(' '),
            _ if forges(character) => escaped.extend(character.escape_default()),
            _ => escaped.push(character),
        }
    }
    cut(&escaped).to_owned()
}

/// Controls, separators of lines and paragraphs, and marks of the direction of writing.
fn forges(character: char) -> bool {
    let marks =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    character.is_control() || marks
}

fn set_fuel(store: &mut Store<State>, fuel: u64) {
    store.set_fuel(fuel).expect("the engine counts fuel");
}

/// The bound that a plugin broke.
fn fault(error: &wasmtime::Error, state: &State) -> PluginFault {
    /// wasmtime's type of this error is private. Its version is fixed, and a test checks that this text still matches.
    const TOO_MUCH: &str = "too much data is being copied between the host and the guest";
    let text = one_line(error);
    let trap = error.downcast_ref::<Trap>();
    let kind = match trap {
        Some(Trap::OutOfFuel) => FaultKind::OutOfFuel,
        Some(Trap::Interrupt) => FaultKind::Deadline,
        _ if text.contains(TOO_MUCH) => FaultKind::TooMuch,
        _ if state.limits.refused.is_some() => FaultKind::Memory,
        _ => FaultKind::Trap,
    };
    let text = match kind {
        FaultKind::OutOfFuel => {
            let (of, fuel) = state.fuel;
            format!("used all its fuel: {fuel} units in one {}", of.advice())
        }
        FaultKind::Deadline => DEADLINE.to_owned(),
        FaultKind::TooMuch => format!(
            "passed more to the host than one call may: {} KiB, or {} KiB in a snapshot",
            CALL_BYTES >> 10,
            SNAPSHOT_BYTES >> 10
        ),
        FaultKind::Memory => {
            let refused = state.limits.refused.map(|refused| state.limits.describe(refused));
            cut(&format!("{}: {text}", refused.unwrap_or_default())).to_owned()
        }
        FaultKind::Trap | FaultKind::Error | FaultKind::Overflow | FaultKind::Start | FaultKind::Trial => {
            let text = match trap {
                Some(Trap::StackOverflow) => format!("used all its stack, as recursion without end does: {text}"),
                // The stack of a compiled language lies at the bottom of the plugin's memory and grows downwards.
                Some(Trap::MemoryOutOfBounds) => {
                    format!(
                        "went outside its memory, as recursion without end does, or a wrong index or pointer: {text}"
                    )
                }
                _ => text,
            };
            cut(&text).to_owned()
        }
    };
    PluginFault { kind, text }
}

/// What a call has fuel for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FuelOf {
    /// `describe`, `init` and `restore`, together with the component's own initialisation.
    Start,
    /// `step`.
    Step,
    /// `snapshot`.
    Snapshot,
}

impl FuelOf {
    /// What it is for, why it may be used up, and what to do.
    const fn advice(self) -> &'static str {
        match self {
            Self::Start => {
                "start: too much work in it, or a loop without end (the same for each plugin: no key of mission.toml sets it)"
            }
            Self::Step => {
                "call: too much for one step, or a loop without end (plugin.budget.fuel_per_step in mission.toml)"
            }
            Self::Snapshot => {
                "snapshot: too much state, or a loop without end (the same for each plugin: no key of mission.toml sets it)"
            }
        }
    }
}

/// Elements in all tables together: functions that are called through pointers.
const TABLE_ELEMENTS: usize = 100_000;

/// What an instance may still allocate.
struct Limits {
    bytes_max: usize,
    bytes_left: usize,
    elements_left: usize,
    /// The growth that was refused last during this call.
    refused: Option<Refused>,
}

/// A growth that was refused.
#[derive(Clone, Copy)]
enum Refused {
    /// Of a memory, by so many bytes.
    Memory(usize),
    /// Of a table, by so many elements.
    Table(usize),
}

impl Limits {
    /// What was refused, and what was left.
    fn describe(&self, refused: Refused) -> String {
        let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
        match refused {
            Refused::Memory(asked) => format!(
                "was refused {:.2} MiB of memory, as it uses {:.2} MiB of its {:.2} MiB (plugin.budget.memory_mib in mission.toml)",
                mib(asked),
                mib(self.bytes_max - self.bytes_left),
                mib(self.bytes_max)
            ),
            Refused::Table(asked) => format!(
                "was refused {asked} elements of a table, as it uses {} of its {TABLE_ELEMENTS}",
                TABLE_ELEMENTS - self.elements_left
            ),
        }
    }
}

/// Takes a growth from what is left, or returns by how much it was to grow.
fn take(left: &mut usize, current: usize, desired: usize) -> Result<(), usize> {
    let growth = desired.saturating_sub(current);
    *left = left.checked_sub(growth).ok_or(growth)?;
    Ok(())
}

impl ResourceLimiter for Limits {
    fn memory_growing(&mut self, current: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        let taken = take(&mut self.bytes_left, current, desired);
        self.refused = taken.err().map(Refused::Memory).or(self.refused);
        Ok(taken.is_ok())
    }

    fn table_growing(&mut self, current: usize, desired: usize, _: Option<usize>) -> wasmtime::Result<bool> {
        let taken = take(&mut self.elements_left, current, desired);
        self.refused = taken.err().map(Refused::Table).or(self.refused);
        Ok(taken.is_ok())
    }

    fn instances(&self) -> usize {
        64
    }

    fn tables(&self) -> usize {
        32
    }

    fn memories(&self) -> usize {
        8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_plugin_says_is_one_line_that_drives_no_terminal() {
        assert_eq!(
            said("12.5 °C: naïve, \"quoted\" \\ 深さ"),
            "12.5 °C: naïve, \"quoted\" \\ 深さ"
        );
        assert_eq!(
            said("x\n  no violation\r\n\u{1b}[1A\u{202e}evil\u{2028}"),
            "x   no violation\\r \\u{1b}[1A\\u{202e}evil\\u{2028}"
        );
        assert_eq!(said(&"\u{1b}".repeat(1000)).len(), TEXT_BYTES / 6 * 6 + TEXT_BYTES % 6);
    }
}

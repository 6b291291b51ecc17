//! What stands in for the runtime's imports on the host: standard error, or the recorder of a test.

use std::cell::RefCell;
use std::collections::BTreeMap;

use crate::log::Level;
use crate::{Refusal, Request, Rule};

/// Answers a question to the fence: a refusal, or nothing if it has none.
pub(crate) type Answer = Box<dyn FnMut(&Request) -> Option<Refusal>>;
/// The clearance of what is not refused, metres: the greatest that the runtime gives.
const CLEARANCE_M: f64 = 1000.0;

/// What a plugin has logged and published, and the fence that answers it.
pub(crate) struct Recorder {
    pub(crate) lines: Vec<(Level, String)>,
    pub(crate) measures: BTreeMap<String, Vec<f64>>,
    pub(crate) fence: Answer,
}

thread_local! {
    static CURRENT: RefCell<Option<Recorder>> = const { RefCell::new(None) };
}

/// Calls a function with a recorder in place, and gives back the recorder.
pub(crate) fn with<R>(recorder: Recorder, call: impl FnOnce() -> R) -> (Recorder, R) {
    let before = CURRENT.replace(Some(recorder));
    let result = call();
    let recorder = CURRENT.replace(before);
    #[expect(clippy::expect_used, reason = "it was put there above")]
    (recorder.expect("the recorder of this test"), result)
}

pub(crate) fn write(level: Level, text: &str) {
    let recorded = CURRENT.with_borrow_mut(|current| {
        let recorder = current.as_mut()?;
        recorder.lines.push((level, text.to_owned()));
        Some(())
    });
    if recorded.is_none() {
        eprintln!("{level:?}: {text}");
    }
}

pub(crate) fn publish(name: &str, value: f64, unit: &str) {
    let recorded = CURRENT.with_borrow_mut(|current| {
        let recorder = current.as_mut()?;
        recorder.measures.entry(name.to_owned()).or_default().push(value);
        Some(())
    });
    if recorded.is_none() {
        eprintln!("{name} = {value} {unit}");
    }
}

#[expect(clippy::result_large_err, reason = "the interface's own type")]
pub(crate) fn check(request: &Request) -> Result<f64, Refusal> {
    CURRENT.with_borrow_mut(|current| match current {
        Some(recorder) => (recorder.fence)(request).map_or(Ok(CLEARANCE_M), Err),
        None => Err(Refusal::new(Rule::State, "no fence outside the runtime")),
    })
}

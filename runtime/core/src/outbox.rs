pub(crate) mod budget;

use std::collections::VecDeque;

use backseat_units::Timestamp;

use crate::io::{Note, Output};
use crate::outbox::budget::LineBudget;

/// What is to be done by whoever drives core, oldest first.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Outbox {
    #[cfg_attr(feature = "explore", serde(skip))]
    outputs: VecDeque<Output>,
    /// Lines about what the vehicle says.
    vehicle_lines: LineBudget,
}

impl Outbox {
    pub(crate) fn push(&mut self, output: Output) {
        self.outputs.push_back(output);
    }

    pub(crate) fn pop(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    pub(crate) fn note(&mut self, note: Note) {
        self.push(Output::Note(note));
    }

    /// As [`Outbox::note`], of what the vehicle has said: so many a second, the rest is counted.
    pub(crate) fn note_of_vehicle(&mut self, now: Timestamp, note: Note) {
        if self.vehicle_lines.take(now) {
            self.note(note);
        }
    }

    /// How many lines about the vehicle were counted and not noted since this was last asked.
    pub(crate) fn take_dropped(&mut self) -> u64 {
        self.vehicle_lines.take_dropped()
    }
}

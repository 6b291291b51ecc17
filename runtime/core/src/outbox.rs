pub(crate) mod budget;

use std::collections::VecDeque;

use backseat_units::Timestamp;

use crate::io::{Note, Output};
use crate::outbox::budget::LineBudget;

/// What the driver has to do, oldest first.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Outbox {
    #[cfg_attr(feature = "explore", serde(skip))]
    outputs: VecDeque<Output>,
    /// Limits the lines about what the vehicle says.
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

    /// As [`Outbox::note`], for what the vehicle has said: so many a second; the rest is only counted.
    pub(crate) fn note_of_vehicle(&mut self, now: Timestamp, note: Note) {
        if self.vehicle_lines.take(now) {
            self.note(note);
        }
    }

    /// How many lines about the vehicle were only counted since the last call.
    pub(crate) fn take_dropped(&mut self) -> u64 {
        self.vehicle_lines.take_dropped()
    }
}

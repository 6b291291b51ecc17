use std::collections::VecDeque;

use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};

/// The dive that the vehicle says it flies (SPI 6.9, 6.11).
///
/// BFMIS and BFMBS may write the name of one file in two ways, so each name is compared with those from the same
/// message. If one message names another file, the other message will too, in its own way. An empty name says nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dive {
    of_status: Option<Vec<u8>>,
    of_behavior: Option<Vec<u8>>,
    /// When the vehicle named another dive, if it has not reported the plan of that dive since.
    unplanned: Option<Moment>,
    /// Our requests for the plan: the time in the BPRMP, and when it left; oldest first.
    asked: VecDeque<(TimeOfDay, Moment)>,
}

impl Dive {
    const ASKED_MAX: usize = 32;

    /// BFMIS names the dive file.
    pub(crate) fn named_by_status(&mut self, at: Moment, name: &[u8]) {
        if is_another(&mut self.of_status, name) {
            self.of_behavior = None;
            self.unplanned = Some(at);
        }
    }

    /// BFMBS names the dive file.
    pub(crate) fn named_by_behavior(&mut self, at: Moment, name: &[u8]) {
        if is_another(&mut self.of_behavior, name) {
            self.of_status = None;
            self.unplanned = Some(at);
        }
    }

    /// We asked for the plan.
    pub(crate) fn asked(&mut self, at: Moment, created: TimeOfDay) {
        if self.asked.len() == Self::ASKED_MAX {
            self.asked.pop_front();
        }
        self.asked.push_back((created, at));
    }

    /// The vehicle reported a plan to its end, as the answer to one of our requests. If we asked before the vehicle
    /// named the dive, the plan may be that of the dive before.
    pub(crate) fn planned(&mut self, echo: Echo) {
        let answered = |(created, _): &&(TimeOfDay, Moment)| echo.echoes(*created);
        let asked = self.asked.iter().rev().find(answered).map(|(_, at)| *at);
        self.unplanned = self.unplanned.filter(|named| asked.is_some_and(|asked| asked < *named));
    }

    /// Whether the vehicle has named a dive.
    pub(crate) const fn is_named(&self) -> bool {
        self.of_status.is_some() || self.of_behavior.is_some()
    }

    /// When the vehicle named another dive, if it has not reported the plan of that dive since.
    pub(crate) const fn unplanned(&self) -> Option<Moment> {
        self.unplanned
    }

    /// The record has a gap.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Whether a name differs from the known one, which it replaces. The first name differs from none.
fn is_another(known: &mut Option<Vec<u8>>, name: &[u8]) -> bool {
    let name = name.trim_ascii();
    if name.is_empty() || known.as_deref() == Some(name) {
        return false;
    }
    known.replace(name.to_vec()).is_some()
}

//! Which dive the vehicle flies. A plan belongs to the dive file for which the vehicle reported it (SPI 6.9, 6.11;
//! safety requirement 025).

use crate::control::{ClockSet, Newest};
use crate::refusal::Uncontrolled;
use backseat_spi::Text;
use backseat_units::{TimeOfDay, Timestamp};

/// The dive file as the vehicle last named it.
///
/// BFMIS and BFMBS may name one file in two ways (with its folder, without its ending), so each name is compared only
/// with names from the same kind of message. If the two tell a change of dive one after the other, each counts as a change: the
/// second may be the first word of yet another dive. An empty name says nothing: the vehicle leaves the name out if a behavior
/// is the payload's, and while no mission is loaded.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Dive {
    of_status: Option<Text>,
    of_behavior: Option<Text>,
    /// A kind of message has named another file at least once.
    has_changed: bool,
    /// The newest message that has named another file. What was made before it belongs to the dive before.
    changed: Newest,
    /// The file is another one now, and its plan is not complete yet.
    plan_due: bool,
}

/// Which message has named a dive file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum NamedBy {
    /// BFMIS.
    Status,
    /// BFMBS.
    Behavior,
}

impl Dive {
    /// The file is another one now: nothing steers until its plan is complete.
    pub(crate) const fn is_another(&mut self) {
        self.plan_due = true;
    }

    /// The vehicle's plan has come and is complete.
    pub(crate) const fn planned(&mut self) {
        self.plan_due = false;
    }

    /// Why we have no control after a change of the dive file.
    pub(crate) fn reason(&self) -> Option<Uncontrolled> {
        self.plan_due.then_some(Uncontrolled::DivePlanUnknown)
    }

    /// A message that was made at this time has named another file.
    pub(crate) fn changed_by(&mut self, now: Timestamp, created: TimeOfDay) {
        self.changed.hear(now, created);
    }

    /// The connection is new: it has brought no message about a dive yet.
    pub(crate) fn connected(&mut self) {
        self.changed = Newest::default();
    }

    /// The vehicle's clock was set.
    pub(crate) fn clock_set(&mut self, set: ClockSet) {
        self.changed.clock_set(set);
    }

    /// Whether a BFMBS or BFMBE that comes now, and names this file, is late and belongs to the dive before: it was made before
    /// the message that named another file, and does not name another file itself.
    pub(crate) fn is_before(&self, now: Timestamp, created: TimeOfDay, file: &Text) -> bool {
        let known = self.of_behavior.as_ref().map_or("", |known| known.as_str().trim());
        let file = file.as_str().trim();
        self.changed.is_after(now, created) && (file.is_empty() || known.is_empty() || file == known)
    }

    /// Whether a BFMIS that comes now was made before another message named another file.
    pub(crate) fn has_since_changed(&self, now: Timestamp, created: TimeOfDay) -> bool {
        self.changed.is_after(now, created)
    }

    /// The vehicle has named its dive file. Returns true if it may be another one than the one whose plan core has or has
    /// asked for: it differs from the last one that this kind of message named.
    pub(crate) fn named(&mut self, by: NamedBy, file: &Text) -> bool {
        if file.as_str().trim().is_empty() {
            return false;
        }
        let known = match by {
            NamedBy::Status => &mut self.of_status,
            NamedBy::Behavior => &mut self.of_behavior,
        };
        let differs = match known.replace(file.clone()) {
            Some(known) => known.as_str().trim() != file.as_str().trim(),
            // There is nothing to compare the first name with. It belongs to the first file, unless there has been
            // another one since.
            None => self.has_changed,
        };
        self.has_changed |= differs;
        differs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(dive: &mut Dive, by: NamedBy, file: &str) -> bool {
        dive.named(by, &Text::cleaned(file))
    }

    #[test]
    fn sr_025_dive_files_are_compared_by_kind_of_message_and_an_empty_name_does_not_count() {
        use NamedBy::{Behavior, Status};
        let mut dive = Dive::default();
        assert!(!named(&mut dive, Status, "dives/a.dive"));
        assert!(!named(&mut dive, Behavior, "a"));
        assert!(!named(&mut dive, Behavior, ""));
        assert!(!named(&mut dive, Status, " "));
        assert!(!named(&mut dive, Behavior, "a "));
        assert!(named(&mut dive, Behavior, "b"));
        assert!(!named(&mut dive, Behavior, "b") && !named(&mut dive, Status, "dives/a.dive"));
        // It may be the same file in other words, or the first word of a third one.
        assert!(named(&mut dive, Status, "dives/b.dive"));
        assert!(named(&mut dive, Status, "dives/c.dive"));
        assert!(named(&mut dive, Behavior, "a"));
    }

    #[test]
    fn sr_025_a_first_name_after_a_change_may_be_another_dive() {
        use NamedBy::{Behavior, Status};
        let mut dive = Dive::default();
        assert!(!named(&mut dive, Behavior, "a") && named(&mut dive, Behavior, "b"));
        assert!(named(&mut dive, Status, "dives/c.dive"));
        assert!(named(&mut dive, Behavior, "c") && !named(&mut dive, Behavior, "c"));
    }
}

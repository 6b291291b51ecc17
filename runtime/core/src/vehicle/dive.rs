//! Which dive the vehicle flies. A plan belongs to the dive file for which the vehicle reported it (SPI 6.9, 6.11;
//! safety requirement 025).

use crate::refusal::Uncontrolled;
use backseat_spi::Text;

/// The dive file as the vehicle last named it.
///
/// BFMIS and BFMBS may name one file in two ways (with its folder, without its ending), so each name is compared only
/// with names from the same kind of message. An empty name says nothing: the vehicle leaves the name out if a behavior
/// is the payload's, and while no mission is loaded.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Dive {
    of_status: Option<Text>,
    of_behavior: Option<Text>,
    /// The file is another one now, and its plan is not complete yet.
    plan_due: bool,
}

/// Which message has named a dive file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

    /// The vehicle has named its dive file. Returns true if it differs from the last one that this kind of message
    /// named.
    pub(crate) fn named(&mut self, by: NamedBy, file: &Text) -> bool {
        if file.as_str().trim().is_empty() {
            return false;
        }
        let (known, other) = match by {
            NamedBy::Status => (&mut self.of_status, &mut self.of_behavior),
            NamedBy::Behavior => (&mut self.of_behavior, &mut self.of_status),
        };
        let known = known.replace(file.clone());
        let another = known.is_some_and(|known| known.as_str().trim() != file.as_str().trim());
        if another {
            // The other kind of message will name the new file too, in its own way.
            *other = None;
        }
        another
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
        assert!(
            !named(&mut dive, Status, "dives/b.dive"),
            "the same file, named differently"
        );
        assert!(named(&mut dive, Status, "dives/c.dive"));
        assert!(!named(&mut dive, Behavior, "c"));
        assert!(named(&mut dive, Behavior, "a"));
    }
}

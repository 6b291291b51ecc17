//! Which dive the vehicle flies: a plan belongs to the file that it was told for (SPI 6.9, 6.11; safety requirement 025).

use backseat_spi::Text;

use crate::context::Context;
use crate::expected::Compared;
use crate::io::Note;
use crate::machine::Core;
use crate::switches::{Check, is_on};

/// The dive file as the vehicle last named it.
///
/// BFMIS and BFMBS may write one file in two ways (with its folder, without its ending), so that each is held against its
/// own kind alone. An empty name says nothing: it is left out where a behaviour is the payload's, and while no mission is
/// loaded.
#[derive(Debug, Default)]
pub(crate) struct Dive {
    of_status: Option<Text>,
    of_behavior: Option<Text>,
    /// It is another one, and its plan is not whole yet.
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
    /// The vehicle has named its dive file. True where it is another one than the last that this kind of message named.
    fn named(&mut self, by: NamedBy, file: &Text) -> bool {
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
            // The other kind will name it too, in its own way.
            *other = None;
        }
        another
    }
}

impl Core {
    /// Where the vehicle names another dive file, the plan is forgotten and asked for, and nothing steers until it is
    /// whole.
    pub(crate) fn dive_named(&mut self, by: NamedBy, file: &Text) {
        if !self.cx.vehicle.dive.named(by, file) || !is_on(Check::DiveIdentity) {
            return;
        }
        self.cx.note_of_vehicle(Note::Text {
            text: format!("another dive: {}", file.as_str().trim()),
        });
        self.capabilities
            .end_leases(&mut self.cx, "the vehicle flies another dive");
        self.cx.vehicle.plan.forget();
        self.cx.vehicle.compared = Compared::default();
        self.cx.link.commands.forget_plan();
        self.cx.vehicle.courses.lose();
        self.cx.vehicle.dive.plan_due = true;
        self.session.want_plan(&mut self.cx);
        self.settle_control();
    }
}

impl Context {
    /// Why another dive leaves us without control.
    pub(crate) fn unplanned_dive(&self) -> Option<&'static str> {
        self.vehicle
            .dive
            .plan_due
            .then_some("the plan of this dive is not known yet")
    }

    /// The vehicle's plan has come whole.
    pub(crate) fn dive_planned(&mut self) {
        self.vehicle.dive.plan_due = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(dive: &mut Dive, by: NamedBy, file: &str) -> bool {
        dive.named(by, &Text::cleaned(file))
    }

    #[test]
    fn sr_025_each_message_is_held_against_its_own_kind_and_an_empty_name_says_nothing() {
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
            "it is the same, named in its own way"
        );
        assert!(named(&mut dive, Status, "dives/c.dive"));
        assert!(!named(&mut dive, Behavior, "c"));
        assert!(named(&mut dive, Behavior, "a"));
    }
}

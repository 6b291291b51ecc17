//! Navigation (SPI 6.1, 6.2), and what follows from it.

use std::time::Duration;

use backseat_spi::{Navigation, VelocityAndRates};

use super::{Core, course};
use crate::ended::EndCause;
use crate::io::Note;
use crate::vehicle::integrity::Flaw;
use crate::vehicle::navigation::Change;

/// How often a flaw of navigation is reported while it lasts.
const FLAW_TOLD_EVERY: Duration = Duration::from_secs(10);

impl Core {
    pub(super) fn navigated(&mut self, message: &Navigation) {
        let utc = self.cx.utc();
        let Some(change) = self.cx.vehicle.navigation.position(self.cx.now, utc, message) else {
            return;
        };
        self.session.heard_navigation(&mut self.cx);
        self.capabilities.sonar.navigated(&mut self.cx);
        self.capabilities.inserts.watch_schedules(&mut self.cx);
        let jump = match change {
            Change::Follows => None,
            Change::Jumped(jump) => Some(jump),
        };
        if let Some(jump) = jump {
            // Safety requirement 021: the vehicle's position cannot be trusted for a while.
            self.cx.note_of_vehicle(Note::Navigation {
                text: format!("navigation jumped by {:.1} m", jump.metres),
            });
            self.capabilities.modify.end(&mut self.cx, EndCause::NavigationJumped);
        }
        self.end_leases_on_flaw();
        course::navigated(&mut self.cx, jump);
        self.unjudged = true;
        self.whereabouts
            .watch_place(&mut self.cx, &mut self.capabilities, &mut self.orders);
    }

    /// Safety requirement 024: navigation that cannot be true ends every lease.
    fn end_leases_on_flaw(&mut self) {
        let Some(Flaw { what, text }) = self.cx.vehicle.navigation.take_flaw() else {
            return;
        };
        if self
            .flaw_told
            .is_none_or(|(told, at)| told != what || self.cx.now.since(at) >= FLAW_TOLD_EVERY)
        {
            self.flaw_told = Some((what, self.cx.now));
            self.cx.note_of_vehicle(Note::Navigation {
                text: format!("{}: {text}", what.text()),
            });
            // The vehicle may not have the subscription: an acknowledgement of BPLOG does not say which one it answers.
            if what == EndCause::VelocitiesMissing {
                self.session.subscribe_anew(&mut self.cx, "NVR");
            }
        }
        self.capabilities.end_leases(&mut self.cx, what);
        self.capabilities.inserts.judge_waiting(&mut self.cx);
    }

    pub(super) fn velocity(&mut self, message: &VelocityAndRates) {
        self.unjudged = true;
        let completes = self.cx.vehicle.navigation.velocity(self.cx.now, message);
        self.end_leases_on_flaw();
        if completes {
            self.capabilities.sonar.velocity(&mut self.cx, message);
            self.follow_navigation();
            // This navigation may have given us control, and the plugins need to know that before they are stepped.
            self.settle_control();
            self.step_due(true);
        }
    }

    /// Judges the modify and the station keeping by the newest navigation: once for each BFNVG with its BFNVR, or, at
    /// the end of an input, by what has come of the two.
    pub(super) fn follow_navigation(&mut self) {
        if core::mem::take(&mut self.unjudged) {
            course::watch(&mut self.cx);
            self.capabilities.modify.prevent(&mut self.cx);
            self.capabilities.station.prevent(&mut self.cx);
        }
    }
}

//! What new relative navigation means for station keeping.

use backseat_spi::{CartesianNavigation, RelativeNavigation};

use super::Station;
use crate::context::Context;
use crate::ended::{EndCause, Ended};
use crate::io::Note;
use crate::plugin::{CartesianSample, RelativeSample};
use crate::timer::Timer;

impl Station {
    /// BFRNV.
    pub(crate) fn heard_relative(&mut self, cx: &mut Context, message: &RelativeNavigation) {
        cx.heard(message.created);
        if !cx.vehicle.relative.advances(message.created, message.solution) {
            return;
        }
        let sample = RelativeSample {
            measured: cx.when(message.solution),
            horizontal_m: message.horizontal_m,
            vertical_m: message.vertical_m,
            distance_m: message.distance_m,
            heading_deg: message.heading_deg,
            depth_m: message.depth_m,
            absolute_heading_deg: message.absolute_heading_deg,
            roll_deg: message.roll_deg,
            pitch_deg: message.pitch_deg,
        };
        let jumped = cx.vehicle.relative.take(cx.now, sample, message.solution);
        self.relative_came(cx, "BFRNV", jumped);
    }

    /// BFCNV. It does not carry the time of its solution, so core cannot notice a solution that stands still while the
    /// messages go on.
    pub(crate) fn heard_cartesian(&mut self, cx: &mut Context, message: &CartesianNavigation) {
        cx.heard(message.created);
        if !cx.vehicle.cartesian.advances(message.created, message.created) {
            return;
        }
        let sample = CartesianSample {
            measured: cx.when(message.created),
            x_m: message.x_m,
            y_m: message.y_m,
            z_m: message.z_m,
            heading_deg: message.heading_deg,
        };
        let jumped = cx.vehicle.cartesian.take(cx.now, sample, message.created);
        self.relative_came(cx, "BFCNV", jumped);
    }

    fn relative_came(&mut self, cx: &mut Context, message: &str, jumped_m: Option<f64>) {
        if let Some(metres) = jumped_m {
            // Safety requirement 021: the vehicle's place cannot be trusted for a while.
            let text = format!("{message} jumped by {metres:.1} m");
            self.end(
                cx,
                Ended::Said(EndCause::NavigationJumped, format!("{message} by {metres:.1} m")),
            );
            cx.note(Note::Navigation { text });
        }
        self.watch_return(cx);
        self.prevent(cx);
        self.watch_relative(cx);
    }

    /// Sets the timer for when relative navigation becomes stale under station keeping.
    pub(super) fn watch_relative(&mut self, cx: &mut Context) {
        let stale_at = [cx.vehicle.relative.stale_at(), cx.vehicle.cartesian.stale_at()];
        let next = stale_at.into_iter().flatten().filter(|at| *at > cx.now).min();
        let next = next.filter(|_| self.keeping.is_some());
        cx.timers.set_or_stop(Timer::Relative, next);
    }

    /// Relative navigation has become stale. Station keeping goes on if it does not need it.
    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        if self.prevent(cx) {
            self.watch_relative(cx);
        }
    }
}

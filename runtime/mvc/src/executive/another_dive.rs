use backseat_spi::Text;

use super::mission::Mission;
use crate::context::Context;
use crate::event::Status;
use crate::plan::{PlanItem, Shape};

impl Mission {
    /// Changes to another dive, as if somebody had started it on the vehicle's main computer. Everything of the old
    /// dive ends under its old name. Then BFMIS names the new dive, and its plan begins. The mission's status does not
    /// change (SPI 6.11).
    ///
    /// If `reversed` is false, the plan stays the same: only the name changes, and the vehicle flies on. An empty
    /// mission, and one that is over, keep their name.
    pub(crate) fn change_dive(&mut self, ctx: &mut Context<'_>, file: Text, reversed: bool) {
        let goes = match self.executive.status() {
            Status::Ready | Status::Running => !self.executive.is_empty_mission(),
            Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::WrappingUp
            | Status::Aborting
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => false,
        };
        if !goes {
            return;
        }
        if reversed {
            self.executive.end_dive();
            self.settle(ctx);
        }
        self.dive_file = file;
        self.executive.tell_status();
        if reversed {
            let plan = backwards(self.executive.plan());
            self.executive.begin_dive(plan, ctx.now, ctx.estimate.at);
        }
        self.settle(ctx);
    }
}

/// A plan in reverse order, with new numbers.
fn backwards(plan: &[PlanItem]) -> Vec<PlanItem> {
    let elements = plan.last().map_or(0, |item| item.element);
    let numbered = (1..).zip(plan.iter().rev());
    let turned = numbered.map(|(number, item)| PlanItem {
        number,
        element: elements + 1 - item.element,
        shape: match item.shape {
            Shape::Trackline { start, end } => Shape::Trackline { start: end, end: start },
            Shape::Waypoint { .. }
            | Shape::GpsHit { .. }
            | Shape::Trackcircle { .. }
            | Shape::Setpoint { .. }
            | Shape::Command
            | Shape::Idle => item.shape,
        },
        ..item.clone()
    });
    turned.collect()
}

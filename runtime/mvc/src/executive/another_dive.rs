use backseat_spi::Text;

use super::mission::Mission;
use crate::context::Context;
use crate::event::Status;
use crate::plan::{PlanItem, Shape};

impl Mission {
    /// The vehicle flies another dive, as where somebody on its main computer has begun one: what was of the old one ends
    /// under its name, BFMIS names the new one, and its plan begins. The mission's status stays what it was (SPI 6.11).
    ///
    /// Where the plan is the same it is only called otherwise, and what is flown goes on. A mission that is over stays as
    /// it was called.
    pub(crate) fn change_dive(&mut self, ctx: &mut Context<'_>, file: Text, reversed: bool) {
        let goes = match self.executive.status() {
            Status::Ready | Status::Running => !self.executive.is_empty_mission(),
            Status::WrappingUp | Status::Aborting | Status::Completed | Status::Aborted | Status::Stopped => false,
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

/// A plan from its end to its begin, numbered anew.
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

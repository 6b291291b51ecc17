use backseat_spi::{BehaviorId, PlanElement, PlanElementKind};
use backseat_units::EastNorth;
use backseat_units::math::TAU;

use super::Executive;
use super::mission::Mission;
use crate::context::Context;
use crate::event::ClientId;
use crate::plan::Shape;

/// Points for each turn of a reported circle. The chords stay within 0.9 % of the radius.
const POINTS_PER_ORBIT: f64 = 24.0;
/// The greatest number of points for a circle. More would only repeat the same circle.
const POINTS_MAX: f64 = 240.0;

impl Mission {
    /// Sends the whole plan as BFPLN messages (SPI 6.20), with the inserts at their place in it. Returns the number of
    /// messages.
    pub(super) fn send_plan(&self, ctx: &mut Context<'_>, client: ClientId) -> u32 {
        let created = ctx.stamp();
        let mut count = 0;
        for point in self.executive.points(ctx.estimate.at) {
            let message = PlanElement {
                created,
                number: point.number,
                identifier: point.identifier,
                index: point.index,
                element: point.element,
                position: ctx.frame().to_position(point.at),
            };
            ctx.server.send(ctx.now, client, &message.into());
            count += 1;
        }
        count
    }
}

impl Executive {
    /// The points of the plan and of the inserts in it, for a vehicle at the place `at`.
    pub(super) fn points(&self, at: EastNorth) -> Vec<Point> {
        let lead_in_m = self.interpretation.lead_in_m;
        let (plan, inserts_after) = (self.plan(), self.inserts_after());
        let mut teller = Teller { at, points: Vec::new() };
        let (before, after) = plan.split_at(inserts_after.min(plan.len()));
        for item in before {
            let shape = item.shape.with_leads(item.lead_m);
            teller.tell(Some(item.number), None, &shape, item.speed_mps);
        }
        for insert in self.inserts() {
            let shape = insert.shape.with_leads(lead_in_m);
            teller.tell(None, Some(insert.id), &shape, insert.speed_mps);
        }
        for item in after {
            let shape = item.shape.with_leads(item.lead_m);
            teller.tell(Some(item.number), None, &shape, item.speed_mps);
        }
        teller.points
    }
}

/// A point of a plan, as BFPLN reports it.
pub(super) struct Point {
    pub(super) number: Option<u32>,
    identifier: Option<BehaviorId>,
    index: u32,
    element: PlanElementKind,
    pub(super) at: EastNorth,
}

struct Teller {
    /// Where the plan has led so far, for a setpoint that starts there.
    at: EastNorth,
    points: Vec<Point>,
}

impl Teller {
    fn tell(&mut self, number: Option<u32>, identifier: Option<BehaviorId>, shape: &Shape, speed_mps: f64) {
        let mut index = 0;
        let mut point = |element, at| {
            self.points.push(Point {
                number,
                identifier,
                index,
                element,
                at,
            });
            index += 1;
            at
        };
        self.at = match *shape {
            Shape::Waypoint { to } | Shape::GpsHit { at: to, .. } => point(PlanElementKind::Waypoint, to),
            // These do not move the vehicle.
            Shape::Command | Shape::Idle => self.at,
            Shape::Trackline { start, end } => {
                point(PlanElementKind::TracklineStart, start);
                point(PlanElementKind::TracklineEnd, end)
            }
            // A heading for a time has no place of its own. The point is where dead reckoning ends.
            Shape::Setpoint { heading_deg, duration } => point(
                PlanElementKind::Waypoint,
                self.at.offset(heading_deg, speed_mps * duration.as_secs_f64()),
            ),
            Shape::Trackcircle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => {
                let entry_deg = entry_deg.unwrap_or_else(|| centre.bearing_deg(self.at));
                let steps = (orbits.abs() * POINTS_PER_ORBIT).ceil().clamp(1.0, POINTS_MAX);
                // For a circle with more points than that, whole turns are left out, so the points still end where the
                // circle ends.
                let turns = orbits
                    .abs()
                    .min(POINTS_MAX / POINTS_PER_ORBIT - 1.0 + orbits.abs().fract());
                let mut last = centre;
                for step in 0..=steps as u32 {
                    let angle_rad = TAU * turns * orbits.signum() * f64::from(step) / steps;
                    let at = centre.offset(entry_deg + angle_rad.to_degrees(), radius_m);
                    last = point(PlanElementKind::Trackcircle, at);
                }
                last
            }
        };
    }
}

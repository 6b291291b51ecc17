use backseat_spi::{BehaviorId, PlanElement, PlanElementKind};
use backseat_units::math::TAU;
use backseat_units::{EastNorth, Position, Timestamp};

use crate::event::ClientId;
use crate::mvc::Mvc;
use crate::plan::Shape;

/// A circle is told as this many points a turn: chords stay within 0.9 % of the radius.
const POINTS_PER_ORBIT: f64 = 24.0;
/// More points would only tell the same circle again.
const POINTS_MAX: f64 = 240.0;

impl Mvc {
    /// The whole plan as BFPLN messages (SPI 6.20), the inserts at their place in it. How many messages.
    pub(crate) fn send_plan(&mut self, now: Timestamp, client: ClientId) -> u32 {
        let created = self.stamp(now);
        let mut count = 0;
        for point in self.points() {
            let position = self.frame().to_position(point.at);
            let (number, identifier, index, element) = (point.number, point.identifier, point.index, point.element);
            self.send(
                now,
                client,
                PlanElement {
                    created,
                    number,
                    identifier,
                    index,
                    element,
                    position,
                }
                .into(),
            );
            count += 1;
        }
        count
    }

    /// The points of the front seat's plan and of the inserts in it, with the numbers of the planned elements.
    #[must_use]
    pub fn plan_points(&self) -> Vec<(Option<u32>, Position)> {
        self.points()
            .into_iter()
            .map(|point| (point.number, self.frame().to_position(point.at)))
            .collect()
    }

    fn points(&self) -> Vec<Point> {
        let lead_in_m = self.interpretation.lead_in_m;
        let (plan, inserts_after) = (self.executive.plan(), self.executive.inserts_after());
        let mut teller = Teller {
            at: self.sensors.estimate(&self.vehicle).at,
            points: Vec::new(),
        };
        let (before, after) = plan.split_at(inserts_after.min(plan.len()));
        for item in before {
            teller.tell(
                Some(item.number),
                None,
                &item.shape.with_leads(item.lead_m),
                item.speed_mps,
            );
        }
        for insert in self.executive.inserts() {
            teller.tell(
                None,
                Some(insert.id),
                &insert.shape.with_leads(lead_in_m),
                insert.speed_mps,
            );
        }
        for item in after {
            teller.tell(
                Some(item.number),
                None,
                &item.shape.with_leads(item.lead_m),
                item.speed_mps,
            );
        }
        teller.points
    }
}

struct Point {
    number: Option<u32>,
    identifier: Option<BehaviorId>,
    index: u32,
    element: PlanElementKind,
    at: EastNorth,
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
            // It leads nowhere.
            Shape::Command | Shape::Idle => self.at,
            Shape::Trackline { start, end } => {
                point(PlanElementKind::TracklineStart, start);
                point(PlanElementKind::TracklineEnd, end)
            }
            // A heading for a time has no place of its own: where dead reckoning ends.
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
                // Past the most points the last turns repeat the first ones, and end where the circle ends.
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

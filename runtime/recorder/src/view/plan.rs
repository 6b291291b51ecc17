use backseat_spi::{BehaviorId, FromVehicle, PlanElement, PlanElementKind, ToVehicle};
use backseat_units::Position;
use serde_json::json;

use super::geometry::{Shape, write_features};
use super::link::name;
use super::{Batch, Topic};

/// A plan with more points than this is not kept; core does not believe one either.
const POINTS_MAX: usize = 10_000;

/// `/map/plan`: the vehicle's plan, whenever core has heard all of it and it differs from the last.
#[derive(Default)]
pub(super) struct Plan {
    /// The series that is coming; `None` while none was asked for.
    coming: Option<Vec<Element>>,
    points: usize,
    /// The first message of the series. If it comes again, both answers to two questions come.
    first: Option<Key>,
    told: Vec<Element>,
}

type Key = (Option<u32>, Option<BehaviorId>, u32);

#[derive(Debug, PartialEq)]
struct Element {
    number: Option<u32>,
    identifier: Option<BehaviorId>,
    kind: PlanElementKind,
    points: Vec<Position>,
}

impl Plan {
    pub(super) fn wants(&self, line: &[u8]) -> bool {
        self.coming.is_some() && name(line) == b"BFPLN"
    }

    pub(super) fn wants_sent(line: &[u8]) -> bool {
        name(line) == b"BPRMP"
    }

    pub(super) fn link_began(&mut self) {
        self.coming = None;
    }

    pub(super) fn sent(&mut self, message: &ToVehicle) {
        if matches!(message, ToVehicle::RequestPlan(_)) {
            self.coming = Some(Vec::new());
            self.points = 0;
            self.first = None;
        }
    }

    pub(super) fn heard(&mut self, message: &FromVehicle) {
        let (Some(elements), FromVehicle::PlanElement(point)) = (&mut self.coming, message) else {
            return;
        };
        let key = (point.number, point.identifier, point.index);
        let is_named = point.number.is_some() || point.identifier.is_some();
        if *self.first.get_or_insert(key) == key && is_named {
            elements.clear();
            self.points = 0;
        }
        match elements.last_mut() {
            Some(last) if last.number == point.number && last.identifier == point.identifier => {
                last.points.push(point.position);
            }
            _ => elements.push(Element::beginning_with(point)),
        }
        self.points += 1;
        if self.points > POINTS_MAX {
            self.coming = None;
        }
    }

    /// Core has heard the whole plan.
    pub(super) fn complete(&mut self, batch: &mut Batch) {
        let Some(elements) = self.coming.take().filter(|elements| *elements != self.told) else {
            return;
        };
        let features = elements.iter().map(Element::feature).collect();
        write_features(Topic::Plan, features, batch);
        self.told = elements;
    }
}

impl Element {
    fn beginning_with(point: &PlanElement) -> Self {
        Self {
            number: point.number,
            identifier: point.identifier,
            kind: point.element,
            points: vec![point.position],
        }
    }

    fn feature(&self) -> serde_json::Value {
        let kind = match self.kind {
            PlanElementKind::Waypoint => "waypoint",
            PlanElementKind::TracklineStart | PlanElementKind::TracklineEnd => "trackline",
            PlanElementKind::Trackcircle => "trackcircle",
            PlanElementKind::Other(_) => "other",
        };
        let mut properties = json!({"kind": kind});
        if let Some(number) = self.number {
            properties["number"] = number.into();
        }
        if let Some(identifier) = self.identifier {
            properties["identifier"] = identifier.get().into();
        }
        let shape = match self.points[..] {
            [only] => Shape::Point(only),
            _ => Shape::Line(self.points.clone()),
        };
        shape.feature("#9467bd", properties)
    }
}

use crate::earth::{Line, Position, wrap_180};
use crate::error::OracleError;
use crate::geojson;
use crate::plane::{Plane, Point, Vector, to_segment_m};
use crate::wire::Setpoint;
use crate::zone::{Kind, Shape, Zone};

/// Legs are judged in pieces of this length, metres: the plane of a piece is exact to millimetres.
const PIECE_M: f64 = 250.0;
/// The longest leg, metres. A longer one is outside every fence.
const LEG_MAX_M: f64 = 100_000.0;

/// The fence: the area in which the vehicle may be.
#[derive(Clone, Debug)]
pub(crate) struct Area {
    reference_deg: f64,
    zones: Vec<Zone>,
}

/// How a request breaks the fence.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Fault {
    Horizontal(String),
    Vertical(String),
}

/// What surrounds a point.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    /// The zones that contain the point.
    pub(crate) zones: Vec<usize>,
    /// The distance from the point to the nearest edge of any zone, metres.
    pub(crate) edge_m: f64,
}

impl Area {
    pub(crate) fn read(geojson: &str) -> Result<Self, OracleError> {
        let (reference_deg, zones) = geojson::read(geojson)?;
        Ok(Self { reference_deg, zones })
    }

    pub(crate) fn zone(&self, index: usize) -> Option<&Zone> {
        self.zones.get(index)
    }

    pub(crate) fn point(&self, position: Position) -> Point {
        Point {
            x: wrap_180(position.longitude_deg - self.reference_deg),
            y: position.latitude_deg,
        }
    }

    /// Writes what surrounds a point into `surroundings`, to avoid an allocation.
    pub(crate) fn survey(&self, point: Point, surroundings: &mut Surroundings) {
        surroundings.zones.clear();
        let mut nearest_m = f64::INFINITY;
        let plane = Plane::at(point);
        for (index, zone) in self.zones.iter().enumerate() {
            if zone.contains(point) {
                surroundings.zones.push(index);
            }
            for edge in zone.edges() {
                nearest_m = nearest_m.min(to_segment_m([0.0, 0.0], edge.map(|end| plane.vector(end))));
            }
        }
        surroundings.edge_m = nearest_m;
    }

    /// How much room a place has, metres: to the nearest border that must not be crossed, and down to the greatest depth
    /// that is allowed there. Both are negative on the wrong side, and infinite where nothing bounds them.
    ///
    /// Of the keep-in zones, the one with the most room counts; keep-out zones count if they hold at this depth at all
    /// times. The distance is infinite if it is not asked for.
    pub(crate) fn room(&self, point: Point, depth_m: f64, distance: bool) -> (f64, f64) {
        let plane = Plane::at(point);
        let edge_m = |zone: &Zone| {
            let to_edge_m = |edge: [Point; 2]| to_segment_m([0.0, 0.0], edge.map(|end| plane.vector(end)));
            zone.edges().map(to_edge_m).fold(f64::INFINITY, f64::min)
        };
        let (mut kept_m, mut clear_m, mut depth_room_m) = (f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY);
        for zone in &self.zones {
            let inside = zone.contains(point);
            let signed_m = |sign: f64| if distance { sign * edge_m(zone) } else { f64::INFINITY };
            match zone.kind {
                Kind::KeepIn => {
                    kept_m = kept_m.max(signed_m(if inside { 1.0 } else { -1.0 }));
                    if inside {
                        depth_room_m = depth_room_m.max(zone.depth_max_m - depth_m);
                    }
                }
                Kind::KeepOut if !zone.timed && (zone.depth_min_m..=zone.depth_max_m).contains(&depth_m) => {
                    clear_m = clear_m.min(signed_m(if inside { -1.0 } else { 1.0 }));
                }
                Kind::KeepOut => {}
            }
        }
        (kept_m.min(clear_m), depth_room_m)
    }

    /// The widest margin of any zone, metres.
    pub(crate) fn margin_max_m(&self) -> f64 {
        self.zones.iter().fold(0.0, |most, zone| zone.margin_m.max(most))
    }

    /// The zone in whose margin a place of the plane is by more than a slack; `None` if the place keeps all margins.
    /// The zone is a keep-out zone that holds at all of the depths, or, if the place is in the margin of every keep-in
    /// zone or outside it, the last keep-in zone.
    pub(crate) fn margin_broken(&self, plane: &Plane, place: Vector, depths_m: &[f64], slack_m: f64) -> Option<&Zone> {
        let mut nearest = None;
        let mut kept = false;
        for zone in &self.zones {
            let within_m = zone.margin_m - slack_m;
            match zone.kind {
                Kind::KeepIn if !kept => {
                    kept = zone.is_inside_by(plane, place, within_m);
                    nearest = Some(zone);
                }
                Kind::KeepOut if zone.surely_holds(depths_m) && zone.is_inside_by(plane, place, -within_m) => {
                    return Some(zone);
                }
                Kind::KeepIn | Kind::KeepOut => {}
            }
        }
        nearest.filter(|_| !kept)
    }

    /// Writes the zones that contain a point into `zones`, to avoid an allocation.
    pub(crate) fn holding(&self, point: Point, zones: &mut Vec<usize>) {
        zones.clear();
        zones.extend((0..self.zones.len()).filter(|index| self.zones[*index].contains(point)));
    }

    /// Judges whether a straight leg with its setpoint stays inside one keep-in zone and clear of keep-out zones.
    pub(crate) fn judge_leg(&self, from: Position, to: Position, setpoint: Setpoint) -> Result<(), Fault> {
        let line = Line::between(from, to);
        let length_m = line.length_m();
        if !length_m.is_finite() || length_m > LEG_MAX_M {
            return Err(Fault::Horizontal(format!("a leg of {length_m:.0} m")));
        }
        let count = (length_m / PIECE_M).ceil().max(1.0);
        let at = |index: f64| self.point(line.at(index / count));
        let mut pieces = Vec::with_capacity(count as usize);
        let mut start = at(0.0);
        for index in 1..=count as usize {
            let end = at(index as f64);
            let plane = Plane::at(Point {
                x: (start.x + end.x) / 2.0,
                y: (start.y + end.y) / 2.0,
            });
            pieces.push((plane, [plane.vector(start), plane.vector(end)]));
            start = end;
        }
        self.judge(&Shape::Leg(&pieces), setpoint)
    }

    /// Judges whether a circle's rim with its setpoint stays inside one keep-in zone and clear of keep-out zones.
    pub(crate) fn judge_circle(&self, centre: Position, radius_m: f64, setpoint: Setpoint) -> Result<(), Fault> {
        if !(0.0..=LEG_MAX_M).contains(&radius_m) {
            return Err(Fault::Horizontal(format!("a circle of radius {radius_m:.0} m")));
        }
        let plane = Plane::at(self.point(centre));
        self.judge(&Shape::Rim { plane, radius_m }, setpoint)
    }

    /// Whether a zone that allows surfacing contains a position.
    pub(crate) fn may_surface(&self, position: Position) -> bool {
        let point = self.point(position);
        let surfacing = |zone: &&Zone| zone.kind == Kind::KeepIn && zone.surfacing;
        self.zones.iter().filter(surfacing).any(|zone| zone.contains(point))
    }

    /// Judges whether a setpoint is within the bands of any keep-in zone.
    pub(crate) fn judge_setpoint(&self, setpoint: Setpoint) -> Result<(), Fault> {
        let mut keep_ins = self.zones.iter().filter(|zone| zone.kind == Kind::KeepIn);
        if keep_ins.any(|zone| zone.allows(setpoint)) {
            return Ok(());
        }
        Err(Fault::Vertical(format!("no keep-in zone allows {setpoint}")))
    }

    fn judge(&self, shape: &Shape<'_>, setpoint: Setpoint) -> Result<(), Fault> {
        let mut fault = None;
        let mut vertical = None;
        let mut inside = false;
        for zone in self.zones.iter().filter(|zone| zone.kind == Kind::KeepIn) {
            match zone.clearance(shape) {
                (true, clear_m) if clear_m >= zone.margin_m - shape.slack_m(zone.margin_m) => {
                    if zone.allows(setpoint) {
                        inside = true;
                        break;
                    }
                    vertical = Some(zone);
                }
                (true, clear_m) => fault = Some((zone, clear_m)),
                (false, _) => {}
            }
        }
        if !inside {
            return Err(match (vertical, fault) {
                (Some(zone), _) => Fault::Vertical(format!(
                    "{setpoint} is not allowed in zone {}: expected {} to {} m deep, or at least {} m above the seabed",
                    zone.name, zone.depth_min_m, zone.depth_max_m, zone.altitude_min_m
                )),
                (None, Some((zone, clear_m))) => Fault::Horizontal(format!(
                    "{clear_m:.2} m from the edge of keep-in zone {}, whose margin is {} m",
                    zone.name, zone.margin_m
                )),
                (None, None) => Fault::Horizontal("begins in no keep-in zone".to_owned()),
            });
        }
        let keep_outs = self
            .zones
            .iter()
            .filter(|zone| zone.kind == Kind::KeepOut && !zone.timed);
        for zone in keep_outs.filter(|zone| zone.forbids(setpoint)) {
            let (inside, clear_m) = zone.clearance(shape);
            if inside || clear_m < zone.margin_m - shape.slack_m(zone.margin_m) {
                let clear_m = if inside { 0.0 } else { clear_m };
                return Err(Fault::Horizontal(format!(
                    "{clear_m:.2} m from keep-out zone {}, whose margin is {} m",
                    zone.name, zone.margin_m
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::{EastNorth, LocalFrame};
    use proptest::prelude::*;

    use super::*;

    const FENCE: &str = r#"{ "type": "FeatureCollection", "features": [
        { "type": "Feature", "properties": { "name": "a", "kind": "keep-in", "margin_m": 15 },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.0, 60.0], [5.2, 60.0], [5.3, 60.1], [5.1, 60.05], [5.0, 60.2], [5.0, 60.0]] ] } },
        { "type": "Feature", "properties": { "name": "b", "kind": "keep-out", "margin_m": 40 },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.08, 60.02], [5.12, 60.03], [5.1, 60.01], [5.08, 60.02]] ] } } ] }"#;

    /// Whether a point keeps all margins with some metres to spare.
    fn keeps(area: &Area, position: Position, spare_m: f64) -> bool {
        let point = area.point(position);
        let plane = Plane::at(point);
        area.zones.iter().all(|zone| {
            let edges = zone
                .edges()
                .map(|edge| to_segment_m([0.0, 0.0], edge.map(|end| plane.vector(end))));
            let clear_m = edges.fold(f64::INFINITY, f64::min);
            zone.contains(point) == (zone.kind == Kind::KeepIn) && clear_m >= zone.margin_m + spare_m
        })
    }

    proptest! {
        /// The judgement of a shape agrees with that of many points on it. Only the spacing of the points makes a
        /// difference.
        #[test]
        fn a_shape_is_judged_like_its_points(
            from in (-9000.0..9000.0f64, -12000.0..12000.0f64), bearing in 0.0..360.0f64, length in 1.0..4000.0f64,
            rim: bool,
        ) {
            let area = Area::read(FENCE).unwrap();
            let from = EastNorth::new(from.0, from.1);
            // The frame in which the runtime judges, which shares no code with this crate.
            let frame = LocalFrame::new(backseat_units::Position::from_deg(60.1, 5.15).unwrap());
            let position = |point| {
                let position = frame.to_position(point);
                Position { latitude_deg: position.latitude.as_deg(), longitude_deg: position.longitude.as_deg() }
            };
            let count = 2000;
            let (good, points): (bool, Vec<EastNorth>) = if rim {
                let radius_m = length / 10.0;
                let points = (0..count).map(|index| from.offset(f64::from(index) * 360.0 / f64::from(count), radius_m));
                (area.judge_circle(position(from), radius_m, Setpoint::Depth(5.0)).is_ok(), points.collect())
            } else {
                let end = from.offset(bearing, length);
                let points = (0..=count).map(|index| from + (end - from) * (f64::from(index) / f64::from(count)));
                (area.judge_leg(position(from), position(end), Setpoint::Depth(5.0)).is_ok(), points.collect())
            };
            let all = |spare_m| points.iter().all(|point| keeps(&area, position(*point), spare_m));
            if good {
                prop_assert!(all(-2.0));
            } else {
                prop_assert!(!all(1.0));
            }
        }
    }
}

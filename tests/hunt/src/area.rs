use backseat_units::{EastNorth, LocalFrame, Position};
use serde_json::{Value, json};

use crate::dice::Dice;

/// The fence and the plan of a scenario, in metres around the origin.
pub(crate) struct Area {
    pub(crate) origin: Position,
    ring: Vec<EastNorth>,
    hole: Option<Vec<EastNorth>>,
    keep_outs: Vec<KeepOut>,
    surfacing: bool,
    pub(crate) depth_max_m: f64,
    pub(crate) altitude_min_m: f64,
    margin_m: f64,
    /// The points of the plan.
    pub(crate) points: Vec<EastNorth>,
    /// The depth at which the plan is flown.
    pub(crate) depth_m: f64,
    pub(crate) speed_mps: f64,
}

struct KeepOut {
    ring: Vec<EastNorth>,
    /// The depths at which it is valid; `None` means all.
    depths_m: Option<(f64, f64)>,
}

/// The distance of zones from the legs that they lie between, beyond their margin: the width of a turn and the
/// vehicle's tracking error.
const ASIDE_M: f64 = 35.0;
const MIDDLE: EastNorth = EastNorth::new(0.0, 0.0);

impl Area {
    /// Draws the plan in the middle, keep-out zones around it and between its legs, and the border farther out. There
    /// is room to fly, and an obstacle on every side and on many ways back.
    pub(crate) fn draw(dice: &mut Dice, hovering: bool) -> Self {
        let kept_out = |dice: &mut Dice| if hovering { 0 } else { dice.below(4) };
        Self::draw_with(dice, hovering, kept_out, 0.4)
    }

    /// Like [`Area::draw`], with as many walls as find a place.
    pub(crate) fn draw_walled(dice: &mut Dice) -> Self {
        Self::draw_with(dice, false, |_| 4, 1.0)
    }

    fn draw_with(dice: &mut Dice, hovering: bool, kept_out: impl Fn(&mut Dice) -> usize, walls: f64) -> Self {
        let origin = Position::from_deg(dice.figure(-60.0, 65.0), dice.figure(-179.0, 179.0))
            .expect("both are within their ranges");
        let base_m = if dice.chance(0.3) {
            dice.between(420.0, 640.0)
        } else {
            dice.between(640.0, 950.0)
        };
        let vertices = dice.one(&[4, 5, 8, 40, 200]);
        let rough = if vertices < 8 { 0.02 } else { 0.12 };
        let ring = star(dice, MIDDLE, vertices, base_m, rough);
        // Between the plan and the border.
        let ring_m = (0.81 * base_m - 45.0).min(540.0);
        let kept_out = kept_out(dice);
        let hole = (!hovering && dice.chance(0.2)).then(|| {
            let at = MIDDLE.offset(dice.between(0.0, 360.0), ring_m * dice.between(0.9, 1.0));
            star(dice, at, 6, 30.0, 0.2)
        });
        let turn_deg = dice.between(100.0, 200.0);
        let bearing_deg = dice.between(0.0, 360.0);
        let points: Vec<EastNorth> = (0..6)
            .map(|leg| {
                let point = MIDDLE.offset(
                    bearing_deg + turn_deg * f64::from(leg),
                    dice.between(120.0, (0.5 * base_m).min(320.0)),
                );
                EastNorth::new(tenths(point.east_m), tenths(point.north_m))
            })
            .collect();
        let margin_m = dice.figure(2.0, 20.0);
        let keep_outs = (0..kept_out)
            .filter_map(|_| {
                if dice.chance(walls) {
                    return Some(KeepOut {
                        ring: wall(dice, &points, margin_m + ASIDE_M)?,
                        depths_m: None,
                    });
                }
                let size_m = dice.between(20.0, 50.0);
                let at = if dice.chance(0.5) {
                    MIDDLE.offset(dice.between(0.0, 360.0), ring_m * dice.between(0.9, 1.0))
                } else {
                    beside(dice, &points, 1.7 * size_m + margin_m + ASIDE_M)?
                };
                let corners = dice.one(&[3, 5, 12]);
                Some(KeepOut {
                    ring: star(dice, at, corners, size_m, 0.2),
                    depths_m: dice
                        .chance(0.3)
                        .then(|| (dice.figure(0.0, 5.0), dice.figure(15.0, 40.0))),
                })
            })
            .collect();
        Self {
            origin,
            ring,
            hole,
            keep_outs,
            surfacing: dice.chance(0.5),
            depth_max_m: dice.figure(28.0, 45.0),
            altitude_min_m: dice.figure(2.0, 6.0),
            margin_m,
            points,
            depth_m: tenths(dice.between(6.0, 18.0)),
            speed_mps: dice.figure(1.2, 1.9),
        }
    }

    /// Half the side of a box around everything, metres.
    pub(crate) fn reach_m(&self) -> f64 {
        self.ring
            .iter()
            .map(|point| point.east_m.abs().max(point.north_m.abs()))
            .fold(0.0, f64::max)
    }

    /// The fence as a `fence.geojson`.
    pub(crate) fn fence(&self) -> String {
        let mut rings = vec![self.coordinates(&self.ring)];
        rings.extend(self.hole.iter().map(|hole| self.coordinates(hole)));
        let mut properties = json!({
            "name": "area",
            "kind": "keep-in",
            "margin_m": self.margin_m,
            "depth_max_m": self.depth_max_m,
            "altitude_min_m": self.altitude_min_m,
        });
        if self.surfacing {
            properties["surfacing"] = json!(true);
        }
        let mut features = vec![feature(&properties, rings)];
        for (index, keep_out) in self.keep_outs.iter().enumerate() {
            let mut properties = json!({
                "name": format!("keep out {}", index + 1),
                "kind": "keep-out",
                "margin_m": self.margin_m,
            });
            if let Some((min_m, max_m)) = keep_out.depths_m {
                properties["depth_min_m"] = json!(min_m);
                properties["depth_max_m"] = json!(max_m);
            }
            features.push(feature(&properties, vec![self.coordinates(&keep_out.ring)]));
        }
        format!("{}", json!({ "type": "FeatureCollection", "features": features }))
    }

    fn coordinates(&self, ring: &[EastNorth]) -> Value {
        let frame = LocalFrame::new(self.origin);
        let degrees = |deg: f64| (deg * 1e8).round() / 1e8;
        let mut coordinates: Vec<Value> = ring
            .iter()
            .map(|point| {
                let position = frame.to_position(*point);
                json!([
                    degrees(position.longitude.as_deg()),
                    degrees(position.latitude.as_deg())
                ])
            })
            .collect();
        coordinates.extend(coordinates.first().cloned());
        Value::Array(coordinates)
    }
}

/// A point between the legs of a plan, at least this far from all of them; `None` if none is found.
fn beside(dice: &mut Dice, points: &[EastNorth], clear_m: f64) -> Option<EastNorth> {
    let home = [points[points.len() - 1], points[0]];
    let legs = || points.windows(2).chain([home.as_slice()]);
    let is_clear = |at: &EastNorth| legs().all(|leg| to_leg_m(*at, leg[0], leg[1]) > clear_m);
    (0..30)
        .map(|_| MIDDLE.offset(dice.between(0.0, 360.0), dice.between(0.0, 460.0)))
        .find(is_clear)
}

/// A narrow, long zone between the legs of a plan, at least this far from all of them, so that no straight path leads
/// from one of its sides to the other. `None` if there is no room.
fn wall(dice: &mut Dice, points: &[EastNorth], clear_m: f64) -> Option<Vec<EastNorth>> {
    const HALF_WIDTH_M: f64 = 8.0;
    let home = [points[points.len() - 1], points[0]];
    let legs = || points.windows(2).chain([home.as_slice()]);
    for _ in 0..40 {
        let at = MIDDLE.offset(dice.between(0.0, 360.0), dice.between(0.0, 420.0));
        let along_deg = dice.between(0.0, 360.0);
        let half_m = dice.between(50.0, 140.0);
        let on_it = |share: f64| at.offset(along_deg, share * half_m);
        let is_clear = |place: EastNorth| legs().all(|leg| to_leg_m(place, leg[0], leg[1]) > clear_m + HALF_WIDTH_M);
        if [-1.0, -0.6, -0.2, 0.2, 0.6, 1.0]
            .into_iter()
            .all(|share| is_clear(on_it(share)))
        {
            let corner = |share: f64, side_deg: f64| on_it(share).offset(along_deg + side_deg, HALF_WIDTH_M);
            return Some(vec![
                corner(-1.0, -90.0),
                corner(1.0, -90.0),
                corner(1.0, 90.0),
                corner(-1.0, 90.0),
            ]);
        }
    }
    None
}

/// The distance from a point to a leg, metres.
fn to_leg_m(point: EastNorth, start: EastNorth, end: EastNorth) -> f64 {
    let (leg, from) = (end - start, point - start);
    let square_m2 = (leg.east_m * leg.east_m + leg.north_m * leg.north_m).max(1e-6);
    let share = ((from.east_m * leg.east_m + from.north_m * leg.north_m) / square_m2).clamp(0.0, 1.0);
    point.distance_m(start + leg * share)
}

fn feature(properties: &Value, rings: Vec<Value>) -> Value {
    json!({
        "type": "Feature",
        "properties": properties,
        "geometry": { "type": "Polygon", "coordinates": rings },
    })
}

/// A ring all of which is visible from its middle, so that it does not cross itself.
fn star(dice: &mut Dice, middle: EastNorth, vertices: usize, radius_m: f64, rough: f64) -> Vec<EastNorth> {
    // The corners of a triangle or a square are farther out, so that its sides are as far away as those of other rings.
    let reach_m = if vertices < 6 { 1.4 * radius_m } else { radius_m };
    (0..vertices)
        .map(|vertex| {
            let bearing_deg = 360.0 * vertex as f64 / vertices as f64;
            middle.offset(bearing_deg, reach_m * dice.between(1.0 - rough, 1.0 + rough))
        })
        .collect()
}

fn tenths(m: f64) -> f64 {
    (m * 10.0).round() / 10.0
}

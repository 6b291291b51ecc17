use crate::plane::{Plane, Point, Vector, between_m, length_m, rim_to_segment_m, to_segment_m};
use crate::wire::Setpoint;

/// How much the resolution of the sentences and two ways of projecting can change a distance, metres.
const SLACK_M: f64 = 0.05;

/// A setpoint or a depth this near to the end of a band may be beyond it, metres.
const BAND_SLACK_M: f64 = 1.0;

/// One feature of the fence.
#[derive(Clone, Debug)]
pub(crate) struct Zone {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) margin_m: f64,
    pub(crate) depth_min_m: f64,
    pub(crate) depth_max_m: f64,
    pub(crate) altitude_min_m: f64,
    /// The zone is valid for a limited time, which the oracle does not judge: such a keep-out zone never counts, and
    /// such a keep-in zone always does.
    pub(crate) timed: bool,
    /// The vehicle may surface in the zone.
    pub(crate) surfacing: bool,
    rings: Vec<Vec<Point>>,
    min: Point,
    max: Point,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    KeepIn,
    KeepOut,
}

/// The shape of a request.
pub(crate) enum Shape<'a> {
    Leg(&'a [(Plane, [Vector; 2])]),
    Rim { plane: Plane, radius_m: f64 },
}

impl Zone {
    pub(crate) fn new(
        name: String,
        kind: Kind,
        margin_m: f64,
        [depth_min_m, depth_max_m]: [f64; 2],
        altitude_min_m: f64,
        rings: Vec<Vec<Point>>,
    ) -> Self {
        let (mut min, mut max) = (Point { x: 360.0, y: 90.0 }, Point { x: -360.0, y: -90.0 });
        for point in rings.iter().flatten() {
            min = Point {
                x: min.x.min(point.x),
                y: min.y.min(point.y),
            };
            max = Point {
                x: max.x.max(point.x),
                y: max.y.max(point.y),
            };
        }
        Self {
            name,
            kind,
            margin_m,
            depth_min_m,
            depth_max_m,
            altitude_min_m,
            timed: false,
            surfacing: false,
            rings,
            min,
            max,
        }
    }

    /// Whether a point is inside, by the number of edges that a line to the east crosses.
    pub(crate) fn contains(&self, point: Point) -> bool {
        if point.x < self.min.x || point.x > self.max.x || point.y < self.min.y || point.y > self.max.y {
            return false;
        }
        let crossings = self.edges().filter(|[a, b]| {
            (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }

    /// Whether a keep-out zone certainly holds at all of these depths, even if rounding takes a part of a metre.
    /// Without depths: whether it holds at every depth.
    pub(crate) fn surely_holds(&self, depths_m: &[f64]) -> bool {
        let band = self.depth_min_m + BAND_SLACK_M..=self.depth_max_m - BAND_SLACK_M;
        let holds = if depths_m.is_empty() {
            self.depth_min_m == f64::NEG_INFINITY && self.depth_max_m == f64::INFINITY
        } else {
            depths_m.iter().all(|depth_m| band.contains(depth_m))
        };
        holds && !self.timed
    }

    pub(crate) fn edges(&self) -> impl Iterator<Item = [Point; 2]> {
        self.rings.iter().flat_map(|ring| ring.array_windows::<2>().copied())
    }

    pub(crate) fn allows(&self, setpoint: Setpoint) -> bool {
        match setpoint {
            Setpoint::Depth(depth_m) => (self.depth_min_m - 0.01..=self.depth_max_m + 0.01).contains(&depth_m),
            Setpoint::Altitude(altitude_m) => altitude_m > 0.0 && altitude_m >= self.altitude_min_m - 0.01,
        }
    }

    /// Whether a keep-out zone certainly holds at the setpoint. A zone with a band of depths says nothing about an
    /// altitude.
    pub(crate) fn forbids(&self, setpoint: Setpoint) -> bool {
        match setpoint {
            Setpoint::Depth(depth_m) => self.depth_min_m < depth_m && depth_m < self.depth_max_m,
            Setpoint::Altitude(_) => self.depth_min_m == f64::NEG_INFINITY && self.depth_max_m == f64::INFINITY,
        }
    }

    /// Whether a place of the plane is inside by at least so many metres; if `metres` is negative, whether it is
    /// inside, or outside by less than that.
    pub(crate) fn is_inside_by(&self, plane: &Plane, place: Vector, metres: f64) -> bool {
        let inside = self.contains(plane.point(place));
        if metres < 0.0 {
            inside || self.has_edge_within(plane, place, -metres)
        } else {
            inside && !self.has_edge_within(plane, place, metres)
        }
    }

    /// Whether a place of the plane is nearer to an edge than so many metres.
    fn has_edge_within(&self, plane: &Plane, place: Vector, metres: f64) -> bool {
        let [x, y] = place;
        // A place far outside the zone's box is not.
        let ([west, south], [east, north]) = (plane.vector(self.min), plane.vector(self.max));
        if x < west - metres || x > east + metres || y < south - metres || y > north + metres {
            return false;
        }
        self.edges()
            .any(|edge| to_segment_m(place, edge.map(|end| plane.vector(end))) < metres)
    }

    /// Whether the shape begins inside, and the distance from the shape to the nearest edge, metres; zero if they
    /// cross.
    pub(crate) fn clearance(&self, shape: &Shape<'_>) -> (bool, f64) {
        let mut clear_m = f64::INFINITY;
        let begin = match shape {
            Shape::Leg(pieces) => {
                for (plane, piece) in *pieces {
                    for edge in self.edges() {
                        clear_m = clear_m.min(between_m(*piece, edge.map(|end| plane.vector(end))));
                    }
                }
                pieces.first().map(|(plane, piece)| plane.point(piece[0]))
            }
            Shape::Rim { plane, radius_m } => {
                for edge in self.edges() {
                    clear_m = clear_m.min(rim_to_segment_m(*radius_m, edge.map(|end| plane.vector(end))));
                }
                Some(plane.point([0.0, *radius_m]))
            }
        };
        (begin.is_some_and(|begin| self.contains(begin)), clear_m)
    }
}

impl Shape<'_> {
    /// The possible error of judging a margin, metres.
    pub(crate) fn slack_m(&self, margin_m: f64) -> f64 {
        match self {
            Self::Leg(pieces) => pieces.first().map_or(SLACK_M, |(plane, piece)| {
                SLACK_M + plane.error_m(margin_m + length_m(piece[0]))
            }),
            Self::Rim { plane, radius_m } => SLACK_M + plane.error_m(margin_m + radius_m),
        }
    }
}

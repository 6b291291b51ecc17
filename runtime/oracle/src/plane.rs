use crate::earth::{E2, SEMI_MAJOR_AXIS_M};

/// A place in degrees. Longitude counts from the area's reference, so that the date line is far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// East, degrees.
    pub(crate) x: f64,
    /// North, degrees.
    pub(crate) y: f64,
}

/// A vector in a plane, metres.
pub(crate) type Vector = [f64; 2];

/// The plane that touches the ellipsoid at one point: degrees, multiplied by the length of a degree there in metres. A
/// line that is straight in longitude and latitude is straight in this plane, which no conformal projection offers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    origin: Point,
    x_m_per_deg: f64,
    y_m_per_deg: f64,
    /// The error of the plane: metres for each square metre of distance.
    bend_per_m: f64,
}

impl Plane {
    pub(crate) fn at(origin: Point) -> Self {
        let (sin, cos) = libm::sincos(origin.y.to_radians());
        let w = 1.0 - E2 * sin * sin;
        let normal_m = SEMI_MAJOR_AXIS_M / w.sqrt();
        let meridian_m = normal_m * (1.0 - E2) / w;
        Self {
            origin,
            x_m_per_deg: (normal_m * cos).to_radians(),
            y_m_per_deg: meridian_m.to_radians(),
            bend_per_m: (1.0 + (sin / cos).abs()) / meridian_m,
        }
    }

    pub(crate) fn vector(&self, point: Point) -> Vector {
        [
            (point.x - self.origin.x) * self.x_m_per_deg,
            (point.y - self.origin.y) * self.y_m_per_deg,
        ]
    }

    pub(crate) fn point(&self, vector: Vector) -> Point {
        Point {
            x: self.origin.x + vector[0] / self.x_m_per_deg,
            y: self.origin.y + vector[1] / self.y_m_per_deg,
        }
    }

    /// The greatest error of a length within a distance of the origin, metres.
    pub(crate) fn error_m(&self, distance_m: f64) -> f64 {
        distance_m * distance_m * self.bend_per_m
    }
}

pub(crate) fn length_m(v: Vector) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The distance from a point to a segment, metres.
pub(crate) fn to_segment_m(p: Vector, [a, b]: [Vector; 2]) -> f64 {
    let along = minus(b, a);
    let from = minus(p, a);
    let square = along[0] * along[0] + along[1] * along[1];
    if square <= 0.0 {
        return length_m(from);
    }
    let t = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
    length_m([from[0] - t * along[0], from[1] - t * along[1]])
}

/// The distance between two segments, metres; zero if they meet.
pub(crate) fn between_m(s: [Vector; 2], t: [Vector; 2]) -> f64 {
    let side = |[a, b]: [Vector; 2], p| cross(minus(b, a), minus(p, a));
    if side(s, t[0]) * side(s, t[1]) < 0.0 && side(t, s[0]) * side(t, s[1]) < 0.0 {
        return 0.0;
    }
    // Segments that do not cross are nearest at an end; touching ends give zero.
    to_segment_m(s[0], t)
        .min(to_segment_m(s[1], t))
        .min(to_segment_m(t[0], s))
        .min(to_segment_m(t[1], s))
}

/// The distance between a segment and the rim of a circle around the origin, metres; zero if they meet.
pub(crate) fn rim_to_segment_m(radius_m: f64, s: [Vector; 2]) -> f64 {
    let nearest = to_segment_m([0.0, 0.0], s);
    let farthest = length_m(s[0]).max(length_m(s[1]));
    if nearest > radius_m {
        nearest - radius_m
    } else if farthest < radius_m {
        radius_m - farthest
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_degree_has_its_published_length() {
        // 111 132.95 m and 78 846.81 m at 45 N.
        let plane = Plane::at(Point { x: 0.0, y: 45.0 });
        let [x, y] = plane.vector(Point { x: 1.0, y: 46.0 });
        assert!((x - 78_846.81).abs() < 0.1, "{x}");
        assert!((y - 111_131.78).abs() < 1.5, "{y}");
    }

    #[test]
    fn distances_of_segments_and_rims() {
        let edge = [[0.0, 10.0], [10.0, 10.0]];
        assert_eq!(between_m([[0.0, 0.0], [10.0, 0.0]], edge), 10.0);
        assert_eq!(between_m([[5.0, 0.0], [5.0, 20.0]], edge), 0.0);
        assert_eq!(between_m([[5.0, 0.0], [5.0, 10.0]], edge), 0.0);
        assert_eq!(between_m([[13.0, 6.0], [13.0, 6.0]], edge), 5.0);
        assert_eq!(rim_to_segment_m(4.0, edge), 6.0);
        assert_eq!(rim_to_segment_m(12.0, edge), 0.0);
        assert_eq!(rim_to_segment_m(20.0, [[0.0, 10.0], [0.0, 12.0]]), 8.0);
    }
}

use geo::{LineString, Simplify};

/// Removes the points of a line that are within `tolerance` of the remaining line.
pub(crate) fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let line: LineString = points.iter().copied().collect();
    let simple = line.simplify(tolerance);
    simple.into_iter().map(|point| (point.x, point.y)).collect()
}

#[cfg(test)]
mod tests {
    use geo::Distance;
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_straight_line_needs_its_ends_only() {
        let line: Vec<_> = (0..100).map(|x| (f64::from(x), 2.0 * f64::from(x))).collect();
        assert_eq!(simplify(&line, 0.5), [(0.0, 0.0), (99.0, 198.0)]);
    }

    proptest! {
        #[test]
        fn nothing_is_moved_by_more_than_the_tolerance(
            points in prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 0..60), tolerance in 0.1..20.0f64,
        ) {
            let simple = simplify(&points, tolerance);
            prop_assert_eq!(simple.first(), points.first());
            prop_assert_eq!(simple.last(), points.last());
            for point in &points {
                let near = simple.windows(2).any(|pair| {
                    let piece = geo::Line::new(pair[0], pair[1]);
                    geo::Euclidean.distance(&geo::Point::from(*point), &piece) <= tolerance * 1.000_001
                });
                prop_assert!(near || simple.len() < 2);
            }
        }
    }
}

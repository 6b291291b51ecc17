/// Leaves out the points of a line that are within `tolerance` of what remains: Douglas and Peucker, Cartographica 10,
/// 112 (1973), without recursion.
pub(crate) fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    keep[0] = true;
    keep[points.len() - 1] = true;
    while let Some((from, to)) = open.pop() {
        let mut farthest = (tolerance * tolerance, None);
        for index in from + 1..to {
            let square = distance_squared(points[index], points[from], points[to]);
            if square > farthest.0 {
                farthest = (square, Some(index));
            }
        }
        if let Some(index) = farthest.1 {
            keep[index] = true;
            open.push((from, index));
            open.push((index, to));
        }
    }
    let kept = points.iter().zip(keep).filter(|(_, keep)| *keep);
    kept.map(|(point, _)| *point).collect()
}

/// Square of the distance from a point to a segment.
fn distance_squared(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 {
        (((point.0 - from.0) * dx + (point.1 - from.1) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (x, y) = (from.0 + along * dx - point.0, from.1 + along * dy - point.1);
    x * x + y * y
}

#[cfg(test)]
mod tests {
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
                    distance_squared(*point, pair[0], pair[1]) <= tolerance * tolerance * 1.000_001
                });
                prop_assert!(near || simple.len() < 2);
            }
        }
    }
}

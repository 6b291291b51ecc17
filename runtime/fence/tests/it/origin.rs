//! The plane of a fence may count from any place near it.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, Form, Shape, Sweep, VerticalExtent};
use backseat_units::{EastNorth, Position};

const FENCE: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature",
     "properties": {"name": "bay", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3},
     "geometry": {"type": "Polygon", "coordinates": [
        [[-70.0, 42.0], [-69.98, 42.0], [-69.98, 42.02], [-70.0, 42.02], [-70.0, 42.0]]]}}]}"#;

fn at(latitude: f64, longitude: f64) -> Position {
    Position::from_deg(latitude, longitude).unwrap()
}

#[test]
fn the_same_place_has_the_same_clearance_from_any_origin() {
    let origin = at(42.1, -70.1);
    let (own, moved) = (
        Fence::read(FENCE, Form::GeoJson, None).unwrap(),
        Fence::read(FENCE, Form::GeoJson, Some(origin)).unwrap(),
    );
    assert_eq!(moved.frame().origin(), origin);
    let middle = own.frame().origin();
    assert!((middle.latitude.as_deg() - 42.01).abs() < 1e-4 && (middle.longitude.as_deg() + 69.99).abs() < 1e-4);
    let vertical = VerticalExtent {
        depth_min_m: 5.0,
        depth_max_m: 12.0,
        altitude_min_m: 8.0,
    };
    for (latitude, longitude, inside) in [(42.01, -69.99, true), (42.002, -69.985, true), (42.021, -69.99, false)] {
        let place = at(latitude, longitude);
        let [from_own, from_moved] = [&own, &moved].map(|fence| {
            let point = fence.frame().to_local(place);
            let leg = Shape::leg(point, point + EastNorth::new(20.0, 0.0));
            let judged = fence.check(&Sweep::new(leg, 5.0), &vertical);
            judged.map(|clearance| clearance.metres)
        });
        assert_eq!(from_own.is_ok(), inside);
        match (from_own, from_moved) {
            (Ok(own_m), Ok(moved_m)) => assert!((own_m - moved_m).abs() < 0.2, "{own_m} m, {moved_m} m"),
            (own, moved) => assert_eq!(own.is_err(), moved.is_err()),
        }
    }
}

#[test]
fn an_origin_that_is_too_far_away_is_refused() {
    let error = Fence::read(FENCE, Form::GeoJson, Some(at(43.0, -70.0)))
        .unwrap_err()
        .to_string();
    assert!(error.contains("the origin (latitude 43 longitude -70)"), "{error}");
    assert!(!error.contains('\n'), "{error}");
}

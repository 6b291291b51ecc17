//! Several shapes at once are judged as if one by one.

use backseat_fence::{Fence, Rule, Shape, Sweep, VerticalExtent};
use backseat_units::EastNorth;
use proptest::prelude::*;

const GEOJSON: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "box", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30,
        "altitude_min_m": 3},
     "geometry": {"type": "Polygon", "coordinates": [
        [[-70.0, 42.0], [-69.98, 42.0], [-69.984, 42.01], [-69.98, 42.02], [-70.0, 42.02], [-70.0, 42.0]]]}},
    {"type": "Feature", "properties": {"name": "wreck", "kind": "keep-out", "margin_m": 5, "radius_m": 60},
     "geometry": {"type": "Point", "coordinates": [-69.991, 42.012]}}]}"#;

const VERTICAL: VerticalExtent = VerticalExtent {
    depth_min_m: 5.0,
    depth_max_m: 20.0,
    altitude_min_m: 10.0,
};
const DEPTHS_M: [f64; 2] = [VERTICAL.depth_min_m, VERTICAL.depth_max_m];

fn point() -> impl Strategy<Value = EastNorth> {
    (-900.0..900.0, -1200.0..1200.0).prop_map(|(east_m, north_m)| EastNorth::new(east_m, north_m))
}

fn shapes() -> impl Strategy<Value = Vec<Shape>> {
    let near = (point(), prop::collection::vec((-150.0..150.0, -150.0..150.0), 6));
    near.prop_map(|(at, offs): (EastNorth, Vec<(f64, f64)>)| {
        let p: Vec<EastNorth> = offs
            .into_iter()
            .map(|(east_m, north_m)| at + EastNorth::new(east_m, north_m))
            .collect();
        vec![
            Shape::quadrilateral([at, p[0], p[1], p[2]]),
            Shape::triangle(at, p[0], p[3]),
            Shape::leg(p[4], p[5]),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn several_shapes_pass_only_if_each_of_them_does(shapes in shapes(), radius_m in 0.0..40.0) {
        let fence = Fence::from_geojson(GEOJSON).unwrap();
        let each: Vec<_> = shapes.iter().map(|shape| fence.check(&Sweep::new(*shape, radius_m), &VERTICAL)).collect();
        match fence.check_all(&shapes, radius_m, &VERTICAL, DEPTHS_M) {
            Ok(clearance) => {
                let least_m = each.iter().map(|checked| checked.as_ref().unwrap().metres).fold(f64::MAX, f64::min);
                prop_assert!(clearance.metres <= least_m + 1e-6, "{} {least_m}", clearance.metres);
            }
            Err(breach) => {
                let first = each.iter().find_map(|checked| checked.as_ref().err()).unwrap();
                prop_assert_eq!(breach.to_string(), first.to_string());
            }
        }
    }
}

#[test]
fn a_rim_and_nan_are_judged_as_always() {
    let fence = Fence::from_geojson(GEOJSON).unwrap();
    let middle = EastNorth::new(-300.0, -500.0);
    let rim = Shape::rim(middle, 50.0);
    let wide = Shape::rim(middle, 5000.0);
    let leg = Shape::leg(middle, middle + EastNorth::new(30.0, 0.0));
    assert!(fence.check_all(&[leg, rim], 5.0, &VERTICAL, DEPTHS_M).is_ok());
    assert!(fence.check_all(&[leg, leg, wide], 5.0, &VERTICAL, DEPTHS_M).is_err());
    let nowhere = Shape::triangle(middle, middle, EastNorth::new(f64::NAN, 0.0));
    assert!(fence.check_all(&[leg, nowhere], 5.0, &VERTICAL, DEPTHS_M).is_err());
    assert!(fence.check_all(&[leg, leg], f64::NAN, &VERTICAL, DEPTHS_M).is_err());
}

#[test]
fn a_keep_out_zone_counts_at_all_depths_on_the_way_and_a_keep_in_zone_only_at_the_given_extent() {
    let fence = Fence::from_geojson(
        r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":1,"depth_min_m":5,"depth_max_m":40,"altitude_min_m":2},
         "geometry":{"type":"Polygon","coordinates":[[[-70.01,41.99],[-69.99,41.99],[-69.99,42.01],[-70.01,42.01],[-70.01,41.99]]]}},
        {"type":"Feature","properties":{"name":"shoal","kind":"keep-out","margin_m":1,"depth_max_m":10},
         "geometry":{"type":"Polygon","coordinates":[[[-70.001,41.999],[-69.999,41.999],[-69.999,42.001],[-70.001,42.001],[-70.001,41.999]]]}}]}"#,
    )
    .unwrap();
    let sweep = Sweep::new(Shape::leg(EastNorth::new(-300.0, 0.0), EastNorth::new(300.0, 0.0)), 5.0);
    let extent = VerticalExtent {
        depth_min_m: 20.0,
        depth_max_m: 20.0,
        altitude_min_m: 10.0,
    };
    assert!(fence.check(&sweep, &extent).is_ok());
    assert!(fence.check_passing(&sweep, &extent, [12.0, 100.0]).is_ok());
    let breach = fence.check_passing(&sweep, &extent, [8.0, 20.0]).unwrap_err();
    assert_eq!(breach.rule, Rule::KeepOut);
    assert!(fence.check_passing(&sweep, &extent, [f64::NAN, 20.0]).is_err());
}

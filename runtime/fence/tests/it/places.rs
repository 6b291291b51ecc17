//! Errors that no single ring shows still name the feature, and the vertex if there is one.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, Terms};
use serde_json::{Value, json};

#[track_caller]
fn refused(features: &[(&str, &str, Value)]) -> String {
    let features: Vec<_> = features
        .iter()
        .map(|(name, kind, geometry)| {
            let mut properties = json!({ "name": name, "kind": kind, "margin_m": 1 });
            if *kind == "keep-in" {
                properties["depth_max_m"] = json!(30);
                properties["altitude_min_m"] = json!(3);
            }
            match geometry["type"].as_str() {
                Some("Point") => properties["radius_m"] = json!(50),
                Some("LineString") => properties["half_width_m"] = json!(50),
                _ => {}
            }
            json!({ "type": "Feature", "properties": properties, "geometry": geometry })
        })
        .collect();
    let text = json!({ "type": "FeatureCollection", "features": features }).to_string();
    let error = Fence::from_geojson(&text).unwrap_err().to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error
}

/// A box of a hundredth of a degree, by its south-west corner.
fn square(west: f64, south: f64) -> Value {
    let (east, north) = (west + 0.01, south + 0.01);
    json!([
        [west, south],
        [east, south],
        [east, north],
        [west, north],
        [west, south]
    ])
}

fn polygon(rings: &[Value]) -> Value {
    json!({ "type": "Polygon", "coordinates": rings })
}

fn box_2() -> (&'static str, &'static str, Value) {
    ("box 2", "keep-in", polygon(&[square(-69.98, 42.0)]))
}

#[test]
fn a_wide_fence_names_the_vertex_that_is_farthest_out() {
    let box_ = || ("box", "keep-in", polygon(&[square(-70.0, 42.0)]));
    // Two digits are swapped.
    let mut typo = square(-69.99, 42.0);
    typo[2][1] = json!(24.01);
    assert_eq!(
        refused(&[box_(), ("bay", "keep-out", polygon(&[typo.clone()]))]),
        "feature 'bay' outer ring vertex 3: the fence is 2010.5 km across, expected at most 50 km, and this is farthest out"
    );
    let several =
        json!({ "type": "MultiPolygon", "coordinates": [[square(-69.98, 42.0)], [square(-69.97, 42.0), typo]] });
    let error = refused(&[box_(), ("bay", "keep-out", several)]);
    assert!(
        error.starts_with("feature 'bay' polygon 2 hole 1 vertex 3: the fence is 2010.5 km"),
        "{error}"
    );
    // This fence is a little too wide, which is found only once it is on its plane.
    let far = ("bay", "keep-out", polygon(&[square(-70.0, 42.45)]));
    let error = refused(&[box_(), box_2(), far]);
    assert!(
        error.starts_with("feature 'bay' outer ring vertex 4: the fence is 51.1 km across"),
        "{error}"
    );
    // A circle has no vertices, and counts as one place however finely it is drawn.
    let circle = (
        "buoy",
        "keep-out",
        json!({ "type": "Point", "coordinates": [-70.0, 24.0] }),
    );
    let error = refused(&[box_(), circle]);
    assert!(error.starts_with("feature 'buoy': the fence is"), "{error}");
    let line = json!({ "type": "LineString", "coordinates": [[-70.0, 42.0], [-70.0, 24.0], [-70.01, 42.0]] });
    let error = refused(&[box_(), ("cable", "keep-out", line)]);
    assert!(error.starts_with("feature 'cable' vertex 2: the fence is"), "{error}");
}

#[test]
fn too_many_vertices_are_reported_with_the_feature_that_exceeds_the_limit() {
    // The vertices that divide long edges count: along this parallel each edge gets some hundred.
    let (west, east) = (json!([-70.0, 84.0]), json!([-66.0, 84.0]));
    let mut parallels: Vec<_> = [west.clone(), east].into_iter().cycle().take(10_000).collect();
    parallels.push(json!([-68.0, 84.1]));
    parallels.push(west);
    let box_ = ("box", "keep-in", polygon(&[square(-68.0, 84.0)]));
    let error = refused(&[
        box_,
        ("coast", "keep-out", polygon(&[Value::from(parallels)])),
        ("bay", "keep-out", polygon(&[square(-67.0, 84.0)])),
    ]);
    assert!(error.starts_with("feature 'coast': 1000"), "{error}");
    assert!(
        error.ends_with(" vertices up to here, expected at most 1000000"),
        "{error}"
    );
}

#[test]
fn coordinates_that_are_not_numbers_are_named_by_ring_and_vertex() {
    let with = |geometry: Value| refused(&[("box", "keep-in", geometry)]);
    let mut hole = square(-69.998, 42.002);
    for (position, found) in [
        (json!([-70.0, null]), "[-70.0,null]"),
        (json!(["-70", 42.0]), "[\"-70\",42.0]"),
        (json!(null), "null"),
        (json!([[-70.0, 42.0]]), "[[-70.0,42.0]]"),
    ] {
        hole[1] = position.clone();
        let end = format!("vertex 2: {found}, expected longitude and latitude");
        assert_eq!(
            with(polygon(&[square(-70.0, 42.0), hole.clone()])),
            format!("feature 'box' hole 1 {end}")
        );
        let several = json!({ "type": "MultiPolygon", "coordinates": [[square(-70.0, 42.0)], [hole]] });
        assert_eq!(with(several), format!("feature 'box' polygon 2 outer ring {end}"));
        let line = json!({ "type": "LineString", "coordinates": [[-70.0, 42.0], position] });
        assert_eq!(with(line), format!("feature 'box' {end}"));
    }
    let point = json!({ "type": "Point", "coordinates": ["west", 42.0] });
    assert_eq!(
        with(point),
        "feature 'box' vertex 1: [\"west\",42.0], expected longitude and latitude"
    );
}

#[test]
fn positions_of_a_plan_are_expected_in_the_plans_own_order() {
    let terms = Terms {
        margin_m: 10.0,
        depth_min_m: 2.0,
        depth_max_m: 30.0,
        altitude_min_m: 3.0,
        surfacing: true,
    };
    let corners = json!([[91.0, -70.0], [42.0, -69.98], [42.02, -69.98]]);
    let plan = json!({ "fileType": "Plan", "version": 1, "geoFence": {
        "version": 2, "circles": [], "polygons": [{ "inclusion": true, "version": 1, "polygon": corners }],
    }});
    assert_eq!(
        Fence::from_plan(&plan.to_string(), &terms).unwrap_err().to_string(),
        "geoFence polygon 1 vertex 1: latitude 91 deg is not within -90 to 90, expected latitude, then longitude"
    );
}

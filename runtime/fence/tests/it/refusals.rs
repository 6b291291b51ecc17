//! An invalid fence is refused in one line, with the place and what was expected.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, FenceError, Kind};
use serde_json::{Value, json};

const SQUARE: &str = "[[-70.0, 42.0], [-69.99, 42.0], [-69.99, 42.01], [-70.0, 42.01], [-70.0, 42.0]]";

/// A feature with these properties and this geometry.
fn feature(properties: &Value, geometry: &Value) -> Value {
    json!({ "type": "Feature", "properties": properties, "geometry": geometry })
}

fn collection(features: &[Value]) -> String {
    json!({ "type": "FeatureCollection", "features": features }).to_string()
}

fn keep_in() -> Value {
    json!({ "name": "survey box", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3 })
}

fn keep_out() -> Value {
    json!({ "name": "wreck", "kind": "keep-out", "margin_m": 10 })
}

fn polygon(rings: &[Vec<(f64, f64)>]) -> Value {
    json!({ "type": "Polygon", "coordinates": rings })
}

fn square() -> Value {
    json!({ "type": "Polygon", "coordinates": [serde_json::from_str::<Value>(SQUARE).unwrap()] })
}

/// Offsets in thousandths of a degree from 42 N 70 W, east then north.
fn ring(offsets: &[(f64, f64)]) -> Vec<(f64, f64)> {
    offsets
        .iter()
        .map(|(east, north)| (-70.0 + east / 1000.0, 42.0 + north / 1000.0))
        .collect()
}

#[track_caller]
fn refused(text: &str) -> String {
    let error = Fence::from_geojson(text).expect_err("it should be refused").to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error
}

#[track_caller]
fn with_ring(offsets: &[(f64, f64)]) -> String {
    refused(&collection(&[feature(&keep_in(), &polygon(&[ring(offsets)]))]))
}

#[track_caller]
fn with_holes(holes: &[&[(f64, f64)]]) -> String {
    let mut rings = vec![ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)])];
    rings.extend(holes.iter().map(|hole| ring(hole)));
    refused(&collection(&[feature(&keep_in(), &polygon(&rings))]))
}

#[track_caller]
fn with_property(key: &str, value: Value) -> String {
    let mut properties = keep_in();
    properties[key] = value;
    refused(&collection(&[feature(&properties, &square())]))
}

#[test]
fn a_valid_fence_is_accepted() {
    let text = collection(&[feature(&keep_in(), &square())]);
    let fence = Fence::from_geojson(&text).unwrap();
    assert_eq!(fence.zones().count(), 1);
    // A document as editors and GDAL write it.
    let decorated = format!(
        "\u{feff}{}",
        text.replacen(
            '{',
            r#"{"name": "fence", "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}, "#,
            1
        )
    );
    assert!(Fence::from_geojson(&decorated).is_ok());
}

#[test]
fn errors_in_json_name_their_line() {
    assert_eq!(refused(""), "line 1 column 0: EOF while parsing a value");
    assert_eq!(
        refused("{\n  \"type\": \"FeatureCollection\",\n}"),
        "line 3 column 1: trailing comma"
    );
    assert_eq!(refused("{\n\"type\": 1e999}"), "line 2 column 13: number out of range");
    assert!(refused("{\n\"a\": NaN}").starts_with("line 2 column 6"));
    assert_eq!(
        refused("{\"type\": 1,\n\n\"type\": 2}"),
        "line 3 column 6: key `type` is given twice, expected it only once"
    );
    let deep = "[".repeat(100_000);
    assert!(refused(&deep).contains("recursion limit"));
}

#[test]
fn a_document_that_is_no_feature_collection_is_refused_with_what_it_is() {
    assert_eq!(refused("[]"), "document: an array, expected a FeatureCollection");
    assert_eq!(
        refused("{}"),
        "document: no `type`, expected `type` of \"FeatureCollection\""
    );
    assert_eq!(
        refused(&square().to_string()),
        "document: Polygon, expected a FeatureCollection"
    );
    assert_eq!(
        refused(r#"{"type": "FeatureCollection"}"#),
        "document: no `features`, expected an array of features"
    );
    assert_eq!(
        refused(r#"{"type": "FeatureCollection", "features": 3}"#),
        "`features`: a number, expected an array of features"
    );
    assert_eq!(
        refused(r#"{"type": "FeatureCollection", "features": [4]}"#),
        "feature 1: a number, expected a Feature with properties and geometry"
    );
    assert_eq!(
        refused(r#"{"type": "FeatureCollection", "features": [], "margin_m": 3}"#),
        "document: unknown key `margin_m`, expected `type`, `name`, `crs`, `bbox` or `features`"
    );
    assert_eq!(
        refused(r#"{"type": "FeatureCollection", "crs": {"properties": {"name": "EPSG:32619"}}, "features": []}"#),
        "`crs`: {\"properties\":{\"name\":\"EPSG:32619\"}}, expected urn:ogc:def:crs:OGC:1.3:CRS84, or no `crs`"
    );
}

#[test]
fn fences_without_zones_are_refused() {
    assert_eq!(
        refused(&collection(&[])),
        "no features, expected at least one keep-in zone"
    );
    assert_eq!(
        refused(&collection(&[feature(&keep_out(), &square())])),
        "no keep-in zone among 1 features, expected at least one"
    );
}

#[test]
fn only_areas_circles_and_corridors_are_accepted_as_geometry() {
    let with = |geometry: Value| refused(&collection(&[feature(&keep_in(), &geometry)]));
    assert_eq!(
        with(json!({ "type": "MultiPoint", "coordinates": [[1, 2]] })),
        "feature 'survey box': geometry is MultiPoint, expected Polygon, MultiPolygon, Point or LineString"
    );
    assert_eq!(
        with(Value::Null),
        "feature 'survey box': no geometry, expected Polygon, MultiPolygon, Point or LineString"
    );
    assert_eq!(
        with(json!({ "type": "Polygon", "coordinates": [] })),
        "feature 'survey box': polygon without rings, expected an outer ring"
    );
    assert_eq!(
        with(json!({ "type": "MultiPolygon", "coordinates": [] })),
        "feature 'survey box': polygon without rings, expected an outer ring"
    );
    assert_eq!(
        with(json!({ "type": "Polygon", "coordinates": [], "margin_m": 2 })),
        "feature 'survey box' geometry: unknown key `margin_m`, expected `type` or `coordinates`"
    );
    assert_eq!(
        with(json!({ "type": "Polygon", "coordinates": [["a"]] })),
        "feature 'survey box' outer ring vertex 1: \"a\", expected longitude and latitude"
    );
    assert!(with(json!({ "type": "Polygon", "coordinates": ["a"] })).starts_with("feature 'survey box': "));
    assert!(with(json!({ "type": "Polygons" })).ends_with("expected a Feature of RFC 7946"));
}

#[test]
fn missing_and_unknown_properties_are_refused() {
    let without = |key: &str| {
        let mut properties = keep_in();
        properties.as_object_mut().unwrap().remove(key);
        refused(&collection(&[feature(&properties, &square())]))
    };
    assert_eq!(
        without("name"),
        "feature 1: `name` is missing, expected a name of 1 to 100 printable characters"
    );
    assert_eq!(
        without("kind"),
        "feature 'survey box': `kind` is missing, expected \"keep-in\" or \"keep-out\""
    );
    assert_eq!(
        without("margin_m"),
        "feature 'survey box': `margin_m` is missing, expected metres, 0 or more"
    );
    assert_eq!(
        without("depth_max_m"),
        "feature 'survey box': `depth_max_m` is missing, expected metres"
    );
    assert_eq!(
        without("altitude_min_m"),
        "feature 'survey box': `altitude_min_m` is missing, expected metres, 0 or more"
    );
    let mut keep_out = keep_out();
    keep_out.as_object_mut().unwrap().remove("margin_m");
    assert_eq!(
        refused(&collection(&[feature(&keep_out, &square())])),
        "feature 'wreck': `margin_m` is missing, expected metres, 0 or more"
    );
    assert_eq!(
        with_property("depth_max", json!(3)),
        "feature 'survey box': unknown key `depth_max`, expected `name`, `kind`, `margin_m`, `depth_min_m`, `depth_max_m`, `altitude_min_m`, `surfacing`, `valid_from` or `valid_until`"
    );
    keep_out["margin_m"] = json!(1);
    keep_out["altitude_min_m"] = json!(1);
    assert_eq!(
        refused(&collection(&[feature(&keep_out, &square())])),
        "feature 'wreck': unknown key `altitude_min_m`, expected `name`, `kind`, `margin_m`, `depth_min_m`, `depth_max_m`, `valid_from` or `valid_until`"
    );
    let mut stray = feature(&keep_in(), &square());
    stray["margin_m"] = json!(5);
    assert_eq!(
        refused(&collection(&[stray])),
        "feature 'survey box': unknown key `margin_m`, expected `type`, `id`, `bbox`, `properties` or `geometry`"
    );
    let mut bare = feature(&keep_in(), &square());
    bare["properties"] = Value::Null;
    assert_eq!(
        refused(&collection(&[bare])),
        "feature 1: no `properties`, expected an object with `name` and `kind`"
    );
}

#[test]
fn values_out_of_range_are_refused() {
    for (key, value, expected) in [
        (
            "margin_m",
            json!(-1),
            "`margin_m` is -1, expected metres within 0 to 50000",
        ),
        (
            "margin_m",
            json!("5"),
            "`margin_m` is \"5\", expected metres within 0 to 50000",
        ),
        (
            "kind",
            json!("Keep-in"),
            "`kind` is \"Keep-in\", expected \"keep-in\" or \"keep-out\"",
        ),
        (
            "depth_max_m",
            json!(20_000),
            "`depth_max_m` is 20000, expected metres within -100 to 12000",
        ),
        (
            "depth_max_m",
            json!(-3),
            "`depth_max_m` is -3.0, expected at least the `depth_min_m` of 0",
        ),
        (
            "depth_min_m",
            json!(31),
            "`depth_max_m` is 30.0, expected at least the `depth_min_m` of 31",
        ),
        (
            "depth_min_m",
            json!([1]),
            "`depth_min_m` is [1], expected metres within -100 to 12000",
        ),
        (
            "altitude_min_m",
            json!(-0.5),
            "`altitude_min_m` is -0.5, expected metres within 0 to 12000",
        ),
    ] {
        assert_eq!(with_property(key, value), format!("feature 'survey box': {expected}"));
    }
    assert_eq!(
        with_property("name", json!(" ")),
        "feature 1: `name` is \" \", expected a name of 1 to 100 printable characters"
    );
    assert!(with_property("name", json!("a\nb")).starts_with("feature 1: `name` is \"a\\nb\""));
    let huge = with_property("margin_m", json!("x".repeat(10_000)));
    assert!(huge.len() < 200, "{huge}");
}

#[test]
fn windows_need_valid_times_in_order() {
    assert_eq!(
        with_property("valid_from", json!("tomorrow")),
        "feature 'survey box': `valid_from` is \"tomorrow\", expected a time of RFC 3339, such as \"2026-05-01T08:00:00Z\""
    );
    assert!(with_property("valid_until", json!(1_777_622_400)).contains("`valid_until` is 1777622400"));
    let mut properties = keep_out();
    properties["valid_from"] = json!("2026-05-01T10:00:00+02:00");
    properties["valid_until"] = json!("2026-05-01T08:00:00Z");
    assert_eq!(
        refused(&collection(&[
            feature(&keep_in(), &square()),
            feature(&properties, &square())
        ])),
        "feature 'wreck': `valid_until` is \"2026-05-01T08:00:00Z\", expected a time after `valid_from`"
    );
}

#[test]
fn duplicate_names_are_refused() {
    let features = [
        feature(&keep_in(), &square()),
        feature(&keep_out(), &square()),
        feature(&keep_in(), &square()),
    ];
    assert_eq!(
        refused(&collection(&features)),
        "feature 3: `name` is 'survey box', the same as that of feature 1, expected different names"
    );
}

#[test]
fn positions_off_the_earth_or_near_the_poles_are_refused() {
    let with = |position: Value| {
        let mut geometry = square();
        geometry["coordinates"][0][2] = position;
        refused(&collection(&[feature(&keep_in(), &geometry)]))
    };
    let place = "feature 'survey box' outer ring vertex 3";
    assert_eq!(
        with(json!([-70.0, 95.0])),
        format!("{place}: latitude 95 deg is not within -90 to 90, expected longitude, then latitude")
    );
    assert_eq!(
        with(json!([-190.0, 42.0])),
        format!("{place}: longitude -190 deg is not within -180 to 180, expected longitude, then latitude")
    );
    assert_eq!(
        with(json!([-70.0, 86.0])),
        format!("{place}: latitude 86 deg, expected at most 85 degrees north or south")
    );
    assert_eq!(
        with(json!([-70.0, 42.0, 5.0])),
        format!("{place}: 3 numbers, expected longitude and latitude")
    );
    for position in [json!([]), json!([-70.0]), json!([-70.0, "42"]), json!([-70.0, null])] {
        assert!(with(position).starts_with("feature 'survey box'"));
    }
}

#[test]
fn rings_must_be_closed_and_enclose_something() {
    assert_eq!(
        with_ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]),
        "feature 'survey box' outer ring: ring is open, vertex 4 differs from vertex 1, expected the first vertex again as the last"
    );
    assert_eq!(
        with_ring(&[(0.0, 0.0), (10.0, 0.0), (0.0, 0.0)]),
        "feature 'survey box' outer ring: 2 distinct vertices, expected at least 3"
    );
    assert_eq!(
        with_ring(&[]),
        "feature 'survey box' outer ring: 0 distinct vertices, expected at least 3"
    );
    assert_eq!(
        with_ring(&[(0.0, 0.0), (0.0, 5.0), (0.0, 10.0), (0.0, 0.0)]),
        "feature 'survey box' outer ring: zero area, all vertices lie on one line, expected a ring that encloses an area"
    );
    assert_eq!(
        with_ring(&[
            (0.0, 0.0),
            (10.0, 0.0),
            (10.0, 10.0),
            (10.0, 20.0),
            (10.0, 10.0),
            (0.0, 10.0),
            (0.0, 0.0)
        ]),
        "feature 'survey box' outer ring: ring runs back on itself at vertex 4 (latitude 42.020000 longitude -69.990000), expected a corner of over 0.006 degrees"
    );
}

#[test]
fn crossing_edges_are_named_with_their_place() {
    let bow_tie = [(0.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 10.0), (0.0, 0.0)];
    let text = "feature 'survey box' outer ring: edge 1 crosses or touches edge 3 at latitude 42.005000 longitude -69.995000, expected edges that meet at their shared vertices only";
    assert_eq!(with_ring(&bow_tie), text);
    let turned: Vec<_> = bow_tie.into_iter().rev().collect();
    // In the other direction edges 2 and 4 cross.
    assert!(with_ring(&turned).contains("edge 2 crosses or touches edge 4 at latitude 42.005000 longitude -69.995000"));
    // A vertex that touches an edge, and then a vertex that occurs twice.
    let touch = [
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 10.0),
        (5.0, 0.0),
        (0.0, 10.0),
        (0.0, 0.0),
    ];
    assert!(with_ring(&touch).contains("edge 1 crosses or touches edge 3"));
    let twice = [
        (0.0, 0.0),
        (5.0, 5.0),
        (10.0, 0.0),
        (10.0, 10.0),
        (5.0, 5.0),
        (0.0, 10.0),
        (0.0, 0.0),
    ];
    assert!(with_ring(&twice).contains("crosses or touches"));
    // Lines that run along each other.
    let along = [
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 5.0),
        (8.0, 0.0),
        (4.0, 0.0),
        (2.0, 5.0),
        (0.0, 0.0),
    ];
    assert!(with_ring(&along).contains("crosses or touches"));
}

#[test]
fn a_crossing_is_named_by_the_files_own_numbers_in_either_direction() {
    // Edge 5 crosses edge 3, also in a ring of the other direction. After a repeated vertex the numbers are one higher.
    let text = with_ring(&[
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 10.0),
        (6.0, 10.0),
        (6.5, 11.0),
        (7.0, 9.0),
        (0.0, 10.0),
        (0.0, 0.0),
    ]);
    assert!(text.contains("edge 3 crosses or touches edge 5"), "{text}");
    let clockwise = [
        (0.0, 0.0),
        (0.0, 10.0),
        (7.0, 9.0),
        (6.5, 11.0),
        (6.0, 10.0),
        (10.0, 10.0),
        (10.0, 0.0),
        (0.0, 0.0),
    ];
    let text = with_ring(&clockwise);
    assert!(text.contains("edge 3 crosses or touches edge 5"), "{text}");
    let repeated = [
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 0.0),
        (10.0, 10.0),
        (6.0, 10.0),
        (6.5, 11.0),
        (7.0, 9.0),
        (0.0, 10.0),
        (0.0, 0.0),
    ];
    let text = with_ring(&repeated);
    assert!(text.contains("edge 4 crosses or touches edge 6"), "{text}");
}

#[test]
fn holes_must_lie_inside_their_polygon_and_apart() {
    let small = [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (1.0, 1.0)];
    let outside = small.map(|(east, north)| (east + 20.0, north));
    let within = [(1.2, 1.2), (1.8, 1.2), (1.8, 1.8), (1.2, 1.2)];
    let across = small.map(|(east, north)| (east - 1.5, north));
    let overlapping = small.map(|(east, north)| (east + 0.5, north + 0.5));
    assert_eq!(
        with_holes(&[&small, &outside]),
        "feature 'survey box' hole 2: hole lies outside its polygon, expected a hole inside the outer ring"
    );
    assert_eq!(
        with_holes(&[&within, &small]),
        "feature 'survey box' hole 1: hole lies inside hole 2, expected holes apart from each other"
    );
    let text = with_holes(&[&across]);
    assert!(
        text.starts_with("feature 'survey box' outer ring: edge 4 crosses or touches hole 1 edge 3 at"),
        "{text}"
    );
    let text = with_holes(&[&small, &overlapping]);
    assert!(
        text.starts_with("feature 'survey box' hole 1: edge 3 crosses or touches hole 2 edge 4 at"),
        "{text}"
    );
}

#[test]
fn polygons_of_a_multipolygon_are_numbered() {
    let good = ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 0.0)]);
    let open = ring(&[(20.0, 0.0), (30.0, 0.0), (30.0, 10.0), (20.0, 10.0)]);
    let geometry = json!({ "type": "MultiPolygon", "coordinates": [[good], [open]] });
    assert!(
        refused(&collection(&[feature(&keep_in(), &geometry)]))
            .starts_with("feature 'survey box' polygon 2 outer ring: ring is open")
    );
}

#[test]
fn a_fence_across_the_antimeridian_is_refused() {
    let across = polygon(&[vec![(179.99, 10.0), (-179.99, 10.0), (-179.99, 10.01), (179.99, 10.0)]]);
    assert_eq!(
        refused(&collection(&[feature(&keep_in(), &across)])),
        "feature 'survey box': crosses the antimeridian (longitudes -179.99 to 179.99), expected a fence on one side of it"
    );
    let west = polygon(&[vec![(179.98, 10.0), (179.99, 10.0), (179.99, 10.01), (179.98, 10.0)]]);
    let east = polygon(&[vec![
        (-179.99, 10.0),
        (-179.98, 10.0),
        (-179.98, 10.01),
        (-179.99, 10.0),
    ]]);
    assert!(
        refused(&collection(&[feature(&keep_in(), &west), feature(&keep_out(), &east)]))
            .starts_with("fence: crosses the antimeridian")
    );
    // A fence that ends at the antimeridian is accepted.
    let beside = polygon(&[vec![(179.99, 10.0), (180.0, 10.0), (180.0, 10.01), (179.99, 10.0)]]);
    assert!(Fence::from_geojson(&collection(&[feature(&keep_in(), &beside)])).is_ok());
}

#[test]
fn fences_over_fifty_kilometres_are_refused() {
    assert_eq!(
        with_ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 455.0), (0.0, 455.0), (0.0, 0.0)]),
        "feature 'survey box' outer ring vertex 3: the fence is 50.5 km across, expected at most 50 km, and this is farthest out"
    );
    let text = with_ring(&[(0.0, 0.0), (10_000.0, 0.0), (10_000.0, 10_000.0), (0.0, 0.0)]);
    assert!(
        text.ends_with("km across, expected at most 50 km, and this is farthest out"),
        "{text}"
    );
    // A keep-out zone far away counts too.
    let far = polygon(&[ring(&[(0.0, 500.0), (1.0, 500.0), (1.0, 501.0), (0.0, 500.0)])]);
    let text = refused(&collection(&[
        feature(&keep_in(), &square()),
        feature(&keep_out(), &far),
    ]));
    assert!(
        text.ends_with("km across, expected at most 50 km, and this is farthest out"),
        "{text}"
    );
    let near = polygon(&[ring(&[
        (0.0, 0.0),
        (10.0, 0.0),
        (10.0, 445.0),
        (0.0, 445.0),
        (0.0, 0.0),
    ])]);
    assert!(Fence::from_geojson(&collection(&[feature(&keep_in(), &near)])).is_ok());
}

#[test]
fn a_margin_that_leaves_nothing_is_refused() {
    let text = with_property("margin_m", json!(450));
    assert_eq!(
        text,
        "feature 'survey box' outer ring: `margin_m` of 450 leaves nothing inside, expected under 414.254, half of its width"
    );
    // What counts for a slanting strip is its width across.
    let strip = ring(&[(0.0, 0.0), (0.2, 0.0), (10.2, 10.0), (10.0, 10.0), (0.0, 0.0)]);
    let text = refused(&collection(&[feature(&keep_in(), &polygon(&[strip]))]));
    assert!(text.contains("leaves nothing inside"), "{text}");
    // A keep-out zone's margin may have any width.
    let mut wide = keep_out();
    wide["margin_m"] = json!(450);
    assert!(
        Fence::from_geojson(&collection(&[
            feature(&keep_in(), &square()),
            feature(
                &wide,
                &polygon(&[ring(&[(4.0, 4.0), (5.0, 4.0), (5.0, 5.0), (4.0, 4.0)])])
            )
        ]))
        .is_ok()
    );
}

#[test]
fn more_than_a_million_vertices_are_refused() {
    let mut text = String::from(
        r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"a","kind":"keep-in","margin_m":0,"depth_max_m":9,"altitude_min_m":1},"geometry":{"type":"Polygon","coordinates":[["#,
    );
    text.push_str(&"[1,2],".repeat(1_000_000));
    text.push_str("[1,2]]]}}]}");
    assert_eq!(
        refused(&text),
        "feature 'a': 1000001 vertices up to here, expected at most 1000000"
    );
}

#[test]
fn programs_can_distinguish_the_errors() {
    let error = Fence::from_geojson(&collection(&[feature(&keep_in(), &polygon(&[ring(&[])]))])).unwrap_err();
    let FenceError::TooFewVertices { place, found: 0 } = error else {
        panic!("{error}")
    };
    assert_eq!(
        (place.feature.as_str(), place.polygon, place.hole),
        ("feature 'survey box'", None, None)
    );
}

#[test]
fn surfacing_is_true_or_false_and_only_for_keep_in_zones() {
    let message = with_property("surfacing", json!("yes"));
    assert!(
        message.contains("`surfacing` is \"yes\", expected true or false"),
        "{message}"
    );
    let mut properties = keep_out();
    properties["surfacing"] = json!(true);
    let message = refused(&collection(&[
        feature(&keep_in(), &square()),
        feature(&properties, &square()),
    ]));
    assert!(message.contains("unknown key `surfacing`"), "{message}");
    for (value, allowed) in [(json!(true), true), (json!(false), false), (Value::Null, false)] {
        let mut properties = keep_in();
        properties["surfacing"] = value;
        let fence = Fence::from_geojson(&collection(&[feature(&properties, &square())])).unwrap();
        let zone = fence.zones().next().unwrap();
        assert!(matches!(zone.kind(), Kind::KeepIn { surfacing, .. } if surfacing == allowed));
    }
}

#[test]
fn a_keep_in_zone_that_a_keep_out_zone_covers_is_refused() {
    let zones = |inner: &Value, outer: &Value, around: &Value| {
        let text = collection(&[feature(inner, &square()), feature(outer, around)]);
        Fence::from_geojson(&text)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    let message = "feature 'survey box' outer ring: lies wholly inside keep-out zone 'wreck', expected a part that the vehicle can reach";
    let around =
        |low: f64, high: f64| polygon(&[ring(&[(low, low), (high, low), (high, high), (low, high), (low, low)])]);
    // The keep-out zone lies around the keep-in zone, or has the very same ring, as if the two kinds had been swapped.
    assert_eq!(
        zones(&keep_in(), &keep_out(), &around(-1.0, 11.0)),
        Err(message.to_owned())
    );
    assert_eq!(zones(&keep_in(), &keep_out(), &square()), Err(message.to_owned()));
    assert_eq!(
        zones(&keep_in(), &keep_out(), &around(0.0, 11.0)),
        Err(message.to_owned())
    );
    // A part is left.
    assert_eq!(zones(&keep_in(), &keep_out(), &around(0.0, 9.9)), Ok(()));
    assert_eq!(zones(&keep_in(), &keep_out(), &around(1.0, 12.0)), Ok(()));
    let notched = polygon(&[ring(&[
        (-1.0, -1.0),
        (11.0, -1.0),
        (11.0, 4.0),
        (-0.5, 4.2),
        (11.0, 4.4),
        (11.0, 11.0),
        (-1.0, 11.0),
        (-1.0, -1.0),
    ])]);
    assert_eq!(zones(&keep_in(), &keep_out(), &notched), Ok(()));
    let holed = polygon(&[
        ring(&[(-1.0, -1.0), (11.0, -1.0), (11.0, 11.0), (-1.0, 11.0), (-1.0, -1.0)]),
        ring(&[(4.0, 4.0), (4.0, 5.0), (5.0, 5.0), (4.0, 4.0)]),
    ]);
    assert_eq!(zones(&keep_in(), &keep_out(), &holed), Ok(()));
    // At other depths or times it can be reached.
    let with = |mut properties: Value, key: &str, value: Value| {
        properties[key] = value;
        properties
    };
    let deep = with(keep_out(), "depth_min_m", json!(20));
    assert_eq!(zones(&keep_in(), &deep, &around(-1.0, 11.0)), Ok(()));
    let covering = with(with(keep_out(), "depth_min_m", json!(0)), "depth_max_m", json!(30));
    assert_eq!(
        zones(&keep_in(), &covering, &around(-1.0, 11.0)),
        Err(message.to_owned())
    );
    let until = |properties| with(properties, "valid_until", json!("2026-05-01T08:00:00Z"));
    assert_eq!(zones(&keep_in(), &until(keep_out()), &around(-1.0, 11.0)), Ok(()));
    assert_eq!(
        zones(&until(keep_in()), &keep_out(), &around(-1.0, 11.0)),
        Err(message.to_owned())
    );
    assert_eq!(
        zones(&until(keep_in()), &until(keep_out()), &around(-1.0, 11.0)),
        Err(message.to_owned())
    );
}

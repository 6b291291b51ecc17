//! A fence of any file that is written as GeoJSON and read again judges as before.

use backseat_fence::{Fence, Kind, Shape, Span, Sweep, Terms, VerticalExtent};
use backseat_units::{EastNorth, Utc};

const GEOJSON: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "box \"a\"", "kind": "keep-in", "margin_m": 10, "depth_min_m": 2,
        "depth_max_m": 30, "altitude_min_m": 3, "surfacing": true, "valid_from": "2026-05-01T08:00:00.25Z"},
     "geometry": {"type": "MultiPolygon", "coordinates": [
        [[[-70.0, 42.0], [-69.9, 42.0], [-69.9, 42.05], [-70.0, 42.05], [-70.0, 42.0]],
         [[-69.98, 42.01], [-69.97, 42.01], [-69.97, 42.02], [-69.98, 42.01]]],
        [[[-70.1, 42.0], [-70.05, 42.0], [-70.05, 42.05], [-70.1, 42.0]]]]}},
    {"type": "Feature", "properties": {"name": "wreck", "kind": "keep-out", "margin_m": 0, "radius_m": 200,
        "depth_min_m": 12.5, "valid_until": "2026-06-01T00:00:00Z"},
     "geometry": {"type": "Point", "coordinates": [-69.95, 42.03]}},
    {"type": "Feature", "properties": {"name": "cable", "kind": "keep-out", "margin_m": 5, "half_width_m": 20},
     "geometry": {"type": "LineString", "coordinates": [[-69.99, 42.04], [-69.93, 42.045], [-69.91, 42.04]]}},
    {"type": "Feature", "properties": {"name": "basin", "kind": "keep-in", "margin_m": 5, "radius_m": 1500,
        "depth_max_m": 10, "altitude_min_m": 1},
     "geometry": {"type": "Point", "coordinates": [-70.03, 42.02]}}]}"#;

const PLAN: &str = r#"{"fileType": "Plan", "groundStation": "QGroundControl", "version": 1, "geoFence": {"version": 2,
    "polygons": [{"inclusion": true, "version": 1, "polygon": [[42.0, -70.0], [42.0, -69.98], [42.02, -69.98], [42.02, -70.0]]}],
    "circles": [{"inclusion": false, "version": 1, "circle": {"center": [42.005, -69.995], "radius": 100.5}}]}}"#;

const KML: &str = r#"<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
  <Placemark><name>box</name>
    <ExtendedData><Data name="kind"><value>keep-in</value></Data></ExtendedData>
    <Polygon><outerBoundaryIs><LinearRing><coordinates>
      -70.0,42.0 -69.98,42.0 -69.98,42.02 -70.0,42.02 -70.0,42.0
    </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>
  <Placemark><name>cable</name>
    <ExtendedData><Data name="kind"><value>keep-out</value></Data><Data name="half_width_m"><value>15</value></Data></ExtendedData>
    <LineString><coordinates>-69.999,42.015 -69.99,42.016 -69.981,42.012</coordinates></LineString></Placemark>
</Document></kml>"#;

const TERMS: Terms = Terms {
    margin_m: 10.0,
    depth_min_m: 0.0,
    depth_max_m: 30.0,
    altitude_min_m: 3.0,
    surfacing: false,
};

#[test]
fn a_fence_that_is_written_out_and_read_again_judges_as_before() {
    let fences = [
        Fence::from_geojson(GEOJSON).unwrap(),
        Fence::from_plan(PLAN, &TERMS).unwrap(),
        Fence::from_kml(KML, &TERMS).unwrap(),
    ];
    for fence in fences {
        let text = fence.to_geojson();
        let again = Fence::from_geojson(&text).unwrap();
        for (zone, other) in fence.zones().zip(again.zones()) {
            assert_eq!(zone.name(), other.name());
            assert_eq!(zone.kind(), other.kind(), "{}", zone.name());
            assert_eq!(zone.margin_m().to_bits(), other.margin_m().to_bits());
            assert_eq!(zone.window(), other.window());
            assert_eq!(zone.rings().count(), other.rings().count());
        }
        let noon = Utc::from_unix_nanos(1_778_000_000_000_000_000);
        let span = Span {
            from: noon,
            until: noon,
        };
        let (mut inside, mut outside) = (0, 0);
        for step in 0..40_000_u32 {
            let unit = |prime: u32| f64::from(step.wrapping_mul(prime) % 10_007) / 10_007.0 - 0.5;
            let at = EastNorth::new(unit(7919) * 20_000.0, unit(104_729) * 8_000.0);
            let local = again.frame().to_local(fence.frame().to_position(at));
            let depth_m = 1.0 + (unit(31) + 0.5) * 14.0;
            let vertical = VerticalExtent {
                depth_min_m: depth_m,
                depth_max_m: depth_m,
                altitude_min_m: 20.0,
            };
            let judged = |fence: &Fence, at| fence.during(span).check(&Sweep::new(Shape::point(at), 1.0), &vertical);
            match (judged(&fence, at), judged(&again, local)) {
                (Ok(ours), Ok(theirs)) => {
                    inside += 1;
                    assert!((ours.metres - theirs.metres).abs() < 0.05, "{ours:?} {theirs:?}");
                }
                (Err(ours), Err(theirs)) => {
                    outside += 1;
                    assert_eq!(ours.rule, theirs.rule);
                }
                // The two may differ by the centimetre by which edges are divided, and by the difference of their
                // planes.
                (Ok(clearance), Err(breach)) | (Err(breach), Ok(clearance)) => {
                    assert!(
                        clearance.metres < 0.05 && breach.metres < 0.05,
                        "{clearance:?} {breach}"
                    );
                }
            }
        }
        assert!(inside > 300 && outside > 1000, "{inside} {outside}");
    }
}

#[test]
fn the_written_geojson_has_only_areas() {
    let fence = Fence::from_geojson(GEOJSON).unwrap();
    let text = fence.to_geojson();
    assert!(!text.contains("Point") && !text.contains("LineString"), "{text}");
    assert!(text.contains(r#""valid_from":"2026-05-01T08:00:00.250000000Z""#));
    let wreck = fence.zones().find(|zone| zone.name() == "wreck").unwrap();
    assert!(matches!(wreck.kind(), Kind::KeepOut { depth: Some(band) } if band.max_m.is_infinite()));
}

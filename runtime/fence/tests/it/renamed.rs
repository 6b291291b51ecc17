//! Files with former names are refused with the present names.

use backseat_fence::{Fence, Terms};

const GEOJSON: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature",
    "properties": {"name": "box", "kind": "KIND", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3},
    "geometry": {"type": "Polygon", "coordinates": [[[-70.0, 42.0], [-69.9, 42.0], [-69.9, 42.1], [-70.0, 42.0]]]}}]}"#;
const KML: &str = "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark><name>box</name>\
    <ExtendedData><Data name=\"kind\"><value>KIND</value></Data></ExtendedData>\
    <Polygon><outerBoundaryIs><LinearRing><coordinates>-70.0,42.0 -69.9,42.0 -69.9,42.1 -70.0,42.0</coordinates>\
    </LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>";
const TERMS: Terms = Terms {
    margin_m: 10.0,
    depth_min_m: 0.0,
    depth_max_m: 30.0,
    altitude_min_m: 3.0,
    surfacing: false,
};

#[test]
fn a_former_kind_of_zone_is_refused_with_its_present_name() {
    for (old, new) in [("inclusion", "keep-in"), ("exclusion", "keep-out")] {
        let expected = format!("`kind` is \"{old}\", expected \"{new}\", as it is called now");
        for error in [
            Fence::from_geojson(&GEOJSON.replace("KIND", old)).unwrap_err(),
            Fence::from_kml(&KML.replace("KIND", old), &TERMS).unwrap_err(),
        ] {
            assert!(error.to_string().contains(&expected), "{error}");
        }
    }
    assert!(Fence::from_geojson(&GEOJSON.replace("KIND", "keep-in")).is_ok());
    assert!(Fence::from_kml(&KML.replace("KIND", "keep-in"), &TERMS).is_ok());
}

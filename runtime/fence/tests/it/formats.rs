//! Plans of QGroundControl, and KML: the same fences as in GeoJSON, and errors with their place.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, Kind, Rule, Shape, Sweep, Terms, VerticalExtent};
use backseat_units::Position;
use proptest::prelude::*;

const TERMS: Terms = Terms {
    margin_m: 10.0,
    depth_min_m: 2.0,
    depth_max_m: 30.0,
    altitude_min_m: 3.0,
    surfacing: true,
};

const PLAN: &str = r#"{
    "fileType": "Plan", "groundStation": "QGroundControl", "version": 1, "mission": {"items": []},
    "rallyPoints": {"points": [], "version": 2},
    "geoFence": {
        "version": 2,
        "polygons": [
            {"inclusion": true, "version": 1, "polygon": [[42.0, -70.0], [42.0, -69.98], [42.02, -69.98], [42.02, -70.0]]},
            {"inclusion": false, "version": 1, "polygon": [[42.012, -69.99], [42.012, -69.988], [42.014, -69.988]]}
        ],
        "circles": [{"inclusion": false, "version": 1, "circle": {"center": [42.005, -69.995], "radius": 100.5}}]
    }
}"#;

const KML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
  <Style id="s"><LineStyle><width>2</width></LineStyle></Style>
  <Folder><name>range</name>
    <Placemark><name>box &amp; bay</name>
      <ExtendedData>
        <Data name="kind"><value>keep-in</value></Data>
        <Data name="depth_max_m"><value> 40 </value></Data>
        <Data name="surfacing"><value>false</value></Data>
        <Data name="depth_min_m"><value></value></Data>
      </ExtendedData>
      <Polygon><tessellate>1</tessellate>
        <outerBoundaryIs><LinearRing><coordinates>
          -70.0,42.0,0 -69.98,42.0,0
          -69.98,42.02,0 -70.0,42.02,0 -70.0,42.0,0
        </coordinates></LinearRing></outerBoundaryIs>
        <innerBoundaryIs><LinearRing><coordinates>
          -69.99,42.012 -69.988,42.012 -69.988,42.014 -69.99,42.012
        </coordinates></LinearRing></innerBoundaryIs>
      </Polygon>
    </Placemark>
    <Placemark><name>wreck</name>
      <TimeSpan><begin>2026-05-01T08:00:00Z</begin></TimeSpan>
      <ExtendedData><SchemaData>
        <SimpleData name="kind">keep-out</SimpleData><SimpleData name="radius_m">100.5</SimpleData>
      </SchemaData></ExtendedData>
      <Point><coordinates>-69.995,42.005,0</coordinates></Point>
    </Placemark>
    <Placemark><name>cable</name>
      <ExtendedData>
        <Data name="kind"><value>keep-out</value></Data><Data name="half_width_m"><value>5</value></Data>
      </ExtendedData>
      <LineString><coordinates>-69.999,42.018 -69.981,42.018</coordinates></LineString>
    </Placemark>
  </Folder>
</Document></kml>"#;

fn judged(fence: &Fence, latitude: f64, longitude: f64) -> Result<f64, (Rule, String)> {
    let at = fence.frame().to_local(Position::from_deg(latitude, longitude).unwrap());
    let vertical = VerticalExtent {
        depth_min_m: 5.0,
        depth_max_m: 20.0,
        altitude_min_m: 10.0,
    };
    let verdict = fence.check(&Sweep::new(Shape::point(at), 0.0), &vertical);
    verdict
        .map(|clearance| clearance.metres)
        .map_err(|breach| (breach.rule, breach.zone().unwrap().to_owned()))
}

#[test]
fn a_plan_is_read_into_zones() {
    let fence = Fence::from_plan(PLAN, &TERMS).unwrap();
    let names: Vec<_> = fence.zones().map(|zone| zone.name()).collect();
    assert_eq!(names, ["polygon 1", "polygon 2", "circle 1"]);
    let first = fence.zones().next().unwrap();
    let Kind::KeepIn {
        depth,
        altitude_min_m,
        surfacing,
    } = first.kind()
    else {
        panic!("{:?}", first.kind())
    };
    assert_eq!(
        (depth.min_m, depth.max_m, altitude_min_m, surfacing),
        (2.0, 30.0, 3.0, true)
    );
    assert!(fence.zones().all(|zone| zone.margin_m() == 10.0));
    assert!(judged(&fence, 42.016, -69.995).is_ok());
    assert_eq!(
        judged(&fence, 42.0125, -69.9885),
        Err((Rule::KeepOut, "polygon 2".to_owned()))
    );
    assert_eq!(
        judged(&fence, 42.0055, -69.995),
        Err((Rule::KeepOut, "circle 1".to_owned()))
    );
    assert_eq!(
        judged(&fence, 42.03, -69.99),
        Err((Rule::KeepIn, "polygon 1".to_owned()))
    );
}

#[test]
fn kml_is_read_into_zones() {
    let fence = Fence::from_kml(KML, &TERMS).unwrap();
    let names: Vec<_> = fence.zones().map(|zone| zone.name()).collect();
    assert_eq!(names, ["box & bay", "wreck", "cable"]);
    let first = fence.zones().next().unwrap();
    let Kind::KeepIn { depth, surfacing, .. } = first.kind() else {
        panic!("{:?}", first.kind())
    };
    // Values of the placemark override the terms.
    assert_eq!((depth.min_m, depth.max_m, surfacing), (2.0, 40.0, false));
    let window = fence.zones().nth(1).unwrap().window();
    assert_eq!(window.to_string(), "from 2026-05-01T08:00:00Z");
    assert!(judged(&fence, 42.016, -69.995).is_ok());
    assert_eq!(
        judged(&fence, 42.0125, -69.9885),
        Err((Rule::KeepIn, "box & bay".to_owned()))
    );
    assert_eq!(
        judged(&fence, 42.0055, -69.995),
        Err((Rule::KeepOut, "wreck".to_owned()))
    );
    assert_eq!(
        judged(&fence, 42.01805, -69.99),
        Err((Rule::KeepOut, "cable".to_owned()))
    );
}

#[test]
fn errors_in_a_plan_name_their_place() {
    let refused = |from: &str, to: &str| {
        assert!(PLAN.contains(from), "{from}");
        let text = PLAN.replacen(from, to, 1);
        Fence::from_plan(&text, &TERMS).unwrap_err().to_string()
    };
    for (from, to, message) in [
        (
            "\"Plan\"",
            "\"Other\"",
            "document: \"Other\", expected `fileType` of \"Plan\"",
        ),
        (
            "\"geoFence\"",
            "\"fence\"",
            "`geoFence`: nothing, expected an object with `polygons` and `circles`",
        ),
        (
            "\"version\": 2,\n        \"polygons\"",
            "\"version\": 3, \"polygons\"",
            "`geoFence` version: 3, expected 2",
        ),
        (
            "\"polygons\"",
            "\"areas\"",
            "`geoFence`: unknown key `areas`, expected `version`, `polygons`, `circles` or `breachReturn`",
        ),
        (
            "\"inclusion\": false",
            "\"inclusion\": 0",
            "geoFence polygon 2 `inclusion`: 0, expected true or false",
        ),
        (
            "[42.012, -69.99]",
            "[42.012]",
            "geoFence polygon 2 vertex 1: [42.012], expected latitude and longitude",
        ),
        ("[42.012, -69.99]", "[-69.99, 200.0]", "geoFence polygon 2 vertex 1: "),
        (
            "\"radius\": 100.5",
            "\"radius\": -1",
            "geoFence circle 1: `radius_m` is -1, expected metres within 0.1 to 25000",
        ),
        ("\"radius\": 100.5", "\"r\": 1", "geoFence circle 1: unknown key `r`"),
        (
            "[42.0, -69.98], [42.02, -69.98]",
            "[42.02, -69.98], [42.0, -69.98]",
            "geoFence polygon 1 outer ring: edge 1 crosses or touches edge 3",
        ),
        ("\"mission\"", "\"version\"", "line 2 column"),
        (
            "\"inclusion\": true",
            "\"inclusion\": false",
            "no keep-in zone among 3 features",
        ),
    ] {
        let error = refused(from, to);
        assert!(error.starts_with(message), "{error}\n{message}");
    }
    let terms = Terms {
        depth_max_m: f64::NAN,
        ..TERMS
    };
    let error = Fence::from_plan(PLAN, &terms).unwrap_err().to_string();
    assert_eq!(error, "geoFence polygon 1: `depth_max_m` is missing, expected metres");
}

#[test]
fn errors_in_kml_name_their_line() {
    let refused = |from: &str, to: &str| {
        assert!(KML.contains(from), "{from}");
        let error = Fence::from_kml(&KML.replacen(from, to, 1), &TERMS)
            .unwrap_err()
            .to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    };
    for (from, to, message) in [
        ("</Placemark>", "</Place>", "line 21: "),
        (
            "<Document>",
            "<!DOCTYPE kml [<!ENTITY a \"b\">]><Document>",
            "line 2: a document type definition",
        ),
        ("box &amp;", "box &all;", "line 5: unknown entity `all`"),
        ("<kml xmlns", "<gpx><kml xmlns", "line "),
        (
            "<value>keep-in</value>",
            "<value>inside</value>",
            "line 5 placemark 'box & bay': `kind` is \"inside\"",
        ),
        (
            "<value> 40 </value>",
            "<value>nan</value>",
            "line 5 placemark 'box & bay': `depth_max_m` is \"nan\"",
        ),
        (
            "name=\"surfacing\"",
            "name=\"surface\"",
            "line 5 placemark 'box & bay': unknown key `surface`",
        ),
        (
            "name=\"surfacing\"",
            "name=\"kind\"",
            "line 5 placemark 'box & bay': `kind` given twice",
        ),
        (
            "name=\"surfacing\"",
            "id=\"surfacing\"",
            "line 5 placemark 'box & bay' line 9: <Data> without name",
        ),
        (
            "-69.988,42.014",
            "-69.988;42.014",
            "line 5 placemark 'box & bay' hole 1 vertex 3: -69.988;42.014, expected longitude,latitude",
        ),
        (
            " -69.99,42.012\n",
            "\n",
            "line 5 placemark 'box & bay' hole 1: ring is open",
        ),
        ("<name>wreck</name>", "", "line 22 placemark: `name` is missing"),
        (
            "<name>wreck</name>",
            "<name>cable</name>",
            "feature 3: `name` is 'cable'",
        ),
        (
            "<begin>2026-05-01T08:00:00Z",
            "<begin>2026-05",
            "line 22 placemark 'wreck': `valid_from` is \"2026-05\"",
        ),
        (
            "<Point><coordinates>-69.995,42.005,0</coordinates></Point>",
            "",
            "line 22 placemark 'wreck': no geometry",
        ),
        (
            "radius_m",
            "half_width_m",
            "line 22 placemark 'wreck': unknown key `half_width_m`",
        ),
        (
            "<coordinates>-69.999,42.018 -69.981,42.018",
            "<coordinates>",
            "line 29 placemark 'cable'",
        ),
        ("<Folder>", "<NetworkLink/><Folder>", "line 4: <NetworkLink>"),
    ] {
        let error = refused(from, to);
        assert!(error.starts_with(message), "{error}\n{message}");
    }
    assert_eq!(
        Fence::from_kml("<kml/>", &TERMS).unwrap_err().to_string(),
        "no features, expected at least one keep-in zone"
    );
    let deep = "<kml>".repeat(1000);
    assert!(
        Fence::from_kml(&deep, &TERMS)
            .unwrap_err()
            .to_string()
            .contains("over 64 deep")
    );
}

proptest! {
    #[test]
    fn no_text_makes_the_readers_panic(text in r#"[<>/&;!a-z"= \[\]{},:0-9.\-]{0,80}"#, cut in 0..1500usize, junk in "[<>/&;!\"\\[{,]{1,3}") {
        prop_assert!(Fence::from_kml(&text, &TERMS).is_err());
        prop_assert!(Fence::from_plan(&text, &TERMS).is_err());
        // Nor does a file that is damaged at one place.
        for whole in [KML, PLAN] {
            let cut = cut % whole.len();
            let scratched = format!("{}{junk}{}", &whole[..cut], &whole[cut..]);
            let _ = Fence::from_kml(&scratched, &TERMS);
            let _ = Fence::from_plan(&scratched, &TERMS);
        }
    }
}

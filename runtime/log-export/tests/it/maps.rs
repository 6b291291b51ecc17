use backseat_log_export::{Export, Format, export};
use serde_json::Value;

use crate::{Desk, compose};

/// The properties of a map's features, with the geometry under `geometry`, in one layer.
fn layer(map: &str, name: &str) -> Vec<Value> {
    let document: Value = serde_json::from_str(map).unwrap();
    let features = document["features"].as_array().unwrap().iter();
    features
        .filter(|feature| feature["properties"]["layer"] == name)
        .map(|feature| {
            let mut properties = feature["properties"].clone();
            properties["geometry"] = feature["geometry"].clone();
            properties
        })
        .collect()
}

fn lines_and_points(features: &[Value]) -> [usize; 2] {
    ["LineString", "Point"].map(|kind| {
        let features = features.iter();
        features.filter(|feature| feature["geometry"]["type"] == kind).count()
    })
}

#[test]
fn a_track_comes_from_position_with_what_navigation_says_and_is_apart_at_a_gap() {
    let map = Desk::with(&compose::whole()).exported(Format::Geojson, "map.geojson");
    let track = layer(&map, "track");
    // 120 s without the 10 s of the gap, a point each 10 s.
    assert_eq!(lines_and_points(&track), [2, 13]);
    assert_eq!(track[0]["geometry"]["coordinates"].as_array().unwrap().len(), 251);
    assert_eq!(
        (&track[0]["until_s"], &track[1]["from_s"]),
        (&50.0.into(), &60.0.into())
    );
    let point = &track[2 + 3];
    assert_eq!((&point["t_s"], &point["heading_deg"]), (&30.0.into(), &56.3.into()));
    assert_eq!(point["time"], "2026-11-23T14:05:37.250000000Z");
    let coordinates = &point["geometry"]["coordinates"];
    // /navigation says 42.3101.
    assert!(
        (coordinates[1].as_f64().unwrap() - 42.310_100_2).abs() < 1e-12,
        "{coordinates}"
    );
    assert_eq!(coordinates[2], -7.5);
    assert_eq!(lines_and_points(&layer(&map, "truth")), [2, 13]);
}

#[test]
fn layers_have_the_last_state_of_each_feature_and_when_it_stood() {
    let map = Desk::with(&compose::whole()).exported(Format::Geojson, "map.geojson");
    let fence = layer(&map, "fence");
    let named: Vec<&Value> = fence.iter().map(|zone| &zone["name"]).collect();
    assert_eq!(named, ["box", "wreck & reef"]);

    let plan = layer(&map, "plan");
    let stood: Vec<_> = plan
        .iter()
        .map(|element| {
            (
                element["number"].as_u64(),
                element["t_s"].as_f64(),
                element["until_s"].as_f64(),
            )
        })
        .collect();
    assert_eq!(
        stood,
        [
            (Some(1), Some(2.0), Some(40.0)),
            (Some(2), Some(2.0), None),
            (Some(3), Some(40.0), None)
        ]
    );

    let inserts = layer(&map, "inserts");
    assert_eq!(inserts.len(), 1, "{inserts:?}");
    assert_eq!(
        (&inserts[0]["state"], &inserts[0]["identifier"]),
        (&"ended".into(), &4711.into())
    );
    assert_eq!(
        (&inserts[0]["t_s"], &inserts[0]["changed_s"]),
        (&11.0.into(), &22.0.into())
    );

    // The third was for a modify. It has no geometry, and is where the vehicle was.
    let requests = layer(&map, "requests");
    let told: Vec<_> = requests
        .iter()
        .map(|request| {
            (
                request["request"].as_u64(),
                request["state"].as_str(),
                &request["geometry"]["type"],
            )
        })
        .collect();
    let [line, point] = ["LineString", "Point"].map(Value::from);
    assert_eq!(
        told,
        [
            (Some(1), Some("sent"), &line),
            (Some(2), Some("rejected"), &line),
            (Some(3), Some("rejected"), &point)
        ]
    );
    assert!(requests.iter().all(|request| request["style"].is_null()));
    assert!(requests[1]["reason"].as_str().unwrap().contains("12.5 m"));
}

#[test]
fn the_period_of_points_is_the_users() {
    let desk = Desk::with(&compose::whole());
    let out = desk.at("map.geojson");
    let done = export(&Export {
        log: &desk.log,
        to: Format::Geojson,
        out: &out,
        channel: None,
        every_s: Some(60.0),
    });
    assert!(done.unwrap().remarks[0].contains("250 records are missing from 50.000 s to 60.000 s"));
    let map = std::fs::read_to_string(out).unwrap();
    assert_eq!(lines_and_points(&layer(&map, "track")), [2, 3]);
}

#[test]
fn google_earth_gets_folders_times_and_texts_for_people() {
    let map = Desk::with(&compose::whole()).exported(Format::Kml, "map.kml");
    for part in [
        "<name>composed &lt;&amp;&gt;, Mon Nov 23 14:05:07 2026 UTC</name>",
        "<name>wreck &amp; reef</name>",
        "<name>trackline 4711: ended</name>",
        "<styleUrl>#keep-out</styleUrl>",
        "<styleUrl>#refused</styleUrl>",
        "<altitudeMode>clampToGround</altitudeMode>",
        "heading: 56.3°",
        "depth: 7.5 m",
    ] {
        assert!(map.contains(part), "{part}");
    }
    assert!(!map.contains("#1f77b4"));
    // A position a second: 0 to 50 and 60 to 120 of the track, and the same of the truth.
    assert_eq!(map.matches("<gx:coord>").count(), 2 * (51 + 61));
    let folders: Vec<&str> = map
        .split("<Folder>")
        .skip(1)
        .filter_map(|folder| folder.split(['<', '>']).nth(2))
        .collect();
    assert_eq!(
        folders,
        [
            "Track",
            "Points",
            "True track",
            "Points",
            "Fence",
            "Plan",
            "Requests",
            "Inserts"
        ]
    );
}

#[test]
fn a_log_of_an_older_program_has_its_track_from_navigation_and_its_fence_from_the_attachment() {
    let desk = Desk::with(&compose::without(&["/position", "/map/"]));
    let map = desk.exported(Format::Geojson, "map.geojson");
    let track = layer(&map, "track");
    assert_eq!(lines_and_points(&track), [2, 13]);
    let latitude = track[2 + 3]["geometry"]["coordinates"][1].as_f64().unwrap();
    assert!((latitude - 42.3101).abs() < 1e-12, "{latitude}");
    assert_eq!(layer(&map, "fence").len(), 2);
    // Without their geometry, refused requests are points.
    assert_eq!(lines_and_points(&layer(&map, "requests")), [0, 2]);
}

#[test]
fn a_log_with_no_channel_but_position_has_a_track() {
    let desk = Desk::with(&compose::without(&["/navigation", "/truth"]));
    let track = layer(&desk.exported(Format::Geojson, "map.geojson"), "track");
    assert_eq!(lines_and_points(&track), [2, 13]);
    assert_eq!(track[5]["depth_m"], 7.5);
    assert!(
        track[5]
            .as_object()
            .unwrap()
            .keys()
            .all(|name| !name.contains("timestamp"))
    );
}

#[test]
fn a_log_without_any_position_has_a_map_of_the_rest_and_says_so() {
    let desk = Desk::with(&compose::without(&["/navigation", "/position", "/truth"]));
    for (format, out) in [(Format::Geojson, "map.geojson"), (Format::Kml, "map.kml")] {
        let done = desk.export(format, out).unwrap();
        let remark = done.remarks.last().unwrap();
        assert!(
            remark.ends_with("dive.mcap: no position: the map has no track"),
            "{remark}"
        );
    }
    let map = std::fs::read_to_string(desk.at("map.geojson")).unwrap();
    assert_eq!(lines_and_points(&layer(&map, "track")), [0, 0]);
    assert_eq!(layer(&map, "fence").len(), 2);
}

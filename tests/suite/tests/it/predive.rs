//! `backseat check` reports everything that would prevent a dive, with its place.

use backseat_suite::{Backseat, Mission};
use backseat_units::math::{cos, sin};

/// The output of a check of a mission that is not ready.
#[track_caller]
fn not_ready(mission: &Mission, arguments: &[&str]) -> String {
    let finished = Backseat::new()
        .arg("check")
        .mission(mission)
        .args(arguments)
        .run()
        .exit(1);
    assert!(finished.stdout.trim_end().ends_with("\nnot ready"), "{finished}");
    finished.stdout
}

/// The output of a check of a mission that is ready.
#[track_caller]
pub(crate) fn ready(mission: &Mission, arguments: &[&str]) -> String {
    let finished = Backseat::new()
        .arg("check")
        .mission(mission)
        .args(arguments)
        .run()
        .exit(0);
    assert!(finished.stdout.trim_end().ends_with("\nready"), "{finished}");
    finished.stdout
}

/// Requires one line that contains all of these.
#[track_caller]
pub(crate) fn has(said: &str, parts: &[&str]) {
    let told = said.lines().any(|line| parts.iter().all(|part| line.contains(part)));
    assert!(told, "no line with {parts:?} in:\n{said}");
}

/// The suite's mission with another zone in its fence.
fn with_zone(properties: &str, ring: &str) -> Mission {
    and_zone(Mission::steady(), properties, ring)
}

fn and_zone(mission: Mission, properties: &str, ring: &str) -> Mission {
    let zone = format!(
        r#"    {{"type": "Feature", "properties": {{{properties}}}, "geometry": {{"type": "Polygon", "coordinates": [[{ring}]]}}}},
    {{"type": "Feature", "properties": {{"name": "box""#
    );
    mission.edit(
        "fence.geojson",
        r#"    {"type": "Feature", "properties": {"name": "box""#,
        &zone,
    )
}

/// Some 80 to 250 m east of the middle, on the leg.
const ON_THE_LEG: &str =
    "[-70.699, 42.349], [-70.697, 42.349], [-70.697, 42.351], [-70.699, 42.351], [-70.699, 42.349]";

#[test]
fn missions_of_the_project_are_ready() {
    for name in ["isobath", "plume", "reinspect", "coverage"] {
        let said = ready(&Mission::copy(name), &[]);
        has(&said, &["plan: its start, all", "inside the fence"]);
    }
}

#[test]
fn a_leg_over_a_keep_out_zone_is_told_with_its_edge_and_metres() {
    let mission = with_zone(r#""name": "wreck", "kind": "keep-out", "margin_m": 5"#, ON_THE_LEG);
    has(
        &not_ready(&mission, &[]),
        &["plan element 1: ", "'wreck'", " edge ", " m"],
    );
    // Beside the leg, but closer than the vehicle's tracking error.
    let beside = "[-70.699, 42.3501], [-70.697, 42.3501], [-70.697, 42.351], [-70.699, 42.351], [-70.699, 42.3501]";
    let mission = with_zone(r#""name": "wreck", "kind": "keep-out", "margin_m": 8"#, beside);
    has(&not_ready(&mission, &[]), &["plan element 1: ", "'wreck'"]);
    let _ = ready(&mission, &["--set", "limits.tracking_error_m=1"]);
    // Above or below the leg's depth it is no obstacle.
    let deep = with_zone(
        r#""name": "wreck", "kind": "keep-out", "margin_m": 5, "depth_min_m": 20"#,
        ON_THE_LEG,
    );
    let _ = ready(&deep, &[]);
}

#[test]
fn a_zone_counts_at_the_time_of_the_leg() {
    // The dive begins at 08:00:02 and the leg is over within a quarter of an hour.
    let zone = |window: &str| {
        with_zone(
            &format!(r#""name": "convoy", "kind": "keep-out", "margin_m": 5, {window}"#),
            ON_THE_LEG,
        )
    };
    let at = ["--at", "2026-06-01T08:00:00Z"];
    let during = zone(r#""valid_from": "2026-06-01T08:10:00Z""#);
    has(&not_ready(&during, &at), &["plan element 1: ", "'convoy'"]);
    let _ = ready(&zone(r#""valid_from": "2026-06-01T09:00:00Z""#), &at);
    let _ = ready(&zone(r#""valid_until": "2026-06-01T07:59:00Z""#), &at);
    let closes = Mission::steady().edit(
        "fence.geojson",
        r#""name": "box","#,
        r#""name": "box", "valid_until": "2026-06-01T08:05:00Z","#,
    );
    has(
        &not_ready(&closes, &at),
        &["plan element 1: ", "box", "2026-06-01T08:05:00Z"],
    );
    let over = with_zone(
        r#""name": "harbour", "kind": "keep-in", "margin_m": 5, "depth_max_m": 30, "altitude_min_m": 3,
            "valid_until": "2026-05-31T08:00:00Z""#,
        ON_THE_LEG,
    );
    has(
        &not_ready(&over, &at),
        &["keep-in zone 'harbour': ", "until 2026-05-31T08:00:00Z", "expected"],
    );
}

#[test]
fn zones_that_come_and_go_count_today_and_on_the_day_of_the_simulation() {
    let zone = |window: &str| {
        with_zone(
            &format!(r#""name": "dredging", "kind": "keep-out", "margin_m": 5, {window}"#),
            ON_THE_LEG,
        )
    };
    let since = zone(r#""valid_from": "2026-06-02T00:00:00Z""#);
    let said = not_ready(&since, &[]);
    has(
        &said,
        &[
            "plan: checked for a dive that begins at 2026-06-01T08:00:00Z",
            "now",
            "--at",
        ],
    );
    has(&said, &["plan element 1: ", "'dredging'", "start of the dive: now"]);
    let until = zone(r#""valid_until": "2026-06-02T00:00:00Z""#);
    has(
        &not_ready(&until, &[]),
        &["'dredging'", "start of the dive: from world.toml"],
    );
    let _ = ready(&until, &["--at", "2027-01-01T00:00:00+01:00"]);
    let line = Backseat::new()
        .args(["check", "--at", "tomorrow"])
        .mission(&since)
        .run();
    assert_eq!(line.code, Some(2), "{line}");
    assert!(line.stderr.contains("2026-06-01T08:00:00Z"), "{line}");
}

/// A plan's file beside a mission.
fn plan_file(mission: &Mission, plan: &str) -> String {
    let file = mission.beside("plan.toml");
    std::fs::write(&file, plan).expect("the mission's folder can be written");
    file.display().to_string()
}

fn line(from: [i32; 2], to: [i32; 2], rest: &str) -> String {
    let [[a, b], [c, d]] = [from, to];
    format!(
        "[[plan]]\nkind = \"trackline\"\nstart = {{ east_m = {a}, north_m = {b} }}\nend = {{ east_m = {c}, north_m = {d} }}\n\
         depth_m = 8\nspeed_mps = 1.5\n{rest}\n"
    )
}

#[test]
fn a_time_limit_may_end_an_element_anywhere_on_it() {
    // From the middle of the first line, the path to the second leads across the zone.
    let zone = with_zone(
        r#""name": "reef", "kind": "keep-out", "margin_m": 5"#,
        "[-70.7005, 42.3518], [-70.699, 42.3518], [-70.699, 42.3522], [-70.7005, 42.3522], [-70.7005, 42.3518]",
    );
    let plan = |limit: &str| {
        let back = line([600, 500], [-600, 500], "");
        plan_file(&zone, &format!("{}{back}", line([-600, 0], [600, 0], limit)))
    };
    let _ = ready(&zone, &["--plan", &plan("")]);
    let _ = ready(&zone, &["--plan", &plan("timeout_s = 3600")]);
    let said = not_ready(&zone, &["--plan", &plan("timeout_s = 300")]);
    has(
        &said,
        &["plan element 2: ", "from a place where a time limit", "'reef'"],
    );
}

#[test]
fn the_way_down_is_judged() {
    let shallow = with_zone(
        r#""name": "lane", "kind": "keep-out", "margin_m": 1, "depth_max_m": 5"#,
        "[-70.7065, 42.349], [-70.7060, 42.349], [-70.7060, 42.351], [-70.7065, 42.351], [-70.7065, 42.349]",
    );
    let _ = ready(&shallow, &[]);
    let from = |mission: Mission, depth_m: u32| {
        mission.edit(
            "world.toml",
            "depth_m = 8\nheading_deg",
            &format!("depth_m = {depth_m}\nheading_deg"),
        )
    };
    has(&not_ready(&from(shallow, 0), &[]), &["plan element 1: ", "'lane'"]);
    has(
        &not_ready(&from(Mission::steady(), 45), &[]),
        &["plan element 1: ", "5.0 m deeper", "'box'"],
    );
}

#[test]
fn a_turn_needs_room() {
    // The zone's edge is 20 m beyond the end of the line and its margin, and a turn back is wider.
    let mission = Mission::steady();
    let plan = |east_m: i32| {
        let there = line([0, 0], [east_m, 0], "");
        plan_file(&mission, &format!("{there}{}", line([east_m, 30], [0, 30], "")))
    };
    let _ = ready(&mission, &["--plan", &plan(1400)]);
    let said = not_ready(&mission, &["--plan", &plan(1460)]);
    has(&said, &["plan element 2: turning to it: ", "'box'"]);
    assert!(!said.contains("plan element 1: "), "{said}");
}

#[test]
fn a_start_outside_and_depths_out_of_their_band_are_told() {
    let outside = Mission::steady().edit(
        "world.toml",
        "east_m = -600\nnorth_m = 0",
        "east_m = -1700\nnorth_m = 0",
    );
    has(&not_ready(&outside, &[]), &["start: ", "box"]);
    let excluded = with_zone(
        r#""name": "berth", "kind": "keep-out", "margin_m": 5"#,
        "[-70.708, 42.349], [-70.7065, 42.349], [-70.7065, 42.351], [-70.708, 42.351], [-70.708, 42.349]",
    );
    has(&not_ready(&excluded, &[]), &["start: ", "'berth'"]);
    let deep = Mission::steady().edit("fence.geojson", r#""depth_max_m": 40"#, r#""depth_max_m": 8.5"#);
    has(&not_ready(&deep, &[]), &["plan element 1: ", "0.5"]);
    let low = Mission::steady().edit("fence.geojson", r#""altitude_min_m": 3"#, r#""altitude_min_m": 37"#);
    has(&not_ready(&low, &[]), &["plan element 1: ", "altitude"]);
}

#[test]
fn a_circle_is_checked_on_its_whole_rim() {
    let circle = "[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 0, north_m = 0 }\nradius_m = 400\norbits = 1\ndepth_m = 8\nspeed_mps = 1.5\n\n[expect]";
    let _ = ready(&Mission::steady().edit("world.toml", "[expect]", circle), &[]);
    let wide = circle.replace("radius_m = 400", "radius_m = 790");
    has(
        &not_ready(&Mission::steady().edit("world.toml", "[expect]", &wide), &[]),
        &["plan element 3: ", "box", " edge "],
    );
}

#[test]
fn a_keep_in_zone_that_nobody_can_reach_is_told() {
    let island = "[-70.6650, 42.345], [-70.6550, 42.345], [-70.6550, 42.355], [-70.6650, 42.355], [-70.6650, 42.345]";
    let properties = r#""name": "island", "kind": "keep-in", "margin_m": 5, "depth_max_m": 30, "altitude_min_m": 3"#;
    has(
        &not_ready(&with_zone(properties, island), &[]),
        &["keep-in zone 'island': ", "cannot be reached"],
    );
    let joined = island.replace("-70.6650", "-70.6900");
    let _ = ready(&with_zone(properties, &joined), &[]);
    // At other depths than the zone that it overlaps.
    let under = properties.replace(r#""depth_max_m": 30"#, r#""depth_min_m": 45, "depth_max_m": 50"#);
    has(
        &not_ready(&with_zone(&under, &joined), &[]),
        &["keep-in zone 'island': ", "both allow"],
    );
    // Two keep-out zones together leave no room in it, though neither does alone.
    let half = |name: &str, mission: Mission, west: f64, east: f64| {
        let ring = format!("[{west}, 42.344], [{east}, 42.344], [{east}, 42.356], [{west}, 42.356], [{west}, 42.344]");
        and_zone(
            mission,
            &format!(r#""name": "{name}", "kind": "keep-out", "margin_m": 5"#),
            &ring,
        )
    };
    let beside = island.replace("-70.6650", "-70.6830");
    let eastern = || half("east", with_zone(properties, &beside), -70.67, -70.65);
    let _ = ready(&eastern(), &[]);
    has(
        &not_ready(&half("west", eastern(), -70.69, -70.6699), &[]),
        &["keep-in zone 'island': ", "keep-out zones", "no room"],
    );
}

#[test]
fn each_zone_is_told_with_its_size_and_place() {
    // A zone to keep out of that was meant to be a thousand times as large.
    let wreck = r#"]]]}},
    {"type": "Feature", "properties": {"name": "wreck", "kind": "keep-out", "margin_m": 1, "radius_m": 0.5},
        "geometry": {"type": "Point", "coordinates": [-70.7, 42.352]}}
  ]"#;
    let mission = Mission::steady().edit("fence.geojson", "]]]}}\n  ]", wreck);
    let said = ready(&mission, &[]);
    let zone = |name: &str| {
        said.lines()
            .find(|line| line.trim_start().starts_with(name))
            .unwrap_or_default()
    };
    assert!(
        zone("box: keep-in").contains(" m high around latitude 42.35000 longitude -70.70000"),
        "{said}"
    );
    assert!(
        zone("wreck: keep-out").contains("1 m wide and 1 m high around latitude 42.35200 longitude -70.70000"),
        "{said}"
    );
}

#[test]
fn limits_are_held_against_the_class() {
    for (limit, parts) in [
        (
            "limits.speed_max_mps=2.6",
            ["limits.speed_max_mps is 2.6", "2.5 m/s of a 12-inch vehicle"],
        ),
        (
            "limits.turn_rate_dps=12",
            ["limits.turn_rate_dps is 12", "10 degrees a second"],
        ),
        (
            "vehicle.class=hovering",
            ["limits.speed_max_mps is 2", "0.75 m/s of a hovering vehicle"],
        ),
    ] {
        let finished = Backseat::new()
            .args(["check", "--set", limit])
            .mission(&Mission::steady())
            .run();
        // A plan that the class cannot fly is invalid.
        if finished.code == Some(2) {
            assert!(
                finished.stderr.contains("plan element 1: speed_mps is 1.5"),
                "{finished}"
            );
            continue;
        }
        has(&finished.exit(1).stdout, &parts);
    }
    let deep = Mission::steady().edit("fence.geojson", r#""depth_max_m": 40"#, r#""depth_max_m": 300"#);
    has(
        &not_ready(&deep, &[]),
        &["keep-in zone 'box': depth_max_m is 300", "200 m of a 12-inch vehicle"],
    );
}

#[test]
fn a_plan_in_a_file_is_checked_in_the_worlds_place() {
    let mission = Mission::steady();
    let plan = mission.beside("plan.toml");
    let write = |north_m: f64| {
        let text = format!(
            "[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = 0, north_m = {north_m} }}\ndepth_m = 8\nspeed_mps = 1.5\n"
        );
        std::fs::write(&plan, text).unwrap();
    };
    write(100.0);
    let _ = ready(&mission, &["--plan", plan.to_str().unwrap()]);
    write(900.0);
    has(
        &not_ready(&mission, &["--plan", plan.to_str().unwrap()]),
        &["plan element 1: ", "box"],
    );
    std::fs::write(&plan, "[[plan]]\nkind = \"waypoint\"\nwhere = 3\n").unwrap();
    let line = Backseat::new()
        .args(["check", "--plan"])
        .arg(&plan)
        .mission(&mission)
        .run();
    assert_eq!(line.code, Some(2), "{line}");
    assert!(line.stderr.contains("plan.toml:3: unknown field `where`"), "{line}");
}

#[test]
fn what_would_keep_the_run_from_steering_is_told() {
    let mission = Mission::steady();
    let state = mission.beside("state");
    let arguments = ["--state", state.to_str().unwrap()];
    std::fs::create_dir(&state).unwrap();
    let _ = ready(&mission, &arguments);
    std::fs::write(state.join("hold"), "").unwrap();
    has(&not_ready(&mission, &arguments), &["hold: ", "exists"]);
    std::fs::remove_file(state.join("hold")).unwrap();
    std::fs::write(state.join("identifiers"), "many").unwrap();
    has(&not_ready(&mission, &arguments), &["identifiers", "expected a number"]);
    std::fs::remove_file(state.join("identifiers")).unwrap();
    has(
        &not_ready(&mission, &["--set", "vehicle.address=nowhere"]),
        &["vehicle.address", "HOST:PORT"],
    );
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = taken.local_addr().unwrap();
    let source = format!("[[external]]\nname = \"ctd\"\nlisten = \"{listen}\"\nsends = [\"BPCTD\"]\n");
    let with_external = Mission::steady().append("mission.toml", &source);
    has(&not_ready(&with_external, &[]), &["external source ctd: ", "in use"]);
    drop(taken);
    let _ = ready(&with_external, &[]);
}

#[test]
fn what_the_computer_lacks_is_told() {
    let mission = Mission::steady();
    let file = mission.beside("file");
    std::fs::write(&file, "").unwrap();
    let state = file.join("state");
    has(
        &not_ready(&mission, &["--state", state.to_str().unwrap()]),
        &["state: ", "file", "Not a directory"],
    );
    has(&not_ready(&mission, &["--log", "/proc/logs"]), &["logs: /proc"]);
    let from_the_future = std::time::UNIX_EPOCH + std::time::Duration::from_secs(4_000_000_000);
    let fence = std::fs::File::options()
        .write(true)
        .open(mission.path().join("fence.geojson"))
        .unwrap();
    fence.set_modified(from_the_future).unwrap();
    has(
        &not_ready(&mission, &[]),
        &["clock: fence.geojson was written ", "behind"],
    );
}

const PLAN_FENCE: &str = r#"{"fileType": "Plan", "groundStation": "QGroundControl", "version": 1, "geoFence": {"version": 2,
    "polygons": [{"inclusion": true, "version": 1,
        "polygon": [[42.3428, -70.7182], [42.3428, -70.6818], [42.3572, -70.6818], [42.3572, -70.7182]]}],
    "circles": [{"inclusion": false, "version": 1, "circle": {"center": [42.354, -70.7], "radius": 50}}]}}"#;

const KML_FENCE: &str = r#"<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
  <Placemark><name>box</name>
    <ExtendedData><Data name="kind"><value>keep-in</value></Data></ExtendedData>
    <Polygon><outerBoundaryIs><LinearRing><coordinates>
      -70.7182,42.3428 -70.6818,42.3428 -70.6818,42.3572 -70.7182,42.3572 -70.7182,42.3428
    </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>
  <Placemark><name>cable</name>
    <ExtendedData><Data name="kind"><value>keep-out</value></Data><Data name="half_width_m"><value>15</value></Data></ExtendedData>
    <LineString><coordinates>-70.715,42.356 -70.69,42.3555</coordinates></LineString></Placemark>
</Document></kml>"#;

const TABLE: &str = "[fence]\nmargin_m = 20\ndepth_max_m = 40\naltitude_min_m = 3\n";

fn with_fence(file: &str, text: &str) -> Mission {
    Mission::steady()
        .without("fence.geojson")
        .write(file, text)
        .append("mission.toml", TABLE)
}

#[test]
fn fences_of_qgroundcontrol_and_kml_are_flown_in_simulation() {
    let geojson = Mission::steady();
    let circle = r#""features": [
    {"type": "Feature", "properties": {"name": "buoy", "kind": "keep-out", "margin_m": 20, "radius_m": 50},
     "geometry": {"type": "Point", "coordinates": [-70.7, 42.354]}},"#;
    let missions = [
        geojson.edit("fence.geojson", r#""features": ["#, circle),
        with_fence("fence.plan", PLAN_FENCE),
        with_fence("fence.kml", KML_FENCE),
    ];
    for mission in missions {
        let _ = ready(&mission, &[]);
        let report = Backseat::new()
            .args(["sim", "--json"])
            .mission(&mission)
            .run()
            .exit(0)
            .json();
        assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
        assert!(report["requests"]["accepted"].as_u64() > Some(10), "{report}");
    }
}

#[track_caller]
fn refused(mission: &Mission, parts: &[&str]) {
    let line = Backseat::new().arg("check").mission(mission).run().refusal();
    for part in parts {
        assert!(line.contains(part), "no {part:?} in: {line}");
    }
}

#[test]
fn a_mission_has_one_fence_and_what_it_needs() {
    let two = Mission::steady().write("fence.kml", KML_FENCE);
    refused(&two, &["fence.geojson and fence.kml", "expected only one"]);
    refused(
        &Mission::steady().without("fence.geojson"),
        &["fence.geojson, fence.plan and fence.kml"],
    );
    let bare = Mission::steady()
        .without("fence.geojson")
        .write("fence.plan", PLAN_FENCE);
    refused(&bare, &["mission.toml", "[fence]", "margin_m", "fence.plan"]);
    let twice = Mission::steady().append("mission.toml", TABLE);
    refused(&twice, &["mission.toml", "[fence]", "fence.geojson"]);
    for (figure, wrong) in [
        ("margin_m = 20", "margin_m = nan"),
        ("margin_m = 20", "margin_m = -10"),
        ("altitude_min_m = 3", "altitude_min_m = 3\ndepth_min_m = nan"),
        ("depth_max_m = 40", "depth_max_m = inf"),
        ("altitude_min_m = 3", "altitude_min_m = 3\ndepth_min_m = 60"),
    ] {
        let table = TABLE.replace(figure, wrong);
        let mission = Mission::steady()
            .without("fence.geojson")
            .write("fence.plan", PLAN_FENCE)
            .append("mission.toml", &table);
        refused(&mission, &["mission.toml: fence.", "expected"]);
    }
    let unknown = with_fence("fence.plan", PLAN_FENCE).append("mission.toml", "depth_m = 3");
    refused(&unknown, &["mission.toml:", "unknown field `depth_m`"]);
    let broken = with_fence("fence.plan", &PLAN_FENCE.replace("-70.7182", "\"west\""));
    refused(&broken, &["fence.plan", "polygon 1"]);
    let broken = with_fence("fence.kml", &KML_FENCE.replace("42.3428 -70.6818,", "42.3428 east,"));
    refused(&broken, &["fence.kml", "box"]);
}

/// The same error in each file format.
#[test]
fn fences_that_are_none_are_refused_before_the_dive_with_the_place() {
    let geojson = |ring: &str| {
        Mission::steady().edit(
            "fence.geojson",
            "[[-70.7182, 42.3428], [-70.6818, 42.3428], [-70.6818, 42.3572], [-70.7182, 42.3572], [-70.7182, 42.3428]]",
            ring,
        )
    };
    let bow_tie =
        "[[-70.7182, 42.3428], [-70.6818, 42.3572], [-70.6818, 42.3428], [-70.7182, 42.3572], [-70.7182, 42.3428]]";
    refused(&geojson(bow_tie), &["fence.geojson", "'box'", "edge 1", "crosses"]);
    let plan = with_fence(
        "fence.plan",
        &PLAN_FENCE.replace(
            "[42.3428, -70.6818], [42.3572, -70.6818], [42.3572, -70.7182]",
            "[42.3572, -70.6818], [42.3428, -70.6818], [42.3572, -70.7182]",
        ),
    );
    refused(&plan, &["fence.plan", "polygon 1", "crosses"]);
    let kml = with_fence(
        "fence.kml",
        &KML_FENCE.replace(
            "-70.6818,42.3428 -70.6818,42.3572 -70.7182,42.3572",
            "-70.6818,42.3572 -70.6818,42.3428 -70.7182,42.3572",
        ),
    );
    refused(&kml, &["fence.kml", "'box'", "crosses"]);

    let around = "[[179.99, 42.3428], [-179.99, 42.3428], [-179.99, 42.3572], [179.99, 42.3572], [179.99, 42.3428]]";
    refused(&geojson(around), &["fence.geojson", "'box'", "antimeridian"]);
    let plan = with_fence(
        "fence.plan",
        &PLAN_FENCE.replace("-70.7182", "179.99").replace("-70.6818", "-179.99"),
    );
    refused(&plan, &["fence.plan", "polygon 1", "antimeridian"]);

    // Keep-in and keep-out exchanged.
    let inside_out = with_zone(
        r#""name": "sea", "kind": "keep-out", "margin_m": 5"#,
        "[-70.74, 42.33], [-70.66, 42.33], [-70.66, 42.37], [-70.74, 42.37], [-70.74, 42.33]",
    );
    refused(
        &inside_out,
        &["fence.geojson", "'box'", "wholly inside keep-out zone 'sea'"],
    );
    let outside_alone = with_fence(
        "fence.plan",
        &PLAN_FENCE.replace("\"inclusion\": true", "\"inclusion\": false"),
    );
    refused(&outside_alone, &["fence.plan", "keep-in"]);
    // The direction of a ring does not matter: clockwise or not, it is the same zone.
    let clockwise =
        "[[-70.7182, 42.3428], [-70.7182, 42.3572], [-70.6818, 42.3572], [-70.6818, 42.3428], [-70.7182, 42.3428]]";
    let _ = ready(&geojson(clockwise), &[]);

    let narrow = Mission::steady().edit("fence.geojson", r#""margin_m": 20"#, r#""margin_m": 900"#);
    refused(&narrow, &["fence.geojson", "'box'", "margin_m", "900"]);
}

/// A closed ring with this many vertices around the middle of the suite's mission, 1,200 m wide.
fn many(vertices: usize) -> String {
    let ring = (0..=vertices).map(|at| {
        let turn = std::f64::consts::TAU * (at % vertices) as f64 / vertices as f64;
        let radius = if at % 2 == 0 { 1.0 } else { 0.9999 };
        format!(
            "[{:.10},{:.10}]",
            -70.7 + 0.0182 * radius * cos(turn),
            42.35 + 0.0072 * radius * sin(turn)
        )
    });
    format!("[{}]", ring.collect::<Vec<_>>().join(","))
}

#[test]
fn a_million_vertices_are_loaded_in_time_or_refused() {
    let with = |vertices: usize| {
        Mission::steady().edit(
            "fence.geojson",
            "[[-70.7182, 42.3428], [-70.6818, 42.3428], [-70.6818, 42.3572], [-70.7182, 42.3572], [-70.7182, 42.3428]]",
            &many(vertices),
        )
    };
    // A million and one positions, the first repeated as the last.
    refused(&with(1_000_000), &["fence.geojson", "vertices", "1000000"]);
    // It ends within the time limit of a command.
    let _ = ready(&with(100_000), &[]);
}

#[test]
fn the_plan_that_was_checked_is_held_against_the_vehicles_own() {
    let plan = "[[plan]]\nkind = \"setpoint\"\nheading_deg = 90\nduration_s = 60\ndepth_m = 8\nspeed_mps = 1.5\n\n[[plan]]\nkind = \"command\"\ntext = \"sonar on\"\n\n[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 600, north_m = 200 }\nradius_m = 60\norbits = -0.5\nseparate_transit = true\ndepth_m = 8\nspeed_mps = 1.5\n\n[[plan]]\nkind = \"trackline\"\nstart = { east_m = 400, north_m = 300 }\nend = { east_m = 300, north_m = 300 }\nlead_in_m = 20\ndepth_m = 8\nspeed_mps = 1.5\ntimeout_s = 60\n\n[expect]";
    let mission = || Mission::steady().edit("world.toml", "[expect]", plan);
    let flown = |mission: &Mission| {
        let log = mission.beside("run.mcap");
        let finished = Backseat::new()
            .args(["sim", "--json", "--log"])
            .arg(&log)
            .mission(mission)
            .run();
        let report = finished.json();
        assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
        let read = backseat_recorder::read(&log).unwrap();
        let notes: Vec<String> = read.notes().map(|(_, text)| text.to_owned()).collect();
        let sent = report["requests"]["sent"].as_u64().unwrap();
        (sent, notes)
    };
    let same = mission().append("mission.toml", "[plan]\nfile = \"world.toml\"");
    let said = ready(&same, &[]);
    assert!(!said.contains("differs"), "{said}");
    let (sent, notes) = flown(&same);
    assert!(sent > 10, "{notes:#?}");

    let other = mission()
        .append("mission.toml", "[plan]\nfile = \"plan.toml\"")
        .write(
            "plan.toml",
            "[origin]\nlatitude_deg = 42.35\nlongitude_deg = -70.70\n\n[[plan]]\nkind = \"trackline\"\nstart = { east_m = -600, north_m = 0 }\nend = { east_m = 600, north_m = 15 }\ndepth_m = 8\nspeed_mps = 1.5\n",
        );
    has(&ready(&other, &[]), &["[[plan]] of world.toml differs from plan.toml"]);
    let (sent, notes) = flown(&other);
    assert_eq!(sent, 0, "{notes:#?}");
    assert!(
        notes
            .iter()
            .any(|note| note.contains("element 1: its point 2 is 15.0 m from the expected one")),
        "{notes:#?}"
    );
    refused(
        &mission().append("mission.toml", "[plan]\nfile = \"nowhere.toml\""),
        &["nowhere.toml", "No such file"],
    );
    refused(
        &mission().append("mission.toml", "[plan]\nfile = \"world.toml\"\ntolerance_m = -1"),
        &["plan.tolerance_m is -1", "expected"],
    );
}

#[test]
fn the_plan_is_checked_without_the_plugins() {
    let mission = Mission::steady().edit("mission.toml", "component = \"faulty\"", "component = \"missing\"");
    let said = not_ready(&mission, &[]);
    has(&said, &["no component `missing`", "--plugins", "BACKSEAT_PLUGINS"]);
    has(&said, &["plan:", "lie inside the fence"]);
}

#[test]
fn a_good_computer_has_a_line_of_its_own() {
    has(
        &ready(&Mission::steady(), &[]),
        &["this computer: ok", " free for logs"],
    );
}

#[test]
fn a_disk_without_room_for_the_dives_logs_is_told() {
    let mission = Mission::steady();
    let said = not_ready(&mission, &["--log-room", "900000GB"]);
    has(
        &said,
        &["logs: ", " are free, expected at least 900000 GB", "--log-room"],
    );
    // The option comes before the environment, in which the tests ask for little.
    has(&ready(&mission, &["--log-room", "2MB"]), &["this computer: ok"]);
}

#[test]
fn a_room_for_logs_has_a_unit() {
    let finished = Backseat::new()
        .arg("check")
        .mission(&Mission::steady())
        .args(["--log-room", "900"])
        .run()
        .exit(2);
    has(
        &finished.stderr,
        &["--log-room", "expected a whole number of GB or MB, such as 20GB"],
    );
}

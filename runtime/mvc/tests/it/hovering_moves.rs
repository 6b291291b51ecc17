//! How a suspended vehicle moves, and what it says about its position (SPI 6.17 to 6.19, 8.4 to 8.9).

use backseat_mvc::{Mvc, WorldFile};

use crate::hovering::{HARBOUR, hovering, keep};
use crate::payload::Payload;

/// The numbers of the newest sentence of this name, without its time.
fn newest(payload: &mut Payload, name: &str) -> Vec<f64> {
    let line = payload
        .heard()
        .into_iter()
        .rev()
        .find(|line| line.starts_with(name))
        .expect("the sentence came");
    line.split(',')
        .skip(2)
        .map(|field| field.parse().expect("a number"))
        .collect()
}

fn near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

fn fault(text: &str) -> String {
    WorldFile::from_toml(text).expect_err("the file is wrong").to_string()
}

#[test]
fn a_hull_position_is_reached_facing_the_hull() {
    // SPI 8.6. The starboard side faces south: right of it is east.
    let mut payload = Payload::connected(HARBOUR, 1, &["RNV", "CNV"]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 90.0, "$BPGHP,070000.000,-10,4,2");
    let (truth, hover) = (payload.mvc.truth(), hovering(&payload));
    assert!(
        near(truth.local.east_m, -10.0, 0.2) && near(truth.local.north_m, -7.0, 0.2),
        "{truth:?}"
    );
    assert!(near(truth.depth_m, 4.0, 0.1), "{truth:?}");
    assert!(
        near(hover.clearance_m.expect("a ship"), 2.0, 0.2) && hover.bearing_deg.abs() < 1.0,
        "{hover:?}"
    );
    // BFRNV and BFCNV (SPI 6.17 and 6.19) say the same.
    let said = payload.heard();
    let last = |name: &str| {
        let line = said.iter().rev().find(|line| line.starts_with(name)).expect("it came");
        line.split(',').map(str::to_owned).collect::<Vec<_>>()
    };
    let (rnv, cnv) = (last("$BFRNV"), last("$BFCNV"));
    let number = |text: &String| text.parse::<f64>().expect("a number");
    assert_eq!(rnv.len(), 11, "{rnv:?}");
    assert!(
        near(number(&rnv[2]), hover.y_m, 0.01) && near(number(&rnv[3]), truth.believed_depth_m, 0.001),
        "{rnv:?}"
    );
    assert!(
        near(number(&rnv[4]), 2.0, 0.2) && near(number(&rnv[5]), hover.bearing_deg, 0.01),
        "{rnv:?}"
    );
    assert!(near(number(&rnv[6]), truth.believed_depth_m, 0.001), "{rnv:?}");
    // The message and its solution have the same time, which is now.
    assert!(rnv[1] == "080130.000" && rnv[10] == "080130.000", "{rnv:?}");
    assert!(
        near(number(&cnv[2]), hover.x_m, 0.01) && near(number(&cnv[3]), hover.y_m, 0.01),
        "{cnv:?}"
    );
    assert!(near(number(&cnv[4]), truth.believed_depth_m, 0.001) && near(number(&cnv[5]), hover.bearing_deg, 0.01));
    let log = payload.log();
    assert_eq!(
        log.iter()
            .filter(|line| line.ends_with("arrived where it was sent"))
            .count(),
        1,
        "{log:?}"
    );
}

#[test]
fn the_port_side_counts_the_other_way() {
    let text = HARBOUR.replace("draft_m = 5", "draft_m = 5\nside = \"port\"").replace(
        "north_m = -12\ndepth_m = 3",
        "north_m = 12\ndepth_m = 3\nheading_deg = 180",
    );
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(2.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 60.0, "$BPGHP,070000.000,4,3,3");
    let truth = payload.mvc.truth();
    assert!(
        near(truth.local.east_m, -4.0, 0.2) && near(truth.local.north_m, 8.0, 0.2),
        "{truth:?}"
    );
    assert!(near(truth.heading_deg, 180.0, 1.0), "{truth:?}");
}

#[test]
fn the_direction_of_the_vertical_is_a_setting() {
    let text = format!("{HARBOUR}\n[interpretation]\nhull_vertical = \"up\"");
    let mut payload = Payload::connected(&text, 1, &["RNV", "ACK"]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    payload.say("$BPGHP,070000.000,0,4,3");
    assert!(
        payload
            .heard()
            .iter()
            .any(|line| line.ends_with("GHP,070000.000,0,1,0,the depth must be 0 to 60 m"))
    );
    keep(&mut payload, 60.0, "$BPGHP,070000.000,0,-4,3");
    assert!(near(payload.mvc.truth().depth_m, 4.0, 0.1));
    let rnv = payload
        .heard()
        .into_iter()
        .rfind(|line| line.starts_with("$BFRNV"))
        .expect("it came");
    let fields: Vec<&str> = rnv.split(',').collect();
    assert!(fields[3].starts_with("-4") || fields[3].starts_with("-3.9"), "{rnv}");
    assert!(!fields[6].starts_with('-'), "{rnv}");
}

#[test]
fn a_bottom_position_is_reached_by_depth_and_by_altitude() {
    // SPI 8.7.
    for (sentence, depth_m) in [
        ("$BPGBP,070000.000,-12,-6,D,8", 8.0),
        ("$BPGBP,070000.000,-12,-6,A,4", 11.0),
    ] {
        let mut payload = Payload::connected(HARBOUR, 1, &[]);
        payload.until(6.0);
        payload.say("$BPSUS,070000.000");
        let bearing_deg = hovering(&payload).bearing_deg;
        keep(&mut payload, 90.0, sentence);
        let (truth, hover) = (payload.mvc.truth(), hovering(&payload));
        assert!(near(hover.x_m, -12.0, 0.2) && near(hover.y_m, -6.0, 0.2), "{hover:?}");
        assert!(near(truth.depth_m, depth_m, 0.15), "{truth:?}");
        assert!(
            near(hover.bearing_deg, bearing_deg, 5.0),
            "it keeps its bearing: {hover:?}"
        );
    }
}

#[test]
fn a_suspended_vehicle_without_a_target_stays_at_its_place_in_a_current() {
    let text = format!("{HARBOUR}\n[current]\nspeed_mps = 0.2\ntowards_deg = 0");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(8.0);
    payload.say("$BPSUS,070000.000");
    let at = payload.mvc.truth().local;
    keep(&mut payload, 60.0, "$BPCON,070000.000");
    let truth = payload.mvc.truth();
    assert!(truth.local.distance_m(at) < 0.3, "{at:?} {truth:?}");
    assert!(near(truth.depth_m, 3.0, 0.2), "{truth:?}");
}

#[test]
fn the_speed_limit_is_kept_and_outlives_station_keeping() {
    // SPI 8.4: the limit is 1.5 m/s at first, and the vehicle is never faster than its own best, 0.75 m/s.
    let mut payload = Payload::connected(HARBOUR, 1, &[]);
    assert_eq!(hovering(&payload).speed_limit_mps, 1.5);
    let fastest = |payload: &mut Payload, from_s: u32, sentence: &str| {
        let mut fastest: f64 = 0.0;
        for second in from_s..from_s + 30 {
            payload.say(sentence);
            for tenth in 1..=10 {
                payload.until(f64::from(second) + f64::from(tenth) / 10.0);
                let truth = payload.mvc.truth();
                // In the first two seconds the vehicle slows down from the mission's speed.
                if second > from_s + 2 {
                    fastest = fastest.max(backseat_units::math::hypot(truth.east_mps, truth.north_mps));
                }
            }
        }
        fastest
    };
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    let best = fastest(&mut payload, 6, "$BPGBP,070000.000,-40,-20,D,3");
    assert!(best > 0.7 && best <= 0.7501, "{best}");
    payload.say("$BPSPD,070000.000,0.3");
    // The vehicle slows down first.
    keep(&mut payload, 39.0, "$BPCON,070000.000");
    let limited = fastest(&mut payload, 39, "$BPGBP,070000.000,-10,-20,D,3");
    assert!(limited > 0.25 && limited <= 0.3001, "{limited}");
    payload.say("$BPRES,070000.000");
    payload.until(100.0);
    payload.say("$BPSUS,070000.000");
    assert_eq!(hovering(&payload).speed_limit_mps, 0.3);
}

#[test]
fn the_vehicle_does_not_go_through_the_ship() {
    // To a target on the other side the vehicle stops at its own safety distance.
    let mut payload = Payload::connected(HARBOUR, 1, &[]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    let mut closest = f64::INFINITY;
    for second in 6..120 {
        payload.until(f64::from(second));
        payload.say("$BPGBP,070000.000,25,0,D,3");
        closest = closest.min(hovering(&payload).clearance_m.expect("a ship"));
    }
    assert!((0.499..0.55).contains(&closest), "{closest}");
    // A mission that leads through it is stopped too.
    let text = HARBOUR.replace(
        "end = { east_m = 25, north_m = -12 }",
        "end = { east_m = 0, north_m = 40 }",
    );
    let mut payload = Payload::connected(&text, 1, &[]);
    for second in 6..120 {
        payload.until(f64::from(second));
        assert!(hovering(&payload).clearance_m.expect("a ship") > 0.499);
    }
}

#[test]
fn the_vehicle_does_not_squeeze_itself_between_the_keel_and_the_bottom() {
    // The bottom rises towards the north, and leaves less than 2 m under the keel's southern edge, and nothing under its
    // northern one.
    let text = HARBOUR.replace(
        "depth_m = 15\nslope = 0",
        "depth_m = 6\nslope = 0.2\ndownslope_deg = 180",
    );
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    for second in 6..150 {
        payload.until(f64::from(second));
        payload.say("$BPGBP,070000.000,20,0,D,6");
        let (truth, hover) = (payload.mvc.truth(), hovering(&payload));
        assert!(truth.altitude_m > 0.8, "{truth:?}");
        assert!(hover.clearance_m.is_some_and(|metres| metres > 0.49), "{hover:?}");
    }
    // The vehicle did go under the ship.
    assert!(payload.mvc.truth().local.north_m > -5.5, "{:?}", payload.mvc.truth());
}

#[test]
fn a_reset_moves_relative_navigation_at_once_and_the_vehicle_after_it() {
    // SPI 8.8. The vehicle holds its place: the coordinates move, it does not.
    let mut payload = Payload::connected(HARBOUR, 1, &["RNV", "CNV"]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 40.0, "$BPGHP,070000.000,0,3,4");
    payload.say("$BPRNS,070000.000,-3,6,0");
    payload.until(40.2);
    let cnv = newest(&mut payload, "$BFCNV");
    assert!(near(cnv[0], -3.0, 0.1) && near(cnv[1], 6.0, 0.1), "{cnv:?}");
    payload.until(40.4);
    let rnv = newest(&mut payload, "$BFRNV");
    // The distance is measured, and did not change.
    assert!(near(rnv[0], 6.0, 0.15) && near(rnv[2], 4.0, 0.2), "{rnv:?}");
    // The same target 0 now takes the vehicle 6 m to the left in truth.
    keep(&mut payload, 90.0, "$BPGHP,070000.000,0,3,4");
    assert!(
        near(payload.mvc.truth().local.east_m, -6.0, 0.4),
        "{:?}",
        payload.mvc.truth()
    );
}

#[test]
fn a_reset_does_not_move_a_vehicle_that_holds_its_place() {
    let mut payload = Payload::connected(HARBOUR, 1, &[]);
    payload.until(8.0);
    keep(&mut payload, 20.0, "$BPSUS,070000.000");
    let before = payload.mvc.truth();
    payload.say("$BPRNS,070000.000,-30,12,45");
    payload.say("$BPRBO,070000.000,20");
    keep(&mut payload, 40.0, "$BPSUS,070000.000");
    let after = payload.mvc.truth();
    assert!(before.local.distance_m(after.local) < 0.1, "{before:?} {after:?}");
    assert!(near(before.heading_deg, after.heading_deg, 1.0), "{before:?} {after:?}");
}

#[test]
fn a_bearing_offset_adds_to_the_bearings_and_turns_the_vehicle_that_faces_the_hull() {
    // SPI 8.9.
    let mut payload = Payload::connected(HARBOUR, 1, &["RNV"]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 40.0, "$BPGHP,070000.000,0,3,4");
    let before = newest(&mut payload, "$BFRNV");
    payload.say("$BPRBO,070000.000,10");
    payload.until(40.2);
    let after = newest(&mut payload, "$BFRNV");
    // The relative and the inertial bearing change; the position does not.
    assert!(near(after[3] - before[3], 10.0, 1.5), "{before:?} {after:?}");
    let turned = (after[5] - before[5] + 360.0) % 360.0;
    assert!(near(turned, 10.0, 1.5), "{before:?} {after:?}");
    assert!(near(after[0], before[0], 0.02), "{before:?} {after:?}");
    keep(&mut payload, 60.0, "$BPGHP,070000.000,0,3,4");
    // The vehicle believes that it faces the hull, but points 10 degrees to the left of it in truth.
    assert!(
        near(hovering(&payload).bearing_deg, -10.0, 0.5),
        "{:?}",
        hovering(&payload)
    );
    assert!(near(newest(&mut payload, "$BFRNV")[3], 0.0, 0.5));
}

#[test]
fn an_error_of_the_bearing_turns_the_dead_reckoned_way() {
    // SPI 8.9: the way that the vehicle believes to be straight to the right leads away from the hull.
    let mut payload = Payload::connected(HARBOUR, 1, &["CNV"]);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 40.0, "$BPGBP,070000.000,-8,0,D,3");
    payload.say("$BPRBO,070000.000,-30");
    keep(&mut payload, 90.0, "$BPGBP,070000.000,-8,10,D,3");
    let (cnv, hover) = (newest(&mut payload, "$BFCNV"), hovering(&payload));
    assert!(near(cnv[0], -8.0, 0.2) && near(cnv[1], 10.0, 0.2), "{cnv:?}");
    // 10 m at 30 degrees: 5 m across and 8.66 m along.
    assert!(near(hover.x_m, -13.0, 0.3) && near(hover.y_m, 8.66, 0.3), "{hover:?}");
}

#[test]
fn no_message_announces_a_suspension() {
    // SPI 8.1 to 8.3 name no message: the mission is still `Running`, and control as it was.
    let mut payload = Payload::connected(HARBOUR, 1, &["MIS", "CTL", "MBS", "MBE"]);
    payload.until(6.0);
    payload.heard();
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 12.0, "$BPCON,070000.000");
    payload.say("$BPRES,070000.000");
    payload.until(20.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    assert!(payload.mvc.truth().control);
}

#[test]
fn sonar_and_dvl_turn_at_their_rate() {
    // SPI 6.18, 8.5: 30 degrees a second.
    let mut payload = Payload::connected(HARBOUR, 1, &["PIT"]);
    payload.until(6.0);
    assert_eq!(newest(&mut payload, "$BFPIT"), [-90.0, 0.0]);
    payload.say("$BPSAN,070000.000,60");
    payload.say("$BPSUS,070000.000");
    payload.say("$BPGHP,070000.000,0,3,4");
    payload.until(7.0);
    let halfway = newest(&mut payload, "$BFPIT");
    assert!(
        near(halfway[0], -60.0, 0.01) && near(halfway[1], 30.0, 0.01),
        "{halfway:?}"
    );
    // A command beyond the limits does not change the movement.
    payload.say("$BPSAN,070000.000,-91");
    payload.say("$BPCON,070000.000");
    payload.until(8.0);
    assert_eq!(newest(&mut payload, "$BFPIT"), [-30.0, 60.0]);
    // Once the payload has given the vehicle back, the DVL looks at the bottom again, because the mission flies by
    // that.
    payload.say("$BPRES,070000.000");
    payload.until(12.0);
    assert_eq!(newest(&mut payload, "$BFPIT"), [-90.0, 60.0]);
}

#[test]
fn each_message_comes_at_its_rate_and_only_if_there_is_something_to_say() {
    let count = |text: &str| {
        let mut payload = Payload::connected(text, 1, &["ALL"]);
        payload.until(10.0);
        let heard = payload.heard();
        ["$BFRNV", "$BFCNV", "$BFPIT"].map(|name| heard.iter().filter(|line| line.starts_with(name)).count())
    };
    assert_eq!(count(HARBOUR), [50, 50, 50]);
    let rates = HARBOUR.replace("[hovering]", "[hovering]\nrelative_hz = 2\nservo_hz = 100");
    assert_eq!(count(&rates), [20, 20, 100]);
    // Without a hull there is no target.
    let open = HARBOUR.split("[hovering.hull]").next().expect("a part").to_owned()
        + "[mission]\nstarts_after_s = 1\n[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 60\ndepth_m = 3\nspeed_mps = 0\n";
    assert_eq!(count(&open), [0, 50, 50]);
    // Torpedoes have none of them.
    assert_eq!(count(crate::files::CALM), [0, 0, 0]);
}

#[test]
fn without_a_ship_hull_positions_are_refused_and_bottom_positions_count_from_the_start() {
    let open = HARBOUR.split("[hovering.hull]").next().expect("a part").to_owned()
        + "[mission]\nstarts_after_s = 1\n[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 60\ndepth_m = 3\nspeed_mps = 0\n";
    let open = open.replace("depth_m = 3\n[origin]", "depth_m = 3\nheading_deg = 90\n[origin]");
    let mut payload = Payload::connected(&open, 1, &["ACK"]);
    payload.until(2.0);
    payload.say("$BPSUS,070000.000");
    payload.say("$BPGHP,070000.000,0,3,4");
    assert!(
        payload
            .heard()
            .contains(&"$BFACK,080002.000,GHP,070000.000,0,1,0,there is no hull".to_owned())
    );
    // The vehicle pointed east: x is east, y is south.
    keep(&mut payload, 60.0, "$BPGBP,070000.000,5,2,D,4");
    let truth = payload.mvc.truth();
    assert!(
        near(truth.local.east_m, 5.0, 0.2) && near(truth.local.north_m, -14.0, 0.2),
        "{truth:?}"
    );
}

#[test]
fn relative_navigation_drifts_with_the_seed_and_the_distance_does_not() {
    let text = HARBOUR.replace("drift_m_per_sqrt_h = 0", "drift_m_per_sqrt_h = 20");
    let drift = |seed| {
        let mut payload = Payload::connected(&text, seed, &["RNV"]);
        payload.until(6.0);
        payload.say("$BPSUS,070000.000");
        keep(&mut payload, 200.0, "$BPGHP,070000.000,0,3,4");
        let (rnv, hover) = (newest(&mut payload, "$BFRNV"), hovering(&payload));
        assert!(
            near(rnv[2], hover.clearance_m.expect("a ship"), 0.01),
            "{rnv:?} {hover:?}"
        );
        rnv[0] - hover.y_m
    };
    let (one, two) = (drift(1), drift(2));
    assert!(
        one.abs() > 0.05 && two.abs() > 0.05 && (one - two).abs() > 0.05,
        "{one} {two}"
    );
    assert_eq!(one, drift(1));
}

#[test]
fn an_impossible_ship_is_refused_at_the_start() {
    for (from, to, expected) in [
        (
            "draft_m = 5",
            "draft_m = 50",
            "hovering.hull.draft_m is 50, expected 0.5 to 40 m",
        ),
        (
            "class = \"hovering\"",
            "class = \"12-inch\"",
            "vehicle.class is \"12-inch\", expected \"hovering\" with a [hovering.hull]",
        ),
        (
            "[hovering]\n",
            "[hovering]\nsonar_max_deg = -100\n",
            "hovering.sonar_min_deg is -90, expected -180 to sonar_max_deg",
        ),
        (
            "[hovering]\n",
            "[hovering]\nsafety_m = 0\n",
            "hovering.safety_m is 0, expected 0.1 to 10 m",
        ),
    ] {
        assert!(HARBOUR.contains(from));
        assert_eq!(fault(&HARBOUR.replace(from, to)), expected);
    }
    let inside = fault(&HARBOUR.replace("north_m = -12\ndepth_m", "north_m = -5.2\ndepth_m"));
    assert!(
        inside.starts_with("start: the distance from hovering.hull in metres is 0.2"),
        "{inside}"
    );
    let unknown = fault(&HARBOUR.replace("beam_m", "width_m"));
    assert!(unknown.contains("unknown field `width_m`"), "{unknown}");
}

#[test]
fn a_file_without_the_hovering_section_has_its_defaults() {
    let file = WorldFile::from_toml(crate::files::CALM).expect("the file is right");
    assert_eq!(file.hovering, backseat_mvc::HoveringConfig::default());
    assert!(Mvc::new(&file, 1).is_ok());
}

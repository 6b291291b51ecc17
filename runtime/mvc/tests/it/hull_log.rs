//! The DVL of a hovering vehicle and its servo: ranges, velocities, lock, BFPIT and BFRNV are one geometry, at the hull
//! and over the bottom (SPI 6.13, 6.14, 6.17, 6.18, 8.6).

use backseat_units::math::{cos, sin};

use crate::fields::{field, number, of};
use crate::hovering::{HARBOUR, hovering, keep};
use crate::payload::Payload;

/// The harbour with a DVL without noise.
fn harbour(more: &str) -> String {
    format!(
        "{HARBOUR}\n[sensors]\naltitude_dropouts_per_h = 0\n[sensors.dvl]\nscale_error = 0\nmisalignment_deg = 0\n\
         velocity_noise_mps = 0\nrange_noise_m = 0\nbeam_loss = 0\n{more}"
    )
}

const ALL: [&str; 6] = ["PIT", "DVL", "DV2", "RNV", "NVG", "NVR"];

/// At the hull from 6 s on: on its middle, 3 m deep, at a distance of 2 m.
fn at_hull(more: &str, until_s: f64) -> Payload {
    let mut payload = Payload::connected(&harbour(more), 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, until_s, "$BPGHP,070000.000,0,3,2");
    payload
}

/// The newest line of this name.
fn newest(lines: &[String], name: &str) -> String {
    of(lines, name).pop().unwrap_or_else(|| panic!("no {name}"))
}

fn near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

/// The beams of a DVL, as unit vectors ahead, to starboard and down: 30 degrees from its axis, which looks this many
/// degrees above the horizontal.
fn beams(look_deg: f64) -> [[f64; 3]; 4] {
    let (out, along) = (sin(30.0_f64.to_radians()), cos(30.0_f64.to_radians()));
    let tilt = (look_deg + 90.0).to_radians();
    [45.0_f64, 135.0, 225.0, 315.0].map(|azimuth| {
        let (ahead, starboard) = (out * cos(azimuth.to_radians()), out * sin(azimuth.to_radians()));
        [
            ahead * cos(tilt) + along * sin(tilt),
            starboard,
            along * cos(tilt) - ahead * sin(tilt),
        ]
    })
}

// SPI 8.6: "Distance from the hull"; 6.17: "Distance from target"; 6.18: "DVL position, in degrees"; 6.13: "Beam
// ranges".
#[test]
fn at_the_hull_the_beams_end_at_the_hull() {
    let mut payload = at_hull("", 90.0);
    let lines = payload.heard();
    let hover = hovering(&payload);
    let clearance_m = hover.clearance_m.expect("a ship");
    assert!(
        near(clearance_m, 2.0, 0.2) && hover.bearing_deg.abs() < 1.0,
        "{hover:?}"
    );
    assert_eq!(number(&newest(&lines, "BFPIT"), 2), 0.0);
    assert!(near(number(&newest(&lines, "BFRNV"), 4), clearance_m, 0.02));
    let (dvl, extended) = (newest(&lines, "BFDVL"), newest(&lines, "BFDV2"));
    for beam in 0..4 {
        let range_m = clearance_m / beams(0.0)[beam][0];
        assert!(near(number(&dvl, 5 + beam), range_m, 0.03), "{dvl} {range_m}");
        assert_eq!(field(&dvl, 5 + beam), field(&extended, 6 + beam));
    }
    // The altitude comes from the altimeter, which looks down.
    let altitude_m = payload.mvc.truth().altitude_m;
    assert!(near(number(&newest(&lines, "BFNVG"), 7), altitude_m, 0.5));
}

#[test]
fn over_the_bottom_the_beams_end_at_the_bottom() {
    let mut payload = Payload::connected(&harbour(""), 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 60.0, "$BPCON,070000.000");
    let lines = payload.heard();
    assert_eq!(number(&newest(&lines, "BFPIT"), 2), -90.0);
    let dvl = newest(&lines, "BFDVL");
    // The ship is 7 m away, and no beam reaches so far to the side before it reaches the bottom.
    let range_m = payload.mvc.truth().altitude_m / cos(30.0_f64.to_radians());
    for beam in 0..4 {
        assert!(near(number(&dvl, 5 + beam), range_m, 0.05), "{dvl} {range_m}");
    }
}

// SPI 6.13: "X velocity (m/s) positive is forward"; 6.14: "beam velocities, not vehicle velocities. Currently this is
// the HAUV only."
#[test]
fn velocities_are_along_the_beams_where_the_servo_has_turned_them() {
    // On its way to the hull, with the DVL turned to it, it moves ahead.
    let mut payload = Payload::connected(&harbour(""), 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    for (until_s, look_deg) in [(7.6, -40.0), (11.0, 0.0)] {
        keep(&mut payload, until_s, "$BPGHP,070000.000,0,3,2");
        let lines = payload.heard();
        assert!(near(number(&newest(&lines, "BFPIT"), 2), look_deg, 3.1), "{look_deg}");
        let (dvl, extended) = (newest(&lines, "BFDVL"), newest(&lines, "BFDV2"));
        let velocity = [2, 3, 4].map(|index| number(&dvl, index));
        let truth = payload.mvc.truth();
        let (sin, cos) = backseat_units::math::sin_cos(truth.heading_deg.to_radians());
        let ahead_mps = truth.north_mps * cos + truth.east_mps * sin;
        let starboard_mps = truth.east_mps * cos - truth.north_mps * sin;
        assert!(
            near(velocity[0], ahead_mps, 0.02) && near(velocity[1], starboard_mps, 0.02),
            "{dvl} {truth:?}"
        );
        // BFPIT comes twice a second or less often, so the beams are tried at the angles around it.
        let fits = |look_deg: f64| {
            beams(look_deg).iter().enumerate().all(|(index, beam)| {
                let along_mps: f64 = beam.iter().zip(velocity).map(|(part, mps)| part * mps).sum();
                near(number(&extended, 2 + index), along_mps, 0.005)
            })
        };
        let servo_deg = number(&newest(&lines, "BFPIT"), 2);
        assert!(
            (0..=60).any(|step| fits((servo_deg + f64::from(step) * 0.5).min(0.0))),
            "{extended} {velocity:?}"
        );
    }
}

// A DVL that does not measure the hull cannot tell its distance: then the vehicle reckons it (6.17: "relative to an
// initial position").
#[test]
fn without_the_dvl_the_distance_is_reckoned() {
    let drifting = |text: String| text.replace("\ndrift_m_per_sqrt_h = 0", "\ndrift_m_per_sqrt_h = 20");
    let text = drifting(harbour(
        "[[faults.fault]]\nat_s = 60\nfor_s = 20\nkind = \"sensor_dropout\"\nsensor = \"dvl\"\n",
    ));
    let mut payload = Payload::connected(&text, 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    let off_m = |payload: &mut Payload| {
        let lines = payload.heard();
        let said_m = number(&newest(&lines, "BFRNV"), 4);
        let readings = of(&lines, "BFDVL").len();
        (said_m - hovering(payload).clearance_m.expect("a ship"), readings)
    };
    keep(&mut payload, 59.5, "$BPGHP,070000.000,0,3,2");
    let (before_m, _) = off_m(&mut payload);
    assert!(before_m.abs() < 0.01, "{before_m}");
    keep(&mut payload, 61.0, "$BPGHP,070000.000,0,3,2");
    payload.heard();
    keep(&mut payload, 79.5, "$BPGHP,070000.000,0,3,2");
    let (dead_m, readings) = off_m(&mut payload);
    assert!(dead_m.abs() > 0.05 && readings == 0, "{dead_m} {readings}");
    keep(&mut payload, 110.0, "$BPGHP,070000.000,0,3,2");
    let (after_m, _) = off_m(&mut payload);
    assert!(after_m.abs() < 0.01, "{after_m}");
}

// Beyond the end of the ship a DVL that is turned to it finds nothing ahead: too few beams, no velocity, no lock.
#[test]
fn beyond_the_end_of_the_hull_there_is_no_lock() {
    let mut payload = Payload::connected(&harbour(""), 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 200.0, "$BPGHP,070000.000,36,3,2");
    let lines = payload.heard();
    let dvl = newest(&lines, "BFDVL");
    assert_eq!(number(&newest(&lines, "BFPIT"), 2), 0.0);
    assert!((2..5).all(|index| field(&dvl, index).is_empty()), "{dvl}");
    assert!((5..9).all(|index| field(&dvl, index).is_empty()), "{dvl}");
    assert!(payload.log().iter().any(|line| line.ends_with("bottom lock lost")));
    // Back in the mission, the DVL looks down again and has lock.
    payload.say("$BPRES,070000.000");
    payload.until(205.0);
    let lines = payload.heard();
    assert_eq!(number(&newest(&lines, "BFPIT"), 2), -90.0);
    assert!((5..9).all(|beam| number(&newest(&lines, "BFDVL"), beam) > 10.0));
}

// The ranges end with the reach of the DVL, and so does the distance.
#[test]
fn beyond_its_reach_the_hull_has_neither_ranges_nor_a_distance() {
    let text = harbour("").replace("[hovering]\n", "[hovering]\nrange_max_m = 3\n");
    let mut payload = Payload::connected(&text, 1, &ALL);
    payload.until(6.0);
    payload.say("$BPSUS,070000.000");
    keep(&mut payload, 60.0, "$BPGHP,070000.000,0,3,5");
    let lines = payload.heard();
    let dvl = newest(&lines, "BFDVL");
    assert!((5..9).all(|index| field(&dvl, index).is_empty()), "{dvl}");
    keep(&mut payload, 120.0, "$BPGHP,070000.000,0,3,2");
    let lines = payload.heard();
    assert!((5..9).all(|beam| number(&newest(&lines, "BFDVL"), beam) < 3.0));
}

//! Faults of the navigation messages (SPI 6.1, 6.2): the vehicle is well, but its messages are wrong.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_mvc::Truth;

use crate::files::CALM;
use crate::payload::Payload;

/// A minute of latitude, metres.
const MINUTE_M: f64 = 1852.0;

/// The BFNVG and the BFNVR of a step, as far as these tests need them.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    /// The minutes of the latitude; `place` has the fields of the whole position as they are written.
    minutes: f64,
    place: String,
    depth_m: f64,
    heading_deg: f64,
    solution: String,
    velocity: Option<String>,
}

/// What the vehicle says from 2 s to 12 s in steps of 0.1 s, and the truth at the end, with this fault from 4 s to 10
/// s.
fn said(fault: &str) -> (Vec<Said>, Truth) {
    let section = if fault.is_empty() {
        String::new()
    } else {
        let fault = fault.replace("; ", "\n");
        format!("[[faults.fault]]\nat_s = 3.95\nfor_s = 6\n{fault}\n")
    };
    let mut payload = Payload::connected(&format!("{CALM}\n{section}"), 1, &["NVG", "NVR"]);
    payload.until(1.95);
    payload.heard();
    payload.until(11.95);
    let mut all: Vec<Said> = Vec::new();
    for line in payload.heard() {
        let fields: Vec<&str> = line.split(',').collect();
        if line.starts_with("$BFNVG") {
            all.push(Said {
                minutes: fields[2][2..].parse().unwrap(),
                place: fields[2..6].join(","),
                depth_m: fields[8].parse().unwrap(),
                heading_deg: fields[9].parse().unwrap(),
                solution: fields.last().unwrap().to_string(),
                velocity: None,
            });
        } else if let Some(said) = all.last_mut() {
            said.velocity = Some(fields[2..].join(","));
        }
    }
    assert_eq!(all.len(), 100, "{fault}");
    (all, payload.mvc.truth())
}

/// What the vehicle says without and with a fault, in pairs, while the fault acts. Checks that both say the same before
/// and after it, and that the fault does not move the vehicle.
fn beside(fault: &str) -> Vec<(Said, Said)> {
    let ((well, truth), (ill, as_true)) = (said(""), said(fault));
    assert_eq!(truth, as_true, "{fault}");
    assert_eq!((&well[..20], &well[80..]), (&ill[..20], &ill[80..]), "{fault}");
    well.into_iter().zip(ill).take(80).skip(20).collect()
}

#[test]
fn the_position_creeps_while_the_velocity_stays_that_of_the_vehicle() {
    for (number, (well, ill)) in beside("kind = \"position_creep\"; speed_mps = 2; towards_deg = 180")
        .iter()
        .enumerate()
    {
        let off_m = (ill.minutes - well.minutes) * MINUTE_M;
        let expected_m = -0.2 * (number + 1) as f64;
        assert!((off_m - expected_m).abs() < 0.03, "{off_m} {expected_m}");
        assert_eq!((&well.velocity, &well.solution), (&ill.velocity, &ill.solution));
    }
}

#[test]
fn the_position_is_frozen_to_its_last_digit_while_the_solutions_time_goes_on() {
    let pairs = beside("kind = \"position_frozen\"");
    let first = pairs[0].1.place.clone();
    assert_eq!(first, pairs[0].0.place);
    for (well, ill) in pairs {
        assert_eq!(ill.place, first);
        assert_eq!((well.velocity, well.solution), (ill.velocity, ill.solution));
    }
}

#[test]
fn the_position_goes_back_as_far_as_the_vehicle_goes_ahead() {
    let pairs = beside("kind = \"position_backwards\"");
    let way_m = |from: f64, to: f64| (to - from) * MINUTE_M;
    let (first, last) = (&pairs[0], &pairs[pairs.len() - 1]);
    let ahead_m = way_m(first.0.minutes, last.0.minutes);
    let back_m = way_m(first.1.minutes, last.1.minutes);
    assert!(
        ahead_m.abs() > 3.0 && (ahead_m + back_m).abs() < 0.1,
        "{ahead_m} {back_m}"
    );
    assert_eq!(last.0.velocity, last.1.velocity);
}

#[test]
fn velocities_are_missing_while_positions_continue() {
    for (well, ill) in beside("kind = \"velocity_missing\"") {
        assert_eq!(ill.velocity, None);
        assert!(well.velocity.is_some());
        assert_eq!((well.place, well.solution), (ill.place, ill.solution));
    }
}

#[test]
fn heading_and_depth_flip_at_every_other_step() {
    for (number, (well, ill)) in beside("kind = \"heading_flip\"; by_deg = -90").iter().enumerate() {
        let turned = if number % 2 == 0 { 270.0 } else { 0.0 };
        let by_deg = (ill.heading_deg - well.heading_deg).rem_euclid(360.0);
        assert!((by_deg - turned).abs() < 0.01, "step {number}: {by_deg}");
        assert_eq!((&well.place, well.depth_m), (&ill.place, ill.depth_m));
    }
    for (number, (well, ill)) in beside("kind = \"depth_flip\"; by_m = 12.5").iter().enumerate() {
        let by_m = if number % 2 == 0 { 12.5 } else { 0.0 };
        assert!((ill.depth_m - well.depth_m - by_m).abs() < 0.01, "step {number}");
        assert_eq!((&well.place, well.heading_deg), (&ill.place, ill.heading_deg));
    }
}

/// The world of [`CALM`] with another dive at 5 s.
fn diving(reversed: bool) -> Payload {
    let fault = format!(
        "[[faults.fault]]\nkind = \"another_dive\"\nat_s = 5\ndive_file = \"other.dive\"\nreversed = {reversed}\n"
    );
    let mut payload = Payload::connected(&format!("{CALM}\n{fault}"), 1, &["MIS", "MBS", "MBE", "CTL"]);
    payload.until(4.95);
    payload.heard();
    payload.until(5.4);
    payload
}

// SPI 6.9 and 6.11: BFMBS and BFMIS name the dive file.
#[test]
fn another_dive_may_be_the_same_plan_under_another_name() {
    let mut payload = diving(false);
    assert_eq!(payload.heard(), ["$BFMIS,080005.000,other.dive,Running /logs/survey,"]);
    let before = payload.mvc.truth();
    assert!(before.control);
}

#[test]
fn another_dive_ends_the_current_behavior_and_begins_its_own_plan_during_the_mission() {
    let mut payload = diving(true);
    let plan = |payload: &Payload| payload.mvc.plan_points();
    let whole = {
        let payload = Payload::connected(CALM, 1, &[]);
        plan(&payload)
    };
    assert_eq!(
        payload.heard(),
        [
            "$BFMBE,080005.000,survey.dive,1,,trackline",
            "$BFMIS,080005.000,other.dive,Running /logs/survey,",
            "$BFMBS,080005.000,other.dive,1,,waypoint",
            "$BFCTL,080005.000,0",
        ]
    );
    let reversed = plan(&payload);
    assert_eq!(reversed.len(), whole.len());
    let places = |points: &[(Option<u32>, backseat_units::Position)]| -> Vec<backseat_units::Position> {
        points.iter().map(|(_, place)| *place).collect()
    };
    let mut back = places(&reversed);
    back.reverse();
    assert_eq!(back, places(&whole));
}

//! SR-024: navigation that cannot be true steers nothing.

use std::time::Duration;

use backseat_core::Note;
use backseat_core::plugin::Request;
use backseat_spi::{Navigation, PositionQuality, VelocityAndRates};
use backseat_units::{Altitude, Depth, EastNorth, Heading, TimeOfDay, Timestamp, utm_convergence_deg};

use crate::course::{self, modify};
use crate::trial::Trial;

/// A way in which the vehicle's navigation goes wrong, from a figure and the seconds since it began to. False means
/// that no BFNVR is sent.
type Wrong = fn(f64, f64, &mut Navigation, &mut VelocityAndRates) -> bool;

fn move_by(navigation: &mut Navigation, by: EastNorth) {
    let frame = *course::fence().frame();
    navigation.position = frame.to_position(frame.to_local(navigation.position) + by);
}

fn head(navigation: &mut Navigation, degrees: f64) {
    let heading = Heading::from_deg(degrees.rem_euclid(360.0)).unwrap();
    navigation.heading = heading.to_grid(utm_convergence_deg(navigation.position));
}

/// Whether the sample of this time is an even one, at 10 Hz.
fn is_even(since_s: f64) -> bool {
    ((since_s * 10.0).round() as u64).is_multiple_of(2)
}

/// The position creeps away from what the velocity says, at `figure` m/s.
fn creeps(figure: f64, since_s: f64, navigation: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    move_by(navigation, EastNorth::new(0.0, figure * since_s));
    true
}

/// The position stands still while the velocity says `figure` m/s.
fn freezes(figure: f64, since_s: f64, navigation: &mut Navigation, velocity: &mut VelocityAndRates) -> bool {
    move_by(navigation, EastNorth::new(-1.5 * since_s, 0.0));
    velocity.east_mps = figure;
    // The position stays the same to its last digit.
    let frame = *course::fence().frame();
    let place = frame.to_local(navigation.position);
    navigation.position = frame.to_position(EastNorth::new(place.east_m.round(), 0.0));
    true
}

/// The position goes backwards at `figure` m/s while the velocity goes on.
fn backs(figure: f64, since_s: f64, navigation: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    move_by(navigation, EastNorth::new(-(1.5 + figure) * since_s, 0.0));
    true
}

/// The velocity itself is `figure` m/s, and the position follows it.
fn races(figure: f64, since_s: f64, navigation: &mut Navigation, velocity: &mut VelocityAndRates) -> bool {
    velocity.east_mps = figure;
    move_by(navigation, EastNorth::new((figure - 1.5) * since_s, 0.0));
    true
}

/// The heading jumps to and fro by `figure` degrees at each sample.
fn flips(figure: f64, since_s: f64, navigation: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    let even = is_even(since_s);
    head(navigation, if even { 90.0 } else { 90.0 + figure });
    true
}

/// The depth jumps to and fro by `figure` metres at each sample.
fn heaves(figure: f64, since_s: f64, navigation: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    let even = is_even(since_s);
    let (depth_m, altitude_m) = if even {
        (20.0, 70.0)
    } else {
        (20.0 + figure, 70.0 - figure)
    };
    navigation.depth = Depth::from_m(depth_m).unwrap();
    navigation.altitude = Some(Altitude::from_m(altitude_m).unwrap());
    true
}

/// The vehicle sends no BFNVR.
fn withholds(_: f64, _: f64, _: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    false
}

/// Each BFNVR is two seconds old.
fn lags(_: f64, _: f64, _: &mut Navigation, velocity: &mut VelocityAndRates) -> bool {
    let nanos = velocity.created.as_nanos() - 2_000_000_000;
    velocity.created = TimeOfDay::from_nanos(nanos).unwrap();
    true
}

/// Depth plus altitude steps to and fro by `figure` metres.
fn steps(figure: f64, since_s: f64, navigation: &mut Navigation, _: &mut VelocityAndRates) -> bool {
    let even = is_even(since_s);
    navigation.altitude = Some(Altitude::from_m(if even { 70.0 } else { 70.0 - figure }).unwrap());
    true
}

/// How many seconds after navigation goes wrong the lease ends; `None` if it goes on for half a minute.
fn ends_after_s(wrong: Wrong, figure: f64) -> Option<f64> {
    let mut trial = Trial::steering();
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
    trial.run_for(5.0);
    let began = trial.now;
    trial.vehicle.bend = Some(Box::new(move |now: Timestamp, navigation: &mut _, velocity: &mut _| {
        wrong(figure, now.since(began).as_secs_f64(), navigation, velocity)
    }));
    trial.run_for(30.0);
    let ended = trial.sent_since("EMB", began).first().copied();
    if let Some(ended) = ended {
        // While navigation is wrong, nothing steers again.
        let steered = trial.sent_since("RMB", ended + Duration::from_millis(1));
        assert!(
            steered.is_empty(),
            "{figure}: {:?} {:?}",
            steered.first(),
            trial.lease_ends()
        );
        assert!(!trial.core.has_control());
    }
    ended.map(|ended| ended.since(began).as_secs_f64())
}

#[test]
fn sr_024_each_kind_of_wrong_navigation_ends_the_lease() {
    let cases: [(&str, Wrong, f64, f64); 8] = [
        ("creeping 9 m a sample", creeps, 90.0, 2.0),
        ("frozen under 1.5 m/s", freezes, 1.5, 12.0),
        ("backwards against BFNVR", backs, 1.5, 8.0),
        ("no BFNVR", withholds, 0.0, 2.0),
        ("BFNVR of another time", lags, 0.0, 2.0),
        ("heading turned by 180 degrees at each sample", flips, 180.0, 2.0),
        ("depth between 20 and 50 m at each sample", heaves, 30.0, 2.0),
        ("a velocity of 30 m/s", races, 30.0, 2.0),
    ];
    for (name, wrong, figure, within_s) in cases {
        let after_s = ends_after_s(wrong, figure);
        assert!(
            after_s.is_some_and(|after_s| after_s <= within_s),
            "{name}: {after_s:?}"
        );
    }
}

#[test]
fn sr_024_each_flaw_has_its_limit() {
    // With the default limits: a figure under the limit, and one just over it.
    let cases: [(&str, Wrong, f64, f64); 6] = [
        ("creeping", creeps, 1.3, 1.45),
        ("frozen", freezes, 0.29, 0.31),
        ("backwards", backs, 1.0, 1.5),
        ("racing", races, 4.8, 5.2),
        ("flipping", flips, 60.0, 61.5),
        ("heaving", heaves, 5.0, 5.6),
    ];
    for (name, wrong, under, over) in cases {
        if name != "backwards" && name != "creeping" && name != "frozen" {
            assert_eq!(ends_after_s(wrong, under / 2.0), None, "{name}, half");
            assert_eq!(ends_after_s(wrong, under), None, "{name}, just under");
        }
        assert!(ends_after_s(wrong, over).is_some(), "{name}, just over");
    }
    // The limit of position against velocity is 10 m and 0.3 m/s over 9.5 s, which makes 1.35 m/s.
    for (drift, ends) in [(0.67, false), (1.3, false), (1.45, true)] {
        assert_eq!(ends_after_s(creeps, drift).is_some(), ends, "{drift} m/s");
    }
    // A vehicle of under 0.3 m/s may be standing still, so a frozen position is no flaw there.
    assert_eq!(ends_after_s(freezes, 0.0), None);
    assert!(ends_after_s(steps, 14.5).is_none() && ends_after_s(steps, 30.0).is_some());
}

#[test]
fn sr_024_a_true_gps_fix_is_no_flaw_but_counts_as_unsteady() {
    for metres in [5.0, 15.0, 200.0] {
        let mut trial = Trial::under_way();
        trial.vehicle.bend = Some(Box::new(
            move |now: Timestamp, navigation: &mut Navigation, _: &mut _| {
                navigation.depth = Depth::from_m(0.5).unwrap();
                navigation.altitude = None;
                if now >= Timestamp::from_secs(20) {
                    move_by(navigation, EastNorth::new(0.0, metres));
                    if now < Timestamp::from_secs(30) {
                        navigation.quality = PositionQuality::Gps;
                    }
                }
                true
            },
        ));
        // This vehicle comes up at once. That is a flaw of its own, which is long over by then.
        trial.run_for(17.0);
        let before = trial.now;
        trial.run_for(30.0);
        let flaws: Vec<_> = trial
            .notes()
            .into_iter()
            .filter(|(at, note)| *at > before && matches!(note, Note::Navigation { text } if !text.contains("jumped")))
            .collect();
        assert!(flaws.is_empty(), "{metres} m: {flaws:?}");
        assert!(trial.core.has_control());
    }
}

/// Each BFNVG is followed by its own BFNVR, and by another one half a sample later.
#[test]
fn sr_024_the_limits_of_speed_apply_to_each_velocity_and_not_only_to_the_first_of_a_sample() {
    for (east_mps, down_mps, ends) in [(1.5, 0.0, false), (30.0, 0.0, true), (1.5, 30.0, true)] {
        let mut trial = Trial::steering();
        trial.run_for(1.0);
        let at = trial.now;
        for _ in 0..10 {
            let second = VelocityAndRates {
                created: trial.vehicle.clock(trial.now),
                east_mps,
                north_mps: 0.0,
                down_mps,
                pitch_rate_dps: 0.0,
                roll_rate_dps: 0.0,
                yaw_rate_dps: 0.0,
            };
            trial.hear_now([second.into()]);
            if ends {
                assert!(!trial.core.has_control(), "{east_mps} {down_mps}");
            }
            trial.run_for(0.1);
        }
        let ended = trial.sent_since("EMB", at);
        assert_eq!(
            !ended.is_empty(),
            ends,
            "{east_mps} {down_mps}: {:?}",
            trial.lease_ends()
        );
        if ends {
            assert_eq!(ended, [at]);
        }
    }
}

/// The BPLOG,NVR was lost on its way, and core took the answer to another BPLOG for its own.
#[test]
fn sr_024_missing_velocities_are_subscribed_again() {
    let mut trial = Trial::under_way();
    trial.vehicle.subscribed.remove("NVR");
    let at = trial.now;
    trial.run_for(3.0);
    assert!(!trial.core.has_control());
    let asked = trial.sent_since("LOG", at);
    assert_eq!(asked.len(), 1, "once, and only that: {asked:?}");
    assert!(trial.vehicle.subscribed.contains("NVR"));
    trial.run_for(15.0);
    assert!(trial.core.has_control());
}

/// The vehicle's clock is set while velocities are missing, and core notices that before it misses them. The time
/// without velocities goes on by our own clock.
#[test]
fn sr_024_velocities_are_missing_over_a_step_of_the_vehicles_clock_too() {
    let mut trial = Trial::steering();
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
    trial.run_for(5.0);
    let began = trial.now;
    trial.vehicle.bend = Some(Box::new(move |now: Timestamp, _: &mut _, _: &mut _| {
        now.since(began) >= Duration::from_millis(2150)
    }));
    trial.run_for(0.9);
    trial.vehicle.clock_nanos += 88_000_000_000;
    trial.run_for(40.0);
    let ended = *trial.sent_since("EMB", began).first().unwrap();
    assert!(
        ended.since(began) < Duration::from_millis(1500),
        "the step was noticed before velocities were missed: {ended}"
    );
    let again = *trial
        .sent_since("RMB", ended + Duration::from_millis(1))
        .first()
        .expect("it steers again");
    let after_s = again.since(began).as_secs_f64();
    assert!(
        after_s >= 2.05 + 10.0,
        "{after_s} s after velocities began to be missing"
    );
}

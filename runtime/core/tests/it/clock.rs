//! The vehicle's clock: its time is data, and whatever it does costs no more control than it must.

use std::time::Duration;

use backseat_core::Note;
use backseat_units::Timestamp;

use crate::course::modify_for;
use crate::trial::{Setup, Trial};

const SECOND: i64 = 1_000_000_000;
const HOUR: i64 = 3600 * SECOND;

/// A dive that starts this many seconds before midnight on the vehicle's clock.
fn before_midnight(seconds: i64) -> Trial {
    let mut trial = Trial::new();
    let clock = i64::try_from(trial.vehicle.clock(Timestamp::ZERO).as_nanos()).unwrap();
    trial.vehicle.clock_nanos = 24 * HOUR - clock - seconds * SECOND;
    trial
}

fn steer(trial: &mut Trial) {
    trial.ask(0, [modify_for(1, Duration::from_secs(60))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
}

/// The offsets that core reported: our clock less the vehicle's, in seconds.
fn offsets(trial: &Trial) -> Vec<f64> {
    let told = |(_, note)| match note {
        Note::Clock { offset_s, .. } => Some(offset_s),
        _ => None,
    };
    trial.notes().into_iter().filter_map(told).collect()
}

fn late_sentences(trial: &Trial) -> bool {
    trial
        .notes()
        .iter()
        .any(|(_, note)| matches!(note, Note::Navigation { .. }))
}

#[test]
fn midnight_on_either_clock_ends_no_lease() {
    // Our clock starts this long before midnight.
    for (ours_before_s, vehicle_ahead_s) in [(10, 5), (10, -5), (10, 3600), (10, -3600), (10, 0), (10, 43_200)] {
        let mut setup = Setup::default();
        let start = 1_700_006_400 - ours_before_s;
        setup.start.utc = backseat_units::Utc::from_unix_nanos(start * 1_000_000_000);
        let mut trial = Trial::with(setup);
        // The vehicle's clock counts from 22:13:20 at the start of the trial.
        trial.vehicle.clock_nanos = i64::try_from(start - 1_700_000_000).unwrap() * SECOND + vehicle_ahead_s * SECOND;
        trial.run_for(3.0);
        steer(&mut trial);
        trial.run_for(30.0);
        assert!(
            trial.core.is_steering() && trial.lease_ends().is_empty(),
            "{vehicle_ahead_s} s ahead"
        );
        assert!(!late_sentences(&trial));
    }
}

#[test]
fn a_leap_second_ends_no_lease() {
    for delay_ms in [5, 80] {
        let mut trial = before_midnight(10);
        trial.delay = Duration::from_millis(delay_ms);
        trial.vehicle.leap_at = Some(Timestamp::from_secs(10));
        trial.run_for(3.0);
        steer(&mut trial);
        trial.run_for(20.0);
        assert!(trial.core.is_steering(), "{:?}", trial.lease_ends());
        assert!(trial.lease_ends().is_empty());
        let told = offsets(&trial);
        let step = told.last().unwrap() - told[0];
        assert!((step - 1.0).abs() < 0.05, "{told:?}");
        // Core still computes ages correctly: navigation that is delayed afterwards is old.
        trial.stalled_until = trial.now + Duration::from_millis(1500);
        trial.run_for(1.3);
        assert!(!trial.core.is_steering() && !trial.core.has_control());
    }
}

#[test]
fn hours_between_the_clocks_are_reported_and_do_no_harm() {
    for hours in [-9, 1, 7] {
        let mut trial = Trial::new();
        trial.vehicle.clock_nanos = hours * HOUR;
        trial.run_for(2.0);
        steer(&mut trial);
        let told = offsets(&trial);
        assert!(
            told.iter().all(|offset| (offset + hours as f64 * 3600.0).abs() < 0.1),
            "{told:?}"
        );
        assert_eq!(told.len(), 1, "once on a connection");
    }
}

#[test]
fn sr_023_setting_the_vehicles_clock_ends_leases_for_ten_seconds_and_is_reported() {
    // Also by hours: half a day forward looks the same as half a day back.
    for millis in [
        300,
        1000,
        5000,
        4_000_000,
        -300,
        -2000,
        -5000,
        -4_000_000,
        -50_000_000i64,
    ] {
        let mut trial = Trial::under_way();
        // The first report of the offset is then some time ago.
        trial.run_for(10.0);
        steer(&mut trial);
        trial.vehicle.clock_nanos += millis * 1_000_000;
        let set = trial.now;
        trial.run_for(1.5);
        assert!(!trial.core.is_steering() && !trial.core.has_control(), "{millis} ms");
        assert_eq!(trial.sent_since("EMB", set).len(), 1, "{millis} ms");
        trial.run_for(8.4);
        assert!(!trial.core.has_control(), "{millis} ms");
        trial.run_for(2.0);
        assert!(trial.core.has_control(), "{millis} ms");
        let told = trial.notes().into_iter().any(|(_, note)| match note {
            Note::Navigation { text } => text.contains("clock was set by"),
            _ => false,
        });
        assert!(told, "{:?}", trial.notes());
        if millis.abs() > 1000 && millis != -50_000_000 {
            let told = *offsets(&trial).last().unwrap();
            assert!((told + millis as f64 / 1e3).abs() < 0.1, "{:?}", offsets(&trial));
        }
    }
}

#[test]
fn drifting_clocks_end_no_lease() {
    for parts_per_million in [-90, 90] {
        let mut trial = Trial::under_way();
        trial.ask(0, [modify_for(1, Duration::from_secs(60))]);
        for _ in 0..55 {
            trial.run_for(1.0);
            trial.vehicle.clock_nanos += parts_per_million * 1000;
        }
        assert!(
            trial.core.is_steering(),
            "{parts_per_million} ppm: {:?}",
            trial.lease_ends()
        );
        // Two more minutes of the same drift, in steps of 0.2 s.
        for _ in 0..600 {
            trial.run_for(0.2);
            trial.vehicle.clock_nanos += parts_per_million * 200;
        }
        assert!(trial.core.has_control());
    }
}

use std::time::Duration;

use backseat_core::Note;
use backseat_core::plugin::Request;
use backseat_units::{EastNorth, Timestamp};

use crate::course::modify;
use crate::trial::{Seen, Trial};

const HOUR_NANOS: i64 = 3_600_000_000_000;

/// The first plugin asks for a lease in every step from now on.
fn insist(trial: &mut Trial) {
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
}

#[test]
fn sr_008_a_lease_ends_when_navigation_stops() {
    let mut trial = Trial::steering();
    let newest = trial.now;
    trial.vehicle.navigates = false;
    trial.run_for(3.0);
    let (ended, reason) = trial.lease_ends().pop().unwrap();
    assert_eq!(reason, "navigation is stale");
    assert!((0.8..1.1).contains(&ended.since(newest).as_secs_f64()), "{ended}");
    assert_eq!(trial.sent("EMB"), [ended]);
}

/// Core is called somewhat late, though not so late that this ends a lease, and the input brings new navigation. The
/// navigation before it was stale for a moment.
#[test]
fn sr_008_a_stale_moment_ends_the_lease_although_core_is_called_after_it() {
    let mut trial = Trial::steering();
    trial.run_for(0.5);
    let start = trial.now;
    trial.vehicle.navigates = false;
    trial.run_for(0.9);
    trial.asleep_until = trial.now + Duration::from_millis(450);
    trial.run_for(0.34);
    trial.vehicle.navigates = true;
    trial.run_for(1.0);
    let (ended, reason) = trial.lease_ends().pop().expect("an end");
    assert_eq!(reason, "navigation is stale");
    assert_eq!(trial.sent_since("EMB", start), [ended]);
    assert_eq!(trial.core.late_count(), 0);
    assert!(trial.sent_since("RMB", ended).is_empty());
}

/// The same without a lease: what comes after a stale moment must be steady again before it gives control.
#[test]
fn sr_008_navigation_after_a_stale_moment_is_unsteady_although_core_is_called_after_it() {
    let mut trial = Trial::under_way();
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.vehicle.navigates = false;
    trial.run_for(0.9);
    trial.asleep_until = trial.now + Duration::from_millis(450);
    trial.run_for(0.34);
    trial.vehicle.navigates = true;
    trial.run_for(0.2);
    let awake = trial.now;
    trial.vehicle.set_control(awake, true);
    trial.run_for(0.2);
    assert!(!trial.core.has_control());
    trial.run_for(0.6);
    assert!(trial.core.has_control());
}

#[test]
fn sr_008_messages_with_a_frozen_solution_are_stale() {
    let mut trial = Trial::steering();
    let frozen = trial.now;
    trial.vehicle.frozen = Some(frozen);
    trial.run_for(2.0);
    assert!(!trial.core.has_control());
    assert!(trial.lease_ends()[0].0.since(frozen) < Duration::from_millis(1200));
    trial.vehicle.frozen = None;
    trial.run_for(1.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_008_a_frozen_solution_counts_as_silence_and_resets_the_connection() {
    let mut trial = Trial::under_way();
    trial.vehicle.frozen = Some(trial.now);
    trial.run_for(15.5);
    assert!(trial.seen.iter().any(|(_, seen)| *seen == Seen::Reset));
}

#[test]
fn sr_008_timestamps_that_are_wrong_by_hours_never_make_old_navigation_fresh() {
    let mut trial = Trial::under_way();
    let ack = |clock: backseat_units::TimeOfDay, hours: u64| -> backseat_spi::FromVehicle {
        backseat_spi::BackseatControl {
            created: clock + Duration::from_secs(hours * 3600),
            granted: true,
        }
        .into()
    };
    trial.delay = Duration::from_millis(1700);
    for hours in [5, 10, 15, 20] {
        let clock = trial.vehicle.clock(trial.now);
        trial.hear_now([ack(clock, hours)]);
    }
    insist(&mut trial);
    // The judge of the trial, which knows true time, sees every sentence.
    trial.run_for(8.0);
    assert!(!trial.core.is_steering());
}

#[test]
fn sr_008_a_burst_of_buffered_navigation_is_old() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    let stalled = trial.now;
    // The link holds back the vehicle's messages for 4 s.
    trial.stalled_until = stalled + Duration::from_secs(4);
    trial.run_for(3.9);
    assert!(!trial.core.has_control());
    let before = trial.now;
    trial.run_for(0.11);
    assert!(trial.sent_since("RMB", before).is_empty() || trial.core.has_control());
    trial.run_for(2.0);
    assert!(trial.core.has_control(), "what comes after the burst is fresh");
}

#[test]
fn sr_008_a_link_that_becomes_slow_is_noticed_although_messages_keep_coming() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.delay = Duration::from_millis(1500);
    trial.run_for(1.2);
    let slow = trial.now;
    trial.run_for(8.0);
    assert!(!trial.core.has_control());
    assert!(trial.sent_since("RMB", slow).is_empty());
}

#[test]
fn sr_008_a_new_connection_that_is_slow_from_its_first_byte_is_not_taken_for_another_clock() {
    let mut trial = Trial::steering();
    trial.run_for(2.0);
    trial.cut();
    trial.delay = Duration::from_millis(1600);
    let slow = trial.now;
    trial.run_for(20.0);
    insist(&mut trial);
    trial.run_for(5.0);
    assert!(!trial.core.has_control() && trial.sent_since("RMB", slow).is_empty());
}

#[test]
fn hours_between_the_clocks_do_not_matter() {
    for hours in [-23, -12, -11, -3, 2, 11, 12, 23] {
        for offset_nanos in [-20_000_000, -3_000_000, 0, 3_000_000, 20_000_000] {
            let mut trial = Trial::new();
            trial.vehicle.clock_nanos = hours * HOUR_NANOS + offset_nanos;
            trial.run_for(2.0);
            insist(&mut trial);
            // Delays differ from message to message.
            for milliseconds in [1, 12, 3, 9, 2, 15] {
                trial.delay = Duration::from_millis(milliseconds);
                trial.run_for(0.5);
            }
            assert!(trial.core.has_control(), "{hours} h and {offset_nanos} ns");
            assert!(
                trial.lease_ends().is_empty(),
                "{hours} h and {offset_nanos} ns: {:?}",
                trial.lease_ends()
            );
        }
    }
}

/// A dive that starts this many seconds before midnight on the vehicle's clock.
fn before_midnight(seconds: i64) -> Trial {
    let mut trial = Trial::new();
    let clock = i64::try_from(trial.vehicle.clock(Timestamp::ZERO).as_nanos()).unwrap();
    trial.vehicle.clock_nanos = 24 * HOUR_NANOS - clock - seconds * 1_000_000_000;
    trial
}

#[test]
fn midnight_on_the_vehicles_clock_or_on_ours_ends_no_lease() {
    let mut trial = before_midnight(10);
    trial.run_for(2.0);
    insist(&mut trial);
    trial.run_for(30.0);
    assert!(trial.lease_ends().is_empty() && trial.core.is_steering());
    let mut setup = crate::trial::Setup::default();
    setup.start.utc = backseat_units::Utc::from_unix_nanos(1_700_006_390_000_000_000);
    let mut trial = Trial::with_under_way(setup);
    insist(&mut trial);
    trial.run_for(30.0);
    assert!(trial.lease_ends().is_empty() && trial.core.is_steering());
}

#[test]
fn a_leap_second_costs_control_for_a_minute_at_most() {
    let mut trial = before_midnight(10);
    trial.run_for(12.0);
    trial.vehicle.clock_nanos -= 1_000_000_000;
    trial.run_for(60.0);
    assert!(trial.core.has_control(), "a leap second");
}

#[test]
fn a_vehicle_clock_set_back_by_five_seconds_costs_control_for_a_minute_at_most() {
    let mut trial = Trial::steering();
    trial.vehicle.clock_nanos -= 5_000_000_000;
    trial.run_for(60.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_008_a_vehicle_clock_set_back_never_makes_old_navigation_fresh() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.vehicle.clock_nanos -= 5_000_000_000;
    trial.run_for(20.0);
    let _ = trial.core.has_control();
    // The judge of the trial, which knows true time, has seen every sentence.
}

#[test]
fn sr_008_a_vehicle_clock_set_forward_never_makes_old_navigation_fresh() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.vehicle.clock_nanos += 5_000_000_000;
    // From now on the vehicle's messages come 2 s late, and by the clock as core measured it they are not even written
    // yet.
    trial.delay = Duration::from_secs(2);
    trial.delay_to_vehicle = Some(Duration::from_millis(5));
    trial.run_for(30.0);
    assert!(!trial.core.is_steering());
}

#[test]
fn sr_021_a_jump_ends_the_lease_until_navigation_has_been_steady_for_ten_seconds() {
    let mut trial = Trial::steering();
    insist(&mut trial);
    trial.vehicle.jump = EastNorth::new(0.0, 40.0);
    let jumped = trial.now;
    trial.run_for(9.9);
    assert!(!trial.core.has_control());
    assert_eq!(trial.lease_ends()[0].1, "navigation jumped");
    assert_eq!(trial.sent_since("EMB", jumped).len(), 1);
    trial.run_for(0.5);
    assert!(trial.core.has_control() && trial.core.is_steering());
    trial.vehicle.jump = EastNorth::new(0.0, 45.0);
    trial.run_for(1.0);
    assert!(trial.core.is_steering(), "a step of 5 m is allowed");
}

#[test]
fn sr_021_a_second_jump_restarts_the_ten_seconds() {
    let mut trial = Trial::steering();
    trial.vehicle.jump = EastNorth::new(0.0, 40.0);
    trial.run_for(6.0);
    trial.vehicle.jump = EastNorth::new(0.0, 0.0);
    trial.run_for(6.0);
    assert!(!trial.core.has_control());
    trial.run_for(4.5);
    assert!(trial.core.has_control());
}

#[test]
fn sr_021_a_new_connection_does_not_shorten_the_ten_seconds() {
    let mut trial = Trial::steering();
    trial.vehicle.jump = EastNorth::new(0.0, 40.0);
    trial.run_for(1.0);
    trial.cut();
    trial.run_for(5.0);
    assert!(!trial.core.has_control(), "the jump was 6 s ago");
    trial.run_for(8.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_021_a_jump_during_a_link_loss_is_noticed() {
    let mut trial = Trial::steering();
    trial.cut();
    trial.vehicle.jump = EastNorth::new(0.0, 200.0);
    trial.run_for(5.0);
    assert!(!trial.core.has_control());
    let jumps = trial
        .notes()
        .into_iter()
        .filter(|(_, note)| matches!(note, Note::Navigation { .. }))
        .count();
    assert_eq!(jumps, 1);
    trial.run_for(10.0);
    assert!(trial.core.has_control());
}

#[test]
fn sr_021_a_jump_during_a_link_loss_is_noticed_even_if_the_vehicles_clock_was_set_before() {
    let mut trial = Trial::under_way();
    trial.vehicle.clock_nanos -= 20_000_000_000;
    // By all that core knows, the navigation that comes then was solved 20 s ago.
    trial.run_for(24.0);
    trial.cut();
    trial.vehicle.jump = EastNorth::new(0.0, 100.0);
    trial.run_for(3.0);
    let jumped = |(_, note)| matches!(note, Note::Navigation { .. });
    assert!(trial.notes().into_iter().any(jumped), "{:#?}", trial.notes());
}

#[test]
fn a_vehicle_that_moves_on_during_a_link_loss_has_not_jumped() {
    let mut trial = Trial::steering();
    trial.cut();
    trial.unreachable = true;
    trial.run_for(120.0);
    trial.unreachable = false;
    trial.run_for(25.0);
    assert!(trial.core.has_control());
    let jumped = trial
        .notes()
        .into_iter()
        .any(|(_, note)| matches!(note, Note::Navigation { .. }));
    assert!(!jumped);
}

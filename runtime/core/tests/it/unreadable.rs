//! Leases over sentences that were damaged or cannot be read: each may have been the begin or the end of what is flown.

use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::{GpsHitRequest, Request};
use backseat_spi::{FromVehicle, VelocityAndRates};

use crate::course::{self, at, modify, turn};
use crate::scene::{begins, led_to};
use crate::trial::{Setup, Trial, granted, shorts};

/// At (400, -1500) under the second behavior, a way to anywhere else in the plan leads over the wreck.
fn steering_east_of_the_wreck() -> Trial {
    let mut trial = Trial::under_way();
    led_to(&mut trial, 380.0, -1500.0);
    begins(&mut trial, Some(2), None);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.3);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    trial
}

fn velocity(trial: &Trial, east_mps: f64) -> FromVehicle {
    VelocityAndRates {
        created: trial.vehicle.clock(trial.now),
        east_mps,
        north_mps: 0.0,
        down_mps: 0.0,
        pitch_rate_dps: 0.0,
        roll_rate_dps: 0.0,
        yaw_rate_dps: 0.0,
    }
    .into()
}

/// The refresh is due at the moment of a read that ends with a damaged sentence.
fn refresh_beside_a_damaged_sentence(with_navigation: bool) -> (usize, usize) {
    let mut trial = steering_east_of_the_wreck();
    let last = *trial.sent("RMB").last().unwrap();
    trial.run_for((last + Duration::from_millis(999)).since(trial.now).as_secs_f64());
    trial.now = last + Duration::from_secs(1);
    let now = trial.now;
    let mut bytes = Vec::new();
    if with_navigation {
        FromVehicle::from(trial.vehicle.navigation(now, now))
            .encode(&mut bytes)
            .unwrap();
        velocity(&trial, 1.5).encode(&mut bytes).unwrap();
    }
    bytes.extend_from_slice(b"$BFMBS,081025.987,survey,3,,waypoint*00\r\n");
    trial.hear_bytes(&bytes);
    let refreshed = trial.sent_since("RMB", now).len();
    trial.run_for(0.5);
    let ended = trial.sent_since("EMB", now).len();
    (refreshed, ended)
}

#[test]
fn sr_004_the_read_that_has_a_loss_in_it_ends_the_lease_before_its_refresh() {
    assert_eq!(refresh_beside_a_damaged_sentence(false), (0, 1));
}

#[test]
fn sr_004_navigation_in_the_same_read_does_not_keep_a_lease_over_a_loss() {
    assert_eq!(refresh_beside_a_damaged_sentence(true), (0, 1));
}

fn gps_setup() -> Setup {
    Setup {
        fence: course::harbour(),
        ..granted(&[Grant::Surface], &[])
    }
}

fn hit(tag: u64) -> Request {
    Request::GpsHit(GpsHitRequest {
        tag,
        position: at(0.0, 500.0),
    })
}

/// A damaged sentence, which may have been the begin of the GPS hit that waits: a new modify is refused from then on.
#[test]
fn sr_004_a_lease_ends_when_a_waiting_gps_hit_may_have_begun_unheard() {
    let mut trial = Trial::with_under_way(gps_setup());
    trial.run_for(5.0);
    trial.ask(0, [hit(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(2));
    let lost = trial.now;
    trial.hear_bytes(b"$BFMBS,081025.987,,,1,gps*00\r\n");
    trial.run_for(0.2);
    // For comparison.
    trial.ask(1, [Request::Modify(modify(3))]);
    trial.ask(0, [turn(2, 91.0)]);
    trial.run_for(5.0);
    assert_eq!(
        trial.sent_since("EMB", lost).len(),
        1,
        "refreshed {} times",
        trial.sent_since("RMB", lost).len()
    );
}

#[test]
fn sr_004_a_lease_ends_when_its_behavior_may_have_ended_unheard() {
    let mut trial = Trial::steering();
    let lost = trial.now;
    trial.hear_bytes(b"$BFMBS,081025.987,survey,2,,waypoint*00\r\n");
    trial.run_for(0.2);
    trial.ask(0, [turn(1, 91.0)]);
    trial.run_for(5.0);
    assert_eq!(
        trial.sent_since("EMB", lost).len(),
        1,
        "refreshed {} times",
        trial.sent_since("RMB", lost).len()
    );
}

fn line_of(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// A BFMBS or BFMBE with a good checksum of which one field cannot be read.
#[test]
fn sr_003_a_begin_or_end_that_cannot_be_read_ends_the_lease() {
    let mut wrong = Vec::new();
    for body in ["BFMBS,081025.987,survey,2.5,,waypoint", "BFMBE,,survey,1,,trackline"] {
        let mut trial = Trial::steering();
        let at = trial.now;
        trial.hear_bytes(&line_of(body));
        trial.run_for(0.3);
        let ended = trial.sent_since("EMB", at).len();
        trial.run_for(5.0);
        wrong.push((body, ended, trial.sent_since("RMB", at).len()));
        let mut trial = Trial::under_way();
        trial.hear_bytes(&line_of(body));
        trial.ask(0, [Request::Modify(modify(2))]);
        trial.run_for(0.3);
    }
    assert!(wrong.iter().all(|(_, ended, _)| *ended == 1), "{wrong:?}");
}

/// The begin of the accepted GPS hit has a good checksum and a number that cannot be read. SPI 7.7: the vehicle is on its
/// way to the surface now.
#[test]
fn sr_002_nothing_is_modified_after_a_begin_of_a_gps_hit_that_cannot_be_read() {
    let mut trial = Trial::with_under_way(gps_setup());
    trial.run_for(5.0);
    trial.ask(0, [hit(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial.hear_bytes(&line_of("BFMBS,081025.987,,-,1,gps"));
    trial.run_for(0.2);
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(0.5);
    assert!(trial.commands("RMB").is_empty(), "{:?}", trial.states(2));
}

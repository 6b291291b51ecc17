//! The vehicle's navigation and speed of sound, as frames for the controller.

use std::f64::consts::PI;
use std::time::Duration;

use backseat_s7k::Time7k;
use backseat_s7k::record::NavigationField;
use backseat_sonar::{Input, NavigationTimes, SonarConfig, VehicleNavigation, VehicleSoundSpeed};

use crate::trial::{Trial, config, navigation, utc};

impl Trial {
    /// Navigation at a rate, as the vehicle sends it.
    fn navigate(&mut self, seconds: f64, hertz: f64) {
        for _ in 0..(seconds * hertz) as usize {
            let sample = navigation(self.now);
            self.handle(Input::Navigation(sample));
            self.run_s(1.0 / hertz);
        }
    }

    fn frame_of(&mut self, sample: VehicleNavigation) -> backseat_s7k::record::NavigationFrame {
        self.controller.navigation.clear();
        self.handle(Input::Navigation(sample));
        self.run_s(1.0);
        assert_eq!(self.controller.navigation.len(), 1);
        self.controller.navigation[0][0].1
    }
}

/// The bits of a full solution: all but speed (2), altitude rate (11).
const FULL: u32 = 0b1_1111_0111_1111_1011;

#[test]
fn a_solution_becomes_a_frame_bit_by_bit() {
    let mut trial = Trial::ready();
    let at = trial.now;
    let frame = trial.frame_of(navigation(at));

    assert_eq!(frame.quality.0, FULL, "{:#b}", frame.quality.0);
    assert_eq!(frame.latitude_rad, 42.3635 * PI / 180.0);
    assert_eq!(frame.longitude_rad, -71.1141_f64.to_radians());
    assert_eq!((frame.depth_m, frame.altitude_m, frame.speed_mps), (20.1, 45.3, 0.0));
    assert_eq!(frame.yaw_rad, 203.1_f64.to_radians() as f32);
    assert_eq!(frame.roll_rad, -3.4_f64.to_radians() as f32);
    assert_eq!(frame.pitch_rad, 4.5_f64.to_radians() as f32);
    assert_eq!((frame.northing_rate_mps, frame.easting_rate_mps), (-1.3746, -0.5864));
    assert_eq!((frame.depth_rate_mps, frame.altitude_rate_mps), (0.02, 0.0));
    assert_eq!(frame.roll_rate_radps, -0.25_f64.to_radians() as f32);
    assert_eq!(frame.pitch_rate_radps, 0.1_f64.to_radians() as f32);
    assert_eq!(frame.yaw_rate_radps, 1.5_f64.to_radians() as f32);
    let seconds = utc(at).as_unix_nanos() as f64 / 1e9;
    assert_eq!((frame.position_time_s, frame.attitude_time_s), (seconds, seconds));
    assert_eq!(trial.controller.navigation[0][0].0, Time7k::from_utc(utc(at)));

    // The bytes: the frame of 64, the header of 32, the frame's header of 32, and in it the quality's four bytes.
    let bytes = &trial.controller.vehicle_bytes[0];
    assert_eq!(bytes.len(), 64 + 32 + 128 + 4);
    assert_eq!(
        bytes[64 + 4..64 + 16],
        [1, 0, 0, 0, 128, 0, 0, 0, 0, 0, 0, 0],
        "one navigation frame of 128"
    );
    assert_eq!(bytes[96..108], [128, 0, 0, 0, 1, 0, 32, 0, 1, 0, 0, 0]);
    assert_eq!(bytes[128..132], FULL.to_le_bytes());
    assert_eq!(bytes[132..140], (42.3635 * PI / 180.0).to_le_bytes());
}

#[test]
fn what_the_vehicle_does_not_tell_is_marked_as_invalid() {
    use NavigationField as F;
    let mut trial = Trial::ready();
    let without = |trial: &mut Trial, change: fn(&mut VehicleNavigation)| {
        let mut sample = navigation(trial.now);
        change(&mut sample);
        let quality = trial.frame_of(sample).quality;
        let missing: Vec<F> = F::ALL
            .iter()
            .copied()
            .filter(|field| !quality.contains(*field))
            .collect();
        missing
    };
    assert_eq!(without(&mut trial, |_| {}), [F::Speed, F::AltitudeRate]);
    assert_eq!(
        without(&mut trial, |sample| sample.altitude = None),
        [F::Speed, F::Altitude, F::AltitudeRate]
    );
    assert_eq!(
        without(&mut trial, |sample| sample.rates = None),
        [
            F::Speed,
            F::NorthingRate,
            F::EastingRate,
            F::DepthRate,
            F::AltitudeRate,
            F::RollRate,
            F::PitchRate,
            F::YawRate
        ]
    );
    assert_eq!(
        without(&mut trial, |sample| {
            sample.roll_deg = f64::NAN;
            sample.pitch_deg = 1e300;
        }),
        [F::Speed, F::Roll, F::Pitch, F::AltitudeRate]
    );
    assert_eq!(trial.sonar.counts().impossible_values, 1);
}

#[test]
fn the_times_of_a_frame_are_a_setting() {
    for (times, seconds, quality) in [
        (NavigationTimes::Day, Some(14.0 * 3600.0 + 5.0 * 60.0 + 9.0), FULL),
        (NavigationTimes::Invalid, None, FULL & !(0b11 << 15)),
    ] {
        let settings = SonarConfig {
            navigation_times: times,
            ..config()
        };
        let mut trial = Trial::with(settings, Vec::new()).until_ready();
        let at = trial.now;
        let frame = trial.frame_of(navigation(at));
        assert_eq!(frame.quality.0, quality);
        assert_eq!(frame.position_time_s, seconds.unwrap_or(0.0));
        assert_eq!(frame.attitude_time_s, seconds.unwrap_or(0.0));
    }
}

#[test]
fn each_solution_is_one_frame_at_most_a_second_old() {
    let mut trial = Trial::ready();
    let begin = trial.now;
    trial.navigate(10.0, 10.0);
    trial.run_s(1.0);
    let frames: Vec<Time7k> = trial
        .controller
        .navigation
        .iter()
        .flatten()
        .map(|(time, _)| *time)
        .collect();
    assert_eq!(frames.len(), 100);
    for (number, time) in frames.iter().enumerate() {
        let solution = utc(begin + Duration::from_millis(100 * number as u64));
        assert_eq!(*time, Time7k::from_utc(solution));
    }
    let sizes: Vec<usize> = trial.controller.navigation.iter().map(Vec::len).collect();
    assert!(sizes.iter().all(|size| *size <= 10), "{sizes:?}");
}

#[test]
fn a_record_has_at_most_25_frames() {
    let mut trial = Trial::ready();
    trial.navigate(4.0, 100.0);
    trial.run_s(1.0);
    let sizes: Vec<usize> = trial.controller.navigation.iter().map(Vec::len).collect();
    assert_eq!(sizes, [25; 16]);
}

#[test]
fn a_frame_that_has_become_old_is_dropped_and_counted() {
    let mut trial = Trial::ready();
    let sample = navigation(trial.now);
    trial.handle(Input::Navigation(sample));
    // The process stood still.
    trial.now = trial.now + Duration::from_millis(1500);
    let sample = navigation(trial.now);
    trial.handle(Input::Navigation(sample));
    trial.run_s(1.0);
    assert_eq!(trial.controller.navigation.len(), 1);
    assert_eq!(trial.controller.navigation[0].len(), 1);
    assert_eq!(trial.sonar.counts().old_frames, 1);
}

#[test]
fn nothing_is_kept_for_the_next_connection() {
    let mut trial = Trial::ready();
    trial.navigate(0.5, 10.0);
    trial.cut();
    trial.navigate(0.8, 10.0);
    trial.run_s(5.0);
    assert!(trial.controller.navigation.is_empty());
    trial.navigate(1.0, 10.0);
    assert!(!trial.controller.navigation.is_empty());
}

#[test]
fn the_speed_of_sound_becomes_an_environment_frame() {
    let mut trial = Trial::ready();
    let at = trial.now;
    for mps in [1492.31, f64::NAN, -3.0, 0.0, 20_000.0] {
        let time = utc(at);
        trial.handle(Input::SoundSpeed(VehicleSoundSpeed {
            time,
            sound_speed_mps: mps,
        }));
    }
    trial.run_s(1.0);
    assert_eq!(trial.controller.environment.len(), 1);
    let [(time, frame)] = trial.controller.environment[0][..] else {
        panic!("one frame")
    };
    assert_eq!((frame.quality.0, frame.sound_speed_mps), (1, 1492.31));
    assert_eq!(time, Time7k::from_utc(utc(at)));
    assert_eq!(trial.sonar.counts().impossible_values, 4);
    let bytes = &trial.controller.vehicle_bytes[0];
    assert_eq!(
        bytes[64 + 12..64 + 16],
        [1, 0, 0, 0],
        "the record says environment by 1"
    );
    assert_eq!(bytes[104..108], [2, 0, 0, 0], "and its frame by 2");
}

#[test]
fn vehicle_data_can_be_turned_off() {
    let settings = SonarConfig {
        vehicle_data: false,
        ..config()
    };
    let mut trial = Trial::with(settings, Vec::new()).until_ready();
    trial.navigate(2.0, 10.0);
    assert!(trial.controller.navigation.is_empty());
}

use std::collections::BTreeSet;

use backseat_mvc::{Sensor, SensorFailure};
use backseat_units::math::wrap_180;

use crate::files::CALM;
use crate::payload::Payload;
use crate::sentences::{field, heard, with};

fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    (mean, square.sqrt())
}

/// Readings of one field, taken while the vehicle stays on the surface, so that only noise changes them.
fn held(text: &str, seed: u64, message: &str, index: usize) -> Vec<f64> {
    let text = with(text, "mission", "starts_after_s = 1000");
    let (_, heard) = heard(&text, seed, message, 0.0, 100.0);
    heard.iter().map(|line| field(line, index)).collect()
}

const TAILCONE: [&str; 10] = ["CTD", "DV2", "DVL", "ERC", "IMU", "NVG", "NVR", "RCM", "RDP", "RVL"];

/// SPI 6: each message comes at its own rate, to the clients that have switched it on.
#[test]
fn every_sensor_has_its_rate_and_its_subscribers() {
    for (message, per_s) in [
        ("NVG", 10),
        ("NVR", 10),
        ("CTD", 1),
        ("SVS", 1),
        ("RCM", 5),
        ("RDP", 5),
        ("RVL", 5),
        ("ERC", 5),
        ("DVL", 5),
        ("DV2", 5),
        ("IMU", 10),
    ] {
        let (_, heard) = heard(CALM, 1, message, 2.0, 12.0);
        assert_eq!(heard.len(), 10 * per_s, "{message}");
        assert!(heard.iter().all(|line| line.starts_with(&format!("$BF{message},"))));
    }
    let (_, slow) = heard(&with(CALM, "sensors.imu", "period_s = 2.5"), 1, "IMU", 2.0, 12.0);
    assert_eq!(slow.len(), 4);
}

#[test]
fn noise_has_the_spread_that_is_set_and_no_bias_of_its_own() {
    for (section, key, message, index, deviation) in [
        ("sensors", "heading_noise_deg = 0.5", "NVG", 9, 0.5),
        ("sensors", "depth_noise_m = 0.2", "NVG", 8, 0.2),
        ("sensors", "altitude_noise_m = 0.3", "NVG", 7, 0.3),
        ("sensors", "attitude_noise_deg = 0.4", "NVG", 10, 0.4),
        ("sensors", "velocity_noise_mps = 0.05", "NVR", 2, 0.05),
        ("sensors", "temperature_noise_c = 0.1", "CTD", 3, 0.1),
        ("sensors", "conductivity_noise_us_per_cm = 50", "CTD", 2, 50.0),
        ("sensors", "pressure_noise_kpa = 2", "CTD", 4, 2.0),
        ("sensors.depth", "noise_kpa = 0.5", "RDP", 2, 0.5),
        ("sensors.compass", "noise_deg = 1.5", "RCM", 3, 1.5),
        ("sensors.compass", "noise_deg = 0.7", "RCM", 5, 0.7),
        ("sensors.imu", "rate_noise_dps = 0.3", "IMU", 4, 0.3),
        ("sensors.imu", "acceleration_noise_mps2 = 0.2", "IMU", 7, 0.2),
        ("sensors.tailcone", "rpm_noise = 4", "RVL", 2, 4.0),
        ("sensors.tailcone", "angle_noise_deg = 0.5", "ERC", 3, 0.5),
        ("sensors.dvl", "velocity_noise_mps = 0.05", "DVL", 2, 0.05),
        ("sensors.dvl", "range_noise_m = 0.6", "DVL", 6, 0.6),
        ("sensors.dvl", "temperature_noise_c = 0.5", "DVL", 9, 0.5),
    ] {
        let perfect = held(CALM, 1, message, index);
        assert!(moments(&perfect).1 < 1e-3, "{key}: {:?}", moments(&perfect));
        let text = with(CALM, section, key);
        let mut all = Vec::new();
        for seed in 0..4 {
            let mut readings = held(&text, seed, message, index);
            // Headings around north.
            if matches!((message, index), ("RCM", 3) | ("NVG", 9)) {
                readings.iter_mut().for_each(|deg| *deg = wrap_180(*deg));
            }
            all.append(&mut readings);
        }
        let (mean, spread) = moments(&all);
        let count = all.len() as f64;
        let truth = if matches!((message, index), ("RCM", 3) | ("NVG", 9)) {
            wrap_180(perfect[0])
        } else {
            perfect[0]
        };
        // On the surface the vehicle may also read a depth a little above it, as in a wave.
        assert!(
            (mean - truth).abs() < 4.5 * deviation / count.sqrt() + 1e-3,
            "{key}: {mean} {truth}"
        );
        assert!(
            (spread / deviation - 1.0).abs() < 4.5 / (2.0 * count).sqrt(),
            "{key}: {spread}"
        );
    }
}

#[test]
fn a_bias_is_constant_in_a_run_and_has_its_spread_over_seeds() {
    for (section, key, message, index, deviation) in [
        ("sensors.depth", "bias_kpa = 5", "RDP", 2, 5.0),
        ("sensors.ins", "heading_bias_deg = 3", "NVG", 9, 3.0),
        ("sensors", "temperature_bias_c = 0.5", "CTD", 3, 0.5),
        ("sensors", "conductivity_bias_us_per_cm = 40", "CTD", 2, 40.0),
        ("sensors", "pressure_bias_kpa = 3", "CTD", 4, 3.0),
        ("sensors.compass", "bias_deg = 2", "RCM", 3, 2.0),
        ("sensors.imu", "rate_bias_dph = 3600", "IMU", 3, 1.0),
        ("sensors.imu", "acceleration_bias_mps2 = 0.4", "IMU", 5, 0.4),
    ] {
        let text = with(&with(CALM, section, key), "mission", "starts_after_s = 1000");
        let wrap = |deg: f64| {
            if matches!((message, index), ("RCM", 3) | ("NVG", 9)) {
                wrap_180(deg)
            } else {
                deg
            }
        };
        let reading = |text: &str, seed| {
            let (_, heard) = heard(text, seed, message, 0.0, 5.0);
            let readings: Vec<f64> = heard.iter().map(|line| wrap(field(line, index))).collect();
            assert!(moments(&readings).1 < 1e-3, "{key}");
            readings[0]
        };
        let truth = reading(&with(CALM, "mission", "starts_after_s = 1000"), 1);
        let off: Vec<f64> = (0..200).map(|seed| reading(&text, seed) - truth).collect();
        let (mean, spread) = moments(&off);
        assert!(mean.abs() < 4.0 * deviation / 200.0_f64.sqrt(), "{key} {mean}");
        assert!((0.8..1.2).contains(&(spread / deviation)), "{key} {spread}");
    }
}

/// SPI 6.5.
#[test]
fn the_compass_reads_magnetic_north_with_a_deviation_that_depends_on_the_heading() {
    let text = with(CALM, "sensors.compass", "declination_deg = -14");
    let (payload, lines) = heard(&text, 1, "RCM", 0.0, 60.0);
    let line = lines.last().expect("a compass");
    let truth = payload.mvc.truth();
    assert!(
        (wrap_180(field(line, 3) - truth.heading_deg - 14.0)).abs() < 0.01,
        "{line} {truth:?}"
    );
    // The deviation depends on the heading alone, and at opposite headings it is opposite.
    let plan = "[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 0, north_m = 0 }\nradius_m = 40\norbits = 4\n\
        depth_m = 10\nspeed_mps = 1\n";
    let (before, _) = text.split_once("[[plan]]").expect("a plan");
    let circle = with(&format!("{before}{plan}"), "sensors.compass", "deviation_deg = 3");
    let mut payload = Payload::connected(&circle, 2, &["RCM"]);
    payload.until(200.0);
    let mut deviations: Vec<(f64, f64)> = Vec::new();
    for step in 0..600 {
        payload.heard();
        payload.until(200.0 + f64::from(step));
        let Some(line) = payload.heard().pop() else { continue };
        let truth = payload.mvc.truth();
        deviations.push((truth.heading_deg, wrap_180(field(&line, 3) - truth.heading_deg - 14.0)));
    }
    let most = deviations.iter().map(|(_, deg)| deg.abs()).fold(0.0, f64::max);
    assert!((0.5..12.0).contains(&most), "{most}");
    for (heading, deviation) in &deviations {
        let opposite = deviations
            .iter()
            .find(|(other, _)| wrap_180(other - heading - 180.0).abs() < 1.0);
        let (_, opposite) = opposite.expect("a whole circle");
        assert!(
            (deviation + opposite).abs() < 0.3 + 0.1 * most,
            "{heading} {deviation} {opposite}"
        );
    }
}

#[test]
fn each_compass_has_its_own_message_and_there_may_be_none() {
    let (_, lines) = heard(&with(CALM, "sensors.compass", "count = 3"), 1, "RCM", 0.0, 1.0);
    let numbers: Vec<f64> = lines.iter().map(|line| field(line, 2)).collect();
    assert_eq!(numbers[..6], [1.0, 2.0, 3.0, 1.0, 2.0, 3.0]);
    let (_, lines) = heard(&with(CALM, "sensors.compass", "count = 0"), 1, "RCM", 0.0, 1.0);
    assert!(lines.is_empty());
}

/// SPI 6.6.
#[test]
fn pressure_is_absolute() {
    let (payload, lines) = heard(CALM, 1, "RDP", 0.0, 60.0);
    // Saunders (1981), at 42.3 degrees of latitude near the surface: 1.00839 dbar a metre.
    let expected = 101.325 + 10.0839 * payload.mvc.truth().depth_m;
    assert!((field(lines.last().expect("a reading"), 2) - expected).abs() < 0.01);
}

/// SPI 6.7.
#[test]
fn the_thrusters_rpm_gives_the_speed_through_the_water() {
    let (payload, lines) = heard(CALM, 1, "RVL", 0.0, 60.0);
    let line = lines.last().expect("a reading");
    let speed = payload.mvc.truth().speed_mps;
    assert!(
        (field(line, 2) - 300.0 * speed).abs() < 0.5 && (field(line, 3) - speed).abs() < 0.01,
        "{line}"
    );
    let (_, lines) = heard(
        &with(CALM, "sensors.tailcone", "speed_table = false"),
        1,
        "RVL",
        0.0,
        5.0,
    );
    assert!(lines.iter().all(|line| line.ends_with(',')), "{lines:?}");
    let wrong = with(CALM, "sensors.tailcone", "speed_error = 0.2");
    let (payload, lines) = heard(&wrong, 3, "RVL", 0.0, 60.0);
    let ratio = field(lines.last().expect("a reading"), 3) / payload.mvc.truth().speed_mps;
    assert!((ratio - 1.0).abs() > 0.01 && (ratio - 1.0).abs() < 0.8, "{ratio}");
}

/// SPI 6.12: pitch up and to starboard are positive.
#[test]
fn the_tailcone_turns_and_dives_the_vehicle() {
    let mut payload = Payload::connected(CALM, 1, &["ERC", "NVR"]);
    payload.until(4.0);
    payload.heard();
    // The target comes first, the angle follows it.
    payload.until(6.0);
    let dive: Vec<String> = payload
        .heard()
        .into_iter()
        .filter(|line| line.contains("ERC"))
        .collect();
    let line = dive.last().expect("angles");
    assert!(field(line, 2) < -1.0 && field(line, 4) < field(line, 2), "{line}");
    payload.until(60.0);
    payload.heard();
    for second in 60..63 {
        payload.say("$BPRMB,080000.000,90,10,0,2,1,0");
        payload.until(f64::from(second) + 1.0);
    }
    let heard = payload.heard();
    let rate_dps = field(heard.iter().rfind(|line| line.contains("NVR")).expect("rates"), 7);
    let line = heard.iter().rfind(|line| line.contains("ERC")).expect("angles");
    assert!(rate_dps > 3.0, "{rate_dps}");
    assert!(
        (field(line, 3) - 20.0 * rate_dps / 10.0).abs() < 0.4,
        "{line} {rate_dps}"
    );
    assert!((field(line, 5) - 20.0).abs() < 1e-6, "{line}");
}

/// SPI 6.7, 6.12: only vehicles with a tailcone.
#[test]
fn a_hovering_vehicle_has_no_tailcone() {
    let text = CALM
        .replace("[mission]", "[vehicle]\nclass = \"hovering\"\n[mission]")
        .replace("speed_mps = 2", "speed_mps = 0.5");
    let mut payload = Payload::connected(&text, 1, &["ALL"]);
    payload.until(10.0);
    let names: BTreeSet<String> = payload.heard().iter().map(|line| line[3..6].to_owned()).collect();
    assert!(
        !names.contains("RVL") && !names.contains("ERC") && names.contains("DV2"),
        "{names:?}"
    );
}

/// SPI 6.15.
#[test]
fn the_inertial_sensor_feels_gravity_turns_and_thrust() {
    let level = CALM.replace("depth_m = 10", "depth_m = 0");
    let mut payload = Payload::connected(&level, 1, &["IMU"]);
    payload.until(0.9);
    let line = payload.heard().pop().expect("a reading");
    assert!((field(&line, 7) + 9.806_65).abs() < 1e-5, "{line}");
    payload.until(2.0);
    let line = payload.heard().pop().expect("a reading");
    assert!((0.1..0.25).contains(&field(&line, 5)), "it speeds up: {line}");
    payload.until(60.0);
    payload.heard();
    payload.say("$BPRMB,080000.000,90,0,0,2,1,0");
    payload.until(63.0);
    let line = payload.heard().pop().expect("a reading");
    // A turn to starboard at 2 m/s: the rate about the axis down, and the pull to starboard.
    let (rate_dps, pull) = (field(&line, 4), field(&line, 6));
    let roll = 0.3 * rate_dps.to_radians();
    let expected = 2.0 * rate_dps.to_radians() - 9.806_65 * roll;
    assert!(rate_dps > 3.0 && (pull - expected).abs() < 0.08, "{line} {expected}");
}

/// SPI 6.4: the sensor's output, else an estimate.
#[test]
fn sound_velocity_is_measured_or_estimated() {
    let svs = |text: &str| {
        let (_, lines) = heard(text, 1, "SVS", 50.0, 60.0);
        lines.iter().map(|line| field(line, 2)).collect::<Vec<f64>>()
    };
    // 12 degrees, 40 mS/cm and 10 m: a salinity of 34.8.
    let estimated = svs(CALM);
    assert!((estimated[0] - 1497.3).abs() < 1.5, "{estimated:?}");
    let nominal = svs(&with(
        &with(CALM, "sensors", "ctd_fitted = false"),
        "sensors.sound",
        "nominal_mps = 1480",
    ));
    assert!(nominal.iter().all(|speed| *speed == 1480.0));
    let fitted = svs(&with(
        &with(CALM, "sensors.sound", "fitted = true"),
        "sensors.sound",
        "bias_mps = 3",
    ));
    assert!((fitted[0] - estimated[0]).abs() > 0.05 && (fitted[0] - estimated[0]).abs() < 12.0);
    let noisy = svs(&with(
        &with(CALM, "sensors.sound", "fitted = true"),
        "sensors.sound",
        "noise_mps = 1",
    ));
    assert!(moments(&noisy).1 > 0.3);
}

/// SPI 6.3: not implemented, unless the file asks for it.
#[test]
fn telemetry_is_off_unless_it_is_asked_for() {
    let (_, lines) = heard(CALM, 1, "TEL", 0.0, 10.0);
    assert!(lines.is_empty());
    let (_, lines) = heard(&with(CALM, "sensors.telemetry", "enabled = true"), 1, "TEL", 0.0, 60.0);
    assert!(lines[0].ends_with(",0.6,0,0.6,0,1,0"), "{}", lines[0]);
    assert!(
        lines[59].ends_with(",0.6,0,0.6,0,0,0"),
        "under water there is no radio: {}",
        lines[59]
    );
}

/// SPI 6.16.
#[test]
fn a_vehicle_without_a_ctd_gives_no_output() {
    let (_, lines) = heard(&with(CALM, "sensors", "ctd_fitted = false"), 1, "CTD", 0.0, 20.0);
    assert!(lines.is_empty());
}

#[test]
fn a_sensor_that_fails_is_silent_and_comes_back() {
    for (sensor, messages) in [
        (Sensor::Dvl, &["DVL", "DV2"][..]),
        (Sensor::Compass, &["RCM"]),
        (Sensor::Depth, &["RDP"]),
        (Sensor::Imu, &["IMU"]),
        (Sensor::Ctd, &["CTD"]),
        (Sensor::Tailcone, &["RVL", "ERC"]),
    ] {
        let mut payload = Payload::connected(CALM, 1, &TAILCONE);
        let names = |payload: &mut Payload, until_s| -> BTreeSet<String> {
            payload.until(until_s);
            payload.heard().iter().map(|line| line[3..6].to_owned()).collect()
        };
        let all: BTreeSet<String> = TAILCONE.iter().map(|name| (*name).to_owned()).collect();
        assert_eq!(names(&mut payload, 5.0), all);
        payload.mvc.fail_sensor(SensorFailure::Dropout(sensor, true));
        let mut left = all.clone();
        left.retain(|name| !messages.contains(&name.as_str()));
        assert_eq!(names(&mut payload, 10.0), left, "{sensor:?}");
        payload.mvc.fail_sensor(SensorFailure::Dropout(sensor, false));
        assert_eq!(names(&mut payload, 15.0), all, "{sensor:?}");
    }
}

#[test]
fn a_sound_velocity_sensor_that_fails_leaves_an_estimate() {
    let text = with(
        &with(CALM, "sensors.sound", "fitted = true"),
        "sensors.sound",
        "bias_mps = 20",
    );
    let mut payload = Payload::connected(&text, 1, &["SVS"]);
    payload.until(50.0);
    let measured = field(&payload.heard().pop().expect("a reading"), 2);
    payload
        .mvc
        .fail_sensor(SensorFailure::Dropout(Sensor::SoundVelocity, true));
    payload.until(55.0);
    let estimated = field(&payload.heard().pop().expect("a reading"), 2);
    assert!(
        (estimated - 1497.3).abs() < 1.5 && (measured - estimated).abs() > 0.5,
        "{measured} {estimated}"
    );
    payload.mvc.fail_sensor(SensorFailure::Dropout(Sensor::Ctd, true));
    payload.until(60.0);
    assert_eq!(field(&payload.heard().pop().expect("a reading"), 2), 1500.0);
}

#[test]
fn settings_out_of_range_name_their_key() {
    for (section, key, message) in [
        (
            "sensors.dvl",
            "scale_error = 0.5",
            "sensors.dvl.scale_error is 0.5, expected 0 to 0.2",
        ),
        (
            "sensors.gps",
            "period_s = 0",
            "sensors.gps.period_s is 0, expected 0.1 to 60 s",
        ),
        (
            "sensors.compass",
            "count = 9",
            "sensors.compass.count is 9, expected 0 to 4",
        ),
        (
            "sensors.imu",
            "rate_noise_dps = -1",
            "sensors.imu.rate_noise_dps is -1, expected 0 to 100",
        ),
        (
            "sensors.fixes",
            "age_max_s = 500",
            "sensors.fixes.age_max_s is 500, expected 0 to 120 s",
        ),
        (
            "sensors.sound",
            "nominal_mps = 340",
            "sensors.sound.nominal_mps is 340, expected 1300 to 1700 m/s",
        ),
        (
            "sensors.ins",
            "heading_bias_deg = nan",
            "sensors.ins.heading_bias_deg is NaN, expected 0 to 30 degrees",
        ),
    ] {
        let fault = backseat_mvc::WorldFile::from_toml(&with(CALM, section, key)).expect_err(key);
        assert_eq!(fault.to_string(), message);
    }
    let unknown = backseat_mvc::WorldFile::from_toml(&with(CALM, "sensors.dvl", "scale = 1")).expect_err("unknown");
    assert!(unknown.to_string().contains("unknown field `scale`"), "{unknown}");
}

use crate::files::{CALM, LIVELY};
use crate::payload::Payload;
use crate::sentences::{field, heard, with};

/// SPI 6.13: forward, to starboard and down; ranges along four beams of 30 degrees.
#[test]
fn the_doppler_log_measures_along_the_vehicles_axes() {
    let text = CALM.replace("[sensors]", "[current]\nspeed_mps = 0.3\ntowards_deg = 90\n[sensors]");
    let (payload, lines) = heard(&text, 1, "DVL", 0.0, 100.0);
    let line = lines.last().expect("a reading");
    let truth = payload.mvc.truth();
    let heading = truth.heading_deg.to_radians();
    // The course is level, and the frame's convergence is zero here.
    let (north, east) = (truth.north_mps, truth.east_mps);
    let forward = north * backseat_units::math::cos(heading) + east * backseat_units::math::sin(heading);
    let starboard = east * backseat_units::math::cos(heading) - north * backseat_units::math::sin(heading);
    assert!(
        (field(line, 2) - forward).abs() < 0.005 && (field(line, 3) - starboard).abs() < 0.005,
        "{line}"
    );
    assert!(starboard > 0.2, "the current sets it to starboard: {starboard}");
    for beam in 5..9 {
        let range = truth.altitude_m / backseat_units::math::cos(30.0_f64.to_radians());
        assert!((field(line, beam) - range).abs() < 0.5, "{line} {range}");
    }
}

/// SPI 6.14: on vehicles that do not hover the first three are the axes' and the fourth the error velocity.
#[test]
fn the_extended_message_has_axes_on_torpedoes_and_beams_on_hovering_hulls() {
    let mut payload = Payload::connected(LIVELY, 1, &["DVL", "DV2"]);
    payload.until(60.0);
    let lines = payload.heard();
    let (dvl, extended) = (&lines[lines.len() - 2], &lines[lines.len() - 1]);
    for index in 2..5 {
        assert_eq!(
            dvl.split(',').nth(index),
            extended.split(',').nth(index),
            "{dvl} {extended}"
        );
    }
    assert!(field(extended, 5).abs() < 0.03);
    let text = CALM
        .replace("[mission]", "[vehicle]\nclass = \"hovering\"\n[mission]")
        .replace("speed_mps = 2", "speed_mps = 0.5");
    let (payload, lines) = heard(&text, 1, "DV2", 0.0, 300.0);
    let line = lines.last().expect("a reading");
    let forward = payload.mvc.truth().speed_mps * 0.5 * 0.5_f64.sqrt();
    for (index, expected) in [(2, forward), (3, -forward), (4, -forward), (5, forward)] {
        assert!((field(line, index) - expected).abs() < 0.01, "{line} {expected}");
    }
}

#[test]
fn without_bottom_lock_the_dvl_gives_no_ranges_and_if_configured_the_velocity_through_the_water() {
    let deep = with(CALM, "sensors", "altitude_range_m = 20");
    let (_, lines) = heard(&deep, 1, "DVL", 20.0, 60.0);
    assert!(lines.iter().all(|line| line.contains(",,,,,,,")), "{:?}", lines[0]);
    let water = with(&deep, "sensors.dvl", "water_velocity = true");
    let water = water.replace("[sensors]", "[current]\nspeed_mps = 0.4\ntowards_deg = 0\n[sensors]");
    let (payload, lines) = heard(&water, 1, "DVL", 20.0, 60.0);
    let line = lines.last().expect("a reading");
    let truth = payload.mvc.truth();
    assert!(
        (field(line, 2) - truth.speed_mps).abs() < 0.02 && truth.north_mps > truth.speed_mps + 0.3,
        "{line}"
    );
    assert!(line.contains(",,,,,"), "{line}");
}

#[test]
fn bottom_lock_ends_at_the_limits_of_reach_blanking_and_tilt_and_with_two_beams() {
    let locked = |text: &str, from_s, to_s| {
        let (_, lines) = heard(text, 1, "NVG", from_s, to_s);
        let with = lines.iter().filter(|line| field(line, 7) > 0.0).count();
        (with, lines.len())
    };
    // The vehicle is 50 m above the bottom, just within and just out of the reach.
    for (key, expected) in [
        ("altitude_range_m = 50.5", true),
        ("altitude_range_m = 49.5", false),
        ("altitude_blanking_m = 49.5", true),
        ("altitude_blanking_m = 50.5", false),
    ] {
        let (with_lock, all) = locked(&with(CALM, "sensors", key), 100.0, 110.0);
        assert_eq!(with_lock, if expected { all } else { 0 }, "{key}");
    }
    // The vehicle dives at 17 degrees.
    let (with_lock, all) = locked(&with(CALM, "sensors.dvl", "tilt_max_deg = 10"), 4.0, 25.0);
    assert!(with_lock > 0 && with_lock < all - 50, "{with_lock} of {all}");
    let (with_lock, all) = locked(CALM, 4.0, 25.0);
    assert_eq!(with_lock, all);
    // When the vehicle is pitched, two of the four beams are out of reach: there is no lock although the altitude is
    // within it.
    let (with_lock, all) = locked(&with(CALM, "sensors", "altitude_range_m = 61"), 4.0, 12.0);
    assert!(with_lock < all - 10, "{with_lock} of {all}");
}

#[test]
fn single_beams_are_lost_at_their_rate() {
    let text = with(CALM, "sensors.dvl", "beam_loss = 0.1");
    let (_, lines) = heard(&text, 1, "DVL", 0.0, 190.0);
    let lost = lines
        .iter()
        .flat_map(|line| line.split(',').skip(5).take(4))
        .filter(|field| field.is_empty())
        .count() as f64;
    let share = lost / (4 * lines.len()) as f64;
    assert!((0.08..0.12).contains(&share), "{share}");
    // With two of four beams lost there is no velocity, in 5.2 % of the readings.
    let none = lines.iter().filter(|line| line.split(',').nth(2) == Some("")).count() as f64;
    let share = none / lines.len() as f64;
    assert!((0.03..0.08).contains(&share), "{share}");
}

#[test]
fn losses_of_bottom_lock_come_at_their_rate_and_last_their_time() {
    let text = with(
        &with(CALM, "sensors", "altitude_dropouts_per_h = 120"),
        "sensors",
        "altitude_dropout_s = 2",
    );
    let (mut losses, mut without, mut all) = (0, 0, 0);
    for seed in 0..20 {
        let (mut payload, lines) = heard(&text, seed, "NVG", 0.0, 200.0);
        losses += payload
            .log()
            .iter()
            .filter(|line| line.contains("bottom lock lost"))
            .count();
        without += lines.iter().filter(|line| field(line, 7) == 0.0).count();
        all += lines.len();
    }
    // 4000 s have 133 losses of 2 s, less those that overlap.
    assert!((95..165).contains(&losses), "{losses}");
    let share = without as f64 / all as f64;
    assert!((0.045..0.085).contains(&share), "{share}");
}

#[test]
fn a_dvl_without_a_phased_array_has_the_error_of_the_speed_of_sound() {
    let text = with(
        &with(CALM, "sensors", "ctd_fitted = false"),
        "sensors.sound",
        "nominal_mps = 1650",
    );
    let speed = |text: &str| {
        let (_, lines) = heard(text, 1, "NVR", 100.0, 101.0);
        field(lines.last().expect("velocity"), 3)
    };
    let exact = speed(&text);
    let wrong = speed(&with(&text, "sensors.dvl", "phased_array = false"));
    assert!((exact - 2.0).abs() < 0.01, "{exact}");
    assert!((wrong / exact - 1650.0 / 1497.3).abs() < 0.003, "{wrong} {exact}");
}

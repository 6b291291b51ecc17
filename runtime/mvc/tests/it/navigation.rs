use backseat_units::{Heading, utm_convergence_deg};

use crate::files::{CALM, LIVELY};
use crate::payload::Payload;

fn field(line: &str, index: usize) -> f64 {
    line.split(',')
        .nth(index)
        .and_then(|field| field.parse().ok())
        .expect("a number")
}

#[test]
fn navigation_comes_at_ten_hertz_in_pairs_with_one_stamp() {
    let mut payload = Payload::connected(CALM, 1, &["NVG", "NVR"]);
    payload.until(2.0);
    let heard = payload.heard();
    assert_eq!(heard.len(), 40);
    for (tick, pair) in heard.chunks(2).enumerate() {
        let millis = (tick + 1) * 100;
        let stamp = format!("0800{:02}.{:03}", millis / 1000, millis % 1000);
        assert!(pair[0].starts_with(&format!("$BFNVG,{stamp},")) && pair[0].ends_with(&format!(",{stamp}")));
        assert!(pair[1].starts_with(&format!("$BFNVR,{stamp},")));
    }
}

#[test]
fn the_heading_is_the_grids() {
    let mut payload = Payload::connected(LIVELY, 1, &["NVG"]);
    payload.until(60.0);
    let heard = payload.heard();
    let line = heard.last().expect("navigation");
    let truth = payload.mvc.truth();
    // 66.1 W is 2.9 degrees east of its zone's meridian: nearly two degrees of convergence.
    let convergence_deg = utm_convergence_deg(truth.position);
    assert!(convergence_deg.abs() > 1.5, "{convergence_deg}");
    let expected = Heading::from_deg(truth.heading_deg)
        .unwrap()
        .to_grid(convergence_deg)
        .as_deg();
    let off_deg = backseat_units::math::wrap_180(field(line, 9) - expected);
    assert!(off_deg.abs() < 0.3, "{line} {expected}");
}

#[test]
fn quality_is_one_on_the_surface_and_none_below() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    payload.until(1.0);
    assert!(payload.heard().iter().all(|line| field(line, 6) == 1.0));
    payload.until(60.0);
    assert!(payload.heard().last().is_some_and(|line| field(line, 6) == 0.0));
}

#[test]
fn altitude_without_bottom_lock_reads_zero() {
    let text = CALM.replace("[sensors]", "[sensors]\naltitude_range_m = 55").replace(
        "altitude_dropouts_per_h = 0",
        "altitude_dropouts_per_h = 300\naltitude_dropout_s = 2",
    );
    let mut payload = Payload::connected(&text, 1, &["NVG"]);
    payload.until(1.0);
    assert!(
        payload
            .heard()
            .iter()
            .all(|line| line.split(',').nth(7) == Some("0.000")),
        "60 m is out of range"
    );
    payload.until(60.0);
    payload.heard();
    payload.until(180.0);
    let readings: Vec<f64> = payload.heard().iter().map(|line| field(line, 7)).collect();
    let lost = readings.iter().filter(|metres| **metres == 0.0).count();
    assert!((50..600).contains(&lost), "{lost} of {}", readings.len());
    assert!(
        readings
            .iter()
            .all(|metres| *metres == 0.0 || (metres - 50.0).abs() < 0.3)
    );
}

#[test]
fn the_ctd_measures_the_plume() {
    let mut payload = Payload::connected(LIVELY, 2, &["CTD"]);
    payload.until(400.0);
    let mut heard = payload.heard();
    heard.retain(|line| line.starts_with("$BFCTD"));
    assert!((398..=401).contains(&heard.len()), "{}", heard.len());
    let truth = payload.mvc.truth();
    let line = heard.last().expect("a reading");
    let expected = payload
        .mvc
        .world()
        .temperature_c(truth.local, truth.depth_m, payload.now);
    assert!((field(line, 3) - expected).abs() < 0.1, "{line} {expected}");
    assert!(
        (field(line, 4) - 101.325 - 10.052 * truth.depth_m).abs() < 3.0,
        "{line}"
    );
}

#[test]
fn position_drifts_under_water_and_stays_near_the_truth() {
    let mut payload = Payload::connected(LIVELY, 5, &["NVG"]);
    payload.until(300.0);
    let line = payload.heard().pop().expect("navigation");
    let degrees = |value: f64| (value / 100.0).trunc() + value % 100.0 / 60.0;
    let truth = payload.mvc.truth();
    let north_m = (degrees(field(&line, 2)) - truth.position.latitude.as_deg()) * 111_000.0;
    let east_m = (-degrees(field(&line, 4)) - truth.position.longitude.as_deg()) * 82_000.0;
    let off_m = (north_m * north_m + east_m * east_m).sqrt();
    assert!(off_m > 0.001 && off_m < 8.0, "{off_m}");
}

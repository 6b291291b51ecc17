//! Wrong clocks: the vehicle's clock is hours away from ours, or is set during the dive. A request lasts by time that
//! is not affected. Only zones with a time window need the right time, and they stay closed.

use std::time::Duration;

use backseat_suite::{Line, Mission, Signal, Vehicle, settle};

use super::session::{SOON, runtime, steers};

/// The time of day in the vehicle's navigation, seconds.
fn said_s(line: &Line) -> f64 {
    let time = line.field(1);
    let part = |range: std::ops::Range<usize>| time[range].parse::<f64>().expect("a time is digits");
    part(0..2) * 3600.0 + part(2..4) * 60.0 + part(4..time.len())
}

/// The steady mission on a vehicle whose clock is hours away from ours: set by a third of a day, at the hours at which
/// the two would otherwise agree.
fn hours_apart() -> Mission {
    let now = std::process::Command::new("date").args(["-u", "+%H"]).output();
    let hour: u32 = String::from_utf8_lossy(&now.expect("there is `date`").stdout)
        .trim()
        .parse()
        .expect("an hour is a number");
    let other = (hour + 8) % 24;
    Mission::steady().edit(
        "world.toml",
        "utc = 2026-06-01T08:00:00Z",
        &format!("utc = 2026-06-01T{other:02}:00:00Z"),
    )
}

#[test]
fn a_vehicle_whose_clock_is_hours_away_is_steered_but_not_by_zones_that_need_the_hour() {
    let mission = hours_apart();
    let vehicle = Vehicle::start(&mission);
    let _runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 4, SOON);

    // The same box, with a window from long ago into the far future.
    let mission = hours_apart().edit(
        "fence.geojson",
        "\"kind\": \"keep-in\",",
        "\"kind\": \"keep-in\", \"valid_from\": \"2020-01-01T00:00:00Z\", \"valid_until\": \"2100-01-01T00:00:00Z\",",
    );
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    runtime.says("control granted", SOON);
    runtime.says("rejected", SOON);
    settle(Duration::from_secs(3));
    assert!(!vehicle.lines().iter().any(steers), "{}", vehicle.story());
}

#[test]
fn sr_008_a_vehicles_clock_that_is_stepped_ends_no_promise() {
    for by_s in [7200, -7200] {
        let mission = Mission::steady().append(
            "world.toml",
            &format!("[[faults.fault]]\nkind = \"clock_step\"\nat_s = 20\nby_s = {by_s}"),
        );
        let vehicle = Vehicle::start(&mission);
        let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
        vehicle.receives("BPRMB", 2, SOON);
        let stepped = vehicle.sees("the step", SOON, |line| {
            line.name() == "BFNVG" && (said_s(line) - 8.0 * 3600.0 - line.at_s - f64::from(by_s)).abs() < 1.0
        });
        vehicle.sees("the runtime steer again", Duration::from_secs(120), |line| {
            line.is_received("BPRMB") && line.at_s > stepped.at_s + 3.0
        });
        // While its navigation was not trusted, the runtime refreshed nothing, and the vehicle ended the modify in
        // time.
        let lines = vehicle.lines();
        let mut last: Option<f64> = None;
        for line in &lines {
            if line.is_received("BPRMB") {
                last = Some(line.at_s);
            } else if line.text.starts_with("modify ended: ")
                && let Some(last_s) = last
            {
                assert!(line.at_s - last_s <= 5.2, "{:.3} s", line.at_s - last_s);
            }
        }
        assert!(!runtime.stderr().contains("panicked"), "{}", runtime.stderr());
    }
}

/// A runtime that is armed meets a vehicle at another speed. Returns the rate that its screen names.
fn named_and_not_steered(speed: &str) -> f64 {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 6000");
    let vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &["--speed", speed]);
    let mut runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    let line = runtime.says("times as fast as this computer's", SOON);
    let rate = line
        .split_once("clock runs ")
        .and_then(|(_, after)| after.split(' ').next());
    assert!(line.contains("nothing may steer"), "{line}");
    settle(Duration::from_secs(12));
    assert!(!vehicle.lines().iter().any(steers), "{}", vehicle.story());
    runtime.signal(Signal::TERM);
    assert_eq!(runtime.wait(SOON), Some(0), "{}", runtime.stderr());
    let said = runtime.stderr();
    assert_eq!(said.matches("times as fast").count(), 1, "one line says it\n{said}");
    rate.and_then(|rate| rate.parse().ok()).expect("the line has a rate")
}

#[test]
fn a_vehicle_whose_clock_runs_faster_is_named_and_not_steered() {
    let rate = named_and_not_steered("20");
    assert!((15.0..25.0).contains(&rate), "{rate}");
    let rate = named_and_not_steered("1.5");
    assert!((1.4..1.6).contains(&rate), "{rate}");
}

#[test]
fn a_vehicle_whose_clock_runs_slower_is_named_and_not_steered() {
    let rate = named_and_not_steered("0.5");
    assert!((0.4..0.6).contains(&rate), "{rate}");
}

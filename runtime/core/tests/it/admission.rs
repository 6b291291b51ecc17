//! What a request must be before its geometry is judged at all.

use backseat_core::plugin::{Judge, Request};

use crate::course::{circle, envelope, limits, line};
use crate::trial::Trial;

/// The exact cause for which the monitor refuses a request; "" if it does not.
fn cause(request: &Request) -> &'static str {
    let mut trial = Trial::under_way();
    trial.run_for(1.0);
    let (_, input) = trial.steps(0).pop().expect("the plugin was stepped");
    let judged = envelope(limits()).judge(request, &input);
    judged.err().map_or("", |refusal| refusal.cause())
}

#[test]
fn a_circle_is_within_what_the_vehicle_can_turn_and_ten_kilometres() {
    let of_radius = |radius_m| cause(&Request::Trackcircle(circle(1, (0.0, 500.0), radius_m)));
    // At 1.5 m/s and 8 degrees a second.
    let least_m = 1.5 / 8.0_f64.to_radians();
    for radius_m in [least_m - 0.01, 0.0, -50.0, 10_000.1, f64::NAN, f64::INFINITY] {
        assert_eq!(of_radius(radius_m), "circle-radius", "{radius_m} m");
    }
    for radius_m in [least_m + 0.01, 50.0] {
        assert_eq!(of_radius(radius_m), "", "{radius_m} m");
    }
    // It does not fit into the fence, but its radius is no fault.
    assert_eq!(of_radius(10_000.0), "keep-in");
}

#[test]
fn a_circle_has_more_than_no_and_at_most_a_hundred_orbits() {
    let of_orbits = |orbits| {
        let mut circle = circle(1, (0.0, 500.0), 50.0);
        circle.orbits = orbits;
        cause(&Request::Trackcircle(circle))
    };
    for orbits in [0.0, -0.0, 100.1, -100.1, f64::NAN, f64::INFINITY] {
        assert_eq!(of_orbits(orbits), "circle-orbits", "{orbits}");
    }
    // A hundred orbits take longer than inserts may, which the judgement of geometry does not ask.
    for orbits in [0.1, -0.1, 100.0, -100.0] {
        assert_eq!(of_orbits(orbits), "", "{orbits}");
    }
}

#[test]
fn a_line_is_at_least_a_metre_long() {
    let of_length = |length_m| cause(&Request::Trackline(line(1, (0.0, 500.0), (length_m, 500.0))));
    for length_m in [0.0, 0.9] {
        assert_eq!(of_length(length_m), "trackline-length", "{length_m} m");
    }
    assert_eq!(of_length(1.1), "");
}

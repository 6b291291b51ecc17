//! Compares the body with what is published about it.
//!
//! Two figures are published: 31.9 kg, and 2.5 m/s at 1525 turns a minute (`remus100.m`, Marine Systems Simulator). The
//! other references are solutions of the published equations by an independent program: it has full matrices with Euler
//! angles in the velocity over ground (numpy, Runge-Kutta, 5 and 10 ms), the published limit and lags of the fins, and
//! no code in common with this one. The two may differ in the lift at large angles of attack, which is ours
//! ([`super::forces`]), and by the integrators.

use backseat_units::EastNorth;
use backseat_units::math::{exp, hypot, wrap_180};

use super::coefficients::Coefficients;
use super::{Actuators, STEP_MAX_S, SixDof};

const STILL: (f64, f64, f64) = (0.0, 0.0, 0.0);

fn neutral(depth_m: f64) -> SixDof {
    SixDof::new(EastNorth::default(), depth_m, 0.0, 0.0)
}

fn tail(rudder_deg: f64, stern_plane_deg: f64, propeller_rpm: f64) -> Actuators {
    Actuators {
        rudder_deg,
        stern_plane_deg,
        propeller_rpm,
    }
}

fn run(vehicle: &mut SixDof, command: Actuators, current: (f64, f64, f64), seconds: f64) {
    vehicle.step(command, current, seconds);
}

#[track_caller]
fn near(what: &str, value: f64, wanted: f64, tolerance: f64) {
    assert!(
        (value - wanted).abs() <= tolerance,
        "{what}: {value}, published {wanted}"
    );
}

/// Compares with a state of a reference run: north, east, down (metres), roll, pitch, heading (radians).
fn near_track(what: &str, vehicle: &SixDof, reference: [f64; 6], metres: f64, degrees: f64) {
    let [north_m, east_m, down_m, roll, pitch, heading] = reference;
    near(what, vehicle.at().north_m, north_m, metres);
    near(what, vehicle.at().east_m, east_m, metres);
    near(what, vehicle.depth_m(), down_m, metres);
    near(what, vehicle.roll_deg(), roll.to_degrees(), degrees);
    near(what, vehicle.pitch_deg(), pitch.to_degrees(), degrees);
    near(
        what,
        wrap_180(vehicle.heading_deg() - heading.to_degrees()),
        0.0,
        degrees,
    );
}

#[test]
fn terminal_speed_is_the_published_one() {
    let mut vehicle = neutral(50.0);
    run(&mut vehicle, tail(0.0, 0.0, 1525.0), STILL, 60.0);
    // The figure is published to one decimal; the equations balance at 2.540.
    near("speed at 1525", vehicle.velocity()[0], 2.5, 0.05);
    for (rpm, mps) in [
        (1525.0, 2.540_182),
        (1300.0, 2.165_321),
        (1000.0, 1.665_222),
        (700.0, 1.163_779),
    ] {
        let mut vehicle = neutral(50.0);
        run(&mut vehicle, tail(0.0, 0.0, rpm), STILL, 60.0);
        near("speed by the equations", vehicle.velocity()[0], mps, 1e-4);
    }
}

#[test]
fn propeller_heels_the_body_as_published() {
    for (rpm, roll_deg) in [(1525.0, 0.9968), (1000.0, 0.4288)] {
        let mut vehicle = neutral(50.0);
        run(&mut vehicle, tail(0.0, 0.0, rpm), STILL, 60.0);
        near("roll", vehicle.roll_deg(), roll_deg, 0.001);
    }
}

/// Turns a minute and rudder in degrees; then speed in metres a second, rate of turn in degrees a second, radius in
/// metres, roll in degrees.
const CIRCLES: [[f64; 6]; 6] = [
    [1525.0, 5.0, 2.530_049, 3.791_660, 38.231_335, 1.974_710],
    [1525.0, 10.0, 2.513_163, 6.234_901, 23.093_873, 2.591_808],
    [1525.0, 15.0, 2.490_825, 8.248_455, 17.299_991, 3.085_351],
    [1000.0, 5.0, 1.659_363, 2.169_872, 43.815_709, 0.796_437],
    [1000.0, 10.0, 1.648_895, 3.646_541, 25.907_995, 1.043_053],
    [1000.0, 15.0, 1.634_745, 4.876_283, 19.207_965, 1.243_723],
];

#[test]
fn steady_circles_are_the_published_equations() {
    for [rpm, rudder_deg, mps, dps, radius_m, roll_deg] in CIRCLES {
        for side in [1.0, -1.0] {
            let mut vehicle = neutral(50.0);
            run(&mut vehicle, tail(side * rudder_deg, 0.0, rpm), STILL, 60.0);
            let [u, v, w, ..] = vehicle.velocity();
            let (east, north, _) = vehicle.ground_velocity();
            let rate_dps = vehicle.attitude_rates_dps().2;
            let ground_mps = hypot(east, north);
            near("speed", (u * u + v * v + w * w).sqrt(), mps, 0.002);
            near("rate of turn", side * rate_dps, dps, 0.003 * dps);
            near("radius", side * ground_mps / rate_dps.to_radians(), radius_m, 0.05);
            // The propeller heels the body to one side, so the roll in a turn to port differs.
            if side > 0.0 {
                near("roll", vehicle.roll_deg(), roll_deg, 0.01);
            }
        }
    }
}

#[test]
fn step_inputs_give_the_track_of_the_reference() {
    // Fossen's open-loop demonstration: rudder 5 degrees for 100 s, stern planes -5 degrees for 50 s, full propeller.
    let reference = [
        (5.0, [7.766_006, 0.389_288, 79.846_508, 0.034_348, 0.149_903, 0.209_157]),
        (
            10.0,
            [19.359_266, 4.033_367, 76.875_894, 0.038_638, 0.319_469, 0.559_655],
        ),
        (
            25.0,
            [37.806_750, 32.894_845, 64.687_472, 0.038_998, 0.338_640, 1.608_850],
        ),
        (
            50.0,
            [-0.891_521, 68.250_033, 44.213_837, 0.038_998, 0.338_640, 3.357_472],
        ),
        (
            75.0,
            [-32.970_986, 22.201_972, 42.071_143, 0.034_465, -0.005_420, 5.004_105],
        ),
        (
            100.0,
            [15.623_006, -6.189_477, 42.295_939, 0.034_465, -0.005_420, 6.658_529],
        ),
        (
            120.0,
            [62.641_963, 12.995_207, 42.310_252, 0.017_473, -0.000_001, 6.689_320],
        ),
    ];
    let mut vehicle = neutral(80.0);
    let mut now_s = 0.0;
    for (at_s, state) in reference {
        let command = tail(
            if now_s < 100.0 { 5.0 } else { 0.0 },
            if now_s < 50.0 { -5.0 } else { 0.0 },
            1525.0,
        );
        run(&mut vehicle, command, STILL, at_s - now_s);
        now_s = at_s;
        // Over 300 m, the track agrees within a centimetre and a hundredth of a degree.
        near_track(&format!("after {at_s} s"), &vehicle, state, 0.01, 0.01);
    }
}

#[test]
fn a_current_carries_as_in_the_reference() {
    // 0.5 m/s towards 30 degrees and 0.1 m/s down, starting at rest in the water; stern planes 3 degrees for 20 s, 1300
    // turns a minute.
    let angle = 30_f64.to_radians();
    let current = (
        0.5 * backseat_units::math::sin(angle),
        0.5 * backseat_units::math::cos(angle),
        0.1,
    );
    let reference = [
        (
            10.0,
            3.0,
            [21.366_522, 2.478_088, 22.888_515, 0.012_799, -0.151_195, -0.001_791],
        ),
        (20.0, 3.0, [f64::NAN; 6]),
        (
            30.0,
            0.0,
            [73.050_085, 7.432_646, 28.843_786, 0.012_643, 0.000_197, 0.000_139],
        ),
        (
            60.0,
            0.0,
            [151.000_102, 14.939_600, 31.843_173, 0.012_643, 0.0, 0.000_136],
        ),
    ];
    let mut vehicle = neutral(20.0);
    let mut now_s = 0.0;
    for (at_s, stern_plane_deg, state) in reference {
        run(&mut vehicle, tail(0.0, stern_plane_deg, 1300.0), current, at_s - now_s);
        now_s = at_s;
        if state[0].is_finite() {
            near_track(&format!("after {at_s} s"), &vehicle, state, 0.01, 0.01);
        }
    }
}

#[test]
fn depth_step_under_the_published_autopilot_follows_the_reference() {
    // Fossen's depth autopilot (successive loops, `SIMremus100.m`), from 0 to 10 m at 1300 turns a minute, sampled at
    // 50 Hz. Its low-pass filter of 0.02 rad/s makes the dive slow and without overshoot.
    let reference = [
        (10.0, 0.954_100, -0.082_988),
        (25.0, 3.428_881, -0.068_515),
        (50.0, 6.184_574, -0.039_888),
        (75.0, 7.801_110, -0.023_475),
        (100.0, 8.751_837, -0.013_778),
        (150.0, 9.630_207, -0.004_612),
        (200.0, 9.916_672, -0.001_430),
        (300.0, 10.018_594, -0.000_043),
    ];
    let mut vehicle = neutral(0.0);
    vehicle.state.velocity[0] = 1.0;
    vehicle.tail.now.propeller_rpm = 1000.0;
    let (mut wanted_m, mut depth_integral, mut pitch_integral) = (0.0, 0.0, 0.0);
    let mut steps = 0_u32;
    for (at_s, depth_m, pitch) in reference {
        while f64::from(steps) * STEP_MAX_S < at_s - 1e-6 {
            let [u, _, w, _, q, _] = vehicle.velocity();
            let bandwidth = if hypot(u, w) < 1.0 { 0.01 } else { 0.02 };
            wanted_m += (1.0 - exp(-STEP_MAX_S * bandwidth)) * (10.0 - wanted_m);
            let depth_error = vehicle.depth_m() - wanted_m;
            let pitch_error = vehicle.pitch_deg().to_radians() - 0.1 * (depth_error + depth_integral / 100.0);
            let stern_plane = 5.0 * pitch_error + 2.0 * q + 0.3 * pitch_integral + 5.0 * w;
            depth_integral += STEP_MAX_S * depth_error;
            pitch_integral += STEP_MAX_S * pitch_error;
            vehicle.step(tail(0.0, stern_plane.to_degrees(), 1300.0), STILL, STEP_MAX_S);
            steps += 1;
        }
        near("depth", vehicle.depth_m(), depth_m, 0.01);
        near("pitch", vehicle.pitch_deg(), f64::to_degrees(pitch), 0.01);
    }
}

#[test]
fn righting_moment_acts_as_in_the_reference() {
    // Released at rest, with a roll of 30 and a pitch of 20 degrees.
    let mut vehicle = neutral(20.0);
    vehicle.state.attitude = attitude(30.0, 20.0);
    near("roll", vehicle.roll_deg(), 30.0, 1e-9);
    near("pitch", vehicle.pitch_deg(), 20.0, 1e-9);
    let mut now_s = 0.0;
    for (at_s, roll, pitch) in [
        (1.0, 0.053_393, 0.271_812),
        (2.0, 0.003_941, 0.163_709),
        (5.0, -0.000_023, 0.013_450),
        (20.0, 0.0, 0.0),
    ] {
        run(&mut vehicle, tail(0.0, 0.0, 0.0), STILL, at_s - now_s);
        now_s = at_s;
        near("roll", vehicle.roll_deg(), f64::to_degrees(roll), 0.01);
        near("pitch", vehicle.pitch_deg(), f64::to_degrees(pitch), 0.01);
    }
}

/// An attitude with heading north.
fn attitude(roll_deg: f64, pitch_deg: f64) -> super::attitude::Attitude {
    use backseat_units::math::sin_cos;
    let (sr, cr) = sin_cos(0.5 * roll_deg.to_radians());
    let (sp, cp) = sin_cos(0.5 * pitch_deg.to_radians());
    super::attitude::Attitude(nalgebra::Quaternion::new(cr * cp, sr * cp, cr * sp, -sr * sp))
}

#[test]
fn a_neutral_vehicle_at_rest_stays_in_place() {
    let mut vehicle = SixDof::new(EastNorth::new(3.0, 4.0), 20.0, 123.0, 0.0);
    run(&mut vehicle, Actuators::default(), STILL, 600.0);
    assert_eq!(vehicle.at(), EastNorth::new(3.0, 4.0));
    assert_eq!(vehicle.depth_m(), 20.0);
    near("heading", vehicle.heading_deg(), 123.0, 1e-9);
    assert_eq!(vehicle.velocity(), [0.0; 6]);
}

#[test]
fn without_a_propeller_energy_only_falls() {
    // Forces that are skew-symmetric in the velocity do no work. A wrong sign in one of them would show here.
    for case in 0..64_u32 {
        let part =
            |salt: u32| f64::from((case + 1).wrapping_mul(2_654_435_761).rotate_left(salt) % 2001) / 1000.0 - 1.0;
        let mut vehicle = neutral(1000.0);
        vehicle.state.attitude = attitude(170.0 * part(3), 85.0 * part(7));
        for (i, velocity) in vehicle.state.velocity.iter_mut().enumerate() {
            *velocity = part(5 * i as u32 + 1) * 2.0;
        }
        let mut before = vehicle.energy_j();
        for _ in 0..500 {
            run(&mut vehicle, Actuators::default(), STILL, STEP_MAX_S);
            let now = vehicle.energy_j();
            assert!(now <= before + 1e-6 * before, "case {case}: {before} to {now}");
            before = now;
        }
        assert!(before < 30.0, "case {case}: {before} J are left after 10 s");
    }
}

#[test]
fn at_fifty_hertz_the_integrator_is_stable_and_exact_enough() {
    // The hardest manoeuvre that the tail can do, with steps at 50 Hz, half and a tenth as long.
    let fly = |step_s: f64| {
        let mut vehicle = neutral(500.0);
        for i in 0..(60.0 / step_s).round() as u32 {
            let seconds = f64::from(i) * step_s + 1e-9;
            let side = if seconds % 8.0 < 4.0 { 1.0 } else { -1.0 };
            vehicle.step(tail(15.0 * side, -15.0 * side, 1525.0), STILL, step_s);
        }
        vehicle
    };
    let (coarse, fine, finest) = (fly(0.02), fly(0.01), fly(0.002));
    for vehicle in [&coarse, &fine] {
        near("east", vehicle.at().east_m, finest.at().east_m, 0.02);
        near("north", vehicle.at().north_m, finest.at().north_m, 0.02);
        near("down", vehicle.depth_m(), finest.depth_m(), 0.02);
        near("heading", vehicle.heading_deg(), finest.heading_deg(), 0.05);
    }
}

#[test]
fn a_current_carries_a_drifter_and_adds_to_a_moving_vehicle() {
    let current = (0.4, -0.3, 0.0);
    let mut still = neutral(20.0);
    let mut carried = neutral(20.0);
    run(&mut carried, Actuators::default(), current, 100.0);
    near("east", carried.at().east_m, 40.0, 1e-6);
    near("north", carried.at().north_m, -30.0, 1e-6);
    let mut carried = neutral(20.0);
    for vehicle in [(&mut still, STILL), (&mut carried, current)] {
        run(vehicle.0, tail(4.0, 1.0, 1200.0), vehicle.1, 100.0);
    }
    near("east", carried.at().east_m - still.at().east_m, 40.0, 1e-6);
    near("north", carried.at().north_m - still.at().north_m, -30.0, 1e-6);
    let (east, north, _) = carried.ground_velocity();
    let (through_east, through_north, _) = still.ground_velocity();
    near("east", east, through_east + 0.4, 1e-9);
    near("north", north, through_north - 0.3, 1e-9);
}

#[test]
fn a_new_current_takes_time_to_carry_the_vehicle() {
    let mut vehicle = neutral(20.0);
    run(&mut vehicle, Actuators::default(), STILL, 1.0);
    run(&mut vehicle, Actuators::default(), (0.5, 0.0, 0.0), 0.02);
    // The current comes from the side. At first the body stays at rest over ground, and the water flows past it.
    near("at once", vehicle.ground_velocity().0, 0.0, 0.02);
    run(&mut vehicle, Actuators::default(), (0.5, 0.0, 0.0), 120.0);
    near("in the end", vehicle.ground_velocity().0, 0.5, 0.05);
}

#[test]
fn buoyancy_brings_it_to_the_surface_and_no_further() {
    let mut vehicle = SixDof::rising_at(EastNorth::default(), 5.0, 0.0, 0.1);
    run(&mut vehicle, Actuators::default(), STILL, 30.0);
    near("rise", vehicle.ground_velocity().2, -0.1, 0.002);
    let mut least_m = f64::INFINITY;
    for _ in 0..3000 {
        run(&mut vehicle, Actuators::default(), STILL, STEP_MAX_S);
        least_m = least_m.min(vehicle.depth_m());
    }
    assert!(least_m >= 0.0 && vehicle.depth_m() < 0.05, "{}", vehicle.depth_m());
    near("speed", hypot(vehicle.velocity()[0], vehicle.velocity()[1]), 0.0, 0.01);
    // With full power and the nose up it does not leave the water either.
    let mut vehicle = SixDof::rising_at(EastNorth::default(), 5.0, 0.0, 0.1);
    for _ in 0..3000 {
        run(&mut vehicle, tail(0.0, -15.0, 1525.0), STILL, STEP_MAX_S);
        assert!(vehicle.depth_m() >= 0.0);
    }
}

#[test]
fn no_order_and_no_current_makes_its_state_nan() {
    let mut vehicle = neutral(20.0);
    for value in [f64::NAN, f64::INFINITY, -1e300] {
        run(&mut vehicle, tail(value, value, value), STILL, 1.0);
        run(&mut vehicle, Actuators::default(), STILL, value.min(0.0));
    }
    run(&mut vehicle, tail(15.0, 15.0, -1525.0), (20.0, 20.0, 20.0), 10.0);
    run(&mut vehicle, tail(15.0, 15.0, -1525.0), (-20.0, -20.0, -20.0), 10.0);
    run(
        &mut vehicle,
        tail(15.0, 15.0, -1525.0),
        (f64::NAN, 1e300, -f64::INFINITY),
        10.0,
    );
    assert!(vehicle.velocity().iter().all(|value| value.is_finite()));
    assert!(vehicle.depth_m().is_finite() && vehicle.heading_deg().is_finite());
}

#[test]
fn the_propeller_reaches_the_speed_that_it_is_set_for() {
    let coefficients = Coefficients::remus_100();
    for mps in [0.6, 1.0, 1.7, 2.5] {
        let mut vehicle = neutral(50.0);
        let rpm = super::autopilot::rpm_for(&coefficients, mps);
        run(&mut vehicle, tail(0.0, 0.0, rpm), STILL, 120.0);
        near("speed", vehicle.velocity()[0], mps, 0.002);
    }
}

#[test]
fn results_are_bit_identical_on_all_platforms() {
    // The result is the same in debug and release builds and on all processors, because the code uses elementary
    // arithmetic and libm only.
    let mut vehicle = SixDof::rising_at(EastNorth::default(), 20.0, 33.0, 0.1);
    run(&mut vehicle, tail(7.0, 4.0, 1400.0), (0.3, -0.2, 0.05), 30.0);
    let seen = [
        vehicle.at().east_m,
        vehicle.at().north_m,
        vehicle.depth_m(),
        vehicle.heading_deg(),
    ];
    assert_eq!(
        seen,
        [
            60.88372122739766,
            -5.306029262429202,
            33.77251853408242,
            156.23145456264038
        ]
    );
}

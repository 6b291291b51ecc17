//! Manoeuvres of the piloted vehicle: how the autopilot carries out orders, and the limits that it keeps.
//!
//! The figures here are requirements of this project. The published ones are in [`super::published`].

use backseat_plan::VehicleClass;
use backseat_units::math::wrap_180;
use backseat_units::{EastNorth, Timestamp};

use super::piloted::Motion;
use super::{Actuators, Helm, Orders, Piloted, STEP_MAX_S, SixDof, Steering, Surroundings, Throttle, Trim};
use crate::estimate::Estimate;
use crate::plan::Shape;
use crate::plan::course::{Course, Way, crabbed_deg};
use crate::vehicle::performance::Performance;

const TORPEDOES: [VehicleClass; 3] = [
    VehicleClass::NineInch,
    VehicleClass::TwelveInch,
    VehicleClass::TwentyOneInch,
];

fn open_sea() -> Surroundings {
    Surroundings {
        water_depth_m: 1000.0,
        gradient: EastNorth::default(),
        current: (0.0, 0.0, 0.0),
    }
}

fn orders(heading_deg: f64, trim: Trim, speed_mps: f64) -> Orders {
    Orders {
        steering: Steering::Heading(heading_deg),
        trim,
        throttle: Throttle::Speed(speed_mps),
    }
}

fn vehicle(class: VehicleClass, depth_m: f64) -> Piloted {
    Piloted::new(Performance::of(class), 2.0, EastNorth::default(), depth_m, 0.0)
}

/// Flies at 10 Hz, like the mock, and calls `each` after every step.
fn fly(vehicle: &mut Piloted, orders: Orders, around: &Surroundings, seconds: u32, mut each: impl FnMut(f64, &Motion)) {
    for i in 1..=10 * seconds {
        vehicle.drive(&Helm::Under(orders), around, 0.1);
        each(f64::from(i) * 0.1, &vehicle.motion());
    }
}

/// The times at which the response first reaches 10 % and 90 % of the step, and the overshoot as a share of the step.
#[derive(Default)]
struct Response {
    tenth_s: Option<f64>,
    nine_tenths_s: Option<f64>,
    overshoot: f64,
}

impl Response {
    fn see(&mut self, at_s: f64, share: f64) {
        if share >= 0.1 {
            self.tenth_s.get_or_insert(at_s);
        }
        if share >= 0.9 {
            self.nine_tenths_s.get_or_insert(at_s);
        }
        self.overshoot = self.overshoot.max(share - 1.0);
    }

    fn rise_s(&self) -> f64 {
        self.nine_tenths_s.unwrap() - self.tenth_s.unwrap()
    }
}

#[test]
fn dives_to_a_depth_and_holds_it() {
    for class in TORPEDOES {
        let mut vehicle = vehicle(class, 5.0);
        let performance = *vehicle.performance();
        fly(
            &mut vehicle,
            orders(0.0, Trim::Depth(5.0), 1.5),
            &open_sea(),
            60,
            |_, _| {},
        );
        let (mut response, mut steepest_deg) = (Response::default(), 0.0_f64);
        fly(
            &mut vehicle,
            orders(0.0, Trim::Depth(15.0), 1.5),
            &open_sea(),
            120,
            |at_s, motion| {
                response.see(at_s, (motion.depth_m - 5.0) / 10.0);
                steepest_deg = steepest_deg.max(motion.pitch_deg.abs());
            },
        );
        let motion = vehicle.motion();
        // The gain of the vehicle class sets the pace: a first-order response rises in 2.2 time constants.
        let pace_s = 2.2 / performance.depth_gain_per_s;
        assert!(
            (0.6 * pace_s..9.8 * pace_s).contains(&response.rise_s()),
            "{class:?} {}",
            response.rise_s()
        );
        assert!(response.overshoot < 0.05, "{class:?} {}", response.overshoot);
        assert!(
            steepest_deg <= performance.pitch_max_deg + 1.0,
            "{class:?} {steepest_deg}"
        );
        assert!((motion.depth_m - 15.0).abs() < 0.1, "{class:?} {}", motion.depth_m);
        assert!((motion.surge_mps - 1.5).abs() < 0.02, "{class:?} {}", motion.surge_mps);
    }
}

#[test]
fn dives_from_the_surface_at_the_least_speed() {
    let mut vehicle = vehicle(VehicleClass::TwelveInch, 0.0);
    let least_mps = vehicle.performance().speed_min_mps;
    fly(
        &mut vehicle,
        orders(0.0, Trim::Depth(5.0), least_mps),
        &open_sea(),
        300,
        |_, _| {},
    );
    let motion = vehicle.motion();
    assert!((motion.depth_m - 5.0).abs() < 0.2, "{motion:?}");
}

#[test]
fn turns_to_a_heading_without_hunting() {
    for speed_mps in [1.0, 1.5, 2.3] {
        for turn_deg in [30.0, -120.0, 179.0] {
            let mut vehicle = vehicle(VehicleClass::NineInch, 10.0);
            fly(
                &mut vehicle,
                orders(0.0, Trim::Depth(10.0), speed_mps),
                &open_sea(),
                60,
                |_, _| {},
            );
            let (mut response, mut deepest_m) = (Response::default(), 0.0_f64);
            let (mut before_deg, mut turned_deg) = (vehicle.motion().heading_deg, 0.0);
            fly(
                &mut vehicle,
                orders(turn_deg, Trim::Depth(10.0), speed_mps),
                &open_sea(),
                150,
                |at_s, motion| {
                    turned_deg += wrap_180(motion.heading_deg - before_deg);
                    before_deg = motion.heading_deg;
                    response.see(at_s, turned_deg / turn_deg);
                    deepest_m = deepest_m.max((motion.depth_m - 10.0).abs());
                },
            );
            let off_deg = wrap_180(vehicle.motion().heading_deg - turn_deg);
            assert!(off_deg.abs() < 0.3, "{speed_mps} {turn_deg}: {off_deg}");
            assert!(response.overshoot * turn_deg.abs() < 4.0, "{speed_mps} {turn_deg}");
            assert!(deepest_m < 0.5, "{speed_mps} {turn_deg}: {deepest_m}");
        }
    }
}

#[test]
fn holds_pitch_fins_and_turns_as_ordered() {
    let mut vehicle = vehicle(VehicleClass::TwelveInch, 50.0);
    fly(
        &mut vehicle,
        orders(90.0, Trim::Pitch(-8.0), 2.0),
        &open_sea(),
        40,
        |_, _| {},
    );
    let motion = vehicle.motion();
    assert!((motion.pitch_deg + 8.0).abs() < 0.3, "{motion:?}");
    assert!(motion.heave_mps > 0.1);
    let by_hand = Orders {
        steering: Steering::Rudder(6.0),
        trim: Trim::Elevator(3.0),
        throttle: Throttle::Rpm(1200.0),
    };
    fly(&mut vehicle, by_hand, &open_sea(), 20, |_, _| {});
    let motion = vehicle.motion();
    assert!((motion.tail.rudder_deg - 6.0).abs() < 0.01 && (motion.tail.propeller_rpm - 1200.0).abs() < 1.0);
    assert!((motion.tail.elevator_deg() - 3.0).abs() < 0.01);
    assert!(motion.pitch_deg > 2.0 && motion.yaw_rate_dps > 2.0, "{motion:?}");
}

#[test]
fn altitude_follows_a_slope() {
    let mut vehicle = vehicle(VehicleClass::TwelveInch, 20.0);
    // First up the slope to the east, which rises one in twenty, then down.
    for (heading_deg, seconds) in [(90.0, 200), (270.0, 300)] {
        let mut furthest_m = 0.0_f64;
        for i in 0..10 * seconds {
            let around = Surroundings {
                water_depth_m: 40.0 - 0.05 * vehicle.motion().at.east_m,
                gradient: EastNorth::new(-0.05, 0.0),
                current: (0.0, 0.0, 0.0),
            };
            vehicle.drive(
                &Helm::Under(orders(heading_deg, Trim::Altitude(8.0), 1.5)),
                &around,
                0.1,
            );
            if i > 1000 {
                let altitude_m = around.water_depth_m - vehicle.motion().depth_m;
                furthest_m = furthest_m.max((altitude_m - 8.0).abs());
            }
        }
        assert!(furthest_m < 0.4, "{heading_deg}: {furthest_m}");
    }
}

#[test]
fn no_demand_exceeds_the_limits() {
    let trims = [
        Trim::Depth(5000.0),
        Trim::Altitude(0.0),
        Trim::Pitch(-30.0),
        Trim::Elevator(-15.0),
    ];
    for class in [VehicleClass::NineInch, VehicleClass::TwentyOneInch] {
        for trim in trims {
            for (steering, throttle) in [
                (Steering::Heading(90.0), Throttle::Speed(99.0)),
                (Steering::Rudder(15.0), Throttle::Rpm(9999.0)),
            ] {
                let order = Orders {
                    steering,
                    trim,
                    throttle,
                };
                let performance = Performance {
                    depth_max_m: 60.0,
                    speed_max_mps: 2.0,
                    ..*Performance::of(class)
                };
                let mut vehicle = Piloted::new(&performance, 2.0, EastNorth::default(), 0.0, 0.0);
                for _ in 0..3000 {
                    let at = vehicle.motion().at;
                    let around = Surroundings {
                        water_depth_m: (80.0 - 0.05 * at.east_m).max(5.0),
                        gradient: EastNorth::new(if at.east_m < 1500.0 { -0.05 } else { 0.0 }, 0.0),
                        current: (0.2, 0.1, 0.0),
                    };
                    vehicle.drive(&Helm::Under(order), &around, 0.1);
                    let motion = vehicle.motion();
                    let altitude_m = around.water_depth_m - motion.depth_m;
                    let case = format!("{class:?} {order:?} {motion:?}");
                    assert!(altitude_m > 1.0 && motion.depth_m <= 60.5, "{altitude_m} {case}");
                    assert!(motion.surge_mps <= 2.0, "{case}");
                    assert!(motion.pitch_deg.abs() <= performance.pitch_max_deg + 3.0, "{case}");
                }
            }
        }
    }
}

#[test]
fn a_held_vehicle_stays_and_one_adrift_floats_up_with_the_current() {
    let mut vehicle = vehicle(VehicleClass::NineInch, 3.0);
    let around = Surroundings {
        current: (0.3, 0.0, 0.0),
        ..open_sea()
    };
    for _ in 0..100 {
        vehicle.drive(&Helm::Held, &around, 0.1);
    }
    let held = vehicle.motion();
    assert_eq!(
        (held.at, held.depth_m, held.ground),
        (EastNorth::default(), 3.0, (0.0, 0.0))
    );
    fly(
        &mut vehicle,
        orders(0.0, Trim::Depth(5.0), 1.5),
        &around,
        100,
        |_, _| {},
    );
    let begin = vehicle.motion();
    for _ in 0..1200 {
        vehicle.drive(&Helm::Adrift, &around, 0.1);
    }
    let adrift = vehicle.motion();
    assert!(adrift.depth_m < 0.05 && adrift.surge_mps.abs() < 0.05, "{adrift:?}");
    assert!((adrift.ground.0 - 0.3).abs() < 0.02 && (adrift.at.east_m - begin.at.east_m - 36.0).abs() < 3.0);
    vehicle.drive(&Helm::Held, &around, 0.1);
    let held = vehicle.motion();
    assert_eq!((held.at, held.ground, held.surge_mps), (adrift.at, (0.0, 0.0), 0.0));
}

#[test]
fn the_seabed_stops_it() {
    let mut body = SixDof::new(EastNorth::default(), 9.0, 0.0, 0.0);
    for _ in 0..500 {
        let command = Actuators {
            stern_plane_deg: 15.0,
            propeller_rpm: 1525.0,
            ..Actuators::default()
        };
        body.step(command, (0.0, 0.0, 0.0), STEP_MAX_S);
        body.ground_at(10.0);
        assert!(body.depth_m() <= 10.0);
    }
    assert_eq!(body.depth_m(), 10.0);
    let mut vehicle = vehicle(VehicleClass::NineInch, 9.0);
    vehicle.drive(
        &Helm::Adrift,
        &Surroundings {
            water_depth_m: 8.0,
            ..open_sea()
        },
        0.1,
    );
    assert!(vehicle.motion().grounded && vehicle.motion().depth_m == 8.0);
}

#[test]
fn the_same_orders_give_the_same_bits() {
    let track = || {
        let mut vehicle = vehicle(VehicleClass::NineInch, 3.0);
        let mut seen = Vec::new();
        fly(
            &mut vehicle,
            orders(200.0, Trim::Depth(9.0), 1.7),
            &open_sea(),
            60,
            |_, motion| seen.push(*motion),
        );
        seen
    };
    assert_eq!(track(), track());
}

#[test]
fn surfaces_under_way_and_stays_up() {
    // The wrap-up of a mission does this. At the surface means less than 0.3 m deep, where GPS works.
    for class in TORPEDOES {
        let mut vehicle = vehicle(class, 12.0);
        fly(
            &mut vehicle,
            orders(30.0, Trim::Depth(12.0), 1.5),
            &open_sea(),
            30,
            |_, _| {},
        );
        let mut surfaced_s = None;
        let mut deepest_m = 0.0_f64;
        fly(
            &mut vehicle,
            orders(30.0, Trim::Depth(0.0), 1.5),
            &open_sea(),
            180,
            |at_s, motion| {
                assert!(motion.depth_m >= 0.0);
                if motion.depth_m < 0.3 {
                    surfaced_s.get_or_insert(at_s);
                }
                if surfaced_s.is_some() {
                    deepest_m = deepest_m.max(motion.depth_m);
                }
            },
        );
        assert!(surfaced_s.is_some_and(|at_s| at_s < 90.0), "{class:?} {surfaced_s:?}");
        assert!(deepest_m < 0.3, "{class:?} {deepest_m}");
        // It can dive again from there.
        fly(
            &mut vehicle,
            orders(30.0, Trim::Depth(6.0), 1.5),
            &open_sea(),
            120,
            |_, _| {},
        );
        assert!(
            (vehicle.motion().depth_m - 6.0).abs() < 0.1,
            "{class:?} {:?}",
            vehicle.motion()
        );
    }
}

#[test]
fn leaves_the_seabed_when_it_is_ordered_to() {
    let shallow = Surroundings {
        water_depth_m: 20.0,
        ..open_sea()
    };
    let mut vehicle = Piloted::new(
        Performance::of(VehicleClass::NineInch),
        0.0,
        EastNorth::default(),
        25.0,
        0.0,
    );
    vehicle.drive(&Helm::Held, &shallow, 0.1);
    assert!(vehicle.motion().grounded);
    fly(
        &mut vehicle,
        orders(0.0, Trim::Altitude(5.0), 1.5),
        &shallow,
        120,
        |_, _| {},
    );
    let motion = vehicle.motion();
    assert!(!motion.grounded && (motion.depth_m - 15.0).abs() < 0.1, "{motion:?}");
}

#[test]
fn speed_is_reached_and_held_in_turns_and_dives() {
    let mut vehicle = vehicle(VehicleClass::TwelveInch, 10.0);
    for (speed_mps, heading_deg, depth_m) in [(1.2, 0.0, 10.0), (2.0, 150.0, 25.0), (1.5, 10.0, 5.0)] {
        fly(
            &mut vehicle,
            orders(heading_deg, Trim::Depth(depth_m), speed_mps),
            &open_sea(),
            10,
            |_, _| {},
        );
        fly(
            &mut vehicle,
            orders(heading_deg, Trim::Depth(depth_m), speed_mps),
            &open_sea(),
            60,
            |_, motion| {
                assert!((motion.surge_mps - speed_mps).abs() < 0.1, "{speed_mps} {motion:?}");
            },
        );
    }
}

#[test]
fn the_length_of_the_step_matters_little() {
    // With the same orders, 1, 10 and 100 steps a second lead to the same place.
    let fly_at = |hertz: u32| {
        let mut vehicle = vehicle(VehicleClass::TwelveInch, 5.0);
        for second in 0..180 {
            let heading_deg = if second < 60 { 0.0 } else { 100.0 };
            for _ in 0..hertz {
                let order = orders(heading_deg, Trim::Depth(12.0), 1.5);
                vehicle.drive(&Helm::Under(order), &open_sea(), 1.0 / f64::from(hertz));
            }
        }
        vehicle.motion()
    };
    let [slow, usual, quick] = [1, 10, 100].map(fly_at);
    for motion in [slow, quick] {
        assert!(motion.at.distance_m(usual.at) < 0.3, "{motion:?} {usual:?}");
        assert!((motion.depth_m - usual.depth_m).abs() < 0.02);
    }
}

#[test]
fn it_flies_on_after_orders_and_currents_that_are_not_finite() {
    let mut vehicle = vehicle(VehicleClass::NineInch, 10.0);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for trim in [
            Trim::Depth(value),
            Trim::Altitude(value),
            Trim::Pitch(value),
            Trim::Elevator(value),
        ] {
            for steering in [Steering::Heading(value), Steering::Rudder(value)] {
                for throttle in [Throttle::Speed(value), Throttle::Rpm(value)] {
                    let order = Orders {
                        steering,
                        trim,
                        throttle,
                    };
                    fly(&mut vehicle, order, &open_sea(), 2, |_, _| {});
                    let bottomless = Surroundings {
                        water_depth_m: f64::INFINITY,
                        gradient: EastNorth::new(value, 0.0),
                        current: (value, value, value),
                    };
                    fly(&mut vehicle, order, &bottomless, 2, |_, _| {});
                    vehicle.drive(&Helm::Under(order), &open_sea(), value.min(0.0));
                }
            }
        }
    }
    fly(
        &mut vehicle,
        orders(45.0, Trim::Depth(10.0), 1.5),
        &open_sea(),
        200,
        |_, _| {},
    );
    let motion = vehicle.motion();
    assert!(
        (motion.depth_m - 10.0).abs() < 0.1 && (motion.heading_deg - 45.0).abs() < 0.3,
        "{motion:?}"
    );
}

/// Flies a shape as the mission executive does, at 10 Hz in a cross current. Returns the distances off the line.
fn fly_shape(shape: Shape) -> Vec<f64> {
    let around = Surroundings {
        current: (0.25, -0.1, 0.0),
        ..open_sea()
    };
    let mut vehicle = vehicle(VehicleClass::TwelveInch, 10.0);
    let mut course = Course::begin(shape, vehicle.motion().at, Timestamp::ZERO);
    let mut off_m = Vec::new();
    for _ in 0..20_000 {
        let motion = vehicle.motion();
        let estimate = Estimate {
            at: motion.at,
            ..Estimate::default()
        };
        let steer = course.steer(&estimate, 1.5, vehicle.performance(), Timestamp::ZERO);
        let (Way::Course(bearing_deg), None) = (steer.way, steer.end) else {
            break;
        };
        off_m.push(steer.off_line_m);
        let current = (around.current.0, around.current.1);
        let heading_deg = crabbed_deg(bearing_deg, motion.surge_mps, current);
        vehicle.drive(&Helm::Under(orders(heading_deg, Trim::Depth(10.0), 1.5)), &around, 0.1);
    }
    off_m
}

#[test]
fn the_executive_s_steering_keeps_it_on_lines_and_circles() {
    let line = fly_shape(Shape::Trackline {
        start: EastNorth::new(100.0, 50.0),
        end: EastNorth::new(-200.0, 250.0),
    });
    let (begin, end) = line.split_at(2 * line.len() / 3);
    assert!(line.len() < 5000 && begin.iter().all(|off_m| *off_m < 60.0));
    assert!(
        end.iter().all(|off_m| *off_m < 0.2),
        "{:?}",
        end.iter().copied().fold(0.0, f64::max)
    );
    let circle = fly_shape(Shape::Trackcircle {
        centre: EastNorth::new(100.0, 100.0),
        radius_m: 40.0,
        orbits: -2.0,
        entry_deg: None,
    });
    let (_, end) = circle.split_at(2 * circle.len() / 3);
    assert!(circle.len() < 8000);
    assert!(
        end.iter().all(|off_m| *off_m < 1.0),
        "{:?}",
        end.iter().copied().fold(0.0, f64::max)
    );
}

use backseat_units::EastNorth;

use super::autopilot::{Autopilot, Bounds, Setpoints, Steering, TURN_MAX_DEG_PER_M, Throttle, Vertical};
use super::{Actuators, STEP_MAX_S, SixDof};
use crate::hull::Hull;

/// What moves the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Helm {
    /// Held where it is: before its mission.
    Held,
    /// Under its autopilot.
    Under(Orders),
    /// Nothing: fins amidships, propeller stopped; it drifts and floats up.
    Adrift,
}

/// What the autopilot is to hold, as a mission says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// In the horizontal plane.
    pub steering: Steering,
    /// In the vertical plane.
    pub trim: Trim,
    /// Along.
    pub throttle: Throttle,
}

/// The vertical order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trim {
    /// Metres below the surface.
    Depth(f64),
    /// Metres above the seabed.
    Altitude(f64),
    /// Degrees, positive nose up.
    Pitch(f64),
    /// The elevator's angle, degrees, positive pitches the nose up; within ±15.
    Elevator(f64),
}

/// The sea where the vehicle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Depth of the water, metres; may be infinite.
    pub water_depth_m: f64,
    /// Change of that depth, metres a metre eastward and northward.
    pub gradient: EastNorth,
    /// Velocity of the water, east, north, down, metres a second.
    pub current: (f64, f64, f64),
}

/// How the vehicle is and moves: what sensors and a judge look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Where it is in the world's frame.
    pub at: EastNorth,
    /// Metres, never negative.
    pub depth_m: f64,
    /// Degrees from the frame's north, in [0, 360).
    pub heading_deg: f64,
    /// Speed through the water, forward, metres a second.
    pub surge_mps: f64,
    /// Depth rate, metres a second, positive down.
    pub heave_mps: f64,
    /// Rate of the heading, degrees a second.
    pub yaw_rate_dps: f64,
    /// Degrees, positive nose up.
    pub pitch_deg: f64,
    /// Degrees a second.
    pub pitch_rate_dps: f64,
    /// Degrees, positive to starboard.
    pub roll_deg: f64,
    /// Degrees a second.
    pub roll_rate_dps: f64,
    /// Velocity over ground, east and north, metres a second.
    pub ground: (f64, f64),
    /// Whether it lies on the seabed.
    pub grounded: bool,
    /// Fins and propeller.
    pub tail: Actuators,
}

/// A body, its autopilot, and the limits that it keeps whatever it is asked.
#[derive(Clone, Debug)]
pub struct Piloted {
    hull: Hull,
    altitude_min_m: f64,
    body: SixDof,
    autopilot: Autopilot,
    held: bool,
    grounded: bool,
}

/// The slowest that this body steers and holds its depth, metres a second. Below about 0.7 the stern planes' own force
/// lifts it more than the pitch that they make brings it down, and its buoyancy comes on top.
const STEERAGE_MPS: f64 = 1.0;
/// The fastest that it goes, metres a second: a little less than all the propeller gives in a straight line.
const FASTEST_MPS: f64 = 2.4;
/// How far under the speed limit the autopilot stays, metres a second: speed swings a little where the pitch changes.
const SPEED_RESERVE_MPS: f64 = 0.03;
/// How far ahead the seabed's slope is heeded, seconds.
const LOOK_AHEAD_S: f64 = 10.0;
/// Depth at which the vehicle is kept off its limits, because a body that dives does not stop at once: metres for each
/// metre a second of its depth rate.
const LEVEL_OUT_S: f64 = 1.0;

/// What a hull can do with this body under it: its limits, as far as the body reaches them.
///
/// Plans and requests are to be judged by these: slower than 1 m/s it does not hold its depth, and its turns are those
/// of two thirds of its rudder. A hull that hovers is not for this model.
#[must_use]
pub fn flown(hull: &Hull) -> Hull {
    let speed_max_mps = hull.speed_max_mps.min(FASTEST_MPS);
    let speed_min_mps = hull.speed_min_mps.max(STEERAGE_MPS).min(speed_max_mps);
    Hull {
        speed_min_mps,
        speed_max_mps,
        yaw_rate_max_dps: hull.yaw_rate_max_dps.min(TURN_MAX_DEG_PER_M * speed_max_mps),
        yaw_tau_s: hull.yaw_tau_s.max(2.0),
        hovers: false,
        ..*hull
    }
}

impl Piloted {
    /// At rest, with the limits of `hull` as far as the body reaches them ([`flown`]) and its least height over the
    /// seabed, metres.
    #[must_use]
    pub fn new(hull: &Hull, altitude_min_m: f64, at: EastNorth, depth_m: f64, heading_deg: f64) -> Self {
        Self {
            hull: flown(hull),
            altitude_min_m,
            body: SixDof::rising_at(at, depth_m, heading_deg, hull.buoyant_rise_mps),
            autopilot: Autopilot::default(),
            held: true,
            grounded: false,
        }
    }

    /// The limits that it flies by.
    #[must_use]
    pub const fn hull(&self) -> &Hull {
        &self.hull
    }

    /// One step of `dt_s` seconds. The autopilot steers at 50 Hz or more within it; the surroundings are those of its
    /// begin.
    pub fn drive(&mut self, helm: &Helm, around: &Surroundings, dt_s: f64) {
        if dt_s.is_nan() || dt_s <= 0.0 {
            return;
        }
        match helm {
            Helm::Held => {
                if !self.held {
                    self.body.hold();
                    self.autopilot = Autopilot::default();
                }
                self.held = true;
                self.grounded = self.body.ground_at(around.water_depth_m);
            }
            Helm::Adrift => {
                self.held = false;
                self.autopilot = Autopilot::default();
                self.body.step(Actuators::default(), around.current, dt_s);
                self.grounded = self.body.ground_at(around.water_depth_m);
            }
            Helm::Under(orders) => {
                self.held = false;
                let steps = (dt_s / STEP_MAX_S - 1e-9).ceil().max(1.0);
                let part_s = dt_s / steps;
                for i in 0..steps as u32 {
                    let water_depth_m = self.water_depth_after(around, f64::from(i) * part_s);
                    let (setpoints, bounds) = self.within_limits(orders, around, water_depth_m);
                    let command = self.autopilot.command(&self.body, &setpoints, &bounds, part_s);
                    self.body.step(command, around.current, part_s);
                    self.grounded = self.body.ground_at(water_depth_m);
                }
            }
        }
    }

    /// How it is and moves. While it is held it has no velocity.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let (east_mps, north_mps, down_mps) = if self.held {
            (0.0, 0.0, 0.0)
        } else {
            self.body.ground_velocity()
        };
        let (roll_rate_dps, pitch_rate_dps, yaw_rate_dps) = self.body.attitude_rates_dps();
        Motion {
            at: self.body.at(),
            depth_m: self.body.depth_m(),
            heading_deg: self.body.heading_deg(),
            surge_mps: self.body.velocity()[0],
            heave_mps: down_mps,
            yaw_rate_dps,
            pitch_deg: self.body.pitch_deg(),
            pitch_rate_dps,
            roll_deg: self.body.roll_deg(),
            roll_rate_dps,
            ground: (east_mps, north_mps),
            grounded: self.grounded,
            tail: self.body.tail(),
        }
    }

    /// Depth of the water some time into the step, by the slope where it began.
    fn water_depth_after(&self, around: &Surroundings, seconds: f64) -> f64 {
        around.water_depth_m + seconds * self.deepening_mps(around)
    }

    /// How fast the water under it gets deeper.
    fn deepening_mps(&self, around: &Surroundings) -> f64 {
        let (east_mps, north_mps, _) = self.body.ground_velocity();
        east_mps * around.gradient.east_m + north_mps * around.gradient.north_m
    }

    fn within_limits(&self, orders: &Orders, around: &Surroundings, water_depth_m: f64) -> (Setpoints, Bounds) {
        let hull = &self.hull;
        let deepening_mps = self.deepening_mps(around);
        let floor_m = water_depth_m + (LOOK_AHEAD_S * deepening_mps).min(0.0) - self.altitude_min_m;
        let deepest_m = hull.depth_max_m.min(floor_m);
        let sinking_mps = self.body.ground_velocity().2.max(0.0);
        let bounds = Bounds {
            depth_max_m: (deepest_m - LEVEL_OUT_S * sinking_mps).max(0.0),
            speed_max_mps: hull.speed_max_mps - SPEED_RESERVE_MPS,
            pitch_max_deg: hull.pitch_max_deg,
            depth_rate_max_mps: hull.depth_rate_max_mps,
            depth_gain_per_s: hull.depth_gain_per_s,
            yaw_rate_max_dps: hull.yaw_rate_max_dps,
        };
        let vertical = match orders.trim {
            Trim::Depth(depth_m) => Vertical::Depth(depth_m),
            Trim::Altitude(altitude_m) => Vertical::MovingDepth(water_depth_m - altitude_m, deepening_mps),
            Trim::Pitch(pitch_deg) => Vertical::Pitch(pitch_deg),
            Trim::Elevator(elevator_deg) => Vertical::Elevator(elevator_deg),
        };
        let throttle = match orders.throttle {
            Throttle::Speed(speed_mps) => Throttle::Speed(speed_mps.clamp(hull.speed_min_mps, hull.speed_max_mps)),
            Throttle::Rpm(rpm) => Throttle::Rpm(rpm),
        };
        let setpoints = Setpoints {
            steering: orders.steering,
            vertical,
            throttle,
        };
        (setpoints, bounds)
    }
}

#[cfg(test)]
mod tests {
    use backseat_units::math::wrap_180;

    use super::*;
    use crate::hull::HullClass;

    const TORPEDOES: [HullClass; 3] = [HullClass::NineInch, HullClass::TwelveInch, HullClass::TwentyOneInch];

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

    fn vehicle(class: HullClass, depth_m: f64) -> Piloted {
        Piloted::new(Hull::of(class), 2.0, EastNorth::default(), depth_m, 0.0)
    }

    /// Flies at 10 Hz as the mock does and shows each step.
    fn fly(
        vehicle: &mut Piloted,
        orders: Orders,
        around: &Surroundings,
        seconds: u32,
        mut each: impl FnMut(f64, &Motion),
    ) {
        for i in 1..=10 * seconds {
            vehicle.drive(&Helm::Under(orders), around, 0.1);
            each(f64::from(i) * 0.1, &vehicle.motion());
        }
    }

    /// First time at which the response is past a share of the way, and the furthest past its end as a share of it.
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
            let hull = *vehicle.hull();
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
            // The hull's own gain sets the pace: a first-order response rises in 2.2 time constants.
            let pace_s = 2.2 / hull.depth_gain_per_s;
            assert!(
                (0.6 * pace_s..9.8 * pace_s).contains(&response.rise_s()),
                "{class:?} {}",
                response.rise_s()
            );
            assert!(response.overshoot < 0.05, "{class:?} {}", response.overshoot);
            assert!(steepest_deg <= hull.pitch_max_deg + 1.0, "{class:?} {steepest_deg}");
            assert!((motion.depth_m - 15.0).abs() < 0.1, "{class:?} {}", motion.depth_m);
            assert!((motion.surge_mps - 1.5).abs() < 0.02, "{class:?} {}", motion.surge_mps);
        }
    }

    #[test]
    fn dives_from_the_surface_at_the_least_speed() {
        let mut vehicle = vehicle(HullClass::TwelveInch, 0.0);
        let least_mps = vehicle.hull().speed_min_mps;
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
                let mut vehicle = vehicle(HullClass::NineInch, 10.0);
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
        let mut vehicle = vehicle(HullClass::TwelveInch, 50.0);
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
        assert!((motion.tail.stern_plane_deg + 3.0).abs() < 0.01);
        assert!(motion.pitch_deg > 2.0 && motion.yaw_rate_dps > 2.0, "{motion:?}");
    }

    #[test]
    fn altitude_follows_a_slope() {
        let mut vehicle = vehicle(HullClass::TwelveInch, 20.0);
        // Up and down one in twenty towards the east.
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
    fn nothing_leads_beyond_its_own_limits() {
        let trims = [
            Trim::Depth(5000.0),
            Trim::Altitude(0.0),
            Trim::Pitch(-30.0),
            Trim::Elevator(-15.0),
        ];
        for class in TORPEDOES {
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
                    let hull = Hull {
                        depth_max_m: 60.0,
                        speed_max_mps: 2.0,
                        ..*Hull::of(class)
                    };
                    let mut vehicle = Piloted::new(&hull, 2.0, EastNorth::default(), 0.0, 0.0);
                    for _ in 0..4000 {
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
                        assert!(motion.pitch_deg.abs() <= hull.pitch_max_deg + 3.0, "{case}");
                    }
                }
            }
        }
    }

    #[test]
    fn held_it_stays_and_adrift_it_floats_up_with_the_current() {
        let mut vehicle = vehicle(HullClass::NineInch, 3.0);
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
        let mut vehicle = vehicle(HullClass::NineInch, 9.0);
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
            let mut vehicle = vehicle(HullClass::NineInch, 3.0);
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
}

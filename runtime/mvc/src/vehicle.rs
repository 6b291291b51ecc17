mod body;
mod demand;
mod hover;
mod lags;
mod motion;
pub(crate) mod performance;
pub(crate) mod ship;
pub(crate) mod sixdof;
mod tailcone;

use backseat_units::math::{asin, sin, sin_cos, wrap_180, wrap_360};
use backseat_units::{EastNorth, Timestamp};
use backseat_world::World;

use self::lags::Lags;
use self::performance::Performance;
use self::sixdof::{Actuators, Piloted};
use self::tailcone::SpinDown;

pub(crate) use self::demand::{Demand, Drive, HoverDemand, Turn, Vertical};
pub(crate) use self::hover::Obstacle;
pub(crate) use self::motion::{Motion, Tail};
pub(crate) use self::sixdof::Throttle;

/// A rate below this is set to zero. It is too small to matter in any unit, but a lag would turn it into a subnormal
/// number, and a processor needs a hundred times as long for arithmetic with those.
const AT_REST: f64 = 1e-30;

/// The vehicle, which the current carries along. It is a first-order model of surge, yaw and pitch, or the body of
/// [`crate::vehicle::sixdof`].
///
/// No rate of the first-order model jumps, because demands change accelerations. A step moves the vehicle by the mean
/// of the rates before and after it. So the reported rates add up to the distance made, whatever the step length.
#[derive(Clone, Debug)]
pub(crate) struct Vehicle {
    performance: Performance,
    altitude_min_m: f64,
    /// Sine of the steepest pitch.
    pitch_max_sin: f64,
    lags: Lags,
    /// The ship that a hovering vehicle keeps clear of.
    obstacle: Option<Obstacle>,
    motion: Motion,
    /// The part of a torpedo's depth rate that comes from its buoyancy and not from its pitch.
    float_mps: f64,
    /// The velocity of the water relative to which surge and sway are counted. It is zero while the vehicle is held,
    /// because then it is at rest over ground and not in the water.
    carried_by: (f64, f64),
    /// Sine and cosine of the heading.
    axis: (f64, f64),
    /// How fast it floats up when adrift, as a share of the buoyant rise of its class. A command can adjust its
    /// buoyancy (SPI 7.24).
    rise_share: f64,
    spin_down: SpinDown,
    /// The body with six degrees of freedom, if it replaces the first-order model.
    piloted: Option<Box<Piloted>>,
}

impl Vehicle {
    pub(crate) fn new(
        performance: Performance,
        altitude_min_m: f64,
        at: EastNorth,
        depth_m: f64,
        heading_deg: f64,
    ) -> Self {
        let heading_deg = wrap_360(heading_deg);
        let mut motion = Motion::at_rest(at, depth_m, heading_deg);
        motion.tail = (!performance.hovers).then(Tail::default);
        Self {
            performance,
            altitude_min_m,
            pitch_max_sin: sin(performance.pitch_max_deg.to_radians()),
            lags: Lags::of(&performance, 1.0),
            obstacle: None,
            motion,
            float_mps: 0.0,
            carried_by: (0.0, 0.0),
            axis: sin_cos(heading_deg.to_radians()),
            rise_share: 1.0,
            spin_down: SpinDown::new(),
            piloted: None,
        }
    }

    /// As [`Vehicle::new`], with six degrees of freedom. `performance` is a result of
    /// [`crate::vehicle::sixdof::flown`].
    pub(crate) fn with_body(
        performance: Performance,
        altitude_min_m: f64,
        at: EastNorth,
        depth_m: f64,
        heading_deg: f64,
    ) -> Self {
        let piloted = Piloted::new(&performance, altitude_min_m, at, depth_m, heading_deg);
        Self {
            piloted: Some(Box::new(piloted)),
            ..Self::new(performance, altitude_min_m, at, depth_m, heading_deg)
        }
    }

    pub(crate) const fn performance(&self) -> &Performance {
        &self.performance
    }

    pub(crate) const fn altitude_min_m(&self) -> f64 {
        self.altitude_min_m
    }

    /// Its position, attitude and motion after the last step.
    pub(crate) const fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Sets the ship to keep clear of.
    pub(crate) const fn keep_clear_of(&mut self, obstacle: Option<Obstacle>) {
        self.obstacle = obstacle;
    }

    /// The ship that it keeps clear of.
    pub(crate) const fn obstacle(&self) -> Option<&Obstacle> {
        self.obstacle.as_ref()
    }

    /// Sets how fast it floats up when adrift, as a share of the buoyant rise of its class.
    pub(crate) const fn float_with(&mut self, rise_share: f64) {
        self.rise_share = rise_share;
    }

    /// Reads water depth, gradient and current at the vehicle's position, and stops the vehicle at the seabed.
    pub(crate) fn sense(&mut self, world: &World, now: Timestamp) {
        (self.motion.water_depth_m, self.motion.gradient) = world.seabed().depth_and_gradient(self.motion.at);
        self.motion.water_depth_m = (self.motion.water_depth_m + world.tide_m(now)).max(0.0);
        self.motion.current = world.current_at(self.motion.at, self.motion.depth_m, now);
        if self.piloted.is_some() {
            return self.ground();
        }
        self.motion.grounded = self.motion.depth_m >= self.motion.water_depth_m;
        if self.motion.grounded {
            self.motion.depth_m = self.motion.water_depth_m;
            self.motion.heave_mps = self.motion.heave_mps.min(self.deepening_mps());
        }
    }

    /// One step of `dt_s` seconds: computes the new rates, then moves the vehicle by the mean of the old and the new
    /// ones.
    pub(crate) fn step(&mut self, drive: Drive, dt_s: f64) {
        if self.piloted.is_some() {
            return self.pilot(drive, dt_s);
        }
        if dt_s.to_bits() != self.lags.dt_s.to_bits() {
            self.lags = Lags::of(&self.performance, dt_s);
        }
        let (ground, heave_mps) = (self.motion.ground, self.motion.heave_mps);
        let yaw_rate_dps = self.motion.yaw_rate_dps;
        match drive {
            Drive::Held => return self.stand(),
            Drive::Under(demand) => {
                self.carry_over();
                self.rates(&demand, dt_s);
            }
            Drive::Hover(demand) => {
                self.carry_over();
                self.hover(&demand, dt_s);
            }
            Drive::Adrift => {
                self.carry_over();
                self.drift(dt_s);
            }
        }
        for rate in [
            &mut self.motion.surge_mps,
            &mut self.motion.sway_mps,
            &mut self.motion.heave_mps,
            &mut self.float_mps,
            &mut self.motion.yaw_rate_dps,
            &mut self.motion.pitch_rate_dps,
            &mut self.motion.roll_rate_dps,
        ] {
            if rate.abs() < AT_REST {
                *rate = 0.0;
            }
        }
        self.motion.heading_deg =
            wrap_360(self.motion.heading_deg + 0.5 * (yaw_rate_dps + self.motion.yaw_rate_dps) * dt_s);
        self.axis = sin_cos(self.motion.heading_deg.to_radians());
        let (sin, cos) = self.axis;
        self.roll(dt_s);
        let ahead_mps = self.make_way();
        self.motion.ground = (
            ahead_mps * sin + self.motion.sway_mps * cos + self.carried_by.0,
            ahead_mps * cos - self.motion.sway_mps * sin + self.carried_by.1,
        );
        self.meet_surface_and_bed();
        // When it is adrift, only the ship's hull stops it.
        let safety_m = if drive == Drive::Adrift { 0.0 } else { self.safety_m() };
        self.stay_clear(safety_m);
        self.motion.at = self.motion.at
            + EastNorth::new(ground.0 + self.motion.ground.0, ground.1 + self.motion.ground.1) * (0.5 * dt_s);
        self.motion.depth_m += 0.5 * (heave_mps + self.motion.heave_mps) * dt_s;
        // The rise slows down towards the surface and would never end, so the last millimetre is skipped.
        if self.motion.depth_m < AFLOAT_M && self.motion.heave_mps <= 0.0 {
            self.motion.depth_m = 0.0;
            self.motion.heave_mps = 0.0;
        }
    }

    /// Holds it over ground. When it is released, it is at rest over ground and the water moves past it.
    fn stand(&mut self) {
        (self.motion.surge_mps, self.motion.sway_mps) = (0.0, 0.0);
        (self.motion.heave_mps, self.motion.yaw_rate_dps) = (0.0, 0.0);
        (self.motion.ground, self.carried_by) = ((0.0, 0.0), (0.0, 0.0));
        self.motion.tail = self.motion.tail.map(|_| Tail::default());
    }

    /// If the water's velocity changes, the vehicle's inertia keeps its velocity over ground at first.
    fn carry_over(&mut self) {
        let (sin, cos) = self.axis;
        let change = (
            self.motion.current.0 - self.carried_by.0,
            self.motion.current.1 - self.carried_by.1,
        );
        self.motion.surge_mps -= change.0 * sin + change.1 * cos;
        self.motion.sway_mps -= change.0 * cos - change.1 * sin;
        self.carried_by = self.motion.current;
    }

    fn drift(&mut self, dt_s: f64) {
        self.surge(0.0, dt_s);
        self.settle_sway();
        let lags = self.lags;
        self.turn_tail(Actuators::default(), &lags);
        let most_dps = self.performance.turn_max_dps(self.motion.surge_mps);
        self.motion.yaw_rate_dps -= self.motion.yaw_rate_dps * self.lags.yaw;
        self.motion.yaw_rate_dps = self.motion.yaw_rate_dps.clamp(-most_dps, most_dps);
        let rise_mps = self.performance.buoyant_rise_mps * self.rise_share;
        if self.performance.hovers {
            self.heave(-rise_mps);
        } else {
            self.float(-rise_mps);
            self.pitch(0.0, dt_s);
        }
    }

    fn rates(&mut self, demand: &Demand, dt_s: f64) {
        let performance = self.performance;
        let speed_mps = match demand.throttle {
            Throttle::Speed(mps) => mps,
            Throttle::Rpm(rpm) => performance.speed_mps(rpm),
        };
        let speed_mps = speed_mps.clamp(performance.speed_min_mps, performance.speed_max_mps);
        let ordered_mps = speed_mps;
        let before_mps = self.motion.surge_mps;
        self.surge(speed_mps, dt_s);
        self.settle_sway();
        self.yaw(demand.turn);
        let wanted_mps = self.wanted_heave_mps(demand.vertical);
        if performance.hovers {
            self.heave(wanted_mps);
            return;
        }
        self.float(0.0);
        // A torpedo climbs and dives by its pitch. The pitch is what the depth rate needs at the speed that the vehicle
        // will have when it reaches that pitch.
        let speed_mps = self.motion.surge_mps + (self.motion.surge_mps - before_mps) * self.lags.pitch_steps;
        let steepest = self.pitch_max_sin;
        let rise = (self.float_mps - wanted_mps) / speed_mps.max(PITCHES_FROM_MPS);
        let pitch_deg = asin(rise.clamp(-steepest, steepest)).to_degrees();
        let (ordered, lags) = (self.orders(demand, ordered_mps, wanted_mps, pitch_deg), self.lags);
        self.turn_tail(ordered, &lags);
        self.pitch(pitch_deg, dt_s);
    }

    fn yaw(&mut self, turn: Turn) {
        let performance = self.performance;
        // A rudder has no effect without speed.
        let rate_max_dps = performance.turn_max_dps(self.motion.surge_mps);
        let rate_dps = match turn {
            Turn::Heading(heading_deg) => {
                let error_deg = wrap_180(heading_deg - self.motion.heading_deg);
                (performance.yaw_gain_per_s * error_deg).clamp(-rate_max_dps, rate_max_dps)
            }
            Turn::Rudder(rudder_deg) => {
                performance.rudder_dps(rudder_deg) * rate_max_dps / performance.yaw_rate_max_dps
            }
        };
        self.motion.yaw_rate_dps += (rate_dps - self.motion.yaw_rate_dps) * self.lags.yaw;
        self.motion.yaw_rate_dps = self.motion.yaw_rate_dps.clamp(-rate_max_dps, rate_max_dps);
    }

    fn wanted_heave_mps(&self, vertical: Vertical) -> f64 {
        let performance = self.performance;
        let rate_max_mps = self.depth_rate_max_mps();
        let wanted_mps = match vertical {
            Vertical::Depth(depth_m) => self.towards_mps(depth_m),
            Vertical::Altitude(altitude_m) => self.towards_mps(self.motion.water_depth_m - altitude_m),
            Vertical::Pitch(pitch_deg) => self.by_pitch_mps(pitch_deg),
            Vertical::Elevator(elevator_deg) => self.by_pitch_mps(performance.elevator_pitch_deg(elevator_deg)),
        };
        // Over a slope, the depth for an altitude changes as the vehicle moves.
        let follow_mps = match vertical {
            Vertical::Altitude(_) => self.deepening_mps(),
            Vertical::Depth(_) | Vertical::Pitch(_) | Vertical::Elevator(_) => 0.0,
        };
        (wanted_mps + follow_mps).clamp(-rate_max_mps, rate_max_mps)
    }

    /// The depth rate that a pitch causes, within the limits of [`Vehicle::towards_mps`].
    fn by_pitch_mps(&self, pitch_deg: f64) -> f64 {
        let pitch_deg = pitch_deg.clamp(-self.performance.pitch_max_deg, self.performance.pitch_max_deg);
        let by_pitch_mps = -self.motion.surge_mps * sin(pitch_deg.to_radians());
        by_pitch_mps
            .max(self.towards_mps(0.0).min(0.0))
            .min(self.towards_mps(f64::INFINITY))
    }

    /// How fast the water depth under the vehicle grows.
    fn deepening_mps(&self) -> f64 {
        self.motion.ground.0 * self.motion.gradient.east_m + self.motion.ground.1 * self.motion.gradient.north_m
    }

    /// The depth rate towards a depth. The depth is clamped to the vehicle's safe limits: not above the surface, not
    /// below its greatest depth, and not closer to the seabed than its least altitude, now and 10 s ahead.
    fn towards_mps(&self, depth_m: f64) -> f64 {
        let ahead_m = 10.0 * self.deepening_mps();
        let floor_m = self.motion.water_depth_m + ahead_m.min(0.0) - self.altitude_min_m;
        let depth_m = depth_m.min(self.performance.depth_max_m).min(floor_m).max(0.0);
        self.performance.depth_gain_per_s * (depth_m - self.motion.depth_m)
    }

    fn depth_rate_max_mps(&self) -> f64 {
        if self.performance.hovers {
            return self.performance.depth_rate_max_mps;
        }
        let by_pitch_mps = self.motion.surge_mps * self.pitch_max_sin;
        by_pitch_mps.clamp(0.02, self.performance.depth_rate_max_mps)
    }

    fn surge(&mut self, speed_mps: f64, dt_s: f64) {
        let change = (speed_mps - self.motion.surge_mps) * self.lags.surge;
        let most = self.performance.surge_accel_mps2 * dt_s;
        self.motion.surge_mps += change.clamp(-most, most);
    }

    fn settle_sway(&mut self) {
        self.motion.sway_mps -= self.motion.sway_mps * self.lags.surge;
    }

    fn heave(&mut self, rate_mps: f64) {
        self.motion.heave_mps += (rate_mps - self.motion.heave_mps) * self.lags.heave;
    }

    fn float(&mut self, rate_mps: f64) {
        self.float_mps += (rate_mps - self.float_mps) * self.lags.heave;
    }

    fn pitch(&mut self, wanted_deg: f64, dt_s: f64) {
        let most_dps = self.performance.pitch_rate_max_dps;
        let left_deg = wanted_deg - self.motion.pitch_deg - 0.5 * self.motion.pitch_rate_dps * dt_s;
        let wanted_dps = (left_deg * self.lags.pitch_per_s).clamp(-most_dps, most_dps);
        let rate_dps = self.motion.pitch_rate_dps + (wanted_dps - self.motion.pitch_rate_dps) * self.lags.attitude;
        self.motion.pitch_deg += 0.5 * (self.motion.pitch_rate_dps + rate_dps) * dt_s;
        self.motion.pitch_rate_dps = rate_dps;
    }

    /// The vehicle leans into turns a little. Roll, like pitch, is computed half a step ahead: otherwise it would
    /// overshoot with long steps.
    fn roll(&mut self, dt_s: f64) {
        let left_deg =
            LEAN_S * self.motion.yaw_rate_dps - self.motion.roll_deg - 0.5 * self.motion.roll_rate_dps * dt_s;
        let wanted_dps = left_deg * self.lags.roll_per_s;
        let rate_dps = self.motion.roll_rate_dps + (wanted_dps - self.motion.roll_rate_dps) * self.lags.attitude;
        self.motion.roll_deg += 0.5 * (self.motion.roll_rate_dps + rate_dps) * dt_s;
        self.motion.roll_rate_dps = rate_dps;
    }

    /// Sets the depth rate of a torpedo from its pitch. Returns its horizontal speed ahead through the water.
    fn make_way(&mut self) -> f64 {
        if self.performance.hovers {
            return self.motion.surge_mps;
        }
        let sin = sin(self.motion.pitch_deg.to_radians());
        self.motion.heave_mps = self.float_mps - self.motion.surge_mps * sin;
        // The pitch never comes close to 90 degrees, and a square root costs less than a cosine.
        self.motion.surge_mps * (1.0 - sin * sin).sqrt()
    }

    /// The surface and the bed stop the vehicle: the closer it comes to them, the slower it moves. A rising bed pushes
    /// it up.
    fn meet_surface_and_bed(&mut self) {
        let gain_per_s = self.lags.stop_per_s;
        let altitude_m = self.motion.water_depth_m - self.motion.depth_m;
        let down_mps = self.deepening_mps() + TOUCH_MPS + gain_per_s * altitude_m;
        self.motion.heave_mps = self
            .motion
            .heave_mps
            .max(-gain_per_s * self.motion.depth_m)
            .min(down_mps);
    }
}

/// The least speed in the computation of the pitch for a climb or dive, metres a second.
const PITCHES_FROM_MPS: f64 = 0.4;
/// Degrees of roll per degree a second of turn, seconds.
const LEAN_S: f64 = 0.3;
/// The speed with which it touches the bed, metres a second.
const TOUCH_MPS: f64 = 0.02;
/// A vehicle closer to the surface than this is at the surface, metres.
const AFLOAT_M: f64 = 0.001;

#[cfg(test)]
mod tests {
    use backseat_plan::VehicleClass;
    use backseat_world::{CurrentConfig, FieldConfig, OriginConfig, SeabedConfig, Span, TideLevelConfig, WorldConfig};

    use super::*;

    fn world() -> World {
        let config = WorldConfig {
            origin: OriginConfig {
                latitude_deg: 42.0,
                longitude_deg: -70.0,
            },
            seabed: SeabedConfig {
                downslope_deg: Span::fixed(90.0),
                ..SeabedConfig::default()
            },
            tide: TideLevelConfig::default(),
            current: CurrentConfig::default(),
            field: FieldConfig::default(),
            targets: Vec::new(),
        };
        World::new(&config, 4).unwrap()
    }

    fn fly(class: VehicleClass, demand: Demand, seconds: u32) -> Vehicle {
        let world = world();
        let mut vehicle = Vehicle::new(*Performance::of(class), 2.0, EastNorth::default(), 0.0, 0.0);
        for _ in 0..seconds * 10 {
            vehicle.sense(&world, Timestamp::ZERO);
            vehicle.step(Drive::Under(demand), 0.1);
        }
        vehicle.sense(&world, Timestamp::ZERO);
        vehicle
    }

    const CLASSES: [VehicleClass; 4] = [
        VehicleClass::NineInch,
        VehicleClass::TwelveInch,
        VehicleClass::TwentyOneInch,
        VehicleClass::Hovering,
    ];

    #[test]
    fn every_class_reaches_heading_depth_and_speed() {
        for class in CLASSES {
            let demand = Demand {
                turn: Turn::Heading(180.0),
                vertical: Vertical::Depth(20.0),
                throttle: Throttle::Speed(0.7),
            };
            let vehicle = fly(class, demand, 200);
            assert!(wrap_180(vehicle.motion().heading_deg - 180.0).abs() < 0.5, "{class:?}");
            assert!(
                (vehicle.motion().depth_m - 20.0).abs() < 0.2,
                "{class:?} {}",
                vehicle.motion().depth_m
            );
            assert!((vehicle.motion().surge_mps - 0.7).abs() < 0.01, "{class:?}");
        }
    }

    #[test]
    fn altitude_follows_the_bottom() {
        // Up the slope.
        let demand = Demand {
            turn: Turn::Heading(270.0),
            vertical: Vertical::Altitude(10.0),
            throttle: Throttle::Speed(1.5),
        };
        let vehicle = fly(VehicleClass::TwelveInch, demand, 400);
        let altitude = vehicle.motion().water_depth_m - vehicle.motion().depth_m;
        assert!((altitude - 10.0).abs() < 0.6, "{altitude}");
    }

    #[test]
    fn no_demand_exceeds_the_limits() {
        for class in CLASSES {
            for vertical in [Vertical::Depth(5000.0), Vertical::Altitude(0.0), Vertical::Pitch(-20.0)] {
                let demand = Demand {
                    turn: Turn::Heading(270.0),
                    vertical,
                    throttle: Throttle::Speed(99.0),
                };
                let world = world();
                let performance = *Performance::of(class);
                let mut vehicle = Vehicle::new(performance, 2.0, EastNorth::default(), 0.0, 0.0);
                for _ in 0..5000 {
                    vehicle.sense(&world, Timestamp::ZERO);
                    let altitude = vehicle.motion().water_depth_m - vehicle.motion().depth_m;
                    assert!(
                        altitude > 0.5 && vehicle.motion().depth_m <= performance.depth_max_m + 0.5,
                        "{class:?} {altitude}"
                    );
                    assert!(vehicle.motion().surge_mps <= performance.speed_max_mps);
                    vehicle.step(Drive::Under(demand), 0.1);
                }
            }
        }
    }

    #[test]
    fn the_rudder_turns_to_starboard_and_the_elevator_lifts_the_nose() {
        let demand = Demand {
            turn: Turn::Rudder(10.0),
            vertical: Vertical::Elevator(-4.0),
            throttle: Throttle::Speed(1.5),
        };
        let vehicle = fly(VehicleClass::TwelveInch, demand, 20);
        // Half of the greatest rudder angle gives half of the fastest turn.
        assert!(
            (vehicle.motion().yaw_rate_dps - 5.0).abs() < 0.1,
            "{}",
            vehicle.motion().yaw_rate_dps
        );
        assert!(
            vehicle.motion().pitch_deg < -3.0 && vehicle.motion().depth_m > 0.5,
            "{}",
            vehicle.motion().pitch_deg
        );
        let demand = Demand {
            turn: Turn::Rudder(-90.0),
            ..demand
        };
        let vehicle = fly(VehicleClass::TwelveInch, demand, 20);
        assert!(
            (vehicle.motion().yaw_rate_dps + 10.0).abs() < 0.1,
            "{}",
            vehicle.motion().yaw_rate_dps
        );
    }

    #[test]
    fn a_vehicle_adrift_floats_up_and_stops() {
        let demand = Demand {
            turn: Turn::Heading(0.0),
            vertical: Vertical::Depth(5.0),
            throttle: Throttle::Speed(1.5),
        };
        let mut vehicle = fly(VehicleClass::NineInch, demand, 100);
        for _ in 0..1200 {
            vehicle.step(Drive::Adrift, 0.1);
        }
        assert_eq!(vehicle.motion().depth_m, 0.0);
        assert!(vehicle.motion().surge_mps < 0.01);
    }
}

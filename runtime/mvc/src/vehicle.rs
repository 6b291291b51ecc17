mod body;
mod hover;

use backseat_units::math::{asin, sin, sin_cos, wrap_180, wrap_360};
use backseat_units::{EastNorth, Timestamp};
use backseat_world::World;

use crate::hull::Hull;
use crate::plan::Vertical;
use crate::sixdof::{Actuators, Piloted};

pub(crate) use crate::sixdof::Throttle;
pub(crate) use hover::{HoverDemand, Obstacle};

/// What the vehicle turns to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Degrees from the frame's north.
    Heading(f64),
    /// Degrees of rudder, positive to starboard (SPI 6.12), held.
    Rudder(f64),
}

/// What a lag has brought down to this moves nothing any more, in any unit. Left to itself it becomes a subnormal number,
/// and every sum with those takes a processor a hundred times as long.
const AT_REST: f64 = 1e-30;

/// What the vehicle is asked to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Demand {
    pub(crate) turn: Turn,
    pub(crate) vertical: Vertical,
    pub(crate) throttle: Throttle,
}

/// Rudder, elevator and thruster, as they are and as they have been told to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tail {
    pub(crate) now: Actuators,
    pub(crate) ordered: Actuators,
}

/// What moves the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drive {
    /// Held where it is: before its mission.
    Held,
    Under(Demand),
    /// Any way, as only a hovering vehicle can.
    Hover(HoverDemand),
    /// Nothing: it drifts and floats up.
    Adrift,
}

/// The vehicle, which the current carries along: a first-order model of surge, yaw and depth, or the body of
/// [`crate::sixdof`].
#[derive(Clone, Debug)]
pub(crate) struct Vehicle {
    hull: Hull,
    altitude_min_m: f64,
    /// What a hovering vehicle keeps clear of.
    pub(crate) obstacle: Option<Obstacle>,
    pub(crate) at: EastNorth,
    pub(crate) depth_m: f64,
    /// Degrees from the frame's north, in [0, 360).
    pub(crate) heading_deg: f64,
    pub(crate) surge_mps: f64,
    /// To starboard; torpedoes have none.
    pub(crate) sway_mps: f64,
    /// Positive down.
    pub(crate) heave_mps: f64,
    pub(crate) yaw_rate_dps: f64,
    pub(crate) pitch_deg: f64,
    pub(crate) pitch_rate_dps: f64,
    pub(crate) roll_deg: f64,
    pub(crate) roll_rate_dps: f64,
    /// Velocity of the water where the vehicle is, east and north.
    pub(crate) current: (f64, f64),
    /// Velocity over ground, east and north.
    pub(crate) ground: (f64, f64),
    pub(crate) water_depth_m: f64,
    pub(crate) gradient: EastNorth,
    pub(crate) grounded: bool,
    /// How fast it floats up adrift, as a share of the hull's buoyant rise: its buoyancy may be adjusted (SPI 7.24).
    pub(crate) rise_share: f64,
    /// What the tail does; none where the model has none.
    pub(crate) tail: Option<Tail>,
    /// The body that moves it in place of the first-order model.
    piloted: Option<Box<Piloted>>,
}

impl Vehicle {
    pub(crate) fn new(hull: Hull, altitude_min_m: f64, at: EastNorth, depth_m: f64, heading_deg: f64) -> Self {
        Self {
            hull,
            altitude_min_m,
            obstacle: None,
            at,
            depth_m,
            heading_deg: wrap_360(heading_deg),
            surge_mps: 0.0,
            sway_mps: 0.0,
            heave_mps: 0.0,
            yaw_rate_dps: 0.0,
            pitch_deg: 0.0,
            pitch_rate_dps: 0.0,
            roll_deg: 0.0,
            roll_rate_dps: 0.0,
            current: (0.0, 0.0),
            ground: (0.0, 0.0),
            water_depth_m: f64::INFINITY,
            gradient: EastNorth::default(),
            grounded: false,
            rise_share: 1.0,
            tail: None,
            piloted: None,
        }
    }

    /// As [`Vehicle::new`], with six degrees of freedom. `hull` is what [`crate::sixdof::flown`] makes of one.
    pub(crate) fn with_body(hull: Hull, altitude_min_m: f64, at: EastNorth, depth_m: f64, heading_deg: f64) -> Self {
        let piloted = Piloted::new(&hull, altitude_min_m, at, depth_m, heading_deg);
        Self {
            piloted: Some(Box::new(piloted)),
            ..Self::new(hull, altitude_min_m, at, depth_m, heading_deg)
        }
    }

    pub(crate) const fn hull(&self) -> &Hull {
        &self.hull
    }

    pub(crate) const fn altitude_min_m(&self) -> f64 {
        self.altitude_min_m
    }

    /// Reads the sea where the vehicle is.
    pub(crate) fn sense(&mut self, world: &World, now: Timestamp) {
        (self.water_depth_m, self.gradient) = world.seabed().depth_and_gradient(self.at);
        self.water_depth_m = (self.water_depth_m + world.tide_m(now)).max(0.0);
        self.current = world.current_at(self.at, self.depth_m, now);
        if self.piloted.is_some() {
            return self.ground();
        }
        self.grounded = self.depth_m >= self.water_depth_m;
        if self.grounded {
            self.depth_m = self.water_depth_m;
            self.heave_mps = self.heave_mps.min(0.0);
        }
    }

    /// One step of `dt_s`, of the first-order model by semi-implicit Euler: rates first, then what they move.
    pub(crate) fn step(&mut self, drive: Drive, dt_s: f64) {
        if self.piloted.is_some() {
            return self.pilot(drive, dt_s);
        }
        match drive {
            Drive::Held => {
                (self.surge_mps, self.sway_mps) = (0.0, 0.0);
                (self.heave_mps, self.yaw_rate_dps) = (0.0, 0.0);
                self.ground = (0.0, 0.0);
                return;
            }
            Drive::Under(demand) => self.rates(&demand, dt_s),
            Drive::Hover(demand) => self.hover(&demand, dt_s),
            Drive::Adrift => {
                self.surge(0.0, dt_s);
                self.settle_sway(dt_s);
                self.yaw_rate_dps -= self.yaw_rate_dps * share(dt_s, self.hull.yaw_tau_s);
                self.heave(-self.hull.buoyant_rise_mps * self.rise_share, dt_s);
            }
        }
        for rate in [
            &mut self.surge_mps,
            &mut self.sway_mps,
            &mut self.heave_mps,
            &mut self.yaw_rate_dps,
        ] {
            if rate.abs() < AT_REST {
                *rate = 0.0;
            }
        }
        self.heading_deg = wrap_360(self.heading_deg + self.yaw_rate_dps * dt_s);
        let (sin, cos) = sin_cos(self.heading_deg.to_radians());
        self.ground = (
            self.surge_mps * sin + self.sway_mps * cos + self.current.0,
            self.surge_mps * cos - self.sway_mps * sin + self.current.1,
        );
        // Adrift, nothing keeps it off but the hull itself.
        let safety_m = if drive == Drive::Adrift { 0.0 } else { self.safety_m() };
        self.stay_clear(safety_m, sin, cos);
        self.at = EastNorth::new(
            self.at.east_m + self.ground.0 * dt_s,
            self.at.north_m + self.ground.1 * dt_s,
        );
        self.depth_m += self.heave_mps * dt_s;
        if self.depth_m <= 0.0 {
            self.depth_m = 0.0;
            self.heave_mps = self.heave_mps.max(0.0);
        }
        self.attitude(dt_s);
    }

    fn rates(&mut self, demand: &Demand, dt_s: f64) {
        let hull = self.hull;
        let speed_mps = match demand.throttle {
            Throttle::Speed(mps) => mps,
            Throttle::Rpm(rpm) => hull.speed_mps(rpm),
        };
        let speed_mps = speed_mps.clamp(hull.speed_min_mps, hull.speed_max_mps);
        self.surge(speed_mps, dt_s);
        self.settle_sway(dt_s);
        // A rudder needs way on: below the least speed the turn fades with it.
        let authority = if hull.hovers {
            1.0
        } else {
            (self.surge_mps / hull.speed_min_mps.max(0.1)).clamp(0.05, 1.0)
        };
        self.yaw(demand.turn, authority, dt_s);
        self.heave(self.wanted_heave_mps(demand.vertical), dt_s);
    }

    fn yaw(&mut self, turn: Turn, authority: f64, dt_s: f64) {
        let hull = self.hull;
        let rate_max_dps = hull.yaw_rate_max_dps * authority;
        let rate_dps = match turn {
            Turn::Heading(heading_deg) => {
                let error_deg = wrap_180(heading_deg - self.heading_deg);
                (hull.yaw_gain_per_s * error_deg).clamp(-rate_max_dps, rate_max_dps)
            }
            Turn::Rudder(rudder_deg) => hull.rudder_dps(rudder_deg) * authority,
        };
        self.yaw_rate_dps += (rate_dps - self.yaw_rate_dps) * share(dt_s, hull.yaw_tau_s);
    }

    fn wanted_heave_mps(&self, vertical: Vertical) -> f64 {
        let hull = self.hull;
        let rate_max_mps = self.depth_rate_max_mps();
        let wanted_mps = match vertical {
            Vertical::Depth(depth_m) => self.towards_mps(depth_m),
            Vertical::Altitude(altitude_m) => self.towards_mps(self.water_depth_m - altitude_m),
            Vertical::Pitch(pitch_deg) => self.by_pitch_mps(pitch_deg),
            Vertical::Elevator(elevator_deg) => self.by_pitch_mps(hull.elevator_pitch_deg(elevator_deg)),
        };
        // Over a slope the depth to hold moves with the vehicle.
        let follow_mps = match vertical {
            Vertical::Altitude(_) => self.ground.0 * self.gradient.east_m + self.ground.1 * self.gradient.north_m,
            Vertical::Depth(_) | Vertical::Pitch(_) | Vertical::Elevator(_) => 0.0,
        };
        (wanted_mps + follow_mps).clamp(-rate_max_mps, rate_max_mps)
    }

    /// Depth rate that a pitch makes, within the same safe limits.
    fn by_pitch_mps(&self, pitch_deg: f64) -> f64 {
        let pitch_deg = pitch_deg.clamp(-self.hull.pitch_max_deg, self.hull.pitch_max_deg);
        let by_pitch_mps = -self.surge_mps * sin(pitch_deg.to_radians());
        by_pitch_mps.min(self.towards_mps(f64::INFINITY))
    }

    /// Depth rate towards a depth, clipped to the vehicle's own safe limits: not above the surface, not below its
    /// greatest depth, not nearer the seabed of now and of 10 s ahead than its least altitude.
    fn towards_mps(&self, depth_m: f64) -> f64 {
        let ahead_m = 10.0 * (self.ground.0 * self.gradient.east_m + self.ground.1 * self.gradient.north_m);
        let floor_m = self.water_depth_m + ahead_m.min(0.0) - self.altitude_min_m;
        let depth_m = depth_m.min(self.hull.depth_max_m).min(floor_m).max(0.0);
        self.hull.depth_gain_per_s * (depth_m - self.depth_m)
    }

    fn depth_rate_max_mps(&self) -> f64 {
        if self.hull.hovers {
            return self.hull.depth_rate_max_mps;
        }
        let by_pitch_mps = self.surge_mps * sin(self.hull.pitch_max_deg.to_radians());
        by_pitch_mps.clamp(0.02, self.hull.depth_rate_max_mps)
    }

    fn surge(&mut self, speed_mps: f64, dt_s: f64) {
        let change = (speed_mps - self.surge_mps) * share(dt_s, self.hull.surge_tau_s);
        let most = self.hull.surge_accel_mps2 * dt_s;
        self.surge_mps += change.clamp(-most, most);
    }

    fn settle_sway(&mut self, dt_s: f64) {
        self.sway_mps -= self.sway_mps * share(dt_s, self.hull.surge_tau_s);
    }

    fn heave(&mut self, rate_mps: f64, dt_s: f64) {
        self.heave_mps += (rate_mps - self.heave_mps) * share(dt_s, self.hull.heave_tau_s);
    }

    fn attitude(&mut self, dt_s: f64) {
        let pitch_deg = if self.hull.hovers {
            0.0
        } else {
            // Climbs and dives by its attitude: pitch is what the depth rate needs at this speed.
            asin((-self.heave_mps / self.surge_mps.max(0.4)).clamp(-0.7, 0.7)).to_degrees()
        };
        // Leans into turns a little.
        let roll_deg = 0.3 * self.yaw_rate_dps;
        self.pitch_rate_dps = (pitch_deg - self.pitch_deg) / dt_s;
        self.roll_rate_dps = (roll_deg - self.roll_deg) / dt_s;
        (self.pitch_deg, self.roll_deg) = (pitch_deg, roll_deg);
    }
}

/// The part of the way that a first-order lag goes in a step.
fn share(dt_s: f64, tau_s: f64) -> f64 {
    dt_s / (tau_s + dt_s)
}

#[cfg(test)]
mod tests {
    use backseat_world::{CurrentConfig, FieldConfig, OriginConfig, SeabedConfig, Span, TideLevelConfig, WorldConfig};

    use super::*;
    use crate::hull::HullClass;

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

    fn fly(class: HullClass, demand: Demand, seconds: u32) -> Vehicle {
        let world = world();
        let mut vehicle = Vehicle::new(*Hull::of(class), 2.0, EastNorth::default(), 0.0, 0.0);
        for _ in 0..seconds * 10 {
            vehicle.sense(&world, Timestamp::ZERO);
            vehicle.step(Drive::Under(demand), 0.1);
        }
        vehicle.sense(&world, Timestamp::ZERO);
        vehicle
    }

    const CLASSES: [HullClass; 4] = [
        HullClass::NineInch,
        HullClass::TwelveInch,
        HullClass::TwentyOneInch,
        HullClass::Hovering,
    ];

    #[test]
    fn every_hull_reaches_heading_depth_and_speed() {
        for class in CLASSES {
            let demand = Demand {
                turn: Turn::Heading(180.0),
                vertical: Vertical::Depth(20.0),
                throttle: Throttle::Speed(0.7),
            };
            let vehicle = fly(class, demand, 200);
            assert!(wrap_180(vehicle.heading_deg - 180.0).abs() < 0.5, "{class:?}");
            assert!((vehicle.depth_m - 20.0).abs() < 0.2, "{class:?} {}", vehicle.depth_m);
            assert!((vehicle.surge_mps - 0.7).abs() < 0.01, "{class:?}");
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
        let vehicle = fly(HullClass::TwelveInch, demand, 400);
        let altitude = vehicle.water_depth_m - vehicle.depth_m;
        assert!((altitude - 10.0).abs() < 0.6, "{altitude}");
    }

    #[test]
    fn nothing_leads_beyond_its_own_limits() {
        for class in CLASSES {
            for vertical in [Vertical::Depth(5000.0), Vertical::Altitude(0.0), Vertical::Pitch(-20.0)] {
                let demand = Demand {
                    turn: Turn::Heading(270.0),
                    vertical,
                    throttle: Throttle::Speed(99.0),
                };
                let world = world();
                let hull = *Hull::of(class);
                let mut vehicle = Vehicle::new(hull, 2.0, EastNorth::default(), 0.0, 0.0);
                for _ in 0..5000 {
                    vehicle.sense(&world, Timestamp::ZERO);
                    let altitude = vehicle.water_depth_m - vehicle.depth_m;
                    assert!(
                        altitude > 0.5 && vehicle.depth_m <= hull.depth_max_m + 0.5,
                        "{class:?} {altitude}"
                    );
                    assert!(vehicle.surge_mps <= hull.speed_max_mps);
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
        let vehicle = fly(HullClass::TwelveInch, demand, 20);
        // Half of the greatest rudder is half of the fastest turn.
        assert!((vehicle.yaw_rate_dps - 5.0).abs() < 0.1, "{}", vehicle.yaw_rate_dps);
        assert!(
            vehicle.pitch_deg < -3.0 && vehicle.depth_m > 0.5,
            "{}",
            vehicle.pitch_deg
        );
        let demand = Demand {
            turn: Turn::Rudder(-90.0),
            ..demand
        };
        let vehicle = fly(HullClass::TwelveInch, demand, 20);
        assert!((vehicle.yaw_rate_dps + 10.0).abs() < 0.1, "{}", vehicle.yaw_rate_dps);
    }

    #[test]
    fn adrift_it_floats_up_and_stops() {
        let demand = Demand {
            turn: Turn::Heading(0.0),
            vertical: Vertical::Depth(5.0),
            throttle: Throttle::Speed(1.5),
        };
        let mut vehicle = fly(HullClass::NineInch, demand, 100);
        for _ in 0..1200 {
            vehicle.step(Drive::Adrift, 0.1);
        }
        assert_eq!(vehicle.depth_m, 0.0);
        assert!(vehicle.surge_mps < 0.01);
    }
}

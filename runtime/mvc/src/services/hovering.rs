mod commands;
mod relative;
mod servo;

use core::time::Duration;

use backseat_spi::{CartesianNavigation, RelativeNavigation, ServoPositions};
use backseat_units::Timestamp;
use backseat_units::math::hypot;
use backseat_world::{Stream, World};

use relative::Relative;
use servo::Servo;

use crate::context::Context;
use crate::estimate::Estimate;
use crate::event::{HoveringEvent, MvcEventKind};
use crate::executive::mission::Mission;
use crate::file::WorldFile;
use crate::server::topics::Topic;
use crate::truth::HoveringTruth;
use crate::vehicle::ship::Ship;
use crate::vehicle::{HoverDemand, Obstacle, Vehicle, Vertical};

/// Demanded speed per metre of distance, per second.
const POSITION_GAIN_PER_S: f64 = 0.25;
/// The vehicle has arrived if it is closer to its goal than this, metres.
const ARRIVED_M: f64 = 0.15;
/// Angle of the DVL when it faces the hull, and when it faces the bottom: degrees above the horizontal.
const DVL_TO_HULL_DEG: f64 = 0.0;
const DVL_TO_BOTTOM_DEG: f64 = -90.0;

/// What only hovering vehicles have (SPI 6.17 to 6.19, 8). It is empty in other vehicles.
#[derive(Debug)]
pub(crate) struct Hovering {
    state: Option<Box<Inspector>>,
}

/// A hovering vehicle: its relative navigation, its devices, and the goal that a payload has given it.
#[derive(Debug)]
pub(crate) struct Inspector {
    relative: Relative,
    noise: Stream,
    position_noise_m: f64,
    range_noise_m: f64,
    has_hull: bool,
    safety_m: f64,
    goal: Goal,
    arrived: bool,
    speed_limit_mps: f64,
    sonar: Servo,
    sonar_min_deg: f64,
    sonar_max_deg: f64,
    dvl: Servo,
    servo_step_deg: f64,
    has_camera: bool,
    has_light: bool,
    light_on: bool,
    relative_period: Duration,
    next_relative: Timestamp,
    servo_period: Duration,
    next_servo: Timestamp,
}

/// The goal of a suspended vehicle, in coordinates of its relative navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Goal {
    /// The place where it was suspended, with the bearing that it had there.
    Stay {
        x_m: f64,
        y_m: f64,
        depth_m: f64,
        bearing_deg: f64,
    },
    /// At a distance from the hull, facing it.
    Hull {
        horizontal_m: f64,
        depth_m: f64,
        distance_m: f64,
    },
    /// Near the bottom, with the bearing that it had when it was sent there.
    Bottom {
        x_m: f64,
        y_m: f64,
        vertical: Vertical,
        bearing_deg: f64,
    },
}

impl Hovering {
    pub(crate) fn new(file: &WorldFile, world: &World, vehicle: &mut Vehicle, seed: u64) -> Self {
        if !vehicle.performance().hovers {
            return Self { state: None };
        }
        let config = &file.hovering;
        let ship = config.hull.map(|hull| Ship::new(&hull, world.frame()));
        vehicle.keep_clear_of(ship.map(|ship| Obstacle {
            ship,
            safety_m: config.safety_m,
        }));
        let relative = Relative::new(config, ship, vehicle, file.vehicle.tick_hz, seed);
        let relative_period = Duration::from_secs_f64(1.0 / config.relative_hz);
        let servo_period = Duration::from_secs_f64(1.0 / config.servo_hz);
        let (x_m, y_m) = relative.believed();
        let goal = Goal::Stay {
            x_m,
            y_m,
            depth_m: vehicle.motion().depth_m,
            bearing_deg: relative.bearing_deg(vehicle),
        };
        Self {
            state: Some(Box::new(Inspector {
                relative,
                noise: Stream::new(seed, "relative navigation noise"),
                position_noise_m: config.position_noise_m,
                range_noise_m: config.range_noise_m,
                has_hull: ship.is_some(),
                safety_m: config.safety_m,
                goal,
                arrived: true,
                speed_limit_mps: config.speed_limit_mps,
                sonar: Servo::new(0.0_f64.clamp(config.sonar_min_deg, config.sonar_max_deg)),
                sonar_min_deg: config.sonar_min_deg,
                sonar_max_deg: config.sonar_max_deg,
                dvl: Servo::new(DVL_TO_BOTTOM_DEG),
                servo_step_deg: config.servo_rate_dps / f64::from(file.vehicle.tick_hz),
                has_camera: config.camera,
                has_light: config.light,
                light_on: false,
                relative_period,
                next_relative: Timestamp::ZERO + relative_period,
                servo_period,
                next_servo: Timestamp::ZERO + servo_period,
            })),
        }
    }
}

impl Inspector {
    /// Makes the present place the goal, at the depth that the vehicle believes to be at.
    fn stay(&mut self, vehicle: &Vehicle, depth_m: f64) {
        let (x_m, y_m) = self.relative.believed();
        self.goal = Goal::Stay {
            x_m,
            y_m,
            depth_m,
            bearing_deg: self.relative.bearing_deg(vehicle),
        };
        self.arrived = true;
    }

    /// Sends the vehicle to a place. Returns false if that is already its goal.
    fn go(&mut self, goal: Goal) -> bool {
        if self.goal == goal {
            return false;
        }
        self.arrived = false;
        self.goal = goal;
        true
    }

    /// One step of sonar and DVL. The DVL faces the ship while a payload keeps the vehicle at the hull, and otherwise
    /// the bottom.
    fn turn_devices(&mut self, suspended: bool) {
        self.dvl.turn_to(match self.goal {
            Goal::Hull { .. } if suspended => DVL_TO_HULL_DEG,
            Goal::Hull { .. } | Goal::Stay { .. } | Goal::Bottom { .. } => DVL_TO_BOTTOM_DEG,
        });
        self.sonar.step(self.servo_step_deg);
        self.dvl.step(self.servo_step_deg);
    }

    /// BPRNS changes the coordinates. A vehicle that stays in place must not move because of it.
    fn reset(&mut self, x_m: f64, y_m: f64, bearing_deg: f64, vehicle: &Vehicle) -> f64 {
        let turned_deg = bearing_deg - self.relative.bearing_deg(vehicle);
        let moved = self.relative.reset(x_m, y_m, bearing_deg, vehicle);
        if let Goal::Stay { x_m, y_m, .. } = &mut self.goal {
            *x_m += moved.0;
            *y_m += moved.1;
        }
        self.turn_held_bearing(turned_deg);
        hypot(moved.0, moved.1)
    }

    fn offset_bearing(&mut self, offset_deg: f64) {
        self.relative.offset_bearing(offset_deg);
        self.turn_held_bearing(offset_deg);
    }

    /// When the coordinates turn, a bearing that nobody has requested turns with them, so that the vehicle does not. A
    /// payload has requested to face the hull, so that bearing stays.
    fn turn_held_bearing(&mut self, turned_deg: f64) {
        match &mut self.goal {
            Goal::Stay { bearing_deg, .. } | Goal::Bottom { bearing_deg, .. } => *bearing_deg += turned_deg,
            Goal::Hull { .. } => {}
        }
    }

    fn demand(&self, estimate: &Estimate) -> HoverDemand {
        let (x_m, y_m) = self.relative.believed();
        let (left_x_m, left_y_m, vertical, bearing_deg) = match self.goal {
            Goal::Stay {
                x_m: to_x_m,
                y_m: to_y_m,
                depth_m,
                bearing_deg,
            } => (to_x_m - x_m, to_y_m - y_m, Vertical::Depth(depth_m), bearing_deg),
            Goal::Hull {
                horizontal_m,
                depth_m,
                distance_m,
            } => (
                self.relative.distance_m(estimate.ship_m) - distance_m,
                horizontal_m - y_m,
                Vertical::Depth(depth_m),
                0.0,
            ),
            Goal::Bottom {
                x_m: to_x_m,
                y_m: to_y_m,
                vertical,
                bearing_deg,
            } => (to_x_m - x_m, to_y_m - y_m, vertical, bearing_deg),
        };
        HoverDemand {
            ground: self
                .relative
                .over_ground(left_x_m * POSITION_GAIN_PER_S, left_y_m * POSITION_GAIN_PER_S),
            vertical,
            heading_deg: self.relative.heading_deg(bearing_deg),
            speed_max_mps: self.speed_limit_mps,
        }
    }

    /// Whether the vehicle arrives at its goal in this step, by the depth that it believes to be at.
    fn arrives(&mut self, vehicle: &Vehicle, estimate: &Estimate) -> bool {
        if self.arrived {
            return false;
        }
        let left = self.demand(estimate).ground;
        let left_m = hypot(left.0, left.1) / POSITION_GAIN_PER_S;
        let vertical_m = match self.goal {
            Goal::Stay { depth_m, .. } | Goal::Hull { depth_m, .. } => depth_m - estimate.depth_m,
            Goal::Bottom {
                vertical: Vertical::Altitude(altitude_m),
                ..
            } => vehicle.motion().water_depth_m - altitude_m - vehicle.motion().depth_m,
            Goal::Bottom {
                vertical: Vertical::Depth(metres) | Vertical::Pitch(metres) | Vertical::Elevator(metres),
                ..
            } => metres - estimate.depth_m,
        };
        self.arrived = left_m < ARRIVED_M && vertical_m.abs() < ARRIVED_M;
        self.arrived
    }
}

impl Hovering {
    /// The truth about a hovering vehicle, in addition to [`crate::Mvc::truth`]; `None` for other vehicles.
    pub(crate) fn truth(&self, vehicle: &Vehicle, mission: &Mission) -> Option<HoveringTruth> {
        let state = self.state.as_ref()?;
        let (x_m, y_m) = state.relative.truth();
        let motion = vehicle.motion();
        Some(HoveringTruth {
            clearance_m: vehicle.obstacle().map(|obstacle| {
                let (clearance_m, _) = obstacle.ship.clearance(motion.at, motion.depth_m);
                clearance_m
            }),
            x_m,
            y_m,
            bearing_deg: state.relative.true_bearing_deg(vehicle),
            sway_mps: motion.sway_mps,
            suspended_until: mission.suspended_until(),
            speed_limit_mps: state.speed_limit_mps,
            light_on: state.light_on,
        })
    }

    /// Sets, before a step of the vehicle, where the payload that has suspended the mission wants it to go.
    pub(crate) fn steer(&self, ctx: &Context<'_>, mission: &mut Mission) {
        if let Some(state) = &self.state
            && mission.is_suspended()
        {
            let demand = state.demand(&ctx.estimate);
            // The heading of a demand is one that the vehicle believes, so its bias is added.
            mission.set_hover(HoverDemand {
                heading_deg: demand.heading_deg + ctx.estimate.heading_bias_deg,
                ..demand
            });
        }
    }

    /// Turns the devices, after a step of the vehicle and before its sensors read. Returns the angle of the DVL,
    /// degrees above the horizontal.
    pub(crate) fn turn_devices(&mut self, mission: &Mission) -> Option<f64> {
        let state = self.state.as_mut()?;
        state.turn_devices(mission.is_suspended());
        Some(state.dvl.at_deg())
    }

    /// The service's step, after a step of the vehicle and of its sensors.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>, mission: &Mission) {
        let Some(state) = &mut self.state else { return };
        state.relative.reckon(ctx.vehicle, ctx.estimate.way);
        if mission.is_suspended() && state.arrives(ctx.vehicle, &ctx.estimate) {
            ctx.note(MvcEventKind::Hovering(HoveringEvent::Arrived));
        }
        state.report(ctx);
    }
}

impl Inspector {
    /// Sends BFRNV if there is a hull, BFCNV, and BFPIT.
    fn report(&mut self, ctx: &mut Context<'_>) {
        let (relative, cartesian) = (Topic::RelativeNavigation, Topic::CartesianNavigation);
        if ctx.now >= self.next_relative {
            self.next_relative = next_due(self.next_relative, ctx.now, self.relative_period);
            if ctx.wanted(relative.bit() | cartesian.bit()) {
                let created = ctx.stamp();
                let (x_m, y_m) = self.relative.believed();
                let x_m = x_m + self.position_noise_m * self.noise.gaussian();
                let y_m = y_m + self.position_noise_m * self.noise.gaussian();
                let range_noise_m = self.range_noise_m * self.noise.gaussian();
                let heading_deg = self.relative.bearing_deg(ctx.vehicle);
                let depth_m = ctx.estimate.depth_m;
                if self.has_hull {
                    let vertical = if ctx.interpretation.hull_vertical_up { -1.0 } else { 1.0 };
                    let message = RelativeNavigation {
                        created,
                        horizontal_m: y_m,
                        vertical_m: vertical * depth_m,
                        distance_m: (self.relative.distance_m(ctx.estimate.ship_m) + range_noise_m).max(0.0),
                        heading_deg,
                        depth_m,
                        absolute_heading_deg: self.relative.inertial_deg(ctx.vehicle),
                        roll_deg: ctx.vehicle.motion().roll_deg,
                        pitch_deg: ctx.vehicle.motion().pitch_deg,
                        solution: created,
                    };
                    ctx.publish(Some(relative), &message.into());
                }
                let message = CartesianNavigation {
                    created,
                    x_m,
                    y_m,
                    z_m: depth_m,
                    heading_deg,
                };
                ctx.publish(Some(cartesian), &message.into());
            }
        }
        if ctx.now >= self.next_servo {
            self.next_servo = next_due(self.next_servo, ctx.now, self.servo_period);
            if ctx.wanted(Topic::PitchServo.bit()) {
                let message = ServoPositions {
                    created: ctx.stamp(),
                    dvl_deg: self.dvl.at_deg(),
                    sonar_deg: self.sonar.at_deg(),
                };
                ctx.publish(Some(Topic::PitchServo), &message.into());
            }
        }
    }
}

/// The next due time of a periodic message: a period after the last one, or a period from now if the vehicle's steps
/// are longer than that.
fn next_due(due: Timestamp, now: Timestamp, period: Duration) -> Timestamp {
    let next = due + period;
    if next > now { next } else { now + period }
}

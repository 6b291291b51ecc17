mod aiding;
mod attitude;
mod compass;
mod dvl;
mod imu;
mod noise;
mod readings;
mod schedule;
mod solution;
mod tailcone;
mod untrue;
mod water;

use backseat_spi::{Navigation, PayloadCtd, PositionQuality, VelocityAndRates};
use backseat_units::{Altitude, Depth, EastNorth, GridHeading, Heading, LocalFrame, Position, TimeOfDay, Timestamp};
use backseat_world::World;

use self::compass::Compasses;
use self::dvl::Dvl;
use self::imu::Imu;
use self::noise::Noise;
use self::readings::Schedules;
use self::solution::Solution;
use self::tailcone::Tailcone;
use self::untrue::UntrueWords;
use self::water::{Water, true_sound_mps};
use crate::estimate::Estimate;
use crate::faults::{Sensor, Untrue};
use crate::file::{SensorConfig, WorldFile};
use crate::interpretation::Interpretation;
use crate::vehicle::Vertical;
use crate::vehicle::{Demand, Drive, HoverDemand, Turn, Vehicle};

use self::solution::FixOutcome;

/// What triggers the DVL (SPI 7.4).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Trigger {
    /// The DVL itself, at its own rate.
    #[default]
    Internal,
    /// Pulses on the payload's line, so many seconds apart; `None`: at the DVL's own rate.
    Pulses(Option<f64>),
    /// Nothing: it waits for a pulse and measures nothing.
    Nothing,
}

/// Velocity towards the frame's east and north, metres a second.
type EastNorthRate = (f64, f64);

/// What the vehicle's sensors measure of the truth: the navigation solution, and the readings of all sensors.
///
/// None of this depends on which messages are subscribed: the solution advances in every step, and the noise of a
/// reading depends only on the reading's number.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    config: SensorConfig,
    dt_s: f64,
    steps: u64,
    motion: Noise,
    report: Noise,
    solution: Solution,
    dvl: Dvl,
    compasses: Compasses,
    imu: Imu,
    tailcone: Tailcone,
    water: Water,
    depth_error_m: f64,
    /// The last depth reading, without noise, metres.
    depth_m: f64,
    /// The vehicle's speed of sound, divided by the true one: the scale error of a DVL without a phased array.
    sound_ratio: f64,
    schedules: Schedules,
    /// The vehicle's rates in the step before.
    before: Rates,
    now: Rates,
    last: Option<(Navigation, VelocityAndRates)>,
    failed: Failed,
    untrue: UntrueWords,
}

#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    ground: EastNorthRate,
    heave_mps: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Failed {
    frozen: bool,
    silent: bool,
    altimeter: bool,
    compass: bool,
    depth: bool,
    imu: bool,
    tailcone: bool,
    telemetry: bool,
}

impl Sensors {
    pub(crate) fn new(file: &WorldFile, interpretation: &Interpretation, vehicle: &Vehicle, seed: u64) -> Self {
        let config = file.sensors;
        let dt_s = 1.0 / f64::from(file.vehicle.tick_hz);
        let water = Water::new(&config, interpretation.ctd_pressure_is_gauge, seed);
        let depth_error_m = water.depth_error_m();
        Self {
            config,
            dt_s,
            steps: 0,
            motion: Noise::new(seed, "dead reckoning"),
            report: Noise::new(seed, "navigation"),
            solution: Solution::new(&config, dt_s, vehicle, seed),
            dvl: Dvl::new(
                &config,
                3600.0 / dt_s,
                vehicle.performance().hovers,
                file.hovering.range_max_m,
                seed,
            ),
            compasses: Compasses::new(&config.compass, seed),
            imu: Imu::new(&config.imu, seed),
            tailcone: Tailcone::new(&config.tailcone, seed),
            water,
            depth_error_m,
            depth_m: vehicle.motion().depth_m + depth_error_m,
            sound_ratio: 1.0,
            schedules: Schedules::new(&config),
            before: Rates::default(),
            now: Rates::default(),
            last: None,
            failed: Failed::default(),
            untrue: UntrueWords::default(),
        }
    }

    /// The estimate by which the executive steers.
    pub(crate) fn estimate(&self, vehicle: &Vehicle) -> Estimate {
        let velocity = self.solution.velocity;
        // The current is the velocity over ground minus the velocity through the water.
        let water = (
            vehicle.motion().ground.0 - vehicle.motion().current.0,
            vehicle.motion().ground.1 - vehicle.motion().current.1,
        );
        Estimate {
            at: self.solution.at,
            depth_m: self.depth_m,
            heading_deg: vehicle.motion().heading_deg + self.solution.heading_bias_deg,
            surge_mps: vehicle.motion().surge_mps,
            current: (velocity.0 - water.0, velocity.1 - water.1),
            heading_bias_deg: self.solution.heading_bias_deg,
            way: self.solution.own_way(),
            ship_m: self.dvl.ship_m,
        }
    }

    /// What a demand makes the vehicle do in truth: it holds heading and depth by its sensors, so their errors are
    /// subtracted.
    pub(crate) fn as_flown(&self, drive: Drive) -> Drive {
        match drive {
            Drive::Under(demand) => Drive::Under(Demand {
                turn: match demand.turn {
                    Turn::Heading(heading_deg) => Turn::Heading(heading_deg - self.solution.heading_bias_deg),
                    Turn::Rudder(_) => demand.turn,
                },
                vertical: self.vertical_as_flown(demand.vertical),
                ..demand
            }),
            Drive::Hover(demand) => Drive::Hover(HoverDemand {
                heading_deg: demand.heading_deg - self.solution.heading_bias_deg,
                vertical: self.vertical_as_flown(demand.vertical),
                ..demand
            }),
            Drive::Held | Drive::Adrift => drive,
        }
    }

    fn vertical_as_flown(&self, vertical: Vertical) -> Vertical {
        match vertical {
            Vertical::Depth(depth_m) => Vertical::Depth((depth_m - self.depth_error_m).max(0.0)),
            Vertical::Altitude(_) | Vertical::Pitch(_) | Vertical::Elevator(_) => vertical,
        }
    }

    /// Whether the solution uses GPS.
    pub(crate) const fn has_gps(&self) -> bool {
        self.solution.has_gps()
    }

    /// Whether the DVL has bottom lock.
    pub(crate) const fn has_bottom_lock(&self) -> bool {
        self.dvl.lock
    }

    /// Sets what triggers the DVL in this step.
    pub(crate) fn trigger_dvl(&mut self, trigger: Trigger) {
        self.dvl.waits = trigger == Trigger::Nothing;
        let own_s = self.config.dvl.period_s;
        self.schedules.trigger_dvl_every(match trigger {
            Trigger::Internal | Trigger::Nothing | Trigger::Pulses(None) => own_s,
            Trigger::Pulses(Some(period_s)) => period_s,
        });
    }

    /// Turns the DVL to this angle, degrees above the horizontal.
    pub(crate) fn turn_log(&mut self, look_deg: f64) {
        self.dvl.turn_to(look_deg);
    }

    /// Freezes navigation, with its values and the time of its solution, or lets it continue.
    pub(crate) const fn freeze(&mut self, frozen: bool) {
        self.failed.frozen = frozen;
    }

    /// Begins or ends a fault, identified by its number, that makes navigation report wrong values from the next step
    /// on.
    pub(crate) fn say_untrue(&mut self, number: usize, what: Option<Untrue>) {
        match what {
            Some(what) => self.untrue.begin(number, what, self.steps, self.solution.at),
            None => self.untrue.end(number),
        }
    }

    /// Makes the solution jump.
    pub(crate) fn jump(&mut self, way: EastNorth) {
        self.solution.move_by(way);
    }

    /// Stops the sending of navigation, or starts it again.
    pub(crate) const fn silence_navigation(&mut self, silent: bool) {
        self.failed.silent = silent;
    }

    /// Makes a sensor fail, or work again.
    pub(crate) const fn sensor_dropout(&mut self, sensor: Sensor, dead: bool) {
        match sensor {
            Sensor::Dvl => self.dvl.dead = dead,
            Sensor::Altimeter => self.failed.altimeter = dead,
            Sensor::Gps => self.solution.kill_gps(dead),
            Sensor::Compass => self.failed.compass = dead,
            Sensor::Depth => self.failed.depth = dead,
            Sensor::Imu => self.failed.imu = dead,
            Sensor::Ctd => self.water.ctd_dead = dead,
            Sensor::SoundVelocity => self.water.sound_dead = dead,
            Sensor::Tailcone => self.failed.tailcone = dead,
            Sensor::Telemetry => self.failed.telemetry = dead,
        }
    }

    /// Applies a payload's fix, see [`Solution::fix`].
    pub(crate) fn fix(
        &mut self,
        now: Timestamp,
        place: EastNorth,
        error_m: f64,
        age_s: f64,
        force: bool,
    ) -> FixOutcome {
        self.solution.fix(now, place, error_m, age_s, force)
    }

    /// Takes a payload's CTD data.
    pub(crate) fn heed_payload_ctd(&mut self, now: Timestamp, data: &PayloadCtd) {
        self.water.heed(now, data);
    }

    /// Follows a step that the vehicle has made.
    fn advance(&mut self, vehicle: &Vehicle, world: &World, now: Timestamp) {
        self.steps += 1;
        self.before = self.now;
        self.now = Rates {
            ground: vehicle.motion().ground,
            heave_mps: vehicle.motion().heave_mps,
        };
        if !self.failed.depth {
            self.depth_m = vehicle.motion().depth_m + self.depth_error_m;
        }
        if !self.config.dvl.phased_array && self.schedules.sound_ratio.due(now).is_some() {
            let used_mps = self.water.sound_mps(vehicle, world, now);
            self.sound_ratio = used_mps / true_sound_mps(vehicle, world, now);
        }
        let mut draws = self.motion.reading(self.steps);
        self.dvl.step(vehicle, now, &mut draws);
        self.solution
            .step(vehicle, &self.dvl, self.sound_ratio, now, &mut draws);
    }

    /// BFNVG and BFNVR of this step. The stamp is the time of the messages and of the solution.
    fn navigation(
        &mut self,
        vehicle: &Vehicle,
        frame: &LocalFrame,
        convergence_deg: f64,
        stamp: TimeOfDay,
    ) -> (Navigation, VelocityAndRates) {
        if self.failed.frozen
            && let Some((navigation, velocity)) = &mut self.last
        {
            (navigation.created, velocity.created) = (stamp, stamp);
            return (navigation.clone(), velocity.clone());
        }
        let config = &self.config;
        let mut draws = self.report.reading(self.steps);
        let noise = EastNorth::new(draws.gaussian(), draws.gaussian()) * config.position_noise_m;
        let heading_deg =
            vehicle.motion().heading_deg + self.solution.heading_bias_deg + draws.normal(config.heading_noise_deg);
        let depth_m = self.depth_m + draws.normal(config.depth_noise_m);
        let altitude_noise_m = draws.normal(config.altitude_noise_m);
        let place = self.untrue.place(self.solution.at + noise, self.steps, self.dt_s);
        let (heading_deg, depth_m) = self.untrue.attitude(heading_deg, depth_m, self.steps);
        let navigation = Navigation {
            created: stamp,
            position: frame.to_position(place),
            quality: if self.has_gps() {
                PositionQuality::Gps
            } else {
                PositionQuality::NoGps
            },
            altitude: if self.dvl.sounds && !self.failed.altimeter {
                // An altitude of zero would mean that there is no lock.
                Altitude::from_m(
                    (vehicle.motion().water_depth_m - vehicle.motion().depth_m + altitude_noise_m).max(0.01),
                )
                .ok()
            } else {
                None
            },
            depth: Depth::from_m(depth_m.clamp(-100.0, 12_000.0)).expect("clamped to the range of a depth"),
            heading: GridHeading::from_deg(heading_deg + convergence_deg)
                .expect("a wrapped angle, a convergence and noise are finite"),
            roll_deg: vehicle.motion().roll_deg + draws.normal(config.attitude_noise_deg),
            pitch_deg: vehicle.motion().pitch_deg + draws.normal(config.attitude_noise_deg),
            solution: stamp,
        };
        let velocity = VelocityAndRates {
            created: stamp,
            east_mps: self.solution.velocity.0 + draws.normal(config.velocity_noise_mps),
            north_mps: self.solution.velocity.1 + draws.normal(config.velocity_noise_mps),
            down_mps: vehicle.motion().heave_mps,
            pitch_rate_dps: vehicle.motion().pitch_rate_dps,
            roll_rate_dps: vehicle.motion().roll_rate_dps,
            yaw_rate_dps: vehicle.motion().yaw_rate_dps,
        };
        self.last = Some((navigation.clone(), velocity.clone()));
        (navigation, velocity)
    }
}

/// Converts a heading from the frame's north to one from true north.
pub(crate) fn true_heading(frame_deg: f64, frame: &LocalFrame, position: Position) -> Heading {
    Heading::from_deg(frame_deg + frame.convergence_deg(position))
        .expect("a wrapped angle and a convergence are finite")
}

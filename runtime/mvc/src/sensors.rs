use backseat_spi::{Ctd, Navigation, PositionQuality, VelocityAndRates};
use backseat_units::utm_convergence_deg;
use backseat_units::{Altitude, Depth, EastNorth, Heading, LocalFrame, Position, TimeOfDay, Timestamp};
use backseat_world::{Stream, World};

use crate::estimate::Estimate;
use crate::faults::SensorKind;
use crate::file::SensorConfig;
use crate::vehicle::Vehicle;

/// Pressure of the air, kilopascals, and of a metre of sea water at 1025 kg/m3.
const AIR_KPA: f64 = 101.325;
const WATER_KPA_PER_M: f64 = 10.052;
/// Above this depth the antenna is out of the water, metres.
const SURFACED_M: f64 = 0.3;

/// What the vehicle's own sensors make of the truth: seeded noise, drift, losses of bottom lock.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    config: SensorConfig,
    stream: Stream,
    lock: Stream,
    ctd: Stream,
    /// How much of the walk one reading makes, metres, and how likely one is to lose bottom lock.
    drift_step_m: f64,
    dropout_chance: f64,
    drift: EastNorth,
    no_lock_until: Timestamp,
    /// The last solution that was told, repeated while navigation is frozen.
    told: Option<Navigation>,
    told_velocity: Option<VelocityAndRates>,
    frozen: bool,
    silent: bool,
    /// By how much faults have moved the solution.
    offset: EastNorth,
    out: [bool; SensorKind::ALL.len()],
}

impl Sensors {
    pub(crate) fn new(config: SensorConfig, tick_hz: u32, seed: u64) -> Self {
        let readings_per_h = 3600.0 * f64::from(tick_hz);
        Self {
            config,
            stream: Stream::new(seed, "navigation"),
            lock: Stream::new(seed, "bottom lock"),
            ctd: Stream::new(seed, "ctd"),
            drift_step_m: config.position_drift_m_per_sqrt_h / readings_per_h.sqrt(),
            dropout_chance: config.altitude_dropouts_per_h / readings_per_h,
            drift: EastNorth::default(),
            no_lock_until: Timestamp::ZERO,
            told: None,
            told_velocity: None,
            frozen: false,
            silent: false,
            offset: EastNorth::default(),
            out: [false; SensorKind::ALL.len()],
        }
    }

    /// What the executive steers by.
    pub(crate) fn estimate(&self, vehicle: &Vehicle) -> Estimate {
        Estimate {
            at: vehicle.at + self.offset,
            depth_m: vehicle.depth_m,
            heading_deg: vehicle.heading_deg,
            surge_mps: vehicle.surge_mps,
            current: vehicle.current,
        }
    }

    /// Navigation repeats its last solution, and its time.
    pub(crate) const fn freeze(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// Moves the solution.
    pub(crate) fn jump(&mut self, by: EastNorth) {
        self.offset = self.offset + by;
    }

    /// Navigation is not told.
    pub(crate) const fn silence_navigation(&mut self, silent: bool) {
        self.silent = silent;
    }

    pub(crate) const fn navigation_silent(&self) -> bool {
        self.silent
    }

    /// A sensor gives nothing.
    pub(crate) const fn sensor_dropout(&mut self, sensor: SensorKind, out: bool) {
        self.out[sensor as usize] = out;
    }

    pub(crate) const fn is_out(&self, sensor: SensorKind) -> bool {
        self.out[sensor as usize]
    }

    /// BFNVG: `stamp` is both when it was made and when it was solved.
    pub(crate) fn navigation(
        &mut self,
        vehicle: &Vehicle,
        frame: &LocalFrame,
        now: Timestamp,
        stamp: TimeOfDay,
    ) -> Navigation {
        if self.frozen
            && let Some(told) = &self.told
        {
            return Navigation {
                created: stamp,
                ..told.clone()
            };
        }
        let config = self.config;
        let surfaced = vehicle.depth_m < SURFACED_M && !self.is_out(SensorKind::Gps);
        if surfaced {
            self.drift = EastNorth::default();
        } else {
            let (east, north) = (self.stream.gaussian(), self.stream.gaussian());
            self.drift = self.drift + EastNorth::new(east, north) * self.drift_step_m;
        }
        let noise = EastNorth::new(self.stream.gaussian(), self.stream.gaussian()) * config.position_noise_m;
        let position = frame.to_position(vehicle.at + self.drift + self.offset + noise);
        let heading_deg = vehicle.heading_deg + config.heading_noise_deg * self.stream.gaussian();
        let navigation = Navigation {
            created: stamp,
            position,
            quality: if surfaced {
                PositionQuality::Gps
            } else {
                PositionQuality::NoGps
            },
            altitude: self.altitude(vehicle, now),
            depth: depth(vehicle.depth_m + config.depth_noise_m * self.stream.gaussian()),
            heading: true_heading(heading_deg, frame, position).to_grid(utm_convergence_deg(position)),
            roll_deg: vehicle.roll_deg + config.attitude_noise_deg * self.stream.gaussian(),
            pitch_deg: vehicle.pitch_deg + config.attitude_noise_deg * self.stream.gaussian(),
            solution: stamp,
        };
        self.told = Some(navigation.clone());
        navigation
    }

    /// BFNVR, with the same stamp as its BFNVG.
    pub(crate) fn velocity(&mut self, vehicle: &Vehicle, stamp: TimeOfDay) -> VelocityAndRates {
        if self.frozen
            && let Some(told) = &self.told_velocity
        {
            return VelocityAndRates {
                created: stamp,
                ..told.clone()
            };
        }
        let noise_mps = self.config.velocity_noise_mps;
        let velocity = VelocityAndRates {
            created: stamp,
            east_mps: vehicle.ground.0 + noise_mps * self.stream.gaussian(),
            north_mps: vehicle.ground.1 + noise_mps * self.stream.gaussian(),
            down_mps: vehicle.heave_mps,
            pitch_rate_dps: vehicle.pitch_rate_dps,
            roll_rate_dps: vehicle.roll_rate_dps,
            yaw_rate_dps: vehicle.yaw_rate_dps,
        };
        self.told_velocity = Some(velocity.clone());
        velocity
    }

    /// BFCTD.
    pub(crate) fn ctd(&mut self, vehicle: &Vehicle, world: &World, now: Timestamp, stamp: TimeOfDay) -> Ctd {
        let config = self.config;
        let conductivity = world.conductivity_us_per_cm(vehicle.at, vehicle.depth_m, now);
        let temperature_c = world.temperature_c(vehicle.at, vehicle.depth_m, now);
        let pressure_kpa = AIR_KPA + WATER_KPA_PER_M * vehicle.depth_m;
        Ctd {
            created: stamp,
            conductivity_us_per_cm: (conductivity + config.conductivity_noise_us_per_cm * self.ctd.gaussian()).max(0.0),
            temperature_c: temperature_c + config.temperature_noise_c * self.ctd.gaussian(),
            pressure_kpa: pressure_kpa + config.pressure_noise_kpa * self.ctd.gaussian(),
            measured: stamp,
        }
    }

    /// None without bottom lock.
    fn altitude(&mut self, vehicle: &Vehicle, now: Timestamp) -> Option<Altitude> {
        let config = self.config;
        if self.lock.uniform() < self.dropout_chance {
            let seconds = config.altitude_dropout_s * self.lock.uniform_in(0.5, 1.5);
            self.no_lock_until = now + core::time::Duration::from_secs_f64(seconds);
        }
        let altitude_m = vehicle.water_depth_m - vehicle.depth_m;
        let in_range = altitude_m >= config.altitude_blanking_m && altitude_m <= config.altitude_range_m;
        if !in_range || now < self.no_lock_until || self.is_out(SensorKind::Dvl) || self.is_out(SensorKind::Altimeter) {
            return None;
        }
        // A reading of zero would say that there is no lock.
        Altitude::from_m((altitude_m + config.altitude_noise_m * self.stream.gaussian()).max(0.01)).ok()
    }
}

/// The heading from true north, of one from the frame's north.
pub(crate) fn true_heading(frame_deg: f64, frame: &LocalFrame, position: Position) -> Heading {
    Heading::from_deg(frame_deg + frame.convergence_deg(position))
        .expect("a wrapped angle and a convergence are finite")
}

fn depth(metres: f64) -> Depth {
    Depth::from_m(metres.clamp(-100.0, 12_000.0)).expect("clamped to the range of a depth")
}

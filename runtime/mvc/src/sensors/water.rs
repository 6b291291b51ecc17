use core::time::Duration;

use backseat_spi::{Ctd, DepthSensor, PayloadCtd, SoundVelocity};
use backseat_units::{TimeOfDay, Timestamp};
use backseat_world::{World, seawater};

use super::noise::Noise;
use crate::file::SensorConfig;
use crate::vehicle::Vehicle;

/// Atmospheric pressure, kilopascals.
const AIR_KPA: f64 = 101.325;
/// Pressure of a metre of sea water at 1025 kg/m3, kilopascals. It converts a sensor's error to metres.
const WATER_KPA_PER_M: f64 = 10.052;

/// The sensors for the water: pressure, temperature, conductivity, speed of sound.
#[derive(Clone, Debug)]
pub(super) struct Water {
    config: SensorConfig,
    ctd: Noise,
    pressure: Noise,
    sound: Noise,
    temperature_bias_c: f64,
    conductivity_bias_us_per_cm: f64,
    ctd_pressure_bias_kpa: f64,
    depth_bias_kpa: f64,
    /// What the pressure of BFCTD and BPCTD counts from, absolute, kilopascals.
    ctd_pressure_from_kpa: f64,
    sound_bias_mps: f64,
    /// Speed of sound from the payload's newest CTD data, and until when it is used.
    by_payload: Option<(f64, Timestamp)>,
    pub(super) ctd_dead: bool,
    pub(super) sound_dead: bool,
}

impl Water {
    pub(super) fn new(config: &SensorConfig, ctd_pressure_is_gauge: bool, seed: u64) -> Self {
        let mut ctd = Noise::new(seed, "ctd bias").reading(0);
        Self {
            config: *config,
            ctd: Noise::new(seed, "ctd"),
            pressure: Noise::new(seed, "depth sensor"),
            sound: Noise::new(seed, "sound velocity"),
            temperature_bias_c: ctd.normal(config.temperature_bias_c),
            conductivity_bias_us_per_cm: ctd.normal(config.conductivity_bias_us_per_cm),
            ctd_pressure_bias_kpa: ctd.normal(config.pressure_bias_kpa),
            depth_bias_kpa: Noise::new(seed, "depth sensor bias")
                .reading(0)
                .normal(config.depth.bias_kpa),
            ctd_pressure_from_kpa: if ctd_pressure_is_gauge { AIR_KPA } else { 0.0 },
            sound_bias_mps: Noise::new(seed, "sound velocity bias")
                .reading(0)
                .normal(config.sound.bias_mps),
            by_payload: None,
            ctd_dead: false,
            sound_dead: false,
        }
    }

    /// Error of the depth, metres.
    pub(super) fn depth_error_m(&self) -> f64 {
        self.depth_bias_kpa / WATER_KPA_PER_M
    }

    /// BFRDP (SPI 6.6), with the reading of this number. The pressure is absolute, with that of the atmosphere.
    pub(super) fn depth_sensor(&self, vehicle: &Vehicle, world: &World, number: u64, stamp: TimeOfDay) -> DepthSensor {
        let noise_kpa = self.pressure.reading(number).normal(self.config.depth.noise_kpa);
        DepthSensor {
            created: stamp,
            pressure_kpa: pressure_kpa(world, vehicle.motion().depth_m) + self.depth_bias_kpa + noise_kpa,
        }
    }

    /// BFCTD (SPI 6.16), with the reading of this number.
    pub(super) fn ctd(&self, vehicle: &Vehicle, world: &World, now: Timestamp, number: u64, stamp: TimeOfDay) -> Ctd {
        let config = &self.config;
        let mut draws = self.ctd.reading(number);
        let (conductivity, temperature_c, pressure_kpa) = self.ctd_without_noise(vehicle, world, now);
        let conductivity = conductivity + draws.normal(config.conductivity_noise_us_per_cm);
        Ctd {
            created: stamp,
            conductivity_us_per_cm: conductivity.max(0.0),
            temperature_c: temperature_c + draws.normal(config.temperature_noise_c),
            pressure_kpa: pressure_kpa - self.ctd_pressure_from_kpa + draws.normal(config.pressure_noise_kpa),
            measured: stamp,
        }
    }

    fn ctd_without_noise(&self, vehicle: &Vehicle, world: &World, now: Timestamp) -> (f64, f64, f64) {
        let (at, depth_m) = (vehicle.motion().at, vehicle.motion().depth_m);
        (
            world.conductivity_us_per_cm(at, depth_m, now) + self.conductivity_bias_us_per_cm,
            world.temperature_c(at, depth_m, now) + self.temperature_bias_c,
            pressure_kpa(world, depth_m) + self.ctd_pressure_bias_kpa,
        )
    }

    /// Takes a payload's measurement of the water (SPI 7.15).
    pub(super) fn heed(&mut self, now: Timestamp, data: &PayloadCtd) {
        let pressure_kpa = data.pressure_kpa + self.ctd_pressure_from_kpa;
        let speed_mps = sound_speed_by_ctd_mps(data.conductivity_us_per_cm, data.temperature_c, pressure_kpa);
        let until = now + Duration::from_secs_f64(self.config.sound.payload_data_for_s);
        self.by_payload = Some((speed_mps, until));
    }

    /// The vehicle's value for the speed of sound, metres a second, without a sensor's noise.
    pub(super) fn sound_mps(&self, vehicle: &Vehicle, world: &World, now: Timestamp) -> f64 {
        if self.config.sound.fitted && !self.sound_dead {
            return true_sound_mps(vehicle, world, now) + self.sound_bias_mps;
        }
        if let Some((speed_mps, until)) = self.by_payload
            && now < until
        {
            return speed_mps;
        }
        if self.config.ctd_fitted && !self.ctd_dead {
            let (conductivity, temperature_c, pressure_kpa) = self.ctd_without_noise(vehicle, world, now);
            return sound_speed_by_ctd_mps(conductivity, temperature_c, pressure_kpa);
        }
        self.config.sound.nominal_mps
    }

    /// BFSVS (SPI 6.4), with the reading of this number from the sensor, or with the estimate if there is no sensor.
    pub(super) fn sound(
        &self,
        vehicle: &Vehicle,
        world: &World,
        now: Timestamp,
        number: u64,
        stamp: TimeOfDay,
    ) -> SoundVelocity {
        let sensed = self.config.sound.fitted && !self.sound_dead;
        let noise_mps = self.sound.reading(number).normal(self.config.sound.noise_mps);
        SoundVelocity {
            created: stamp,
            sound_velocity_mps: self.sound_mps(vehicle, world, now) + if sensed { noise_mps } else { 0.0 },
        }
    }
}

/// Absolute pressure at a depth, kilopascals.
fn pressure_kpa(world: &World, depth_m: f64) -> f64 {
    AIR_KPA + 10.0 * world.pressure_dbar(depth_m)
}

/// The true speed of sound, metres a second.
pub(super) fn true_sound_mps(vehicle: &Vehicle, world: &World, now: Timestamp) -> f64 {
    world.sound_speed_mps(vehicle.motion().at, vehicle.motion().depth_m, now)
}

/// Speed of sound from the readings of a CTD: microsiemens a centimetre, degrees Celsius, kilopascals including the
/// atmosphere.
fn sound_speed_by_ctd_mps(conductivity_us_per_cm: f64, temperature_c: f64, pressure_kpa: f64) -> f64 {
    let pressure_dbar = 0.1 * (pressure_kpa - AIR_KPA).max(0.0);
    let salinity = seawater::salinity(conductivity_us_per_cm, temperature_c, pressure_dbar);
    seawater::sound_speed_mps(salinity, temperature_c, pressure_dbar)
}

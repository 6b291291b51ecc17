use backseat_spi::{ControlSurfaces, VehicleSpeed};
use backseat_units::TimeOfDay;

use super::noise::Noise;
use crate::file::TailconeConfig;
use crate::vehicle::Vehicle;

/// Thruster, rudder and elevator.
#[derive(Clone, Debug)]
pub(super) struct Tailcone {
    config: TailconeConfig,
    rotation: Noise,
    angles: Noise,
    /// Error of the table of speeds, a factor.
    table: f64,
}

impl Tailcone {
    pub(super) fn new(config: &TailconeConfig, seed: u64) -> Self {
        let mut constant = Noise::new(seed, "speed table").reading(0);
        Self {
            config: *config,
            rotation: Noise::new(seed, "thruster"),
            angles: Noise::new(seed, "tailcone angles"),
            table: 1.0 + constant.normal(config.speed_error),
        }
    }

    /// BFRVL (SPI 6.7), with the reading of this number.
    pub(super) fn speed(&self, vehicle: &Vehicle, number: u64, stamp: TimeOfDay) -> VehicleSpeed {
        let rpm_per_mps = vehicle.performance().rpm_per_mps;
        let turns_rpm = vehicle.motion().tail.map_or(0.0, |tail| tail.now.propeller_rpm);
        let thruster_rpm = turns_rpm + self.rotation.reading(number).normal(self.config.rpm_noise);
        VehicleSpeed {
            created: stamp,
            thruster_rpm,
            water_speed_mps: self.config.speed_table.then(|| thruster_rpm / rpm_per_mps * self.table),
        }
    }

    /// BFERC (SPI 6.12), with the reading of this number: the angles, and the targets to which they were commanded.
    pub(super) fn angles(&self, vehicle: &Vehicle, number: u64, stamp: TimeOfDay) -> ControlSurfaces {
        let mut draws = self.angles.reading(number);
        let mut noise_deg = || draws.normal(self.config.angle_noise_deg);
        let tail = vehicle.motion().tail.unwrap_or_default();
        ControlSurfaces {
            created: stamp,
            elevator_deg: tail.now.elevator_deg() + noise_deg(),
            rudder_deg: tail.now.rudder_deg + noise_deg(),
            elevator_target_deg: tail.ordered.elevator_deg(),
            rudder_target_deg: tail.ordered.rudder_deg,
        }
    }
}

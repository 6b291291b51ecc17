use backseat_spi::{ControlSurfaces, VehicleSpeed};
use backseat_units::TimeOfDay;

use super::Rates;
use super::noise::Noise;
use crate::file::TailconeConfig;
use crate::vehicle::Vehicle;

/// The least value for the fastest turn, degrees a second. It avoids a division by zero for a vehicle without speed.
const TURN_LEAST_DPS: f64 = 0.5;

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
        // After a release against the current, the speed through the water can be negative while the thruster does not
        // turn yet.
        let turns_rpm = vehicle
            .motion()
            .tail
            .map_or(vehicle.motion().surge_mps.max(0.0) * rpm_per_mps, |tail| {
                tail.now.propeller_rpm
            });
        let thruster_rpm = turns_rpm + self.rotation.reading(number).normal(self.config.rpm_noise);
        VehicleSpeed {
            created: stamp,
            thruster_rpm,
            water_speed_mps: self.config.speed_table.then(|| thruster_rpm / rpm_per_mps * self.table),
        }
    }

    /// BFERC (SPI 6.12), with the reading of this number.
    ///
    /// If the model has fins, their angles. The first-order model has none: there, an angle is the vehicle's turn or
    /// climb as a share of its fastest turn at this speed, or of its fastest climb. The target is the demanded share,
    /// computed from the change of the rate in a step.
    pub(super) fn angles(
        &self,
        vehicle: &Vehicle,
        before: &Rates,
        dt_s: f64,
        number: u64,
        stamp: TimeOfDay,
    ) -> ControlSurfaces {
        let mut draws = self.angles.reading(number);
        let mut noise_deg = || draws.normal(self.config.angle_noise_deg);
        if let Some(tail) = vehicle.motion().tail {
            return ControlSurfaces {
                created: stamp,
                elevator_deg: tail.now.elevator_deg() + noise_deg(),
                rudder_deg: tail.now.rudder_deg + noise_deg(),
                elevator_target_deg: tail.ordered.elevator_deg(),
                rudder_target_deg: tail.ordered.rudder_deg,
            };
        }
        let performance = vehicle.performance();
        let most_deg = self.config.angle_max_deg;
        let angle = |rate: f64, fastest: f64| (most_deg * rate / fastest).clamp(-most_deg, most_deg);
        let asked = |before: f64, now: f64, tau_s: f64| before + (now - before) * (tau_s + dt_s) / dt_s;
        let yaw_dps = asked(
            before.yaw_rate_dps,
            vehicle.motion().yaw_rate_dps,
            performance.yaw_tau_s,
        );
        let turn_max_dps = performance.turn_max_dps(vehicle.motion().surge_mps).max(TURN_LEAST_DPS);
        let heave_mps = asked(before.heave_mps, vehicle.motion().heave_mps, performance.heave_tau_s);
        ControlSurfaces {
            created: stamp,
            elevator_deg: angle(-vehicle.motion().heave_mps, performance.depth_rate_max_mps) + noise_deg(),
            rudder_deg: angle(vehicle.motion().yaw_rate_dps, turn_max_dps) + noise_deg(),
            elevator_target_deg: angle(-heave_mps, performance.depth_rate_max_mps),
            rudder_target_deg: angle(yaw_dps, turn_max_dps),
        }
    }
}

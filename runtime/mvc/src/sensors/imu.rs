use backseat_spi::Imu as ImuMessage;
use backseat_units::TimeOfDay;
use backseat_units::math::sin_cos;

use super::Rates;
use super::attitude::Attitude;
use super::noise::Noise;
use crate::file::ImuConfig;
use crate::vehicle::Vehicle;

/// Standard gravity, metres a second squared (ISO 80000-3).
const GRAVITY_MPS2: f64 = 9.806_65;

/// Gyroscopes and accelerometers.
#[derive(Clone, Debug)]
pub(super) struct Imu {
    config: ImuConfig,
    noise: Noise,
    rate_bias_dps: [f64; 3],
    acceleration_bias_mps2: [f64; 3],
}

impl Imu {
    pub(super) fn new(config: &ImuConfig, seed: u64) -> Self {
        let mut constant = Noise::new(seed, "imu bias").reading(0);
        Self {
            config: *config,
            noise: Noise::new(seed, "imu"),
            rate_bias_dps: [(); 3].map(|()| constant.normal(config.rate_bias_dph / 3600.0)),
            acceleration_bias_mps2: [(); 3].map(|()| constant.normal(config.acceleration_bias_mps2)),
        }
    }

    /// BFIMU (SPI 6.15), with the reading of this number. An accelerometer does not measure gravity but the force
    /// against it: level and at rest, it reads -9.81 down.
    pub(super) fn message(
        &self,
        vehicle: &Vehicle,
        before: &Rates,
        dt_s: f64,
        number: u64,
        stamp: TimeOfDay,
    ) -> ImuMessage {
        let mut draws = self.noise.reading(number);
        let rate_dps = body_rates_dps(vehicle);
        let acceleration = Attitude::of(vehicle).to_body([
            (vehicle.motion().ground.1 - before.ground.1) / dt_s,
            (vehicle.motion().ground.0 - before.ground.0) / dt_s,
            (vehicle.motion().heave_mps - before.heave_mps) / dt_s - GRAVITY_MPS2,
        ]);
        ImuMessage {
            created: stamp,
            rate_dps: [0, 1, 2].map(|axis: usize| {
                rate_dps[axis] + self.rate_bias_dps[axis] + draws.normal(self.config.rate_noise_dps)
            }),
            acceleration_mps2: [0, 1, 2].map(|axis: usize| {
                acceleration[axis]
                    + self.acceleration_bias_mps2[axis]
                    + draws.normal(self.config.acceleration_noise_mps2)
            }),
            measured: stamp,
        }
    }
}

/// Rates about the vehicle's axes, computed from the rates of roll, pitch and heading (Fossen 2011, equation 2.26).
fn body_rates_dps(vehicle: &Vehicle) -> [f64; 3] {
    let (sin_pitch, cos_pitch) = sin_cos(vehicle.motion().pitch_deg.to_radians());
    let (sin_roll, cos_roll) = sin_cos(vehicle.motion().roll_deg.to_radians());
    let (roll, pitch, yaw) = (
        vehicle.motion().roll_rate_dps,
        vehicle.motion().pitch_rate_dps,
        vehicle.motion().yaw_rate_dps,
    );
    [
        roll - yaw * sin_pitch,
        pitch * cos_roll + yaw * sin_roll * cos_pitch,
        yaw * cos_roll * cos_pitch - pitch * sin_roll,
    ]
}

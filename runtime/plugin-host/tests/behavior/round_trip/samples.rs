use std::time::Duration;

use backseat_core::plugin::{
    BatterySample, BuoyancySample, CompassSample, DvlBeamsSample, DvlSample, ImuSample, PressureSample, Sample,
    ServoSample, SoundVelocitySample, SurfacesSample, TelemetrySample, TrimSample, VehicleSpeedSample,
};
use backseat_sdk as sdk;
use backseat_units::Timestamp;

/// Every sample with its form in the guest, in a step at `now`.
pub(super) fn samples(now: Timestamp) -> Vec<(Sample, sdk::Sample)> {
    let ago = |before_ms| now - Duration::from_millis(before_ms);
    vec![
        (
            Sample::Telemetry(TelemetrySample {
                measured: ago(1),
                acoustic_up_available_kb: 1.5,
                acoustic_up_last_kb: 2.5,
                acoustic_down_available_kb: 3.5,
                acoustic_down_last_kb: 4.5,
                rf_connected: true,
                ethernet_available: false,
            }),
            sdk::Sample::Telemetry(sdk::Telemetry {
                age_ns: 1_000_000,
                acoustic_up_available: 1.5,
                acoustic_up_last: 2.5,
                acoustic_down_available: 3.5,
                acoustic_down_last: 4.5,
                rf_connected: true,
                ethernet_available: false,
            }),
        ),
        (
            Sample::SoundVelocity(SoundVelocitySample {
                measured: ago(2),
                sound_velocity_mps: 1_480.123_456_789,
            }),
            sdk::Sample::SoundVelocity(sdk::SoundVelocity {
                age_ns: 2_000_000,
                velocity: 1_480.123_456_789,
            }),
        ),
        (
            Sample::Compass(CompassSample {
                measured: ago(3),
                number: 2,
                heading_deg: 5.5,
                pitch_deg: -6.5,
                roll_deg: 7.5,
            }),
            sdk::Sample::Compass(sdk::Compass {
                age_ns: 3_000_000,
                number: 2,
                heading: 5.5,
                pitch: -6.5,
                roll: 7.5,
            }),
        ),
        (
            Sample::Pressure(PressureSample {
                measured: ago(4),
                pressure_kpa: 8.5,
            }),
            sdk::Sample::Pressure(sdk::Pressure {
                age_ns: 4_000_000,
                pressure: 8.5,
            }),
        ),
        (
            Sample::VehicleSpeed(VehicleSpeedSample {
                measured: ago(5),
                thruster_rpm: -9.5,
                water_speed_mps: Some(10.5),
            }),
            sdk::Sample::VehicleSpeed(sdk::VehicleSpeed {
                age_ns: 5_000_000,
                thruster_rpm: -9.5,
                water_speed: Some(10.5),
            }),
        ),
        (
            Sample::Battery(BatterySample {
                measured: ago(6),
                number: 1,
                voltage_v: Some(11.5),
                cell_min_v: Some(12.5),
                cell_max_v: Some(13.5),
                temperature_c: Some(14.5),
                capacity_kwh: Some(15.5),
                charge_percent: Some(16.5),
            }),
            sdk::Sample::Battery(sdk::Battery {
                age_ns: 6_000_000,
                number: 1,
                voltage: Some(11.5),
                cell_min: Some(12.5),
                cell_max: Some(13.5),
                temperature: Some(14.5),
                capacity: Some(15.5),
                charge: Some(16.5),
            }),
        ),
        (
            Sample::Battery(BatterySample {
                measured: ago(7),
                number: 0,
                voltage_v: None,
                cell_min_v: None,
                cell_max_v: None,
                temperature_c: None,
                capacity_kwh: None,
                charge_percent: None,
            }),
            sdk::Sample::Battery(sdk::Battery {
                age_ns: 7_000_000,
                number: 0,
                voltage: None,
                cell_min: None,
                cell_max: None,
                temperature: None,
                capacity: None,
                charge: None,
            }),
        ),
        (
            Sample::Surfaces(SurfacesSample {
                measured: ago(8),
                elevator_deg: 17.5,
                rudder_deg: -18.5,
                elevator_target_deg: 19.5,
                rudder_target_deg: -20.5,
            }),
            sdk::Sample::Surfaces(sdk::Surfaces {
                age_ns: 8_000_000,
                elevator: 17.5,
                rudder: -18.5,
                elevator_target: 19.5,
                rudder_target: -20.5,
            }),
        ),
        (
            Sample::Dvl(DvlSample {
                measured: ago(9),
                velocity_mps: [Some(21.5), None, Some(23.5)],
                ranges_m: [Some(24.5), Some(25.5), None, Some(27.5)],
                temperature_c: Some(28.5),
            }),
            sdk::Sample::Dvl(sdk::Dvl {
                age_ns: 9_000_000,
                velocity_forward: Some(21.5),
                velocity_starboard: None,
                velocity_down: Some(23.5),
                ranges: (Some(24.5), Some(25.5), None, Some(27.5)),
                temperature: Some(28.5),
            }),
        ),
        (
            Sample::DvlBeams(DvlBeamsSample {
                measured: ago(10),
                velocity_mps: [Some(29.5), Some(30.5), Some(31.5), None],
                ranges_m: [None, Some(34.5), Some(35.5), Some(36.5)],
                temperature_c: None,
            }),
            sdk::Sample::DvlBeams(sdk::DvlBeams {
                age_ns: 10_000_000,
                velocities: (Some(29.5), Some(30.5), Some(31.5), None),
                ranges: (None, Some(34.5), Some(35.5), Some(36.5)),
                temperature: None,
            }),
        ),
        (
            Sample::Imu(ImuSample {
                measured: ago(11),
                rate_dps: [37.5, 38.5, 39.5],
                acceleration_mps2: [-40.5, -0.0, 42.5],
            }),
            sdk::Sample::Imu(sdk::Imu {
                age_ns: 11_000_000,
                rate: sdk::Axes {
                    forward: 37.5,
                    starboard: 38.5,
                    down: 39.5,
                },
                acceleration: sdk::Axes {
                    forward: -40.5,
                    starboard: -0.0,
                    down: 42.5,
                },
            }),
        ),
        (
            Sample::Servo(ServoSample {
                measured: ago(12),
                dvl_deg: 43.5,
                sonar_deg: -44.5,
            }),
            sdk::Sample::Servo(sdk::Servo {
                age_ns: 12_000_000,
                dvl: 43.5,
                sonar: -44.5,
            }),
        ),
        (
            Sample::Trim(TrimSample {
                measured: ago(13),
                adjusting: true,
                pitch_deg: 45.5,
                roll_deg: -46.5,
            }),
            sdk::Sample::Trim(sdk::Trim {
                age_ns: 13_000_000,
                adjusting: true,
                pitch: 45.5,
                roll: -46.5,
            }),
        ),
        (
            Sample::Buoyancy(BuoyancySample {
                measured: ago(14),
                adjusting: false,
                buoyancy_n: -47.5,
            }),
            sdk::Sample::Buoyancy(sdk::Buoyancy {
                age_ns: 14_000_000,
                adjusting: false,
                buoyancy: -47.5,
            }),
        ),
    ]
}

use backseat_core::plugin as core;
use backseat_units::{Altitude, Timestamp};

use super::{age_ns, wit};

pub(super) fn navigation(sample: &core::NavigationSample, now: Timestamp) -> wit::Navigation {
    wit::Navigation {
        age_ns: age_ns(sample.solution, now),
        position: sample.position.into(),
        east: sample.local.east_m,
        north: sample.local.north_m,
        depth: sample.depth.as_m(),
        altitude: sample.altitude.map(Altitude::as_m),
        heading: sample.heading.as_deg(),
        roll: sample.roll_deg,
        pitch: sample.pitch_deg,
        velocity_east: sample.east_mps,
        velocity_north: sample.north_mps,
        velocity_down: sample.down_mps,
        yaw_rate: sample.yaw_rate_dps,
        gps: sample.gps,
    }
}

pub(super) fn relative(sample: &core::RelativeSample, now: Timestamp) -> wit::Relative {
    wit::Relative {
        age_ns: age_ns(sample.measured, now),
        horizontal: sample.horizontal_m,
        vertical: sample.vertical_m,
        distance: sample.distance_m,
        heading: sample.heading_deg,
        depth: sample.depth_m,
        absolute_heading: sample.absolute_heading_deg,
        roll: sample.roll_deg,
        pitch: sample.pitch_deg,
    }
}

pub(super) fn cartesian(sample: &core::CartesianSample, now: Timestamp) -> wit::Cartesian {
    wit::Cartesian {
        age_ns: age_ns(sample.measured, now),
        x: sample.x_m,
        y: sample.y_m,
        z: sample.z_m,
        heading: sample.heading_deg,
    }
}

pub(super) fn ctd(sample: &core::CtdSample, now: Timestamp) -> wit::Ctd {
    wit::Ctd {
        age_ns: age_ns(sample.measured, now),
        conductivity: sample.conductivity_us_per_cm,
        temperature: sample.temperature_c,
        pressure: sample.pressure_kpa,
    }
}

/// A sensor's sample as the guest receives it in the step at `now`.
pub(super) fn sample(sample: &core::Sample, now: Timestamp) -> wit::Sample {
    let age_ns = |measured| age_ns(measured, now);
    match sample {
        core::Sample::Telemetry(sample) => wit::Sample::Telemetry(wit::Telemetry {
            age_ns: age_ns(sample.measured),
            acoustic_up_available: sample.acoustic_up_available_kb,
            acoustic_up_last: sample.acoustic_up_last_kb,
            acoustic_down_available: sample.acoustic_down_available_kb,
            acoustic_down_last: sample.acoustic_down_last_kb,
            rf_connected: sample.rf_connected,
            ethernet_available: sample.ethernet_available,
        }),
        core::Sample::SoundVelocity(sample) => wit::Sample::SoundVelocity(wit::SoundVelocity {
            age_ns: age_ns(sample.measured),
            velocity: sample.sound_velocity_mps,
        }),
        core::Sample::Compass(sample) => wit::Sample::Compass(wit::Compass {
            age_ns: age_ns(sample.measured),
            number: sample.number,
            heading: sample.heading_deg,
            pitch: sample.pitch_deg,
            roll: sample.roll_deg,
        }),
        core::Sample::Pressure(sample) => wit::Sample::Pressure(wit::Pressure {
            age_ns: age_ns(sample.measured),
            pressure: sample.pressure_kpa,
        }),
        core::Sample::VehicleSpeed(sample) => wit::Sample::VehicleSpeed(wit::VehicleSpeed {
            age_ns: age_ns(sample.measured),
            thruster_rpm: sample.thruster_rpm,
            water_speed: sample.water_speed_mps,
        }),
        core::Sample::Battery(sample) => wit::Sample::Battery(wit::Battery {
            age_ns: age_ns(sample.measured),
            number: sample.number,
            voltage: sample.voltage_v,
            cell_min: sample.cell_min_v,
            cell_max: sample.cell_max_v,
            temperature: sample.temperature_c,
            capacity: sample.capacity_kwh,
            charge: sample.charge_percent,
        }),
        core::Sample::Surfaces(sample) => wit::Sample::Surfaces(wit::Surfaces {
            age_ns: age_ns(sample.measured),
            elevator: sample.elevator_deg,
            rudder: sample.rudder_deg,
            elevator_target: sample.elevator_target_deg,
            rudder_target: sample.rudder_target_deg,
        }),
        core::Sample::Dvl(sample) => {
            let [velocity_forward, velocity_starboard, velocity_down] = sample.velocity_mps;
            wit::Sample::Dvl(wit::Dvl {
                age_ns: age_ns(sample.measured),
                velocity_forward,
                velocity_starboard,
                velocity_down,
                ranges: sample.ranges_m.into(),
                temperature: sample.temperature_c,
            })
        }
        core::Sample::DvlBeams(sample) => wit::Sample::DvlBeams(wit::DvlBeams {
            age_ns: age_ns(sample.measured),
            velocities: sample.velocity_mps.into(),
            ranges: sample.ranges_m.into(),
            temperature: sample.temperature_c,
        }),
        core::Sample::Imu(sample) => wit::Sample::Imu(wit::Imu {
            age_ns: age_ns(sample.measured),
            rate: axes(sample.rate_dps),
            acceleration: axes(sample.acceleration_mps2),
        }),
        core::Sample::Servo(sample) => wit::Sample::Servo(wit::Servo {
            age_ns: age_ns(sample.measured),
            dvl: sample.dvl_deg,
            sonar: sample.sonar_deg,
        }),
        core::Sample::Trim(sample) => wit::Sample::Trim(wit::Trim {
            age_ns: age_ns(sample.measured),
            adjusting: sample.adjusting,
            pitch: sample.pitch_deg,
            roll: sample.roll_deg,
        }),
        core::Sample::Buoyancy(sample) => wit::Sample::Buoyancy(wit::Buoyancy {
            age_ns: age_ns(sample.measured),
            adjusting: sample.adjusting,
            buoyancy: sample.buoyancy_n,
        }),
    }
}

const fn axes([forward, starboard, down]: [f64; 3]) -> wit::Axes {
    wit::Axes {
        forward,
        starboard,
        down,
    }
}

//! The messages of the vehicle's sensors, for the plugins that asked for them (SPI 6.3 to 6.8, 6.12 to 6.15, 6.18).

use backseat_spi::FromVehicle;
use backseat_units::TimeOfDay;

use crate::context::Context;
use crate::plugin::{
    BatterySample, CompassSample, DvlBeamsSample, DvlSample, Event, ImuSample, PlannedElement, PressureSample, Sample,
    ServoSample, SoundVelocitySample, SurfacesSample, TelemetrySample, Topic, VehicleSpeedSample,
};

/// Passes a sensor's message to the plugins. Ignores any other message.
pub(super) fn sampled(cx: &mut Context, message: &FromVehicle) {
    if let Some(created) = message.created() {
        cx.heard(created);
        if let Some((topic, sample)) = sample(cx, message, created) {
            cx.plugins.tell_wanting(topic, &Event::Sample(sample));
        }
    }
}

fn sample(cx: &Context, message: &FromVehicle, created: TimeOfDay) -> Option<(Topic, Sample)> {
    use FromVehicle as M;
    #[expect(clippy::wildcard_enum_match_arm, reason = "no other message is a sample")]
    Some(match message {
        M::Telemetry(message) => (
            Topic::Telemetry,
            Sample::Telemetry(TelemetrySample {
                measured: cx.when(created),
                acoustic_up_available_kb: message.acoustic_up_available_kb,
                acoustic_up_last_kb: message.acoustic_up_last_kb,
                acoustic_down_available_kb: message.acoustic_down_available_kb,
                acoustic_down_last_kb: message.acoustic_down_last_kb,
                rf_connected: message.rf_connected,
                ethernet_available: message.ethernet_available,
            }),
        ),
        M::SoundVelocity(message) => (
            Topic::SoundVelocity,
            Sample::SoundVelocity(SoundVelocitySample {
                measured: cx.when(created),
                sound_velocity_mps: message.sound_velocity_mps,
            }),
        ),
        M::Compass(message) => (
            Topic::Compass,
            Sample::Compass(CompassSample {
                measured: cx.when(message.measured),
                number: message.number,
                heading_deg: message.heading_deg,
                pitch_deg: message.pitch_deg,
                roll_deg: message.roll_deg,
            }),
        ),
        M::DepthSensor(message) => (
            Topic::Pressure,
            Sample::Pressure(PressureSample {
                measured: cx.when(created),
                pressure_kpa: message.pressure_kpa,
            }),
        ),
        M::VehicleSpeed(message) => (
            Topic::VehicleSpeed,
            Sample::VehicleSpeed(VehicleSpeedSample {
                measured: cx.when(created),
                thruster_rpm: message.thruster_rpm,
                water_speed_mps: message.water_speed_mps,
            }),
        ),
        M::Battery(message) => (
            Topic::Battery,
            Sample::Battery(BatterySample {
                measured: cx.when(created),
                number: message.number,
                voltage_v: message.voltage_v,
                cell_min_v: message.cell_min_v,
                cell_max_v: message.cell_max_v,
                temperature_c: message.temperature_c,
                capacity_kwh: message.capacity_kwh,
                charge_percent: message.charge_percent,
            }),
        ),
        M::ControlSurfaces(message) => (
            Topic::Surfaces,
            Sample::Surfaces(SurfacesSample {
                measured: cx.when(created),
                elevator_deg: message.elevator_deg,
                rudder_deg: message.rudder_deg,
                elevator_target_deg: message.elevator_target_deg,
                rudder_target_deg: message.rudder_target_deg,
            }),
        ),
        M::Dvl(message) => (
            Topic::Dvl,
            Sample::Dvl(DvlSample {
                measured: cx.when(message.measured),
                velocity_mps: message.velocity_mps,
                ranges_m: message.ranges_m,
                temperature_c: message.temperature_c,
            }),
        ),
        M::DvlBeams(message) => (
            Topic::DvlBeams,
            Sample::DvlBeams(DvlBeamsSample {
                measured: cx.when(message.measured),
                velocity_mps: message.velocity_mps,
                ranges_m: message.ranges_m,
                temperature_c: message.temperature_c,
            }),
        ),
        M::Imu(message) => (
            Topic::Imu,
            Sample::Imu(ImuSample {
                measured: cx.when(message.measured),
                rate_dps: message.rate_dps,
                acceleration_mps2: message.acceleration_mps2,
            }),
        ),
        M::ServoPositions(message) => (
            Topic::Servo,
            Sample::Servo(ServoSample {
                measured: cx.when(created),
                dvl_deg: message.dvl_deg,
                sonar_deg: message.sonar_deg,
            }),
        ),
        _ => return None,
    })
}

/// Gives the new plan to the plugins that asked for it.
pub(super) fn tell_of_plan(cx: &mut Context) {
    if !cx.plugins.ids().any(|plugin| cx.plugins.wants(plugin, Topic::Plan)) {
        return;
    }
    let frame = cx.monitor.envelope.fence().frame();
    let elements: Vec<PlannedElement> = cx
        .vehicle
        .plan
        .elements()
        .map(|element| PlannedElement {
            number: element.number,
            identifier: element.identifier.map(backseat_spi::BehaviorId::get),
            points: element
                .points
                .iter()
                .map(|point| (frame.to_position(*point), *point))
                .collect(),
        })
        .collect();
    cx.plugins.tell_wanting(Topic::Plan, &Event::Plan(elements));
}

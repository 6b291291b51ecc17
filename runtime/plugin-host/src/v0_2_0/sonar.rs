//! Pings and reports of the sonars, as the guest receives them, and its settings.

use backseat_core::plugin as core;
use backseat_units::Timestamp;

use super::{age_ns, wit};

/// A ping as the guest receives it in the step at `now`.
pub(super) fn ping(ping: &core::SonarPing, now: Timestamp) -> wit::SonarPing {
    wit::SonarPing {
        age_ns: age_ns(ping.time, now),
        time_source: match ping.time_source {
            core::PingTime::Measured => wit::PingTime::Measured,
            core::PingTime::Controller => wit::PingTime::Controller,
            core::PingTime::Arrival => wit::PingTime::Arrival,
        },
        sensor: ping.sensor,
        number: ping.number,
        decimation: match ping.decimation {
            core::Decimation::Maximum => wit::Decimation::Maximum,
            core::Decimation::Mean => wit::Decimation::Mean,
        },
        channels: ping.channels.iter().map(wit::SonarChannel::from).collect(),
        navigation: ping
            .navigation
            .as_ref()
            .map(|navigation| ping_navigation(navigation, ping.time)),
    }
}

fn ping_navigation(navigation: &core::PingNavigation, ping: Timestamp) -> wit::PingNavigation {
    let velocity = navigation.velocity_mps;
    wit::PingNavigation {
        before_ping_ns: age_ns(navigation.solution, ping),
        position: navigation.position.into(),
        east: navigation.local.east_m,
        north: navigation.local.north_m,
        depth: navigation.depth.as_m(),
        altitude: navigation.altitude.map(|altitude| altitude.as_m()),
        heading: navigation.heading.as_deg(),
        roll: navigation.roll_deg,
        pitch: navigation.pitch_deg,
        velocity_east: velocity.map(|(east_mps, _)| east_mps),
        velocity_north: velocity.map(|(_, north_mps)| north_mps),
    }
}

impl From<&core::SonarChannel> for wit::SonarChannel {
    fn from(channel: &core::SonarChannel) -> Self {
        Self {
            side: match channel.side {
                core::SonarSide::Port => wit::SonarSide::Port,
                core::SonarSide::Starboard => wit::SonarSide::Starboard,
                core::SonarSide::Other => wit::SonarSide::Other,
            },
            ground_range: channel.ground_range,
            range: channel.range_m,
            start_ns: channel.start_nanos,
            sample_ns: channel.sample_nanos,
            recorded: channel.recorded,
            volts_per_step: channel.volts_per_step,
            samples: channel.samples.clone(),
        }
    }
}

impl From<&core::SonarEvent> for wit::SonarEvent {
    fn from(event: &core::SonarEvent) -> Self {
        match event {
            core::SonarEvent::Ready(ready) => Self::Ready(*ready),
            core::SonarEvent::Logging(logging) => Self::Logging(wit::SonarLogging {
                on: logging.on,
                file: logging.file.clone(),
                size_mb: logging.size_mb,
                missing: logging.missing,
            }),
            core::SonarEvent::Health(sensors) => Self::Health(
                sensors
                    .iter()
                    .map(|&(sensor, healthy)| wit::SensorHealth { sensor, healthy })
                    .collect(),
            ),
            core::SonarEvent::Alarm(alarm) => Self::Alarm(alarm.into()),
            core::SonarEvent::ActiveAlarms(alarms) => {
                Self::ActiveAlarms(alarms.iter().map(wit::SonarAlarm::from).collect())
            }
            core::SonarEvent::Swath(swath) => Self::Swath(swath.into()),
            core::SonarEvent::ControllerShutdown => Self::ControllerShutdown,
        }
    }
}

impl From<&core::SonarAlarm> for wit::SonarAlarm {
    fn from(alarm: &core::SonarAlarm) -> Self {
        Self {
            id: alarm.id,
            active: alarm.active,
            sensor: alarm.sensor,
            text: alarm.text.clone(),
        }
    }
}

impl From<&core::Swath> for wit::Swath {
    fn from(swath: &core::Swath) -> Self {
        Self {
            sensor: swath.sensor,
            number: swath.number,
            port: swath.port_m,
            starboard: swath.starboard_m,
            altitude: swath.altitude_m,
            source: match swath.source {
                core::AltitudeSource::BottomLock => wit::AltitudeSource::BottomLock,
                core::AltitudeSource::FirstReturn => wit::AltitudeSource::FirstReturn,
                core::AltitudeSource::GroundRange => wit::AltitudeSource::GroundRange,
            },
        }
    }
}

impl From<wit::SonarSetting> for core::SonarSetting {
    fn from(setting: wit::SonarSetting) -> Self {
        match setting {
            wit::SonarSetting::Range(range_m) => Self::RangeM(range_m),
            wit::SonarSetting::Pulse(name) => Self::Pulse(name),
            wit::SonarSetting::Ping(on) => Self::Ping(on),
            wit::SonarSetting::Power(percent) => Self::PowerPercent(percent),
            wit::SonarSetting::Gain(steps) => Self::Gain(steps),
            wit::SonarSetting::Period(period_ms) => Self::PeriodMs(period_ms),
            wit::SonarSetting::DefaultState => Self::DefaultState,
        }
    }
}

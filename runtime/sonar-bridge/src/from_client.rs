//! From the client's types to core's.

use backseat_core::plugin::{
    AltitudeSource, Decimation, PingNavigation, PingTime, SonarAlarm, SonarChannel, SonarEvent, SonarLogging,
    SonarPing, SonarSide, Swath,
};
use backseat_s7k::record::{AlarmMode, ChannelSide, RangeKind};
use backseat_sonar as client;
use backseat_sonar::{AlarmState, Event, PingChannel, VehicleNavigation};
use backseat_units::{LocalFrame, Timestamp, Utc};

pub(crate) fn ping(ping: &client::SonarPing, frame: &LocalFrame, timestamp: impl Fn(Utc) -> Timestamp) -> SonarPing {
    SonarPing {
        sub_bottom: ping.sub_bottom,
        sensor: ping.sensor.0,
        number: ping.ping,
        time: timestamp(ping.time),
        time_source: match ping.time_source {
            client::PingTime::Measured => PingTime::Measured,
            client::PingTime::Controller => PingTime::Controller,
            client::PingTime::Arrival => PingTime::Arrival,
        },
        decimation: match ping.decimation {
            client::Decimation::Maximum => Decimation::Maximum,
            client::Decimation::Mean => Decimation::Mean,
        },
        channels: ping.channels.iter().map(channel).collect(),
        navigation: ping
            .navigation
            .as_ref()
            .map(|navigation| ping_navigation(navigation, frame, &timestamp)),
    }
}

fn channel(channel: &PingChannel) -> SonarChannel {
    SonarChannel {
        side: match channel.side {
            ChannelSide::Port => SonarSide::Port,
            ChannelSide::Starboard => SonarSide::Starboard,
            ChannelSide::Other(_) => SonarSide::Other,
        },
        ground_range: channel.range_kind == RangeKind::Ground,
        range_m: channel.range_m,
        start_nanos: u64::from(channel.start_us) * 1000,
        sample_nanos: channel.bin_us * 1000.0,
        recorded: channel.recorded,
        volts_per_step: channel.volts_per_step,
        samples: channel.samples.clone(),
    }
}

fn ping_navigation(
    navigation: &VehicleNavigation,
    frame: &LocalFrame,
    timestamp: impl Fn(Utc) -> Timestamp,
) -> PingNavigation {
    PingNavigation {
        solution: timestamp(navigation.solution),
        position: navigation.position,
        local: frame.to_local(navigation.position),
        depth: navigation.depth,
        altitude: navigation.altitude,
        heading: navigation.heading,
        roll_deg: navigation.roll_deg,
        pitch_deg: navigation.pitch_deg,
        velocity_mps: navigation.rates.map(|rates| (rates.east_mps, rates.north_mps)),
    }
}

/// What plugins see of an event. Whether the client is ready is not an event of its own here.
pub(crate) fn event(event: &Event) -> Option<SonarEvent> {
    Some(match event {
        Event::Logging { details, missing } => SonarEvent::Logging(SonarLogging {
            on: details.on,
            file: String::from(&*details.file),
            size_mb: details.size_mb,
            missing: *missing,
        }),
        Event::Health { sensors } => {
            SonarEvent::Health(sensors.iter().map(|entry| (entry.sensor.0, entry.healthy)).collect())
        }
        Event::Alarm { alarm } => SonarEvent::Alarm(alarm_of(alarm)),
        Event::AlarmsClear => SonarEvent::ActiveAlarms(Vec::new()),
        Event::ActiveAlarms { alarms } => SonarEvent::ActiveAlarms(alarms.iter().map(alarm_of).collect()),
        Event::Swath(swath) => SonarEvent::Swath(swath_of(swath)),
        Event::ControllerShutdown => SonarEvent::ControllerShutdown,
        Event::Ready
        | Event::Disconnected { .. }
        | Event::Connected
        | Event::CommandFailed { .. }
        | Event::SensorStarting { .. }
        | Event::SettingFailed { .. }
        | Event::NotSubscribed { .. }
        | Event::Version { .. }
        | Event::Modules { .. }
        | Event::RunList { .. }
        | Event::LoggingSetup { .. }
        | Event::Pulses { .. }
        | Event::Clock { .. }
        | Event::Outcome { .. }
        | Event::Malformed { .. }
        | Event::Counts { .. } => return None,
    })
}

fn alarm_of(alarm: &AlarmState) -> SonarAlarm {
    SonarAlarm {
        id: alarm.id,
        active: match alarm.mode {
            AlarmMode::Active => Some(true),
            AlarmMode::Clear => Some(false),
            AlarmMode::Unspecified | AlarmMode::Other(_) => None,
        },
        sensor: alarm.sensor.map(|sensor| sensor.0),
        text: String::from(&*alarm.text),
    }
}

fn swath_of(swath: &client::Swath) -> Swath {
    Swath {
        sensor: swath.sensor.0,
        number: swath.ping,
        port_m: swath.port_m,
        starboard_m: swath.starboard_m,
        altitude_m: swath.altitude_m,
        source: match swath.source {
            client::AltitudeSource::BottomLock => AltitudeSource::BottomLock,
            client::AltitudeSource::FirstReturn => AltitudeSource::FirstReturn,
            client::AltitudeSource::GroundRange => AltitudeSource::GroundRange,
        },
    }
}

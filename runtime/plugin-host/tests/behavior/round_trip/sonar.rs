use backseat_core::plugin::{
    AltitudeSource, Decimation, Event, PingNavigation, PingTime, SonarAlarm, SonarChannel, SonarEvent, SonarLogging,
    SonarPing, SonarSide, Swath,
};
use backseat_sdk as sdk;
use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp};

/// Every ping and report of the sonars with its form in the guest, in a step at `now`.
pub(super) fn events(now: Timestamp) -> Vec<(Event, sdk::Event)> {
    let mut events: Vec<(Event, sdk::Event)> = reports()
        .into_iter()
        .map(|(event, guest)| (Event::Sonar(event), sdk::Event::Sonar(guest)))
        .collect();
    let (ping, guest) = full_ping(now);
    events.push((Event::Sidescan(ping.clone()), sdk::Event::Sidescan(guest.clone())));
    events.push((Event::SubBottom(ping), sdk::Event::SubBottom(guest)));
    for (time_source, guest) in [
        (PingTime::Controller, sdk::PingTime::Controller),
        (PingTime::Arrival, sdk::PingTime::Arrival),
    ] {
        let (event, guest) = bare_ping(now, time_source, guest);
        events.push((Event::Sidescan(event), sdk::Event::Sidescan(guest)));
    }
    events
}

fn full_ping(now: Timestamp) -> (SonarPing, sdk::SonarPing) {
    let nanos = now.as_nanos();
    let channel = |side, ground_range, samples: Vec<f32>| SonarChannel {
        side,
        ground_range,
        range_m: 101.5,
        start_nanos: 102,
        sample_nanos: 103.5,
        recorded: 104,
        volts_per_step: Some(0.125),
        samples,
    };
    let guest = |side, ground_range, samples: Vec<f32>| sdk::SonarChannel {
        side,
        ground_range,
        range: 101.5,
        start_ns: 102,
        sample_ns: 103.5,
        recorded: 104,
        volts_per_step: Some(0.125),
        samples,
    };
    let core = SonarPing {
        sub_bottom: false,
        sensor: -105,
        number: 106,
        time: Timestamp::from_nanos(nanos - 107),
        time_source: PingTime::Measured,
        decimation: Decimation::Maximum,
        channels: vec![
            channel(SonarSide::Port, false, vec![1.5, f32::MAX, -0.0]),
            channel(SonarSide::Starboard, true, vec![]),
            channel(SonarSide::Other, true, vec![65_535.0; 600]),
        ],
        navigation: Some(PingNavigation {
            solution: Timestamp::from_nanos(nanos - 107 - 108),
            position: Position::from_deg(42.5, -70.25).unwrap(),
            local: EastNorth::new(109.5, -110.5),
            depth: Depth::from_m(111.5).unwrap(),
            altitude: Some(Altitude::from_m(112.5).unwrap()),
            heading: Heading::from_deg(113.5).unwrap(),
            roll_deg: -114.5,
            pitch_deg: 115.5,
            velocity_mps: Some((1.25, -1.75)),
        }),
    };
    let guest = sdk::SonarPing {
        age_ns: 107,
        time_source: sdk::PingTime::Measured,
        sensor: -105,
        number: 106,
        decimation: sdk::Decimation::Maximum,
        channels: vec![
            guest(sdk::SonarSide::Port, false, vec![1.5, f32::MAX, -0.0]),
            guest(sdk::SonarSide::Starboard, true, vec![]),
            guest(sdk::SonarSide::Other, true, vec![65_535.0; 600]),
        ],
        navigation: Some(sdk::PingNavigation {
            before_ping_ns: 108,
            position: sdk::Position {
                latitude: 42.5,
                longitude: -70.25,
            },
            east: 109.5,
            north: -110.5,
            depth: 111.5,
            altitude: Some(112.5),
            heading: 113.5,
            roll: -114.5,
            pitch: 115.5,
            velocity_east: Some(1.25),
            velocity_north: Some(-1.75),
        }),
    };
    (core, guest)
}

fn bare_ping(now: Timestamp, time_source: PingTime, guest: sdk::PingTime) -> (SonarPing, sdk::SonarPing) {
    let core = SonarPing {
        sub_bottom: true,
        sensor: 0,
        number: 0,
        time: now,
        time_source,
        decimation: Decimation::Mean,
        channels: vec![],
        navigation: None,
    };
    let guest = sdk::SonarPing {
        age_ns: 0,
        time_source: guest,
        sensor: 0,
        number: 0,
        decimation: sdk::Decimation::Mean,
        channels: vec![],
        navigation: None,
    };
    (core, guest)
}

fn reports() -> Vec<(SonarEvent, sdk::SonarEvent)> {
    let alarm = |active, sensor| SonarAlarm {
        id: 116,
        active,
        sensor,
        text: "an alarm".to_owned(),
    };
    let guest = |active, sensor| sdk::SonarAlarm {
        id: 116,
        active,
        sensor,
        text: "an alarm".to_owned(),
    };
    let mut reports = vec![
        (SonarEvent::Ready(true), sdk::SonarEvent::Ready(true)),
        (SonarEvent::Ready(false), sdk::SonarEvent::Ready(false)),
        (
            SonarEvent::Logging(SonarLogging {
                on: true,
                file: "a file".to_owned(),
                size_mb: 117.5,
                missing: false,
            }),
            sdk::SonarEvent::Logging(sdk::SonarLogging {
                on: true,
                file: "a file".to_owned(),
                size_mb: 117.5,
                missing: false,
            }),
        ),
        (
            SonarEvent::Health(vec![(118, true), (-119, false)]),
            sdk::SonarEvent::Health(vec![
                sdk::SensorHealth {
                    sensor: 118,
                    healthy: true,
                },
                sdk::SensorHealth {
                    sensor: -119,
                    healthy: false,
                },
            ]),
        ),
        (
            SonarEvent::Alarm(alarm(Some(true), Some(120))),
            sdk::SonarEvent::Alarm(guest(Some(true), Some(120))),
        ),
        (
            SonarEvent::ActiveAlarms(vec![alarm(Some(false), None), alarm(None, Some(-1))]),
            sdk::SonarEvent::ActiveAlarms(vec![guest(Some(false), None), guest(None, Some(-1))]),
        ),
        (SonarEvent::ControllerShutdown, sdk::SonarEvent::ControllerShutdown),
    ];
    for (source, guest, altitude) in [
        (AltitudeSource::BottomLock, sdk::AltitudeSource::BottomLock, Some(124.5)),
        (
            AltitudeSource::FirstReturn,
            sdk::AltitudeSource::FirstReturn,
            Some(124.5),
        ),
        (AltitudeSource::GroundRange, sdk::AltitudeSource::GroundRange, None),
    ] {
        reports.push((
            SonarEvent::Swath(Swath {
                sensor: 121,
                number: 122,
                port_m: 123.5,
                starboard_m: 0.0,
                altitude_m: altitude,
                source,
            }),
            sdk::SonarEvent::Swath(sdk::Swath {
                sensor: 121,
                number: 122,
                port: 123.5,
                starboard: 0.0,
                altitude,
                source: guest,
            }),
        ));
    }
    reports
}

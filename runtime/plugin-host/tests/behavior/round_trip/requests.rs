use std::time::Duration;

use backseat_core::plugin::{
    CameraRequest, DvlTriggerRequest, GpsHitRequest, LightRequest, ModifyRequest, PacketRequest, PositionRequest,
    Request, SilentRequest, SonarAngleRequest, SonarLogRequest, SonarSetRequest, SonarSetting, StationRequest,
    StationTarget, TopsideRequest, TrackcircleRequest, TracklineRequest, Transport, VerticalRequest,
};

/// What the plugin `echo` requests, as core receives it.
pub(super) fn every_request() -> Vec<Request> {
    let position = |latitude_deg, longitude_deg| PositionRequest {
        latitude_deg,
        longitude_deg,
    };
    let topside = |tag, slowest, text: &str| {
        Request::Topside(TopsideRequest {
            tag,
            slowest,
            text: text.into(),
        })
    };
    let station = |tag, target, speed_mps, nanos| {
        Request::Station(StationRequest {
            tag,
            target,
            speed_mps,
            duration: Duration::from_nanos(nanos),
        })
    };
    vec![
        Request::Modify(ModifyRequest {
            tag: 1,
            heading_deg: 101.5,
            vertical: VerticalRequest::AltitudeM(102.5),
            speed_mps: 103.5,
            duration: Duration::from_nanos(104),
        }),
        Request::EndModify,
        Request::Trackline(TracklineRequest {
            tag: 2,
            start: position(1.25, 2.25),
            end: position(3.25, 4.25),
            vertical: VerticalRequest::DepthM(105.5),
            speed_mps: 106.5,
            interrupt: true,
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 3,
            centre: position(5.25, 6.25),
            radius_m: 107.5,
            orbits: -108.5,
            vertical: VerticalRequest::AltitudeM(109.5),
            speed_mps: 110.5,
            entry_angle_deg: Some(111.5),
            interrupt: false,
        }),
        Request::Trackcircle(TrackcircleRequest {
            tag: 4,
            centre: position(-7.25, -8.25),
            radius_m: 112.5,
            orbits: 113.5,
            vertical: VerticalRequest::DepthM(114.5),
            speed_mps: 115.5,
            entry_angle_deg: None,
            interrupt: true,
        }),
        Request::Cancel(5),
        Request::Message("a line".into()),
        Request::GpsHit(GpsHitRequest {
            tag: 6,
            position: position(9.25, -10.25),
        }),
        topside(7, Transport::Ethernet, "by cable"),
        topside(8, Transport::Wifi, "by air"),
        topside(9, Transport::RadioModem, "by radio"),
        topside(10, Transport::AcousticModem, ""),
        Request::DvlTrigger(DvlTriggerRequest {
            tag: 11,
            external: true,
            triggering: false,
        }),
        Request::DvlTrigger(DvlTriggerRequest {
            tag: 12,
            external: false,
            triggering: true,
        }),
        Request::Silent(SilentRequest { tag: 13, silent: true }),
        Request::Silent(SilentRequest { tag: 14, silent: false }),
        Request::Trim(15),
        Request::Buoyancy(16),
        Request::Packet(PacketRequest {
            tag: 17,
            destination: 4_000_000_001,
            mode: -118,
            acknowledge: true,
            frames: vec![vec![0, 255, b'$'], vec![], vec![7; 1024]],
        }),
        Request::Packet(PacketRequest {
            tag: 18,
            destination: 119,
            mode: 120,
            acknowledge: false,
            frames: vec![vec![0], vec![1], vec![2], vec![3], vec![4], vec![5], vec![6], vec![7]],
        }),
        station(19, StationTarget::Here, None, 121),
        station(
            20,
            StationTarget::Hull {
                horizontal_m: 122.5,
                vertical_m: -123.5,
                distance_m: 124.5,
            },
            Some(125.5),
            126,
        ),
        station(
            21,
            StationTarget::Bottom {
                x_m: 127.5,
                y_m: -128.5,
                vertical: VerticalRequest::AltitudeM(129.5),
            },
            Some(130.5),
            131,
        ),
        station(
            22,
            StationTarget::Bottom {
                x_m: -0.0,
                y_m: f64::INFINITY,
                vertical: VerticalRequest::DepthM(132.5),
            },
            None,
            u64::MAX,
        ),
        Request::EndStation,
        Request::SonarAngle(SonarAngleRequest {
            tag: 23,
            angle_deg: -133.5,
        }),
        Request::Camera(CameraRequest {
            tag: 24,
            pan: -9,
            tilt: 134,
            zoom: i32::MIN,
        }),
        Request::Light(LightRequest {
            tag: 25,
            light: -135,
            on: true,
        }),
        Request::Light(LightRequest {
            tag: u64::MAX,
            light: 136,
            on: false,
        }),
        sonar(26, SonarSetting::RangeM(139.5)),
        sonar(27, SonarSetting::Pulse("a pulse".to_owned())),
        sonar(28, SonarSetting::Ping(true)),
        sonar(29, SonarSetting::PowerPercent(140.5)),
        sonar(30, SonarSetting::Gain(-141)),
        sonar(31, SonarSetting::PeriodMs(142.5)),
        sonar(32, SonarSetting::DefaultState),
        Request::SonarLog(SonarLogRequest {
            tag: 33,
            on: true,
            file: Some("a file".to_owned()),
        }),
        Request::SonarLog(SonarLogRequest {
            tag: 34,
            on: false,
            file: None,
        }),
        Request::Timer {
            id: 137,
            after: Duration::from_nanos(138),
        },
    ]
}

fn sonar(tag: u64, setting: SonarSetting) -> Request {
    Request::SonarSet(SonarSetRequest {
        tag,
        sensor: -143,
        setting,
    })
}

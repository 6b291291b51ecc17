//! Requests in JSON with every number preserved bit for bit: a plugin may request a heading of NaN, and a replay must
//! do the same.
//!
//! The derives of `backseat_core` suffice for types that cannot hold such a number. The definitions here mirror the
//! other types, and fail to compile if a field is missing.

use std::time::Duration;

use backseat_core::plugin::{
    CameraRequest, DvlTriggerRequest, GpsHitRequest, LightRequest, LogLine, ModifyRequest, PacketRequest, PluginFault,
    PositionRequest, Request, Returned, SilentRequest, SonarAngleRequest, SonarLogRequest, SonarSetRequest,
    SonarSetting, StationRequest, StationTarget, TopsideRequest, TrackcircleRequest, TracklineRequest, VerticalRequest,
};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Returned")]
pub(crate) struct ReturnedJson {
    fuel: u64,
    log: Vec<LogLine>,
    #[serde(with = "requests")]
    result: Result<Vec<Request>, PluginFault>,
}

/// The result of a step, borrowed.
pub(crate) struct ReturnedRef<'a>(pub(crate) &'a Returned);

impl Serialize for ReturnedRef<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        ReturnedJson::serialize(self.0, serializer)
    }
}

mod requests {
    use backseat_core::plugin::{PluginFault, Request};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{RequestJson, RequestRef};

    #[derive(Deserialize)]
    struct RequestOwned(#[serde(with = "RequestJson")] Request);

    pub(super) fn serialize<S: Serializer>(
        result: &Result<Vec<Request>, PluginFault>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        match result {
            // Most steps return no request.
            Ok(requests) if requests.is_empty() => Ok::<[(); 0], ()>([]).serialize(serializer),
            Ok(requests) => {
                let requests: Vec<_> = requests.iter().map(RequestRef).collect();
                Ok::<_, ()>(requests).serialize(serializer)
            }
            Err(fault) => Err::<(), _>(fault).serialize(serializer),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Result<Vec<Request>, PluginFault>, D::Error> {
        let result = Result::<Vec<RequestOwned>, PluginFault>::deserialize(deserializer)?;
        Ok(result.map(|requests| requests.into_iter().map(|request| request.0).collect()))
    }
}

struct RequestRef<'a>(&'a Request);

impl Serialize for RequestRef<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        RequestJson::serialize(self.0, serializer)
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Request", rename_all = "kebab-case")]
enum RequestJson {
    Modify(#[serde(with = "ModifyJson")] ModifyRequest),
    EndModify,
    Trackline(#[serde(with = "TracklineJson")] TracklineRequest),
    Trackcircle(#[serde(with = "TrackcircleJson")] TrackcircleRequest),
    Cancel(u64),
    Message(String),
    GpsHit(#[serde(with = "GpsHitJson")] GpsHitRequest),
    Topside(TopsideRequest),
    DvlTrigger(DvlTriggerRequest),
    Silent(SilentRequest),
    Trim(u64),
    Buoyancy(u64),
    Packet(PacketRequest),
    Station(#[serde(with = "StationJson")] StationRequest),
    EndStation,
    SonarAngle(#[serde(with = "SonarAngleJson")] SonarAngleRequest),
    Camera(CameraRequest),
    Light(LightRequest),
    SonarSet(#[serde(with = "SonarSetJson")] SonarSetRequest),
    SonarLog(SonarLogRequest),
    Timer { id: u64, after: Duration },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SonarSetRequest")]
struct SonarSetJson {
    tag: u64,
    sensor: i32,
    #[serde(with = "SonarSettingJson")]
    setting: SonarSetting,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SonarSetting", rename_all = "kebab-case")]
enum SonarSettingJson {
    RangeM(#[serde(with = "figure")] f64),
    Pulse(String),
    Ping(bool),
    PowerPercent(#[serde(with = "figure")] f64),
    Gain(i32),
    PeriodMs(#[serde(with = "figure")] f64),
    DefaultState,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ModifyRequest")]
struct ModifyJson {
    tag: u64,
    #[serde(with = "figure")]
    heading_deg: f64,
    #[serde(with = "VerticalJson")]
    vertical: VerticalRequest,
    #[serde(with = "figure")]
    speed_mps: f64,
    duration: Duration,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "TracklineRequest")]
struct TracklineJson {
    tag: u64,
    #[serde(with = "PositionJson")]
    start: PositionRequest,
    #[serde(with = "PositionJson")]
    end: PositionRequest,
    #[serde(with = "VerticalJson")]
    vertical: VerticalRequest,
    #[serde(with = "figure")]
    speed_mps: f64,
    interrupt: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "TrackcircleRequest")]
struct TrackcircleJson {
    tag: u64,
    #[serde(with = "PositionJson")]
    centre: PositionRequest,
    #[serde(with = "figure")]
    radius_m: f64,
    #[serde(with = "figure")]
    orbits: f64,
    #[serde(with = "VerticalJson")]
    vertical: VerticalRequest,
    #[serde(with = "figure")]
    speed_mps: f64,
    #[serde(with = "optional_figure")]
    entry_angle_deg: Option<f64>,
    interrupt: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "GpsHitRequest")]
struct GpsHitJson {
    tag: u64,
    #[serde(with = "PositionJson")]
    position: PositionRequest,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "StationRequest")]
struct StationJson {
    tag: u64,
    #[serde(with = "StationTargetJson")]
    target: StationTarget,
    #[serde(with = "optional_figure")]
    speed_mps: Option<f64>,
    duration: Duration,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "StationTarget", rename_all = "snake_case")]
enum StationTargetJson {
    Here,
    Hull {
        #[serde(with = "figure")]
        horizontal_m: f64,
        #[serde(with = "figure")]
        vertical_m: f64,
        #[serde(with = "figure")]
        distance_m: f64,
    },
    Bottom {
        #[serde(with = "figure")]
        x_m: f64,
        #[serde(with = "figure")]
        y_m: f64,
        #[serde(with = "VerticalJson")]
        vertical: VerticalRequest,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "SonarAngleRequest")]
struct SonarAngleJson {
    tag: u64,
    #[serde(with = "figure")]
    angle_deg: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "VerticalRequest", rename_all = "snake_case")]
enum VerticalJson {
    DepthM(#[serde(with = "figure")] f64),
    AltitudeM(#[serde(with = "figure")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "PositionRequest")]
struct PositionJson {
    #[serde(with = "figure")]
    latitude_deg: f64,
    #[serde(with = "figure")]
    longitude_deg: f64,
}

/// A number, or the name of a value that JSON cannot express. The sign and payload of NaN are not kept, because the
/// host makes all NaNs the same.
mod figure {
    use std::fmt;

    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(figure: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        if figure.is_finite() {
            serializer.serialize_f64(*figure)
        } else if figure.is_nan() {
            serializer.serialize_str("nan")
        } else if *figure > 0.0 {
            serializer.serialize_str("inf")
        } else {
            serializer.serialize_str("-inf")
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        deserializer.deserialize_any(Figure)
    }

    struct Figure;

    impl Visitor<'_> for Figure {
        type Value = f64;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a number, \"nan\", \"inf\" or \"-inf\"")
        }

        fn visit_f64<E: Error>(self, figure: f64) -> Result<f64, E> {
            Ok(figure)
        }

        fn visit_u64<E: Error>(self, figure: u64) -> Result<f64, E> {
            Ok(figure as f64)
        }

        fn visit_i64<E: Error>(self, figure: i64) -> Result<f64, E> {
            Ok(figure as f64)
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<f64, E> {
            match name {
                "nan" => Ok(f64::NAN),
                "inf" => Ok(f64::INFINITY),
                "-inf" => Ok(f64::NEG_INFINITY),
                _ => Err(E::invalid_value(serde::de::Unexpected::Str(name), &self)),
            }
        }
    }
}

mod optional_figure {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    struct Figure(#[serde(with = "super::figure")] f64);

    pub(super) fn serialize<S: Serializer>(figure: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        figure.map(Figure).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Ok(Option::<Figure>::deserialize(deserializer)?.map(|figure| figure.0))
    }
}

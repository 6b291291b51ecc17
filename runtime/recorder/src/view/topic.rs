use serde_json::Value;

use super::sensors::Sensor;
use crate::schema::{Fields, shadow};

/// A derived channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    Position,
    Log,
    Fence,
    Plan,
    Inserts,
    Requests,
    Sensor(Sensor),
    Shadow,
    Reach,
}

impl Topic {
    /// How many there are.
    pub(crate) const COUNT: usize = 8 + Sensor::COUNT;

    /// All of them, in the order of their places.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let first = [
            Self::Position,
            Self::Log,
            Self::Fence,
            Self::Plan,
            Self::Inserts,
            Self::Requests,
        ];
        let sensors = Sensor::all().map(Self::Sensor);
        first.into_iter().chain(sensors).chain([Self::Shadow, Self::Reach])
    }

    /// Its place among all.
    pub(crate) const fn place(self) -> usize {
        match self {
            Self::Position => 0,
            Self::Log => 1,
            Self::Fence => 2,
            Self::Plan => 3,
            Self::Inserts => 4,
            Self::Requests => 5,
            Self::Sensor(sensor) => 6 + sensor.place(),
            Self::Shadow => 6 + Sensor::COUNT,
            Self::Reach => 7 + Sensor::COUNT,
        }
    }

    /// Its name in the log.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Position => "/position".to_owned(),
            Self::Log => "/log".to_owned(),
            Self::Fence => "/map/fence".to_owned(),
            Self::Plan => "/map/plan".to_owned(),
            Self::Inserts => "/map/inserts".to_owned(),
            Self::Requests => "/map/requests".to_owned(),
            Self::Sensor(sensor) => format!("/sensors/{}", sensor.name()),
            Self::Shadow => "/shadow".to_owned(),
            Self::Reach => "/map/reach".to_owned(),
        }
    }

    /// The name and the text of its schema.
    pub(crate) fn schema(self) -> (String, String) {
        let (name, schema) = match self {
            Self::Position => ("foxglove.LocationFix".to_owned(), location_fix()),
            Self::Log => ("foxglove.Log".to_owned(), log()),
            Self::Fence | Self::Plan | Self::Inserts | Self::Requests | Self::Reach => {
                ("foxglove.GeoJSON".to_owned(), geojson())
            }
            Self::Sensor(sensor) => (format!("backseat.{}", sensor.name()), sensor.schema()),
            Self::Shadow => ("backseat.Shadow".to_owned(), shadow()),
        };
        (name, schema.to_string())
    }
}

fn time() -> Fields {
    Fields::new().integer("sec", "").integer("nsec", "")
}

fn location_fix() -> Value {
    let velocity = Fields::new()
        .number("x", "East.")
        .number("y", "North.")
        .number("z", "Up.");
    let colour = Fields::new()
        .number("r", "")
        .number("g", "")
        .number("b", "")
        .number("a", "");
    Fields::new()
        .object("timestamp", "UTC of the solution.", time())
        .text("frame_id", "")
        .number("latitude", "Degrees.")
        .number("longitude", "Degrees.")
        .number("altitude", "Metres above the surface: the depth with its sign changed.")
        .list_of("position_covariance", "number", "Nine numbers; unknown.")
        .integer("position_covariance_type", "0: unknown.")
        .number("heading", "True, radians.")
        .object("velocity", "Left out: it is on /navigation.", velocity)
        .object("color", "Left out.", colour)
        .list("metadata", "Left out.", Fields::new().text("key", "").text("value", ""))
        .into_message(
            "Navigation as the safety monitor uses it.",
            &[
                "timestamp",
                "frame_id",
                "latitude",
                "longitude",
                "altitude",
                "position_covariance",
                "position_covariance_type",
            ],
        )
}

fn log() -> Value {
    Fields::new()
        .object("timestamp", "UTC.", time())
        .integer("level", "1 debug, 2 info, 3 warning, 4 error.")
        .text("message", "")
        .text("name", "`plugin NAME`, `runtime` or `vehicle`.")
        .text("file", "Empty.")
        .integer("line", "0.")
        .into_message(
            "A line of a plugin, a note, or a new state of a request.",
            &["timestamp", "level", "message", "name", "file", "line"],
        )
}

fn geojson() -> Value {
    Fields::new()
        .text("geojson", "GeoJSON.")
        .into_message("Shapes on the map.", &["geojson"])
}

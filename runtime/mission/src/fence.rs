//! The fence's file of a mission, in one of three formats.

use std::path::Path;

use backseat_fence::{Fence, Form, Terms};
use backseat_units::Position;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::MissionError;
use crate::mission::{read_own, value};
use crate::unknown::with_suggestion;

/// The formats, in the order in which messages list them.
const FILES: [&str; 3] = ["fence.geojson", "fence.plan", "fence.kml"];

/// The `[fence]` table: the values that `fence.plan` cannot hold and `fence.kml` may leave out. `fence.geojson` holds
/// all of them, so the table is not allowed with it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FenceTable {
    /// Distance from the edges of all zones, metres, 0 or more.
    pub margin_m: f64,
    /// Shallowest depth of keep-in zones, metres; 0 if missing.
    #[serde(default)]
    pub depth_min_m: f64,
    /// Deepest depth of keep-in zones, metres.
    pub depth_max_m: f64,
    /// Least altitude above the bottom in keep-in zones, metres, 0 or more.
    pub altitude_min_m: f64,
    /// Whether the vehicle may surface in keep-in zones; false if missing.
    #[serde(default)]
    pub surfacing: bool,
}

/// The `[origin]` table: where the local frame has its zero point, in which plugins, the log and the map count metres
/// east and north.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Degrees, north positive, -85 to 85.
    pub latitude_deg: f64,
    /// Degrees, east positive, -180 to 180.
    pub longitude_deg: f64,
}

impl Origin {
    fn position(self) -> Result<Position, String> {
        let Self {
            latitude_deg,
            longitude_deg,
        } = self;
        let found = || format!("origin is latitude {latitude_deg} longitude {longitude_deg}");
        let position = Position::from_deg(latitude_deg, longitude_deg).ok();
        position
            .filter(|_| latitude_deg.abs() <= 85.0)
            .ok_or_else(|| format!("{}, expected -85 to 85 and -180 to 180 degrees", found()))
    }
}

/// A fence as it was read.
pub(crate) struct Loaded {
    pub(crate) fence: Fence,
    /// The name of its file.
    pub(crate) file: &'static str,
    /// The fence as GeoJSON with polygons only, for readers of no other format.
    pub(crate) text: String,
    /// The text of its file, if it is another.
    pub(crate) as_read: Option<String>,
}

/// Reads the fence of a mission's folder, which must have exactly one.
pub(crate) fn load(folder: &Path, table: Option<&FenceTable>, origin: Option<Origin>) -> Result<Loaded, MissionError> {
    // A file that cannot be read, such as a dangling link, counts too: someone meant it to be the fence.
    let there = |file: &&str| folder.join(file).symlink_metadata().is_ok();
    let found: Vec<&str> = FILES.into_iter().filter(there).collect();
    let file = match found[..] {
        [file] => file,
        [] => {
            let expected = "no fence here: expected one of fence.geojson, fence.plan and fence.kml";
            return Err(value(folder, expected.to_owned()));
        }
        _ => {
            let several = format!("found {}: expected only one fence file", found.join(" and "));
            return Err(value(folder, several));
        }
    };
    let text = read_own(&folder.join(file))?;
    read_text(folder, file, text, table, origin)
}

/// Reads the fence from the text of this file of a mission's folder.
pub(crate) fn read_text(
    folder: &Path,
    file: &str,
    text: String,
    table: Option<&FenceTable>,
    origin: Option<Origin>,
) -> Result<Loaded, MissionError> {
    let path = folder.join(file);
    let Some(file) = FILES.into_iter().find(|known| *known == file) else {
        return Err(value(&path, format!("expected one of {}", FILES.join(", "))));
    };
    let mission = || folder.join("mission.toml");
    let terms = || match table {
        Some(table) => table.terms().map_err(|message| value(&mission(), message)),
        None => {
            let needed = format!(
                "no [fence] table: expected one with margin_m, depth_max_m and altitude_min_m, which {file} does not have"
            );
            Err(value(&mission(), needed))
        }
    };
    let origin = match origin {
        Some(origin) => Some(origin.position().map_err(|message| value(&mission(), message))?),
        None => None,
    };
    let kept;
    let form = match file {
        "fence.plan" => {
            kept = terms()?;
            Form::Plan(&kept)
        }
        "fence.kml" => {
            kept = terms()?;
            Form::Kml(&kept)
        }
        _ if table.is_some() => {
            let doubled = "[fence] is for fence.plan and fence.kml only: fence.geojson has these values itself";
            return Err(value(&mission(), doubled.to_owned()));
        }
        _ => Form::GeoJson,
    };
    let fence = Fence::read(&text, form, origin).map_err(|error| {
        // If the fence is good without the origin, the fault is in the file that has the origin.
        let is_the_origins = origin.is_some() && Fence::read(&text, form, None).is_ok();
        let at = if is_the_origins { mission() } else { path };
        value(&at, with_suggestion(&error.to_string()))
    })?;
    let (text, as_read) = if file == "fence.geojson" && has_areas_alone(&text) {
        (text, None)
    } else {
        (fence.to_geojson(), Some(text))
    };
    Ok(Loaded {
        fence,
        file,
        text,
        as_read,
    })
}

impl FenceTable {
    fn terms(&self) -> Result<Terms, String> {
        let figures = [
            ("margin_m", self.margin_m),
            ("depth_min_m", self.depth_min_m),
            ("depth_max_m", self.depth_max_m),
            ("altitude_min_m", self.altitude_min_m),
        ];
        for (key, metres) in figures {
            if !(0.0..=1e6).contains(&metres) {
                return Err(format!("fence.{key} is {metres}: expected metres, 0 or more"));
            }
        }
        if self.depth_min_m >= self.depth_max_m {
            return Err(format!(
                "fence.depth_max_m is {}: expected more than depth_min_m of {}",
                self.depth_max_m, self.depth_min_m
            ));
        }
        Ok(Terms {
            margin_m: self.margin_m,
            depth_min_m: self.depth_min_m,
            depth_max_m: self.depth_max_m,
            altitude_min_m: self.altitude_min_m,
            surfacing: self.surfacing,
        })
    }
}

/// Whether a fence as it was read has no circles and no corridors.
fn has_areas_alone(text: &str) -> bool {
    let Ok(document) = serde_json::from_str::<Value>(text) else {
        return false;
    };
    let features = document.get("features").and_then(Value::as_array);
    features.is_some_and(|features| {
        features.iter().all(|feature| {
            let kind = feature.pointer("/geometry/type").and_then(Value::as_str);
            matches!(kind, Some("Polygon" | "MultiPolygon"))
        })
    })
}

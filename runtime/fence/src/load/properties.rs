//! Reads a feature's properties: name, kind, limits.

use backseat_units::{Depth, Utc};
use serde_json::{Map, Value};

use super::renamed;
use crate::error::FenceError;
use crate::window::{self, Window};
use crate::zone::{Band, Kind};

/// The properties of a zone.
pub(super) struct Properties {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) margin_m: f64,
    pub(super) window: Window,
}

/// Whether a feature is a circle, a corridor or neither, which decides which length it must have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Round {
    No,
    Circle,
    Corridor,
}

impl Properties {
    pub(super) fn is_keep_in(&self) -> bool {
        match self.kind {
            Kind::KeepIn { .. } => true,
            Kind::KeepOut { .. } => false,
        }
    }
}

impl Round {
    const fn key(self) -> Option<&'static str> {
        match self {
            Self::No => None,
            Self::Circle => Some("radius_m"),
            Self::Corridor => Some("half_width_m"),
        }
    }
}

const KEEP_IN_KEYS: &str = "`name`, `kind`, `margin_m`, `depth_min_m`, `depth_max_m`, `altitude_min_m`, `surfacing`, `valid_from` or `valid_until`";
const KEEP_OUT_KEYS: &str = "`name`, `kind`, `margin_m`, `depth_min_m`, `depth_max_m`, `valid_from` or `valid_until`";
/// The smallest radius or half width, metres: smaller circles and narrower corridors are mistakes.
const ROUND_MIN_M: f64 = 0.1;
/// The greatest radius or half width, metres: half of the widest fence.
const ROUND_MAX_M: f64 = 25_000.0;
const NAME: &str = "a name of 1 to 100 printable characters";
const KIND: &str = "\"keep-in\" or \"keep-out\"";

/// The name of a feature in errors: its own name if that is usable, otherwise its number.
pub(super) fn label(properties: Option<&Map<String, Value>>, index: usize) -> String {
    match properties
        .and_then(|map| map.get("name"))
        .and_then(Value::as_str)
        .filter(|name| usable_name(name))
    {
        Some(name) => format!("feature '{name}'"),
        None => format!("feature {}", index + 1),
    }
}

/// Reads all properties and refuses unknown ones. Also returns the radius of a circle or half the width of a corridor;
/// zero for an area.
pub(super) fn read(map: &Map<String, Value>, feature: &str, round: Round) -> Result<(Properties, f64), FenceError> {
    let source = Source { map, feature };
    let name = source.required("name", NAME)?;
    let name = match name.as_str() {
        Some(text) if usable_name(text) => text.to_owned(),
        _ => return Err(source.bad("name", name, NAME)),
    };
    let kind = source.required("kind", KIND)?;
    let keep_in = match kind.as_str() {
        Some("keep-in") => true,
        Some("keep-out") => false,
        other => return Err(source.bad("kind", kind, other.and_then(renamed::kind).unwrap_or(KIND))),
    };
    for (key, value) in map {
        let known = match key.as_str() {
            "name" | "kind" | "margin_m" | "depth_min_m" | "depth_max_m" | "valid_from" | "valid_until" => true,
            // Geographic information systems write every column for every feature.
            "altitude_min_m" | "surfacing" => keep_in || value.is_null(),
            other => round.key() == Some(other) || (matches!(other, "radius_m" | "half_width_m") && value.is_null()),
        };
        if !known {
            let (place, key) = (feature.to_owned(), shortened(key));
            return Err(FenceError::UnknownKey {
                place,
                key,
                expected: if keep_in { KEEP_IN_KEYS } else { KEEP_OUT_KEYS },
            });
        }
    }
    let margin_m = source.metres("margin_m", 0.0, 50_000.0)?;
    let margin_m = margin_m.ok_or_else(|| source.missing("margin_m", "metres, 0 or more"))?;
    let (depth_min_m, depth_max_m) = (source.depth("depth_min_m")?, source.depth("depth_max_m")?);
    if let (Some(min_m), Some(max_m)) = (depth_min_m, depth_max_m)
        && min_m > max_m
    {
        let found = Value::from(max_m);
        return Err(source.bad("depth_max_m", &found, &format!("at least the `depth_min_m` of {min_m}")));
    }
    let kind = if keep_in {
        let max_m = depth_max_m.ok_or_else(|| source.missing("depth_max_m", "metres"))?;
        let min_m = depth_min_m.unwrap_or(0.0);
        if min_m > max_m {
            return Err(source.bad("depth_max_m", &Value::from(max_m), "at least the `depth_min_m` of 0"));
        }
        let altitude_min_m = source.metres("altitude_min_m", 0.0, 12_000.0)?;
        let altitude_min_m = altitude_min_m.ok_or_else(|| source.missing("altitude_min_m", "metres, 0 or more"))?;
        Kind::KeepIn {
            depth: Band { min_m, max_m },
            altitude_min_m,
            surfacing: source.truth("surfacing")?.unwrap_or(false),
        }
    } else if depth_min_m.is_none() && depth_max_m.is_none() {
        Kind::KeepOut { depth: None }
    } else {
        let (min_m, max_m) = (
            depth_min_m.unwrap_or(f64::NEG_INFINITY),
            depth_max_m.unwrap_or(f64::INFINITY),
        );
        Kind::KeepOut {
            depth: Some(Band { min_m, max_m }),
        }
    };
    let window = Window {
        from: source.time("valid_from")?,
        until: source.time("valid_until")?,
    };
    if let (Some(from), Some(until)) = (window.from, window.until)
        && from >= until
    {
        let found = source.get("valid_until").unwrap_or(&Value::Null);
        return Err(source.bad("valid_until", found, "a time after `valid_from`"));
    }
    let round_m = match round.key() {
        Some(key) => {
            let length_m = source.metres(key, ROUND_MIN_M, ROUND_MAX_M)?;
            length_m.ok_or_else(|| source.missing(key, "metres, 0.1 to 25000"))?
        }
        None => 0.0,
    };
    let properties = Properties {
        name,
        kind,
        margin_m,
        window,
    };
    Ok((properties, round_m))
}

fn usable_name(name: &str) -> bool {
    !name.trim().is_empty() && name.chars().count() <= 100 && !name.chars().any(char::is_control)
}

struct Source<'a> {
    map: &'a Map<String, Value>,
    feature: &'a str,
}

impl Source<'_> {
    /// A value; null counts as absent.
    fn get(&self, key: &str) -> Option<&Value> {
        self.map.get(key).filter(|value| !value.is_null())
    }

    fn required(&self, key: &'static str, expected: &'static str) -> Result<&Value, FenceError> {
        self.get(key).ok_or_else(|| self.missing(key, expected))
    }

    fn metres(&self, key: &'static str, min: f64, max: f64) -> Result<Option<f64>, FenceError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.as_f64() {
            Some(metres) if (min..=max).contains(&metres) => Ok(Some(metres)),
            _ => Err(self.bad(key, value, &format!("metres within {min} to {max}"))),
        }
    }

    fn truth(&self, key: &'static str) -> Result<Option<bool>, FenceError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.as_bool() {
            Some(truth) => Ok(Some(truth)),
            None => Err(self.bad(key, value, "true or false")),
        }
    }

    fn depth(&self, key: &'static str) -> Result<Option<f64>, FenceError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let metres = value.as_f64().unwrap_or(f64::NAN);
        match Depth::from_m(metres) {
            Ok(depth) => Ok(Some(depth.as_m())),
            Err(range) => Err(self.bad(key, value, &format!("metres within {} to {}", range.min, range.max))),
        }
    }

    fn time(&self, key: &'static str) -> Result<Option<Utc>, FenceError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.as_str().and_then(window::utc) {
            Some(time) => Ok(Some(time)),
            None => Err(self.bad(key, value, "a time of RFC 3339, such as \"2026-05-01T08:00:00Z\"")),
        }
    }

    fn missing(&self, key: &'static str, expected: &'static str) -> FenceError {
        FenceError::MissingKey {
            feature: self.feature.to_owned(),
            key,
            expected,
        }
    }

    fn bad(&self, key: &'static str, found: &Value, expected: &str) -> FenceError {
        let feature = self.feature.to_owned();
        FenceError::BadValue {
            feature,
            key,
            found: shortened(&found.to_string()),
            expected: expected.to_owned(),
        }
    }
}

/// The part of a value that an error shows: enough to find it, on one line.
pub(super) fn shortened(text: &str) -> String {
    let (start, rest) = match text.char_indices().nth(60) {
        Some((end, _)) => (&text[..end], "..."),
        None => (text, ""),
    };
    format!("{}{rest}", start.replace(char::is_control, " "))
}

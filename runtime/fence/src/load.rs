//! From the text of a fence to its frame and zones.

use std::collections::BTreeMap;

use backseat_units::{LocalFrame, Position};
use geojson::{Feature, GeometryValue};
use serde_json::{Map, Value};

use crate::error::{FenceError, Place};
use crate::outline::{Outliner, RawPolygon, RawRing};
use crate::zone::{Kind, Zone};

mod json;
mod properties;
mod round;

use properties::{Properties, Round, label, shortened};

/// More vertices are refused: a mistake, or an attempt to exhaust memory.
pub(crate) const VERTICES_MAX: usize = 1_000_000;

/// The frame's formulas lose their precision towards the poles.
const LATITUDE_MAX_DEG: f64 = 85.0;

/// The greatest side of a fence, metres.
const ACROSS_MAX_M: f64 = 50_000.0;

/// Metres to a degree of latitude, at most (WGS84, at the pole).
const METRES_PER_DEG: f64 = 111_694.0;

/// A feature as it was read, before its rings are judged.
struct RawZone {
    label: String,
    properties: Properties,
    polygons: Vec<RawPolygon>,
}

const GEOMETRY: &str = "Polygon, MultiPolygon, Point or LineString";

impl RawZone {
    fn rings(&self) -> impl Iterator<Item = &RawRing> {
        self.polygons.iter().flatten()
    }

    fn circle(label: String, properties: Properties, centre: Position, radius_m: f64) -> Result<Self, FenceError> {
        // Rings of positions wrap at the antimeridian.
        let reach_deg = radius_m / METRES_PER_DEG / backseat_units::math::cos(centre.latitude.as_deg().to_radians());
        let longitude = centre.longitude.as_deg();
        if longitude.abs() + 1.1 * reach_deg > 180.0 {
            return Err(FenceError::Antimeridian {
                place: label,
                west: longitude - reach_deg,
                east: longitude + reach_deg,
            });
        }
        let polygons = vec![round::circle(centre, radius_m, properties.is_inclusion())];
        Ok(Self {
            label,
            properties,
            polygons,
        })
    }

    fn corridor(
        label: String,
        properties: Properties,
        line: &[Position],
        half_width_m: f64,
    ) -> Result<Self, FenceError> {
        let mut bounds = Bounds::NOTHING;
        line.iter().for_each(|position| bounds.add(position));
        bounds.refuse_antimeridian(&label)?;
        bounds.refuse_wide()?;
        let middle = Position::from_deg((bounds.south + bounds.north) / 2.0, (bounds.west + bounds.east) / 2.0);
        let Ok(middle) = middle else {
            return Err(form(
                label,
                "no positions".to_owned(),
                "a LineString of at least two positions",
            ));
        };
        let polygons = round::corridor(line, middle, half_width_m, properties.is_inclusion(), &label)?;
        Ok(Self {
            label,
            properties,
            polygons,
        })
    }
}

pub(crate) fn load(text: &str) -> Result<(LocalFrame, Vec<Zone>), FenceError> {
    let raw = read(json::parse(text)?)?;
    let bounds = Bounds::of(&raw)?;
    let frame = frame(&raw, &bounds)?;
    let mut outliner = Outliner::new(&frame);
    let mut zones = Vec::with_capacity(raw.len());
    for zone in raw {
        let mut polygons = Vec::with_capacity(zone.polygons.len());
        for (index, polygon) in zone.polygons.iter().enumerate() {
            let place = |hole: usize| Place {
                feature: zone.label.clone(),
                polygon: (zone.polygons.len() > 1).then_some(index + 1),
                hole: (hole > 0).then_some(hole),
            };
            let margin_m = match zone.properties.kind {
                Kind::Inclusion { .. } => zone.properties.margin_m,
                Kind::Exclusion { .. } => 0.0,
            };
            polygons.push(outliner.polygon(polygon, margin_m, &place)?);
        }
        let Properties {
            name,
            kind,
            margin_m,
            window,
        } = zone.properties;
        zones.push(Zone {
            name,
            kind,
            margin_m,
            window,
            polygons,
        });
    }
    let across_m = outliner.across_m();
    if across_m > ACROSS_MAX_M {
        return Err(too_wide(across_m));
    }
    Ok((frame, zones))
}

/// The features of the document.
fn read(document: Value) -> Result<Vec<RawZone>, FenceError> {
    let place = || "document".to_owned();
    let Value::Object(mut document) = document else {
        return Err(form(place(), kind_of(&document), "a FeatureCollection"));
    };
    match document.get("type").map(Value::as_str) {
        Some(Some("FeatureCollection")) => {}
        Some(Some(other)) => return Err(form(place(), shortened(other), "a FeatureCollection")),
        Some(None) | None => return Err(form(place(), "no `type`".to_owned(), "`type` of \"FeatureCollection\"")),
    }
    if let Some(system) = document.get("crs").filter(|system| !system.is_null()) {
        coordinate_system(system)?;
    }
    let features = match document.remove("features") {
        Some(Value::Array(features)) => features,
        Some(other) => return Err(form("`features`".to_owned(), kind_of(&other), "an array of features")),
        None => return Err(form(place(), "no `features`".to_owned(), "an array of features")),
    };
    // The last one is what GDAL writes beside the features.
    let known = ["type", "name", "crs", "bbox", "xy_coordinate_resolution"];
    refuse_unknown(&document, place, &known, "`type`, `name`, `crs`, `bbox` or `features`")?;
    if features.is_empty() {
        return Err(FenceError::Empty);
    }
    let mut zones: Vec<RawZone> = Vec::with_capacity(features.len());
    let mut names = BTreeMap::new();
    let mut vertices = 0;
    for (index, feature) in features.into_iter().enumerate() {
        let zone = zone(feature, index)?;
        let name = zone.properties.name.clone();
        if let Some(first) = names.insert(name.clone(), index) {
            return Err(FenceError::DuplicateName {
                name,
                first: first + 1,
                second: index + 1,
            });
        }
        vertices += zone.rings().map(|ring| ring.positions.len()).sum::<usize>();
        if vertices > VERTICES_MAX {
            return Err(FenceError::TooManyVertices {
                found: vertices,
                limit: VERTICES_MAX,
            });
        }
        zones.push(zone);
    }
    if !zones
        .iter()
        .any(|zone| matches!(zone.properties.kind, Kind::Inclusion { .. }))
    {
        return Err(FenceError::NoInclusion { features: zones.len() });
    }
    Ok(zones)
}

/// Only WGS84 in longitude and latitude: the same numbers mean other places elsewhere.
fn coordinate_system(system: &Value) -> Result<(), FenceError> {
    let name = system.pointer("/properties/name").and_then(Value::as_str);
    if matches!(
        name,
        Some("urn:ogc:def:crs:OGC:1.3:CRS84" | "urn:ogc:def:crs:OGC::CRS84")
    ) {
        return Ok(());
    }
    Err(form(
        "`crs`".to_owned(),
        shortened(&system.to_string()),
        "urn:ogc:def:crs:OGC:1.3:CRS84, or no `crs`",
    ))
}

fn zone(feature: Value, index: usize) -> Result<RawZone, FenceError> {
    let numbered = || format!("feature {}", index + 1);
    let Value::Object(object) = feature else {
        return Err(form(
            numbered(),
            kind_of(&feature),
            "a Feature with properties and geometry",
        ));
    };
    let label = label(object.get("properties").and_then(Value::as_object), index);
    let place = || label.clone();
    refuse_unknown(
        &object,
        place,
        &["type", "id", "bbox", "properties", "geometry"],
        "`type`, `id`, `bbox`, `properties` or `geometry`",
    )?;
    let round = match object
        .get("geometry")
        .and_then(|geometry| geometry.get("type"))
        .and_then(Value::as_str)
    {
        Some("Point") => Round::Circle,
        Some("LineString") => Round::Corridor,
        Some(_) | None => Round::No,
    };
    let (properties, round_m) = match object.get("properties") {
        Some(Value::Object(map)) => properties::read(map, &label, round)?,
        Some(_) | None => {
            return Err(form(
                place(),
                "no `properties`".to_owned(),
                "an object with `name` and `kind`",
            ));
        }
    };
    if let Some(Value::Object(geometry)) = object.get("geometry") {
        let place = || format!("{label} geometry");
        refuse_unknown(
            geometry,
            place,
            &["type", "coordinates", "bbox"],
            "`type` or `coordinates`",
        )?;
    }
    let feature = serde_json::from_value::<Feature>(Value::Object(object))
        .map_err(|error| form(place(), shortened(&error.to_string()), "a Feature of RFC 7946"))?;
    let polygons = match feature.geometry.map(|geometry| geometry.value) {
        Some(GeometryValue::Polygon { coordinates }) => vec![coordinates],
        Some(GeometryValue::MultiPolygon { coordinates }) => coordinates,
        Some(GeometryValue::Point { coordinates }) => {
            let place = || label.clone();
            let centre = position(coordinates.as_slice(), 0, &place)?;
            return RawZone::circle(label, properties, centre, round_m);
        }
        Some(GeometryValue::LineString { coordinates }) => {
            let line = positions(&coordinates, &|| label.clone())?;
            return RawZone::corridor(label, properties, &line, round_m);
        }
        Some(
            other @ (GeometryValue::MultiPoint { .. }
            | GeometryValue::MultiLineString { .. }
            | GeometryValue::GeometryCollection { .. }),
        ) => {
            return Err(form(place(), format!("geometry is {}", other.type_name()), GEOMETRY));
        }
        None => return Err(form(place(), "no geometry".to_owned(), GEOMETRY)),
    };
    if polygons.is_empty() || polygons.iter().any(Vec::is_empty) {
        return Err(form(place(), "polygon without rings".to_owned(), "an outer ring"));
    }
    let several = polygons.len() > 1;
    let mut raw = Vec::with_capacity(polygons.len());
    for (number, rings) in polygons.into_iter().enumerate() {
        let mut polygon = Vec::with_capacity(rings.len());
        for (hole, ring) in rings.into_iter().enumerate() {
            let place = || Place {
                feature: label.clone(),
                polygon: several.then_some(number + 1),
                hole: (hole > 0).then_some(hole),
            };
            polygon.push(RawRing {
                positions: positions(&ring, &|| place().to_string())?,
                numbers: None,
            });
        }
        raw.push(polygon);
    }
    Ok(RawZone {
        label,
        properties,
        polygons: raw,
    })
}

fn positions(line: &[geojson::Position], place: &dyn Fn() -> String) -> Result<Vec<Position>, FenceError> {
    let numbered = line.iter().enumerate();
    numbered
        .map(|(index, raw)| position(raw.as_slice(), index, place))
        .collect()
}

fn position(raw: &[f64], index: usize, place: &dyn Fn() -> String) -> Result<Position, FenceError> {
    let bad = |found: String, expected: &'static str| FenceError::Vertex {
        place: place(),
        vertex: index + 1,
        found,
        expected,
    };
    let [longitude, latitude] = *raw else {
        return Err(bad(format!("{} numbers", raw.len()), "longitude and latitude"));
    };
    let position =
        Position::from_deg(latitude, longitude).map_err(|error| bad(error.to_string(), "longitude, then latitude"))?;
    if latitude.abs() > LATITUDE_MAX_DEG {
        return Err(bad(
            format!("latitude {latitude} deg"),
            "at most 85 degrees north or south",
        ));
    }
    Ok(position)
}

/// The extent in degrees.
struct Bounds {
    west: f64,
    east: f64,
    south: f64,
    north: f64,
}

impl Bounds {
    const NOTHING: Self = Self {
        west: f64::INFINITY,
        east: f64::NEG_INFINITY,
        south: f64::INFINITY,
        north: f64::NEG_INFINITY,
    };

    fn of(zones: &[RawZone]) -> Result<Self, FenceError> {
        let mut all = Self::NOTHING;
        for zone in zones {
            let mut own = Self::NOTHING;
            for position in zone.rings().flat_map(|ring| &ring.positions) {
                own.add(position);
                all.add(position);
            }
            own.refuse_antimeridian(&zone.label)?;
        }
        all.refuse_antimeridian("fence")?;
        Ok(all)
    }

    fn add(&mut self, position: &Position) {
        self.west = self.west.min(position.longitude.as_deg());
        self.east = self.east.max(position.longitude.as_deg());
        self.south = self.south.min(position.latitude.as_deg());
        self.north = self.north.max(position.latitude.as_deg());
    }

    /// What spans more than half of the earth is taken to go the other way round.
    fn refuse_antimeridian(&self, place: &str) -> Result<(), FenceError> {
        if self.east - self.west > 180.0 {
            return Err(FenceError::Antimeridian {
                place: place.to_owned(),
                west: self.west,
                east: self.east,
            });
        }
        Ok(())
    }

    /// A rough measure: far from its origin the frame's series mean nothing.
    fn refuse_wide(&self) -> Result<(), FenceError> {
        let widest = self.south.abs().min(self.north.abs());
        let widest = if self.south <= 0.0 && self.north >= 0.0 {
            0.0
        } else {
            widest
        };
        let east_m = (self.east - self.west) * METRES_PER_DEG * backseat_units::math::cos(widest.to_radians());
        let rough_m = east_m.max((self.north - self.south) * METRES_PER_DEG);
        if rough_m > 1.2 * ACROSS_MAX_M {
            return Err(too_wide(rough_m));
        }
        Ok(())
    }

    fn contains(&self, longitude: f64, latitude: f64) -> bool {
        (self.west..=self.east).contains(&longitude) && (self.south..=self.north).contains(&latitude)
    }
}

/// The frame around the centroid of the inclusion zones' outer rings, where the fence is small enough for one.
fn frame(zones: &[RawZone], bounds: &Bounds) -> Result<LocalFrame, FenceError> {
    let (mut middle_east, mut middle_north) = ((bounds.west + bounds.east) / 2.0, (bounds.south + bounds.north) / 2.0);
    if !(middle_east.is_finite() && middle_north.is_finite()) {
        // No position at all: any frame will do until the empty rings are refused.
        (middle_east, middle_north) = (0.0, 0.0);
    }
    bounds.refuse_wide()?;
    let (mut area, mut east, mut north) = (0.0, 0.0, 0.0);
    for zone in zones
        .iter()
        .filter(|zone| matches!(zone.properties.kind, Kind::Inclusion { .. }))
    {
        for ring in zone.polygons.iter().map(|rings| &rings[0]) {
            let moments = ring
                .positions
                .windows(2)
                .fold((0.0, 0.0, 0.0), |(area, east, north), ends| {
                    let (x, y) = (
                        ends[0].longitude.as_deg() - middle_east,
                        ends[0].latitude.as_deg() - middle_north,
                    );
                    let (u, v) = (
                        ends[1].longitude.as_deg() - middle_east,
                        ends[1].latitude.as_deg() - middle_north,
                    );
                    let cross = x * v - u * y;
                    (area + cross, east + (x + u) * cross, north + (y + v) * cross)
                });
            // Either winding counts.
            let sign = if moments.0 < 0.0 { -1.0 } else { 1.0 };
            area += sign * moments.0;
            east += sign * moments.1;
            north += sign * moments.2;
        }
    }
    let (mut longitude, mut latitude) = (middle_east + east / (3.0 * area), middle_north + north / (3.0 * area));
    // A ring that crosses itself has no such centroid; it is refused later, where its edges can be named.
    if !bounds.contains(longitude, latitude) {
        (longitude, latitude) = (middle_east, middle_north);
    }
    let origin = Position::from_deg(latitude, longitude).expect("the middle of legal positions is legal");
    Ok(LocalFrame::new(origin))
}

fn too_wide(across_m: f64) -> FenceError {
    FenceError::TooWide {
        across_km: across_m / 1000.0,
        limit_km: ACROSS_MAX_M / 1000.0,
    }
}

fn form(place: String, found: String, expected: &'static str) -> FenceError {
    FenceError::Form { place, found, expected }
}

fn refuse_unknown(
    object: &Map<String, Value>,
    place: impl Fn() -> String,
    known: &[&str],
    expected: &'static str,
) -> Result<(), FenceError> {
    match object.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(FenceError::UnknownKey {
            place: place(),
            key: shortened(key),
            expected,
        }),
        None => Ok(()),
    }
}

fn kind_of(value: &Value) -> String {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
    .to_owned()
}

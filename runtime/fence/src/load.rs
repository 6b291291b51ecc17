//! Makes the frame and the zones from the text of a fence. A reader for each file format makes raw zones, which are
//! then checked in the same way.

use std::collections::BTreeMap;

use backseat_units::{LocalFrame, Position};
use serde_json::Value;

use crate::cover;
use crate::error::{FenceError, Place};
use crate::outline::{Outliner, RawPolygon, RawRing};
use crate::terms::Form;
use crate::zone::{Kind, Zone};

mod geojson;
mod json;
mod kml;
mod plan;
mod properties;
mod renamed;
mod round;
mod xml;

use properties::Properties;

/// More vertices are refused: they are a mistake, or an attempt to exhaust memory.
pub(crate) const VERTICES_MAX: usize = 1_000_000;

/// The greatest latitude, north or south: towards the poles, the frame's formulas lose their precision.
const LATITUDE_MAX_DEG: f64 = 85.0;

/// The greatest side of a fence, metres.
const ACROSS_MAX_M: f64 = 50_000.0;

/// The greatest length of a degree of latitude, metres (WGS84, at the pole).
const METRES_PER_DEG: f64 = 111_694.0;

/// The frame and the zones in the order of the file.
type Loaded = (LocalFrame, Vec<Zone>);

/// A feature as it was read, before its rings are checked.
struct RawZone {
    label: String,
    properties: Properties,
    polygons: Vec<RawPolygon>,
}

const GEOMETRY: &str = "Polygon, MultiPolygon, Point or LineString";
const LONGITUDE_FIRST: &str = "longitude, then latitude";

impl RawZone {
    fn rings(&self) -> impl Iterator<Item = &RawRing> {
        self.polygons.iter().flatten()
    }

    /// Names a ring. Both numbers count from 0; hole 0 is the outer ring.
    fn place(&self, polygon: usize, hole: usize) -> Place {
        Place {
            feature: self.label.clone(),
            polygon: (self.polygons.len() > 1).then_some(polygon + 1),
            hole: (hole > 0).then_some(hole),
        }
    }

    fn circle(label: String, properties: Properties, centre: Position, radius_m: f64) -> Result<Self, FenceError> {
        // Rings of positions would wrap at the antimeridian.
        let reach_deg = radius_m / METRES_PER_DEG / backseat_units::math::cos(centre.latitude.as_deg().to_radians());
        let longitude = centre.longitude.as_deg();
        if longitude.abs() + 1.1 * reach_deg > 180.0 {
            return Err(FenceError::Antimeridian {
                place: label,
                west: longitude - reach_deg,
                east: longitude + reach_deg,
            });
        }
        let polygons = vec![round::circle(centre, radius_m, properties.is_keep_in())];
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
        bounds.refuse_wide(|| {
            let vertices: Vec<_> = line.iter().zip(1..).collect();
            farthest(&vertices).map_or_else(|| label.clone(), |vertex| format!("{label} vertex {vertex}"))
        })?;
        let middle = Position::from_deg((bounds.south + bounds.north) / 2.0, (bounds.west + bounds.east) / 2.0);
        let Ok(middle) = middle else {
            return Err(form(
                label,
                "no positions".to_owned(),
                "a LineString of at least two positions",
            ));
        };
        let polygons = round::corridor(line, middle, half_width_m, properties.is_keep_in(), &label)?;
        Ok(Self {
            label,
            properties,
            polygons,
        })
    }
}

/// Reads the text of a file. The frame's origin is the centroid of the keep-in zones if none is given.
pub(crate) fn read(text: &str, form: Form<'_>, origin: Option<Position>) -> Result<Loaded, FenceError> {
    let raw = match form {
        Form::GeoJson => geojson::read(text)?,
        Form::Plan(terms) => plan::read(text, terms)?,
        Form::Kml(terms) => kml::read(text, terms)?,
    };
    judged(raw, origin)
}

/// Checks raw zones, and makes the frame and the zones from them.
fn judged(raw: Vec<RawZone>, origin: Option<Position>) -> Result<Loaded, FenceError> {
    refuse_collection(&raw)?;
    let bounds = Bounds::of(&raw)?;
    let frame = match origin {
        Some(origin) => frame_at(origin, &raw, bounds)?,
        None => frame(&raw, &bounds)?,
    };
    let mut outliner = Outliner::new(&frame);
    let mut zones = Vec::with_capacity(raw.len());
    for zone in &raw {
        let mut polygons = Vec::with_capacity(zone.polygons.len());
        for (index, polygon) in zone.polygons.iter().enumerate() {
            let place = |hole: usize| zone.place(index, hole);
            let margin_m = match zone.properties.kind {
                Kind::KeepIn { .. } => zone.properties.margin_m,
                Kind::KeepOut { .. } => 0.0,
            };
            let polygon = outliner.polygon(polygon, margin_m, &place);
            polygons.push(polygon.map_err(|fault| within(&zone.label, fault))?);
        }
        zones.push(Zone {
            name: zone.properties.name.clone(),
            kind: zone.properties.kind,
            margin_m: zone.properties.margin_m,
            window: zone.properties.window,
            polygons,
        });
    }
    if let Some(covered) = cover::find(&zones) {
        return Err(FenceError::Excluded {
            place: raw[covered.keep_in].place(covered.polygon, 0),
            keep_out: zones[covered.keep_out].name.clone(),
        });
    }
    let across_m = outliner.across_m();
    if across_m > ACROSS_MAX_M {
        return Err(too_wide(farthest_vertex(&raw), across_m));
    }
    Ok((frame, zones))
}

/// Refuses faults that no zone shows alone.
fn refuse_collection(zones: &[RawZone]) -> Result<(), FenceError> {
    if zones.is_empty() {
        return Err(FenceError::Empty);
    }
    let mut names = BTreeMap::new();
    let mut vertices = 0;
    for (index, zone) in zones.iter().enumerate() {
        let name = &zone.properties.name;
        if let Some(first) = names.insert(name, index) {
            return Err(FenceError::DuplicateName {
                name: name.clone(),
                first: first + 1,
                second: index + 1,
            });
        }
        vertices += zone.rings().map(|ring| ring.positions.len()).sum::<usize>();
        if vertices > VERTICES_MAX {
            let (found, limit) = (vertices, VERTICES_MAX);
            return Err(within(&zone.label, FenceError::TooManyVertices { found, limit }));
        }
    }
    if !zones.iter().any(|zone| zone.properties.is_keep_in()) {
        return Err(FenceError::NoKeepIn { features: zones.len() });
    }
    Ok(())
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

    /// An extent of more than half of the earth is taken to go the other way round.
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

    /// Refuses a fence by a rough measure of its size, because far from its origin the frame's series have no meaning.
    fn refuse_wide(&self, farthest: impl FnOnce() -> String) -> Result<(), FenceError> {
        let widest = self.south.abs().min(self.north.abs());
        let widest = if self.south <= 0.0 && self.north >= 0.0 {
            0.0
        } else {
            widest
        };
        let east_m = (self.east - self.west) * METRES_PER_DEG * backseat_units::math::cos(widest.to_radians());
        let rough_m = east_m.max((self.north - self.south) * METRES_PER_DEG);
        if rough_m > 1.2 * ACROSS_MAX_M {
            return Err(too_wide(farthest(), rough_m));
        }
        Ok(())
    }

    fn contains(&self, longitude: f64, latitude: f64) -> bool {
        (self.west..=self.east).contains(&longitude) && (self.south..=self.north).contains(&latitude)
    }
}

/// The frame around this origin, if fence and origin together are small enough for one frame.
fn frame_at(origin: Position, zones: &[RawZone], mut bounds: Bounds) -> Result<LocalFrame, FenceError> {
    bounds.refuse_wide(|| farthest_vertex(zones))?;
    bounds.add(&origin);
    bounds.refuse_wide(|| {
        let (latitude, longitude) = (origin.latitude.as_deg(), origin.longitude.as_deg());
        format!("the origin (latitude {latitude} longitude {longitude})")
    })?;
    Ok(LocalFrame::new(origin))
}

/// The frame around the centroid of the keep-in zones' outer rings, if the fence is small enough for one frame.
fn frame(zones: &[RawZone], bounds: &Bounds) -> Result<LocalFrame, FenceError> {
    let (mut middle_east, mut middle_north) = ((bounds.west + bounds.east) / 2.0, (bounds.south + bounds.north) / 2.0);
    if !(middle_east.is_finite() && middle_north.is_finite()) {
        // There is no position at all. Any frame will do until the empty rings are refused.
        (middle_east, middle_north) = (0.0, 0.0);
    }
    bounds.refuse_wide(|| farthest_vertex(zones))?;
    let (mut area, mut east, mut north) = (0.0, 0.0, 0.0);
    for zone in zones
        .iter()
        .filter(|zone| matches!(zone.properties.kind, Kind::KeepIn { .. }))
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
            // Rings count in both directions.
            let sign = if moments.0 < 0.0 { -1.0 } else { 1.0 };
            area += sign * moments.0;
            east += sign * moments.1;
            north += sign * moments.2;
        }
    }
    let (mut longitude, mut latitude) = (middle_east + east / (3.0 * area), middle_north + north / (3.0 * area));
    // A ring that crosses itself may have no such centroid. It is refused later, where its edges can be named.
    if !bounds.contains(longitude, latitude) {
        (longitude, latitude) = (middle_east, middle_north);
    }
    let origin = Position::from_deg(latitude, longitude).expect("the middle of valid positions is valid");
    Ok(LocalFrame::new(origin))
}

/// The vertex, circle or corridor that is farthest out.
fn farthest_vertex(zones: &[RawZone]) -> String {
    let mut vertices = Vec::new();
    for zone in zones {
        for (polygon, rings) in zone.polygons.iter().enumerate() {
            for (hole, ring) in rings.iter().enumerate() {
                // A circle or corridor counts once, because its vertices are not those of the file.
                let count = if ring.numbers.is_some() { 1 } else { usize::MAX };
                let numbered = ring.positions.iter().zip(1..).take(count);
                vertices.extend(numbered.map(|(position, number)| (position, (zone, polygon, hole, ring, number))));
            }
        }
    }
    match farthest(&vertices) {
        Some((zone, polygon, hole, ring, number)) if ring.numbers.is_none() => {
            format!("{} vertex {number}", zone.place(*polygon, *hole))
        }
        Some((zone, ..)) => zone.label.clone(),
        None => "fence".to_owned(),
    }
}

/// The item that is farthest from the median position: probably one with mistyped digits.
fn farthest<'a, T>(all: &'a [(&Position, T)]) -> Option<&'a T> {
    let median = |degrees: fn(&Position) -> f64| {
        let mut sorted: Vec<_> = all.iter().map(|(position, _)| degrees(position)).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or_default()
    };
    let (middle_east, middle_north) = (
        median(|position| position.longitude.as_deg()),
        median(|position| position.latitude.as_deg()),
    );
    let narrowing = backseat_units::math::cos(middle_north.to_radians());
    let squared = |position: &Position| {
        let east = (position.longitude.as_deg() - middle_east) * narrowing;
        let north = position.latitude.as_deg() - middle_north;
        east * east + north * north
    };
    // The first one, if several are equally far.
    let reversed = all.iter().rev();
    reversed
        .max_by(|a, b| squared(a.0).total_cmp(&squared(b.0)))
        .map(|(_, which)| which)
}

/// Adds the feature to a fault that does not name it.
fn within(feature: &str, fault: FenceError) -> FenceError {
    if !matches!(fault, FenceError::TooManyVertices { .. }) {
        return fault;
    }
    FenceError::Within {
        feature: feature.to_owned(),
        fault: Box::new(fault),
    }
}

/// Makes a position from longitude and latitude; `order` is their order in the file.
fn position(
    raw: &[f64],
    index: usize,
    order: &'static str,
    place: &dyn Fn() -> String,
) -> Result<Position, FenceError> {
    let bad = |found: String, expected: &'static str| FenceError::Vertex {
        place: place(),
        vertex: index + 1,
        found,
        expected,
    };
    let [longitude, latitude] = *raw else {
        return Err(bad(format!("{} numbers", raw.len()), "longitude and latitude"));
    };
    let position = Position::from_deg(latitude, longitude).map_err(|error| bad(error.to_string(), order))?;
    if latitude.abs() > LATITUDE_MAX_DEG {
        return Err(bad(
            format!("latitude {latitude} deg"),
            "at most 85 degrees north or south",
        ));
    }
    Ok(position)
}

fn too_wide(place: String, across_m: f64) -> FenceError {
    FenceError::TooWide {
        place,
        across_km: across_m / 1000.0,
        limit_km: ACROSS_MAX_M / 1000.0,
    }
}

fn form(place: String, found: String, expected: &'static str) -> FenceError {
    FenceError::Form { place, found, expected }
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

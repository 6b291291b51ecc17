//! Writes a fence as GeoJSON text, whatever file it was read from.

use serde_json::{Map, Value, json};

use crate::fence::Fence;
use crate::zone::{Band, Kind, Ring, Zone};

impl Fence {
    /// The fence as a `FeatureCollection` of areas in the form that [`Fence::from_geojson`] reads. Circles and
    /// corridors are written as the polygons that were made from them, and long edges with the vertices that divide
    /// them. A fence that is read from this text judges like this one, except for the rounding of positions (a few
    /// nanometres).
    #[must_use]
    pub fn to_geojson(&self) -> String {
        let features: Vec<Value> = self.zones().map(|zone| self.feature(zone)).collect();
        json!({"type": "FeatureCollection", "features": features}).to_string()
    }

    fn feature(&self, zone: &Zone) -> Value {
        let mut polygons: Vec<Vec<Value>> = Vec::new();
        for ring in zone.rings() {
            let coordinates = self.coordinates(&ring);
            match polygons.last_mut().filter(|_| ring.hole.is_some()) {
                Some(polygon) => polygon.push(coordinates),
                None => polygons.push(vec![coordinates]),
            }
        }
        let geometry = match <[Vec<Value>; 1]>::try_from(polygons) {
            Ok([polygon]) => json!({"type": "Polygon", "coordinates": polygon}),
            Err(polygons) => json!({"type": "MultiPolygon", "coordinates": polygons}),
        };
        json!({"type": "Feature", "properties": properties(zone), "geometry": geometry})
    }

    fn coordinates(&self, ring: &Ring<'_>) -> Value {
        let position = |point: &_| {
            let position = self.frame().to_position(*point);
            json!([position.longitude.as_deg(), position.latitude.as_deg()])
        };
        ring.points.iter().map(position).collect()
    }
}

fn properties(zone: &Zone) -> Map<String, Value> {
    let mut properties = Map::new();
    let mut add = |key: &str, value: Value| properties.insert(key.to_owned(), value);
    add("name", zone.name().into());
    add("margin_m", zone.margin_m().into());
    match zone.kind() {
        Kind::KeepIn {
            depth,
            altitude_min_m,
            surfacing,
        } => {
            add("kind", "keep-in".into());
            add("depth_min_m", depth.min_m.into());
            add("depth_max_m", depth.max_m.into());
            add("altitude_min_m", altitude_min_m.into());
            add("surfacing", surfacing.into());
        }
        Kind::KeepOut { depth } => {
            add("kind", "keep-out".into());
            // An open end is infinite and is left out.
            if let Some(Band { min_m, max_m }) = depth {
                for (key, value) in [("depth_min_m", min_m), ("depth_max_m", max_m)] {
                    if value.is_finite() {
                        add(key, value.into());
                    }
                }
            }
        }
    }
    let window = zone.window();
    for (key, time) in [("valid_from", window.from), ("valid_until", window.until)] {
        if let Some(time) = time {
            add(key, crate::window::Rfc3339(time).to_string().into());
        }
    }
    properties
}

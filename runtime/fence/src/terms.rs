use serde_json::{Map, Value};

/// The form of a fence's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form<'a> {
    /// GeoJSON, as the crate's documentation describes it.
    GeoJson,
    /// A plan of QGroundControl. The terms give the values that it cannot have.
    Plan(&'a Terms),
    /// KML. The terms give the values that it does not have.
    Kml(&'a Terms),
}

/// Values for zones whose file cannot give them: plans of QGroundControl, and placemarks of KML without such data. The
/// ranges are those of the GeoJSON form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// The margin of all zones, metres.
    pub margin_m: f64,
    /// The shallowest depth of keep-in zones, metres.
    pub depth_min_m: f64,
    /// The deepest depth of keep-in zones, metres.
    pub depth_max_m: f64,
    /// The least altitude above the bottom in keep-in zones, metres.
    pub altitude_min_m: f64,
    /// Whether the vehicle may surface in keep-in zones.
    pub surfacing: bool,
}

impl Terms {
    /// Adds the values to a zone's properties. A keep-out zone takes only the margin, and forbids all depths.
    pub(crate) fn complete(&self, properties: &mut Map<String, Value>) {
        let keep_in = properties.get("kind").and_then(Value::as_str) == Some("keep-in");
        let mut add = |key: &str, value: Value| {
            properties.entry(key).or_insert(value);
        };
        add("margin_m", self.margin_m.into());
        if keep_in {
            add("depth_min_m", self.depth_min_m.into());
            add("depth_max_m", self.depth_max_m.into());
            add("altitude_min_m", self.altitude_min_m.into());
            add("surfacing", self.surfacing.into());
        }
    }
}

use core::fmt;

/// Why a fence was refused. Each text is one line, to which the caller adds the file's name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FenceError {
    /// The text is not JSON, or has a key twice.
    #[error("line {line} column {column}: {message}")]
    Json {
        /// Counted from 1.
        line: usize,
        /// Counted from 1.
        column: usize,
        /// The parser's message.
        message: String,
    },
    /// The text is not XML.
    #[error("line {line}: {message}, expected well-formed XML")]
    Xml {
        /// Counted from 1.
        line: usize,
        /// The fault.
        message: String,
    },
    /// The text is JSON, but does not have the form of GeoJSON.
    #[error("{place}: {found}, expected {expected}")]
    Form {
        /// The place in the document.
        place: String,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// An unknown key.
    #[error("{place}: unknown key `{key}`, expected {expected}")]
    UnknownKey {
        /// The place in the document.
        place: String,
        /// The key.
        key: String,
        /// The known keys.
        expected: &'static str,
    },
    /// A missing property.
    #[error("{feature}: `{key}` is missing, expected {expected}")]
    MissingKey {
        /// The feature.
        feature: String,
        /// The key.
        key: &'static str,
        /// What was expected.
        expected: &'static str,
    },
    /// A property whose value is not allowed.
    #[error("{feature}: `{key}` is {found}, expected {expected}")]
    BadValue {
        /// The feature.
        feature: String,
        /// The key.
        key: &'static str,
        /// The value, as JSON.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// Two features with one name.
    #[error("feature {second}: `name` is '{name}', the same as that of feature {first}, expected different names")]
    DuplicateName {
        /// The name.
        name: String,
        /// The first feature with the name, from 1.
        first: usize,
        /// The second feature with the name, from 1.
        second: usize,
    },
    /// A collection without features.
    #[error("no features, expected at least one keep-in zone")]
    Empty,
    /// There are only keep-out zones, so the vehicle could be nowhere.
    #[error("no keep-in zone among {features} features, expected at least one")]
    NoKeepIn {
        /// The number of features.
        features: usize,
    },
    /// Too many vertices, including those that divide long edges.
    #[error("{found} vertices up to here, expected at most {limit}")]
    TooManyVertices {
        /// How many vertices there are, or would be.
        found: usize,
        /// How many are accepted.
        limit: usize,
    },
    /// A vertex that is not a position, or is too near to a pole for the plane.
    #[error("{place} vertex {vertex}: {found}, expected {expected}")]
    Vertex {
        /// The ring, or the feature.
        place: String,
        /// The vertex, from 1.
        vertex: usize,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A keep-in corridor whose line turns so tightly that its sides would cross.
    #[error(
        "{feature}: turns too tightly at vertex {vertex} for its `half_width_m` of {half_width_m}, expected longer legs, a smaller width, or a polygon"
    )]
    TightTurn {
        /// The feature.
        feature: String,
        /// The vertex of its line, from 1.
        vertex: usize,
        /// Half of its width, metres.
        half_width_m: f64,
    },
    /// The last vertex is not the first.
    #[error("{place}: ring is open, vertex {last} differs from vertex 1, expected the first vertex again as the last")]
    OpenRing {
        /// The ring.
        place: Place,
        /// The last vertex, from 1.
        last: usize,
    },
    /// A ring with fewer than three distinct vertices.
    #[error("{place}: {found} distinct vertices, expected at least 3")]
    TooFewVertices {
        /// The ring.
        place: Place,
        /// How many there are.
        found: usize,
    },
    /// A ring whose vertices lie on one line.
    #[error("{place}: zero area, all vertices lie on one line, expected a ring that encloses an area")]
    ZeroArea {
        /// The ring.
        place: Place,
    },
    /// A corner so sharp that the ring runs back on itself.
    #[error(
        "{place}: ring runs back on itself at vertex {vertex} (latitude {latitude:.6} longitude {longitude:.6}), expected a corner of over 0.006 degrees"
    )]
    Spike {
        /// The ring.
        place: Place,
        /// The vertex, from 1.
        vertex: usize,
        /// The latitude, degrees.
        latitude: f64,
        /// The longitude, degrees.
        longitude: f64,
    },
    /// Two edges of a polygon that cross or come within a micrometre of each other.
    #[error(
        "{place}: edge {edge} crosses or touches {other}edge {other_edge} at latitude {latitude:.6} longitude {longitude:.6}, expected edges that meet at their shared vertices only"
    )]
    Crossing {
        /// The ring of the first edge.
        place: Place,
        /// The first edge: from this vertex to the next one.
        edge: usize,
        /// The ring of the second edge and a blank, if it is another ring of the same polygon; otherwise empty.
        other: String,
        /// The second edge.
        other_edge: usize,
        /// The latitude, degrees.
        latitude: f64,
        /// The longitude, degrees.
        longitude: f64,
    },
    /// A hole that is not inside its outer ring.
    #[error("{place}: hole lies outside its polygon, expected a hole inside the outer ring")]
    HoleOutside {
        /// The hole.
        place: Place,
    },
    /// A hole inside another hole.
    #[error("{place}: hole lies inside hole {outer}, expected holes apart from each other")]
    HoleInHole {
        /// The inner hole.
        place: Place,
        /// The hole around it, from 1.
        outer: usize,
    },
    /// A fence that spans the antimeridian, or more than half of the earth.
    #[error("{place}: crosses the antimeridian (longitudes {west} to {east}), expected a fence on one side of it")]
    Antimeridian {
        /// The feature, or the collection.
        place: String,
        /// The lowest longitude, degrees.
        west: f64,
        /// The highest longitude, degrees.
        east: f64,
    },
    /// A fence that is too wide for one plane.
    #[error("{place}: the fence is {across_km:.1} km across, expected at most {limit_km} km, and this is farthest out")]
    TooWide {
        /// The vertex or feature that is farthest from the middle of all.
        place: String,
        /// The greater side of the fence, from west to east or from south to north.
        across_km: f64,
        /// The greatest side that is accepted.
        limit_km: f64,
    },
    /// A keep-in zone that lies wholly inside a keep-out zone which counts at all its depths and times: two zones that
    /// were mistaken for each other, or one that was drawn too large.
    #[error("{place}: lies wholly inside keep-out zone '{keep_out}', expected a part that the vehicle can reach")]
    Excluded {
        /// The outer ring of the keep-in zone's polygon.
        place: Place,
        /// The name of the keep-out zone.
        keep_out: String,
    },
    /// A keep-in zone in which no point keeps the margin.
    #[error("{place}: `margin_m` of {margin_m} leaves nothing inside, expected under {:.3}, half of its width", width_m / 2.0)]
    NothingReachable {
        /// The polygon's outer ring.
        place: Place,
        /// The margin.
        margin_m: f64,
        /// An upper bound of the diameter of the widest circle inside, metres.
        width_m: f64,
    },
    /// A fault whose text does not say where it is.
    #[error("{feature}: {fault}")]
    Within {
        /// The feature.
        feature: String,
        /// The fault.
        fault: Box<Self>,
    },
}

/// A ring of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The feature's name, or its number if it has none.
    pub feature: String,
    /// Which polygon, from 1; `None` for the single one of a `Polygon`.
    pub polygon: Option<usize>,
    /// Which hole, from 1; `None` for the outer ring.
    pub hole: Option<usize>,
}

impl Place {
    /// The name of the ring in its polygon: `outer ring`, `hole 2`.
    #[must_use]
    pub fn ring(&self) -> String {
        self.hole
            .map_or_else(|| "outer ring".to_owned(), |hole| format!("hole {hole}"))
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.feature)?;
        if let Some(polygon) = self.polygon {
            write!(f, " polygon {polygon}")?;
        }
        write!(f, " {}", self.ring())
    }
}

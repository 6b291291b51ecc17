use serde::Deserialize;

/// One `[[plan]]`: an element of the front seat's plan as it is written. Which keys it needs depends on its kind;
/// the others must be absent.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanEntry {
    /// What is flown.
    pub kind: PlanKind,
    /// `waypoint`: where to.
    pub at: Option<PlaceConfig>,
    /// `trackline`: from where.
    pub start: Option<PlaceConfig>,
    /// `trackline`: to where.
    pub end: Option<PlaceConfig>,
    /// `trackcircle`: around what.
    pub centre: Option<PlaceConfig>,
    /// `trackcircle`: metres, 5 to 20000.
    pub radius_m: Option<f64>,
    /// `trackcircle`: how often round, positive clockwise, 0.01 to 1000 either way.
    pub orbits: Option<f64>,
    /// `trackcircle`: the point of the circle where it begins, degrees clockwise from the frame's north as seen from
    /// the centre; the nearest where it is absent.
    pub entry_angle_deg: Option<f64>,
    /// `setpoint`: degrees from true north.
    pub heading_deg: Option<f64>,
    /// `setpoint`: seconds, 1 to 1e6.
    pub duration_s: Option<f64>,
    /// Depth, metres. Every element has this or `altitude_m`.
    pub depth_m: Option<f64>,
    /// Height above the seabed, metres.
    pub altitude_m: Option<f64>,
    /// Speed through the water, metres a second.
    pub speed_mps: f64,
    /// Whether dynamic requests are allowed while this is the current planned element (`allowDynamicRequests`).
    #[serde(default)]
    pub dynamic: bool,
    /// Where dynamic: they are allowed only from so many seconds after the element's begin.
    pub dynamic_from_s: Option<f64>,
    /// Where dynamic: they are allowed only for so many seconds.
    pub dynamic_for_s: Option<f64>,
    /// The element ends where it takes longer, seconds, 1 to 1e6.
    pub timeout_s: Option<f64>,
}

/// What an element flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlanKind {
    /// Straight to a point.
    Waypoint,
    /// To a line's start, then along it.
    Trackline,
    /// A heading for a time.
    Setpoint,
    /// To a circle, then around it.
    Trackcircle,
}

/// A place: `{ east_m, north_m }` in the world's frame, or `{ latitude_deg, longitude_deg }`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceConfig {
    /// Metres east of the origin.
    pub east_m: Option<f64>,
    /// Metres north of the origin.
    pub north_m: Option<f64>,
    /// WGS84 latitude, degrees.
    pub latitude_deg: Option<f64>,
    /// WGS84 longitude, degrees.
    pub longitude_deg: Option<f64>,
}

use serde::Deserialize;

/// One `[[plan]]`: an element of the front seat's plan as it is written. Which keys it needs depends on its kind;
/// the others must be absent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
    /// `trackline`: length of the lead-in before and of the lead-out after the line, metres, 0 to 500; 0 where absent.
    pub lead_in_m: Option<f64>,
    /// `trackline`: the payload logs here. BFBDL with this text where the lead-in begins (SPI 5.3), BFSDL after the
    /// lead-out (SPI 5.4).
    pub payload_message: Option<String>,
    /// `trackline`, `trackcircle`: the way to its begin is a behavior of its own, a waypoint, and has a number of its
    /// own in the dive file. BPRCB ends one behavior, BPRCE the element with both (SPI 7.10, 7.11).
    #[serde(default)]
    pub separate_transit: bool,
    /// `command`: what BFMSC says (SPI 5.1).
    pub text: Option<String>,
    /// `command`, or a `trackline` with a `payload_message`: the role of the client that is told (SPI 4.1); every
    /// client where it is absent.
    pub role: Option<String>,
    /// Depth, metres. Every element but a command has this or `altitude_m`.
    pub depth_m: Option<f64>,
    /// Height above the seabed, metres.
    pub altitude_m: Option<f64>,
    /// Speed through the water, metres a second. Every element but a command has it.
    pub speed_mps: Option<f64>,
    /// Whether dynamic requests are allowed while this is the current planned element (`allowDynamicRequests`).
    #[serde(default)]
    pub dynamic: bool,
    /// Where dynamic: they are allowed only from so many seconds after the element's begin.
    pub dynamic_from_s: Option<f64>,
    /// Where dynamic: they are allowed only for so many seconds.
    pub dynamic_for_s: Option<f64>,
    /// Each behavior of the element ends where it takes longer, seconds, 1 to 1e6.
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
    /// A user-defined behavior: a text to the payload (SPI 5.1), and at once the next element.
    Command,
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

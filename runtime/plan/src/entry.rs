use serde::Deserialize;

/// One `[[plan]]` table: an element of the front seat's plan. Its kind decides which keys it needs; other keys are
/// refused.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanEntry {
    /// The kind of element.
    pub kind: PlanKind,
    /// `waypoint`: the destination.
    pub at: Option<PlaceConfig>,
    /// `trackline`: the start.
    pub start: Option<PlaceConfig>,
    /// `trackline`: the end.
    pub end: Option<PlaceConfig>,
    /// `trackcircle`: the centre.
    pub centre: Option<PlaceConfig>,
    /// `trackcircle`: the radius, metres, 5 to 20000.
    pub radius_m: Option<f64>,
    /// `trackcircle`: the number of rounds, positive clockwise, 0.01 to 1000 in either direction.
    pub orbits: Option<f64>,
    /// `trackcircle`: the point of the circle where the vehicle begins, degrees clockwise from the frame's north as
    /// seen from the centre; the nearest point if missing.
    pub entry_angle_deg: Option<f64>,
    /// `setpoint`: the heading, degrees from true north.
    pub heading_deg: Option<f64>,
    /// `setpoint`: the duration, seconds, 1 to 1e6.
    pub duration_s: Option<f64>,
    /// `trackline`: length of the lead-in before and of the lead-out after the line, metres, 0 to 500; 0 if missing.
    pub lead_in_m: Option<f64>,
    /// `trackline`, `trackcircle`: the text of BFBDL where the lead-in or the circle begins (SPI 5.3), and of BFSDL
    /// after the lead-out or the circle (SPI 5.4); an empty one if missing.
    pub payload_message: Option<String>,
    /// `trackline`, `trackcircle`: the way to its beginning is a separate behavior, a waypoint, with its own number in
    /// the dive file. BPRCB ends one behavior, BPRCE the element with both (SPI 7.10, 7.11).
    #[serde(default)]
    pub separate_transit: bool,
    /// `command`: the text that BFMSC carries (SPI 5.1).
    pub text: Option<String>,
    /// `command`, or any element with a `payload_message`: the role of the client that receives the text (SPI 4.1);
    /// every client if missing.
    pub role: Option<String>,
    /// Depth, metres. Every element except a command has this or `altitude_m`.
    pub depth_m: Option<f64>,
    /// Altitude above the seabed, metres.
    pub altitude_m: Option<f64>,
    /// Speed through the water, metres a second. Every element except a command has it. For a setpoint it may be 0:
    /// then the vehicle stops, and one that does not hover floats up slowly.
    pub speed_mps: Option<f64>,
    /// Whether dynamic requests are allowed while this is the current planned element (`allowDynamicRequests`).
    #[serde(default)]
    pub dynamic: bool,
    /// With `dynamic`: requests are allowed only from this many seconds after the element's beginning.
    pub dynamic_from_s: Option<f64>,
    /// With `dynamic`: requests are allowed only for this many seconds.
    pub dynamic_for_s: Option<f64>,
    /// Each behavior of the element ends after this time at the latest, seconds, 1 to 1e6.
    pub timeout_s: Option<f64>,
}

/// The kind of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlanKind {
    /// Straight to a point.
    Waypoint,
    /// To a line's start, then along it.
    Trackline,
    /// A heading for some time.
    Setpoint,
    /// To a circle, then around it.
    Trackcircle,
    /// A user-defined behavior: sends a text to the payload (SPI 5.1) and goes on to the next element at once.
    Command,
}

/// A position: `{ east_m, north_m }` in the world's frame, or `{ latitude_deg, longitude_deg }`.
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

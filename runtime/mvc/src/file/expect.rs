use serde::Deserialize;

/// The `[expect]` section: what a run must fulfil to count as passed. The mock carries it and does not judge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expectations {
    /// At most so many violations; none where it is left away.
    pub max_violations: Option<u32>,
    /// At least so many requests accepted.
    pub min_accepted: Option<u32>,
    /// Whether the mission must have completed.
    pub mission_completed: Option<bool>,
    /// A depth contour that a plugin must follow.
    pub contour: Option<ContourExpectation>,
    /// A field whose maximum a plugin must circle.
    pub maximum: Option<MaximumExpectation>,
}

/// The `[expect.contour]` section: horizontal distance of the vehicle's true way, while a plugin modifies it, from the
/// true contour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContourExpectation {
    /// The contour's water depth, metres.
    pub water_depth_m: f64,
    /// It counts as acquired when the distance is first below this, metres.
    pub acquired_m: f64,
    /// How long after the first modify that may be, seconds.
    pub acquired_within_s: f64,
    /// Root mean square of the distance from then on, metres.
    pub rms_m: f64,
    /// For how long it must be followed in all, seconds.
    pub followed_for_s: f64,
}

/// The `[expect.maximum]` section: distance of the last trackcircle's centre from the field's true maximum.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaximumExpectation {
    /// At most this, metres.
    pub within_m: f64,
}

use serde::Deserialize;

/// The `[expect]` section: what a run must achieve. The mock only carries it and does not judge the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Expectations {
    /// How many violations the run may have; `None` allows none.
    pub max_violations: Option<u32>,
    /// How many requests the vehicle must have accepted at least.
    pub min_accepted: Option<u32>,
    /// Whether the mission must have been completed (true) or must not (false); `None` allows both.
    pub mission_completed: Option<bool>,
    /// A depth contour that a plugin must follow.
    pub contour: Option<ContourExpectation>,
    /// A maximum that a plugin must find.
    pub maximum: Option<MaximumExpectation>,
}

/// The `[expect.contour]` section: how near the vehicle's true track is to the true contour, horizontally, while a
/// plugin modifies what the vehicle flies.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContourExpectation {
    /// The depth of the water along the contour, metres.
    pub water_depth_m: f64,
    /// Once the distance is less than this, the contour counts as acquired, metres.
    pub acquired_m: f64,
    /// How long that may take, counted from the first modify, seconds.
    pub acquired_within_s: f64,
    /// The greatest root mean square of the distance from then on, metres.
    pub rms_m: f64,
    /// How long the vehicle must follow the contour in all, seconds.
    pub followed_for_s: f64,
}

/// The `[expect.maximum]` section: how near the centre of the last trackcircle is to the field's true maximum.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaximumExpectation {
    /// The greatest distance, metres.
    pub within_m: f64,
}

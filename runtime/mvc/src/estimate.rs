use backseat_units::EastNorth;

/// What the vehicle believes of itself: the solution that its executive steers by and its navigation messages tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Estimate {
    /// In the world's frame, metres.
    pub(crate) at: EastNorth,
    /// Metres, positive down.
    pub(crate) depth_m: f64,
    /// Degrees from the frame's north.
    pub(crate) heading_deg: f64,
    /// Speed through the water, metres a second.
    pub(crate) surge_mps: f64,
    /// Velocity of the water, metres a second east and north.
    pub(crate) current: (f64, f64),
    /// What its headings are wrong by, degrees.
    pub(crate) heading_bias_deg: f64,
    /// The way of the last step as the log and the inertial system know it, by the vehicle's true heading.
    pub(crate) way: EastNorth,
}

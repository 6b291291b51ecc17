use backseat_units::EastNorth;

/// What the vehicle believes about itself: the solution by which its executive steers and which its navigation messages
/// report.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Estimate {
    /// Position in the world's frame, metres.
    pub(crate) at: EastNorth,
    /// Depth, metres.
    pub(crate) depth_m: f64,
    /// Heading, degrees from the frame's north.
    pub(crate) heading_deg: f64,
    /// Speed through the water, metres a second.
    pub(crate) surge_mps: f64,
    /// Velocity of the water, metres a second east and north.
    pub(crate) current: (f64, f64),
    /// The error of its headings, degrees.
    pub(crate) heading_bias_deg: f64,
    /// The movement in the last step, without the heading's error: as the Doppler log and the inertial system measure
    /// it along the vehicle's own axes.
    pub(crate) way: EastNorth,
    /// Distance from the inspected side of the ship, metres, if the DVL is turned to it and measures it.
    pub(crate) ship_m: Option<f64>,
}

use backseat_units::EastNorth;

use crate::error::{AcousticsError, within};

/// Where a sonar is at the moment of a ping, and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Its place in the world's frame, within 1000 km of the origin.
    pub at: EastNorth,
    /// Its depth below the surface, metres, within ±12000. Above the surface (negative) a sonar hears noise alone.
    pub depth_m: f64,
    /// Its altitude above the seabed, metres, within ±12000. The world gives the shape of the seabed, and this gives its
    /// height: so the tide is in the altitude. At 0 and below, in the seabed, a sonar hears noise alone.
    pub altitude_m: f64,
    /// Its heading, degrees clockwise from the frame's north, within ±3600.
    pub heading_deg: f64,
    /// Its pitch, degrees within ±180: positive with the bow up.
    pub pitch_deg: f64,
    /// Its roll, degrees within ±180: positive with the starboard side down.
    pub roll_deg: f64,
}

impl Pose {
    /// Checks the ranges of all fields, and that all are numbers.
    ///
    /// # Errors
    /// [`AcousticsError`] with the first field that is out of its range.
    pub fn check(&self) -> Result<(), AcousticsError> {
        let near = "within 1000 km of the origin";
        within(self.at.east_m, -1e6, 1e6, "pose.at.east_m", near)?;
        within(self.at.north_m, -1e6, 1e6, "pose.at.north_m", near)?;
        let height = "-12000 to 12000 m";
        within(self.depth_m, -12_000.0, 12_000.0, "pose.depth_m", height)?;
        within(self.altitude_m, -12_000.0, 12_000.0, "pose.altitude_m", height)?;
        let turn = "-3600 to 3600 degrees";
        within(self.heading_deg, -3600.0, 3600.0, "pose.heading_deg", turn)?;
        let tilt = "-180 to 180 degrees";
        within(self.pitch_deg, -180.0, 180.0, "pose.pitch_deg", tilt)?;
        within(self.roll_deg, -180.0, 180.0, "pose.roll_deg", tilt)
    }

    /// Whether there is water around the sonar.
    pub(crate) fn is_in_water(&self) -> bool {
        self.depth_m >= 0.0 && self.altitude_m > 0.0
    }
}

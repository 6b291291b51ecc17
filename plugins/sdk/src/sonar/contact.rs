use backseat_units::EastNorth;
use serde::{Deserialize, Serialize};

use super::look::Side;

/// A highlight followed by a shadow in the average of the last pings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    /// The side on which it is.
    pub side: Side,
    /// Where the highlight is, in the mission's local frame.
    pub at: EastNorth,
    /// Where the sonar was in the middle of the pings that show it.
    pub from: EastNorth,
    /// Ground range of the highlight, metres.
    pub ground_m: f64,
    /// Length of the highlight over the ground, metres.
    pub highlight_m: f64,
    /// Slant range of the shadow's begin, metres.
    pub shadow_slant_m: f64,
    /// Length of the shadow along the slant range, metres.
    pub shadow_m: f64,
    /// The shadow reaches the end of what the sonar sees, so it is longer than it looks.
    pub cut: bool,
    /// The height that follows from the shadow, metres.
    pub height_m: f64,
    /// How much brighter the highlight is than the seabed on its near side, as a ratio of intensities.
    pub brighter: f64,
    /// How much darker the shadow is, as a ratio of intensities, 0 to 1.
    pub darker: f64,
    /// The logarithm of the generalised likelihood ratio of this against an even seabed: the more, the clearer.
    pub score: f64,
}

impl Hit {
    /// The direction from which the sonar saw it, degrees: from the highlight to the sonar.
    #[must_use]
    pub fn aspect_deg(&self) -> f64 {
        self.at.bearing_deg(self.from)
    }
}

/// An object on the seabed, as successive pings of one line show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The side of the vehicle on which it is.
    pub side: Side,
    /// Where it is, in the mission's local frame: the mean of its highlights, by score.
    pub at: EastNorth,
    /// The same on the globe, degrees north.
    pub latitude_deg: f64,
    /// Degrees east.
    pub longitude_deg: f64,
    /// Where the sonar was when it showed best.
    pub from: EastNorth,
    /// Mean ground range of its highlights, metres.
    pub ground_m: f64,
    /// Slant range to where its shadow begins, metres: the median.
    pub slant_m: f64,
    /// Length of its highlight over the ground, metres: the median.
    pub highlight_m: f64,
    /// Length of its shadow along the slant range, metres: the median.
    pub shadow_m: f64,
    /// Its height by its shadow, metres: the median. A lower bound if the shadow is cut.
    pub height_m: f64,
    /// In most pings the shadow reaches the end of what the sonar sees.
    pub cut: bool,
    /// Its length along the track, metres: the way of the sonar while it was in view, less that over which pings are
    /// averaged, at least one ping. The beam's width is in it.
    pub length_m: f64,
    /// How many pings show it.
    pub pings: u16,
    /// The greatest score of a ping.
    pub score: f64,
}

impl Contact {
    /// The direction from which the sonar saw it, degrees: from the contact to the sonar.
    #[must_use]
    pub fn aspect_deg(&self) -> f64 {
        self.at.bearing_deg(self.from)
    }
}

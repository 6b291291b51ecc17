//! The lines along which the vehicle flies an insert.

use backseat_units::EastNorth;

use super::{Envelope, Insert, InsertPath};

impl Envelope {
    /// The line of a trackline as it was given, without leads.
    pub(crate) fn line_without_leads(&self, insert: &Insert) -> Option<(EastNorth, EastNorth)> {
        let frame = self.fence.frame();
        match insert.path {
            InsertPath::Line { start, end, .. } => Some((frame.to_local(start), frame.to_local(end))),
            InsertPath::Surface { .. } | InsertPath::Circle { .. } => None,
        }
    }

    /// The two points between which an insert's path begins, if the vehicle began the insert at `begun`. The length of
    /// a lead-in is not known. If a circle has no entry angle, the place where the vehicle enters it is not known
    /// either.
    pub(crate) fn path_begins(&self, insert: &Insert, begun: EastNorth) -> [EastNorth; 2] {
        let frame = self.fence.frame();
        match insert.path {
            InsertPath::Line { start, end, .. } => {
                let (start, end) = (frame.to_local(start), frame.to_local(end));
                [self.with_leads(start, end).0, start]
            }
            InsertPath::Circle {
                centre,
                radius_m,
                entry_angle_deg: None,
                ..
            } => {
                let centre = frame.to_local(centre);
                let bearing_deg = begun.bearing_deg(centre);
                let away_m = begun.distance_m(centre);
                // Inside a circle, or so near to it that the error of navigation does not exclude that, the way may
                // lead in any direction. So `begun` lies between the two points.
                if away_m <= radius_m + self.limits.navigation_error_m {
                    return [2.0 * radius_m, -2.0 * radius_m].map(|off_m| begun.offset(bearing_deg, off_m));
                }
                // Abeam of the centre, on the two tangents from `begun` to the circle.
                let radius_m = radius_m * away_m / (away_m * away_m - radius_m * radius_m).sqrt();
                let across_deg = bearing_deg + 90.0;
                [radius_m, -radius_m].map(|off_m| centre.offset(across_deg, off_m))
            }
            InsertPath::Circle { .. } | InsertPath::Surface { .. } => [self.ends(insert).0.middle(); 2],
        }
    }

    /// The lines around everything that the vehicle flies of an insert: the line itself with its longest leads, or the
    /// sides of the square around a circle or around the area in which the vehicle drifts.
    pub(crate) fn legs(&self, insert: &Insert) -> Vec<(EastNorth, EastNorth)> {
        let (centre, radius_m) = match insert.path {
            InsertPath::Line { start, end, .. } => {
                let frame = self.fence.frame();
                return vec![self.with_leads(frame.to_local(start), frame.to_local(end))];
            }
            InsertPath::Circle { centre, radius_m, .. } => (centre, radius_m),
            InsertPath::Surface { at } => (at, self.drift_m()),
        };
        let centre = self.fence.frame().to_local(centre);
        let corner = |east, north| centre + EastNorth::new(east, north) * radius_m;
        let corners = [
            corner(-1.0, -1.0),
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
        ];
        (0..4).map(|side| (corners[side], corners[(side + 1) % 4])).collect()
    }
}

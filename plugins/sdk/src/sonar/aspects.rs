use backseat_units::EastNorth;
use backseat_units::math::{sin_cos, wrap_360};
use serde::{Deserialize, Serialize};

use super::contact::Hit;
use super::look::Pose;

/// How many heights of a sector are kept.
const KEPT: usize = 32;

/// The directions between two bearings, and what the sonar saw from there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sector {
    /// How many pings had the place in the beam, as far as it is known.
    pub looks: u32,
    /// How many of them showed a highlight with a shadow there.
    pub hits: u32,
    heights_m: Vec<f32>,
}

/// What a place showed from all directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// From how many sectors the sonar looked at it.
    pub looked: u32,
    /// From how many of them it showed an object.
    pub seen: u32,
    /// Height of the object, metres: the median of the sectors' medians; 0 if none saw it.
    pub height_m: f64,
    /// Where the object is: the mean of its highlights, in the mission's local frame.
    pub at: EastNorth,
}

/// Counts from how many directions a place shows an object, while the vehicle flies around it.
///
/// An object stands out from every side, and its shadow always points away from the sonar. Speckle does not repeat, and
/// what only looks like an object from one side (a ripple's crest, the edge of a patch) does not from others. That
/// several aspects decide is the method of Zerr, Bovio and Stage 2001 ("Automatic mine classification approach based on
/// AUV manoeuverability and COTS side scan sonar", *Proceedings of the GOATS 2000 Conference*, SACLANTCEN).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aspects {
    at: EastNorth,
    tolerance_m: f64,
    sectors: Vec<Sector>,
    place: EastNorth,
    hits: u32,
}

impl Aspects {
    /// For an object at a place; `tolerance_m` is how far off its known place may be. The circle is divided into
    /// `sectors` equal sectors, from north clockwise.
    #[must_use]
    pub fn new(at: EastNorth, tolerance_m: f64, sectors: usize) -> Self {
        Self {
            at,
            tolerance_m,
            sectors: vec![Sector::default(); sectors.max(1)],
            place: EastNorth::default(),
            hits: 0,
        }
    }

    /// Takes a ping: where the sonar was, and what [`Detector::hits`](super::Detector::hits) says after it. The place
    /// counts as looked at if it is abeam, within the tolerance along the track, at a ground range between `nearest_m` and
    /// `farthest_m`.
    pub fn look(&mut self, pose: &Pose, hits: &[Hit], nearest_m: f64, farthest_m: f64) {
        let to = self.at - pose.at;
        let (sin, cos) = sin_cos(pose.heading_deg.to_radians());
        let ahead_m = to.east_m * sin + to.north_m * cos;
        let abeam_m = (to.east_m * cos - to.north_m * sin).abs();
        let is_abeam = ahead_m.abs() <= self.tolerance_m && (nearest_m..=farthest_m).contains(&abeam_m);
        if is_abeam {
            let sector = self.sector(self.at.bearing_deg(pose.at));
            self.sectors[sector].looks += 1;
        }
        let near = hits
            .iter()
            .filter(|hit| hit.at.distance_m(self.at) <= self.tolerance_m)
            .max_by(|one, other| one.score.total_cmp(&other.score));
        if let Some(hit) = near {
            let sector = self.sector(hit.aspect_deg());
            let sector = &mut self.sectors[sector];
            sector.hits += 1;
            if sector.heights_m.len() < KEPT {
                sector.heights_m.push(hit.height_m as f32);
            }
            self.place = self.place + hit.at;
            self.hits += 1;
        }
    }

    fn sector(&self, bearing_deg: f64) -> usize {
        let count = self.sectors.len();
        ((wrap_360(bearing_deg) / 360.0 * count as f64) as usize).min(count - 1)
    }

    /// The sectors, from north clockwise.
    #[must_use]
    pub fn sectors(&self) -> &[Sector] {
        &self.sectors
    }

    /// What the sectors say so far. A sector counts as looked at, or as one that saw the object, from `least` pings on.
    #[must_use]
    pub fn verdict(&self, least: u32) -> Verdict {
        let mut heights_m: Vec<f32> = Vec::new();
        let (mut looked, mut seen) = (0, 0);
        for sector in &self.sectors {
            looked += u32::from(sector.looks >= least || sector.hits >= least);
            if sector.hits >= least {
                seen += 1;
                heights_m.extend(median(&sector.heights_m));
            }
        }
        Verdict {
            looked,
            seen,
            height_m: median(&heights_m).map_or(0.0, f64::from),
            at: if self.hits == 0 {
                self.at
            } else {
                self.place * (1.0 / f64::from(self.hits))
            },
        }
    }
}

fn median(values: &[f32]) -> Option<f32> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sonar::Side;

    fn pose(bearing_deg: f64, radius_m: f64) -> Pose {
        Pose {
            at: EastNorth::new(100.0, 50.0).offset(bearing_deg, radius_m),
            latitude_deg: 42.0,
            longitude_deg: -70.0,
            // Clockwise around the place: it is to starboard.
            heading_deg: bearing_deg + 90.0,
            altitude_m: Some(8.0),
        }
    }

    fn hit(pose: &Pose, at: EastNorth, height_m: f64) -> Hit {
        Hit {
            side: Side::Starboard,
            at,
            from: pose.at,
            ground_m: 30.0,
            highlight_m: 1.0,
            shadow_slant_m: 31.0,
            shadow_m: 4.0,
            cut: false,
            height_m,
            brighter: 9.0,
            darker: 0.1,
            score: 30.0,
        }
    }

    #[test]
    fn an_object_shows_from_every_side_and_a_chance_hit_from_one() {
        let place = EastNorth::new(100.0, 50.0);
        let mut object = Aspects::new(place + EastNorth::new(1.5, 0.0), 4.0, 8);
        let mut chance = object.clone();
        for step in 0..360 {
            let pose = pose(f64::from(step), 30.0);
            let hits = [
                hit(&pose, place, 1.2),
                hit(&pose, place + EastNorth::new(9.0, 0.0), 3.0),
            ];
            object.look(&pose, &hits, 5.0, 60.0);
            let once = if (40..44).contains(&step) {
                &hits[..1]
            } else {
                &hits[1..]
            };
            chance.look(&pose, once, 5.0, 60.0);
        }
        let verdict = object.verdict(4);
        assert_eq!((verdict.looked, verdict.seen), (8, 8));
        assert!((verdict.height_m - 1.2).abs() < 1e-6 && verdict.at.distance_m(place) < 1e-6);
        let verdict = chance.verdict(4);
        assert!(verdict.looked == 8 && verdict.seen <= 1, "{verdict:?}");
    }

    #[test]
    fn a_place_out_of_the_swath_is_not_looked_at() {
        let mut aspects = Aspects::new(EastNorth::new(100.0, 50.0), 4.0, 8);
        for step in 0..360 {
            aspects.look(&pose(f64::from(step), 30.0), &[], 5.0, 25.0);
        }
        assert_eq!(aspects.verdict(1).looked, 0);
    }
}

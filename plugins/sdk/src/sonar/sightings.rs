use backseat_units::EastNorth;
use backseat_units::math::wrap_180;
use serde::{Deserialize, Serialize};

use super::contact::Contact;

/// Two sightings are of different lines if the sonar's places are farther apart than this, metres, or the directions
/// differ by more than [`TURNED_DEG`].
const APART_M: f64 = 20.0;
const TURNED_DEG: f64 = 20.0;
/// How many lines are told apart.
const VIEWS_MAX: usize = 16;

/// An object that one or several lines have shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sighted {
    /// Its number, from 1, which stays.
    pub number: u32,
    /// Where it is, in the mission's local frame: the mean of its sightings, by score.
    pub at: EastNorth,
    /// The same on the globe, degrees north.
    pub latitude_deg: f64,
    /// Degrees east.
    pub longitude_deg: f64,
    /// Its height, metres: the mean of its sightings, by score.
    pub height_m: f64,
    /// Its length along the track, metres: that of its longest sighting.
    pub length_m: f64,
    /// The length of its highlight across the track, metres: that of its longest sighting.
    pub highlight_m: f64,
    /// How many contacts are in it.
    pub sightings: u32,
    /// The sum of their scores.
    pub score: f64,
    /// From where each line saw it: direction to the sonar, degrees, and the sonar's place.
    views: Vec<(f64, EastNorth)>,
}

impl Sighted {
    fn new(number: u32, contact: &Contact) -> Self {
        Self {
            number,
            at: contact.at,
            latitude_deg: contact.latitude_deg,
            longitude_deg: contact.longitude_deg,
            height_m: contact.height_m,
            length_m: contact.length_m,
            highlight_m: contact.highlight_m,
            sightings: 1,
            score: contact.score,
            views: vec![(contact.aspect_deg(), contact.from)],
        }
    }

    /// How many lines have shown it, at most 16.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.views.len()
    }

    fn merge(&mut self, contact: &Contact) {
        let part = contact.score / (self.score + contact.score).max(1e-9);
        let towards = |from: f64, to: f64| from + part * (to - from);
        self.at = self.at + (contact.at - self.at) * part;
        self.latitude_deg = towards(self.latitude_deg, contact.latitude_deg);
        self.longitude_deg += part * wrap_180(contact.longitude_deg - self.longitude_deg);
        self.height_m = towards(self.height_m, contact.height_m);
        self.length_m = self.length_m.max(contact.length_m);
        self.highlight_m = self.highlight_m.max(contact.highlight_m);
        self.sightings = self.sightings.saturating_add(1);
        self.score += contact.score;
        let aspect_deg = contact.aspect_deg();
        let is_known = self.views.iter().any(|(deg, from)| {
            wrap_180(deg - aspect_deg).abs() <= TURNED_DEG && from.distance_m(contact.from) <= APART_M
        });
        if !is_known && self.views.len() < VIEWS_MAX {
            self.views.push((aspect_deg, contact.from));
        }
    }
}

/// Merges contacts at the same place, as far as navigation tells places apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sightings {
    error_m: f64,
    most: usize,
    objects: Vec<Sighted>,
    made: u32,
    dropped: u32,
}

impl Sightings {
    /// `error_m` is how far two sightings of the same object may be apart by the error of navigation and of the
    /// detector, metres; half of the object's length is added. At most `most` objects are kept.
    #[must_use]
    pub const fn new(error_m: f64, most: usize) -> Self {
        Self {
            error_m,
            most,
            objects: Vec::new(),
            made: 0,
            dropped: 0,
        }
    }

    /// Takes a contact. Returns the object that it belongs to: the nearest one within reach, or a new one. If there are
    /// too many, the object with the least score gives way, or the contact if its score is less.
    pub fn add(&mut self, contact: &Contact) -> Option<&Sighted> {
        let nearest = self
            .objects
            .iter()
            .enumerate()
            .map(|(index, object)| {
                let reach_m = self.error_m + 0.5 * object.length_m.max(contact.length_m);
                (index, object.at.distance_m(contact.at), reach_m)
            })
            .filter(|(_, off_m, reach_m)| off_m <= reach_m)
            .min_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((index, _, _)) = nearest {
            self.objects[index].merge(contact);
            return self.objects.get(index);
        }
        if self.objects.len() >= self.most {
            self.dropped = self.dropped.saturating_add(1);
            let least = (0..self.objects.len())
                .min_by(|one, other| self.objects[*one].score.total_cmp(&self.objects[*other].score))
                .filter(|index| self.objects[*index].score < contact.score)?;
            self.objects.remove(least);
        }
        self.made += 1;
        self.objects.push(Sighted::new(self.made, contact));
        self.objects.last()
    }

    /// All objects, oldest first.
    #[must_use]
    pub fn objects(&self) -> &[Sighted] {
        &self.objects
    }

    /// How many objects or contacts were given up because there were too many.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sonar::Side;

    fn contact(at: EastNorth, from: EastNorth, score: f64) -> Contact {
        Contact {
            side: Side::Port,
            at,
            latitude_deg: 42.0 + at.north_m / 111_000.0,
            longitude_deg: -70.0,
            from,
            ground_m: 30.0,
            slant_m: 31.0,
            highlight_m: 1.0,
            shadow_m: 3.0,
            height_m: 1.0,
            cut: false,
            length_m: 2.0,
            pings: 10,
            score,
        }
    }

    #[test]
    fn two_lines_show_one_object() {
        let mut sightings = Sightings::new(4.0, 10);
        sightings.add(&contact(EastNorth::new(0.0, 0.0), EastNorth::new(30.0, 0.0), 30.0));
        // A second piece of the same line, and the same object from the other side.
        sightings.add(&contact(EastNorth::new(0.0, 2.0), EastNorth::new(30.0, 2.0), 30.0));
        let object = sightings
            .add(&contact(EastNorth::new(0.0, 4.0), EastNorth::new(-30.0, 3.0), 60.0))
            .unwrap()
            .clone();
        assert_eq!((object.number, object.sightings, object.lines()), (1, 3, 2));
        assert!((object.at.north_m - 2.5).abs() < 1e-9, "{object:?}");
        let other = sightings
            .add(&contact(EastNorth::new(0.0, 12.0), EastNorth::new(30.0, 12.0), 5.0))
            .unwrap();
        assert_eq!(other.number, 2);
    }

    proptest! {
        #[test]
        fn no_more_objects_are_kept_than_allowed_and_the_clearest_stay(
            places in prop::collection::vec((-500.0..500.0_f64, -500.0..500.0_f64, 1.0..100.0_f64), 1..60),
        ) {
            let mut sightings = Sightings::new(3.0, 7);
            for (east, north, score) in &places {
                sightings.add(&contact(EastNorth::new(*east, *north), EastNorth::new(0.0, 0.0), *score));
            }
            prop_assert!(sightings.objects().len() <= 7);
            let greatest = places.iter().map(|place| place.2).fold(0.0, f64::max);
            prop_assert!(sightings.objects().iter().any(|object| object.score >= greatest));
            let all: u32 = sightings.objects().iter().map(|object| object.sightings).sum();
            prop_assert!(sightings.dropped() > 0 || all as usize == places.len());
        }
    }
}

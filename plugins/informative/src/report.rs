use std::cmp::Ordering;

use backseat_sdk::measures;
use backseat_sdk::survey::{Circle, FieldMap};
use backseat_sdk::units::EastNorth;

use crate::settings::Settings;
use crate::survey::Survey;

/// The radius of the circle around the warmest place, metres.
const RADIUS_M: f64 = 20.0;
/// At how many places the map is looked at in a step.
const LOOKED: usize = 200;
/// How many places are published in a step, with four values each: a plugin may publish 64 values a second.
const PUBLISHED: usize = 12;

/// The warmest place of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Where it is.
    pub at: EastNorth,
    /// What temperature is expected there, degrees Celsius.
    pub mean_c: f64,
}

impl Found {
    /// One circle around it.
    #[must_use]
    pub const fn circle(&self) -> Circle {
        Circle {
            centre: self.at,
            radius_m: RADIUS_M,
            orbits: 1.0,
            entry_deg: None,
        }
    }

    /// Publishes it.
    pub fn publish(&self) {
        measures::publish("found_east", self.at.east_m, "m");
        measures::publish("found_north", self.at.north_m, "m");
        measures::publish("found", self.mean_c, "C");
    }
}

/// Looks for the warmest place of a map, some places a step.
#[derive(Clone, Debug)]
pub struct Peak {
    map: FieldMap,
    looked: usize,
    best: Option<Found>,
}

impl Peak {
    /// A search in a map.
    #[must_use]
    pub const fn new(map: FieldMap) -> Self {
        Self {
            map,
            looked: 0,
            best: None,
        }
    }

    /// Does a step's work: looks at the next of the places, and after the last one around the best of them, ever closer.
    /// `None` while it goes on.
    pub fn work(&mut self, settings: &Settings, places: &[EastNorth]) -> Option<Found> {
        let until = (self.looked + LOOKED).min(places.len());
        let now = places[self.looked..until].iter().map(|place| self.look(*place));
        self.best = self.best.into_iter().chain(now).max_by(warmer);
        self.looked = until;
        if until < places.len() {
            return None;
        }
        let mut best = self.best?;
        let mut step_m = 0.2 * settings.kernel.length_m;
        while step_m > 1.0 {
            let around = [0.0, 90.0, 180.0, 270.0].map(|bearing_deg| best.at.offset(bearing_deg, step_m));
            let inside = around.into_iter().filter(|at| settings.area.contains(*at, 0.0));
            let warmest = inside.map(|at| self.look(at)).max_by(warmer);
            match warmest.filter(|found| found.mean_c > best.mean_c) {
                Some(better) => best = better,
                None => step_m *= 0.5,
            }
        }
        Some(best)
    }

    fn look(&self, at: EastNorth) -> Found {
        Found {
            at,
            mean_c: self.map.mean_at(at),
        }
    }
}

fn warmer(one: &Found, other: &Found) -> Ordering {
    one.mean_c.total_cmp(&other.mean_c)
}

/// Publishes the next places of the map, and after the last one what the map says in all.
pub(crate) fn publish(settings: &Settings, survey: &mut Survey, map: &FieldMap, places: &[EastNorth]) {
    let until = (survey.published + PUBLISHED).min(places.len());
    let each_m2 = settings.area.length_m() * settings.area.width_m() / places.len() as f64;
    for place in &places[survey.published..until] {
        let known = map.at(*place);
        if known.mean > settings.warm_c {
            survey.warm_m2 += each_m2;
            survey.warm_variance += each_m2 * known.deviation * known.deviation;
        }
        measures::publish("map_east", place.east_m, "m");
        measures::publish("map_north", place.north_m, "m");
        measures::publish("map_mean", known.mean, "C");
        measures::publish("map_deviation", known.deviation, "C");
    }
    if until == places.len() && survey.published < until {
        measures::publish("warm_area", survey.warm_m2, "m2");
        if survey.warm_m2 > 0.0 {
            measures::publish("warm_deviation", (survey.warm_variance / survey.warm_m2).sqrt(), "C");
        }
        measures::publish("way", survey.flown_m(), "m");
    }
    survey.published = until;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::tests::settings;

    #[test]
    fn the_warmest_place_is_found_between_the_places_of_the_map() {
        let settings = settings();
        let mut process = settings.process().unwrap();
        let warm = EastNorth::new(107.0, -33.0);
        for (off_m, value) in [(0.0, 14.0), (60.0, 13.2), (120.0, 12.2), (240.0, 12.0)] {
            for bearing_deg in [0.0, 90.0, 180.0, 270.0] {
                process.add(warm.offset(bearing_deg, off_m), value);
            }
        }
        let mut peak = Peak::new(process.fit().unwrap());
        let places = settings.places();
        let found = (0..20).find_map(|_| peak.work(&settings, &places)).unwrap();
        assert!(found.at.distance_m(warm) < 3.0, "{found:?}");
        assert!((found.mean_c - 14.0).abs() < 0.05 && found.circle().centre == found.at);
        assert_eq!(Peak::new(process.fit().unwrap()).work(&settings, &[]), None);
    }
}

use backseat_sdk::units::math::wrap_360;
use serde::{Deserialize, Serialize};

/// How strongly a new measurement counts in the smoothed temperature: a time constant of some five samples.
const SMOOTHING: f64 = 0.2;
/// The water is warm or cold from so far beyond the mean of both, as a part of their difference.
const HYSTERESIS: f64 = 0.1;
/// Without a crossing the vehicle turns back when it is this many times `beyond_m` beyond where the front was.
const LOST: f64 = 4.0;

/// How the front is crossed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The direction along the front, degrees from north.
    pub along_deg: f64,
    /// The angle between the legs and that direction, degrees.
    pub cross_deg: f64,
    /// How far beyond the front the vehicle turns back, metres.
    pub beyond_m: f64,
    /// How far to each side of where it began the vehicle searches, metres.
    pub search_m: f64,
    /// Waters whose temperatures differ by less than this are the same water, degrees Celsius.
    pub contrast_min_c: f64,
    /// If false, the vehicle turns only at `search_m` to each side.
    pub adaptive: bool,
}

/// The coldest and the warmest water of a leg, degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Extremes {
    coldest_c: f64,
    warmest_c: f64,
}

impl Extremes {
    fn and(self, other: Self) -> Self {
        Self {
            coldest_c: self.coldest_c.min(other.coldest_c),
            warmest_c: self.warmest_c.max(other.warmest_c),
        }
    }
}

/// Decides on which side of the front the vehicle is, where the front is, and when to turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracker {
    /// 1 if the leg leads to starboard of the direction along the front, -1 if to port.
    side: f64,
    smooth_c: Option<f64>,
    leg: Option<Extremes>,
    before: Option<Extremes>,
    /// Whether the vehicle is in the warm water.
    warm: Option<bool>,
    /// Where the front was crossed last, metres to starboard of where the vehicle began.
    front_m: Option<f64>,
    /// Whether it was crossed on this leg.
    crossed: bool,
    crossings: u32,
}

impl Default for Tracker {
    fn default() -> Self {
        Self {
            side: 1.0,
            smooth_c: None,
            leg: None,
            before: None,
            warm: None,
            front_m: None,
            crossed: false,
            crossings: 0,
        }
    }
}

impl Tracker {
    /// How often the front was crossed.
    #[must_use]
    pub const fn crossings(&self) -> u32 {
        self.crossings
    }

    /// Where the front was crossed last, metres to starboard of where the vehicle began.
    #[must_use]
    pub const fn front_m(&self) -> Option<f64> {
        self.front_m
    }

    /// The heading of the leg, degrees from north, in [0, 360).
    #[must_use]
    pub fn heading_deg(&self, settings: &Settings) -> f64 {
        wrap_360(settings.along_deg + self.side * settings.cross_deg)
    }

    /// Takes in a measurement. A temperature that is not finite is left out.
    pub fn measure(&mut self, settings: &Settings, across_m: f64, temperature_c: f64) {
        if !temperature_c.is_finite() {
            return;
        }
        let before_c = self.smooth_c.unwrap_or(temperature_c);
        let smooth_c = before_c + SMOOTHING * (temperature_c - before_c);
        self.smooth_c = Some(smooth_c);
        let here = Extremes {
            coldest_c: smooth_c,
            warmest_c: smooth_c,
        };
        let leg = self.leg.map_or(here, |leg| leg.and(here));
        self.leg = Some(leg);
        let seen = self.before.map_or(leg, |before| before.and(leg));
        let contrast_c = seen.warmest_c - seen.coldest_c;
        if contrast_c < settings.contrast_min_c {
            return;
        }
        let off_c = smooth_c - 0.5 * (seen.warmest_c + seen.coldest_c);
        if off_c.abs() < HYSTERESIS * contrast_c {
            return;
        }
        let warm = off_c > 0.0;
        // The first time that two waters are known, the vehicle has just come into the second one.
        if self.warm != Some(warm) {
            self.front_m = Some(across_m);
            self.crossed = true;
            self.crossings += 1;
        }
        self.warm = Some(warm);
    }

    /// Turns if it is time. Returns whether it has turned.
    pub fn turn(&mut self, settings: &Settings, across_m: f64) -> bool {
        let beyond = |from_m: f64, metres: f64| (across_m - from_m) * self.side >= metres;
        let due = match self.front_m {
            Some(front_m) if settings.adaptive => {
                let beyond_m = settings.beyond_m * if self.crossed { 1.0 } else { LOST };
                beyond(front_m, beyond_m)
            }
            Some(_) | None => beyond(0.0, settings.search_m),
        };
        if due {
            self.side = -self.side;
            self.before = self.leg.take();
            self.crossed = false;
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use backseat_sdk::units::math::tanh;
    use proptest::prelude::*;

    use super::*;

    const SETTINGS: Settings = Settings {
        along_deg: 0.0,
        cross_deg: 60.0,
        beyond_m: 80.0,
        search_m: 400.0,
        contrast_min_c: 0.5,
        adaptive: true,
    };

    /// Flies across a front that moves, for some seconds. Returns the tracker, and how far the vehicle was from the front
    /// at each second.
    fn flown(settings: &Settings, front: impl Fn(f64) -> f64, seconds: u32) -> (Tracker, Vec<f64>) {
        let mut tracker = Tracker::default();
        let mut across_m = 0.0;
        let off_m = (0..seconds).map(|second| {
            let front_m = front(f64::from(second));
            let temperature_c = 13.0 - tanh((across_m - front_m) / 40.0);
            tracker.measure(settings, across_m, temperature_c);
            tracker.turn(settings, across_m);
            across_m += tracker.side * 1.3;
            (across_m - front_m).abs()
        });
        let off_m = off_m.collect();
        (tracker, off_m)
    }

    proptest! {
        #[test]
        fn it_finds_a_front_within_its_search_and_stays_with_it(
            (at_m, speed_mps) in (-300.0..300.0, -0.1..0.1),
        ) {
            let (tracker, off_m) = flown(&SETTINGS, |second| at_m + speed_mps * second, 3000);
            prop_assert!(tracker.crossings() >= 10, "{}", tracker.crossings());
            let farthest_m = off_m[1500..].iter().copied().fold(0.0, f64::max);
            prop_assert!(farthest_m < 250.0, "{farthest_m}");
        }
    }

    #[test]
    fn without_a_front_it_searches_from_side_to_side() {
        let (tracker, off_m) = flown(&SETTINGS, |_| 1e6, 3000);
        assert_eq!((tracker.crossings(), tracker.front_m()), (0, None));
        let across = |off: &f64| off - 1e6;
        let reach_m = off_m.iter().map(across).fold(0.0, |reach: f64, at| reach.max(at.abs()));
        assert!((400.0..403.0).contains(&reach_m), "{reach_m}");
    }

    #[test]
    fn a_plain_zigzag_turns_at_its_sides_alone() {
        let plain = Settings {
            adaptive: false,
            ..SETTINGS
        };
        let (tracker, off_m) = flown(&plain, |_| 0.0, 3000);
        let reach_m = off_m.iter().copied().fold(0.0, f64::max);
        assert!((400.0..403.0).contains(&reach_m), "{reach_m}");
        assert!(tracker.crossings() >= 3);
    }

    #[test]
    fn headings_lie_on_both_sides_of_the_front() {
        let mut tracker = Tracker::default();
        assert!((tracker.heading_deg(&SETTINGS) - 60.0).abs() < 1e-9);
        assert!(!tracker.turn(&SETTINGS, 399.0));
        assert!(tracker.turn(&SETTINGS, 400.0));
        assert!((tracker.heading_deg(&SETTINGS) - 300.0).abs() < 1e-9);
        tracker.measure(&SETTINGS, 0.0, f64::NAN);
        assert_eq!(tracker.smooth_c, None);
    }
}

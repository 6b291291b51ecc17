use backseat_sdk::units::EastNorth;
use serde::{Deserialize, Serialize};

/// Joins measurements along a track to means, each at the middle of its places. (`GaussianProcess::add` also joins what is
/// close together, but leaves it at the first of the places.)
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    first: Option<EastNorth>,
    places: EastNorth,
    values: f64,
    count: f64,
}

impl Samples {
    /// Takes in a measurement. If it is `apart_m` metres or more from the first one of the mean so far, it begins the next
    /// mean, and this one is returned. What is not finite is left out.
    pub fn add(&mut self, apart_m: f64, at: EastNorth, value: f64) -> Option<(EastNorth, f64)> {
        if !(value.is_finite() && at.east_m.is_finite() && at.north_m.is_finite()) {
            return None;
        }
        let full = self.first.is_some_and(|first| first.distance_m(at) >= apart_m);
        let mean = if full { self.take() } else { None };
        self.first.get_or_insert(at);
        self.places = self.places + at;
        self.values += value;
        self.count += 1.0;
        mean
    }

    /// Ends the mean, and returns it. `None` without a measurement.
    pub fn take(&mut self) -> Option<(EastNorth, f64)> {
        let all = std::mem::take(self);
        (all.count > 0.0).then(|| (all.places * (1.0 / all.count), all.values / all.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_lies_in_the_middle_of_its_places() {
        let mut samples = Samples::default();
        for east in [0.0, 10.0, 20.0] {
            assert_eq!(samples.add(30.0, EastNorth::new(east, 4.0), east), None);
        }
        assert_eq!(samples.add(30.0, EastNorth::new(25.0, 4.0), f64::NAN), None);
        let mean = samples.add(30.0, EastNorth::new(30.0, 4.0), 7.0);
        assert_eq!(mean, Some((EastNorth::new(10.0, 4.0), 10.0)));
        assert_eq!(samples.take(), Some((EastNorth::new(30.0, 4.0), 7.0)));
        assert_eq!(samples.take(), None);
    }
}

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

/// Looks are taken to be within these limits.
const LOOKS: core::ops::RangeInclusive<f64> = 1.0..=2000.0;

/// Thresholds on the ratio of two mean intensities, with a stated probability of a false alarm.
///
/// Speckle makes intensities exponential, and a mean of `n` independent looks a gamma distribution of shape `n` (Goodman
/// 1976). So the ratio of a mean over `n` looks and one over `m` others of the same seabed follows the F distribution
/// with `2n` and `2m` degrees of freedom, whatever the level: this is the constant false alarm rate of Finn and Johnson
/// 1968 ("Adaptive detection mode with threshold control as a function of spatially sampled clutter-level estimates",
/// *RCA Review* 29), whose threshold for one look is the case `n = 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chance {
    /// How probable it is that the ratio passes the threshold by chance, 1e-12 to 0.5.
    pub probability: f64,
}

impl Chance {
    fn distribution(over: f64, under: f64) -> Option<FisherSnedecor> {
        let degrees = |looks: f64| 2.0 * looks.clamp(*LOOKS.start(), *LOOKS.end());
        FisherSnedecor::new(degrees(over), degrees(under)).ok()
    }

    fn tail(self) -> f64 {
        if self.probability.is_nan() {
            0.5
        } else {
            self.probability.clamp(1e-12, 0.5)
        }
    }

    /// The ratio that the mean of `looks` looks over the mean of `reference` looks exceeds with this probability.
    #[must_use]
    pub fn above(self, looks: f64, reference: f64) -> f64 {
        // The reciprocal of the ratio has the two means exchanged. So both thresholds are in the lower tail, where
        // probabilities near 0 keep their digits.
        1.0 / self.below(reference, looks).max(1e-9)
    }

    /// The ratio that it falls below with this probability.
    #[must_use]
    pub fn below(self, looks: f64, reference: f64) -> f64 {
        Self::distribution(looks, reference).map_or(0.0, |distribution| distribution.inverse_cdf(self.tail()))
    }
}

/// Measures the looks of a mean in the imagery itself: `mean² / variance`, the equivalent number of looks (Oliver and
/// Quegan, *Understanding Synthetic Aperture Radar Images*, SciTech 2004, section 4.3). It is fewer than there are
/// samples if neighbours share their speckle, and fewer still on a seabed that is uneven by itself: there thresholds rise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct LooksMeter {
    mean: f64,
    square: f64,
    rows: u32,
    memory: u32,
}

impl LooksMeter {
    /// `memory` is the number of rows that it covers.
    pub(crate) const fn new(memory: u32) -> Self {
        Self {
            mean: 0.0,
            square: 0.0,
            rows: 0,
            memory,
        }
    }

    /// Takes in the ratios of a row.
    pub(crate) fn row(&mut self, mean: f64, square: f64) {
        self.rows = (self.rows + 1).min(self.memory);
        let part = 1.0 / f64::from(self.rows);
        self.mean += (mean - self.mean) * part;
        self.square += (square - self.square) * part;
    }

    /// Looks of the mean in the numerator, if that in the denominator has `more` times as many. `None` before 30 rows.
    pub(crate) fn looks(&self, more: f64) -> Option<f64> {
        let variance = self.square / (self.mean * self.mean).max(1e-12) - 1.0;
        // The relative variance of a ratio of means is the sum of theirs, if both are small.
        (self.rows >= 30.min(self.memory))
            .then(|| ((1.0 + 1.0 / more) / variance.max(1e-9)).clamp(*LOOKS.start(), *LOOKS.end()))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Finn and Johnson's threshold for one look over the sum of `m`: `m (P^(-1/m) - 1)` of the mean.
    #[test]
    fn one_look_has_the_threshold_of_cell_averaging() {
        for (probability, reference) in [(1e-3_f64, 16.0_f64), (1e-6, 32.0), (1e-4, 200.0)] {
            let expected = reference * (probability.powf(-1.0 / reference) - 1.0);
            let found = Chance { probability }.above(1.0, reference);
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }

    /// Table values of F: 5 % and 1 % points for (10, 20) and (24, 60) degrees of freedom.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        let found = [
            Chance { probability: 0.05 }.above(5.0, 10.0),
            Chance { probability: 0.01 }.above(5.0, 10.0),
            Chance { probability: 0.05 }.above(12.0, 30.0),
            Chance { probability: 0.01 }.above(12.0, 30.0),
        ];
        for (found, expected) in found.into_iter().zip([2.35, 3.37, 1.70, 2.12]) {
            assert!((found - expected).abs() < 0.006, "{found} {expected}");
        }
    }

    proptest! {
        #[test]
        fn rarer_is_farther_from_one(looks in 1.0..500.0_f64, reference in 4.0..500.0_f64, exponent in 1.0..10.0_f64) {
            let often = Chance { probability: 10_f64.powf(-exponent) };
            let rare = Chance { probability: 10_f64.powf(-exponent - 1.0) };
            prop_assert!(rare.above(looks, reference) > often.above(looks, reference));
            prop_assert!(often.above(looks, reference) > 1.0);
            prop_assert!(rare.below(looks, reference) < often.below(looks, reference));
        }

        #[test]
        fn no_figures_break_it(
            probability in prop::num::f64::ANY, looks in prop::num::f64::ANY, reference in prop::num::f64::ANY,
        ) {
            let chance = Chance { probability };
            let looks = if looks.is_nan() { 1.0 } else { looks };
            let reference = if reference.is_nan() { 1.0 } else { reference };
            prop_assert!(chance.above(looks, reference) > 0.0);
            prop_assert!(chance.below(looks, reference) >= 0.0);
        }
    }
}

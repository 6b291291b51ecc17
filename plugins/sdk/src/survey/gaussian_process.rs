use std::collections::VecDeque;

use backseat_units::EastNorth;
use backseat_units::math::exp;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::{Deserialize, Serialize};

/// How a field varies: a squared exponential (Rasmussen and Williams, *Gaussian Processes for Machine Learning*, 2006,
/// equation 2.31).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kernel {
    /// The distance over which the field changes, metres, above 0.
    pub length_m: f64,
    /// The standard deviation of the field around its mean, in its unit, above 0.
    pub deviation: f64,
    /// The standard deviation of a measurement's error, in the field's unit, above 0.
    pub noise: f64,
}

impl Kernel {
    /// The covariance of the field at two places.
    #[must_use]
    pub fn covariance(&self, a: EastNorth, b: EastNorth) -> f64 {
        let off = a - b;
        let square = (off.east_m * off.east_m + off.north_m * off.north_m) / (self.length_m * self.length_m);
        self.deviation * self.deviation * exp(-0.5 * square)
    }

    fn is_usable(&self) -> bool {
        [self.length_m, self.deviation, self.noise]
            .iter()
            .all(|value| value.is_finite() && *value > 0.0)
    }
}

/// What is known about a field at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value that is expected.
    pub mean: f64,
    /// Its standard deviation, without the error of a measurement.
    pub deviation: f64,
}

/// A map of a field from measurements, with what it does not know: Gaussian-process regression (Rasmussen and Williams
/// 2006, algorithm 2.1).
///
/// [`GaussianProcess::add`] merges measurements that lie close together, so that a long track has few points. The fuel of
/// a fit grows with the cube of their number, that of an estimate with the square. So fit rarely, and estimate at few places
/// a step: with 220 points one place costs some 0.6 million units of fuel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaussianProcess {
    kernel: Kernel,
    points_max: usize,
    merge_m: f64,
    /// Place, mean of the values there, and how many there were.
    points: VecDeque<(EastNorth, f64, f64)>,
}

impl GaussianProcess {
    /// Keeps the newest `points_max` points. A measurement closer than `merge_m` metres to the newest point joins it: the mean of
    /// both counts at the place of the first. Along a track the map is then about half of `merge_m` behind. Where that matters,
    /// average some samples and their places before you add them.
    ///
    /// # Errors
    /// One line, if a value of the kernel is not above 0, or `points_max` is not 1 to 400.
    pub fn new(kernel: Kernel, points_max: usize, merge_m: f64) -> Result<Self, String> {
        if !kernel.is_usable() {
            return Err(format!("{kernel:?}: every value must be above 0"));
        }
        if !(1..=400).contains(&points_max) {
            return Err(format!("{points_max} points are not within 1 to 400"));
        }
        Ok(Self {
            kernel,
            points_max,
            merge_m,
            points: VecDeque::new(),
        })
    }

    /// Adds a measurement. A value or a place that is not finite is left out.
    pub fn add(&mut self, place: EastNorth, value: f64) {
        if !(value.is_finite() && place.east_m.is_finite() && place.north_m.is_finite()) {
            return;
        }
        if let Some((at, mean, count)) = self.points.back_mut()
            && at.distance_m(place) < self.merge_m
        {
            *count += 1.0;
            *mean += (value - *mean) / *count;
            return;
        }
        self.points.push_back((place, value, 1.0));
        while self.points.len() > self.points_max {
            self.points.pop_front();
        }
    }

    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no measurement.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Makes the map. `None` without a measurement.
    #[must_use]
    pub fn fit(&self) -> Option<FieldMap> {
        let places: Vec<EastNorth> = self.points.iter().map(|(place, _, _)| *place).collect();
        FieldMap::of(self.kernel, places, |index| {
            let (_, value, count) = self.points[index];
            (value, count)
        })
    }
}

/// A fitted Gaussian process.
#[derive(Clone, Debug)]
pub struct FieldMap {
    kernel: Kernel,
    mean: f64,
    places: Vec<EastNorth>,
    /// The inverse of the measurements' covariance, times what they differ from the mean.
    weights: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl FieldMap {
    fn of(kernel: Kernel, places: Vec<EastNorth>, measured: impl Fn(usize) -> (f64, f64)) -> Option<Self> {
        let count = places.len();
        if count == 0 {
            return None;
        }
        let noise = kernel.noise * kernel.noise;
        let errors: Vec<f64> = (0..count).map(|index| noise / measured(index).1).collect();
        let factor = factor(&kernel, &places, &errors)?;
        // The mean by generalised least squares: many measurements close together count little more than one of them.
        let values = DVector::from_fn(count, |row, _| measured(row).0);
        let ones = factor.solve(&DVector::from_element(count, 1.0));
        let mean = ones.dot(&values) / ones.sum();
        let weights = factor.solve(&values.add_scalar(-mean));
        Some(Self {
            kernel,
            mean,
            places,
            weights,
            factor,
        })
    }

    /// The mean of the field, which is expected far from all measurements (Rasmussen and Williams 2006, section 2.7).
    #[must_use]
    pub const fn mean(&self) -> f64 {
        self.mean
    }

    /// The value that is expected at a place; cheaper than [`FieldMap::at`].
    #[must_use]
    pub fn mean_at(&self, place: EastNorth) -> f64 {
        let known = self.places.iter().zip(self.weights.iter());
        known.fold(self.mean, |sum, (at, weight)| {
            sum + weight * self.kernel.covariance(*at, place)
        })
    }

    /// What is known about a place.
    #[must_use]
    pub fn at(&self, place: EastNorth) -> Estimate {
        let (estimate, _) = self.project(place);
        estimate
    }

    /// What is known about some places, kept so that many plans can be judged by them.
    #[must_use]
    pub fn know(&self, places: &[EastNorth]) -> Known {
        let (estimates, projections) = places.iter().map(|place| self.project(*place)).unzip();
        Known {
            places: places.to_vec(),
            estimates,
            projections,
        }
    }

    /// The deviations that would be left at the known places if these places were measured too: no value need be known for
    /// that. So a plan of several lines can be judged before any of them is flown. `None` if two of the places are one and
    /// their measurements have no error.
    #[must_use]
    pub fn deviations_after(&self, known: &Known, planned: &[EastNorth]) -> Option<Vec<f64>> {
        let noise = self.kernel.noise * self.kernel.noise;
        let own: Vec<DVector<f64>> = planned.iter().map(|place| self.project(*place).1).collect();
        // The covariance that the measurements leave between two places.
        let left = |a: (EastNorth, &DVector<f64>), b: (EastNorth, &DVector<f64>)| {
            self.kernel.covariance(a.0, b.0) - a.1.dot(b.1)
        };
        let covariance = DMatrix::from_fn(planned.len(), planned.len(), |row, column| {
            let error = if row == column { noise } else { 0.0 };
            left((planned[row], &own[row]), (planned[column], &own[column])) + error
        });
        let factor = Cholesky::new(covariance)?;
        let each = known.places.iter().zip(&known.projections).zip(&known.estimates);
        let after = each.map(|((place, projection), before)| {
            let with = DVector::from_fn(planned.len(), |row, _| {
                left((planned[row], &own[row]), (*place, projection))
            });
            let explained = factor.l_dirty().solve_lower_triangular(&with);
            let variance = before.deviation * before.deviation - explained.map_or(0.0, |part| part.norm_squared());
            variance.max(0.0).sqrt()
        });
        Some(after.collect())
    }

    /// The estimate at a place, and what explains it: the covariance with the measurements, over their factor.
    fn project(&self, place: EastNorth) -> (Estimate, DVector<f64>) {
        let near = DVector::from_fn(self.places.len(), |row, _| {
            self.kernel.covariance(self.places[row], place)
        });
        let mean = self.mean + near.dot(&self.weights);
        let projection = self
            .factor
            .l_dirty()
            .solve_lower_triangular(&near)
            .unwrap_or_else(|| DVector::zeros(self.places.len()));
        let variance = self.kernel.deviation * self.kernel.deviation - projection.norm_squared();
        let estimate = Estimate {
            mean,
            deviation: variance.max(0.0).sqrt(),
        };
        (estimate, projection)
    }
}

/// What a map knows about some places.
#[derive(Clone, Debug)]
pub struct Known {
    places: Vec<EastNorth>,
    estimates: Vec<Estimate>,
    projections: Vec<DVector<f64>>,
}

impl Known {
    /// What is known about each place, in the order in which they were given.
    #[must_use]
    pub fn estimates(&self) -> &[Estimate] {
        &self.estimates
    }
}

/// The factor of the measurements' covariance.
fn factor(kernel: &Kernel, places: &[EastNorth], errors: &[f64]) -> Option<Cholesky<f64, Dyn>> {
    let covariance = DMatrix::from_fn(places.len(), places.len(), |row, column| {
        let own = if row == column { errors[row] } else { 0.0 };
        kernel.covariance(places[row], places[column]) + own
    });
    Cholesky::new(covariance)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KERNEL: Kernel = Kernel {
        length_m: 100.0,
        deviation: 2.0,
        noise: 0.1,
    };

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    fn process() -> GaussianProcess {
        GaussianProcess::new(KERNEL, 100, 5.0).unwrap()
    }

    #[test]
    fn one_measurement_is_known_there_and_forgotten_far_away() {
        let mut process = process();
        assert!(process.is_empty() && process.fit().is_none());
        process.add(at(0.0, 0.0), 7.0);
        let map = process.fit().unwrap();
        let here = map.at(at(0.0, 0.0));
        assert_eq!(here.mean, 7.0);
        // Variance: 4 - 16 / 4.01.
        assert!((here.deviation - (4.0f64 - 16.0 / 4.01).sqrt()).abs() < 1e-12);
        let far = map.at(at(5000.0, 0.0));
        assert!((far.deviation - 2.0).abs() < 1e-12 && (far.mean - 7.0).abs() < 1e-12);
    }

    #[test]
    fn two_measurements_are_as_by_hand() {
        let mut process = process();
        process.add(at(0.0, 0.0), 1.0);
        process.add(at(100.0, 0.0), 3.0);
        let place = at(30.0, 40.0);
        // Around the mean 2, because both weigh the same: k is 4 exp(-1/2), with 4.01 on the diagonal.
        let k = 4.0 * (-0.5f64).exp();
        let determinant = 4.01 * 4.01 - k * k;
        let (first, second) = ((-4.01 - k) / determinant, (k + 4.01) / determinant);
        let near = [4.0 * (-0.125f64).exp(), 4.0 * (-0.5f64 * 0.65).exp()];
        let expected = 2.0 + near[0] * first + near[1] * second;
        let map = process.fit().unwrap();
        assert!((map.at(place).mean - expected).abs() < 1e-12);
        assert!((map.mean_at(place) - expected).abs() < 1e-12);
        let explained =
            (4.01 * near[0] * near[0] - 2.0 * k * near[0] * near[1] + 4.01 * near[1] * near[1]) / determinant;
        assert!((map.at(place).deviation - (4.0 - explained).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn measurements_close_together_are_one_point_with_less_noise() {
        let mut process = process();
        for value in [1.0, 2.0, 3.0, 2.0] {
            process.add(at(0.0, 0.0), value);
        }
        process.add(at(f64::NAN, 0.0), 2.0);
        process.add(at(0.0, 0.0), f64::INFINITY);
        assert_eq!(process.len(), 1);
        let map = process.fit().unwrap();
        assert!((map.at(at(0.0, 0.0)).deviation - (4.0f64 - 16.0 / 4.0025).sqrt()).abs() < 1e-12);
        for step in 0..150 {
            process.add(at(10.0 * f64::from(step), 0.0), 1.0);
        }
        assert_eq!(process.len(), 100, "the oldest are forgotten");
    }

    #[test]
    fn a_plan_leaves_the_deviations_that_its_measurements_would_leave() {
        let mut process = process();
        for (east, north, value) in [(0.0, 0.0, 1.0), (100.0, 0.0, 3.0), (0.0, 80.0, 2.0)] {
            process.add(at(east, north), value);
        }
        let map = process.fit().unwrap();
        let places = [at(280.0, 10.0), at(50.0, 20.0), at(-300.0, 0.0)];
        let known = map.know(&places);
        let planned = [at(300.0, 0.0), at(320.0, 0.0), at(60.0, 60.0)];
        let after = map.deviations_after(&known, &planned).unwrap();
        for place in planned {
            process.add(place, 7.0);
        }
        let measured = process.fit().unwrap();
        for ((place, after), before) in places.iter().zip(after).zip(known.estimates()) {
            assert!(
                (after - measured.at(*place).deviation).abs() < 1e-9,
                "{after} at {place:?}"
            );
            assert!(after <= before.deviation);
            assert_eq!(map.at(*place), *before);
        }
        let nothing = map.deviations_after(&known, &[]).unwrap();
        assert!((nothing[0] - known.estimates()[0].deviation).abs() < 1e-12);
    }

    #[test]
    fn a_kernel_of_nothing_is_refused() {
        let flat = Kernel {
            length_m: 0.0,
            ..KERNEL
        };
        assert!(GaussianProcess::new(flat, 100, 5.0).unwrap_err().contains("above 0"));
        assert_eq!(
            GaussianProcess::new(KERNEL, 401, 5.0).unwrap_err(),
            "401 points are not within 1 to 400"
        );
    }
}

use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::{exp, ln};
use nalgebra::{Matrix2, Vector2};

use crate::least_squares::LeastSquares;
use crate::samples::Bin;

/// The unit of lengths, so that all coefficients are of similar size.
const UNIT_M: f64 = 100.0;
/// A fit whose standard deviation is outside this range is discarded, metres.
const SIGMA_MIN_M: f64 = 10.0;
const SIGMA_MAX_M: f64 = 1000.0;
/// The fit ends when the centre moves by less than this, metres.
const SETTLED_M: f64 = 0.05;
/// The least value of a bin for the fit, as a fraction of the peak. Below it, the logarithm describes the background
/// more than the peak.
const FOOT: f64 = 0.1;
/// The same, as a number of standard deviations of a bin's noise.
const FOOT_SIGMAS: f64 = 3.0;
/// Fewer bins on the peak than this do not determine its shape.
const BINS_MIN: u32 = 8;

/// A Gaussian over a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Metres from the area's middle.
    pub centre: EastNorth,
    /// Height over the background at the centre.
    pub amplitude: f64,
    /// Inverse covariance of east and north, per square metre.
    pub tightness: Matrix2<f64>,
    /// Background at the area's middle, and its gradient east and north per metre.
    pub background: [f64; 3],
}

impl Gaussian {
    /// A round Gaussian with unknown height and background.
    #[must_use]
    pub fn round(centre: EastNorth, sigma_m: f64) -> Self {
        Self {
            centre,
            amplitude: 1.0,
            tightness: Matrix2::from_diagonal_element(1.0 / (sigma_m * sigma_m)),
            background: [0.0; 3],
        }
    }

    /// The smaller and the larger standard deviation along the ellipse's axes, metres.
    #[must_use]
    pub fn sigmas_m(&self) -> (f64, f64) {
        let axes = self.tightness.symmetric_eigenvalues();
        (1.0 / axes.max().sqrt(), 1.0 / axes.min().max(1e-12).sqrt())
    }

    /// The background at a position.
    #[must_use]
    pub fn background_at(&self, at: EastNorth) -> f64 {
        let [middle, east, north] = self.background;
        middle + east * at.east_m + north * at.north_m
    }

    /// The height at a position, as a fraction of the amplitude.
    #[must_use]
    pub fn shape_at(&self, at: EastNorth) -> f64 {
        let from = at - self.centre;
        let from = Vector2::new(from.east_m, from.north_m);
        let square = from.dot(&(self.tightness * from));
        if square > 100.0 { 0.0 } else { exp(-0.5 * square) }
    }

    /// Fits a Gaussian over a sloping background, starting from a first guess of centre and shape. `noise` is the
    /// standard deviation of a single sample, `rounds` the most rounds. Returns `None` if the bins do not show a
    /// Gaussian.
    ///
    /// The logarithm of a Gaussian is a quadratic, which linear least squares can fit (Caruana et al., *Analytical
    /// Chemistry* 58, 1986). Because the logarithm magnifies the noise of low values, each bin is weighted by the
    /// square of its value, taken from the last round's fit rather than from the noisy bin itself: Guo, "A simple
    /// algorithm for fitting a Gaussian function", IEEE Signal Processing Magazine 28(5), 2011, equations 9 and 14,
    /// here in two dimensions. That method assumes a known background. Here every round first fits background and
    /// amplitude, which are linear for a given shape, to all bins including the low ones.
    #[must_use]
    pub fn fit(bins: &[Bin], guess: Self, noise: f64, rounds: u32) -> Option<Self> {
        let mut fit = guess;
        for _ in 0..rounds {
            fit = fit.with_background(bins)?;
            let before = fit.centre;
            fit = fit.with_shape(bins, noise)?;
            if before.distance_m(fit.centre) < SETTLED_M {
                break;
            }
        }
        fit.with_background(bins)
    }

    fn with_background(self, bins: &[Bin]) -> Option<Self> {
        let mut squares = LeastSquares::<4>::new();
        for bin in bins {
            let at = bin.at * (1.0 / UNIT_M);
            let row = [1.0, at.east_m, at.north_m, self.shape_at(bin.at)];
            squares.add(row, bin.value, f64::from(bin.count));
        }
        let [middle, east, north, amplitude] = squares.solve()?;
        if amplitude <= 0.0 {
            return None;
        }
        Some(Self {
            amplitude,
            background: [middle, east / UNIT_M, north / UNIT_M],
            ..self
        })
    }

    fn with_shape(self, bins: &[Bin], noise: f64) -> Option<Self> {
        let mut ellipse = LeastSquares::<6>::new();
        let mut circle = LeastSquares::<4>::new();
        let mut used = 0;
        for bin in bins {
            let count = f64::from(bin.count);
            let fitted = self.amplitude * self.shape_at(bin.at);
            let value = bin.value - self.background_at(bin.at);
            // Bins are chosen by the fit, not by their value: choosing low bins with high noise would widen the fit.
            if fitted < FOOT * self.amplitude || fitted < FOOT_SIGMAS * noise / count.sqrt() || value < 0.2 * fitted {
                continue;
            }
            let from = (bin.at - self.centre) * (1.0 / UNIT_M);
            let (x, y) = (from.east_m, from.north_m);
            let (log, weight) = (ln(value), count * fitted * fitted);
            ellipse.add([1.0, x, y, x * x, x * y, y * y], log, weight);
            circle.add([1.0, x, y, x * x + y * y], log, weight);
            used += 1;
        }
        if used < BINS_MIN {
            return None;
        }
        let by_ellipse = ellipse
            .solve()
            .and_then(|[_, x, y, xx, xy, yy]| self.with_quadratic(x, y, [xx, xy, yy]));
        by_ellipse.or_else(|| {
            circle
                .solve()
                .and_then(|[_, x, y, square]| self.with_quadratic(x, y, [square, 0.0, square]))
        })
    }

    /// A Gaussian from the linear and quadratic coefficients of the logarithm around the last centre. `None` if it has
    /// no maximum, or one that is much too narrow, wide or far away.
    fn with_quadratic(self, x: f64, y: f64, [xx, xy, yy]: [f64; 3]) -> Option<Self> {
        let tightness = Matrix2::new(-2.0 * xx, -xy, -xy, -2.0 * yy);
        let step = tightness.cholesky()?.solve(&Vector2::new(x, y)) * UNIT_M;
        let step = EastNorth::new(step.x, step.y);
        let fit = Self {
            centre: self.centre + step,
            tightness: tightness / (UNIT_M * UNIT_M),
            ..self
        };
        let (least_m, most_m) = fit.sigmas_m();
        let plausible =
            least_m >= SIGMA_MIN_M && most_m <= SIGMA_MAX_M && step.distance_m(EastNorth::default()) < 500.0;
        plausible.then_some(fit)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_gaussian_without_noise_is_found_to_two_metres(
            east in -200.0..200.0f64, north in -150.0..150.0f64, wide in 60.0..150.0f64, narrow in 60.0..150.0f64,
            correlation in -0.5..0.5f64, slope in -3e-4..3e-4f64,
        ) {
            let (ee, nn) = (1.0 / (wide * wide), 1.0 / (narrow * narrow));
            let truth = Gaussian {
                centre: EastNorth::new(east, north),
                amplitude: 1.0,
                tightness: Matrix2::new(ee, correlation / (wide * narrow), correlation / (wide * narrow), nn),
                background: [12.0, slope, -slope],
            };
            let bins: Vec<Bin> = (0..8)
                .flat_map(|row| (0..60).map(move |column| (f64::from(row), f64::from(column))))
                .map(|(row, column)| {
                    let at = EastNorth::new(column * 10.0 - 295.0, row * 66.0 - 231.0);
                    Bin { at, value: truth.background_at(at) + truth.shape_at(at), count: 6 }
                })
                .collect();
            let guess = Gaussian::round(truth.centre + EastNorth::new(25.0, -25.0), 90.0);
            let fit = Gaussian::fit(&bins, guess, 0.02, 20).unwrap();
            prop_assert!(fit.centre.distance_m(truth.centre) < 2.0, "{fit:?} {truth:?}");
            prop_assert!((fit.amplitude - 1.0).abs() < 0.05, "{fit:?}");
        }
    }

    #[test]
    fn a_plane_has_no_peak() {
        let bins: Vec<Bin> = (0..100)
            .map(|index| {
                let at = EastNorth::new(f64::from(index % 10) * 50.0, f64::from(index / 10) * 50.0);
                Bin {
                    at,
                    value: 12.0 + 1e-3 * at.east_m,
                    count: 6,
                }
            })
            .collect();
        let guess = Gaussian::round(EastNorth::new(200.0, 200.0), 80.0);
        assert!(Gaussian::fit(&bins, guess, 0.02, 20).is_none_or(|fit| fit.amplitude < 0.02));
    }
}

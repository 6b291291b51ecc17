use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::{exp, hypot};
use nalgebra::{Matrix6, RowVector6, Vector6};
use serde::{Deserialize, Serialize};

/// The unit of coordinates, so that all coefficients are metres of similar size.
const UNIT_M: f64 = 50.0;
/// The standard deviation of the slope from the general one, metres per metre.
const SLOPE_SIGMA: f64 = 0.02;
/// The standard deviation of the seabed's bend, per metre: a meander of 400 m that adds 0.6 % of slope has 0.0001.
const BEND_SIGMA_PER_M: f64 = 0.8e-4;
/// Samples farther from the surface than this many standard deviations are outliers.
const GATE: f64 = 4.0;
/// After this many outliers in a row, the surface must be wrong, and not the samples.
const OUTLIERS_MAX: u32 = 10;
/// The noise of a sample, metres: the initial value, and the range within which it is estimated.
const NOISE_FIRST_M: f64 = 0.2;
const NOISE_MIN_M: f64 = 0.05;
const NOISE_MAX_M: f64 = 0.5;
/// The weight of the newest sample in the estimate of the noise.
const NOISE_GAIN: f64 = 0.02;

/// A surface fitted to the water depth around the vehicle, by recursive least squares in information form.
///
/// The surface is D + g·x + x·Hx/2 around the vehicle, and moves exactly with it. A straight run along a contour
/// contains no information on the slope across it, and with plain exponential forgetting that estimate would wind up
/// (Åström and Wittenmark, *Adaptive Control*, section 11.5). The fit therefore forgets towards a general slope without
/// bends: stabilised forgetting, Λ ← λΛ + (1 - λ)Λ₀ (Kulhavý and Zarrop, "On a general concept of forgetting", Int. J.
/// Control 58(4), 1993). λ falls with the distance travelled, not with time, because the seabed does not change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seabed {
    memory_m: f64,
    /// The general gradient, metres deeper per metre.
    general: EastNorth,
    /// The origin of the coefficients; `None` before the first sample.
    at: Option<EastNorth>,
    /// The information matrix of the six coefficients: depth, its gradient, and its three second derivatives.
    information: Matrix6<f64>,
    vector: Vector6<f64>,
    noise_m: f64,
    outliers: u32,
}

/// The seabed at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Water depth, metres.
    pub depth_m: f64,
    /// Metres deeper per metre, east and north.
    pub gradient: EastNorth,
    /// Second derivatives of depth, per metre: east-east, east-north, north-north.
    pub bend_per_m: [f64; 3],
    /// Standard deviation of `depth_m`, metres.
    pub depth_sigma_m: f64,
}

impl Estimate {
    /// The gradient at this offset from the position.
    #[must_use]
    pub fn gradient_at(&self, from: EastNorth) -> EastNorth {
        let [ee, en, nn] = self.bend_per_m;
        self.gradient
            + EastNorth::new(
                ee * from.east_m + en * from.north_m,
                en * from.east_m + nn * from.north_m,
            )
    }

    /// Steepness, metres per metre.
    #[must_use]
    pub fn slope(&self) -> f64 {
        hypot(self.gradient.east_m, self.gradient.north_m)
    }
}

impl Seabed {
    /// A surface before any measurement: `slope` metres deeper per metre towards `deeper_toward_deg`. The fit forgets
    /// towards this slope over `memory_m` metres of travel.
    #[must_use]
    pub fn new(slope: f64, deeper_toward_deg: f64, memory_m: f64) -> Self {
        Self {
            memory_m,
            general: EastNorth::default().offset(deeper_toward_deg, slope),
            at: None,
            information: Matrix6::zeros(),
            vector: Vector6::zeros(),
            noise_m: NOISE_FIRST_M,
            outliers: 0,
        }
    }

    /// Takes in a water depth measured at a position. Returns false if the sample is an outlier and was not used.
    pub fn measure(&mut self, at: EastNorth, water_depth_m: f64) -> bool {
        if !(at.east_m.is_finite() && at.north_m.is_finite() && water_depth_m.is_finite()) {
            return false;
        }
        self.move_to(at);
        if let Some(estimate) = self.estimate() {
            let residual_m = water_depth_m - estimate.depth_m;
            let sigma_m = hypot(self.noise_m, estimate.depth_sigma_m);
            if residual_m.abs() > GATE * sigma_m && self.outliers < OUTLIERS_MAX {
                self.outliers += 1;
                return false;
            }
            if residual_m.abs() > GATE * sigma_m {
                self.forget_all();
            }
            // The mean absolute value of a normal distribution is √(2/π) of its standard deviation.
            let size_m = residual_m.abs() * 1.2533;
            self.noise_m = (self.noise_m + NOISE_GAIN * (size_m - self.noise_m)).clamp(NOISE_MIN_M, NOISE_MAX_M);
        }
        self.outliers = 0;
        // At the position itself only the depth coefficient is observed.
        let weight = 1.0 / (self.noise_m * self.noise_m);
        self.information[(0, 0)] += weight;
        self.vector[0] += weight * water_depth_m;
        true
    }

    /// Moves the surface to the vehicle's position, and forgets according to the distance.
    pub fn move_to(&mut self, at: EastNorth) {
        let Some(before) = self.at else {
            self.at = Some(at);
            self.forget_all();
            return;
        };
        let way = at - before;
        let way_m = before.distance_m(at);
        self.at = Some(at);
        if way_m <= 0.0 {
            return;
        }
        self.shift(way.east_m / UNIT_M, way.north_m / UNIT_M);
        let keep = exp(-way_m / self.memory_m);
        let (information, vector) = self.prior();
        self.information = self.information * keep + Matrix6::from_diagonal(&information) * (1.0 - keep);
        self.vector = self.vector * keep + vector * (1.0 - keep);
    }

    /// The seabed at the vehicle; `None` before a sample, or if the samples do not determine it.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        if self.information[(0, 0)] < 1e-3 {
            return None;
        }
        let factor = self.information.cholesky()?;
        let [depth_m, east, north, ee, en, nn] = factor.solve(&self.vector).into();
        let variance = factor.solve(&Vector6::x())[0];
        let square = UNIT_M * UNIT_M;
        Some(Estimate {
            depth_m,
            gradient: EastNorth::new(east / UNIT_M, north / UNIT_M),
            bend_per_m: [ee / square, en / square, nn / square],
            depth_sigma_m: variance.max(0.0).sqrt(),
        })
    }

    /// The estimated noise of a sample, metres.
    #[must_use]
    pub const fn noise_m(&self) -> f64 {
        self.noise_m
    }

    fn forget_all(&mut self) {
        let (information, vector) = self.prior();
        self.information = Matrix6::from_diagonal(&information);
        self.vector = vector;
    }

    /// The diagonal of Λ₀, and Λ₀θ₀.
    fn prior(&self) -> (Vector6<f64>, Vector6<f64>) {
        let slope = 1.0 / (SLOPE_SIGMA * UNIT_M * SLOPE_SIGMA * UNIT_M);
        let bend_sigma = BEND_SIGMA_PER_M * UNIT_M * UNIT_M;
        let bend = 1.0 / (bend_sigma * bend_sigma);
        // The depth itself has no general value; the small number keeps the matrix regular.
        let information = Vector6::new(1e-6, slope, slope, bend, 2.0 * bend, bend);
        let gradient = self.general * UNIT_M;
        let vector = Vector6::new(0.0, slope * gradient.east_m, slope * gradient.north_m, 0.0, 0.0, 0.0);
        (information, vector)
    }

    /// Moves the origin of the coefficients by (e, n) units: θ' = Tθ, so Λ' = SᵀΛS and η' = Sᵀη with S = T⁻¹, which is
    /// the opposite shift.
    fn shift(&mut self, e: f64, n: f64) {
        let mut back = Matrix6::identity();
        back.set_row(0, &RowVector6::new(1.0, -e, -n, 0.5 * e * e, e * n, 0.5 * n * n));
        (back[(1, 3)], back[(1, 4)]) = (-e, -n);
        (back[(2, 4)], back[(2, 5)]) = (-e, -n);
        self.information = back.transpose() * (self.information * back);
        self.vector = back.transpose() * self.vector;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A weaving run of `count` samples over a plane.
    fn run(seabed: &mut Seabed, depth: impl Fn(EastNorth) -> f64, count: u32) -> EastNorth {
        let mut at = EastNorth::default();
        for index in 0..count {
            let t = f64::from(index);
            at = EastNorth::new(0.75 * t, 10.0 * backseat_sdk::units::math::sin(t / 12.0));
            seabed.measure(at, depth(at));
        }
        at
    }

    proptest! {
        #[test]
        fn a_plane_is_found_whatever_slope_was_assumed(
            slope in 0.015..0.07f64, toward in 0.0..360.0f64, assumed in 0.0..360.0f64,
        ) {
            let gradient = EastNorth::default().offset(toward, slope);
            let depth = |at: EastNorth| 30.0 + gradient.east_m * at.east_m + gradient.north_m * at.north_m;
            let mut seabed = Seabed::new(0.03, assumed, 40.0);
            let at = run(&mut seabed, depth, 300);
            let estimate = seabed.estimate().unwrap();
            prop_assert!((estimate.depth_m - depth(at)).abs() < 0.05, "{estimate:?}");
            prop_assert!(estimate.gradient.distance_m(gradient) < 0.006, "{estimate:?} {gradient:?}");
        }
    }

    #[test]
    fn outliers_are_left_out_but_a_step_of_the_seabed_is_followed() {
        let mut seabed = Seabed::new(0.03, 0.0, 40.0);
        let at = run(&mut seabed, |at| 30.0 + 0.03 * at.north_m, 100);
        let before = seabed.estimate().unwrap();
        assert!(!seabed.measure(at, 55.0));
        assert_eq!(seabed.estimate().unwrap(), before);
        let used = (0..20).filter(|_| seabed.measure(at, 40.0)).count();
        assert!(used >= 9, "{used}");
        assert!((seabed.estimate().unwrap().depth_m - 40.0).abs() < 0.2);
    }

    #[test]
    fn a_straight_run_keeps_the_slope_across_it() {
        // Plain forgetting would lose it, and make the matrix singular.
        let mut seabed = Seabed::new(0.04, 0.0, 40.0);
        for index in 0..4000 {
            seabed.measure(EastNorth::new(0.75 * f64::from(index), 0.0), 30.0);
        }
        let estimate = seabed.estimate().unwrap();
        assert!((estimate.gradient.north_m - 0.04).abs() < 1e-3, "{estimate:?}");
        assert!(estimate.gradient.east_m.abs() < 1e-3, "{estimate:?}");
    }

    #[test]
    fn invalid_samples_are_not_used() {
        let mut seabed = Seabed::new(0.03, 0.0, 40.0);
        assert!(!seabed.measure(EastNorth::default(), f64::NAN));
        assert!(!seabed.measure(EastNorth::new(f64::INFINITY, 0.0), 3.0));
        assert!(seabed.estimate().is_none());
    }
}

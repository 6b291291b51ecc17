use nalgebra::{SMatrix, SVector};

/// A smaller pivot counts as zero.
const PIVOT_MIN: f64 = 1e-12;

/// The normal equations of a weighted linear least squares.
pub(crate) struct LeastSquares<const N: usize> {
    matrix: SMatrix<f64, N, N>,
    right: SVector<f64, N>,
}

impl<const N: usize> LeastSquares<N> {
    pub(crate) fn new() -> Self {
        Self {
            matrix: SMatrix::zeros(),
            right: SVector::zeros(),
        }
    }

    pub(crate) fn add(&mut self, row: [f64; N], value: f64, weight: f64) {
        let row = SVector::from(row);
        self.matrix.ger(weight, &row, &row, 1.0);
        self.right.axpy(weight * value, &row, 1.0);
    }

    /// `None` if the system is singular or not finite.
    pub(crate) fn solve(self) -> Option<[f64; N]> {
        let factor = self.matrix.cholesky()?;
        let regular = factor.l_dirty().diagonal().iter().all(|root| root * root >= PIVOT_MIN);
        let found = factor.solve(&self.right);
        (regular && found.iter().all(|value| value.is_finite())).then(|| found.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found_and_a_singular_system_refused() {
        let mut squares = LeastSquares::<3>::new();
        for index in -5..6 {
            let x = f64::from(index);
            squares.add([1.0, x, x * x], 3.0 - 2.0 * x + 0.5 * x * x, 1.0 + x.abs());
        }
        let found = squares.solve().unwrap();
        for (found, true_value) in found.iter().zip([3.0, -2.0, 0.5]) {
            assert!((found - true_value).abs() < 1e-9);
        }
        let mut singular = LeastSquares::<2>::new();
        singular.add([1.0, 2.0], 1.0, 1.0);
        assert_eq!(singular.solve(), None);
    }
}

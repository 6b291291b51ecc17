/// Solves a small linear system by elimination with partial pivoting. None where it is singular or not finite.
pub(crate) fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let mut pivot = column;
        for row in column + 1..N {
            if matrix[row][column].abs() > matrix[pivot][column].abs() {
                pivot = row;
            }
        }
        let head = matrix[pivot][column].abs();
        if head.is_nan() || head < 1e-12 {
            return None;
        }
        matrix.swap(pivot, column);
        right.swap(pivot, column);
        let upper = matrix[column];
        for row in column + 1..N {
            let factor = matrix[row][column] / upper[column];
            for inner in column..N {
                matrix[row][inner] -= factor * upper[inner];
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..N).rev() {
        for inner in row + 1..N {
            right[row] -= matrix[row][inner] * right[inner];
        }
        right[row] /= matrix[row][row];
    }
    right.iter().all(|x| x.is_finite()).then_some(right)
}

/// The normal equations of a weighted linear least squares.
pub(crate) struct LeastSquares<const N: usize> {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> LeastSquares<N> {
    pub(crate) const fn new() -> Self {
        Self {
            matrix: [[0.0; N]; N],
            right: [0.0; N],
        }
    }

    pub(crate) fn add(&mut self, row: [f64; N], value: f64, weight: f64) {
        for (index, factor) in row.iter().enumerate() {
            let weighted = weight * factor;
            for (cell, other) in self.matrix[index].iter_mut().zip(row) {
                *cell += weighted * other;
            }
            self.right[index] += weighted * value;
        }
    }

    pub(crate) fn solve(self) -> Option<[f64; N]> {
        solve(self.matrix, self.right)
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

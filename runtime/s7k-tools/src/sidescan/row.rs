//! A side of a ping on evenly spaced columns of range.

use super::Side;

/// Columns of equal width, from the vehicle outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    pub(crate) columns: usize,
    /// Width of a column.
    pub(crate) step_m: f64,
}

/// Fills the columns with mean amplitudes; NaN where the side has no sample. With an altitude, columns are along the
/// seabed, which is taken to be flat: the sample at slant range r lies at sqrt(r^2 - altitude^2).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "clamped to the samples that there are"
)]
pub(crate) fn fill(side: &Side, grid: Grid, altitude_m: Option<f64>, out: &mut Vec<f32>) {
    out.clear();
    let altitude_m = altitude_m.filter(|_| !side.ground).unwrap_or(0.0);
    let count = side.amplitudes.len();
    // The place of a column's edge among the samples.
    let place = |column: usize| {
        let range = column as f64 * grid.step_m;
        ((range * range + altitude_m * altitude_m).sqrt() - side.first_m) / side.step_m
    };
    let mut from = place(0);
    for column in 0..grid.columns {
        let to = place(column + 1);
        let first = from.ceil().clamp(0.0, count as f64) as usize;
        let end = to.ceil().clamp(0.0, count as f64) as usize;
        // Below the vehicle a column is narrower than a sample: the first one behind, lest it be one of the water.
        let middle = if altitude_m > 0.0 {
            f64::midpoint(from, to).ceil()
        } else {
            f64::midpoint(from, to).round()
        };
        let value = if count == 0 || middle < 0.0 || middle >= count as f64 {
            f32::NAN
        } else if first < end {
            let samples = &side.amplitudes[first..end];
            samples.iter().sum::<f32>() / samples.len() as f32
        } else {
            side.amplitudes[middle as usize]
        };
        out.push(value);
        from = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(count: u16) -> Side {
        Side {
            amplitudes: (0..count).map(f32::from).collect(),
            first_m: 0.0,
            step_m: 0.1,
            ground: false,
        }
    }

    #[test]
    fn columns_are_means_of_their_samples() {
        let mut out = Vec::new();
        let grid = Grid {
            columns: 6,
            step_m: 1.0,
        };
        fill(&side(50), grid, None, &mut out);
        assert_eq!(out[..5], [4.5, 14.5, 24.5, 34.5, 44.5]);
        assert!(out[5].is_nan());
    }

    #[test]
    fn narrow_columns_repeat_the_nearest_sample() {
        let mut out = Vec::new();
        fill(
            &side(4),
            Grid {
                columns: 16,
                step_m: 0.025,
            },
            None,
            &mut out,
        );
        assert_eq!(out[..4], [0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn along_the_seabed_an_echo_lies_where_pythagoras_puts_it() {
        let mut out = Vec::new();
        // 5 m of slant range are sample 50; 3 m high, it lies 4 m away.
        fill(
            &side(80),
            Grid {
                columns: 80,
                step_m: 0.1,
            },
            Some(3.0),
            &mut out,
        );
        assert!((out[40] - 50.0).abs() <= 1.0, "{}", out[40]);
        assert!((out[0] - 30.0).abs() <= 1.0, "{}", out[0]);
        let flat = Side {
            ground: true,
            ..side(80)
        };
        fill(
            &flat,
            Grid {
                columns: 80,
                step_m: 0.1,
            },
            Some(3.0),
            &mut out,
        );
        assert!((out[40] - 40.0).abs() <= 1.0, "{}", out[40]);
    }
}

use core::ops::Range;

use serde::{Deserialize, Serialize};

use super::geometry::slant_m;
use super::look::Strip;

/// A row of even cells over the ground, from below the sonar outwards.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cells {
    /// Width of a cell across the track, metres.
    pub cell_m: f64,
    /// Number of cells.
    pub count: usize,
}

impl Cells {
    /// Ground range of a cell's near edge, metres.
    #[must_use]
    pub fn edge_m(&self, cell: usize) -> f64 {
        cell as f64 * self.cell_m
    }

    /// Number of cells that a length takes, at least 1.
    #[must_use]
    pub fn across(&self, length_m: f64) -> usize {
        ((length_m / self.cell_m + 0.5) as usize).max(1)
    }

    /// Fills `row` with the intensity in each cell: the mean square of the amplitudes of the samples whose slant range
    /// over a level seabed falls into the cell, or of the nearest sample if there is none. Returns the cells that the
    /// samples reach; the others hold 0. Amplitudes that are not finite count as 0.
    pub fn project(&self, strip: &Strip<'_>, altitude_m: f64, row: &mut Vec<f32>) -> Range<usize> {
        row.clear();
        row.resize(self.count, 0.0);
        let samples = strip.samples;
        let sample_m = strip.sample_m();
        let has_ranges = sample_m > 0.0 && altitude_m.is_finite() && altitude_m >= 0.0 && strip.start_m >= 0.0;
        if samples.is_empty() || !has_ranges {
            return 0..0;
        }
        let index_at = |cell: usize| {
            let ground_m = self.edge_m(cell);
            let range_m = if strip.over_ground {
                ground_m
            } else {
                slant_m(ground_m, altitude_m)
            };
            (range_m - strip.start_m) / sample_m
        };
        let square = |sample: &f32| {
            let amplitude = sample * strip.step;
            let square = amplitude * amplitude;
            if square.is_finite() { square } else { 0.0 }
        };
        let mut reached: Option<Range<usize>> = None;
        let mut from = index_at(0);
        for (cell, intensity) in row.iter_mut().enumerate() {
            let to = index_at(cell + 1);
            if to > samples.len() as f64 + 1e-6 {
                break;
            }
            if from >= -1e-6 {
                // A sample belongs to the cell that has its middle.
                let first = (from + 0.5) as usize;
                let last = ((to + 0.5) as usize).min(samples.len());
                *intensity = if first < last {
                    samples[first..last].iter().map(square).sum::<f32>() / (last - first) as f32
                } else {
                    square(&samples[((0.5 * (from + to)) as usize).min(samples.len() - 1)])
                };
                reached = Some(reached.map_or(cell, |range| range.start)..cell + 1);
            }
            from = to;
        }
        reached.unwrap_or(0..0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CELLS: Cells = Cells {
        cell_m: 0.25,
        count: 400,
    };

    proptest! {
        #[test]
        fn a_bright_sample_lies_in_the_cell_of_its_ground_range(
            sample in 0_usize..1500, altitude in 2.0..30.0_f64,
        ) {
            let mut samples = vec![0.0; 1500];
            samples[sample] = 4.0;
            let mut row = Vec::new();
            let reached = CELLS.project(&Strip::along_slant(&samples, 75.0), altitude, &mut row);
            let slant = (sample as f64 + 0.5) * 0.05;
            let expected = crate::sonar::ground_m(slant, altitude).map(|ground| (ground / CELLS.cell_m) as usize);
            let brightest = (0..row.len()).max_by(|one, other| row[*one].total_cmp(&row[*other])).unwrap();
            match expected.filter(|cell| reached.contains(cell)) {
                Some(cell) => prop_assert!(brightest.abs_diff(cell) <= 1, "{brightest} {cell}"),
                // Directly below, a cell has many samples, or one sample many cells, from the first one on.
                None => prop_assert!(row[brightest] == 0.0 || row[brightest] == row[0]),
            }
        }

        #[test]
        fn an_even_picture_stays_even(altitude in 0.0..40.0_f64, step in 0.1..4.0_f32, over_ground: bool) {
            let samples = vec![3.0; 700];
            let strip = Strip { step, over_ground, ..Strip::along_slant(&samples, 75.0) };
            let mut row = Vec::new();
            let reached = CELLS.project(&strip, altitude, &mut row);
            let expected = 9.0 * step * step;
            prop_assert!(row[reached.clone()].iter().all(|cell| (cell / expected - 1.0).abs() < 1e-4));
            let end = if over_ground { 75.0 } else { (75.0_f64 * 75.0 - altitude * altitude).sqrt() };
            prop_assert!((CELLS.edge_m(reached.end) - end).abs() <= CELLS.cell_m, "{reached:?} {end}");
        }

        #[test]
        fn no_figures_break_it(
            samples in prop::collection::vec(prop::num::f32::ANY, 0..50),
            start in prop::num::f64::ANY, end in prop::num::f64::ANY, altitude in prop::num::f64::ANY, step in prop::num::f32::ANY,
        ) {
            let strip = Strip { samples: &samples, start_m: start, end_m: end, over_ground: false, step };
            let mut row = Vec::new();
            let reached = CELLS.project(&strip, altitude, &mut row);
            prop_assert!(reached.end <= CELLS.count && row.iter().all(|cell| cell.is_finite() && *cell >= 0.0));
        }
    }
}

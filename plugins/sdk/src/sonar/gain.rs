use core::ops::Range;

use serde::{Deserialize, Serialize};

/// A cell's mean is used once it has seen this many pings.
const KNOWN: u16 = 20;
/// A ping adds at most this many times the mean, so that what is bright for a short time changes little.
const CLIP: f32 = 4.0;

/// Empirical gain normalisation: for each cell over the ground the running mean of what earlier pings had there. A row
/// divided by it has neither the falloff with range nor the pattern of the beam, whatever the sonar's gains.
///
/// The mean covers about `memory` pings. Rows that are brighter than four times the mean count as four times it: of
/// even speckle with one look this takes 2 % from the mean, and of several looks next to nothing.
///
/// The method is that of the flat-field and beam-pattern corrections for sidescan mosaics: Chang, Hsu and Tsai 2010,
/// "Sidescan sonar image processing: correcting brightness variation and patching gaps", *Journal of Marine Science and
/// Technology* 18(6); Blondel 2009, chapter 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gain {
    means: Vec<f32>,
    seen: Vec<u16>,
    memory: u16,
}

impl Gain {
    /// For rows of `count` cells; `memory` is the number of pings that the mean covers, at least 1.
    #[must_use]
    pub fn new(count: usize, memory: u16) -> Self {
        Self {
            means: vec![0.0; count],
            seen: vec![0; count],
            memory: memory.max(1),
        }
    }

    /// Takes a row into the means of the cells that it reaches.
    pub fn learn(&mut self, row: &[f32], reached: Range<usize>) {
        let cells = self.means.iter_mut().zip(&mut self.seen).zip(row);
        let count = reached.end.saturating_sub(reached.start);
        for ((mean, seen), intensity) in cells.skip(reached.start).take(count) {
            let clipped = if *seen >= KNOWN {
                intensity.min(CLIP * *mean)
            } else {
                *intensity
            };
            *seen = seen.saturating_add(1).min(self.memory);
            *mean += (clipped - *mean) / f32::from(*seen);
        }
    }

    /// Divides a row by the means, in place. Returns the cells of `reached` that are known; outside them the row holds 1,
    /// as the seabed does on average.
    pub fn normalise(&self, row: &mut [f32], reached: Range<usize>) -> Range<usize> {
        let known = |cell: usize| {
            self.seen.get(cell).is_some_and(|seen| *seen >= KNOWN.min(self.memory)) && self.means[cell] > 0.0
        };
        let mut range = reached.start..reached.start;
        for (cell, intensity) in row.iter_mut().enumerate() {
            if reached.contains(&cell) && known(cell) {
                if range.is_empty() {
                    range.start = cell;
                }
                range.end = cell + 1;
                *intensity /= self.means[cell];
            } else {
                *intensity = 1.0;
            }
        }
        range
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Whatever falls off with range is gone, whatever the level.
        #[test]
        fn falloff_and_level_disappear(level in 1e-3..1e6_f32, power in 0.0..4.0_f32) {
            let row: Vec<f32> = (1..=200).map(|cell| level * (cell as f32).powf(-power)).collect();
            let mut gain = Gain::new(200, 100);
            for _ in 0..50 {
                gain.learn(&row, 0..200);
            }
            let mut out = row.clone();
            prop_assert_eq!(gain.normalise(&mut out, 0..200), 0..200);
            prop_assert!(out.iter().all(|cell| (cell - 1.0).abs() < 1e-3), "{:?}", &out[..5]);
        }
    }

    #[test]
    fn a_bright_target_is_not_learnt() {
        let mut gain = Gain::new(3, 300);
        for ping in 0..400 {
            let target = if (300..310).contains(&ping) { 1000.0 } else { 1.0 };
            gain.learn(&[1.0, target, 1.0], 0..3);
        }
        let mut row = vec![1.0, 1.0, 1.0];
        gain.normalise(&mut row, 0..3);
        assert!(row[1] > 0.9, "{row:?}");
    }

    #[test]
    fn cells_that_were_not_seen_are_even_and_outside() {
        let mut gain = Gain::new(10, 100);
        for _ in 0..30 {
            gain.learn(&[2.0; 10], 3..8);
        }
        let mut row = vec![4.0; 10];
        assert_eq!(gain.normalise(&mut row, 2..9), 3..8);
        assert_eq!(row, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 1.0]);
    }
}

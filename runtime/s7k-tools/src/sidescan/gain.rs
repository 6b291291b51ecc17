//! Brightness: amplitudes relative to what is usual at their range, on a logarithmic scale.
//!
//! A sonar's echo falls with range by orders of magnitude. For each column of range the median amplitude of the whole
//! recording is found (over a few neighbouring columns), and each amplitude is divided by it. What is half as strong as
//! usual is then equally dark near and far. What is usual becomes grey; of all ratios, the lowest 1 % become black and the
//! highest 0.2 % white, but black is at 6 to 18 dB below the usual and white at 6 to 12 dB above, so that neither a
//! picture without contrast nor one with a few extremes is spoilt.

use backseat_units::math::ln;

/// What amplitudes are divided by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GainBy {
    /// The median at the same range and side.
    #[default]
    Range,
    /// Nothing: brightness falls with range as the echo does.
    None,
}

/// Counts amplitudes by side, range and level.
#[derive(Debug)]
pub(crate) struct Gain {
    columns: usize,
    counts: [Vec<u32>; 2],
}

/// Turns an amplitude into a shade of grey.
#[derive(Debug)]
pub(crate) struct Scale {
    usual: [Vec<f64>; 2],
    /// Levels from the usual down to black, and up to white.
    black: f64,
    white: f64,
}

/// Levels: eight an octave of amplitude, from 1 to 2^32; below 1 is level 0.
const PER_OCTAVE: f64 = 8.0;
const LEVELS: usize = 32 * 8 + 2;
/// Shares of all ratios below black and below white.
const BLACK: f64 = 0.01;
const WHITE: f64 = 0.998;
/// Where black and white may be, levels from the usual: octaves of amplitude, which are 6 dB each.
const BLACK_RANGE: [f64; 2] = [PER_OCTAVE, 3.0 * PER_OCTAVE];
const WHITE_RANGE: [f64; 2] = [PER_OCTAVE, 2.0 * PER_OCTAVE];
/// The shade of what is usual.
const USUAL_SHADE: f64 = 110.0;
/// Neighbours on each side that count for a column's median: one column in so many.
const NEIGHBOURS: usize = 64;

fn level(amplitude: f32) -> f64 {
    if amplitude < 1.0 {
        0.0
    } else {
        1.0 + PER_OCTAVE * ln(f64::from(amplitude)) / core::f64::consts::LN_2
    }
}

impl Gain {
    pub(crate) fn new(columns: usize) -> Self {
        Self {
            columns,
            counts: [vec![0; columns * LEVELS], vec![0; columns * LEVELS]],
        }
    }

    /// Counts a row. Columns without a sample do not count.
    pub(crate) fn add(&mut self, side: usize, row: &[f32]) {
        for (column, amplitude) in row.iter().enumerate().filter(|(_, amplitude)| amplitude.is_finite()) {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 257")]
            let level = (level(*amplitude) as usize).min(LEVELS - 1);
            let count = &mut self.counts[side][column * LEVELS + level];
            *count = count.saturating_add(1);
        }
    }

    pub(crate) fn finish(&self, by: GainBy) -> Scale {
        let usual = match by {
            GainBy::Range => [self.medians(0), self.medians(1)],
            GainBy::None => {
                let median = self.median();
                [vec![median; self.columns], vec![median; self.columns]]
            }
        };
        let mut ratios = vec![0_u64; 2 * LEVELS];
        for (side, usual) in usual.iter().enumerate() {
            for (column, usual) in usual.iter().enumerate() {
                for (level, count) in self
                    .column(side, column)
                    .iter()
                    .enumerate()
                    .filter(|(_, count)| **count > 0)
                {
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        clippy::cast_precision_loss,
                        reason = "0 to 2 LEVELS"
                    )]
                    let ratio =
                        (level as f64 + 0.5 - usual + LEVELS as f64).clamp(0.0, 2.0 * LEVELS as f64 - 1.0) as usize;
                    ratios[ratio] += u64::from(*count);
                }
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "2 LEVELS")]
        let zero = LEVELS as f64;
        let below = zero - percentile(ratios.iter().copied(), BLACK).unwrap_or(zero);
        let above = percentile(ratios.iter().copied(), WHITE).unwrap_or(zero) - zero;
        let (black, white) = match by {
            GainBy::Range => (
                below.clamp(BLACK_RANGE[0], BLACK_RANGE[1]),
                above.clamp(WHITE_RANGE[0], WHITE_RANGE[1]),
            ),
            // The fall with range is in the picture: it needs all that there is.
            GainBy::None => (below.max(1.0), above.max(1.0)),
        };
        Scale { usual, black, white }
    }

    /// The median level of everything.
    fn median(&self) -> f64 {
        let mut sum = vec![0_u64; LEVELS];
        for counts in self.counts.iter().flat_map(|counts| counts.chunks(LEVELS)) {
            for (sum, count) in sum.iter_mut().zip(counts) {
                *sum += u64::from(*count);
            }
        }
        percentile(sum.iter().copied(), 0.5).unwrap_or(0.0)
    }

    fn column(&self, side: usize, column: usize) -> &[u32] {
        &self.counts[side][column * LEVELS..(column + 1) * LEVELS]
    }

    /// The median level of each column with its neighbours; that of the nearest column before where there is none.
    fn medians(&self, side: usize) -> Vec<f64> {
        let reach = (self.columns / NEIGHBOURS).max(1);
        let mut sum = vec![0_u64; LEVELS];
        let mut medians = Vec::with_capacity(self.columns);
        let mut last = 0.0;
        for column in 0..self.columns + reach {
            if column < self.columns {
                for (sum, count) in sum.iter_mut().zip(self.column(side, column)) {
                    *sum += u64::from(*count);
                }
            }
            if let Some(gone) = column.checked_sub(2 * reach + 1) {
                for (sum, count) in sum.iter_mut().zip(self.column(side, gone)) {
                    *sum -= u64::from(*count);
                }
            }
            if column >= reach {
                last = percentile(sum.iter().copied(), 0.5).unwrap_or(last);
                medians.push(last);
            }
        }
        medians
    }
}

/// The place in a row of counts below which a share of them lies; `None` if there are none.
#[expect(clippy::cast_precision_loss, reason = "a place needs no more digits")]
fn percentile(counts: impl Iterator<Item = u64> + Clone, share: f64) -> Option<f64> {
    let all: u64 = counts.clone().sum();
    let wanted = share * all as f64;
    let mut below = 0.0;
    for (index, count) in counts.enumerate() {
        let count = count as f64;
        if count > 0.0 && below + count >= wanted {
            return Some(index as f64 + (wanted - below) / count);
        }
        below += count;
    }
    None
}

impl Scale {
    /// The shade of an amplitude: 1 (black) to 255 (white), or 0 where there is none.
    pub(crate) fn shade(&self, side: usize, column: usize, amplitude: f32) -> f32 {
        if !amplitude.is_finite() {
            return 0.0;
        }
        let usual = self.usual[side].get(column).copied().unwrap_or(0.0);
        let off = level(amplitude) - usual;
        let shade = if off < 0.0 {
            USUAL_SHADE - (USUAL_SHADE - 1.0) * (-off / self.black).min(1.0)
        } else {
            USUAL_SHADE + (255.0 - USUAL_SHADE) * (off / self.white).min(1.0)
        };
        #[expect(clippy::cast_possible_truncation, reason = "1 to 255")]
        let shade = shade as f32;
        shade
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_usual_at_its_range_has_the_same_shade_near_and_far() {
        let mut gain = Gain::new(100);
        // The echo falls to a thousandth; one row in a hundred is four times as strong.
        let usual = |column: usize| 100_000.0 / ((column + 1) * (column + 1)) as f32;
        for row in 0..400 {
            let speckle = 0.5 + (row % 20) as f32 / 20.0;
            let row: Vec<f32> = (0..100).map(|column| usual(column) * speckle).collect();
            gain.add(0, &row);
        }
        let scale = gain.finish(GainBy::Range);
        // Steep near the vehicle, where the neighbours differ much: compare from the fourth column on.
        let near = scale.shade(0, 4, usual(4));
        let far = scale.shade(0, 99, usual(99));
        assert!((near - far).abs() < 30.0, "{near} {far}");
        assert!((far - 110.0).abs() < 40.0, "{far}");
        assert_eq!(
            (scale.shade(0, 50, 4.0 * usual(50)), scale.shade(0, 50, 0.0)),
            (255.0, 1.0)
        );
        assert_eq!(scale.shade(0, 50, f32::NAN), 0.0);
        let none = gain.finish(GainBy::None);
        assert!(none.shade(0, 4, usual(4)) > none.shade(0, 99, usual(99)) + 100.0);
    }

    #[test]
    fn nothing_counted_is_no_division_by_zero() {
        let scale = Gain::new(3).finish(GainBy::Range);
        assert!(scale.shade(1, 2, 7.0).is_finite());
    }
}

use serde::{Deserialize, Serialize};

use super::look::Band;

/// Distances that are this near to each other are the same, metres.
const JOIN_M: f64 = 1e-6;

/// Lays parallel lines across an area one by one, by what the lines before have seen. Distances are metres across.
///
/// It works along one dimension: it knows which distances the lines have seen over their whole length, from `from_m` on.
/// What single places have missed is the map's to know. See the [module](super) for why lines come in pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    from_m: f64,
    to_m: f64,
    /// Gaps narrower than this are left.
    leave_m: f64,
    /// The distances that were seen, in order, without overlaps.
    seen: Vec<(f64, f64)>,
}

impl Sweep {
    /// A sweep from one distance to a greater one. Gaps of less than `leave_m` across are not worth a line of their own:
    /// they are left to short lines that fill gaps.
    #[must_use]
    pub fn new(from_m: f64, to_m: f64, leave_m: f64) -> Self {
        Self {
            from_m,
            to_m: to_m.max(from_m),
            leave_m: leave_m.max(JOIN_M),
            seen: Vec::new(),
        }
    }

    /// All from its begin up to here was seen.
    #[must_use]
    pub fn frontier_m(&self) -> f64 {
        match self.seen.first() {
            Some((from_m, to_m)) if *from_m <= self.from_m + self.leave_m => *to_m,
            Some(_) | None => self.from_m,
        }
    }

    /// Whether everything was seen.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.frontier_m() >= self.to_m - self.leave_m
    }

    /// What was not seen between two parts that were: from the frontier to where the next one begins. `None` if nothing
    /// beyond the frontier was seen.
    #[must_use]
    pub fn hole_m(&self) -> Option<(f64, f64)> {
        let frontier_m = self.frontier_m();
        let beyond = self.seen.iter().find(|(from_m, _)| *from_m > frontier_m);
        beyond.map(|(from_m, _)| (frontier_m, from_m.min(self.to_m)))
    }

    /// A line was flown. `low` is what it has seen towards smaller distances, `high` towards greater ones.
    pub fn flown(&mut self, across_m: f64, low: Band, high: Band) {
        self.add(across_m - low.outer_m, across_m - low.inner_m);
        self.add(across_m + high.inner_m, across_m + high.outer_m);
    }

    /// Counts everything between two distances as seen: it is given up.
    pub fn skip(&mut self, from_m: f64, to_m: f64) {
        self.add(from_m, to_m);
    }

    /// Where the next line lies if both of its sides see as much as `expected`, and what is seen by two lines shall
    /// overlap by so much. `None` if everything was seen, or if such a line would see nothing new.
    #[must_use]
    pub fn next(&self, expected: Band, overlap_m: f64) -> Option<f64> {
        let Band { inner_m, outer_m } = expected;
        let frontier_m = self.frontier_m();
        // What a line adds whose own gap lies in what was seen before.
        let near_m = expected.width_m() - overlap_m;
        if self.is_done() || near_m <= 0.0 {
            return None;
        }
        // The side towards smaller distances begins before the frontier, or at the edge of the area.
        let before_m = if frontier_m > self.from_m {
            frontier_m - overlap_m
        } else {
            frontier_m
        };
        let beyond = self.seen.iter().find(|(from_m, _)| *from_m > frontier_m);
        if let Some((from_m, to_m)) = beyond
            && *from_m < self.to_m
        {
            // The second of a pair: it sees the gap of the first by its low side, and its own gap was seen. It goes as
            // far out as both allow.
            let least_m = from_m + overlap_m + inner_m;
            let most_m = (before_m + outer_m).min(to_m - overlap_m - inner_m);
            if most_m >= least_m {
                return Some(most_m);
            }
            // Without the overlaps, if that is enough.
            let least_m = from_m + inner_m;
            let most_m = (frontier_m + outer_m).min(to_m - inner_m);
            return Some(if most_m >= least_m {
                0.5 * (least_m + most_m)
            } else {
                before_m - inner_m
            });
        }
        // What is seen of the area by a single line with its own gap outside what is left.
        let left_m = beyond.map_or(self.to_m, |(from_m, _)| from_m.min(self.to_m)) - frontier_m;
        if left_m <= expected.width_m() {
            // With as much overlap as there is room for.
            let end_m = frontier_m + left_m;
            return Some((end_m - outer_m).clamp(before_m - inner_m, frontier_m - inner_m));
        }
        // The first of a pair. The last pair is moved back, so that it ends at the edge of the area and not beyond it.
        let pair_m = 2.0 * outer_m - inner_m - overlap_m;
        Some((before_m + outer_m).min((self.to_m - pair_m).max(before_m + 2.0 * inner_m)))
    }

    fn add(&mut self, from_m: f64, to_m: f64) {
        let (mut from_m, mut to_m) = (from_m.max(self.from_m), to_m);
        if to_m.is_nan() || from_m >= to_m {
            return;
        }
        self.seen.retain(|(other_from_m, other_to_m)| {
            let apart = *other_to_m < from_m - self.leave_m || *other_from_m > to_m + self.leave_m;
            if !apart {
                from_m = from_m.min(*other_from_m);
                to_m = to_m.max(*other_to_m);
            }
            apart
        });
        let place = self.seen.partition_point(|(other_m, _)| *other_m < from_m);
        self.seen.insert(place, (from_m, to_m));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn lines_come_in_pairs() {
        let band = Band {
            inner_m: 10.0,
            outer_m: 60.0,
        };
        let mut sweep = Sweep::new(0.0, 1000.0, 0.0);
        let mut lines = Vec::new();
        while let Some(across_m) = sweep.next(band, 5.0) {
            lines.push(across_m);
            sweep.flown(across_m, band, band);
        }
        // 60 from the edge, 45 to the second of the pair, 115 to the next pair, and the last pair ends at the edge.
        assert_eq!(lines[..5], [60.0, 105.0, 220.0, 265.0, 380.0]);
        assert_eq!(lines.len(), 13);
        assert!(sweep.is_done());
        // With even spacing, the neighbours of a line see its gap if they are as near as they reach.
        assert!(lines.len() < (1000.0_f64 / 60.0).ceil() as usize);
    }

    #[test]
    fn a_small_rest_takes_one_line_inside_what_was_seen() {
        let band = Band {
            inner_m: 10.0,
            outer_m: 60.0,
        };
        let mut sweep = Sweep::new(0.0, 200.0, 0.0);
        sweep.flown(60.0, band, band);
        sweep.flown(105.0, band, band);
        assert_eq!(sweep.frontier_m(), 165.0);
        assert_eq!(sweep.hole_m(), None);
        assert_eq!(sweep.next(band, 5.0), Some(150.0));
        sweep.flown(150.0, band, band);
        assert_eq!((sweep.is_done(), sweep.next(band, 5.0)), (true, None));
    }

    #[test]
    fn a_narrow_swath_brings_the_next_line_nearer() {
        let wide = Band {
            inner_m: 10.0,
            outer_m: 60.0,
        };
        let narrow = Band {
            inner_m: 20.0,
            outer_m: 45.0,
        };
        let mut sweep = Sweep::new(0.0, 1000.0, 0.0);
        sweep.flown(60.0, wide, narrow);
        // The gap from 50 to 80 is seen by the low side of a line whose own gap lies before 105, if it can be.
        assert_eq!(sweep.next(narrow, 5.0), Some(25.0));
        // A wide one fits between 90 and 95, but without overlap.
        assert_eq!(sweep.next(wide, 5.0), Some(92.5));
    }

    #[test]
    fn a_gap_too_narrow_for_a_line_is_left() {
        let band = Band {
            inner_m: 10.0,
            outer_m: 60.0,
        };
        let short = Band {
            inner_m: 10.0,
            outer_m: 53.0,
        };
        for (leave_m, next_m) in [(3.0, 265.0), (0.0, 195.0)] {
            let mut sweep = Sweep::new(0.0, 1000.0, leave_m);
            sweep.flown(60.0, band, band);
            sweep.flown(105.0, band, band);
            // It has missed the 2 m behind 165.
            sweep.flown(220.0, short, band);
            assert_eq!(sweep.next(band, 5.0), Some(next_m));
        }
    }

    #[test]
    fn a_swath_without_width_has_no_next_line() {
        let sweep = Sweep::new(0.0, 100.0, 0.0);
        assert_eq!(
            sweep.next(
                Band {
                    inner_m: 30.0,
                    outer_m: 34.0
                },
                5.0
            ),
            None
        );
        assert_eq!(sweep.next(Band::default(), 0.0), None);
        assert!(Sweep::new(5.0, 5.0, 0.0).is_done());
    }

    proptest! {
        /// Whatever the lines achieve, each new line sees something new or there is none, and the sweep ends.
        #[test]
        fn every_line_advances(
            to_m in 50.0..2000.0f64, inner_m in 0.0..25.0f64, outer_m in 40.0..150.0f64, overlap_m in 0.0..10.0f64,
            achieved in proptest::collection::vec((0.7..1.1f64, 0.9..1.3f64), 200),
        ) {
            let expected = Band { inner_m, outer_m };
            let mut sweep = Sweep::new(0.0, to_m, 0.0);
            let mut lines = 0;
            for (reach, gap) in achieved {
                let Some(across_m) = sweep.next(expected, overlap_m) else { break };
                let before = sweep.clone();
                let band = Band { inner_m: inner_m * gap, outer_m: outer_m * reach };
                sweep.flown(across_m, band, band);
                prop_assert!(across_m < to_m + outer_m && across_m > -outer_m, "{across_m}");
                if sweep == before {
                    // It has achieved too little to see anything new: what it should have seen is given up.
                    sweep.skip(across_m - outer_m, across_m + outer_m);
                }
                prop_assert!(sweep != before);
                lines += 1;
            }
            prop_assert!(sweep.is_done() || lines == 200, "{sweep:?}");
        }

        /// If every line sees what was expected, everything is seen, by few lines.
        #[test]
        fn a_constant_swath_covers_everything(
            to_m in 50.0..3000.0f64, inner_m in 0.0..25.0f64, outer_m in 80.0..150.0f64, overlap_m in 0.0..10.0f64,
        ) {
            let band = Band { inner_m, outer_m };
            let mut sweep = Sweep::new(0.0, to_m, 0.0);
            let mut lines = 0.0;
            while let Some(across_m) = sweep.next(band, overlap_m) {
                sweep.flown(across_m, band, band);
                lines += 1.0;
                prop_assert!(lines < 100.0);
            }
            prop_assert!(sweep.is_done(), "{sweep:?}");
            let advance_m = 3.0 * outer_m - inner_m - 2.0 * overlap_m;
            prop_assert!(lines <= 2.0 * (to_m / advance_m).ceil() + 1.0, "{lines} lines");
        }
    }
}

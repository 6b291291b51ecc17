//! Highlights and shadows in one row of cells.

use core::ops::Range;

use serde::{Deserialize, Serialize};

use crate::sonar::cells::Cells;
use crate::sonar::chance::{Chance, LooksMeter};
use crate::sonar::settings::DetectorSettings;

/// Cells count as at most this many times the mean in a reference, so that an object beside it changes it little: a
/// trimmed mean, as in the ordered statistics of Rohling 1983.
const TRIM: f32 = 4.0;
/// Ratios count as at most this in the measure of looks.
const RATIO_MAX: f64 = 3.0;
/// The intensity of a shadow over that of the seabed that the search for its ends assumes: noise, and what comes in from
/// beside the object.
const DARK: f32 = 0.25;
/// The search for the end of a shadow stops after this much evidence against it: three cells of even seabed.
const AGAINST: f32 = 5.0;
/// A cell that is so much brighter than the seabed belongs to a highlight.
const EDGE: f64 = 2.0;
/// Seabed between a highlight and its shadow, metres at most.
const BETWEEN_M: f64 = 0.5;
/// Rows that a measure of looks covers.
const LOOKS_ROWS: u32 = 400;
/// Thresholds follow the measured looks after so many rows.
const RENEW_ROWS: u32 = 50;

/// A highlight and its shadow, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    pub(super) highlight: (usize, usize),
    pub(super) shadow: (usize, usize),
    pub(super) brighter: f64,
    pub(super) darker: f64,
    pub(super) score: f64,
    pub(super) cut: bool,
}

/// Searches rows of one side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RowSearch {
    highlight: usize,
    highlight_max: usize,
    shadow: usize,
    shadow_max: usize,
    reference: usize,
    between: usize,
    chance: Chance,
    /// The least ratio of a highlight, and the greatest of a shadow.
    bright: f64,
    dark: f64,
    highlights: LooksMeter,
    shadows: LooksMeter,
    rows: u32,
    thresholds: Thresholds,
    #[serde(skip)]
    sums: Vec<f64>,
    #[serde(skip)]
    trimmed: Vec<f64>,
}

/// What a row is compared with, for the looks that were measured last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Thresholds {
    /// Looks of a highlight, and of the shortest shadow.
    looks: (f64, f64),
    /// A highlight is brighter than this.
    high: f64,
    /// A shadow of at least so many cells is darker than this; by length.
    low: Vec<(usize, f64)>,
}

impl RowSearch {
    pub(super) fn new(settings: &DetectorSettings, cells: &Cells) -> Self {
        // Half of the probability's digits are the highlight's, half the shadow's.
        let chance = Chance {
            probability: settings.false_alarm.sqrt(),
        };
        Self {
            highlight: cells.across(settings.highlight_m),
            highlight_max: cells.across(settings.highlight_max_m),
            shadow: cells.across(settings.shadow_m),
            shadow_max: cells.across(settings.shadow_max_m),
            reference: cells.across(settings.reference_m),
            between: cells.across(BETWEEN_M),
            chance,
            bright: backseat_units::math::pow(10.0, settings.highlight_db / 10.0),
            dark: backseat_units::math::pow(10.0, -settings.shadow_db / 10.0),
            highlights: LooksMeter::new(LOOKS_ROWS),
            shadows: LooksMeter::new(LOOKS_ROWS),
            rows: 0,
            thresholds: Thresholds::default(),
            sums: Vec::new(),
            trimmed: Vec::new(),
        }
    }

    /// The mean over some cells.
    fn mean(sums: &[f64], cells: Range<usize>) -> f64 {
        (sums[cells.end] - sums[cells.start]) / (cells.end - cells.start) as f64
    }

    /// The seabed on the near side of a cell; `None` too near to the first cell.
    fn seabed(&self, cell: usize, first: usize) -> Option<f64> {
        let end = cell.checked_sub(self.between)?;
        let start = end.saturating_sub(self.reference).max(first);
        (end >= start + self.reference / 2 && end > start)
            .then(|| Self::mean(&self.trimmed, start..end))
            .filter(|mean| *mean > 1e-6)
    }

    fn sum(&mut self, row: &[f32]) {
        self.sums.clear();
        self.trimmed.clear();
        let (mut sum, mut trimmed) = (0.0, 0.0);
        self.sums.push(sum);
        self.trimmed.push(trimmed);
        for cell in row {
            sum += f64::from(*cell);
            trimmed += f64::from(cell.min(TRIM));
            self.sums.push(sum);
            self.trimmed.push(trimmed);
        }
    }

    /// Measures the looks in a row that is steady and known, and follows them with the thresholds.
    pub(super) fn learn(&mut self, row: &[f32], known: Range<usize>) {
        self.sum(row);
        let measured = [self.highlight, self.shadow].map(|length| {
            let (mut mean, mut square, mut count) = (0.0, 0.0, 0u32);
            for cell in known.start..known.end.saturating_sub(length) {
                let Some(seabed) = self.seabed(cell, known.start) else {
                    continue;
                };
                let ratio = (Self::mean(&self.sums, cell..cell + length) / seabed).min(RATIO_MAX);
                mean += ratio;
                square += ratio * ratio;
                count += 1;
            }
            (count > 0).then(|| (mean / f64::from(count), square / f64::from(count)))
        });
        for (meter, measured) in [&mut self.highlights, &mut self.shadows].into_iter().zip(measured) {
            if let Some((mean, square)) = measured {
                meter.row(mean, square);
            }
        }
        self.rows = self.rows.wrapping_add(1);
        if self.thresholds.high == 0.0 || self.rows.is_multiple_of(RENEW_ROWS) {
            self.renew();
        }
    }

    fn renew(&mut self) {
        let more = |length: usize| self.reference as f64 / length as f64;
        let looks = self
            .highlights
            .looks(more(self.highlight))
            .zip(self.shadows.looks(more(self.shadow)));
        let Some((highlight, shadow)) = looks else { return };
        let high = self.chance.above(highlight, highlight * more(self.highlight));
        // A shadow that is longer has more looks, up to those of the reference.
        let mut low = Vec::new();
        let mut length = self.shadow;
        while length <= self.shadow_max {
            let has = shadow * length as f64 / self.shadow as f64;
            let below = self.chance.below(has, shadow * more(self.shadow));
            low.push((length, below.min(self.dark)));
            length = (length + length / 2).max(length + 1);
        }
        self.thresholds = Thresholds {
            looks: (highlight, shadow),
            high: high.max(self.bright),
            low,
        };
    }

    /// Looks of a highlight and of the shortest shadow, as the imagery has them; 0 before they are known.
    pub(super) fn looks(&self) -> (f64, f64) {
        self.thresholds.looks
    }

    /// Finds highlights that shadows follow, from the near end on.
    pub(super) fn search(&mut self, row: &[f32], known: Range<usize>, from: usize, found: &mut Vec<Found>) {
        if self.thresholds.high == 0.0 {
            return;
        }
        self.sum(row);
        let mut cell = known.start.max(from);
        let end = known.end;
        while cell + self.highlight + self.shadow <= end {
            let Some(seabed) = self.seabed(cell, known.start) else {
                cell += 1;
                continue;
            };
            let ratio = Self::mean(&self.sums, cell..cell + self.highlight) / seabed;
            if ratio <= self.thresholds.high {
                cell += 1;
                continue;
            }
            let highlight = self.highlight_at(row, cell, seabed, end);
            // Behind a highlight without a shadow the search goes on: inside, the reference would be the highlight itself.
            cell = highlight.1 + 1;
            if let Some(object) = self.object(row, highlight, seabed, end) {
                cell = object.shadow.1.max(cell);
                found.push(object);
            }
        }
    }

    /// The first and the last cell of the highlight that begins at a cell: it goes on while its cells are clearly brighter than
    /// the seabed, and a few darker ones may be inside.
    fn highlight_at(&self, row: &[f32], first: usize, seabed: f64, end: usize) -> (usize, usize) {
        let bright = |cell: usize| f64::from(row[cell]) > EDGE * seabed;
        let start = (first..first + self.highlight)
            .find(|cell| bright(*cell))
            .unwrap_or(first);
        let mut last = start;
        for cell in start..end.min(start + self.highlight_max) {
            if bright(cell) {
                last = cell;
            } else if cell > last + self.between {
                break;
            }
        }
        (start, last)
    }

    /// The object with a highlight, if a shadow follows it.
    fn object(&self, row: &[f32], (start, last): (usize, usize), seabed: f64, end: usize) -> Option<Found> {
        let mut brighter = 0.0_f64;
        for cell in start..=last.min(end.saturating_sub(self.highlight)) {
            brighter = brighter.max(Self::mean(&self.sums, cell..cell + self.highlight) / seabed);
        }
        let (from, to) = self.shadow_of(row, start, last, seabed, end)?;
        let length = to - from;
        if length < self.shadow {
            return None;
        }
        let darker = Self::mean(&self.sums, from..to) / seabed;
        let low = self.thresholds.low.iter().rev().find(|(least, _)| *least <= length)?.1;
        if darker > low {
            return None;
        }
        let (highlight, shadow) = self.thresholds.looks;
        let evidence =
            |looks: f64, ratio: f64| looks * (ratio - 1.0 - backseat_units::math::ln(ratio.max(1e-6))).max(0.0);
        Some(Found {
            highlight: (start, from.min(last + 1)),
            shadow: (from, to),
            brighter,
            darker,
            // A highlight is never so bright that its shadow does not matter.
            score: evidence(highlight, brighter.min(10.0))
                + evidence(shadow * length as f64 / self.shadow as f64, darker),
            cut: to + 1 >= end,
        })
    }

    /// The ends of the shadow behind a highlight: the run of cells with the greatest sum of log-likelihood ratios of
    /// shadow against seabed. That is the cumulative sum of Page 1954 ("Continuous inspection schemes", *Biometrika* 41),
    /// which begins anew where it falls to 0.
    fn shadow_of(&self, row: &[f32], start: usize, last: usize, seabed: f64, end: usize) -> Option<(usize, usize)> {
        let for_shadow = -backseat_units::math::ln(f64::from(DARK)) as f32;
        let against = (1.0 / DARK - 1.0) / seabed as f32;
        let (mut sum, mut from) = (0.0_f32, start + 1);
        let (mut best, mut ends) = (0.0_f32, None);
        let until = end.min(last + self.between + self.shadow_max);
        for (cell, intensity) in row.iter().enumerate().take(until).skip(start + 1) {
            sum += for_shadow - against * intensity;
            if sum <= 0.0 {
                if cell > last + self.between {
                    break;
                }
                (sum, from) = (0.0, cell + 1);
            } else if sum > best {
                best = sum;
                ends = Some((from, cell + 1));
            } else if sum < best - AGAINST && ends.is_some_and(|(first, _)| first == from) {
                if cell > last {
                    break;
                }
                (sum, from) = (0.0, cell + 1);
            }
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CELLS: Cells = Cells {
        cell_m: 0.25,
        count: 300,
    };

    /// A search that knows an even seabed with little speckle.
    fn search() -> RowSearch {
        let mut search = RowSearch::new(&DetectorSettings::default(), &CELLS);
        for row in 0..100_u32 {
            let cells: Vec<f32> = (0..300_u32)
                .map(|cell| 1.0 + 0.3 * (((row * 7919 + cell * 104_729) % 1000) as f32 / 500.0 - 1.0))
                .collect();
            search.learn(&cells, 0..300);
        }
        search
    }

    fn found(row: &[f32]) -> Vec<Found> {
        let mut found = Vec::new();
        search().search(row, 0..300, 28, &mut found);
        found
    }

    proptest! {
        #[test]
        fn an_object_is_found_where_it_is(
            at in 60_usize..200, highlight in 2_usize..20, shadow in 5_usize..60,
            bright in 12.0..1e4_f32, dark in 0.0..0.2_f32,
        ) {
            let mut row = vec![1.0; 300];
            row[at..at + highlight].fill(bright);
            row[at + highlight..at + highlight + shadow].fill(dark);
            let found = found(&row);
            prop_assert_eq!(found.len(), 1);
            let object = found[0];
            prop_assert!(object.highlight.0.abs_diff(at) <= 1, "{object:?}");
            prop_assert_eq!(object.shadow, (at + highlight, at + highlight + shadow));
            prop_assert!(!object.cut && object.score > 20.0);
        }

        #[test]
        fn neither_a_highlight_nor_a_shadow_alone_is_an_object(
            at in 60_usize..200, length in 2_usize..30, bright in 3.0..1e4_f32, dark in 0.0..0.3_f32,
        ) {
            let mut row = vec![1.0; 300];
            row[at..at + length].fill(bright);
            prop_assert_eq!(found(&row), vec![]);
            row[at..at + length].fill(dark);
            prop_assert_eq!(found(&row), vec![]);
            // And not a shadow far behind a highlight.
            row[at..at + length].fill(1.0);
            row[at - 10..at - 8].fill(bright);
            row[at..at + length].fill(dark);
            prop_assert_eq!(found(&row), vec![]);
        }

        #[test]
        fn no_row_breaks_it(row in prop::collection::vec(prop::num::f32::POSITIVE | prop::num::f32::ZERO, 300)) {
            let mut found = Vec::new();
            let mut search = search();
            search.learn(&row, 3..298);
            search.search(&row, 3..298, 0, &mut found);
            prop_assert!(found.iter().all(|object| object.shadow.1 <= 298 && object.shadow.0 < object.shadow.1));
        }
    }

    /// Speckle alone passes each of the two thresholds as often as the stated probability says.
    #[test]
    fn false_alarms_are_as_frequent_as_stated() {
        let settings = DetectorSettings {
            false_alarm: 1e-4,
            highlight_db: 0.0,
            shadow_db: 0.0,
            ..DetectorSettings::default()
        };
        for looks in [3_u32, 12] {
            let mut state = 88_172_645_463_325_252_u64;
            let mut row = || -> Vec<f32> {
                let mut exponential = || {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    -backseat_units::math::ln(((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64) as f32
                };
                (0..300)
                    .map(|_| (0..looks).map(|_| exponential()).sum::<f32>() / looks as f32)
                    .collect()
            };
            let mut search = RowSearch::new(&settings, &CELLS);
            for _ in 0..400 {
                search.learn(&row(), 0..300);
            }
            let (mut high, mut low, mut all) = (0, 0, 0);
            for _ in 0..2000 {
                search.sum(&row());
                for cell in 40..290 {
                    let seabed = search.seabed(cell, 0).unwrap();
                    let mean = |length: usize| RowSearch::mean(&search.sums, cell..cell + length) / seabed;
                    high += u32::from(mean(search.highlight) > search.thresholds.high);
                    low += u32::from(mean(search.shadow) < search.thresholds.low[0].1);
                    all += 1;
                }
            }
            // The root of the stated probability for each.
            let rates = [high, low].map(|count| f64::from(count) / f64::from(all));
            assert!(
                rates.iter().all(|rate| (0.004..0.02).contains(rate)),
                "{looks} looks: {rates:?}"
            );
        }
    }

    #[test]
    fn a_shadow_that_reaches_the_end_is_cut() {
        let mut row = vec![1.0; 300];
        row[270..274].fill(50.0);
        row[274..300].fill(0.02);
        let found = found(&row);
        assert!(found[0].cut && found[0].shadow == (274, 300), "{found:?}");
    }
}

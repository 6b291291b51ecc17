use super::look::Band;
use super::map::CoverageMap;

/// What [`CoverageMap::best_fill`] looks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillWish {
    /// How many lines shall have seen each place, 1 to 3.
    pub times: u8,
    /// The edges of the swath are not counted on, metres.
    pub overlap_m: f64,
    /// The shortest line, metres.
    pub length_min_m: f64,
    /// The way to a line and onto it, metres: each line costs its own length and this.
    pub overhead_m: f64,
    /// A line is worth its way if it sees more than this for the first time, square metres a metre of way.
    pub worth_m2_per_m: f64,
}

/// A short line that fills gaps: in the map's axes, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Where it lies across.
    pub across_m: f64,
    /// Where it begins along, at the smaller value.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
    /// What it should see for the first time, square metres.
    pub gain_m2: f64,
}

impl CoverageMap {
    /// The line along the map's axes that is worth most: what it sees for the first time, less its way times
    /// [`FillWish::worth_m2_per_m`]. `None` if no line is worth its way.
    ///
    /// `band` says what a line at a distance across sees to each side. For each row of the map, the best part of a line
    /// in its middle is found by Kadane's algorithm (J. Bentley, "Programming Pearls: Algorithm Design Techniques",
    /// *Communications of the ACM* 27 (1984)). The work grows with the number of cells, and the memory is four bytes a
    /// cell while it runs.
    #[must_use]
    pub fn best_fill(&self, wish: &FillWish, band: impl Fn(f64) -> Band) -> Option<Fill> {
        let (columns, rows) = self.shape();
        let cell_m2 = self.cell_m() * self.cell_m();
        // How many cells of a column are wanted in all rows before a row.
        let mut before = vec![0_u32; columns * (rows + 1)];
        for row in 0..rows {
            for column in 0..columns {
                let index = row * columns + column;
                before[index + columns] = before[index] + u32::from(self.is_wanted(index, wish.times));
            }
        }
        let cost_m2 = wish.worth_m2_per_m * self.cell_m();
        let mut best: Option<(f64, Fill)> = None;
        for row in 0..rows {
            let across_m = self.corner((0, row)).across_m + 0.5 * self.cell_m();
            let Band { inner_m, outer_m } = band(across_m);
            let (inner_m, outer_m) = (inner_m + wish.overlap_m, outer_m - wish.overlap_m);
            if outer_m <= inner_m {
                continue;
            }
            let low = self.rows_between(across_m - outer_m, across_m - inner_m);
            let high = self.rows_between(across_m + inner_m, across_m + outer_m);
            let seen_m2 = |column: usize| {
                let cells = |rows: &core::ops::Range<usize>| {
                    before[rows.end * columns + column] - before[rows.start * columns + column]
                };
                f64::from(cells(&low) + cells(&high)) * cell_m2
            };
            let Some((value_m2, gain_m2, from, to)) = best_run(columns, seen_m2, cost_m2) else {
                continue;
            };
            let value_m2 = value_m2 - wish.overhead_m * wish.worth_m2_per_m;
            if value_m2 > 0.0 && best.is_none_or(|(most_m2, _)| value_m2 > most_m2) {
                let (from_m, to_m) = (self.corner((from, 0)).along_m, self.corner((to, 0)).along_m);
                let longer_m = (0.5 * (wish.length_min_m - (to_m - from_m))).max(0.0);
                best = Some((
                    value_m2,
                    Fill {
                        across_m,
                        from_m: from_m - longer_m,
                        to_m: to_m + longer_m,
                        gain_m2,
                    },
                ));
            }
        }
        best.map(|(_, fill)| fill)
    }
}

/// The run of columns that is worth most: its worth, what it gains, and its begin and end.
fn best_run(columns: usize, gain: impl Fn(usize) -> f64, cost: f64) -> Option<(f64, f64, usize, usize)> {
    let mut best: Option<(f64, f64, usize, usize)> = None;
    let (mut worth, mut gained, mut from) = (0.0, 0.0, 0);
    for column in 0..columns {
        if worth <= 0.0 {
            (worth, gained, from) = (0.0, 0.0, column);
        }
        let gain = gain(column);
        gained += gain;
        worth += gain - cost;
        if worth > best.map_or(0.0, |best| best.0) {
            best = Some((worth, gained, from, column + 1));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use backseat_units::EastNorth;

    use super::super::area::{Area, Axes, Place};
    use super::super::look::{Look, Strip};
    use super::*;

    const BAND: Band = Band {
        inner_m: 10.0,
        outer_m: 60.0,
    };
    const WISH: FillWish = FillWish {
        times: 1,
        overlap_m: 5.0,
        length_min_m: 40.0,
        overhead_m: 100.0,
        worth_m2_per_m: 5.0,
    };

    fn map() -> CoverageMap {
        let area = Area::rectangle(EastNorth::default(), 90.0, 600.0, 300.0).unwrap();
        CoverageMap::new(&area, Axes::new(EastNorth::default(), 90.0), 5.0).unwrap()
    }

    fn fly(map: &mut CoverageMap, across_m: f64, from_m: f64, to_m: f64) {
        let look = |along_m| Look {
            at_ns: 0,
            at: map.axes().local(Place { along_m, across_m }),
            bearing_deg: 90.0,
            port: BAND,
            starboard: BAND,
        };
        let strip = Strip {
            from: look(from_m),
            to: look(to_m),
        };
        map.begin_line();
        map.mark(&strip);
    }

    #[test]
    fn a_gap_is_filled_from_beside_it() {
        let mut map = map();
        // All is seen but the gap below the line at 0 between 100 and 200 m.
        for across_m in [-130.0, -85.0, 0.0, 85.0, 130.0] {
            fly(&mut map, across_m, -300.0, 300.0);
        }
        for across_m in [-30.0, 30.0] {
            fly(&mut map, across_m, -300.0, 100.0);
            fly(&mut map, across_m, 200.0, 300.0);
        }
        let gaps = map.gaps(1, 100.0);
        assert!(gaps.iter().any(|gap| gap.size_m2 == 2000.0), "{gaps:?}");
        let fill = map.best_fill(&WISH, |_| BAND).unwrap();
        assert!(fill.gain_m2 >= 2000.0, "{fill:?}");
        assert!(
            fill.from_m <= 100.0 && fill.to_m >= 200.0 && fill.to_m - fill.from_m <= 110.0,
            "{fill:?}"
        );
        assert!((25.0..=55.0).contains(&fill.across_m.abs()), "{fill:?}");
        fly(&mut map, fill.across_m, fill.from_m, fill.to_m);
        assert_eq!(map.extent(-10.0, 10.0, 1), None);
    }

    #[test]
    fn what_is_not_worth_its_way_is_left() {
        let mut map = map();
        for across_m in [-105.0, -60.0, -30.0, 30.0, 60.0, 105.0] {
            fly(&mut map, across_m, -300.0, if across_m == 60.0 { 280.0 } else { 300.0 });
        }
        assert!(map.part(1) > 0.9);
        let left = map.best_fill(
            &FillWish {
                worth_m2_per_m: 200.0,
                ..WISH
            },
            |_| BAND,
        );
        assert_eq!(left, None);
        assert_eq!(
            map.best_fill(&WISH, |_| Band {
                inner_m: 10.0,
                outer_m: 19.0
            }),
            None
        );
        assert!(map.best_fill(&FillWish { times: 3, ..WISH }, |_| BAND).is_some());
    }

    #[test]
    fn an_empty_map_asks_for_a_whole_line_and_a_short_one_is_made_longer() {
        let fill = map().best_fill(&WISH, |_| BAND).unwrap();
        assert_eq!((fill.from_m, fill.to_m), (-300.0, 300.0));
        let long = FillWish {
            length_min_m: 800.0,
            ..WISH
        };
        let fill = map().best_fill(&long, |_| BAND).unwrap();
        assert_eq!((fill.from_m, fill.to_m), (-400.0, 400.0));
    }
}

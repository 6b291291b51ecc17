use backseat_units::EastNorth;
use serde::{Deserialize, Serialize};

use super::{Line, Rectangle};

/// The most cells of a grid. A snapshot with a byte a cell must stay well below 1 MiB.
const CELLS_MAX: f64 = 250_000.0;

/// A grid over a rectangle that counts how often each cell was seen, up to 255 times. A cell counts as seen at its
/// centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoverageGrid {
    area: Rectangle,
    cell_m: f64,
    rows: usize,
    columns: usize,
    /// Row by row along the length, from the port side.
    counts: Vec<u8>,
}

impl CoverageGrid {
    /// A grid of cells of `cell_m` metres. The last row and column may reach over the edges of the rectangle.
    ///
    /// # Errors
    /// One line, if the cells are not above 0 m, or more than 250,000.
    pub fn new(area: Rectangle, cell_m: f64) -> Result<Self, String> {
        let cells = |metres: f64| (metres / cell_m - 1e-9).ceil().max(1.0);
        let (rows, columns) = (cells(area.length_m()), cells(area.width_m()));
        let count = rows * columns;
        if cell_m.is_nan() || cell_m <= 0.0 || count.is_nan() || count > CELLS_MAX {
            return Err(format!(
                "cells of {cell_m} m: an area of {:.0} by {:.0} m must have at most {CELLS_MAX:.0} of them",
                area.length_m(),
                area.width_m()
            ));
        }
        Ok(Self {
            area,
            cell_m,
            rows: rows as usize,
            columns: columns as usize,
            counts: vec![0; count as usize],
        })
    }

    /// Counts what a sensor saw that moved along a line and looks so many metres to port and to starboard. Returns how
    /// many cells were seen for the first time.
    pub fn see(&mut self, way: &Line, port_m: f64, starboard_m: f64) -> usize {
        let length_m = way.length_m();
        let reach_m = port_m.max(starboard_m).max(0.0) + self.cell_m;
        let ((a, b), (c, d)) = (self.area.axes(way.start), self.area.axes(way.end));
        let from = |metres: f64, half_m: f64, count: usize| self.between(metres + half_m, count);
        let (half_length_m, half_width_m) = (self.area.length_m() / 2.0, self.area.width_m() / 2.0);
        let rows =
            from(a.min(c) - reach_m, half_length_m, self.rows)..=from(a.max(c) + reach_m, half_length_m, self.rows);
        let columns =
            from(b.min(d) - reach_m, half_width_m, self.columns)..=from(b.max(d) + reach_m, half_width_m, self.columns);
        let mut new = 0;
        for row in rows {
            for column in columns.clone() {
                let centre = self.centre_of(row, column);
                let across_m = way.across_m(centre);
                if (0.0..=length_m).contains(&way.along_m(centre)) && -port_m <= across_m && across_m <= starboard_m {
                    let count = &mut self.counts[row * self.columns + column];
                    new += usize::from(*count == 0);
                    *count = count.saturating_add(1);
                }
            }
        }
        new
    }

    /// The row or column of a coordinate, counted from the first, within the grid.
    fn between(&self, metres: f64, count: usize) -> usize {
        ((metres / self.cell_m).floor().max(0.0) as usize).min(count - 1)
    }

    fn centre_of(&self, row: usize, column: usize) -> EastNorth {
        self.area.point(
            (row as f64 + 0.5) * self.cell_m - self.area.length_m() / 2.0,
            (column as f64 + 0.5) * self.cell_m - self.area.width_m() / 2.0,
        )
    }

    /// How often the cell at a place was seen; `None` outside the grid.
    #[must_use]
    pub fn seen(&self, at: EastNorth) -> Option<u8> {
        let (along_m, across_m) = self.area.axes(at);
        let cell = |metres: f64, half_m: f64, count: usize| {
            let cell = ((metres + half_m) / self.cell_m).floor();
            (0.0..count as f64).contains(&cell).then_some(cell as usize)
        };
        let row = cell(along_m, self.area.length_m() / 2.0, self.rows)?;
        let column = cell(across_m, self.area.width_m() / 2.0, self.columns)?;
        self.counts.get(row * self.columns + column).copied()
    }

    /// How much of the rectangle was seen at least once, percent.
    #[must_use]
    pub fn percent(&self) -> f64 {
        let seen = self.counts.iter().filter(|count| **count > 0).count();
        100.0 * seen as f64 / self.counts.len() as f64
    }

    /// The centres of the cells that were not seen.
    pub fn unseen(&self) -> impl Iterator<Item = EastNorth> {
        let cells = self.counts.iter().enumerate().filter(|(_, count)| **count == 0);
        cells.map(|(index, _)| self.centre_of(index / self.columns, index % self.columns))
    }

    /// How many cells a sensor would see for the first time on a line, as [`CoverageGrid::see`], which changes the grid.
    #[must_use]
    pub fn would_see(&self, way: &Line, port_m: f64, starboard_m: f64) -> usize {
        let length_m = way.length_m();
        let unseen = self.unseen().filter(|centre| {
            let across_m = way.across_m(*centre);
            (0.0..=length_m).contains(&way.along_m(*centre)) && -port_m <= across_m && across_m <= starboard_m
        });
        unseen.count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    /// 100 m to the east, 40 m wide, around the origin: 10 by 4 cells.
    fn grid() -> CoverageGrid {
        CoverageGrid::new(Rectangle::new(at(0.0, 0.0), 100.0, 40.0, 90.0), 10.0).unwrap()
    }

    fn eastwards(north_m: f64) -> Line {
        Line {
            start: at(-50.0, north_m),
            end: at(50.0, north_m),
        }
    }

    #[test]
    fn a_sensor_sees_what_lies_beside_its_way() {
        let mut grid = grid();
        // The two rows of cells to port of the middle: north of it.
        assert_eq!(grid.would_see(&eastwards(0.0), 20.0, 0.0), 20);
        assert_eq!(grid.see(&eastwards(0.0), 20.0, 0.0), 20);
        assert_eq!(grid.percent(), 50.0);
        assert_eq!(grid.seen(at(3.0, 3.0)), Some(1));
        assert_eq!(grid.seen(at(3.0, -3.0)), Some(0));
        assert_eq!(grid.seen(at(3.0, -23.0)), None);
        assert_eq!(grid.see(&eastwards(0.0), 20.0, 10.0), 10);
        assert_eq!(grid.seen(at(3.0, 3.0)), Some(2));
        let unseen: Vec<EastNorth> = grid.unseen().collect();
        assert_eq!(unseen.len(), 10);
        assert!(
            unseen.iter().all(|centre| (centre.north_m + 15.0).abs() < 1e-9),
            "{unseen:?}"
        );
        // Half of a line, the other way.
        let back = Line {
            start: at(0.0, -20.0),
            end: at(-50.0, -20.0),
        };
        assert_eq!(grid.see(&back, 0.0, 20.0), 5);
        assert_eq!(grid.percent(), 87.5);
    }

    #[test]
    fn a_way_outside_of_the_grid_sees_nothing() {
        let mut grid = grid();
        assert_eq!(grid.see(&eastwards(500.0), 20.0, 20.0), 0);
        assert_eq!(grid.see(&eastwards(f64::NAN), 20.0, 20.0), 0);
        for _ in 0..300 {
            grid.see(&eastwards(0.0), 20.0, 20.0);
        }
        assert_eq!(grid.seen(at(3.0, 3.0)), Some(255));
    }

    #[test]
    fn too_many_cells_are_refused() {
        let area = Rectangle::new(at(0.0, 0.0), 1000.0, 1000.0, 0.0);
        assert!(CoverageGrid::new(area, 2.0).is_ok());
        assert_eq!(
            CoverageGrid::new(area, 1.0).unwrap_err(),
            "cells of 1 m: an area of 1000 by 1000 m must have at most 250000 of them"
        );
        for cell_m in [0.0, -1.0, f64::NAN] {
            assert!(CoverageGrid::new(area, cell_m).is_err(), "{cell_m}");
        }
    }
}

use backseat_units::EastNorth;
use fixedbitset::FixedBitSet;
use serde::{Deserialize, Serialize};

use super::area::{Area, Axes, Place};
use super::look::{Band, Strip};

/// The most cells of a map.
const CELLS_MAX: usize = 1 << 18;
/// The most lines by which a cell is counted as seen.
pub(super) const TIMES_MAX: u8 = 3;
/// A cell whose middle is this near to the edge of a strip is in it, cells: the strips beside it have the same edge.
const ON_EDGE: f64 = 1e-9;

/// Why a map cannot be made, or not be restored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A cell size that is no length.
    #[error("cells of {0} m: expected 0.5 to 100 m")]
    Cell(f64),
    /// Too many cells.
    #[error("{0} cells: expected at most 262144; make the cells larger or the area smaller")]
    Cells(u64),
    /// No cell's middle is inside the area.
    #[error("the area is smaller than a cell")]
    Empty,
    /// The state is that of another map.
    #[error("the state is that of a map with other cells")]
    State,
}

/// How often each cell of an area was seen: a raster along [`Axes`].
///
/// A cell counts as seen if its middle is in a strip, and once a line (see [`CoverageMap::begin_line`]), at most three
/// times in all. The map needs two bytes a cell at most, and has at most 262144 cells.
#[derive(Clone, Debug)]
pub struct CoverageMap {
    axes: Axes,
    /// The corner with the least coordinates.
    first: Place,
    cell_m: f64,
    /// Cells along the lines, and across them.
    columns: usize,
    rows: usize,
    inside: FixedBitSet,
    counts: Vec<u8>,
    /// What the present line has seen.
    line: FixedBitSet,
    /// How many cells of the area were seen at least once, twice and three times.
    seen: [u32; TIMES_MAX as usize],
}

/// A connected part of the area that was not seen often enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Its size, square metres.
    pub size_m2: f64,
    /// The corner of the box around it with the least coordinates, in the map's axes.
    pub least: Place,
    /// The opposite corner.
    pub most: Place,
}

impl Gap {
    /// The box around it, as a polygon in the local frame.
    #[must_use]
    pub fn corners(&self, axes: &Axes) -> [EastNorth; 4] {
        let (least, most) = (self.least, self.most);
        let corner = |along_m, across_m| axes.local(Place { along_m, across_m });
        [
            corner(least.along_m, least.across_m),
            corner(most.along_m, least.across_m),
            corner(most.along_m, most.across_m),
            corner(least.along_m, most.across_m),
        ]
    }
}

impl CoverageMap {
    /// An empty map of an area, with square cells of a size of 0.5 to 100 m.
    ///
    /// # Errors
    /// [`MapError`] if the cells have another size, or if there are none or more than 262144.
    pub fn new(area: &Area, axes: Axes, cell_m: f64) -> Result<Self, MapError> {
        if !(0.5..=100.0).contains(&cell_m) {
            return Err(MapError::Cell(cell_m));
        }
        let places: Vec<Place> = area.corners().iter().map(|corner| axes.place(*corner)).collect();
        let span = |of: fn(&Place) -> f64| {
            let values = places.iter().map(of);
            let least = values.clone().fold(f64::INFINITY, f64::min);
            // Less than a millionth of a cell is rounding.
            (
                least,
                ((values.fold(f64::NEG_INFINITY, f64::max) - least) / cell_m - 1e-6)
                    .ceil()
                    .max(1.0),
            )
        };
        let (along_m, columns) = span(|place| place.along_m);
        let (across_m, rows) = span(|place| place.across_m);
        // An area reaches 50 km from its origin at most, so the product is exact.
        let cells = columns * rows;
        if cells > CELLS_MAX as f64 {
            return Err(MapError::Cells(cells as u64));
        }
        let (columns, rows) = (columns as usize, rows as usize);
        let mut map = Self {
            axes,
            first: Place { along_m, across_m },
            cell_m,
            columns,
            rows,
            inside: FixedBitSet::with_capacity(columns * rows),
            counts: vec![0; columns * rows],
            line: FixedBitSet::with_capacity(columns * rows),
            seen: [0; TIMES_MAX as usize],
        };
        for row in 0..rows {
            for column in 0..columns {
                let at = axes.local(map.middle(column, row));
                map.inside.set(row * columns + column, area.contains(at));
            }
        }
        if map.inside.is_clear() {
            Err(MapError::Empty)
        } else {
            Ok(map)
        }
    }

    /// The axes of its raster.
    #[must_use]
    pub const fn axes(&self) -> &Axes {
        &self.axes
    }

    /// The side of a cell, metres.
    #[must_use]
    pub const fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The corners of the raster with the least and the greatest coordinates.
    #[must_use]
    pub fn bounds(&self) -> (Place, Place) {
        let most = Place {
            along_m: self.first.along_m + self.columns as f64 * self.cell_m,
            across_m: self.first.across_m + self.rows as f64 * self.cell_m,
        };
        (self.first, most)
    }

    /// The size of the area by its cells, square metres.
    #[must_use]
    pub fn size_m2(&self) -> f64 {
        self.inside.count_ones(..) as f64 * self.cell_m * self.cell_m
    }

    /// The part of the area that at least so many lines have seen, 0 to 1. More than three lines count as three.
    #[must_use]
    pub fn part(&self, times: u8) -> f64 {
        let index = usize::from(times.clamp(1, TIMES_MAX)) - 1;
        f64::from(self.seen[index]) / self.inside.count_ones(..) as f64
    }

    /// A new line begins: what it sees counts once more.
    pub fn begin_line(&mut self) {
        self.line.clear();
    }

    /// Marks what a strip shows. Returns how many cells of the area this line sees for the first time.
    pub fn mark(&mut self, strip: &Strip) -> u32 {
        strip.triangles().map(|triangle| self.mark_triangle(triangle)).sum()
    }

    /// How many lines have seen the cell at a place; `None` outside the area.
    #[must_use]
    pub fn count_at(&self, place: Place) -> Option<u8> {
        let cell = |value_m: f64, first_m: f64| ((value_m - first_m) / self.cell_m).floor();
        let (column, row) = (
            cell(place.along_m, self.first.along_m),
            cell(place.across_m, self.first.across_m),
        );
        let is_in = (0.0..self.columns as f64).contains(&column) && (0.0..self.rows as f64).contains(&row);
        let index = is_in.then(|| row as usize * self.columns + column as usize)?;
        self.inside.contains(index).then(|| self.counts[index])
    }

    /// The connected parts of the area that fewer than `times` lines have seen, the largest first, without those below
    /// a size, square metres. Cells are connected by their sides.
    #[must_use]
    pub fn gaps(&self, times: u8, least_m2: f64) -> Vec<Gap> {
        let mut left = FixedBitSet::with_capacity(self.counts.len());
        left.extend((0..self.counts.len()).filter(|index| self.is_wanted(*index, times)));
        let mut gaps = Vec::new();
        let mut stack = Vec::new();
        while let Some(start) = left.minimum() {
            left.remove(start);
            stack.push(start);
            let mut cells = 0_u32;
            let (mut least, mut most) = ((self.columns, self.rows), (0, 0));
            while let Some(index) = stack.pop() {
                let (column, row) = (index % self.columns, index / self.columns);
                cells += 1;
                least = (least.0.min(column), least.1.min(row));
                most = (most.0.max(column + 1), most.1.max(row + 1));
                let beside = [
                    (column > 0).then(|| index - 1),
                    (column + 1 < self.columns).then(|| index + 1),
                    (row > 0).then(|| index - self.columns),
                    (row + 1 < self.rows).then(|| index + self.columns),
                ];
                for other in beside.into_iter().flatten() {
                    if left.contains(other) {
                        left.remove(other);
                        stack.push(other);
                    }
                }
            }
            gaps.push(Gap {
                size_m2: f64::from(cells) * self.cell_m * self.cell_m,
                least: self.corner(least),
                most: self.corner(most),
            });
        }
        gaps.retain(|gap| gap.size_m2 >= least_m2);
        gaps.sort_by(|one, other| other.size_m2.total_cmp(&one.size_m2));
        gaps
    }

    /// The segments of a line at `across_m` that fewer than `times` lines have seen: from and to, metres along. Empty
    /// beside the area.
    #[must_use]
    pub fn segments(&self, across_m: f64, times: u8) -> Vec<(f64, f64)> {
        let row = ((across_m - self.first.across_m) / self.cell_m).floor();
        if !(0.0..self.rows as f64).contains(&row) {
            return Vec::new();
        }
        let base = row as usize * self.columns;
        let mut segments: Vec<(f64, f64)> = Vec::new();
        let mut from = None;
        for column in 0..=self.columns {
            let wanted = column < self.columns && self.is_wanted(base + column, times);
            match (wanted, from) {
                (true, None) => from = Some(column),
                (false, Some(start)) => {
                    segments.push((self.corner((start, 0)).along_m, self.corner((column, 0)).along_m));
                    from = None;
                }
                (true, Some(_)) | (false, None) => {}
            }
        }
        segments
    }

    /// The part along the lines in which something between two distances across was seen by fewer than `times` lines:
    /// from and to, metres along. `None` if there is nothing.
    #[must_use]
    pub fn extent(&self, from_m: f64, to_m: f64, times: u8) -> Option<(f64, f64)> {
        let (mut least, mut most) = (self.columns, 0);
        for row in self.rows_between(from_m, to_m) {
            let wanted = |column: &usize| self.is_wanted(row * self.columns + column, times);
            if let Some(column) = (0..self.columns).find(wanted) {
                least = least.min(column);
                most = most.max((0..self.columns).rfind(wanted).map_or(column, |last| last + 1));
            }
        }
        (least < most).then(|| (self.corner((least, 0)).along_m, self.corner((most, 0)).along_m))
    }

    /// How much a line sees that fewer than `times` lines have seen, square metres: the line at a distance across, between
    /// two places along, with a band that it sees to each side.
    #[must_use]
    pub fn gain_m2(&self, across_m: f64, (from_m, to_m): (f64, f64), band: Band, times: u8) -> f64 {
        let column = |along_m: f64| {
            let column = ((along_m - self.first.along_m) / self.cell_m - 0.5).ceil();
            column.clamp(0.0, self.columns as f64) as usize
        };
        let columns = column(from_m)..column(to_m).max(column(from_m));
        let low = self.rows_between(across_m - band.outer_m, across_m - band.inner_m);
        let high = self.rows_between(across_m + band.inner_m, across_m + band.outer_m);
        let cells = low.chain(high).map(|row| {
            let wanted = |column: &usize| self.is_wanted(row * self.columns + column, times);
            columns.clone().filter(wanted).count()
        });
        cells.sum::<usize>() as f64 * self.cell_m * self.cell_m
    }

    /// What a snapshot of it needs. [`CoverageMap::set_state`] puts it into a map of the same area and cells.
    #[must_use]
    pub fn state(&self) -> MapState {
        let mut runs: Vec<(u8, u32)> = Vec::new();
        for (index, count) in self.counts.iter().enumerate() {
            let value = count * 2 + u8::from(self.line.contains(index));
            match runs.last_mut() {
                Some((last, length)) if *last == value => *length += 1,
                Some(_) | None => runs.push((value, 1)),
            }
        }
        MapState {
            columns: self.columns as u32,
            runs,
        }
    }

    /// Replaces what was seen by the state of another map of the same area and cells.
    ///
    /// # Errors
    /// [`MapError::State`] if the state has other cells. The map is then as it was.
    pub fn set_state(&mut self, state: &MapState) -> Result<(), MapError> {
        let cells: u64 = state.runs.iter().map(|(_, length)| u64::from(*length)).sum();
        let is_valid = state.runs.iter().all(|(value, _)| *value < (TIMES_MAX + 1) * 2);
        if cells != self.counts.len() as u64 || u64::from(state.columns) != self.columns as u64 || !is_valid {
            return Err(MapError::State);
        }
        let mut index = 0;
        self.line.clear();
        for (value, length) in &state.runs {
            for _ in 0..*length {
                self.counts[index] = value / 2;
                self.line.set(index, value % 2 == 1);
                index += 1;
            }
        }
        for times in 1..=TIMES_MAX {
            let seen = self.inside.ones().filter(|index| self.counts[*index] >= times).count();
            self.seen[usize::from(times) - 1] = seen as u32;
        }
        Ok(())
    }

    /// Whether a cell is inside the area and fewer lines have seen it.
    pub(super) fn is_wanted(&self, index: usize, times: u8) -> bool {
        self.inside.contains(index) && self.counts[index] < times
    }

    /// Cells along the lines, and across them.
    pub(super) const fn shape(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// The rows whose middles are between two distances across.
    pub(super) fn rows_between(&self, from_m: f64, to_m: f64) -> core::ops::Range<usize> {
        let row = |across_m: f64| {
            let row = ((across_m - self.first.across_m) / self.cell_m - 0.5).ceil();
            row.clamp(0.0, self.rows as f64) as usize
        };
        let from = row(from_m);
        from..row(to_m).max(from)
    }

    /// The corner of a cell with the least coordinates.
    pub(super) fn corner(&self, (column, row): (usize, usize)) -> Place {
        Place {
            along_m: self.first.along_m + column as f64 * self.cell_m,
            across_m: self.first.across_m + row as f64 * self.cell_m,
        }
    }

    fn middle(&self, column: usize, row: usize) -> Place {
        let corner = self.corner((column, row));
        Place {
            along_m: corner.along_m + 0.5 * self.cell_m,
            across_m: corner.across_m + 0.5 * self.cell_m,
        }
    }

    fn mark_triangle(&mut self, triangle: [EastNorth; 3]) -> u32 {
        // In cells from the middle of the first one.
        let corners = triangle.map(|at| {
            let place = self.axes.place(at);
            let cells = |value_m: f64, first_m: f64| (value_m - first_m) / self.cell_m - 0.5;
            (
                cells(place.along_m, self.first.along_m),
                cells(place.across_m, self.first.across_m),
            )
        });
        let least = corners.iter().map(|corner| corner.1).fold(f64::INFINITY, f64::min) - ON_EDGE;
        let most = corners.iter().map(|corner| corner.1).fold(f64::NEG_INFINITY, f64::max) + ON_EDGE;
        let end = |value: f64, count: usize| (value.floor() + 1.0).clamp(0.0, count as f64) as usize;
        let begin = |value: f64, count: usize| value.ceil().clamp(0.0, count as f64) as usize;
        let mut marked = 0;
        for row in begin(least, self.rows)..end(most, self.rows) {
            let Some((from, to)) = crossing(&corners, row as f64) else {
                continue;
            };
            for column in begin(from - ON_EDGE, self.columns)..end(to + ON_EDGE, self.columns) {
                marked += u32::from(self.see(row * self.columns + column));
            }
        }
        marked
    }

    /// Notes that the present line sees a cell. Returns whether it does so for the first time.
    fn see(&mut self, index: usize) -> bool {
        if !self.inside.contains(index) || self.line.put(index) {
            return false;
        }
        if let Some(seen) = self.seen.get_mut(usize::from(self.counts[index])) {
            self.counts[index] += 1;
            *seen += 1;
        }
        true
    }
}

/// What was seen, in runs of equal cells.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapState {
    columns: u32,
    /// Twice the count, and one more if the present line has seen it; and the number of cells.
    runs: Vec<(u8, u32)>,
}

/// Where a line at `y` crosses a triangle: from and to.
fn crossing(corners: &[(f64, f64); 3], y: f64) -> Option<(f64, f64)> {
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for (index, one) in corners.iter().enumerate() {
        let other = corners[(index + 1) % 3];
        let (low, high) = (one.1.min(other.1), one.1.max(other.1));
        if y < low - ON_EDGE || y > high + ON_EDGE {
            continue;
        }
        let part = if high > low {
            ((y - one.1) / (other.1 - one.1)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let x = one.0 + part * (other.0 - one.0);
        let ends = if high > low { [x, x] } else { [one.0, other.0] };
        from = ends.into_iter().fold(from, f64::min);
        to = ends.into_iter().fold(to, f64::max);
    }
    (from <= to).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::look::Look;
    use super::*;

    const BAND: Band = Band {
        inner_m: 10.0,
        outer_m: 50.0,
    };

    fn map(bearing_deg: f64) -> CoverageMap {
        let area = Area::rectangle(EastNorth::new(0.0, 0.0), bearing_deg, 400.0, 200.0).unwrap();
        CoverageMap::new(&area, Axes::new(EastNorth::new(0.0, 0.0), bearing_deg), 5.0).unwrap()
    }

    /// A flight along a line of the map's own axes, a look every so many metres.
    fn fly(map: &mut CoverageMap, bearing_deg: f64, across_m: f64, from_m: f64, to_m: f64, apart_m: f64) {
        map.begin_line();
        let steps = ((to_m - from_m).abs() / apart_m).ceil();
        let heading = bearing_deg + if to_m < from_m { 180.0 } else { 0.0 };
        let look = |step: f64| Look {
            at_ns: step as u64,
            at: map.axes.local(Place {
                along_m: from_m + (to_m - from_m) * step / steps,
                across_m,
            }),
            bearing_deg: heading,
            port: BAND,
            starboard: BAND,
        };
        let looks: Vec<Look> = (0..=steps as u32).map(|step| look(f64::from(step))).collect();
        for pair in looks.windows(2) {
            map.mark(&Strip {
                from: pair[0],
                to: pair[1],
            });
        }
    }

    #[test]
    fn a_line_sees_both_sides_but_not_what_is_below_it() {
        let mut map = map(30.0);
        fly(&mut map, 30.0, 0.0, -200.0, 200.0, 7.3);
        let at = |across_m| map.count_at(Place { along_m: 3.0, across_m });
        assert_eq!(
            (at(-52.0), at(-48.0), at(-12.0), at(-8.0)),
            (Some(0), Some(1), Some(1), Some(0))
        );
        assert_eq!(
            (at(8.0), at(12.0), at(48.0), at(52.0)),
            (Some(0), Some(1), Some(1), Some(0))
        );
        assert_eq!(at(103.0), None);
        assert!((map.part(1) - 0.4).abs() < 1e-9, "{}", map.part(1));
        // The gap below the line, and what is beside the swath.
        let gaps = map.gaps(1, 0.0);
        let sizes: Vec<f64> = gaps.iter().map(|gap| gap.size_m2).collect();
        assert_eq!(sizes, [20_000.0, 20_000.0, 8_000.0]);
        let near = |one: f64, other: f64| (one - other).abs() < 1e-6;
        assert!(near(gaps[2].least.across_m, -10.0) && near(gaps[2].most.across_m, 10.0));
        let [(from_m, to_m)] = map.segments(0.0, 1)[..] else {
            panic!("one segment is left")
        };
        assert!(near(from_m, -200.0) && near(to_m, 200.0));
        assert_eq!(map.segments(20.0, 1), []);
        assert_eq!(map.extent(-50.0, 50.0, 1), Some((from_m, to_m)));
        assert_eq!(map.extent(12.0, 48.0, 1), None);
        let middle = gaps[2]
            .corners(map.axes())
            .into_iter()
            .fold(EastNorth::default(), |sum, at| sum + at)
            * 0.25;
        assert!(middle.distance_m(EastNorth::default()) < 1e-9);
    }

    #[test]
    fn a_line_counts_once_however_often_it_looks() {
        let mut map = map(0.0);
        fly(&mut map, 0.0, 0.0, -100.0, 100.0, 1.0);
        fly(&mut map, 0.0, 0.0, 100.0, -50.0, 9.0);
        let at = |along_m| {
            map.count_at(Place {
                along_m,
                across_m: 30.0,
            })
        };
        assert_eq!(
            (at(-60.0), at(-40.0), at(90.0), at(110.0)),
            (Some(1), Some(2), Some(2), Some(0))
        );
        assert!(map.part(2) < map.part(1) && map.part(2) > 0.0);
        assert_eq!(map.segments(30.0, 2), [(-200.0, -50.0), (100.0, 200.0)]);
        // The near side of a line beside it sees nothing new, and its far side 30 m, where the area ends.
        assert_eq!(map.gain_m2(60.0, (-100.0, 100.0), BAND, 1), 200.0 * 30.0);
        assert_eq!(map.gain_m2(60.0, (-100.0, -90.0), BAND, 2), 10.0 * (40.0 + 30.0));
    }

    #[test]
    fn a_state_is_small_and_restores_the_map() {
        let mut map = map(12.0);
        fly(&mut map, 12.0, -40.0, -200.0, 200.0, 6.0);
        fly(&mut map, 12.0, 30.0, 200.0, 90.0, 6.0);
        let state = map.state();
        assert!(state.runs.len() < 400, "{}", state.runs.len());
        let mut other = self::map(12.0);
        other.set_state(&state).unwrap();
        assert_eq!((other.state(), other.seen), (state.clone(), map.seen));
        // Another flight over what the present line has seen adds nothing.
        let strip = |along_m: f64| Look {
            at_ns: 1,
            at: map.axes.local(Place {
                along_m,
                across_m: 30.0,
            }),
            bearing_deg: 12.0,
            port: BAND,
            starboard: BAND,
        };
        assert_eq!(
            other.mark(&Strip {
                from: strip(120.0),
                to: strip(150.0)
            }),
            0
        );
        let small = Area::rectangle(EastNorth::default(), 12.0, 400.0, 205.0).unwrap();
        let mut small = CoverageMap::new(&small, map.axes, 5.0).unwrap();
        assert_eq!(small.set_state(&state), Err(MapError::State));
    }

    #[test]
    fn maps_without_bound_are_refused() {
        let area = Area::rectangle(EastNorth::default(), 0.0, 5000.0, 5000.0).unwrap();
        let axes = Axes::new(EastNorth::default(), 0.0);
        assert_eq!(
            CoverageMap::new(&area, axes, 1.0).unwrap_err(),
            MapError::Cells(25_000_000)
        );
        assert!(matches!(
            CoverageMap::new(&area, axes, f64::NAN).unwrap_err(),
            MapError::Cell(_)
        ));
        assert!(CoverageMap::new(&area, axes, 10.0).is_ok());
    }

    proptest! {
        /// The raster agrees with the geometry: the middle of a cell is seen if and only if it is in a strip.
        #[test]
        fn cells_are_seen_as_the_geometry_says(
            bearing in -180.0..180.0f64, crab in -20.0..20.0f64, across in -90.0..90.0f64, apart in 1.0..25.0f64,
        ) {
            let mut map = map(bearing);
            let axes = map.axes;
            let look = |step: u32| Look {
                at_ns: u64::from(step),
                at: axes.local(Place { along_m: f64::from(step) * apart - 100.0, across_m: across }),
                bearing_deg: bearing + crab,
                port: BAND,
                starboard: BAND,
            };
            for step in 0..8 {
                map.mark(&Strip { from: look(step), to: look(step + 1) });
            }
            let (sin, cos) = backseat_units::math::sin_cos(crab.to_radians());
            for row in 0..map.rows {
                for column in 0..map.columns {
                    if !map.inside.contains(row * map.columns + column) {
                        continue;
                    }
                    let middle = map.middle(column, row);
                    // Along the track and out along the beam, which the crab angle turns.
                    let out_m = (middle.across_m - across) / cos;
                    let flown_m = middle.along_m + 100.0 + out_m * sin;
                    let inside = |slack: f64| {
                        (10.0 + slack..=50.0 - slack).contains(&out_m.abs()) && (slack..=8.0 * apart - slack).contains(&flown_m)
                    };
                    let seen = map.counts[row * map.columns + column] > 0;
                    prop_assert!(!inside(1e-6) || seen, "{column} {row} is not seen");
                    prop_assert!(inside(-1e-6) || !seen, "{column} {row} is seen");
                }
            }
        }
    }
}

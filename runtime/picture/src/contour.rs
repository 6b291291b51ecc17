//! Contours of a grid by marching squares (Lorensen and Cline, SIGGRAPH 1987, in two dimensions), joined into lines.

use crate::picture::Raster;

/// One contour line, in grid coordinates: x nodes from the west, y nodes from the south.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) closed: bool,
}

/// The contour lines of a raster at a value. They end at its border and at holes.
pub(crate) fn lines(raster: &Raster, value: f64) -> Vec<Line> {
    let field = Field {
        raster,
        value,
        border: 0,
    };
    field.chain()
}

/// The closed outlines of all ground at or above a value. Outlines of holes run in the opposite direction.
pub(crate) fn outlines(raster: &Raster, value: f64) -> Vec<Line> {
    let field = Field {
        raster,
        value,
        border: 1,
    };
    field.chain()
}

const NONE: u32 = u32::MAX;

/// A raster and a value. With a border of 1, a ring of low nodes lies on the outermost nodes (not beside them), and
/// holes are low, so that every outline closes.
struct Field<'a> {
    raster: &'a Raster,
    value: f64,
    border: usize,
}

impl Field<'_> {
    fn width(&self) -> usize {
        self.raster.width + 2 * self.border
    }

    fn height(&self) -> usize {
        self.raster.height + 2 * self.border
    }

    /// The value of a node; `None` if it belongs to the ring or a hole.
    fn node(&self, x: usize, y: usize) -> Option<f64> {
        let (x, y) = (x.checked_sub(self.border)?, y.checked_sub(self.border)?);
        if x >= self.raster.width || y >= self.raster.height {
            return None;
        }
        let value = *self.raster.values.get(y * self.raster.width + x)?;
        value.is_finite().then_some(value)
    }

    fn is_high(&self, x: usize, y: usize) -> bool {
        self.node(x, y).is_some_and(|node| node >= self.value)
    }

    /// The number of an edge: even for the edge to the east of a node, odd for the one to its north.
    fn edge(&self, x: usize, y: usize, north: bool) -> u32 {
        u32::try_from(2 * (y * self.width() + x) + usize::from(north)).unwrap_or(NONE)
    }

    /// The point where the contour crosses an edge.
    fn crossing(&self, edge: u32) -> (f64, f64) {
        let node = edge as usize / 2;
        let (x, y) = (node % self.width(), node / self.width());
        let (x2, y2) = if edge % 2 == 1 { (x, y + 1) } else { (x + 1, y) };
        let along = match (self.node(x, y), self.node(x2, y2)) {
            (Some(a), Some(b)) if a != b => ((self.value - a) / (b - a)).clamp(0.0, 1.0),
            // At a hole the ground extends halfway; on the ring both ends are at the same point.
            _ => 0.5,
        };
        let (a, b) = (self.place(x, y), self.place(x2, y2));
        (a.0 + along * (b.0 - a.0), a.1 + along * (b.1 - a.1))
    }

    fn place(&self, x: usize, y: usize) -> (f64, f64) {
        let place = |index: usize, count: usize| index.saturating_sub(self.border).min(count - 1) as f64;
        (place(x, self.raster.width), place(y, self.raster.height))
    }

    /// For each edge, the edge to which the contour runs from it, with the high ground on its left. Each edge is
    /// therefore left at most once and reached at most once.
    fn steps(&self) -> Vec<u32> {
        let mut next = vec![NONE; 2 * self.width() * self.height()];
        for y in 0..self.height() - 1 {
            for x in 0..self.width() - 1 {
                let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
                if self.border == 0 && corners.iter().any(|(x, y)| self.node(*x, *y).is_none()) {
                    continue;
                }
                let (south, east) = (self.edge(x, y, false), self.edge(x + 1, y, true));
                let (north, west) = (self.edge(x, y + 1, false), self.edge(x, y, true));
                let case = corners
                    .iter()
                    .enumerate()
                    .fold(0u8, |case, (bit, (x, y))| case | u8::from(self.is_high(*x, *y)) << bit);
                let mut step = |from: u32, to: u32| next[from as usize] = to;
                match case {
                    1 => step(south, west),
                    2 => step(east, south),
                    3 => step(east, west),
                    4 => step(north, east),
                    6 => step(north, south),
                    7 => step(north, west),
                    8 => step(west, north),
                    9 => step(south, north),
                    11 => step(east, north),
                    12 => step(west, east),
                    13 => step(south, east),
                    14 => step(west, south),
                    // At a saddle the middle decides whether the two high corners are connected.
                    5 | 10 => {
                        let sum: f64 = corners.iter().filter_map(|(x, y)| self.node(*x, *y)).sum();
                        let meet = sum / 4.0 >= self.value;
                        match (case, meet) {
                            (5, true) => (step(south, east), step(north, west)),
                            (5, false) => (step(south, west), step(north, east)),
                            (_, true) => (step(west, south), step(east, north)),
                            (_, false) => (step(east, south), step(west, north)),
                        };
                    }
                    _ => {}
                }
            }
        }
        next
    }

    fn chain(&self) -> Vec<Line> {
        let sound = self.raster.width >= 2
            && self.raster.height >= 2
            && self.raster.values.len() == self.raster.width * self.raster.height
            && self.raster.values.len() < (1 << 28);
        if !sound {
            return Vec::new();
        }
        let mut next = self.steps();
        let mut reached = vec![false; next.len()];
        for to in &next {
            if *to != NONE {
                reached[*to as usize] = true;
            }
        }
        let mut lines = Vec::new();
        // First the open lines from their beginnings, then the remaining loops.
        for loops in [false, true] {
            for first in 0..next.len() {
                if next[first] == NONE || (!loops && reached[first]) {
                    continue;
                }
                let mut edge = u32::try_from(first).unwrap_or(NONE);
                let mut points = vec![self.crossing(edge)];
                loop {
                    let to = std::mem::replace(&mut next[edge as usize], NONE);
                    if to == NONE {
                        break;
                    }
                    points.push(self.crossing(to));
                    edge = to;
                }
                let closed = edge as usize == first;
                lines.push(Line { points, closed });
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Extent, Palette};

    fn raster(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Raster {
        let nodes = (0..height).flat_map(|y| (0..width).map(move |x| (x as f64, y as f64)));
        Raster {
            extent: Extent {
                west_m: 0.0,
                south_m: 0.0,
                east_m: 1.0,
                north_m: 1.0,
            },
            width,
            height,
            values: nodes.map(|(x, y)| value(x, y)).collect(),
            label: String::new(),
            unit: String::new(),
            palette: Palette::Depth,
            highlight: None,
        }
    }

    fn area(line: &Line) -> f64 {
        let pairs = line.points.iter().zip(line.points.iter().cycle().skip(1));
        pairs.map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>() / 2.0
    }

    #[test]
    fn a_slope_has_one_straight_line() {
        let lines = lines(&raster(10, 5, |x, _| x), 3.25);
        assert_eq!(lines.len(), 1);
        assert!(!lines[0].closed);
        assert!(lines[0].points.iter().all(|(x, _)| (x - 3.25).abs() < 1e-9));
        assert_eq!(lines[0].points.len(), 5);
    }

    #[test]
    fn a_hill_has_one_ring_with_the_high_ground_on_its_left() {
        let lines = lines(
            &raster(41, 41, |x, y| -((x - 20.0) * (x - 20.0) + (y - 20.0) * (y - 20.0))),
            -100.0,
        );
        assert_eq!(lines.len(), 1);
        assert!(lines[0].closed);
        let expected = 100.0 * std::f64::consts::PI;
        assert!((area(&lines[0]) - expected).abs() < 3.0, "{}", area(&lines[0]));
    }

    #[test]
    fn outlines_cover_what_is_high_up_to_the_border() {
        let covered = |value: f64| -> f64 { outlines(&raster(11, 6, |x, _| x), value).iter().map(area).sum() };
        assert!((covered(-1.0) - 50.0).abs() < 1e-9, "{}", covered(-1.0));
        assert!((covered(5.0) - 25.0).abs() < 1e-9, "{}", covered(5.0));
        assert_eq!(covered(10.5), 0.0);
        let all = outlines(&raster(11, 6, |x, _| x), 5.0);
        assert!(all.iter().all(|line| line.closed));
    }

    #[test]
    fn saddles_and_holes_break_nothing() {
        let checker = raster(9, 9, |x, y| if (x + y) % 2.0 == 0.0 { 1.0 } else { 0.0 });
        for value in [0.4, 0.5, 0.6] {
            assert!(outlines(&checker, value).iter().all(|line| line.closed));
        }
        let holed = raster(9, 9, |x, y| if x == 4.0 && y == 4.0 { f64::NAN } else { x });
        assert!(outlines(&holed, 2.5).iter().all(|line| line.closed));
        assert!(lines(&holed, 4.0).len() >= 2, "the line stops at the hole");
        assert!(outlines(&raster(4, 4, |_, _| f64::NAN), 0.0).is_empty());
        assert!(lines(&raster(1, 4, |x, _| x), 0.0).is_empty());
        let mut short = raster(4, 4, |x, _| x);
        short.values.pop();
        assert!(lines(&short, 1.5).is_empty());
    }
}

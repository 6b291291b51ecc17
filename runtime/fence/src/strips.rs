//! An index over the edges of a polygon: boxes in directions of their own, each around a stretch of the outline.
//!
//! A stretch of a coast is much longer than it is wide, and seldom runs along an axis, so that a box turned with it is
//! a far better bound than an upright one: the idea of strip trees (Ballard, CACM 24(5), 1981). Consecutive edges lie
//! beside each other in the plane, so that no sorting is needed to build it. A node keeps the boxes of its children
//! side by side, number by number, for the compiler to take several at a time.

use backseat_units::EastNorth;
use parry2d_f64::math::Vector;

use crate::distance::vector;

/// Children of a node.
pub(crate) const WIDTH: usize = 4;

/// Edges to a leaf.
const RUN: usize = 4;

/// Boxes are taken that much larger, metres: the rounding errors of turning are a thousandth of it.
const ROUNDING_M: f64 = 1e-8;

/// Places for nodes that wait. A million vertices are at most 400,000 runs (two for a ring of five edges), which make ten
/// levels; of each but the lowest at most three children wait, so that 31 places would do.
const WAITING: usize = 48;

/// What fills the places of absent children: farther away than everything.
const ABSENT_M: f64 = -1e200;

/// The boxes of a node's children. A box's own coordinates are those of the plane, turned so that the first runs along
/// (`along_x`, `along_y`), a vector of length one.
#[derive(Clone, Copy)]
pub(crate) struct Strips {
    along_x: [f64; WIDTH],
    along_y: [f64; WIDTH],
    /// The middle of the box, in its own coordinates, metres.
    middle_x: [f64; WIDTH],
    middle_y: [f64; WIDTH],
    /// Half of its length and of its width, metres.
    half_x: [f64; WIDTH],
    half_y: [f64; WIDTH],
    /// The first child: a leaf of the lowest nodes, a node of all others.
    first: u32,
}

/// Consecutive edges of one ring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    first: u32,
    count: u32,
}

/// The index.
#[derive(Clone)]
pub(crate) struct StripTree {
    runs: Vec<Run>,
    /// Level by level, the lowest first; the last one is the root.
    nodes: Vec<Strips>,
    /// How many nodes have runs for children.
    lowest: u32,
}

impl Run {
    /// The vertices of its edges, one more than there are edges, out of all.
    #[inline]
    pub(crate) fn vertices<'a>(&self, all: &'a [EastNorth]) -> &'a [EastNorth] {
        &all[self.first as usize..=(self.first + self.count) as usize]
    }

    #[inline]
    pub(crate) fn first_edge(&self) -> u32 {
        self.first
    }

    pub(crate) fn edges(&self) -> impl Iterator<Item = u32> + use<> {
        self.first..self.first + self.count
    }
}

impl StripTree {
    /// Of rings, each by its first edge and how many there are: near ones one after the other.
    pub(crate) fn new(vertices: &[EastNorth], rings: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut runs = Vec::new();
        for (first, edges) in rings {
            for offset in (0..edges).step_by(RUN) {
                runs.push(Run {
                    first: first + offset,
                    count: (edges - offset).min(RUN as u32),
                });
            }
        }
        let mut nodes: Vec<Strips> = Vec::new();
        // Of the level below: where its nodes begin, how many there are, and how many runs each of them has.
        let (mut below, mut children, mut runs_each) = (0, runs.len(), 1);
        loop {
            let begin = nodes.len();
            for first in (0..children).step_by(WIDTH) {
                let mut strips = Strips::absent((below + first) as u32);
                for child in first..children.min(first + WIDTH) {
                    let end = runs.len().min((child + 1) * runs_each);
                    strips.set(child - first, vertices, &runs[child * runs_each..end]);
                }
                nodes.push(strips);
            }
            let made = nodes.len() - begin;
            if made <= 1 {
                break;
            }
            (below, children, runs_each) = (begin, made, runs_each * WIDTH);
        }
        let lowest = runs.len().div_ceil(WIDTH) as u32;
        Self { runs, nodes, lowest }
    }

    /// Goes through the runs that may be nearer than the least squared distance that is known, which `visit` is given
    /// and gives back; those first that look nearest. `bound` is a lower bound of the squared distance to each box.
    #[inline]
    pub(crate) fn search(
        &self,
        below_m2: f64,
        bound: impl Fn(&Strips) -> [f64; WIDTH],
        mut visit: impl FnMut(&Run, f64) -> f64,
    ) {
        let mut least_m2 = below_m2;
        let mut waiting = [(0.0, 0_u32); WAITING];
        let mut count = 0;
        let mut node = self.nodes.len() as u32 - 1;
        loop {
            let strips = &self.nodes[node as usize];
            let bounds = bound(strips);
            // The farthest first, as they are taken from the end.
            let bottom = count;
            for (d2, child) in bounds.into_iter().zip(strips.first..) {
                if d2 < least_m2 {
                    let mut place = count;
                    while place > bottom && waiting[place - 1].0 < d2 {
                        waiting[place] = waiting[place - 1];
                        place -= 1;
                    }
                    waiting[place] = (d2, child);
                    count += 1;
                }
            }
            if node < self.lowest {
                while count > bottom {
                    count -= 1;
                    let (d2, run) = waiting[count];
                    if d2 >= least_m2 {
                        count = bottom;
                        break;
                    }
                    least_m2 = visit(&self.runs[run as usize], least_m2);
                }
            }
            loop {
                if count == 0 {
                    return;
                }
                count -= 1;
                if waiting[count].0 < least_m2 {
                    node = waiting[count].1;
                    break;
                }
            }
        }
    }
}

impl Strips {
    /// Where a point is from the middle of a box, in the box's coordinates.
    #[inline]
    pub(crate) fn off(&self, lane: usize, point: Vector) -> Vector {
        let turned = self.turn(lane, point);
        Vector::new(turned.x - self.middle_x[lane], turned.y - self.middle_y[lane])
    }

    /// A direction in the coordinates of a box.
    #[inline]
    pub(crate) fn turn(&self, lane: usize, v: Vector) -> Vector {
        let (x, y) = (self.along_x[lane], self.along_y[lane]);
        Vector::new(x * v.x + y * v.y, x * v.y - y * v.x)
    }

    /// Half of a box's length and of its width, metres.
    #[inline]
    pub(crate) fn half(&self, lane: usize) -> Vector {
        Vector::new(self.half_x[lane], self.half_y[lane])
    }

    fn absent(first: u32) -> Self {
        Self {
            along_x: [1.0; WIDTH],
            along_y: [0.0; WIDTH],
            middle_x: [0.0; WIDTH],
            middle_y: [0.0; WIDTH],
            half_x: [ABSENT_M; WIDTH],
            half_y: [ABSENT_M; WIDTH],
            first,
        }
    }

    /// The box of a child: along its chord or along an axis, whichever makes it smaller.
    fn set(&mut self, lane: usize, vertices: &[EastNorth], runs: &[Run]) {
        let own = |run: &Run| run.vertices(vertices);
        let (first, last) = (own(&runs[0]), own(&runs[runs.len() - 1]));
        let (from, to) = (vector(first[0]), vector(last[last.len() - 1]));
        // A ring's chord is nothing: halfway round it is something.
        let middle = vector(own(&runs[runs.len() / 2])[0]);
        let mut least_m = f64::INFINITY;
        for direction in [Vector::new(1.0, 0.0), to - from, middle - from] {
            let length = direction.length();
            if length < 1e-3 {
                continue;
            }
            let along = direction / length;
            let (mut min, mut max) = (Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY));
            for vertex in runs.iter().flat_map(own) {
                let turned = Vector::new(along.dot(vector(*vertex)), along.perp_dot(vector(*vertex)));
                (min, max) = (min.min(turned), max.max(turned));
            }
            let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5 + Vector::splat(ROUNDING_M));
            if half.x + half.y < least_m {
                least_m = half.x + half.y;
                (self.along_x[lane], self.along_y[lane]) = (along.x, along.y);
                (self.middle_x[lane], self.middle_y[lane]) = (middle.x, middle.y);
                (self.half_x[lane], self.half_y[lane]) = (half.x, half.y);
            }
        }
    }
}

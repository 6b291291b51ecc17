//! The seabed on one side as a row of nodes, and what it adds to the samples between them.

use super::bed::Bed;
use super::objects::{Met, Place};
use super::ranging::Ranging;
use crate::backscatter::Coefficients;

/// Nodes are this part of their slant range apart, so what they scatter changes little from one to the next: at a range
/// of many altitudes it falls with the square of the range, and a straight line from node to node is at most 1.2 percent
/// (0.05 dB) above that.
const SPACING: f64 = 0.125;
/// More nodes than any settings need.
const NODES_MAX: usize = 4096;

/// Where the fan crosses a patch: metres to starboard.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) enter_m: f64,
    pub(super) leave_m: f64,
    pub(super) coefficients: Coefficients,
}

/// A place on the seabed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    /// Metres outwards, and below the sonar.
    pub(super) out_m: f64,
    pub(super) below_m: f64,
    pub(super) slant_m: f64,
    /// Slopes of the seabed outwards and ahead: metres down a metre.
    pub(super) outwards: f64,
    pub(super) ahead: f64,
    /// Distance to the node before it, metres.
    pub(super) reach_m: f64,
    /// Whether the seabed nearer to the sonar leaves it in the open.
    pub(super) is_lit: bool,
    /// What it scatters back, square metres, but for the coefficients of its texture.
    pub(super) lambert: f64,
    pub(super) facets: f64,
    /// The place nearest to the horizontal, so far.
    horizon: Place,
}

/// Where the texture changes on one side, in order.
pub(super) fn edges(crossings: &[Crossing], side: f64, range_m: f64, edges: &mut Vec<f64>) {
    edges.clear();
    let both = crossings
        .iter()
        .flat_map(|crossing| [crossing.enter_m, crossing.leave_m]);
    edges.extend(
        both.map(|edge_m| side * edge_m)
            .filter(|edge_m| *edge_m > 0.0 && *edge_m < range_m),
    );
    edges.sort_by(f64::total_cmp);
}

/// Walks outwards over the seabed.
pub(super) fn walk(bed: &Bed, ranging: &Ranging, edges: &[f64], nodes: &mut Vec<Node>) {
    nodes.clear();
    let range_m = ranging.settings.range_m;
    let mut edges = edges.iter().copied().peekable();
    let mut out_m = 0.0;
    let mut horizon = Place::default();
    while nodes.len() < NODES_MAX {
        let (below_m, outwards, ahead) = bed.at(out_m);
        let place = Place { out_m, below_m };
        let slant_m = place.slant_m();
        let last = nodes.last().map_or(out_m, |node: &Node| node.out_m);
        let is_lit = nodes.is_empty() || place.clears(horizon);
        if is_lit {
            horizon = place;
        }
        nodes.push(Node {
            out_m,
            below_m,
            slant_m,
            outwards,
            ahead,
            reach_m: out_m - last,
            is_lit,
            lambert: 0.0,
            facets: 0.0,
            horizon,
        });
        if out_m >= range_m {
            break;
        }
        // Below the sonar the slant range hardly grows, so a node a sample is enough.
        let sample_m = (out_m * out_m + slant_m * ranging.sample_m).sqrt() - out_m;
        let mut next_m = out_m + (SPACING * slant_m).max(sample_m).min(bed.step_m());
        while edges.next_if(|edge_m| *edge_m <= out_m).is_some() {}
        if let Some(edge_m) = edges.next_if(|edge_m| *edge_m < next_m) {
            next_m = edge_m;
        }
        out_m = next_m.min(range_m);
    }
}

/// The part of the seabed that one pulse covers, square metres: as wide as the beam, and as long as what the pulse takes
/// along the seabed. `growth` is how fast the slant range grows along the seabed. Straight below the sonar, where it does
/// not grow, a pulse of the length Δ covers √(2 r Δ): Lurton, *An Introduction to Underwater Acoustics* (Springer 2010).
pub(super) fn area_m2(slant_m: f64, growth: f64, ranging: &Ranging) -> f64 {
    let straight_below_m = (2.0 * slant_m * ranging.pulse_m).sqrt();
    let length_m = (ranging.pulse_m / growth.max(1e-9)).min(straight_below_m);
    ranging.equivalent_rad * slant_m * length_m
}

/// Adds what the seabed scatters back. Where two pieces of it have the same slant range, both count.
pub(super) fn add(
    nodes: &[Node],
    crossings: &[Crossing],
    side: f64,
    base: Coefficients,
    ranging: &Ranging,
    power: &mut [f32],
) {
    for pair in nodes.windows(2) {
        let [one, other] = [&pair[0], &pair[1]];
        let middle_m = side * 0.5 * (one.out_m + other.out_m);
        let crossing = crossings
            .iter()
            .rev()
            .find(|crossing| crossing.enter_m <= middle_m && middle_m <= crossing.leave_m);
        let coefficients = crossing.map_or(base, |crossing| crossing.coefficients);
        let scatters = |node: &Node| coefficients.lambert * node.lambert + coefficients.reflected * node.facets;
        let (near, far) = if one.slant_m <= other.slant_m {
            (one, other)
        } else {
            (other, one)
        };
        let (from, to) = (scatters(near), scatters(far));
        if from + to <= 0.0 {
            continue;
        }
        let samples = ranging.samples(near.slant_m, far.slant_m);
        let slope = (to - from) / (far.slant_m - near.slant_m).max(1e-12);
        let first_m = (samples.start as f64 + 0.5) * ranging.sample_m - near.slant_m;
        let (first, step) = ((from + slope * first_m) as f32, (slope * ranging.sample_m) as f32);
        let heard = power[samples.clone()].iter_mut().zip(&ranging.scale[samples]);
        for (number, (power, scale)) in (0u16..).zip(heard) {
            *power += scale * (first + step * f32::from(number));
        }
    }
}

/// Whether the seabed leaves a place in the open.
pub(super) fn is_lit(nodes: &[Node], place: Place) -> bool {
    let nearer = nodes.partition_point(|node| node.out_m < place.out_m);
    nearer == 0 || place.clears(nodes[nearer - 1].horizon)
}

/// The shadow of a target on the seabed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    pub(super) met: Met,
    /// Slant ranges of the seabed that it covers, from the target's foot on, metres.
    pub(super) from_m: f64,
    pub(super) to_m: f64,
    /// Where it ends, metres outwards.
    end_m: f64,
    /// The part of the sound that passes beside it.
    pub(super) left: f64,
}

impl Shadow {
    pub(super) fn of(met: Met, bed: &Bed, nodes: &[Node], ranging: &Ranging) -> Self {
        let from_m = met.foot.slant_m();
        let apex = met.apex;
        if !met.has_shadow {
            return Self {
                met,
                from_m,
                to_m: from_m,
                end_m: apex.out_m,
                left: 1.0,
            };
        }
        // The ray over the apex passes over the seabed as long as this is positive.
        let over = |place: Place| apex.out_m * place.below_m - place.out_m * apex.below_m;
        let start = Place {
            out_m: apex.out_m,
            below_m: bed.at(apex.out_m).0,
        };
        let mut last = (start, over(start));
        for node in &nodes[nodes.partition_point(|node| node.out_m <= apex.out_m)..] {
            if last.1 <= 0.0 {
                break;
            }
            let place = Place {
                out_m: node.out_m,
                below_m: node.below_m,
            };
            let height = over(place);
            let part = if height < 0.0 { last.1 / (last.1 - height) } else { 1.0 };
            let between = |from: f64, to: f64| from + part * (to - from);
            let reached = Place {
                out_m: between(last.0.out_m, place.out_m),
                below_m: between(last.0.below_m, place.below_m),
            };
            last = (reached, height);
        }
        Self {
            met,
            from_m,
            to_m: last.0.slant_m(),
            end_m: last.0.out_m,
            left: 1.0 - met.hides(ranging.along_rad),
        }
    }

    /// Whether another target stands in it.
    pub(super) fn hides(&self, other: &Met) -> bool {
        let out_m = other.apex.out_m;
        self.met.has_shadow && out_m > self.met.apex.out_m && out_m < self.end_m && !other.apex.clears(self.met.apex)
    }
}

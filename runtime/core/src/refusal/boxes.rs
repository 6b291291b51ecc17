//! Boxes that a vehicle that hovers must keep within, or out of.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A box of `[limits.station]` that is left, or come into.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxBreach {
    /// The key of the box, `hull_box`, or the name of one to be kept out of.
    pub name: String,
    /// On which part of what the vehicle would do.
    pub stretch: Stretch,
    /// How many metres are missing; `None` for what is no number.
    pub missing_m: Option<f64>,
    /// The bound that is passed.
    pub edge: BoxEdge,
}

/// Where the vehicle would breach a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stretch {
    /// Where it is, and runs on to.
    Here,
    /// On its way.
    Way,
}

/// A bound of a box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxEdge {
    /// One that holds the vehicle: it may come to this place on the axis, metres.
    Kept {
        /// What the axis is called.
        axis: String,
        /// The key of the bound: `depth_max_m`.
        key: String,
        /// Where the vehicle may come to; `None` for what is no number.
        reached_m: Option<f64>,
        /// Where the bound is.
        bound_m: f64,
    },
    /// The nearest of one to be kept out of.
    Entered {
        /// The list of the box: `keep_out_hull`.
        list: String,
        /// The key of the bound: `depth_max_m`.
        key: String,
    },
}

impl fmt::Display for BoxBreach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stretch = match self.stretch {
            Stretch::Here => "where it is",
            Stretch::Way => "on its way",
        };
        let missing_m = self.missing_m.unwrap_or(f64::NAN);
        match &self.edge {
            BoxEdge::Kept {
                axis,
                key,
                reached_m: None,
                bound_m,
            } => write!(
                f,
                "{stretch}: {axis} is no finite number; {}'s {key} is {bound_m}",
                self.name
            ),
            BoxEdge::Kept {
                axis,
                key,
                reached_m: Some(reached_m),
                bound_m,
            } => write!(
                f,
                "{stretch}: {axis} may come to {:.2} m, {missing_m:.2} m beyond {}'s {key} {bound_m}",
                reached_m, self.name
            ),
            BoxEdge::Entered { list, key } => write!(
                f,
                "{stretch}: it may come {missing_m:.2} m into {list} '{}', over its {key}",
                self.name
            ),
        }
    }
}

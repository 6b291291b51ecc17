//! The boxes that a hovering vehicle must stay in or keep out of.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A breach of a box of `[limits.station]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxBreach {
    /// The key of an allowed box (`hull_box`), the name of a forbidden one, or `limits.station` for its least altitude.
    pub name: String,
    /// The part of the vehicle's movement that breaches it.
    pub stretch: Stretch,
    /// How many metres are missing; `None` if that is not a finite number.
    pub missing_m: Option<f64>,
    /// The bound that is breached.
    pub edge: BoxEdge,
}

/// Where the vehicle would breach a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stretch {
    /// Where it is, until it has stopped.
    Here,
    /// On its way.
    Way,
}

/// A bound of a box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxEdge {
    /// A bound of an allowed box.
    Kept {
        /// The name of the axis.
        axis: String,
        /// The key of the bound, such as `depth_max_m`.
        key: String,
        /// How far the vehicle may come on the axis, metres; `None` if that is not a finite number.
        reached_m: Option<f64>,
        /// The bound, metres.
        bound_m: f64,
    },
    /// The nearest bound of a forbidden box.
    Entered {
        /// The list of the box, such as `keep_out_hull`.
        list: String,
        /// The key of the bound, such as `depth_max_m`.
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
                "{stretch}: {axis} is not a finite number; {}'s {key} is {bound_m}",
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

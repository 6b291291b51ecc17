use serde::{Deserialize, Serialize};

/// The stages of the survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Stage {
    /// The lines of the first map.
    Map,
    /// The cross through the first estimate.
    Cross,
    /// The circle around the second estimate.
    Circle,
    /// Nothing is left to request.
    Done,
}

use core::fmt;

use super::client::ClientId;

/// The system that is adjusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdjustmentKind {
    /// Trim: pitch and roll.
    Trim,
    /// Variable buoyancy.
    Buoyancy,
}

/// What happened to an adjustment of trim or buoyancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdjustmentEvent {
    /// It began; `None` if the vehicle began it by itself.
    Began(AdjustmentKind, Option<ClientId>),
    /// It was completed.
    Completed(AdjustmentKind),
    /// It failed or was cancelled, for this reason.
    Failed(AdjustmentKind, &'static str),
}

impl AdjustmentKind {
    /// The behavior's type in BFMBS and BFMBE.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trim => "trim",
            Self::Buoyancy => "buoyancy",
        }
    }
}

impl fmt::Display for AdjustmentEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Began(kind, Some(client)) => write!(f, "{} adjustment of {client} began", kind.name()),
            Self::Began(kind, None) => write!(f, "{} adjustment by the vehicle itself began", kind.name()),
            Self::Completed(kind) => write!(f, "{} adjustment completed", kind.name()),
            Self::Failed(kind, why) => write!(f, "{} adjustment ended: {why}", kind.name()),
        }
    }
}

//! External sources: the operator's own programs that may send what no plugin may (SPI 7.14, 7.15, 7.21, 8.8, 8.9).
//!
//! An external source sends the sentence as it would send it to the vehicle. The runtime checks that the mission allows
//! it and that its values are in bounds, gives it a new timestamp, sends it, and answers with the vehicle's own BFACK.

use backseat_spi::{BearingOffset, PayloadCtd, PositionFix, RelativeReset, ToVehicle, TopsideRelay};
use serde::{Deserialize, Serialize};

use crate::ledger::RequestKind;

pub(crate) mod bounds;

pub use bounds::{ConductivityUnit, ExternalBounds};

/// A sentence that an external source may send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ExternalSentence {
    /// Topside message relay.
    #[serde(rename = "BPTMR")]
    Relay,
    /// Raw CTD data.
    #[serde(rename = "BPCTD")]
    PayloadCtd,
    /// Navigation position update.
    #[serde(rename = "BPNPU")]
    PositionFix,
    /// Reset of relative navigation.
    #[serde(rename = "BPRNS")]
    RelativeReset,
    /// Offset of the hull-relative bearing.
    #[serde(rename = "BPRBO")]
    BearingOffset,
}

impl ExternalSentence {
    /// The sentence of a message; `None` for a message that no external source may send.
    pub(crate) fn of(message: &ToVehicle) -> Option<Self> {
        match message.name() {
            TopsideRelay::NAME => Some(Self::Relay),
            PayloadCtd::NAME => Some(Self::PayloadCtd),
            PositionFix::NAME => Some(Self::PositionFix),
            RelativeReset::NAME => Some(Self::RelativeReset),
            BearingOffset::NAME => Some(Self::BearingOffset),
            _ => None,
        }
    }

    /// The three letters by which it is acknowledged.
    #[must_use]
    pub const fn letters(self) -> &'static str {
        match self {
            Self::Relay => "TMR",
            Self::PayloadCtd => "CTD",
            Self::PositionFix => "NPU",
            Self::RelativeReset => "RNS",
            Self::BearingOffset => "RBO",
        }
    }

    pub(crate) const fn kind(self) -> RequestKind {
        match self {
            Self::Relay => RequestKind::Relay,
            Self::PayloadCtd => RequestKind::PayloadCtd,
            Self::PositionFix => RequestKind::PositionFix,
            Self::RelativeReset => RequestKind::RelativeReset,
            Self::BearingOffset => RequestKind::BearingOffset,
        }
    }
}

/// An external source of the mission: a `[[external]]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExternalSetup {
    /// Its name in the mission.
    pub name: String,
    /// What it may send.
    pub sends: Vec<ExternalSentence>,
    /// The values that it may send, and how often.
    #[serde(default)]
    pub bounds: ExternalBounds,
}

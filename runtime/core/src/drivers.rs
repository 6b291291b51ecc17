//! Configured drivers: the operator's own programs that feed what no plugin may (SPI 7.14, 7.15, 7.21, 8.8, 8.9).
//!
//! A driver speaks the sentence that it wants sent, as it would to the vehicle; the runtime checks that the mission lets
//! it, bounds it, stamps it anew, sends it, and answers with the vehicle's own BFACK.

use serde::{Deserialize, Serialize};

use crate::machine::Core;
use crate::owner::DriverId;

/// A sentence that a driver may send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum DriverSentence {
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

/// A driver of the mission: a `[[driver]]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverSetup {
    /// Its name in the mission.
    pub name: String,
    /// What it may send.
    pub sends: Vec<DriverSentence>,
}

impl Core {
    /// Bytes from a driver.
    pub(crate) fn driver_received(&mut self, driver: DriverId, bytes: &[u8]) {
        let _ = (driver, bytes);
    }
}

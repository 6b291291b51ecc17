/// The phase of the vehicle's mission, by the last BFMIS of this connection (SPI 6.11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Phase {
    /// No status yet, or one with an unknown word.
    #[default]
    Unknown,
    /// It runs.
    Running,
    /// It wraps up, after its end or an abort. The vehicle still moves.
    Ending,
    /// No mission runs.
    Over,
}

impl Phase {
    pub(crate) fn of(status: &str) -> Self {
        if status.starts_with("Running") {
            Self::Running
        } else if ["Aborting", "WrappingUp"].iter().any(|word| status.starts_with(word)) {
            Self::Ending
        } else if is_over(status) {
            Self::Over
        } else {
            Self::Unknown
        }
    }
}

/// Whether a mission status says that nothing of the mission is flown any more. Any other status than these and
/// `Running`, also an unknown one, takes control away but leaves the inserts open, because the vehicle may still fly
/// them. The words are those of SPI 6.11.
pub(crate) fn is_over(status: &str) -> bool {
    let over = [
        "Offline",
        "Waiting",
        "Invalid",
        "Ready",
        "Completed",
        "Aborted",
        "Stopped",
    ];
    over.iter().any(|word| status.starts_with(word))
}

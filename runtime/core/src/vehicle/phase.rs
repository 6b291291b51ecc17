/// How far the vehicle's mission is, as BFMIS has last said on this connection (SPI 6.11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Phase {
    /// Nothing that means anything.
    #[default]
    Unknown,
    /// It runs.
    Running,
    /// It wraps up, after its end or an abort: the vehicle moves yet.
    Ending,
    /// None runs.
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

/// Whether a mission status says that nothing of the mission is flown any more. Others, junk among them, take control
/// but leave the inserts open: the vehicle may fly them yet. The words are those of SPI 6.11.
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

use crate::receive::is_over;

/// How far the vehicle's mission is, as BFMIS has last said on this connection (SPI 6.11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

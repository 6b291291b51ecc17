use backseat_mission::MissionError;
use backseat_plugin_host::HostError;
use backseat_plugin_loader::LoadError;
use backseat_recorder::RecorderError;
use backseat_scenario::ScenarioError;
use backseat_sim::SimError;

/// Why something could not be done. Each text is one line, as the program prints it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The mission cannot be read.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// The mission's `world.toml` or a file of faults cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The faults that the seed shall draw are not written as expected.
    #[error("draw_faults: {0}")]
    Faults(String),
    /// A plugin cannot be loaded.
    #[error(transparent)]
    Plugin(#[from] LoadError),
    /// The simulation cannot be made.
    #[error(transparent)]
    Simulation(SimError),
    /// This computer cannot run WebAssembly.
    #[error(transparent)]
    Host(#[from] HostError),
    /// The log of the run cannot be written.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// A log cannot be read or exported.
    #[error(transparent)]
    Log(#[from] backseat_log_export::Error),
    /// A sentence or a message is not one of SPI.
    #[error("{0}")]
    Spi(String),
    /// A campaign cannot be flown.
    #[error(transparent)]
    Campaign(Box<backseat_campaign::CampaignError>),
    /// The report of a campaign cannot be written.
    #[error(transparent)]
    Report(Box<backseat_campaign_report::ReportError>),
    /// The caller ended the run.
    #[error("interrupted")]
    Interrupted,
}

impl From<SimError> for Error {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Recorder(error) => Self::Recorder(error),
            error @ (SimError::Mvc(_)
            | SimError::Oracle(_)
            | SimError::Controller(_)
            | SimError::Scenario(_)
            | SimError::Sonar(_)) => Self::Simulation(error),
        }
    }
}

impl From<backseat_campaign::CampaignError> for Error {
    fn from(error: backseat_campaign::CampaignError) -> Self {
        Self::Campaign(Box::new(error))
    }
}

impl From<backseat_campaign_report::ReportError> for Error {
    fn from(error: backseat_campaign_report::ReportError) -> Self {
        Self::Report(Box::new(error))
    }
}

impl Error {
    /// Whether the mission is at fault, or one of its files, plugins or settings.
    #[must_use]
    pub const fn is_of_mission(&self) -> bool {
        match self {
            Self::Mission(_)
            | Self::Scenario(_)
            | Self::Faults(_)
            | Self::Plugin(_)
            | Self::Simulation(_)
            | Self::Campaign(_) => true,
            Self::Host(_) | Self::Recorder(_) | Self::Log(_) | Self::Spi(_) | Self::Report(_) | Self::Interrupted => {
                false
            }
        }
    }
}

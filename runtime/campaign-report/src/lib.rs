//! What a campaign's results show, from `runs.parquet` alone: pass rates with their bounds, distributions of measures,
//! paired comparisons of variants, which parameter moves a measure, and the worst runs.
//!
//! [`page`] is one HTML file without any need of a network. [`table`] is for the terminal, [`Summary`] for
//! programs. Pictures of runs are drawn by
//! flying these runs again ([`Gallery`]); without the missions the page does without them.

mod chart;
mod compare;
mod figure;
mod gallery;
mod json;
mod outcome;
mod page;
mod sensitivity;
mod statistics;
mod table;
mod worst;
mod write;

pub use compare::{Comparison, Verdict};
pub use gallery::Gallery;
pub use json::Summary;
pub use outcome::{Arm, Outcomes};
pub use page::page;
pub use statistics::{Interval, pass_rate};
pub use table::table;
pub use write::{REPORT, write};

/// Why results cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The results cannot be read.
    #[error(transparent)]
    Campaign(#[from] backseat_campaign::CampaignError),
    /// The page cannot be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// Its path.
        path: std::path::PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A chart cannot be drawn.
    #[error("a chart cannot be drawn: {0}")]
    Chart(String),
    /// The campaign has no such measure.
    #[error(
        "report.measure is `{measure}`: expected one of the measures of its runs: {known}; correct it \
             and give the same command again, which flies nothing twice"
    )]
    Measure {
        /// What was asked for.
        measure: String,
        /// What there is, separated by commas.
        known: String,
    },
}

//! `backseat log join`: one log of the parts of a run.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::expected_log;
use crate::output::say;
use crate::terminal::tell;

#[derive(Debug, Args)]
pub(crate) struct LogJoin {
    /// The parts, written by `run --log-split`
    #[arg(value_name = "PART.mcap", required = true)]
    parts: Vec<PathBuf>,
    /// Write the whole log into this new file
    #[arg(short, long, value_name = "DIVE.mcap")]
    output: PathBuf,
}

pub(super) fn join(arguments: &LogJoin) -> Result<bool> {
    let joined = match backseat_recorder::join(&arguments.parts, &arguments.output) {
        Ok(joined) => joined,
        Err(backseat_recorder::JoinError::Log(error)) => return expected_log(Err(error)),
        Err(error) => return Err(error.into()),
    };
    if joined.missing > 0 {
        tell(&format!(
            "{} records are missing at the ends of parts that were cut short; the new log marks where",
            joined.missing
        ));
    }
    say!(
        "{}: {} messages, from parts: {}",
        arguments.output.display(),
        joined.messages,
        joined.parts
    );
    Ok(true)
}

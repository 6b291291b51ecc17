//! `backseat log`: tools for the log of a run.

#[cfg(feature = "simulation")]
mod export;
mod files;
mod info;
mod join;
#[cfg(feature = "simulation")]
mod judge;
mod report;
mod show;
#[cfg(feature = "console")]
mod view;

use std::path::Path;

use anyhow::{Context, Result, bail};
use backseat_mission::Mission;
use backseat_plugin_loader::Loaded;
use backseat_recorder::{RecorderError, Sources, read};
use clap::Subcommand;

#[derive(Debug, Subcommand)]
pub(crate) enum Log {
    /// Show a log's mission, times, counts, attachments and gaps
    Info(info::LogInfo),
    /// Print what happened in a run, line by line with its time
    ///
    /// The lines are those that `run` prints, and every state of every request. Times are seconds since the start of
    /// the run.
    Show(show::LogShow),
    /// Sum up a run: what was asked for, refused, flown and taken back
    ///
    /// By owner: how many requests, and how they ended. What was refused, by rule, with the first text of each kind. Inserts
    /// that the vehicle flew, from when to when. Why leases ended, what the operator did, and what went wrong.
    Report(report::LogReport),
    /// Make one log of the parts that `run --log-split` writes
    ///
    /// The parts may be named in any order, and all of them up to the last one must be there. Replay, report and judge read the
    /// new log as if it had never been split.
    Join(join::LogJoin),
    /// Look at a run in a browser: map, time line, plugins and refusals
    ///
    /// The page is served for this computer alone until Ctrl-C, and needs no network. The space bar plays the run.
    #[cfg(feature = "console")]
    View(view::LogView),
    /// Judge a recorded run by the safety requirements, as simulations are judged
    ///
    /// The oracle that judges simulations reads the link's bytes from the log, and the mission's limits and the fence
    /// that are attached to it. It prints one line for each rule that it could judge: whether the rule held and how
    /// many times it applied. With --all it also prints why it could not judge the others.
    ///
    /// The word in front of each result says what the rule looks at: `sent`, our sentences alone; `heard`, our
    /// sentences after what the runtime had read from the vehicle; `operator`, our sentences after what the operator
    /// did; `arrived` and `truth`, facts that only a simulation knows, so these two are never judged here. For each
    /// violation it prints time, rule, description and sentence.
    ///
    /// Records are missing where the disk was too slow. After such a gap nothing is judged that depends on earlier
    /// records, until the log states it again.
    ///
    /// Exit code: 0 if no rule was broken, 1 if one was, 2 if a file cannot be judged.
    #[cfg(feature = "simulation")]
    Judge(judge::LogJudge),
    /// Export a log for QGIS, Google Earth, pandas, DuckDB, MOOS, xarray and others
    ///
    /// A log is MCAP, which Foxglove and Lichtblick open as it is. For other programs:
    ///
    /// `geojson` is one file for QGIS: the track, the true track of a simulation, the fence, the plan, inserts and
    /// requests. Each feature has the property `layer`. Positions are longitude, latitude and height, so depths are
    /// negative.
    ///
    /// `kml` is the same for Google Earth, with a folder for each layer. The time slider plays the track, one position a
    /// second at most. Everything is drawn at the surface of the sea; the coordinates and descriptions have the depths.
    ///
    /// `csv` and `parquet` are tables: a column for each property of a channel (`a.b` for nested ones, `a.0` for arrays
    /// of numbers), behind `time` (UTC) and `t_s` (seconds since the start of the run). All channels go to a folder, with
    /// `tables.json` that describes each column and its unit; one --channel goes to a file.
    ///
    /// `alog` is for the tools of MOOS: NAV_X, NAV_Y and so on from navigation, DESIRED_HEADING and so on while we
    /// steer, and everything else under BACKSEAT_.
    ///
    /// `netcdf` is the trajectory by the conventions CF 1.8 and ACDD 1.3, for data centres, xarray and Panoply: a row for
    /// each navigation solution, with what the CTD and others measured nearest to it, and flags for control and steering.
    ///
    /// The log of a process that was killed is exported as far as it goes. A line on standard error says where it ends,
    /// and another where records are missing.
    ///
    /// Exit code: 0 if the export was written, 2 if not; nothing has changed then.
    #[cfg(feature = "simulation")]
    Export(export::LogExport),
}

pub(crate) fn log(command: &Log) -> Result<bool> {
    match command {
        Log::Info(arguments) => info::info(arguments),
        Log::Show(arguments) => show::show(arguments),
        Log::Report(arguments) => report::report(arguments),
        Log::Join(arguments) => join::join(arguments),
        #[cfg(feature = "console")]
        Log::View(arguments) => view::view(arguments),
        #[cfg(feature = "simulation")]
        Log::Judge(arguments) => judge::judge(arguments),
        #[cfg(feature = "simulation")]
        Log::Export(arguments) => arguments.export(),
    }
}

#[cfg(feature = "simulation")]
pub(crate) use show::plugin_lines;

/// What the log of a run has of its mission for a replay.
pub(crate) fn sources<'a>(mission: &'a Mission, loaded: &'a Loaded) -> Sources<'a> {
    Sources {
        plan: mission.plan.as_ref().map(|plan| plan.text.as_str()),
        fence: mission.other_fence(),
        plugins: &loaded.setups,
    }
}

/// Refuses a later part of a log: what came before it is missing.
pub(crate) fn whole(path: &Path, part: u64) -> Result<()> {
    if part != 1 {
        bail!(
            "{}: part {part} of a log, without what came before: expected the whole log, which `backseat log join` makes",
            path.display()
        );
    }
    Ok(())
}

fn read_log(path: &Path) -> Result<backseat_recorder::Log> {
    expected_log(read(path))
}

/// Says what was expected of a log that cannot be read.
pub(crate) fn expected_log<T>(log: Result<T, RecorderError>) -> Result<T> {
    match log {
        // It is the log of a run, or one that is written.
        Err(error @ (RecorderError::Format { .. } | RecorderError::Create { .. } | RecorderError::Write { .. })) => {
            Err(error.into())
        }
        log => log.context("expected the log of a run, written by `run`, `fly` or `sim --log`"),
    }
}

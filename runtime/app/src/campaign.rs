//! `backseat campaign`: simulated missions by the thousand.

mod merge;
mod report;
mod show;
mod slurm;

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use anyhow::{Result, bail};
use backseat_campaign::{
    Crew, Finished, Folder, Given, Key, Order, Plan, Progress, Seeds, Shard, Stop, finish, fly, pending, word,
};
use backseat_campaign_report::write;
use backseat_reference::{MET, STOPPED, UNMET};
use clap::{Args, Subcommand};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use tokio::signal::unix::{SignalKind, signal};
use tracing::warn;

use crate::arguments::folder;
use crate::cache::host_with;
use crate::clock::Clock;
use crate::output::say;
use crate::sonar_settings::beyond_sonar;
use crate::surroundings::{beyond_limits, beyond_vehicle};
use crate::terminal::{share, tell};

/// Without a terminal the progress is a line this often.
const LINE_EVERY: Duration = Duration::from_secs(10);
/// Runs that are looked at before a campaign begins.
const LOOKED_AT: u64 = 200;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Campaign {
    #[command(subcommand)]
    task: Option<Task>,
    #[command(flatten)]
    fly: Option<CampaignArguments>,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Write the report of results again: DIR/report.html
    Report(report::CampaignReport),
    /// Print the tables of a campaign's results
    Show(show::CampaignShow),
    /// Put the results of shards together, and write the report
    Merge(merge::CampaignMerge),
    /// Write the scripts of a Slurm array job that flies a campaign in shards, or submit them
    Slurm(slurm::CampaignSlurm),
}

/// What to fly. Also the arguments of a shard.
#[derive(Debug, Args)]
pub(crate) struct CampaignArguments {
    /// A campaign's file, or the folder of a mission
    #[arg(value_name = "CAMPAIGN.toml|MISSION")]
    pub(crate) campaign: PathBuf,
    /// The seeds, such as 1..1000 or 1..10,42; both ends of a range count. Overrides the file [default of a mission:
    /// 1..100]
    #[arg(long, value_name = "A..B")]
    pub(crate) seeds: Option<Seeds>,
    /// Set a key in every run: limits.speed_max_mps=1.8, plugin.NAME.config.KEY=VALUE, or world.current.speed_mps=0.3
    /// for a key of world.toml
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Look in this folder first for plugins that a mission names without a path
    #[arg(long, value_name = "DIR", value_parser = folder)]
    pub(crate) plugins: Option<PathBuf>,
    /// Compile the plugins, and keep nothing for the next start
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// The folder of the results. If it has a part of this campaign, the campaign goes on
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Fly only this share of the runs, such as 2/7; `campaign merge` puts the shares together
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Number of threads [default: one for each core]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) workers: Option<u16>,
    /// Stop after this time, with exit code 75: 90s, 55m or 11h
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub(crate) stop_after: Option<Duration>,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn campaign(arguments: &Campaign) -> Result<u8> {
    match (&arguments.task, &arguments.fly) {
        (Some(Task::Report(arguments)), _) => report::report(arguments).map(|()| MET),
        (Some(Task::Show(arguments)), _) => show::show(arguments).map(|()| MET),
        (Some(Task::Merge(arguments)), _) => merge::merge(arguments),
        (Some(Task::Slurm(arguments)), _) => slurm::slurm(arguments).map(|()| MET),
        (None, Some(arguments)) => run(arguments),
        (None, None) => bail!("expected a campaign's file or a mission's folder; `backseat campaign --help` has more"),
    }
}

impl CampaignArguments {
    fn given(&self) -> Result<Given> {
        Ok(Given::read(&self.campaign, self.seeds.clone(), &self.set)?)
    }

    /// Reads everything that the campaign needs once, and opens its results folder.
    fn open(&self, given: &Given) -> Result<(Crew, Folder)> {
        let crew = Crew::new(host_with(!self.no_cache)?, self.plugins.clone());
        let folder = given.open(&crew, &self.out, env!("CARGO_PKG_VERSION"))?;
        Ok((crew, folder))
    }

    fn workers(&self) -> usize {
        self.workers
            .map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from)
    }
}

fn run(arguments: &CampaignArguments) -> Result<u8> {
    let given = arguments.given()?;
    let plan = &given.plan;
    if std::env::vars_os().any(|(name, _)| name.to_string_lossy().starts_with("BACKSEAT__")) {
        warn!("a campaign does not read BACKSEAT__ variables: give keys in its file or with --set");
    }
    let (crew, folder) = arguments.open(&given)?;
    // One shard says it for all.
    if arguments.shard.is_none_or(|shard| shard.of(plan.runs()).start == 0) {
        warn_beyond(plan, &crew);
    }
    let stop = Arc::new(Stop::default());
    stop_at_signals(&stop)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let host = rustix::system::uname();
    let order = Order {
        plan,
        crew: &crew,
        folder: &folder,
        shard,
        workers: arguments.workers(),
        stop_after: arguments.stop_after,
        host: &host.nodename().to_string_lossy(),
    };
    let mut screen = Screen::new(arguments.json);
    let ended = fly(&order, &stop, |progress| screen.show(progress))?;
    screen.end(&ended.progress);
    let Progress { runs, before, now, .. } = ended.progress;
    if ended.stopped {
        tell(&format!(
            "stopped after {} of {runs} runs: the same command goes on",
            before + now
        ));
        if arguments.json {
            say!(
                "{}",
                serde_json::json!({
                    "out": folder.path(),
                    "stopped": true,
                    "runs": runs,
                    "flown": before + now,
                    "flown_now": now,
                })
            );
        }
        return Ok(STOPPED);
    }
    if arguments.shard.is_some() {
        let left = pending(plan, &folder)?;
        if runs == 0 {
            warn!("shard {shard} has no runs: the campaign has {} runs", plan.runs());
        }
        let next = if left == 0 {
            format!(
                "the campaign is whole: `backseat campaign merge {}`",
                word(&arguments.out.display().to_string())
            )
        } else {
            format!("{left} runs of other shards are not flown yet")
        };
        if arguments.json {
            say!(
                "{}",
                serde_json::json!({ "shard": shard.to_string(), "runs": runs, "flown_now": now, "left": left })
            );
        } else {
            say!("shard {shard}: {runs} runs flown; {next}");
        }
        return Ok(MET);
    }
    let finished = finish(plan, std::slice::from_ref(&folder), &folder)?;
    warn_lacking(write(&folder, plan, Some(&crew))?);
    conclude(&folder, &finished, arguments.json)
}

/// Says why the report lacks pictures, if it does.
fn warn_lacking(why: Option<String>) {
    if let Some(why) = why {
        warn!("the report lacks pictures of runs that could not be flown again, such as {why}");
    }
}

/// Prints where the results are and what they are in a line; returns the exit code.
fn conclude(folder: &Folder, finished: &Finished, json: bool) -> Result<u8> {
    let Finished {
        runs,
        passed,
        not_flown,
        violations,
    } = finished;
    if json {
        say!(
            "{}",
            serde_json::json!({
                "out": folder.path(),
                "stopped": false,
                "runs": runs,
                "passed": passed,
                "missed": runs - passed - not_flown,
                "not_flown": not_flown,
                "violations": violations,
            })
        );
    } else {
        show::print(folder)?;
        let path = folder.path().display();
        say!("report: {path}/report.html; rows: {path}/runs.parquet");
    }
    Ok(if passed == runs && *violations == 0 { MET } else { UNMET })
}

/// Looks at some runs of each mission and variant, and says what is beyond the mission's limits there, as `sim` does, and
/// which of them cannot be flown. Each thing is said once, with the first run that has it.
fn warn_beyond(plan: &Plan, crew: &Crew) {
    let mut found: BTreeMap<String, (u64, String)> = BTreeMap::new();
    let looked_at = plan.some_runs(LOOKED_AT);
    for key in &looked_at {
        let (name, lines) = beyond(plan, crew, key);
        for line in lines {
            // Lines that differ in their figures alone are one.
            let kind: String = line.chars().filter(|character| !character.is_ascii_digit()).collect();
            let first = || (0, format!("{name}: {line} (run {})", key.run));
            found.entry(format!("{name}: {kind}")).or_insert_with(first).0 += 1;
        }
    }
    let all = looked_at.len() as u64;
    for (count, line) in found.into_values() {
        if count == all {
            warn!("{line}");
        } else {
            warn!("{line}; {count} of {all} runs that were looked at");
        }
    }
}

fn beyond(plan: &Plan, crew: &Crew, key: &Key) -> (String, Vec<String>) {
    let name = plan.mission(key).display().to_string();
    let prepared = match crew.prepare(plan, key) {
        Ok(prepared) => prepared,
        Err(error) => return (name, vec![format!("cannot be flown: {error}")]),
    };
    let simulation = match prepared.simulation(key.seed) {
        Ok(simulation) => simulation,
        Err(error) => return (name, vec![format!("cannot be flown: {error}")]),
    };
    let (mission, scenario) = (&prepared.mission, &prepared.scenario);
    let mut lines = beyond_vehicle(mission, scenario);
    lines.extend(beyond_limits(mission, scenario, simulation.world()));
    lines.extend(beyond_sonar(mission, scenario));
    (mission.name.clone(), lines)
}

/// Ctrl-C, SIGTERM and SIGHUP stop the campaign; what it has flown is kept.
fn stop_at_signals(stop: &Arc<Stop>) -> Result<()> {
    let stop = Arc::clone(stop);
    let clock = Clock::start();
    let runtime = clock.runtime()?;
    let (mut interrupt, mut terminate, mut hang_up) = {
        let _within = runtime.enter();
        (
            signal(SignalKind::interrupt())?,
            signal(SignalKind::terminate())?,
            signal(SignalKind::hangup())?,
        )
    };
    thread::spawn(move || {
        runtime.block_on(async move {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
                _ = hang_up.recv() => {}
            }
        });
        stop.set();
    });
    Ok(())
}

/// The progress: a bar on a terminal, elsewhere a line from time to time.
struct Screen {
    bar: ProgressBar,
    clock: Clock,
    lines: bool,
    next_line: Duration,
    told_measure: bool,
}

impl Screen {
    fn new(quiet: bool) -> Self {
        let bar = if quiet {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(0)
        };
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos} of {len} runs, {per_sec}, {eta} left{msg}") {
            bar.set_style(style);
        }
        share(&bar);
        Self {
            bar,
            clock: Clock::start(),
            lines: !quiet && !std::io::stderr().is_terminal(),
            next_line: LINE_EVERY,
            told_measure: false,
        }
    }

    fn show(&mut self, progress: &Progress) {
        let done = progress.before + progress.now;
        if self.bar.length() != Some(progress.runs) {
            self.bar.set_length(progress.runs);
            // What was flown before says nothing of the rate.
            self.bar.set_position(done);
            self.bar.reset_eta();
            if progress.cut_off > 0 {
                warn!(
                    "the journal is damaged: its last {} bytes are cut off, and the runs in them are flown again",
                    progress.cut_off
                );
            }
        }
        self.bar.set_position(done);
        if let Some(lack) = &progress.lacks_measure
            && !std::mem::replace(&mut self.told_measure, true)
        {
            warn!(
                "{lack}: unless a later run has it, there will be no report. Ctrl-C, correct it, and the same command goes on"
            );
        }
        let mut message = String::new();
        for (count, what) in [
            (progress.missed, "missed an expectation"),
            (progress.not_flown, "could not be flown"),
            (progress.violations, "violations"),
        ] {
            if count > 0 {
                message.push_str(&format!("; {count} {what}"));
            }
        }
        let elapsed = self.clock.elapsed();
        if self.lines && elapsed >= self.next_line && done < progress.runs {
            self.next_line = elapsed + LINE_EVERY;
            let per_s = progress.now as f64 / elapsed.as_secs_f64();
            let left_s = ((progress.runs - done) as f64 / per_s.max(1e-9)).min(1e12);
            tell(&format!(
                "{done} of {} runs, {per_s:.1} a second, {} left{message}",
                progress.runs,
                HumanDuration(Duration::from_secs_f64(left_s))
            ));
        }
        self.bar.set_message(message);
    }

    fn end(&self, progress: &Progress) {
        self.bar.finish_and_clear();
        let seconds = self.clock.elapsed().as_secs_f64();
        if self.lines && progress.now > 0 {
            let before = match progress.before {
                0 => String::new(),
                before => format!("; {before} were there"),
            };
            tell(&format!(
                "{} runs flown in {seconds:.1} s, {:.1} a second{before}",
                progress.now,
                progress.now as f64 / seconds.max(1e-9)
            ));
        }
    }
}

/// A time on the command line: a number with s, m or h.
fn time(text: &str) -> Result<Duration, String> {
    let expected = || "expected a time such as 90s, 55m or 11h".to_owned();
    let unit = text.chars().last().ok_or_else(expected)?;
    let seconds = match unit {
        's' => 1.0,
        'm' => 60.0,
        'h' => 3600.0,
        _ => return Err(expected()),
    };
    let number: f64 = text[..text.len() - 1].parse().map_err(|_| expected())?;
    if number > 0.0 && number * seconds < 1e8 {
        Ok(Duration::from_secs_f64(number * seconds))
    } else {
        Err(expected())
    }
}

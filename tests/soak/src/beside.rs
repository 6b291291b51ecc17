//! Every fault of the plugin `faulty` beside a good plugin, with the programs themselves in real time (safety
//! requirement 006). Measures how long the vehicle waits for the good plugin's modifies, by its own clock.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Result, bail};
use backseat_suite::{Backseat, Line, Mission, Vehicle};
use clap::Args;
use faulty::Fault;

const STARTS_WITHIN: Duration = Duration::from_secs(180);
/// A modify must be refreshed within this time, seconds (safety requirement 003).
const GAP_MAX_S: f64 = 2.5;
/// When the fault begins, seconds after the plugin's first step.
const AFTER_S: f64 = 2.0;
/// The heading that only the good plugin requests.
const HEADING: &str = "90";
const EVERY_GRANT: &str = r#"["modify", "insert", "interrupt", "message", "surface", "topside", "dvl", "silent", "trim", "buoyancy",
    "acoustic", "station", "devices"]"#;

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Beside {
    /// Only these faults, such as trap,loop [default: all]
    #[arg(long, value_delimiter = ',')]
    pub faults: Vec<String>,
    /// Duration of the fault, seconds of the vehicle's time
    #[arg(long, default_value_t = 10.0)]
    pub seconds: f64,
    /// Number of faults flown at once
    #[arg(long, default_value_t = 8)]
    pub at_once: usize,
}

/// The results.
#[derive(Clone, Debug, Default)]
pub struct BesideReport {
    rows: Vec<Row>,
    misses: Vec<String>,
}

#[derive(Clone, Debug)]
struct Row {
    fault: String,
    modifies: usize,
    worst_gap_s: f64,
    failures: usize,
}

/// Flies the faults.
///
/// # Errors
///
/// If a fault's name is unknown.
pub fn run(arguments: &Beside) -> Result<BesideReport> {
    let all = Fault::names();
    let faults = if arguments.faults.is_empty() {
        &all
    } else {
        &arguments.faults
    };
    if let Some(unknown) = faults.iter().find(|fault| !all.contains(fault)) {
        bail!(
            "--faults: unknown fault {unknown:?}, expected one of {}",
            all.join(", ")
        );
    }
    // Built here, before several threads try to build it.
    let _program = backseat_test_support::program();
    let _plugins = backseat_test_support::plugins();
    let (next, report) = (AtomicUsize::new(0), Mutex::new(BesideReport::default()));
    thread::scope(|scope| {
        for _ in 0..arguments.at_once.max(1) {
            scope.spawn(|| {
                while let Some(fault) = faults.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let flown = catch_unwind(AssertUnwindSafe(|| fly(fault, arguments.seconds)));
                    let mut report = report.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    match flown {
                        Ok(row) => report.rows.push(row),
                        Err(panic) => {
                            let why = panic.downcast_ref::<String>().map_or("it panicked", String::as_str);
                            report.misses.push(format!("{fault}: could not be flown: {why}"));
                        }
                    }
                }
            });
        }
    });
    Ok(report.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

/// The steady mission with a second plugin, of lower priority and with this fault.
fn fly(fault: &str, seconds: f64) -> Row {
    let mission = Mission::steady().append(
        "mission.toml",
        &format!(
            "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = {EVERY_GRANT}\n\
             [plugin.config]\nfault = \"{fault}\"\nafter_s = {AFTER_S:?}"
        ),
    );
    let vehicle = Vehicle::start_within(&mission, STARTS_WITHIN);
    let runtime = Backseat::new()
        .args([
            "run",
            "--arm",
            "--first-identifier",
            "1",
            "--connect",
            &vehicle.address,
            "--log",
        ])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .spawn();
    let first = vehicle.sees("the good one steer", STARTS_WITHIN, is_good);
    let until_s = first.at_s + AFTER_S + seconds;
    // Navigation, to which the runtime has subscribed, advances the log's clock.
    let end = vehicle.sees("the end", STARTS_WITHIN, |line| line.at_s >= until_s);
    let mut times: Vec<f64> = vehicle
        .lines()
        .iter()
        .filter(|line| is_good(line) && line.at_s <= end.at_s)
        .map(|line| line.at_s)
        .collect();
    let modifies = times.len();
    times.push(end.at_s);
    let said = runtime.stderr();
    Row {
        fault: fault.to_owned(),
        modifies,
        worst_gap_s: times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
        failures: said.lines().filter(|line| line.contains("bad failed")).count(),
    }
}

fn is_good(line: &Line) -> bool {
    line.is_received("BPRMB") && line.field(2) == HEADING
}

impl BesideReport {
    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let late = self.rows.iter().filter(|row| row.worst_gap_s >= GAP_MAX_S);
        let late = late.map(|row| {
            format!(
                "{}: {:.3} s without a modify of the good plugin",
                row.fault, row.worst_gap_s
            )
        });
        self.misses.iter().cloned().chain(late).collect()
    }

    /// How many times the runtime reported that the faulty plugin failed, for each fault.
    #[must_use]
    pub fn failures(&self, fault: &str) -> usize {
        let row = self.rows.iter().find(|row| row.fault == fault);
        row.map_or(0, |row| row.failures)
    }
}

impl fmt::Display for BesideReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<16}{:>10}{:>14}{:>10}",
            "fault", "modifies", "worst gap, s", "failures"
        )?;
        for row in &self.rows {
            let Row {
                fault,
                modifies,
                worst_gap_s,
                failures,
            } = row;
            writeln!(f, "{fault:<16}{modifies:>10}{worst_gap_s:>14.3}{failures:>10}")?;
        }
        let worst = self.rows.iter().map(|row| row.worst_gap_s).fold(0.0, f64::max);
        write!(f, "{} faults, the worst gap {worst:.3} s", self.rows.len())
    }
}

//! Terminals and disks around the runtime are slow, stuck, full or closed. Measures how long the vehicle waits for a
//! modify, and for the end of the lease when the operator ends it, by the vehicle's own clock (safety requirement 022).

mod flight;
pub mod frozen;

use std::fmt;
use std::fs::{self, File};
use std::io::{PipeReader, Read, Write, pipe};
use std::os::unix::fs::symlink;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use anyhow::{Result, bail};
use backseat_suite::{Backseat, Behavior, Mission, Scripted, Stall, settle};
use clap::Args;

use flight::Figures;

const STARTS_WITHIN: Duration = Duration::from_secs(60);
const ACTS_WITHIN: Duration = Duration::from_secs(30);
/// The number of plugins that log as much as they may.
const TALKERS: u32 = 12;
/// The aims on an otherwise idle machine, seconds.
const AIM_GAP_S: f64 = 1.5;
const AIM_OBEYED_S: f64 = 0.2;
/// The limits, however busy the machine is, seconds. A gap of 2.5 s is the limit of safety requirement 003.
const GAP_MAX_S: f64 = 2.5;
const OBEYED_MAX_S: f64 = 1.0;
/// At its end the runtime gives the log 2 s, and the state folder, the link and standard error less than half a second
/// each.
const GONE_MAX_S: f64 = 5.0;

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Stuck {
    /// Number of flights of each kind; the worst counts
    #[arg(long, default_value_t = 3)]
    pub flights: u32,
    /// How long modifies are watched in each flight, seconds
    #[arg(long, default_value_t = 8.0)]
    pub seconds: f64,
    /// Only the faults whose names contain this text
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
}

/// The fault around the runtime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    Nothing,
    ErrorsTalkative,
    ErrorsSlow,
    ErrorsStuck,
    ErrorsFull,
    ErrorsGone,
    LogFull,
    LogHangs,
    StateFull,
    StateHangs,
}

const FAULTS: [(Fault, &str); 10] = [
    (Fault::Nothing, "nothing"),
    (Fault::ErrorsTalkative, "standard error: much of it, to a file"),
    (Fault::ErrorsSlow, "standard error: read at 11 KB/s"),
    (Fault::ErrorsStuck, "standard error: read by nobody"),
    (Fault::ErrorsFull, "standard error: full"),
    (Fault::ErrorsGone, "standard error: its reader is gone"),
    (Fault::LogFull, "log: disk full"),
    (Fault::LogHangs, "log: disk hangs"),
    (Fault::StateFull, "state: disk full"),
    (Fault::StateHangs, "state: disk hangs"),
];

/// The results.
#[derive(Clone, Debug, Default)]
pub struct StuckReport {
    rows: Vec<(String, Figures)>,
    misses: Vec<String>,
}

/// Flies the faults, one after the other.
///
/// # Errors
///
/// If no fault has such a name.
pub fn run(arguments: &Stuck) -> Result<StuckReport> {
    let chosen = |name: &str| arguments.only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    if !FAULTS.iter().any(|(_, name)| chosen(name)) {
        let names: Vec<&str> = FAULTS.iter().map(|(_, name)| *name).collect();
        bail!(
            "--only: no fault has this in its name; the faults are: {}",
            names.join("; ")
        );
    }
    let mut report = StuckReport::default();
    for (fault, name) in FAULTS.into_iter().filter(|(_, name)| chosen(name)) {
        let mut worst: Option<Figures> = None;
        for _ in 0..arguments.flights.max(1) {
            match catch_unwind(AssertUnwindSafe(|| fly(fault, arguments.seconds))) {
                Ok(Ok(figures)) => worst = Some(worst.map_or(figures, |worst| worst.worst(figures))),
                Ok(Err(why)) => report.misses.push(format!("{name}: {why}")),
                Err(panic) => {
                    let why = panic.downcast_ref::<String>().map_or("it panicked", String::as_str);
                    report.misses.push(format!("{name}: could not be flown: {why}"));
                }
            }
        }
        report.rows.extend(worst.map(|worst| (name.to_owned(), worst)));
    }
    Ok(report)
}

/// One flight. A disk hangs only once the vehicle is steered; any other fault begins before the start.
fn fly(fault: Fault, seconds: f64) -> Result<Figures> {
    let (mission, stall) = (mission(fault), Stall::new());
    let vehicle = Scripted::start(Behavior::default());
    let (logs, state) = (mission.beside("logs"), mission.beside("state"));
    let mut program = Backseat::new()
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(&logs)
        .arg("--state")
        .arg(&state)
        .mission(&mission);
    // Kept until the end of the flight.
    let (mut unread, mut slow) = (None, None);
    match fault {
        Fault::Nothing => {}
        Fault::ErrorsTalkative => program = program.env("BACKSEAT_LOG", "trace"),
        Fault::ErrorsSlow => {
            let (reader, writer) = pipe()?;
            slow = Some(SlowReader::start(reader));
            program = program.env("BACKSEAT_LOG", "trace").stderr_to(writer);
        }
        Fault::ErrorsStuck => {
            let (reader, mut writer) = pipe()?;
            // It holds 64 KiB, of which a page is left.
            writer.write_all(&[b'\n'; 15 << 12])?;
            unread = Some(reader);
            program = program.env("BACKSEAT_LOG", "trace").stderr_to(writer);
        }
        Fault::ErrorsFull => {
            let full = File::options().write(true).open("/dev/full")?;
            program = program.env("BACKSEAT_LOG", "trace").stderr_to(full);
        }
        Fault::ErrorsGone => {
            let (_, writer) = pipe()?;
            program = program.env("BACKSEAT_LOG", "trace").stderr_to(writer);
        }
        Fault::LogFull => {
            // After the plugin is attached to the log, there is room for some seconds.
            let attached = fs::metadata(backseat_test_support::plugins().join("faulty.wasm"))?.len();
            program = program.file_max_kib(attached / 1024 + 40);
        }
        Fault::StateFull => {
            fs::create_dir(&state)?;
            fs::write(state.join("vehicle"), "steady")?;
            fs::write(state.join("identifiers"), "70")?;
            for name in ["identifiers.new", "hold.new"] {
                symlink("/dev/full", state.join(name))?;
            }
        }
        Fault::LogHangs => program = program.stalled(&stall, &[&logs]),
        Fault::StateHangs => program = program.stalled(&stall, &[&state]),
    }
    let mut runtime = program.spawn();
    flight::begin(&vehicle);
    let hangs = matches!(fault, Fault::LogHangs | Fault::StateHangs);
    if hangs {
        stall.begin();
    }
    let (modifies, gap_s) = flight::window(&vehicle, seconds);
    let (figures, code) = flight::end(&vehicle, &mut runtime);
    drop(unread);
    let said = runtime.stderr();
    if code != Some(0) {
        bail!("it ended with {code:?}\n{}", last_lines(&said));
    }
    let happened = match fault {
        Fault::LogFull => said.contains("the log ends here"),
        Fault::StateFull => said.contains("identifiers cannot be reserved"),
        Fault::LogHangs | Fault::StateHangs => !stall.held().is_empty(),
        Fault::ErrorsTalkative => said.len() > 100_000,
        Fault::ErrorsSlow => slow.is_some_and(SlowReader::missed_some),
        Fault::Nothing | Fault::ErrorsStuck | Fault::ErrorsFull | Fault::ErrorsGone => true,
    };
    if !happened {
        bail!("the fault had no effect\n{}", last_lines(&said));
    }
    Ok(Figures {
        modifies,
        gap_s,
        slip_s: flight::slip(&said),
        ..figures
    })
}

fn mission(fault: Fault) -> Mission {
    match fault {
        Fault::Nothing | Fault::LogFull | Fault::LogHangs | Fault::StateHangs => Mission::steady(),
        Fault::ErrorsTalkative | Fault::ErrorsSlow | Fault::ErrorsStuck | Fault::ErrorsFull | Fault::ErrorsGone => {
            talkative()
        }
        Fault::StateFull => Mission::steady().append(
            "mission.toml",
            "[[plugin]]\nname = \"inserter\"\ncomponent = \"faulty\"\ngrants = [\"insert\", \"interrupt\"]\n\
             [plugin.config]\nfault = \"cross_fence\"\ntarget_east_m = -500.0\ntarget_north_m = 0.0\n\
             after_current = true",
        ),
    }
}

/// The pilot steers, and other plugins beside it log more in each step than they may: 25 KB/s in total.
fn talkative() -> Mission {
    (1..=TALKERS).fold(Mission::steady(), |mission, number| {
        let table = format!(
            "[[plugin]]\nname = \"talker-{number}\"\ncomponent = \"faulty\"\ngrants = [\"message\"]\n\
             [plugin.config]\nfault = \"log_flood\""
        );
        mission.append("mission.toml", &table)
    })
}

/// Reads at the speed of a serial console of 115,200 baud: 11 KB/s.
struct SlowReader {
    hurries: Arc<AtomicBool>,
    thread: JoinHandle<bool>,
}

impl SlowReader {
    fn start(mut reader: PipeReader) -> Self {
        let hurries = Arc::new(AtomicBool::new(false));
        let hurry = Arc::clone(&hurries);
        let thread = thread::spawn(move || {
            let (mut buffer, mut read) = ([0; 1100], Vec::new());
            while let Ok(count @ 1..) = reader.read(&mut buffer) {
                read.extend_from_slice(&buffer[..count]);
                if !hurry.load(Ordering::Relaxed) {
                    settle(Duration::from_millis(100));
                }
            }
            String::from_utf8_lossy(&read).contains("lines were dropped")
        });
        Self { hurries, thread }
    }

    /// Called when the process has ended. Returns whether the text reports dropped lines, which this slow reader has
    /// caused.
    fn missed_some(self) -> bool {
        self.hurries.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or(false)
    }
}

fn last_lines(said: &str) -> String {
    let lines: Vec<&str> = said.lines().collect();
    lines[lines.len().saturating_sub(10)..].join("\n")
}

impl StuckReport {
    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.misses.clone();
        for (name, figures) in &self.rows {
            faults.extend(late(name, figures));
        }
        faults
    }
}

/// The measurements that exceed their limits.
fn late<'a>(name: &'a str, figures: &Figures) -> impl Iterator<Item = String> + 'a {
    let Figures {
        gap_s,
        held_s,
        ended_s,
        gone_s,
        ..
    } = *figures;
    [
        (gap_s, GAP_MAX_S, "without a modify"),
        (held_s, OBEYED_MAX_S, "from SIGUSR1 to BPEMB"),
        (ended_s, OBEYED_MAX_S, "from SIGTERM to BPEMB"),
        (gone_s, GONE_MAX_S, "from SIGTERM to the end of the process"),
    ]
    .into_iter()
    .filter(|(figure_s, most_s, _)| figure_s > most_s)
    .map(move |(figure_s, most_s, what)| format!("{name}: {figure_s:.3} s {what}, at most {most_s} s"))
}

impl fmt::Display for StuckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", heading())?;
        for (name, figures) in &self.rows {
            writeln!(f, "{}", line(name, figures))?;
        }
        write!(
            f,
            "the worst of all flights, seconds; aims: {AIM_GAP_S} s without a modify, {AIM_OBEYED_S} s to BPEMB\n\
             slip: how late the loop woke at worst, as it reports; 0 if less than 0.05"
        )
    }
}

fn heading() -> String {
    let (modifies, gap, held, ended, gone) = ("modifies", "worst gap", "USR1>BPEMB", "TERM>BPEMB", "TERM>end");
    format!(
        "{:<40}{modifies:>9}{gap:>11}{held:>12}{ended:>12}{gone:>10}{:>8}",
        "fault", "slip"
    )
}

fn line(name: &str, figures: &Figures) -> String {
    let Figures {
        modifies,
        gap_s,
        held_s,
        ended_s,
        gone_s,
        slip_s,
    } = figures;
    let slip = slip_s.map_or("?".to_owned(), |slip_s| format!("{slip_s:.3}"));
    format!("{name:<40}{modifies:>9}{gap_s:>11.3}{held_s:>12.3}{ended_s:>12.3}{gone_s:>10.3}{slip:>8}")
}

//! A frozen file system under the log (`fsfreeze`): a thread that writes to it waits in the kernel, where no signal
//! ends it. The test freezes an ext4 file system on a loop device, which only root can create.
//!
//! The file system is thawed on every exit: by the code that froze it or, if this process is killed, by a child process
//! that waits only for that.

use std::fmt;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_suite::{Backseat, Behavior, Mission, Scripted, Signal, Stopwatch, settle};
use clap::Args;
use tempfile::TempDir;

use super::flight::{self, Figures};
use super::{ACTS_WITHIN, heading, last_lines, late, line};

const IMAGE_BYTES: u64 = 64 << 20;
/// How long the child waits for the end of this process at most, seconds; then it thaws the file system in any case.
const THAWS_WITHIN_S: &str = "300";

/// Waits for the end of standard input, thaws, kills processes that still write there, and unmounts.
const THAW: &str = r#"
trap '' INT TERM HUP
timeout "$1" cat >/dev/null
fsfreeze --unfreeze "$0" 2>/dev/null
for file in /proc/[0-9]*/fd/*; do
    case "$(readlink "$file")" in
        "$0"/*) process="${file#/proc/}"; kill -9 "${process%%/*}" ;;
    esac
done 2>/dev/null
umount --lazy --quiet "$0"
"#;

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Frozen {
    /// Duration of the freeze, seconds
    #[arg(long, default_value_t = 8.0)]
    pub seconds: f64,
}

/// The results.
#[derive(Clone, Debug)]
pub enum FrozenReport {
    /// Nothing was shown, and why.
    NotShown(String),
    /// The flights took place.
    Flown {
        /// The measurements, with what was frozen.
        table: String,
        /// Everything that is not as required.
        faults: Vec<String>,
    },
}

/// Flies twice: first the log's file system is frozen for some time; then the log's and the state's, until the process
/// has been told to end.
///
/// # Errors
///
/// None; if no file system can be frozen, the report gives the reason.
pub fn run(arguments: &Frozen) -> Result<FrozenReport> {
    let disk = match Disk::mount() {
        Ok(disk) => disk,
        Err(why) => return Ok(FrozenReport::NotShown(format!("{why:#}"))),
    };
    let mut table = heading();
    let mut faults = Vec::new();
    let flights: [(&str, Flight); 2] = [
        ("log: file system frozen, then thawed", thawed),
        ("log and state: frozen to the end", to_the_end),
    ];
    for (name, fly) in flights {
        match catch_unwind(AssertUnwindSafe(|| fly(&disk, arguments.seconds))) {
            Ok(Ok(figures)) => {
                table = format!("{table}\n{}", line(name, &figures));
                // Nothing can end a process before the thaw if one of its threads waits for a frozen file system.
                let judged = Figures { gone_s: 0.0, ..figures };
                faults.extend(late(name, &judged));
            }
            Ok(Err(why)) => faults.push(format!("{name}: {why:#}")),
            Err(panic) => {
                let why = panic.downcast_ref::<String>().map_or("it panicked", String::as_str);
                faults.push(format!("{name}: could not be flown: {why}"));
            }
        }
    }
    Ok(FrozenReport::Flown { table, faults })
}

type Flight = fn(&Disk, f64) -> Result<Figures>;

fn runtime(mission: &Mission, vehicle: &Scripted, logs: &Path, state: &Path) -> Backseat {
    Backseat::new()
        .args(["run", "--arm", "--connect", &vehicle.address, "--log"])
        .arg(logs)
        .arg("--state")
        .arg(state)
        .mission(mission)
}

fn thawed(disk: &Disk, seconds: f64) -> Result<Figures> {
    let (mission, vehicle) = (Mission::steady(), Scripted::start(Behavior::default()));
    let logs = disk.folder.join("thawed");
    let mut runtime = runtime(&mission, &vehicle, &logs, &mission.beside("state")).spawn();
    flight::begin(&vehicle);
    let frozen = disk.freeze()?;
    let (modifies, gap_s) = flight::window(&vehicle, seconds);
    let held_s = flight::end_lease(&vehicle, &runtime, Signal::USR1);
    drop(frozen);
    flight::release(&vehicle, &runtime);
    let stopped = Stopwatch::start();
    let ended_s = flight::end_lease(&vehicle, &runtime, Signal::TERM);
    let code = runtime.wait(ACTS_WITHIN);
    if code != Some(0) {
        bail!("it ended with {code:?}\n{}", last_lines(&runtime.stderr()));
    }
    if runtime.stderr().contains("the log has no end") {
        bail!("the log did not continue\n{}", last_lines(&runtime.stderr()));
    }
    Ok(Figures {
        modifies,
        gap_s,
        held_s,
        ended_s,
        gone_s: stopped.elapsed().as_secs_f64(),
        slip_s: flight::slip(&runtime.stderr()),
    })
}

fn to_the_end(disk: &Disk, seconds: f64) -> Result<Figures> {
    let (mission, vehicle) = (Mission::steady(), Scripted::start(Behavior::default()));
    let (logs, state) = (disk.folder.join("to-the-end"), disk.folder.join("state"));
    let mut runtime = runtime(&mission, &vehicle, &logs, &state).spawn();
    flight::begin(&vehicle);
    let frozen = disk.freeze()?;
    let (modifies, gap_s) = flight::window(&vehicle, seconds);
    let held_s = flight::end_lease(&vehicle, &runtime, Signal::USR1);
    flight::release(&vehicle, &runtime);
    let stopped = Stopwatch::start();
    let ended_s = flight::end_lease(&vehicle, &runtime, Signal::TERM);
    settle(Duration::from_secs(5));
    let before_the_thaw = runtime.ended();
    drop(frozen);
    let code = runtime.wait(ACTS_WITHIN);
    let gone_s = stopped.elapsed().as_secs_f64();
    if before_the_thaw.is_some() {
        bail!("it ended before the thaw, so no thread waited for the file system and nothing was shown");
    }
    if code != Some(0) {
        bail!("it ended with {code:?}\n{}", last_lines(&runtime.stderr()));
    }
    Ok(Figures {
        modifies,
        gap_s,
        held_s,
        ended_s,
        gone_s,
        slip_s: flight::slip(&runtime.stderr()),
    })
}

/// A small separate file system. It is thawed, unmounted and removed when this is dropped.
struct Disk {
    folder: PathBuf,
    /// The child that thaws it if this process is killed; it waits for the end of its standard input.
    watchdog: Child,
    _image: TempDir,
}

/// The frozen disk. It is thawed when this is dropped.
struct Freeze<'a>(&'a Disk);

impl Disk {
    fn mount() -> Result<Self> {
        let image = tempfile::tempdir().context("no temporary folder")?;
        let (path, folder) = (image.path().join("image"), image.path().join("mounted"));
        std::fs::create_dir(&folder)?;
        File::create(&path)?.set_len(IMAGE_BYTES)?;
        tool(Command::new("mkfs.ext4").arg("-q").arg(&path))?;
        tool(Command::new("mount").args(["-o", "loop"]).arg(&path).arg(&folder))?;
        // From here on it is unmounted on every exit.
        let watchdog = watch(&folder);
        let unmount = || unmounted(&folder);
        let disk = Self {
            watchdog: watchdog.inspect_err(|_| unmount())?,
            folder,
            _image: image,
        };
        // Checks whether it can be frozen at all.
        drop(disk.freeze()?);
        Ok(disk)
    }

    fn freeze(&self) -> Result<Freeze<'_>> {
        // Created before the freeze, so that any exit after this thaws it.
        let freeze = Freeze(self);
        tool(Command::new("fsfreeze").arg("--freeze").arg(&self.folder))?;
        Ok(freeze)
    }
}

impl Drop for Freeze<'_> {
    fn drop(&mut self) {
        // This fails if it is not frozen.
        let _thawed = tool(Command::new("fsfreeze").arg("--unfreeze").arg(&self.0.folder));
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // The end of its input makes it thaw once more and unmount.
        drop(self.watchdog.stdin.take());
        let _ended = self.watchdog.wait();
        unmounted(&self.folder);
    }
}

/// Unmounts it if it is mounted.
fn unmounted(folder: &Path) {
    let _not_mounted = tool(Command::new("umount").args(["--lazy", "--quiet"]).arg(folder));
}

/// Starts a child in a process group of its own, which Ctrl-C does not reach. When this process has ended, in whatever
/// way, the child thaws the file system and unmounts it.
fn watch(folder: &Path) -> Result<Child> {
    use std::os::unix::process::CommandExt as _;
    Command::new("sh")
        .args(["-c", THAW])
        .arg(folder)
        .arg(THAWS_WITHIN_S)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .context("sh")
}

/// Runs a system tool. Its output is the error.
fn tool(command: &mut Command) -> Result<()> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.stdin(Stdio::null()).output().with_context(|| name.clone())?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{name}: {}", said.trim().lines().next().unwrap_or("failed"));
    }
    Ok(())
}

impl FrozenReport {
    /// Everything that is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        match self {
            Self::NotShown(_) => Vec::new(),
            Self::Flown { faults, .. } => faults.clone(),
        }
    }

    /// Whether anything was shown.
    #[must_use]
    pub const fn was_shown(&self) -> bool {
        matches!(self, Self::Flown { .. })
    }
}

impl fmt::Display for FrozenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotShown(why) => write!(f, "NOT SHOWN: no file system can be frozen here: {why}"),
            Self::Flown { table, .. } => write!(f, "{table}"),
        }
    }
}

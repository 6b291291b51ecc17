//! A campaign on a real Slurm of one node: an array job whose tasks are killed, and whose node is taken away in mid-run.
//! The merged results must be those of one process, byte for byte.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use backseat_test_support::{mission, plugins, program};
use clap::Args;
use tempfile::TempDir;

/// What must be installed, by Debian's packages.
const PROGRAMS: [&str; 5] = ["slurmctld", "slurmd", "munged", "sbatch", "setpriv"];
const PACKAGES: &str = "slurm-wlm munge";
/// Slurm lets two minutes pass before a task that was queued again may run.
const ENDS_WITHIN: Duration = Duration::from_secs(20 * 60);

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Slurm {
    /// Number of runs
    #[arg(long, default_value_t = 300)]
    pub runs: u64,
    /// Number of tasks
    #[arg(long, default_value_t = 3)]
    pub tasks: u64,
}

/// The results.
#[derive(Clone, Debug, Default)]
pub struct SlurmReport {
    /// Why nothing was shown, if nothing was.
    not_shown: Option<String>,
    killed: bool,
    taken_away: bool,
    restarts: u64,
    seconds: f64,
    same: bool,
    merged: String,
}

impl SlurmReport {
    /// Whether this machine can run Slurm.
    #[must_use]
    pub const fn was_shown(&self) -> bool {
        self.not_shown.is_none()
    }

    /// What is not as required.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if !self.killed || !self.taken_away {
            faults.push("no task was killed, or the node was not taken away while a task ran".to_owned());
        }
        if self.restarts < 2 {
            faults.push(format!("{} tasks were queued again, expected 2 or more", self.restarts));
        }
        if !self.same {
            faults.push(format!(
                "the merged results are not those of one process: {}",
                self.merged
            ));
        }
        faults
    }
}

impl fmt::Display for SlurmReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(why) = &self.not_shown {
            return write!(f, "not shown: {why}");
        }
        write!(
            f,
            "an array job on Slurm: one task killed, the node taken away once, {} restarts; merged after {:.0} s, {}",
            self.restarts,
            self.seconds,
            if self.same {
                "the same bytes as one process"
            } else {
                "other bytes than one process"
            }
        )
    }
}

/// Starts a Slurm, flies a campaign on it and by itself, and compares the two.
///
/// # Errors
///
/// If a program cannot be started, or if the jobs do not end.
pub fn run(arguments: &Slurm) -> Result<SlurmReport> {
    let missing: Vec<&str> = PROGRAMS.into_iter().filter(|name| !is_installed(name)).collect();
    if !missing.is_empty() {
        return Ok(SlurmReport {
            not_shown: Some(format!(
                "{} not found: install Debian's packages {PACKAGES}",
                missing.join(", ")
            )),
            ..SlurmReport::default()
        });
    }
    if !rustix::process::geteuid().is_root() {
        return Ok(SlurmReport {
            not_shown: Some("a Slurm of one's own needs root".to_owned()),
            ..SlurmReport::default()
        });
    }
    let folder = tempfile::tempdir()?;
    let cluster = Cluster::start(folder.path())?;
    let campaign = folder.path().join("campaign.toml");
    fs::write(
        &campaign,
        format!(
            "missions = [{:?}]\nseeds = \"1..{}\"\n",
            mission("isobath"),
            arguments.runs
        ),
    )?;
    let (shared, alone) = (folder.path().join("shared"), folder.path().join("alone"));
    let begun = Instant::now();
    let submitted = backseat(&["campaign", "slurm"], &campaign, &shared)
        .args(["--submit", "--minutes", "5", "--shards", &arguments.tasks.to_string()])
        .env("SLURM_CONF", &cluster.config)
        .output()?;
    good(&submitted, "campaign slurm --submit")?;
    let mut report = SlurmReport {
        // Its program is killed once it has some rows.
        killed: cluster.in_mid_run(&shared, 1, || kill_program(&shared))?,
        taken_away: cluster.in_mid_run(&shared, 2, || cluster.take_node_away())?,
        ..SlurmReport::default()
    };
    let results = shared.join("runs.parquet");
    let page = shared.join("report.html");
    while !(results.is_file() && page.is_file()) {
        if begun.elapsed() > ENDS_WITHIN {
            bail!(
                "the jobs have not ended: {}",
                cluster.told(&["squeue"])?.replace('\n', "; ")
            );
        }
        sleep(Duration::from_secs(1));
    }
    report.seconds = begun.elapsed().as_secs_f64();
    report.merged = fs::read_to_string(shared.join("slurm/merge.txt")).unwrap_or_default();
    report.restarts = cluster.restarts()?;
    // A run that misses an expectation is no failure here.
    let flown = backseat(&["campaign"], &campaign, &alone).output()?;
    if !matches!(flown.status.code(), Some(0 | 1)) {
        good(&flown, "campaign")?;
    }
    report.same = fs::read(alone.join("runs.parquet"))? == fs::read(results)?;
    Ok(report)
}

fn backseat(words: &[&str], campaign: &Path, out: &Path) -> Command {
    let mut command = Command::new(program());
    command
        .args(words)
        .arg(campaign)
        .arg("--out")
        .arg(out)
        .arg("--plugins")
        .arg(plugins());
    command
}

fn good(output: &Output, what: &str) -> Result<()> {
    if !output.status.success() {
        bail!("{what}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(())
}

fn is_installed(name: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    // Debian's daemons are not in every user's path.
    std::env::split_paths(&folders)
        .chain([PathBuf::from("/usr/sbin")])
        .any(|folder| folder.join(name).is_file())
}

/// Kills the program of a task, as the kernel does when memory runs out.
fn kill_program(shared: &Path) -> Result<()> {
    let pattern = format!("campaign .*--shard .*--out {}", shared.display());
    let killed = Command::new("pkill").args(["-KILL", "-f", &pattern]).status()?;
    if !killed.success() {
        bail!("no task's program was found");
    }
    Ok(())
}

/// A Slurm of one node, for as long as this lives.
struct Cluster {
    config: PathBuf,
    folder: PathBuf,
    host: String,
    _munge: TempDir,
}

impl Cluster {
    fn start(folder: &Path) -> Result<Self> {
        let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
        let cluster = folder.join("slurm");
        for name in ["state", "spool"] {
            fs::create_dir_all(cluster.join(name))?;
        }
        let munge = munge()?;
        let socket = munge.path().join("munge.socket");
        let at = |name: &str| cluster.join(name).display().to_string();
        let config = cluster.join("slurm.conf");
        fs::write(
            &config,
            format!(
                "ClusterName=soak\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort=16817\nSlurmdPort=16818\n\
                 SlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\nAuthInfo=socket={}\n\
                 ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nJobAcctGatherType=jobacct_gather/none\n\
                 AccountingStorageType=accounting_storage/none\nJobCompType=jobcomp/filetxt\nJobCompLoc={}\n\
                 ReturnToService=2\nSelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nKillWait=5\n\
                 SchedulerParameters=sched_min_interval=10000,sched_interval=1,batch_sched_delay=0\n\
                 StateSaveLocation={}\nSlurmdSpoolDir={}\nSlurmctldPidFile={}\nSlurmdPidFile={}\n\
                 SlurmctldLogFile={}\nSlurmdLogFile={}\n\
                 NodeName={host} NodeAddr=127.0.0.1 CPUs=1\nPartitionName=main Nodes={host} Default=YES State=UP\n",
                socket.display(),
                at("jobs.txt"),
                at("state"),
                at("spool"),
                at("slurmctld.pid"),
                at("slurmd.pid"),
                at("slurmctld.log"),
                at("slurmd.log"),
            ),
        )?;
        let cluster = Self {
            config,
            folder: cluster,
            host,
            _munge: munge,
        };
        for daemon in ["/usr/sbin/slurmctld", "/usr/sbin/slurmd"] {
            good(&cluster.command(daemon).output().context(daemon)?, daemon)?;
        }
        let begun = Instant::now();
        while !cluster.told(&["sinfo", "--noheader", "--format=%t"])?.contains("idle") {
            if begun.elapsed() > Duration::from_secs(60) {
                bail!("Slurm does not come up: {}", cluster.told(&["sinfo"])?);
            }
            sleep(Duration::from_millis(500));
        }
        Ok(cluster)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", &self.config).stdin(Stdio::null());
        command
    }

    fn told(&self, words: &[&str]) -> Result<String> {
        let [program, arguments @ ..] = words else {
            bail!("no command")
        };
        let output = self
            .command(program)
            .args(arguments)
            .output()
            .context(words.join(" "))?;
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Acts while a task has begun and is not over; false if none was met in mid-run.
    fn in_mid_run(&self, shared: &Path, task: u64, act: impl FnOnce() -> Result<()>) -> Result<bool> {
        /// A journal with some rows.
        const BEGUN: u64 = 4000;
        let begun = Instant::now();
        while begun.elapsed() < ENDS_WITHIN {
            let running = self.told(&["squeue", "--noheader", "--states=RUNNING", "--format=%K"])?;
            let journal = fs::read_dir(shared.join("journal"))
                .into_iter()
                .flatten()
                .filter_map(Result::ok)
                .find(|entry| entry.file_name().to_string_lossy().starts_with(&format!("{task}-of-")));
            let rows = journal
                .and_then(|journal| journal.metadata().ok())
                .map_or(0, |file| file.len());
            if running.lines().any(|line| line == task.to_string()) && rows > BEGUN {
                act()?;
                return Ok(true);
            }
            sleep(Duration::from_millis(200));
        }
        Ok(false)
    }

    /// The node goes down in mid-run, and comes back.
    fn take_node_away(&self) -> Result<()> {
        let node = format!("nodename={}", self.host);
        self.told(&["scontrol", "update", &node, "state=down", "reason=soak"])?;
        sleep(Duration::from_secs(3));
        self.told(&["scontrol", "update", &node, "state=resume"])?;
        Ok(())
    }

    /// How often tasks were queued again, from the file of completed jobs: it has a line for each turn.
    fn restarts(&self) -> Result<u64> {
        let text = fs::read_to_string(self.folder.join("jobs.txt"))?;
        let mut turns = std::collections::BTreeMap::<&str, u64>::new();
        for line in text.lines() {
            if let Some(job) = line.split_whitespace().find(|word| word.starts_with("JobId=")) {
                *turns.entry(job).or_default() += 1;
            }
        }
        Ok(turns.values().map(|turns| turns - 1).sum())
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for name in ["slurmd.pid", "slurmctld.pid"] {
            let Ok(pid) = fs::read_to_string(self.folder.join(name)) else {
                continue;
            };
            // It may have ended by itself.
            let _ended = Command::new("kill").arg(pid.trim()).status();
        }
        let pattern = format!("munged .*{}", self._munge.path().display());
        let _ended = Command::new("pkill").args(["-f", &pattern]).status();
    }
}

/// Munge, which authenticates Slurm's messages, with a key, a socket and files of its own.
fn munge() -> Result<TempDir> {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::Builder::new().prefix("munge-").tempdir_in("/run")?;
    let path = folder.path();
    let mut key = vec![0; 1024];
    std::io::Read::read_exact(&mut fs::File::open("/dev/urandom")?, &mut key)?;
    fs::write(path.join("munge.key"), key)?;
    fs::set_permissions(path.join("munge.key"), fs::Permissions::from_mode(0o400))?;
    fs::set_permissions(path, fs::Permissions::from_mode(0o755))?;
    good(
        &Command::new("chown").args(["-R", "munge:munge"]).arg(path).output()?,
        "chown",
    )?;
    let option = |name: &str, file: &str| format!("--{name}={}", path.join(file).display());
    let started = Command::new("setpriv")
        .args(["--reuid=munge", "--regid=munge", "--clear-groups", "/usr/sbin/munged"])
        .args([
            option("key-file", "munge.key"),
            option("socket", "munge.socket"),
            option("pid-file", "munged.pid"),
            option("log-file", "munged.log"),
            option("seed-file", "munged.seed"),
        ])
        .output()?;
    good(&started, "munged")?;
    Ok(folder)
}

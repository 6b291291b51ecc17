//! What this computer needs for a dive: folders that can be written, room for the logs, a clock that is right.

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use anyhow::Result;
use backseat_fence::Rfc3339;
use backseat_mission::Mission;
use backseat_units::Utc;
use clap::Args;

use crate::log_room::size;
use crate::output::say;
use crate::owner::{explained, not_made};
use crate::run::names_requests;
use crate::state::State;

/// How much room a dive's logs need.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct RoomForLogs {
    /// The free space that the dive's logs need. A day at sea writes about 0.75 GB (8.7 kB a second)
    #[arg(
        id = "log-room",
        long = "log-room",
        env = "BACKSEAT_LOG_ROOM",
        hide_env_values = true,
        value_name = "SIZE",
        default_value = "1074MB",
        value_parser = size
    )]
    pub(crate) bytes: u64,
}

/// Free space that must be there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    bytes: u64,
    /// How the operator asks for more or less, in brackets; empty if there is no way.
    option: &'static str,
}

impl From<RoomForLogs> for Room {
    fn from(asked: RoomForLogs) -> Self {
        Self {
            bytes: asked.bytes,
            option: " (--log-room)",
        }
    }
}

/// The records of identifiers and hold are a few bytes each, and occupy one block each.
pub(crate) const STATE_ROOM: Room = Room {
    bytes: 1 << 20,
    option: "",
};
/// 2025-01-01. A clock that has lost power starts in 1970, or when its firmware was built.
pub(crate) const CLOCK_MIN: Utc = Utc::from_unix_nanos(1_735_689_600_000_000_000);
/// 2100-01-01.
pub(crate) const CLOCK_MAX: Utc = Utc::from_unix_nanos(4_102_444_800_000_000_000);
/// A mission's files are not written in the future, but the clock of the machine that wrote them may be this far ahead.
const AHEAD_MAX: Duration = Duration::from_secs(3600);

/// Everything that this computer lacks, one line each. Prints a line if it lacks nothing.
pub(super) fn findings(mission: &Mission, log: (&Path, RoomForLogs), state: &Path, now: Utc) -> Result<Vec<String>> {
    let folders = [("logs", log.0, log.1.into()), ("state", state, STATE_ROOM)];
    let (mut findings, mut free) = (Vec::new(), Vec::new());
    for (what, folder, room) in folders {
        match writable(folder, room) {
            Ok(bytes) => free.push(format!("{} free for {what}", in_words(bytes))),
            Err(error) => findings.push(format!("{what}: {error:#}")),
        }
    }
    if !is_plausible(now) {
        findings.push(format!("clock: {}", implausible(now)));
    } else if let Some((file, ahead)) = written_later(mission, now) {
        findings.push(format!(
            "clock: {file} was written {} in the future, so this computer's clock is probably behind; set it",
            apart(ahead)
        ));
    }
    if findings.is_empty() {
        let whole = Utc::from_unix_nanos(now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000);
        say!(
            "this computer: ok ({}; its clock says {})",
            free.join(", "),
            Rfc3339(whole)
        );
    }
    Ok(findings)
}

/// Whether a computer's clock can be right.
pub(crate) fn is_plausible(now: Utc) -> bool {
    (CLOCK_MIN..=CLOCK_MAX).contains(&now)
}

/// What is wrong with a clock that cannot be right.
pub(crate) fn implausible(now: Utc) -> String {
    let whole = Utc::from_unix_nanos(now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000);
    format!("the time is {}, expected one from 2025 to 2100: set it", Rfc3339(whole))
}

/// A long time, as a person says it.
fn apart(time: Duration) -> String {
    match time.as_secs() {
        seconds @ ..7200 => format!("{seconds} s"),
        seconds @ 7200..172_800 => format!("{} hours", seconds / 3600),
        seconds => format!("{} days", seconds / 86_400),
    }
}

/// What earlier runs, the operator or other programs have left behind that prevents this mission from being flown, one
/// line each.
pub(super) fn kept(mission: &Mission, folder: &Path) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    // A check does not create the folder where it is missing.
    let state = folder
        .is_dir()
        .then(|| State::open(folder, mission.file.vehicle.name.as_deref()));
    let mut recorded = None;
    match state.transpose() {
        Ok(Some(state)) => {
            if state.held() {
                findings.push(format!(
                    "hold: {} exists, so nothing that steers is sent; release the hold or delete the file",
                    state.hold_path().display()
                ));
            }
            match state.identifiers(None) {
                Ok(identifiers) => recorded = identifiers,
                Err(error) => findings.push(format!("state: {error:#}")),
            }
        }
        Ok(None) => {}
        Err(error) => findings.push(format!("state: {error:#}")),
    }
    if recorded.is_none() && findings.is_empty() && names_requests(mission) {
        say!(
            "no record of SPI identifiers in {}: `run` sends no tracklines, circles, GPS hits or acoustic packets \
             until you begin one with --first-identifier N",
            folder.display()
        );
    }
    for source in &mission.file.externals {
        if let Err(error) = TcpListener::bind(&source.listen) {
            findings.push(format!("external source {}: {}: {error}", source.name, source.listen));
        }
    }
    Ok(findings)
}

/// Checks that the folder, or the existing one in which it will be created, can be written to and has room. Returns how
/// many bytes are free.
pub(crate) fn writable(folder: &Path, room: Room) -> Result<u64> {
    let there = existing(folder);
    let probe = there.join(format!(".backseat-check-{}", std::process::id()));
    let written = fs::write(&probe, b"write test by backseat check\n");
    let removed = fs::remove_file(&probe);
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    written.and(removed).map_err(|error| {
        if there == whole {
            explained(&there, error)
        } else {
            not_made(folder, error)
        }
    })?;
    let figures = rustix::fs::statvfs(&there).map_err(|error| explained(&there, error.into()))?;
    let free = figures.f_bavail.saturating_mul(figures.f_frsize);
    anyhow::ensure!(
        free >= room.bytes,
        "{}: {} are free, expected at least {}{}",
        there.display(),
        in_words(free),
        in_words(room.bytes),
        room.option
    );
    Ok(free)
}

/// So many bytes, as a person says it.
pub(crate) fn in_words(bytes: u64) -> String {
    if bytes < 10_000_000_000 {
        format!("{} MB", bytes / 1_000_000)
    } else {
        format!("{} GB", bytes / 1_000_000_000)
    }
}

/// The folder itself, or its nearest ancestor that exists.
fn existing(folder: &Path) -> PathBuf {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let there = whole.ancestors().find(|folder| folder.exists());
    there.unwrap_or(&whole).to_path_buf()
}

/// The first file of the mission that was written in the future, and how far.
fn written_later(mission: &Mission, now: Utc) -> Option<(&'static str, Duration)> {
    let now = UNIX_EPOCH + Duration::from_nanos(now.as_unix_nanos());
    ["mission.toml", mission.fence_file, "world.toml", "plan.toml"]
        .into_iter()
        .find_map(|file| {
            let written = fs::metadata(mission.folder.join(file)).ok()?.modified().ok()?;
            let ahead = written.duration_since(now).ok()?;
            (ahead > AHEAD_MAX).then_some((file, ahead))
        })
}

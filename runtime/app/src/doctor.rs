//! `backseat doctor`: whether this computer and its network are fit for a dive of a mission.

mod clock;
mod network;

use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use anyhow::Result;
use backseat_lock::sha256;
use backseat_mission::Mission;
use clap::Args;
use serde_json::json;

use crate::arguments::MissionArguments;
use crate::check::machine::{Room, RoomForLogs, STATE_ROOM, in_words, writable};
use crate::lock::{program_sha256, read_components};
use crate::output::{kib, say};
use crate::owner::explained;
use crate::run::host_and_port;
use crate::state::State;

#[derive(Debug, Args)]
pub(crate) struct Doctor {
    #[command(flatten)]
    mission: MissionArguments,
    /// The vehicle's address [default: vehicle.address of mission.toml]
    #[arg(long, value_name = "HOST:PORT")]
    connect: Option<String>,
    /// Look at this computer alone: connect to nothing
    #[arg(long)]
    offline: bool,
    /// Where the dive will write its logs
    #[arg(long, value_name = "DIR", default_value = "logs")]
    log: PathBuf,
    #[command(flatten)]
    log_room: RoomForLogs,
    /// Where the dive will keep identifiers and the operator's hold [default: the user's state folder]
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

/// How something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    Ok,
    /// The dive can go on, and somebody should know.
    Odd,
    /// The dive would suffer.
    Bad,
}

impl Word {
    const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Odd => "odd",
            Self::Bad => "bad",
        }
    }
}

/// What was looked at, how it is, and in words.
#[derive(Debug)]
struct Finding {
    what: String,
    word: Word,
    text: String,
}

impl Finding {
    fn new(what: impl Into<String>, word: Word, text: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            word,
            text: text.into(),
        }
    }
}

pub(crate) fn doctor(arguments: &Doctor) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let mut findings = vec![program(), kernel(), governor(Path::new("/sys/devices/system/cpu"))];
    findings.extend(clock::findings());
    findings.push(room("room for logs", &arguments.log, arguments.log_room.into()));
    match State::folder_of(arguments.state.as_deref(), &mission) {
        Ok(folder) => {
            let room = room("room for state", &folder, STATE_ROOM);
            // What cannot be made has said so.
            let is_possible = folder.exists() || room.word != Word::Bad;
            findings.push(room);
            findings.extend(is_possible.then(|| private(&folder)));
        }
        Err(error) => findings.push(Finding::new("state", Word::Bad, format!("{error:#}"))),
    }
    findings.extend(plugins(&mission, arguments.mission.plugins.as_deref()));
    if !arguments.offline {
        let (given, place) = match &arguments.connect {
            Some(address) => (address, "--connect"),
            None => (&mission.file.vehicle.address, "vehicle.address"),
        };
        match host_and_port(given, place) {
            Ok(address) => findings.extend(network::vehicle(&address)),
            Err(error) => findings.push(Finding::new("vehicle", Word::Bad, format!("{error:#}"))),
        }
        if let Some(sonar) = &mission.file.sonar {
            findings.push(network::reach(
                "payload controller",
                &format!("{}:{}", sonar.host, sonar.port),
            ));
        }
    }
    let fit = findings.iter().all(|finding| finding.word != Word::Bad);
    if arguments.json {
        let findings: Vec<_> = findings
            .iter()
            .map(|finding| json!({ "what": finding.what, "word": finding.word.name(), "text": finding.text }))
            .collect();
        say!("{}", json!({ "fit": fit, "findings": findings }));
    } else {
        for Finding { what, word, text } in &findings {
            say!("{:>3}  {what}: {text}", word.name());
        }
        say!("{}", if fit { "fit" } else { "not fit" });
    }
    Ok(fit)
}

fn program() -> Finding {
    let hash = program_sha256().unwrap_or_else(|error| format!("{error:#}"));
    let build = if cfg!(feature = "simulation") {
        "complete"
    } else {
        "for sea"
    };
    Finding::new(
        "program",
        Word::Ok,
        format!("{}, {build}, SHA-256 {hash}", env!("CARGO_PKG_VERSION")),
    )
}

fn kernel() -> Finding {
    let name = rustix::system::uname();
    let text = [name.sysname(), name.release(), name.machine()].map(|part| part.to_string_lossy().into_owned());
    Finding::new("computer", Word::Ok, text.join(" "))
}

/// The processor's speed should not wait for work: a step that begins at a low speed takes longer.
fn governor(folder: &Path) -> Finding {
    let governor = fs::read_to_string(folder.join("cpu0/cpufreq/scaling_governor"));
    match governor.as_deref().map(str::trim) {
        Ok("performance") => Finding::new("processor", Word::Ok, "governor performance"),
        Ok(other) => Finding::new(
            "processor",
            Word::Odd,
            format!("governor {other}: steps of plugins may take longer; cpupower frequency-set -g performance"),
        ),
        Err(_) => Finding::new("processor", Word::Ok, "its speed is not set by Linux"),
    }
}

fn room(what: &str, folder: &Path, least: Room) -> Finding {
    match writable(folder, least) {
        Ok(free) => Finding::new(what, Word::Ok, format!("{} in {}", in_words(free), folder.display())),
        Err(error) => Finding::new(what, Word::Bad, format!("{error:#}")),
    }
}

/// The hold and the console's token are of one user.
fn private(folder: &Path) -> Finding {
    let Ok(about) = fs::metadata(folder) else {
        return Finding::new("state", Word::Ok, format!("{} will be made", folder.display()));
    };
    let ours = rustix::process::geteuid().as_raw();
    if about.uid() != ours {
        let text = format!(
            "{} is of user {}, and this is user {ours}",
            folder.display(),
            about.uid()
        );
        return Finding::new("state", Word::Bad, text);
    }
    if about.permissions().mode() & 0o022 != 0 {
        let text = format!(
            "others can write into {}, and release a hold: chmod go-w",
            folder.display()
        );
        return Finding::new("state", Word::Odd, text);
    }
    // As a run opens them. An earlier run may have been another user's.
    let of_others =
        State::files(folder)
            .into_iter()
            .find_map(|path| match fs::OpenOptions::new().write(true).open(&path) {
                Err(error) if error.kind() == ErrorKind::PermissionDenied => Some(explained(&path, error)),
                _ => None,
            });
    if let Some(error) = of_others {
        return Finding::new("state", Word::Bad, format!("{error:#}"));
    }
    Finding::new("state", Word::Ok, format!("{} is ours", folder.display()))
}

fn plugins(mission: &Mission, folder: Option<&Path>) -> Vec<Finding> {
    match read_components(mission, folder) {
        Ok(components) => components
            .iter()
            .map(|(name, bytes)| {
                let text = format!("{} KiB, SHA-256 {}", kib(bytes.len()), sha256(bytes));
                Finding::new(format!("plugin {name}"), Word::Ok, text)
            })
            .collect(),
        Err(error) => vec![Finding::new("plugins", Word::Bad, format!("{error:#}"))],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_governor_that_saves_power_is_odd() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(governor(folder.path()).word, Word::Ok);
        let cpu = folder.path().join("cpu0/cpufreq");
        fs::create_dir_all(&cpu).unwrap();
        for (name, word) in [("performance\n", Word::Ok), ("powersave\n", Word::Odd)] {
            fs::write(cpu.join("scaling_governor"), name).unwrap();
            assert_eq!(governor(folder.path()).word, word, "{name}");
        }
    }

    #[test]
    fn a_state_folder_into_which_others_can_write_is_odd() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |mode| fs::set_permissions(folder.path(), fs::Permissions::from_mode(mode)).unwrap();
        mode(0o700);
        assert_eq!(private(folder.path()).word, Word::Ok);
        mode(0o770);
        assert_eq!(private(folder.path()).word, Word::Odd);
        assert_eq!(private(&folder.path().join("none")).word, Word::Ok);
    }
}

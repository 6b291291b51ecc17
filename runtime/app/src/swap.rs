//! `backseat swap`: another version of a plugin for a dive that is under way.
//!
//! The command leaves the component and an order in the folder `swap` of the vehicle's state, and waits for the answer
//! that the runtime leaves there.

use std::fs;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use backseat_lock::sha256;
use backseat_mission::Mission;
use backseat_plugin_loader::read_component;
use backseat_units::Timestamp;
use clap::Args;
use serde::{Deserialize, Serialize};

use crate::arguments::MissionArguments;
use crate::clock::{Clock, pause};
use crate::output::say;
use crate::owner::explained;
use crate::state::State;
use crate::terminal::tell;

/// The folder's name in that of the state.
pub(crate) const FOLDER: &str = "swap";
/// Why no order is taken from a folder.
pub(crate) const OPEN_FOLDER: &str = "others can write into this folder: chmod go-w";
/// The least of a hash that the operator must name, hexadecimal digits.
const HASH_DIGITS_MIN: usize = 12;
/// How long the command waits for the runtime, which may have to compile.
const PATIENCE: Duration = Duration::from_secs(150);
/// How soon a runtime takes an order.
const TAKEN_WITHIN: Duration = Duration::from_secs(5);
const LOOK_EVERY: Duration = Duration::from_millis(100);

#[derive(Debug, Args)]
pub(crate) struct Swap {
    #[command(flatten)]
    mission: MissionArguments,
    /// The plugin's name in the mission, and the component that takes its place
    #[arg(value_name = "NAME=FILE.wasm", value_parser = named_file)]
    plugin: (String, PathBuf),
    /// The SHA-256 of FILE, or its first 12 digits or more: the operator's word that it is the right one. Without it, the
    /// command names the hash and swaps nothing
    #[arg(long, value_name = "HASH")]
    sha256: Option<String>,
    /// Go back to the version before if this one fails, or is refused something for what it asks for, in its first N steps;
    /// 0 never goes back
    #[arg(long, value_name = "N", default_value_t = 30)]
    trial: u32,
    /// The folder of the run's state [default: that of the vehicle in the user's state folder]
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
}

/// What the operator wants, as it is left in the folder.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Order {
    /// Tells an order from the next one.
    pub(crate) number: u64,
    pub(crate) sha256: String,
    pub(crate) trial_steps: u32,
}

/// What came of it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Answer {
    pub(crate) number: u64,
    pub(crate) swapped: bool,
    pub(crate) text: String,
}

/// The files of the orders for a plugin, and what the runtime does with them.
pub(crate) struct Files<'a> {
    folder: &'a Path,
    plugin: &'a str,
}

impl<'a> Files<'a> {
    pub(crate) const fn of(folder: &'a Path, plugin: &'a str) -> Self {
        Self { folder, plugin }
    }

    fn file(&self, kind: &str) -> PathBuf {
        self.folder.join(format!("{}.{kind}", self.plugin))
    }

    /// The newest order, until the runtime takes it.
    pub(crate) fn order(&self) -> PathBuf {
        self.file("order")
    }

    /// The component of an order. Each order has its own, as the one before may still be at work.
    pub(crate) fn component(&self, number: u64) -> PathBuf {
        self.file(&format!("{number}.wasm"))
    }

    /// What came of an order.
    pub(crate) fn answer(&self, number: u64) -> PathBuf {
        self.file(&format!("{number}.answer"))
    }

    /// There while the runtime makes a version ready, of whichever plugin.
    pub(crate) fn at_work(folder: &Path) -> PathBuf {
        folder.join("at-work")
    }

    /// Lets nobody else give an order for the plugin, until the file is closed.
    fn lock(&self) -> Result<fs::File> {
        let path = self.file("lock");
        // A pipe is not waited for.
        let now = i32::try_from(rustix::fs::OFlags::NONBLOCK.bits()).unwrap_or_default();
        let mut options = fs::OpenOptions::new();
        let file = options.write(true).create(true).custom_flags(now).open(&path);
        let file = file.map_err(|error| explained(&path, error))?;
        match file.try_lock() {
            Ok(()) => Ok(file),
            Err(fs::TryLockError::WouldBlock) => bail!(
                "another `backseat swap` of {} is under way: wait for its end",
                self.plugin
            ),
            Err(fs::TryLockError::Error(error)) => Err(explained(&path, error)),
        }
    }

    /// Removes what commands that were stopped have left.
    pub(crate) fn clear(&self) -> Result<()> {
        let prefix = format!("{}.", self.plugin);
        let is_left = |name: &str| {
            let numbered = name.strip_prefix(&prefix).and_then(|rest| rest.split_once('.'));
            numbered.is_some_and(|(number, kind)| {
                number.bytes().all(|digit| digit.is_ascii_digit())
                    && matches!(kind, "wasm" | "answer" | "wasm.new" | "answer.new")
            })
        };
        for entry in fs::read_dir(self.folder).map_err(|error| explained(self.folder, error))? {
            let entry = entry.map_err(|error| explained(self.folder, error))?;
            if entry.file_name().to_str().is_some_and(is_left) {
                // The runtime may have removed it.
                let _gone = fs::remove_file(entry.path());
            }
        }
        Ok(())
    }
}

/// Parses NAME=FILE.
pub(crate) fn named_file(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, file)) if !name.is_empty() && !file.is_empty() => Ok((name.to_owned(), PathBuf::from(file))),
        _ => Err("expected NAME=FILE with the name of a plugin of the mission".to_owned()),
    }
}

/// Writes a file whole or not at all.
pub(crate) fn place(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut draft = path.as_os_str().to_owned();
    draft.push(".new");
    let written = fs::write(&draft, bytes).and_then(|()| fs::rename(&draft, path));
    written.map_err(|error| {
        // On a full disk a part of it may be there.
        let _none = fs::remove_file(&draft);
        explained(path, error)
    })
}

/// Whether somebody else than its owner and the administrator can write into a folder.
pub(crate) fn is_open(folder: &Path) -> std::io::Result<bool> {
    let found = fs::metadata(folder)?;
    let ours = rustix::process::geteuid().as_raw();
    Ok(found.mode() & 0o022 != 0 || (found.uid() != ours && found.uid() != 0))
}

/// Puts another version in a plugin's place. Returns whether it took over.
pub(crate) fn swap(arguments: &Swap) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    let (plugin, file) = &arguments.plugin;
    let names: Vec<&str> = mission.file.plugins.iter().map(|table| table.name.as_str()).collect();
    ensure!(
        names.contains(&plugin.as_str()),
        "no plugin {plugin} in the mission; its plugins are: {}",
        names.join(", ")
    );
    let component = read_component(file).with_context(|| file.display().to_string())?;
    let hash = sha256(&component);
    let Some(named) = &arguments.sha256 else {
        bail!(
            "{}: name its hash if this is the component that you mean: --sha256 {}",
            file.display(),
            &hash[..HASH_DIGITS_MIN]
        );
    };
    let named = named.to_ascii_lowercase();
    ensure!(
        named.len() >= HASH_DIGITS_MIN && named.bytes().all(|digit| digit.is_ascii_hexdigit()),
        "--sha256 {named}: expected {HASH_DIGITS_MIN} hexadecimal digits or more"
    );
    ensure!(
        hash.starts_with(&named),
        "{}: its SHA-256 is {hash}, and not {named}",
        file.display()
    );
    let state = State::folder_of(arguments.state.as_deref(), &mission)?;
    ensure!(
        State::is_in_use(&state)?,
        "{}: no runtime uses this folder: start one with `backseat run`, or name its state folder with --state",
        state.display()
    );
    let folder = state.join(FOLDER);
    fs::DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(&folder)
        .map_err(|error| explained(&folder, error))?;
    ensure!(
        !is_open(&folder).map_err(|error| explained(&folder, error))?,
        "{}: {OPEN_FOLDER}",
        folder.display()
    );
    let clock = Clock::start();
    let order = Order {
        number: clock.utc_at_start().as_unix_nanos(),
        sha256: hash,
        trial_steps: arguments.trial,
    };
    let files = Files::of(&folder, plugin);
    let _ours_alone = files.lock()?;
    files.clear()?;
    place(&files.component(order.number), &component)?;
    place(&files.order(), toml::to_string(&order)?.as_bytes())?;
    let answer = await_answer(&files, order.number, &state, clock)?;
    say!("{}", answer.text);
    Ok(answer.swapped)
}

/// Waits for what comes of an order.
fn await_answer(files: &Files<'_>, number: u64, state: &Path, clock: Clock) -> Result<Answer> {
    let (mut taken, mut told) = (None, false);
    // When the runtime was last seen at work on another order.
    let mut at_work = Timestamp::ZERO;
    loop {
        pause(LOOK_EVERY);
        let answer = fs::read_to_string(files.answer(number)).ok();
        if let Some(answer) = answer.and_then(|text| toml::from_str::<Answer>(&text).ok()) {
            let _kept_for_nobody = fs::remove_file(files.answer(number));
            return Ok(answer);
        }
        let now = clock.now();
        let is_waiting = taken.is_none() && files.order().exists();
        if is_waiting {
            if Files::at_work(files.folder).exists() {
                at_work = now;
            }
            let busy = now.since(Timestamp::ZERO) > PATIENCE;
            if (now.since(at_work) > TAKEN_WITHIN || busy) && withdrawn(files, number)? {
                match busy && now.since(at_work) <= TAKEN_WITHIN {
                    true => bail!("the runtime is still at work on an earlier order: this one is withdrawn"),
                    false => bail!("the runtime has not taken the order, which is withdrawn: is it stuck?"),
                }
            }
        } else {
            let since = *taken.get_or_insert(now);
            ensure!(
                now.since(since) <= PATIENCE,
                "the runtime has taken the order and not answered for {} s: look at its log",
                PATIENCE.as_secs()
            );
        }
        if now.since(Timestamp::ZERO) > TAKEN_WITHIN && !told {
            told = true;
            let what = match is_waiting {
                true => "the runtime is at work on an earlier order, and this one waits",
                false => "the runtime makes the new version ready",
            };
            tell(&format!("{}: {what}", files.plugin));
        }
        ensure!(
            State::is_in_use(state)?,
            "the runtime has ended, and has not answered: nothing is known of the order"
        );
    }
}

/// Takes an order back. Returns false if the runtime has just taken it.
fn withdrawn(files: &Files<'_>, number: u64) -> Result<bool> {
    match fs::remove_file(files.order()) {
        Ok(()) => {
            let _not_needed = fs::remove_file(files.component(number));
            Ok(true)
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(explained(&files.order(), error)),
    }
}

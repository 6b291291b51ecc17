//! `backseat swap`: another version of a plugin for a dive that is under way.
//!
//! The command leaves the component and an order in the folder `swap` of the vehicle's state, and waits for the answer
//! that the runtime leaves there.

use std::fs;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use backseat_lock::sha256;
use backseat_mission::Mission;
use backseat_plugin_host::COMPONENT_BYTES;
use clap::Args;
use serde::{Deserialize, Serialize};

use crate::arguments::MissionArguments;
use crate::clock::{Clock, pause};
use crate::output::say;
use crate::owner::explained;
use crate::state::State;

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
    /// The SHA-256 of FILE, or its first 12 digits or more: the operator's word that it is the right one
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

/// The files of an order for a plugin.
pub(crate) struct Files {
    pub(crate) component: PathBuf,
    pub(crate) order: PathBuf,
    pub(crate) answer: PathBuf,
}

impl Files {
    pub(crate) fn of(folder: &Path, plugin: &str) -> Self {
        let file = |kind: &str| folder.join(format!("{plugin}.{kind}"));
        Self {
            component: file("wasm"),
            order: file("order"),
            answer: file("answer"),
        }
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
    written.map_err(|error| explained(path, error))
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
    let size = fs::metadata(file).with_context(|| file.display().to_string())?.len();
    ensure!(
        size <= COMPONENT_BYTES as u64,
        "{}: {size} bytes, expected at most {COMPONENT_BYTES}",
        file.display()
    );
    let component = fs::read(file).with_context(|| file.display().to_string())?;
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
    place(&files.component, &component)?;
    place(&files.order, toml::to_string(&order)?.as_bytes())?;
    let answer = await_answer(&files, order.number, clock)?;
    say!("{}", answer.text);
    Ok(answer.swapped)
}

fn await_answer(files: &Files, number: u64, clock: Clock) -> Result<Answer> {
    loop {
        pause(LOOK_EVERY);
        let answer = fs::read_to_string(&files.answer).ok();
        let answer = answer.and_then(|text| toml::from_str::<Answer>(&text).ok());
        if let Some(answer) = answer.filter(|answer| answer.number == number) {
            let _kept_for_nobody = fs::remove_file(&files.answer);
            return Ok(answer);
        }
        let waited = clock.now().since(backseat_units::Timestamp::ZERO);
        if waited > TAKEN_WITHIN && files.order.exists() {
            let _taken = fs::remove_file(&files.order);
            bail!("the runtime has not taken the order, which is withdrawn: is it stuck?");
        }
        ensure!(
            waited <= PATIENCE,
            "the runtime has taken the order and not answered for {} s: look at its log",
            PATIENCE.as_secs()
        );
    }
}

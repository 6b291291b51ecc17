use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use backseat_core::{Condition, Envelope, Order, Policy, Settings, SonarSetup};
use backseat_spi::Text;
use config::{Config, Environment, File, FileFormat};
use sha2::{Digest, Sha256};

use crate::component::find_component;
use crate::error::MissionError;
use crate::external::{ExternalTable, check_externals};
use crate::fence;
use crate::file::{MissionFile, PluginTable, VehicleTable};
use crate::place::config_line;
use crate::plan::{self, FrontSeatPlan};
use crate::set;
use crate::sonar::check_sonar;
use crate::unknown::with_new_name;

/// The layers over `mission.toml`.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// `KEY=VALUE` from the command line; keys are joined by dots.
    pub set: Vec<String>,
    /// Whether the environment's `BACKSEAT__*` variables are used.
    pub environment: bool,
}

impl Layers {
    /// The names of what they set, in the order in which one overrides another: variables, then `--set KEY=VALUE`.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        if self.environment {
            let variables = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
            names.extend(variables.filter(|name| name.starts_with("BACKSEAT__")));
            names.sort();
        }
        names.extend(self.set.iter().map(|set| format!("--set {set}")));
        names
    }
}

/// A mission, parsed and checked.
pub struct Mission {
    /// The folder's name.
    pub name: String,
    /// The folder.
    pub folder: PathBuf,
    /// `mission.toml` with its layers merged.
    pub file: MissionFile,
    /// The fence and the limits.
    pub envelope: Arc<Envelope>,
    /// The name of the fence's file.
    pub fence_file: &'static str,
    /// The fence as GeoJSON with polygons only: the text of `fence.geojson` if it has nothing else, otherwise written
    /// from the fence that was read.
    pub fence_text: String,
    /// The fence's file, if `fence_text` was written from it.
    fence_as_read: Option<String>,
    /// The front seat's plan that the mission names, if it names one.
    pub plan: Option<FrontSeatPlan>,
    /// The whole mission file after merging, as TOML.
    pub resolved: String,
    /// The text of `mission.toml`; `None` if the mission was read from a log.
    text: Option<String>,
}

/// What the log of a run has of its mission.
#[derive(Clone, Copy, Debug)]
pub struct RecordedParts<'a> {
    /// The mission's name.
    pub name: &'a str,
    /// [`Mission::resolved`].
    pub mission: &'a str,
    /// The name and the text of the fence's file: `fence.geojson`, `fence.plan` or `fence.kml`.
    pub fence: (&'a str, &'a str),
    /// The text of the plan that the mission names.
    pub plan: Option<&'a str>,
    /// `plugin.NAME.KEY=VALUE` to change in it.
    pub set: &'a [String],
}

impl MissionFile {
    /// Reads `mission.toml` alone, as attached to the log of a run, without the other files of the mission's folder.
    ///
    /// # Errors
    ///
    /// [`MissionError::Toml`] with the line in `name`.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, MissionError> {
        toml::from_str(text).map_err(|error| toml_error(Path::new(name), text, &error))
    }
}

impl Mission {
    /// Reads a mission's folder.
    ///
    /// # Errors
    ///
    /// [`MissionError`] in one line, with file and place.
    pub fn load(folder: &Path, layers: &Layers) -> Result<Self, MissionError> {
        let path = folder.join("mission.toml");
        if !path.is_file() {
            return Err(if folder.is_file() {
                MissionError::NoFolder {
                    path: folder.to_path_buf(),
                    folder: folder.parent().map(Path::to_path_buf).unwrap_or_default(),
                }
            } else if folder.exists() {
                MissionError::NoMission {
                    path: folder.to_path_buf(),
                    inside: missions_in(folder).into_iter().next(),
                }
            } else {
                MissionError::NoSuchMission {
                    path: folder.to_path_buf(),
                    similar: similar_mission(folder),
                }
            });
        }
        let text = read_own(&path)?;
        // Parsed on its own first, because merging loses the line numbers.
        toml::from_str::<MissionFile>(&text).map_err(|error| toml_error(&path, &text, &error))?;
        let file = layered(&path, &text, layers)?;
        check(&path, &file)?;
        let fence = fence::load(folder, file.fence.as_ref(), file.origin)?;
        let plan = match &file.plan {
            Some(table) => Some(plan::load(folder, table, file.vehicle.class)?),
            None => None,
        };
        let name = folder
            .canonicalize()
            .unwrap_or_else(|_| folder.to_path_buf())
            .file_name()
            .map_or_else(|| "mission".to_owned(), |name| name.to_string_lossy().into_owned());
        Ok(Self {
            text: Some(text),
            ..Self::assemble(name, folder, file, fence, plan)?
        })
    }

    /// Reads the mission of a run again from what the run's log has of it. The settings, the fence and the limits have
    /// the bits that they had in the run.
    ///
    /// # Errors
    ///
    /// [`MissionError`] in one line, with the attachment and the place; [`MissionError::Value`] if the mission names a
    /// plan and `parts` have none.
    pub fn recorded(parts: &RecordedParts<'_>) -> Result<Self, MissionError> {
        let path = Path::new("mission.toml");
        let text = set::plugins(parts.mission, parts.set)?;
        let file: MissionFile = toml::from_str(&text).map_err(|error| toml_error(path, &text, &error))?;
        check(path, &file)?;
        let (name, text) = parts.fence;
        // With a fence that was written as GeoJSON, the table is of the file from which it was read.
        let table = file.fence.as_ref().filter(|_| name != "fence.geojson");
        let fence = fence::read_text(Path::new(""), name, text.to_owned(), table, file.origin)?;
        let plan = match (&file.plan, parts.plan) {
            (Some(table), Some(text)) => Some(plan::of_text(
                Path::new(""),
                table,
                file.vehicle.class,
                text.to_owned(),
            )?),
            (Some(table), None) => {
                let missing = format!("plan.file is {:?}, and the log does not have this file", table.file);
                return Err(value(path, missing));
            }
            (None, _) => None,
        };
        Self::assemble(parts.name.to_owned(), Path::new(""), file, fence, plan)
    }

    fn assemble(
        name: String,
        folder: &Path,
        mut file: MissionFile,
        fence: fence::Loaded,
        plan: Option<FrontSeatPlan>,
    ) -> Result<Self, MissionError> {
        file.session.externals = file.externals.iter().map(ExternalTable::setup).collect();
        file.session.recovery.clone_from(&file.recovery);
        file.session.policies.clone_from(&file.policies);
        file.session.trackcircle_entry_angle = file.vehicle.trackcircle_entry_angle;
        file.session.sonar = file.sonar.as_ref().map(|sonar| SonarSetup {
            sensors: sonar.sensor.iter().map(|sensor| sensor.index).collect(),
            log_with_vehicle: sonar.log_with_vehicle,
        });
        file.session.expected_plan = plan.as_ref().map(FrontSeatPlan::expected);
        let resolved = toml::to_string(&file).map_err(|error| {
            value(
                &folder.join("mission.toml"),
                format!("cannot be written as TOML: {error}"),
            )
        })?;
        let envelope = Arc::new(Envelope::new(fence.fence, file.limits.clone()));
        Ok(Self {
            name,
            folder: folder.to_path_buf(),
            file,
            envelope,
            fence_file: fence.file,
            fence_text: fence.text,
            fence_as_read: fence.as_read,
            plan,
            resolved,
            text: None,
        })
    }

    /// The name and the text of the fence's file, if [`Mission::fence_text`] is not that text.
    #[must_use]
    pub fn other_fence(&self) -> Option<(&'static str, &str)> {
        self.fence_as_read.as_deref().map(|text| (self.fence_file, text))
    }

    /// The line, counted from 1, at which `mission.toml` has a key of a plugin's config: `contour_m`, or `area.east_m`
    /// for a key of a table. If it lacks the key, the line of the table that lacks it; `None` if the plugin has no config there, and
    /// for a mission that was read from a log.
    #[must_use]
    pub fn config_line(&self, plugin: &str, key: &str) -> Option<usize> {
        config_line(self.text.as_deref()?, plugin, key)
    }

    /// Where each plugin's component is, in priority order.
    ///
    /// # Errors
    ///
    /// [`MissionError::NoComponent`] for the first that is not found.
    pub fn components(&self, folder: Option<&Path>) -> Result<Vec<PathBuf>, MissionError> {
        self.file
            .plugins
            .iter()
            .map(|plugin| find_component(&self.folder, &plugin.name, &plugin.component, folder))
            .collect()
    }

    /// The SHA-256 of the resolved mission file, the fence's text and the text of the plan that it names, in
    /// hexadecimal.
    #[must_use]
    pub fn hash(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(self.resolved.as_bytes());
        hash.update([0]);
        hash.update(self.fence_text.as_bytes());
        if let Some(plan) = &self.plan {
            hash.update([0]);
            hash.update(plan.text.as_bytes());
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn layered(path: &Path, text: &str, layers: &Layers) -> Result<MissionFile, MissionError> {
    let text = &set::plugins(text, &layers.set)?;
    let mut builder = Config::builder().add_source(File::from_str(text, FileFormat::Toml));
    if layers.environment {
        builder = builder.add_source(
            Environment::with_prefix("BACKSEAT")
                .prefix_separator("__")
                .separator("__")
                .try_parsing(true),
        );
    }
    for set in &layers.set {
        if let Some(line) = set::line(set)? {
            builder = builder.add_source(File::from_str(&line, FileFormat::Toml));
        }
    }
    let over = |error: config::ConfigError| {
        let mut message = with_new_name(&dotted(&one_line(&error.to_string())));
        // The first name of a key that `mission.toml` does not know, which may be one of the world.
        let of_world = |set: &&String| {
            let first = set.split(['.', '=']).next().unwrap_or_default().trim();
            message.starts_with(&format!("unknown field `{first}`"))
        };
        if let Some(set) = layers.set.iter().find(of_world) {
            message.push_str(&format!(
                "; a key of world.toml begins with `world.`: world.{}",
                set.trim_start()
            ));
        }
        MissionError::Layer {
            layer: [vec![path.display().to_string()], layers.names()]
                .concat()
                .join(" with "),
            message,
        }
    };
    builder.build().map_err(over)?.try_deserialize().map_err(over)
}

/// The missions in a folder, by name.
fn missions_in(folder: &Path) -> Vec<PathBuf> {
    let listed = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let entries = std::fs::read_dir(listed).into_iter().flatten().filter_map(Result::ok);
    let mut missions: Vec<PathBuf> = entries
        .map(|entry| folder.join(entry.file_name()))
        .filter(|path| path.join("mission.toml").is_file())
        .collect();
    missions.sort();
    missions
}

/// The mission that somebody may have meant who gave a path at which there is nothing: one of a similar name in the same
/// folder, or in `missions`.
fn similar_mission(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let folders = [path.parent()?, Path::new("missions")];
    folders.iter().flat_map(|folder| missions_in(folder)).find(|mission| {
        let known = mission.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        crate::unknown::is_like(name, known)
    })
}

/// Checks the values that no type checks.
fn check(path: &Path, file: &MissionFile) -> Result<(), MissionError> {
    check_externals(&file.externals).map_err(|fault| value(path, fault))?;
    file.limits
        .validate()
        .map_err(|error| value(path, format!("limits.{error}")))?;
    file.recovery
        .validate()
        .map_err(|error| value(path, format!("recovery.{error}")))?;
    check_texts(path, &file.session)?;
    check_vehicle(path, &file.vehicle)?;
    check_plugins(path, &file.plugins)?;
    check_sonar(file.sonar.as_ref(), &file.plugins).map_err(|fault| value(path, fault))?;
    check_policies(path, &file.policies)?;
    check_holds(path, &file.session, &file.policies)
}

fn check_plugins(path: &Path, plugins: &[PluginTable]) -> Result<(), MissionError> {
    let mut names = BTreeSet::new();
    for plugin in plugins {
        if plugin.name.is_empty() || !names.insert(&plugin.name) {
            return Err(value(
                path,
                format!(
                    "plugin name `{}`: expected one that is not empty and not used twice",
                    plugin.name
                ),
            ));
        }
        plugin
            .limits
            .validate()
            .map_err(|error| value(path, format!("plugin `{}`: limits.{error}", plugin.name)))?;
        let budget = &plugin.budget;
        if budget.fuel_per_step == 0 || !(1..=1024).contains(&budget.memory_mib) {
            return Err(value(
                path,
                format!(
                    "plugin `{}`: budget.fuel_per_step is {} (expected above 0) and budget.memory_mib is {} (expected 1 to 1024)",
                    plugin.name, budget.fuel_per_step, budget.memory_mib
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that the operator's texts can arrive as a mission command, and that they differ.
fn check_texts(path: &Path, session: &Settings) -> Result<(), MissionError> {
    let (hold, release) = (&session.hold_text, &session.release_text);
    for (key, text) in [("hold_text", hold), ("release_text", release)] {
        if let Some(text) = text {
            check_text(text).map_err(|why| value(path, format!("session.{key} {why}")))?;
        }
    }
    if hold.is_some() && hold == release {
        return Err(value(
            path,
            "session.release_text equals session.hold_text: expected a different text".to_owned(),
        ));
    }
    Ok(())
}

/// Checks the vehicle's name.
fn check_vehicle(path: &Path, vehicle: &VehicleTable) -> Result<(), MissionError> {
    let Some(name) = &vehicle.name else { return Ok(()) };
    let plain = |character: char| character.is_ascii_alphanumeric() || matches!(character, '.' | '_' | '-');
    if (1..=64).contains(&name.len()) && name.chars().all(plain) && !name.starts_with('.') {
        return Ok(());
    }
    let expected = "1 to 64 letters, digits, '.', '_' and '-', and no '.' first";
    Err(value(path, format!("vehicle.name is {name:?}: expected {expected}")))
}

fn check_holds(path: &Path, session: &Settings, policies: &[Policy]) -> Result<(), MissionError> {
    let texts = [
        ("session.hold_text", &session.hold_text, Order::Hold),
        ("session.release_text", &session.release_text, Order::Release),
    ];
    let mut told: Vec<(String, Condition, Order)> = Vec::new();
    for (name, text, order) in texts {
        if let Some(text) = text {
            told.push((name.to_owned(), Condition::MissionCommand(text.clone()), order));
        }
    }
    for (number, policy) in (1..).zip(policies) {
        let name = format!("policy {number}");
        if matches!(policy.order, Order::Hold | Order::Release) {
            let contrary = told
                .iter()
                .find(|(_, when, order)| *when == policy.when && *order != policy.order);
            if let Some((other, _, order)) = contrary {
                let message = format!(
                    "{name} would {} on the same condition on which {other} would {order}: expected another condition",
                    policy.order
                );
                return Err(value(path, message));
            }
            told.push((name, policy.when.clone(), policy.order.clone()));
        }
    }
    Ok(())
}

/// A stale time of more than a day is probably a typing error.
const STALE_MAX_S: f64 = 86_400.0;
/// The length that fits into the vehicle's log and into a topside message.
const TEXT_MAX: usize = 200;

fn check_policies(path: &Path, policies: &[Policy]) -> Result<(), MissionError> {
    for (number, policy) in (1..).zip(policies) {
        let fault = |what: String| value(path, format!("policy {number}: {what}"));
        match &policy.when {
            Condition::MissionCommand(text) => {
                check_text(text).map_err(|why| fault(format!("when.mission-command {why}")))?;
            }
            Condition::TopsideMessage(text) => {
                check_text(text).map_err(|why| fault(format!("when.topside-message {why}")))?;
            }
            Condition::NavigationStaleForS(seconds) => {
                if !(*seconds > 0.0 && *seconds <= STALE_MAX_S) {
                    return Err(fault(format!(
                        "when.navigation-stale-for-s is {seconds}: expected seconds above 0 and at most {STALE_MAX_S}"
                    )));
                }
            }
            Condition::PluginQuarantined => {}
        }
        match &policy.order {
            Order::Abort { text, .. } => check_text(text).map_err(|why| fault(format!("order.abort.text {why}")))?,
            Order::Kill { text } => check_text(text).map_err(|why| fault(format!("order.kill.text {why}")))?,
            Order::StartEmptyMission { duration_s: 0 } => {
                return Err(fault(
                    "order.start-empty-mission.duration_s is 0: expected seconds above 0".to_owned(),
                ));
            }
            Order::Hold
            | Order::Release
            | Order::CancelAll
            | Order::CancelCurrent
            | Order::CancelElement
            | Order::StartEmptyMission { .. } => {}
        }
    }
    Ok(())
}

/// Checks that a text can be a field of a sentence.
fn check_text(text: &str) -> Result<(), String> {
    let expected = format!(
        "expected 1 to {TEXT_MAX} printable characters of ASCII without comma, asterisk, dollar, and leading or \
         trailing spaces"
    );
    if text.trim() != text || !(1..=TEXT_MAX).contains(&text.len()) || Text::new(text).is_err() {
        return Err(format!("is {text:?}: {expected}"));
    }
    Ok(())
}

/// Reads a file of the mission's folder. A pipe there would hold up the start for ever, so it is refused.
pub(crate) fn read_own(path: &Path) -> Result<String, MissionError> {
    let is_other = path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir());
    if is_other {
        return Err(value(
            path,
            "expected a file, found a pipe, a socket or a device".to_owned(),
        ));
    }
    read(path)
}

pub(crate) fn read(path: &Path) -> Result<String, MissionError> {
    std::fs::read_to_string(path).map_err(|source| MissionError::Read {
        path: path.to_path_buf(),
        source,
    })
}

pub(crate) fn value(path: &Path, message: String) -> MissionError {
    MissionError::Value {
        path: path.to_path_buf(),
        message,
    }
}

pub(crate) fn toml_error(path: &Path, text: &str, error: &toml::de::Error) -> MissionError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let before = text.get(..start).unwrap_or("");
    let line = before.matches('\n').count() + 1;
    let message = with_new_name(&one_line(error.message()));
    // serde names a type of Rust, and not the key.
    let message = match key_before(before) {
        Some(key) => format!("{key}: {message}"),
        None => message,
    };
    let message = TYPES
        .iter()
        .fold(message, |message, (rust, plain)| message.replace(rust, plain));
    MissionError::Toml {
        path: path.to_path_buf(),
        line,
        message,
    }
}

/// What serde calls a type, and what its value is in a file.
const TYPES: [(&str, &str); 8] = [
    ("expected f64", "expected a number"),
    ("expected i32", "expected a whole number, -2147483648 to 2147483647"),
    ("expected u16", "expected a whole number, 0 to 65535"),
    ("expected u32", "expected a whole number, 0 to 4294967295"),
    ("expected u64", "expected a whole number, 0 or more"),
    ("expected usize", "expected a whole number, 0 or more"),
    ("expected a boolean", "expected true or false"),
    ("expected a sequence", "expected a list"),
];

/// The key whose value, or an entry of whose list, begins where this text ends.
fn key_before(text: &str) -> Option<&str> {
    let (before, value) = text.rsplit_once('=')?;
    let value = value.trim();
    if !(value.is_empty() || value.starts_with('[') && !value.contains(']')) {
        return None;
    }
    let key = before.rsplit(['\n', ',', '{']).next()?.trim();
    (!key.is_empty()).then_some(key)
}

/// The crate `config` writes the path of a key in a table of a list as `plugin[0]limits`.
fn dotted(text: &str) -> String {
    let Some((before, key)) = text.rsplit_once("for key `") else {
        return text.to_owned();
    };
    let mut path = String::new();
    for (at, part) in key.split(']').enumerate() {
        if at > 0 {
            path.push_str(if part.starts_with(char::is_alphanumeric) {
                "]."
            } else {
                "]"
            });
        }
        path.push_str(part);
    }
    format!("{before}for key `{path}")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;

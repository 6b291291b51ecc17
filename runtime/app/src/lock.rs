//! Signs a mission that was checked, and compares one that is going to run with what was signed.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use backseat_fence::Rfc3339;
use backseat_lock::{
    Contents, Difference, LOCK, Parts, PublicKey, SecretKey, create_keys, open, open_unverified, seal, sha256,
};
use backseat_mission::Mission;
use backseat_plugin_loader::read_component;
use backseat_units::Utc;
use clap::Args;

use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct Key {
    /// The pair's name: NAME.key, which is yours alone, and NAME.pub, which goes to the vehicle
    #[arg(value_name = "NAME")]
    name: PathBuf,
}

pub(crate) fn key(arguments: &Key) -> Result<bool> {
    let (secret, public) = create_keys(&arguments.name)?;
    say!(
        "{}: sign with it, and give it to nobody: check --sign {}",
        secret.display(),
        secret.display()
    );
    say!(
        "{}: goes to the vehicle: run --locked {}",
        public.display(),
        public.display()
    );
    Ok(true)
}

/// The SHA-256 of this program.
pub(crate) fn program_sha256() -> Result<String> {
    let bytes = std::env::current_exe().and_then(std::fs::read);
    Ok(sha256(&bytes.context("the program's own file")?))
}

/// Components that may take the place of those of a mission in mid-dive, or step beside them, because the lock has them.
#[derive(Debug)]
pub(crate) struct Allowed {
    path: PathBuf,
    signed: Contents,
}

impl Allowed {
    /// Checks that a component may take a plugin's place.
    ///
    /// # Errors
    ///
    /// If nobody signed that.
    pub(crate) fn check(&self, plugin: &str, sha256: &str) -> Result<()> {
        ensure!(
            self.signed.may_swap(plugin, sha256),
            "{}: {} did not sign that {} may take the place of {plugin}: check --sign KEY --may-swap {plugin}=FILE",
            self.path.display(),
            self.signed.signed_by,
            &sha256[..12]
        );
        Ok(())
    }
}

/// What of a mission is signed, as it was loaded.
fn contents(
    mission: &Mission,
    components: &[(String, Vec<u8>)],
    swaps: &[(String, Vec<u8>)],
    program_sha256: &str,
    by: &str,
    at: &str,
) -> Result<Contents> {
    let file = mission.folder.join("mission.toml");
    let parts = Parts {
        name: &mission.name,
        file: &std::fs::read(&file).with_context(|| file.display().to_string())?,
        mission: &mission.resolved,
        fence: mission
            .other_fence()
            .map_or(mission.fence_text.as_str(), |(_, text)| text)
            .as_bytes(),
        plan: mission.plan.as_ref().map(|plan| plan.text.as_str()),
        components,
        swaps,
        program_sha256,
    };
    Ok(Contents::of(&parts, by, at))
}

/// A name that people can read in a line.
pub(crate) fn signer(text: &str) -> Result<String, String> {
    let name = text.trim();
    if name.is_empty() || name.chars().count() > 64 || name.chars().any(char::is_control) {
        return Err("expected a name of 1 to 64 characters in one line".to_owned());
    }
    Ok(name.to_owned())
}

/// Signs a mission, and writes its lock.
pub(crate) fn sign(
    mission: &Mission,
    components: &[(String, Vec<u8>)],
    may_swap: &[(String, PathBuf)],
    key: &Path,
    by: &str,
    now: Utc,
) -> Result<()> {
    let key = SecretKey::read(key)?;
    let swaps = may_swap
        .iter()
        .map(|(name, file)| {
            let option = || format!("--may-swap {name}={}", file.display());
            ensure!(
                mission.file.plugins.iter().any(|table| table.name == *name),
                "{}: no plugin {name} in the mission",
                option()
            );
            Ok((name.clone(), read_component(file).with_context(option)?))
        })
        .collect::<Result<Vec<_>>>()?;
    let lock = seal(
        &contents(
            mission,
            components,
            &swaps,
            &program_sha256()?,
            by,
            &Rfc3339(now).to_string(),
        )?,
        &key,
    );
    let path = mission.folder.join(LOCK);
    std::fs::write(&path, lock).with_context(|| path.display().to_string())?;
    say!("signed: {}", path.display());
    Ok(())
}

/// How a mission stands to the lock in its folder, if there is one, in a line. Whether somebody whom the vehicle trusts has
/// signed the lock is not looked at.
///
/// `folder` is where components are looked for, as in [`Mission::components`].
pub(crate) fn beside_lock(
    mission: &Mission,
    components: &[(String, Vec<u8>)],
    folder: Option<&Path>,
) -> Result<BesideLock> {
    let path = mission.folder.join(LOCK);
    if !path.exists() {
        return Ok(BesideLock::None);
    }
    let signed = match open_unverified(&path) {
        Ok(signed) => signed,
        Err(error) => return Ok(BesideLock::Refused(error.to_string())),
    };
    let now = contents(mission, components, &[], &program_sha256()?, "", "")?;
    Ok(match signed.difference(&now) {
        None => BesideLock::Same(format!(
            "{LOCK}: nothing differs from what it says that {} signed; check --locked NAME.pub looks at the signature too",
            signed.signed_by
        )),
        Some(difference) => BesideLock::Refused(format!(
            "{LOCK}: {}, so that `run --locked` refuses this mission: restore what {} signed, or sign anew",
            with_file(&difference, mission, folder),
            signed.signed_by
        )),
    })
}

/// How a mission stands to the lock in its folder, in words.
pub(crate) enum BesideLock {
    /// There is no lock.
    None,
    /// The mission is as it was signed.
    Same(String),
    /// `run --locked` refuses it.
    Refused(String),
}

/// A difference, and which file has it.
fn with_file(difference: &Difference, mission: &Mission, folder: Option<&Path>) -> String {
    let file = match difference {
        Difference::Limits | Difference::File => Some(mission.folder.join("mission.toml")),
        Difference::Fence => Some(mission.folder.join(mission.fence_file)),
        Difference::Plan => mission.file.plan.as_ref().map(|plan| mission.folder.join(&plan.file)),
        Difference::Component(plugin) => {
            let mut names = mission.file.plugins.iter().map(|table| &table.name);
            let paths = mission.components(folder).unwrap_or_default();
            names
                .position(|name| name == plugin)
                .and_then(|index| paths.into_iter().nth(index))
        }
        Difference::Program => std::env::current_exe().ok(),
        Difference::Mission { .. } | Difference::LimitsSet | Difference::Setting => None,
    };
    match file {
        Some(file) => format!("{difference} ({})", file.display()),
        None => difference.to_string(),
    }
}

/// Reads the components of a mission, before anything of them runs.
pub(crate) fn read_components(mission: &Mission, folder: Option<&Path>) -> Result<Vec<(String, Vec<u8>)>> {
    let paths = mission.components(folder)?;
    let plugins = mission.file.plugins.iter().zip(paths);
    plugins
        .map(|(plugin, path)| {
            let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
            Ok((plugin.name.clone(), bytes))
        })
        .collect()
}

/// The lock of a mission that is going to run, signed by somebody whom the vehicle trusts.
pub(crate) struct Locked {
    path: PathBuf,
    signed: Contents,
    program_sha256: String,
}

impl Locked {
    /// Reads the lock, and checks that this key has signed it.
    ///
    /// # Errors
    ///
    /// If it cannot be read, or somebody else signed it.
    pub(crate) fn read(mission: &Mission, key: &Path) -> Result<Self> {
        let path = mission.folder.join(LOCK);
        Ok(Self {
            signed: open(&path, &PublicKey::read(key)?)?,
            program_sha256: program_sha256()?,
            path,
        })
    }

    /// What else may run.
    pub(crate) fn allowed(self) -> Allowed {
        Allowed {
            path: self.path,
            signed: self.signed,
        }
    }

    /// Compares what is going to run with what was signed. Returns who signed it, and when. `folder` is where components are
    /// looked for, as in [`Mission::components`].
    ///
    /// # Errors
    ///
    /// If something differs.
    pub(crate) fn compare(
        &self,
        mission: &Mission,
        components: &[(String, Vec<u8>)],
        folder: Option<&Path>,
    ) -> Result<String> {
        let Self {
            path,
            signed,
            program_sha256,
        } = self;
        let loaded = contents(mission, components, &[], program_sha256, "", "")?;
        if let Some(difference) = signed.difference(&loaded) {
            bail!(
                "{}: {}: restore what {} signed, or check and sign anew",
                path.display(),
                with_file(&difference, mission, folder),
                signed.signed_by
            );
        }
        Ok(format!("signed by {}, {}", signed.signed_by, signed.signed_at))
    }
}

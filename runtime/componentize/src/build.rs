use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::{Error, componentize};

/// The target of plugins.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// The settings of the profile `plugin`. They are also given on the command line, so that a crate outside of this
/// workspace, or with a changed profile, is built in the same way.
const PROFILE: [&str; 7] = [
    "profile.plugin.inherits='release'",
    "profile.plugin.opt-level=3",
    "profile.plugin.lto=true",
    "profile.plugin.codegen-units=1",
    "profile.plugin.panic='abort'",
    "profile.plugin.strip=true",
    "profile.plugin.debug=false",
];

/// Separates the flags in `CARGO_ENCODED_RUSTFLAGS`.
const FLAG_SEPARATOR: &str = "\x1f";

/// The plugins of a workspace in alphabetical order: the packages in its folder `plugins` that build a `cdylib`.
///
/// # Errors
///
/// [`Error::Failed`] if there is no workspace, [`Error::Tool`] if cargo cannot be run.
pub fn plugins(workspace_dir: &Path) -> Result<Vec<String>, Error> {
    let metadata = metadata(workspace_dir, &["--no-deps"])?;
    let folder = Path::new(metadata["workspace_root"].as_str().unwrap_or_default()).join("plugins");
    let mut names: Vec<String> = metadata["packages"]
        .as_array()
        .into_iter()
        .flatten()
        .filter(|package| {
            package["manifest_path"]
                .as_str()
                .is_some_and(|path| Path::new(path).starts_with(&folder))
                && is_plugin(package)
        })
        .filter_map(|package| package["name"].as_str().map(str::to_owned))
        .collect();
    names.sort();
    Ok(names)
}

/// Whether a package in cargo's metadata builds a module.
fn is_plugin(package: &serde_json::Value) -> bool {
    let targets = package["targets"].as_array().into_iter().flatten();
    targets
        .filter_map(|target| target["crate_types"].as_array())
        .flatten()
        .any(|kind| kind == "cdylib")
}

/// Builds packages and writes each as a component to `out_dir/NAME.wasm`, where NAME is the package's name. The
/// packages are those of a workspace, or the single crate in a folder, for which `packages` may be empty. Returns the
/// paths in the order of `packages`, or by name if that is empty.
///
/// Uses the cargo that runs this program (`$CARGO`), or else the one in the path. Cargo's messages go to standard
/// error.
///
/// # Errors
///
/// [`Error::TargetMissing`] if the toolchain lacks the target, [`Error::Failed`] if the code does not compile,
/// [`Error::NoModule`] if a package is not a `cdylib`, [`Error::Encode`] if its module is not a plugin, [`Error::Tool`]
/// and [`Error::File`] if tools or folders are missing.
pub fn build(workspace_or_crate_dir: &Path, packages: &[&str], out_dir: &Path) -> Result<Vec<PathBuf>, Error> {
    require_target(workspace_or_crate_dir)?;
    let modules = compile(workspace_or_crate_dir, packages)?;
    fs::create_dir_all(out_dir).map_err(|source| Error::File {
        path: out_dir.into(),
        source,
    })?;
    let names: Vec<&str> = if packages.is_empty() {
        if modules.is_empty() {
            return Err(Error::NoModule(format!("in {}", workspace_or_crate_dir.display())));
        }
        modules.keys().map(String::as_str).collect()
    } else {
        packages.to_vec()
    };
    names
        .into_iter()
        .map(|name| {
            let module = modules.get(name).ok_or_else(|| Error::NoModule(name.to_owned()))?;
            let bytes = fs::read(module).map_err(|source| Error::File {
                path: module.clone(),
                source,
            })?;
            let path = out_dir.join(format!("{name}.wasm"));
            write_whole(&path, &componentize(&bytes)?)?;
            Ok(path)
        })
        .collect()
}

/// Asks the compiler where the target's libraries should be, which also works for toolchains without rustup.
fn require_target(directory: &Path) -> Result<(), Error> {
    let libraries = rustc(directory, &["--print", "target-libdir", "--target", TARGET])?;
    if Path::new(libraries.trim()).is_dir() {
        Ok(())
    } else {
        Err(Error::TargetMissing)
    }
}

/// Runs cargo, and returns the module of each package that has one, by the package's name.
fn compile(directory: &Path, packages: &[&str]) -> Result<BTreeMap<String, PathBuf>, Error> {
    let cargo = cargo();
    let mut command = Command::new(&cargo);
    command.args(["build", "--profile", "plugin", "--target", TARGET, "--lib"]);
    command.arg("--message-format=json-render-diagnostics");
    for setting in PROFILE {
        command.args(["--config", setting]);
    }
    for package in packages {
        command.args(["-p", package]);
    }
    command.current_dir(directory).stderr(Stdio::inherit());
    command.env("CARGO_ENCODED_RUSTFLAGS", flags(directory)?);
    // Such settings would change the generated code, and so the component.
    command
        .env_remove("CARGO_INCREMENTAL")
        .env_remove("RUSTC_WORKSPACE_WRAPPER");
    let output = run(command, &cargo.to_string_lossy())?;
    if !output.status.success() {
        return Err(Error::Failed {
            tool: "cargo build",
            directory: directory.into(),
            status: output.status,
        });
    }
    let messages = String::from_utf8_lossy(&output.stdout);
    Ok(messages
        .lines()
        .filter_map(module)
        .filter(|(name, _)| packages.is_empty() || packages.contains(&&**name))
        .collect())
}

/// The module in a line of cargo's JSON messages, with its package's name.
fn module(message: &str) -> Option<(String, PathBuf)> {
    let message: serde_json::Value = serde_json::from_str(message).ok()?;
    if message["reason"] != "compiler-artifact" {
        return None;
    }
    let is_wasm = |name: &&str| name.ends_with(".wasm");
    let file = message["filenames"]
        .as_array()?
        .iter()
        .filter_map(|name| name.as_str())
        .find(is_wasm)?;
    Some((package_name(message["package_id"].as_str()?)?.to_owned(), file.into()))
}

/// The name in a package ID (the Cargo book, "Package ID Specifications"): `URL#NAME@VERSION`, or `URL#VERSION` if the
/// name is the last part of the URL.
fn package_name(id: &str) -> Option<&str> {
    let (url, fragment) = id.rsplit_once('#')?;
    match fragment.split_once('@') {
        Some((name, _)) => Some(name),
        None => url.trim_end_matches('/').rsplit('/').next(),
    }
}

/// Compiler flags that remove the machine's paths from the artefact, because panics contain the names of source files.
fn flags(directory: &Path) -> Result<OsString, Error> {
    let mut prefixes = local_sources(directory)?;
    if let Some(home) = cargo_home() {
        // The folders' names contain a hash of the registry's address, which differs for a mirror.
        let registries = fs::read_dir(home.join("registry/src")).into_iter().flatten().flatten();
        prefixes.extend(registries.map(|entry| (entry.path(), "/registry".into())));
    }
    // Where the library's sources are installed, the compiler uses their path on this machine.
    let sysroot = rustc(directory, &["--print", "sysroot"])?;
    let version = rustc(directory, &["-vV"])?;
    if let Some(commit) = version.lines().find_map(|line| line.strip_prefix("commit-hash: ")) {
        prefixes.push((
            Path::new(sysroot.trim()).join("lib/rustlib/src/rust"),
            format!("/rustc/{commit}"),
        ));
    }
    // The last matching prefix is used, so the longest must come last.
    prefixes.sort();
    let mut flags = OsString::new();
    for (from, to) in prefixes {
        if !flags.is_empty() {
            flags.push(FLAG_SEPARATOR);
        }
        flags.push("--remap-path-prefix=");
        flags.push(from);
        flags.push("=");
        flags.push(to);
    }
    Ok(flags)
}

/// The places of sources that do not come from a registry, and their names in the artefact: the workspace, and packages
/// outside of it that are dependencies by path (the SDK, for a plugin in a folder of its own).
fn local_sources(directory: &Path) -> Result<Vec<(PathBuf, String)>, Error> {
    let metadata = metadata(directory, &["--filter-platform", TARGET])?;
    let root = Path::new(metadata["workspace_root"].as_str().unwrap_or_default());
    let mut sources = vec![(root.to_owned(), "/plugin".to_owned())];
    for package in metadata["packages"].as_array().into_iter().flatten() {
        let manifest = package["manifest_path"].as_str().map(Path::new).and_then(Path::parent);
        if let (Some(folder), Some(name), true) = (manifest, package["name"].as_str(), package["source"].is_null())
            && !folder.starts_with(root)
        {
            sources.push((folder.to_owned(), format!("/{name}")));
        }
    }
    sources.retain(|(folder, _)| !folder.as_os_str().is_empty());
    Ok(sources)
}

/// Cargo's metadata of a workspace. Missing fields are null, which callers treat as empty.
fn metadata(directory: &Path, arguments: &[&str]) -> Result<serde_json::Value, Error> {
    let cargo = cargo();
    let mut command = Command::new(&cargo);
    command.args(["metadata", "--format-version", "1"]).args(arguments);
    command.current_dir(directory).stderr(Stdio::inherit());
    let output = run(command, &cargo.to_string_lossy())?;
    if !output.status.success() {
        return Err(Error::Failed {
            tool: "cargo metadata",
            directory: directory.into(),
            status: output.status,
        });
    }
    Ok(serde_json::from_slice(&output.stdout).unwrap_or_default())
}

/// The cargo that runs this program, or else the one in the path.
fn cargo() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

fn cargo_home() -> Option<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")))
}

/// The output of rustc. It runs in the crate's folder, where a toolchain file may select the version.
fn rustc(directory: &Path, arguments: &[&str]) -> Result<String, Error> {
    let mut command = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    command.args(arguments).current_dir(directory).stderr(Stdio::inherit());
    let output = run(command, "rustc")?;
    if !output.status.success() {
        return Err(Error::Failed {
            tool: "rustc",
            directory: directory.into(),
            status: output.status,
        });
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn run(mut command: Command, tool: &str) -> Result<Output, Error> {
    command.output().map_err(|source| Error::Tool {
        tool: tool.to_owned(),
        source,
    })
}

/// Writes a file so that readers see either the old or the new bytes, never a part, because tests build side by side.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let part = path.with_extension(format!("wasm.{}", std::process::id()));
    fs::write(&part, bytes)
        .and_then(|()| fs::rename(&part, path))
        .map_err(|source| Error::File {
            path: path.into(),
            source,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_named_as_cargo_writes_their_ids() {
        for (id, name) in [
            ("path+file:///home/diver/plugins/isobath#0.1.0", "isobath"),
            ("path+file:///home/diver/plugins/survey#isobath@0.1.0", "isobath"),
            (
                "registry+https://github.com/rust-lang/crates.io-index#serde@1.0.0",
                "serde",
            ),
        ] {
            assert_eq!(package_name(id), Some(name));
        }
    }

    #[test]
    fn a_folder_without_a_crate_is_an_error() {
        let empty = tempfile::tempdir().unwrap();
        let error = build(empty.path(), &[], &empty.path().join("out")).unwrap_err();
        assert!(
            matches!(
                error,
                Error::Failed {
                    tool: "cargo metadata",
                    ..
                } | Error::TargetMissing
            ),
            "{error}"
        );
    }
}

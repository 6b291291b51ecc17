use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::cargo::{cargo_command, root, target};

/// The result of a compilation for the tests.
#[derive(Debug)]
pub(crate) struct Compiled {
    /// The test programs, each with the folder of its crate.
    pub(crate) tests: Vec<TestProgram>,
    /// The folder of the other programs.
    pub(crate) programs: PathBuf,
}

/// A test program.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TestProgram {
    pub(crate) folder: PathBuf,
    pub(crate) program: PathBuf,
}

/// Compiles every target of the workspace once, with Clippy in place of the compiler. Clippy is the compiler with more
/// lints; `cargo clippy` uses it in the same way but discards the code. A warning is an error in each crate that takes
/// the workspace's lints (`[lints] workspace = true`). In others, such as a plugin of your own, it is only shown.
pub(crate) fn compile() -> Result<Compiled> {
    compile_with(&["--workspace", "--all-targets"])
}

/// Compiles with these arguments for Cargo, in the same way.
pub(crate) fn compile_with(arguments: &[&str]) -> Result<Compiled> {
    let colours = if std::io::stderr().is_terminal() {
        "--message-format=json-diagnostic-rendered-ansi"
    } else {
        "--message-format=json"
    };
    let mut command = cargo_command(&[&["build", colours], arguments].concat());
    with_lints(&mut command)?;
    let mut cargo = command
        .current_dir(root()?)
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| format!("{command:?}"))?;
    let messages = cargo.stdout.take().context("the stream was asked for")?;
    let mut warned = BTreeSet::new();
    let mut tests = BTreeSet::new();
    let mut shown = BTreeSet::new();
    for line in BufReader::new(messages).lines() {
        let Ok(message) = serde_json::from_str::<Value>(&line?) else {
            continue;
        };
        // A library is compiled for itself and for its tests; a message of both is shown once.
        if let Some(text) = message["message"]["rendered"].as_str()
            && shown.insert(text.to_owned())
        {
            eprint!("{text}");
        }
        warned.extend(warned_manifest(&message));
        tests.extend(test_program(&message));
    }
    if !cargo.wait()?.success() {
        bail!("the workspace does not compile");
    }
    let held: Vec<String> = warned
        .iter()
        .filter(|manifest| takes_lints(manifest))
        .map(|manifest| manifest.display().to_string())
        .collect();
    if !held.is_empty() {
        bail!("warnings, shown above, in: {}", held.join(", "));
    }
    Ok(Compiled {
        tests: tests.into_iter().collect(),
        programs: target()?.join("debug"),
    })
}

/// Puts Clippy in place of the compiler, so that everything that Cargo does for the tests uses the same code.
pub(crate) fn with_lints(command: &mut Command) -> Result<()> {
    match clippy()? {
        Some(clippy) => {
            command.env("RUSTC_WORKSPACE_WRAPPER", clippy);
        }
        None => bail!("this toolchain has no Clippy: `rustup component add clippy` adds it"),
    }
    Ok(())
}

fn clippy() -> Result<Option<OsString>> {
    let output = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--print", "sysroot"])
        .current_dir(root()?)
        .output()
        .context("rustc")?;
    if !output.status.success() {
        bail!(
            "rustc --print sysroot: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    let sysroot = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let program = Path::new(&sysroot)
        .join("bin")
        .join(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    Ok(program.is_file().then(|| program.into_os_string()))
}

/// The manifest of the crate that a message of Cargo warns about.
fn warned_manifest(message: &Value) -> Option<PathBuf> {
    let warns = message["reason"] == "compiler-message" && message["message"]["level"] == "warning";
    // The summary at the end of a crate's warnings has no code and no place.
    let placed = message["message"]["spans"]
        .as_array()
        .is_some_and(|spans| !spans.is_empty());
    (warns && placed).then(|| message["manifest_path"].as_str().map(PathBuf::from))?
}

/// The test program in a message of Cargo.
fn test_program(message: &Value) -> Option<TestProgram> {
    if message["reason"] != "compiler-artifact" || message["profile"]["test"] != true {
        return None;
    }
    // Benchmarks have main functions of their own, and are not tests.
    if message["target"]["kind"].as_array()?.iter().any(|kind| kind == "bench") {
        return None;
    }
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    Some(TestProgram {
        folder: folder.to_path_buf(),
        program: message["executable"].as_str()?.into(),
    })
}

/// Whether a crate takes the workspace's lints.
fn takes_lints(manifest: &Path) -> bool {
    let text = std::fs::read_to_string(manifest).unwrap_or_default();
    text.split("\n[lints]").nth(1).is_some_and(|lints| {
        let own = lints.split("\n[").next().unwrap_or_default();
        own.lines().any(|line| line.replace(' ', "") == "workspace=true")
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_cargo_says_is_understood() {
        let artifact = |kind: &str, test: bool| {
            json!({ "reason": "compiler-artifact", "profile": { "test": test }, "target": { "kind": [kind] },
                "manifest_path": "/w/runtime/core/Cargo.toml", "executable": "/t/debug/deps/it-0" })
        };
        let expected = TestProgram {
            folder: "/w/runtime/core".into(),
            program: "/t/debug/deps/it-0".into(),
        };
        assert_eq!(test_program(&artifact("test", true)), Some(expected));
        assert_eq!(test_program(&artifact("bench", true)), None);
        assert_eq!(test_program(&artifact("bin", false)), None);
        let warning = json!({ "reason": "compiler-message", "manifest_path": "/w/Cargo.toml",
            "message": { "level": "warning", "spans": [{}] } });
        assert_eq!(warned_manifest(&warning), Some("/w/Cargo.toml".into()));
        let sum = json!({ "reason": "compiler-message", "manifest_path": "/w/Cargo.toml",
            "message": { "level": "warning", "spans": [] } });
        assert_eq!(warned_manifest(&sum), None);
    }

    #[test]
    fn a_crate_says_itself_whether_it_is_held_to_the_lints() {
        let folder = std::env::temp_dir().join(format!("xtask-lints-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let manifest = folder.join("Cargo.toml");
        for (text, held) in [
            ("[package]\nname = \"a\"\n\n[lints]\nworkspace = true\n", true),
            ("[package]\nname = \"a\"\n", false),
            ("[package]\n\n[lints]\nrust = {}\n\n[x]\nworkspace = true\n", false),
        ] {
            std::fs::write(&manifest, text).unwrap();
            assert_eq!(takes_lints(&manifest), held, "{text}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::cargo::root;
use crate::mutations::mutations;
use crate::safety::safety;
use crate::sea::sea;

/// The crates on which each crate must never depend: the arrows of `runtime/docs/architecture.md`.
const NEVER: [(&str, &[&str]); 23] = [
    (
        "units",
        &[
            "spi",
            "fence",
            "core",
            "world",
            "mvc",
            "oracle",
            "sim",
            "recorder",
            "plugin-host",
        ],
    ),
    (
        "s7k",
        &["spi", "fence", "core", "world", "mvc", "oracle", "sim", "tokio"],
    ),
    ("spi", &["fence", "core", "world", "mvc", "oracle", "sim", "tokio"]),
    ("fence", &["spi", "core", "world", "mvc", "oracle", "sim", "tokio"]),
    (
        "core",
        &[
            "world",
            "mvc",
            "oracle",
            "sim",
            "recorder",
            "plugin-host",
            "tokio",
            "wasmtime",
        ],
    ),
    (
        "sonar",
        &["spi", "fence", "core", "world", "mvc", "plc", "sim", "tokio"],
    ),
    ("plc", &["spi", "fence", "core", "mvc", "sonar", "sim", "tokio"]),
    ("acoustics", &["s7k", "spi", "fence", "core", "mvc", "tokio"]),
    ("world", &["spi", "fence", "core", "tokio"]),
    // Crates that both a mission and the mock read with depend on neither of them.
    (
        "plan",
        &["fence", "core", "world", "mvc", "mission", "oracle", "sim", "tokio"],
    ),
    ("mvc", &["core", "fence", "oracle", "tokio"]),
    // The oracle shares nothing with what it judges, not even how a sentence or a position is read.
    (
        "oracle",
        &[
            "units",
            "spi",
            "fence",
            "core",
            "world",
            "mvc",
            "sim",
            "mission",
            "recorder",
            "plugin-host",
            "tokio",
        ],
    ),
    ("plugin-host", &["spi", "mvc", "world", "tokio"]),
    // The crates that go to sea.
    (
        "mission",
        &[
            "world",
            "mvc",
            "plc",
            "acoustics",
            "scenario",
            "oracle",
            "sim",
            "recorder",
            "log-export",
            "plugin-host",
            "tokio",
        ],
    ),
    (
        "plugin-loader",
        &["world", "mvc", "scenario", "oracle", "sim", "recorder", "tokio"],
    ),
    (
        "recorder",
        &[
            "world",
            "mvc",
            "scenario",
            "oracle",
            "sim",
            "picture",
            "log-export",
            "tokio",
        ],
    ),
    (
        "replay",
        &[
            "world",
            "mvc",
            "scenario",
            "oracle",
            "sim",
            "picture",
            "log-export",
            "tokio",
        ],
    ),
    // A log is read by what it says of itself, so that its channels can grow without this crate.
    (
        "log-export",
        &[
            "core",
            "fence",
            "mission",
            "mvc",
            "world",
            "oracle",
            "sim",
            "recorder",
            "plugin-host",
            "tokio",
        ],
    ),
    (
        "picture",
        &["core", "mission", "mvc", "world", "sim", "recorder", "tokio"],
    ),
    ("scenario", &["oracle", "sim", "recorder", "plugin-host", "tokio"]),
    // Plugins are built without a host, and the tools drive both.
    ("componentize", &["core", "plugin-host", "wasmtime"]),
    ("plugin-tools", &["mvc", "world", "plc", "tokio"]),
    ("sim", &["tokio"]),
];
/// A longer file must be split.
const LINES_MAX: usize = 700;

/// Macros that wait for a terminal, and panic if it is closed.
const PRINTS: [&str; 4] = ["println!(", "print!(", "eprintln!(", "eprint!("];

/// The project's own rules.
pub(crate) fn tidy() -> Result<()> {
    let root = root()?;
    let mut faults = Vec::new();
    arrows(&root, &mut faults)?;
    mutations(&root, &mut faults)?;
    sea(&root, &mut faults)?;
    let sources = sources(&root)?;
    safety(&root, &sources, &mut faults)?;
    for file in sources {
        let text = std::fs::read_to_string(root.join(&file)).with_context(|| file.display().to_string())?;
        let lines = text.lines().count();
        if lines > LINES_MAX {
            faults.push(format!("{}: {lines} lines, at most {LINES_MAX}", file.display()));
        }
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        // Cargo would treat `tests/sea.rs` as a test of its own, so code that several tests share must be
        // `tests/sea/mod.rs`.
        let shared_by_tests = stem == "mod" && file.components().any(|part| part.as_os_str() == "tests");
        if ["utils", "helpers", "common", "manager", "mod"].contains(&stem) && !shared_by_tests {
            faults.push(format!("{}: a file is named for what is in it", file.display()));
        }
        if is_deployed(&file) {
            for (number, line) in text.lines().enumerate() {
                let code = line.trim_start();
                if !code.starts_with("//") && PRINTS.iter().any(|mark| code.contains(mark)) {
                    faults.push(format!(
                        "{}:{}: a deployed crate prints through tracing or `say!`, because a stuck or closed terminal would stop it otherwise",
                        file.display(),
                        number + 1
                    ));
                }
            }
        }
        if !file.starts_with("runtime/xtask") {
            for (number, line) in text.lines().enumerate() {
                if ["todo!(", "unimplemented!(", "dbg!("]
                    .iter()
                    .any(|mark| line.contains(mark))
                {
                    faults.push(format!("{}:{}: unfinished", file.display(), number + 1));
                }
            }
        }
    }
    if !faults.is_empty() {
        bail!("the project's rules are broken:\n  {}", faults.join("\n  "));
    }
    println!("tidy");
    Ok(())
}

/// Whether a source is part of the program for sea.
fn is_deployed(file: &Path) -> bool {
    let ashore = ["runtime/xtask", "runtime/componentize"];
    let in_sources = file.components().nth(2).is_some_and(|part| part.as_os_str() == "src");
    file.starts_with("runtime") && in_sources && !ashore.iter().any(|place| file.starts_with(place))
}

/// Every Rust source that git tracks.
fn sources(root: &Path) -> Result<Vec<PathBuf>> {
    let output = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.rs"])
        .current_dir(root)
        .output()
        .context("git")?;
    if !output.status.success() {
        bail!("git ls-files: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(String::from_utf8_lossy(&output.stdout)
        .split('\0')
        .filter(|file| !file.is_empty())
        .map(PathBuf::from)
        .filter(|file| root.join(file).exists())
        .collect())
}

fn arrows(root: &Path, faults: &mut Vec<String>) -> Result<()> {
    for (name, never) in NEVER {
        let path = root.join("runtime").join(name).join("Cargo.toml");
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let dependencies = text.split("[dependencies]").nth(1).unwrap_or_default();
        let dependencies = dependencies.split("\n[").next().unwrap_or_default();
        for banned in never {
            let found = dependencies.lines().any(|line| {
                let key = line.split(['.', ' ', '=']).next().unwrap_or_default();
                key == *banned || key == format!("backseat-{banned}")
            });
            if found {
                faults.push(format!("{}: {name} never depends on {banned}", path.display()));
            }
        }
    }
    Ok(())
}

//! Every command of the README and of the pages that lead a new user, run as they stand there, in the order of the page.
//!
//! What `cargo xtask test` has built already is not built again: a program named `cargo` stands for the real one, and
//! does what each command of the pages would have done. A command that it does not know fails.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use backseat_test_support::{componentize, plugins, program, sea_program, workspace};
use tempfile::TempDir;

/// What `cargo` does in the pages.
const CARGO: &str = r#"#!/bin/sh
set -eu
case "$*" in
"xtask demo")
    mkdir -p target/release target/plugins
    cp "$PROGRAM" target/release/backseat
    cp "$PLUGINS"/*.wasm target/plugins/
    ;;
"xtask test") ;;
# The project's own plugins are built already.
"xtask plugins") CARGO_TARGET_DIR="$REAL_TARGET" "$COMPONENTIZE" . target/plugins mine ;;
"build --release --package backseat --no-default-features --features sea,console")
    mkdir -p target/release
    cp "$SEA_PROGRAM" target/release/backseat
    ;;
"test -p mine") CARGO_TARGET_DIR="$REAL_TARGET" "$CARGO" test --quiet -p mine ;;
*) echo "a page has a command that its test does not know: cargo $*" >&2; exit 1 ;;
esac
"#;

/// A folder like a fresh clone, as far as the pages go.
fn clone() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let copy = |name: &str| {
        let status = Command::new("cp")
            .arg("-r")
            .arg(workspace().join(name))
            .arg(folder.path().join(name))
            .status()
            .expect("cp starts");
        assert!(status.success(), "{name} cannot be copied");
    };
    for name in [
        "Cargo.toml",
        "Cargo.lock",
        "rust-toolchain.toml",
        "missions",
        "plugins",
        "runtime",
        "tests",
        "wit",
    ] {
        copy(name);
    }
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).expect("the folder can be written");
    let cargo = bin.join("cargo");
    fs::write(&cargo, CARGO).expect("the folder can be written");
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).expect("the file is ours");
    folder
}

/// The lines of a page's `sh` blocks.
pub(crate) fn script(page: &str) -> String {
    let text = fs::read_to_string(workspace().join(page)).expect("the page is there");
    let mut lines = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside {
            lines.push(line);
        }
    }
    assert!(!lines.is_empty(), "{page} has no commands");
    lines.join("\n")
}

/// Runs a page's commands; gives what they printed, and the folder that they leave.
fn follow(page: &str) -> (String, TempDir) {
    let folder = clone();
    let path = std::env::var("PATH").unwrap_or_default();
    let real = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let program = program();
    let target = program.ancestors().nth(2).expect("a program lies in target/PROFILE");
    let output = Command::new("bash")
        .args(["-eu", "-o", "pipefail", "-c", &script(page)])
        .current_dir(folder.path())
        .env("PATH", format!("{}:{path}", folder.path().join("bin").display()))
        .env("PROGRAM", program)
        .env("SEA_PROGRAM", sea_program())
        .env("PLUGINS", plugins())
        .env("COMPONENTIZE", componentize())
        .env("CARGO", real)
        .env("REAL_TARGET", target)
        .env("XDG_STATE_HOME", folder.path().join("users-state"))
        .env("BACKSEAT_CACHE", backseat_test_support::cache())
        .env("BACKSEAT_LOG_ROOM", backseat_test_support::LOG_ROOM)
        .env_remove("BACKSEAT_PLUGINS")
        .output()
        .expect("bash starts");
    let told = format!(
        "{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(output.status.success(), "{page}: {}\n{told}", output.status);
    (told, folder)
}

fn holds(told: &str, parts: &[&str]) {
    for part in parts {
        assert!(told.contains(part), "no {part:?} in\n{told}");
    }
}

fn is_picture(path: &Path) {
    let text = fs::read_to_string(path).unwrap_or_default();
    assert!(text.starts_with("<svg"), "{} is no picture", path.display());
}

#[test]
fn the_readmes_commands_run_and_print_what_it_shows() {
    let (told, folder) = follow("README.md");
    is_picture(&folder.path().join("isobath.svg"));
    holds(
        &told,
        &["plume, seed 1: completed", "ready", "limits.turn_rate_dps", "RMB"],
    );
    let readme = fs::read_to_string(workspace().join("README.md")).unwrap();
    let shown = fs::read_to_string(workspace().join("runtime/docs/isobath.svg")).unwrap();
    // As the page shows it: seed 1.
    let picture = folder.path().join("shown.svg");
    let flown = Command::new(program())
        .args(["sim", "missions/isobath", "--map"])
        .arg(&picture)
        .current_dir(folder.path())
        .output()
        .unwrap();
    for line in String::from_utf8_lossy(&flown.stdout).lines() {
        if !line.contains(" x real time") && !line.contains("map:") {
            assert!(readme.contains(line), "README does not show {line:?}");
        }
    }
    assert!(
        fs::read_to_string(picture).unwrap() == shown,
        "runtime/docs/isobath.svg is not what `sim --map` draws"
    );
}

#[test]
fn a_new_plugin_flies_as_its_page_says() {
    let (told, folder) = follow("runtime/docs/write-a-plugin.md");
    is_picture(&folder.path().join("mine.svg"));
    holds(
        &told,
        &[
            "mine, seed 1: completed",
            "rejected 480 x depth: 4.0 m deeper than the 36 m of keep-in zone 'bay'",
            "exit code 1",
            "10 runs.jsonl",
        ],
    );
}

#[test]
fn a_study_has_a_result_as_its_page_says() {
    let (told, folder) = follow("runtime/docs/simulation-study.md");
    is_picture(&folder.path().join("faults.svg"));
    holds(
        &told,
        &[
            "report: study/current/report.html",
            "noisy compared with as it is, seed by seed:",
            "contour rms, m: larger: difference ",
            "  fault at 400 s for 20 s: ",
            "no rule broke",
            "$BFNVG,",
        ],
    );
}

#[test]
fn a_dive_is_prepared_flown_and_judged_as_its_page_says() {
    let (told, _folder) = follow("runtime/docs/go-to-sea.md");
    holds(
        &told,
        &["ready", "dive, seed 5: completed", "$BPRMB", "$BFACK", "no rule broke"],
    );
}

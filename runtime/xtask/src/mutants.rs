use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::{Value, json};

use crate::cargo::{cargo, root, target};

/// The program that makes the mutants, and the version that is installed if there is none.
const MUTANTS: (&str, &str) = ("cargo-mutants", "27.1.0");
/// Which sources are changed, and which tests must notice.
const CONFIG: &str = "tests/mutants/mutants.toml";
/// The mutants that no test can kill, each with its reason.
const ACCEPTED: &str = "tests/mutants/accepted.toml";
/// What became of each mutant, a file a shard.
const RESULTS: &str = "tests/mutants/results";

/// Change the code of the safety monitor in one place at a time, and see whether a test notices.
#[derive(Args)]
pub(crate) struct Mutants {
    /// Only this part of the mutants, for example 1/16; the result of a part is kept in tests/mutants/results
    #[arg(long, default_value = "1/1", value_name = "K/N", value_parser = shard)]
    shard: (u32, u32),
    /// Only mutants whose names contain this text; the result is not kept
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Change the files of this clone itself and not those of a copy, which saves a build: for a clone in which nobody
    /// works
    #[arg(long)]
    in_place: bool,
    /// Run nothing; add up the results that are kept
    #[arg(long, conflicts_with_all = ["shard", "only", "in_place"])]
    sum: bool,
}

/// What became of one mutant.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    /// A test failed.
    Killed,
    /// No test failed.
    Missed,
    /// The tests did not end.
    TimedOut,
    /// It does not compile.
    Unviable,
}

pub(crate) fn mutants(arguments: &Mutants) -> Result<()> {
    if arguments.sum {
        return sum();
    }
    install()?;
    let (part, parts) = arguments.shard;
    let output = target()?.join(format!("mutants/{part}-of-{parts}"));
    fs::create_dir_all(&output).with_context(|| output.display().to_string())?;
    let mut command = Command::new("cargo");
    command
        .current_dir(root()?)
        .args(["mutants", "--config", CONFIG, "--no-shuffle", "--colors", "never"]);
    // Shards are counted from 0 there.
    command
        .args(["--shard", &format!("{}/{parts}", part - 1), "--output"])
        .arg(&output);
    if let Some(only) = &arguments.only {
        command.args(["--re", only]);
    }
    if arguments.in_place {
        command.arg("--in-place");
    }
    // Each mutant differs from the last one in a line, and the environment would win over the profile.
    command
        .env("CARGO_INCREMENTAL", "1")
        .env_remove("RUSTC_WORKSPACE_WRAPPER");
    println!("> cargo mutants --config {CONFIG} --shard {}/{parts}", part - 1);
    let status = command.status().context("cargo mutants")?;
    // 2: mutants were missed. 3: some timed out. Both are told below.
    if !matches!(status.code(), Some(0 | 2 | 3)) {
        bail!(
            "cargo mutants ended with {status}; its output is in {}",
            output.display()
        );
    }
    let fates = read(&output.join("mutants.out/outcomes.json"), &names()?)?;
    if arguments.only.is_none() {
        keep(arguments.shard, &fates)?;
    }
    judge(&fates)
}

/// A part of a whole, from 1.
fn shard(text: &str) -> Result<(u32, u32), String> {
    let numbers = text
        .split_once('/')
        .and_then(|(part, parts)| Some((part.parse().ok()?, parts.parse().ok()?)));
    numbers
        .filter(|(part, parts)| (1..=*parts).contains(part))
        .ok_or_else(|| "expected K/N with K from 1 to N, for example 1/16".to_owned())
}

fn install() -> Result<()> {
    let (name, version) = MUTANTS;
    let shown = Command::new("cargo")
        .args(["mutants", "--version"])
        .output()
        .context("cargo")?;
    if !shown.status.success() {
        cargo(&["install", "--locked", "--quiet", name, "--version", version])?;
    }
    Ok(())
}

/// The fate of each mutant by its name.
fn read(path: &Path, names: &BTreeMap<String, String>) -> Result<BTreeMap<String, Fate>> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let outcomes: Value = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    let outcomes = outcomes["outcomes"].as_array().context("outcomes.json: no outcomes")?;
    let mut fates = BTreeMap::new();
    for outcome in outcomes {
        let Some(name) = outcome["scenario"]["Mutant"]["name"].as_str() else {
            continue;
        };
        let fate = match outcome["summary"].as_str() {
            Some("CaughtMutant") => Fate::Killed,
            Some("MissedMutant") => Fate::Missed,
            Some("Timeout") => Fate::TimedOut,
            Some("Unviable") => Fate::Unviable,
            other => bail!("{name}: unknown outcome {other:?}"),
        };
        let name = names
            .get(name)
            .with_context(|| format!("{name} is not in the list of mutants"))?;
        fates.insert(name.clone(), fate);
    }
    Ok(fates)
}

/// The names of all mutants, from those with line and column to those without. Of several in one function that are the
/// same without their places, the second and later ones are numbered.
fn names() -> Result<BTreeMap<String, String>> {
    let mut command = Command::new("cargo");
    command.current_dir(root()?).args([
        "mutants",
        "--config",
        CONFIG,
        "--list",
        "--no-shuffle",
        "--colors",
        "never",
    ]);
    let output = command.output().context("cargo mutants --list")?;
    if !output.status.success() {
        bail!(
            "cargo mutants --list: {}",
            String::from_utf8_lossy(&output.stderr).trim()
        );
    }
    let listed = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(numbered(listed.lines()))
}

fn numbered<'a>(listed: impl Iterator<Item = &'a str>) -> BTreeMap<String, String> {
    let mut seen = BTreeMap::<String, u32>::new();
    let name = |line: &str| {
        let short = without_line(line);
        let count = seen.entry(short.clone()).and_modify(|count| *count += 1).or_insert(1);
        let name = if *count == 1 {
            short
        } else {
            format!("{short} ({count})")
        };
        (line.to_owned(), name)
    };
    listed.map(name).collect()
}

/// A mutant's name without line and column, which every edit above it changes: `envelope.rs: replace … in …`.
fn without_line(name: &str) -> String {
    let mut parts = name.splitn(4, ':');
    match (parts.next(), parts.next(), parts.next(), parts.next()) {
        (Some(file), Some(_), Some(_), Some(what)) => format!("{file}:{what}"),
        _ => name.to_owned(),
    }
}

/// Writes the result of a shard.
fn keep((part, parts): (u32, u32), fates: &BTreeMap<String, Fate>) -> Result<()> {
    let names = |wanted: Fate| -> Vec<&String> {
        fates
            .iter()
            .filter(|(_, fate)| **fate == wanted)
            .map(|(name, _)| name)
            .collect()
    };
    let result = json!({
        "killed": names(Fate::Killed).len(),
        "unviable": names(Fate::Unviable).len(),
        "timed_out": names(Fate::TimedOut),
        "missed": names(Fate::Missed),
    });
    let folder = root()?.join(RESULTS);
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let path = folder.join(format!("{part:02}-of-{parts:02}.json"));
    fs::write(&path, format!("{result:#}\n")).with_context(|| path.display().to_string())
}

/// Fails if a mutant was missed that no reason stands for.
fn judge(fates: &BTreeMap<String, Fate>) -> Result<()> {
    let count = |wanted: Fate| fates.values().filter(|fate| **fate == wanted).count();
    println!(
        "{} mutants: {} killed, {} timed out, {} missed, {} do not compile",
        fates.len(),
        count(Fate::Killed),
        count(Fate::TimedOut),
        count(Fate::Missed),
        count(Fate::Unviable)
    );
    let accepted = accepted()?;
    let missed: Vec<&String> = fates
        .iter()
        .filter(|(name, fate)| **fate == Fate::Missed && !accepted.contains_key(*name))
        .map(|(name, _)| name)
        .collect();
    if missed.is_empty() {
        return Ok(());
    }
    for name in &missed {
        println!("  no test notices: {name}");
    }
    bail!(
        "{} mutants live. Write a test that fails with each, or list it in {ACCEPTED} with the reason",
        missed.len()
    )
}

/// The mutants that may live, with their reasons.
fn accepted() -> Result<BTreeMap<String, String>> {
    let path = root()?.join(ACCEPTED);
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let table: BTreeMap<String, String> = toml::from_str(&text).with_context(|| ACCEPTED.to_owned())?;
    if let Some((name, _)) = table.iter().find(|(_, reason)| reason.trim().len() < 10) {
        bail!("{ACCEPTED}: {name:?} has no reason");
    }
    Ok(table)
}

/// Adds up the results that are kept.
fn sum() -> Result<()> {
    let folder = root()?.join(RESULTS);
    let entries = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    let mut paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    paths.sort();
    let accepted = accepted()?;
    let (mut killed, mut unviable, mut timed_out, mut listed) = (0, 0, 0, 0);
    let mut missed = Vec::new();
    for path in &paths {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let result: Value = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        killed += result["killed"].as_u64().unwrap_or(0);
        unviable += result["unviable"].as_u64().unwrap_or(0);
        timed_out += result["timed_out"].as_array().map_or(0, Vec::len);
        for name in result["missed"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
        {
            if accepted.contains_key(name) {
                listed += 1;
            } else {
                missed.push(name.to_owned());
            }
        }
    }
    println!(
        "{} parts: {killed} killed, {timed_out} timed out, {listed} listed with a reason, {} missed, {unviable} do not compile",
        paths.len(),
        missed.len()
    );
    for name in missed {
        println!("  no test notices: {name}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutant_keeps_its_name_when_lines_move() {
        let name = "runtime/core/src/monitor/gate.rs:95:5: replace steers -> bool with true";
        assert_eq!(
            without_line(name),
            "runtime/core/src/monitor/gate.rs: replace steers -> bool with true"
        );
    }

    #[test]
    fn mutants_of_one_name_are_numbered() {
        let names = numbered(["a.rs:1:2: replace < with <= in f", "a.rs:9:2: replace < with <= in f"].into_iter());
        let names: Vec<&str> = names.values().map(String::as_str).collect();
        assert_eq!(
            names,
            ["a.rs: replace < with <= in f", "a.rs: replace < with <= in f (2)"]
        );
    }

    #[test]
    fn a_shard_is_a_part_of_a_whole() {
        assert_eq!(shard("3/16"), Ok((3, 16)));
        for text in ["0/4", "5/4", "1", "a/b", "1/0"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }

    /// A mutant of the list that is not in the code any more would hide one of the same name later.
    #[test]
    fn each_accepted_mutant_names_a_file_that_is_examined() {
        let config = fs::read_to_string(root().unwrap().join(CONFIG)).unwrap();
        for name in accepted().unwrap().keys() {
            let (file, _) = name.split_once(':').unwrap();
            assert!(root().unwrap().join(file).exists(), "{name}");
            let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
            assert!(
                config.contains(file) || config.contains(&format!("{folder}/*.rs")),
                "{name}"
            );
        }
    }
}

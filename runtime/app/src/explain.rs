use anyhow::{Result, bail};
use backseat_reference::{EXITS, Found, REFERENCES, Reference, describe, find, schema};
use clap::Args;

use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// The key to explain: in full (limits.turn_rate_dps), its last part (turn_rate_dps), or with its file
    /// (world.toml:vehicle.class). `backseat explain exit-codes` explains the exit codes. Without a key, the command lists
    /// the files and their tables
    #[arg(value_name = "KEY")]
    pub(crate) keys: Vec<String>,
    /// Print the JSON Schema of a file, for editors: mission.toml, world.toml, ...
    #[arg(long, value_name = "FILE", conflicts_with = "keys")]
    pub(crate) schema: Option<String>,
}

/// What a mission's files may hold.
pub(crate) fn explain(arguments: &Explain) -> Result<bool> {
    if let Some(file) = &arguments.schema {
        let Some(reference) = Reference::of(file).filter(|reference| reference.has_schema()) else {
            bail!("no schema for {file}: expected one of {}", files());
        };
        say!("{:#}", schema(reference));
        return Ok(true);
    }
    if arguments.keys.is_empty() {
        return overview();
    }
    for (number, key) in arguments.keys.iter().enumerate() {
        if number > 0 {
            say!("");
        }
        if key == "exit-codes" {
            for exit in EXITS {
                say!("{:>3}  {}", exit.code, exit.meaning.replace('`', ""));
            }
            continue;
        }
        match find(key) {
            Found::Entries(entries) => {
                for (place, (reference, entry)) in entries.into_iter().enumerate() {
                    if place > 0 {
                        say!("");
                    }
                    say!("{}", describe(reference, entry).trim_end());
                }
            }
            Found::Similar(names) if names.is_empty() => {
                bail!("no key `{key}`: `backseat explain` lists the files and their tables")
            }
            Found::Similar(names) => bail!("no key `{key}`: did you mean {}?", names.join(", ")),
        }
    }
    Ok(true)
}

fn files() -> String {
    let files: Vec<&str> = REFERENCES
        .iter()
        .filter(|reference| reference.has_schema())
        .map(|reference| reference.file.as_str())
        .collect();
    files.join(", ")
}

/// The files, and what is at the top of each.
fn overview() -> Result<bool> {
    for reference in REFERENCES.iter() {
        say!("{}", reference.file);
        for entry in reference.within("") {
            let meaning = entry.meaning.replace('`', "");
            let sentence = meaning
                .split_once(". ")
                .map_or(meaning.trim_end_matches('.'), |(first, _)| first);
            let sentence = sentence.split_once(": ").map_or(sentence, |(first, _)| first);
            say!("  {:<16} {sentence}", entry.key);
        }
        say!("");
    }
    say!("exit-codes         How each command ends");
    Ok(true)
}

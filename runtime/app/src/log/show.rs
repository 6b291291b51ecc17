//! `backseat log show`: what happened in a run, line by line.

use std::path::PathBuf;

use anyhow::{Result, bail};
use backseat_recorder::Log;
#[cfg(feature = "simulation")]
use backseat_recorder::Record;
#[cfg(feature = "simulation")]
use backseat_units::Timestamp;
use clap::Args;
#[cfg(feature = "simulation")]
use serde_json::Value;

use super::read_log;
use crate::output::{escaped, say};

#[derive(Debug, Args)]
pub(crate) struct LogShow {
    /// The log, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap")]
    file: PathBuf,
    /// Print only the lines that name this plugin: what it logged, its requests and what became of them, its failures
    #[arg(long, value_name = "NAME")]
    plugin: Option<String>,
}

pub(super) fn show(arguments: &LogShow) -> Result<bool> {
    let log = read_log(&arguments.file)?;
    let plugins = plugins(&log);
    if let Some(plugin) = &arguments.plugin
        && !plugins.contains(plugin)
    {
        bail!(
            "{}: no plugin `{plugin}` flew in this run; its plugins are: {}",
            arguments.file.display(),
            plugins.join(", ")
        );
    }
    for (at, text) in log.notes() {
        let text = named(text, &plugins);
        if arguments.plugin.as_ref().is_none_or(|plugin| names(&text, plugin)) {
            // One line for each note, whatever it says.
            say!("{:10.3} {}", at.as_secs_f64(), escaped(&text, char::is_control));
        }
    }
    Ok(true)
}

/// The plugins' names in priority order, from the mission that is attached to the log.
pub(super) fn plugins(log: &Log) -> Vec<String> {
    let mission = log
        .attachment("mission.toml")
        .and_then(|text| std::str::from_utf8(text).ok());
    let mission = mission
        .and_then(|text| text.parse::<toml::Table>().ok())
        .unwrap_or_default();
    let tables = mission.get("plugin").and_then(toml::Value::as_array);
    let names = tables.into_iter().flatten().map(|table| table.get("name")?.as_str());
    names.map(|name| name.unwrap_or("?").to_owned()).collect()
}

/// The line with the plugins' names. In the log it has their numbers.
pub(super) fn named(text: &str, plugins: &[String]) -> String {
    // From the last, so that 1 is not found in 10.
    let plugins = plugins.iter().enumerate().rev();
    plugins.fold(text.to_owned(), |text, (number, name)| {
        text.replace(&format!("plugin {number}"), name)
    })
}

/// Whether a line has this name as a whole word.
fn names(text: &str, name: &str) -> bool {
    let part_of_word = |character: char| character.is_alphanumeric() || matches!(character, '-' | '_');
    text.match_indices(name).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + name.len()..].chars().next();
        !before.is_some_and(part_of_word) && !after.is_some_and(part_of_word)
    })
}

/// What the plugins of a run logged, with its time.
#[cfg(feature = "simulation")]
pub(crate) fn plugin_lines(log: &Log) -> impl Iterator<Item = (Timestamp, String)> {
    let plugins = plugins(log);
    log.entries.iter().filter_map(move |entry| {
        let Record::Note(note) = &entry.record else { return None };
        let is_line = note.get("note").and_then(Value::as_str) == Some("plugin-log");
        let text = note.get("text").and_then(Value::as_str).filter(|_| is_line)?;
        // A panic has several lines, and is one entry.
        let line = text.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        Some((entry.now, named(&line, &plugins)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_counts_as_a_whole_word_only() {
        assert!(names("Modify 3 (isobath, tag 1) sent", "isobath"));
        assert!(names("isobath says: on the contour", "isobath"));
        assert!(!names("isobath-2 says: on the contour", "isobath"));
        assert!(!names("the isobaths are close", "isobath"));
    }

    #[test]
    fn plugins_have_their_names_in_a_line() {
        let plugins: Vec<String> = (0..11).map(|number| format!("p{number}")).collect();
        assert_eq!(named("plugin 10 says: ready", &plugins), "p10 says: ready");
        assert_eq!(
            named("Modify 7 (plugin 1, tag 4) sent", &plugins),
            "Modify 7 (p1, tag 4) sent"
        );
    }
}

//! Tables: one for each channel in a folder, or that of one channel as a file.

mod csv;
mod parquet;

pub(crate) use self::csv::decimal;

use std::path::Path;

use serde::Serialize;

use crate::contents::{Contents, Gap};
use crate::error::Error;
use crate::output::{INDEX, OutputFile, OutputFolder};
use crate::source::{End, Source};
use crate::table::{Cell, Table};
use crate::time::rfc3339;
use crate::{Exported, counted};

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Csv,
    Parquet,
}

impl Form {
    const fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }

    fn writer(self, file: OutputFile, sheet: &Sheet, contents: &Contents) -> Result<Box<dyn Writer>, Error> {
        Ok(match self {
            Self::Csv => Box::new(csv::Csv::new(file, &sheet.table)?),
            Self::Parquet => Box::new(parquet::Parquet::new(file, sheet, contents)?),
        })
    }
}

/// Memory for rows that wait to be written, of all tables, bytes.
const WAITING_MAX: usize = 32 << 20;

/// The writer of a table.
trait Writer {
    /// Writes a message, or keeps it for later. Returns the memory that all kept messages use, bytes.
    fn write(&mut self, log_time: u64, t_s: f64, row: &[Cell<'_>]) -> Result<usize, Error>;
    /// Writes the kept messages.
    fn flush(&mut self) -> Result<(), Error>;
    /// Ends the table, and returns its file.
    fn finish(self: Box<Self>) -> Result<OutputFile, Error>;
}

/// The index of a folder of tables.
#[derive(Serialize)]
struct Index<'a> {
    /// Names of the other files of the folder.
    files: Vec<String>,
    log: String,
    run: &'a std::collections::BTreeMap<String, String>,
    start: String,
    seconds: f64,
    complete: bool,
    gaps: Vec<IndexedGap>,
    tables: Vec<Indexed<'a>>,
}

#[derive(Serialize)]
struct IndexedGap {
    since_s: f64,
    until_s: f64,
    records: u64,
}

#[derive(Serialize)]
struct Indexed<'a> {
    topic: &'a str,
    file: &'a str,
    schema: &'a str,
    rows: u64,
    columns: Vec<IndexedColumn<'a>>,
}

#[derive(Serialize)]
struct IndexedColumn<'a> {
    name: &'a str,
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    description: &'a str,
}

/// A channel's table with what is written of it.
struct Sheet {
    topic: String,
    schema: String,
    table: Table,
    file: String,
}

pub(crate) fn export(source: &Source, form: Form, channel: Option<&str>, out: &Path) -> Result<Exported, Error> {
    // A mistake in the output is found before a long log is read.
    let mut target = match channel {
        Some(_) => Target::File(Some(OutputFile::create(out)?)),
        None => Target::Folder(OutputFolder::create(out)?),
    };
    let wanted = |topic: &str| channel.is_none_or(|channel| same_topic(channel, topic));
    let mut contents = Contents::of(source, wanted)?;
    let sheets = sheets(&mut contents, form);
    if let Some(topic) = channel
        && !sheets.iter().any(|sheet| wanted(&sheet.topic))
    {
        let topics: Vec<&str> = sheets.iter().map(|sheet| sheet.topic.as_str()).collect();
        return Err(Error::NoChannel {
            path: source.path().to_owned(),
            topic: topic.to_owned(),
            topics: topics.join(", "),
        });
    }
    let mut remarks = contents.remarks(source);
    for sheet in sheets.iter().filter(|sheet| sheet.table.overfull) {
        remarks.push(format!(
            "{}: {} has over {} columns; the others are left out",
            source.path().display(),
            sheet.topic,
            sheet.table.columns.len()
        ));
    }
    let mut writers = Vec::new();
    for sheet in &sheets {
        let file = if wanted(&sheet.topic) {
            target.file(&sheet.file)?
        } else {
            None
        };
        let writer = file.map(|file| form.writer(file, sheet, &contents)).transpose()?;
        writers.push(writer);
    }
    let mut waiting = vec![0; writers.len()];
    contents.read(source, wanted, |message| {
        let (Some(Some(writer)), Some(sheet)) = (writers.get_mut(message.channel), sheets.get(message.channel)) else {
            return Ok(());
        };
        let row = sheet.table.row(&message.value);
        let kept = writer.write(message.log_time, message.t_s, &row)?;
        if let Some(entry) = waiting.get_mut(message.channel) {
            *entry = kept;
        }
        if waiting.iter().sum::<usize>() > WAITING_MAX {
            // Only the largest, so that row groups stay large.
            let largest = waiting.iter().enumerate().max_by_key(|(_, bytes)| **bytes);
            if let Some((place, _)) = largest
                && let Some(Some(writer)) = writers.get_mut(place)
            {
                writer.flush()?;
                waiting[place] = 0;
            }
        }
        Ok(())
    })?;
    let mut files = Vec::new();
    for writer in writers.into_iter().flatten() {
        files.push(writer.finish()?);
    }
    // Only now: an error until here leaves an existing file as it was.
    files.into_iter().try_for_each(OutputFile::commit)?;
    let written = sheets.iter().filter(|sheet| wanted(&sheet.topic));
    let rows = counted(written.map(|sheet| sheet.table.rows).sum(), "row");
    let summary = match target {
        Target::File(_) => format!("{}: {rows}", out.display()),
        Target::Folder(folder) => {
            folder.write_index(&index(source, &contents, &sheets))?;
            folder.commit()?;
            let tables = counted(sheets.len() as u64, "table");
            format!("{}: {tables} with {rows}, described in {INDEX}", out.display())
        }
    };
    Ok(Exported { summary, remarks })
}

/// The index without the names of files.
pub(crate) fn describe(source: &Source) -> Result<serde_json::Value, Error> {
    let mut contents = Contents::of(source, |_| true)?;
    let sheets = sheets(&mut contents, Form::Parquet);
    let mut described = serde_json::json!(index(source, &contents, &sheets));
    let tables = described["tables"].as_array_mut().into_iter().flatten();
    for table in tables.filter_map(serde_json::Value::as_object_mut) {
        table.remove("file");
    }
    if let Some(members) = described.as_object_mut() {
        members.remove("files");
    }
    Ok(described)
}

/// `/navigation`, also written without its slash.
fn same_topic(given: &str, topic: &str) -> bool {
    given == topic || topic.strip_prefix('/') == Some(given)
}

fn sheets(contents: &mut Contents, form: Form) -> Vec<Sheet> {
    let mut names: Vec<String> = Vec::new();
    let channels = contents.channels.iter_mut();
    channels
        .map(|channel| {
            let stem = stem(&channel.topic);
            // Two topics can have one stem. Some file systems do not tell capitals apart.
            let taken = |name: &str| names.iter().any(|known| known.eq_ignore_ascii_case(name));
            let name = if taken(&stem) {
                (2..)
                    .map(|number| format!("{stem}_{number}"))
                    .find(|name| !taken(name))
                    .unwrap_or_default()
            } else {
                stem
            };
            names.push(name.clone());
            Sheet {
                topic: channel.topic.clone(),
                schema: channel.schema.clone(),
                table: std::mem::take(&mut channel.draft).table(),
                file: format!("{name}.{}", form.extension()),
            }
        })
        .collect()
}

/// A file's name from a topic: `sensors_ctd` from `/sensors/ctd`.
fn stem(topic: &str) -> String {
    const LENGTH_MAX: usize = 100;
    let topic = topic.trim_start_matches('/');
    let stem: String = topic
        .chars()
        .take(LENGTH_MAX)
        .map(|character| {
            if character.is_ascii_alphanumeric() || character == '-' {
                character
            } else {
                '_'
            }
        })
        .collect();
    if stem.is_empty() { "channel".to_owned() } else { stem }
}

enum Target {
    /// Until its writer has it.
    File(Option<OutputFile>),
    Folder(OutputFolder),
}

impl Target {
    fn file(&mut self, name: &str) -> Result<Option<OutputFile>, Error> {
        match self {
            Self::File(file) => Ok(file.take()),
            Self::Folder(folder) => OutputFile::create(&folder.file(name)).map(Some),
        }
    }
}

fn index<'a>(source: &Source, contents: &'a Contents, sheets: &'a [Sheet]) -> Index<'a> {
    let own = [
        ("time", "time", "UTC, when the message was written to the log."),
        ("t_s", "number", "The same in seconds since the start of the run."),
    ];
    let own = own.map(|(name, kind, description)| IndexedColumn {
        name,
        kind,
        description,
    });
    let tables = sheets.iter().map(|sheet| Indexed {
        topic: &sheet.topic,
        file: &sheet.file,
        schema: &sheet.schema,
        rows: sheet.table.rows,
        columns: own
            .iter()
            .map(
                |IndexedColumn {
                     name,
                     kind,
                     description,
                 }| IndexedColumn {
                    name,
                    kind,
                    description,
                },
            )
            .chain(sheet.table.columns.iter().map(|column| IndexedColumn {
                name: &column.name,
                kind: column.kind.name(),
                description: &column.description,
            }))
            .collect(),
    });
    Index {
        files: sheets.iter().map(|sheet| sheet.file.clone()).collect(),
        log: source.path().display().to_string(),
        run: &contents.run,
        start: rfc3339(contents.start_ns),
        seconds: contents.last_s,
        complete: contents.end == End::Complete,
        gaps: contents
            .gaps
            .iter()
            .map(
                |Gap {
                     since_s,
                     until_s,
                     records,
                 }| IndexedGap {
                    since_s: *since_s,
                    until_s: *until_s,
                    records: *records,
                },
            )
            .collect(),
        tables: tables.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_cannot_name_a_file_elsewhere() {
        assert_eq!(stem("/sensors/ctd"), "sensors_ctd");
        assert_eq!(stem("/../../etc/passwd"), "______etc_passwd");
        assert_eq!(stem("/"), "channel");
        assert_eq!(stem(&"/x".repeat(500)).len(), 100);
    }
}

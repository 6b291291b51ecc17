use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::LazyLock;

use backseat_spi::{Entry, catalogue};
use serde::Serialize;

use crate::paint::Paint;
use crate::reading::{Checksum, Message, Raw, Reading};
use crate::text::write_fields;

/// How sentences are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// One line of text, with or without colours.
    Text {
        /// Whether the output supports escape sequences.
        colour: bool,
    },
    /// One JSON object a line.
    Json,
}

#[derive(Serialize)]
struct Object<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    received_s: Option<f64>,
    name: &'a str,
    checksum: Checksum,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<&'a Message>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u64>,
}

/// Appends a sentence in the given form, with a line end. `received_s` is when it was received, for a live link.
pub(crate) fn write_reading(
    out: &mut Vec<u8>,
    form: Form,
    reading: &Reading<'_>,
    received_s: Option<f64>,
) -> io::Result<()> {
    match form {
        Form::Json => {
            let error = reading.outcome.as_ref().err();
            let object = Object {
                received_s: received_s.map(|seconds| (seconds * 1e3).round() / 1e3),
                name: reading.name,
                checksum: reading.checksum,
                message: reading.outcome.as_ref().ok(),
                error: error.map(ToString::to_string),
                // Only a recording has line numbers that someone can look up.
                line: error.filter(|_| received_s.is_none()).map(|_| reading.line),
            };
            serde_json::to_writer(&mut *out, &object)?;
        }
        Form::Text { colour } => {
            if let Some(seconds) = received_s {
                write!(out, "{seconds:9.3}  ")?;
            }
            write_text(out, Paint::new(colour), reading, received_s.is_none())?;
        }
    }
    out.push(b'\n');
    Ok(())
}

fn write_text(out: &mut Vec<u8>, paint: Paint, reading: &Reading<'_>, with_line: bool) -> io::Result<()> {
    let (strong, plain) = (paint.strong(), paint.plain());
    match &reading.outcome {
        Ok(message) => {
            let (title, fields) = reading
                .entry
                .map_or(("", [].as_slice()), |entry| (entry.title, entry.fields));
            write!(out, "{strong}{}{plain}  {title}: ", reading.name)?;
            write_fields(out, fields, message)?;
            match reading.checksum {
                Checksum::Valid => Ok(()),
                Checksum::Absent => write!(out, "{}  (no checksum){plain}", paint.quiet()),
                Checksum::Invalid => write!(out, "{}  (wrong checksum){plain}", paint.alarm()),
            }
        }
        Err(error) => {
            let name: String = reading.name.chars().take(12).collect();
            write!(out, "{strong}{name}{plain}  {}error", paint.alarm())?;
            if with_line {
                write!(out, " in line {}", reading.line)?;
            }
            write!(out, ": {error}{plain}  {}", Raw(reading.bytes))
        }
    }
}

/// A message's row of the catalogue.
pub(crate) fn entry(name: &str) -> Option<&'static Entry> {
    static ROWS: LazyLock<BTreeMap<&str, &Entry>> =
        LazyLock::new(|| catalogue().iter().map(|entry| (entry.name, entry)).collect());
    ROWS.get(name).copied()
}

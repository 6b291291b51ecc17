use std::io::Write;

use backseat_spi::{Direction, Entry, EntryField, catalogue};
use serde::Serialize;

use crate::error::Error;
use crate::paint::Paint;
use crate::reading::Reading;
use crate::sheet::{Form, write_reading};
use crate::splitter::{End, Piece};

/// The format in which the catalogue is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listing {
    /// One line for each message, with or without colours.
    Text {
        /// Whether the output supports escape sequences.
        colour: bool,
    },
    /// One JSON object a line.
    Json,
}

/// Writes the catalogue, one line for each message; or, if names are given, everything about those messages.
///
/// A name is `BFNVG` or its last three letters, in either case; `CTD` is two messages.
///
/// # Errors
///
/// [`Error::NoMessage`] for an unknown name; [`Error::Output`].
pub fn list(names: &[String], listing: Listing, out: &mut impl Write) -> Result<(), Error> {
    let mut entries = Vec::new();
    for name in names {
        let found = entries.len();
        entries.extend(catalogue().iter().filter(|entry| is_named(entry, name)));
        if entries.len() == found {
            return Err(Error::NoMessage { name: name.clone() });
        }
    }
    let shown = match listing {
        Listing::Json if names.is_empty() => catalogue().iter().try_for_each(|entry| json(entry, out)),
        Listing::Json => entries.into_iter().try_for_each(|entry| json(entry, out)),
        Listing::Text { colour } if names.is_empty() => rows(Paint::new(colour), out),
        Listing::Text { colour } => {
            let mut between: &[u8] = b"";
            entries.into_iter().try_for_each(|entry| {
                out.write_all(between)?;
                between = b"\n";
                whole(entry, Paint::new(colour), out)
            })
        }
    };
    shown.and_then(|()| out.flush()).map_err(Error::Output)
}

/// Whether an entry has this name: its five letters, or the last three of them.
pub(crate) fn is_named(entry: &Entry, name: &str) -> bool {
    entry.name.eq_ignore_ascii_case(name) || entry.name[2..].eq_ignore_ascii_case(name)
}

const fn way(direction: Direction) -> &'static str {
    match direction {
        Direction::FromVehicle => "from vehicle",
        Direction::ToVehicle => "to vehicle",
    }
}

fn rows(paint: Paint, out: &mut impl Write) -> std::io::Result<()> {
    let title = catalogue().iter().map(|entry| entry.title.len()).max().unwrap_or(0);
    for entry in catalogue() {
        let fields: Vec<String> = entry.fields.iter().map(brief).collect();
        writeln!(
            out,
            "{}{}{}  {:<4}  {:<12}  {:<title$}  {}",
            paint.strong(),
            entry.name,
            paint.plain(),
            entry.section,
            way(entry.direction),
            entry.title,
            fields.join(", "),
        )?;
    }
    Ok(())
}

/// The name, the unit, and the range if it is short.
fn brief(field: &EntryField) -> String {
    let EntryField { name, unit, range, .. } = field;
    if *range == "any" || range.len() > BRIEF_RANGE || *unit == "UTC" {
        format!("{name} ({unit})")
    } else if range.starts_with(unit) {
        format!("{name} ({range})")
    } else {
        format!("{name} ({unit}, {range})")
    }
}

/// Longer ranges are shown only with a single message.
const BRIEF_RANGE: usize = 16;

fn whole(entry: &Entry, paint: Paint, out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "{}{}{}  {}",
        paint.strong(),
        entry.name,
        paint.plain(),
        entry.title
    )?;
    writeln!(out, "section  SPI {}, {}", entry.section, way(entry.direction))?;
    writeln!(out, "example  {}", entry.example)?;
    writeln!(out, "as json  {}", as_json(entry)?)?;
    let width = |text: fn(&EntryField) -> usize| entry.fields.iter().map(text).max().unwrap_or(0);
    let name = width(|field| field.name.len()).max("field".len());
    let unit = width(|field| field.unit.len()).max("unit".len());
    let range = width(|field| field.range.chars().count()).max("range".len());
    writeln!(
        out,
        "{}{:<name$}  {:<unit$}  {:<range$}  on the wire{}",
        paint.quiet(),
        "field",
        "unit",
        "range",
        paint.plain()
    )?;
    for field in entry.fields {
        let formats = field.formats.join(",");
        writeln!(
            out,
            "{:<name$}  {:<unit$}  {:<range$}  {formats}",
            field.name, field.unit, field.range
        )?;
    }
    Ok(())
}

/// The example as `decode --json` writes it and `encode` reads it.
pub(crate) fn as_json(entry: &Entry) -> std::io::Result<String> {
    let piece = Piece {
        bytes: entry.example.as_bytes(),
        end: End::Line,
        line: 1,
    };
    let mut line = Vec::new();
    if let Some(reading) = Reading::of(piece, false) {
        write_reading(&mut line, Form::Json, &reading, None)?;
    }
    Ok(String::from_utf8_lossy(&line).trim_end().to_owned())
}

fn json(entry: &Entry, out: &mut impl Write) -> std::io::Result<()> {
    #[derive(Serialize)]
    struct Row<'a> {
        name: &'a str,
        section: &'a str,
        direction: &'a str,
        title: &'a str,
        fields: Vec<Column<'a>>,
        example: &'a str,
    }
    #[derive(Serialize)]
    struct Column<'a> {
        name: &'a str,
        unit: &'a str,
        range: &'a str,
        formats: &'a [&'a str],
    }
    let row = Row {
        name: entry.name,
        section: entry.section,
        direction: match entry.direction {
            Direction::FromVehicle => "from-vehicle",
            Direction::ToVehicle => "to-vehicle",
        },
        title: entry.title,
        fields: entry
            .fields
            .iter()
            .map(|field| Column {
                name: field.name,
                unit: field.unit,
                range: field.range,
                formats: field.formats,
            })
            .collect(),
        example: entry.example,
    };
    serde_json::to_writer(&mut *out, &row)?;
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Listing = Listing::Text { colour: false };

    fn listed(names: &[&str], listing: Listing) -> String {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        let mut out = Vec::new();
        list(&names, listing, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn every_message_has_its_line_and_nothing_else_is_said() {
        let text = listed(&[], PLAIN);
        assert_eq!(text.lines().count(), 71);
        for (line, entry) in text.lines().zip(catalogue()) {
            assert!(line.starts_with(entry.name) && line.contains(entry.section) && line.contains(entry.title));
            for field in entry.fields {
                assert!(line.contains(&format!("{} ({}", field.name, field.unit)), "{line}");
            }
            assert!(!line.contains('\u{1b}'));
        }
        assert!(
            text.contains("altitude (m, 0..12000), depth (m, -100..12000)"),
            "{text}"
        );
    }

    #[test]
    fn json_has_an_object_a_line() {
        let text = listed(&[], Listing::Json);
        let rows: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(rows.len(), 71);
        let navigation = rows.iter().find(|row| row["name"] == "BFNVG").unwrap();
        assert_eq!(
            (&navigation["section"], &navigation["direction"]),
            (&"6.1".into(), &"from-vehicle".into())
        );
        assert_eq!(navigation["fields"][4]["unit"], "m");
        assert_eq!(navigation["fields"][1]["formats"].as_array().unwrap().len(), 4);
    }

    #[test]
    fn one_message_is_shown_whole_by_any_form_of_its_name() {
        let text = listed(&["BFNVG"], PLAIN);
        assert!(text.starts_with("BFNVG  navigation update\nsection  SPI 6.1, from vehicle\nexample  $BFNVG,"));
        assert!(
            text.lines()
                .any(|line| line.starts_with("depth ") && line.contains("-100..12000")),
            "{text}"
        );
        assert!(
            text.contains("as json  {\"name\":\"BFNVG\",\"checksum\":\"valid\",\"message\":{\"created\":"),
            "{text}"
        );
        assert_eq!(listed(&["nvg"], PLAIN), text);
        assert_eq!(listed(&["CTD"], Listing::Json).lines().count(), 2);
        let error = list(&["NVX".to_owned()], PLAIN, &mut Vec::new()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown message \"NVX\": `backseat spi list` lists all 71"
        );
    }
}

//! A message as a line of text. It is made from the message's JSON, so that the list of fields exists only once.

use std::io::{self, Write};

use backseat_spi::EntryField;
use serde::Serialize;
use serde_json::ser::{CharEscape, CompactFormatter, Formatter, Serializer};

use crate::reading::Message;

/// Writes `depth 20.1 m, heading 203.1 deg, …`.
pub(crate) fn write_fields(out: &mut Vec<u8>, fields: &[EntryField], message: &Message) -> serde_json::Result<()> {
    let plain = Plain {
        fields: fields.iter(),
        field: None,
        depth: 0,
        arrays: 0,
        in_key: false,
        key: None,
        blank: false,
        absent: false,
    };
    message.serialize(&mut Serializer::with_formatter(out, plain))
}

/// A field's name without the unit, which is shown after its value: `roll_deg` becomes `roll`.
pub(crate) fn bare_name(field: &EntryField) -> &'static str {
    let suffix = match field.unit {
        "m" => "_m",
        "deg" => "_deg",
        "m/s" => "_mps",
        "deg/s" => "_dps",
        "m/s^2" => "_mps2",
        "kB" => "_kb",
        "kPa" => "_kpa",
        "rpm" => "_rpm",
        "V" => "_v",
        "degC" => "_c",
        "kWh" => "_kwh",
        "%" => "_percent",
        "uS/cm" => "_us_per_cm",
        "N" => "_n",
        "s" => "_s",
        _ => return field.name,
    };
    field.name.strip_suffix(suffix).unwrap_or(field.name)
}

/// The unit, unless it is a word for a kind of value. A position shows its own letters.
fn unit(field: &EntryField) -> Option<&'static str> {
    let is_word = matches!(
        field.unit,
        "UTC" | "text" | "code" | "flag" | "name" | "identifier" | "count" | "address" | "bytes" | "status and bytes"
    );
    let is_position = field.unit == "deg" && field.formats.len() > 1;
    (!is_word && !is_position).then_some(field.unit)
}

struct Plain<'a> {
    fields: std::slice::Iter<'a, EntryField>,
    field: Option<&'a EntryField>,
    depth: usize,
    arrays: usize,
    in_key: bool,
    /// The key of the next value, if it matters.
    key: Option<Key>,
    /// Whether a space is due before the next value, unless that is empty.
    blank: bool,
    absent: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Key {
    Latitude,
    Longitude,
}

impl Plain<'_> {
    fn is_free_text(&self) -> bool {
        self.depth == 1 && self.field.is_some_and(|field| field.unit == "text") && !self.in_key
    }

    fn write_blank<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if std::mem::take(&mut self.blank) {
            out.write_all(b" ")
        } else {
            Ok(())
        }
    }
}

impl Formatter for Plain<'_> {
    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        if self.arrays > 0 { out.write_all(b"(") } else { Ok(()) }
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if self.arrays > 0 { out.write_all(b")") } else { Ok(()) }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.in_key = true;
        if self.depth > 1 {
            self.blank = !first;
            return Ok(());
        }
        if !first {
            out.write_all(b", ")?;
        }
        self.field = self.fields.next();
        self.absent = false;
        out.write_all(self.field.map_or("", bare_name).as_bytes())?;
        out.write_all(b" ")
    }

    fn end_object_key<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.in_key = false;
        Ok(())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        Ok(())
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        match self.field.and_then(unit) {
            Some(unit) if self.depth == 1 && !self.absent => {
                out.write_all(b" ")?;
                out.write_all(unit.as_bytes())
            }
            Some(_) | None => Ok(()),
        }
    }

    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.arrays += 1;
        out.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.arrays -= 1;
        out.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { out.write_all(b" ") }
    }

    fn begin_string<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.is_free_text() {
            out.write_all(b"\"")
        } else {
            Ok(())
        }
    }

    fn end_string<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.is_free_text() {
            out.write_all(b"\"")
        } else {
            Ok(())
        }
    }

    fn write_string_fragment<W: ?Sized + Write>(&mut self, out: &mut W, fragment: &str) -> io::Result<()> {
        if self.in_key {
            self.key = match fragment {
                "latitude_deg" => Some(Key::Latitude),
                "longitude_deg" => Some(Key::Longitude),
                _ => None,
            };
            // An option that is known by its number only.
            return if fragment == "other" && self.depth > 1 {
                out.write_all(b"other ")
            } else {
                Ok(())
            };
        }
        self.write_blank(out)?;
        out.write_all(fragment.as_bytes())
    }

    fn write_char_escape<W: ?Sized + Write>(&mut self, out: &mut W, escape: CharEscape) -> io::Result<()> {
        // Texts in messages are printable ASCII, so JSON escapes only these two characters.
        match escape {
            CharEscape::Quote => out.write_all(b"\""),
            CharEscape::ReverseSolidus => out.write_all(b"\\"),
            CharEscape::Solidus
            | CharEscape::Backspace
            | CharEscape::FormFeed
            | CharEscape::LineFeed
            | CharEscape::CarriageReturn
            | CharEscape::Tab
            | CharEscape::AsciiControl(_) => out.write_all(b" "),
        }
    }

    fn write_null<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.absent = self.depth == 1 && self.arrays == 0;
        out.write_all(b"-")
    }

    fn write_bool<W: ?Sized + Write>(&mut self, out: &mut W, value: bool) -> io::Result<()> {
        out.write_all(if value { b"yes" } else { b"no" })
    }

    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        self.write_blank(out)?;
        let letters = match self.key.take() {
            Some(Key::Latitude) => ["N", "S"],
            Some(Key::Longitude) => ["E", "W"],
            // Without the `.0` that JSON has.
            None if value.trunc() == value && value.abs() < WHOLE_MAX => {
                return CompactFormatter.write_i64(out, value as i64);
            }
            None => return CompactFormatter.write_f64(out, value),
        };
        out.write_all(place(value, letters).as_bytes())
    }
}

/// Larger numbers have an exponent.
const WHOLE_MAX: f64 = 1e15;

/// `42.363515 N`: six decimals are about a decimetre.
pub(crate) fn place(degrees: f64, [positive, negative]: [&str; 2]) -> String {
    let letter = if degrees < 0.0 { negative } else { positive };
    format!("{:.6} {letter}", degrees.abs())
}

#[cfg(test)]
mod tests {
    use backseat_spi::catalogue;

    use super::*;
    use crate::reading::Reading;
    use crate::splitter::{End, Piece};

    fn line(sentence: &str) -> String {
        let piece = Piece {
            bytes: sentence.as_bytes(),
            end: End::Line,
            line: 1,
        };
        let reading = Reading::of(piece, false).unwrap();
        let entry = catalogue().iter().find(|entry| entry.name == reading.name).unwrap();
        let mut out = Vec::new();
        write_fields(&mut out, entry.fields, &reading.outcome.unwrap()).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn fields_are_shown_with_their_units() {
        assert_eq!(
            line("$BFNVG,081025.987,4221.810920,N,07106.846030,W,1,,20.1,203.1,-3.4,4.5,081025.980"),
            "created 08:10:25.987, position 42.363515 N 71.114101 W, quality gps, altitude -, depth 20.1 m, \
             heading 203.1 deg, roll -3.4 deg, pitch 4.5 deg, solution 08:10:25.980"
        );
        assert_eq!(
            line("$BPRMB,081025.987,90,,2,1.5,9,0"),
            "created 08:10:25.987, horizontal 90 deg, vertical -, vertical_mode pitch, speed 1.5 m/s or rpm, \
             speed_mode other 9, horizontal_mode heading"
        );
        assert_eq!(
            line("$BFMIS,081025.987,,Running \"a\\b\","),
            "created 08:10:25.987, dive_file \"\", status \"Running \"a\\b\"\", details \"\""
        );
        assert_eq!(line("$BPLOG,NVG,ON"), "message NVG, on yes");
    }

    #[test]
    fn lists_and_frames_are_shown_whole() {
        assert_eq!(
            line("$BFDVL,081025.987,1.5,,0.01,45.1,45.3,44.9,45,10.25,081025.900"),
            "created 08:10:25.987, velocity [1.5 - 0.01] m/s, ranges [45.1 45.3 44.9 45] m, temperature 10.25 degC, \
             measured 08:10:25.900"
        );
        assert!(line("$BPCPD,081025.987,4711,3,1,1,2,48656C6C6F,00FF,,,,,,").ends_with("frames [48656C6C6F 00FF]"));
        let frames = line("$BFCPR,081025.987,081025.500,3,7,-1,2,1,48656C6C6F,9,00FF,0,,0,,0,,0,,0,,0,");
        assert!(
            frames.contains("data [(good 48656C6C6F) ((other 9) 00FF) (unset) ("),
            "{frames}"
        );
    }

    #[test]
    fn every_example_can_be_shown() {
        for entry in catalogue() {
            let line = line(entry.example);
            let shown: Vec<_> = entry
                .fields
                .iter()
                .filter(|field| line.contains(bare_name(field)))
                .collect();
            assert_eq!(shown.len(), entry.fields.len(), "{line}");
            assert!(!line.contains('{') && !line.contains('\n'), "{line}");
        }
    }
}

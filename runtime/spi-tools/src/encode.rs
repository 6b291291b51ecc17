use std::io::{BufRead, BufReader, Read, Write};

use backseat_spi::{Direction, FromVehicle, ToVehicle};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use crate::error::Error;
use crate::list::as_json;
use crate::reading::Message;
use crate::sheet::entry;

/// The longest line of JSON that is read, bytes: many times the longest message.
const MAX_OBJECT: usize = 1 << 16;

/// Encodes JSON objects, one a line, as sentences with checksum and line end. Returns the number of sentences.
///
/// An object has `name` and `message`, as written by [`crate::decode`]. `checksum` and `received_s` are ignored: the
/// checksum is always computed. Blank lines are skipped. Reading ends at the first invalid line; the sentences before
/// it have been written by then.
///
/// # Errors
///
/// The error gives the line, the message and its field, and what was expected.
pub fn encode(input: impl Read, out: &mut impl Write) -> Result<u64, Error> {
    let mut input = BufReader::with_capacity(MAX_OBJECT, input);
    let mut text = Vec::new();
    let mut sentences = Vec::new();
    let mut count = 0;
    for line in 1.. {
        // Writes what there is before waiting for more input.
        if sentences.len() > MAX_OBJECT || memchr::memchr(b'\n', input.buffer()).is_none() {
            flush(&mut sentences, out)?;
        }
        text.clear();
        let limit = MAX_OBJECT as u64 + 1;
        let read = input
            .by_ref()
            .take(limit)
            .read_until(b'\n', &mut text)
            .map_err(Error::Input)?;
        if read == 0 {
            break;
        }
        let encoded = if text.len() > MAX_OBJECT {
            Err(Error::TooLong { line, max: MAX_OBJECT })
        } else if text.trim_ascii().is_empty() {
            continue;
        } else {
            object(line, &text).and_then(|message| {
                message
                    .encode(&mut sentences)
                    .map_err(|source| Error::Value { line, source })
            })
        };
        if let Err(error) = encoded {
            flush(&mut sentences, out)?;
            return Err(error);
        }
        count += 1;
    }
    flush(&mut sentences, out)?;
    Ok(count)
}

fn flush(sentences: &mut Vec<u8>, out: &mut impl Write) -> Result<(), Error> {
    out.write_all(sentences)
        .and_then(|()| out.flush())
        .map_err(Error::Output)?;
    sentences.clear();
    Ok(())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Object {
    name: String,
    message: Option<Value>,
    error: Option<String>,
    #[serde(rename = "checksum", default)]
    _checksum: IgnoredAny,
    #[serde(rename = "received_s", default)]
    _received_s: IgnoredAny,
    #[serde(rename = "line", default)]
    _line: IgnoredAny,
}

fn object(line: u64, text: &[u8]) -> Result<Message, Error> {
    let Object {
        name, message, error, ..
    } = serde_json::from_slice(text).map_err(|error| Error::Object {
        line,
        column: error.column(),
        fault: without_place(&error.to_string()),
    })?;
    let Some(entry) = entry(&name) else {
        return Err(Error::Name { line, name });
    };
    let message = match (message, error) {
        (Some(message), None) => message,
        (_, Some(error)) => return Err(Error::NoContent { line, name, error }),
        (None, None) => {
            return Err(Error::Object {
                line,
                column: 0,
                fault: "no `message`".to_owned(),
            });
        }
    };
    let mut track = serde_path_to_error::Track::new();
    let fields = serde_path_to_error::Deserializer::new(message, &mut track);
    let read = match entry.direction {
        Direction::FromVehicle => FromVehicle::deserialize_named(&name, fields).map(Message::FromVehicle),
        Direction::ToVehicle => ToVehicle::deserialize_named(&name, fields).map(Message::ToVehicle),
    };
    read.map_err(|error| Error::Field {
        line,
        name,
        field_path: track.path().to_string(),
        // serde names a type of Rust.
        fault: error.to_string().replace("expected f64", "expected a number"),
        example: as_json(entry).unwrap_or_default(),
    })
}

/// An error of the JSON parser without its own `at line 1 column 7`, because the line number must be that of our input.
fn without_place(text: &str) -> String {
    text.split(" at line ").next().unwrap_or(text).to_owned()
}

#[cfg(test)]
mod tests {
    use backseat_spi::catalogue;

    use super::*;
    use crate::{Decoding, Form, decode};

    fn encoded(text: &str) -> (String, Result<u64, Error>) {
        let mut out = Vec::new();
        let result = encode(text.as_bytes(), &mut out);
        (String::from_utf8(out).unwrap(), result)
    }

    fn decoded(text: &str) -> String {
        let json = Decoding {
            form: Form::Json,
            ignore_checksum: false,
        };
        let mut out = Vec::new();
        decode(text.as_bytes(), json, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    fn fault(text: &str) -> String {
        let (out, result) = encoded(text);
        assert_eq!(out, "");
        let error = result.unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    }

    #[test]
    fn decode_encode_decode_is_the_identity_for_every_message() {
        let sentences: String = catalogue()
            .iter()
            .map(|entry| format!("{}\r\n", entry.example))
            .collect();
        let objects = decoded(&sentences);
        let (again, count) = encoded(&objects);
        assert_eq!(count.unwrap(), 71);
        assert_eq!(again, sentences);
        assert_eq!(decoded(&again), objects);
    }

    #[test]
    fn what_is_wrong_is_said_with_line_field_and_what_was_expected() {
        assert_eq!(
            fault("\n{\"name\":\"BPSTS\",\"message\":{\"created\":\"08:10:25\",\"ok\":\"yes\",\"text\":\"\"}}"),
            "line 2: BPSTS field ok: invalid type: string \"yes\", expected a boolean; a valid one is \
             {\"name\":\"BPSTS\",\"checksum\":\"valid\",\"message\":{\"created\":\"08:10:25.987\",\"ok\":true,\"text\":\"all ok\"}}"
        );
        assert!(
            fault("{\"name\":\"BPSTS\",\"message\":{\"created\":\"08:10:25\",\"ok\":true}}")
                .starts_with("line 1: BPSTS: missing field `text`; a valid one is {\"name\":\"BPSTS\",")
        );
        assert!(
            fault("{\"name\":\"BPSTS\",\"message\":{\"okay\":true}}")
                .starts_with("line 1: BPSTS field okay: unknown field `okay`, expected one of `created`, `ok`, `text`")
        );
        assert!(
            fault("{\"name\":\"BPSPD\",\"message\":{\"created\":\"08:10:25\",\"speed_mps\":1e12}}")
                .starts_with("line 1: BPSPD field speed_mps: expected ")
        );
        assert!(
            fault("{\"name\":\"BPSPD\",\"message\":{\"created\":\"8 o'clock\",\"speed_mps\":1}}")
                .starts_with("line 1: BPSPD field created: ")
        );
        assert!(fault("{\"name\":\"BPXYZ\",\"message\":{}}").starts_with("line 1: unknown message \"BPXYZ\""));
        assert!(fault("$BFCTL,081025.987,1*78").starts_with("line 1 column 1: expected value; expected {\"name\""));
        assert!(fault("{\"name\":\"BPRMP\"}").starts_with("line 1: no `message`; expected"));
        assert!(fault("{\"name\":\"BPRMP\",\"mesage\":{}}").contains("unknown field `mesage`"));
        assert!(fault(&decoded("$BFCTL,1*00\n")).starts_with("line 1: BFCTL has an error instead of a message"));
        assert!(fault(&"x".repeat(1 << 20)).starts_with("line 1: longer than 65536 bytes"));
        assert!(fault("\u{fffd}").starts_with("line 1"));
    }

    #[test]
    fn a_text_with_a_reserved_character_is_refused() {
        for bad in ["a,b", "a*b", "$BPABT", "a\\r\\nb", "é"] {
            let object = format!("{{\"name\":\"BPMSG\",\"message\":{{\"created\":\"08:10:25\",\"text\":\"{bad}\"}}}}");
            let fault = fault(&object);
            assert!(
                fault.starts_with("line 1: BPMSG field text: character ") && fault.contains("not allowed"),
                "{fault}"
            );
        }
    }

    #[test]
    fn the_lines_before_a_wrong_one_are_written() {
        let good = decoded("$BFCTL,081025.987,1*78\r\n");
        let (out, result) = encoded(&format!("{good}\r\n{good}{{}}\n{good}"));
        assert_eq!(out, "$BFCTL,081025.987,1*78\r\n".repeat(2));
        assert!(result.unwrap_err().to_string().starts_with("line 4"));
    }
}

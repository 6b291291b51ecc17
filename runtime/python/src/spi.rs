//! Sentences of the Standard Payload Interface as JSON, by the tools behind `backseat spi`.

use backseat_spi_tools::{Decoding, Form, Listing};
use serde_json::Value;

use crate::error::Error;

/// Every sentence in some bytes, in their order: `name`, `checksum`, and `message` or `error`. Other bytes are skipped.
///
/// # Errors
///
/// [`Error::Spi`] does not happen with bytes in memory.
pub fn decode(bytes: &[u8], ignore_checksum: bool) -> Result<Vec<Value>, Error> {
    let decoding = Decoding {
        form: Form::Json,
        ignore_checksum,
    };
    let mut out = Vec::new();
    backseat_spi_tools::decode(bytes, decoding, &mut out).map_err(|error| failed(&error))?;
    lines(&out)
}

/// The sentence of a message, with checksum and line end, from its name and its fields as [`decode`] gives them.
///
/// # Errors
///
/// [`Error::Spi`] with the field and what was expected.
pub fn encode(name: &str, message: &Value) -> Result<String, Error> {
    let object = serde_json::json!({ "name": name, "message": message });
    let mut out = Vec::new();
    backseat_spi_tools::encode(object.to_string().as_bytes(), &mut out).map_err(|error| failed(&error))?;
    // Sentences are bytes of Latin 1.
    Ok(out.into_iter().map(char::from).collect())
}

/// Every message of the interface, with section, direction, title and fields; or those with these names.
///
/// # Errors
///
/// [`Error::Spi`] if a name is unknown.
pub fn catalogue(names: &[String]) -> Result<Vec<Value>, Error> {
    let mut out = Vec::new();
    backseat_spi_tools::list(names, Listing::Json, &mut out).map_err(|error| failed(&error))?;
    lines(&out)
}

fn lines(out: &[u8]) -> Result<Vec<Value>, Error> {
    let lines = out.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    lines
        .map(|line| serde_json::from_slice(line).map_err(|error| Error::Spi(error.to_string())))
        .collect()
}

/// The error without the number of the line, because there is only one.
fn failed(error: &backseat_spi_tools::Error) -> Error {
    let text = error.to_string();
    Error::Spi(text.strip_prefix("line 1: ").unwrap_or(&text).to_owned())
}

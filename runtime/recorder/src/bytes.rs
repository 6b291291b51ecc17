//! Bytes in JSON: `text` if they are UTF-8, as sentences are, so that people can read them; otherwise `base64`.

use backseat_core::ExternalId;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::de::Error as _;
use serde_json::{Error, Map, Value};

/// Appends a message with these bytes. Written without the encoder, because half of all messages are bytes.
pub(crate) fn write(out: &mut Vec<u8>, bytes: &[u8]) {
    out.push(b'{');
    write_properties(out, bytes);
    out.push(b'}');
}

/// Appends a message with bytes from or for an external source; `kind` is `"input"` or `"output"`.
pub(crate) fn write_external(out: &mut Vec<u8>, kind: &str, external: ExternalId, bytes: &[u8]) {
    let ExternalId(external) = external;
    out.extend_from_slice(format!(r#"{{"{kind}":"external","external":{external},"#).as_bytes());
    write_properties(out, bytes);
    out.push(b'}');
}

fn write_properties(out: &mut Vec<u8>, bytes: &[u8]) {
    let written = match std::str::from_utf8(bytes) {
        Ok(text) => {
            out.extend_from_slice(br#""text":"#);
            serde_json::to_writer(out, text)
        }
        Err(_) => {
            out.extend_from_slice(br#""base64":"#);
            serde_json::to_writer(out, &STANDARD.encode(bytes))
        }
    };
    written.expect("a Vec takes every string");
}

/// The bytes of a message.
pub(crate) fn read(message: &Map<String, Value>) -> Result<Vec<u8>, Error> {
    let text = |key| message.get(key).and_then(Value::as_str);
    if let Some(text) = text("text") {
        return Ok(text.as_bytes().to_vec());
    }
    let base64 = text("base64").ok_or_else(|| Error::custom("expected `text` or `base64`"))?;
    STANDARD.decode(base64).map_err(Error::custom)
}

//! Bytes in JSON: as a string if they are UTF-8, as sentences are, so that people can read them; otherwise as numbers.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Json<'a> {
    Text(Cow<'a, str>),
    Numbers(Cow<'a, [u8]>),
}

pub(crate) fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Json::Text(text.into()),
        Err(_) => Json::Numbers(bytes.into()),
    }
    .serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    Ok(match Json::deserialize(deserializer)? {
        Json::Text(text) => text.into_owned().into_bytes(),
        Json::Numbers(bytes) => bytes.into_owned(),
    })
}

use serde::ser::{Serialize, SerializeStruct, Serializer};
use serde::{Deserialize, Deserializer};

use crate::error::{EncodeError, Fault};
use crate::sentence::{Fields, Sentence};

/// A sentence whose name this crate does not know in its direction. Programs should count and log it, and otherwise
/// ignore it (SPI 4.2). Serialised as its `name` and its raw `fields`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownMessage {
    name: Box<str>,
    body: Option<Box<str>>,
}

impl UnknownMessage {
    /// Makes a message from a name and raw fields.
    ///
    /// # Errors
    /// [`Fault`] if the name is not letters and digits, or if a field holds a delimiter or a control character.
    pub fn new(name: &str, fields: &[&str]) -> Result<Self, Fault> {
        if name.is_empty() || !name.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
            return Err(Fault::expected("a name of letters and digits"));
        }
        if fields
            .iter()
            .any(|field| field.chars().any(|c| c.is_control() || matches!(c, ',' | '*' | '$')))
        {
            return Err(Fault::expected(
                "fields without comma, asterisk, dollar and control characters",
            ));
        }
        let body = (!fields.is_empty()).then(|| fields.join(",").into_boxed_str());
        Ok(Self {
            name: name.into(),
            body,
        })
    }

    /// The sentence's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The raw text of the fields. Control characters, dollar signs and asterisks are replaced by blanks.
    #[must_use]
    pub fn fields(&self) -> Fields<'_> {
        Fields::of(self.body.as_deref())
    }

    pub(crate) fn of(sentence: &Sentence<'_>) -> Self {
        let body = sentence.body().map(|body| {
            body.replace(|c: char| c.is_control() || matches!(c, '$' | '*'), " ")
                .into_boxed_str()
        });
        Self {
            name: sentence.name().into(),
            body,
        }
    }

    /// Appends the name and the fields, without the dollar sign and the checksum.
    pub(crate) fn write(&self, out: &mut Vec<u8>, is_known: impl Fn(&str) -> bool) -> Result<(), EncodeError> {
        if is_known(&self.name) {
            return Err(EncodeError::Known {
                message: self.name.clone(),
            });
        }
        out.extend_from_slice(self.name.as_bytes());
        if let Some(body) = &self.body {
            out.push(b',');
            out.extend_from_slice(body.as_bytes());
        }
        Ok(())
    }
}

impl Serialize for UnknownMessage {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut both = serializer.serialize_struct("UnknownMessage", 2)?;
        both.serialize_field("name", &self.name)?;
        both.serialize_field("fields", &self.fields())?;
        both.end()
    }
}

impl<'de> Deserialize<'de> for UnknownMessage {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Both {
            name: String,
            fields: Vec<String>,
        }
        let Both { name, fields } = Both::deserialize(deserializer)?;
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        Self::new(&name, &fields).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_and_raw_fields_are_kept() {
        let sentence = Sentence::parse("$BFXYZ,1,,two words,*00").unwrap();
        let unknown = UnknownMessage::of(&sentence);
        assert_eq!(unknown.name(), "BFXYZ");
        assert_eq!(unknown.fields().collect::<Vec<_>>(), ["1", "", "two words", ""]);
        assert_eq!(
            unknown,
            UnknownMessage::new("BFXYZ", &["1", "", "two words", ""]).unwrap()
        );
    }

    #[test]
    fn name_and_raw_fields_are_serialised() {
        let unknown = UnknownMessage::new("BFXYZ", &["1", "", "two words"]).unwrap();
        let text = r#"{"name":"BFXYZ","fields":["1","","two words"]}"#;
        assert_eq!(serde_json::to_string(&unknown).unwrap(), text);
        assert_eq!(serde_json::from_str::<UnknownMessage>(text).unwrap(), unknown);
        assert!(serde_json::from_str::<UnknownMessage>(r#"{"name":"BFXYZ","fields":["1,2"]}"#).is_err());
    }

    #[test]
    fn control_characters_and_delimiters_become_blanks() {
        let unknown = UnknownMessage::of(&Sentence::parse("$BFXYZ,a\rb\u{1}c,é,$B*2*00").unwrap());
        assert_eq!(unknown.fields().collect::<Vec<_>>(), ["a b c", "é", " B 2"]);
    }

    #[test]
    fn fields_that_would_break_the_sentence_are_refused() {
        assert!(UnknownMessage::new("", &[]).is_err());
        assert!(UnknownMessage::new("BF,A", &[]).is_err());
        assert!(UnknownMessage::new("BFABC", &["a\r\n$BPABT"]).is_err());
        assert!(UnknownMessage::new("BFABC", &["a*00"]).is_err());
    }
}

#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Strategy};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::text::{RelayedText, Text};

/// Free text, which may be empty. A character that a [`Text`] may not hold is read as a blank, so that an accent in a
/// file's name does not lose a whole status.
impl Field for Text {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["c--c"];
    const RANGE: &'static str = "printable ASCII without , * $";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        reader.text().map(Self::cleaned)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.text(value.as_str());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        "[ -~]{0,60}".prop_map(|text| Self::cleaned(&text)).boxed()
    }
}

/// The free text that ends a message. A missing field is an empty text.
pub(crate) struct LastText;

impl Field for LastText {
    type Value = Text;
    const FORMATS: &'static [&'static str] = Text::FORMATS;
    const RANGE: &'static str = Text::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<Text, Fault> {
        if reader.is_done() {
            Ok(Text::default())
        } else {
            Text::decode(reader)
        }
    }

    fn encode(value: &Text, writer: &mut Writer<'_>) -> Result<(), Fault> {
        Text::encode(value, writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Text> {
        Text::strategy()
    }
}

/// The text that ends a message and is passed on with its delimiters. A missing field is an empty text.
impl Field for RelayedText {
    type Value = Self;
    const FORMATS: &'static [&'static str] = Text::FORMATS;
    const RANGE: &'static str = "printable ASCII with delimiters";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        if reader.is_done() {
            Ok(Self::default())
        } else {
            reader.text_to_end().map(Self::cleaned)
        }
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        if value.holds_command() {
            return Err(Fault::expected(
                "a text without $BP, which a vehicle could take for a command",
            ));
        }
        writer.text(value.as_str());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        proptest::prop_oneof!["[ -~]{0,60}", "[$][A-Z]{5}(,[$*,a-z0-9]{0,5}){0,6}[*][0-9A-F]{2}"]
            .prop_map(|text| Self::cleaned(&text.replace("$BP", "$CC")))
            .boxed()
    }
}

/// The three letters of a message, or `ALL`; letters and digits only.
pub(crate) struct Word;

const NOT_A_WORD: Fault = Fault::expected("a word of letters and digits");

impl Field for Word {
    type Value = Text;
    const FORMATS: &'static [&'static str] = &["rrr"];
    const RANGE: &'static str = "letters and digits";

    fn decode(reader: &mut Reader<'_>) -> Result<Text, Fault> {
        let word = reader.text()?.trim_ascii();
        if word.is_empty() {
            return Err(Fault::Empty);
        }
        if is_word(word) {
            Ok(Text::cleaned(word))
        } else {
            Err(NOT_A_WORD)
        }
    }

    fn encode(value: &Text, writer: &mut Writer<'_>) -> Result<(), Fault> {
        if !is_word(value.as_str()) {
            return Err(NOT_A_WORD);
        }
        writer.text(value.as_str());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Text> {
        "[A-Z0-9]{3}".prop_map(|text| Text::cleaned(&text)).boxed()
    }
}

fn is_word(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

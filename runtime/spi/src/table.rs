/// The messages of one direction. Each message is one row, and everything about it comes from its row.
///
/// A row has a doc line, the wire name, the type's name, section and title, the fields as `name: Type as Form,
/// "unit";`, where the form is a [`crate::field::Field`] whose value is the type, and an example. The table emits the
/// structs, the enum with `Unknown`, `From`, decode, encode, the catalogue's entries, and for each row a test of its
/// example and of a round trip. What is special about a message goes into a form, never into this macro.
macro_rules! messages {
    (
        $(#[$enum_doc:meta])*
        pub enum $Enum:ident from $direction:expr;

        $(
            $(#[$doc:meta])*
            $name:literal $Message:ident, $section:literal, $title:literal {
                $( $(#[$field_doc:meta])* $field:ident: $Type:ty as $Form:ty, $unit:literal; )*
            }
            $example:literal
        )*
    ) => {
        $(#[$enum_doc])*
        ///
        /// Serialised as the message, without its name.
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(untagged)]
        pub enum $Enum {
            $(
                #[doc = concat!($name, ", SPI ", $section, ".")]
                $Message($Message),
            )*
            /// A sentence whose name is not known in this direction.
            Unknown($crate::UnknownMessage),
        }

        $(
            $(#[$doc])*
            ///
            #[doc = concat!($name, ", SPI ", $section, ".")]
            #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
            #[serde(deny_unknown_fields)]
            pub struct $Message {
                $( $(#[$field_doc])* pub $field: $Type, )*
            }

            impl $Message {
                /// The sentence's name on the wire.
                pub const NAME: &'static str = $name;

                const KEY: u64 = $crate::table::key($name);

                /// Returns the enum and not the message, so that the message is built in place and not copied.
                fn read(reader: &mut $crate::field::Reader<'_>) -> Result<$Enum, $crate::DecodeError> {
                    $(
                        let $field = match <$Form as $crate::field::Field>::decode(reader) {
                            Ok(value) => value,
                            Err(fault) => return Err(reader.error($name, stringify!($field), fault)),
                        };
                    )*
                    Ok($Enum::$Message(Self { $($field),* }))
                }

                fn write(&self, out: &mut Vec<u8>) -> Result<(), $crate::EncodeError> {
                    out.extend_from_slice($name.as_bytes());
                    let mut writer = $crate::field::Writer::new(out);
                    $(
                        <$Form as $crate::field::Field>::encode(&self.$field, &mut writer).map_err(|fault| {
                            $crate::EncodeError::Field { message: $name, field: stringify!($field), fault }
                        })?;
                    )*
                    Ok(())
                }

                fn created_field(&self) -> Option<backseat_units::TimeOfDay> {
                    None $( .or(<$Form as $crate::field::Field>::created(&self.$field)) )*
                }
            }

            impl From<$Message> for $Enum {
                fn from(message: $Message) -> Self {
                    Self::$Message(message)
                }
            }
        )*

        impl $Enum {
            /// Reads a sentence of this direction. An unknown name gives `Unknown`. Fields after the known ones are
            /// ignored.
            ///
            /// The checksum is not checked here: [`crate::Framer`] passes only sentences that its policy allows.
            ///
            /// # Errors
            /// [`crate::DecodeError`] names message, field and fault.
            pub fn decode(sentence: &$crate::Sentence<'_>) -> Result<Self, $crate::DecodeError> {
                let mut reader = $crate::field::Reader::new(sentence);
                match $crate::table::key(sentence.name()) {
                    $( $Message::KEY => $Message::read(&mut reader), )*
                    _ => Ok(Self::Unknown($crate::UnknownMessage::of(sentence))),
                }
            }

            /// Appends the sentence, `$NAME,…*HH` with carriage return and line feed.
            ///
            /// # Errors
            /// [`crate::EncodeError`] if the other side would not read a value as the same value. Then nothing is
            /// appended.
            pub fn encode(&self, out: &mut Vec<u8>) -> Result<(), $crate::EncodeError> {
                $crate::table::enclose(out, |out| match self {
                    $( Self::$Message(message) => message.write(out), )*
                    Self::Unknown(unknown) => unknown.write(out, |name| {
                        ENTRIES.iter().any(|entry| entry.name == name)
                    }),
                })
            }

            /// Reads a serialised message. This is the reverse of serialising, which leaves the name out.
            ///
            /// # Errors
            /// The deserializer's own error, if no message of this direction has the name, or if a field is missing,
            /// unknown, or not a value of its type. [`Self::encode`] checks ranges.
            pub fn deserialize_named<'de, D: serde::Deserializer<'de>>(
                name: &str,
                deserializer: D,
            ) -> Result<Self, D::Error> {
                match name {
                    $( $name => <$Message as serde::Deserialize>::deserialize(deserializer).map(Self::$Message), )*
                    _ => Err(serde::de::Error::custom(format_args!(
                        "{name:?} is not a message of this direction"
                    ))),
                }
            }

            /// The sentence's name on the wire.
            #[must_use]
            pub fn name(&self) -> &str {
                match self {
                    $( Self::$Message(_) => $name, )*
                    Self::Unknown(unknown) => unknown.name(),
                }
            }

            /// When the message was made, by its sender's clock; `None` if the message does not say.
            #[must_use]
            pub fn created(&self) -> Option<backseat_units::TimeOfDay> {
                match self {
                    $( Self::$Message(message) => message.created_field(), )*
                    Self::Unknown(_) => None,
                }
            }
        }

        pub(crate) const ENTRIES: &[$crate::Entry] = &[$(
            $crate::Entry {
                name: $name,
                section: $section,
                title: $title,
                direction: $direction,
                fields: &[$(
                    $crate::EntryField {
                        name: stringify!($field),
                        unit: $unit,
                        formats: <$Form as $crate::field::Field>::FORMATS,
                        range: <$Form as $crate::field::Field>::RANGE,
                    }
                ),*],
                example: $example,
            }
        ),*];

        #[cfg(test)]
        mod table {
            use proptest::strategy::{BoxedStrategy, Just, Strategy};
            use proptest::test_runner::TestRunner;

            use super::*;

            /// Any message of each row, in the order of the rows.
            fn rows() -> Vec<BoxedStrategy<$Enum>> {
                vec![$( {
                    let all = Just(());
                    $( let all = (all, <$Form as $crate::field::Field>::strategy()); )*
                    all.prop_map(|values| {
                        $crate::table::unnest!(values; $($field)*);
                        $Enum::from($Message { $($field),* })
                    })
                    .boxed()
                } ),*]
            }

            #[test]
            fn every_row_survives_the_wire() {
                for row in rows() {
                    TestRunner::deterministic().run(&row, |message| {
                        $crate::table::check_round_trip::<$Enum>(&message, $Enum::encode, $Enum::decode);
                        let text = serde_json::to_string(&message).unwrap();
                        let mut json = serde_json::Deserializer::from_str(&text);
                        let back = $Enum::deserialize_named(message.name(), &mut json).unwrap();
                        // Compared as written on the wire, because the JSON parser may miss a number's last bit.
                        assert_eq!($crate::table::line(&back, $Enum::encode), $crate::table::line(&message, $Enum::encode));
                        Ok(())
                    }).unwrap();
                }
            }

            #[test]
            fn every_example_decodes_and_encodes() {
                for entry in ENTRIES {
                    let sentence = $crate::Sentence::parse(entry.example).unwrap();
                    let message = $Enum::decode(&sentence).unwrap();
                    assert!(!matches!(message, $Enum::Unknown(_)), "{}", entry.name);
                    assert_eq!(message.name(), entry.name);
                    let mut out = Vec::new();
                    message.encode(&mut out).unwrap();
                    assert_eq!(String::from_utf8(out).unwrap(), format!("{}\r\n", entry.example));
                }
            }

            #[test]
            fn every_row_ignores_more_fields_and_names_the_missing_one() {
                for entry in ENTRIES {
                    let (line, _) = entry.example.split_once('*').unwrap();
                    let plain = $Enum::decode(&$crate::Sentence::parse(line).unwrap()).unwrap();
                    let longer = format!("{line},,of a later version,7");
                    let longer = $Enum::decode(&$crate::Sentence::parse(&longer).unwrap()).unwrap();
                    let relays = |field: &$crate::EntryField| {
                        field.range == <$crate::RelayedText as $crate::field::Field>::RANGE
                    };
                    // A comma does not end a text that may hold commas.
                    assert_eq!(longer != plain, entry.fields.iter().any(relays), "{}", entry.name);
                    let bare = $Enum::decode(&$crate::Sentence::parse(&format!("${}", entry.name)).unwrap()).unwrap_err();
                    assert_eq!((bare.message, bare.number), (entry.name, 1));
                    assert_eq!((bare.field, &bare.fault), (entry.fields[0].name, &$crate::Fault::Missing));
                }
            }
        }
    };
}

/// Binds each field from tuples that are nested to the left, because proptest's own tuples have at most twelve
/// elements.
#[cfg(test)]
macro_rules! unnest {
    ($values:expr;) => { let () = $values; };
    ($values:expr; $($field:ident)+) => { $crate::table::unnest!(@reverse $values; [$($field)+] []); };
    (@reverse $values:expr; [$first:ident $($rest:ident)*] [$($done:ident)*]) => {
        $crate::table::unnest!(@reverse $values; [$($rest)*] [$first $($done)*]);
    };
    (@reverse $values:expr; [] [$($field:ident)*]) => { $crate::table::unnest!(@take $values; $($field)*); };
    (@take $values:expr; $last:ident $($field:ident)*) => {
        let (rest, $last) = $values;
        $crate::table::unnest!(@take rest; $($field)*);
    };
    (@take $values:expr;) => { let () = $values; };
}

pub(crate) use messages;
#[cfg(test)]
pub(crate) use unnest;

use crate::error::EncodeError;
use crate::{MAX_LINE, hex, sentence};

/// A name as a number, so that decoding finds its row by comparing integers. All names of SPI have five letters.
pub(crate) const fn key(name: &str) -> u64 {
    match *name.as_bytes() {
        [a, b, c, d, e] => u64::from_be_bytes([0, 0, 0, a, b, c, d, e]),
        _ => 0,
    }
}

/// Writes the dollar sign, what `write` writes, the checksum and the line end. If that fails or is too long, writes
/// nothing.
pub(crate) fn enclose(
    out: &mut Vec<u8>,
    write: impl FnOnce(&mut Vec<u8>) -> Result<(), EncodeError>,
) -> Result<(), EncodeError> {
    let start = out.len();
    out.reserve(160);
    out.push(b'$');
    if let Err(error) = write(out) {
        out.truncate(start);
        return Err(error);
    }
    let [high, low] = hex::digits(sentence::xor(&out[start + 1..]));
    out.extend_from_slice(&[b'*', high, low, b'\r', b'\n']);
    let length = out.len() - start;
    if length > MAX_LINE {
        let name = out[start + 1..].iter().take_while(|byte| byte.is_ascii_alphanumeric());
        let message = name
            .take(16)
            .map(|byte| char::from(*byte))
            .collect::<String>()
            .into_boxed_str();
        out.truncate(start);
        return Err(EncodeError::TooLong { message, length });
    }
    Ok(())
}

/// The line of a message, which must be one that can be written.
#[cfg(test)]
pub(crate) fn line<M>(message: &M, encode: fn(&M, &mut Vec<u8>) -> Result<(), EncodeError>) -> String {
    let mut out = Vec::new();
    encode(message, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// Encodes, decodes and encodes again, and checks that the message and the bytes stay the same.
#[cfg(test)]
pub(crate) fn check_round_trip<M: Clone + core::fmt::Debug + PartialEq>(
    message: &M,
    encode: fn(&M, &mut Vec<u8>) -> Result<(), EncodeError>,
    decode: fn(&crate::Sentence<'_>) -> Result<M, crate::DecodeError>,
) {
    let mut out = Vec::new();
    encode(message, &mut out).unwrap();
    let line = core::str::from_utf8(&out).unwrap();
    assert!(line.ends_with("\r\n"));
    let sentence = crate::Sentence::parse(line).unwrap();
    assert_eq!(sentence.checksum(), crate::ChecksumState::Valid);
    let back = decode(&sentence).unwrap();
    assert_eq!(&back, message, "{line}");
    let mut again = Vec::new();
    encode(&back, &mut again).unwrap();
    assert_eq!(again, out);
}

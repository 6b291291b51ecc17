//! One table a kind of text: a row a text, and everything about it from the row.

/// Emits the enum, its numbers, its codec and its entries for the catalogue, and tests of each row's example and of a
/// round trip.
macro_rules! texts {
    (
        $(#[$enum_doc:meta])*
        pub enum $Enum:ident of $kind:ident;
        $(
            $(#[$doc:meta])*
            $id:literal $Variant:ident $prefix:literal {
                $( $(#[$field_doc:meta])* $field:ident: $Type:ty as $Form:ty, $unit:literal; )*
            }
            $example:literal
        )*
    ) => {
        $(#[$enum_doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $Enum {
            $(
                $(#[$doc])*
                $Variant { $( $(#[$field_doc])* $field: $Type, )* },
            )*
        }

        impl $Enum {
            /// The number in the record's header.
            #[must_use]
            pub const fn id(&self) -> i32 {
                match self { $( Self::$Variant { .. } => $id, )* }
            }

            /// The variant's name.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                match self { $( Self::$Variant { .. } => stringify!($Variant), )* }
            }

            /// Reads the text of row `id`; `None` if there is no such row.
            fn read_row(id: i32, text: &str) -> Option<Result<Self, $crate::plc::TextError>> {
                match id {
                    $( $id => Some((|| {
                        #[allow(clippy::allow_attributes, unused_variables, reason = "a row may have no parameter")]
                        let fail = |field: &'static str| move |fault: $crate::plc::TextFault| $crate::plc::TextError {
                            text: stringify!($Variant),
                            field,
                            fault,
                        };
                        let words = $crate::plc::text::without_prefix(text, $prefix);
                        let fault = || $crate::plc::TextFault::expected(concat!("a text that begins with ", $prefix), text);
                        #[allow(clippy::allow_attributes, unused_mut, reason = "a row may have no parameter")]
                        let mut reader = $crate::plc::text::Reader::new(words.ok_or_else(fault).map_err(fail("text"))?);
                        $(
                            let $field = <$Form as $crate::plc::form::Form>::read(&mut reader)
                                .map_err(fail(stringify!($field)))?;
                        )*
                        match reader.left() {
                            None => Ok(Self::$Variant { $($field),* }),
                            Some(more) => Err(fail("end")($crate::plc::TextFault::extra(more))),
                        }
                    })()), )*
                    _ => None,
                }
            }

            /// Appends the text, exactly as the table has it.
            ///
            /// # Errors
            /// [`crate::plc::TextError`] if a value cannot be written so that it is read as the same; then nothing is
            /// appended.
            pub fn write(&self, out: &mut String) -> Result<(), $crate::plc::TextError> {
                let start = out.len();
                let result = match self {
                    $( Self::$Variant { $($field),* } => {
                        out.push_str($prefix);
                        #[allow(clippy::allow_attributes, unused_mut, unused_variables, reason = "as above")]
                        let mut writer = $crate::plc::text::Writer::new(out);
                        #[allow(clippy::allow_attributes, unused_mut, reason = "as above")]
                        let mut write = || {
                        $(
                            <$Form as $crate::plc::form::Form>::write($field, &mut writer).map_err(|fault| {
                                $crate::plc::TextError {
                                    text: stringify!($Variant),
                                    field: stringify!($field),
                                    fault,
                                }
                            })?;
                        )*
                        Ok(())
                        };
                        write()
                    }, )*
                };
                if result.is_err() {
                    out.truncate(start);
                }
                result
            }
        }

        pub(crate) const ENTRIES: &[$crate::plc::TextEntry] = &[$(
            $crate::plc::TextEntry {
                kind: $crate::plc::TextKind::$kind,
                id: $id,
                name: stringify!($Variant),
                prefix: $prefix,
                fields: &[$(
                    $crate::plc::TextField {
                        name: stringify!($field),
                        format: <$Form as $crate::plc::form::Form>::FORMAT,
                        unit: $unit,
                    }
                ),*],
                example: $example,
                test: concat!(module_path!(), "::table::every_row_survives_its_text"),
            }
        ),*];

        #[cfg(test)]
        mod table {
            use proptest::strategy::{BoxedStrategy, Just, Strategy as _};
            use proptest::test_runner::TestRunner;

            use super::*;

            /// Any text of each row, in the order of the rows.
            fn rows() -> Vec<BoxedStrategy<$Enum>> {
                vec![$( {
                    #[allow(clippy::allow_attributes, unused_variables, reason = "a row may have no parameter")]
                    let all = Just(());
                    $( let all = (all, <$Form as $crate::plc::form::Form>::strategy()); )*
                    all.prop_map(|values| {
                        $crate::plc::table::unnest!(values; $($field)*);
                        $Enum::$Variant { $($field),* }
                    })
                    .boxed()
                } ),*]
            }

            #[test]
            fn every_row_survives_its_text() {
                for row in rows() {
                    TestRunner::deterministic().run(&row, |value| {
                        let mut text = String::new();
                        value.write(&mut text).unwrap();
                        let back = $Enum::read_row(value.id(), &text).unwrap();
                        assert_eq!(back.as_ref(), Ok(&value), "{text}");
                        Ok(())
                    }).unwrap();
                }
            }

            #[test]
            fn every_example_is_read_and_written() {
                for entry in ENTRIES {
                    let value = $Enum::read_row(entry.id, entry.example).unwrap().unwrap();
                    assert_eq!((value.name(), value.id()), (entry.name, entry.id));
                    let mut text = String::new();
                    value.write(&mut text).unwrap();
                    assert_eq!(text, entry.example, "{}", entry.name);
                }
            }
        }
    };
}

/// `let` for each field out of tuples nested to the left: proptest's own tuples end at twelve.
#[cfg(test)]
macro_rules! unnest {
    ($values:expr;) => { let () = $values; };
    ($values:expr; $($field:ident)+) => { $crate::plc::table::unnest!(@reverse $values; [$($field)+] []); };
    (@reverse $values:expr; [$first:ident $($rest:ident)*] [$($done:ident)*]) => {
        $crate::plc::table::unnest!(@reverse $values; [$($rest)*] [$first $($done)*]);
    };
    (@reverse $values:expr; [] [$($field:ident)*]) => { $crate::plc::table::unnest!(@take $values; $($field)*); };
    (@take $values:expr; $last:ident $($field:ident)*) => {
        let (rest, $last) = $values;
        $crate::plc::table::unnest!(@take rest; $($field)*);
    };
    (@take $values:expr;) => { let () = $values; };
}

pub(crate) use texts;
#[cfg(test)]
pub(crate) use unnest;

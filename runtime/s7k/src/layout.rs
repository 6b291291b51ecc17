//! Fixed parts of records: one table row a field, and everything about the field from its row.

use serde::Serialize;

/// The values that a number may have; both bounds belong to it. NaN is outside every range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The least value.
    pub least: f64,
    /// The greatest value.
    pub greatest: f64,
}

impl Range {
    /// Every number of the field's type. A floating-point number must be finite.
    pub const ANY: Self = Self::new(f64::MIN, f64::MAX);

    pub(crate) const fn new(least: f64, greatest: f64) -> Self {
        Self { least, greatest }
    }

    /// Whether the value is inside.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        value >= self.least && value <= self.greatest
    }
}

impl core::fmt::Display for Range {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if *self == Self::ANY {
            f.write_str("any")
        } else if self.greatest == f64::MAX {
            write!(f, "{} or more", self.least)
        } else if self.least.to_bits() == self.greatest.to_bits() {
            write!(f, "{}", self.least)
        } else {
            write!(f, "{} to {}", self.least, self.greatest)
        }
    }
}

/// A fixed part of a record: a header, a frame, an entry of a list.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Layout {
    /// The name of this crate's type.
    pub name: &'static str,
    /// Where it is specified: a table of the data format's Volume III, or the framing of Volume I.
    pub source: &'static str,
    /// How many bytes it takes.
    pub size: usize,
    /// Its fields, in order, without gaps.
    pub fields: &'static [LayoutField],
    /// The test that any bytes survive reading and writing.
    pub test: &'static str,
}

/// A field of a [`Layout`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LayoutField {
    /// Its name in this crate's type.
    pub name: &'static str,
    /// Its type on the wire: `u32`.
    pub wire: &'static str,
    /// How many bytes it takes.
    pub size: usize,
    /// Its unit or meaning.
    pub unit: &'static str,
    /// Which values it may have.
    pub range: Range,
}

impl Layout {
    /// The fields with their offsets from the start of the part, in bytes.
    pub fn offsets(&self) -> impl Iterator<Item = (usize, &'static LayoutField)> {
        self.fields.iter().scan(0, |at, field| {
            let offset = *at;
            *at += field.size;
            Some((offset, field))
        })
    }
}

/// A value outside the range that the specification gives its field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{layout} field {field}: {value} is outside its range ({range})")]
pub struct FieldFault {
    /// The layout's name.
    pub layout: &'static str,
    /// The field's name.
    pub field: &'static str,
    /// The value; NaN for one that is no number.
    pub value: f64,
    /// The range.
    pub range: Range,
}

/// The part's bytes end before its last field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{layout} field {field}: the record ends at byte {found} of {needed}")]
pub struct Truncated {
    /// The layout's name.
    pub layout: &'static str,
    /// The first field that is not whole.
    pub field: &'static str,
    /// How many bytes there are.
    pub found: usize,
    /// How many the layout takes.
    pub needed: usize,
}

/// The fixed parts of records. A row is a doc line, the field's name and type, its unit and its range; the macro emits
/// the struct, its codec, its entry in the catalogue, and a test that any bytes survive reading and writing.
macro_rules! layouts {
    ($(
        $(#[$doc:meta])*
        $source:literal $Name:ident $test:ident {
            $( $(#[$field_doc:meta])* $field:ident: $Type:ty, $unit:literal, $range:expr; )*
        }
    )*) => {
        $(
            $(#[$doc])*
            ///
            #[doc = concat!("Source: ", $source, ".")]
            #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
            pub struct $Name {
                $( $(#[$field_doc])* pub $field: $Type, )*
            }

            impl $Name {
                /// How many bytes it takes.
                pub const SIZE: usize = 0 $( + <$Type as $crate::wire::Wire>::SIZE )*;

                /// Its fields, with types, units and ranges.
                pub const LAYOUT: $crate::Layout = $crate::Layout {
                    name: stringify!($Name),
                    source: $source,
                    size: Self::SIZE,
                    fields: &[$(
                        $crate::LayoutField {
                            name: stringify!($field),
                            wire: <$Type as $crate::wire::Wire>::TYPE,
                            size: <$Type as $crate::wire::Wire>::SIZE,
                            unit: $unit,
                            range: $range,
                        }
                    ),*],
                    test: concat!(module_path!(), "::layouts::", stringify!($test)),
                };

                /// Reads it from the start of `bytes`. Every bit pattern is accepted: see [`Self::faults`].
                ///
                /// # Errors
                /// [`crate::Truncated`] if there are fewer than [`Self::SIZE`] bytes.
                pub fn read(bytes: &[u8]) -> Result<Self, $crate::Truncated> {
                    let Some(bytes) = bytes.first_chunk::<{ Self::SIZE }>() else {
                        return Err($crate::layout::truncated(&Self::LAYOUT, bytes.len()));
                    };
                    let at = 0;
                    $(
                        let end = at + <$Type as $crate::wire::Wire>::SIZE;
                        let $field = <$Type as $crate::wire::Wire>::get(&bytes[at..end]);
                        let at = end;
                    )*
                    debug_assert_eq!(at, Self::SIZE);
                    Ok(Self { $($field),* })
                }

                /// Appends its [`Self::SIZE`] bytes.
                pub fn write(&self, out: &mut Vec<u8>) {
                    $( $crate::wire::Wire::put(&self.$field, out); )*
                }

                /// The values that are outside their ranges, in the order of the fields.
                #[must_use]
                pub fn faults(&self) -> Vec<$crate::FieldFault> {
                    let mut fields = Self::LAYOUT.fields.iter();
                    let mut faults = Vec::new();
                    $( $crate::layout::audit(&Self::LAYOUT, fields.next(), &self.$field, &mut faults); )*
                    faults
                }
            }
        )*

        /// The layouts of this module, in its order.
        pub(crate) const LAYOUTS: &[$crate::Layout] = &[$( $Name::LAYOUT ),*];

        #[cfg(test)]
        mod layouts {
            use proptest::strategy::Strategy as _;

            $(
                #[test]
                fn $test() {
                    use super::$Name;
                    let bytes = proptest::collection::vec(proptest::num::u8::ANY, $Name::SIZE);
                    let mut runner = proptest::test_runner::TestRunner::deterministic();
                    runner.run(&bytes.boxed(), |bytes| {
                        let mut out = Vec::new();
                        $Name::read(&bytes).unwrap().write(&mut out);
                        assert_eq!(out, bytes);
                        let short = $Name::read(&bytes[..bytes.len() - 1]).unwrap_err();
                        assert_eq!(short.field, $Name::LAYOUT.fields.last().unwrap().name);
                        Ok(())
                    }).unwrap();
                }
            )*
        }
    };
}

pub(crate) use layouts;

use crate::wire::Wire;

/// Names the first field that `found` bytes do not hold whole.
#[cold]
pub(crate) fn truncated(layout: &Layout, found: usize) -> Truncated {
    let whole = |(offset, field): &(usize, &LayoutField)| offset + field.size <= found;
    let field = layout
        .offsets()
        .find(|field| !whole(field))
        .map_or("", |(_, field)| field.name);
    Truncated {
        layout: layout.name,
        field,
        found,
        needed: layout.size,
    }
}

/// Adds a fault if the value is outside its field's range.
pub(crate) fn audit<T: Wire>(layout: &Layout, field: Option<&LayoutField>, value: &T, faults: &mut Vec<FieldFault>) {
    let Some(field) = field else { return };
    let number = value.number();
    let inside = number.is_none_or(|number| field.range.contains(number)) && value.is_known();
    if !inside {
        faults.push(FieldFault {
            layout: layout.name,
            field: field.name,
            value: number.unwrap_or(f64::NAN),
            range: field.range,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_outside_every_range() {
        assert!(!Range::ANY.contains(f64::NAN));
        assert!(!Range::ANY.contains(f64::INFINITY));
        assert!(Range::ANY.contains(-0.0));
        assert!(Range::new(1.0, 366.0).contains(366.0));
        assert!(!Range::new(1.0, 366.0).contains(0.0));
    }

    #[test]
    fn ranges_read_as_a_person_writes_them() {
        let shown = [
            Range::ANY,
            Range::new(0.0, f64::MAX),
            Range::new(1.0, 366.0),
            Range::new(1.0, 1.0),
        ];
        assert_eq!(
            shown.map(|range| range.to_string()),
            ["any", "0 or more", "1 to 366", "1"]
        );
    }
}

use core::marker::PhantomData;

#[cfg(test)]
use proptest::prelude::BoxedStrategy;

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};

/// A value, followed by fields that the specification reserves. They are written as `R` says. In reading they are
/// ignored, and may be missing.
pub(crate) struct Then<F, R>(PhantomData<(F, R)>);

/// The text of reserved fields, as they are written.
pub(crate) trait Reserved {
    /// The text of each field.
    const FIELDS: &'static [&'static str];
}

/// One field, always 0 in this version (SPI 6.21).
pub(crate) struct Zero;

impl Reserved for Zero {
    const FIELDS: &'static [&'static str] = &["0"];
}

/// Three fields that are not specified (SPI 6.20).
pub(crate) struct ThreeEmpty;

impl Reserved for ThreeEmpty {
    const FIELDS: &'static [&'static str] = &["", "", ""];
}

impl<F: Field, R: Reserved> Field for Then<F, R> {
    type Value = F::Value;
    const FORMATS: &'static [&'static str] = {
        // A constant cannot join slices of arbitrary lengths, so this lists the combinations that the tables have.
        match (F::FORMATS, R::FIELDS.len()) {
            ([a], 1) => &[*a, "reserved"],
            ([a, b, c, d], 3) => &[*a, *b, *c, *d, "reserved", "reserved", "reserved"],
            _ => panic!("a row combines a value and reserved fields in a way that this list lacks"),
        }
    };
    const RANGE: &'static str = F::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        let value = F::decode(reader)?;
        for _ in R::FIELDS {
            if reader.is_done() {
                break;
            }
            reader.bytes()?;
        }
        Ok(value)
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        F::encode(value, writer)?;
        R::FIELDS.iter().for_each(|field| writer.text(field));
        Ok(())
    }

    fn created(value: &Self::Value) -> Option<backseat_units::TimeOfDay> {
        F::created(value)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        F::strategy()
    }
}

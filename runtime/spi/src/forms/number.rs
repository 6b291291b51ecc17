use core::marker::PhantomData;

#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop_oneof};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::number::parse_integer;

/// Plain numbers, at most `D` decimals written. The unit is in the field's name.
pub(crate) struct Decimal<const D: u8>;

impl<const D: u8> Field for Decimal<D> {
    type Value = f64;
    const FORMATS: &'static [&'static str] = &["x.x"];

    fn decode(reader: &mut Reader<'_>) -> Result<f64, Fault> {
        reader.decimal()
    }

    fn encode(value: &f64, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.decimal(*value, D)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<f64> {
        decimals(-1_000_000_000, 1_000_000_000, D)
    }
}

/// Whole numbers.
impl Field for u32 {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x"];

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        parse_integer(reader.trimmed()?)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.integer(*value);
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        any::<u32>().boxed()
    }
}

/// A value whose fields may be empty: the first one says.
pub(crate) struct Optional<F>(PhantomData<F>);

impl<F: Field> Field for Optional<F>
where
    F::Value: Clone + core::fmt::Debug + 'static,
{
    type Value = Option<F::Value>;
    const FORMATS: &'static [&'static str] = F::FORMATS;

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        if reader.next_is_blank() {
            for _ in F::FORMATS {
                reader.bytes()?;
            }
            return Ok(None);
        }
        F::decode(reader).map(Some)
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        match value {
            Some(value) => F::encode(value, writer),
            None => {
                F::FORMATS.iter().for_each(|_| writer.empty());
                Ok(())
            }
        }
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        prop_oneof![Just(None), F::strategy().prop_map(Some)].boxed()
    }
}

/// The entry angle of a trackcircle: the header of SPI 7.6 leaves it out, the table has it. Read with and without,
/// and always written.
pub(crate) struct EntryAngle;

impl Field for EntryAngle {
    type Value = Option<f64>;
    const FORMATS: &'static [&'static str] = &["x.x"];

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        // Only the interrupt code follows: where one field is left, it is that.
        if reader.remaining() <= 1 {
            Ok(None)
        } else {
            Optional::<Decimal<3>>::decode(reader)
        }
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        Optional::<Decimal<3>>::encode(value, writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        Optional::<Decimal<3>>::strategy()
    }
}

/// Multiples of a decimal place, which the wire keeps exactly.
#[cfg(test)]
pub(super) fn decimals(min: i64, max: i64, places: u8) -> BoxedStrategy<f64> {
    (min..=max)
        .prop_map(move |scaled| scaled as f64 / (0..places).fold(1.0, |power, _| power * 10.0))
        .boxed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    #[test]
    fn empty_is_not_zero() {
        assert_eq!(read::<Decimal<3>>(""), Err(Fault::Empty));
        assert_eq!(read::<Decimal<3>>(" ,1"), Err(Fault::Empty));
        assert_eq!(read::<u32>(""), Err(Fault::Empty));
        assert_eq!(read::<Optional<Decimal<3>>>(" ,1"), Ok(None));
        assert_eq!(read::<Optional<Decimal<3>>>("0"), Ok(Some(0.0)));
        assert_eq!(written::<Optional<Decimal<3>>>(&None).unwrap(), ",");
    }

    #[test]
    fn blanks_around_numbers_are_tolerated() {
        assert_eq!(read::<Decimal<3>>("  -1.5 ,2"), Ok(-1.5));
        assert_eq!(read::<u32>(" 7 "), Ok(7));
        assert_eq!(read::<Optional<u32>>(" 7 "), Ok(Some(7)));
        assert!(read::<Decimal<3>>("- 1.5").is_err());
    }

    #[test]
    fn an_entry_angle_is_there_where_more_than_the_interrupt_code_is_left() {
        assert_eq!(read::<EntryAngle>("180.0,4"), Ok(Some(180.0)));
        assert_eq!(read::<EntryAngle>(",4"), Ok(None));
        assert_eq!(read::<EntryAngle>("4"), Ok(None));
    }
}

use core::marker::PhantomData;

#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Just, Strategy, prop_oneof};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};

/// A value whose fields may be empty. If the first field is empty, the value is `None`.
pub(crate) struct Optional<F>(PhantomData<F>);

impl<F: Field> Field for Optional<F>
where
    F::Value: Clone + core::fmt::Debug + 'static,
{
    type Value = Option<F::Value>;
    const FORMATS: &'static [&'static str] = F::FORMATS;
    const RANGE: &'static str = F::RANGE;

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

/// A value that a sender may leave out. If its field is missing or empty, it has its default.
pub(crate) struct OrDefault<F>(PhantomData<F>);

impl<F: Field> Field for OrDefault<F>
where
    F::Value: Default,
{
    type Value = F::Value;
    const FORMATS: &'static [&'static str] = F::FORMATS;
    const RANGE: &'static str = F::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<F::Value, Fault> {
        if reader.is_done() {
            return Ok(F::Value::default());
        }
        if reader.next_is_blank() {
            for _ in F::FORMATS {
                reader.bytes()?;
            }
            return Ok(F::Value::default());
        }
        F::decode(reader)
    }

    fn encode(value: &F::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        F::encode(value, writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<F::Value> {
        F::strategy()
    }
}

/// Several values of one form in a row.
pub(crate) struct Each<F, const N: usize>(PhantomData<F>);

impl<F: Field, const N: usize> Field for Each<F, N>
where
    F::Value: Copy + core::fmt::Debug + 'static,
{
    type Value = [F::Value; N];
    const FORMATS: &'static [&'static str] = match F::FORMATS {
        [format] => &[*format; N],
        _ => panic!("only values of one field are repeated"),
    };
    const RANGE: &'static str = F::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        let mut values = [F::decode(reader)?; N];
        for value in values.iter_mut().skip(1) {
            *value = F::decode(reader)?;
        }
        Ok(values)
    }

    fn encode(values: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        values.iter().try_for_each(|value| F::encode(value, writer))
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        proptest::collection::vec(F::strategy(), N)
            .prop_map(|values| values.try_into().expect("as many as there are places"))
            .boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{Decimal, read, written};

    #[test]
    fn values_that_may_be_left_out_have_their_default() {
        let second = |body: &str| {
            let line = format!("$X,7{body}");
            let sentence = crate::Sentence::parse(&line).unwrap();
            let mut reader = Reader::new(&sentence);
            u32::decode(&mut reader)?;
            OrDefault::<u32>::decode(&mut reader)
        };
        assert_eq!(
            (second(""), second(","), second(", ,9"), second(",8")),
            (Ok(0), Ok(0), Ok(0), Ok(8))
        );
        assert!(second(",x").is_err());
    }

    #[test]
    fn each_place_of_an_array_is_its_own_field() {
        type Ranges = Each<Optional<Decimal<3>>, 4>;
        assert_eq!(read::<Ranges>("1.5,, ,-2"), Ok([Some(1.5), None, None, Some(-2.0)]));
        assert_eq!(read::<Ranges>("1.5,,"), Err(Fault::Missing));
        assert_eq!(
            written::<Ranges>(&[None, Some(2.0), None, Some(0.0)]).unwrap(),
            ",,2,,0"
        );
        assert_eq!(Ranges::FORMATS, ["x.x"; 4]);
    }
}

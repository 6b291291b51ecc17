#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop_oneof};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::forms::Optional;
use crate::identity::{BehaviorId, CommandName};

impl Field for CommandName {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["rrr"];
    const RANGE: &'static str = "three of A-Z 0-9";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        if let Some(letters) = reader.peek().copied().and_then(Self::from_letters) {
            reader.skip(3);
            return Ok(letters);
        }
        Self::new(reader.text()?.trim_ascii())
            .map_err(|_| Fault::expected("three upper-case letters, or BP and three letters"))
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.text(value.as_str());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        "[A-Z0-9]{3}"
            .prop_map(|letters| Self::new(&letters).expect("three letters"))
            .boxed()
    }
}

impl Field for BehaviorId {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["iiii"];
    const RANGE: &'static str = "0..4294967295";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        reader.integer().map(Self::new)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.integer(value.get());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        any::<u32>().prop_map(Self::new).boxed()
    }
}

/// Reads an identifier that may be absent: 0 or an empty field is `None`.
fn optional_identifier(reader: &mut Reader<'_>) -> Result<Option<BehaviorId>, Fault> {
    let identifier = Optional::<BehaviorId>::decode(reader)?;
    Ok(identifier.filter(|identifier| identifier.get() != 0))
}

fn write_optional_identifier(identifier: Option<BehaviorId>, none: &str, writer: &mut Writer<'_>) -> Result<(), Fault> {
    match identifier {
        Some(identifier) if identifier.get() == 0 => {
            Err(Fault::expected("an identifier that is not 0, which means none"))
        }
        Some(identifier) => BehaviorId::encode(&identifier, writer),
        None => {
            writer.text(none);
            Ok(())
        }
    }
}

/// An identifier that may be absent. `None` is written as 0, as in real acknowledgements.
pub(crate) struct IdentifierOrZero;

impl Field for IdentifierOrZero {
    type Value = Option<BehaviorId>;
    const FORMATS: &'static [&'static str] = BehaviorId::FORMATS;
    const RANGE: &'static str = "1..4294967295";

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        optional_identifier(reader)
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        write_optional_identifier(*value, "0", writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        any::<u32>()
            .prop_map(|number| (number != 0).then_some(BehaviorId::new(number)))
            .boxed()
    }
}

/// An identifier that may be absent. `None` is written as an empty field (SPI 6.9).
pub(crate) struct IdentifierOrEmpty;

impl Field for IdentifierOrEmpty {
    type Value = Option<BehaviorId>;
    const FORMATS: &'static [&'static str] = BehaviorId::FORMATS;
    const RANGE: &'static str = "1..4294967295";

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        optional_identifier(reader)
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        write_optional_identifier(*value, "", writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        prop_oneof![Just(None), IdentifierOrZero::strategy()].boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    #[test]
    fn an_absent_identifier_is_zero_or_empty_and_never_a_number() {
        assert_eq!(read::<IdentifierOrZero>("0,"), Ok(None));
        assert_eq!(read::<IdentifierOrEmpty>(","), Ok(None));
        assert_eq!(read::<IdentifierOrZero>("1001"), Ok(Some(BehaviorId::new(1001))));
        assert!(read::<IdentifierOrZero>("x").is_err());
        assert_eq!(written::<IdentifierOrZero>(&None).unwrap(), ",0");
        assert_eq!(written::<IdentifierOrEmpty>(&None).unwrap(), ",");
        assert!(written::<IdentifierOrZero>(&Some(BehaviorId::new(0))).is_err());
    }
}

use backseat_units::{Altitude, Depth, GridHeading};
#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Just, Strategy, prop_oneof};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
#[cfg(test)]
use crate::forms::number::decimals;
use crate::forms::{Decimal, Optional};

/// Metres, three decimals.
impl Field for Depth {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "-100..12000";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        Ok(Self::from_m(reader.decimal()?)?)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.decimal(value.as_m(), 3)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        decimals(-100_000, 12_000_000, 3)
            .prop_map(|metres| Self::from_m(metres).expect("within the range"))
            .boxed()
    }
}

/// An altitude as the vehicle writes it: `0.000` or nothing if there is no bottom lock.
pub(crate) struct BottomLock;

impl Field for BottomLock {
    type Value = Option<Altitude>;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "0..12000";

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        let metres = Optional::<Decimal<3>>::decode(reader)?.unwrap_or(0.0);
        Ok(if metres == 0.0 {
            None
        } else {
            Some(Altitude::from_m(metres)?)
        })
    }

    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        match value {
            // A vehicle that lies on the bottom has not lost it, so an altitude that would round to zero is written as
            // the smallest one above zero.
            Some(altitude) => writer.decimal(altitude.as_m().max(0.001), 3),
            None => {
                writer.text("0.000");
                Ok(())
            }
        }
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        prop_oneof![
            Just(None),
            decimals(1, 12_000_000, 3).prop_map(|metres| Some(Altitude::from_m(metres).expect("within the range"))),
        ]
        .boxed()
    }
}

/// Degrees, three decimals. The written value is below 360 after rounding too.
impl Field for GridHeading {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "0..360";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        Ok(Self::from_deg(reader.decimal()?)?)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        let deg = value.as_deg();
        writer.decimal(if deg < 359.9995 { deg } else { 0.0 }, 3)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        decimals(0, 359_999, 3)
            .prop_map(|deg| Self::from_deg(deg).expect("within a turn"))
            .boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    #[test]
    fn without_bottom_lock_there_is_no_altitude() {
        for none in ["", " ", "0", "0.000", "-0.0"] {
            assert_eq!(read::<BottomLock>(none), Ok(None), "{none:?}");
        }
        assert_eq!(read::<BottomLock>("45.3"), Ok(Some(Altitude::from_m(45.3).unwrap())));
        assert_eq!(written::<BottomLock>(&None).unwrap(), ",0.000");
        // A vehicle on the bottom has bottom lock.
        assert_eq!(
            written::<BottomLock>(&Some(Altitude::from_m(0.000_1).unwrap())).unwrap(),
            ",0.001"
        );
    }

    #[test]
    fn ranges_are_those_of_the_units() {
        assert!(matches!(read::<Depth>("12000.1"), Err(Fault::OutOfRange(_))));
        assert!(matches!(read::<BottomLock>("-1"), Err(Fault::OutOfRange(_))));
        assert!(matches!(read::<GridHeading>("1000001"), Err(Fault::OutOfRange(_))));
        assert_eq!(read::<Depth>("-0.25"), Ok(Depth::from_m(-0.25).unwrap()));
    }

    #[test]
    fn a_heading_is_never_written_as_a_whole_turn() {
        let deg = |deg| GridHeading::from_deg(deg).unwrap();
        assert_eq!(written::<GridHeading>(&deg(359.999_9)).unwrap(), ",0");
        assert_eq!(written::<GridHeading>(&deg(359.999)).unwrap(), ",359.999");
        assert_eq!(read::<GridHeading>("-90"), Ok(deg(270.0)));
    }
}

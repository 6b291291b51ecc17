#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Strategy, any};

use crate::circle_entry::CircleEntry;
use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::forms::Optional;

/// A plain number, written with at most `D` decimals. The unit is in the field's name.
pub(crate) struct Decimal<const D: u8>;

impl<const D: u8> Field for Decimal<D> {
    type Value = f64;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "any";

    #[inline]
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

/// A whole number.
impl Field for u32 {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x"];
    const RANGE: &'static str = "0..4294967295";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        reader.integer()
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

/// A whole number that may be negative.
impl Field for i32 {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x"];
    const RANGE: &'static str = "-2147483648..2147483647";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        reader.signed()
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.signed(*value);
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        any::<i32>().boxed()
    }
}

/// A camera's movement, tenths of a second (SPI 8.10).
pub(crate) struct Nine;

impl Nine {
    fn checked(value: i32) -> Result<i32, Fault> {
        if (-9..=9).contains(&value) {
            Ok(value)
        } else {
            Err(Fault::expected("a whole number from -9 to 9"))
        }
    }
}

impl Field for Nine {
    type Value = i32;
    const FORMATS: &'static [&'static str] = i32::FORMATS;
    const RANGE: &'static str = "-9..9";

    fn decode(reader: &mut Reader<'_>) -> Result<i32, Fault> {
        Self::checked(i32::decode(reader)?)
    }

    fn encode(value: &i32, writer: &mut Writer<'_>) -> Result<(), Fault> {
        i32::encode(&Self::checked(*value)?, writer)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<i32> {
        (-9..=9).boxed()
    }
}

/// A percentage. Any value is read, because a battery that reports 100.4 reports other values too; only 0 to 100 is
/// written.
pub(crate) struct Percent;

impl Field for Percent {
    type Value = f64;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "0..100";

    fn decode(reader: &mut Reader<'_>) -> Result<f64, Fault> {
        reader.decimal()
    }

    fn encode(value: &f64, writer: &mut Writer<'_>) -> Result<(), Fault> {
        if (0.0..=100.0).contains(value) {
            writer.decimal(*value, 3)
        } else {
            Err(Fault::expected("a percentage from 0 to 100"))
        }
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<f64> {
        decimals(0, 100_000, 3)
    }
}

impl Field for CircleEntry {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x.x"];
    const RANGE: &'static str = "any";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        // Only the interrupt code follows. If one field is left, it is that code.
        if reader.remaining() <= 1 {
            return Ok(Self::Absent);
        }
        let angle = Optional::<Decimal<3>>::decode(reader)?;
        Ok(angle.map_or(Self::Anywhere, Self::Angle))
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        match value {
            Self::Angle(degrees) => Decimal::<3>::encode(degrees, writer),
            Self::Anywhere => Optional::<Decimal<3>>::encode(&None, writer),
            Self::Absent => Ok(()),
        }
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        use proptest::prelude::Just;
        proptest::prop_oneof![
            Decimal::<3>::strategy().prop_map(Self::Angle),
            Just(Self::Anywhere),
            Just(Self::Absent),
        ]
        .boxed()
    }
}

/// Multiples of a decimal place, which are written exactly.
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
    fn a_camera_moves_at_most_nine_tenths_and_a_battery_may_report_over_100_percent() {
        assert_eq!((read::<Nine>("-9"), read::<Nine>("9")), (Ok(-9), Ok(9)));
        assert!(read::<Nine>("10").is_err() && written::<Nine>(&-10).is_err());
        assert_eq!(read::<Percent>("100.4"), Ok(100.4));
        assert!(written::<Percent>(&100.4).is_err() && written::<Percent>(&-0.1).is_err());
        assert!(written::<Percent>(&f64::NAN).is_err());
    }

    #[test]
    fn blanks_around_numbers_are_tolerated() {
        assert_eq!(read::<Decimal<3>>("  -1.5 ,2"), Ok(-1.5));
        assert_eq!(read::<u32>(" 7 "), Ok(7));
        assert_eq!(read::<Optional<u32>>(" 7 "), Ok(Some(7)));
        assert!(read::<Decimal<3>>("- 1.5").is_err());
    }

    #[test]
    fn an_entry_angle_is_read_if_more_than_the_interrupt_code_is_left() {
        assert_eq!(read::<CircleEntry>("180.0,4"), Ok(CircleEntry::Angle(180.0)));
        assert_eq!(read::<CircleEntry>(",4"), Ok(CircleEntry::Anywhere));
        assert_eq!(read::<CircleEntry>("4"), Ok(CircleEntry::Absent));
    }
}

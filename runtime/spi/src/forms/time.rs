use backseat_units::TimeOfDay;
#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Strategy};

use crate::echo::EchoedTime;
use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::number::two_digits;
use crate::word;

const NOT_A_TIME: Fault = Fault::expected("a time of day, hhmmss and any decimals");

/// UTC without a date. Any number of decimals is read and cut to nanoseconds. Exactly three are written, cut and not
/// rounded.
impl Field for TimeOfDay {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["hhmmss.sss"];
    const RANGE: &'static str = "000000.000..235960.999";

    #[inline]
    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        match take_millis(reader) {
            Some(time) => Ok(time),
            None => parse_time(reader.trimmed()?).ok_or(NOT_A_TIME),
        }
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        let (hour, minute, second, nanos) = value.hms_nano();
        let millis = nanos / 1_000_000;
        let [h1, h2] = two_digits(hour);
        let [m1, m2] = two_digits(minute);
        let [s1, s2] = two_digits(second);
        let [d1, d2] = two_digits(millis / 10);
        let [_, d3] = two_digits(millis % 10);
        writer
            .field()
            .extend_from_slice(&[h1, h2, m1, m2, s1, s2, b'.', d1, d2, d3]);
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        (0..86_401_000u64)
            .prop_map(|millis| Self::from_nanos(millis * 1_000_000).expect("within a day and a leap second"))
            .boxed()
    }
}

/// Takes the next field if it is `hhmmss.sss`, as nearly all times are. The result is returned in registers.
#[inline(never)]
fn take_millis(reader: &mut Reader<'_>) -> Option<TimeOfDay> {
    let time = parse_millis(reader.peek()?)?;
    reader.skip(10);
    Some(time)
}

fn parse_millis(text: &[u8; 10]) -> Option<TimeOfDay> {
    const FORM: u64 = u64::from_le_bytes(*b"000000.0");
    let [first @ .., d2, d3] = text;
    // Each character, less the character `0` or the point that belongs in its place.
    let values = u64::from_le_bytes(*first) ^ FORM;
    let (d2, d3) = (d2.wrapping_sub(b'0'), d3.wrapping_sub(b'0'));
    if !word::are_digits(values) || values.to_le_bytes()[6] != 0 || d2 > 9 || d3 > 9 {
        return None;
    }
    let [h1, h2, m1, m2, s1, s2, _, d1] = values.to_le_bytes().map(u32::from);
    let millis = d1 * 100 + u32::from(d2) * 10 + u32::from(d3);
    TimeOfDay::from_hms_nano(h1 * 10 + h2, m1 * 10 + m2, s1 * 10 + s2, millis * 1_000_000)
}

fn parse_time(text: &[u8]) -> Option<TimeOfDay> {
    let (digits, decimals) = text.split_at_checked(6)?;
    let pair = |at: usize| match (digits[at].wrapping_sub(b'0'), digits[at + 1].wrapping_sub(b'0')) {
        (tens @ 0..=9, ones @ 0..=9) => Some(u32::from(tens) * 10 + u32::from(ones)),
        _ => None,
    };
    let mut nanos = 0;
    if let [point, decimals @ ..] = decimals {
        if *point != b'.' {
            return None;
        }
        let mut unit = 100_000_000;
        for byte in decimals {
            match byte.wrapping_sub(b'0') {
                digit @ 0..=9 => nanos += u32::from(digit) * unit,
                _ => return None,
            }
            unit /= 10;
        }
    }
    TimeOfDay::from_hms_nano(pair(0)?, pair(2)?, pair(4)?, nanos)
}

/// The time at which the message was made, which is the first field of nearly all messages.
pub(crate) struct Created;

impl Field for Created {
    type Value = TimeOfDay;
    const FORMATS: &'static [&'static str] = TimeOfDay::FORMATS;
    const RANGE: &'static str = TimeOfDay::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<TimeOfDay, Fault> {
        TimeOfDay::decode(reader)
    }

    fn encode(value: &TimeOfDay, writer: &mut Writer<'_>) -> Result<(), Fault> {
        TimeOfDay::encode(value, writer)
    }

    fn created(value: &TimeOfDay) -> Option<TimeOfDay> {
        Some(*value)
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<TimeOfDay> {
        TimeOfDay::strategy()
    }
}

impl Field for EchoedTime {
    type Value = Self;
    const FORMATS: &'static [&'static str] = TimeOfDay::FORMATS;
    const RANGE: &'static str = TimeOfDay::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        if let Some(time) = take_millis(reader) {
            return Ok(Self::of(time));
        }
        // BPLOG has no time to echo. Most vehicles write `000000.000` then, and some write nothing.
        let text = match reader.trimmed() {
            Err(Fault::Empty) => return Ok(Self::NONE),
            text => text?,
        };
        let time = parse_time(text).ok_or(NOT_A_TIME)?;
        let decimals = text.len().saturating_sub("hhmmss.".len()).min(9);
        Ok(Self::with_decimals(time, decimals as u8))
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        let (hour, minute, second, nanos) = value.time().hms_nano();
        let field = writer.field();
        for pair in [hour, minute, second] {
            field.extend_from_slice(&two_digits(pair));
        }
        let mut rest = nanos;
        let mut unit = 100_000_000;
        for place in 0..value.decimals() {
            if place == 0 {
                field.push(b'.');
            }
            field.push(b'0' + (rest / unit) as u8);
            rest %= unit;
            unit /= 10;
        }
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        (0..86_401_000_000_000u64, 0..=9u8)
            .prop_map(|(nanos, decimals)| {
                let time = TimeOfDay::from_nanos(nanos).expect("within a day and a leap second");
                Self::with_decimals(time, decimals)
            })
            .boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    fn at(hour: u32, minute: u32, second: u32, nanos: u32) -> TimeOfDay {
        TimeOfDay::from_hms_nano(hour, minute, second, nanos).unwrap()
    }

    #[test]
    fn times_with_any_decimals_are_read() {
        for (text, time) in [
            ("081025.987", at(8, 10, 25, 987_000_000)),
            ("081025.987,5", at(8, 10, 25, 987_000_000)),
            ("235960.001,", at(23, 59, 60, 1_000_000)),
            ("081025.9870", at(8, 10, 25, 987_000_000)),
            ("081025", at(8, 10, 25, 0)),
            ("081025.", at(8, 10, 25, 0)),
            (" 081025.9 ", at(8, 10, 25, 900_000_000)),
            ("081025.123456789999", at(8, 10, 25, 123_456_789)),
            ("235960.5", at(23, 59, 60, 500_000_000)),
        ] {
            assert_eq!(read::<TimeOfDay>(text), Ok(time), "{text}");
        }
    }

    #[test]
    fn an_invalid_time_of_day_is_refused() {
        for bad in [
            "8:10:25",
            "81025",
            "240000",
            "08102,.987",
            "081025.9a7",
            "081025.98/",
            "081025:987",
            "240000.000",
            "08102/.987",
            "086000",
            "081060",
            "-81025",
            "081025.x",
            "0810255",
            "é1025",
        ] {
            assert_eq!(read::<TimeOfDay>(bad), Err(NOT_A_TIME), "{bad}");
        }
    }

    proptest::proptest! {
        #[test]
        fn the_fast_reader_agrees_with_the_slow_one(text in "[0-2/][0-9:][0-6][0-9][0-6][0-9][-./0][0-9:]{2}[0-9/]") {
            let short = parse_millis(text.as_bytes().try_into().unwrap());
            proptest::prop_assert_eq!(short, parse_time(text.as_bytes()));
        }
    }

    #[test]
    fn three_decimals_are_written_and_never_rounded_up() {
        assert_eq!(
            written::<TimeOfDay>(&at(23, 59, 59, 999_999_999)).unwrap(),
            ",235959.999"
        );
        assert_eq!(written::<TimeOfDay>(&at(0, 0, 0, 1_000_000)).unwrap(), ",000000.001");
        assert_eq!(written::<TimeOfDay>(&at(23, 59, 60, 0)).unwrap(), ",235960.000");
    }
}

//! The forms that parameters have.

use backseat_units::Utc;

use super::text::{Reader, TextFault, Writer};
use crate::Time7k;

/// How a parameter is read and written.
pub(crate) trait Form {
    type Value;

    /// The format as the specification writes it.
    const FORMAT: &'static str;

    fn read(reader: &mut Reader<'_>) -> Result<Self::Value, TextFault>;

    fn write(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), TextFault>;

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self::Value>;
}

#[cfg(test)]
use proptest::strategy::Strategy as _;

macro_rules! numbers {
    ($( $(#[$doc:meta])* $Form:ident: $Value:ty, $format:literal, $expected:literal; )*) => { $(
        $(#[$doc])*
        pub(crate) enum $Form {}

        impl Form for $Form {
            type Value = $Value;
            const FORMAT: &'static str = $format;

            fn read(reader: &mut Reader<'_>) -> Result<$Value, TextFault> {
                let text = reader.next()?;
                text.parse().map_err(|_| TextFault::expected($expected, text))
            }

            fn write(value: &$Value, writer: &mut Writer<'_>) -> Result<(), TextFault> {
                writer.push(format_args!("{value}"));
                Ok(())
            }

            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<$Value> {
                proptest::arbitrary::any::<$Value>().boxed()
            }
        }
    )* };
}

numbers! {
    /// A number with sign.
    Int: i32, "%d", "a whole number";
    /// A number with sign, as a C `long` of 32 bits.
    Long: i32, "%ld", "a whole number";
    /// A number without sign, as a C `unsigned long` of 32 bits.
    Unsigned: u32, "%lu", "a whole number, 0 or more";
}

/// A sensor's index; -1 is the payload controller.
pub(crate) enum Sensor {}

impl Form for Sensor {
    type Value = crate::SensorIndex;
    const FORMAT: &'static str = "%d";

    fn read(reader: &mut Reader<'_>) -> Result<Self::Value, TextFault> {
        Int::read(reader).map(crate::SensorIndex)
    }

    fn write(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        Int::write(&value.0, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self::Value> {
        Int::strategy().prop_map(crate::SensorIndex).boxed()
    }
}

/// Yes or no: 0 is no, any other number is yes.
pub(crate) enum Flag {}

impl Form for Flag {
    type Value = bool;
    const FORMAT: &'static str = "%d";

    fn read(reader: &mut Reader<'_>) -> Result<bool, TextFault> {
        Int::read(reader).map(|number| number != 0)
    }

    fn write(value: &bool, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        Int::write(&i32::from(*value), writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<bool> {
        proptest::arbitrary::any::<bool>().boxed()
    }
}

/// 1 or 0, where the specification gives these two numbers and no other a meaning.
fn bit(text: &str) -> Result<bool, TextFault> {
    match text.parse() {
        Ok(0_u8) => Ok(false),
        Ok(1) => Ok(true),
        _ => Err(TextFault::expected("0 or 1", text)),
    }
}

macro_rules! bits {
    ($( $(#[$doc:meta])* $Form:ident, $format:literal; )*) => { $(
        $(#[$doc])*
        pub(crate) enum $Form {}

        impl Form for $Form {
            type Value = bool;
            const FORMAT: &'static str = $format;

            fn read(reader: &mut Reader<'_>) -> Result<bool, TextFault> {
                bit(reader.next()?)
            }

            fn write(value: &bool, writer: &mut Writer<'_>) -> Result<(), TextFault> {
                Flag::write(value, writer)
            }

            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<bool> {
                Flag::strategy()
            }
        }
    )* };
}

bits! {
    /// 1 for yes, 0 for no, and nothing else.
    Bit, "%d";
    /// 1 for yes, 0 for no, and nothing else, where the format has `%lu`.
    UnsignedBit, "%lu";
}

macro_rules! decimals {
    ($( $(#[$doc:meta])* $Form:ident, $format:literal, $write:literal, $scale:literal; )*) => { $(
        $(#[$doc])*
        pub(crate) enum $Form {}

        impl Form for $Form {
            type Value = f64;
            const FORMAT: &'static str = $format;

            fn read(reader: &mut Reader<'_>) -> Result<f64, TextFault> {
                let text = reader.next()?;
                let number = text.parse().ok().filter(|number: &f64| number.is_finite());
                number.ok_or_else(|| TextFault::expected("a number", text))
            }

            fn write(value: &f64, writer: &mut Writer<'_>) -> Result<(), TextFault> {
                if !value.is_finite() {
                    return Err(TextFault::expected("a finite number", &value.to_string()));
                }
                writer.push(format_args!("{}", without_negative_zero(&format!($write, value))));
                Ok(())
            }

            /// Numbers that the form's decimals hold.
            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<f64> {
                (-10_000_000_i32..10_000_000).prop_map(|number| f64::from(number) / $scale).boxed()
            }
        }
    )* };
}

decimals! {
    /// Two decimals.
    Hundredths, "%.2f", "{:.2}", 100.0;
    /// Three decimals: megabytes.
    Thousandths, "%0.3lf", "{:.3}", 1000.0;
}

/// A number's text without the sign, if all its digits are 0: a reader takes `-0.00` for a fault.
fn without_negative_zero(text: &str) -> &str {
    let zero = |digits: &&str| digits.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    text.strip_prefix('-').filter(zero).unwrap_or(text)
}

/// A text that may be written: no control characters, and no space at its ends, which readers drop.
fn writable(text: &str) -> Result<&str, TextFault> {
    let fine = !text.contains(char::is_control) && text.trim() == text;
    if fine {
        Ok(text)
    } else {
        Err(TextFault::expected(
            "text without control characters or spaces at its ends",
            text,
        ))
    }
}

/// A text with others behind it: no comma.
pub(crate) enum Word {}

impl Form for Word {
    type Value = Box<str>;
    const FORMAT: &'static str = "%s";

    fn read(reader: &mut Reader<'_>) -> Result<Box<str>, TextFault> {
        reader.next().map(Box::from)
    }

    fn write(value: &Box<str>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        let text = writable(value)?;
        if text.contains(',') {
            return Err(TextFault::expected("text without commas", text));
        }
        writer.push(format_args!("{text}"));
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Box<str>> {
        "[!-+.-~]([ -+.-~]{0,10}[!-+.-~])?".prop_map(Box::from).boxed()
    }
}

/// The last parameter: all that is left, commas too. It may be empty.
pub(crate) enum Last {}

impl Form for Last {
    type Value = Box<str>;
    const FORMAT: &'static str = "%s";

    fn read(reader: &mut Reader<'_>) -> Result<Box<str>, TextFault> {
        Ok(Box::from(reader.rest()))
    }

    fn write(value: &Box<str>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        writer.push(format_args!("{}", writable(value)?));
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Box<str>> {
        "[!-~]([ -~]{0,20}[!-~])?".prop_map(Box::from).boxed()
    }
}

/// The last parameter, which must not be empty.
pub(crate) enum Name {}

impl Form for Name {
    type Value = Box<str>;
    const FORMAT: &'static str = "%s";

    fn read(reader: &mut Reader<'_>) -> Result<Box<str>, TextFault> {
        let text = reader.rest();
        if text.is_empty() {
            Err(TextFault::Missing)
        } else {
            Ok(Box::from(text))
        }
    }

    fn write(value: &Box<str>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        if value.is_empty() {
            return Err(TextFault::Missing);
        }
        Last::write(value, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Box<str>> {
        Last::strategy()
    }
}

/// The last parameter but one: it may hold commas, the one behind it holds none.
pub(crate) enum LastButOne {}

impl Form for LastButOne {
    type Value = Box<str>;
    const FORMAT: &'static str = "%s";

    fn read(reader: &mut Reader<'_>) -> Result<Box<str>, TextFault> {
        reader.all_but_last().map(Box::from)
    }

    fn write(value: &Box<str>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        Last::write(value, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Box<str>> {
        Last::strategy()
    }
}

/// The last parameter, in quotation marks. It is read without them as well.
pub(crate) enum Quoted {}

impl Form for Quoted {
    type Value = Box<str>;
    const FORMAT: &'static str = "\"%s\"";

    fn read(reader: &mut Reader<'_>) -> Result<Box<str>, TextFault> {
        let text = reader.rest();
        let inner = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        Ok(Box::from(inner.unwrap_or(text)))
    }

    fn write(value: &Box<str>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        let text = writable(value)?;
        if text.contains('"') {
            return Err(TextFault::expected("text without quotation marks", text));
        }
        writer.push(format_args!("\"{text}\""));
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Box<str>> {
        "[#-~]([#-~ ]{0,20}[#-~])?".prop_map(Box::from).boxed()
    }
}

/// A version as the payload controller writes it: X.YYZZ is major X, minor YY, maintenance ZZ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct PlcVersion {
    /// Major.
    pub major: u32,
    /// Minor, 0 to 99.
    pub minor: u8,
    /// Maintenance, 0 to 99.
    pub maintenance: u8,
}

impl core::fmt::Display for PlcVersion {
    /// `1.02.03`, as the specification says that it is to be interpreted.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}.{:02}.{:02}", self.major, self.minor, self.maintenance)
    }
}

/// A version.
pub(crate) enum Version {}

impl Form for Version {
    type Value = PlcVersion;
    const FORMAT: &'static str = "%0.4f";

    fn read(reader: &mut Reader<'_>) -> Result<PlcVersion, TextFault> {
        let text = reader.next()?;
        let version = || {
            let (major, rest) = text.split_once('.').unwrap_or((text, ""));
            let digits = rest.len() <= 4 && rest.bytes().all(|byte| byte.is_ascii_digit());
            let number: u32 = digits.then(|| format!("{rest:0<4}").parse().ok())??;
            Some(PlcVersion {
                major: major.parse().ok()?,
                minor: u8::try_from(number / 100).ok()?,
                maintenance: u8::try_from(number % 100).ok()?,
            })
        };
        version().ok_or_else(|| TextFault::expected("a version of the form 1.0203", text))
    }

    fn write(value: &PlcVersion, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        if value.minor > 99 || value.maintenance > 99 {
            return Err(TextFault::expected(
                "minor and maintenance numbers of at most 99",
                &value.to_string(),
            ));
        }
        writer.push(format_args!(
            "{}.{:02}{:02}",
            value.major, value.minor, value.maintenance
        ));
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<PlcVersion> {
        (0..1000_u32, 0..100_u8, 0..100_u8)
            .prop_map(|(major, minor, maintenance)| PlcVersion {
                major,
                minor,
                maintenance,
            })
            .boxed()
    }
}

/// A calendar time, as the command "time sync" has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct CalendarTime {
    /// The year, 0 to 9999.
    pub year: u16,
    /// The month, 1 to 12.
    pub month: u8,
    /// The day of the month, 1 to 31.
    pub day: u8,
    /// Hours, 0 to 23.
    pub hour: u8,
    /// Minutes, 0 to 59.
    pub minute: u8,
    /// Seconds in units of 10 microseconds, 0 to 6,099,999.
    pub second_10us: u32,
}

impl CalendarTime {
    /// The time of an instant, rounded down to 10 microseconds.
    #[must_use]
    pub fn from_utc(utc: Utc) -> Self {
        let time = Time7k::from_utc(utc);
        let (month, day) = month_and_day(time.year, time.day);
        let in_minute = utc.as_unix_nanos() % 60_000_000_000;
        Self {
            year: time.year,
            month,
            day,
            hour: time.hours,
            minute: time.minutes,
            second_10us: u32::try_from(in_minute / 10_000).unwrap_or(0),
        }
    }

    /// The instant; `None` if there is no such day or time, or before 1970.
    #[must_use]
    pub fn to_utc(&self) -> Option<Utc> {
        let length = *month_lengths(self.year).get(usize::from(self.month.checked_sub(1)?))?;
        if self.day == 0 || u16::from(self.day) > length || self.second_10us >= 6_100_000 {
            return None;
        }
        let before: u16 = month_lengths(self.year)[..usize::from(self.month - 1)].iter().sum();
        let day = before + u16::from(self.day);
        let minute = Time7k {
            year: self.year,
            day,
            seconds: 0.0,
            hours: self.hour,
            minutes: self.minute,
        }
        .to_utc()?;
        Some(Utc::from_unix_nanos(
            minute.as_unix_nanos() + u64::from(self.second_10us) * 10_000,
        ))
    }
}

const fn month_lengths(year: u16) -> [u16; 12] {
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
}

/// Month and day of a day of the year.
fn month_and_day(year: u16, day_of_year: u16) -> (u8, u8) {
    let mut left = day_of_year;
    for (month, length) in (1..).zip(month_lengths(year)) {
        if left <= length {
            return (month, u8::try_from(left).unwrap_or(0));
        }
        left -= length;
    }
    (12, 31)
}

/// A calendar time: two parameters, the date and the time of day.
pub(crate) enum Calendar {}

impl Form for Calendar {
    type Value = CalendarTime;
    const FORMAT: &'static str = "%04u/%02u/%02u,%02u:%02u:%08.5f";

    fn read(reader: &mut Reader<'_>) -> Result<CalendarTime, TextFault> {
        let (date, time) = (reader.next()?, reader.next()?);
        let parse = || {
            let mut date = date.split('/');
            let mut time = time.split(':');
            let calendar = CalendarTime {
                year: date.next()?.parse().ok()?,
                month: date.next()?.parse().ok()?,
                day: date.next()?.parse().ok()?,
                hour: time.next()?.parse().ok()?,
                minute: time.next()?.parse().ok()?,
                second_10us: seconds(time.next()?)?,
            };
            let whole = date.next().is_none() && time.next().is_none();
            Some(calendar).filter(|calendar| whole && calendar.to_utc().is_some())
        };
        let expected = "a date and time that exist, of the form 2026/11/23,14:05:07.25000";
        parse().ok_or_else(|| TextFault::expected(expected, &format!("{date},{time}")))
    }

    fn write(value: &CalendarTime, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        if value.to_utc().is_none() {
            return Err(TextFault::expected("a date and time that exist", &format!("{value:?}")));
        }
        let CalendarTime {
            year,
            month,
            day,
            hour,
            minute,
            second_10us,
        } = value;
        let (second, decimals) = (second_10us / 100_000, second_10us % 100_000);
        writer.push(format_args!(
            "{year:04}/{month:02}/{day:02},{hour:02}:{minute:02}:{second:02}.{decimals:05}"
        ));
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<CalendarTime> {
        (0..400_000_000_000_000_u64)
            .prop_map(|number| CalendarTime::from_utc(Utc::from_unix_nanos(number * 10_000)))
            .boxed()
    }
}

/// Seconds in units of 10 microseconds; further decimals are cut.
fn seconds(text: &str) -> Option<u32> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
    if !decimals.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let decimals: String = decimals.chars().chain("00000".chars()).take(5).collect();
    whole
        .parse::<u32>()
        .ok()?
        .checked_mul(100_000)?
        .checked_add(decimals.parse().ok()?)
}

/// One entry of a list: its own words before its parameters, and these.
pub(crate) trait Item: Sized {
    /// The format of an entry.
    const FORMAT: &'static str;

    fn read(reader: &mut Reader<'_>) -> Result<Self, TextFault>;

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), TextFault>;

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self>;
}

/// A count and so many entries.
pub(crate) struct Each<T>(core::marker::PhantomData<T>);

impl<T: Item> Form for Each<T>
where
    T: core::fmt::Debug + 'static,
{
    type Value = Vec<T>;
    const FORMAT: &'static str = T::FORMAT;

    fn read(reader: &mut Reader<'_>) -> Result<Vec<T>, TextFault> {
        let count = Unsigned::read(reader)?;
        // The list is as long as its text, whatever its count says.
        let mut entries = Vec::new();
        for _ in 0..count {
            entries.push(T::read(reader)?);
        }
        Ok(entries)
    }

    fn write(value: &Vec<T>, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        writer.push(format_args!("{}", value.len()));
        value.iter().try_for_each(|entry| entry.write(writer))
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Vec<T>> {
        proptest::collection::vec(T::strategy(), 0..5).boxed()
    }
}

use core::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::error::{WorldError, check};
use crate::stream::Stream;

/// A number of the configuration: either fixed, such as `3.5`, or a range such as `[2.0, 5.0]`, from which the seed
/// draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    least: f64,
    most: f64,
}

impl Span {
    /// A fixed number.
    #[must_use]
    pub const fn fixed(value: f64) -> Self {
        Self {
            least: value,
            most: value,
        }
    }

    /// A range from `least` to `most`.
    #[must_use]
    pub const fn between(least: f64, most: f64) -> Self {
        Self { least, most }
    }

    /// The least value that may be drawn.
    #[must_use]
    pub const fn least(self) -> f64 {
        self.least
    }

    /// The greatest value that may be drawn.
    #[must_use]
    pub const fn most(self) -> f64 {
        self.most
    }

    /// Draws a value, uniformly. It takes one number from the stream even if the value is fixed, so later draws do not
    /// depend on that.
    pub fn draw(self, stream: &mut Stream) -> f64 {
        stream.uniform_in(self.least, self.most)
    }

    /// Rejects a span that exceeds the range of its key.
    pub(crate) fn within(
        self,
        least: f64,
        most: f64,
        key: &'static str,
        expected: &'static str,
    ) -> Result<(), WorldError> {
        check(self.least >= least && self.least <= most, key, self.least, expected)?;
        check(self.most >= self.least && self.most <= most, key, self.most, expected)
    }
}

impl<'de> Deserialize<'de> for Span {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpanVisitor)
    }
}

struct SpanVisitor;

impl<'de> Visitor<'de> for SpanVisitor {
    type Value = Span;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a finite number, or two of them as [least, most]")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Span, E> {
        if value.is_finite() {
            Ok(Span::fixed(value))
        } else {
            Err(E::custom("expected a finite number"))
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Span, E> {
        Ok(Span::fixed(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Span, E> {
        Ok(Span::fixed(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Span, A::Error> {
        let least: f64 = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(0, &self))?;
        let most: f64 = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(1, &self))?;
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::invalid_length(3, &self));
        }
        if least.is_finite() && most.is_finite() && least <= most {
            Ok(Span { least, most })
        } else {
            Err(A::Error::custom(format!(
                "expected [least, most], found [{least}, {most}]"
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::Span;

    #[derive(Debug, Deserialize)]
    struct Holder {
        key: Span,
    }

    #[test]
    fn a_span_is_one_number_or_two() {
        let parse = |text: &str| toml::from_str::<Holder>(text).map(|holder| holder.key);
        assert_eq!(parse("key = 3").unwrap(), Span::fixed(3.0));
        assert_eq!(parse("key = 3.5").unwrap(), Span::fixed(3.5));
        assert_eq!(parse("key = [1, 2.5]").unwrap(), Span::between(1.0, 2.5));
        for bad in [
            "key = [2, 1]",
            "key = [1]",
            "key = [1, 2, 3]",
            "key = nan",
            "key = [0, inf]",
            "key = \"3\"",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }
}

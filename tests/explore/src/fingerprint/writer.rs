//! The serializer that makes a fingerprint.

use std::fmt::{self, Display};
use std::str::FromStr;

use backseat_units::{TimeOfDay, Timestamp, Utc};
use serde::Serialize;
use serde::ser::{
    Error, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple, SerializeTupleStruct,
    SerializeTupleVariant, Serializer,
};

use super::rules::{RULES, Rule, Treatment, of};
use super::{AGE_MAX_S, Fingerprint};

const FIRST: u64 = 0x9E37_79B9_7F4A_7C15;
const SECOND: u64 = 0xD6E8_FEB8_6659_FD93;
const CELL_M: f64 = 250.0;
const AGE_MAX_NANOS: i64 = AGE_MAX_S as i64 * 1_000_000_000;

/// Eats a state, value by value.
pub(super) struct Writer {
    lanes: [u64; 2],
    now: Timestamp,
    time_of_day: TimeOfDay,
    /// What becomes of the next number.
    treatment: Option<Treatment>,
    /// The next number is a timestamp's.
    is_time: bool,
    requests: Vec<u64>,
    identifiers: Vec<u64>,
    tags: Vec<u64>,
    pub(super) met: [bool; RULES.len()],
    /// Every word that was eaten, with the names of the fields that lead to it, where somebody wants to read them.
    pub(super) parts: Option<Vec<String>>,
    path: Vec<&'static str>,
}

/// The 128 bits of the product, folded: every bit of both goes into every bit of it.
const fn fold(a: u64, b: u64) -> u64 {
    let product = a as u128 * b as u128;
    product as u64 ^ (product >> 64) as u64
}

/// What a serializer of this crate cannot meet.
#[derive(Debug)]
pub(super) enum Never {}

impl Display for Never {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {}
    }
}

impl std::error::Error for Never {}

impl Error for Never {
    fn custom<T: Display>(message: T) -> Self {
        panic!("core's state cannot be written: {message}")
    }
}

impl Writer {
    pub(super) fn new(now: Timestamp, utc: Utc) -> Self {
        Self {
            lanes: [FIRST, SECOND],
            now,
            time_of_day: utc.time_of_day(),
            treatment: None,
            is_time: false,
            requests: Vec::new(),
            identifiers: Vec::new(),
            tags: Vec::new(),
            met: [false; RULES.len()],
            parts: None,
            path: Vec::new(),
        }
    }

    pub(super) const fn finish(&self) -> Fingerprint {
        let [a, b] = self.lanes;
        (fold(a ^ b.rotate_left(32), FIRST) as u128) << 64 | fold(b ^ SECOND, a | 1) as u128
    }

    fn word(&mut self, word: u64) {
        if let Some(parts) = &mut self.parts {
            parts.push(format!("{} {:#x}", self.path.join("."), word));
        }
        let [a, b] = self.lanes;
        self.lanes = [
            fold(a ^ word, FIRST).wrapping_add(b),
            fold(b ^ word.rotate_left(29), SECOND) ^ a.rotate_left(17),
        ];
    }

    fn text(&mut self, text: &str) {
        self.word(text.len() as u64);
        for chunk in text.as_bytes().chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.word(u64::from_le_bytes(word));
        }
    }

    /// So many nanoseconds from now.
    fn nanos_ahead(&mut self, nanos: i64) {
        let most = match self.treatment {
            Some(Treatment::Within(seconds)) => seconds as i64 * 1_000_000_000,
            _ => AGE_MAX_NANOS,
        };
        self.word(nanos.max(-most) as u64);
    }

    fn timestamp(&mut self, at: Timestamp) {
        if at == Timestamp::MAX {
            return self.word(u64::MAX);
        }
        let ahead = at.since(self.now).as_nanos() as i64;
        let ago = self.now.since(at).as_nanos() as i64;
        self.nanos_ahead(ahead - ago);
    }

    fn number(&mut self, number: u64) {
        if std::mem::take(&mut self.is_time) {
            return self.timestamp(Timestamp::from_nanos(number));
        }
        let names = match self.treatment {
            Some(Treatment::Request) => &mut self.requests,
            Some(Treatment::Identifier) => &mut self.identifiers,
            Some(Treatment::Tag) => &mut self.tags,
            _ => return self.word(number),
        };
        let place = names.iter().position(|known| *known == number).unwrap_or_else(|| {
            names.push(number);
            names.len() - 1
        });
        self.word(place as u64);
    }

    fn figure(&mut self, figure: f64) {
        let figure = match self.treatment {
            Some(Treatment::Cell) => (figure / CELL_M).round(),
            Some(Treatment::Thousandth) => (figure * 1e3).round(),
            Some(Treatment::Tenth) => (figure * 10.0).round(),
            Some(Treatment::SecondsAgo) => {
                let ago_s = self.now.as_secs_f64() - figure;
                (ago_s.min(AGE_MAX_S as f64) * 1e6).round()
            }
            _ => figure,
        };
        // Zero has two signs.
        self.word((figure + 0.0).to_bits());
    }

    /// A value of its own: what is outside of it has no say in it.
    fn inner<T: Serialize + ?Sized>(&mut self, treatment: Option<Treatment>, value: &T) -> Result<(), Never> {
        let outer = std::mem::replace(&mut self.treatment, treatment);
        let written = value.serialize(&mut *self);
        self.treatment = outer;
        written
    }

    fn variant<T: Serialize + ?Sized>(
        &mut self,
        name: &str,
        variant: &str,
        index: u32,
        value: &T,
    ) -> Result<(), Never> {
        self.word(u64::from(index));
        let (first, rules) = of(name);
        match rules.iter().position(|rule| rule.field == variant) {
            Some(place) => {
                self.met[first + place] = true;
                self.inner(Some(rules[place].treatment), value)
            }
            None => self.inner(None, value),
        }
    }
}

/// A struct's fields, and the rules of its type.
pub(super) struct Fields<'w> {
    writer: &'w mut Writer,
    first: usize,
    rules: &'static [Rule],
}

impl Fields<'_> {
    fn field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
        let rule = self.rules.iter().position(|rule| rule.field == name);
        let treatment = rule.map(|place| {
            self.writer.met[self.first + place] = true;
            self.rules[place].treatment
        });
        match treatment {
            Some(Treatment::Leave) => Ok(()),
            other => {
                self.writer.path.push(name);
                let written = self.writer.inner(other, value);
                self.writer.path.pop();
                written
            }
        }
    }
}

impl SerializeStruct for Fields<'_> {
    type Ok = ();
    type Error = Never;
    fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
        self.field(name, value)
    }
    fn end(self) -> Result<(), Never> {
        Ok(())
    }
}

impl SerializeStructVariant for Fields<'_> {
    type Ok = ();
    type Error = Never;
    fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Result<(), Never> {
        self.field(name, value)
    }
    fn end(self) -> Result<(), Never> {
        Ok(())
    }
}

/// Several values: each is announced, so that where they end is told too.
pub(super) struct Values<'w>(&'w mut Writer);

impl Values<'_> {
    fn value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        self.0.word(1);
        value.serialize(&mut *self.0)
    }

    fn over(self) {
        self.0.word(0);
    }
}

macro_rules! values {
    ($($kind:ident $method:ident),*) => {
        $(impl $kind for Values<'_> {
            type Ok = ();
            type Error = Never;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
                self.value(value)
            }
            fn end(self) -> Result<(), Never> {
                self.over();
                Ok(())
            }
        })*
    };
}

values!(SerializeSeq serialize_element, SerializeTuple serialize_element, SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field);

impl SerializeMap for Values<'_> {
    type Ok = ();
    type Error = Never;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Never> {
        self.value(key)
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Never> {
        value.serialize(&mut *self.0)
    }
    fn end(self) -> Result<(), Never> {
        self.over();
        Ok(())
    }
}

macro_rules! numbers {
    ($($method:ident $number:ty),*) => {
        $(fn $method(self, number: $number) -> Result<(), Never> {
            self.number(number as u64);
            Ok(())
        })*
    };
}

impl<'w> Serializer for &'w mut Writer {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = Values<'w>;
    type SerializeTuple = Values<'w>;
    type SerializeTupleStruct = Values<'w>;
    type SerializeTupleVariant = Values<'w>;
    type SerializeMap = Values<'w>;
    type SerializeStruct = Fields<'w>;
    type SerializeStructVariant = Fields<'w>;

    numbers!(serialize_bool bool, serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64,
        serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, serialize_char char);

    fn serialize_f32(self, figure: f32) -> Result<(), Never> {
        self.figure(f64::from(figure));
        Ok(())
    }

    fn serialize_f64(self, figure: f64) -> Result<(), Never> {
        self.figure(figure);
        Ok(())
    }

    fn serialize_str(self, text: &str) -> Result<(), Never> {
        self.text(text);
        Ok(())
    }

    fn serialize_bytes(self, bytes: &[u8]) -> Result<(), Never> {
        self.text(&String::from_utf8_lossy(bytes));
        Ok(())
    }

    fn collect_str<T: Display + ?Sized>(self, value: &T) -> Result<(), Never> {
        let text = value.to_string();
        match TimeOfDay::from_str(&text) {
            Ok(time) => self.nanos_ahead(time.nanos_since(self.time_of_day)),
            Err(_) => self.text(&text),
        }
        Ok(())
    }

    fn serialize_none(self) -> Result<(), Never> {
        self.word(2);
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Never> {
        self.word(3);
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Never> {
        self.word(4);
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Never> {
        self.serialize_unit()
    }

    fn serialize_unit_variant(self, _: &'static str, index: u32, _: &'static str) -> Result<(), Never> {
        self.word(u64::from(index));
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, name: &'static str, value: &T) -> Result<(), Never> {
        match name {
            "Timestamp" => {
                self.is_time = true;
                value.serialize(self)
            }
            // What time it is is told by nothing but the clock that all is relative to.
            "Utc" => Ok(()),
            _ => value.serialize(self),
        }
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Never> {
        self.variant(name, variant, index, value)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Values<'w>, Never> {
        Ok(Values(self))
    }

    fn serialize_tuple(self, _: usize) -> Result<Values<'w>, Never> {
        Ok(Values(self))
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Values<'w>, Never> {
        Ok(Values(self))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Values<'w>, Never> {
        self.word(u64::from(index));
        Ok(Values(self))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Values<'w>, Never> {
        Ok(Values(self))
    }

    fn serialize_struct(self, name: &'static str, _: usize) -> Result<Fields<'w>, Never> {
        let (first, rules) = of(name);
        Ok(Fields {
            writer: self,
            first,
            rules,
        })
    }

    fn serialize_struct_variant(
        self,
        name: &'static str,
        index: u32,
        _: &'static str,
        fields: usize,
    ) -> Result<Fields<'w>, Never> {
        self.word(u64::from(index));
        self.serialize_struct(name, fields)
    }
}

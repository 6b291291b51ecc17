use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer, MapAccess, SeqAccess, VariantAccess,
    Visitor,
};
use serde::forward_to_deserialize_any;
use serde_json::{Error, Map, Value};

use super::{IS, ITEMS, SPECIAL, variant_name};

/// A value as it was written.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    content: Content<'a>,
    /// The object that has the value, and the value's name in it; `None` for an element of a list.
    within: Option<(&'a Map<String, Value>, &'a str)>,
}

#[derive(Clone, Copy)]
enum Content<'a> {
    Absent,
    Value(&'a Value),
    /// A number that JSON cannot express.
    Special(f64),
}

/// The number of this name.
fn special(name: &Value) -> Option<f64> {
    match name.as_str()? {
        "nan" => Some(f64::NAN),
        "inf" => Some(f64::INFINITY),
        "-inf" => Some(f64::NEG_INFINITY),
        _ => None,
    }
}

impl<'a> Node<'a> {
    /// The property of this name, which may be absent.
    pub(super) fn property(object: &'a Map<String, Value>, key: &str) -> Self {
        if let Some((key, value)) = object.get_key_value(key) {
            return Self {
                content: Content::Value(value),
                within: Some((object, key)),
            };
        }
        let figure = object.get(&format!("{key}{SPECIAL}")).and_then(special);
        Self {
            content: figure.map_or(Content::Absent, Content::Special),
            within: None,
        }
    }

    const fn element(value: &'a Value) -> Self {
        Self {
            content: Content::Value(value),
            within: None,
        }
    }

    fn object(self) -> Result<&'a Map<String, Value>, Error> {
        match self.content {
            Content::Value(Value::Object(object)) => Ok(object),
            Content::Value(_) | Content::Absent | Content::Special(_) => Err(Error::custom("expected an object")),
        }
    }

    fn list(self) -> Result<&'a [Value], Error> {
        match self.content {
            Content::Value(Value::Array(list)) => Ok(list),
            Content::Value(Value::Object(object)) => match object.get(ITEMS) {
                Some(Value::Array(list)) => Ok(list),
                _ => Err(Error::custom("expected a list")),
            },
            Content::Value(_) | Content::Absent | Content::Special(_) => Err(Error::custom("expected a list")),
        }
    }

    /// The variant's name and content.
    fn variant(self) -> Result<(&'a str, Self), Error> {
        let (object, key) = match (self.content, self.within) {
            (Content::Value(Value::String(_)), Some(within)) => within,
            _ => (self.object()?, IS),
        };
        let name = object.get(key).and_then(Value::as_str);
        let name = name.ok_or_else(|| Error::custom("expected the name of a variant"))?;
        Ok((name, Self::property(object, &format!("{key}_{name}"))))
    }
}

impl<'de> Deserializer<'de> for Node<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.content {
            Content::Absent => Err(Error::custom("missing")),
            Content::Special(figure) => visitor.visit_f64(figure),
            Content::Value(Value::Array(_)) => self.deserialize_seq(visitor),
            Content::Value(Value::Object(_)) => self.deserialize_map(visitor),
            Content::Value(value) => value.deserialize_any(visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.content {
            Content::Absent => visitor.visit_none(),
            Content::Special(_) | Content::Value(_) => visitor.visit_some(self),
        }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(Elements(self.list()?))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, places: usize, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(Numbered {
            object: self.object()?,
            next: 1,
            places,
        })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        places: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(places, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let object = self.object()?;
        visitor.visit_map(Properties {
            object,
            left: object.iter(),
            value: None,
        })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let (name, content) = self.variant()?;
        let known = variants.iter().find(|variant| variant_name(variant) == name);
        visitor.visit_enum(Variant {
            name: known.map_or(name, |known| known),
            content,
        })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf identifier ignored_any
    }
}

struct Elements<'a>(&'a [Value]);

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        let Some((first, rest)) = self.0.split_first() else {
            return Ok(None);
        };
        self.0 = rest;
        seed.deserialize(Node::element(first)).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// A tuple.
struct Numbered<'a> {
    object: &'a Map<String, Value>,
    next: usize,
    places: usize,
}

impl<'de> SeqAccess<'de> for Numbered<'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        if self.next > self.places {
            return Ok(None);
        }
        let node = Node::property(self.object, &self.next.to_string());
        self.next += 1;
        seed.deserialize(node).map(Some)
    }
}

struct Properties<'a> {
    object: &'a Map<String, Value>,
    left: serde_json::map::Iter<'a>,
    value: Option<Node<'a>>,
}

impl<'de> MapAccess<'de> for Properties<'de> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Error> {
        let Some((key, value)) = self.left.next() else {
            return Ok(None);
        };
        let figure = key.strip_suffix(SPECIAL).zip(special(value));
        let (key, content) = match figure {
            Some((key, figure)) => (key, Content::Special(figure)),
            None => (key.as_str(), Content::Value(value)),
        };
        self.value = Some(Node {
            content,
            within: Some((self.object, key)),
        });
        let key: StrDeserializer<'_, Error> = key.into_deserializer();
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        let node = self
            .value
            .take()
            .ok_or_else(|| Error::custom("a value without a key"))?;
        seed.deserialize(node)
    }
}

struct Variant<'a> {
    name: &'a str,
    content: Node<'a>,
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Error;
    type Variant = Node<'de>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Node<'de>), Error> {
        let name: StrDeserializer<'_, Error> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self.content))
    }
}

impl<'de> VariantAccess<'de> for Node<'de> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, places: usize, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_tuple(places, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Error> {
        self.deserialize_map(visitor)
    }
}

use serde::ser::{
    Error as _, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};
use serde_json::{Error, Value};

use super::{IS, ITEMS, SPECIAL, variant_name};

/// Writes one value.
pub(crate) struct Writer<'a> {
    out: &'a mut Vec<u8>,
    place: Place<'a>,
}

/// Where the value stands.
enum Place<'a> {
    /// In a list, or alone.
    Element,
    /// In an object, by this name.
    Property { empty: &'a mut bool, key: &'a str },
}

impl<'a> Writer<'a> {
    pub(super) fn element(out: &'a mut Vec<u8>) -> Self {
        Self {
            out,
            place: Place::Element,
        }
    }

    fn property(out: &'a mut Vec<u8>, empty: &'a mut bool, key: &'a str) -> Self {
        Self {
            out,
            place: Place::Property { empty, key },
        }
    }

    /// Writes the property's name, if it has one; the value comes next.
    fn begin(self) -> &'a mut Vec<u8> {
        if let Place::Property { empty, key } = self.place {
            write_key(self.out, empty, key, "");
        }
        self.out
    }

    fn scalar(self, value: &impl Serialize) -> Result<(), Error> {
        serde_json::to_writer(self.begin(), value)
    }

    fn figure(self, figure: f64, value: &impl Serialize) -> Result<(), Error> {
        if figure.is_finite() {
            return self.scalar(value);
        }
        let name = if figure.is_nan() {
            "nan"
        } else if figure > 0.0 {
            "inf"
        } else {
            "-inf"
        };
        match self.place {
            Place::Property { empty, key } => {
                write_key(self.out, empty, key, SPECIAL);
                serde_json::to_writer(self.out, name)
            }
            // No list of core's has such numbers: samples of pings are whole numbers or means of these.
            Place::Element => serde_json::to_writer(self.out, &0),
        }
    }

    fn object(self) -> Object<'a> {
        let out = self.begin();
        out.push(b'{');
        Object::new(out, "}")
    }

    /// Writes the variant's name. Its content comes next, in an object of its own.
    fn variant_object(self, variant: &str) -> Object<'a> {
        let name = variant_name(variant);
        let (out, key, close) = match self.place {
            Place::Property { empty, key } => {
                write_name(self.out, empty, key, &name);
                (self.out, key, "}")
            }
            Place::Element => {
                self.out.push(b'{');
                write_name(self.out, &mut true, IS, &name);
                (self.out, IS, "}}")
            }
        };
        write_key(out, &mut false, key, &format!("_{name}"));
        out.push(b'{');
        Object::new(out, close)
    }
}

/// Writes `"key" + suffix:` after a comma, if one is due.
fn write_key(out: &mut Vec<u8>, empty: &mut bool, key: &str, suffix: &str) {
    if !std::mem::replace(empty, false) {
        out.push(b',');
    }
    if key.bytes().all(|byte| byte >= b' ' && byte != b'"' && byte != b'\\') {
        out.push(b'"');
        out.extend_from_slice(key.as_bytes());
        out.extend_from_slice(suffix.as_bytes());
        out.push(b'"');
    } else {
        serde_json::to_writer(&mut *out, &format!("{key}{suffix}")).expect("a Vec takes everything");
    }
    out.push(b':');
}

/// Writes which variant it is.
fn write_name(out: &mut Vec<u8>, empty: &mut bool, key: &str, name: &str) {
    write_key(out, empty, key, "");
    out.push(b'"');
    out.extend_from_slice(name.as_bytes());
    out.push(b'"');
}

macro_rules! scalars {
    ($($method:ident $type:ty),*) => {
        $(fn $method(self, value: $type) -> Result<(), Error> { self.scalar(&value) })*
    };
}

impl<'a> Serializer for Writer<'a> {
    type Ok = ();
    type Error = Error;
    type SerializeSeq = List<'a>;
    type SerializeTuple = Object<'a>;
    type SerializeTupleStruct = Object<'a>;
    type SerializeTupleVariant = Object<'a>;
    type SerializeMap = Object<'a>;
    type SerializeStruct = Object<'a>;
    type SerializeStructVariant = Object<'a>;

    scalars! {
        serialize_bool bool, serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64,
        serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, serialize_char char,
        serialize_str &str
    }

    fn serialize_f32(self, value: f32) -> Result<(), Error> {
        self.figure(value.into(), &value)
    }

    fn serialize_f64(self, value: f64) -> Result<(), Error> {
        self.figure(value, &value)
    }

    fn serialize_bytes(self, bytes: &[u8]) -> Result<(), Error> {
        bytes.serialize(self)
    }

    fn serialize_none(self) -> Result<(), Error> {
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), Error> {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Error> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Result<(), Error> {
        let name = variant_name(variant);
        match self.place {
            Place::Property { empty, key } => write_name(self.out, empty, key, &name),
            Place::Element => {
                self.out.push(b'{');
                write_name(self.out, &mut true, IS, &name);
                self.out.push(b'}');
            }
        }
        Ok(())
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, _: &'static str, value: &T) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Error> {
        let name = variant_name(variant);
        match self.place {
            Place::Property { empty, key } => {
                write_name(self.out, empty, key, &name);
                value.serialize(Writer::property(self.out, empty, &format!("{key}_{name}")))
            }
            Place::Element => {
                self.out.push(b'{');
                let mut empty = true;
                write_name(self.out, &mut empty, IS, &name);
                value.serialize(Writer::property(self.out, &mut empty, &format!("{IS}_{name}")))?;
                self.out.push(b'}');
                Ok(())
            }
        }
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<List<'a>, Error> {
        let close = match self.place {
            Place::Property { .. } => "]",
            Place::Element => "]}",
        };
        let in_list = matches!(self.place, Place::Element);
        let out = self.begin();
        if in_list {
            out.push(b'{');
            write_key(out, &mut true, ITEMS, "");
        }
        out.push(b'[');
        Ok(List {
            out,
            empty: true,
            close,
        })
    }

    fn serialize_tuple(self, _: usize) -> Result<Object<'a>, Error> {
        Ok(self.object())
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Object<'a>, Error> {
        Ok(self.object())
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Object<'a>, Error> {
        Ok(self.variant_object(variant))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Object<'a>, Error> {
        Ok(self.object())
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Object<'a>, Error> {
        Ok(self.object())
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Object<'a>, Error> {
        Ok(self.variant_object(variant))
    }
}

/// An object that is being written.
pub(crate) struct Object<'a> {
    out: &'a mut Vec<u8>,
    empty: bool,
    close: &'static str,
    /// The key of a map whose value comes next.
    key: String,
    /// The place in a tuple, from 1.
    place: usize,
}

impl<'a> Object<'a> {
    fn new(out: &'a mut Vec<u8>, close: &'static str) -> Self {
        Self {
            out,
            empty: true,
            close,
            key: String::new(),
            place: 0,
        }
    }

    fn put<T: ?Sized + Serialize>(&mut self, key: &str, value: &T) -> Result<(), Error> {
        value.serialize(Writer::property(self.out, &mut self.empty, key))
    }

    fn put_next<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), Error> {
        self.place += 1;
        self.put(&self.place.to_string(), value)
    }

    fn close(self) -> Result<(), Error> {
        self.out.extend_from_slice(self.close.as_bytes());
        Ok(())
    }
}

macro_rules! objects {
    (named $($trait:ident),*) => {
        $(impl $trait for Object<'_> {
            type Ok = ();
            type Error = Error;

            fn serialize_field<T: ?Sized + Serialize>(&mut self, key: &'static str, value: &T) -> Result<(), Error> {
                self.put(key, value)
            }

            fn end(self) -> Result<(), Error> {
                self.close()
            }
        })*
    };
    (numbered $($trait:ident $method:ident),*) => {
        $(impl $trait for Object<'_> {
            type Ok = ();
            type Error = Error;

            fn $method<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), Error> {
                self.put_next(value)
            }

            fn end(self) -> Result<(), Error> {
                self.close()
            }
        })*
    };
}

objects! { named SerializeStruct, SerializeStructVariant }
objects! {
    numbered SerializeTuple serialize_element, SerializeTupleStruct serialize_field,
    SerializeTupleVariant serialize_field
}

impl SerializeMap for Object<'_> {
    type Ok = ();
    type Error = Error;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, key: &T) -> Result<(), Error> {
        let Value::String(key) = serde_json::to_value(key)? else {
            return Err(Error::custom("key must be a string"));
        };
        self.key = key;
        Ok(())
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), Error> {
        let key = std::mem::take(&mut self.key);
        self.put(&key, value)
    }

    fn end(self) -> Result<(), Error> {
        self.close()
    }
}

/// A list that is being written.
pub(crate) struct List<'a> {
    out: &'a mut Vec<u8>,
    empty: bool,
    close: &'static str,
}

impl SerializeSeq for List<'_> {
    type Ok = ();
    type Error = Error;

    fn serialize_element<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), Error> {
        let before = self.out.len();
        if !self.empty {
            self.out.push(b',');
        }
        let begun = self.out.len();
        value.serialize(Writer::element(self.out))?;
        if self.out.len() == begun {
            // The element is absent.
            self.out.truncate(before);
        } else {
            self.empty = false;
        }
        Ok(())
    }

    fn end(self) -> Result<(), Error> {
        self.out.extend_from_slice(self.close.as_bytes());
        Ok(())
    }
}

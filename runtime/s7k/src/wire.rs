//! Values of fixed size, as they lie in a 7k record: little-endian and packed.

use serde::Serialize;

/// A value that takes the same number of bytes in every record.
///
/// Reading accepts every bit pattern, and writing gives the same bytes again. That is what lets a record be rewritten
/// byte for byte: a value outside its range is reported by [`crate::Layout`]'s audit, not changed.
pub(crate) trait Wire: Sized {
    /// How many bytes the value takes.
    const SIZE: usize;

    /// The type as the specification writes it: `u32`, `u8 * 3`.
    const TYPE: &'static str;

    /// Reads the value from exactly [`Self::SIZE`] bytes.
    fn get(bytes: &[u8]) -> Self;

    /// Appends exactly [`Self::SIZE`] bytes.
    fn put(&self, out: &mut Vec<u8>);

    /// The value as a number, to compare it with its range; `None` for values that are no numbers.
    fn number(&self) -> Option<f64> {
        None
    }

    /// False if the value is a code that the specification does not name, or a time that no clock shows.
    fn is_known(&self) -> bool {
        true
    }
}

macro_rules! numbers {
    ($($number:ty),*) => { $(
        impl Wire for $number {
            const SIZE: usize = size_of::<$number>();
            const TYPE: &'static str = stringify!($number);

            fn get(bytes: &[u8]) -> Self {
                let mut array = [0; size_of::<$number>()];
                array.copy_from_slice(bytes);
                Self::from_le_bytes(array)
            }

            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            #[allow(clippy::allow_attributes, clippy::cast_lossless, clippy::cast_precision_loss, reason = "one macro for all widths")]
            fn number(&self) -> Option<f64> {
                Some(*self as f64)
            }
        }
    )* };
}

numbers!(u8, u16, u32, u64, i8, i16, i32, f32, f64);

/// Bytes that the specification reserves. They are kept as they are; we write zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reserved<const N: usize>(pub [u8; N]);

impl<const N: usize> Default for Reserved<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> Serialize for Reserved<N> {
    /// As text in hexadecimal digits, or as an empty text if all bytes are zero.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let zeros = self.0.iter().all(|byte| *byte == 0);
        let text: String = if zeros {
            String::new()
        } else {
            self.0.iter().map(|byte| format!("{byte:02x}")).collect()
        };
        serializer.serialize_str(&text)
    }
}

impl<const N: usize> Wire for Reserved<N> {
    const SIZE: usize = N;
    const TYPE: &'static str = "bytes";

    fn get(bytes: &[u8]) -> Self {
        let mut array = [0; N];
        array.copy_from_slice(bytes);
        Self(array)
    }

    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.0);
    }
}

/// A text in a field of `N` bytes, ended by a NUL unless it fills the field. Bytes after the NUL are kept.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Chars<const N: usize>(pub [u8; N]);

impl<const N: usize> Chars<N> {
    /// The text with NULs behind it; `None` if it has more than `N` bytes or contains a NUL.
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let mut array = [0; N];
        array.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
        (!text.as_bytes().contains(&0)).then_some(Self(array))
    }

    /// The text before the first NUL. Bytes that are not UTF-8 become replacement characters.
    #[must_use]
    pub fn text(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(before_nul(&self.0))
    }
}

impl<const N: usize> Default for Chars<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> core::fmt::Debug for Chars<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

impl<const N: usize> Serialize for Chars<N> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text())
    }
}

impl<const N: usize> Wire for Chars<N> {
    const SIZE: usize = N;
    const TYPE: &'static str = "text";

    fn get(bytes: &[u8]) -> Self {
        let mut array = [0; N];
        array.copy_from_slice(bytes);
        Self(array)
    }

    fn put(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.0);
    }
}

/// The bytes before the first NUL; all of them if there is none.
pub(crate) fn before_nul(bytes: &[u8]) -> &[u8] {
    let end = memchr::memchr(0, bytes).unwrap_or(bytes.len());
    &bytes[..end]
}

/// An enumeration on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CodeTable {
    /// The name of this crate's type.
    pub name: &'static str,
    /// Its type on the wire.
    pub wire: &'static str,
    /// The codes that the specification names, with the names of their variants.
    pub values: &'static [(i64, &'static str)],
}

/// Enumerations on the wire. A code that the specification does not name is kept in `Other`.
macro_rules! codes {
    ($(
        $(#[$doc:meta])*
        pub enum $Code:ident: $number:ty { $( $(#[$variant_doc:meta])* $value:literal $Variant:ident, )* }
    )*) => {
        /// The enumerations of this module, in its order.
        pub(crate) const CODES: &[$crate::CodeTable] = &[$(
            $crate::CodeTable {
                name: stringify!($Code),
                wire: stringify!($number),
                values: &[$( ($value, stringify!($Variant)) ),*],
            }
        ),*];

        $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $Code {
            $( $(#[$variant_doc])* $Variant, )*
            /// A code that the specification does not name.
            Other($number),
        }

        impl $Code {
            /// The codes that the specification names, with the names of their variants.
            pub const NAMED: &'static [(Self, &'static str)] = &[$( (Self::$Variant, stringify!($Variant)) ),*];

            /// The number on the wire.
            #[must_use]
            pub const fn code(self) -> $number {
                match self {
                    $( Self::$Variant => $value, )*
                    Self::Other(code) => code,
                }
            }
        }

        impl From<$number> for $Code {
            fn from(code: $number) -> Self {
                match code {
                    $( $value => Self::$Variant, )*
                    other => Self::Other(other),
                }
            }
        }

        impl $crate::wire::Wire for $Code {
            const SIZE: usize = <$number as $crate::wire::Wire>::SIZE;
            const TYPE: &'static str = <$number as $crate::wire::Wire>::TYPE;

            fn get(bytes: &[u8]) -> Self {
                Self::from(<$number as $crate::wire::Wire>::get(bytes))
            }

            fn put(&self, out: &mut Vec<u8>) {
                $crate::wire::Wire::put(&self.code(), out);
            }

            fn number(&self) -> Option<f64> {
                $crate::wire::Wire::number(&self.code())
            }

            fn is_known(&self) -> bool {
                !matches!(self, Self::Other(_))
            }
        }
    )*
    };
}

pub(crate) use codes;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_fills_its_field_or_ends_at_a_nul() {
        assert_eq!(Chars::<4>::new("port").unwrap().text(), "port");
        assert_eq!(Chars::<4>::new("sb").unwrap().0, *b"sb\0\0");
        assert_eq!(Chars::<4>::new("sb").unwrap().text(), "sb");
        assert!(Chars::<4>::new("sides").is_none());
        assert!(Chars::<4>::new("a\0b").is_none());
        assert_eq!(Chars(*b"ab\0c").text(), "ab");
        assert_eq!(Chars([0xFF, b'a', 0, 0]).text(), "\u{FFFD}a");
    }

    #[test]
    fn reserved_bytes_are_shown_only_if_they_are_used() {
        assert_eq!(serde_json::to_string(&Reserved([0, 0, 0])).unwrap(), "\"\"");
        assert_eq!(serde_json::to_string(&Reserved([0, 0x1F, 0])).unwrap(), "\"001f00\"");
    }
}

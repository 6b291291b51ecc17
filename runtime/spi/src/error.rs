use backseat_units::OutOfRange;

/// Why a field could not be read or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The sentence ends before the field.
    #[error("the field is missing")]
    Missing,
    /// The field is empty and must not be: empty is not zero.
    #[error("the field is empty")]
    Empty,
    /// The text, or the value to write, does not have the form that the field needs.
    #[error("expected {expected}")]
    Malformed {
        /// What the field needs.
        expected: &'static str,
    },
    /// The number is outside what its quantity allows.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
}

impl Fault {
    pub(crate) const fn expected(expected: &'static str) -> Self {
        Self::Malformed { expected }
    }
}

/// A sentence that could not be decoded: message, field and fault.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message} field {number} ({field}) {found:?}: {fault}")]
pub struct DecodeError {
    /// The sentence's name, `BFNVG`.
    pub message: &'static str,
    /// The field's name in this crate's type.
    pub field: &'static str,
    /// The field's number on the wire, 1 for the first after the sentence's name.
    pub number: usize,
    /// The text that was found, cut to [`DecodeError::FOUND_CHARS`] characters; empty if the field is missing.
    pub found: Box<str>,
    /// What is wrong with it.
    pub fault: Fault,
}

impl DecodeError {
    /// How many characters of a wrong field the error keeps.
    pub const FOUND_CHARS: usize = 32;
}

/// A message that could not be encoded. Nothing was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// A value that cannot be written without being misread.
    #[error("{message} field {field}: {fault}")]
    Field {
        /// The sentence's name.
        message: &'static str,
        /// The field's name in this crate's type.
        field: &'static str,
        /// What is wrong with it.
        fault: Fault,
    },
    /// The line would be longer than [`crate::MAX_LINE`].
    #[error("{message} would take {length} bytes, at most {} are allowed", crate::MAX_LINE)]
    TooLong {
        /// The sentence's name.
        message: Box<str>,
        /// The length of the line, bytes.
        length: usize,
    },
    /// An unknown message with the name of a known one: the other side would read it as the known one.
    #[error("{message} is a known message of this direction: use its own type")]
    Known {
        /// The sentence's name.
        message: Box<str>,
    },
}

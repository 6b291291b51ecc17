use std::io;

use backseat_spi::EncodeError;

/// Why a tool stopped.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No message bears the name.
    #[error("no message is named {name:?}: `backseat spi list` names all {}", backseat_spi::catalogue().len())]
    NoMessage {
        /// The name that was given.
        name: String,
    },
    /// What can be subscribed to comes from the vehicle, and this does not.
    #[error("{name} goes to the vehicle: expected messages from it, such as NVG or CTL")]
    NotFromVehicle {
        /// The name that was given.
        name: String,
    },
    /// No address.
    #[error("{text:?} is no address: expected HOST or HOST:PORT, such as 127.0.0.1:29500")]
    Address {
        /// What was given.
        text: String,
    },
    /// The input cannot be read.
    #[error("cannot read: {0}")]
    Input(#[source] io::Error),
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Output(#[source] io::Error),
    /// A line to encode is longer than any message's.
    #[error("line {line}: longer than {max} bytes: expected one JSON object a line")]
    TooLong {
        /// The line, from 1.
        line: u64,
        /// The longest that is read, bytes.
        max: usize,
    },
    /// A line to encode is no object with a name and a message.
    #[error("line {line}{}: {fault}; expected {{\"name\":\"BPSTS\",\"message\":{{…}}}}, as `backseat spi decode --json` writes it", at(*column))]
    Object {
        /// The line, from 1.
        line: u64,
        /// The column, from 1; 0 where it is not known.
        column: usize,
        /// What is wrong.
        fault: String,
    },
    /// A line to encode has no message, because the sentence that it comes from had none.
    #[error("line {line}: {name} has an error in place of a message ({error}): leave such lines out")]
    NoContent {
        /// The line, from 1.
        line: u64,
        /// The sentence's name.
        name: String,
        /// The error that it brought.
        error: String,
    },
    /// The name of a line to encode is no message's.
    #[error("line {line}: {name:?} is no message: `backseat spi list` names all")]
    Name {
        /// The line, from 1.
        line: u64,
        /// The name.
        name: String,
    },
    /// A field of a line to encode is missing, of the wrong kind, or none of the message's.
    #[error("line {line}: {name}{}: {fault}; see `backseat spi list {name}`", within(field_path))]
    Field {
        /// The line, from 1.
        line: u64,
        /// The message's name.
        name: String,
        /// Where in the message; empty for the message itself.
        field_path: String,
        /// What is wrong, and what was expected.
        fault: String,
    },
    /// A value that the wire cannot carry.
    #[error("line {line}: {source}")]
    Value {
        /// The line, from 1.
        line: u64,
        /// Message, field, and what was expected.
        source: EncodeError,
    },
}

fn at(column: usize) -> String {
    if column == 0 {
        String::new()
    } else {
        format!(" column {column}")
    }
}

fn within(path: &str) -> String {
    if path.is_empty() || path == "." {
        String::new()
    } else {
        format!(" field {path}")
    }
}

impl Error {
    /// Whether the reader of the output has gone, as `head` does: not a fault of anybody's.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

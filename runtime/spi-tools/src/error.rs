use std::io;

use backseat_spi::EncodeError;

/// Why a tool stopped.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No message has this name.
    #[error("unknown message {name:?}: `backseat spi list` lists all {}", backseat_spi::catalogue().len())]
    NoMessage {
        /// The name that was given.
        name: String,
    },
    /// Only messages from the vehicle can be subscribed to, and this one goes to the vehicle.
    #[error("{name} goes to the vehicle: expected messages from the vehicle, such as NVG or CTL")]
    NotFromVehicle {
        /// The name that was given.
        name: String,
    },
    /// Not a valid address.
    #[error("invalid address {text:?}: expected HOST or HOST:PORT, such as 127.0.0.1:29500")]
    Address {
        /// The text that was given.
        text: String,
    },
    /// The input cannot be read.
    #[error("cannot read: {0}")]
    Input(#[source] io::Error),
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Output(#[source] io::Error),
    /// A line to encode is longer than any message needs.
    #[error("line {line}: longer than {max} bytes: expected one JSON object a line")]
    TooLong {
        /// The line, from 1.
        line: u64,
        /// The longest line that is read, bytes.
        max: usize,
    },
    /// A line to encode is not an object with a name and a message.
    #[error("line {line}{}: {fault}; expected {{\"name\":\"BPSTS\",\"message\":{{…}}}}, as `backseat spi decode --json` writes it", at(*column))]
    Object {
        /// The line, from 1.
        line: u64,
        /// The column, from 1; 0 if unknown.
        column: usize,
        /// What is wrong.
        fault: String,
    },
    /// A line to encode has no message, because its sentence had none when it was decoded.
    #[error("line {line}: {name} has an error instead of a message ({error}): remove such lines")]
    NoContent {
        /// The line, from 1.
        line: u64,
        /// The sentence's name.
        name: String,
        /// The error in the object.
        error: String,
    },
    /// A line to encode has an unknown name.
    #[error("line {line}: unknown message {name:?}: `backseat spi list` lists all")]
    Name {
        /// The line, from 1.
        line: u64,
        /// The name.
        name: String,
    },
    /// A field of a line to encode is missing, has the wrong type, or is unknown.
    #[error("line {line}: {name}{}: {fault}; a valid one is {example}", within(field_path))]
    Field {
        /// The line, from 1.
        line: u64,
        /// The message's name.
        name: String,
        /// The path of the field in the message; empty for the message itself.
        field_path: String,
        /// What is wrong, and what was expected.
        fault: String,
        /// A valid message of that name.
        example: String,
    },
    /// A value that cannot be encoded.
    #[error("line {line}: {source}")]
    Value {
        /// The line, from 1.
        line: u64,
        /// The message, the field, and what was expected.
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
    /// Whether the reader of the output has closed it, as `head` does. This is not a failure.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

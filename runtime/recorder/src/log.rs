use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;

use backseat_core::{Reservation, Start};
use backseat_units::{Position, Timestamp, Utc};
use serde::de::Error as _;
use serde_json::{Error, Map, Value};

use crate::channel::Channel;
use crate::error::RecorderError;
use crate::header::Rate;
use crate::message::LoggedInput;
use crate::reader::{LogReader, open_regular};
use crate::{bytes, plain};

/// A log, read as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Facts about the run.
    pub run: Run,
    /// The attachments, in the order of the file.
    pub attachments: Vec<Attachment>,
    /// All messages in the order of their sequence numbers.
    pub entries: Vec<Entry>,
    /// Whether the file has its end. If not, the process was killed, and what it had not yet written is missing.
    pub complete: bool,
}

/// The facts about its run that a log holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The program's version.
    pub version: String,
    /// The mission's name.
    pub mission: String,
    /// The simulation's seed; `None` at sea.
    pub seed: Option<u64>,
    /// How much was decoded.
    pub rate: Rate,
    /// The UTC at the run's time zero.
    pub utc_at_start: Utc,
    /// The origin of the frame in which the log counts metres.
    pub origin: Position,
    /// SHA-256 of the resolved mission, hexadecimal.
    pub mission_sha256: String,
    /// SHA-256 of the fence, hexadecimal.
    pub fence_sha256: String,
    /// Which part of the run's log this file is; 1 also if the log has no other.
    pub part: u64,
    /// SHA-256 of each component by its attachment's name, whether or not it is attached.
    pub components: BTreeMap<String, String>,
}

/// A file attached to a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Its name.
    pub name: String,
    /// Its media type.
    pub media_type: String,
    /// Its content.
    pub data: Vec<u8>,
}

/// One message of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its place in the order of all messages.
    pub sequence: u32,
    /// The run's time.
    pub now: Timestamp,
    /// Its contents.
    pub record: Record,
}

/// The contents of a message. JSON is as in its channel's schema.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// The values with which core was started.
    Start(Start),
    /// An input of core, including the link's bytes.
    Input(LoggedInput),
    /// Records are missing here, possibly inputs too: the disk did not accept them in time.
    Gap {
        /// Since when, seconds of the run.
        since_s: f64,
        /// The number of records.
        records: u64,
    },
    /// Bytes written to the link.
    Sent(Vec<u8>),
    /// Another output of core.
    Output(Value),
    /// A note.
    Note(Value),
    /// A new state of a request.
    Request(Value),
    /// Control gained or lost.
    Control(Value),
    /// Navigation.
    Navigation(Value),
    /// The simulation's truth.
    Truth(Value),
    /// A line of the simulated vehicle's own log.
    Vehicle(String),
}

impl Log {
    /// The inputs of core, in the order in which it handled them.
    pub fn inputs(&self) -> impl Iterator<Item = (Timestamp, &LoggedInput)> {
        self.entries.iter().filter_map(|entry| {
            let Record::Input(input) = &entry.record else {
                return None;
            };
            Some((entry.now, input))
        })
    }

    /// The values with which core was started, if they were recorded.
    #[must_use]
    pub fn start(&self) -> Option<Start> {
        self.entries.iter().find_map(|entry| {
            let Record::Start(start) = &entry.record else {
                return None;
            };
            Some(*start)
        })
    }

    /// All bytes of the link in order: the time, whether they came from the vehicle, and the bytes.
    pub fn link(&self) -> impl Iterator<Item = (Timestamp, bool, &[u8])> {
        self.entries.iter().filter_map(|entry| {
            if let Record::Input(LoggedInput::Received(bytes)) = &entry.record {
                Some((entry.now, true, bytes.as_slice()))
            } else if let Record::Sent(bytes) = &entry.record {
                Some((entry.now, false, bytes.as_slice()))
            } else {
                None
            }
        })
    }

    /// The lines of notes, requests and control.
    pub fn notes(&self) -> impl Iterator<Item = (Timestamp, &str)> {
        self.entries.iter().filter_map(|entry| {
            let (Record::Note(json) | Record::Request(json) | Record::Control(json)) = &entry.record else {
                return None;
            };
            Some((entry.now, json.get("text").and_then(Value::as_str)?))
        })
    }

    /// An attachment's content.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.attachments
            .iter()
            .find(|attachment| attachment.name == name)
            .map(|attachment| attachment.data.as_slice())
    }
}

/// Reads a log file into memory.
///
/// # Errors
/// [`RecorderError::Open`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Log, RecorderError> {
    let mut bytes = Vec::new();
    let read = open_regular(path)?.read_to_end(&mut bytes);
    read.map_err(|source| RecorderError::Open {
        path: path.to_owned(),
        source,
    })?;
    parse_named(&bytes, &path.display().to_string())
}

/// Reads a log from its bytes.
///
/// Channels that are derived from others are skipped, and so are unknown ones, because a newer program may write more.
///
/// # Errors
///
/// [`RecorderError::NotALog`], [`RecorderError::Damaged`], [`RecorderError::Foreign`], [`RecorderError::Format`],
/// [`RecorderError::Message`].
pub fn parse(bytes: &[u8]) -> Result<Log, RecorderError> {
    parse_named(bytes, "in memory")
}

fn parse_named(bytes: &[u8], log: &str) -> Result<Log, RecorderError> {
    let mut reader = LogReader::new(bytes, log.to_owned())?;
    let mut entries = Vec::new();
    while let Some(message) = reader.next_message()? {
        if let Some(record) = reader.record(&message)? {
            entries.push(Entry {
                sequence: message.sequence,
                now: message.now,
                record,
            });
        }
    }
    Ok(Log {
        run: reader.run().clone(),
        attachments: reader.attachments().to_vec(),
        entries,
        complete: reader.is_complete(),
    })
}

pub(crate) fn read_record(channel: Channel, data: &[u8]) -> Result<Record, Error> {
    let json = || serde_json::from_slice::<Value>(data);
    let object = || serde_json::from_slice::<Map<String, Value>>(data);
    Ok(match channel {
        Channel::FromVehicle => Record::Input(LoggedInput::Received(bytes::read(&object()?)?)),
        Channel::ToVehicle => Record::Sent(bytes::read(&object()?)?),
        Channel::Input => read_input(&object()?)?,
        Channel::Output => Record::Output(json()?),
        Channel::Notes => Record::Note(json()?),
        Channel::Requests => Record::Request(json()?),
        Channel::Control => Record::Control(json()?),
        Channel::Navigation => Record::Navigation(json()?),
        Channel::Truth => Record::Truth(json()?),
        Channel::Vehicle => Record::Vehicle(plain::read(&object()?, "text")?),
    })
}

fn read_input(message: &Map<String, Value>) -> Result<Record, Error> {
    let name = message.get("input").and_then(Value::as_str).unwrap_or_default();
    let plugin = || plain::read(message, "plugin");
    let input = match name {
        "start" => return Ok(Record::Start(plain::read(message, "start")?)),
        "gap" => {
            return Ok(Record::Gap {
                since_s: plain::read(message, "since_s")?,
                records: plain::read(message, "records")?,
            });
        }
        "link-up" => LoggedInput::LinkUp,
        "link-down" => LoggedInput::LinkDown,
        "returned" => LoggedInput::Returned(plugin()?, plain::read(message, "returned")?),
        "restarted" => LoggedInput::Restarted(plugin()?, plain::read(message, "restarted")?),
        "swap" => LoggedInput::Swap(plugin()?, plain::read(message, "version")?),
        "operator" => LoggedInput::Operator(plain::read(message, "act")?),
        "external" => LoggedInput::External(plain::read(message, "external")?, bytes::read(message)?),
        "reserved" => LoggedInput::Reserved(Reservation {
            below: plain::read(message, "below")?,
            inserts: plain::read(message, "inserts")?,
            gps_hits: plain::read(message, "gps_hits")?,
        }),
        "sonar" => LoggedInput::Sonar(plain::read(message, "report")?),
        "utc-set" => LoggedInput::UtcSet(plain::read(message, "by_nanos")?),
        "timeout" => LoggedInput::Timeout,
        _ => return Err(Error::custom(format!("unknown input {name:?}"))),
    };
    Ok(Record::Input(input))
}

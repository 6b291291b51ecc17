//! Makes one log of the parts of a run's log.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use backseat_units::Timestamp;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions};

use crate::channel::Channel;
use crate::chunks::Message;
use crate::error::RecorderError;
use crate::header::PART;
use crate::log::Attachment;
use crate::message::InputRef;
use crate::plain;
use crate::reader::LogReader;
use crate::topics::schema_of;

/// Why parts cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// A part cannot be read, or the new log cannot be written.
    #[error(transparent)]
    Log(#[from] RecorderError),
    /// Two files are of different runs.
    #[error("{} and {} are of different runs: expected the parts of one log", one.display(), other.display())]
    Runs {
        /// The first part.
        one: PathBuf,
        /// The other one.
        other: PathBuf,
    },
    /// A part is missing.
    #[error(
        "part {part} is missing: expected all parts of the log up to the last one (a log whose first parts were removed, as --log-quota does, cannot be joined)"
    )]
    Missing {
        /// Its number.
        part: u64,
    },
    /// A part is there twice.
    #[error("{} and {} are both part {part}: expected each part once", one.display(), other.display())]
    Twice {
        /// Its number.
        part: u64,
        /// One file.
        one: PathBuf,
        /// The other one.
        other: PathBuf,
    },
}

/// What was joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joined {
    /// How many parts.
    pub parts: usize,
    /// How many messages the new log has.
    pub messages: u64,
    /// How many records are missing at the end of parts that were cut short. The new log marks each such gap.
    pub missing: u64,
}

/// Writes one log with everything that these parts have, in any order, into a new file. The last part may be missing its end,
/// as that of a process that was killed.
///
/// # Errors
///
/// [`JoinError`]. Nothing is left of the new file then; a file that exists is not touched.
pub fn join(parts: &[PathBuf], into: &Path) -> Result<Joined, JoinError> {
    let parts = in_order(parts)?;
    let create_error = |source: std::io::Error| {
        let path = into.to_owned();
        if source.kind() == std::io::ErrorKind::AlreadyExists {
            RecorderError::Exists { path }
        } else {
            RecorderError::Create { path, source }
        }
    };
    let file = File::create_new(into).map_err(create_error)?;
    let joined = write_all(&parts, BufWriter::new(file), &into.display().to_string());
    if joined.is_err() {
        // The first error counts.
        let _removed = std::fs::remove_file(into);
    }
    joined
}

/// The parts by their numbers, which are 1 and so on.
fn in_order(paths: &[PathBuf]) -> Result<Vec<&Path>, JoinError> {
    let mut parts: BTreeMap<u64, &Path> = BTreeMap::new();
    let mut first = None;
    for path in paths {
        let run = LogReader::open(path)?.run().clone();
        let same = (run.mission.clone(), run.utc_at_start, run.mission_sha256.clone());
        let (one, expected) = first.get_or_insert_with(|| (path, same.clone()));
        if *expected != same {
            return Err(JoinError::Runs {
                one: one.to_path_buf(),
                other: path.clone(),
            });
        }
        if let Some(one) = parts.insert(run.part, path) {
            return Err(JoinError::Twice {
                part: run.part,
                one: one.to_path_buf(),
                other: path.clone(),
            });
        }
    }
    let missing = (1..).zip(parts.keys()).find(|(expected, part)| expected != *part);
    if let Some((part, _)) = missing {
        return Err(JoinError::Missing { part });
    }
    Ok(parts.into_values().collect())
}

fn write_all<W: Write + Seek>(parts: &[&Path], writer: W, log: &str) -> Result<Joined, JoinError> {
    let failed = |source: McapError| RecorderError::Write {
        log: log.to_owned(),
        source: Box::new(source),
    };
    let options = WriteOptions::new().library(concat!("backseat ", env!("CARGO_PKG_VERSION")));
    let mut out = Out {
        writer: options.create(writer).map_err(failed)?,
        channels: BTreeMap::new(),
        last: None,
        joined: Joined {
            parts: parts.len(),
            messages: 0,
            missing: 0,
        },
    };
    let mut attached: BTreeSet<String> = BTreeSet::new();
    for (place, path) in parts.iter().enumerate() {
        let mut part = LogReader::open(path)?;
        if place == 0 {
            out.begin(&part).map_err(failed)?;
        }
        let start_ns = part.run().utc_at_start.as_unix_nanos();
        let mut seen = 0;
        loop {
            let message = part.next_message()?;
            // Later parts repeat the texts of the first one; what is new is a version that took a plugin's place.
            let new = part.attachments().get(seen..).unwrap_or_default();
            seen += new.len();
            let at = message.as_ref().map_or(0, |message| message.now.as_nanos());
            for attachment in new {
                if attached.insert(attachment.name.clone()) {
                    out.attach(attachment, start_ns + at).map_err(failed)?;
                }
            }
            let Some(message) = message else { break };
            out.message(start_ns, &message).map_err(failed)?;
        }
    }
    out.writer.finish().map_err(failed)?;
    Ok(out.joined)
}

/// The new log.
struct Out<W: Write + Seek> {
    writer: mcap::Writer<W>,
    /// MCAP identifiers by topic.
    channels: BTreeMap<String, u16>,
    /// The sequence number and the time of the last message.
    last: Option<(u32, Timestamp)>,
    joined: Joined,
}

impl<W: Write + Seek> Out<W> {
    /// Writes what the first part says before its first message. The new log is no part.
    fn begin<R: Read>(&mut self, part: &LogReader<R>) -> Result<(), McapError> {
        for (name, metadata) in part.metadata() {
            let mut metadata = metadata.clone();
            metadata.remove(PART);
            self.writer.write_metadata(&Metadata {
                name: name.clone(),
                metadata,
            })?;
        }
        Ok(())
    }

    fn attach(&mut self, attachment: &Attachment, time_ns: u64) -> Result<(), McapError> {
        self.writer.attach(&mcap::Attachment {
            log_time: time_ns,
            create_time: time_ns,
            name: attachment.name.clone(),
            media_type: attachment.media_type.clone(),
            data: Cow::Borrowed(&attachment.data),
        })
    }

    /// Marks what is missing before a message.
    fn message(&mut self, start_ns: u64, message: &Message) -> Result<(), McapError> {
        if let Some((sequence, since)) = self.last {
            let missing = message.sequence.wrapping_sub(sequence.wrapping_add(1));
            if missing > 0 {
                self.joined.missing += u64::from(missing);
                let (since_s, records) = (since.since(Timestamp::ZERO).as_secs_f64(), u64::from(missing));
                let mut gap = Vec::new();
                plain::write(&mut gap, &InputRef::Gap { since_s, records }).expect("a Vec takes every message");
                let (topic, at) = (Channel::Input.topic(), start_ns + message.now.as_nanos());
                self.put(topic, message.sequence.wrapping_sub(1), at, &gap)?;
            }
        }
        self.last = Some((message.sequence, message.now));
        let at = start_ns + message.now.as_nanos();
        self.put(&message.topic, message.sequence, at, &message.data)
    }

    fn put(&mut self, topic: &str, sequence: u32, at: u64, data: &[u8]) -> Result<(), McapError> {
        let channel_id = self.channel(topic)?;
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: at,
            publish_time: at,
        };
        self.joined.messages += 1;
        self.writer.write_to_known_channel(&header, data)
    }

    fn channel(&mut self, topic: &str) -> Result<u16, McapError> {
        if let Some(id) = self.channels.get(topic) {
            return Ok(*id);
        }
        // A topic without a schema is one of a newer program.
        let schema = match schema_of(topic) {
            Some((name, schema)) => self.writer.add_schema(&name, "jsonschema", schema.as_bytes())?,
            None => 0,
        };
        let id = self.writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
        self.channels.insert(topic.to_owned(), id);
        Ok(id)
    }
}

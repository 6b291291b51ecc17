use std::collections::BTreeMap;
use std::fs::{self, File, Metadata};
use std::io::{self, BufReader, Read};
use std::path::Path;

use backseat_core::plugin::Description;
use backseat_units::{Position, Utc};

use crate::channel::Channel;
use crate::chunks::{Chunks, Message};
use crate::error::RecorderError;
use crate::header::{AS_READ, COMPONENTS, DESCRIPTIONS, FORMAT, PART, PLAN, RUN, Rate, component_name};
use crate::log::{Attachment, Record, Run, read_record};

/// Reads a log message by message. Its memory is bounded by the attachments and the largest chunk.
pub struct LogReader<R> {
    chunks: Chunks<R>,
    run: Run,
}

impl Message {
    /// What it says; `None` on a channel that is derived from others, or unknown.
    ///
    /// # Errors
    ///
    /// If it does not match its channel's schema.
    pub fn record(&self) -> Result<Option<Record>, serde_json::Error> {
        Channel::from_topic(&self.topic)
            .map(|channel| read_record(channel, &self.data))
            .transpose()
    }
}

impl LogReader<BufReader<File>> {
    /// Opens a log, and reads what it says before its first message.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Open`], and those of [`LogReader::new`].
    pub fn open(path: &Path) -> Result<Self, RecorderError> {
        let file = open_regular(path)?;
        Self::new(BufReader::with_capacity(1 << 18, file), path.display().to_string())
    }
}

/// Opens a log's file, and no pipe or device: opening a pipe would wait for its other end.
pub(crate) fn open_regular(path: &Path) -> Result<File, RecorderError> {
    let regular = |found: Metadata| match found.is_file() || found.is_dir() {
        true => Ok(()),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file")),
    };
    let opened = fs::metadata(path).and_then(regular).and_then(|()| File::open(path));
    opened.map_err(|source| RecorderError::Open {
        path: path.to_owned(),
        source,
    })
}

impl<R: Read> LogReader<R> {
    /// Reads what a log says before its first message. Errors call it `log`.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Open`], [`RecorderError::NotALog`], [`RecorderError::Damaged`], [`RecorderError::Foreign`],
    /// [`RecorderError::Format`].
    pub fn new(source: R, log: String) -> Result<Self, RecorderError> {
        let mut chunks = Chunks::open(source, log)?;
        let run = chunks.metadata(RUN).ok_or_else(|| {
            let what = if chunks.is_cut() {
                "no run, as it was cut short before that was written"
            } else {
                "no metadata"
            };
            foreign(chunks.log(), what.to_owned(), "a metadata record named backseat")
        })?;
        let components = chunks.metadata(COMPONENTS).cloned().unwrap_or_default();
        let run = read_run(run, components, chunks.log())?;
        chunks.count_from(run.utc_at_start);
        Ok(Self { chunks, run })
    }

    /// Facts about the run.
    #[must_use]
    pub const fn run(&self) -> &Run {
        &self.run
    }

    /// The metadata records by their names.
    pub(crate) const fn metadata(&self) -> &BTreeMap<String, BTreeMap<String, String>> {
        self.chunks.all_metadata()
    }

    /// The attachments, in the order of the file. They come before the messages.
    #[must_use]
    pub fn attachments(&self) -> &[Attachment] {
        self.chunks.attachments()
    }

    /// An attachment's content.
    #[must_use]
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        let attachment = self.attachments().iter().find(|attachment| attachment.name == name)?;
        Some(&attachment.data)
    }

    /// The plan that the mission names. Logs of earlier versions do not have it.
    #[must_use]
    pub fn plan(&self) -> Option<&[u8]> {
        self.attachment(PLAN)
    }

    /// The name and the content of the fence's file, if `fence.geojson` was written from it. Logs of earlier versions do
    /// not have it.
    #[must_use]
    pub fn fence_as_read(&self) -> Option<(&str, &[u8])> {
        let mut attachments = self.attachments().iter();
        attachments.find_map(|attachment| Some((attachment.name.strip_prefix(AS_READ)?, attachment.data.as_slice())))
    }

    /// The component of a plugin, if it is attached.
    #[must_use]
    pub fn component(&self, plugin: &str) -> Option<&[u8]> {
        self.attachment(&component_name(plugin))
    }

    /// The SHA-256 of a plugin's component, hexadecimal.
    #[must_use]
    pub fn component_sha256(&self, plugin: &str) -> Option<&str> {
        self.run.components.get(&component_name(plugin)).map(String::as_str)
    }

    /// What a plugin said about itself. Logs of earlier versions do not have it.
    #[must_use]
    pub fn description(&self, plugin: &str) -> Option<Description> {
        serde_json::from_str(self.chunks.metadata(DESCRIPTIONS)?.get(plugin)?).ok()
    }

    /// Whether the file ended in the middle of what has been read so far. Before the first message: it has none.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.chunks.is_cut()
    }

    /// Whether the file has its end. Only known when there are no more messages.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.chunks.is_complete()
    }

    /// The next message, of any channel; `None` at the end.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Open`], [`RecorderError::Damaged`].
    pub fn next_message(&mut self) -> Result<Option<Message>, RecorderError> {
        self.chunks.next_message()
    }

    /// What a message says, as [`Message::record`], with an error that names the log.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Message`].
    pub fn record(&self, message: &Message) -> Result<Option<Record>, RecorderError> {
        message.record().map_err(|source| RecorderError::Message {
            log: self.chunks.log().to_owned(),
            channel: message.topic.to_string(),
            sequence: message.sequence,
            source,
        })
    }
}

fn foreign(log: &str, what: String, expected: &'static str) -> RecorderError {
    RecorderError::Foreign {
        log: log.to_owned(),
        what,
        expected,
    }
}

fn read_run(
    run: &BTreeMap<String, String>,
    components: BTreeMap<String, String>,
    log: &str,
) -> Result<Run, RecorderError> {
    let text = |key: &str| run.get(key).cloned().unwrap_or_default();
    if text("format") != FORMAT {
        return Err(RecorderError::Format {
            log: log.to_owned(),
            found: text("format"),
            expected: FORMAT,
        });
    }
    let part = run.get(PART).map_or(Ok(1), |part| part.parse());
    let rate = Rate::from_name(&text("rate"));
    let seed = run.get("seed").map(|seed| seed.parse()).transpose();
    Ok(Run {
        version: text("version"),
        mission: text("mission"),
        seed: seed.map_err(|_| foreign(log, format!("seed {:?}", text("seed")), "a whole number"))?,
        rate: rate.ok_or_else(|| foreign(log, format!("rate {:?}", text("rate")), "simulation or deployed"))?,
        utc_at_start: Utc::from_unix_nanos(text("utc_at_start_ns").parse().map_err(|_| {
            let what = format!("utc_at_start_ns {:?}", text("utc_at_start_ns"));
            foreign(log, what, "nanoseconds since 1970")
        })?),
        origin: read_origin(run).ok_or_else(|| {
            let what = format!(
                "origin {:?} {:?}",
                text("origin_latitude_deg"),
                text("origin_longitude_deg")
            );
            foreign(log, what, "degrees of latitude and longitude")
        })?,
        mission_sha256: text("mission_sha256"),
        fence_sha256: text("fence_sha256"),
        part: part.map_err(|_| foreign(log, format!("part {:?}", text(PART)), "a whole number"))?,
        components,
    })
}

fn read_origin(run: &BTreeMap<String, String>) -> Option<Position> {
    let degrees = |key| run.get(key)?.parse().ok();
    let (latitude_deg, longitude_deg) = (degrees("origin_latitude_deg")?, degrees("origin_longitude_deg")?);
    Position::from_deg(latitude_deg, longitude_deg).ok()
}

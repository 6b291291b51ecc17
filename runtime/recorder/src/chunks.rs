use std::collections::{BTreeMap, VecDeque};
use std::io::Read;
use std::path::PathBuf;
use std::sync::Arc;

use backseat_units::{Timestamp, Utc};
use mcap::records::{Record as Raw, op};
use mcap::{MAGIC, McapError};

use crate::error::RecorderError;
use crate::log::Attachment;
use crate::raw::Records;

/// Opcode and length.
const RECORD_HEAD: usize = 1 + size_of::<u64>();

/// A message of any channel, as it is in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Its place in the order of all messages.
    pub sequence: u32,
    /// The run's time.
    pub now: Timestamp,
    /// Its channel's topic.
    pub topic: Arc<str>,
    /// JSON.
    pub data: Vec<u8>,
}

/// A file's records, one after the other; a chunk's messages at once.
pub(crate) struct Chunks<R> {
    source: R,
    /// The file's path, for errors.
    log: String,
    /// The UTC at the run's time zero.
    start_ns: u64,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    attachments: Vec<Attachment>,
    topics: BTreeMap<u16, Arc<str>>,
    /// Messages of the chunk that was read last.
    waiting: VecDeque<Message>,
    end: End,
    /// How many messages were read, also those of unknown channels.
    count: u64,
    /// The time of the newest message.
    newest: Timestamp,
    /// How much of the file was read, bytes, and where the current record begins.
    read: u64,
    record_at: u64,
    /// The current record, kept to reuse its allocation.
    bytes: Vec<u8>,
}

/// How far a file was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// There is more.
    Ahead,
    /// It ends in order.
    Complete,
    /// It was cut short.
    Cut,
}

impl<R: Read> Chunks<R> {
    /// Reads everything before the first message.
    pub(crate) fn open(source: R, log: String) -> Result<Self, RecorderError> {
        let mut chunks = Self {
            source,
            log,
            start_ns: 0,
            metadata: BTreeMap::new(),
            attachments: Vec::new(),
            topics: BTreeMap::new(),
            waiting: VecDeque::new(),
            end: End::Ahead,
            count: 0,
            newest: Timestamp::ZERO,
            read: 0,
            record_at: 0,
            bytes: Vec::new(),
        };
        if !chunks.fill(MAGIC.len() as u64)? || chunks.bytes != MAGIC {
            return Err(RecorderError::NotALog {
                log: chunks.log,
                what: if chunks.bytes.is_empty() {
                    "is empty"
                } else {
                    "is no MCAP file"
                },
            });
        }
        chunks.read_on()?;
        Ok(chunks)
    }

    /// From now on, the times of messages count from this UTC.
    pub(crate) fn count_from(&mut self, utc: Utc) {
        self.start_ns = utc.as_unix_nanos();
        for message in &mut self.waiting {
            message.now = Timestamp::from_nanos(message.now.as_nanos().saturating_sub(self.start_ns));
            self.newest = self.newest.max(message.now);
        }
    }

    pub(crate) fn log(&self) -> &str {
        &self.log
    }

    pub(crate) fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.metadata.get(name)
    }

    pub(crate) const fn all_metadata(&self) -> &BTreeMap<String, BTreeMap<String, String>> {
        &self.metadata
    }

    pub(crate) fn attachments(&self) -> &[Attachment] {
        &self.attachments
    }

    pub(crate) fn is_complete(&self) -> bool {
        self.end == End::Complete
    }

    pub(crate) fn is_cut(&self) -> bool {
        self.end == End::Cut
    }

    pub(crate) fn next_message(&mut self) -> Result<Option<Message>, RecorderError> {
        self.read_on()?;
        Ok(self.waiting.pop_front())
    }

    /// Reads records until a message waits, or to the end.
    fn read_on(&mut self) -> Result<(), RecorderError> {
        while self.waiting.is_empty() && self.end == End::Ahead {
            self.bytes.clear();
            self.record_at = self.read;
            if !self.fill(RECORD_HEAD as u64)? {
                return self.cut();
            }
            let length = self.bytes.get(1..).and_then(|length| length.try_into().ok());
            if !self.fill(length.map_or(0, u64::from_le_bytes))? {
                return self.cut();
            }
            let bytes = std::mem::take(&mut self.bytes);
            let taken = self.take(&bytes);
            self.bytes = bytes;
            taken?;
        }
        Ok(())
    }

    /// The file ended within a record, and [`Self::bytes`] are its last ones. The log of a process that was killed does. But
    /// a file that ends as MCAP files do was finished, so what is read before its end is damaged.
    fn cut(&mut self) -> Result<(), RecorderError> {
        self.end = End::Cut;
        if self.bytes.ends_with(MAGIC) {
            return Err(RecorderError::Damaged {
                log: self.log.clone(),
                reason: format!(
                    "the record at byte {} runs past the end of the file, which was finished (after {:.3} s of the run)",
                    self.record_at,
                    self.newest.as_secs_f64()
                ),
            });
        }
        Ok(())
    }

    /// Appends so many bytes of the file. Returns false if it ends before.
    fn fill(&mut self, missing: u64) -> Result<bool, RecorderError> {
        let read = (&mut self.source).take(missing).read_to_end(&mut self.bytes);
        let read = read.map_err(|source| RecorderError::Open {
            path: PathBuf::from(&self.log),
            source,
        })?;
        self.read += read as u64;
        Ok(read as u64 == missing)
    }

    /// Reads what follows the messages, as far as it is there. It says how many there are: a damaged chunk can look like
    /// something unknown, which is passed over.
    fn read_summary(&mut self) -> Result<(), RecorderError> {
        loop {
            self.bytes.clear();
            if !self.fill(RECORD_HEAD as u64)? {
                return Ok(());
            }
            let opcode = self.bytes.first().copied().unwrap_or_default();
            let length = self.bytes.get(1..).and_then(|length| length.try_into().ok());
            if opcode == op::FOOTER || !self.fill(length.map_or(0, u64::from_le_bytes))? {
                return Ok(());
            }
            let body = self.bytes.get(RECORD_HEAD..).unwrap_or_default();
            if opcode == op::STATISTICS
                && let Ok(Raw::Statistics(statistics)) = mcap::parse_record(opcode, body)
                && statistics.message_count != self.count
            {
                return Err(RecorderError::Damaged {
                    log: self.log.clone(),
                    reason: format!(
                        "it says that it has {} messages, and {} were found",
                        statistics.message_count, self.count
                    ),
                });
            }
        }
    }

    fn take(&mut self, bytes: &[u8]) -> Result<(), RecorderError> {
        for record in Records::of(bytes) {
            match record.map_err(|source| self.damaged(source))? {
                Raw::Channel(channel) => {
                    self.topics.insert(channel.id, channel.topic.into());
                }
                Raw::Metadata(metadata) => {
                    self.metadata.insert(metadata.name, metadata.metadata);
                }
                Raw::Attachment { header, data, .. } => self.attachments.push(Attachment {
                    name: header.name,
                    media_type: header.media_type,
                    data: data.into_owned(),
                }),
                Raw::Message { header, data } => {
                    self.count += 1;
                    let now = Timestamp::from_nanos(header.log_time.saturating_sub(self.start_ns));
                    if self.start_ns > 0 {
                        self.newest = self.newest.max(now);
                    }
                    if let Some(topic) = self.topics.get(&header.channel_id) {
                        self.waiting.push_back(Message {
                            sequence: header.sequence,
                            now,
                            topic: Arc::clone(topic),
                            data: data.into_owned(),
                        });
                    }
                }
                Raw::DataEnd(_) => {
                    self.end = End::Complete;
                    return self.read_summary();
                }
                Raw::Header(_)
                | Raw::Footer(_)
                | Raw::Schema { .. }
                | Raw::Chunk { .. }
                | Raw::MessageIndex(_)
                | Raw::ChunkIndex(_)
                | Raw::AttachmentIndex(_)
                | Raw::Statistics(_)
                | Raw::MetadataIndex(_)
                | Raw::SummaryOffset(_)
                | Raw::Unknown { .. } => {}
            }
        }
        Ok(())
    }

    fn damaged(&self, source: McapError) -> RecorderError {
        let log = self.log.clone();
        if let McapError::UnsupportedCompression(with) = source {
            RecorderError::Compressed { log, with }
        } else {
            RecorderError::Damaged {
                log,
                reason: format!(
                    "{} (in the record at byte {}, after {:.3} s of the run)",
                    reason(&source),
                    self.record_at,
                    self.newest.as_secs_f64()
                ),
            }
        }
    }
}

/// Where reading fails, in one line. The reader's own text for a record that it cannot read is a picture of many lines.
fn reason(error: &McapError) -> String {
    let McapError::Parse(parsing) = error else {
        return error.to_string();
    };
    let cause = parsing.root_cause().to_string();
    let words: Vec<_> = cause.split_whitespace().collect();
    format!("a record cannot be read: {}", words.join(" "))
}

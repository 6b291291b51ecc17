//! What a log contains: found in a first pass, so that the second can write.

use std::collections::BTreeMap;

use mcap::records::Record;
use serde::Deserialize;
use serde_json::Value;

use crate::error::Error;
use crate::schema::Schema;
use crate::source::{End, Source};
use crate::table::Draft;
use crate::time::seconds;

/// Name of the metadata record about the run.
const RUN: &str = "backseat";
const FENCE: &str = "fence.geojson";
/// Where a gap is recorded.
const INPUT: &str = "/core/input";

/// A log's run, channels and faults.
#[derive(Debug)]
pub(crate) struct Contents {
    /// The metadata about the run: mission, version, seed, ...
    pub(crate) run: BTreeMap<String, String>,
    /// The UTC at the run's time zero, nanoseconds since 1970.
    pub(crate) start_ns: u64,
    /// Each topic once, in the order of the file.
    pub(crate) channels: Vec<Channel>,
    /// The attached fence.
    pub(crate) fence: Option<String>,
    pub(crate) gaps: Vec<Gap>,
    pub(crate) end: End,
    /// The time of the last message, seconds of the run.
    pub(crate) last_s: f64,
    /// Whether no message is older than the one before it.
    pub(crate) in_order: bool,
    /// The channel of each MCAP identifier.
    ids: BTreeMap<u16, usize>,
}

#[derive(Debug)]
pub(crate) struct Channel {
    pub(crate) topic: String,
    /// The name of its schema; empty if it has none.
    pub(crate) schema: String,
    /// Whether its messages are JSON.
    pub(crate) json: bool,
    pub(crate) messages: u64,
    pub(crate) draft: Draft,
}

/// Records that the disk did not accept in time.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(crate) struct Gap {
    /// Since when, seconds of the run.
    pub(crate) since_s: f64,
    /// How many.
    pub(crate) records: u64,
    /// Until when, seconds of the run.
    #[serde(skip)]
    pub(crate) until_s: f64,
}

/// A message of a channel.
pub(crate) struct Message<'a> {
    /// Its channel's place in [`Contents::channels`].
    pub(crate) channel: usize,
    pub(crate) topic: &'a str,
    pub(crate) schema: &'a str,
    /// Nanoseconds since 1970.
    pub(crate) log_time: u64,
    /// Seconds of the run.
    pub(crate) t_s: f64,
    pub(crate) value: Value,
}

impl Contents {
    /// Reads a log once. The columns of those channels are found whose topic is `wanted`.
    pub(crate) fn of(source: &Source, wanted: impl Fn(&str) -> bool) -> Result<Self, Error> {
        let mut schemas: BTreeMap<u16, (String, Vec<u8>)> = BTreeMap::new();
        let mut contents = Self {
            run: BTreeMap::new(),
            start_ns: 0,
            channels: Vec::new(),
            fence: None,
            gaps: Vec::new(),
            end: End::Cut,
            last_s: 0.0,
            in_order: true,
            ids: BTreeMap::new(),
        };
        let (mut last, mut gaps) = (0, Vec::new());
        let end = source.read(|record| {
            // Other records have nothing that is exported.
            if let Record::Schema { header, data } = record {
                schemas.insert(header.id, (header.name, data.into_owned()));
            } else if let Record::Channel(channel) = record {
                let schema = schemas.get(&channel.schema_id);
                contents.add(&channel, schema);
            } else if let Record::Metadata(metadata) = record {
                if metadata.name == RUN {
                    contents.run = metadata.metadata;
                }
            } else if let Record::Attachment { header, data, .. } = record {
                if header.name == FENCE {
                    contents.fence = String::from_utf8(data.into_owned()).ok();
                }
            } else if let Record::Message { header, data } = record
                && let Some(place) = contents.ids.get(&header.channel_id)
                && let Some(channel) = contents.channels.get_mut(*place)
            {
                contents.in_order &= header.log_time >= last;
                last = last.max(header.log_time);
                channel.messages += 1;
                if channel.topic == INPUT
                    && let Some(gap) = gap(&data)
                {
                    gaps.push((header.log_time, gap));
                }
                if wanted(&channel.topic) {
                    let value = channel.value(source, &header, &data)?;
                    channel.draft.see(&value);
                }
            }
            Ok(())
        })?;
        contents.end = end;
        contents.start_ns = contents
            .run
            .get("utc_at_start_ns")
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| foreign(source, &contents.end))?;
        contents.last_s = if last == 0 {
            0.0
        } else {
            seconds(last, contents.start_ns)
        };
        contents.gaps = gaps
            .into_iter()
            .map(|(until, gap)| Gap {
                until_s: seconds(until, contents.start_ns),
                ..gap
            })
            .collect();
        Ok(contents)
    }

    /// Whether a channel of this topic has messages.
    pub(crate) fn has(&self, topic: &str) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|channel| channel.topic == topic && channel.messages > 0)
    }

    fn add(&mut self, channel: &mcap::records::Channel, schema: Option<&(String, Vec<u8>)>) {
        let same = self.channels.iter().position(|known| known.topic == channel.topic);
        let place = same.unwrap_or_else(|| {
            let mut draft = Draft::default();
            if let Some((_, text)) = schema {
                draft.declare(&Schema::parse(text));
            }
            self.channels.push(Channel {
                topic: channel.topic.clone(),
                schema: schema.map_or_else(String::new, |(name, _)| name.clone()),
                json: channel.message_encoding == "json",
                messages: 0,
                draft,
            });
            self.channels.len() - 1
        });
        self.ids.insert(channel.id, place);
    }

    /// Reads the log again, and gives the messages of those channels whose topic is `wanted`.
    pub(crate) fn read(
        &self,
        source: &Source,
        wanted: impl Fn(&str) -> bool,
        mut take: impl FnMut(Message<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        source.read(|record| {
            if let Record::Message { header, data } = record
                && let Some(place) = self.ids.get(&header.channel_id)
                && let Some(channel) = self.channels.get(*place)
                && wanted(&channel.topic)
            {
                take(Message {
                    channel: *place,
                    topic: &channel.topic,
                    schema: &channel.schema,
                    log_time: header.log_time,
                    t_s: seconds(header.log_time, self.start_ns),
                    value: channel.value(source, &header, &data)?,
                })?;
            }
            Ok(())
        })?;
        Ok(())
    }

    /// What is missing of the log, a line each.
    pub(crate) fn remarks(&self, source: &Source) -> Vec<String> {
        let log = source.path().display();
        let mut remarks: Vec<String> = self
            .gaps
            .iter()
            .map(|gap| {
                format!(
                    "{log}: {} records are missing from {:.3} s to {:.3} s, because the disk was too slow",
                    gap.records, gap.since_s, gap.until_s
                )
            })
            .collect();
        let last = self.last_s;
        match &self.end {
            End::Complete => {}
            End::Cut => remarks.push(format!(
                "{log}: cut short: the log ends at {last:.3} s without its end, and is exported as far as that"
            )),
            End::Damaged(fault) => remarks.push(format!(
                "{log}: damaged after {last:.3} s ({fault}), and exported as far as that"
            )),
        }
        remarks
    }
}

impl Channel {
    /// A message's values. Bytes of another encoding are given as the log gives the link's: as `text`, or as `base64`.
    fn value(&self, source: &Source, header: &mcap::records::MessageHeader, data: &[u8]) -> Result<Value, Error> {
        use base64::Engine as _;
        if self.json {
            return serde_json::from_slice(data).map_err(|error| Error::Message {
                path: source.path().to_owned(),
                topic: self.topic.clone(),
                sequence: header.sequence,
                source: error,
            });
        }
        Ok(match std::str::from_utf8(data) {
            Ok(text) => serde_json::json!({ "text": text }),
            Err(_) => serde_json::json!({ "base64": base64::engine::general_purpose::STANDARD.encode(data) }),
        })
    }
}

/// A gap, if the message of [`INPUT`] is one. Few are, and the others can be large.
fn gap(data: &[u8]) -> Option<Gap> {
    data.starts_with(br#"{"input":"gap""#)
        .then(|| serde_json::from_slice(data).ok())
        .flatten()
}

fn foreign(source: &Source, end: &End) -> Error {
    let what = match end {
        End::Complete => "is MCAP, but not of backseat (it has no metadata record named backseat)".to_owned(),
        End::Cut => "is cut off before it says which run it is of".to_owned(),
        End::Damaged(fault) => format!("is damaged before it says which run it is of ({fault})"),
    };
    Error::no_log(source.path(), what)
}

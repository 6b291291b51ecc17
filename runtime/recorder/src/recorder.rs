use std::borrow::Cow;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;
use std::time::Duration;

use backseat_core::plugin::{Event, NavigationSample, StepInput};
use backseat_core::{Input, Note, Output, Start, ToSonar};
use backseat_units::Timestamp;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions};
use serde::Serialize;

use crate::channel::Channel;
use crate::error::RecorderError;
use crate::header::{COMPONENTS, Header, RUN, Rate};
use crate::message::{ControlRef, InputRef, Line, NavigationRow, NoteRef, OutputRef, RequestRef};
use crate::request::ReturnedRef;

/// A chunk that is larger than this is closed, bytes. At this size it is still in the processor's cache when it is
/// copied, and closing it costs little.
const CHUNK_SIZE: u64 = 256 << 10;

/// Writes the log of a run. The crate's documentation describes the format.
///
/// If dropped without [`Recorder::finish`], it still writes the file's end, but errors are lost.
pub struct Recorder<W: Write + Seek> {
    writer: mcap::Writer<W>,
    /// The file's path, for errors.
    log: String,
    /// MCAP identifiers, in the order of [`Channel::ALL`].
    ids: [u16; Channel::ALL.len()],
    rate: Rate,
    utc_at_start_ns: u64,
    sequence: u32,
    flush_at: Timestamp,
    navigation: Decimation,
    truth: Decimation,
    /// The current message, kept to reuse its allocation.
    json: Vec<u8>,
    /// The line of a note, kept to reuse its allocation.
    text: String,
}

impl Recorder<BufWriter<File>> {
    /// Creates a log file, and replaces an existing one.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Create`] and [`RecorderError::Write`], with the path.
    pub fn create(path: &Path, header: &Header<'_>) -> Result<Self, RecorderError> {
        let file = File::create(path).map_err(|source| RecorderError::Create {
            path: path.to_owned(),
            source,
        })?;
        Self::named(BufWriter::new(file), path.display().to_string(), header)
    }
}

impl<W: Write + Seek> Recorder<W> {
    /// Writes a log to any writer.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn new(writer: W, header: &Header<'_>) -> Result<Self, RecorderError> {
        Self::named(writer, "in memory".to_owned(), header)
    }

    /// Writes a log to any writer, with a name for errors.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn named(writer: W, log: String, header: &Header<'_>) -> Result<Self, RecorderError> {
        let (writer, ids) = open(writer, header).map_err(|source| write_error(&log, source))?;
        Ok(Self {
            writer,
            log,
            ids,
            rate: header.rate,
            utc_at_start_ns: header.utc_at_start.as_unix_nanos(),
            sequence: 0,
            flush_at: Timestamp::ZERO + header.rate.flush_period(),
            navigation: Decimation::new(header.rate.period()),
            truth: Decimation::new(header.rate.period()),
            json: Vec::with_capacity(1024),
            text: String::with_capacity(256),
        })
    }

    /// Records the values with which core was started. This comes before the first input, so that a replay starts core
    /// in the same way.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn start(&mut self, start: &Start) -> Result<(), RecorderError> {
        self.put_json(Channel::Input, Timestamp::ZERO, &InputRef::Start { start })
    }

    /// Records the values with which a later process of a simulation was started. (A deployed process has a log of its
    /// own.)
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn restart(&mut self, now: Timestamp, start: &Start) -> Result<(), RecorderError> {
        self.put_json(Channel::Input, now, &InputRef::Start { start })
    }

    /// Records an input. Call this before or after core handles it, but before recording its outputs.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn input(&mut self, now: Timestamp, input: &Input<'_>) -> Result<(), RecorderError> {
        let message = match input {
            Input::Received(bytes) => return self.put(Channel::FromVehicle, now, bytes),
            // The most frequent input is written without the encoder.
            Input::Timeout => return self.put(Channel::Input, now, br#"{"input":"timeout"}"#),
            Input::LinkUp => InputRef::LinkUp,
            Input::LinkDown => InputRef::LinkDown,
            Input::Returned(plugin, returned) => InputRef::Returned {
                plugin: *plugin,
                returned: ReturnedRef(returned),
            },
            Input::Restarted(plugin, restarted) => InputRef::Restarted {
                plugin: *plugin,
                restarted,
            },
            Input::Operator(act) => InputRef::Operator { act },
            Input::External(external, bytes) => InputRef::External {
                external: *external,
                bytes,
            },
            Input::Sonar(report) => InputRef::Sonar { report },
            Input::UtcSet(by_nanos) => InputRef::UtcSet { by_nanos: *by_nanos },
            Input::Reserved(reservation) => InputRef::Reserved {
                reservation: *reservation,
            },
        };
        self.put_json(Channel::Input, now, &message)
    }

    /// Records an output.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn output(&mut self, now: Timestamp, output: &Output) -> Result<(), RecorderError> {
        let message = match output {
            Output::Send(bytes) => return self.put(Channel::ToVehicle, now, bytes),
            Output::Note(note) => return self.note(now, note),
            Output::Connect { after } => OutputRef::Connect {
                after_s: after.as_secs_f64(),
            },
            Output::ResetLink => OutputRef::ResetLink,
            Output::Invoke(plugin, step) => {
                let without_samples = match self.rate {
                    Rate::Simulation => None,
                    Rate::Deployed => Some(without_samples(step)),
                };
                let (plugin, step) = (*plugin, without_samples.as_deref());
                return self.put_json(Channel::Output, now, &OutputRef::Invoke { plugin, step });
            }
            // What the client is told of the vehicle is in the vehicle's own sentences.
            Output::Sonar(ToSonar::Navigation(..) | ToSonar::SoundSpeed { .. }) => return Ok(()),
            Output::Sonar(order) => OutputRef::Sonar { order },
            Output::External(external, bytes) => OutputRef::External {
                external: *external,
                bytes,
            },
            Output::Restart(plugin) => OutputRef::Restart { plugin: *plugin },
            Output::Reserve(reservation) => OutputRef::Reserve {
                reservation: *reservation,
            },
            Output::Finish => OutputRef::Finish,
        };
        self.put_json(Channel::Output, now, &message)
    }

    /// Records navigation as the safety monitor uses it; in simulation only once a second.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn navigation(&mut self, now: Timestamp, sample: &NavigationSample) -> Result<(), RecorderError> {
        if !self.navigation.take(now) {
            return Ok(());
        }
        self.put_json(Channel::Navigation, now, &NavigationRow::from(sample))
    }

    /// Records that records were left out from `since` until now.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn gap(&mut self, now: Timestamp, since: Timestamp, records: u64) -> Result<(), RecorderError> {
        let since_s = since.since(Timestamp::ZERO).as_secs_f64();
        self.put_json(Channel::Input, now, &InputRef::Gap { since_s, records })
    }

    /// Whether [`Recorder::truth`] would write anything now, so that a caller can avoid needless work.
    #[must_use]
    pub fn truth_is_due(&self, now: Timestamp) -> bool {
        self.truth.is_due(now)
    }

    /// Records the simulation's truth, a JSON object; in simulation only once a second.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`]; [`RecorderError::Encode`] if it cannot be written as JSON.
    pub fn truth(&mut self, now: Timestamp, json: &impl Serialize) -> Result<(), RecorderError> {
        if !self.truth.take(now) {
            return Ok(());
        }
        self.put_json(Channel::Truth, now, json)
    }

    /// Records a line of the simulated vehicle's own log.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn vehicle_event(&mut self, now: Timestamp, text: &str) -> Result<(), RecorderError> {
        self.put_json(Channel::Vehicle, now, &Line { text })
    }

    /// Closes the open chunk and hands it to the operating system. This also happens by itself as the run's time
    /// passes. A driver calls it when no record may come for a long time.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn flush(&mut self) -> Result<(), RecorderError> {
        self.writer.flush().map_err(|source| write_error(&self.log, source))
    }

    /// Writes the file's end: summary, indexes, footer.
    ///
    /// # Errors
    /// [`RecorderError::Write`].
    pub fn finish(mut self) -> Result<(), RecorderError> {
        match self.writer.finish() {
            Ok(_) => Ok(()),
            Err(source) => Err(write_error(&self.log, source)),
        }
    }

    fn note(&mut self, now: Timestamp, note: &Note) -> Result<(), RecorderError> {
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        write!(text, "{note}").expect("a String takes everything");
        #[expect(clippy::wildcard_enum_match_arm, reason = "all other notes go to one channel")]
        let result = match note {
            Note::Request(transition) => self.put_json(Channel::Requests, now, &RequestRef::new(&text, transition)),
            Note::Control { granted, reason } => {
                let message = ControlRef {
                    text: &text,
                    granted: *granted,
                    reason: reason.map_or("", |reason| reason.text()),
                    cause: reason.map(|reason| reason.name()),
                };
                self.put_json(Channel::Control, now, &message)
            }
            other => self.put_json(
                Channel::Notes,
                now,
                &NoteRef {
                    text: &text,
                    note: other,
                },
            ),
        };
        self.text = text;
        result
    }

    fn put_json(&mut self, channel: Channel, now: Timestamp, message: &impl Serialize) -> Result<(), RecorderError> {
        let mut json = std::mem::take(&mut self.json);
        json.clear();
        let result = match serde_json::to_writer(&mut json, message) {
            Ok(()) => self.put(channel, now, &json),
            Err(source) => Err(RecorderError::Encode {
                log: self.log.clone(),
                channel: channel.topic(),
                source,
            }),
        };
        self.json = json;
        result
    }

    fn put(&mut self, channel: Channel, now: Timestamp, data: &[u8]) -> Result<(), RecorderError> {
        let time = self.utc_at_start_ns.saturating_add(now.as_nanos());
        let header = MessageHeader {
            channel_id: self.ids[channel as usize],
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer
            .write_to_known_channel(&header, data)
            .map_err(|source| write_error(&self.log, source))?;
        if now >= self.flush_at {
            self.flush_at = now + self.rate.flush_period();
            self.flush()?;
        }
        Ok(())
    }
}

type Opened<W> = (mcap::Writer<W>, [u16; Channel::ALL.len()]);

/// Opens the file and writes everything that is known before the run.
fn open<W: Write + Seek>(writer: W, header: &Header<'_>) -> Result<Opened<W>, McapError> {
    let mut writer = WriteOptions::new()
        .library(concat!("backseat ", env!("CARGO_PKG_VERSION")))
        .chunk_size(Some(CHUNK_SIZE))
        // Chunks are assembled in memory, so that a killed process leaves only whole ones.
        .disable_seeking(true)
        .create(writer)?;
    let time = header.utc_at_start.as_unix_nanos();
    for (name, metadata) in [(RUN, header.run()), (COMPONENTS, header.component_hashes())] {
        writer.write_metadata(&Metadata {
            name: name.to_owned(),
            metadata,
        })?;
    }
    for (name, media_type, data) in header.attachments() {
        writer.attach(&mcap::Attachment {
            log_time: time,
            create_time: time,
            name: name.into_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        })?;
    }
    // Even a process that is killed in its first seconds has then recorded its task.
    writer.flush()?;
    let mut ids = [0; Channel::ALL.len()];
    for (id, channel) in ids.iter_mut().zip(Channel::ALL) {
        let schema = match channel.schema() {
            Some((name, schema)) => writer.add_schema(name, "jsonschema", schema.as_bytes())?,
            None => 0,
        };
        *id = writer.add_channel(schema, channel.topic(), channel.encoding(), &Default::default())?;
    }
    Ok((writer, ids))
}

fn write_error(log: &str, source: McapError) -> RecorderError {
    RecorderError::Write {
        log: log.to_owned(),
        source: Box::new(source),
    }
}

/// Passes the first message of each period, counted from time zero: the first of each second, not one a second after
/// another, so that channels stay in step.
struct Decimation {
    period: Duration,
    next: Timestamp,
}

impl Decimation {
    const fn new(period: Duration) -> Self {
        Self {
            period,
            next: Timestamp::ZERO,
        }
    }

    fn is_due(&self, now: Timestamp) -> bool {
        now >= self.next
    }

    fn take(&mut self, now: Timestamp) -> bool {
        if !self.is_due(now) {
            return false;
        }
        if !self.period.is_zero() {
            let period_ns = u64::try_from(self.period.as_nanos()).unwrap_or(u64::MAX);
            let begun = Timestamp::from_nanos(now.as_nanos() / period_ns * period_ns);
            self.next = begun + self.period;
        }
        true
    }
}

/// A step's input without the samples of its pings, which the inputs of core have already.
fn without_samples(step: &StepInput) -> Cow<'_, StepInput> {
    let is_ping = |event: &Event| matches!(event, Event::Sidescan(_) | Event::SubBottom(_));
    if !step.events.iter().any(is_ping) {
        return Cow::Borrowed(step);
    }
    let mut step = step.clone();
    for event in &mut step.events {
        if let Event::Sidescan(ping) | Event::SubBottom(ping) = event {
            for channel in &mut ping.channels {
                channel.samples = Vec::new();
            }
        }
    }
    Cow::Owned(step)
}

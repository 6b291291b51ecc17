use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use backseat_core::plugin::{Measure, NavigationSample, PluginId};
use backseat_core::{Input, LeaseReach, Note, Output, Start};
use backseat_units::{LocalFrame, Position, Timestamp};
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions};
use serde::Serialize;
use serde_json::{Value, json};

use crate::channel::Channel;
use crate::decimation::Decimation;
use crate::encode::{Place, write_input, write_output};
use crate::error::RecorderError;
use crate::header::{COMPONENT_LIMIT, Header, Preamble, Rate, version_name};
use crate::measures::{Measures, SCHEMA};
use crate::message::{AskedRef, InputRef, Line, NavigationRow, RemarkRef};
use crate::plain;
use crate::remark::Remark;
use crate::shadow::ShadowStep;
use crate::view::{Batch, Moment, Topic, View};

/// A chunk that is larger than this is closed, bytes. At this size it is still in the processor's cache when it is
/// copied, and closing it costs little.
const CHUNK_SIZE: u64 = 256 << 10;
/// The encoding of all messages.
const ENCODING: &str = "json";

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
    /// In which the log counts metres.
    frame: LocalFrame,
    sequence: u32,
    flush_at: Timestamp,
    navigation: Decimation,
    truth: Decimation,
    /// The current message, kept to reuse its allocation.
    json: Vec<u8>,
    /// The line of a note, kept to reuse its allocation.
    text: String,
    view: View,
    /// Messages of derived channels that were not yet written.
    derived: Batch,
    /// MCAP identifiers of derived channels; `None` until the first message.
    derived_ids: [Option<u16>; Topic::COUNT],
    measures: Measures,
    /// What each part of the log begins with.
    preamble: Preamble,
    /// The time of the newest message.
    newest: Timestamp,
    /// The topics by MCAP identifier.
    topics: BTreeMap<u16, String>,
    /// The versions that this file has, by SHA-256.
    versions: BTreeSet<String>,
    listener: Option<Listener>,
}

/// Is told each message as it is recorded: the run's time, the topic and the message.
pub type Listener = Box<dyn FnMut(Timestamp, &str, &[u8]) + Send>;

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
        let preamble = Preamble::of(header);
        let components = header.components.iter().map(|(name, data)| (name, data.as_slice()));
        let (writer, ids) = open(writer, &preamble, components).map_err(|source| write_error(&log, source))?;
        Ok(Self {
            writer,
            log,
            ids,
            rate: header.rate,
            utc_at_start_ns: header.utc_at_start.as_unix_nanos(),
            frame: LocalFrame::new(header.origin),
            sequence: 0,
            flush_at: Timestamp::ZERO + header.rate.flush_period(),
            navigation: Decimation::new(header.rate.period()),
            truth: Decimation::new(header.rate.period()),
            json: Vec::with_capacity(1024),
            text: String::with_capacity(256),
            view: View::new(header),
            derived: Batch::default(),
            derived_ids: [None; Topic::COUNT],
            measures: Measures::new(header),
            preamble,
            newest: Timestamp::ZERO,
            topics: BTreeMap::new(),
            versions: BTreeSet::new(),
            listener: None,
        })
    }

    /// Has somebody listen to every message from now on. Before the first message, that is all of them.
    pub fn listen(&mut self, listener: Listener) {
        let topics = Channel::ALL.into_iter().zip(self.ids);
        self.topics
            .extend(topics.map(|(channel, id)| (id, channel.topic().to_owned())));
        self.listener = Some(listener);
    }

    /// Tells the listener something that is not recorded.
    pub fn tell(&mut self, now: Timestamp, topic: &str, data: &[u8]) {
        if let Some(listener) = &mut self.listener {
            listener(now, topic, data);
        }
    }

    /// Ends the file in order, and goes on in another one, which is the log's next part. It begins with the same facts and
    /// texts, but has the components by their hashes alone. [`crate::join`] makes one log of all parts.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`], about either file. Whatever comes next is written to the new one.
    pub fn turn(&mut self, writer: W, log: String) -> Result<(), RecorderError> {
        self.preamble.next_part();
        let (writer, ids) = open(writer, &self.preamble, []).map_err(|source| write_error(&log, source))?;
        self.ids = ids;
        self.derived_ids = [None; Topic::COUNT];
        self.measures.forget_channels();
        self.versions.clear();
        let mut ended = std::mem::replace(&mut self.writer, writer);
        let ended_log = std::mem::replace(&mut self.log, log);
        // A viewer of this part alone sees the fence.
        self.view.started(&mut self.derived);
        self.put_derived(self.newest)?;
        ended.finish().map_err(|source| write_error(&ended_log, source))?;
        Ok(())
    }

    /// Records that somebody at a console has asked for something, as a line of `/log`. It changes nothing by itself: what
    /// core is told is an input of its own.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn asked(&mut self, now: Timestamp, text: &str) -> Result<(), RecorderError> {
        self.put_json(Channel::Notes, now, &AskedRef { note: "asked", text })?;
        self.view.asked(self.moment(now), text, &mut self.derived);
        self.put_derived(now)
    }

    /// Attaches the component of a version that is about to take a plugin's place, unless this file has it or it is larger
    /// than [`crate::COMPONENT_LIMIT`]. A reader finds it before the input that says so.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn version(&mut self, now: Timestamp, sha256: &str, component: &[u8]) -> Result<(), RecorderError> {
        if component.len() > COMPONENT_LIMIT || !self.versions.insert(sha256.to_owned()) {
            return Ok(());
        }
        let time = self.moment(now).utc_ns;
        let attachment = mcap::Attachment {
            log_time: time,
            create_time: time,
            name: version_name(sha256),
            media_type: "application/wasm".to_owned(),
            data: Cow::Borrowed(component),
        };
        self.writer
            .attach(&attachment)
            .map_err(|source| write_error(&self.log, source))
    }

    /// Records where the live modify can lead now, or that nothing steers any more.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn reach(&mut self, now: Timestamp, reach: Option<&LeaseReach>) -> Result<(), RecorderError> {
        self.view.reach(&self.frame, reach, &mut self.derived);
        self.put_derived(now)
    }

    /// Records what a plugin that is in the shadow of another one has asked for in a step.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn shadow(&mut self, now: Timestamp, step: &ShadowStep) -> Result<(), RecorderError> {
        self.derived.add(Topic::Shadow, |out| {
            plain::write(out, step).expect("a Vec takes every step");
        });
        self.put_derived(now)
    }

    /// Records the values with which core was started. This comes before the first input, so that a replay starts core
    /// in the same way.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn start(&mut self, start: &Start) -> Result<(), RecorderError> {
        self.put_json(Channel::Input, Timestamp::ZERO, &InputRef::Start { start })?;
        self.view.started(&mut self.derived);
        self.put_derived(Timestamp::ZERO)
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
        self.put_input(now, input)?;
        self.view.input(self.moment(now), input, &mut self.derived);
        self.put_derived(now)
    }

    fn put_input(&mut self, now: Timestamp, input: &Input<'_>) -> Result<(), RecorderError> {
        let mut json = std::mem::take(&mut self.json);
        json.clear();
        let result = match write_input(&mut json, input) {
            Ok(channel) => self.put(channel, now, &json),
            Err(source) => Err(self.encode_error(Channel::Input, source)),
        };
        self.json = json;
        result
    }

    /// Records an output.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn output(&mut self, now: Timestamp, output: &Output) -> Result<(), RecorderError> {
        self.put_output(now, output)?;
        self.view.output(self.moment(now), output, &mut self.derived);
        self.put_derived(now)
    }

    fn put_output(&mut self, now: Timestamp, output: &Output) -> Result<(), RecorderError> {
        let mut json = std::mem::take(&mut self.json);
        json.clear();
        let result = match write_output(&mut json, &mut self.text, self.rate, output) {
            Ok(None) => Ok(()),
            Ok(Some(Place::Channel(channel))) => self.put(channel, now, &json),
            Ok(Some(Place::Measure(plugin, measure))) => self
                .measure_id(plugin, measure)
                .and_then(|id| self.put_message(id, now, &json)),
            Err(source) => Err(self.encode_error(Channel::Output, source)),
        };
        self.json = json;
        result
    }

    /// Records what a simulation does to the process that it runs.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn remark(&mut self, now: Timestamp, remark: Remark) -> Result<(), RecorderError> {
        let text = remark.to_string();
        self.put_json(Channel::Notes, now, &RemarkRef::new(&text, remark))?;
        let note = Output::Note(Note::Text { text });
        self.view.output(self.moment(now), &note, &mut self.derived);
        self.put_derived(now)
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
        self.put_json(Channel::Navigation, now, &NavigationRow::from(sample))?;
        self.view.navigation(self.moment(now), sample, &mut self.derived);
        self.put_derived(now)
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

    /// Records the simulation's truth, a JSON object; in simulation only once a second. Its property `local` becomes
    /// that of its `position` in the log's frame, because the world has an origin of its own.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`]; [`RecorderError::Encode`] if it cannot be written as JSON.
    pub fn truth(&mut self, now: Timestamp, json: &impl Serialize) -> Result<(), RecorderError> {
        if !self.truth.take(now) {
            return Ok(());
        }
        let truth = serde_json::to_value(json).map_err(|source| self.encode_error(Channel::Truth, source))?;
        self.put_json(Channel::Truth, now, &in_frame(&self.frame, truth))
    }

    /// Records a line of the simulated vehicle's own log.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Write`].
    pub fn vehicle_event(&mut self, now: Timestamp, text: &str) -> Result<(), RecorderError> {
        self.put_json(Channel::Vehicle, now, &Line { text })?;
        self.view.vehicle_event(self.moment(now), text, &mut self.derived);
        self.put_derived(now)
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
        self.view.finish(&mut self.derived);
        self.put_derived(self.newest)?;
        match self.writer.finish() {
            Ok(_) => Ok(()),
            Err(source) => Err(write_error(&self.log, source)),
        }
    }

    /// The channel of a published value.
    fn measure_id(&mut self, plugin: PluginId, measure: &Measure) -> Result<u16, RecorderError> {
        let Self {
            measures,
            writer,
            log,
            topics,
            ..
        } = self;
        measures.channel(plugin, &measure.name, |topic, schema| {
            let id = writer
                .add_schema(SCHEMA, "jsonschema", schema.as_bytes())
                .and_then(|schema| writer.add_channel(schema, topic, ENCODING, &BTreeMap::new()))
                .map_err(|source| write_error(log, source))?;
            topics.insert(id, topic.to_owned());
            Ok(id)
        })
    }

    fn put_json(&mut self, channel: Channel, now: Timestamp, message: &impl Serialize) -> Result<(), RecorderError> {
        let mut json = std::mem::take(&mut self.json);
        json.clear();
        let result = match plain::write(&mut json, message) {
            Ok(()) => self.put(channel, now, &json),
            Err(source) => Err(self.encode_error(channel, source)),
        };
        self.json = json;
        result
    }

    fn encode_error(&self, channel: Channel, source: serde_json::Error) -> RecorderError {
        RecorderError::Encode {
            log: self.log.clone(),
            channel: channel.topic().to_owned(),
            source,
        }
    }

    fn put(&mut self, channel: Channel, now: Timestamp, data: &[u8]) -> Result<(), RecorderError> {
        self.put_message(self.ids[channel as usize], now, data)
    }

    fn moment(&self, now: Timestamp) -> Moment {
        Moment {
            now,
            utc_ns: self.utc_at_start_ns.saturating_add(now.as_nanos()),
        }
    }

    /// Writes what was derived from the last record.
    fn put_derived(&mut self, now: Timestamp) -> Result<(), RecorderError> {
        if self.derived.is_empty() {
            return Ok(());
        }
        let mut derived = std::mem::take(&mut self.derived);
        for (topic, message) in derived.messages() {
            let id = self.derived_id(topic)?;
            self.put_message(id, now, message)?;
        }
        derived.clear();
        self.derived = derived;
        Ok(())
    }

    /// The channel of a topic, which its first message adds.
    fn derived_id(&mut self, topic: Topic) -> Result<u16, RecorderError> {
        let place = topic.place();
        if let Some(id) = self.derived_ids[place] {
            return Ok(id);
        }
        let (name, schema) = topic.schema();
        let id = self
            .writer
            .add_schema(&name, "jsonschema", schema.as_bytes())
            .and_then(|schema| {
                self.writer
                    .add_channel(schema, &topic.name(), ENCODING, &BTreeMap::new())
            })
            .map_err(|source| write_error(&self.log, source))?;
        self.derived_ids[place] = Some(id);
        self.topics.insert(id, topic.name());
        Ok(id)
    }

    fn put_message(&mut self, channel_id: u16, now: Timestamp, data: &[u8]) -> Result<(), RecorderError> {
        let time = self.utc_at_start_ns.saturating_add(now.as_nanos());
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.newest = self.newest.max(now);
        if let Some(listener) = &mut self.listener
            && let Some(topic) = self.topics.get(&channel_id)
        {
            listener(now, topic, data);
        }
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
fn open<'a, W: Write + Seek>(
    writer: W,
    preamble: &'a Preamble,
    components: impl IntoIterator<Item = (&'a String, &'a [u8])>,
) -> Result<Opened<W>, McapError> {
    let mut writer = WriteOptions::new()
        .library(concat!("backseat ", env!("CARGO_PKG_VERSION")))
        .chunk_size(Some(CHUNK_SIZE))
        // Chunks are assembled in memory, so that a killed process leaves only whole ones.
        .disable_seeking(true)
        .create(writer)?;
    for metadata in preamble.metadata() {
        writer.write_metadata(metadata)?;
    }
    for attachment in preamble.attachments(components) {
        writer.attach(&attachment)?;
    }
    // Even a process that is killed in its first seconds has then recorded its task.
    writer.flush()?;
    let mut ids = [0; Channel::ALL.len()];
    for (id, channel) in ids.iter_mut().zip(Channel::ALL) {
        let (name, schema) = channel.schema();
        let schema = writer.add_schema(name, "jsonschema", schema.as_bytes())?;
        *id = writer.add_channel(schema, channel.topic(), ENCODING, &BTreeMap::new())?;
    }
    Ok((writer, ids))
}

/// The truth with its place in this frame.
fn in_frame(frame: &LocalFrame, mut truth: Value) -> Value {
    let degrees = |key: &str| truth["position"][key].as_f64();
    let position = degrees("latitude_deg").zip(degrees("longitude_deg"));
    let position =
        position.and_then(|(latitude_deg, longitude_deg)| Position::from_deg(latitude_deg, longitude_deg).ok());
    if let Some(position) = position {
        let local = frame.to_local(position);
        truth["local"] = json!({"east_m": local.east_m, "north_m": local.north_m});
    }
    truth
}

fn write_error(log: &str, source: McapError) -> RecorderError {
    RecorderError::Write {
        log: log.to_owned(),
        source: Box::new(source),
    }
}

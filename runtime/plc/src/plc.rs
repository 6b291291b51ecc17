//! The controller as a whole: it passes each input to the part that handles it.

mod admission;
mod commands;
mod faults;
mod logging;
mod steps;

use core::time::Duration;
use std::borrow::Cow;
use std::collections::VecDeque;

use backseat_s7k::plc::{PlcVersion, Status};
use backseat_s7k::record::{HeaderLayout, Record};
use backseat_s7k::{FRAME_LIMIT, Frame, SensorIndex};
use backseat_units::{Timestamp, Utc};
use backseat_world::{Span, Stream};

use crate::config::{PlcConfig, parse_version};
use crate::error::PlcError;
use crate::event::{ClientId, DropReason, PlcEvent, PlcEventKind};
use crate::faults::{Fault, FaultKind, Timeline};
use crate::interpretation::InterpretationConfig;
use crate::logging::{FileEffect, FileFailure, FileId, FilePlace, Logger};
use crate::navigation::{Navigation, Reported};
use crate::server::{Received, Server};
use crate::sonar::{Pose, SensorKind};
use crate::suite::Suite;
use crate::suite::stored;

/// The most bytes that are read at once: the controller carries out the commands of one chunk before the next.
const CHUNK: usize = 4096;

/// The most answers of sensors that one client may wait for.
const PENDING_MAX: usize = 64;

/// What an earlier run of the controller left on its disk: the contents of the files that a [`FileEffect`] wrote into
/// the controller's own folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stored {
    /// The content of `6046.sav`, the run list.
    pub run_list: Option<String>,
    /// The content of `6046.cfg`, the setting of the command "auto start".
    pub settings: Option<String>,
}

/// What a sensor answers a client after a time.
#[derive(Debug)]
enum Answer {
    Status(Status),
    Alarm(backseat_s7k::plc::Alarm),
}

/// An answer on its way.
#[derive(Debug)]
struct Pending {
    due: Timestamp,
    client: ClientId,
    answer: Answer,
}

/// The mock payload controller. See the crate's documentation for the order of calls.
#[derive(Debug)]
pub struct Plc {
    server: Server,
    suite: Suite,
    logger: Logger,
    navigation: Navigation,
    faults: Timeline,
    reading: InterpretationConfig,
    version: PlcVersion,
    layout: HeaderLayout,
    truth: Option<(Timestamp, Pose)>,
    /// The run list as it was saved last.
    saved: Option<String>,
    auto_start: bool,
    time_messages: Option<Timestamp>,
    time_message_period: Duration,
    health: Option<(Timestamp, Duration)>,
    reply_s: Span,
    sync_delay_s: Span,
    silent_after: Duration,
    critical_percent: f64,
    pending: VecDeque<Pending>,
    dice: Stream,
    stalled: bool,
    /// When the next records of a flood, or bytes of garbage, are sent.
    noise_due: Option<Timestamp>,
    noise_carry: (f64, f64),
    /// When the controller ends because its key is missing.
    key_ends: Option<Timestamp>,
    key_grace: Duration,
    shutdown_after: Duration,
    /// The shutdown that is under way: when the connections close at the earliest, and whether sensors go down first.
    shutdown: Option<(Timestamp, bool)>,
    is_shut_down: bool,
    samples: (Vec<u16>, Vec<u16>, Vec<[i16; 2]>),
}

impl Plc {
    /// A controller that starts. `utc` is the true UTC at time zero.
    ///
    /// # Errors
    /// [`PlcError`] if a value of the configuration is not allowed, or if a stored file cannot be read.
    pub fn new(config: &PlcConfig, seed: u64, utc: Utc, stored: &Stored) -> Result<Self, PlcError> {
        config.validate()?;
        let reading = config.interpretation.resolve(seed);
        let now = Timestamp::ZERO;
        let auto_start = match &stored.settings {
            Some(text) => commands::parse_settings(text)?,
            None => config.auto_start,
        };
        let entries = match &stored.run_list {
            Some(text) => stored::parse(text)?,
            None => config.sensor.clone(),
        };
        let period = Duration::from_secs_f64;
        let mut plc = Self {
            server: Server::new(config, reading, seed, utc),
            suite: Suite::new(config, seed),
            logger: Logger::new(config, seed, utc),
            navigation: Navigation::new(config.sound_speed_mps, config.bluefin_checksum.checksum()),
            faults: Timeline::new(config.plan()?),
            reading,
            version: parse_version(&config.version)?,
            layout: config.header_layout.layout(),
            truth: None,
            saved: stored.run_list.clone(),
            auto_start,
            time_messages: config.time_messages.then_some(now),
            time_message_period: period(config.time_message_period_s),
            health: config
                .health_period_s
                .map(|seconds| (now + period(seconds), period(seconds))),
            reply_s: config.reply_s,
            sync_delay_s: config.sync_delay_s,
            silent_after: period(config.silent_after_s),
            critical_percent: config.disk.critical_percent,
            pending: VecDeque::new(),
            dice: Stream::new(seed, "plc answers"),
            stalled: false,
            noise_due: None,
            noise_carry: (0.0, 0.0),
            key_ends: None,
            key_grace: period(config.key_grace_s),
            shutdown_after: period(config.shutdown_s),
            shutdown: None,
            is_shut_down: false,
            samples: (Vec::new(), Vec::new(), Vec::new()),
        };
        plc.suite.load(now, &entries, true, auto_start, &mut plc.server);
        if auto_start {
            plc.start_logging(now);
        }
        plc.check_disk(now);
        Ok(plc)
    }

    /// A client has connected. If there is no room, its connection is closed.
    pub fn connect(&mut self, now: Timestamp, client: ClientId) {
        if self.is_shut_down {
            self.server.cut_off(now, client, DropReason::ShutDown);
        } else if self.faults.acts(&FaultKind::LinkClosed) {
            self.server.cut_off(now, client, DropReason::Fault);
        } else {
            self.server.connect(now, client);
        }
    }

    /// A client's connection is gone, with its subscriptions and the bytes that wait for it.
    pub fn disconnect(&mut self, now: Timestamp, client: ClientId) {
        self.pending.retain(|pending| pending.client != client);
        self.server.disconnect(now, client);
    }

    /// Bytes of a client, cut anywhere.
    pub fn receive(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        if self.stalled {
            self.server.clients.keep(client, bytes);
            return;
        }
        for chunk in bytes.chunks(CHUNK) {
            self.server.clients.push(client, chunk);
            while let Some(received) = self.server.clients.next_received(client) {
                match received {
                    Received::Command(request) => self.command(now, client, &request),
                    Received::Other(bytes) => self.route(now, client, &bytes),
                }
            }
            if self.server.clients.is_astray(client) {
                // Nothing tells any more where its records begin: it may connect again.
                self.server.report(now, client);
                self.server.cut_off(now, client, DropReason::Astray);
                return;
            }
        }
        self.server.report(now, client);
    }

    /// Whether the controller takes bytes of this client. While it does not, a driver reads none from its socket.
    #[must_use]
    pub fn reads(&self, client: ClientId) -> bool {
        !self.stalled || self.server.clients.room(client) > 0
    }

    /// Says whether a client's connection takes no more bytes for now. What is for the client waits, up to the limit of
    /// the configuration, and what does not fit is lost.
    pub fn set_blocked(&mut self, now: Timestamp, client: ClientId, blocked: bool) {
        self.server.clients.set_blocked(client, blocked);
        self.server.report(now, client);
    }

    /// Where the vehicle truly is. The controller hands it to the sonar, and uses it for nothing else. There is no ping
    /// before the first pose.
    pub fn truth(&mut self, now: Timestamp, pose: Pose) {
        self.truth = Some((now, pose));
    }

    /// What clients said of the vehicle; `None` before the first navigation frame that came to the vehicle's sensor. A
    /// driver without a vehicle of its own makes the truth from it.
    #[must_use]
    pub fn reported(&self) -> Option<Reported> {
        self.navigation.reported()
    }

    /// The driver's disk has a log file of an earlier run: its name is not used again.
    pub fn keep_file(&mut self, place: FilePlace) {
        self.logger.keep(place);
    }

    /// Shuts the controller down, as command 13 with the parameter 0 does: the log file ends, and all clients get status
    /// 7.
    pub fn shut_down(&mut self, now: Timestamp) {
        if !self.is_shut_down {
            self.begin_shutdown(now, false);
        }
    }

    /// The driver could not carry out an effect on this file.
    pub fn file_failed(&mut self, now: Timestamp, file: FileId, failure: FileFailure) {
        self.server.note(now, PlcEventKind::FileFailed(failure));
        if failure == FileFailure::Full {
            self.logger.set_free(0);
        }
        if self.logger.current().is_some_and(|(current, ..)| current == file) {
            self.stop_logging(now, logging::stop_reason(failure));
        }
        self.check_disk(now);
    }

    /// Says how many bytes are free on the driver's disk. Without it the controller counts for itself what it writes, from
    /// what its configuration says.
    pub fn set_disk_free(&mut self, now: Timestamp, bytes: u64) {
        self.logger.set_free(bytes);
        self.check_disk(now);
    }

    /// Injects a fault: it begins with the next [`Plc::handle_timeout`], which is due at once, whatever its `at` says.
    /// Returns its number, which follows those of the plan.
    pub fn inject(&mut self, now: Timestamp, fault: Fault) -> u32 {
        self.faults.inject(now, fault)
    }

    /// The next client to write to, whose bytes replace what is in `out`.
    pub fn poll_transmit(&mut self, out: &mut Vec<u8>) -> Option<ClientId> {
        self.server.clients.poll_transmit(out)
    }

    /// The next client whose connection the driver closes.
    pub fn poll_disconnect(&mut self) -> Option<ClientId> {
        self.server.clients.poll_disconnect()
    }

    /// The next thing to do with a file.
    pub fn poll_file(&mut self) -> Option<FileEffect> {
        self.logger.poll()
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<PlcEvent> {
        self.server.poll_event()
    }

    /// Whether the controller is shut down. Then nothing happens any more; a driver makes a new one for the next start.
    #[must_use]
    pub const fn is_shut_down(&self) -> bool {
        self.is_shut_down
    }

    /// UTC by the controller's clock.
    #[must_use]
    pub fn utc(&self, now: Timestamp) -> Utc {
        self.server.clock.utc(now)
    }

    /// How this run reads what the specification leaves open.
    #[must_use]
    pub const fn interpretation(&self) -> &InterpretationConfig {
        &self.reading
    }

    /// How many bytes wait for a client.
    #[must_use]
    pub fn waiting(&self, client: ClientId) -> usize {
        self.server.clients.waiting(client)
    }

    /// How many Bluefin frames came with a wrong checksum. They were used all the same.
    #[must_use]
    pub const fn wrong_bluefin_checksums(&self) -> u64 {
        self.navigation.wrong_checksums()
    }

    /// The index and the kind of each sensor of the run list, and whether it pings.
    #[must_use]
    pub fn sensors(&self) -> Vec<(SensorIndex, SensorKind, bool)> {
        let state = |sensor: &crate::suite::sensor::Sensor| (sensor.index, sensor.kind, sensor.pings());
        self.suite.sensors().map(state).collect()
    }

    /// A record of a client that is not for the controller goes to the sensor that is set for it (command 24).
    fn route(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        let Ok(frame) = Frame::read(bytes, FRAME_LIMIT) else {
            return;
        };
        let index = self.suite.route().unwrap_or(SensorIndex::PLC);
        let target = self
            .suite
            .sensor(index)
            .map(|sensor| (sensor.kind, sensor.is_running(), sensor.silent_since));
        let fault = match target {
            None => Cow::Borrowed("no sensor is set for messages"),
            Some((_, false, _)) => Cow::Borrowed("the sensor has not started"),
            Some((_, true, Some(_))) => Cow::Borrowed("the sensor does not respond"),
            Some((SensorKind::Bluefin, true, None)) => match Record::read(&frame) {
                Ok(Record::Bluefin(record)) => match record.check() {
                    Ok(()) => {
                        self.navigation.take(now, &record);
                        self.vehicle_data(now, index, &record);
                        return;
                    }
                    Err(fault) => {
                        self.server.clients.count_ignored(client);
                        Cow::Owned(fault.to_string())
                    }
                },
                Ok(_) => Cow::Borrowed("the sensor takes records 3100 only"),
                Err(_) => {
                    self.server.clients.count_ignored(client);
                    Cow::Borrowed("the record cannot be read")
                }
            },
            Some((SensorKind::SubBottom | SensorKind::SidescanLow | SensorKind::SidescanHigh, true, None)) => {
                Cow::Borrowed("the sensor takes no messages")
            }
        };
        let alarm = backseat_s7k::plc::Alarm::RouteFailed {
            sensor: index,
            client: client_number(client),
            description: Box::from(format!("record {}: {fault}", frame.header().record_type)),
        };
        self.server.warn_about(now, client, alarm);
    }
}

/// The client's number in alarms.
fn client_number(client: ClientId) -> i32 {
    i32::try_from(client.0).unwrap_or(i32::MAX)
}

//! What the controller sends.

use backseat_s7k::plc::{Alarm, HealthEntry, RunListEntry, Status};
use backseat_s7k::record::{Acknowledge, MessageRecord, MessageType, Record};
use backseat_s7k::{Checksum, Frame, SensorIndex, StreamItem, Time7k};

use super::{Link, Sonar};
use crate::alarm::{ALARM_BYTES, AlarmState, Change};
use crate::config::ChecksumPolicy;
use crate::event::Event;
use crate::exchange::Heard;
use crate::job::status_id;
use crate::logging::FileDetails;
use crate::record::{first, text_of};

/// How much of a status is read, bytes: lists of some hundred entries.
const STATUS_BYTES: usize = 8192;
/// How much of a path is kept, bytes.
const PATH_BYTES: usize = 260;

impl Sonar {
    pub(super) fn received(&mut self, bytes: &[u8]) {
        if !matches!(self.link, Link::Up { .. }) {
            // What was under way when the connection was reset.
            return;
        }
        let mut reader = core::mem::take(&mut self.reader);
        reader.push(bytes);
        while matches!(self.link, Link::Up { .. }) {
            match reader.next() {
                Some(StreamItem::Record(frame)) => self.record(&frame),
                Some(StreamItem::Skipped { bytes, why }) => {
                    self.counts.skipped_bytes += bytes as u64;
                    self.note_malformed(&why);
                }
                None => {
                    self.reader = reader;
                    return;
                }
            }
        }
    }

    fn record(&mut self, frame: &Frame<'_>) {
        if self.config.checksum != ChecksumPolicy::Ignore
            && let Checksum::Wrong { .. } = frame.checksum()
        {
            self.counts.wrong_checksums += 1;
            if self.config.checksum == ChecksumPolicy::Refuse {
                return;
            }
        }
        match Record::read(frame) {
            Ok(Record::SideScan(imagery)) => self.imagery(frame, &imagery, false),
            Ok(Record::SubBottom(imagery)) => self.imagery(frame, &imagery, true),
            Ok(Record::Time(..)) => self.time_message(&frame.header().time),
            Ok(Record::Acknowledge(acknowledge, _)) => self.acknowledge(&acknowledge, &frame.header().time),
            Ok(Record::Message(message)) => self.message(&message),
            Ok(
                Record::Bluefin(_) | Record::FileHeader(_) | Record::Catalog(_) | Record::Command(_) | Record::Other(_),
            ) => self.counts.unsubscribed += 1,
            Err(error) => self.malformed(&error),
        }
    }

    fn time_message(&mut self, time: &Time7k) {
        if let Some(controller) = time.to_utc() {
            self.controller_clock.one_way(self.now, self.utc(), controller);
            self.report_clock();
        }
    }

    fn acknowledge(&mut self, acknowledge: &Acknowledge, time: &Time7k) {
        let round_trip = self.exchanges.round_trip_of(acknowledge).zip(time.to_utc());
        let heard = self.exchanges.acknowledge(acknowledge);
        if heard == Heard::Nothing {
            self.counts.late_acknowledgements += 1;
            return;
        }
        let is_time_sync = acknowledge.command == backseat_s7k::plc::CommandId::TimeSync;
        if let Some((sent, controller)) = round_trip.filter(|_| !is_time_sync) {
            let sent = self.our_clock.utc(sent);
            self.controller_clock.round_trip(self.now, sent, self.utc(), controller);
            self.report_clock();
        }
        self.settle_heard(heard);
    }

    fn settle_heard(&mut self, heard: Heard) {
        match heard {
            Heard::Nothing | Heard::Part => {}
            Heard::Ended(end) => {
                self.end_step(end);
                self.advance();
            }
        }
    }

    #[expect(clippy::cast_precision_loss, reason = "seconds to the microsecond are enough")]
    fn report_clock(&mut self) {
        if let Some(offset) = self.controller_clock.news() {
            self.report(Event::Clock {
                offset_s: offset.nanos as f64 / 1e9,
                within_s: offset.within.map(|within| within.as_secs_f64()),
            });
        }
    }

    fn message(&mut self, message: &MessageRecord<'_>) {
        match message.header.message {
            MessageType::Status => self.status(message),
            MessageType::Alarm => self.alarm(message),
            MessageType::Other(_) => self.counts.unknown_messages += 1,
        }
    }

    fn alarm(&mut self, message: &MessageRecord<'_>) {
        let text = text_of(message.text_bytes(), ALARM_BYTES);
        let id = message.header.id;
        let alarm = match Alarm::read(id, &text) {
            Some(Ok(alarm)) => Some(alarm),
            Some(Err(error)) => {
                self.malformed(&error);
                None
            }
            None => {
                self.counts.unknown_messages += 1;
                None
            }
        };
        if alarm.as_ref().is_some_and(|alarm| self.is_of_start(alarm)) {
            return;
        }
        let state = AlarmState::new(id, message.header.mode, alarm, &text);
        match self.alarms.take(self.now, state) {
            Change::None => {}
            Change::One(alarm) => self.report(Event::Alarm { alarm }),
            Change::AllClear => self.report(Event::AlarmsClear),
            Change::NoRoom(alarm) => {
                self.counts.dropped_events += 1;
                self.report(Event::Alarm { alarm });
            }
        }
    }

    fn status(&mut self, message: &MessageRecord<'_>) {
        let text = text_of(message.text_bytes(), STATUS_BYTES);
        let id = message.header.id;
        match Status::read(id, &text) {
            Some(Ok(status)) => self.status_read(status),
            Some(Err(error)) => self.malformed(&error),
            None => self.counts.unknown_messages += 1,
        }
        // A malformed answer is an answer: asking again would bring the same.
        let heard = self.exchanges.status(id, self.config.verbose);
        self.settle_heard(heard);
    }

    fn status_read(&mut self, status: Status) {
        match status {
            Status::Version { version } => self.report(Event::Version { version }),
            Status::Modules { modules } => self.report(Event::Modules { modules }),
            Status::RunList { sensors } => self.run_list(sensors),
            Status::FileDetails { on, file, size_mb } => {
                let file = first(&file, PATH_BYTES);
                self.file_details(FileDetails { on, file, size_mb });
            }
            Status::SensorReply { pulses } => self.report(Event::Pulses { pulses }),
            Status::LoggingSetup {
                file_size,
                overlap,
                folder,
            } => self.report(Event::LoggingSetup {
                file_size,
                overlap,
                folder: first(&folder, PATH_BYTES),
            }),
            Status::Health { sensors } => self.health(sensors),
            Status::Shutdown {} => {
                if !self.controller_ends {
                    self.controller_ends = true;
                    self.tell(Event::ControllerShutdown);
                }
            }
        }
    }

    fn run_list(&mut self, sensors: Vec<RunListEntry>) {
        let configured = self.config.sensor.iter().map(|sensor| SensorIndex(sensor.index));
        let missing = configured
            .filter(|index| !sensors.iter().any(|entry| entry.sensor == *index))
            .collect();
        self.report(Event::RunList { sensors, missing });
    }

    fn file_details(&mut self, details: FileDetails) {
        self.exchanges.note_details(status_id::FILE_DETAILS, &details);
        if let Some(details) = self.logging.reported(details) {
            self.report_logging(details);
        }
    }

    fn health(&mut self, sensors: Vec<HealthEntry>) {
        if self.health != sensors {
            self.health.clone_from(&sensors);
            self.report(Event::Health { sensors });
        }
    }
}

//! What is logged and published: the records of sensors, and what the disk says of it.

use backseat_s7k::plc::{Alarm, Status};
use backseat_s7k::record::BluefinRecord;
use backseat_s7k::{FRAME_LIMIT, Frame, SensorIndex, Time7k};
use backseat_units::Timestamp;

use super::Plc;
use crate::event::{LogStop, PlcEventKind};
use crate::logging::FileFailure;
use crate::sonar::SensorKind;

/// Why logging ends after a failure.
pub(super) const fn stop_reason(failure: FileFailure) -> LogStop {
    match failure {
        FileFailure::Full => LogStop::DiskFull,
        FileFailure::Exists | FileFailure::Other => LogStop::Failed,
    }
}

impl Plc {
    pub(super) fn start_logging(&mut self, now: Timestamp) {
        let devices = self.suite.devices();
        self.logger.start(self.server.clock.utc(now), &devices);
    }

    pub(super) fn stop_logging(&mut self, now: Timestamp, why: LogStop) {
        if self.logger.is_on() {
            self.logger.stop(self.server.time(now));
            self.server.note(now, PlcEventKind::LogStopped(why));
            // A significant change of the system that nobody asked for (2.7). A client that switched logging off knows,
            // and a shutdown has a status of its own.
            match why {
                LogStop::DiskFull | LogStop::Failed => {
                    let details = self.file_details();
                    self.server.status_to_all(now, details);
                }
                LogStop::Command | LogStop::ShutDown => {}
            }
        }
    }

    /// The run list changed: the next file lists other devices.
    pub(super) fn devices_changed(&mut self, now: Timestamp) {
        let devices = self.suite.devices();
        self.logger.set_devices(self.server.clock.utc(now), &devices);
    }

    /// Logs a sensor's record, and sends it to those who subscribed.
    pub(super) fn deliver(&mut self, now: Timestamp, index: SensorIndex, kind: SensorKind, record: Vec<u8>) {
        self.log(now, &record);
        self.server.publish(now, index, kind, record);
    }

    fn log(&mut self, now: Timestamp, record: &[u8]) {
        if !self.logger.is_on() {
            return;
        }
        let Ok(frame) = Frame::read(record, FRAME_LIMIT) else {
            return;
        };
        let before = self.logger.current().map(|(file, ..)| file);
        let written = self.logger.write(&frame);
        if let Some((file, place, _)) = self.logger.current()
            && before != Some(file)
        {
            self.server.note(now, PlcEventKind::LogOpened(place));
        }
        if let Err(failure) = written {
            self.stop_logging(now, stop_reason(failure));
        }
        self.check_disk(now);
    }

    /// Alarm 1 begins and ends with the room on the disk.
    pub(super) fn check_disk(&mut self, now: Timestamp) {
        let free = self.logger.free_percent();
        // A disk without room for logging is critical, whatever part of it is left.
        if free <= self.critical_percent || !self.logger.has_room() {
            let description = Box::from(format!("{free:.1} % of the disk left"));
            self.server
                .raise(now, SensorIndex::PLC, Alarm::DiskSpaceCritical { description });
        } else {
            self.server.clear(now, 1, SensorIndex::PLC);
        }
    }

    /// The vehicle's data go into the log and to subscribers, with the frames as the client sent them.
    pub(super) fn vehicle_data(&mut self, now: Timestamp, index: SensorIndex, record: &BluefinRecord<'_>) {
        let kind = SensorKind::Bluefin;
        let first = record.frames().next();
        let time: Time7k = first.map_or_else(|| self.server.time(now), |frame| frame.header.time);
        let body = *record;
        let record = self.server.record(time, kind.record_type(), kind.device(), |frame| {
            backseat_s7k::record::Record::Bluefin(body).write(frame.bytes());
        });
        self.deliver(now, index, kind, record);
    }

    /// Status 3: the state of logging.
    pub(super) fn file_details(&self) -> Status {
        let (file, bytes) = match self.logger.place() {
            Some((place, bytes)) => (place.to_string(), bytes),
            None => (String::new(), 0),
        };
        Status::FileDetails {
            on: self.logger.is_on(),
            file: file.into_boxed_str(),
            size_mb: bytes as f64 / 1e6,
        }
    }
}

//! What the begin and the end of a fault do.

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Alarm, Status};
use backseat_units::Timestamp;

use super::Plc;
use crate::event::{DropReason, LogStop, PlcEventKind};
use crate::faults::{FaultEdge, FaultKind};

impl Plc {
    /// The next fault of the plan begins or ends.
    pub(super) fn fault_edge(&mut self, now: Timestamp) {
        let Some((number, edge, kind)) = self.faults.advance() else {
            return;
        };
        self.server.note(now, PlcEventKind::Fault(number, edge, kind));
        match kind {
            FaultKind::SensorDies(_) | FaultKind::SensorUnhealthy { .. } | FaultKind::DataMissing(_) => {
                self.suite.faults_changed(now, &self.faults, &mut self.server);
            }
            // These are looked up where they act.
            FaultKind::PingsDropped { .. }
            | FaultKind::StartFails(_)
            | FaultKind::ShutdownFails(_)
            | FaultKind::TimeRefused(_)
            | FaultKind::CommandsRefused(_)
            | FaultKind::ResetRefused(_) => {}
            FaultKind::DiskFull => {
                self.logger.set_full(self.faults.acts(&FaultKind::DiskFull));
                self.check_disk(now);
            }
            FaultKind::Stall => self.stall(now),
            FaultKind::Flood { .. } | FaultKind::Garbage { .. } => {
                self.noise_due.get_or_insert(now);
            }
            FaultKind::ChecksumsWrong { .. } => {
                let chance = self.faults.wrong_checksum_chance();
                self.server.set_wrong_checksum_chance(chance);
            }
            FaultKind::LinkClosed => {
                if edge == FaultEdge::Begin {
                    self.pending.clear();
                    self.server.cut_off_all(now, DropReason::Fault);
                }
            }
            FaultKind::KeyMissing => self.key(now),
        }
    }

    /// The controller stalls, or goes on and reads what has come meanwhile.
    fn stall(&mut self, now: Timestamp) {
        self.stalled = self.faults.acts(&FaultKind::Stall);
        self.server.clients.set_stalled(self.stalled);
        if !self.stalled {
            for client in self.server.clients.all() {
                let unread = self.server.clients.take_unread(client);
                self.receive(now, client, &unread);
            }
        }
    }

    fn key(&mut self, now: Timestamp) {
        if self.faults.acts(&FaultKind::KeyMissing) {
            let description = Box::from("no valid HASP key");
            self.server
                .raise(now, SensorIndex::PLC, Alarm::KeyMissing { description });
            self.key_ends.get_or_insert(now + self.key_grace);
        } else {
            self.key_ends = None;
            self.server.clear(now, 15, SensorIndex::PLC);
        }
    }

    /// Status 7 to all clients; files are closed, and connections after a time.
    pub(super) fn begin_shutdown(&mut self, now: Timestamp, with_sensors: bool) {
        if let Some((_, sensors)) = &mut self.shutdown {
            *sensors |= with_sensors;
        } else {
            self.server.note(now, PlcEventKind::ShuttingDown(with_sensors));
            self.server.status_to_all(now, Status::Shutdown {});
            self.stop_logging(now, LogStop::ShutDown);
            self.shutdown = Some((now + self.shutdown_after, with_sensors));
            self.key_ends = None;
        }
        if with_sensors {
            self.suite.remove_all(now, &mut self.server);
        } else {
            // The sensors go on by themselves; the controller only stops listening to them.
            for sensor in self.suite.sensors_mut() {
                sensor.settings.pinging = false;
                sensor.stop();
            }
        }
    }
}

use backseat_spi::{AckStatus, ChecksumState, FromVehicle, Sentence};
use backseat_units::Timestamp;
use memchr::memrchr;

use super::Oracle;
use super::wire::solution_time;

impl Oracle {
    /// A line of the vehicle's. Most are navigation, so that their names are looked at before anything is decoded.
    pub(super) fn vehicle_line(&mut self, at: Timestamp, line: &[u8]) {
        let Some(line) = memrchr(b'$', line).and_then(|start| line.get(start..)) else {
            return;
        };
        match line.get(1..6) {
            Some(b"BFNVG") => {
                if let Some(solution) = solution_time(line)
                    && self.navigation.heard(at, solution)
                {
                    self.counts.navigations += 1;
                }
            }
            Some(b"BFCTL" | b"BFMIS" | b"BFMSC" | b"BFMBS" | b"BFMBE" | b"BFACK" | b"BFPLN") => {
                let sentence = core::str::from_utf8(line)
                    .ok()
                    .and_then(|line| Sentence::parse(line).ok());
                if let Some(sentence) = sentence
                    && sentence.checksum() == ChecksumState::Valid
                    && let Ok(message) = FromVehicle::decode(&sentence)
                {
                    self.vehicle_says(at, &message);
                }
            }
            Some(_) | None => {}
        }
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "messages that no rule is about, those of later versions included"
    )]
    fn vehicle_says(&mut self, at: Timestamp, message: &FromVehicle) {
        match message {
            FromVehicle::BackseatControl(control) => {
                let change = self.control.backseat_control(at, control.granted);
                self.control_changed(at, change);
            }
            FromVehicle::MissionStatus(status) => {
                let change = self.control.mission_running(at, status.is_running());
                self.control_changed(at, change);
                if !status.is_running() {
                    self.inserts.all_end();
                }
            }
            FromVehicle::MissionCommand(command) => {
                let change = self.control.mission_command(at, command.text.as_str());
                self.control_changed(at, change);
            }
            FromVehicle::BehaviorBegin(begin) => {
                if let Some(identifier) = begin.identifier {
                    self.inserts.begins(at, identifier.get());
                }
            }
            FromVehicle::BehaviorEnd(end) => {
                if let Some(identifier) = end.identifier {
                    self.inserts.ends(identifier.get());
                }
            }
            FromVehicle::PlanElement(element) => {
                let own = element.identifier.is_none();
                self.plan.told(own.then(|| self.area.point(element.position)));
                if let Some(identifier) = element.identifier {
                    self.inserts.planned(at, identifier.get());
                }
            }
            FromVehicle::Acknowledgement(ack) => {
                let identifier = ack.behavior.map(backseat_spi::BehaviorId::get);
                let created = ack.command_created.truncated_to_millis();
                let taken = match ack.status {
                    AckStatus::Succeeded => true,
                    AckStatus::Invalid | AckStatus::Failed | AckStatus::Other(_) => false,
                    AckStatus::Pending => return,
                };
                match ack.command.as_str() {
                    "RTK" | "RTC" | "RGP" => {
                        self.inserts.answered(at, identifier, created, taken);
                        if taken {
                            let (open_max, duration_s) =
                                (self.limits.inserts_open_max, self.limits.inserts_duration_max_s);
                            self.inserts.check_open(at, open_max, duration_s, &mut self.findings);
                        }
                    }
                    "RMP" if taken => self.inserts.plan_told(),
                    "RCN" if taken => self.inserts.cancel_done(identifier, created),
                    _ => {}
                }
            }
            _ => {}
        }
    }
}

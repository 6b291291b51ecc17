use backseat_spi::{AckStatus, Acknowledgement, ChecksumState, FromVehicle, Sentence};
use backseat_units::{TimeOfDay, Timestamp};
use memchr::memrchr;

use super::Oracle;
use super::wire::fix;
use crate::rule::Rule;
use crate::services::Counted;

impl Oracle {
    /// A line of the vehicle's. Most are navigation, so that their names are looked at before anything is decoded.
    pub(super) fn vehicle_line(&mut self, at: Timestamp, line: &[u8]) {
        let Some(line) = memrchr(b'$', line).and_then(|start| line.get(start..)) else {
            return;
        };
        match line.get(1..6) {
            Some(b"BFNVG") => {
                if let Some(fix) = fix(line)
                    && self.navigation.heard(at, fix, self.sure())
                {
                    self.counts.navigations += 1;
                    if let Some(jump) = self.navigation.jump()
                        && jump.at == at
                    {
                        let due = self.jump_due(at);
                        self.lease.must_end(due);
                    }
                }
            }
            Some(
                b"BFCTL" | b"BFMIS" | b"BFMSC" | b"BFMBS" | b"BFMBE" | b"BFACK" | b"BFPLN" | b"BFSHT" | b"BFDVT"
                | b"BFCMA",
            ) => {
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
            FromVehicle::Shutdown(_) => {
                let heard = self.process.heard(at) + self.sure();
                self.shutdown.said(heard, self.process.is_stopped());
            }
            FromVehicle::DvlTriggering(triggering) => {
                let heard = self.process.heard(at) + self.link_delay;
                let hears = self.control.is_up() && !self.process.is_stopped();
                self.trigger.vehicle_says(at, triggering.begin, heard, hears);
            }
            FromVehicle::MediumAccess(window) => self.acoustic.window(at, window.created, window.until),
            FromVehicle::BehaviorBegin(begin) => {
                self.behavior_changed(at);
                if let Some(identifier) = begin.identifier {
                    self.inserts.begins(at, identifier.get());
                } else if begin.number.is_some() {
                    self.inserts.plan_goes_on(at);
                }
            }
            FromVehicle::BehaviorEnd(end) => {
                self.behavior_changed(at);
                if let Some(identifier) = end.identifier {
                    self.inserts.ends(identifier.get());
                }
            }
            FromVehicle::PlanElement(element) => {
                self.plan_heard = true;
                let own = element.identifier.is_none();
                self.plan.told(own.then(|| self.area.point(element.position)));
                let place = (element.number, element.identifier.map(backseat_spi::BehaviorId::get));
                self.inserts.element(at, place, element.index);
            }
            FromVehicle::Acknowledgement(ack) => self.answered(at, ack),
            _ => {}
        }
    }

    /// Another behavior than the one that was modified is flown.
    fn behavior_changed(&mut self, at: Timestamp) {
        let due = self.due(at, Rule::LeaseOutlives, "a behavior began or ended under it");
        self.lease.must_end(due);
    }

    fn answered(&mut self, at: Timestamp, ack: &Acknowledgement) {
        let identifier = ack.behavior.map(backseat_spi::BehaviorId::get);
        let created = ack.command_created.truncated_to_millis();
        let command = ack.command.as_str();
        if command == "RMB" || command == "NAK" {
            self.lease.answered();
        }
        let taken = match ack.status {
            AckStatus::Succeeded => true,
            AckStatus::Invalid | AckStatus::Failed => false,
            AckStatus::Pending | AckStatus::Other(_) => return,
        };
        let unreadable =
            ack.status == AckStatus::Invalid && identifier.is_none() && ack.command_created == TimeOfDay::MIDNIGHT;
        let caps = &self.limits.caps;
        match command {
            "RTK" | "RTC" | "RGP" if unreadable => self.inserts.unreadable(Some(command)),
            "NAK" if unreadable => self.inserts.unreadable(None),
            "RMB" if !taken && self.lease.has(created) => {
                let due = self.due(at, Rule::LeaseOutlives, "the vehicle refused it");
                self.lease.must_end(due);
            }
            "RTK" | "RTC" | "RGP" => {
                self.inserts.answered(at, identifier, created, taken);
                if taken {
                    let (open_max, duration_s) = (self.limits.inserts_open_max, self.limits.inserts_duration_max_s);
                    self.inserts.check_open(at, open_max, duration_s, &mut self.findings);
                }
                if taken && command == "RGP" {
                    self.quota
                        .taken(at, (Counted::GpsHit, created), caps, &mut self.findings);
                }
            }
            "RCN" if taken => {
                self.inserts.cancel_done(identifier, created);
                self.conduct.cancelled(at);
            }
            "RCA" | "RCB" | "RCE" if taken => self.conduct.cancelled(at),
            "RMP" => {
                self.plan_heard |= taken;
                self.inserts.plan_told(created, taken);
            }
            "TRM" | "BOY" if taken => self
                .quota
                .taken(at, (Counted::Adjustment, created), caps, &mut self.findings),
            "SIL" if self.silence.answered(created, taken, caps) => {
                self.quota
                    .taken(at, (Counted::Silence, created), caps, &mut self.findings);
            }
            _ => {}
        }
    }
}

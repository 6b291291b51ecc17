use backseat_spi::{AckStatus, BackseatControl, CommandName, ModifyBehavior, Text, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind};
use crate::faults::ack_identifier;
use crate::insert::Insert;
use crate::modify;
use crate::mvc::Mvc;
use crate::requests::Work;
use crate::server::{Named, Topic, named};

impl Mvc {
    /// Does what a client asks.
    pub(crate) fn command(&mut self, now: Timestamp, client: ClientId, command: ToVehicle) {
        let name = CommandName::new(command.name()).unwrap_or(CommandName::NAK);
        let created = command.created().unwrap_or(TimeOfDay::MIDNIGHT);
        let re = Regarding {
            client,
            command: name,
            created,
            behavior: None,
            muted: false,
        };
        if !matches!(command, ToVehicle::Unknown(_))
            && let Some(status) = self.faults.refusal(name)
        {
            let behavior = ack_identifier(&command);
            self.acknowledge(
                now,
                Regarding { behavior, ..re },
                status,
                "the vehicle cannot do it now",
            );
            return;
        }
        match command {
            ToVehicle::LoggingControl(request) => self.logging(now, re, request.message, request.on),
            ToVehicle::PayloadVersion(message) => {
                self.note(now, MvcEventKind::PayloadVersion(client, message.version));
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::PayloadStatus(message) => {
                self.note(
                    now,
                    MvcEventKind::PayloadStatus {
                        client,
                        ok: message.ok,
                        text: message.text,
                    },
                );
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::LogMessage(message) => {
                self.note(now, MvcEventKind::PayloadMessage(client, message.text));
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::ModifyBehavior(request) => self.modify(now, re, &request),
            ToVehicle::EndModify(_) => {
                let text = if self.executive.end_modify_asked() {
                    ""
                } else {
                    "no behavior was modified"
                };
                self.acknowledge(now, re, AckStatus::Succeeded, text);
            }
            ToVehicle::Trackline(request) => {
                let insert = Insert::trackline(client, &request, self.frame(), self.vehicle.hull());
                self.insert(
                    now,
                    Regarding {
                        behavior: Some(request.identifier),
                        ..re
                    },
                    insert,
                );
            }
            ToVehicle::Trackcircle(request) => {
                let insert = Insert::trackcircle(
                    client,
                    &request,
                    self.interpretation.trackcircle_layout,
                    self.frame(),
                    self.vehicle.hull(),
                );
                self.insert(
                    now,
                    Regarding {
                        behavior: Some(request.identifier),
                        ..re
                    },
                    insert,
                );
            }
            ToVehicle::CancelBehavior(request) => {
                let id = request.identifier;
                self.begin(
                    now,
                    Regarding {
                        behavior: Some(id),
                        ..re
                    },
                    Work::Cancel(id),
                );
            }
            ToVehicle::CancelAll(_) => {
                let waiting = self.executive.cancel_all(client) + self.take_back(client);
                self.acknowledge(now, re, AckStatus::Succeeded, &format!("{waiting} cancelled"));
            }
            // Always pending first, whatever the setting (SPI 7.19).
            ToVehicle::RequestPlan(_) => self.begin_pending(now, re, Work::Plan),
            ToVehicle::Unknown(unknown) => self.no_command(now, re, unknown.name()),
            ToVehicle::GpsHit(request) => self.gps_hit(now, re, &request),
            // An adjustment is the current behavior while it runs (SPI 7.23, 7.24).
            ToVehicle::CancelCurrent(_) if self.adjustment.is_asked_for() => self.cancel_adjustment(now, re),
            ToVehicle::CancelCurrent(request) => self.cancel_current(now, re, &request),
            ToVehicle::CancelElement(request) => self.cancel_element(now, re, &request),
            ToVehicle::Abort(request) => self.abort(now, re, &request),
            ToVehicle::Kill(request) => self.kill(now, re, &request),
            ToVehicle::StartEmptyMission(request) => self.start_empty_mission(now, re, &request),
            ToVehicle::SilentMode(request) => self.silent_mode(now, re, &request),
            ToVehicle::TrimAdjustment(request) => self.adjust_trim(now, re, &request),
            ToVehicle::BuoyancyAdjustment(request) => self.adjust_buoyancy(now, re, &request),
            ToVehicle::DvlTriggerRequest(request) => self.dvl_trigger_request(now, re, &request),
            ToVehicle::TopsideText(request) => self.topside_text(now, re, &request),
            ToVehicle::TopsideRelay(request) => self.topside_relay(now, re, &request),
            ToVehicle::Packet(request) => self.packet(now, re, &request),
            ToVehicle::PositionFix(request) => self.position_fix(now, re, &request),
            ToVehicle::PayloadCtd(request) => self.payload_ctd(now, re, &request),
            ToVehicle::Suspend(request) => self.suspend(now, re, &request),
            ToVehicle::Continue(request) => self.keep_suspended(now, re, &request),
            ToVehicle::Resume(request) => self.resume(now, re, &request),
            ToVehicle::HullSpeedLimit(request) => self.hull_speed_limit(now, re, &request),
            ToVehicle::SonarAngle(request) => self.sonar_angle(now, re, &request),
            ToVehicle::HullPosition(request) => self.hull_position(now, re, &request),
            ToVehicle::BottomPosition(request) => self.bottom_position(now, re, &request),
            ToVehicle::RelativeReset(request) => self.relative_reset(now, re, &request),
            ToVehicle::BearingOffset(request) => self.bearing_offset(now, re, &request),
            ToVehicle::Camera(request) => self.camera(now, re, &request),
            ToVehicle::Light(request) => self.light(now, re, &request),
        }
    }

    /// A command that does not parse: it is named, its time is not echoed.
    pub(crate) fn malformed(&mut self, now: Timestamp, client: ClientId, command: CommandName, text: Text) {
        let re = Regarding {
            client,
            command,
            created: TimeOfDay::MIDNIGHT,
            behavior: None,
            muted: false,
        };
        self.invalid(now, re, text.as_str());
    }

    /// BPLOG (SPI 7.1).
    fn logging(&mut self, now: Timestamp, re: Regarding, message: Text, on: bool) {
        let topics = match named(message.as_str()) {
            Named::Topics(topics) => topics,
            Named::AlwaysOn if on => 0,
            Named::AlwaysOn => {
                self.acknowledge(now, re, AckStatus::Failed, "command messages are always on");
                return;
            }
            Named::Unknown => {
                self.invalid(
                    now,
                    re,
                    &format!("message {message}: expected a message of the vehicle or ALL"),
                );
                return;
            }
        };
        self.server.switch(re.client, topics, on);
        self.note(
            now,
            MvcEventKind::Subscribed {
                client: re.client,
                message,
                on,
            },
        );
        self.acknowledge(now, re, AckStatus::Succeeded, "");
        if on && self.interpretation.control_replay {
            if topics & Topic::Mission.bit() != 0 {
                let message = self.mission_message(now, self.executive.status(), "");
                self.send(now, re.client, message);
            }
            if topics & Topic::Control.bit() != 0 {
                let created = self.stamp(now);
                self.send(
                    now,
                    re.client,
                    BackseatControl {
                        created,
                        granted: self.executive.control(),
                    }
                    .into(),
                );
            }
        }
    }

    /// BPRMB (SPI 7.12).
    fn modify(&mut self, now: Timestamp, re: Regarding, request: &ModifyBehavior) {
        let grid_deg = if self.interpretation.heading_is_grid {
            self.grid_convergence_deg
        } else {
            0.0
        };
        let outcome = match modify::read(request, grid_deg) {
            Ok(values) => self.executive.modify(now, re.client, values),
            Err(text) => return self.invalid(now, re, &text),
        };
        match outcome {
            Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
            Err(why) => self.acknowledge(now, re, AckStatus::Failed, why),
        }
    }
}

//! The messages of the vehicle (SPI 5 and 6).

use std::time::Duration;

use backseat_spi::{Ctd, DecodeError, FromVehicle, MissionCommand, MissionStatus, Text};
use backseat_units::TimeOfDay;

use super::samples::sampled;
use super::{Core, course};
use crate::ended::EndCause;
use crate::io::{Note, Operator};
use crate::vehicle::dive::NamedBy;

use crate::mutations::{Check, is_on};
use crate::order::{Condition, Order};
use crate::plugin::{CtdSample, Event, Topic};
use crate::settings::ControlHook;
use crate::timer::Timer;
use crate::vehicle::phase::is_over;
use crate::vehicle::plan::Collected;

/// Logs are closed within 10 s of BFSHT (safety requirement 011).
const CLOSE_AFTER_SHUTDOWN: Duration = Duration::from_secs(8);

impl Core {
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        if !self.cx.link.is_up() {
            return;
        }
        self.cx.link.read(self.cx.now);
        self.session.push(bytes);
        while let Some(line) = self.session.next_line() {
            self.invalidate_after_unheard();
            match line.message {
                Ok(message) => {
                    self.message(message);
                    self.fail_plugins();
                }
                Err(error) => {
                    if line.is_of_plan {
                        self.cx.vehicle.plan.unreadable();
                    }
                    let begins_or_ends = matches!(error.message, "BFMBS" | "BFMBE");
                    if line.swallows || begins_or_ends {
                        self.invalidate_after_loss();
                    }
                    self.doubt_control(error.message);
                    if error.message == "BFSHT" {
                        // Its only field is the time, which does not matter.
                        self.vehicle_shuts_down();
                    }
                    self.malformed(&error);
                }
            }
        }
        self.invalidate_after_unheard();
    }

    /// If something was lost on the link, it may have been a BFMBS or a BFMBE (safety requirement 002).
    fn invalidate_after_unheard(&mut self) {
        if self.session.take_lost() {
            self.invalidate_after_loss();
        }
        for message in self.session.take_damaged() {
            self.doubt_control(message);
        }
    }

    /// A message was lost. If a modify is steering, it goes on only if it would be allowed now.
    pub(super) fn invalidate_after_loss(&mut self) {
        self.session.lost(self.cx.now);
        course::lost(&mut self.cx);
        self.cx.vehicle.invalidate_after_loss(self.cx.now);
        self.capabilities.modify.prevent(&mut self.cx);
    }

    /// A message of this name was damaged or cannot be read. If it may have taken control away, core has none until the
    /// vehicle says so again.
    fn doubt_control(&mut self, message: &str) {
        if self.cx.control.doubt(self.cx.now, &self.cx.settings.control, message) {
            self.settle_control();
            self.session.lost(self.cx.now);
        }
    }

    /// The power will be cut, in a minute at the earliest (BFSHT).
    fn vehicle_shuts_down(&mut self) {
        if self.cx.control.stopping || !is_on(Check::Shutdown) {
            // A repeated BFSHT gives us no more time.
            return;
        }
        self.cx.note(Note::Text {
            text: "the vehicle shuts our power off in a minute".to_owned(),
        });
        self.capabilities.end_controlled(&mut self.cx, EndCause::PowerGoes);
        self.cx.control.stopping = true;
        self.cx.plugins.tell_all(&Event::Shutdown);
        self.capabilities.sonar.shutdown(&mut self.cx);
        self.cx.timers.set(Timer::Shutdown, self.cx.now + CLOSE_AFTER_SHUTDOWN);
    }

    fn malformed(&mut self, error: &DecodeError) {
        if let Some(count) = self.session.malformed() {
            let text = error.to_string();
            self.cx.note(Note::Malformed { text, count });
        }
    }

    fn message(&mut self, message: FromVehicle) {
        self.cx.link.subscriptions.confirm_by_data(message.name());
        match message {
            FromVehicle::Navigation(message) => self.navigated(&message),
            FromVehicle::VelocityAndRates(message) => self.velocity(&message),
            FromVehicle::Acknowledgement(message) => self.acknowledged(&message),
            FromVehicle::BackseatControl(message) => {
                self.cx.heard(message.created);
                if self.cx.settings.control == ControlHook::Bfctl {
                    let when = (message.created, self.cx.when(message.created));
                    let counts = self.cx.control.hand_over(self.cx.now, when, message.granted);
                    // If the vehicle takes control and gives it back within one read, it was still lost.
                    self.settle_control();
                    if !counts {
                        self.session.lost(self.cx.now);
                    }
                }
            }
            FromVehicle::MissionStatus(message) => self.mission_status(&message),
            FromVehicle::BehaviorBegin(message) => self.behavior_began(message),
            FromVehicle::BehaviorEnd(message) => self.behavior_ended(message),
            FromVehicle::MissionCommand(message) => self.mission_command(&message),
            FromVehicle::Shutdown(message) => {
                self.cx.heard(message.created);
                self.vehicle_shuts_down();
            }
            FromVehicle::Ctd(message) => self.ctd(&message),
            FromVehicle::PlanElement(message) => {
                self.cx.heard(message.created);
                let frame = *self.cx.monitor.envelope.fence().frame();
                if self.cx.vehicle.plan.collect(&frame, &message) == Collected::Late {
                    self.cx.vehicle.plan.invalidate();
                    self.session.want_plan(&mut self.cx);
                }
                if let Some(identifier) = message.identifier {
                    course::named(&mut self.cx, identifier);
                }
                self.capabilities
                    .inserts
                    .previous_run_named(&mut self.cx, message.identifier);
            }
            FromVehicle::VehicleVersion(message) => {
                self.cx.heard(message.created);
                self.cx.note_of_vehicle(Note::VehicleVersion {
                    version: message.version.as_str().to_owned(),
                });
            }
            FromVehicle::LoggingBegin(message) => {
                self.cx.heard(message.created);
                self.capabilities.sonar.vehicle_logs(&mut self.cx, true);
                self.cx
                    .plugins
                    .tell_wanting(Topic::Logging, &Event::LoggingBegan(message.text.as_str().to_owned()));
            }
            FromVehicle::LoggingEnd(message) => {
                self.cx.heard(message.created);
                self.capabilities.sonar.vehicle_logs(&mut self.cx, false);
                self.cx
                    .plugins
                    .tell_wanting(Topic::Logging, &Event::LoggingEnded(message.text.as_str().to_owned()));
            }
            FromVehicle::TopsideMessage(message) => {
                self.capabilities.topside.heard(&mut self.cx, &message);
                let text = message.text.as_str();
                self.carry_out_text(
                    message.created,
                    |when| matches!(when, Condition::TopsideMessage(awaited) if awaited == text),
                );
                self.capabilities.topside.tell(&mut self.cx, &message);
            }
            FromVehicle::DvlTriggering(message) => self.capabilities.dvl.heard(&mut self.cx, &message),
            FromVehicle::TrimStatus(message) => self.capabilities.adjustments.trim_status(&mut self.cx, &message),
            FromVehicle::BuoyancyStatus(message) => {
                self.capabilities.adjustments.buoyancy_status(&mut self.cx, &message)
            }
            FromVehicle::MediumAccess(message) => self.capabilities.acoustic.window(&mut self.cx, &message),
            FromVehicle::PacketSent(message) => self.capabilities.acoustic.packet_sent(&mut self.cx, &message),
            FromVehicle::PacketReceived(message) => self.capabilities.acoustic.packet_received(&mut self.cx, message),
            FromVehicle::RelativeNavigation(message) => {
                self.capabilities.station.heard_relative(&mut self.cx, &message)
            }
            FromVehicle::CartesianNavigation(message) => {
                self.capabilities.station.heard_cartesian(&mut self.cx, &message)
            }
            FromVehicle::SoundVelocity(ref velocity) => {
                sampled(&mut self.cx, &message);
                self.capabilities.sonar.sound_velocity(&mut self.cx, velocity);
            }
            FromVehicle::Telemetry(_)
            | FromVehicle::Compass(_)
            | FromVehicle::DepthSensor(_)
            | FromVehicle::VehicleSpeed(_)
            | FromVehicle::Battery(_)
            | FromVehicle::ControlSurfaces(_)
            | FromVehicle::Dvl(_)
            | FromVehicle::DvlBeams(_)
            | FromVehicle::Imu(_)
            | FromVehicle::ServoPositions(_) => sampled(&mut self.cx, &message),
            FromVehicle::Unknown(_) => {}
        }
    }

    /// If the vehicle names another dive file, core forgets the plan and asks for it again. Nothing steers until the
    /// new plan is complete.
    pub(super) fn dive_named(&mut self, by: NamedBy, created: TimeOfDay, file: &Text) {
        if !self.cx.vehicle.dive.named(by, file) || !is_on(Check::DiveIdentity) {
            return;
        }
        self.cx.vehicle.dive.changed_by(self.cx.now, created);
        self.cx.note_of_vehicle(Note::Text {
            text: format!("the vehicle names another dive: {}", file.as_str().trim()),
        });
        self.capabilities.end_leases(&mut self.cx, EndCause::OtherDive);
        self.capabilities.inserts.another_dive(&mut self.cx);
        self.cx.vehicle.forget_plan();
        self.cx.link.commands.forget_plan();
        self.cx.vehicle.courses.unknown();
        self.cx.vehicle.dive.is_another();
        self.session.want_plan(&mut self.cx);
        self.settle_control();
    }

    fn mission_status(&mut self, message: &MissionStatus) {
        self.cx.heard(message.created);
        let running = message.is_running();
        let when = (message.created, self.cx.when(message.created));
        let is_before_dive = self.cx.vehicle.dive.has_since_changed(self.cx.now, message.created);
        let counts = self.cx.control.mission(self.cx.now, when, running);
        if is_before_dive || !counts {
            // It is late, or the vehicle's clock was set. Nobody can tell which.
            self.cx.control.running = None;
            if self.cx.settings.control == ControlHook::Running {
                self.cx.control.handed_over = None;
            }
            self.settle_control();
            self.session.lost(self.cx.now);
            return;
        }
        self.dive_named(NamedBy::Status, message.created, &message.dive_file);
        self.cx.note_of_vehicle(Note::Mission {
            status: message.status.as_str().trim().to_owned(),
        });
        if self.cx.control.running != Some(running) {
            self.cx.control.running = Some(running);
            if running {
                self.cx.vehicle.forget_plan();
                self.cx.link.commands.forget_plan();
                self.session.want_plan(&mut self.cx);
                self.cx.vehicle.courses.unplace();
            } else if is_on(Check::MissionRuns) && is_on(Check::ControlLossEndsLease) {
                self.capabilities.modify.end(&mut self.cx, EndCause::MissionNotRunning);
            }
        }
        self.orders.heard_mission_status(&mut self.cx, message.status.as_str());
        if is_over(message.status.as_str()) {
            self.capabilities.inserts.mission_over(&mut self.cx);
            self.cx.vehicle.courses.forget();
            self.cx.vehicle.previous_run.mission_over();
            self.capabilities.adjustments.mission_over(&mut self.cx);
            self.cx.vehicle.mission_goes_on();
        }
        if self.cx.settings.control == ControlHook::Running {
            self.cx.control.handed_over = Some(running);
        }
        self.settle_control();
    }

    fn mission_command(&mut self, message: &MissionCommand) {
        self.cx.heard(message.created);
        let text = message.text.as_str();
        self.operator_by_text(message.created, text);
        if let ControlHook::MissionCommand { grant, revoke } = &self.cx.settings.control {
            let given = if text == grant {
                Some(true)
            } else {
                (text.trim() == revoke.trim()).then_some(false)
            };
            if let Some(given) = given {
                let when = (message.created, self.cx.when(message.created));
                self.cx.control.hand_over(self.cx.now, when, given);
            }
            self.settle_control();
        }
        self.cx.note_of_vehicle(Note::Text {
            text: format!("mission command: {text}"),
        });
        self.carry_out_text(
            message.created,
            |when| matches!(when, Condition::MissionCommand(command) if command.trim() == text.trim()),
        );
        self.cx
            .plugins
            .tell_wanting(Topic::MissionCommand, &Event::MissionCommand(text.to_owned()));
    }

    /// The operator's hold and release, if the mission names texts for them: the only way to reach us under water. This
    /// comes before everything else that the text may mean, because a hold overrides everything (safety requirement
    /// 015).
    fn operator_by_text(&mut self, created: TimeOfDay, text: &str) {
        let is = |named: &Option<String>| named.as_deref() == Some(text.trim());
        let act = match (is(&self.cx.settings.hold_text), is(&self.cx.settings.release_text)) {
            (true, _) => {
                self.cx.control.held_by_text.hear(self.cx.now, created);
                Operator::Hold
            }
            (false, true) if self.is_before_hold(created) => return,
            (false, true) => Operator::Release,
            (false, false) => return,
        };
        let holds = act == Operator::Hold;
        self.orders.act(&mut self.cx, &mut self.capabilities, act);
        if holds {
            self.held_by_text();
        }
        self.settle_control();
    }

    /// Carries out the policies for a text of the operator that the vehicle passed on, but not a release that is older than
    /// the newest hold by text.
    fn carry_out_text(&mut self, created: TimeOfDay, is_met: impl Fn(&Condition) -> bool) {
        let policies = &self.cx.settings.policies;
        let orders = |order: &Order| {
            policies
                .iter()
                .any(|policy| policy.order == *order && is_met(&policy.when))
        };
        let (holds, releases) = (orders(&Order::Hold), orders(&Order::Release));
        if holds {
            self.cx.control.held_by_text.hear(self.cx.now, created);
        }
        let late = releases && self.is_before_hold(created);
        self.orders.carry_out(&mut self.cx, &mut self.capabilities, |policy| {
            is_met(&policy.when) && !(late && policy.order == Order::Release)
        });
        if holds {
            self.held_by_text();
        }
    }

    /// The newest hold came by text, if there was one: then the time that the vehicle gave it counts.
    const fn held_by_text(&mut self) {
        self.cx.control.held_at = None;
    }

    /// Whether a release was made before the newest hold: it comes late, or again.
    fn is_before_hold(&mut self, created: TimeOfDay) -> bool {
        let (now, made) = (self.cx.now, self.cx.when(created));
        let control = &self.cx.control;
        let is_before = control.held_by_text.is_after(now, created) || control.is_before_hold(now, made);
        if is_before {
            let text = "the release is ignored, because the vehicle made it before the hold: send it again".to_owned();
            self.cx.note(Note::Text { text });
        }
        is_before
    }

    fn ctd(&mut self, message: &Ctd) {
        let utc = self.cx.utc();
        self.cx.vehicle.navigation.heard(self.cx.now, utc, message.created);
        let age = self
            .cx
            .vehicle
            .navigation
            .clock()
            .age(self.cx.now, utc, message.measured)
            .unwrap_or_default();
        let sample = CtdSample {
            measured: self.cx.now - age,
            conductivity_us_per_cm: message.conductivity_us_per_cm,
            temperature_c: message.temperature_c,
            pressure_kpa: message.pressure_kpa,
        };
        self.cx.plugins.tell_wanting(Topic::Ctd, &Event::Ctd(sample));
    }
}

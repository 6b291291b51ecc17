//! What the vehicle says (SPI 5 and 6).

use std::time::Duration;

use backseat_spi::{
    BehaviorBegin, BehaviorEnd, BehaviorId, Ctd, DecodeError, FromVehicle, MissionCommand, MissionStatus, Navigation,
    Text, VelocityAndRates,
};

use super::samples::sampled;
use super::{Core, course};
use crate::io::{Note, Operator};
use crate::vehicle::dive::NamedBy;
use crate::vehicle::integrity::Flaw;

use crate::order::Condition;
use crate::owner::Owner;
use crate::plugin::slots::Plugins;
use crate::plugin::{Behavior, CtdSample, Event, RequestState, Topic};
use crate::settings::ControlHook;
use crate::switches::{Check, is_on};
use crate::timer::Timer;
use crate::vehicle::navigation::{Change, WITHOUT_VELOCITIES};
use crate::vehicle::phase::is_over;

/// Logs are closed within 10 s of BFSHT (safety requirement 011).
const CLOSE_AFTER_SHUTDOWN: Duration = Duration::from_secs(8);
/// A flaw of navigation that stays is told so often.
const FLAW_TOLD_EVERY: Duration = Duration::from_secs(10);

impl Core {
    pub(crate) fn receive(&mut self, bytes: &[u8]) {
        if !self.cx.link.is_up() {
            return;
        }
        self.cx.link.read(self.cx.now);
        self.session.push(bytes);
        while let Some(line) = self.session.next_line() {
            self.lose_unheard();
            match line.message {
                Ok(message) => {
                    self.message(message);
                    self.fail_plugins();
                }
                Err(error) => {
                    if line.is_of_plan {
                        self.cx.vehicle.plan.unreadable();
                    }
                    if line.swallows {
                        self.cx.vehicle.lose();
                    }
                    if self.cx.control.doubt(&self.cx.settings.control, error.message) {
                        self.settle_control();
                    }
                    self.malformed(&error);
                }
            }
        }
        self.lose_unheard();
    }

    /// What was lost on the link may have been a BFMBS or a BFMBE (safety requirement 002).
    fn lose_unheard(&mut self) {
        if self.session.take_lost() {
            self.cx.vehicle.lose();
        }
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
                    self.cx.control.handed_over = Some(message.granted);
                    // Control that is taken and given back in one read was lost all the same.
                    self.settle_control();
                }
            }
            FromVehicle::MissionStatus(message) => self.mission_status(&message),
            FromVehicle::BehaviorBegin(message) => self.behavior_began(message),
            FromVehicle::BehaviorEnd(message) => self.behavior_ended(message),
            FromVehicle::MissionCommand(message) => self.mission_command(&message),
            FromVehicle::Shutdown(message) => {
                self.cx.heard(message.created);
                if self.cx.control.stopping || !is_on(Check::Shutdown) {
                    // Said again, it gives us no more time.
                    return;
                }
                self.cx.note(Note::Text {
                    text: "the vehicle shuts our power off in a minute".to_owned(),
                });
                self.capabilities.end_controlled(&mut self.cx, "power goes");
                self.cx.control.stopping = true;
                self.cx.plugins.tell_all(&Event::Shutdown);
                self.cx.timers.set(Timer::Shutdown, self.cx.now + CLOSE_AFTER_SHUTDOWN);
            }
            FromVehicle::Ctd(message) => self.ctd(&message),
            FromVehicle::PlanElement(message) => {
                self.cx.heard(message.created);
                let frame = *self.cx.monitor.envelope.fence().frame();
                self.cx.vehicle.plan.collect(&frame, &message);
                self.capabilities.inserts.former_named(&mut self.cx, message.identifier);
            }
            FromVehicle::VehicleVersion(message) => {
                self.cx.heard(message.created);
                self.cx.note_of_vehicle(Note::VehicleVersion {
                    version: message.version.as_str().to_owned(),
                });
            }
            FromVehicle::LoggingBegin(message) => {
                self.cx.heard(message.created);
                self.cx
                    .plugins
                    .tell_wanting(Topic::Logging, &Event::LoggingBegan(message.text.as_str().to_owned()));
            }
            FromVehicle::LoggingEnd(message) => {
                self.cx.heard(message.created);
                self.cx
                    .plugins
                    .tell_wanting(Topic::Logging, &Event::LoggingEnded(message.text.as_str().to_owned()));
            }
            FromVehicle::TopsideMessage(message) => {
                self.capabilities.topside.heard(&mut self.cx, &message);
                let text = message.text.as_str();
                self.orders.carry_out(
                    &mut self.cx,
                    &mut self.capabilities,
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
            FromVehicle::Telemetry(_)
            | FromVehicle::SoundVelocity(_)
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

    fn navigated(&mut self, message: &Navigation) {
        let utc = self.cx.utc();
        let Some(change) = self.cx.vehicle.navigation.position(self.cx.now, utc, message) else {
            return;
        };
        self.session.heard_navigation(&mut self.cx);
        self.capabilities.inserts.watch_schedules(&mut self.cx);
        let jump = match change {
            Change::Follows => None,
            Change::Jumped(jump) => Some(jump),
        };
        if let Some(jump) = jump {
            // Safety requirement 021: what the monitor knows of the vehicle's place cannot be trusted for a while.
            self.cx.note_of_vehicle(Note::Navigation {
                text: format!("navigation jumped by {:.1} m", jump.metres),
            });
            self.capabilities.modify.end(&mut self.cx, "navigation jumped");
        }
        self.heed_flaw();
        course::navigated(&mut self.cx, jump);
        self.unjudged = true;
        self.whereabouts
            .watch_place(&mut self.cx, &mut self.capabilities, &mut self.orders);
    }

    /// Safety requirement 024: what cannot be true steers nothing.
    fn heed_flaw(&mut self) {
        let Some(Flaw { what, text }) = self.cx.vehicle.navigation.take_flaw() else {
            return;
        };
        if self
            .flaw_told
            .is_none_or(|(told, at)| told != what || self.cx.now.since(at) >= FLAW_TOLD_EVERY)
        {
            self.flaw_told = Some((what, self.cx.now));
            self.cx.note_of_vehicle(Note::Navigation {
                text: format!("{what}: {text}"),
            });
            // They may never have been subscribed: an answer to BPLOG does not say to which it is.
            if what == WITHOUT_VELOCITIES {
                self.session.subscribe_anew(&mut self.cx, "NVR");
            }
        }
        self.capabilities.end_leases(&mut self.cx, what);
        self.capabilities.inserts.judge_waiting(&mut self.cx);
    }

    fn velocity(&mut self, message: &VelocityAndRates) {
        self.unjudged = true;
        let completes = self.cx.vehicle.navigation.velocity(self.cx.now, message);
        self.heed_flaw();
        if completes {
            self.follow_navigation();
            // Control may have come with this navigation, and plugins are to know.
            self.settle_control();
            self.step_due(true);
        }
    }

    /// What stands is held against the newest navigation, once for each BFNVG with its BFNVR, or for what has come of
    /// them by the end of an input.
    pub(crate) fn follow_navigation(&mut self) {
        if core::mem::take(&mut self.unjudged) {
            course::watch(&mut self.cx);
            self.capabilities.modify.prevent(&mut self.cx);
            self.capabilities.station.prevent(&mut self.cx);
        }
    }

    /// Where the vehicle names another dive file, the plan is forgotten and asked for, and nothing steers until it is
    /// whole.
    fn dive_named(&mut self, by: NamedBy, file: &Text) {
        if !self.cx.vehicle.dive.named(by, file) || !is_on(Check::DiveIdentity) {
            return;
        }
        self.cx.note_of_vehicle(Note::Text {
            text: format!("another dive: {}", file.as_str().trim()),
        });
        self.capabilities
            .end_leases(&mut self.cx, "the vehicle flies another dive");
        self.cx.vehicle.forget_plan();
        self.cx.link.commands.forget_plan();
        self.cx.vehicle.courses.lose();
        self.cx.vehicle.dive.is_another();
        self.session.want_plan(&mut self.cx);
        self.settle_control();
    }

    fn mission_status(&mut self, message: &MissionStatus) {
        self.cx.heard(message.created);
        self.dive_named(NamedBy::Status, &message.dive_file);
        let running = message.is_running();
        self.cx.note_of_vehicle(Note::Mission {
            status: message.status.as_str().trim().to_owned(),
        });
        if self.cx.control.running != Some(running) {
            self.cx.control.running = Some(running);
            if running {
                self.cx.vehicle.forget_plan();
                self.cx.link.commands.forget_plan();
                self.session.want_plan(&mut self.cx);
            } else if is_on(Check::MissionRuns) && is_on(Check::ControlLossEndsLease) {
                self.capabilities.modify.end(&mut self.cx, "the mission is not running");
            }
        }
        self.orders.heard_mission_status(&mut self.cx, message.status.as_str());
        if is_over(message.status.as_str()) {
            self.capabilities
                .inserts
                .mission_over(&mut self.cx, "the mission is over");
            self.cx.vehicle.courses.forget();
            self.cx.vehicle.former.mission_over();
            self.capabilities
                .adjustments
                .mission_over(&mut self.cx, "the mission is over");
            self.cx.vehicle.mission_goes_on();
        }
        if self.cx.settings.control == ControlHook::Running {
            self.cx.control.handed_over = Some(running);
        }
        self.settle_control();
    }

    fn behavior_began(&mut self, message: BehaviorBegin) {
        // First, for what has begun is of the dive that it names.
        self.dive_named(NamedBy::Behavior, &message.dive_file);
        // One of neither number nor identifier (an adjustment) comes beside what is flown and says nothing of it.
        let is_flown = message.number.is_some() || message.identifier.is_some();
        if is_flown {
            let revenant = message
                .identifier
                .filter(|identifier| self.cx.identifiers.is_ours(*identifier))
                .filter(|identifier| self.cx.ledger.by_identifier(*identifier).is_none());
            self.cx
                .vehicle
                .former
                .heard_begin(message.identifier, message.kind.as_str(), revenant);
            course::began(&mut self.cx, message.number, message.identifier);
        }
        self.cx.heard(message.created);
        self.cx.note_of_vehicle(Note::Behavior {
            began: true,
            number: message.number,
            identifier: message.identifier.map(|identifier| identifier.get()),
            kind: message.kind.as_str().to_owned(),
        });
        if is_on(Check::LeaseEndsWithBehavior) {
            // It modified another one (SPI 7.12).
            self.capabilities.modify.end(&mut self.cx, "a behaviour began under it");
        }
        // A suspended mission begins none: the vehicle has taken it up again. An end says nothing of the kind, for the
        // behaviour that is suspended may be reported so (SPI 8.1 leaves it open), and a hold modifies none.
        self.capabilities
            .station
            .end(&mut self.cx, "a behaviour began: the mission goes on");
        self.cx.vehicle.mission_goes_on();
        if is_flown {
            self.end_overtaken(message.identifier);
            self.cx.vehicle.named_insert.began(message.identifier);
        }
        let mut own = None;
        match (message.identifier, message.number) {
            (Some(identifier), _) => {
                self.cx.vehicle.plan.left_for_insert();
                if let Some(request) = self.cx.ledger.by_identifier(identifier) {
                    own = self.cx.ledger.get(request).map(|entry| (entry.owner, entry.tag));
                    if let Some(entry) = self.cx.ledger.get_mut(request) {
                        entry.interrupted = false;
                    }
                    self.cx.transition(request, RequestState::Started);
                } else if !self.cx.vehicle.plan.has(identifier) {
                    // Another payload's that came after the plan was asked for, perhaps.
                    self.session.want_plan(&mut self.cx);
                }
            }
            (None, Some(number)) => {
                if !self.cx.vehicle.plan.began(number) {
                    self.cx.vehicle.plan.invalidate();
                    self.session.want_plan(&mut self.cx);
                }
                // An insert without the vehicle's word is not flown, and where it does not wait either it is over.
                self.cx
                    .ledger
                    .settle_doubt_if(|entry| entry.waits_not && entry.insert.is_some_and(|insert| !insert.surfaces()));
                let vehicle = &mut self.cx.vehicle;
                vehicle.former.plan_goes_on(&vehicle.plan);
                self.capabilities.inserts.judge_waiting(&mut self.cx);
            }
            (None, None) => self
                .capabilities
                .adjustments
                .behavior(&mut self.cx, true, message.kind.as_str()),
        }
        tell_of_behavior(&mut self.cx.plugins, true, own, message.kind.as_str());
    }

    fn behavior_ended(&mut self, message: BehaviorEnd) {
        self.cx.heard(message.created);
        self.cx.note_of_vehicle(Note::Behavior {
            began: false,
            number: message.number,
            identifier: message.identifier.map(|identifier| identifier.get()),
            kind: message.kind.as_str().to_owned(),
        });
        if is_on(Check::LeaseEndsWithBehavior) {
            self.capabilities.modify.end(&mut self.cx, "a behaviour ended under it");
        }
        self.cx.vehicle.named_insert.finished(message.identifier);
        self.cx.vehicle.former.heard_end(message.identifier);
        if let Some(identifier) = message.identifier {
            self.cx.vehicle.plan.ended(identifier);
            self.cx.ledger.settle_doubt_of(identifier);
        } else if let Some(number) = message.number {
            self.cx.vehicle.plan.finished(number);
        } else {
            self.capabilities
                .adjustments
                .behavior(&mut self.cx, false, message.kind.as_str());
        }
        let mut own = None;
        if let Some(request) = message
            .identifier
            .and_then(|identifier| self.cx.ledger.by_identifier(identifier))
        {
            own = self.cx.ledger.get(request).map(|entry| (entry.owner, entry.tag));
            let interrupted = self.cx.ledger.awaits_interrupter(request);
            match self.cx.ledger.get_mut(request) {
                Some(entry) if interrupted && entry.state == RequestState::Started => entry.interrupted = true,
                _ => self.cx.transition(request, RequestState::Ended("flown".to_owned())),
            }
        }
        course::ended(&mut self.cx, message.number, message.identifier);
        tell_of_behavior(&mut self.cx.plugins, false, own, message.kind.as_str());
    }

    /// The vehicle flies one behaviour at a time: an insert that had begun is over where another one begins, though its
    /// BFMBE was lost with a connection; but where what begins interrupts, it may be taken up again.
    fn end_overtaken(&mut self, begun: Option<BehaviorId>) {
        let interrupts = begun
            .and_then(|begun| self.cx.ledger.get(self.cx.ledger.by_identifier(begun)?)?.insert)
            .is_some_and(|insert| insert.interrupt);
        if interrupts {
            self.cx.ledger.interrupt_all_but(begun);
            return;
        }
        let overtaken: Vec<(u64, &str)> = self
            .cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.is_open_insert() && entry.state == RequestState::Started)
            .filter(|(_, entry)| entry.identifier != begun)
            .map(|(request, entry)| {
                let why = if entry.interrupted {
                    "interrupted, and not taken up again"
                } else {
                    "another behaviour has begun"
                };
                (request, why)
            })
            .collect();
        for (request, why) in overtaken {
            self.cx.transition(request, RequestState::Ended(why.to_owned()));
        }
    }

    fn mission_command(&mut self, message: &MissionCommand) {
        self.cx.heard(message.created);
        let text = message.text.as_str();
        self.operator_by_text(text);
        if let ControlHook::MissionCommand { grant, revoke } = &self.cx.settings.control {
            if text == grant {
                self.cx.control.handed_over = Some(true);
            } else if text == revoke {
                self.cx.control.handed_over = Some(false);
            }
            self.settle_control();
        }
        self.cx.note_of_vehicle(Note::Text {
            text: format!("mission command: {text}"),
        });
        self.orders.carry_out(
            &mut self.cx,
            &mut self.capabilities,
            |when| matches!(when, Condition::MissionCommand(command) if command.trim() == text.trim()),
        );
        self.cx
            .plugins
            .tell_wanting(Topic::MissionCommand, &Event::MissionCommand(text.to_owned()));
    }

    /// The operator's hold and release, where the session names their texts: the only way to reach us under water. Before
    /// all else that the text may mean, for it beats all (safety requirement 015).
    fn operator_by_text(&mut self, text: &str) {
        let is = |named: &Option<String>| named.as_deref() == Some(text.trim());
        let act = match (is(&self.cx.settings.hold_text), is(&self.cx.settings.release_text)) {
            (true, _) => Operator::Hold,
            (false, true) => Operator::Release,
            (false, false) => return,
        };
        self.orders.act(&mut self.cx, &mut self.capabilities, act);
        self.settle_control();
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

/// Those plugins are told that listen to the vehicle's behaviours.
fn tell_of_behavior(plugins: &mut Plugins, began: bool, own: Option<(Owner, u64)>, kind: &str) {
    for plugin in plugins.ids() {
        if plugins.wants(plugin, Topic::Behavior) {
            let behavior = Behavior {
                kind: kind.to_owned(),
                tag: own.filter(|(owner, _)| *owner == plugin).map(|(_, tag)| tag),
            };
            let event = if began {
                Event::BehaviorBegan(behavior)
            } else {
                Event::BehaviorEnded(behavior)
            };
            plugins.tell(plugin, event);
        }
    }
}

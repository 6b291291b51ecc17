//! Compares each sentence that core sends with what the vehicle has said.

use std::time::Duration;

use backseat_core::{ControlHook, Limits, Start};
use backseat_spi::{Acknowledgement, FromVehicle, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

use crate::vehicle::name_of;

/// Knows what the vehicle has said and what was delivered, and nothing about core.
pub(crate) struct Judge {
    pub(crate) hook: ControlHook,
    pub(crate) armed: bool,
    pub(crate) age_max: Duration,
    pub(crate) up: bool,
    pub(crate) held: bool,
    pub(crate) handed_over: Option<bool>,
    pub(crate) running: Option<bool>,
    pub(crate) solved: Option<Timestamp>,
    /// When the last BPRMB was sent, if no BPEMB has ended it.
    pub(crate) modified: Option<Timestamp>,
    pub(crate) last_modify: Option<Timestamp>,
    /// When the last message left that keeps the mission suspended, while it is suspended.
    pub(crate) suspended: Option<Timestamp>,
    pub(crate) last_move: Option<Timestamp>,
    pub(crate) reserved: u32,
    pub(crate) identifiers: Vec<u32>,
    /// Whether the vehicle has allowed us to trigger the DVL.
    pub(crate) may_trigger: bool,
    pub(crate) delay_max: Duration,
    /// The commands with a time, and the BPLOG, that were sent on this connection and are not acknowledged.
    unanswered: Vec<(&'static str, Option<TimeOfDay>, Timestamp)>,
    /// When the newest command left whose acknowledgement came in time.
    answered: Option<Timestamp>,
    /// This trial does not require a round trip for what steers.
    pub(crate) deaf_is_fine: bool,
}

impl Judge {
    pub(crate) fn new(hook: ControlHook, start: &Start, limits: &Limits) -> Self {
        Self {
            hook,
            armed: start.armed,
            age_max: Duration::from_secs_f64(limits.navigation_age_max_s),
            up: false,
            held: start.held,
            handed_over: None,
            running: None,
            solved: None,
            modified: None,
            last_modify: None,
            suspended: None,
            last_move: None,
            reserved: start.identifiers.map_or(0, |identifiers| identifiers.reserved),
            identifiers: Vec::new(),
            may_trigger: false,
            delay_max: Duration::from_secs_f64(limits.link_delay_max_s),
            unanswered: Vec::new(),
            answered: None,
            deaf_is_fine: false,
        }
    }

    /// An acknowledgement completes the round trip of its command.
    fn acknowledged(&mut self, now: Timestamp, ack: &Acknowledgement) {
        let name = ack.command.to_string();
        let index = self.unanswered.iter().position(|(sent, created, _)| {
            *sent == name && created.is_none_or(|created| ack.command_created.echoes(created))
        });
        if let Some(index) = index {
            let (.., sent) = self.unanswered.remove(index);
            if now.since(sent) <= self.delay_max {
                self.answered = self.answered.max(Some(sent));
            }
        }
    }

    pub(crate) fn link(&mut self, up: bool) {
        self.up = up;
        self.unanswered.clear();
        self.answered = None;
        self.may_trigger = false;
        (self.handed_over, self.running, self.solved, self.modified) = (None, None, None, None);
        self.suspended = None;
    }

    pub(crate) fn heard(&mut self, now: Timestamp, message: &FromVehicle, solved: Option<Timestamp>) {
        match message {
            FromVehicle::Acknowledgement(ack) => self.acknowledged(now, ack),
            FromVehicle::BackseatControl(control) if self.hook == ControlHook::Bfctl => {
                self.handed_over = Some(control.granted);
            }
            FromVehicle::MissionStatus(status) => {
                self.running = Some(status.status.as_str().starts_with("Running"));
                if self.hook == ControlHook::Running {
                    self.handed_over = self.running;
                }
            }
            FromVehicle::MissionCommand(command) => {
                if let ControlHook::MissionCommand { grant, revoke } = &self.hook {
                    match command.text.as_str() {
                        text if text == grant => self.handed_over = Some(true),
                        text if text == revoke => self.handed_over = Some(false),
                        _ => {}
                    }
                }
            }
            FromVehicle::Navigation(_) => self.solved = self.solved.max(solved),
            FromVehicle::Shutdown(_) => self.held = true,
            FromVehicle::DvlTriggering(message) => self.may_trigger = message.begin,
            _ => {}
        }
    }

    pub(crate) fn has_control(&self) -> bool {
        self.up && !self.held && self.handed_over == Some(true) && self.running == Some(true)
    }

    /// Checks that nothing steers without control, once core has handled what arrived.
    pub(crate) fn settled(&self, now: Timestamp) {
        assert!(
            self.has_control() || self.modified.is_none(),
            "a modify goes on at {now} without control"
        );
        assert!(
            self.has_control() || self.suspended.is_none(),
            "station keeping goes on at {now} without control"
        );
    }

    pub(crate) fn sent(&mut self, now: Timestamp, command: &ToVehicle) {
        let (name, identifier) = name_of(command);
        if command.created().is_some() || name == "LOG" {
            self.unanswered.push((name, command.created(), now));
        }
        match command {
            ToVehicle::ModifyBehavior(modify) => {
                let full = modify.horizontal.is_some() && modify.vertical_m.is_some() && modify.speed.is_some();
                assert!(full, "{modify:?} leaves a value to inherit");
                assert!(self.suspended.is_none(), "BPRMB at {now} while it keeps its station");
                if let Some(last) = self.last_modify {
                    assert!(
                        now.since(last) >= Duration::from_millis(200),
                        "BPRMB over 5 Hz at {now}"
                    );
                }
                if let Some(last) = self.modified {
                    assert!(now.since(last) <= Duration::from_millis(2500), "BPRMB late at {now}");
                }
                self.last_modify = Some(now);
                self.modified = Some(now);
            }
            ToVehicle::EndModify(_) => {
                assert!(self.modified.take().is_some(), "a BPEMB that ends nothing at {now}");
            }
            ToVehicle::Suspend(_) => {
                assert!(self.modified.is_none(), "BPSUS at {now} under a modify");
                self.suspended = Some(now);
            }
            ToVehicle::Continue(_) | ToVehicle::HullPosition(_) | ToVehicle::BottomPosition(_) => {
                let last = self.suspended.replace(now).expect("a suspended mission");
                assert!(now.since(last) <= Duration::from_secs(1), "{name} late at {now}");
                if name != "CON" {
                    let last = self.last_move.replace(now);
                    let rate = last.is_none_or(|last| now.since(last) >= Duration::from_millis(200));
                    assert!(rate, "{name} over 5 Hz at {now}");
                }
            }
            ToVehicle::Resume(_) => {
                assert!(self.suspended.take().is_some(), "a BPRES that ends nothing at {now}");
            }
            ToVehicle::Trackline(_) | ToVehicle::Trackcircle(_) | ToVehicle::GpsHit(_) => {
                let identifier = identifier.unwrap();
                assert!(identifier < self.reserved, "identifier {identifier} is not reserved");
                assert!(
                    !self.identifiers.contains(&identifier),
                    "identifier {identifier} is used twice"
                );
                self.identifiers.push(identifier);
            }
            ToVehicle::Packet(packet) => {
                let fresh = packet.request < self.reserved && !self.identifiers.contains(&packet.request);
                assert!(fresh, "identifier {} of a packet", packet.request);
                self.identifiers.push(packet.request);
            }
            ToVehicle::DvlTriggerRequest(request) => {
                assert!(
                    self.may_trigger || !request.triggering,
                    "BPDVR x,1 at {now} without permission"
                );
                self.may_trigger &= request.external || request.triggering;
            }
            _ => {}
        }
        let moves_navigation = matches!(name, "NPU" | "CTD" | "RNS" | "RBO");
        let steers = matches!(
            name,
            "RMB"
                | "RTK"
                | "RTC"
                | "RGP"
                | "SUS"
                | "CON"
                | "GHP"
                | "GBP"
                | "SAN"
                | "PTZ"
                | "LIT"
                | "TOP"
                | "SIL"
                | "TRM"
                | "BOY"
                | "CPD"
        );
        if moves_navigation || steers {
            assert!(self.armed && self.has_control(), "{name} at {now} without control");
            let heard = self
                .answered
                .is_some_and(|sent| now.since(sent) < Duration::from_secs(3));
            assert!(
                heard || self.deaf_is_fine,
                "{name} at {now}, and the newest good round trip is {:?}",
                self.answered
            );
            let solved = self.solved.expect("navigation");
            let age = now.since(solved);
            assert!(
                age <= self.age_max + Duration::from_millis(20),
                "{name} on navigation {age:?} old"
            );
        }
    }
}

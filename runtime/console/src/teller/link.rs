use std::collections::VecDeque;

use backseat_spi::{Framer, Policy};
use backseat_spi::{
    FromVehicle, HorizontalMode, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode, Sentence, ToVehicle,
};
use backseat_units::TimeOfDay;

use crate::item::{Beat, Item, Steering};

/// Commands whose acknowledgement may still come.
const COMMANDS: usize = 64;
/// Other figures of a modify are told at most this often, seconds.
const FIGURES_EVERY_S: f64 = 1.0;

/// Follows the bytes of the link: the heartbeat both ways, the status, and who steers.
#[derive(Debug)]
pub(super) struct Link {
    from_vehicle: Framer,
    commands: VecDeque<Command>,
    beat: Beat,
    status: Option<String>,
    steering: Steering,
    /// A lease goes on.
    open: bool,
    told_at: f64,
}

#[derive(Debug)]
struct Command {
    /// As acknowledgements name it: `RMB`.
    name: String,
    created: TimeOfDay,
    sent: f64,
}

impl Link {
    pub(super) fn new() -> Self {
        Self {
            from_vehicle: Framer::new(Policy::FromVehicle),
            commands: VecDeque::new(),
            beat: Beat::default(),
            status: None,
            steering: Steering::default(),
            open: false,
            told_at: f64::NEG_INFINITY,
        }
    }

    /// While nobody steers, no modify is refreshed.
    pub(super) fn beat(&self) -> Beat {
        Beat {
            refreshed: self.beat.refreshed.filter(|_| self.open),
            ..self.beat
        }
    }

    pub(super) fn navigated(&mut self, time_s: f64) {
        self.beat.navigated = Some(millis(time_s));
    }

    pub(super) fn went_down(&mut self) {
        self.from_vehicle = Framer::new(Policy::FromVehicle);
        self.commands.clear();
    }

    /// The vehicle was heard; bytes that are no text are no sentences.
    pub(super) fn heard(&mut self, t: f64, text: Option<&str>) {
        self.beat.heard = Some(millis(t));
        let Some(text) = text else { return };
        self.from_vehicle.push(text.as_bytes());
        while let Some(sentence) = self.from_vehicle.next_sentence() {
            if sentence.name() != "BFACK" {
                continue;
            }
            let Ok(FromVehicle::Acknowledgement(ack)) = FromVehicle::decode(&sentence) else {
                continue;
            };
            let name = ack.command.as_str();
            let found = self
                .commands
                .iter()
                .position(|command| command.name == name && ack.command_created.echoes(command.created));
            if let Some(command) = found.and_then(|place| self.commands.remove(place)) {
                self.beat.round_trip_s = Some(((t - command.sent) * 1e4).round() / 1e4);
                self.beat.acknowledged = Some(millis(t));
            }
        }
    }

    /// The runtime wrote a sentence. `leads` is whose modify this is, if it is one.
    pub(super) fn sent(&mut self, t: f64, text: &str, leads: Option<&str>, mut tell: impl FnMut(Item)) {
        for line in text.lines() {
            let Ok(sentence) = Sentence::parse(line.trim_end()) else {
                continue;
            };
            let Ok(message) = ToVehicle::decode(&sentence) else {
                continue;
            };
            if let Some(created) = sentence.fields().next().and_then(stamp) {
                self.commands.push_back(Command {
                    name: sentence.name().trim_start_matches("BP").to_owned(),
                    created,
                    sent: t,
                });
                if self.commands.len() > COMMANDS {
                    self.commands.pop_front();
                }
            }
            if let ToVehicle::PayloadStatus(status) = &message {
                // What follows the semicolon is about the sonars.
                let text = status.text.as_str().split(';').next().unwrap_or_default().trim();
                if self.status.as_deref() != Some(text) {
                    self.status = Some(text.to_owned());
                    tell(Item::Status { text: text.to_owned() });
                }
            } else if let ToVehicle::ModifyBehavior(modify) = &message {
                self.modified(t, modify, leads, &mut tell);
            } else if let ToVehicle::EndModify(_) = &message
                && let Some(item) = self.ended(None)
            {
                tell(item);
            }
        }
    }

    fn modified(&mut self, t: f64, modify: &ModifyBehavior, leads: Option<&str>, tell: &mut impl FnMut(Item)) {
        if self.open
            && let Some(last) = self.beat.refreshed
        {
            self.beat.worst_gap_s = self.beat.worst_gap_s.max(((t - last) * 1e3).round() / 1e3);
        }
        self.beat.refreshed = Some(millis(t));
        let steering = steering(modify, leads);
        let begins = !self.open || steering.owner != self.steering.owner;
        self.open = true;
        if begins || (steering != self.steering && t >= self.told_at + FIGURES_EVERY_S) {
            self.told_at = t;
            self.steering = steering;
            // Whose it is may be said only after it was written.
            if self.steering.owner.is_some() {
                tell(Item::Steering(self.steering.clone()));
            }
        }
    }

    /// Whose modify was sent last is known now.
    pub(super) fn led_by(&mut self, leads: &str) -> Option<Item> {
        if !self.open || self.steering.owner.as_deref() == Some(leads) {
            return None;
        }
        self.steering.owner = Some(leads.to_owned());
        Some(Item::Steering(self.steering.clone()))
    }

    /// The lease ended, for a reason if it is known; the item if it was open.
    pub(super) fn ended(&mut self, reason: Option<String>) -> Option<Item> {
        if !std::mem::take(&mut self.open) {
            return None;
        }
        self.steering = Steering::default();
        Some(Item::Steering(Steering {
            reason,
            ..Steering::default()
        }))
    }
}

fn steering(modify: &ModifyBehavior, leads: Option<&str>) -> Steering {
    let vertical = |mode| modify.vertical_m.filter(|_| modify.vertical_mode == Some(mode));
    let horizontal = |mode| modify.horizontal.filter(|_| modify.horizontal_mode == Some(mode));
    let speed = modify
        .speed
        .filter(|_| modify.speed_mode == Some(ModifySpeedMode::MetresPerSecond));
    Steering {
        owner: leads.map(str::to_owned),
        heading_deg: horizontal(HorizontalMode::Heading),
        rudder_deg: horizontal(HorizontalMode::Rudder),
        depth_m: vertical(ModifyVerticalMode::Depth),
        altitude_m: vertical(ModifyVerticalMode::Altitude),
        speed_mps: speed,
        reason: None,
    }
}

/// Whole milliseconds, seconds.
fn millis(t: f64) -> f64 {
    (t * 1000.0).round() / 1000.0
}

/// The time of a field, `081025.987`.
fn stamp(field: &str) -> Option<TimeOfDay> {
    let (seconds, nanos) = field.split_once('.').unwrap_or((field, ""));
    if seconds.len() != 6 || nanos.len() > 9 {
        return None;
    }
    let number = |text: &str| text.parse::<u64>().ok();
    let (hour, minute, second) = (number(&seconds[..2])?, number(&seconds[2..4])?, number(&seconds[4..])?);
    let nanos = number(&format!("{nanos:0<9}"))?;
    TimeOfDay::from_nanos(((hour * 60 + minute) * 60 + second) * 1_000_000_000 + nanos)
}

//! Configured drivers: the operator's own programs that feed what no plugin may (SPI 7.14, 7.15, 7.21, 8.8, 8.9).
//!
//! A driver speaks the sentence that it wants sent, as it would to the vehicle; the runtime checks that the mission lets
//! it, bounds it, stamps it anew, sends it, and answers with the vehicle's own BFACK.

use std::collections::BTreeMap;

use backseat_spi::{
    AckStatus, Acknowledgement, BearingOffset, CommandName, DecodeError, EchoedTime, FrameCounts, Framer, FromVehicle,
    PayloadCtd, Policy, PositionFix, RelativeReset, Sentence, Text, ToVehicle, TopsideRelay,
};
use backseat_units::{TimeOfDay, Timestamp};
use serde::{Deserialize, Serialize};

use crate::commands::Purpose;
use crate::context::Context;
use crate::io::{Note, Output};
use crate::ledger::{RequestKind, Transition, is_end};
use crate::machine::Core;
use crate::owner::DriverId;
use crate::plugin::{Refusal, RequestState};
use crate::refusal::refused;
use crate::session::is_told;
use crate::subscriptions::ACKNOWLEDGEMENTS;
use crate::switches::{Check, is_on};

mod bounds;

pub use bounds::{ConductivityUnit, DriverBounds};

/// So many lines of one read are answered; what a driver sends beyond them in one go is dropped and counted.
const LINES_MAX: usize = 32;
/// An answer's text is cut to this, bytes.
const TEXT_BYTES_MAX: usize = 200;

/// A sentence that a driver may send.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum DriverSentence {
    /// Topside message relay.
    #[serde(rename = "BPTMR")]
    Relay,
    /// Raw CTD data.
    #[serde(rename = "BPCTD")]
    PayloadCtd,
    /// Navigation position update.
    #[serde(rename = "BPNPU")]
    PositionFix,
    /// Reset of relative navigation.
    #[serde(rename = "BPRNS")]
    RelativeReset,
    /// Offset of the hull-relative bearing.
    #[serde(rename = "BPRBO")]
    BearingOffset,
}

impl DriverSentence {
    /// The sentence of a message; `None` for all that are no driver's.
    fn of(message: &ToVehicle) -> Option<Self> {
        match message.name() {
            TopsideRelay::NAME => Some(Self::Relay),
            PayloadCtd::NAME => Some(Self::PayloadCtd),
            PositionFix::NAME => Some(Self::PositionFix),
            RelativeReset::NAME => Some(Self::RelativeReset),
            BearingOffset::NAME => Some(Self::BearingOffset),
            _ => None,
        }
    }

    /// The three letters that it is acknowledged by.
    #[must_use]
    pub const fn letters(self) -> &'static str {
        match self {
            Self::Relay => "TMR",
            Self::PayloadCtd => "CTD",
            Self::PositionFix => "NPU",
            Self::RelativeReset => "RNS",
            Self::BearingOffset => "RBO",
        }
    }

    const fn kind(self) -> RequestKind {
        match self {
            Self::Relay => RequestKind::Relay,
            Self::PayloadCtd => RequestKind::PayloadCtd,
            Self::PositionFix => RequestKind::PositionFix,
            Self::RelativeReset => RequestKind::RelativeReset,
            Self::BearingOffset => RequestKind::BearingOffset,
        }
    }
}

/// A driver of the mission: a `[[driver]]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverSetup {
    /// Its name in the mission.
    pub name: String,
    /// What it may send.
    pub sends: Vec<DriverSentence>,
    /// The figures that it may send, and how often.
    #[serde(default)]
    pub bounds: DriverBounds,
}

/// What core knows of its drivers.
#[derive(Debug)]
pub(crate) struct Drivers {
    ports: Vec<Port>,
}

#[derive(Debug)]
struct Port {
    setup: DriverSetup,
    framer: Framer,
    /// What of `framer`'s counts has been dealt with.
    dropped: u64,
    /// Lines that came to nothing before the ledger, of all causes.
    refused: u64,
    /// How many sentences are left of its rate, and when that was so.
    left: f64,
    at: Timestamp,
    /// Requests that are not at their end: the name and the time under which the driver knows them.
    open: BTreeMap<u64, (CommandName, TimeOfDay)>,
    /// Counts its requests: the tags of its ledger entries.
    tag: u64,
}

impl Drivers {
    pub(crate) fn new(setups: &[DriverSetup]) -> Self {
        let port = |setup: &DriverSetup| Port {
            left: setup.bounds.burst(),
            setup: setup.clone(),
            framer: Framer::new(Policy::FromPayload),
            dropped: 0,
            refused: 0,
            at: Timestamp::ZERO,
            open: BTreeMap::new(),
            tag: 0,
        };
        Self {
            ports: setups.iter().map(port).collect(),
        }
    }
}

impl Port {
    /// Takes one of what its rate allows, where one is left.
    fn take(&mut self, now: Timestamp) -> bool {
        let bounds = &self.setup.bounds;
        let refilled = now.since(self.at).as_secs_f64() * bounds.rate_max_hz;
        self.left = (self.left + refilled).min(bounds.burst());
        self.at = now;
        let takes = self.left >= 1.0;
        if takes {
            self.left -= 1.0;
        }
        takes
    }

    /// How many lines have been dropped since the last call because they are no sentences. What the next sentence has
    /// cut short is not among them: it had no end that could be answered.
    fn dropped(&mut self) -> u64 {
        let FrameCounts {
            sentences: _,
            checksum_invalid,
            checksum_absent,
            malformed,
            too_long,
            not_utf8,
            cut_short: _,
            overflowed,
            noise_bytes: _,
        } = self.framer.counts();
        let dropped = checksum_invalid + checksum_absent + malformed + too_long + not_utf8 + overflowed;
        dropped - std::mem::replace(&mut self.dropped, dropped)
    }
}

/// What a driver's line says.
enum Said {
    Message(ToVehicle),
    Unreadable(DecodeError),
}

fn read(sentence: &Sentence<'_>) -> Said {
    match ToVehicle::decode(sentence) {
        Ok(message) => Said::Message(message),
        Err(error) => Said::Unreadable(error),
    }
}

impl Core {
    /// Bytes from a driver.
    pub(crate) fn driver_received(&mut self, driver: DriverId, bytes: &[u8]) {
        let Some(port) = self.cx.drivers.ports.get_mut(driver.0) else {
            return;
        };
        port.framer.push(bytes);
        let mut lines = 0;
        while let Some(port) = self.cx.drivers.ports.get_mut(driver.0) {
            let said = port.framer.next_sentence().map(|sentence| read(&sentence));
            for _ in 0..port.dropped() {
                lines += 1;
                self.refuse_line(
                    driver,
                    lines,
                    CommandName::NAK,
                    TimeOfDay::MIDNIGHT,
                    "it is no sentence",
                );
            }
            let Some(said) = said else { break };
            lines += 1;
            match said {
                Said::Message(message) => self.driver_said(driver, lines, message),
                Said::Unreadable(error) => {
                    let name = name_of(error.message);
                    self.refuse_line(driver, lines, name, TimeOfDay::MIDNIGHT, &error.to_string());
                }
            }
        }
    }

    fn driver_said(&mut self, driver: DriverId, lines: usize, message: ToVehicle) {
        let echoed = message.created().unwrap_or(TimeOfDay::MIDNIGHT);
        let name = name_of(message.name());
        let sends = &self.cx.drivers.ports[driver.0].setup.sends;
        let sentence =
            DriverSentence::of(&message).filter(|sentence| sends.contains(sentence) || !is_on(Check::DriverSends));
        if let Some(sentence) = sentence {
            if lines > LINES_MAX {
                self.count_refused(driver);
            } else {
                self.ask_for_driver(driver, sentence, name, echoed, message);
            }
            return;
        }
        if is_courtesy(&message) && lines <= LINES_MAX {
            // Programs that speak to a vehicle begin like this. Acknowledgements are always on here.
            return self
                .cx
                .acknowledge_driver(driver, name, echoed, AckStatus::Succeeded, "");
        }
        let text = "the mission does not let this driver send it";
        self.refuse_line(driver, lines, name, echoed, text);
    }

    /// A sentence that the driver may send becomes a request.
    fn ask_for_driver(
        &mut self,
        driver: DriverId,
        sentence: DriverSentence,
        name: CommandName,
        echoed: TimeOfDay,
        message: ToVehicle,
    ) {
        let port = &mut self.cx.drivers.ports[driver.0];
        port.tag += 1;
        let request = self.cx.ledger.propose(driver, port.tag, sentence.kind());
        port.open.insert(request, (name, echoed));
        match self.admit_driver(driver, sentence, message) {
            Ok(message) => {
                let moves = bounds::moves_frame(&message) && is_on(Check::FrameReset);
                if moves {
                    // What a lease or a hold stands on is about to be another place (safety requirement 021).
                    let reason = "a driver resets the vehicle's navigation";
                    self.capabilities.end_leases(&mut self.cx, reason);
                }
                let sent = self
                    .cx
                    .send_request(request, sentence.letters(), &message, Purpose::Request(request));
                if sent && bounds::resets_relative(&message) && is_on(Check::FrameReset) {
                    self.cx.vehicle.relative.unsettle(self.cx.now);
                    self.cx.vehicle.cartesian.unsettle(self.cx.now);
                }
                if moves {
                    self.cx.vehicle.navigation.frame_reset(self.cx.now);
                }
            }
            Err(refusal) => self.cx.reject(request, refusal),
        }
    }

    /// The sentence as it is to leave, under our own stamp.
    fn admit_driver(
        &mut self,
        driver: DriverId,
        sentence: DriverSentence,
        message: ToVehicle,
    ) -> Result<ToVehicle, Refusal> {
        let port = &mut self.cx.drivers.ports[driver.0];
        if !port.take(self.cx.now) {
            let text = format!("more than {} sentences a second", port.setup.bounds.rate_max_hz);
            return Err(refused("rate", &text));
        }
        // What is relayed is the topside's word, which is no wish of ours: it passes without control (014).
        if sentence != DriverSentence::Relay
            && let Some(reason) = self.cx.lost_because()
        {
            return Err(refused("control", reason));
        }
        if !self.cx.link.is_up() {
            return Err(refused("control", "the link is down"));
        }
        if !self.cx.control.armed {
            return Err(refused("control", "the runtime is not armed"));
        }
        let message = self.bounded(driver, message)?;
        let created = self.cx.stamper.stamp(self.cx.now, sentence.letters());
        Ok(bounds::stamped(message, created))
    }

    /// The message, every figure within the driver's bounds.
    fn bounded(&self, driver: DriverId, message: ToVehicle) -> Result<ToVehicle, Refusal> {
        let bounds = &self.cx.drivers.ports[driver.0].setup.bounds;
        let utc = self.cx.utc().time_of_day();
        #[expect(clippy::wildcard_enum_match_arm, reason = "no other message is a driver's")]
        match message {
            ToVehicle::TopsideRelay(relay) if relay.text.holds_command() => Err(refused(
                "text",
                "the text holds $BP, and a vehicle that looks for sentences could take what follows for a command",
            )),
            ToVehicle::TopsideRelay(relay) => Ok(relay.into()),
            ToVehicle::PayloadCtd(ctd) => bounds.ctd(ctd, utc).map(ToVehicle::from),
            ToVehicle::PositionFix(fix) => {
                let Some(navigation) = self.cx.vehicle.navigation.fresh(self.cx.now) else {
                    return Err(refused("navigation", "navigation is stale"));
                };
                let frame = self.cx.monitor.envelope.fence().frame();
                bounds.fix(&fix, utc, frame, navigation)?;
                Ok(fix.into())
            }
            ToVehicle::RelativeReset(reset) => {
                bounds.reset(&reset)?;
                Ok(reset.into())
            }
            ToVehicle::BearingOffset(offset) => {
                bounds.bearing(&offset)?;
                Ok(offset.into())
            }
            other => Err(refused("limit", &format!("{} is no driver's", other.name()))),
        }
    }

    /// A line that is not taken: answered, unless there are too many in one read, and counted.
    fn refuse_line(&mut self, driver: DriverId, lines: usize, name: CommandName, echoed: TimeOfDay, text: &str) {
        if lines <= LINES_MAX {
            self.cx
                .acknowledge_driver(driver, name, echoed, AckStatus::Invalid, text);
        }
        self.count_refused(driver);
    }

    fn count_refused(&mut self, driver: DriverId) {
        let port = &mut self.cx.drivers.ports[driver.0];
        port.refused += 1;
        if is_told(port.refused) {
            let text = format!("driver {}: {} lines were not taken", port.setup.name, port.refused);
            self.cx.note(Note::Text { text });
        }
    }
}

impl Context {
    /// A driver's request has come to another state: its end, or that it is pending, is said to it as the vehicle would.
    pub(crate) fn tell_driver(&mut self, driver: DriverId, transition: &Transition) {
        let Some(port) = self.drivers.ports.get_mut(driver.0) else {
            return;
        };
        let Some((name, echoed)) = port.open.get(&transition.request).copied() else {
            return;
        };
        if is_end(&transition.state) {
            port.open.remove(&transition.request);
        }
        let (status, text) = match &transition.state {
            RequestState::Pending => (AckStatus::Pending, ""),
            RequestState::Accepted => (AckStatus::Succeeded, ""),
            RequestState::Rejected(text) | RequestState::Failed(text) => (AckStatus::Failed, text.as_str()),
            RequestState::TimedOut => (AckStatus::Failed, "the vehicle has not answered"),
            RequestState::Cancelled => (AckStatus::Failed, "cancelled"),
            // The acknowledgement has been passed on already, or is yet to come.
            RequestState::Sent | RequestState::Unknown | RequestState::Started | RequestState::Ended(_) => return,
        };
        self.acknowledge_driver(driver, name, echoed, status, text);
    }

    pub(crate) fn acknowledge_driver(
        &mut self,
        driver: DriverId,
        command: CommandName,
        command_created: TimeOfDay,
        status: AckStatus,
        text: &str,
    ) {
        let text: String = text.chars().take(TEXT_BYTES_MAX).collect();
        let ack = FromVehicle::from(Acknowledgement {
            created: self.utc().time_of_day(),
            command,
            command_created: EchoedTime::of(command_created),
            behavior: None,
            status,
            text: Text::cleaned(&text),
        });
        let mut bytes = Vec::with_capacity(96);
        if ack.encode(&mut bytes).is_ok() {
            self.outbox.push(Output::Driver(driver, bytes));
        }
    }
}

/// What every payload may say of itself (SPI 7.25, 7.1), which ends here.
fn is_courtesy(message: &ToVehicle) -> bool {
    #[expect(clippy::wildcard_enum_match_arm, reason = "no other message is one")]
    match message {
        ToVehicle::PayloadVersion(_) => true,
        ToVehicle::LoggingControl(logging) => logging.message.as_str() == ACKNOWLEDGEMENTS,
        _ => false,
    }
}

/// As acknowledgements name it; what has no such name is no command (NAK).
fn name_of(sentence: &str) -> CommandName {
    let known = backseat_spi::catalogue()
        .iter()
        .any(|entry| entry.name == sentence && sentence.starts_with("BP"));
    let name = known.then(|| CommandName::new(sentence).ok()).flatten();
    name.unwrap_or(CommandName::NAK)
}

//! What core keeps of each external source, and what it answers.

use std::collections::BTreeMap;

use backseat_spi::{
    AckStatus, Acknowledgement, CommandName, EchoedTime, FrameCounts, Framer, FromVehicle, Policy, Text,
};
use backseat_units::{TimeOfDay, Timestamp, Utc};

use crate::io::Output;
use crate::ledger::{Transition, is_end};
use crate::outbox::Outbox;
use crate::owner::ExternalId;
use crate::plugin::RequestState;
use crate::settings::external::ExternalSetup;

/// An answer's text is cut to this, characters.
const TEXT_BYTES_MAX: usize = 200;

/// What core knows of its external sources.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Externals {
    pub(crate) ports: Vec<Port>,
}

#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Port {
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) setup: ExternalSetup,
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) framer: Framer,
    /// What of `framer`'s counts has been handled.
    pub(crate) dropped: u64,
    /// Lines that were refused before they reached the ledger, for any reason.
    pub(crate) refused: u64,
    /// How many sentences its rate allowed at the time `at`.
    pub(crate) left: f64,
    pub(crate) at: Timestamp,
    /// Open requests: the name and the time by which the external source knows each.
    pub(crate) open: BTreeMap<u64, (CommandName, TimeOfDay)>,
    /// Counts its requests, for the tags of their ledger entries.
    pub(crate) tag: u64,
}

impl Externals {
    pub(crate) fn new(setups: &[ExternalSetup]) -> Self {
        let port = |setup: &ExternalSetup| Port {
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

    /// A request of an external source has changed its state. Acknowledges it as the vehicle would, if the new state
    /// needs an acknowledgement.
    pub(crate) fn tell(&mut self, outbox: &mut Outbox, utc: Utc, source: ExternalId, transition: &Transition) {
        let Some(port) = self.ports.get_mut(source.0) else {
            return;
        };
        let Some((name, echoed)) = port.open.get(&transition.request).copied() else {
            return;
        };
        if is_end(&transition.state) {
            port.open.remove(&transition.request);
        }
        let said;
        let (status, text) = match &transition.state {
            RequestState::Pending => (AckStatus::Pending, ""),
            RequestState::Accepted => (AckStatus::Succeeded, ""),
            RequestState::Rejected(refusal) => {
                said = refusal.to_string();
                (AckStatus::Failed, said.as_str())
            }
            RequestState::Failed(failure) => {
                said = failure.to_string();
                (AckStatus::Failed, said.as_str())
            }
            RequestState::TimedOut => (AckStatus::Failed, "the vehicle has not answered"),
            RequestState::Cancelled => (AckStatus::Failed, "cancelled"),
            // The acknowledgement has been passed on already, or is yet to come.
            RequestState::Sent | RequestState::Unknown | RequestState::Started | RequestState::Ended(_) => return,
        };
        acknowledge(outbox, utc, source, (name, echoed), (status, text));
    }
}

impl Port {
    /// Takes one sentence of what the rate allows. False if none is left.
    pub(crate) fn take(&mut self, now: Timestamp) -> bool {
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

    /// How many lines were dropped since the last call because they are not sentences. Lines that the next sentence cut
    /// short are not counted: they had no end that could be answered.
    pub(crate) fn dropped(&mut self) -> u64 {
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

/// Acknowledges a command of an external source, as the vehicle would.
pub(crate) fn acknowledge(
    outbox: &mut Outbox,
    utc: Utc,
    source: ExternalId,
    (command, command_created): (CommandName, TimeOfDay),
    (status, text): (AckStatus, &str),
) {
    let text: String = text.chars().take(TEXT_BYTES_MAX).collect();
    let ack = FromVehicle::from(Acknowledgement {
        created: utc.time_of_day(),
        command,
        command_created: EchoedTime::of(command_created),
        behavior: None,
        status,
        text: Text::cleaned(&text),
    });
    let mut bytes = Vec::with_capacity(96);
    if ack.encode(&mut bytes).is_ok() {
        outbox.push(Output::External(source, bytes));
    }
}

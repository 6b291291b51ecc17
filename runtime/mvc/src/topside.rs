use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, RelayedText, Text, TopsideMessage, TopsideRelay, TopsideText, Transport};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind};
use crate::file::{TopsideConfig, TopsideEntry, WorldFile};
use crate::mvc::Mvc;
use crate::requests::Work;

/// Above this depth the radio's antenna is out of the water, metres.
const SURFACED_M: f64 = 0.3;

/// What passed between the payloads and the topside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TopsideEvent {
    /// A payload's message waits for its delivery.
    Queued(ClientId, Text),
    /// A payload's message was delivered to the topside, over this link.
    Delivered(Transport, Text),
    /// A message of the topside was given to the payloads, or to the one with this role.
    Received(Transport, Option<Box<str>>, Text),
    /// A payload has relayed a message that came over its own modem.
    Relayed(ClientId, Transport, RelayedText),
}

/// Text to and from the topside (SPI 5.5, 7.3, 7.14).
#[derive(Debug)]
pub(crate) struct Topside {
    config: TopsideConfig,
    incoming: VecDeque<(Timestamp, TopsideEntry)>,
    outgoing: VecDeque<Text>,
    /// When the message at the head of the queue is delivered.
    delivered_at: Timestamp,
}

impl Topside {
    pub(crate) fn new(file: &WorldFile, _seed: u64) -> Self {
        let config = file.topside.clone();
        let at = |entry: &TopsideEntry| Timestamp::ZERO + Duration::from_secs_f64(entry.at_s);
        Self {
            incoming: config.messages.iter().map(|entry| (at(entry), entry.clone())).collect(),
            outgoing: VecDeque::new(),
            delivered_at: Timestamp::ZERO,
            config,
        }
    }

    fn delivery(&self) -> Duration {
        Duration::from_secs_f64(self.config.delivery_s)
    }
}

impl Mvc {
    /// BPTOP (SPI 7.3): may be pending. The slowest link that it names is advice, "such that all topside messages will
    /// be sent using any communications link".
    pub(crate) fn topside_text(&mut self, now: Timestamp, re: Regarding, request: &TopsideText) {
        if let Transport::Other(code) = request.slowest {
            return self.invalid(now, re, &format!("slowest {code}: expected 0 to 3"));
        }
        if request.text.is_empty() {
            return self.invalid(now, re, "text: empty");
        }
        self.begin(now, re, Work::Topside(request.text.clone()));
    }

    /// The outcome of a BPTOP: success is that it is queued, not that it is received.
    pub(crate) fn queue_topside(&mut self, now: Timestamp, re: Regarding, text: Text) {
        if self.topside.outgoing.len() >= self.topside.config.queue_max as usize {
            return self.acknowledge(now, re, AckStatus::Failed, "too many messages wait for the topside");
        }
        self.note(
            now,
            MvcEventKind::Topside(TopsideEvent::Queued(re.client, text.clone())),
        );
        if self.topside.outgoing.is_empty() {
            self.topside.delivered_at = now + self.topside.delivery();
        }
        self.topside.outgoing.push_back(text);
        self.acknowledge(now, re, AckStatus::Succeeded, "queued");
    }

    /// BPTMR (SPI 7.14). What a relayed message means is not specified: it is logged, and nothing is done.
    pub(crate) fn topside_relay(&mut self, now: Timestamp, re: Regarding, request: &TopsideRelay) {
        if let Transport::Other(code) = request.transport {
            return self.invalid(now, re, &format!("transport {code}: expected 0 to 3"));
        }
        if !self.topside.config.relay {
            return self.acknowledge(now, re, AckStatus::Failed, "this vehicle takes no relayed messages");
        }
        let event = TopsideEvent::Relayed(re.client, request.transport, request.text.clone());
        self.note(now, MvcEventKind::Topside(event));
        self.acknowledge(now, re, AckStatus::Succeeded, "");
    }

    /// One step of the vehicle.
    pub(crate) fn tick_topside(&mut self, now: Timestamp) {
        while self.topside.incoming.front().is_some_and(|(at, _)| *at <= now) {
            if let Some((_, entry)) = self.topside.incoming.pop_front() {
                self.hear_topside(now, entry);
            }
        }
        if self.topside.outgoing.is_empty() || now < self.topside.delivered_at {
            return;
        }
        let surfaced = self.vehicle.depth_m < SURFACED_M;
        let config = &self.topside.config;
        let transport = if surfaced { config.surfaced } else { config.submerged };
        // A silent vehicle's acoustic modem does not send: the messages wait (SPI 7.22).
        if transport == Transport::AcousticModem && self.silence.is_silent() {
            return;
        }
        if let Some(text) = self.topside.outgoing.pop_front() {
            self.topside.delivered_at = now + self.topside.delivery();
            self.note(now, MvcEventKind::Topside(TopsideEvent::Delivered(transport, text)));
        }
    }

    /// BFTOP (SPI 5.5).
    fn hear_topside(&mut self, now: Timestamp, entry: TopsideEntry) {
        let text = Text::cleaned(&entry.text);
        let message = TopsideMessage {
            created: self.stamp(now),
            transport: entry.transport,
            text: text.clone(),
        };
        self.command_client(now, entry.role.as_deref(), &message.into());
        let role = entry.role.map(String::into_boxed_str);
        self.note(
            now,
            MvcEventKind::Topside(TopsideEvent::Received(entry.transport, role, text)),
        );
    }
}

const fn name(transport: Transport) -> &'static str {
    match transport {
        Transport::Ethernet => "ethernet",
        Transport::Wifi => "802.11",
        Transport::RfModem => "RF modem",
        Transport::AcousticModem => "acoustic modem",
        Transport::Other(_) => "unknown link",
    }
}

impl fmt::Display for TopsideEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Queued(client, text) => write!(f, "{client} tells the topside: {text}"),
            Self::Delivered(transport, text) => write!(f, "delivered to the topside by {}: {text}", name(*transport)),
            Self::Received(transport, Some(role), text) => {
                write!(f, "the topside tells {role} by {}: {text}", name(*transport))
            }
            Self::Received(transport, None, text) => write!(f, "the topside says by {}: {text}", name(*transport)),
            Self::Relayed(client, transport, text) => {
                write!(f, "{client} relays from the topside by {}: {text}", name(*transport))
            }
        }
    }
}

use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, Text, TopsideMessage, TopsideRelay, TopsideText, Transport};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::event::{MvcEventKind, TopsideEvent};
use crate::file::{TopsideConfig, TopsideEntry, WorldFile};
use crate::server::answers::Regarding;

/// The radio's antenna is out of the water if the vehicle is above this depth, metres.
const SURFACED_M: f64 = 0.3;

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
    pub(crate) fn new(file: &WorldFile) -> Self {
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

impl Topside {
    /// BPTOP (SPI 7.3). Its acknowledgement can be pending first. The slowest link that it names is only a
    /// recommendation, "such that all topside messages will be sent using any communications link".
    pub(crate) fn text(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &TopsideText) {
        if let Transport::Other(code) = request.slowest {
            return ctx.invalid(re, &format!("slowest {code}: expected 0 to 3"));
        }
        if request.text.is_empty() {
            return ctx.invalid(re, "text: empty");
        }
        if let Some(text) = ctx.server.begin(ctx.now, re, request.text.clone()) {
            self.decide(ctx, re, text);
        }
    }

    /// Decides about a BPTOP. Success means that the text is queued, not that anybody has received it.
    pub(crate) fn decide(&mut self, ctx: &mut Context<'_>, re: Regarding, text: Text) {
        if self.outgoing.len() >= self.config.queue_max as usize {
            return ctx.acknowledge(re, AckStatus::Failed, "too many messages wait for the topside");
        }
        ctx.note(MvcEventKind::Topside(TopsideEvent::Queued(re.client, text.clone())));
        if self.outgoing.is_empty() {
            self.delivered_at = ctx.now + self.delivery();
        }
        self.outgoing.push_back(text);
        ctx.acknowledge(re, AckStatus::Succeeded, "queued");
    }

    /// BPTMR (SPI 7.14). SPI does not specify what a relayed message means, so the mock only logs it.
    pub(crate) fn relay(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &TopsideRelay) {
        if let Transport::Other(code) = request.transport {
            return ctx.invalid(re, &format!("transport {code}: expected 0 to 3"));
        }
        if !self.config.relay {
            return ctx.acknowledge(re, AckStatus::Failed, "this vehicle takes no relayed messages");
        }
        let event = TopsideEvent::Relayed(re.client, request.transport, request.text.clone());
        ctx.note(MvcEventKind::Topside(event));
        ctx.acknowledge(re, AckStatus::Succeeded, "");
    }

    /// One step of the vehicle.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) {
        while self.incoming.front().is_some_and(|(at, _)| *at <= ctx.now) {
            if let Some((_, entry)) = self.incoming.pop_front() {
                self.hear(ctx, entry.transport, Text::cleaned(&entry.text), entry.role);
            }
        }
        if self.outgoing.is_empty() || ctx.now < self.delivered_at {
            return;
        }
        let surfaced = ctx.vehicle.motion().depth_m < SURFACED_M;
        let config = &self.config;
        let transport = if surfaced { config.surfaced } else { config.submerged };
        // The acoustic modem of a silent vehicle does not send, so the messages wait (SPI 7.22).
        if transport == Transport::AcousticModem && ctx.quiet.silent {
            return;
        }
        if let Some(text) = self.outgoing.pop_front() {
            self.delivered_at = ctx.now + self.delivery();
            ctx.note(MvcEventKind::Topside(TopsideEvent::Delivered(transport, text)));
        }
    }

    /// BFTOP (SPI 5.5): a message comes from the topside, for the client with a role, or for every client.
    pub(crate) fn hear(&mut self, ctx: &mut Context<'_>, transport: Transport, text: Text, role: Option<String>) {
        let message = TopsideMessage {
            created: ctx.stamp(),
            transport,
            text: text.clone(),
        };
        ctx.server.order(ctx.now, role.as_deref(), &message.into());
        let role = role.map(String::into_boxed_str);
        ctx.note(MvcEventKind::Topside(TopsideEvent::Received(transport, role, text)));
    }
}

mod modem;
mod peers;

use core::time::Duration;

use backseat_spi::{AckStatus, FrameSentStatus, MediumAccess, Packet, PacketReceived, PacketSent, Text};
use backseat_units::Timestamp;
use backseat_world::Stream;

use self::modem::{Modem, Outcome, Request};
use self::peers::Peers;
use crate::context::Context;
use crate::event::{AcousticEvent, MvcEventKind};
use crate::file::{AcousticConfig, WorldFile};
use crate::server::answers::Regarding;
use crate::server::topics::Topic;

/// Packets over the acoustic modem (SPI 9).
///
/// The modem sends one packet at a time, and waits for its acknowledgement before it sends the next. Sound travels
/// between the vehicle and its peers along a straight line at the speed of sound. A packet that arrives while the modem
/// itself sends is lost.
#[derive(Debug)]
pub(crate) struct Acoustic {
    config: AcousticConfig,
    modem: Modem,
    peers: Peers,
    status_losses: Stream,
    /// When the payload's window ends; `None` outside a window.
    window: Option<Timestamp>,
    next_window: Timestamp,
    next_own: Timestamp,
    own_request: u32,
    /// Nothing is due before this time.
    next: Timestamp,
}

impl Acoustic {
    pub(crate) fn new(file: &WorldFile, seed: u64) -> Self {
        let config = file.acoustic.clone();
        let after = |seconds: f64| Timestamp::ZERO + Duration::from_secs_f64(seconds);
        let windows = config.equipped && config.period_s.is_some();
        Self {
            modem: Modem::new(seed),
            peers: Peers::new(&config, seed),
            status_losses: Stream::new(seed, "acoustic status"),
            window: None,
            next_window: if windows { after(config.first_s) } else { Timestamp::MAX },
            next_own: config.own_period_s.map_or(Timestamp::MAX, after),
            own_request: config.own_request_first,
            next: Timestamp::ZERO,
            config,
        }
    }

    fn due(&self) -> Timestamp {
        let window = self.window.unwrap_or(self.next_window);
        // The vehicle's own packet waits for the end of the window.
        let own = if self.window.is_some() {
            Timestamp::MAX
        } else {
            self.next_own
        };
        window.min(own).min(self.modem.due()).min(self.peers.due())
    }

    /// What is wrong with the mode, the frames or the destination of a packet, at any time.
    fn fault(&self, packet: &Packet) -> Option<String> {
        let device = self.config.device;
        let Some((frames_max, bytes_max)) = device.frames(packet.mode) else {
            return Some(format!("mode {}: {} has no such mode", packet.mode, device.name()));
        };
        if packet.frames.count() > frames_max {
            return Some(format!("frames: mode {} has at most {frames_max}", packet.mode));
        }
        if packet.frames.frames().any(|frame| frame.len() > bytes_max) {
            return Some(format!(
                "frames: mode {} has at most {bytes_max} bytes a frame",
                packet.mode
            ));
        }
        (packet.destination == self.config.address).then(|| "destination: the vehicle's own modem".to_owned())
    }
}

impl Acoustic {
    /// BPCPD (SPI 9.4). "Any message sent to the vehicle outside of the provided windows will be ignored": the packet
    /// is not sent, and if acknowledgements are on, it is acknowledged as failed.
    pub(crate) fn packet(&mut self, ctx: &mut Context<'_>, re: Regarding, request: &Packet) {
        if let Some(text) = self.fault(request) {
            return ctx.invalid(re, &text);
        }
        let why = if !self.config.equipped {
            "the payload has no access to an acoustic modem"
        } else if self.window.is_none_or(|until| ctx.now >= until) {
            ctx.note(MvcEventKind::Acoustic(AcousticEvent::Ignored(
                re.client,
                request.request,
            )));
            "outside of the payload's communication windows"
        } else if ctx.quiet.commanded {
            "the vehicle is silent"
        } else if self.modem.holds(request.request) {
            "a packet with this identifier is being sent"
        } else if self.modem.waiting() >= self.config.queue_max as usize {
            "too many packets are waiting"
        } else {
            ctx.note(MvcEventKind::Acoustic(AcousticEvent::Queued(
                re.client,
                request.request,
            )));
            self.modem.push(Request {
                request: request.request,
                destination: request.destination,
                ack: request.ack,
                frames: request.frames.count(),
                own: false,
                asked: ctx.now,
            });
            self.next = ctx.now;
            ctx.acknowledge(re, AckStatus::Succeeded, "queued");
            return;
        };
        ctx.acknowledge(re, AckStatus::Failed, why);
    }

    /// The vehicle becomes silent: waiting packets are not sent.
    pub(crate) fn fall_silent(&mut self, ctx: &mut Context<'_>) {
        self.drop_packets(ctx);
        self.next = ctx.now;
    }

    /// One step of the vehicle.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) {
        if ctx.now < self.next {
            return;
        }
        self.tick_windows(ctx);
        self.tick_modem(ctx);
        self.tick_peers(ctx);
        self.next = self.due();
    }

    fn tick_windows(&mut self, ctx: &mut Context<'_>) {
        if self.window.is_some_and(|until| until <= ctx.now) {
            self.window = None;
            ctx.note(MvcEventKind::Acoustic(AcousticEvent::WindowEnded));
            self.drop_packets(ctx);
        }
        if self.next_window <= ctx.now {
            let until = self.next_window + Duration::from_secs_f64(self.config.length_s);
            let period = self.config.period_s.map(Duration::from_secs_f64);
            self.next_window = period.map_or(Timestamp::MAX, |period| self.next_window + period);
            if ctx.quiet.silent {
                ctx.note(MvcEventKind::Acoustic(AcousticEvent::WindowSkipped));
            } else {
                self.window = Some(until);
                ctx.note(MvcEventKind::Acoustic(AcousticEvent::WindowBegan));
                let message = MediumAccess {
                    created: ctx.stamp(),
                    until: ctx.server.stamp(until),
                    address: self.config.address,
                    device: Text::cleaned(self.config.device.name()),
                };
                ctx.publish(Some(Topic::MediumAccess), &message.into());
            }
        }
        if self.next_own <= ctx.now && self.window.is_none() {
            let period = self.config.own_period_s.map(Duration::from_secs_f64);
            self.next_own = period.map_or(Timestamp::MAX, |period| ctx.now + period);
            if !ctx.quiet.silent && !self.modem.has_own() {
                self.modem.push(Request {
                    request: self.own_request,
                    destination: 0,
                    ack: false,
                    frames: 1,
                    own: true,
                    asked: ctx.now,
                });
                self.own_request = self.own_request.wrapping_add(1);
            }
        }
    }

    fn tick_modem(&mut self, ctx: &mut Context<'_>) {
        // Each pass ends or begins one packet.
        loop {
            if let Some((request, outcome)) = self.modem.finish(ctx.now, &self.config, &self.peers) {
                self.report_sent(ctx, request, outcome);
            } else if ctx.quiet.silent {
                return;
            } else {
                let until = self.window;
                match self.modem.begin(&self.config, until) {
                    modem::Begun::No => return,
                    modem::Begun::Sending => {}
                    modem::Begun::TooLate(request) => self.report_not_sent(ctx, request),
                }
            }
        }
    }

    fn tick_peers(&mut self, ctx: &mut Context<'_>) {
        let at = (ctx.vehicle.motion().at, ctx.vehicle.motion().depth_m);
        self.peers.transmit(ctx.now, &self.config, at);
        while let Some(arrival) = self.peers.arrived(ctx.now) {
            if arrival.lost || self.modem.sounds(arrival.began, arrival.at) {
                ctx.note(MvcEventKind::Acoustic(AcousticEvent::NotHeard(arrival.source)));
                continue;
            }
            ctx.note(MvcEventKind::Acoustic(AcousticEvent::Received(arrival.source)));
            let message = PacketReceived {
                created: ctx.stamp(),
                arrived: ctx.server.stamp(arrival.at),
                source: arrival.source,
                destination: arrival.destination,
                mode: arrival.mode,
                frames: arrival.frames,
                data: arrival.data,
            };
            ctx.publish(Some(Topic::PacketReceived), &message.into());
        }
        // Packets that end before the next step use the vehicle's position of this step.
        self.modem.place(at);
    }

    /// Removes the payload's waiting packets and reports them as not sent.
    fn drop_packets(&mut self, ctx: &mut Context<'_>) {
        while let Some(request) = self.modem.take_payloads() {
            self.report_not_sent(ctx, request);
        }
    }

    fn report_not_sent(&mut self, ctx: &mut Context<'_>, request: Request) {
        ctx.note(MvcEventKind::Acoustic(AcousticEvent::NotSent(request.request)));
        self.send_status(ctx, request, ctx.now, FrameSentStatus::FailedToSend);
    }

    fn report_sent(&mut self, ctx: &mut Context<'_>, request: Request, outcome: Outcome) {
        let status = match (request.ack, outcome.acked) {
            (true, true) => FrameSentStatus::Acked,
            (true, false) if ctx.interpretation.unacked_is_failed => FrameSentStatus::FailedToSend,
            (true | false, _) => FrameSentStatus::Unacknowledged,
        };
        ctx.note(MvcEventKind::Acoustic(AcousticEvent::Sent {
            request: request.request,
            destination: request.destination,
            heard: outcome.heard,
            status,
        }));
        self.send_status(ctx, request, outcome.sent, status);
    }

    /// BFCPS (SPI 9.2).
    fn send_status(&mut self, ctx: &mut Context<'_>, request: Request, sent: Timestamp, status: FrameSentStatus) {
        if self.status_losses.uniform() < self.config.status_lost_chance {
            return;
        }
        let mut statuses = [FrameSentStatus::Unset; 8];
        statuses
            .iter_mut()
            .take(request.frames)
            .for_each(|place| *place = status);
        let message = PacketSent {
            created: ctx.stamp(),
            sent: ctx.server.stamp(sent),
            request: request.request,
            frames: request.frames as u32,
            statuses,
        };
        ctx.publish(Some(Topic::PacketSent), &message.into());
    }
}

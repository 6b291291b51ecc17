mod modem;
mod peers;

use core::fmt;
use core::time::Duration;

use backseat_spi::{AckStatus, FrameSentStatus, MediumAccess, Packet, PacketReceived, PacketSent, Text};
use backseat_units::Timestamp;
use backseat_world::Stream;

use self::modem::{Modem, Outcome, Request};
use self::peers::Peers;
use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind};
use crate::file::{AcousticConfig, WorldFile};
use crate::mvc::Mvc;
use crate::server::Topic;

/// What happened on the acoustic modem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcousticEvent {
    /// The payload's window began: BFCMA.
    WindowBegan,
    /// The payload's window ended.
    WindowEnded,
    /// A window was left out: the vehicle is silent.
    WindowSkipped,
    /// A payload's packet is queued.
    Queued(ClientId, u32),
    /// A payload's packet was ignored: it came outside of a window.
    Ignored(ClientId, u32),
    /// A packet was sent, and heard or not by the modem with this address.
    Sent {
        /// Its request's identifier.
        request: u32,
        /// The modem that it was for.
        destination: u32,
        /// Whether that modem has heard it.
        heard: bool,
        /// What BFCPS says of its frames.
        status: FrameSentStatus,
    },
    /// A packet was not sent: its window ended or the vehicle is silent.
    NotSent(u32),
    /// A packet arrived from the modem with this address.
    Received(u32),
    /// A packet of the modem with this address was not heard.
    NotHeard(u32),
}

/// Packets over the acoustic modem (SPI 9).
///
/// One packet is under way at a time; the modem waits for an acknowledgement before it takes up the next. Peers hear
/// and are heard along a straight line at the speed of sound; what arrives while the modem itself sends is lost.
#[derive(Debug)]
pub(crate) struct Acoustic {
    config: AcousticConfig,
    modem: Modem,
    peers: Peers,
    status_losses: Stream,
    /// When the payload's window ends; none outside of one.
    window: Option<Timestamp>,
    next_window: Timestamp,
    next_own: Timestamp,
    own_request: u32,
    /// Nothing is due before.
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

    /// What is wrong with a packet whatever the time: its mode, its frames, its destination.
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

impl Mvc {
    /// BPCPD (SPI 9.4). "Any message sent to the vehicle outside of the provided windows will be ignored": nothing is
    /// sent, and where acknowledgements are on, it has failed.
    pub(crate) fn packet(&mut self, now: Timestamp, re: Regarding, request: &Packet) {
        if let Some(text) = self.acoustic.fault(request) {
            return self.invalid(now, re, &text);
        }
        let acoustic = &self.acoustic;
        let why = if !acoustic.config.equipped {
            "the payload has no access to an acoustic modem"
        } else if acoustic.window.is_none_or(|until| now >= until) {
            self.note(
                now,
                MvcEventKind::Acoustic(AcousticEvent::Ignored(re.client, request.request)),
            );
            "outside of the payload's communication windows"
        } else if self.silence.is_commanded() {
            "the vehicle is silent"
        } else if acoustic.modem.holds(request.request) {
            "a packet with this identifier is being sent"
        } else if acoustic.modem.waiting() >= acoustic.config.queue_max as usize {
            "too many packets are waiting"
        } else {
            self.note(
                now,
                MvcEventKind::Acoustic(AcousticEvent::Queued(re.client, request.request)),
            );
            self.acoustic.modem.push(Request {
                request: request.request,
                destination: request.destination,
                ack: request.ack,
                frames: request.frames.count(),
                own: false,
                asked: now,
            });
            self.acoustic.next = now;
            self.acknowledge(now, re, AckStatus::Succeeded, "queued");
            return;
        };
        self.acknowledge(now, re, AckStatus::Failed, why);
    }

    /// The vehicle falls silent: what waits is not sent.
    pub(crate) fn silence_acoustic(&mut self, now: Timestamp) {
        self.drop_packets(now);
        self.acoustic.next = now;
    }

    /// One step of the vehicle.
    pub(crate) fn tick_acoustic(&mut self, now: Timestamp) {
        if now < self.acoustic.next {
            return;
        }
        self.tick_windows(now);
        self.tick_modem(now);
        self.tick_peers(now);
        self.acoustic.next = self.acoustic.due();
    }

    fn tick_windows(&mut self, now: Timestamp) {
        if self.acoustic.window.is_some_and(|until| until <= now) {
            self.acoustic.window = None;
            self.note(now, MvcEventKind::Acoustic(AcousticEvent::WindowEnded));
            self.drop_packets(now);
        }
        if self.acoustic.next_window <= now {
            let acoustic = &mut self.acoustic;
            let until = acoustic.next_window + Duration::from_secs_f64(acoustic.config.length_s);
            let period = acoustic.config.period_s.map(Duration::from_secs_f64);
            acoustic.next_window = period.map_or(Timestamp::MAX, |period| acoustic.next_window + period);
            if self.silence.is_silent() {
                self.note(now, MvcEventKind::Acoustic(AcousticEvent::WindowSkipped));
            } else {
                self.acoustic.window = Some(until);
                self.note(now, MvcEventKind::Acoustic(AcousticEvent::WindowBegan));
                let message = MediumAccess {
                    created: self.stamp(now),
                    until: self.stamp(until),
                    address: self.acoustic.config.address,
                    device: Text::cleaned(self.acoustic.config.device.name()),
                };
                self.publish(now, Some(Topic::MediumAccess), &message.into());
            }
        }
        if self.acoustic.next_own <= now && self.acoustic.window.is_none() {
            let acoustic = &mut self.acoustic;
            let period = acoustic.config.own_period_s.map(Duration::from_secs_f64);
            acoustic.next_own = period.map_or(Timestamp::MAX, |period| now + period);
            if !self.silence.is_silent() && !acoustic.modem.has_own() {
                acoustic.modem.push(Request {
                    request: acoustic.own_request,
                    destination: 0,
                    ack: false,
                    frames: 1,
                    own: true,
                    asked: now,
                });
                acoustic.own_request = acoustic.own_request.wrapping_add(1);
            }
        }
    }

    fn tick_modem(&mut self, now: Timestamp) {
        // Each pass ends a packet or begins one.
        loop {
            let acoustic = &mut self.acoustic;
            let peers = &acoustic.peers;
            if let Some((request, outcome)) = acoustic.modem.finish(now, &acoustic.config, peers) {
                self.report_sent(now, request, outcome);
            } else if self.silence.is_silent() {
                return;
            } else {
                let until = self.acoustic.window;
                let acoustic = &mut self.acoustic;
                match acoustic.modem.begin(&acoustic.config, until) {
                    modem::Begun::No => return,
                    modem::Begun::Sending => {}
                    modem::Begun::TooLate(request) => self.report_not_sent(now, request),
                }
            }
        }
    }

    fn tick_peers(&mut self, now: Timestamp) {
        let acoustic = &mut self.acoustic;
        let at = (self.vehicle.at, self.vehicle.depth_m);
        acoustic.peers.transmit(now, &acoustic.config, at);
        while let Some(arrival) = self.acoustic.peers.arrived(now) {
            if arrival.lost || self.acoustic.modem.sounds(arrival.began, arrival.at) {
                self.note(now, MvcEventKind::Acoustic(AcousticEvent::NotHeard(arrival.source)));
                continue;
            }
            self.note(now, MvcEventKind::Acoustic(AcousticEvent::Received(arrival.source)));
            let message = PacketReceived {
                created: self.stamp(now),
                arrived: self.stamp(arrival.at),
                source: arrival.source,
                destination: arrival.destination,
                mode: arrival.mode,
                frames: arrival.frames,
                data: arrival.data,
            };
            self.publish(now, Some(Topic::PacketReceived), &message.into());
        }
        // The peers' places are those of this step for packets that begin before the next.
        self.acoustic.modem.place(at);
    }

    /// The payload's packets that wait are not sent.
    fn drop_packets(&mut self, now: Timestamp) {
        while let Some(request) = self.acoustic.modem.take_payloads() {
            self.report_not_sent(now, request);
        }
    }

    fn report_not_sent(&mut self, now: Timestamp, request: Request) {
        self.note(now, MvcEventKind::Acoustic(AcousticEvent::NotSent(request.request)));
        self.send_status(now, request, now, FrameSentStatus::FailedToSend);
    }

    fn report_sent(&mut self, now: Timestamp, request: Request, outcome: Outcome) {
        let status = match (request.ack, outcome.acked) {
            (true, true) => FrameSentStatus::Acked,
            (true, false) if self.interpretation.unacked_is_failed => FrameSentStatus::FailedToSend,
            (true | false, _) => FrameSentStatus::Unacknowledged,
        };
        self.note(
            now,
            MvcEventKind::Acoustic(AcousticEvent::Sent {
                request: request.request,
                destination: request.destination,
                heard: outcome.heard,
                status,
            }),
        );
        self.send_status(now, request, outcome.sent, status);
    }

    /// BFCPS (SPI 9.2).
    fn send_status(&mut self, now: Timestamp, request: Request, sent: Timestamp, status: FrameSentStatus) {
        if self.acoustic.status_losses.uniform() < self.acoustic.config.status_lost_chance {
            return;
        }
        let mut statuses = [FrameSentStatus::Unset; 8];
        statuses
            .iter_mut()
            .take(request.frames)
            .for_each(|place| *place = status);
        let message = PacketSent {
            created: self.stamp(now),
            sent: self.stamp(sent),
            request: request.request,
            frames: request.frames as u32,
            statuses,
        };
        self.publish(now, Some(Topic::PacketSent), &message.into());
    }
}

impl fmt::Display for AcousticEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WindowBegan => f.write_str("acoustic window began"),
            Self::WindowEnded => f.write_str("acoustic window ended"),
            Self::WindowSkipped => f.write_str("acoustic window left out: the vehicle is silent"),
            Self::Queued(client, request) => write!(f, "packet {request} of {client} queued"),
            Self::Ignored(client, request) => write!(f, "packet {request} of {client} ignored: outside of a window"),
            Self::Sent {
                request,
                destination,
                heard,
                status,
            } => {
                let heard = if *heard { "heard" } else { "not heard" };
                write!(f, "packet {request} sent to modem {destination}, {heard}")?;
                match status {
                    FrameSentStatus::Acked => f.write_str(", acknowledged"),
                    FrameSentStatus::Unset
                    | FrameSentStatus::Unacknowledged
                    | FrameSentStatus::FailedToSend
                    | FrameSentStatus::Other(_) => Ok(()),
                }
            }
            Self::NotSent(request) => write!(f, "packet {request} was not sent"),
            Self::Received(source) => write!(f, "packet of modem {source} received"),
            Self::NotHeard(source) => write!(f, "packet of modem {source} was not heard"),
        }
    }
}

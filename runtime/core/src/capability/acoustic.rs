//! Packets through the vehicle's acoustic modem (SPI 9; safety requirement 016).
//!
//! A packet's request stays open until BFCPS reports the packet under our identifier, also over a lost link: the modem
//! sends the packet all the same. If the modem fails, no report comes (9.2). So a packet without a report times out one
//! minute after it was sent.

use std::time::Duration;

use backseat_spi::{
    FrameData, FrameReceivedStatus, FrameSentStatus, MAX_LINE, MediumAccess, Packet, PacketReceived, PacketSent,
    ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::context::Context;
use crate::ended::{Ended, Failure, FrameOutcome};
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::plugin::{Event, PacketRequest, ReceivedFrame, ReceivedPacket, Refusal, RequestState, Topic, Window};
use crate::quota::LastMinute;
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;
use crate::timer::Timer;
use crate::vehicle::clock::elapsed_nanos;

/// How long after a packet is sent its report can come. A packet with acknowledgement waits in the modem, and then
/// crosses some kilometres of water twice.
const REPORT_WITHIN: Duration = Duration::from_secs(60);
/// A longer window is ignored: its time of day must be wrong.
const WINDOW_MAX: Duration = Duration::from_secs(3600);

/// What core knows of the modem.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Acoustic {
    /// When the vehicle announced the window, by its own clock, and how long the window is.
    said: Option<(TimeOfDay, Duration)>,
    /// The packets without a report.
    packets: Vec<Unreported>,
    sent: LastMinute,
}

#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
struct Unreported {
    request: u64,
    /// The identifier that BFCPS names.
    identifier: u32,
    overdue: Timestamp,
}

/// The subscriptions that a packet needs, each with the refusal if it is missing.
const SUBSCRIBED: [(&str, Reason); 2] = [
    ("CMA", Reason::WindowsUnsubscribed),
    ("CPS", Reason::ReportsUnsubscribed),
];

impl Acoustic {
    /// Checks a request and returns what to send.
    pub(crate) fn check(&mut self, cx: &mut Context, request: u64, asked: &PacketRequest) -> Result<Dispatch, Refusal> {
        let packet = self.packet(cx, asked)?;
        // The identifier is used up, whatever happens to the packet.
        cx.identifiers.take();
        cx.reserve();
        Ok(Dispatch::new(
            "CPD",
            ToVehicle::Packet(packet),
            Purpose::Packet(request),
        ))
    }

    /// The request's packet was sent under this identifier.
    pub(crate) fn sent(&mut self, cx: &mut Context, request: u64, identifier: u32) {
        self.sent.add(cx.now);
        self.packets.push(Unreported {
            request,
            identifier,
            overdue: cx.now + REPORT_WITHIN,
        });
        self.set_timer(cx);
    }

    fn packet(&mut self, cx: &mut Context, asked: &PacketRequest) -> Result<Packet, Refusal> {
        for (message, unsubscribed) in SUBSCRIBED {
            if !cx.link.subscriptions.has(message) {
                return Err(unsubscribed.into());
            }
        }
        self.narrow_window(cx);
        if !cx.monitor.permits.window_is_open(cx.now) && is_on(Check::ModemWindow) {
            return Err(Reason::NoWindow.into());
        }
        if cx.vehicle.silent {
            return Err(Reason::VehicleSilent.into());
        }
        let most = cx.monitor.limits().packets_per_min;
        if !self.sent.has_room(cx.now, most) {
            return Err(Figure::Packets.one_over(most));
        }
        if asked.mode < 0 {
            return Err(Figure::TelemetryMode.under(asked.mode as f64, 0.0));
        }
        let bytes = asked
            .frames
            .iter()
            .fold(0usize, |all, frame| all.saturating_add(frame.len()));
        // Each byte takes two digits of the line. The encoder checks the length of the whole line.
        if bytes > MAX_LINE / 2 {
            return Err(Figure::FrameBytes.over(bytes as f64, (MAX_LINE / 2) as f64));
        }
        let frames = FrameData::new(asked.frames.clone()).map_err(|error| Refusal::Unwritable(error.to_string()))?;
        let packet = Packet {
            created: cx.stamper.stamp(cx.now, "CPD"),
            // Inserts and packets share these numbers, so it is unique in the whole mission, over restarts too.
            request: cx.identifiers.next()?,
            destination: asked.destination,
            mode: asked.mode,
            ack: asked.acknowledge,
            frames,
        };
        // Only a packet that can be encoded takes an identifier.
        match ToVehicle::Packet(packet.clone()).encode(&mut Vec::new()) {
            Ok(()) => Ok(packet),
            Err(error) => Err(Refusal::Unwritable(error.to_string())),
        }
    }

    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => cx.transition(request, RequestState::Accepted),
            Answer::Refused(text) => {
                self.packets.retain(|packet| packet.request != request);
                self.set_timer(cx);
                cx.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned())));
            }
            // The report may still come, and says more than the acknowledgement.
            Answer::Missing => {}
        }
    }

    /// Handles BFCMA. The newest window replaces an earlier one, and may be shorter.
    pub(crate) fn window(&mut self, cx: &mut Context, message: &MediumAccess) {
        cx.heard(message.created);
        cx.monitor.permits.window_until = None;
        match self.ends_of(cx, message) {
            Ok((until, open_until)) => {
                cx.monitor.permits.window_until = Some(open_until);
                self.said = Some((message.created, length_of(message)));
                let window = Window {
                    until,
                    address: message.address,
                    device: message.device.as_str().to_owned(),
                };
                cx.plugins.tell_wanting(Topic::Acoustic, &Event::Window(window));
            }
            Err(reason) => cx.note(Note::Text {
                text: format!("ignored an acoustic window until {}: {reason}", message.until),
            }),
        }
        self.set_timer(cx);
    }

    /// When a window ends on our clock, and until when a packet may leave; or why no packet may leave in it.
    fn ends_of(&self, cx: &Context, message: &MediumAccess) -> Result<(Timestamp, Timestamp), &'static str> {
        let length = length_of(message);
        if length.is_zero() {
            return Err("it ends before it begins");
        }
        if length > WINDOW_MAX {
            return Err("it ends more than an hour after it begins");
        }
        // The message may have waited before it was read. If the vehicle's clock was set meanwhile, its age by that
        // clock is too small.
        let age = self.age(cx, message.created).max(cx.link.waited());
        let until = cx.now + length - age;
        let open_until = until - self.before_its_end(cx);
        if open_until > cx.now {
            Ok((until, open_until))
        } else {
            Err("a packet sent now would arrive after its end")
        }
    }

    /// How long before a window's end the last packet may leave: one link delay that the clocks' offset can hide, and
    /// one for the packet's own way.
    fn before_its_end(&self, cx: &Context) -> Duration {
        2 * cx.monitor.limits().link_delay_max()
    }

    /// Moves the window's end nearer if the vehicle's clock is better known by now. It never moves the end farther
    /// away.
    fn narrow_window(&mut self, cx: &mut Context) {
        let Some((created, length)) = self.said else {
            return;
        };
        let until = cx.now + length - self.age(cx, created) - self.before_its_end(cx);
        cx.monitor.permits.window_until = cx.monitor.permits.window_until.map(|open_until| open_until.min(until));
    }

    /// Handles BFCPS, which also reports packets of other payloads.
    pub(crate) fn packet_sent(&mut self, cx: &mut Context, message: &PacketSent) {
        cx.heard(message.created);
        let packets = &mut self.packets;
        let own = packets.iter().position(|packet| packet.identifier == message.request);
        let Some(index) = own else { return };
        let request = packets.remove(index).request;
        self.set_timer(cx);
        cx.transition(request, RequestState::Ended(Ended::Frames(frames_of(message))));
    }

    /// Handles BFCPR: passes on as many frames as it says, good or not. A place that it leaves empty counts as not
    /// good.
    pub(crate) fn packet_received(&mut self, cx: &mut Context, message: PacketReceived) {
        cx.heard(message.created);
        let count = usize::try_from(message.frames).unwrap_or(usize::MAX);
        let frames = message.data.into_iter().take(count).map(|frame| ReceivedFrame {
            good: frame.status == FrameReceivedStatus::Good,
            data: frame.data.into_vec(),
        });
        let packet = ReceivedPacket {
            arrived: cx.now - self.age(cx, message.arrived),
            source: message.source,
            destination: message.destination,
            mode: (message.mode != -1).then_some(message.mode),
            frames: frames.collect(),
        };
        cx.plugins.tell_wanting(Topic::Acoustic, &Event::Packet(packet));
    }

    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        if !cx.monitor.permits.window_is_open(cx.now) {
            cx.monitor.permits.window_until = None;
        }
        let now = cx.now;
        let overdue: Vec<Unreported> = self.packets.extract_if(.., |packet| packet.overdue <= now).collect();
        self.set_timer(cx);
        for packet in overdue {
            cx.transition(packet.request, RequestState::TimedOut);
        }
    }

    /// The link is lost. The window counts as closed until the vehicle announces another one. The reports of packets
    /// may still come on the next connection.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        cx.monitor.permits.window_until = None;
        self.set_timer(cx);
        let unreported: Vec<u64> = self.packets.iter().map(|packet| packet.request).collect();
        for request in unreported {
            let state = cx.ledger.get(request).map(|entry| &entry.state);
            if matches!(state, Some(RequestState::Sent | RequestState::Pending)) {
                cx.transition(request, RequestState::Unknown);
            }
        }
    }

    fn set_timer(&mut self, cx: &mut Context) {
        let packets = self.packets.iter().map(|packet| packet.overdue);
        let next = packets.chain(cx.monitor.permits.window_until).min();
        cx.timers.set_or_stop(Timer::Acoustic, next);
    }

    /// The age of something that the vehicle wrote at this time of its clock; zero if the age is unknown.
    fn age(&self, cx: &Context, written: TimeOfDay) -> Duration {
        let age = cx.vehicle.navigation.clock().age(cx.now, cx.utc(), written);
        age.unwrap_or_default()
    }
}

/// What happened to each frame of a packet.
fn frames_of(message: &PacketSent) -> Vec<FrameOutcome> {
    let count = usize::try_from(message.frames).unwrap_or(usize::MAX);
    let outcome = |status| match status {
        FrameSentStatus::Unset => FrameOutcome::Unset,
        FrameSentStatus::Unacknowledged => FrameOutcome::Unacknowledged,
        FrameSentStatus::Acked => FrameOutcome::Acked,
        FrameSentStatus::FailedToSend => FrameOutcome::FailedToSend,
        FrameSentStatus::Other(code) => FrameOutcome::Other(code.into()),
    };
    message.statuses.into_iter().take(count).map(outcome).collect()
}

/// The length of a window; zero if it ends before it begins.
fn length_of(message: &MediumAccess) -> Duration {
    let nanos = u64::try_from(elapsed_nanos(message.created, message.until)).unwrap_or(0);
    Duration::from_nanos(nanos)
}

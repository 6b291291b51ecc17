//! Packets through the vehicle's acoustic modem (SPI 9; safety requirement 016).
//!
//! A packet waits for BFCPS, which names it by our identifier, across losses of the link too: the modem sends it all the
//! same. Where the modem fails no report comes (9.2), so a packet that has none a minute after it left has timed out.

use std::time::Duration;

use backseat_spi::{
    FrameData, FrameReceivedStatus, FrameSentStatus, MAX_LINE, MediumAccess, Packet, PacketReceived, PacketSent,
    ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::clock::elapsed_nanos;
use crate::commands::{Answer, Purpose};
use crate::envelope::limit;
use crate::helm::refused;
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::limits::Grant;
use crate::machine::Core;
use crate::plugin::{
    Event, PacketRequest, PluginId, ReceivedFrame, ReceivedPacket, Refusal, RequestState, Topic, Window,
};
use crate::quota::LastMinute;
use crate::switches::{Check, is_on};
use crate::timer::Timer;

/// A packet's report comes within this or not at all. An acknowledged packet travels some kilometres of water twice, and
/// waits in the modem before that.
const REPORT_WITHIN: Duration = Duration::from_secs(60);
/// A window that ends later than this is a mistaken time of day and no window.
const WINDOW_MAX: Duration = Duration::from_secs(3600);

/// What is known of the modem.
#[derive(Debug, Default)]
pub(crate) struct Acoustic {
    /// When the window was said by the vehicle's clock, and for how long.
    said: Option<(TimeOfDay, Duration)>,
    /// The packets without a report.
    packets: Vec<Unreported>,
    sent: LastMinute,
}

#[derive(Debug)]
struct Unreported {
    request: u64,
    /// Our name for it in BFCPS.
    identifier: u32,
    overdue: Timestamp,
}

impl Core {
    pub(crate) fn ask_packet(&mut self, plugin: PluginId, asked: PacketRequest) {
        let request = self.cx.ledger.propose(plugin, asked.tag, RequestKind::Packet);
        match self.admit_packet(plugin, asked) {
            Ok(packet) => self.send_packet(request, packet),
            Err(refusal) => self.cx.reject(request, refusal),
        }
    }

    fn admit_packet(&mut self, plugin: PluginId, asked: PacketRequest) -> Result<Packet, Refusal> {
        self.cx.admit(plugin, Grant::Acoustic)?;
        for message in ["CMA", "CPS"] {
            if !self.cx.session.is_subscribed(message) {
                let text = format!("the vehicle has not acknowledged the subscription to BF{message}");
                return Err(refused("window", &text));
            }
        }
        self.narrow_window();
        if !self.cx.permits.window_is_open(self.cx.now) && is_on(Check::ModemWindow) {
            return Err(refused("window", "no window is open, or it ends too soon (SPI 9.1)"));
        }
        if self.silent.is_kept() {
            return Err(refused("state", "the vehicle is in silent mode (SPI 7.22)"));
        }
        let most = self.cx.envelope.limits().packets_per_min;
        if !self.acoustic.sent.has_room(self.cx.now, most) {
            let text = format!("{most} packets have been sent in the last minute, the most there may be");
            return Err(refused("rate", &text));
        }
        if asked.mode < 0 {
            return Err(limit(format!("telemetry mode {} is none (SPI 9.3)", asked.mode)));
        }
        let bytes = asked
            .frames
            .iter()
            .fold(0usize, |all, frame| all.saturating_add(frame.len()));
        // Two digits a byte; what else is in the line is seen when it is encoded.
        if bytes > MAX_LINE / 2 {
            return Err(limit(format!("frames of {bytes} bytes do not fit into a line")));
        }
        let frames = FrameData::new(asked.frames).map_err(|error| limit(error.to_string()))?;
        let packet = Packet {
            created: self.cx.stamper.stamp(self.cx.now, "CPD"),
            request: self.packet_identifier()?,
            destination: asked.destination,
            mode: asked.mode,
            ack: asked.acknowledge,
            frames,
        };
        // An identifier is for what can be said.
        match ToVehicle::Packet(packet.clone()).encode(&mut Vec::new()) {
            Ok(()) => Ok(packet),
            Err(error) => Err(limit(error.to_string())),
        }
    }

    /// The next identifier, from the numbers of the inserts: unique for the whole mission, whatever restarts.
    fn packet_identifier(&self) -> Result<u32, Refusal> {
        match self.cx.start.identifiers {
            None => Err(refused("identifier", "the identifiers' state on disk is missing")),
            Some(identifiers) if identifiers.next >= identifiers.reserved && is_on(Check::IdentifiersReserved) => {
                Err(refused("identifier", "no identifier is reserved on disk yet"))
            }
            Some(identifiers) => Ok(identifiers.next),
        }
    }

    fn send_packet(&mut self, request: u64, packet: Packet) {
        let identifier = packet.request;
        if let Some(identifiers) = &mut self.cx.start.identifiers {
            identifiers.next = identifier + 1;
        }
        self.cx.reserve();
        let purpose = Purpose::Packet(request);
        if self
            .cx
            .send_request(request, "CPD", &ToVehicle::Packet(packet), purpose)
        {
            self.acoustic.sent.add(self.cx.now);
            self.acoustic.packets.push(Unreported {
                request,
                identifier,
                overdue: self.cx.now + REPORT_WITHIN,
            });
            self.watch_acoustic();
        }
    }

    pub(crate) fn packet_answered(&mut self, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => self.cx.transition(request, RequestState::Pending),
            Answer::Done => self.cx.transition(request, RequestState::Accepted),
            Answer::Refused(text) => {
                self.acoustic.packets.retain(|packet| packet.request != request);
                self.watch_acoustic();
                self.cx.transition(request, RequestState::Failed(text.to_owned()));
            }
            // The report says more than the acknowledgement would have, and may come yet.
            Answer::Missing => {}
        }
    }

    /// BFCMA. The newest one holds: it may shorten an earlier one.
    pub(crate) fn window(&mut self, message: &MediumAccess) {
        self.cx.heard(message.created);
        self.cx.permits.window_until = None;
        match self.ends_of(message) {
            Ok((until, open_until)) => {
                self.cx.permits.window_until = Some(open_until);
                self.acoustic.said = Some((message.created, length_of(message)));
                let window = Window {
                    until,
                    address: message.address,
                    device: message.device.as_str().to_owned(),
                };
                self.cx.tell_wanting(Topic::Acoustic, &Event::Window(window));
            }
            Err(reason) => self.cx.note(Note::Text {
                text: format!("an acoustic window until {} is none: {reason}", message.until),
            }),
        }
        self.watch_acoustic();
    }

    /// When a window ends on our clock, and until when a packet may leave.
    fn ends_of(&self, message: &MediumAccess) -> Result<(Timestamp, Timestamp), &'static str> {
        let length = length_of(message);
        if length.is_zero() {
            return Err("it ends before it begins");
        }
        if length > WINDOW_MAX {
            return Err("it ends more than an hour after it begins");
        }
        // It may have waited for us, and the vehicle's clock may have been set meanwhile.
        let age = self.age(message.created).max(self.cx.session.reads.waited());
        let until = self.cx.now + length - age;
        let open_until = until - self.before_its_end();
        if open_until > self.cx.now {
            Ok((until, open_until))
        } else {
            Err("nothing that leaves now would arrive in it")
        }
    }

    /// How long before a window's end the last packet may leave: once for the delay that the clocks' offset hides, once
    /// for the packet's own way.
    fn before_its_end(&self) -> Duration {
        2 * self.cx.envelope.limits().link_delay_max()
    }

    /// What is known of the vehicle's clock by now may bring the window's end nearer, and never farther.
    fn narrow_window(&mut self) {
        let Some((created, length)) = self.acoustic.said else {
            return;
        };
        let until = self.cx.now + length - self.age(created) - self.before_its_end();
        self.cx.permits.window_until = self.cx.permits.window_until.map(|open_until| open_until.min(until));
    }

    /// BFCPS: of our packets and of everybody's else.
    pub(crate) fn packet_sent(&mut self, message: &PacketSent) {
        self.cx.heard(message.created);
        let packets = &mut self.acoustic.packets;
        let own = packets.iter().position(|packet| packet.identifier == message.request);
        let Some(index) = own else { return };
        let request = packets.remove(index).request;
        self.watch_acoustic();
        self.cx.transition(request, RequestState::Ended(report(message)));
    }

    /// BFCPR: as many frames as it says, good or not; places that it left empty count as not good.
    pub(crate) fn packet_received(&mut self, message: PacketReceived) {
        self.cx.heard(message.created);
        let count = usize::try_from(message.frames).unwrap_or(usize::MAX);
        let frames = message.data.into_iter().take(count).map(|frame| ReceivedFrame {
            good: frame.status == FrameReceivedStatus::Good,
            data: frame.data.into_vec(),
        });
        let packet = ReceivedPacket {
            arrived: self.cx.now - self.age(message.arrived),
            source: message.source,
            destination: message.destination,
            mode: (message.mode != -1).then_some(message.mode),
            frames: frames.collect(),
        };
        self.cx.tell_wanting(Topic::Acoustic, &Event::Packet(packet));
    }

    pub(crate) fn acoustic_expired(&mut self) {
        if !self.cx.permits.window_is_open(self.cx.now) {
            self.cx.permits.window_until = None;
        }
        let now = self.cx.now;
        let overdue: Vec<Unreported> = self
            .acoustic
            .packets
            .extract_if(.., |packet| packet.overdue <= now)
            .collect();
        self.watch_acoustic();
        for packet in overdue {
            self.cx.transition(packet.request, RequestState::TimedOut);
        }
    }

    /// What is not known to be open is closed. The packets' reports may come on the next connection.
    pub(crate) fn acoustic_link_lost(&mut self) {
        self.cx.permits.window_until = None;
        self.watch_acoustic();
        let unreported: Vec<u64> = self.acoustic.packets.iter().map(|packet| packet.request).collect();
        for request in unreported {
            let state = self.cx.ledger.get(request).map(|entry| &entry.state);
            if matches!(state, Some(RequestState::Sent | RequestState::Pending)) {
                self.cx.transition(request, RequestState::Unknown);
            }
        }
    }

    fn watch_acoustic(&mut self) {
        let packets = self.acoustic.packets.iter().map(|packet| packet.overdue);
        let next = packets.chain(self.cx.permits.window_until).min();
        self.cx.timers.set_or_stop(Timer::Acoustic, next);
    }

    /// How old something of the vehicle's time is.
    fn age(&self, written: TimeOfDay) -> Duration {
        let age = self.cx.tracker.clock().age(self.cx.now, self.cx.utc(), written);
        age.unwrap_or_default()
    }
}

/// What became of a packet, frame by frame.
fn report(message: &PacketSent) -> String {
    let count = usize::try_from(message.frames).unwrap_or(usize::MAX);
    let statuses: Vec<FrameSentStatus> = message.statuses.into_iter().take(count).collect();
    let failed = statuses
        .iter()
        .filter(|status| **status == FrameSentStatus::FailedToSend)
        .count();
    let mut text = match statuses.len() {
        0 => return "no frame was sent".to_owned(),
        1 => "1 frame".to_owned(),
        count => format!("{count} frames"),
    };
    if failed > 0 {
        text.push_str(&format!(", {failed} not sent"));
    }
    for (index, status) in statuses.into_iter().enumerate() {
        text.push_str(if index == 0 { ": " } else { ", " });
        match status {
            FrameSentStatus::Unset => text.push_str("unset"),
            FrameSentStatus::Unacknowledged => text.push_str("unacknowledged"),
            FrameSentStatus::Acked => text.push_str("acked"),
            FrameSentStatus::FailedToSend => text.push_str("failed to send"),
            FrameSentStatus::Other(code) => text.push_str(&format!("status {code}")),
        }
    }
    text
}

/// How long a window lasts; nothing where it ends before it begins.
fn length_of(message: &MediumAccess) -> Duration {
    let nanos = u64::try_from(elapsed_nanos(message.created, message.until)).unwrap_or(0);
    Duration::from_nanos(nanos)
}

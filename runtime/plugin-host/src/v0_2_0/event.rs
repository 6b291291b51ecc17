use backseat_core::plugin as core;
use backseat_units::Timestamp;

use super::{age_ns, sample, sonar, wit};

/// An event as the guest receives it in the step at `now`.
pub(super) fn event(happened: &core::Event, now: Timestamp) -> wit::Event {
    match happened {
        core::Event::Control(held) => wit::Event::Control(*held),
        core::Event::Outcome { tag, state } => wit::Event::Outcome(wit::Outcome {
            tag: *tag,
            state: state.into(),
        }),
        core::Event::Ctd(sample) => wit::Event::Ctd(sample::ctd(sample, now)),
        core::Event::MissionCommand(text) => wit::Event::MissionCommand(text.clone()),
        core::Event::BehaviorBegan(behavior) => wit::Event::BehaviorBegan(behavior.into()),
        core::Event::BehaviorEnded(behavior) => wit::Event::BehaviorEnded(behavior.into()),
        core::Event::Timer(id) => wit::Event::Timer(*id),
        core::Event::Restored { lost_steps, open } => wit::Event::Restored(wit::Restored {
            lost_steps: *lost_steps,
            open: open.clone(),
        }),
        core::Event::Shutdown => wit::Event::Shutdown,
        core::Event::LoggingBegan(text) => wit::Event::LoggingBegan(text.clone()),
        core::Event::LoggingEnded(text) => wit::Event::LoggingEnded(text.clone()),
        core::Event::TopsideMessage { transport, text } => wit::Event::TopsideMessage(wit::TopsideMessage {
            transport: transport.map(wit::Transport::from),
            text: text.clone(),
        }),
        core::Event::DvlTrigger(allowed) => wit::Event::DvlTrigger(*allowed),
        core::Event::Window(window) => wit::Event::Window(wit::Window {
            until_ns: window.until.as_nanos(),
            address: window.address,
            device: window.device.clone(),
        }),
        core::Event::Packet(packet) => wit::Event::Packet(received_packet(packet, now)),
        core::Event::Plan(elements) => wit::Event::Plan(elements.iter().map(wit::PlannedElement::from).collect()),
        core::Event::Sample(sample) => wit::Event::Sample(sample::sample(sample, now)),
        core::Event::Sidescan(ping) => wit::Event::Sidescan(sonar::ping(ping, now)),
        core::Event::SubBottom(ping) => wit::Event::SubBottom(sonar::ping(ping, now)),
        core::Event::Sonar(event) => wit::Event::Sonar(event.into()),
    }
}

fn received_packet(packet: &core::ReceivedPacket, now: Timestamp) -> wit::ReceivedPacket {
    let frames = packet.frames.iter().map(|frame| wit::ReceivedFrame {
        good: frame.good,
        data: frame.data.clone(),
    });
    wit::ReceivedPacket {
        age_ns: age_ns(packet.arrived, now),
        source: packet.source,
        destination: packet.destination,
        mode: packet.mode,
        frames: frames.collect(),
    }
}

impl From<&core::PlannedElement> for wit::PlannedElement {
    fn from(element: &core::PlannedElement) -> Self {
        let points = element.points.iter().map(|(position, local)| wit::PlannedPoint {
            position: (*position).into(),
            east: local.east_m,
            north: local.north_m,
        });
        Self {
            number: element.number,
            identifier: element.identifier,
            points: points.collect(),
        }
    }
}

impl From<core::Transport> for wit::Transport {
    fn from(transport: core::Transport) -> Self {
        match transport {
            core::Transport::Ethernet => Self::Ethernet,
            core::Transport::Wifi => Self::Wifi,
            core::Transport::RadioModem => Self::RadioModem,
            core::Transport::AcousticModem => Self::AcousticModem,
        }
    }
}

impl From<&core::RequestState> for wit::State {
    fn from(state: &core::RequestState) -> Self {
        match state {
            core::RequestState::Rejected(refusal) => Self::Rejected(refusal.into()),
            core::RequestState::Sent => Self::Sent,
            core::RequestState::Pending => Self::Pending,
            core::RequestState::Accepted => Self::Accepted,
            core::RequestState::Failed(failure) => Self::Failed(failure.into()),
            core::RequestState::TimedOut => Self::TimedOut,
            core::RequestState::Unknown => Self::Unknown,
            core::RequestState::Started => Self::Started,
            core::RequestState::Ended(ended) => Self::Ended(ended.into()),
            core::RequestState::Cancelled => Self::Cancelled,
        }
    }
}

impl From<&core::Behavior> for wit::Behavior {
    fn from(behavior: &core::Behavior) -> Self {
        Self {
            kind: behavior.kind.clone(),
            tag: behavior.tag,
        }
    }
}

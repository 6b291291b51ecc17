use core::time::Duration;
use std::collections::VecDeque;

use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use super::peers::Peers;
use crate::file::AcousticConfig;

/// A packet that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) request: u32,
    pub(super) destination: u32,
    pub(super) ack: bool,
    pub(super) frames: usize,
    /// The vehicle's own, not a payload's.
    pub(super) own: bool,
    /// When it was asked for.
    pub(super) asked: Timestamp,
}

/// What became of a packet that was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outcome {
    /// When it began to sound.
    pub(super) sent: Timestamp,
    pub(super) heard: bool,
    pub(super) acked: bool,
}

/// Whether a packet has been taken up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begun {
    /// There is none, or one is under way.
    No,
    Sending,
    /// It would not be through before the window ends.
    TooLate(Request),
}

/// The vehicle's modem: the packets that wait, and the one under way.
#[derive(Debug)]
pub(super) struct Modem {
    stream: Stream,
    queue: VecDeque<Request>,
    state: State,
    idle_since: Timestamp,
    /// The last time that the modem has sounded, from and to.
    sounded: (Timestamp, Timestamp),
    /// Where the vehicle is: east and north, and its depth.
    at: (EastNorth, f64),
}

#[derive(Clone, Copy, Debug)]
enum State {
    Idle,
    Sending {
        request: Request,
        ends: Timestamp,
    },
    /// The packet is through; its acknowledgement is due.
    Listening {
        request: Request,
        outcome: Outcome,
        due: Timestamp,
    },
}

impl Modem {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            stream: Stream::new(seed, "acoustic packets"),
            queue: VecDeque::new(),
            state: State::Idle,
            idle_since: Timestamp::ZERO,
            sounded: (Timestamp::ZERO, Timestamp::ZERO),
            at: (EastNorth::default(), 0.0),
        }
    }

    /// When it next wants to be asked.
    pub(super) fn due(&self) -> Timestamp {
        match self.state {
            State::Idle if self.queue.is_empty() => Timestamp::MAX,
            State::Idle => Timestamp::ZERO,
            State::Sending { ends, .. } => ends,
            State::Listening { due, .. } => due,
        }
    }

    pub(super) fn place(&mut self, at: (EastNorth, f64)) {
        self.at = at;
    }

    pub(super) fn push(&mut self, request: Request) {
        self.queue.push_back(request);
    }

    pub(super) fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Whether a packet with this identifier waits or is under way.
    pub(super) fn holds(&self, request: u32) -> bool {
        let under_way = match self.state {
            State::Idle => false,
            State::Sending { request: of, .. } | State::Listening { request: of, .. } => of.request == request,
        };
        under_way || self.queue.iter().any(|waiting| waiting.request == request)
    }

    /// Whether a packet of the vehicle's own waits: it makes no other then.
    pub(super) fn has_own(&self) -> bool {
        self.queue.iter().any(|request| request.own)
    }

    /// Takes out the payload's first packet that waits.
    pub(super) fn take_payloads(&mut self) -> Option<Request> {
        let at = self.queue.iter().position(|request| !request.own)?;
        self.queue.remove(at)
    }

    /// Whether the modem itself sounds in some part of that time.
    pub(super) fn sounds(&self, from: Timestamp, until: Timestamp) -> bool {
        self.sounded.0 < until && from < self.sounded.1
    }

    /// Takes up the next packet. A payload's must be through before its window ends.
    pub(super) fn begin(&mut self, config: &AcousticConfig, until: Option<Timestamp>) -> Begun {
        if !matches!(self.state, State::Idle) {
            return Begun::No;
        }
        let Some(request) = self.queue.pop_front() else {
            return Begun::No;
        };
        let began = request.asked.max(self.idle_since) + Duration::from_secs_f64(config.latency_s);
        let ends = began + Duration::from_secs_f64(config.frame_s * request.frames as f64);
        if !request.own && until.is_none_or(|until| ends > until) {
            return Begun::TooLate(request);
        }
        self.sounded = (began, ends);
        self.state = State::Sending { request, ends };
        Begun::Sending
    }

    /// The packet that is through, and what became of it.
    pub(super) fn finish(
        &mut self,
        now: Timestamp,
        config: &AcousticConfig,
        peers: &Peers,
    ) -> Option<(Request, Outcome)> {
        if let State::Sending { request, ends } = self.state
            && ends <= now
        {
            // Both are drawn whatever happens, so that one packet's fate does not move the next one's.
            let (there, back) = (self.stream.uniform(), self.stream.uniform());
            let range_m = peers.range_m(request.destination, self.at, ends);
            let heard = range_m.is_some() && there >= config.loss_chance;
            let outcome = Outcome {
                sent: self.sounded.0,
                heard,
                acked: false,
            };
            if !request.ack {
                (self.state, self.idle_since) = (State::Idle, ends);
                return Some((request, outcome));
            }
            let way_s = range_m.unwrap_or(0.0) / config.sound_speed_mps;
            let round_s = 2.0 * way_s + config.turnaround_s + config.ack_s;
            let acked = heard
                && peers.acknowledges(request.destination)
                && back >= config.loss_chance
                && round_s <= config.ack_timeout_s;
            let wait_s = if acked { round_s } else { config.ack_timeout_s };
            self.state = State::Listening {
                request,
                outcome: Outcome { acked, ..outcome },
                due: ends + Duration::from_secs_f64(wait_s),
            };
        }
        if let State::Listening { request, outcome, due } = self.state
            && due <= now
        {
            (self.state, self.idle_since) = (State::Idle, due);
            return Some((request, outcome));
        }
        None
    }
}

use core::time::Duration;
use std::collections::VecDeque;

use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use super::peers::Peers;
use crate::file::AcousticConfig;

/// A packet to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) request: u32,
    pub(super) destination: u32,
    pub(super) ack: bool,
    pub(super) frames: usize,
    /// Whether it is the vehicle's own packet and not a payload's.
    pub(super) own: bool,
    /// When it was requested.
    pub(super) asked: Timestamp,
}

/// The result of sending a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Outcome {
    /// When its transmission began.
    pub(super) sent: Timestamp,
    pub(super) heard: bool,
    pub(super) acked: bool,
}

/// Whether the modem has begun to send a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begun {
    /// None is waiting, or one is being sent.
    No,
    Sending,
    /// Its transmission would not end before the window does.
    TooLate(Request),
}

/// The vehicle's modem: the waiting packets, and the one that is being sent.
#[derive(Debug)]
pub(super) struct Modem {
    stream: Stream,
    queue: VecDeque<Request>,
    state: State,
    idle_since: Timestamp,
    /// Begin and end of the last transmission.
    sounded: (Timestamp, Timestamp),
    /// The vehicle's position and its depth in metres.
    at: (EastNorth, f64),
}

#[derive(Clone, Copy, Debug)]
enum State {
    Idle,
    Sending {
        request: Request,
        ends: Timestamp,
    },
    /// The packet is sent, and the modem waits for its acknowledgement.
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

    /// When [`Modem::begin`] or [`Modem::finish`] next has something to do.
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

    /// Whether a packet with this identifier is waiting or being sent.
    pub(super) fn holds(&self, request: u32) -> bool {
        let under_way = match self.state {
            State::Idle => false,
            State::Sending { request: of, .. } | State::Listening { request: of, .. } => of.request == request,
        };
        under_way || self.queue.iter().any(|waiting| waiting.request == request)
    }

    /// Whether one of the vehicle's own packets is waiting. The vehicle then adds no other.
    pub(super) fn has_own(&self) -> bool {
        self.queue.iter().any(|request| request.own)
    }

    /// Removes and returns the payload's first waiting packet.
    pub(super) fn take_payloads(&mut self) -> Option<Request> {
        let at = self.queue.iter().position(|request| !request.own)?;
        self.queue.remove(at)
    }

    /// Whether the modem itself transmits at any time between `from` and `until`.
    pub(super) fn sounds(&self, from: Timestamp, until: Timestamp) -> bool {
        self.sounded.0 < until && from < self.sounded.1
    }

    /// Begins to send the next packet. The transmission of a payload's packet must end before the window does.
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

    /// The packet that is finished, if there is one, with its result.
    pub(super) fn finish(
        &mut self,
        now: Timestamp,
        config: &AcousticConfig,
        peers: &Peers,
    ) -> Option<(Request, Outcome)> {
        if let State::Sending { request, ends } = self.state
            && ends <= now
        {
            // Both numbers are always drawn, so that the result of one packet does not change the draws for the next.
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

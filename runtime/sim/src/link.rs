use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::Timestamp;
use backseat_world::Stream;

/// The least and the most that a write takes to the other side: an onboard Ethernet with a busy computer at each end.
const DELAY_MIN: Duration = Duration::from_micros(200);
pub(crate) const DELAY_MAX: Duration = Duration::from_millis(15);

/// One direction of the vehicle link: what is written comes out whole, in order, a little later.
#[derive(Debug)]
pub(crate) struct Lane {
    delay: Stream,
    under_way: VecDeque<(Timestamp, Vec<u8>)>,
    spare: Vec<Vec<u8>>,
    last: Timestamp,
}

impl Lane {
    pub(crate) fn new(seed: u64, name: &str) -> Self {
        Self {
            delay: Stream::new(seed, name),
            under_way: VecDeque::new(),
            spare: Vec::new(),
            last: Timestamp::ZERO,
        }
    }

    pub(crate) fn write(&mut self, now: Timestamp, bytes: &[u8]) {
        let span = DELAY_MAX - DELAY_MIN;
        // Mostly short: the square of a uniform number.
        let share = self.delay.uniform();
        let arrives = now + DELAY_MIN + span.mul_f64(share * share);
        self.last = self.last.max(arrives);
        let mut buffer = self.spare.pop().unwrap_or_default();
        buffer.clear();
        buffer.extend_from_slice(bytes);
        self.under_way.push_back((self.last, buffer));
    }

    pub(crate) fn next(&self) -> Option<Timestamp> {
        self.under_way.front().map(|(at, _)| *at)
    }

    pub(crate) fn take(&mut self) -> Option<Vec<u8>> {
        self.under_way.pop_front().map(|(_, bytes)| bytes)
    }

    /// Gives a buffer back.
    pub(crate) fn recycle(&mut self, buffer: Vec<u8>) {
        self.spare.push(buffer);
    }

    /// The connection is gone, and what was under way with it.
    pub(crate) fn cut(&mut self) {
        self.under_way.clear();
    }
}

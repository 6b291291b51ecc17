use std::collections::VecDeque;
use std::time::Duration;

use backseat_mvc::{Fault, FaultyLink};
use backseat_units::Timestamp;
use backseat_world::Stream;

/// The shortest and the longest time that a write takes to the other side: an onboard Ethernet with a busy computer at
/// each end.
const DELAY_MIN: Duration = Duration::from_micros(200);
pub(crate) const DELAY_MAX: Duration = Duration::from_millis(15);

/// One direction of the vehicle link: bytes come out complete, in order, a little later. If the run has faults of the
/// link, they act before that.
#[derive(Debug)]
pub(crate) struct Lane {
    delay: Stream,
    under_way: VecDeque<(Timestamp, Vec<u8>)>,
    spare: Vec<Vec<u8>>,
    last: Timestamp,
    faults: Option<FaultyLink>,
}

impl Lane {
    pub(crate) fn new(seed: u64, name: &str) -> Self {
        Self {
            delay: Stream::new(seed, name),
            under_way: VecDeque::new(),
            spare: Vec::new(),
            last: Timestamp::ZERO,
            faults: None,
        }
    }

    /// Opens a new connection, with its faults.
    pub(crate) fn open(&mut self, faults: Option<FaultyLink>) {
        self.faults = faults;
    }

    /// Adds a fault to the open connection, from now on. If the connection has no faults yet, `link` makes the link
    /// that plays them.
    pub(crate) fn inject(&mut self, fault: &Fault, link: impl FnOnce() -> FaultyLink) {
        self.faults.get_or_insert_with(link).inject(fault);
    }

    /// Writes bytes. `seen` gets the bytes that go on their way now, which are not always the bytes that are written.
    pub(crate) fn write(&mut self, now: Timestamp, bytes: &[u8], mut seen: impl FnMut(&[u8])) {
        match &mut self.faults {
            None => {
                seen(bytes);
                self.carry(now, bytes);
            }
            Some(link) => {
                if let Some(bytes) = link.pass(now, bytes) {
                    seen(bytes);
                    self.carry(now, bytes);
                } else {
                    self.release(now, seen);
                }
            }
        }
    }

    /// Sends the bytes on their way that faults have held back until now.
    pub(crate) fn release(&mut self, now: Timestamp, mut seen: impl FnMut(&[u8])) {
        while let Some(link) = &mut self.faults
            && let Some(chunk) = link.poll(now)
        {
            seen(&chunk);
            self.carry(now, &chunk);
            if let Some(link) = &mut self.faults {
                link.recycle(chunk);
            }
        }
    }

    fn carry(&mut self, now: Timestamp, bytes: &[u8]) {
        let span = DELAY_MAX - DELAY_MIN;
        // Most delays are short: the square of a uniform number.
        let share = self.delay.uniform();
        let arrives = now + DELAY_MIN + span.mul_f64(share * share);
        self.last = self.last.max(arrives);
        let mut buffer = self.spare.pop().unwrap_or_default();
        buffer.clear();
        buffer.extend_from_slice(bytes);
        self.under_way.push_back((self.last, buffer));
    }

    /// When something arrives.
    pub(crate) fn next(&self) -> Option<Timestamp> {
        self.under_way.front().map(|(at, _)| *at)
    }

    /// When a fault releases bytes, or ends the connection.
    pub(crate) fn next_fault(&self) -> Option<Timestamp> {
        self.faults.as_ref().and_then(FaultyLink::poll_timeout)
    }

    /// Whether a fault has ended the connection.
    pub(crate) fn is_cut(&self, now: Timestamp) -> bool {
        self.faults.as_ref().is_some_and(|link| link.is_cut(now))
    }

    /// When a write will have waited for its acknowledgement for `within`.
    pub(crate) fn gives_up(&self, within: Duration) -> Option<Timestamp> {
        self.faults.as_ref().and_then(|link| link.gives_up(within))
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
        self.faults = None;
    }
}

#[cfg(test)]
mod tests {
    use backseat_mvc::{ClientId, Direction, FaultPlan, LinkFaults};

    use super::*;

    fn lane(faults: &str) -> Lane {
        let plan = FaultPlan::from_toml(faults).unwrap();
        let mut lane = Lane::new(1, "test");
        let link = LinkFaults::new(&plan, 1).link(Timestamp::ZERO, ClientId(1), None, Direction::ToVehicle);
        lane.open(Some(link));
        lane
    }

    fn arrivals(lane: &mut Lane) -> Vec<(Timestamp, Vec<u8>)> {
        for second in 1..20 {
            lane.write(Timestamp::from_secs(second), &[second as u8], |_| {});
        }
        core::iter::from_fn(|| lane.next().zip(lane.take())).collect()
    }

    #[test]
    fn a_fault_that_does_not_act_changes_no_delay() {
        let mut without = Lane::new(1, "test");
        let mut with = lane("[[fault]]\nkind = \"stall\"\nat_s = 100\nfor_s = 5\n");
        assert_eq!(arrivals(&mut without), arrivals(&mut with));
    }

    #[test]
    fn bytes_that_a_stall_holds_back_are_seen_and_carried_at_its_end() {
        let mut lane = lane("[[fault]]\nkind = \"stall\"\nat_s = 1\nfor_s = 2\n");
        let (mut seen, end) = (Vec::new(), Timestamp::from_secs(3));
        lane.write(Timestamp::from_secs(2), b"ab", |bytes| seen.extend_from_slice(bytes));
        assert!(seen.is_empty() && lane.next().is_none());
        assert_eq!(
            (lane.next_fault(), lane.gives_up(Duration::from_secs(2))),
            (Some(end), Some(Timestamp::from_secs(4)))
        );
        lane.release(end, |bytes| seen.extend_from_slice(bytes));
        assert_eq!(seen, b"ab");
        assert!(lane.next().is_some_and(|at| at > end && at <= end + DELAY_MAX));
        lane.cut();
        assert_eq!((lane.next(), lane.next_fault()), (None, None));
    }
}

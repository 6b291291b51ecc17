//! How long the bytes that are read now can have waited before. While our process is stopped or the link stands still,
//! the vehicle's sentences pile up. The times in them tell their age only as far as the vehicle's clock can be trusted.

use std::time::Duration;

use backseat_units::Timestamp;

/// If no bytes come for this long, everything that had piled up has been read.
const PAUSE: Duration = Duration::from_millis(100);
/// Everything that has piled up is read within this time.
const READ_WITHIN: Duration = Duration::from_secs(2);

/// When bytes were read from the link.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Reads {
    last: Timestamp,
    /// The last read before the last pause, and the first after it.
    paused: Timestamp,
    resumed: Timestamp,
}

impl Reads {
    /// A new connection: nothing that comes on it is older.
    pub(crate) const fn begin(&mut self, now: Timestamp) {
        (self.last, self.paused, self.resumed) = (now, now, now);
    }

    /// Bytes have been read.
    pub(crate) fn read(&mut self, now: Timestamp) {
        if now.since(self.last) >= PAUSE {
            (self.paused, self.resumed) = (self.last, now);
        }
        self.last = now;
    }

    /// The longest time for which the bytes that are read now can have waited.
    pub(crate) fn waited(&self) -> Duration {
        if self.last.since(self.resumed) <= READ_WITHIN {
            self.last.since(self.paused)
        } else {
            READ_WITHIN
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_after_a_pause_may_be_as_old_as_the_pause_until_all_have_been_read() {
        let at = Timestamp::from_millis;
        let mut reads = Reads::default();
        reads.begin(at(1000));
        for millis in [1250, 1500] {
            reads.read(at(millis));
        }
        assert_eq!(reads.waited(), Duration::from_millis(250));
        // The process is stopped for ten seconds. Then it reads what has piled up in three parts.
        for (millis, waited_ms) in [(11_500, 10_000), (11_501, 10_001), (11_540, 10_040)] {
            reads.read(at(millis));
            assert_eq!(reads.waited(), Duration::from_millis(waited_ms));
        }
        reads.read(at(11_750));
        assert_eq!(reads.waited(), Duration::from_millis(210));
        // No pause for a long time: we keep up with the link.
        for tick in 1..100 {
            reads.read(at(11_750 + 50 * tick));
        }
        assert_eq!(reads.waited(), READ_WITHIN);
        reads.begin(at(60_000));
        reads.read(at(60_020));
        assert_eq!(reads.waited(), Duration::from_millis(20));
    }
}

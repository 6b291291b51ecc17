//! Since when what is read now can have waited to be read: a process that was stopped, and a link that stood still, let
//! the vehicle's sentences pile up, and their own times tell how old they are only as far as its clock can be believed.

use std::time::Duration;

use backseat_units::Timestamp;

/// After a pause of this in what comes all has been read that there was.
const PAUSE: Duration = Duration::from_millis(100);
/// What piled up is read within this.
const READ_WITHIN: Duration = Duration::from_secs(2);

/// When the link was read.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Reads {
    last: Timestamp,
    /// The last read before the last pause, and the first after it.
    paused: Timestamp,
    resumed: Timestamp,
}

impl Reads {
    /// A new connection: nothing on it is older.
    pub(crate) const fn begin(&mut self, now: Timestamp) {
        (self.last, self.paused, self.resumed) = (now, now, now);
    }

    /// Something is read.
    pub(crate) fn read(&mut self, now: Timestamp) {
        if now.since(self.last) >= PAUSE {
            (self.paused, self.resumed) = (self.last, now);
        }
        self.last = now;
    }

    /// The longest that what is read now can have waited.
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
    fn what_is_read_after_a_pause_may_be_as_old_as_the_pause_until_all_has_been_read() {
        let at = Timestamp::from_millis;
        let mut reads = Reads::default();
        reads.begin(at(1000));
        for millis in [1250, 1500] {
            reads.read(at(millis));
        }
        assert_eq!(reads.waited(), Duration::from_millis(250));
        // Stopped for ten seconds; what piled up is read in three goes.
        for (millis, waited_ms) in [(11_500, 10_000), (11_501, 10_001), (11_540, 10_040)] {
            reads.read(at(millis));
            assert_eq!(reads.waited(), Duration::from_millis(waited_ms));
        }
        reads.read(at(11_750));
        assert_eq!(reads.waited(), Duration::from_millis(210));
        // Without a pause for long: it is being kept up with.
        for tick in 1..100 {
            reads.read(at(11_750 + 50 * tick));
        }
        assert_eq!(reads.waited(), READ_WITHIN);
        reads.begin(at(60_000));
        reads.read(at(60_020));
        assert_eq!(reads.waited(), Duration::from_millis(20));
    }
}

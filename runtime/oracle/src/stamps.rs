use std::collections::VecDeque;

use crate::time_of_day::TimeOfDay;

/// The timestamps of our sentences, by name. Acknowledgements are matched by them, so no timestamp may come twice (SPI
/// 6.21).
#[derive(Clone, Debug, Default)]
pub(crate) struct Stamps {
    names: Vec<([u8; 5], Used)>,
}

#[derive(Clone, Debug, Default)]
struct Used {
    latest: TimeOfDay,
    /// The newest timestamps, for senders whose times are not in order.
    recent: VecDeque<TimeOfDay>,
}

impl Stamps {
    /// Far more names than SPI has. The bound keeps random names from filling the memory.
    const NAMES_MAX: usize = 64;
    /// How many timestamps are remembered. Timestamps in order need none.
    const RECENT_MAX: usize = 1024;

    /// Returns whether the name had this timestamp before, and remembers it.
    pub(crate) fn repeats(&mut self, name: [u8; 5], stamp: TimeOfDay) -> bool {
        let stamp = stamp.to_the_millisecond();
        let Some((_, used)) = self.names.iter_mut().find(|(known, _)| *known == name) else {
            if self.names.len() < Self::NAMES_MAX {
                let recent = VecDeque::from([stamp]);
                self.names.push((name, Used { latest: stamp, recent }));
            }
            return false;
        };
        // A time that is later than the latest, the shorter way round midnight, is new without a search.
        let later = stamp.nanos_since(used.latest) > 0;
        if !later && used.recent.contains(&stamp) {
            return true;
        }
        if later {
            used.latest = stamp;
        }
        if used.recent.len() == Self::RECENT_MAX {
            used.recent.pop_front();
        }
        used.recent.push_back(stamp);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_millisecond_of_the_same_name_repeats() {
        let at = crate::time_of_day::from_millis;
        let mut stamps = Stamps::default();
        for (name, millis, repeats) in [
            (b"BPRMB", 86_399_000, false),
            (b"BPEMB", 86_399_000, false),
            (b"BPRMB", 86_399_001, false),
            (b"BPRMB", 86_399_000, true),
            (b"BPRMB", 86_398_000, false),
            (b"BPRMB", 5, false),
            (b"BPRMB", 5, true),
            (b"BPRMB", 86_399_001, true),
        ] {
            assert_eq!(stamps.repeats(*name, at(millis)), repeats, "{millis}");
        }
    }
}

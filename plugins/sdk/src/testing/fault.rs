use std::time::Duration;

/// Something that goes wrong in a [`Basin`](super::Basin). Times count from the beginning of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The backseat has no control for a while: a modify ends, and every request is rejected.
    NoControl {
        /// When it is lost.
        from: Duration,
        /// For how long.
        lasts: Duration,
    },
    /// There is no navigation for a while.
    NoNavigation {
        /// When it is lost.
        from: Duration,
        /// For how long.
        lasts: Duration,
    },
    /// The next requests for inserts and modifies are rejected for a reason that passes.
    Rejections {
        /// From when on.
        from: Duration,
        /// How many.
        count: u32,
    },
    /// The next requests for inserts and modifies are not answered.
    NoAnswers {
        /// From when on.
        from: Duration,
        /// How many.
        count: u32,
    },
    /// The vehicle ends what it is flying.
    EndsEarly {
        /// When.
        at: Duration,
    },
    /// The plugin fails: a new instance goes on from a snapshot that is some steps old.
    Restart {
        /// When.
        at: Duration,
        /// How many steps the new instance has not seen.
        lost_steps: u64,
    },
}

impl Fault {
    /// Up to five faults within the first hour, the same ones for each seed.
    #[must_use]
    pub fn draw(seed: u64) -> Vec<Self> {
        let mut state = seed;
        // SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
        let mut below = |bound: u64| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (mixed ^ (mixed >> 31)) % bound
        };
        let count = below(6);
        let faults = (0..count).map(|_| {
            let from = Duration::from_secs(below(3600));
            let lasts = Duration::from_secs(1 + below(300));
            match below(6) {
                0 => Self::NoControl { from, lasts },
                1 => Self::NoNavigation { from, lasts },
                2 => Self::Rejections {
                    from,
                    count: 1 + below(10) as u32,
                },
                3 => Self::NoAnswers { from, count: 1 },
                4 => Self::EndsEarly { at: from },
                _ => Self::Restart {
                    at: from,
                    lost_steps: below(10),
                },
            }
        });
        faults.collect()
    }
}

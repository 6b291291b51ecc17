use backseat_sdk::units::EastNorth;
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
/// How many fixes are kept to locate samples: enough for the latest sample.
const FIXES_MAX: usize = 64;
/// For how long after the newest fix its velocity is used.
const BEYOND_NS: u64 = 2 * SECOND_NS;
/// The longest time between two fixes. The path between fixes farther apart is unknown.
const GAP_NS: u64 = 10 * SECOND_NS;
/// A bin is complete with this many samples, or at this length or time.
const BIN_SAMPLES: u32 = 10;
const BIN_LENGTH_M: f64 = 16.0;
const BIN_NS: u64 = 12 * SECOND_NS;
/// Bins beyond this number are not kept: about 20 hours of travel.
const BINS_MAX: usize = 8192;

/// A position of the vehicle at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Fix {
    at_ns: u64,
    at: EastNorth,
    depth_m: f64,
    velocity_mps: EastNorth,
}

/// The mean of some successive samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Mean position, metres from the area's centre.
    pub at: EastNorth,
    /// Mean value.
    pub value: f64,
    /// The number of samples.
    pub count: u32,
}

/// Measurements with the positions where they were made.
///
/// A sample has the time of its measurement; its position is interpolated between the fixes around that time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    fixes: Vec<Fix>,
    bins: Vec<Bin>,
    open: Option<Open>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Open {
    first: EastNorth,
    first_ns: u64,
    sum: EastNorth,
    value: f64,
    count: u32,
}

impl Samples {
    /// Takes in the vehicle's position, depth and velocity at a time, nanoseconds. A fix older than the newest is
    /// ignored.
    pub fn fix(&mut self, at_ns: u64, at: EastNorth, depth_m: f64, velocity_mps: EastNorth) {
        let numbers = [
            at.east_m,
            at.north_m,
            depth_m,
            velocity_mps.east_m,
            velocity_mps.north_m,
        ];
        let late = self.fixes.last().is_some_and(|last| at_ns <= last.at_ns);
        if late || numbers.iter().any(|number| !number.is_finite()) {
            return;
        }
        if self.fixes.len() >= FIXES_MAX {
            self.fixes.remove(0);
        }
        self.fixes.push(Fix {
            at_ns,
            at,
            depth_m,
            velocity_mps,
        });
    }

    /// The vehicle's position and depth at a time; `None` if the fixes do not determine them.
    #[must_use]
    pub fn place(&self, at_ns: u64) -> Option<(EastNorth, f64)> {
        let after = self.fixes.partition_point(|fix| fix.at_ns < at_ns);
        let Some(next) = self.fixes.get(after) else {
            let last = self.fixes.last()?;
            let beyond_ns = at_ns - last.at_ns;
            if beyond_ns > BEYOND_NS {
                return None;
            }
            let beyond_s = beyond_ns as f64 / SECOND_NS as f64;
            return Some((last.at + last.velocity_mps * beyond_s, last.depth_m));
        };
        if next.at_ns == at_ns {
            return Some((next.at, next.depth_m));
        }
        let before = self.fixes.get(after.checked_sub(1)?)?;
        let apart_ns = next.at_ns - before.at_ns;
        if apart_ns > GAP_NS {
            return None;
        }
        let share = (at_ns - before.at_ns) as f64 / apart_ns as f64;
        let depth_m = before.depth_m + (next.depth_m - before.depth_m) * share;
        Some((before.at + (next.at - before.at) * share, depth_m))
    }

    /// Takes in a value measured at a position and time.
    pub fn sample(&mut self, at_ns: u64, at: EastNorth, value: f64) {
        if !value.is_finite() {
            return;
        }
        let goes_on = self.open.is_some_and(|open| {
            open.count < BIN_SAMPLES
                && open.first.distance_m(at) <= BIN_LENGTH_M
                && at_ns.saturating_sub(open.first_ns) <= BIN_NS
        });
        if !goes_on {
            self.close();
        }
        let open = self.open.get_or_insert(Open {
            first: at,
            first_ns: at_ns,
            sum: EastNorth::default(),
            value: 0.0,
            count: 0,
        });
        open.sum = open.sum + at;
        open.value += value;
        open.count += 1;
    }

    /// The complete bins in order, without the one that is being filled.
    #[must_use]
    pub fn bins(&self) -> &[Bin] {
        &self.bins
    }

    fn close(&mut self) {
        let Some(open) = self.open.take() else { return };
        if self.bins.len() >= BINS_MAX {
            return;
        }
        let share = 1.0 / f64::from(open.count);
        self.bins.push(Bin {
            at: open.sum * share,
            value: open.value * share,
            count: open.count,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples() -> Samples {
        let mut samples = Samples::default();
        for second in 0..4u64 {
            let east_m = 1.5 * second as f64;
            samples.fix(
                second * SECOND_NS,
                EastNorth::new(east_m, 0.0),
                10.0 + second as f64,
                EastNorth::new(1.5, 0.0),
            );
        }
        samples
    }

    #[test]
    fn a_position_is_interpolated_and_extrapolated_a_little() {
        let samples = samples();
        let (at, depth_m) = samples.place(1_500_000_000).unwrap();
        assert!((at.east_m - 2.25).abs() < 1e-9 && (depth_m - 11.5).abs() < 1e-9);
        assert!((samples.place(4 * SECOND_NS).unwrap().0.east_m - 6.0).abs() < 1e-9);
        assert_eq!(samples.place(2 * SECOND_NS).unwrap().0.east_m, 3.0);
        assert_eq!(samples.place(6 * SECOND_NS), None);
        assert_eq!(Samples::default().place(0), None);
    }

    #[test]
    fn successive_samples_are_averaged_and_a_jump_begins_a_new_bin() {
        let mut samples = samples();
        for index in 0..13u64 {
            let east_m = 1.5 * index as f64;
            samples.sample(index * SECOND_NS, EastNorth::new(east_m, 0.0), 12.0 + east_m);
        }
        samples.sample(13 * SECOND_NS, EastNorth::new(500.0, 0.0), 1.0);
        samples.sample(14 * SECOND_NS, EastNorth::new(500.0, 0.0), f64::NAN);
        assert_eq!(samples.bins().iter().map(|bin| bin.count).collect::<Vec<_>>(), [10, 3]);
        assert!((samples.bins()[0].at.east_m - 6.75).abs() < 1e-9);
        assert!((samples.bins()[0].value - 18.75).abs() < 1e-9);
    }
}

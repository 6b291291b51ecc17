use std::time::Duration;

use backseat_core::Operator;
use backseat_mvc::{Fault, FaultKind, FaultPlan};
use backseat_plugin_loader::Loaded;
use backseat_sim::{SimError, Simulation, Step};
use backseat_units::Timestamp;
use backseat_world::Stream;
use serde::{Deserialize, Serialize};

/// The shares of the hunt's faults that are of the vehicle, its navigation and the link, and of our own computer. The
/// hunt's others are of plugins that are made to fail.
const VEHICLE: f64 = 0.5;
const COMPUTER: f64 = 0.2;
/// The chance of a further fault that ends the mission or switches off the payload's power.
const FATAL_CHANCE: f64 = 0.04;
/// The most faults of a run.
const COUNT_MAX: u32 = 1000;
/// The latest time of a fault, seconds.
const UNTIL_MAX_S: f64 = 86_400.0;

/// Faults that a run's seed draws, as the hunt draws them: of the link, of the vehicle, of its navigation and of our
/// computer, with the hunt's chances for each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnFaults {
    /// The smallest and the largest number of faults in a run.
    #[serde(deserialize_with = "two")]
    pub count: [u32; 2],
    /// The earliest time at which one begins, seconds after the start.
    pub from_s: f64,
    /// The latest time at which one begins, seconds after the start.
    pub until_s: f64,
}

/// Exactly two numbers: an array would leave a third out.
fn two<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<[u32; 2], D::Error> {
    let numbers = Vec::<u32>::deserialize(deserializer)?;
    <[u32; 2]>::try_from(numbers).map_err(|numbers| {
        serde::de::Error::custom(format!("count has {} numbers: expected [least, most]", numbers.len()))
    })
}

impl DrawnFaults {
    pub(crate) fn validate(&self) -> Result<(), String> {
        let [least, most] = self.count;
        if least > most || most > COUNT_MAX {
            return Err(format!(
                "faults.count is [{least}, {most}]: expected [least, most] within 0 to {COUNT_MAX}"
            ));
        }
        if !(0.0 <= self.from_s && self.from_s <= self.until_s && self.until_s <= UNTIL_MAX_S) {
            return Err(format!(
                "faults.from_s is {} and faults.until_s is {}: expected from_s up to until_s, within 0 to {UNTIL_MAX_S}",
                self.from_s, self.until_s
            ));
        }
        Ok(())
    }

    /// The faults of a seed.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Interference {
        let mut stream = Stream::new(seed, "drawn faults");
        let [least, most] = self.count;
        let count = least + (stream.uniform() * f64::from(most - least + 1)) as u32;
        let (mut faults, mut computer, mut acts) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..count.min(most) {
            let at = self.time(&mut stream);
            if stream.uniform() < VEHICLE / (VEHICLE + COMPUTER) {
                faults.push(Fault {
                    at,
                    ..vehicle_fault(&mut stream)
                });
            } else {
                computer.push(computer_fault(at, &mut stream, &mut acts));
            }
        }
        if most > 0 && stream.uniform() < FATAL_CHANCE {
            let (kind, lasts) = if stream.uniform() < 0.5 {
                (FaultKind::MissionAbort, Duration::ZERO)
            } else {
                (FaultKind::Shutdown, Duration::from_secs(60))
            };
            let at = self.time(&mut stream);
            faults.push(Fault { at, lasts, kind });
        }
        faults.sort_by_key(|fault| fault.at);
        computer.sort_by_key(|fault| fault.at);
        acts.sort_by_key(|(at, _)| *at);
        Interference {
            plan: FaultPlan { faults },
            computer,
            acts: acts.into(),
        }
    }

    /// Whole milliseconds.
    fn time(&self, stream: &mut Stream) -> Timestamp {
        Timestamp::ZERO + millis(stream, self.from_s, self.until_s)
    }
}

impl std::str::FromStr for DrawnFaults {
    type Err = String;

    /// As in `sim --draw-faults 3..9@30..800`: so many faults, from then until then.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("`{text}`: expected COUNT..COUNT@FROM_S..UNTIL_S, such as 3..9@30..800");
        let parse = || -> Option<Self> {
            let (count, times) = text.split_once('@')?;
            let (least, most) = count.split_once("..").unwrap_or((count, count));
            let (from, until) = times.split_once("..")?;
            Some(Self {
                count: [least.parse().ok()?, most.parse().ok()?],
                from_s: from.parse().ok()?,
                until_s: until.parse().ok()?,
            })
        };
        let faults = parse().ok_or_else(expected)?;
        faults.validate()?;
        Ok(faults)
    }
}

impl std::fmt::Display for DrawnFaults {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [least, most] = self.count;
        write!(f, "{least}..{most}@{}..{}", self.from_s, self.until_s)
    }
}

/// A fault as a report tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct ToldFault {
    /// When it begins.
    pub at: Timestamp,
    /// How long it lasts.
    pub lasts: Duration,
    /// In words, such as `the runtime is killed`.
    pub what: String,
}

/// What is done to our own computer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Act {
    Kill { away: Duration, clock_step_ns: i64 },
    Stop { lasts: Duration },
    Hold,
    Release,
    DiskFull,
    DiskHasRoom,
}

/// The drawn faults of one run: those that the vehicle and the link have in their plan, and those that are done to the
/// runtime while it flies.
#[derive(Clone, Debug)]
pub struct Interference {
    plan: FaultPlan,
    computer: Vec<ToldFault>,
    acts: std::collections::VecDeque<(Timestamp, Act)>,
}

impl Interference {
    /// The faults of the vehicle and of the link.
    #[must_use]
    pub const fn plan(&self) -> &FaultPlan {
        &self.plan
    }

    /// The faults of our own computer, which no plan of the vehicle has, by time.
    #[must_use]
    pub fn computer(&self) -> &[ToldFault] {
        &self.computer
    }

    /// How many faults of our computer had begun by a time.
    #[must_use]
    pub fn begun(&self, by: Timestamp) -> u64 {
        self.computer.iter().filter(|fault| fault.at <= by).count() as u64
    }

    /// How often something is done to the runtime, or ends.
    #[must_use]
    pub fn acts(&self) -> usize {
        self.acts.len()
    }

    /// Goes on to the next event of a simulation, as [`Simulation::advance`], and does what is due. `reload` starts the
    /// plugins of a process that follows a killed one.
    ///
    /// # Errors
    ///
    /// Those of the simulation and of `reload`.
    pub fn advance<E: From<SimError>>(
        &mut self,
        simulation: &mut Simulation,
        reload: impl Fn() -> Result<Loaded, E>,
    ) -> Result<bool, E> {
        let limit = self.acts.front().map_or(Timestamp::MAX, |(at, _)| *at);
        match simulation.advance_until(limit)? {
            Step::Went => Ok(true),
            Step::Over => Ok(false),
            Step::Reached => {
                if let Some((_, act)) = self.acts.pop_front() {
                    act.carry_out(simulation, reload)?;
                }
                Ok(true)
            }
        }
    }
}

impl Act {
    fn carry_out<E>(self, simulation: &mut Simulation, reload: impl Fn() -> Result<Loaded, E>) -> Result<(), E> {
        match self {
            Self::Kill { away, clock_step_ns } => simulation.kill(away, reload()?, clock_step_ns),
            Self::Stop { lasts } => simulation.stop_for(lasts),
            Self::Hold => simulation.operate(Operator::Hold),
            Self::Release => simulation.operate(Operator::Release),
            Self::DiskFull => simulation.reserve_fails(true),
            Self::DiskHasRoom => simulation.reserve_fails(false),
        }
        Ok(())
    }
}

/// A fault that does not end the mission, with its own duration.
fn vehicle_fault(stream: &mut Stream) -> Fault {
    loop {
        // The mock's own draw knows the range of each kind.
        let mut plan = FaultPlan::draw(stream.next_u64(), Duration::from_secs(60), 0.25);
        if let Some(fault) = plan.faults.pop()
            && !matches!(fault.kind, FaultKind::MissionAbort | FaultKind::Shutdown)
        {
            return fault;
        }
    }
}

/// Draws a fault of our computer, and adds what is done for it.
fn computer_fault(at: Timestamp, stream: &mut Stream, acts: &mut Vec<(Timestamp, Act)>) -> ToldFault {
    /// How far the computer's clock is set when a new process begins, seconds.
    const CLOCK_STEPS_S: [f64; 8] = [-86_400.0, -3600.0, -70.0, -2.5, 0.2, 30.0, 61.0, 4000.0];
    let clock_s = CLOCK_STEPS_S[((stream.uniform() * 8.0) as usize).min(7)];
    let kind = (stream.uniform() * 6.0) as u32;
    let (least_s, most_s) = match kind {
        0 | 1 => (0.1, 20.0),
        2 => (1.0, 30.0),
        3 => (0.05, 1.0),
        4 => (1.0, 60.0),
        _ => (5.0, 120.0),
    };
    let lasts = millis(stream, least_s, most_s);
    let mut act = |after, act| acts.push((at + after, act));
    let what = match kind {
        0 => {
            let clock_step_ns = 0;
            act(
                Duration::ZERO,
                Act::Kill {
                    away: lasts,
                    clock_step_ns,
                },
            );
            "the runtime is killed".to_owned()
        }
        1 => {
            let clock_step_ns = (clock_s * 1e9) as i64;
            act(
                Duration::ZERO,
                Act::Kill {
                    away: lasts,
                    clock_step_ns,
                },
            );
            format!("the runtime is killed, and starts again with its clock set by {clock_s:+} s")
        }
        2 | 3 => {
            act(Duration::ZERO, Act::Stop { lasts });
            "the runtime is stopped".to_owned()
        }
        4 => {
            act(Duration::ZERO, Act::Hold);
            act(lasts, Act::Release);
            "the operator holds".to_owned()
        }
        _ => {
            act(Duration::ZERO, Act::DiskFull);
            act(lasts, Act::DiskHasRoom);
            "the disk is full".to_owned()
        }
    };
    ToldFault { at, lasts, what }
}

fn millis(stream: &mut Stream, least_s: f64, most_s: f64) -> Duration {
    Duration::from_millis((stream.uniform_in(least_s, most_s) * 1000.0).round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAULTS: DrawnFaults = DrawnFaults {
        count: [3, 9],
        from_s: 30.0,
        until_s: 800.0,
    };

    #[test]
    fn a_seed_draws_its_faults_within_their_times() {
        let (mut counts, mut acts) = (Vec::new(), 0);
        for seed in 1..=200 {
            let drawn = FAULTS.draw(seed);
            assert_eq!(drawn.plan, FAULTS.draw(seed).plan);
            for fault in &drawn.plan.faults {
                assert!((30.0..=800.0).contains(&fault.at.as_secs_f64()));
            }
            // A fault that ends the mission is drawn besides.
            let all = drawn.plan.faults.len() + drawn.computer.len();
            assert!((3..=10).contains(&all), "{all} faults");
            for fault in &drawn.computer {
                assert!((30.0..=800.0).contains(&fault.at.as_secs_f64()) && !fault.lasts.is_zero());
            }
            assert_eq!(
                drawn.begun(Timestamp::ZERO + Duration::from_secs(1000)),
                drawn.computer.len() as u64
            );
            assert_eq!(drawn.begun(Timestamp::ZERO), 0);
            counts.push(drawn.plan.faults.len());
            acts += drawn.acts();
        }
        assert!(counts.iter().any(|count| *count >= 7) && counts.iter().any(|count| *count <= 2));
        assert!(acts > 200);
    }

    #[test]
    fn faults_are_written_as_one_argument() {
        assert_eq!("3..9@30..800".parse(), Ok(FAULTS));
        assert_eq!(FAULTS.to_string().parse(), Ok(FAULTS));
        for text in ["", "3..9", "9..3@0..1", "3@800..30", "3@0..1e9", "-1@0..1", "3@nan..5"] {
            assert!(text.parse::<DrawnFaults>().is_err(), "{text}");
        }
    }
}

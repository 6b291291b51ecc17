use core::time::Duration;

use backseat_spi::CommandName;
use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use super::{
    AckFilter, AckStage, Directions, Fault, FaultKind, FaultPlan, LinkFault, LinkFaultKind, NegativeStatus, Untrue,
    Whom,
};
use crate::faults::Sensor;

/// The mean time from one fault to the next at full intensity, seconds.
const EVERY_S: f64 = 15.0;
/// The most faults that a drawn plan has.
const DRAWN_MAX: u32 = 100_000;
/// The chance that a plan of full intensity ends the mission or the payload's power.
const FATAL_CHANCE: f64 = 0.1;
/// The commands whose acknowledgements fail: those that steer, and those with which a session begins.
const COMMANDS: [&str; 7] = ["RMB", "EMB", "RTK", "RTC", "RCN", "RMP", "LOG"];

impl FaultPlan {
    /// Draws a plan from a seed: faults of every kind that begin and end within `duration`. `intensity` goes from 0 (no
    /// faults) to 1 (a fault begins every 15 s on average); a value outside counts as the nearer of the two, and NaN as
    /// 0.
    ///
    /// Only some plans end the mission or cut the payload's power, and only once and in their last fifth, so that most
    /// of a run takes place before. Times are whole milliseconds, so a plan stays the same when it is written and read
    /// back.
    #[must_use]
    pub fn draw(seed: u64, duration: Duration, intensity: f64) -> Self {
        let mut dice = Dice(Stream::new(seed, "fault plan"));
        let intensity = if intensity.is_nan() {
            0.0
        } else {
            intensity.clamp(0.0, 1.0)
        };
        let seconds = duration.as_secs_f64();
        let mean = intensity * seconds / EVERY_S;
        // As many as expected, give or take a third, but at least one if the intensity is above 0.
        let count = (mean * dice.between(0.67, 1.33))
            .round()
            .max(if mean > 0.0 { 1.0 } else { 0.0 });
        let count = (count as u32).min(DRAWN_MAX);
        let mut faults: Vec<Fault> = (0..count).map(|_| dice.fault(seconds)).collect();
        if dice.chance(FATAL_CHANCE * intensity) {
            let at = Timestamp::ZERO + dice.millis(0.8 * seconds, seconds);
            faults.push(if dice.chance(0.5) {
                Fault {
                    at,
                    lasts: Duration::ZERO,
                    kind: FaultKind::MissionAbort,
                }
            } else {
                Fault {
                    at,
                    lasts: crate::file::SHUTDOWN_NOTICE,
                    kind: FaultKind::Shutdown,
                }
            });
        }
        faults.sort_by_key(|fault| fault.at);
        Self { faults }
    }
}

struct Dice(Stream);

impl Dice {
    fn between(&mut self, least: f64, most: f64) -> f64 {
        self.0.uniform_in(least, most)
    }

    fn chance(&mut self, chance: f64) -> bool {
        self.0.uniform() < chance
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.0.uniform() * count as f64) as usize).min(count - 1)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn millis(&mut self, least_s: f64, most_s: f64) -> Duration {
        Duration::from_millis((1000.0 * self.between(least_s, most_s)) as u64)
    }

    /// One of these chances. They span a wide range, so that some faults are rare and others frequent.
    fn rarely(&mut self, of: &[f64]) -> f64 {
        self.one(of)
    }

    fn fault(&mut self, seconds: f64) -> Fault {
        let at = Timestamp::ZERO + self.millis(0.0, seconds);
        // Most faults are short; some last longer than the usual timeouts.
        let longest_s = self.one(&[0.5, 3.0, 10.0, 40.0]);
        let lasts = self.millis(0.0, longest_s);
        let left = Timestamp::ZERO + Duration::from_millis((1000.0 * seconds) as u64);
        let lasts = lasts.min(left.since(at));
        let kind = if self.chance(0.55) {
            FaultKind::Link(self.link())
        } else {
            self.vehicle()
        };
        Fault { at, lasts, kind }
    }

    fn untrue(&mut self) -> Untrue {
        match self.below(6) {
            0 => Untrue::PositionCreeps {
                // From a speed that looks like drift to one that no vehicle reaches.
                speed_mps: self.one(&[0.2, 0.5, 1.0, 1.5, 3.0, 8.0]),
                towards_deg: self.between(0.0, 360.0).round(),
            },
            1 => Untrue::PositionFrozen,
            2 => Untrue::PositionBackwards,
            3 => Untrue::VelocityMissing,
            4 => Untrue::HeadingFlips {
                by_deg: self.between(-180.0, 180.0).round(),
            },
            _ => Untrue::DepthFlips {
                by_m: self.between(-60.0, 60.0).round(),
            },
        }
    }

    fn link(&mut self) -> LinkFault {
        let direction = self.one(&[Directions::Both, Directions::ToVehicle, Directions::FromVehicle]);
        let kind = match self.below(11) {
            0 => LinkFaultKind::Cut,
            1 => LinkFaultKind::Refuse,
            2 => LinkFaultKind::Stall,
            3 => LinkFaultKind::HalfOpen,
            4 => LinkFaultKind::Delay {
                delay: self.millis(0.0, 3.0),
                jitter: self.millis(0.0, 1.0),
                // Half of the delays do not grow.
                growth: self.one(&[0.0, 0.0, 0.0, 0.02, 0.1, 0.5]),
            },
            5 => LinkFaultKind::Split {
                bytes: 1 + self.below(64) as u32,
                gap: Duration::from_micros(100 * self.below(10) as u64),
            },
            6 => LinkFaultKind::Join {
                hold: self.millis(0.001, 2.0),
            },
            7 => LinkFaultKind::Duplicate {
                chance: self.rarely(&[0.01, 0.1, 0.5, 1.0]),
            },
            8 => LinkFaultKind::Corrupt {
                chance: self.rarely(&[0.0001, 0.001, 0.01, 0.1]),
            },
            9 => LinkFaultKind::Deaf,
            _ => LinkFaultKind::Drop {
                chance: self.rarely(&[0.01, 0.1, 0.5, 1.0]),
            },
        };
        let direction = match kind {
            LinkFaultKind::Cut | LinkFaultKind::Refuse => Directions::Both,
            LinkFaultKind::Deaf => Directions::ToVehicle,
            LinkFaultKind::Stall
            | LinkFaultKind::HalfOpen
            | LinkFaultKind::Delay { .. }
            | LinkFaultKind::Split { .. }
            | LinkFaultKind::Join { .. }
            | LinkFaultKind::Duplicate { .. }
            | LinkFaultKind::Corrupt { .. }
            | LinkFaultKind::Drop { .. } => direction,
        };
        LinkFault {
            whom: Whom::All,
            direction,
            kind,
        }
    }

    fn vehicle(&mut self) -> FaultKind {
        match self.below(15) {
            0 => FaultKind::AcksLost(self.acks()),
            1 => FaultKind::AcksLate {
                acks: self.acks(),
                delay: self.millis(0.0, 6.0),
            },
            2 => FaultKind::AcksNegative {
                command: self.command(),
                status: self.one(&[NegativeStatus::Invalid, NegativeStatus::Failed]),
                done: self.chance(0.25),
            },
            3 => FaultKind::ControlTaken,
            4 => FaultKind::NavigationFrozen,
            5 => {
                let mut metres = || self.between(-300.0, 300.0).round();
                FaultKind::NavigationJump(EastNorth::new(metres(), metres()))
            }
            6 => FaultKind::NavigationMissing,
            7 => FaultKind::SensorDropout(self.one(&Sensor::ALL)),
            8..14 => FaultKind::Untrue(self.untrue()),
            _ => FaultKind::ClockStep(1_000_000 * self.between(-90_000.0, 90_000.0) as i64),
        }
    }

    fn acks(&mut self) -> AckFilter {
        AckFilter {
            command: self.command(),
            stage: self.one(&[AckStage::All, AckStage::Pending, AckStage::Outcome]),
        }
    }

    fn command(&mut self) -> Option<CommandName> {
        if self.chance(0.3) {
            return None;
        }
        CommandName::new(self.one(&COMMANDS)).ok()
    }
}

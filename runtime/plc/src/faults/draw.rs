use core::time::Duration;

use backseat_s7k::plc::FailureCause;
use backseat_units::Timestamp;
use backseat_world::Stream;

use super::{Fault, FaultKind, FaultPlan};
use crate::sonar::SensorKind;

/// The mean time from one fault to the next at full intensity, seconds.
const EVERY_S: f64 = 20.0;
/// The most faults that a drawn plan has.
const DRAWN_MAX: u32 = 100_000;
/// The chance that a plan of full intensity ends the controller.
const FATAL_CHANCE: f64 = 0.1;

impl FaultPlan {
    /// Draws a plan from a seed: faults of every kind that begin and end within `duration`. `intensity` goes from 0 (no
    /// faults) to 1 (a fault begins every 20 s on average); a value outside counts as the nearer of the two, and NaN as
    /// 0.
    ///
    /// Only some plans have a missing key, which ends the controller, and only in their last fifth, so that most of a
    /// run takes place before. Times are whole milliseconds.
    #[must_use]
    pub fn draw(seed: u64, duration: Duration, intensity: f64) -> Self {
        let mut dice = Dice(Stream::new(seed, "plc fault plan"));
        let intensity = if intensity.is_nan() {
            0.0
        } else {
            intensity.clamp(0.0, 1.0)
        };
        let seconds = duration.as_secs_f64();
        let mean = intensity * seconds / EVERY_S;
        let least = if mean > 0.0 { 1.0 } else { 0.0 };
        let count = (mean * dice.between(0.67, 1.33)).round().max(least) as u32;
        let mut faults: Vec<Fault> = (0..count.min(DRAWN_MAX)).map(|_| dice.fault(seconds)).collect();
        if dice.between(0.0, 1.0) < FATAL_CHANCE * intensity {
            let at = Timestamp::ZERO + dice.millis(0.8 * seconds, seconds);
            let lasts = Duration::from_secs_f64(seconds.round()).saturating_sub(at.since(Timestamp::ZERO));
            faults.push(Fault {
                at,
                lasts,
                kind: FaultKind::KeyMissing,
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

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[((self.0.uniform() * of.len() as f64) as usize).min(of.len() - 1)]
    }

    fn millis(&mut self, least_s: f64, most_s: f64) -> Duration {
        Duration::from_millis((1000.0 * self.between(least_s, most_s)) as u64)
    }

    fn fault(&mut self, seconds: f64) -> Fault {
        let at = Timestamp::ZERO + self.millis(0.0, seconds);
        // Most faults are short; some last longer than the usual timeouts.
        let longest_s = self.one(&[0.5, 3.0, 10.0, 40.0]);
        let lasts = self.millis(0.0, longest_s);
        let left = Timestamp::ZERO + Duration::from_millis((1000.0 * seconds) as u64);
        Fault {
            at,
            lasts: lasts.min(left.since(at)),
            kind: self.kind(),
        }
    }

    fn kind(&mut self) -> FaultKind {
        let sensor = self.one(&SensorKind::ALL);
        let sonar = self.one(&[SensorKind::SubBottom, SensorKind::SidescanLow, SensorKind::SidescanHigh]);
        match self.one(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14]) {
            0 => FaultKind::SensorDies(sensor),
            1 => FaultKind::SensorUnhealthy {
                sensor,
                cause: self.one(&FailureCause::NAMED),
                code: self.one(&[-1, 17]),
            },
            2 => FaultKind::PingsDropped {
                sensor: sonar,
                chance: self.one(&[0.01, 0.1, 0.5, 1.0]),
            },
            3 => FaultKind::StartFails(sensor),
            4 => FaultKind::ShutdownFails(sensor),
            5 => FaultKind::DataMissing(sonar),
            6 => FaultKind::TimeRefused(sensor),
            7 => FaultKind::CommandsRefused(sensor),
            8 => FaultKind::ResetRefused(sensor),
            9 => FaultKind::DiskFull,
            10 => FaultKind::Stall,
            11 => FaultKind::Flood {
                records_per_s: self.one(&[10.0, 100.0, 1000.0]),
            },
            12 => FaultKind::Garbage {
                bytes_per_s: self.one(&[10.0, 1000.0, 100_000.0]),
            },
            13 => FaultKind::ChecksumsWrong {
                chance: self.one(&[0.01, 0.1, 1.0]),
            },
            _ => FaultKind::LinkClosed,
        }
    }
}

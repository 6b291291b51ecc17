use std::time::Duration;

use backseat_units::Timestamp;

use crate::clock::Clock;
use crate::speed::Speed;

/// How the vehicle's time follows real time: it stands until enough clients are connected, and then goes at its speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VehicleClock {
    real: Clock,
    speed: Speed,
    /// How many clients it waits for.
    wait: usize,
    /// When it began to go.
    began: Option<Duration>,
}

impl VehicleClock {
    pub(crate) fn new(real: Clock, speed: Speed, wait: usize) -> Self {
        Self {
            real,
            speed,
            wait,
            began: (wait == 0).then_some(Duration::ZERO),
        }
    }

    /// How many clients it still waits for, if it stands.
    pub(crate) fn waits_for(&self) -> Option<usize> {
        self.began.is_none().then_some(self.wait)
    }

    /// So many clients are connected now. Returns whether the clock begins to go now. Once it goes, it never stands
    /// again.
    pub(crate) fn connected(&mut self, clients: usize) -> bool {
        let begins = self.began.is_none() && clients >= self.wait;
        if begins {
            self.began = Some(self.real.elapsed());
        }
        begins
    }

    /// The vehicle's time by real time; `at`, where it is, if it stands or goes as fast as possible.
    pub(crate) fn now(&self, at: Timestamp) -> Timestamp {
        match (self.began, self.speed) {
            (Some(began), Speed::Times(times)) => {
                Timestamp::ZERO + self.real.elapsed().saturating_sub(began).mul_f64(times)
            }
            (None, Speed::Times(_)) | (_, Speed::Max) => at,
        }
    }

    /// The real time at which the vehicle's time will be `due`; `None` if it stands or goes as fast as possible.
    pub(crate) fn real(&self, due: Timestamp) -> Option<Timestamp> {
        match (self.began, self.speed) {
            (Some(began), Speed::Times(times)) => {
                Some(Timestamp::ZERO + began + Duration::from_nanos(due.as_nanos()).div_f64(times))
            }
            (None, Speed::Times(_)) | (_, Speed::Max) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands_until_all_are_there_and_then_goes() {
        let mut clock = VehicleClock::new(Clock::start(), Speed::Times(1000.0), 2);
        assert_eq!(
            (clock.waits_for(), clock.now(Timestamp::ZERO)),
            (Some(2), Timestamp::ZERO)
        );
        assert!(!clock.connected(1) && clock.real(Timestamp::ZERO).is_none());
        assert!(clock.connected(2));
        assert!(!clock.connected(1) && !clock.connected(2), "it begins once");
        assert_eq!(clock.waits_for(), None);
        let due = clock.real(Timestamp::from_secs(1000)).unwrap();
        assert!(due < Timestamp::from_secs(60), "a thousand seconds take one: {due:?}");
    }

    #[test]
    fn who_waits_for_nobody_goes_from_the_start() {
        let clock = VehicleClock::new(Clock::start(), Speed::Times(2.0), 0);
        assert_eq!(clock.real(Timestamp::from_secs(10)), Some(Timestamp::from_secs(5)));
        let fastest = VehicleClock::new(Clock::start(), Speed::Max, 0);
        assert_eq!(fastest.now(Timestamp::from_secs(7)), Timestamp::from_secs(7));
    }
}

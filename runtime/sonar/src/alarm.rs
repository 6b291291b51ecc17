//! The alarms of the controller (record 11002, Table 18).

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::Alarm;
use backseat_s7k::record::AlarmMode;
use backseat_units::Timestamp;
use serde::Serialize;

/// How many active alarms are kept.
pub const ALARMS_MAX: usize = 64;

/// An alarm that happens once is not reported again with the same text within this time.
const ONCE_A: Duration = Duration::from_secs(60);

/// How much of an alarm's text is kept, bytes.
pub(crate) const ALARM_BYTES: usize = 200;

/// An alarm and whether it is active.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlarmState {
    /// Its number in Table 18.
    pub id: i32,
    /// Whether it is active, clear, or neither: an alarm without a mode happens once.
    pub mode: AlarmMode,
    /// The sensor that it is about; `None` if it is about none, or if the alarm cannot be read.
    pub sensor: Option<SensorIndex>,
    /// The alarm; `None` if the specification has no alarm of this number, or if its text does not have its form.
    pub alarm: Option<Alarm>,
    /// Its text as the controller sent it, cut to 200 bytes.
    pub text: Box<str>,
}

impl AlarmState {
    pub(crate) fn new(id: i32, mode: AlarmMode, alarm: Option<Alarm>, text: &str) -> Self {
        Self {
            id,
            mode,
            sensor: alarm.as_ref().and_then(sensor_of),
            alarm,
            text: Box::from(text),
        }
    }

    /// What is wrong, in our own words: `sensor 1 unhealthy`. Printable ASCII without comma, asterisk and dollar sign.
    #[must_use]
    pub fn title(&self) -> String {
        let words = match self.id {
            0 => "all clear",
            1 => "disk space critical",
            2 => "not responding",
            3 => "dropped pings",
            4 => "reported a failure",
            5 => "unhealthy",
            6 => "failed to start",
            7 => "failed to shut down",
            8 => "failed to load data",
            9 => "failed to set time",
            10 => "failed to route a record",
            11 => "command failed",
            12 => "status failed",
            13 => "reset failed",
            14 => "invalid command",
            15 => "key missing",
            other => return format!("alarm {other}"),
        };
        match self.sensor {
            Some(sensor) => format!("sensor {sensor} {words}"),
            None => words.to_owned(),
        }
    }

    /// One alarm for each sensor and number.
    fn key(&self) -> (i32, i32) {
        (self.id, self.sensor.map_or(i32::MIN, |sensor| sensor.0))
    }
}

impl std::fmt::Display for AlarmState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mode = match self.mode {
            AlarmMode::Active => "active",
            AlarmMode::Clear => "clear",
            AlarmMode::Unspecified | AlarmMode::Other(_) => "once",
        };
        write!(f, "{} ({mode}): {:?}", self.title(), self.text)
    }
}

fn sensor_of(alarm: &Alarm) -> Option<SensorIndex> {
    match alarm {
        Alarm::SensorNotResponding { sensor, .. }
        | Alarm::PingDropped { sensor, .. }
        | Alarm::SensorFailure { sensor, .. }
        | Alarm::SensorUnhealthy { sensor, .. }
        | Alarm::SensorStartFailed { sensor, .. }
        | Alarm::SensorShutdownFailed { sensor, .. }
        | Alarm::SensorDataFailed { sensor, .. }
        | Alarm::SensorTimeFailed { sensor, .. }
        | Alarm::RouteFailed { sensor, .. }
        | Alarm::SensorCommandFailed { sensor, .. }
        | Alarm::SensorStatusFailed { sensor, .. }
        | Alarm::ResetFailed { sensor, .. } => Some(*sensor),
        Alarm::AllClear {}
        | Alarm::DiskSpaceCritical { .. }
        | Alarm::InvalidCommand { .. }
        | Alarm::KeyMissing { .. } => None,
    }
}

/// The active alarms.
#[derive(Debug, Default)]
pub(crate) struct Alarms {
    active: BTreeMap<(i32, i32), AlarmState>,
    /// When an alarm that happens once was last reported, and its text.
    once: BTreeMap<(i32, i32), (Timestamp, Box<str>)>,
}

/// What an alarm changed.
#[derive(Debug, PartialEq)]
pub(crate) enum Change {
    /// Nothing.
    None,
    /// This alarm.
    One(AlarmState),
    /// No alarm is active any more.
    AllClear,
    /// An alarm is active, and there is no room to keep it.
    NoRoom(AlarmState),
}

impl Alarms {
    pub(crate) fn take(&mut self, now: Timestamp, state: AlarmState) -> Change {
        if state.id == 0 {
            let any = !self.active.is_empty();
            self.active.clear();
            return if any { Change::AllClear } else { Change::None };
        }
        let key = state.key();
        match state.mode {
            AlarmMode::Active => {
                let known = self.active.get(&key);
                if known.is_some_and(|known| known.text == state.text) {
                    return Change::None;
                }
                if known.is_none() && self.active.len() >= ALARMS_MAX {
                    return Change::NoRoom(state);
                }
                self.active.insert(key, state.clone());
                Change::One(state)
            }
            AlarmMode::Clear => {
                if self.active.remove(&key).is_some() {
                    Change::One(state)
                } else {
                    Change::None
                }
            }
            AlarmMode::Unspecified | AlarmMode::Other(_) => self.take_once(now, key, state),
        }
    }

    /// An alarm that happens once. If it happens again and again with the same text, it is reported once a minute.
    fn take_once(&mut self, now: Timestamp, key: (i32, i32), state: AlarmState) -> Change {
        self.once.retain(|_, (at, _)| now.since(*at) < ONCE_A);
        if self.once.get(&key).is_some_and(|(_, text)| *text == state.text) {
            return Change::None;
        }
        if self.once.len() < ALARMS_MAX {
            self.once.insert(key, (now, state.text.clone()));
        }
        Change::One(state)
    }

    /// A new connection: the controller is asked which alarms are active.
    pub(crate) fn begin(&mut self) {
        self.active.clear();
        self.once.clear();
    }

    pub(crate) fn active(&self) -> impl ExactSizeIterator<Item = &AlarmState> {
        self.active.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarm(id: i32, mode: AlarmMode, text: &str) -> AlarmState {
        let alarm = Alarm::read(id, text).and_then(Result::ok);
        AlarmState::new(id, mode, alarm, text)
    }

    #[test]
    fn an_alarm_changes_once_when_it_begins_and_once_when_it_ends() {
        let mut alarms = Alarms::default();
        let unhealthy = |mode| alarm(5, mode, "1, hot");
        assert_eq!(
            alarms.take(Timestamp::ZERO, unhealthy(AlarmMode::Active)),
            Change::One(unhealthy(AlarmMode::Active))
        );
        assert_eq!(alarms.take(Timestamp::ZERO, unhealthy(AlarmMode::Active)), Change::None);
        // Another sensor's alarm is another alarm.
        assert!(matches!(
            alarms.take(Timestamp::ZERO, alarm(5, AlarmMode::Active, "2, hot")),
            Change::One(_)
        ));
        // The text of a clear alarm may differ.
        assert!(matches!(
            alarms.take(Timestamp::ZERO, alarm(5, AlarmMode::Clear, "1, fine")),
            Change::One(_)
        ));
        assert_eq!(
            alarms.take(Timestamp::ZERO, alarm(5, AlarmMode::Clear, "1, fine")),
            Change::None
        );
        assert_eq!(alarms.active().len(), 1);
        assert_eq!(
            alarms.take(Timestamp::ZERO, alarm(0, AlarmMode::Unspecified, "")),
            Change::AllClear
        );
        assert_eq!(alarms.active().len(), 0);
    }

    #[test]
    fn the_table_of_alarms_has_a_bound() {
        let mut alarms = Alarms::default();
        for sensor in 0..200 {
            alarms.take(Timestamp::ZERO, alarm(5, AlarmMode::Active, &format!("{sensor}, hot")));
        }
        assert_eq!(alarms.active().len(), ALARMS_MAX);
        assert!(matches!(
            alarms.take(Timestamp::ZERO, alarm(5, AlarmMode::Active, "300, hot")),
            Change::NoRoom(_)
        ));
    }

    #[test]
    fn an_alarm_that_happens_again_and_again_is_reported_once_a_minute() {
        let mut alarms = Alarms::default();
        let lost = |text| alarm(10, AlarmMode::Unspecified, text);
        let mut reported = 0;
        for second in 0..180 {
            let change = alarms.take(Timestamp::from_secs(second), lost("-1, 1, no sensor"));
            reported += u32::from(change != Change::None);
        }
        assert_eq!(reported, 3);
        let other = alarms.take(Timestamp::from_secs(180), lost("-1, 1, busy"));
        assert_eq!(other, Change::One(lost("-1, 1, busy")));
    }
}

//! What happens by itself: each timer with its time, and what is done when it is due.

use core::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Alarm, Status};
use backseat_units::Timestamp;

use super::{Answer, Plc};
use crate::event::{DropReason, PlcEventKind};
use crate::faults::FaultKind;
use crate::sonar::{SensorKind, Sonar};
use crate::suite::Slot;
use crate::suite::imagery::Heading;
use crate::suite::sensor::Step;

/// The time between two bursts of a flood or of garbage.
const NOISE_EVERY: Duration = Duration::from_millis(100);

/// What is due.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Timer {
    /// A fault begins or ends.
    Fault,
    /// A sensor has something to do.
    Sensor(Slot, Step),
    /// A sensor answers a client.
    Answer(usize),
    /// The automatic health check.
    Health,
    /// A time message.
    TimeMessage,
    /// Floods and garbage.
    Noise,
    /// What of a client could not be used, or was lost, is reported.
    Report,
    /// The controller ends without its key.
    Key,
    /// The connections close.
    Shutdown,
}

impl Plc {
    /// When to call [`Plc::handle_timeout`]; `None` if nothing will happen by itself.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        self.next().map(|(at, _)| at)
    }

    /// Does everything that is due, in the order of its times.
    pub fn handle_timeout(&mut self, now: Timestamp, sonar: &mut dyn Sonar) {
        while let Some((at, timer)) = self.next() {
            if at > now {
                break;
            }
            self.act(at, now, timer, sonar);
        }
    }

    /// The earliest timer; of several at one time the first in the order of [`Timer`].
    fn next(&self) -> Option<(Timestamp, Timer)> {
        if self.is_shut_down {
            return None;
        }
        let fault = Some((self.faults.next(), Timer::Fault)).filter(|(at, _)| *at < Timestamp::MAX);
        if self.stalled {
            return fault;
        }
        let sensor = self
            .suite
            .next(&self.server)
            .map(|(at, slot, step)| (at, Timer::Sensor(slot, step)));
        let answer = self.pending.iter().enumerate().min_by_key(|(_, pending)| pending.due);
        let shutdown = self
            .shutdown
            .filter(|(_, with_sensors)| !with_sensors || self.suite.is_down());
        [
            fault,
            sensor,
            answer.map(|(place, pending)| (pending.due, Timer::Answer(place))),
            self.health.map(|(due, _)| (due, Timer::Health)),
            self.time_messages.map(|due| (due, Timer::TimeMessage)),
            self.noise_due.map(|due| (due, Timer::Noise)),
            self.server.report_due().map(|due| (due, Timer::Report)),
            self.key_ends.map(|due| (due, Timer::Key)),
            shutdown.map(|(due, _)| (due, Timer::Shutdown)),
        ]
        .into_iter()
        .flatten()
        .min_by_key(|(at, _)| *at)
    }

    /// `at` is when the timer was due, `now` the current time.
    fn act(&mut self, at: Timestamp, now: Timestamp, timer: Timer, sonar: &mut dyn Sonar) {
        match timer {
            Timer::Fault => self.fault_edge(now),
            Timer::Sensor(slot, step) => self.sensor_step(at, now, slot, step, sonar),
            Timer::Answer(place) => {
                if let Some(pending) = self.pending.remove(place) {
                    match pending.answer {
                        Answer::Status(status) => self.server.status(now, pending.client, status),
                        Answer::Alarm(alarm) => self.server.warn_about(now, pending.client, alarm),
                    }
                }
            }
            Timer::Health => {
                if let Some((due, period)) = self.health {
                    self.health = Some((next_after(due, period, now), period));
                }
                self.suite.check_health(now, &self.faults, &mut self.server);
            }
            Timer::TimeMessage => {
                self.time_messages = Some(next_after(at, self.time_message_period, now));
                self.server.time_message(now);
            }
            Timer::Noise => self.noise(now),
            Timer::Report => self.server.report_all(now),
            Timer::Key => {
                self.key_ends = None;
                self.begin_shutdown(now, false);
            }
            Timer::Shutdown => {
                self.shutdown = None;
                self.server.cut_off_all(now, DropReason::ShutDown);
                self.server.note(now, PlcEventKind::ShutDown);
                self.is_shut_down = true;
            }
        }
    }

    fn sensor_step(&mut self, at: Timestamp, now: Timestamp, slot: Slot, step: Step, sonar: &mut dyn Sonar) {
        if step == Step::PhaseEnds {
            self.suite.end_phase(now, slot, &self.faults, &mut self.server);
            return;
        }
        let Some((index, kind)) = self.suite.slot(slot).map(|sensor| (sensor.index, sensor.kind)) else {
            return;
        };
        match step {
            Step::PhaseEnds => {}
            Step::Ping => {
                let (truth, sound_speed_mps) = (self.truth, self.navigation.sound_speed_mps());
                let config = self.suite.config(kind).clone();
                if let Some(sensor) = self.suite.slot(slot) {
                    sensor.transmit(at, now, truth, &config, sound_speed_mps);
                }
            }
            Step::Heard => self.heard(now, slot, index, kind, sonar),
            Step::ReportDrops => self.report_drops(now, slot),
            Step::ReportSilence => {
                let description = Box::from("no answer");
                let alarm = Alarm::SensorNotResponding {
                    sensor: index,
                    description,
                };
                self.server.raise(now, index, alarm);
            }
            Step::ReportNoData => {
                let description = Box::from("no data for the log");
                let alarm = Alarm::SensorDataFailed {
                    sensor: index,
                    description,
                };
                self.server.raise(now, index, alarm);
            }
        }
    }

    /// A sonar has heard the whole of a ping: its record is composed, logged and sent, unless a fault takes it away.
    fn heard(&mut self, now: Timestamp, slot: Slot, index: SensorIndex, kind: SensorKind, sonar: &mut dyn Sonar) {
        let chance = self.faults.drop_chance(kind);
        let dropped = chance > 0.0 && self.dice.uniform() < chance;
        let missing = self.faults.acts(&FaultKind::DataMissing(kind));
        let Some(sensor) = self.suite.slot(slot) else { return };
        let Some(ping) = sensor.heard() else { return };
        let sonar_clock = sensor.clock;
        if missing {
            sensor.starved_since.get_or_insert(now);
            return;
        }
        if dropped {
            sensor.drop_pings(now, ping.number, ping.number);
            return;
        }
        self.report_drops(now, slot);
        let (port, starboard, profile) = &mut self.samples;
        let heading = Heading {
            kind,
            ping: &ping,
            navigation: &self.navigation,
            sonar_utc: sonar_clock.utc(ping.time),
            layout: self.layout,
            weighting_factor: self.suite.config(kind).weighting_factor,
            version: self.version,
        };
        let time = self.server.time(ping.time);
        let record = match kind {
            SensorKind::SidescanLow | SensorKind::SidescanHigh => {
                port.clear();
                starboard.clear();
                sonar.side_scan(kind, &ping, port, starboard);
                port.resize(ping.samples, 0);
                starboard.resize(ping.samples, 0);
                self.server.record(time, kind.record_type(), kind.device(), |frame| {
                    heading.side_scan(port, starboard, frame);
                })
            }
            SensorKind::SubBottom => {
                profile.clear();
                sonar.sub_bottom(&ping, profile);
                profile.resize(ping.samples, [0, 0]);
                self.server.record(time, kind.record_type(), kind.device(), |frame| {
                    heading.sub_bottom(profile, frame);
                })
            }
            // The vehicle's interface does not ping.
            SensorKind::Bluefin => return,
        };
        self.deliver(now, index, kind, record);
    }

    /// Alarm 3 for the pings that a sensor has dropped, if there are any.
    fn report_drops(&mut self, now: Timestamp, slot: Slot) {
        let Some(sensor) = self.suite.slot(slot) else { return };
        let index = sensor.index;
        if let Some((first, last)) = sensor.take_drops() {
            let alarm = Alarm::PingDropped {
                sensor: index,
                first: first.cast_signed(),
                last: if first == last { -1 } else { last.cast_signed() },
            };
            self.server.warn(now, alarm);
        }
    }

    /// A burst of records that nobody asked for, and of bytes that are no records.
    fn noise(&mut self, now: Timestamp) {
        let (records_per_s, bytes_per_s) = (self.faults.flood_per_s(), self.faults.garbage_per_s());
        self.noise_due = (records_per_s + bytes_per_s > 0.0).then_some(now + NOISE_EVERY);
        let seconds = NOISE_EVERY.as_secs_f64();
        let whole = |carry: &mut f64, rate: f64| {
            *carry += rate * seconds;
            let whole = carry.floor();
            *carry -= whole;
            whole as usize
        };
        let records = whole(&mut self.noise_carry.0, records_per_s);
        let bytes = whole(&mut self.noise_carry.1, bytes_per_s);
        let version = Status::Version { version: self.version };
        self.server.flood(now, &version, records);
        if bytes > 0 {
            self.server.garbage(now, bytes);
        }
    }
}

/// The next time of a period that is after now: what was missed is not made up for.
fn next_after(due: Timestamp, period: Duration, now: Timestamp) -> Timestamp {
    let next = due + period;
    if next > now { next } else { now + period }
}

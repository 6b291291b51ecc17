use core::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_units::Timestamp;

use super::settings::Settings;
use crate::clock::Clock;
use crate::config::SonarConfig;
use crate::sonar::{Ping, Pose, SensorKind};

/// The most samples of a channel: EdgeTech's SEG-Y header counts them in 16 bits.
pub(crate) const SAMPLES_MAX: usize = 65_535;

/// How late a ping may be before it counts as dropped. A controller that stalled, or a driver that slept, does not
/// make up for what it missed.
const LATE_MAX: Duration = Duration::from_secs(1);

/// How long dropped pings are collected for one alarm.
const DROPS_REPORTED_AFTER: Duration = Duration::from_secs(1);

/// What a sensor is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// It waits until the sensor of its kind that was in the list before is down.
    Waiting,
    /// It starts, until then.
    Starting(Timestamp),
    /// It works.
    Running,
    /// It did not start.
    Failed,
    /// It shuts down, until then.
    ShuttingDown(Timestamp),
}

/// A sensor of the run list.
#[derive(Clone, Debug)]
pub(crate) struct Sensor {
    pub(crate) index: SensorIndex,
    pub(crate) kind: SensorKind,
    pub(crate) name: String,
    pub(crate) port: i32,
    pub(crate) phase: Phase,
    pub(crate) settings: Settings,
    /// Whether it begins to ping as soon as it has started.
    pub(crate) ping_at_start: bool,
    /// The sensor's own clock, which the command "time sync" sets through the controller.
    pub(crate) clock: Clock,
    ping: u32,
    next_ping: Timestamp,
    /// The ping that it listens to, and until when.
    listening: Option<(Ping, Timestamp)>,
    /// The first and the last ping that was dropped, and when alarm 3 is due.
    drops: Option<(u32, u32, Timestamp)>,
    /// Since when it is silent, by a fault.
    pub(crate) silent_since: Option<Timestamp>,
    /// Since when it pings and gives no data, by a fault.
    pub(crate) starved_since: Option<Timestamp>,
}

/// What a sensor has to do at its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// Its start or its shutdown ends.
    PhaseEnds,
    /// It pings.
    Ping,
    /// It has heard the whole of a ping.
    Heard,
    /// Alarm 3 is due.
    ReportDrops,
    /// It was silent for so long that alarm 2 is due.
    ReportSilence,
    /// It gave no data for so long that alarm 8 is due.
    ReportNoData,
}

impl Sensor {
    pub(crate) fn new(
        index: SensorIndex,
        kind: SensorKind,
        name: String,
        port: i32,
        config: &SonarConfig,
        clock: Clock,
    ) -> Self {
        Self {
            index,
            kind,
            name,
            port,
            phase: Phase::Waiting,
            settings: Settings::of(config),
            ping_at_start: false,
            clock,
            ping: 0,
            next_ping: Timestamp::ZERO,
            listening: None,
            drops: None,
            silent_since: None,
            starved_since: None,
        }
    }

    pub(crate) fn is_running(&self) -> bool {
        self.phase == Phase::Running
    }

    /// Whether it pings now.
    pub(crate) fn pings(&self) -> bool {
        self.kind.is_sonar() && self.is_running() && self.settings.pinging && self.silent_since.is_none()
    }

    /// Begins to work; a sonar pings at once if it shall.
    pub(crate) fn run(&mut self, now: Timestamp) {
        self.phase = Phase::Running;
        self.settings.pinging |= core::mem::take(&mut self.ping_at_start) && self.kind.is_sonar();
        self.next_ping = now;
    }

    /// The settings changed: a sonar that was quiet pings at once.
    pub(crate) fn settings_changed(&mut self, now: Timestamp, pinged: bool) {
        if !pinged {
            self.next_ping = self.next_ping.max(now);
        }
        if !self.settings.pinging {
            self.starved_since = None;
        }
    }

    /// Stops at once: it is dead, or its shutdown begins.
    pub(crate) fn stop(&mut self) {
        self.listening = None;
        self.starved_since = None;
    }

    /// What is next, and when. `silent_after` and `no_data_after` are the times of alarms 2 and 8; `None` for an alarm
    /// that is active already.
    pub(crate) fn next(
        &self,
        silent_after: Option<Duration>,
        no_data_after: Option<Duration>,
    ) -> Option<(Timestamp, Step)> {
        let drops = self.drops.map(|(_, _, due)| (due, Step::ReportDrops));
        let work = match self.phase {
            Phase::Waiting | Phase::Failed => None,
            Phase::Starting(until) | Phase::ShuttingDown(until) => Some((until, Step::PhaseEnds)),
            Phase::Running => {
                let silence = self.silent_since.zip(silent_after);
                let no_data = self.starved_since.zip(no_data_after);
                let ping = self.pings().then_some((self.next_ping, Step::Ping));
                let heard = self.listening.as_ref().map(|(_, until)| (*until, Step::Heard));
                [
                    heard.or(ping),
                    silence.map(|(since, after)| (since + after, Step::ReportSilence)),
                    no_data.map(|(since, after)| (since + after, Step::ReportNoData)),
                ]
                .into_iter()
                .flatten()
                .min_by_key(|(at, _)| *at)
            }
        };
        [work, drops].into_iter().flatten().min_by_key(|(at, _)| *at)
    }

    /// Pings, if a pose is known. `at` is when the ping was due; a ping that is very late counts as dropped, with those
    /// that should have followed it.
    pub(crate) fn transmit(
        &mut self,
        at: Timestamp,
        now: Timestamp,
        pose: Option<(Timestamp, Pose)>,
        config: &SonarConfig,
        sound_speed_mps: f64,
    ) {
        let listening_s = 2.0 * self.settings.range_m / sound_speed_mps;
        let listening = Duration::from_secs_f64(listening_s);
        let period = Duration::from_secs_f64(self.settings.period_ms * 1e-3).max(listening);
        let late = now.since(at);
        let at = if late > LATE_MAX {
            let missed = late.as_nanos() / period.as_nanos().max(1);
            let missed = u32::try_from(missed).unwrap_or(u32::MAX).max(1);
            let first = self.ping.wrapping_add(1);
            self.ping = self.ping.wrapping_add(missed);
            self.drop_pings(now, first, self.ping);
            now
        } else {
            at
        };
        self.next_ping = at + period;
        let Some((truth_at, pose)) = pose else { return };
        self.ping = self.ping.wrapping_add(1);
        let interval_us = config.sample_interval_us.max(1);
        let samples = (listening_s * 1e6 / f64::from(interval_us)) as usize + 1;
        let ping = Ping {
            number: self.ping,
            time: at,
            pose: pose.after(at.since(truth_at).as_secs_f64()),
            range_m: self.settings.range_m,
            pulse: self.settings.pulse(config),
            power_percent: self.settings.power_percent,
            gain_steps: self.settings.gain_steps,
            samples: samples.min(SAMPLES_MAX),
            sample_interval_us: interval_us,
            sound_speed_mps,
        };
        self.listening = Some((ping, at + listening));
    }

    /// The ping that it has heard.
    pub(crate) fn heard(&mut self) -> Option<Ping> {
        self.listening.take().map(|(ping, _)| ping)
    }

    /// Notes dropped pings for alarm 3; ranges that touch become one.
    pub(crate) fn drop_pings(&mut self, now: Timestamp, first: u32, last: u32) {
        self.drops = Some(match self.drops {
            Some((begin, end, due)) if end.wrapping_add(1) == first => (begin, last, due),
            // Only one range is kept: the caller reports it before another one begins.
            _ => (first, last, now + DROPS_REPORTED_AFTER),
        });
    }

    /// The dropped pings for alarm 3.
    pub(crate) fn take_drops(&mut self) -> Option<(u32, u32)> {
        self.drops.take().map(|(first, last, _)| (first, last))
    }
}

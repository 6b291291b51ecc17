//! The run list: which sensors there are, what each of them does, and what is asked of them.

pub(crate) mod imagery;
pub(crate) mod sensor;
mod settings;
pub(crate) mod stored;

use core::time::Duration;

use backseat_s7k::plc::{Alarm, FailureCause, HealthEntry, ModuleEntry, PlcVersion, PulseName, RunListEntry, Status};
use backseat_s7k::{DeviceId, SensorIndex};
use backseat_units::Timestamp;
use backseat_world::{Span, Stream};

use crate::config::{PlcConfig, SensorEntry, SonarConfig};
use crate::event::PlcEventKind;
use crate::faults::{FaultKind, Timeline};
use crate::server::Server;
use crate::sonar::SensorKind;
use sensor::{Phase, Sensor, Step};

/// The modules that serve sensors: number, file, version.
const MODULES: [(i32, &str, PlcVersion); 3] = [
    (1, "EdgeTechSBP.dll", version(1, 1, 0)),
    (2, "EdgeTechSS.dll", version(1, 2, 3)),
    (3, "Bluefin.dll", version(1, 0, 1)),
];

const fn version(major: u32, minor: u8, maintenance: u8) -> PlcVersion {
    PlcVersion {
        major,
        minor,
        maintenance,
    }
}

/// The run list.
#[derive(Debug)]
pub(crate) struct Suite {
    sensors: Vec<Sensor>,
    /// Sensors that are out of the list and not yet down, at most one of each kind.
    leaving: Vec<Sensor>,
    next_index: i32,
    /// The sensor that gets records that are not for the controller; `None`: the vehicle's, if it is in the list.
    route: Option<SensorIndex>,
    sub_bottom: SonarConfig,
    sidescan_low: SonarConfig,
    sidescan_high: SonarConfig,
    /// The vehicle's interface, which has no settings.
    bluefin: SonarConfig,
    silent_after: Duration,
    no_data_after: Duration,
    dice: Stream,
}

/// Where a sensor is in the run list or among those that leave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Slot {
    Listed(usize),
    Leaving(usize),
}

impl Suite {
    pub(crate) fn new(config: &PlcConfig, seed: u64) -> Self {
        Self {
            sensors: Vec::new(),
            leaving: Vec::new(),
            next_index: 0,
            route: None,
            sub_bottom: config.sub_bottom.clone(),
            sidescan_low: config.sidescan_low.clone(),
            sidescan_high: config.sidescan_high.clone(),
            bluefin: SonarConfig {
                start_s: Span::fixed(0.5),
                shutdown_s: Span::fixed(0.1),
                pulses: Vec::new(),
                ..config.sub_bottom.clone()
            },
            silent_after: Duration::from_secs_f64(config.silent_after_s),
            no_data_after: Duration::from_secs_f64(config.no_data_after_s),
            dice: Stream::new(seed, "plc sensors"),
        }
    }

    pub(crate) const fn config(&self, kind: SensorKind) -> &SonarConfig {
        match kind {
            SensorKind::SubBottom => &self.sub_bottom,
            SensorKind::SidescanLow => &self.sidescan_low,
            SensorKind::SidescanHigh => &self.sidescan_high,
            SensorKind::Bluefin => &self.bluefin,
        }
    }

    pub(crate) fn sensor(&self, index: SensorIndex) -> Option<&Sensor> {
        self.sensors.iter().find(|sensor| sensor.index == index)
    }

    pub(crate) fn sensor_mut(&mut self, index: SensorIndex) -> Option<&mut Sensor> {
        self.sensors.iter_mut().find(|sensor| sensor.index == index)
    }

    pub(crate) fn sensors(&self) -> impl Iterator<Item = &Sensor> {
        self.sensors.iter()
    }

    pub(crate) fn sensors_mut(&mut self) -> impl Iterator<Item = &mut Sensor> {
        self.sensors.iter_mut()
    }

    pub(crate) fn slot(&mut self, slot: Slot) -> Option<&mut Sensor> {
        match slot {
            Slot::Listed(place) => self.sensors.get_mut(place),
            Slot::Leaving(place) => self.leaving.get_mut(place),
        }
    }

    pub(crate) fn devices(&self) -> Vec<DeviceId> {
        self.sensors.iter().map(|sensor| sensor.kind.device()).collect()
    }

    /// The sensor that gets records that are not for the controller.
    pub(crate) fn route(&self) -> Option<SensorIndex> {
        let vehicle = || self.sensors.iter().find(|sensor| sensor.kind == SensorKind::Bluefin);
        self.route.or_else(|| vehicle().map(|sensor| sensor.index))
    }

    pub(crate) fn set_route(&mut self, route: SensorIndex) {
        self.route = Some(route);
    }

    pub(crate) fn is_down(&self) -> bool {
        self.sensors.is_empty() && self.leaving.is_empty()
    }

    /// What is next of all sensors, and when.
    pub(crate) fn next(&self, server: &Server) -> Option<(Timestamp, Slot, Step)> {
        let next = |sensor: &Sensor, slot: Slot| {
            let silent = (!server.is_active(2, sensor.index)).then_some(self.silent_after);
            let no_data = (!server.is_active(8, sensor.index)).then_some(self.no_data_after);
            sensor.next(silent, no_data).map(|(at, step)| (at, slot, step))
        };
        let listed = self
            .sensors
            .iter()
            .enumerate()
            .filter_map(|(place, sensor)| next(sensor, Slot::Listed(place)));
        let leaving = self
            .leaving
            .iter()
            .enumerate()
            .filter_map(|(place, sensor)| next(sensor, Slot::Leaving(place)));
        listed.chain(leaving).min_by_key(|(at, slot, _)| (*at, *slot))
    }

    /// Adds a sensor and starts it. The error says in words why not.
    pub(crate) fn add(
        &mut self,
        now: Timestamp,
        kind: SensorKind,
        name: &str,
        port: i32,
        ping: bool,
        server: &mut Server,
    ) -> Result<(), String> {
        if let Some(sensor) = self.sensors.iter().find(|sensor| sensor.kind == kind) {
            return Err(format!("sensor {} has this subsystem already", sensor.index));
        }
        let index = SensorIndex(self.next_index);
        self.next_index = self.next_index.saturating_add(1);
        let clock = server.clock;
        let mut sensor = Sensor::new(index, kind, name.to_owned(), port, self.config(kind), clock);
        sensor.ping_at_start = ping;
        self.sensors.push(sensor);
        self.begin_start(now, index, server);
        Ok(())
    }

    /// Starts a sensor, or lets it wait for the one of its kind that is still shutting down.
    fn begin_start(&mut self, now: Timestamp, index: SensorIndex, server: &mut Server) {
        let Some(kind) = self.sensor(index).map(|sensor| sensor.kind) else {
            return;
        };
        if self.leaving.iter().any(|sensor| sensor.kind == kind) {
            return;
        }
        let takes_s = self.config(kind).start_s;
        let until = now + Duration::from_secs_f64(takes_s.draw(&mut self.dice));
        if let Some(sensor) = self.sensor_mut(index) {
            sensor.stop();
            sensor.phase = Phase::Starting(until);
            server.note(now, PlcEventKind::SensorStarting(index, kind));
        }
    }

    /// Takes a sensor out of the list and shuts it down. False if it is not in the list.
    pub(crate) fn remove(&mut self, now: Timestamp, index: SensorIndex, server: &mut Server) -> bool {
        let Some(place) = self.sensors.iter().position(|sensor| sensor.index == index) else {
            return false;
        };
        let mut sensor = self.sensors.remove(place);
        server.clear_sensor(now, index);
        server.clients.forget_sensor(index);
        if self.route == Some(index) {
            self.route = None;
        }
        if matches!(sensor.phase, Phase::Waiting) {
            return true;
        }
        let takes_s = self.config(sensor.kind).shutdown_s;
        sensor.stop();
        sensor.phase = Phase::ShuttingDown(now + Duration::from_secs_f64(takes_s.draw(&mut self.dice)));
        self.leaving.push(sensor);
        true
    }

    /// Replaces the run list: the sensors in it shut down, those of the new one start.
    pub(crate) fn load(
        &mut self,
        now: Timestamp,
        entries: &[SensorEntry],
        restart: bool,
        ping: bool,
        server: &mut Server,
    ) {
        self.remove_all(now, server);
        if restart {
            self.next_index = 0;
        }
        for entry in entries {
            // Entries were checked: no kind is there twice.
            let added = self.add(now, entry.kind, &entry.name, entry.port, ping, server);
            debug_assert!(added.is_ok(), "{added:?}");
        }
    }

    pub(crate) fn remove_all(&mut self, now: Timestamp, server: &mut Server) {
        while let Some(index) = self.sensors.first().map(|sensor| sensor.index) {
            self.remove(now, index, server);
        }
    }

    /// The start or the shutdown of a sensor ends.
    pub(crate) fn end_phase(&mut self, now: Timestamp, slot: Slot, faults: &Timeline, server: &mut Server) {
        match slot {
            Slot::Listed(place) => {
                let Some(sensor) = self.sensors.get_mut(place) else {
                    return;
                };
                let (index, kind) = (sensor.index, sensor.kind);
                let fails = faults.acts(&FaultKind::StartFails(kind)) || faults.acts(&FaultKind::SensorDies(kind));
                if fails {
                    sensor.phase = Phase::Failed;
                    let description = Box::from("no answer at start-up");
                    server.note(now, PlcEventKind::SensorStartFailed(index, kind));
                    server.raise(
                        now,
                        index,
                        Alarm::SensorStartFailed {
                            sensor: index,
                            description,
                        },
                    );
                } else {
                    sensor.run(now);
                    server.note(now, PlcEventKind::SensorStarted(index, kind));
                    server.clear(now, 6, index);
                    self.failure_reported(now, faults, server);
                }
            }
            Slot::Leaving(place) => {
                if place >= self.leaving.len() {
                    return;
                }
                let sensor = self.leaving.remove(place);
                let (index, kind) = (sensor.index, sensor.kind);
                let fails = faults.acts(&FaultKind::ShutdownFails(kind)) || faults.acts(&FaultKind::SensorDies(kind));
                if fails {
                    let description = Box::from("no answer at shutdown");
                    server.warn(
                        now,
                        Alarm::SensorShutdownFailed {
                            sensor: index,
                            description,
                        },
                    );
                }
                server.note(now, PlcEventKind::SensorDown(index, kind, !fails));
                let waits = |sensor: &&Sensor| sensor.kind == kind && sensor.phase == Phase::Waiting;
                if let Some(next) = self.sensors.iter().find(waits).map(|sensor| sensor.index) {
                    self.begin_start(now, next, server);
                }
            }
        }
    }

    /// Resets a sensor: default state, and a start if it did not start before.
    pub(crate) fn reset(&mut self, now: Timestamp, index: SensorIndex, server: &mut Server) {
        let Some(kind) = self.sensor(index).map(|sensor| sensor.kind) else {
            return;
        };
        let settings = settings::Settings::of(self.config(kind));
        if let Some(sensor) = self.sensor_mut(index) {
            sensor.settings = settings;
            sensor.stop();
        }
        server.clear(now, 8, index);
        self.begin_start(now, index, server);
    }

    /// Faults of sensors began or ended.
    pub(crate) fn faults_changed(&mut self, now: Timestamp, faults: &Timeline, server: &mut Server) {
        for sensor in &mut self.sensors {
            let dead = faults.acts(&FaultKind::SensorDies(sensor.kind));
            match (dead, sensor.silent_since) {
                (true, None) => {
                    sensor.silent_since = Some(now);
                    sensor.stop();
                }
                (false, Some(_)) => {
                    sensor.silent_since = None;
                    sensor.settings_changed(now, false);
                    server.clear(now, 2, sensor.index);
                }
                (true, Some(_)) | (false, None) => {}
            }
            if !faults.acts(&FaultKind::DataMissing(sensor.kind)) {
                sensor.starved_since = None;
                server.clear(now, 8, sensor.index);
            }
        }
        self.failure_reported(now, faults, server);
    }

    /// Alarm 4 of sensors that report a failure of their own.
    fn failure_reported(&mut self, now: Timestamp, faults: &Timeline, server: &mut Server) {
        for sensor in &self.sensors {
            let failure = faults.acting().find_map(|kind| {
                if let FaultKind::SensorUnhealthy {
                    sensor: of,
                    cause,
                    code,
                } = *kind
                    && of == sensor.kind
                {
                    Some((cause, code))
                } else {
                    None
                }
            });
            match failure {
                Some((cause, code)) if sensor.is_running() => {
                    let description = Box::from(cause_text(cause));
                    let alarm = Alarm::SensorFailure {
                        sensor: sensor.index,
                        cause,
                        code,
                        description,
                    };
                    server.raise(now, sensor.index, alarm);
                }
                Some(_) => {}
                None => server.clear(now, 4, sensor.index),
            }
        }
    }

    fn is_healthy(sensor: &Sensor, faults: &Timeline) -> bool {
        sensor.phase != Phase::Failed
            && !faults.is_unhealthy(sensor.kind)
            && !faults.acts(&FaultKind::SensorDies(sensor.kind))
    }

    /// The health of one sensor, or of all.
    pub(crate) fn health(&self, only: Option<SensorIndex>, faults: &Timeline) -> Status {
        let asked = self
            .sensors
            .iter()
            .filter(|sensor| only.is_none_or(|index| sensor.index == index));
        let sensors = asked.map(|sensor| HealthEntry {
            sensor: sensor.index,
            // A sensor that has not started yet does not work, and has not failed a check either: no alarm 5.
            healthy: sensor.is_running() && Self::is_healthy(sensor, faults),
        });
        Status::Health {
            sensors: sensors.collect(),
        }
    }

    /// Checks the health of all sensors: alarm 5 begins and ends with what is found.
    pub(crate) fn check_health(&self, now: Timestamp, faults: &Timeline, server: &mut Server) {
        for sensor in &self.sensors {
            let index = sensor.index;
            if Self::is_healthy(sensor, faults) {
                server.clear(now, 5, index);
            } else {
                let description = Box::from("health check failed");
                server.raise(
                    now,
                    index,
                    Alarm::SensorUnhealthy {
                        sensor: index,
                        description,
                    },
                );
            }
        }
    }

    /// Sets the clocks of the sensors to the controller's.
    pub(crate) fn set_time(&mut self, now: Timestamp, faults: &Timeline, server: &mut Server) {
        for sensor in &mut self.sensors {
            let kind = sensor.kind;
            let refuses = faults.acts(&FaultKind::TimeRefused(kind)) || faults.acts(&FaultKind::SensorDies(kind));
            if refuses || sensor.phase == Phase::Failed {
                let (sensor, description) = (sensor.index, Box::from("time not set"));
                server.warn(now, Alarm::SensorTimeFailed { sensor, description });
            } else {
                sensor.clock = server.clock;
            }
        }
    }

    pub(crate) fn modules() -> Status {
        let module = |(module, file, version): (i32, &str, PlcVersion)| ModuleEntry {
            module,
            file: Box::from(file),
            version,
        };
        Status::Modules {
            modules: MODULES.into_iter().map(module).collect(),
        }
    }

    pub(crate) fn run_list(&self) -> Status {
        let entry = |sensor: &Sensor| RunListEntry {
            sensor: sensor.index,
            id: sensor.kind.device().0.cast_signed(),
            kind: sensor.kind.module(),
            port: sensor.port,
            media: 0,
            subsystem: i32::from(sensor.kind.subsystem()),
            name: Box::from(sensor.name.as_str()),
        };
        Status::RunList {
            sensors: self.sensors.iter().map(entry).collect(),
        }
    }

    pub(crate) fn pulses(&self, kind: SensorKind) -> Status {
        let pulses = self.config(kind).pulses.iter();
        Status::SensorReply {
            pulses: pulses.map(|pulse| PulseName(Box::from(pulse.name.as_str()))).collect(),
        }
    }
}

/// The sensor that the command "add" names by module and subsystem.
pub(crate) fn kind_of(module: i32, subsystem: i32) -> Option<SensorKind> {
    let named = |kind: &SensorKind| kind.module() == module && i32::from(kind.subsystem()) == subsystem;
    SensorKind::ALL.into_iter().find(named)
}

const fn cause_text(cause: FailureCause) -> &'static str {
    match cause {
        FailureCause::Unknown | FailureCause::Other(_) => "unknown failure",
        FailureCause::InternalCode => "internal error",
        FailureCause::ServiceRequired => "service required",
        FailureCause::Temperature => "temperature out of range",
        FailureCause::Humidity => "humidity out of range",
    }
}

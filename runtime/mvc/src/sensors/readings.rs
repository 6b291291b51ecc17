use backseat_spi::{FromVehicle, Telemetry};
use backseat_units::Timestamp;

use super::SensorFailure;
use super::schedule::Schedule;
use crate::event::MvcEventKind;
use crate::file::SensorConfig;
use crate::mvc::Mvc;
use crate::server::Topic;

/// When each sensor is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedules {
    pub(super) sound_ratio: Schedule,
    ctd: Schedule,
    sound: Schedule,
    compass: Schedule,
    depth: Schedule,
    tailcone: Schedule,
    dvl: Schedule,
    imu: Schedule,
    telemetry: Schedule,
}

impl Schedules {
    pub(super) fn new(config: &SensorConfig) -> Self {
        Self {
            sound_ratio: Schedule::every(config.sound.period_s),
            ctd: Schedule::every(config.ctd_period_s),
            sound: Schedule::every(config.sound.period_s),
            compass: Schedule::every(config.compass.period_s),
            depth: Schedule::every(config.depth.period_s),
            tailcone: Schedule::every(config.tailcone.period_s),
            dvl: Schedule::every(config.dvl.period_s),
            imu: Schedule::every(config.imu.period_s),
            telemetry: Schedule::every(config.telemetry.period_s),
        }
    }
}

impl Mvc {
    /// Breaks navigation or a sensor, or mends it.
    pub fn fail_sensor(&mut self, failure: SensorFailure) {
        match failure {
            SensorFailure::Frozen(frozen) => self.sensors.freeze(frozen),
            SensorFailure::Silent(silent) => self.sensors.silence_navigation(silent),
            SensorFailure::Jump(way) => self.sensors.jump(way),
            SensorFailure::Dropout(sensor, dead) => self.sensors.sensor_dropout(sensor, dead),
        }
    }

    /// One step of the vehicle: its navigation and what its sensors read.
    pub(crate) fn tick_sensors(&mut self, now: Timestamp) {
        let (gps, lock) = (self.sensors.has_gps(), self.sensors.has_bottom_lock());
        self.sensors.step(&self.vehicle, &self.world, now);
        if self.sensors.has_gps() != gps {
            self.note(now, MvcEventKind::Gps(!gps));
        }
        if self.sensors.has_bottom_lock() != lock {
            self.note(now, MvcEventKind::BottomLock(!lock));
        }
        self.report_navigation(now);
        self.report_readings(now);
    }

    /// BFNVG and BFNVR are built each step, whoever listens.
    fn report_navigation(&mut self, now: Timestamp) {
        let stamp = self.stamp(now);
        let convergence_deg = self.frame_convergence_deg - self.grid_convergence_deg;
        let (navigation, velocity) = self
            .sensors
            .navigation(&self.vehicle, self.world.frame(), convergence_deg, stamp);
        if !self.sensors.failed.silent {
            self.publish(now, Some(Topic::Navigation), &FromVehicle::Navigation(navigation));
            if !self.sensors.untrue.has_no_velocity() {
                self.publish(now, Some(Topic::Velocity), &FromVehicle::VelocityAndRates(velocity));
            }
        }
    }

    /// The other sensors, each at its own rate: a reading is counted in any case, and made where it is wanted.
    fn report_readings(&mut self, now: Timestamp) {
        let failed = self.sensors.failed;
        let schedules = &mut self.sensors.schedules;
        let ctd = schedules.ctd.due(now);
        let sound = schedules.sound.due(now);
        let compass = schedules.compass.due(now);
        let depth = schedules.depth.due(now);
        let tailcone = schedules.tailcone.due(now);
        let dvl = schedules.dvl.due(now);
        let imu = schedules.imu.due(now);
        let telemetry = schedules.telemetry.due(now);
        if !self.server.wanted(READINGS) {
            return;
        }
        let stamp = self.stamp(now);
        if let Some(number) = ctd.filter(|_| self.sensors.config.ctd_fitted && !self.sensors.water.ctd_dead) {
            let reading = |mvc: &Self| {
                mvc.sensors
                    .water
                    .ctd(&mvc.vehicle, &mvc.world, now, number, stamp)
                    .into()
            };
            self.report(now, Topic::Ctd, reading);
        }
        if let Some(number) = sound {
            let reading = |mvc: &Self| {
                mvc.sensors
                    .water
                    .sound(&mvc.vehicle, &mvc.world, now, number, stamp)
                    .into()
            };
            self.report(now, Topic::SoundVelocity, reading);
        }
        if let Some(number) = compass.filter(|_| !failed.compass) {
            let true_deg = self.vehicle.heading_deg + self.frame_convergence_deg;
            for compass in 1..=self.sensors.compasses.count() {
                let reading = |mvc: &Self| {
                    let compasses = &mvc.sensors.compasses;
                    compasses.message(compass, &mvc.vehicle, true_deg, number, stamp).into()
                };
                self.report(now, Topic::Compass, reading);
            }
        }
        if let Some(number) = depth.filter(|_| !failed.depth) {
            let reading = |mvc: &Self| {
                let Self {
                    sensors,
                    vehicle,
                    world,
                    ..
                } = mvc;
                sensors.water.depth_sensor(vehicle, world, number, stamp).into()
            };
            self.report(now, Topic::DepthSensor, reading);
        }
        // A hovering hull has no tailcone (SPI 6.7, 6.12).
        if let Some(number) = tailcone.filter(|_| !failed.tailcone && !self.vehicle.hull().hovers) {
            let reading = |mvc: &Self| mvc.sensors.tailcone.speed(&mvc.vehicle, number, stamp).into();
            self.report(now, Topic::VehicleSpeed, reading);
            let reading = |mvc: &Self| {
                let Self { sensors, vehicle, .. } = mvc;
                sensors
                    .tailcone
                    .angles(vehicle, &sensors.before, sensors.dt_s, number, stamp)
                    .into()
            };
            self.report(now, Topic::ElevatorRudder, reading);
        }
        if let Some(number) = dvl {
            self.report_dvl(now, number);
        }
        if let Some(number) = imu.filter(|_| !failed.imu) {
            let reading = |mvc: &Self| {
                let Self { sensors, vehicle, .. } = mvc;
                sensors
                    .imu
                    .message(vehicle, &sensors.before, sensors.dt_s, number, stamp)
                    .into()
            };
            self.report(now, Topic::Imu, reading);
        }
        if telemetry.is_some() && self.sensors.config.telemetry.enabled && !failed.telemetry {
            let config = self.sensors.config.telemetry;
            let surfaced = self.vehicle.depth_m < self.sensors.config.gps.antenna_depth_m;
            let reading = |_: &Self| {
                Telemetry {
                    created: stamp,
                    acoustic_up_available_kb: config.acoustic_up_kb,
                    acoustic_up_last_kb: 0.0,
                    acoustic_down_available_kb: config.acoustic_down_kb,
                    acoustic_down_last_kb: 0.0,
                    rf_connected: surfaced,
                    ethernet_available: false,
                }
                .into()
            };
            self.report(now, Topic::Telemetry, reading);
        }
    }

    fn report_dvl(&mut self, now: Timestamp, number: u64) {
        if !self.server.wanted(Topic::Dvl.bit() | Topic::DvlExtended.bit()) {
            return;
        }
        let stamp = self.stamp(now);
        let temperature_c = self.world.temperature_c(self.vehicle.at, self.vehicle.depth_m, now);
        let sensors = &self.sensors;
        let reading = sensors
            .dvl
            .reading(&self.vehicle, temperature_c, sensors.sound_ratio, number);
        if let Some(reading) = reading {
            let hovers = self.vehicle.hull().hovers;
            self.report(now, Topic::Dvl, |_| reading.message(stamp).into());
            self.report(now, Topic::DvlExtended, |_| reading.extended(hovers, stamp).into());
        }
    }

    fn report(&mut self, now: Timestamp, topic: Topic, reading: impl FnOnce(&Self) -> FromVehicle) {
        if self.server.wanted(topic.bit()) {
            let message = reading(self);
            self.publish(now, Some(topic), &message);
        }
    }
}

/// What [`Mvc::report_readings`] may publish.
const READINGS: u32 = Topic::Ctd.bit()
    | Topic::SoundVelocity.bit()
    | Topic::Compass.bit()
    | Topic::DepthSensor.bit()
    | Topic::VehicleSpeed.bit()
    | Topic::ElevatorRudder.bit()
    | Topic::Dvl.bit()
    | Topic::DvlExtended.bit()
    | Topic::Imu.bit()
    | Topic::Telemetry.bit();

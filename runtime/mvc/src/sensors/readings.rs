use backseat_spi::{FromVehicle, Telemetry};

use super::Sensors;
use super::schedule::Schedule;
use crate::context::Context;
use crate::event::MvcEventKind;
use crate::faults::SensorFailure;
use crate::file::SensorConfig;
use crate::server::topics::Topic;

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

impl Schedules {
    /// Sets the time from one reading of the DVL to the next. A change takes effect with the next pulse.
    pub(super) fn trigger_dvl_every(&mut self, period_s: f64) {
        self.dvl.change_period(period_s);
    }
}

impl Sensors {
    /// Makes navigation or a sensor fail, or work again.
    pub(crate) fn fail(&mut self, failure: SensorFailure) {
        match failure {
            SensorFailure::Frozen(frozen) => self.freeze(frozen),
            SensorFailure::Silent(silent) => self.silence_navigation(silent),
            SensorFailure::Jump(way) => self.jump(way),
            SensorFailure::Dropout(sensor, dead) => self.sensor_dropout(sensor, dead),
        }
    }

    /// One step of the vehicle: its navigation and the readings of its sensors.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) {
        let (gps, lock) = (self.has_gps(), self.has_bottom_lock());
        self.advance(ctx.vehicle, ctx.world, ctx.now);
        if self.has_gps() != gps {
            ctx.note(MvcEventKind::Gps(!gps));
        }
        if self.has_bottom_lock() != lock {
            ctx.note(MvcEventKind::BottomLock(!lock));
        }
        self.report_navigation(ctx);
        self.report_readings(ctx);
    }

    /// Builds BFNVG and BFNVR in every step, even if nobody listens.
    fn report_navigation(&mut self, ctx: &mut Context<'_>) {
        let convergence_deg = ctx.north.frame_deg - ctx.north.grid_deg;
        let (navigation, velocity) = self.navigation(ctx.vehicle, ctx.frame(), convergence_deg, ctx.stamp());
        if !self.failed.silent {
            ctx.publish(Some(Topic::Navigation), &FromVehicle::Navigation(navigation));
            if !self.untrue.has_no_velocity() {
                ctx.publish(Some(Topic::Velocity), &FromVehicle::VelocityAndRates(velocity));
            }
        }
    }

    /// The other sensors, each at its own rate. A reading is always counted, but made only if a client wants it.
    fn report_readings(&mut self, ctx: &mut Context<'_>) {
        let (now, failed) = (ctx.now, self.failed);
        let schedules = &mut self.schedules;
        let ctd = schedules.ctd.due(now);
        let sound = schedules.sound.due(now);
        let compass = schedules.compass.due(now);
        let depth = schedules.depth.due(now);
        let tailcone = schedules.tailcone.due(now);
        let dvl = schedules.dvl.due(now);
        let imu = schedules.imu.due(now);
        let telemetry = schedules.telemetry.due(now);
        if !ctx.wanted(READINGS) {
            return;
        }
        let (vehicle, world, stamp) = (ctx.vehicle, ctx.world, ctx.stamp());
        if let Some(number) = ctd.filter(|_| self.config.ctd_fitted && !self.water.ctd_dead) {
            let reading = || self.water.ctd(vehicle, world, now, number, stamp).into();
            report(ctx, Topic::Ctd, reading);
        }
        if let Some(number) = sound {
            let reading = || self.water.sound(vehicle, world, now, number, stamp).into();
            report(ctx, Topic::SoundVelocity, reading);
        }
        if let Some(number) = compass.filter(|_| !failed.compass) {
            let true_deg = vehicle.motion().heading_deg + ctx.north.frame_deg;
            let compasses = &self.compasses;
            for compass in 1..=compasses.count() {
                let reading = || compasses.message(compass, vehicle, true_deg, number, stamp).into();
                report(ctx, Topic::Compass, reading);
            }
        }
        if let Some(number) = depth.filter(|_| !failed.depth) {
            let reading = || self.water.depth_sensor(vehicle, world, number, stamp).into();
            report(ctx, Topic::DepthSensor, reading);
        }
        // A hovering vehicle has no tailcone (SPI 6.7, 6.12).
        if let Some(number) = tailcone.filter(|_| !failed.tailcone && !vehicle.performance().hovers) {
            let tailcone = &self.tailcone;
            report(ctx, Topic::VehicleSpeed, || {
                tailcone.speed(vehicle, number, stamp).into()
            });
            let reading = || tailcone.angles(vehicle, number, stamp).into();
            report(ctx, Topic::ElevatorRudder, reading);
        }
        if let Some(number) = dvl {
            self.report_dvl(ctx, number);
        }
        if let Some(number) = imu.filter(|_| !failed.imu) {
            let reading = || self.imu.message(vehicle, &self.before, self.dt_s, number, stamp).into();
            report(ctx, Topic::Imu, reading);
        }
        if telemetry.is_some() && self.config.telemetry.enabled && !failed.telemetry {
            let config = self.config.telemetry;
            let surfaced = vehicle.motion().depth_m < self.config.gps.antenna_depth_m;
            let reading = || {
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
            report(ctx, Topic::Telemetry, reading);
        }
    }

    fn report_dvl(&self, ctx: &mut Context<'_>, number: u64) {
        if !ctx.wanted(Topic::Dvl.bit() | Topic::DvlExtended.bit()) {
            return;
        }
        let (vehicle, stamp) = (ctx.vehicle, ctx.stamp());
        let motion = vehicle.motion();
        let temperature_c = ctx.world.temperature_c(motion.at, motion.depth_m, ctx.now);
        let reading = self.dvl.reading(vehicle, temperature_c, self.sound_ratio, number);
        if let Some(reading) = reading {
            report(ctx, Topic::Dvl, || reading.message(stamp).into());
            let hovers = vehicle.performance().hovers;
            report(ctx, Topic::DvlExtended, || reading.extended(hovers, stamp).into());
        }
    }
}

fn report(ctx: &mut Context<'_>, topic: Topic, reading: impl FnOnce() -> FromVehicle) {
    if ctx.wanted(topic.bit()) {
        ctx.publish(Some(topic), &reading());
    }
}

/// What [`Sensors::report_readings`] may publish.
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

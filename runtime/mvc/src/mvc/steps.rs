use backseat_units::Timestamp;

use super::Mvc;
use crate::context::{Context, North};
use crate::event::MvcEventKind;
use crate::executive::mission::Mission;
use crate::sensors::Sensors;
use crate::server::answers::Regarding;
use crate::server::requests::Work;
use crate::services::Services;
use crate::vehicle::Drive;

/// The parts of the vehicle and the context that each of them receives. The borrows are separate, so that each part can
/// be called with the same context.
pub(super) struct Parts<'a> {
    pub(super) ctx: Context<'a>,
    pub(super) mission: &'a mut Mission,
    pub(super) sensors: &'a mut Sensors,
    pub(super) services: &'a mut Services,
}

/// A step of the vehicle. It calls every part, always in the same order.
impl Mvc {
    /// The parts, and the context as it is now. A caller needs a new one after a part has changed what the context has
    /// for the next part.
    pub(super) fn parts(&mut self, now: Timestamp) -> Parts<'_> {
        Parts {
            ctx: Context {
                now,
                period: self.period,
                world: &self.world,
                vehicle: &self.vehicle,
                north: self.north,
                estimate: self.sensors.estimate(&self.vehicle),
                interpretation: &self.interpretation,
                mission: self.mission.status(),
                quiet: self.services.quiet(&self.vehicle),
                server: &mut self.server,
            },
            mission: &mut self.mission,
            sensors: &mut self.sensors,
            services: &mut self.services,
        }
    }

    pub(super) fn next_fault(&self) -> Timestamp {
        self.faults.next().min(self.server.late_due())
    }

    pub(super) fn tick(&mut self, now: Timestamp) {
        self.decide_due(now);
        self.move_on(now);
        self.settle(now);
        let Parts {
            mut ctx,
            mission,
            sensors,
            services,
        } = self.parts(now);
        if let Some(look_deg) = services.hovering.turn_devices(mission) {
            sensors.turn_log(look_deg);
        }
        sensors.trigger_dvl(services.dvl_trigger.trigger(now));
        sensors.step(&mut ctx);
        ctx.estimate = sensors.estimate(ctx.vehicle);
        if services.step(&mut ctx) {
            self.settle(now);
        }
        let Parts {
            mut ctx,
            mission,
            services,
            ..
        } = self.parts(now);
        services.step_on(&mut ctx, mission);
        mission.tell_scheduled(&mut ctx);
        self.vehicle.float_with(self.services.adjustment.rise_share());
        self.settle(now);
    }

    /// Decides what the vehicle does now, and moves it.
    fn move_on(&mut self, now: Timestamp) {
        let Parts {
            ctx, mission, services, ..
        } = self.parts(now);
        services.hovering.steer(&ctx, mission);
        let drive = mission.step(&ctx);
        let Parts { mut ctx, services, .. } = self.parts(now);
        let drive = services.quieted(&mut ctx, drive);
        self.vehicle
            .step(self.sensors.as_flown(drive), self.period.as_secs_f64());
        self.vehicle.sense(&self.world, now);
        let motion = self.vehicle.motion();
        if motion.grounded != self.grounded {
            self.grounded = motion.grounded;
            if self.grounded && drive != Drive::Held {
                self.server.note(now, MvcEventKind::Grounded);
            }
        }
        // The angles change by a hundred-thousandth of a degree for each metre.
        if self.ticks.is_multiple_of(10) {
            self.north = North::at(motion.at, self.world.frame());
        }
    }

    /// Decides every pending request that is due, and tells the client the outcome.
    fn decide_due(&mut self, now: Timestamp) {
        while let Some((re, work)) = self.server.next_due(now) {
            self.decide(now, re, work);
            self.settle(now);
        }
    }

    fn decide(&mut self, now: Timestamp, re: Regarding, work: Work) {
        let Parts {
            mut ctx,
            mission,
            services,
            ..
        } = self.parts(now);
        match work {
            Work::Mission(asked) => mission.decide(&mut ctx, re, asked),
            Work::Topside(text) => services.topside.decide(&mut ctx, re, text),
        }
    }

    /// Tells the clients and the log what has happened, and tells the services which clients the server has cut off.
    pub(super) fn settle(&mut self, now: Timestamp) {
        let Parts { mut ctx, mission, .. } = self.parts(now);
        mission.settle(&mut ctx);
        while let Some(client) = self.server.next_left() {
            self.services.client_left(client);
        }
    }
}

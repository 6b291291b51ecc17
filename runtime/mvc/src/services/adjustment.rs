mod system;

use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{
    AckStatus, AdjustmentError, AdjustmentStatus, BehaviorBegin, BehaviorEnd, BuoyancyStatus, Text, TrimStatus,
};
use backseat_units::Timestamp;
use backseat_world::Stream;

use self::system::System;
use super::times::times;
use crate::context::Context;
use crate::event::{AdjustmentEvent, AdjustmentKind, ClientId, MvcEventKind, Status};
use crate::file::{AdjustmentConfig, WorldFile};
use crate::server::answers::Regarding;
use crate::server::topics::Topic;

/// The vehicle is on the surface if it is above this depth, metres.
const SURFACED_M: f64 = 0.3;
/// How long an adjustment works before its drawn failure.
const FAILS_AFTER: Duration = Duration::from_secs(3);

/// Trim and buoyancy (SPI 6.22, 6.23, 7.23, 7.24).
///
/// An adjustment that a payload has requested is the current behavior: the thruster is off. When it ends, the mission
/// continues where it was. The mission's clocks keep running during the adjustment.
#[derive(Debug)]
pub(crate) struct Adjustment {
    config: AdjustmentConfig,
    stream: Stream,
    system: System,
    running: Option<Running>,
    implicit: VecDeque<Timestamp>,
    next_trim: Timestamp,
    next_buoyancy: Timestamp,
}

#[derive(Clone, Copy, Debug)]
struct Running {
    kind: AdjustmentKind,
    /// The client that requested it; `None` if the vehicle adjusts by itself.
    by: Option<ClientId>,
    began: Timestamp,
    /// How long it has worked.
    worked: Duration,
    fails: bool,
    in_mission: bool,
}

/// How an adjustment ended.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    status: AdjustmentStatus,
    error: AdjustmentError,
    text: &'static str,
}

const COMPLETED: Outcome = Outcome {
    status: AdjustmentStatus::Completed,
    error: AdjustmentError::None,
    text: "complete",
};

const fn failed(error: AdjustmentError, text: &'static str) -> Outcome {
    Outcome {
        status: AdjustmentStatus::Failed,
        error,
        text,
    }
}

impl Adjustment {
    pub(crate) fn new(file: &WorldFile, seed: u64) -> Self {
        let config = file.adjustment.clone();
        Self {
            stream: Stream::new(seed, "adjustments"),
            system: System::new(&config, seed),
            running: None,
            implicit: times(&config.implicit_at_s),
            next_trim: Timestamp::ZERO,
            next_buoyancy: Timestamp::ZERO,
            config,
        }
    }

    /// Whether an adjustment is running that a payload has requested.
    pub(crate) fn is_asked_for(&self) -> bool {
        self.running.is_some_and(|running| running.by.is_some())
    }

    /// How fast the vehicle floats up, as a share of the buoyant rise of its class. It is the square root of the share
    /// of buoyancy, because drag grows with the square of the speed. With a negative share the vehicle sinks.
    pub(crate) fn rise_share(&self) -> f64 {
        let share = self.system.buoyancy_n / self.config.buoyancy_nominal_n;
        share.abs().sqrt().copysign(share)
    }

    const fn is_equipped(&self, kind: AdjustmentKind) -> bool {
        match kind {
            AdjustmentKind::Trim => self.config.trim_equipped,
            AdjustmentKind::Buoyancy => self.config.buoyancy_equipped,
        }
    }
}

impl Adjustment {
    /// BPTRM (SPI 7.23).
    pub(crate) fn trim(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        self.adjust(ctx, re, AdjustmentKind::Trim);
    }

    /// BPBOY (SPI 7.24).
    pub(crate) fn buoyancy(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        self.adjust(ctx, re, AdjustmentKind::Buoyancy);
    }

    /// BPRCB while an adjustment is the current behavior (SPI 7.23, 7.24).
    pub(crate) fn cancel(&mut self, ctx: &mut Context<'_>, re: Regarding) {
        self.end(ctx, failed(AdjustmentError::Canceled, "canceled"));
        ctx.acknowledge(re, AckStatus::Succeeded, "");
    }

    /// Silence is commanded: the systems stop at once.
    pub(crate) fn fall_silent(&mut self, ctx: &mut Context<'_>) {
        self.end(
            ctx,
            failed(AdjustmentError::Canceled, "canceled: silence was commanded"),
        );
    }

    /// The mission wraps up and needs the thruster.
    pub(crate) fn abandon(&mut self, ctx: &mut Context<'_>) {
        self.end(ctx, failed(AdjustmentError::Canceled, "canceled: the mission wraps up"));
    }

    /// One step of the vehicle.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) {
        if self.implicit.front().is_some_and(|at| *at <= ctx.now) {
            self.implicit.pop_front();
            let free = self.running.is_none() && !ctx.quiet.commanded;
            if free && self.config.buoyancy_equipped {
                self.begin(ctx, AdjustmentKind::Buoyancy, None);
            }
        }
        if let Some(running) = self.running
            && let Some(outcome) = self.work(ctx, running)
        {
            self.end(ctx, outcome);
        }
        if let Some(running) = self.running {
            self.report_running(ctx, running);
        }
        if ctx.now >= self.next_buoyancy {
            self.report_idle_buoyancy(ctx);
        }
    }

    fn adjust(&mut self, ctx: &mut Context<'_>, re: Regarding, kind: AdjustmentKind) {
        let topic = match kind {
            AdjustmentKind::Trim => Topic::Trim,
            AdjustmentKind::Buoyancy => Topic::Buoyancy,
        };
        let why = if !self.is_equipped(kind) {
            match kind {
                AdjustmentKind::Trim => "no trim adjustment system is fitted",
                AdjustmentKind::Buoyancy => "no variable buoyancy system is fitted",
            }
        } else if ctx.quiet.commanded {
            "the vehicle is silent"
        } else if self.is_asked_for() {
            "another adjustment is running"
        } else if ctx.quiet.spinning {
            "the tailcone is spinning"
        } else if ctx.vehicle.motion().depth_m < SURFACED_M {
            "the vehicle is on the surface"
        } else if ctx.interpretation.adjustment_needs_status && !ctx.server.has(re.client, topic) {
            "its status message is not switched on"
        } else {
            // An adjustment that the vehicle began by itself is canceled.
            self.end(
                ctx,
                failed(AdjustmentError::Canceled, "canceled: another was requested"),
            );
            ctx.acknowledge(re, AckStatus::Succeeded, "");
            self.begin(ctx, kind, Some(re.client));
            return;
        };
        ctx.acknowledge(re, AckStatus::Failed, why);
    }

    fn begin(&mut self, ctx: &mut Context<'_>, kind: AdjustmentKind, by: Option<ClientId>) {
        self.running = Some(Running {
            kind,
            by,
            began: ctx.now,
            worked: Duration::ZERO,
            fails: self.stream.uniform() < self.config.failure_chance,
            in_mission: ctx.mission == Status::Running,
        });
        match kind {
            AdjustmentKind::Trim => self.next_trim = ctx.now,
            AdjustmentKind::Buoyancy => self.next_buoyancy = ctx.now,
        }
        ctx.note(MvcEventKind::Adjustment(AdjustmentEvent::Began(kind, by)));
        if by.is_some() {
            let message = BehaviorBegin {
                created: ctx.stamp(),
                dive_file: Text::default(),
                number: None,
                identifier: None,
                kind: Text::cleaned(kind.name()),
            };
            ctx.publish(Some(Topic::BehaviorBegin), &message.into());
        }
        if self.system.is_done(&self.config, kind) {
            // "If it is detected that no adjustment is necessary, the behavior will immediately complete successfully."
            self.end(ctx, COMPLETED);
        }
    }

    /// Does one step of work. Returns the outcome if the adjustment ends.
    fn work(&mut self, ctx: &Context<'_>, running: Running) -> Option<Outcome> {
        let asked = running.by.is_some();
        if asked && running.in_mission && ctx.mission != Status::Running {
            return Some(failed(AdjustmentError::Canceled, "canceled: the mission ended"));
        }
        if ctx.now.since(running.began).as_secs_f64() >= self.config.time_limit_s {
            return Some(failed(AdjustmentError::Failed, "it took too long"));
        }
        if asked && ctx.vehicle.motion().depth_m < SURFACED_M {
            return Some(failed(AdjustmentError::Failed, "the vehicle is on the surface"));
        }
        if asked && ctx.vehicle.motion().surge_mps > self.config.stopped_mps {
            return None;
        }
        if let Some(running) = &mut self.running {
            running.worked += ctx.period;
            if running.fails && running.worked > FAILS_AFTER {
                return Some(failed(AdjustmentError::Failed, "the system does not answer"));
            }
        }
        let moved = self.system.work(&self.config, running.kind, ctx.period.as_secs_f64());
        if self.system.is_done(&self.config, running.kind) {
            return Some(COMPLETED);
        }
        (!moved).then_some(failed(AdjustmentError::AtLimit, "at limit"))
    }

    fn end(&mut self, ctx: &mut Context<'_>, outcome: Outcome) {
        let Some(running) = self.running.take() else {
            return;
        };
        let kind = running.kind;
        self.report(ctx, kind, outcome);
        ctx.note(MvcEventKind::Adjustment(match outcome.status {
            AdjustmentStatus::Completed => AdjustmentEvent::Completed(kind),
            AdjustmentStatus::Idle
            | AdjustmentStatus::InProgress
            | AdjustmentStatus::Failed
            | AdjustmentStatus::Other(_) => AdjustmentEvent::Failed(kind, outcome.text),
        }));
        if running.by.is_some() {
            let message = BehaviorEnd {
                created: ctx.stamp(),
                dive_file: Text::default(),
                number: None,
                identifier: None,
                kind: Text::cleaned(kind.name()),
            };
            ctx.publish(Some(Topic::BehaviorEnd), &message.into());
        }
        self.next_buoyancy = ctx.now + Duration::from_secs_f64(self.config.idle_period_s);
    }

    fn report_running(&mut self, ctx: &mut Context<'_>, running: Running) {
        let next = ctx.now + Duration::from_secs_f64(self.config.status_period_s);
        let due = match running.kind {
            AdjustmentKind::Trim => &mut self.next_trim,
            AdjustmentKind::Buoyancy => &mut self.next_buoyancy,
        };
        if ctx.now < *due {
            return;
        }
        *due = next;
        let waits = running.by.is_some() && running.worked == Duration::ZERO;
        let text = if waits {
            "waiting for the vehicle to stop"
        } else {
            "adjusting"
        };
        let outcome = Outcome {
            status: AdjustmentStatus::InProgress,
            error: AdjustmentError::None,
            text,
        };
        self.report(ctx, running.kind, outcome);
    }

    /// BFBOY is also sent while no adjustment is in progress (SPI 6.23).
    fn report_idle_buoyancy(&mut self, ctx: &mut Context<'_>) {
        self.next_buoyancy = ctx.now + Duration::from_secs_f64(self.config.idle_period_s);
        if !self.config.buoyancy_equipped || !ctx.wanted(Topic::Buoyancy.bit()) {
            return;
        }
        let outcome = Outcome {
            status: AdjustmentStatus::Idle,
            error: AdjustmentError::None,
            text: "idle",
        };
        self.report(ctx, AdjustmentKind::Buoyancy, outcome);
    }

    fn report(&self, ctx: &mut Context<'_>, kind: AdjustmentKind, outcome: Outcome) {
        let created = ctx.stamp();
        let Outcome { status, error, text } = outcome;
        let text = Text::cleaned(text);
        match kind {
            AdjustmentKind::Trim => {
                let message = TrimStatus {
                    created,
                    status,
                    error,
                    text,
                    pitch_deg: self.system.pitch_deg,
                    roll_deg: self.system.roll_deg,
                };
                ctx.publish(Some(Topic::Trim), &message.into());
            }
            AdjustmentKind::Buoyancy => {
                let message = BuoyancyStatus {
                    created,
                    status,
                    error,
                    text,
                    buoyancy_n: self.system.buoyancy_n,
                };
                ctx.publish(Some(Topic::Buoyancy), &message.into());
            }
        }
    }
}

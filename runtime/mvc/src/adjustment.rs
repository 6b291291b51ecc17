mod system;

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{
    AckStatus, AdjustmentError, AdjustmentStatus, BehaviorBegin, BehaviorEnd, BuoyancyAdjustment, BuoyancyStatus, Text,
    TrimAdjustment, TrimStatus,
};
use backseat_units::Timestamp;
use backseat_world::Stream;

use self::system::System;
use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind, Status};
use crate::file::{AdjustmentConfig, WorldFile};
use crate::mvc::Mvc;
use crate::server::Topic;

/// Above this depth the vehicle is on the surface, metres.
const SURFACED_M: f64 = 0.3;
/// An adjustment that is to fail works for so long first.
const FAILS_AFTER: Duration = Duration::from_secs(3);

/// Which of the two systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdjustmentKind {
    /// Trim: pitch and roll.
    Trim,
    /// Variable buoyancy.
    Buoyancy,
}

/// What happened to an adjustment of trim or buoyancy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdjustmentEvent {
    /// It began, asked for by a client or by the vehicle itself.
    Began(AdjustmentKind, Option<ClientId>),
    /// It ended well.
    Completed(AdjustmentKind),
    /// It ended otherwise: why.
    Failed(AdjustmentKind, &'static str),
}

/// Trim and buoyancy (SPI 6.22, 6.23, 7.23, 7.24).
///
/// An adjustment that a payload has asked for is the current behavior: the thruster is off, and the mission goes on
/// where it was when it ends. The mission's own clocks run meanwhile.
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
    /// Who has asked; none where the vehicle adjusts by itself.
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
            implicit: crate::power::times(&config.implicit_at_s),
            next_trim: Timestamp::ZERO,
            next_buoyancy: Timestamp::ZERO,
            config,
        }
    }

    /// Whether an adjustment runs that a payload has asked for.
    pub(crate) fn is_asked_for(&self) -> bool {
        self.running.is_some_and(|running| running.by.is_some())
    }

    /// How fast the hull floats up, as a share of what its class does: of the buoyancy's root, for drag goes with the
    /// square of the speed. Negative sinks.
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

impl Mvc {
    /// BPTRM (SPI 7.23).
    pub(crate) fn adjust_trim(&mut self, now: Timestamp, re: Regarding, _request: &TrimAdjustment) {
        self.adjust(now, re, AdjustmentKind::Trim);
    }

    /// BPBOY (SPI 7.24).
    pub(crate) fn adjust_buoyancy(&mut self, now: Timestamp, re: Regarding, _request: &BuoyancyAdjustment) {
        self.adjust(now, re, AdjustmentKind::Buoyancy);
    }

    /// BPRCB while an adjustment is the current behavior (SPI 7.23, 7.24).
    pub(crate) fn cancel_adjustment(&mut self, now: Timestamp, re: Regarding) {
        self.end_adjustment(now, failed(AdjustmentError::Canceled, "canceled"));
        self.acknowledge(now, re, AckStatus::Succeeded, "");
    }

    /// Silence has been commanded: the systems stop at once.
    pub(crate) fn silence_adjustment(&mut self, now: Timestamp) {
        self.end_adjustment(
            now,
            failed(AdjustmentError::Canceled, "canceled: silence was commanded"),
        );
    }

    /// The mission is wrapped up: the thruster is needed.
    pub(crate) fn abandon_adjustment(&mut self, now: Timestamp) {
        self.end_adjustment(now, failed(AdjustmentError::Canceled, "canceled: the mission wraps up"));
    }

    /// One step of the vehicle.
    pub(crate) fn tick_adjustment(&mut self, now: Timestamp) {
        if self.adjustment.implicit.front().is_some_and(|at| *at <= now) {
            self.adjustment.implicit.pop_front();
            let free = self.adjustment.running.is_none() && !self.silence.is_commanded();
            if free && self.adjustment.config.buoyancy_equipped {
                self.begin_adjustment(now, AdjustmentKind::Buoyancy, None);
            }
        }
        if let Some(running) = self.adjustment.running
            && let Some(outcome) = self.work(now, running)
        {
            self.end_adjustment(now, outcome);
        }
        if let Some(running) = self.adjustment.running {
            self.report_running(now, running);
        }
        if now >= self.adjustment.next_buoyancy {
            self.report_idle_buoyancy(now);
        }
    }

    fn adjust(&mut self, now: Timestamp, re: Regarding, kind: AdjustmentKind) {
        let topic = match kind {
            AdjustmentKind::Trim => Topic::Trim,
            AdjustmentKind::Buoyancy => Topic::Buoyancy,
        };
        let why = if !self.adjustment.is_equipped(kind) {
            match kind {
                AdjustmentKind::Trim => "no trim adjustment system is fitted",
                AdjustmentKind::Buoyancy => "no variable buoyancy system is fitted",
            }
        } else if self.silence.is_commanded() {
            "the vehicle is silent"
        } else if self.adjustment.is_asked_for() {
            "another adjustment is running"
        } else if self.silence.is_spinning(now) {
            "the tailcone is spinning"
        } else if self.vehicle.depth_m < SURFACED_M {
            "the vehicle is on the surface"
        } else if self.interpretation.adjustment_needs_status && !self.server.has(re.client, topic) {
            "its status message is not switched on"
        } else {
            // An implicit one gives way.
            self.end_adjustment(
                now,
                failed(AdjustmentError::Canceled, "canceled: another was asked for"),
            );
            self.acknowledge(now, re, AckStatus::Succeeded, "");
            self.begin_adjustment(now, kind, Some(re.client));
            return;
        };
        self.acknowledge(now, re, AckStatus::Failed, why);
    }

    fn begin_adjustment(&mut self, now: Timestamp, kind: AdjustmentKind, by: Option<ClientId>) {
        let adjustment = &mut self.adjustment;
        adjustment.running = Some(Running {
            kind,
            by,
            began: now,
            worked: Duration::ZERO,
            fails: adjustment.stream.uniform() < adjustment.config.failure_chance,
            in_mission: self.executive.status() == Status::Running,
        });
        match kind {
            AdjustmentKind::Trim => adjustment.next_trim = now,
            AdjustmentKind::Buoyancy => adjustment.next_buoyancy = now,
        }
        self.note(now, MvcEventKind::Adjustment(AdjustmentEvent::Began(kind, by)));
        if by.is_some() {
            let message = BehaviorBegin {
                created: self.stamp(now),
                dive_file: Text::default(),
                number: None,
                identifier: None,
                kind: Text::cleaned(kind.name()),
            };
            self.publish(now, Some(Topic::BehaviorBegin), &message.into());
        }
        if self.adjustment.system.is_done(&self.adjustment.config, kind) {
            // "If it is detected that no adjustment is necessary, the behavior will immediately complete successfully."
            self.end_adjustment(now, COMPLETED);
        }
    }

    /// One step of work; the outcome where it is at its end.
    fn work(&mut self, now: Timestamp, running: Running) -> Option<Outcome> {
        let asked = running.by.is_some();
        if asked && running.in_mission && self.executive.status() != Status::Running {
            return Some(failed(AdjustmentError::Canceled, "canceled: the mission ended"));
        }
        if now.since(running.began).as_secs_f64() >= self.adjustment.config.time_limit_s {
            return Some(failed(AdjustmentError::Failed, "it took too long"));
        }
        if asked && self.vehicle.depth_m < SURFACED_M {
            return Some(failed(AdjustmentError::Failed, "the vehicle is on the surface"));
        }
        if asked && self.vehicle.surge_mps > self.adjustment.config.stopped_mps {
            return None;
        }
        let (period, adjustment) = (self.period(), &mut self.adjustment);
        if let Some(running) = &mut adjustment.running {
            running.worked += period;
            if running.fails && running.worked > FAILS_AFTER {
                return Some(failed(AdjustmentError::Failed, "the system does not answer"));
            }
        }
        let moved = adjustment
            .system
            .work(&adjustment.config, running.kind, period.as_secs_f64());
        self.vehicle.rise_share = adjustment.rise_share();
        if adjustment.system.is_done(&adjustment.config, running.kind) {
            return Some(COMPLETED);
        }
        (!moved).then_some(failed(AdjustmentError::AtLimit, "at limit"))
    }

    fn end_adjustment(&mut self, now: Timestamp, outcome: Outcome) {
        let Some(running) = self.adjustment.running.take() else {
            return;
        };
        let kind = running.kind;
        self.report_adjustment(now, kind, outcome);
        self.note(
            now,
            MvcEventKind::Adjustment(match outcome.status {
                AdjustmentStatus::Completed => AdjustmentEvent::Completed(kind),
                AdjustmentStatus::Idle
                | AdjustmentStatus::InProgress
                | AdjustmentStatus::Failed
                | AdjustmentStatus::Other(_) => AdjustmentEvent::Failed(kind, outcome.text),
            }),
        );
        if running.by.is_some() {
            let message = BehaviorEnd {
                created: self.stamp(now),
                dive_file: Text::default(),
                number: None,
                identifier: None,
                kind: Text::cleaned(kind.name()),
            };
            self.publish(now, Some(Topic::BehaviorEnd), &message.into());
        }
        self.adjustment.next_buoyancy = now + Duration::from_secs_f64(self.adjustment.config.idle_period_s);
    }

    fn report_running(&mut self, now: Timestamp, running: Running) {
        let next = now + Duration::from_secs_f64(self.adjustment.config.status_period_s);
        let due = match running.kind {
            AdjustmentKind::Trim => &mut self.adjustment.next_trim,
            AdjustmentKind::Buoyancy => &mut self.adjustment.next_buoyancy,
        };
        if now < *due {
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
        self.report_adjustment(now, running.kind, outcome);
    }

    /// BFBOY comes while no adjustment is in progress as well (SPI 6.23).
    fn report_idle_buoyancy(&mut self, now: Timestamp) {
        self.adjustment.next_buoyancy = now + Duration::from_secs_f64(self.adjustment.config.idle_period_s);
        if !self.adjustment.config.buoyancy_equipped || !self.server.wanted(Topic::Buoyancy.bit()) {
            return;
        }
        let outcome = Outcome {
            status: AdjustmentStatus::Idle,
            error: AdjustmentError::None,
            text: "idle",
        };
        self.report_adjustment(now, AdjustmentKind::Buoyancy, outcome);
    }

    fn report_adjustment(&mut self, now: Timestamp, kind: AdjustmentKind, outcome: Outcome) {
        let created = self.stamp(now);
        let Outcome { status, error, text } = outcome;
        let text = Text::cleaned(text);
        match kind {
            AdjustmentKind::Trim => {
                let message = TrimStatus {
                    created,
                    status,
                    error,
                    text,
                    pitch_deg: self.adjustment.system.pitch_deg,
                    roll_deg: self.adjustment.system.roll_deg,
                };
                self.publish(now, Some(Topic::Trim), &message.into());
            }
            AdjustmentKind::Buoyancy => {
                let message = BuoyancyStatus {
                    created,
                    status,
                    error,
                    text,
                    buoyancy_n: self.adjustment.system.buoyancy_n,
                };
                self.publish(now, Some(Topic::Buoyancy), &message.into());
            }
        }
    }
}

impl AdjustmentKind {
    /// The behavior's type in BFMBS and BFMBE.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trim => "trim",
            Self::Buoyancy => "buoyancy",
        }
    }
}

impl fmt::Display for AdjustmentEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Began(kind, Some(client)) => write!(f, "{} adjustment of {client} began", kind.name()),
            Self::Began(kind, None) => write!(f, "{} adjustment of the vehicle's own began", kind.name()),
            Self::Completed(kind) => write!(f, "{} adjustment completed", kind.name()),
            Self::Failed(kind, why) => write!(f, "{} adjustment ended: {why}", kind.name()),
        }
    }
}

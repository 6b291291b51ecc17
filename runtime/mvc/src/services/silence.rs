use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{AckStatus, SilentMode};
use backseat_units::Timestamp;
use backseat_world::Stream;

use super::acoustic::Acoustic;
use super::adjustment::Adjustment;
use crate::context::{Context, Quiet};
use crate::event::{ClientId, MvcEventKind, SilenceEvent, Status};
use crate::file::{SilenceConfig, WorldFile};
use crate::server::answers::Regarding;
use crate::vehicle::{Drive, Vehicle};

/// How much longer the vehicle waits with the second acknowledgement if the tailcone has not stopped (SPI 7.22).
const HELD_OFF: Duration = Duration::from_secs(2);
/// The greatest number of requests that wait for their second acknowledgement.
const CHANGES_MAX: usize = 64;

/// Silent mode (SPI 7.22), which depends on the tailcone.
#[derive(Debug)]
pub(crate) struct Silence {
    config: SilenceConfig,
    stream: Stream,
    changes: VecDeque<Change>,
    /// When it ends by itself; `None` if the vehicle is not silent.
    until: Option<Timestamp>,
    /// The tailcone's target state: whether its thruster is on.
    driven: bool,
    /// Whether the vehicle has a tailcone. A hovering vehicle has none, and its thrusters keep running in silence.
    has_tailcone: bool,
}

/// The devices that become silent with the vehicle.
pub(crate) struct Devices<'a> {
    pub(crate) adjustment: &'a mut Adjustment,
    pub(crate) acoustic: &'a mut Acoustic,
}

/// A request whose second acknowledgement is pending.
#[derive(Clone, Copy, Debug)]
struct Change {
    re: Regarding,
    silent: bool,
    due: Timestamp,
    held_off: bool,
}

impl Silence {
    pub(crate) fn new(file: &WorldFile, vehicle: &mut Vehicle, seed: u64) -> Self {
        vehicle.spin_down_within(file.silence.spin_down_s);
        Self {
            config: file.silence,
            stream: Stream::new(seed, "silent mode"),
            changes: VecDeque::new(),
            until: None,
            driven: false,
            has_tailcone: !file.vehicle.performance().hovers,
        }
    }

    const fn is_silent(&self) -> bool {
        self.until.is_some()
    }

    /// What the rest of the vehicle needs to know about silent mode.
    pub(crate) fn quiet(&self, vehicle: &Vehicle) -> Quiet {
        Quiet {
            silent: self.is_silent(),
            commanded: self.is_silent() || self.changes.iter().any(|change| change.silent),
            driven: self.driven,
            spinning: self.is_spinning(vehicle),
        }
    }

    /// The target state and the current state of the tailcone: its thruster is on, or its propeller still turns.
    fn is_spinning(&self, vehicle: &Vehicle) -> bool {
        self.has_tailcone && (self.driven || vehicle.is_spinning())
    }

    /// Handles the end of a connection: its requests are still decided, but no longer answered.
    pub(crate) fn client_left(&mut self, client: ClientId) {
        for change in self.changes.iter_mut().filter(|change| change.re.client == client) {
            change.re.muted = true;
        }
    }

    fn take_due(&mut self, now: Timestamp) -> Option<Change> {
        let at = self.changes.iter().position(|change| change.due <= now)?;
        self.changes.remove(at)
    }
}

impl Silence {
    /// BPSIL (SPI 7.22). Both acknowledgements are sent, whatever the setting for other requests is.
    pub(crate) fn request(
        &mut self,
        ctx: &mut Context<'_>,
        re: Regarding,
        request: &SilentMode,
        devices: &mut Devices<'_>,
    ) {
        if self.changes.len() >= CHANGES_MAX {
            ctx.acknowledge(re, AckStatus::Failed, "too many requests are pending");
            return;
        }
        if request.silent && !self.is_silent() {
            // "The target state of the tailcone is checked". Without a running mission, it is at rest.
            if self.has_tailcone && self.driven {
                return failed(ctx, re, "the tailcone is spinning");
            }
            if devices.adjustment.is_asked_for() && !ctx.interpretation.silence_cancels_adjustment {
                return failed(ctx, re, "a trim or buoyancy adjustment is running");
            }
            ctx.note(MvcEventKind::Silence(SilenceEvent::Asked(re.client)));
            devices.adjustment.fall_silent(ctx);
        }
        if !request.silent {
            self.withdraw(ctx);
        }
        ctx.acknowledge(re, AckStatus::Pending, "");
        let settle_s = self.config.settle_s.draw(&mut self.stream);
        self.changes.push_back(Change {
            re,
            silent: request.silent,
            due: ctx.now + Duration::from_secs_f64(settle_s),
            held_off: false,
        });
    }

    /// One step of the vehicle.
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>, devices: &mut Devices<'_>) {
        while let Some(change) = self.take_due(ctx.now) {
            if change.silent {
                self.enter(ctx, change, devices);
            } else {
                let text = if self.is_silent() {
                    ""
                } else {
                    "the vehicle was not silent"
                };
                self.end(ctx, SilenceEvent::Ended);
                ctx.acknowledge(change.re, AckStatus::Succeeded, text);
            }
        }
        // "The vehicle will resume as normal with no feedback to the payload."
        if self.until.is_some_and(|until| until <= ctx.now) {
            self.end(ctx, SilenceEvent::TimedOut);
        }
    }

    /// What actually moves the vehicle when its mission demands `drive`. The thruster is off while the vehicle is
    /// silent, while it adjusts its trim or buoyancy, and if no speed is demanded.
    pub(crate) fn quieted(&mut self, ctx: &mut Context<'_>, drive: Drive, devices: &mut Devices<'_>) -> Drive {
        if matches!(drive, Drive::Under(_)) && ctx.mission != Status::Running {
            // This is a powered ascent. It ends silence, because bringing the vehicle home is more important. The
            // specification does not mention this case.
            self.end(ctx, SilenceEvent::WrapUp);
            devices.adjustment.abandon(ctx);
        }
        let drive = match drive {
            Drive::Under(_) if self.has_tailcone && (self.is_silent() || devices.adjustment.is_asked_for()) => {
                Drive::Adrift
            }
            Drive::Under(demand) if !demand.throttle.is_on() && !ctx.vehicle.performance().hovers => Drive::Adrift,
            Drive::Held | Drive::Under(_) | Drive::Hover(_) | Drive::Adrift => drive,
        };
        self.driven = matches!(drive, Drive::Under(_));
        drive
    }

    fn enter(&mut self, ctx: &mut Context<'_>, mut change: Change, devices: &mut Devices<'_>) {
        if self.is_silent() {
            let text = "already silent: the time is not extended";
            return ctx.acknowledge(change.re, AckStatus::Succeeded, text);
        }
        if self.is_spinning(ctx.vehicle) {
            if change.held_off {
                return failed(ctx, change.re, "the tailcone is still spinning");
            }
            (change.held_off, change.due) = (true, change.due + HELD_OFF);
            self.changes.push_back(change);
            return;
        }
        if self.stream.uniform() < self.config.failure_chance {
            return failed(ctx, change.re, "a device did not go quiet");
        }
        self.until = Some(ctx.now + Duration::from_secs_f64(self.config.timeout_s));
        ctx.note(MvcEventKind::Silence(SilenceEvent::Began));
        devices.adjustment.fall_silent(ctx);
        devices.acoustic.fall_silent(ctx);
        ctx.acknowledge(change.re, AckStatus::Succeeded, "");
    }

    /// A request for normal mode makes the undecided requests for silence fail.
    fn withdraw(&mut self, ctx: &mut Context<'_>) {
        while let Some(at) = self.changes.iter().position(|change| change.silent) {
            if let Some(change) = self.changes.remove(at) {
                failed(ctx, change.re, "normal mode was requested meanwhile");
            }
        }
    }

    fn end(&mut self, ctx: &mut Context<'_>, why: SilenceEvent) {
        if self.until.take().is_some() {
            ctx.note(MvcEventKind::Silence(why));
        }
    }
}

fn failed(ctx: &mut Context<'_>, re: Regarding, why: &'static str) {
    ctx.note(MvcEventKind::Silence(SilenceEvent::Failed(why)));
    ctx.acknowledge(re, AckStatus::Failed, why);
}

//! The suspension of a hovering vehicle's mission (SPI 8.1 to 8.3).
//!
//! While it stands, the mission's own clock stands still: the time of the running behavior, of its element and of the
//! element's window of dynamic requests. The mission's time limit, and the 5 s of a modify, are the vehicle's clock
//! and go on. A modify is not taken meanwhile; inserts are, and are flown after it.

use core::time::Duration;

use backseat_units::{EastNorth, Timestamp};

use super::Executive;
use crate::estimate::Estimate;
use crate::event::{Behavior, ClientId, HoveringEvent, MvcEventKind, SuspensionEnd};
use crate::interpretation::ResumeFrom;
use crate::plan::Shape;
use crate::vehicle::Vertical;
use crate::vehicle::{Drive, HoverDemand};

/// A suspension lapses this long after the last BPSUS, BPCON, BPGHP or BPGBP (SPI 8.1).
pub(crate) const SUSPENSION_LASTS: Duration = Duration::from_secs(2);
/// A place that is not reached in this time is given up: the specification has no figure.
const RETURN_LASTS: Duration = Duration::from_secs(300);
/// So close to where the mission was suspended counts as there, metres.
const RETURNED_M: f64 = 0.5;
/// Speed asked for a metre of distance, per second.
const RETURN_GAIN_PER_S: f64 = 0.25;
/// The slowest return, metres a second: the behavior may be one that stands still.
const RETURN_MIN_MPS: f64 = 0.3;

#[derive(Clone, Copy, Debug)]
pub(super) struct Suspension {
    phase: Phase,
    /// Up to when the mission's clock has been stopped.
    since: Timestamp,
    /// What was running, and where.
    behavior: Behavior,
    at: EastNorth,
    depth_m: f64,
    heading_deg: f64,
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    /// The payload has the vehicle.
    Held {
        until: Timestamp,
        demand: Option<HoverDemand>,
    },
    /// The vehicle has itself again, and is on its way back.
    Returning { until: Timestamp },
}

impl Executive {
    /// BPSUS: whether the mission ran until now, or why it cannot be suspended.
    pub(crate) fn suspend(
        &mut self,
        now: Timestamp,
        client: ClientId,
        estimate: &Estimate,
    ) -> Result<bool, &'static str> {
        if self.keep_suspended(now) {
            return Ok(false);
        }
        let Some(running) = self.running.as_ref().filter(|_| self.is_running()) else {
            return Err("no mission is running");
        };
        if self.interpretation.suspend_needs_control && !self.control {
            return Err("dynamic requests are not allowed now");
        }
        let phase = Phase::Held {
            until: now + SUSPENSION_LASTS,
            demand: None,
        };
        match &mut self.suspension {
            // On its way back: the mission stands where it stood.
            Some(suspension) => suspension.phase = phase,
            None => {
                self.suspension = Some(Suspension {
                    phase,
                    since: now,
                    behavior: running.behavior,
                    at: estimate.at,
                    depth_m: estimate.depth_m,
                    heading_deg: estimate.heading_deg,
                });
            }
        }
        self.log.push(MvcEventKind::Hovering(HoveringEvent::Suspended(client)));
        Ok(true)
    }

    /// Starts the 2 s anew; false where nothing is suspended.
    pub(crate) fn keep_suspended(&mut self, now: Timestamp) -> bool {
        match self.suspension.as_mut().map(|suspension| &mut suspension.phase) {
            Some(Phase::Held { until, .. }) => {
                *until = now + SUSPENSION_LASTS;
                true
            }
            Some(Phase::Returning { .. }) | None => false,
        }
    }

    /// BPRES; false where nothing is suspended.
    pub(crate) fn resume_asked(&mut self, now: Timestamp) -> bool {
        let suspended = self.is_suspended();
        if suspended {
            self.resume(now, SuspensionEnd::Resumed);
        }
        suspended
    }

    pub(crate) fn is_suspended(&self) -> bool {
        self.suspended_until().is_some()
    }

    /// When the suspension lapses unless it is refreshed.
    pub(crate) fn suspended_until(&self) -> Option<Timestamp> {
        match self.suspension.as_ref()?.phase {
            Phase::Held { until, .. } => Some(until),
            Phase::Returning { .. } => None,
        }
    }

    /// What the payload has the vehicle do, where it has it.
    pub(crate) fn set_hover(&mut self, hover: HoverDemand) {
        if let Some(Suspension {
            phase: Phase::Held { demand, .. },
            ..
        }) = &mut self.suspension
        {
            *demand = Some(hover);
        }
    }

    pub(super) fn lapse_suspension(&mut self, now: Timestamp) {
        if self.suspended_until().is_some_and(|until| now >= until) {
            self.resume(now, SuspensionEnd::Lapsed);
        }
    }

    /// The drive while the mission's clock stands still.
    pub(super) fn fly_suspended(&mut self, now: Timestamp, estimate: &Estimate) -> Option<Drive> {
        let mission_now = self.suspension?.since;
        if !self.is_running() {
            self.end_suspension();
            return None;
        }
        // A command may have led to another element, whose window is another.
        self.update_control(mission_now, estimate.at);
        if self.interpretation.suspend_needs_control && !self.control && self.is_suspended() {
            self.resume(now, SuspensionEnd::ControlLost);
        }
        let suspension = self.suspension?;
        match suspension.phase {
            Phase::Held { demand, .. } => Some(Drive::Hover(demand.unwrap_or_else(|| suspension.stay(0.0)))),
            Phase::Returning { until } => {
                let reached = estimate.at.distance_m(suspension.at) < RETURNED_M
                    && (estimate.depth_m - suspension.depth_m).abs() < RETURNED_M;
                if reached || now >= until {
                    self.stop_mission_clock(now);
                    self.suspension = None;
                    self.log.push(MvcEventKind::Hovering(HoveringEvent::Returned(reached)));
                    return None;
                }
                let speed_mps = self.running.as_ref().map_or(0.0, |running| running.speed_mps);
                let way = (suspension.at - estimate.at) * RETURN_GAIN_PER_S;
                Some(Drive::Hover(HoverDemand {
                    ground: (way.east_m, way.north_m),
                    ..suspension.stay(speed_mps.max(RETURN_MIN_MPS))
                }))
            }
        }
    }

    /// Stops the clock of what runs up to now. Called also before something else begins to run under a suspension.
    pub(super) fn stop_mission_clock(&mut self, now: Timestamp) {
        let Some(suspension) = &mut self.suspension else { return };
        let pause = now.since(suspension.since);
        suspension.since = now;
        self.element_began = self.element_began + pause;
        if let Some(running) = &mut self.running {
            running.course.resume(pause);
            running.began = running.began + pause;
        }
    }

    /// The mission is over, and its suspension with it.
    pub(super) fn end_suspension(&mut self) {
        let suspended = self.is_suspended();
        self.suspension = None;
        if suspended {
            self.say_ended(SuspensionEnd::MissionOver);
        }
    }

    fn resume(&mut self, now: Timestamp, why: SuspensionEnd) {
        let Some(suspension) = self.suspension else { return };
        self.say_ended(why);
        if self.returns(&suspension) {
            self.log.push(MvcEventKind::Hovering(HoveringEvent::Returning));
            if let Some(suspension) = &mut self.suspension {
                suspension.phase = Phase::Returning {
                    until: now + RETURN_LASTS,
                };
            }
        } else {
            self.stop_mission_clock(now);
            self.suspension = None;
        }
    }

    /// Whether the vehicle first returns to where the mission was suspended: "depending on the behavior" (SPI 8.3). What
    /// has begun meanwhile has no such place.
    fn returns(&self, suspension: &Suspension) -> bool {
        let Some(running) = self
            .running
            .as_ref()
            .filter(|running| running.behavior == suspension.behavior)
        else {
            return false;
        };
        match self.interpretation.resume_from {
            ResumeFrom::SuspensionPoint => true,
            ResumeFrom::Here => false,
            ResumeFrom::Behavior => match running.course.shape() {
                Shape::Trackline { .. } | Shape::Trackcircle { .. } => true,
                Shape::Waypoint { .. }
                | Shape::Setpoint { .. }
                | Shape::GpsHit { .. }
                | Shape::Command
                | Shape::Idle => false,
            },
        }
    }

    fn say_ended(&mut self, why: SuspensionEnd) {
        self.log
            .push(MvcEventKind::Hovering(HoveringEvent::SuspensionEnded(why)));
    }
}

impl Suspension {
    /// Stopped, as deep and with the heading as it was.
    const fn stay(&self, speed_max_mps: f64) -> HoverDemand {
        HoverDemand {
            ground: (0.0, 0.0),
            vertical: Vertical::Depth(self.depth_m),
            heading_deg: self.heading_deg,
            speed_max_mps,
        }
    }
}

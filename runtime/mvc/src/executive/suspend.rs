//! The suspension of a hovering vehicle's mission (SPI 8.1 to 8.3).
//!
//! During a suspension, the mission's own clock stops: the time of the running behavior, of its element and of the
//! element's window for dynamic requests. The mission's time limit and the 5 s of a modify use the vehicle's clock,
//! which goes on. A modify is refused during a suspension. Inserts are accepted, and flown after it.

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
/// The vehicle gives up a return that takes longer than this. The specification has no figure.
const RETURN_LASTS: Duration = Duration::from_secs(300);
/// The vehicle has returned if it is closer than this to where the mission was suspended, metres.
const RETURNED_M: f64 = 0.5;
/// Demanded speed per metre of distance, per second.
const RETURN_GAIN_PER_S: f64 = 0.25;
/// The least speed of a return, metres a second, because the behavior itself may have speed 0.
const RETURN_MIN_MPS: f64 = 0.3;

#[derive(Clone, Copy, Debug)]
pub(super) struct Suspension {
    phase: Phase,
    /// The mission's clock has been set back for the time up to here.
    since: Timestamp,
    /// What was running, and where the vehicle was.
    behavior: Behavior,
    at: EastNorth,
    depth_m: f64,
    heading_deg: f64,
}

#[derive(Clone, Copy, Debug)]
enum Phase {
    /// The payload controls the vehicle.
    Held {
        until: Timestamp,
        demand: Option<HoverDemand>,
    },
    /// The vehicle controls itself again and is on its way back.
    Returning { until: Timestamp },
}

impl Executive {
    /// BPSUS: suspends the mission. Returns whether it was running until now, or why it cannot be suspended.
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
            // The vehicle is on its way back, so the place of the suspension stays the same.
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

    /// Starts the 2 s again. Returns false if nothing is suspended.
    pub(crate) fn keep_suspended(&mut self, now: Timestamp) -> bool {
        match self.suspension.as_mut().map(|suspension| &mut suspension.phase) {
            Some(Phase::Held { until, .. }) => {
                *until = now + SUSPENSION_LASTS;
                true
            }
            Some(Phase::Returning { .. }) | None => false,
        }
    }

    /// BPRES: resumes the mission. Returns false if nothing is suspended.
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

    /// Sets the payload's demand, if the payload controls the vehicle.
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

    /// The drive while the mission's clock is stopped; `None` if it is not.
    pub(super) fn fly_suspended(&mut self, now: Timestamp, estimate: &Estimate) -> Option<Drive> {
        let mission_now = self.suspension?.since;
        if !self.is_running() {
            self.end_suspension();
            return None;
        }
        // A command may have begun another element, which has another window.
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

    /// Sets the clock of the running behavior back by the time of the suspension up to now. It is also called before
    /// another behavior begins during a suspension.
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

    /// Ends a suspension because the mission is over.
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

    /// Whether the vehicle first returns to where the mission was suspended, "depending on the behavior" (SPI 8.3). A
    /// behavior that has begun during the suspension has no such place.
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
    /// A demand to stay at the depth and with the heading of the suspension.
    const fn stay(&self, speed_max_mps: f64) -> HoverDemand {
        HoverDemand {
            ground: (0.0, 0.0),
            vertical: Vertical::Depth(self.depth_m),
            heading_deg: self.heading_deg,
            speed_max_mps,
        }
    }
}

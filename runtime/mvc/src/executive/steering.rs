use backseat_units::Timestamp;
use backseat_units::math::sin;

use super::{Executive, Running};
use crate::estimate::Estimate;
use crate::event::mission::{MissionEvent, Told};
use crate::event::{EndReason, ModifyHorizontal, ModifySpeed, ModifyValues, ModifyVertical, MvcEventKind};
use crate::plan::course::{Steer, Way, crabbed_deg};
use crate::vehicle::Vertical;
use crate::vehicle::{Demand, Drive, Throttle, Turn};

/// The demands of the running behavior, and of a modify, on the vehicle.
impl Executive {
    /// Ends the behaviors that are at their end, and steers the first one that is not.
    pub(super) fn steer(&mut self, now: Timestamp, estimate: &Estimate) -> Option<Steer> {
        while self.is_running() {
            let running = self.running.as_mut()?;
            let steer = running
                .course
                .steer(estimate, running.speed_mps, &self.performance, now);
            if running.course.is_on_leg()
                && !running.logging
                && let Some(message) = &running.message
            {
                running.logging = true;
                let told = MissionEvent::told(message, Told::LoggingBegins);
                self.log.push(MvcEventKind::Executive(told));
            }
            let late = running.timeout.is_some_and(|timeout| now >= running.began + timeout);
            let Some(reason) = steer.end.or(late.then_some(EndReason::TimedOut)) else {
                return Some(steer);
            };
            if let Some(insert) = running.insert.as_ref().filter(|insert| insert.is_gps_hit()) {
                let fix = if reason == EndReason::Done {
                    MissionEvent::GpsFix(insert.id)
                } else {
                    MissionEvent::NoGpsFix(insert.id)
                };
                self.log.push(MvcEventKind::Executive(fix));
            }
            self.next(now, estimate.at, reason);
        }
        None
    }

    pub(super) fn drive(&self, steer: Option<Steer>, estimate: &Estimate, convergence_deg: f64) -> Drive {
        let (Some(running), Some(steer)) = (&self.running, steer) else {
            return Drive::Adrift;
        };
        let asked = self.modify.map_or(ModifyValues::NONE, |modify| modify.values);
        if steer.way == Way::Drift && asked == ModifyValues::NONE {
            return Drive::Adrift;
        }
        Drive::Under(Demand {
            turn: self.turn(&asked, &steer, estimate, convergence_deg),
            vertical: self.vertical(&asked, running, &steer, estimate),
            throttle: match asked.speed {
                None => Throttle::Speed(running.speed_mps),
                Some(ModifySpeed::MetresPerSecond(mps)) => Throttle::Speed(mps),
                Some(ModifySpeed::Rpm(rpm)) => Throttle::Rpm(rpm),
            },
        })
    }

    fn turn(&self, asked: &ModifyValues, steer: &Steer, estimate: &Estimate, convergence_deg: f64) -> Turn {
        let own_deg = match steer.way {
            Way::Course(bearing_deg) => crabbed_deg(bearing_deg, estimate.surge_mps, estimate.current),
            Way::Heading(true_deg) => true_deg - convergence_deg,
            Way::Climb(heading_deg) => heading_deg,
            Way::Drift => estimate.heading_deg,
        };
        match asked.horizontal {
            None => Turn::Heading(own_deg),
            Some(ModifyHorizontal::Heading(true_deg)) => Turn::Heading(true_deg - convergence_deg),
            // Adding a turn to the one that the heading error demands is the same as shifting the heading by that turn
            // over the gain.
            Some(ModifyHorizontal::Rudder(deg)) if self.interpretation.fins_change => {
                Turn::Heading(own_deg + self.performance.rudder_dps(deg) / self.performance.yaw_gain_per_s)
            }
            Some(ModifyHorizontal::Rudder(deg)) => Turn::Rudder(deg),
        }
    }

    fn vertical(&self, asked: &ModifyValues, running: &Running, steer: &Steer, estimate: &Estimate) -> Vertical {
        let own = match steer.way {
            Way::Course(_) | Way::Heading(_) => running.vertical,
            Way::Climb(_) | Way::Drift => Vertical::Depth(0.0),
        };
        match asked.vertical {
            None => own,
            Some(ModifyVertical::Depth(depth)) => Vertical::Depth(depth),
            Some(ModifyVertical::Altitude(altitude)) => Vertical::Altitude(altitude),
            Some(ModifyVertical::Pitch(pitch)) => Vertical::Pitch(pitch),
            // As with the rudder: adding a climb to the one that the depth error demands is the same as shifting the
            // depth.
            Some(ModifyVertical::Elevator(deg)) if self.interpretation.fins_change => {
                let pitch_deg = self.performance.elevator_pitch_deg(deg);
                let rise_m = estimate.surge_mps * sin(pitch_deg.to_radians()) / self.performance.depth_gain_per_s;
                match own {
                    Vertical::Depth(depth) => Vertical::Depth(depth - rise_m),
                    Vertical::Altitude(altitude) => Vertical::Altitude(altitude + rise_m),
                    Vertical::Pitch(pitch) => Vertical::Pitch(pitch + pitch_deg),
                    Vertical::Elevator(own_deg) => Vertical::Elevator(own_deg + deg),
                }
            }
            Some(ModifyVertical::Elevator(deg)) => Vertical::Elevator(deg),
        }
    }
}

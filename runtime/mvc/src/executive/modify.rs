use core::time::Duration;

use backseat_spi::{HorizontalMode, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode, Text};
use backseat_units::Timestamp;
use backseat_units::math::wrap_360;

use super::Executive;
use super::clipping::clipped;
use crate::event::{ClientId, ModifyEnd, ModifyHorizontal, ModifySpeed, ModifyValues, ModifyVertical, MvcEventKind};
use crate::interpretation::EmptyMode;
use crate::vehicle::Vertical;
use crate::vehicle::performance::Performance;

/// A modify lapses this long after the last BPRMB (SPI 7.12).
const MODIFY_LASTS: Duration = Duration::from_secs(5);

/// The active modify (SPI 7.12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Modify {
    client: ClientId,
    pub(super) values: ModifyValues,
    /// When it lapses unless it is refreshed.
    until: Timestamp,
}

impl Executive {
    /// In what the current behavior counts its depth and its speed.
    pub(super) fn counted(&self) -> Counted {
        self.running.as_ref().map_or_else(Counted::default, |running| Counted {
            by_altitude: matches!(running.vertical, Vertical::Altitude(_)),
            by_rpm: running.insert.is_some_and(|insert| insert.by_rpm),
        })
    }

    /// Accepts a modify (SPI 7.12) and returns what the vehicle clips of it, or returns why not. The log gets one line
    /// for all repetitions of a refused one.
    pub(crate) fn modify(
        &mut self,
        now: Timestamp,
        client: ClientId,
        values: ModifyValues,
        water_depth_m: f64,
    ) -> Result<String, &'static str> {
        let refused = match self.accept_modify(now, client, values, water_depth_m) {
            Ok(clipped) => {
                self.modify_refused = None;
                return Ok(clipped);
            }
            Err(why) => (client, why),
        };
        if self.modify_refused != Some(refused) {
            self.modify_refused = Some(refused);
            self.log.push(MvcEventKind::ModifyRefused(client, refused.1));
        }
        Err(refused.1)
    }

    fn accept_modify(
        &mut self,
        now: Timestamp,
        client: ClientId,
        values: ModifyValues,
        water_depth_m: f64,
    ) -> Result<String, &'static str> {
        if !self.control {
            return Err("dynamic requests are not allowed now");
        }
        if self.is_suspended() {
            return Err("the mission is suspended");
        }
        if self.modify_barred {
            return Err("this behavior has been modified for too long or too far");
        }
        if self.interpretation.modify_beyond_refused
            && let Some(why) = beyond(&values, &self.performance, self.altitude_min_m)
        {
            return Err(why);
        }
        let clipped = clipped(&values, &self.performance, self.altitude_min_m, water_depth_m);
        if self
            .modify
            .is_none_or(|modify| modify.values != values || modify.client != client)
        {
            let clipped = Text::cleaned(&clipped);
            self.log.push(MvcEventKind::Modify {
                client,
                values,
                clipped,
            });
        }
        self.modify = Some(Modify {
            client,
            values,
            until: now + MODIFY_LASTS,
        });
        Ok(clipped)
    }

    /// BPEMB: ends the modify. Returns whether there was one.
    pub(crate) fn end_modify_asked(&mut self) -> bool {
        let active = self.modify.is_some();
        self.end_modify(ModifyEnd::Ended);
        active
    }

    pub(super) fn modify_beyond_limits(&mut self, off_line_m: f64) -> bool {
        if self.modify.is_none() {
            return false;
        }
        self.modified += self.limits.tick;
        self.limits.modify_total.is_some_and(|limit| self.modified > limit)
            || self.limits.modify_deviation_m.is_some_and(|limit| off_line_m > limit)
    }

    /// When the modify lapses unless it is refreshed.
    fn modify_until(&self) -> Option<Timestamp> {
        self.modify.map(|modify| modify.until)
    }

    /// When the modify or the suspension lapses, whichever is first, unless it is refreshed.
    pub(crate) fn lapses_at(&self) -> Option<Timestamp> {
        self.modify_until().into_iter().chain(self.suspended_until()).min()
    }

    /// Ends a modify and a suspension that have lapsed.
    pub(crate) fn lapse(&mut self, now: Timestamp) {
        self.lapse_suspension(now);
        if self.modify_until().is_some_and(|until| now >= until) {
            self.end_modify(ModifyEnd::Lapsed);
        }
    }

    pub(super) fn end_modify(&mut self, why: ModifyEnd) {
        if self.modify.take().is_some() {
            self.log.push(MvcEventKind::ModifyEnded(why));
        }
    }
}

/// In what the current behavior counts its depth and its speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counted {
    by_altitude: bool,
    by_rpm: bool,
}

/// How [`read`] understands BPRMB.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Added to the heading, so that the result counts from true north.
    pub(super) grid_convergence_deg: f64,
    pub(super) empty_mode: EmptyMode,
    pub(super) current: Counted,
}

/// Reads BPRMB. An error is a text that names the field with the invalid value.
///
/// An empty horizontal mode means a heading, because every behavior has one. What an empty mode of the other two values
/// means is a setting.
pub(super) fn read(request: &ModifyBehavior, reading: &Reading) -> Result<ModifyValues, String> {
    let horizontal = match (request.horizontal, request.horizontal_mode) {
        (None, _) => None,
        (Some(deg), None | Some(HorizontalMode::Heading)) if deg.abs() <= 720.0 => {
            Some(ModifyHorizontal::Heading(wrap_360(deg + reading.grid_convergence_deg)))
        }
        (Some(deg), None | Some(HorizontalMode::Heading)) => {
            return Err(format!("horizontal {deg}: expected a heading in degrees"));
        }
        (Some(deg), Some(HorizontalMode::Rudder)) => Some(ModifyHorizontal::Rudder(deg)),
        (Some(_), Some(HorizontalMode::Other(code))) => {
            return Err(format!("horizontal_mode {code}: expected 0 or 1"));
        }
    };
    let vertical_mode = match (request.vertical_mode, reading.empty_mode) {
        (Some(mode), _) => Some(mode),
        (None, EmptyMode::Behavior) if reading.current.by_altitude => Some(ModifyVerticalMode::Altitude),
        (None, EmptyMode::Behavior | EmptyMode::Zero) => Some(ModifyVerticalMode::Depth),
        (None, EmptyMode::Refused) => None,
    };
    let vertical = match (request.vertical_m, vertical_mode) {
        (None, _) => None,
        (Some(_), None) => return Err("vertical_mode: required with a depth or altitude".to_owned()),
        (Some(depth), Some(ModifyVerticalMode::Depth)) => Some(ModifyVertical::Depth(depth)),
        (Some(altitude), Some(ModifyVerticalMode::Altitude)) => Some(ModifyVertical::Altitude(altitude)),
        (Some(pitch), Some(ModifyVerticalMode::Pitch)) => Some(ModifyVertical::Pitch(pitch)),
        (Some(deg), Some(ModifyVerticalMode::Elevator)) => Some(ModifyVertical::Elevator(deg)),
        (Some(_), Some(ModifyVerticalMode::Other(code))) => {
            return Err(format!("vertical_mode {code}: expected 0 to 3"));
        }
    };
    let speed_mode = match (request.speed_mode, reading.empty_mode) {
        (Some(mode), _) => Some(mode),
        (None, EmptyMode::Behavior) if !reading.current.by_rpm => Some(ModifySpeedMode::MetresPerSecond),
        (None, EmptyMode::Behavior | EmptyMode::Zero) => Some(ModifySpeedMode::Rpm),
        (None, EmptyMode::Refused) => None,
    };
    let speed = match (request.speed, speed_mode) {
        (None, _) => None,
        (Some(_), None) => return Err("speed_mode: required with a speed".to_owned()),
        (Some(rpm), Some(ModifySpeedMode::Rpm)) => Some(ModifySpeed::Rpm(rpm)),
        (Some(mps), Some(ModifySpeedMode::MetresPerSecond)) => Some(ModifySpeed::MetresPerSecond(mps)),
        (Some(_), Some(ModifySpeedMode::Other(code))) => {
            return Err(format!("speed_mode {code}: expected 0 or 1"));
        }
    };
    Ok(ModifyValues {
        horizontal,
        vertical,
        speed,
    })
}

/// A text that names the value beyond the vehicle's safe operating parameters (SPI 7.12), if one is.
fn beyond(values: &ModifyValues, performance: &Performance, altitude_min_m: f64) -> Option<&'static str> {
    match values.horizontal {
        Some(ModifyHorizontal::Rudder(deg)) if deg.abs() > performance.fin_max_deg => {
            return Some("the rudder is beyond the safe limits of the vehicle");
        }
        Some(ModifyHorizontal::Rudder(_) | ModifyHorizontal::Heading(_)) | None => {}
    }
    let safe = match values.vertical {
        None => true,
        Some(ModifyVertical::Depth(metres)) => (0.0..=performance.depth_max_m).contains(&metres),
        Some(ModifyVertical::Altitude(metres)) => (altitude_min_m..=1000.0).contains(&metres),
        Some(ModifyVertical::Pitch(deg)) => deg.abs() <= performance.pitch_max_deg,
        Some(ModifyVertical::Elevator(deg)) => deg.abs() <= performance.fin_max_deg,
    };
    if !safe {
        return Some("depth or altitude or pitch or elevator is beyond the safe limits of the vehicle");
    }
    let speed_mps = values.speed.map(|speed| match speed {
        ModifySpeed::MetresPerSecond(mps) => mps,
        ModifySpeed::Rpm(rpm) => performance.speed_mps(rpm),
    });
    // A speed of 0 is safe: the thruster stops, and the vehicle floats up. Silent mode, trim and buoyancy need it (SPI
    // 7.22 to 7.24).
    speed_mps
        .is_some_and(|mps| mps != 0.0 && !(performance.speed_min_mps..=performance.speed_max_mps).contains(&mps))
        .then_some("the speed is beyond the safe limits of the vehicle")
}

use libm::sincos;

use crate::area::Area;
use crate::earth::wrap_180;
use crate::plane::{Plane, Vector};
use crate::surroundings::Survey;
use crate::wire::{Fix, Modify, Setpoint};
use crate::zone::Kind;

/// How long a vehicle certainly continues after a BPRMB, seconds: the 5 s of SPI 7.12, less what delays may take.
const CERTAIN_S: f64 = 4.5;
const STEPS: u32 = 6;
/// The two norths from which a heading may count differ by less than this, degrees.
const NORTH_DEG: f64 = 4.0;
/// Every vehicle turns faster than this, degrees a second.
const TURN_MIN_DPS: f64 = 3.0;
/// How much two frames, the decimals of the sentences and a moment of noise can take from a margin, metres.
const MARGIN_SLACK_M: f64 = 1.0;

/// Where a modify certainly leads.
#[derive(Clone, Debug, Default)]
pub(crate) struct Consequence {
    survey: Survey,
}

impl Consequence {
    /// Describes how a BPRMB takes the vehicle out of the fence, for every north from which its heading may count and
    /// every rate of turn: straight on from the reported position, until the vehicle would forget the modify, and
    /// without any margin. `None` if it does not.
    pub(crate) fn judge(&mut self, modify: &Modify, fix: &Fix, area: &Area) -> Option<String> {
        let (heading_deg, speed_mps) = modify.heading_deg.zip(modify.speed_mps)?;
        let way_m = way_m(speed_mps);
        let from = area.point(fix.position);
        self.survey.at(from, area);
        let surroundings = self.survey.surroundings();
        let depths_m = depths(modify, fix);
        if self.survey.spare_m() > way_m + 1.0 {
            return is_out(&surroundings.zones, &depths_m, area).then(|| "the vehicle is outside already".to_owned());
        }
        let plane = Plane::at(from);
        let mut zones = Vec::new();
        let all = ways(heading_deg, fix.heading_deg, way_m).all(|mut way| {
            way.any(|place| {
                area.holding(plane.point(place), &mut zones);
                is_out(&zones, &depths_m, area)
            })
        });
        all.then(|| format!("within {way_m:.1} m on heading {heading_deg} at {speed_mps} m/s"))
    }

    /// Describes how a BPRMB takes the vehicle into a margin, or finds it there, by the same ways. `None` if it does
    /// not from one of the fixes, because the runtime may have judged by any of them.
    pub(crate) fn judge_margin(&mut self, modify: &Modify, fixes: [&Fix; 2], area: &Area) -> Option<String> {
        let (heading_deg, speed_mps) = modify.heading_deg.zip(modify.speed_mps)?;
        let way_m = way_m(speed_mps);
        self.survey.at(area.point(fixes[0].position), area);
        let far = self.survey.spare_m() > way_m + area.margin_max_m();
        if far && !self.survey.surroundings().zones.is_empty() {
            return None;
        }
        let mut name = None;
        let all = fixes.iter().all(|fix| {
            let plane = Plane::at(area.point(fix.position));
            let depths_m = depths(modify, fix);
            let mut broken = |place: Vector| {
                let zone = area.margin_broken(&plane, place, &depths_m, MARGIN_SLACK_M)?;
                name = Some(&zone.name);
                Some(())
            };
            // The begin and the end of each way are enough: a straight way between two places that keep a margin cannot
            // break it by much.
            ways(heading_deg, fix.heading_deg, way_m).all(|way| {
                let end = way.last().unwrap_or_default();
                broken([0.0, 0.0]).or_else(|| broken(end)).is_some()
            })
        });
        name.filter(|_| all).map(|name| {
            format!("within {way_m:.1} m on heading {heading_deg} at {speed_mps} m/s, in the margin of zone {name}")
        })
    }
}

/// How far a vehicle certainly goes, metres.
fn way_m(speed_mps: f64) -> f64 {
    CERTAIN_S * speed_mps.clamp(0.0, 10.0)
}

/// The depths that the vehicle has or goes to; none if the modify has no setpoint of depth.
fn depths(modify: &Modify, fix: &Fix) -> Vec<f64> {
    match modify.vertical {
        Some(Setpoint::Depth(depth_m)) => vec![depth_m, fix.depth_m],
        Some(Setpoint::Altitude(_)) | None => Vec::new(),
    }
}

/// The ways to a heading, for every north from which it may count and every rate of turn.
fn ways(to_deg: f64, from_deg: f64, way_m: f64) -> impl Iterator<Item = impl Iterator<Item = Vector>> {
    let norths = [0.0, -NORTH_DEG, NORTH_DEG].into_iter();
    norths.flat_map(move |north_deg| [false, true].map(|turns| way(to_deg + north_deg, from_deg, turns, way_m)))
}

/// Points of the way to a heading, onto which the vehicle turns at once, or as slowly as a vehicle can.
fn way(to_deg: f64, from_deg: f64, turns: bool, way_m: f64) -> impl Iterator<Item = Vector> {
    let left_deg = wrap_180(to_deg - from_deg);
    let mut place = [0.0, 0.0];
    (0..=STEPS).map(move |step| {
        if step > 0 {
            let turned_deg = TURN_MIN_DPS * CERTAIN_S * f64::from(step) / f64::from(STEPS);
            let heading_deg = if turns && left_deg.abs() > turned_deg {
                from_deg + turned_deg * left_deg.signum()
            } else {
                to_deg
            };
            let (sin, cos) = sincos(heading_deg.to_radians());
            let step_m = way_m / f64::from(STEPS);
            place = [place[0] + sin * step_m, place[1] + cos * step_m];
        }
        place
    })
}

/// Whether a place in these zones is outside the fence: in no keep-in zone, or in a keep-out zone that holds at its
/// depths.
fn is_out(zones: &[usize], depths_m: &[f64], area: &Area) -> bool {
    let mut inside = false;
    for zone in zones.iter().filter_map(|index| area.zone(*index)) {
        match zone.kind {
            Kind::KeepIn => inside = true,
            Kind::KeepOut if zone.surely_holds(depths_m) => return true,
            Kind::KeepOut => {}
        }
    }
    !inside
}

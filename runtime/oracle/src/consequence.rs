use backseat_spi::{HorizontalMode, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode};
use backseat_units::math::{sin_cos, wrap_180};

use crate::area::Area;
use crate::navigation::Fix;
use crate::plane::{Plane, Vector};
use crate::surroundings::Survey;
use crate::zone::Kind;

/// How long a vehicle goes on after a BPRMB for sure, seconds: the 5 s of SPI 7.12, less what delays may take.
const CERTAIN_S: f64 = 4.5;
const STEPS: u32 = 6;
/// The two norths that a heading may count from differ by less, degrees.
const NORTH_DEG: f64 = 4.0;
/// Any vehicle turns faster than this, degrees a second.
const TURN_MIN_DPS: f64 = 3.0;
/// A setpoint or a depth so near to the end of a band may be beyond it, metres.
const BAND_SLACK_M: f64 = 1.0;

/// What a modify certainly leads to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Consequence {
    survey: Survey,
}

impl Consequence {
    /// Where a BPRMB takes the vehicle out of the fence, whatever north its heading counts from and however fast the
    /// vehicle turns: straight on from where it said that it is, until it would forget the modify, without any margin.
    pub(crate) fn judge(&mut self, modify: &ModifyBehavior, fix: &Fix, area: &Area) -> Option<String> {
        let (Some(HorizontalMode::Heading), Some(heading_deg)) = (modify.horizontal_mode, modify.horizontal) else {
            return None;
        };
        let (Some(ModifySpeedMode::MetresPerSecond), Some(speed_mps)) = (modify.speed_mode, modify.speed) else {
            return None;
        };
        let depths = match (modify.vertical_mode, modify.vertical_m) {
            (Some(ModifyVerticalMode::Depth), Some(depth_m)) => Some([depth_m, fix.depth_m]),
            (Some(_) | None, Some(_) | None) => None,
        };
        let way_m = CERTAIN_S * speed_mps.clamp(0.0, 10.0);
        let from = area.point_deg(fix.latitude_deg, fix.longitude_deg);
        self.survey.at(from, area);
        let surroundings = self.survey.surroundings();
        if self.survey.spare_m() > way_m + 1.0 {
            return is_out(&surroundings.zones, depths, area).then(|| "it is there already".to_owned());
        }
        let plane = Plane::at(from);
        let mut zones = Vec::new();
        let mut leaves = |place: Vector| {
            area.holding(plane.point(place), &mut zones);
            is_out(&zones, depths, area)
        };
        let mut all = true;
        for turns in [false, true] {
            for north_deg in [-NORTH_DEG, 0.0, NORTH_DEG] {
                all &= way(heading_deg + north_deg, fix.heading_deg, turns, way_m).any(&mut leaves);
            }
        }
        all.then(|| format!("{way_m:.1} m on with heading {heading_deg} at {speed_mps} m/s"))
    }
}

/// Points of the way to a heading: turned to at once, or as slowly as a vehicle can.
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
            let (sin, cos) = sin_cos(heading_deg.to_radians());
            let step_m = way_m / f64::from(STEPS);
            place = [place[0] + sin * step_m, place[1] + cos * step_m];
        }
        place
    })
}

/// Whether a place in these zones is out of the fence: in no inclusion, or in an exclusion that holds at its depth.
fn is_out(zones: &[usize], depths: Option<[f64; 2]>, area: &Area) -> bool {
    let mut inside = false;
    for zone in zones.iter().filter_map(|index| area.zone(*index)) {
        match zone.kind {
            Kind::Inclusion => inside = true,
            Kind::Exclusion => {
                let band = zone.depth_min_m + BAND_SLACK_M..=zone.depth_max_m - BAND_SLACK_M;
                let holds = match depths {
                    Some(depths) => depths.iter().all(|depth_m| band.contains(depth_m)),
                    None => zone.depth_min_m == f64::NEG_INFINITY && zone.depth_max_m == f64::INFINITY,
                };
                if holds && !zone.timed {
                    return true;
                }
            }
        }
    }
    !inside
}

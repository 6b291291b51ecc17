//! `[expect.contacts]`: around which targets trackcircles were sent, around what else, and from how many sides the
//! vehicle saw the targets. The truth is the world's. This code shares nothing with the tools of plugins.

use backseat_mvc::{ContactsExpectation, Mvc};
use backseat_spi::ToVehicle;
use backseat_units::EastNorth;
use backseat_units::math::sin_cos;
use backseat_world::{Target, World};

use crate::report::Report;
use crate::trace::{Sounding, Steering, Trace};

/// The sectors around a target. The middle of the first one is north, so that what is abeam of a line to the north, east,
/// south or west is in one sector.
const SECTORS: usize = 8;
/// A target is abeam if its middle is this near to the plane across the vehicle, metres: half of the way between two
/// pings of the trace. Half of the target's length is added.
const ABEAM_M: f64 = 0.8;
/// Half of the gap below the vehicle in altitudes: that of a beam 55 degrees wide which points 30 degrees down.
const GAP: f64 = 0.64;
/// Trackcircles nearer to each other than this are the same, sent again, metres.
const SAME_M: f64 = 1.0;

pub(super) fn judge(report: &mut Report, expect: &ContactsExpectation, trace: &Trace, mvc: &Mvc) {
    let world = mvc.world();
    let counts = |target: &&Target| expect.kinds.contains(target.kind) && target.height_m >= expect.height_min_m;
    let targets: Vec<&Target> = world.targets().iter().filter(counts).collect();
    let centres = centres(trace, mvc);
    let off_m = |target: &Target| {
        centres
            .iter()
            .map(|centre| centre.distance_m(target.at))
            .fold(f64::INFINITY, f64::min)
    };
    let mut errors_m: Vec<f64> = targets
        .iter()
        .map(|target| off_m(target))
        .filter(|off_m| *off_m <= expect.within_m)
        .collect();
    let found = errors_m.len();
    let is_false = |centre: &&EastNorth| {
        targets
            .iter()
            .all(|target| target.at.distance_m(**centre) > expect.within_m)
    };
    let wrong = centres.iter().filter(is_false).count();
    let mut aspects: Vec<f64> = targets
        .iter()
        .map(|target| aspects(target, &trace.soundings, world) as f64)
        .collect();
    let measures = &mut report.measures;
    measures.insert("contacts_targets", targets.len() as f64);
    measures.insert("contacts_found", found as f64);
    measures.insert("contacts_circles", centres.len() as f64);
    measures.insert("contacts_false", wrong as f64);
    measures.insert("contacts_way_m", way_m(trace));
    let aspects = median(&mut aspects);
    if let Some(aspects) = aspects {
        measures.insert("contacts_aspects", aspects);
    }
    if let Some(error_m) = median(&mut errors_m) {
        measures.insert("contacts_error_m", error_m);
    }
    if (found as f64) < expect.found_min * targets.len() as f64 - 1e-9 {
        report.unmet.push(format!(
            "{found} of {} targets have a trackcircle, expected at least {:.0} %",
            targets.len(),
            100.0 * expect.found_min
        ));
    }
    if let Some(most) = expect.false_max
        && wrong > most as usize
    {
        report
            .unmet
            .push(format!("{wrong} trackcircles have no target, expected at most {most}"));
    }
    if let Some(least) = expect.aspects_min
        && aspects.is_none_or(|aspects| aspects < least)
    {
        report.unmet.push(format!(
            "half of the targets were seen from {} sectors or fewer, expected at least {least}",
            aspects.unwrap_or(0.0)
        ));
    }
}

/// The centres of the trackcircles that were sent; one that was sent again counts once.
fn centres(trace: &Trace, mvc: &Mvc) -> Vec<EastNorth> {
    let mut centres: Vec<EastNorth> = Vec::new();
    for insert in &trace.inserts {
        if let ToVehicle::Trackcircle(circle) = insert {
            let centre = mvc.frame().to_local(circle.centre);
            if centres.iter().all(|other| other.distance_m(centre) > SAME_M) {
                centres.push(centre);
            }
        }
    }
    centres
}

/// From how many sectors around it the vehicle has seen a target.
fn aspects(target: &Target, soundings: &[Sounding], world: &World) -> usize {
    let mut seen = [false; SECTORS];
    for sounding in soundings {
        let to = target.at - sounding.local;
        let ground_m = target.at.distance_m(sounding.local);
        if ground_m > sounding.range_m {
            continue;
        }
        let (sin, cos) = sin_cos(sounding.heading_deg.to_radians());
        let ahead_m = to.east_m * sin + to.north_m * cos;
        let altitude_m = world.water_depth_at_m(sounding.local, sounding.at) - sounding.depth_m;
        let is_abeam = ahead_m.abs() <= ABEAM_M + 0.5 * target.length_m;
        let is_reached = ground_m * ground_m + altitude_m * altitude_m <= sounding.range_m * sounding.range_m;
        if is_abeam && is_reached && ground_m >= GAP * altitude_m {
            let sectors = target.at.bearing_deg(sounding.local) / 360.0 * SECTORS as f64;
            seen[(sectors + 0.5) as usize % SECTORS] = true;
        }
    }
    seen.iter().filter(|seen| **seen).count()
}

/// The true way while the vehicle flew its plan or what plugins asked for, metres.
fn way_m(trace: &Trace) -> f64 {
    trace
        .samples
        .windows(2)
        .filter(|pair| pair.iter().all(|sample| sample.steering != Steering::Nobody))
        .map(|pair| pair[0].local.distance_m(pair[1].local))
        .sum()
}

/// The lower one of two middles.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use backseat_plc::SensorKind;
    use backseat_units::Timestamp;
    use backseat_world::WorldConfig;

    use super::*;

    fn world() -> World {
        let config: WorldConfig = toml::from_str(
            "[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.6\n\
            [seabed]\ndepth_m = 40\nslope = 0\nmeanders = 0\nmeander_slope = 0\n\
            [[targets]]\nkind = \"box\"\neast_m = 0\nnorth_m = 0\nlength_m = 2\nwidth_m = 1\nheight_m = 1",
        )
        .unwrap();
        World::new(&config, 1).unwrap()
    }

    fn sounding(second: u32, local: EastNorth, heading_deg: f64) -> Sounding {
        Sounding {
            at: Timestamp::from_secs(u64::from(second)),
            sensor: SensorKind::SidescanHigh,
            range_m: 50.0,
            local,
            depth_m: 30.0,
            heading_deg,
        }
    }

    /// A line to the north, so far to the east of the target.
    fn line(east_m: f64) -> Vec<Sounding> {
        (0..200)
            .map(|second| sounding(second, EastNorth::new(east_m, -150.0 + 1.5 * f64::from(second)), 0.0))
            .collect()
    }

    #[test]
    fn a_line_sees_a_target_from_one_side_and_a_circle_from_all() {
        let world = world();
        let target = &world.targets()[0];
        assert_eq!(aspects(target, &line(-30.0), &world), 1);
        assert_eq!(aspects(target, &line(30.0), &world), 1);
        let both: Vec<Sounding> = line(30.0).into_iter().chain(line(-30.0)).collect();
        assert_eq!(aspects(target, &both, &world), 2);
        assert_eq!(aspects(target, &line(3.0), &world), 0, "it is below the vehicle");
        assert_eq!(
            aspects(target, &line(49.5), &world),
            0,
            "it is out of range along the slant"
        );
        let circle: Vec<Sounding> = (0..100)
            .map(|second| {
                let bearing_deg = 3.6 * f64::from(second);
                sounding(second, target.at.offset(bearing_deg, 25.0), bearing_deg + 90.0)
            })
            .collect();
        assert_eq!(aspects(target, &circle, &world), SECTORS);
        let inwards: Vec<Sounding> = circle
            .iter()
            .map(|sounding| Sounding {
                heading_deg: sounding.heading_deg + 60.0,
                ..*sounding
            })
            .collect();
        assert_eq!(aspects(target, &inwards, &world), 0, "its beams look past the target");
    }

    #[test]
    fn the_median_of_nothing_is_none() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0]), Some(1.0));
    }
}

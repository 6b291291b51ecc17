//! The `[expect]` section of `world.toml`, compared with the mock's true state.

mod contacts;
mod coverage;

use backseat_mvc::{ContourExpectation, Expectations, MaximumExpectation, MeasureExpectation, Mvc};
use backseat_spi::ToVehicle;
use backseat_units::EastNorth;
use backseat_world::World;

use crate::report::Report;
use crate::trace::{Steering, Trace};

pub(crate) fn judge(report: &mut Report, expect: &Expectations, trace: &Trace, mvc: &Mvc) {
    let most = expect.max_violations.unwrap_or(0) as usize;
    if report.violations.len() > most {
        report.unmet.push(format!(
            "{} violations, expected at most {most}",
            report.violations.len()
        ));
    }
    if report.requests_open > 0 {
        report
            .unmet
            .push(format!("{} requests have not ended", report.requests_open));
    }
    if let Some(least) = expect.min_accepted
        && report.requests.accepted < u64::from(least)
    {
        report.unmet.push(format!(
            "{} requests accepted, expected at least {least}",
            report.requests.accepted
        ));
    }
    if let Some(completed) = expect.mission_completed
        && (report.outcome == "completed") != completed
    {
        report
            .unmet
            .push(format!("the mission's outcome is {}", report.outcome));
    }
    if let Some(contour) = &expect.contour {
        judge_contour(report, contour, trace, mvc.world());
    }
    if let Some(maximum) = &expect.maximum {
        judge_maximum(report, maximum, trace, mvc);
    }
    if let Some(area) = &expect.coverage {
        coverage::judge(report, area, trace, mvc.world());
    }
    if let Some(contacts) = &expect.contacts {
        contacts::judge(report, contacts, trace, mvc);
    }
    // Last, because these may name what the others have measured.
    for measure in &expect.measure {
        judge_measure(report, measure);
    }
}

fn judge_measure(report: &mut Report, expect: &MeasureExpectation) {
    let name = &expect.name;
    let measured = report.measures.get::<str>(name).map(|value| (*value, ""));
    let published = report.published.get(name).map(|last| (last.value, last.unit.as_str()));
    let Some((value, unit)) = measured.or(published) else {
        report.unmet.push(format!("{name} was not measured"));
        return;
    };
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let low = expect
        .at_least
        .filter(|bound| value < *bound)
        .map(|bound| ("least", bound));
    let high = expect
        .at_most
        .filter(|bound| value > *bound)
        .map(|bound| ("most", bound));
    for (which, bound) in low.into_iter().chain(high) {
        report
            .unmet
            .push(format!("{name} is {value:.3}{unit}, expected at {which} {bound}{unit}"));
    }
}

/// Measures the horizontal distance from the vehicle's true position, while a plugin steered it, to the true contour.
fn judge_contour(report: &mut Report, expect: &ContourExpectation, trace: &Trace, world: &World) {
    let mut steered_from = None;
    let mut acquired = None;
    let (mut squares, mut count) = (0.0, 0u32);
    for sample in trace
        .samples
        .iter()
        .filter(|sample| sample.steering == Steering::Modify)
    {
        let at_s = sample.at.as_secs_f64();
        let from_s = *steered_from.get_or_insert(at_s);
        let error_m = contour_distance_m(world, sample.local, expect.water_depth_m);
        if acquired.is_none() && error_m < expect.acquired_m {
            acquired = Some(at_s - from_s);
        }
        if acquired.is_some() {
            squares += error_m * error_m;
            count += 1;
        }
    }
    match acquired {
        None => report
            .unmet
            .push(format!("the {} m contour was never acquired", expect.water_depth_m)),
        Some(after_s) => {
            let rms_m = (squares / f64::from(count)).sqrt();
            report.measures.insert("contour_acquired_s", after_s);
            report.measures.insert("contour_rms_m", rms_m);
            report.measures.insert("contour_followed_s", f64::from(count));
            if after_s > expect.acquired_within_s {
                report.unmet.push(format!(
                    "the contour was acquired after {after_s:.0} s, expected within {} s",
                    expect.acquired_within_s
                ));
            }
            if rms_m > expect.rms_m {
                report.unmet.push(format!(
                    "{rms_m:.1} m RMS from the contour, expected at most {} m",
                    expect.rms_m
                ));
            }
            if f64::from(count) < expect.followed_for_s {
                report.unmet.push(format!(
                    "the contour was followed for {count} s, expected at least {} s",
                    expect.followed_for_s
                ));
            }
        }
    }
}

/// The distance to the contour: Newton's method along the gradient finds a point on the contour, and the distance is
/// from there.
fn contour_distance_m(world: &World, from: EastNorth, water_depth_m: f64) -> f64 {
    let mut at = from;
    for _ in 0..20 {
        let gradient = world.gradient(at);
        let steepness = gradient.east_m * gradient.east_m + gradient.north_m * gradient.north_m;
        let off_m = world.water_depth_m(at) - water_depth_m;
        if off_m.abs() < 1e-6 || steepness < 1e-12 {
            break;
        }
        at = at - gradient * (off_m / steepness);
    }
    from.distance_m(at)
}

/// Measures the distance from the centre of the last trackcircle that was sent to the field's true maximum.
fn judge_maximum(report: &mut Report, expect: &MaximumExpectation, trace: &Trace, mvc: &Mvc) {
    let Some(truth) = mvc.world().field_maximum() else {
        report.unmet.push("the world has no field with a maximum".to_owned());
        return;
    };
    let centre = trace.inserts.iter().rev().find_map(|insert| {
        if let ToVehicle::Trackcircle(circle) = insert {
            Some(circle.centre)
        } else {
            None
        }
    });
    let Some(centre) = centre else {
        report.unmet.push("no circle was sent".to_owned());
        return;
    };
    let error_m = mvc.frame().to_local(centre).distance_m(truth);
    report.measures.insert("maximum_error_m", error_m);
    if error_m > expect.within_m {
        report.unmet.push(format!(
            "the circle's centre is {error_m:.1} m from the maximum, expected within {} m",
            expect.within_m
        ));
    }
}

use backseat_core::plugin::{PositionRequest, Request, Rule};
use backseat_fence::Kind;
use backseat_mission::Mission;
use backseat_mvc::Mvc;
use backseat_picture::{
    Extent, Palette, Payload, Picture, Raster, Rejected, Shape, Steer, TrackPoint, Zone, ZoneKind, render,
};
use backseat_scenario::Scenario;
use backseat_spi::ToVehicle;
use backseat_units::{EastNorth, LocalFrame, Position, Timestamp};

use crate::report::Report;
use crate::trace::{Steering, Trace};

/// How many nodes the ground has along its longer side.
const NODES: f64 = 160.0;

/// The picture of a run, as SVG: fence, ground, plan, the vehicle's true track with who steered, inserts and
/// rejections.
#[must_use]
pub fn survey_map(mission: &Mission, scenario: &Scenario, report: &Report, trace: &Trace, mvc: &Mvc) -> String {
    let fence = mission.envelope.fence();
    let frame = fence.frame();
    let zones: Vec<Zone> = fence
        .zones()
        .map(|zone| Zone {
            name: zone.name().to_owned(),
            kind: match zone.kind() {
                Kind::KeepIn { .. } => ZoneKind::KeepIn,
                Kind::KeepOut { .. } => ZoneKind::KeepOut,
            },
            rings: zone.rings().map(|ring| ring.points.to_vec()).collect(),
            margin_m: zone.margin_m(),
        })
        .collect();
    let keep_ins = zones.iter().filter(|zone| zone.kind == ZoneKind::KeepIn);
    let extent = extent_of(keep_ins.flat_map(|zone| zone.rings.iter().flatten().copied()));
    let picture = Picture {
        title: mission.name.clone(),
        subtitle: format!(
            "seed {}, {} after {:.0} min; plugins: {}",
            report.seed,
            report.outcome,
            report.sim_seconds / 60.0,
            mission
                .file
                .plugins
                .iter()
                .map(|plugin| plugin.name.as_str())
                .collect::<Vec<_>>()
                .join(", "),
        ),
        caption: caption(report),
        extent: None,
        ground: Some(ground(extent, frame, mvc, contour_sought(scenario))),
        planned: plan(mvc).iter().map(|position| frame.to_local(*position)).collect(),
        flown: flown(trace, frame),
        inserts: inserts(trace, frame),
        rejected: trace
            .rejected
            .iter()
            .filter_map(|rejected| rejected_shape(rejected, frame, extent))
            .collect(),
        lease_begins: changes(trace, frame, true),
        lease_ends: changes(trace, frame, false),
        payload: Payload::Plugin,
        zones,
    };
    render(&picture)
}

fn caption(report: &Report) -> String {
    let mut text = format!(
        "requests: {} · violations: {}",
        report.requests,
        report.violations.len()
    );
    for measured in report.measured() {
        text.push_str(" · ");
        text.push_str(&measured);
    }
    text
}

fn contour_sought(scenario: &Scenario) -> Option<f64> {
    scenario.world.expect.contour.map(|contour| contour.water_depth_m)
}

/// The vehicle's true track.
pub(crate) fn flown(trace: &Trace, frame: &LocalFrame) -> Vec<TrackPoint> {
    let steered = trace.samples.iter().filter_map(|sample| {
        let steer = match sample.steering {
            Steering::Plan => Steer::FrontSeat,
            Steering::Modify => Steer::Modify,
            Steering::Insert => Steer::Insert,
            Steering::Nobody => return None,
        };
        Some(TrackPoint {
            at: frame.to_local(sample.position),
            steer,
        })
    });
    steered.collect()
}

pub(crate) fn inserts(trace: &Trace, frame: &LocalFrame) -> Vec<Shape> {
    let inserts = trace.inserts.iter();
    inserts.filter_map(|insert| insert_shape(insert, frame)).collect()
}

/// These points with some room around them.
pub(crate) fn extent_of(points: impl Iterator<Item = EastNorth>) -> Extent {
    let mut extent = Extent {
        west_m: f64::MAX,
        south_m: f64::MAX,
        east_m: f64::MIN,
        north_m: f64::MIN,
    };
    for point in points {
        extent.west_m = extent.west_m.min(point.east_m);
        extent.east_m = extent.east_m.max(point.east_m);
        extent.south_m = extent.south_m.min(point.north_m);
        extent.north_m = extent.north_m.max(point.north_m);
    }
    let border_m = 0.04 * (extent.east_m - extent.west_m).max(extent.north_m - extent.south_m);
    Extent {
        west_m: extent.west_m - border_m,
        south_m: extent.south_m - border_m,
        east_m: extent.east_m + border_m,
        north_m: extent.north_m + border_m,
    }
}

/// The field if the world has one, otherwise the seabed.
pub(crate) fn ground(extent: Extent, frame: &LocalFrame, mvc: &Mvc, highlight: Option<f64>) -> Raster {
    let world = mvc.world();
    let (wide_m, high_m) = (extent.east_m - extent.west_m, extent.north_m - extent.south_m);
    let step_m = wide_m.max(high_m) / NODES;
    let width = (wide_m / step_m).ceil() as usize + 1;
    let height = (high_m / step_m).ceil() as usize + 1;
    let has_field = world.field_maximum().is_some();
    let depth_m = mvc.truth().depth_m;
    let mut values = Vec::with_capacity(width * height);
    for row in 0..height {
        for column in 0..width {
            let at = EastNorth::new(
                extent.west_m + wide_m * column as f64 / (width - 1) as f64,
                extent.south_m + high_m * row as f64 / (height - 1) as f64,
            );
            let there = mvc.frame().to_local(frame.to_position(at));
            values.push(if has_field {
                world.temperature_c(there, depth_m, Timestamp::ZERO)
            } else {
                world.water_depth_m(there)
            });
        }
    }
    let (label, unit, palette) = if has_field {
        ("temperature", "°C", Palette::Field)
    } else {
        ("water depth", "m", Palette::Depth)
    };
    Raster {
        extent,
        width,
        height,
        values,
        label: label.to_owned(),
        unit: unit.to_owned(),
        palette,
        highlight,
    }
}

/// The front seat's own plan.
pub(crate) fn plan(mvc: &Mvc) -> Vec<Position> {
    mvc.plan_points()
        .into_iter()
        .filter(|(number, _)| number.is_some())
        .map(|(_, position)| position)
        .collect()
}

fn insert_shape(insert: &ToVehicle, frame: &LocalFrame) -> Option<Shape> {
    if let ToVehicle::Trackline(line) = insert {
        return Some(Shape::Line(frame.to_local(line.start), frame.to_local(line.end)));
    }
    if let ToVehicle::GpsHit(hit) = insert {
        return Some(Shape::Point(frame.to_local(hit.position)));
    }
    let ToVehicle::Trackcircle(circle) = insert else {
        return None;
    };
    Some(Shape::Circle {
        centre: frame.to_local(circle.centre),
        radius_m: circle.radius_m,
    })
}

/// Rules about a place. A request that was rejected for lack of control or by a cap has none.
const OF_PLACE: [Rule; 6] = [
    Rule::KeepIn,
    Rule::KeepOut,
    Rule::Depth,
    Rule::Altitude,
    Rule::Limit,
    Rule::Surfacing,
];

fn rejected_shape(rejected: &crate::trace::Rejected, frame: &LocalFrame, extent: Extent) -> Option<Rejected> {
    if !OF_PLACE.contains(&rejected.refusal.rule()) {
        return None;
    }
    let local = |position: PositionRequest| {
        let position = Position::from_deg(position.latitude_deg, position.longitude_deg).ok()?;
        Some(frame.to_local(position))
    };
    let from = rejected.from.map(|position| frame.to_local(position));
    let shape = match rejected.request.as_ref()? {
        Request::Trackline(line) => {
            let (start, end) = within(extent, local(line.start)?, local(line.end)?)?;
            Shape::Line(start, end)
        }
        Request::Trackcircle(circle) if circle.radius_m.is_finite() && circle.radius_m > 0.0 => Shape::Circle {
            centre: local(circle.centre)?,
            radius_m: circle.radius_m,
        },
        Request::Trackcircle(circle) => Shape::Point(local(circle.centre)?),
        Request::Modify(modify) if modify.heading_deg.is_finite() => {
            Shape::Line(from?, from?.offset(modify.heading_deg, 60.0))
        }
        Request::Modify(_) => Shape::Point(from?),
        Request::GpsHit(hit) => Shape::Point(local(hit.position)?),
        Request::EndModify
        | Request::Cancel(_)
        | Request::Message(_)
        | Request::Topside(_)
        | Request::DvlTrigger(_)
        | Request::Silent(_)
        | Request::Trim(_)
        | Request::Buoyancy(_)
        | Request::Packet(_)
        | Request::Station(_)
        | Request::EndStation
        | Request::SonarAngle(_)
        | Request::Camera(_)
        | Request::Light(_)
        | Request::SonarSet(_)
        | Request::SonarLog(_)
        | Request::Timer { .. } => return None,
    };
    let in_view = match shape {
        Shape::Point(at) | Shape::Line(at, _) => holds(extent, at),
        Shape::Circle { centre, .. } => holds(extent, centre),
    };
    in_view.then(|| Rejected {
        shape,
        reason: rejected.refusal.summary(),
    })
}

fn holds(extent: Extent, at: EastNorth) -> bool {
    (extent.west_m..=extent.east_m).contains(&at.east_m) && (extent.south_m..=extent.north_m).contains(&at.north_m)
}

/// The part of a line that is in view, because a line that ends far outside would shrink the map to a dot. Liang and
/// Barsky, ACM Transactions on Graphics 3(1), 1984.
fn within(extent: Extent, start: EastNorth, end: EastNorth) -> Option<(EastNorth, EastNorth)> {
    let along = end - start;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (rate, room) in [
        (-along.east_m, start.east_m - extent.west_m),
        (along.east_m, extent.east_m - start.east_m),
        (-along.north_m, start.north_m - extent.south_m),
        (along.north_m, extent.north_m - start.north_m),
    ] {
        if rate == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if rate < 0.0 {
            first = first.max(room / rate);
        } else {
            last = last.min(room / rate);
        }
    }
    (first <= last).then(|| (start + along * first, start + along * last))
}

/// Where modifies began, or ended.
pub(crate) fn changes(trace: &Trace, frame: &LocalFrame, begins: bool) -> Vec<EastNorth> {
    trace
        .samples
        .windows(2)
        .filter(|pair| {
            let modified = |index: usize| pair[index].steering == Steering::Modify;
            modified(0) != begins && modified(1) == begins
        })
        .map(|pair| frame.to_local(pair[1].position))
        .collect()
}

//! The map of a replay.

use std::path::Path;

use backseat_core::plugin::{PositionRequest, Request};
use backseat_fence::{Fence, Kind};
use backseat_picture::{Picture, Rejected, Shape, Steer, TrackPoint, Zone, ZoneKind, render};
use backseat_replay::{Asked, Report, Steering};
use backseat_units::{EastNorth, LocalFrame, Position};

/// How long the sign of a modify is, against the length of the track's longer side.
const SIGN: f64 = 0.03;
/// The shortest and the longest one, metres.
const SIGN_M: (f64, f64) = (5.0, 120.0);

/// Draws the recorded track and requests, and what differs now.
pub(super) fn draw(report: &Report, fence: &Fence, log: &Path) -> String {
    let drawing = &report.drawing;
    let frame = fence.frame();
    let zones = fence.zones().map(|zone| Zone {
        name: zone.name().to_owned(),
        kind: match zone.kind() {
            Kind::KeepIn { .. } => ZoneKind::KeepIn,
            Kind::KeepOut { .. } => ZoneKind::KeepOut,
        },
        rings: zone.rings().map(|ring| ring.points.to_vec()).collect(),
        margin_m: zone.margin_m(),
    });
    let flown = drawing.track.iter().map(|point| TrackPoint {
        at: point.at,
        steer: match point.steering {
            Steering::FrontSeat => Steer::FrontSeat,
            Steering::Lease => Steer::Modify,
            Steering::Insert => Steer::Insert,
        },
    });
    let flown: Vec<TrackPoint> = flown.collect();
    let sign_m = (SIGN * length_m(&flown)).clamp(SIGN_M.0, SIGN_M.1);
    let refused = drawing.refused.iter().filter_map(|(request, reason)| {
        Some(Rejected {
            shape: shape(request, None, frame, sign_m)?,
            reason: reason.clone(),
        })
    });
    let picture = Picture {
        title: format!("replay of {}", report.mission),
        subtitle: subtitle(report, log),
        caption: caption(report),
        zones: zones.collect(),
        inserts: drawing
            .inserts
            .iter()
            .filter_map(|request| shape(request, None, frame, sign_m))
            .collect(),
        rejected: refused.collect(),
        asked_then: signs(&drawing.recorded, frame, sign_m),
        asked_now: signs(&drawing.now, frame, sign_m),
        flown,
        ..Picture::default()
    };
    render(&picture)
}

fn subtitle(report: &Report, log: &Path) -> String {
    let file = log
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let plugins: Vec<String> = report
        .plugins
        .iter()
        .map(|plugin| match &plugin.component.file {
            Some(file) => format!("{} ({file})", plugin.name),
            None => plugin.name.clone(),
        })
        .collect();
    format!(
        "{file}, {:.0} min; plugins: {}",
        report.seconds / 60.0,
        plugins.join(", ")
    )
}

fn caption(report: &Report) -> String {
    let mut parts = vec![match report.identical {
        Some(true) => "identical".to_owned(),
        Some(false) => "not identical".to_owned(),
        None => "identical as far as it was replayed".to_owned(),
    }];
    for plugin in report.plugins.iter().filter(|plugin| plugin.different > 0) {
        parts.push(format!(
            "{}: {} of {} steps differ",
            plugin.name, plugin.different, plugin.steps
        ));
    }
    if let Some(first) = &report.first_difference {
        parts.push(format!("first difference at {:.1} s", first.at_s()));
    }
    parts.join(" · ")
}

/// The longer side of the track, metres.
fn length_m(track: &[TrackPoint]) -> f64 {
    let side = |of: fn(&EastNorth) -> f64| {
        let values = track.iter().map(|point| of(&point.at));
        let (least, most) = values.fold((f64::MAX, f64::MIN), |(least, most), value| {
            (least.min(value), most.max(value))
        });
        (most - least).max(0.0)
    };
    side(|at| at.east_m).max(side(|at| at.north_m))
}

/// The shapes of what was asked for. Modifies come twice a second, so those that begin near the last one are left out.
fn signs(asked: &[Asked], frame: &LocalFrame, sign_m: f64) -> Vec<Shape> {
    let mut last: Option<EastNorth> = None;
    let mut shapes = Vec::new();
    for Asked { from, request } in asked {
        if let (Request::Modify(_), Some(from)) = (request, from) {
            let near = last.is_some_and(|last| {
                let apart = *from - last;
                apart.east_m.abs().max(apart.north_m.abs()) < sign_m / 2.0
            });
            if near {
                continue;
            }
            last = Some(*from);
        }
        shapes.extend(shape(request, *from, frame, sign_m));
    }
    shapes
}

/// The geometry of a request; a modify as a line from the vehicle along its heading.
fn shape(request: &Request, from: Option<EastNorth>, frame: &LocalFrame, sign_m: f64) -> Option<Shape> {
    let local = |place: PositionRequest| {
        let place = Position::from_deg(place.latitude_deg, place.longitude_deg).ok()?;
        Some(frame.to_local(place))
    };
    match request {
        Request::Modify(modify) if modify.heading_deg.is_finite() => {
            Some(Shape::Line(from?, from?.offset(modify.heading_deg, sign_m)))
        }
        Request::Trackline(line) => Some(Shape::Line(local(line.start)?, local(line.end)?)),
        Request::Trackcircle(circle) if circle.radius_m.is_finite() && circle.radius_m > 0.0 => Some(Shape::Circle {
            centre: local(circle.centre)?,
            radius_m: circle.radius_m,
        }),
        Request::GpsHit(hit) => Some(Shape::Point(local(hit.position)?)),
        Request::Modify(_)
        | Request::Trackcircle(_)
        | Request::EndModify
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
        | Request::Timer { .. } => None,
    }
}

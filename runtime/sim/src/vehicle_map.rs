use backseat_mvc::Mvc;
use backseat_picture::{Payload, Picture, Shape, render};
use backseat_units::EastNorth;

use crate::survey_map::{changes, extent_of, flown, ground, inserts, plan};
use crate::trace::Trace;

/// The least width and height of the map, metres.
const LEAST_M: f64 = 200.0;

/// The picture of what a vehicle did without a mission of ours, as SVG: ground, plan, the vehicle's true track with who
/// steered, and the inserts of its clients. There is no fence, and no request was judged.
#[must_use]
pub fn vehicle_map(title: &str, subtitle: &str, caption: &str, trace: &Trace, mvc: &Mvc) -> String {
    let frame = mvc.frame();
    let planned: Vec<EastNorth> = plan(mvc).iter().map(|position| frame.to_local(*position)).collect();
    let inserts = inserts(trace, frame);
    let corners = |at: EastNorth, metres: f64| {
        [
            EastNorth::new(at.east_m - metres, at.north_m - metres),
            EastNorth::new(at.east_m + metres, at.north_m + metres),
        ]
    };
    let of_inserts = inserts.iter().flat_map(|shape| match *shape {
        Shape::Point(at) => corners(at, 0.0),
        Shape::Line(start, end) => [start, end],
        Shape::Circle { centre, radius_m } => corners(centre, radius_m),
    });
    let here = mvc.truth().local;
    let points = trace.samples.iter().map(|sample| sample.local);
    let points = points.chain(planned.iter().copied()).chain(of_inserts);
    let extent = extent_of(points.chain(corners(here, LEAST_M / 2.0)));
    render(&Picture {
        title: title.to_owned(),
        subtitle: subtitle.to_owned(),
        caption: caption.to_owned(),
        extent: Some(extent),
        ground: Some(ground(extent, frame, mvc, None)),
        zones: Vec::new(),
        planned,
        flown: flown(trace, frame),
        inserts,
        rejected: Vec::new(),
        lease_begins: changes(trace, frame, true),
        lease_ends: changes(trace, frame, false),
        payload: Payload::Client,
        ..Picture::default()
    })
}

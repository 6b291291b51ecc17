//! Draws a run as one SVG file: the ground, the fence, the plan, the track and who steered it, and the accepted and
//! refused requests.
//!
//! All points are in one local east-north frame, metres, north up. The same picture gives the same bytes. Values that
//! are not finite are left out. No fonts and no scripts are embedded.

mod canvas;
mod contour;
mod fence;
mod ground;
mod ink;
mod labels;
mod legend;
mod picture;
mod simplify;
mod tracks;
mod view;

use backseat_units::EastNorth;

pub use picture::{Extent, Palette, Payload, Picture, Raster, Rejected, Shape, Steer, TrackPoint, Zone, ZoneKind};

use canvas::Canvas;
use labels::Labels;
use view::View;

/// Draws a picture: an SVG document about 1200 pixels wide.
#[must_use]
pub fn render(picture: &Picture) -> String {
    let view = View::new(picture);
    let mut canvas = Canvas::new(&view);
    let mut labels = Labels::new(&view);
    let bands = picture
        .ground
        .as_ref()
        .and_then(|raster| ground::draw(&mut canvas, &view, raster));
    view.draw_graticule(&mut canvas);
    fence::draw(&mut canvas, &view, &picture.zones);
    tracks::draw_planned(&mut canvas, &view, &picture.planned);
    tracks::draw_inserts(&mut canvas, &view, &picture.inserts);
    tracks::draw_rejected(&mut canvas, &view, &picture.rejected);
    tracks::draw_flown(&mut canvas, &view, picture, &mut labels);
    labels::draw(&mut canvas, &mut labels, &view, picture, bands.as_ref());
    view.draw_frame(&mut canvas, picture);
    legend::draw(&mut canvas, &view, picture, bands.as_ref());
    canvas.finish()
}

/// A finite point.
fn is_finite(point: &EastNorth) -> bool {
    point.east_m.is_finite() && point.north_m.is_finite()
}

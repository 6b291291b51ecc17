//! Geofences: keep-in and keep-out polygons, depth and altitude bands, swept-shape checks.
//!
//! A [`Fence`] is read once from GeoJSON ([`Fence::from_geojson`]), a plan of QGroundControl ([`Fence::from_plan`]) or
//! KML ([`Fence::from_kml`]), and never changes. [`Fence::check`] judges a [`Sweep`] (a point, a leg, a solid triangle
//! or quadrilateral, or a circle's rim, each with a radius) together with a [`VerticalExtent`], and returns a
//! [`Clearance`] or a [`Breach`].
//!
//! # What a fence demands
//! - The sweep, with its radius and the zone's margin, must lie wholly inside **one** polygon of one keep-in zone. Two
//!   polygons that overlap or touch are not joined: a leg from one into the other is refused. This is stricter than
//!   necessary, and never laxer. Draw one polygon where the vehicle is to pass.
//! - The sweep's depths must lie within that zone's band, and its least altitude must be at least the zone's.
//! - The sweep, with its radius and the zone's margin, must stay clear of each keep-out zone whose band shares a depth
//!   with the sweep. The two ends of a band belong to it.
//! - A distance equal to margin plus radius is enough. An edge itself is a micrometre thick, so a sweep without radius
//!   on the edge of a zone without margin is refused.
//! - A place where the vehicle surfaces ([`Fence::check_surfacing`]) must lie in a zone that allows it. The zone's
//!   shallowest depth does not count there, and keep-out zones count over all depths through which the vehicle rises.
//! - A zone with a time window is judged by the time of the question ([`Fence::during`]). A keep-in zone must be valid
//!   throughout that time; a keep-out zone counts if it is valid at any instant of it. If the time is unknown, no
//!   keep-in zone with a window can contain the sweep, and every keep-out zone counts.
//! - A number that is not finite is refused.
//!
//! # File
//! The file is a `FeatureCollection` in longitude and latitude of WGS84. A feature is an area (`Polygon`,
//! `MultiPolygon`), a circle (`Point`) or a corridor (`LineString`). Its properties:
//!
//! | key | zone | meaning |
//! |---|---|---|
//! | `name` | both | different from all others |
//! | `kind` | both | `"keep-in"` or `"keep-out"` |
//! | `margin_m` | both | the distance to keep from the edge, 0 or more |
//! | `depth_min_m` | keep-in zone | shallowest allowed depth, 0 if absent |
//! | `depth_max_m` | keep-in zone | deepest allowed depth, required |
//! | `altitude_min_m` | keep-in zone | least altitude above the bottom, required |
//! | `surfacing` | keep-in zone | whether the vehicle may surface here for GPS, false if absent |
//! | `radius_m` | a circle, both | 0.1 to 25,000 |
//! | `half_width_m` | a corridor, both | from its line to its sides and round ends, 0.1 to 25,000 |
//! | `valid_from`, `valid_until` | both | the times at which the zone is valid (RFC 3339), both included; unlimited on the side of an absent key |
//! | `depth_min_m`, `depth_max_m` | keep-out zone | the forbidden depths; unlimited on the side of an absent key |
//!
//! Edges are straight in longitude and latitude (RFC 7946, section 3.1.1). They are divided when the fence is read, so
//! that the straight pieces in the plane follow them to a centimetre. All texts count features, polygons, rings,
//! vertices and edges from 1. Edge 4 of a ring or of a corridor's line runs from vertex 4 to vertex 5, in the order of
//! the file.
//!
//! Circles and corridors are drawn with straight edges. Those of a keep-in zone lie within the true outline, and those
//! of a keep-out zone lie around it. Circles are exact to 12 millimetres, the round corners and ends of corridors to a
//! hundredth of the half width and a centimetre. A keep-in corridor has one outline, so its line must not turn more
//! tightly than the corridor is wide, nor come back over itself.
//!
//! # Example
//! ```
//! use backseat_fence::{Fence, Rule, Shape, Sweep, VerticalExtent};
//! use backseat_units::EastNorth;
//!
//! let fence = Fence::from_geojson(
//!     r#"{"type": "FeatureCollection", "features": [{
//!         "type": "Feature",
//!         "properties": {
//!             "name": "survey box", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3
//!         },
//!         "geometry": {"type": "Polygon", "coordinates": [
//!             [[-70.0, 42.0], [-69.99, 42.0], [-69.99, 42.01], [-70.0, 42.01], [-70.0, 42.0]]
//!         ]}
//!     }]}"#,
//! )?;
//! let vertical = VerticalExtent { depth_min_m: 5.0, depth_max_m: 12.0, altitude_min_m: 8.0 };
//! let leg = |length_m| Sweep::new(Shape::leg(EastNorth::new(0.0, 0.0), EastNorth::new(length_m, 0.0)), 5.0);
//!
//! assert!(fence.check(&leg(300.0), &vertical)?.metres > 90.0);
//! let breach = fence.check(&leg(500.0), &vertical).unwrap_err();
//! assert_eq!(breach.rule, Rule::KeepIn);
//! println!("rejected: {breach}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod breach;
mod cover;
mod distance;
mod error;
mod fence;
mod load;
mod map;
mod outline;
mod polygon;
mod question;
mod save;
mod several;
mod sweep;
mod terms;
mod verdict;
mod window;
mod zone;

pub use breach::{EdgePlace, ZoneBreach};
pub use error::{FenceError, Place};
pub use fence::{Fence, FenceDuring};
pub use sweep::{ConvexHull, Shape, Sweep, VerticalExtent};
pub use terms::{Form, Terms};
pub use verdict::{Breach, Clearance, EdgeId, EdgeInfo, Rule};
pub use window::{Rfc3339, Span, Window, utc};
pub use zone::{Band, Kind, Ring, Zone};

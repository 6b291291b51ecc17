//! Geofences: keep-in and keep-out polygons, depth and altitude bands, swept-shape checks.
//!
//! A [`Fence`] is read once from GeoJSON ([`Fence::from_geojson`]), a plan of QGroundControl ([`Fence::from_plan`]) or KML
//! ([`Fence::from_kml`]), and never changes. [`Fence::check`] judges a
//! [`Sweep`] (a point, a leg, a solid triangle or quadrilateral, a circle's rim, each with a radius) together with a
//! [`VerticalExtent`], and answers with a [`Clearance`] or a [`Breach`].
//!
//! # What holds
//! - The sweep, with its radius and the zone's margin, lies wholly inside **one** polygon of one keep-in zone. Two
//!   that overlap or touch are not joined: a leg from one into the other is refused. This is stricter than need be,
//!   and never laxer; draw one polygon where the vehicle shall pass.
//! - The sweep's depths lie within that zone's band, and its least altitude is at least the zone's.
//! - The sweep, with its radius and the zone's margin, stays clear of each keep-out zone whose band shares a depth
//!   with the sweep; a band's two ends belong to it.
//! - Distance equal to margin plus radius is enough. An edge itself is a micrometre thick, so that a sweep of no
//!   radius on the edge of a zone of no margin is refused.
//! - A place where the vehicle surfaces ([`Fence::check_surfacing`]) lies in a zone that allows it; the zone's shallowest
//!   depth does not count there, and keep-out zones count over all depths that it comes through.
//! - A zone with a time window counts by the time of the question ([`Fence::during`]): a keep-in zone must be valid
//!   throughout, a keep-out zone counts where it is valid at any instant of it. Where the time is unknown no keep-in
//!   zone with a window holds, and every keep-out zone counts.
//! - What is not a finite number is refused, never passed.
//!
//! # File
//! A `FeatureCollection` in longitude and latitude of WGS84. A feature is an area (`Polygon`, `MultiPolygon`), a circle
//! (`Point`) or a corridor (`LineString`). Its properties:
//!
//! | key | zone | meaning |
//! |---|---|---|
//! | `name` | both | unlike all others |
//! | `kind` | both | `"keep-in"` or `"keep-out"` |
//! | `margin_m` | both | kept from the edge, 0 or more |
//! | `depth_min_m` | keep-in zone | shallowest allowed, 0 where absent |
//! | `depth_max_m` | keep-in zone | deepest allowed, required |
//! | `altitude_min_m` | keep-in zone | least height above the bottom, required |
//! | `surfacing` | keep-in zone | whether the vehicle may surface here for GPS, false where absent |
//! | `radius_m` | a circle, both | 0.1 to 25,000 |
//! | `half_width_m` | a corridor, both | from its line to its sides and round ends, 0.1 to 25,000 |
//! | `valid_from`, `valid_until` | both | the times at which the zone is valid (RFC 3339), both included; always, on the side of an absent key |
//! | `depth_min_m`, `depth_max_m` | keep-out zone | the depths that are forbidden; all, on the side of an absent key |
//!
//! Edges are straight in longitude and latitude (RFC 7946, section 3.1.1); they are divided at load so that the
//! plane's straight pieces follow them to a centimetre. Features, polygons, rings, vertices and edges count from 1 in
//! all texts; edge 4 of a ring or of a corridor's line runs from vertex 4 to vertex 5, in the order of the file.

//!
//! Circles and corridors are drawn with straight edges, a keep-in zone's within the true outline and a keep-out zone's
//! around it: circles to 12 millimetres, the round corners and ends of corridors to a hundredth of the half width and a
//! centimetre. A keep-in corridor has one outline, so that it must not turn more tightly than it is wide, nor come
//! back over itself.
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
pub use terms::Terms;
pub use verdict::{Breach, Clearance, EdgeId, EdgeInfo, Rule};
pub use window::{Rfc3339, Span, Window, utc};
pub use zone::{Band, Kind, Ring, Zone};

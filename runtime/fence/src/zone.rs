use backseat_units::EastNorth;

use crate::polygon::Polygon;
use crate::window::Window;

/// One feature of the fence's file.
#[derive(Clone, Debug)]
pub struct Zone {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) margin_m: f64,
    pub(crate) window: Window,
    pub(crate) polygons: Vec<Polygon>,
}

/// Whether the vehicle must be inside or outside a zone, and what the zone limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Inside.
    KeepIn {
        /// The allowed depths.
        depth: Band,
        /// The least altitude above the bottom, metres.
        altitude_min_m: f64,
        /// Whether the vehicle may surface here, whatever the shallowest depth is.
        surfacing: bool,
    },
    /// Outside, at the depths of the band; at all depths if there is no band.
    KeepOut {
        /// The forbidden depths.
        depth: Option<Band>,
    },
}

/// A range of depths, metres below the surface, both ends included. The band of a keep-out zone may be infinite on one
/// side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The shallowest depth.
    pub min_m: f64,
    /// The deepest depth.
    pub max_m: f64,
}

/// One ring of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring<'a> {
    /// Which polygon of the zone, from 1.
    pub polygon: usize,
    /// Which hole of the polygon, from 1; `None` for the outer ring.
    pub hole: Option<usize>,
    /// The vertices, with the first repeated as the last. Outer rings run counterclockwise, holes clockwise. Long edges
    /// have extra vertices, so that they follow the straight line of longitude and latitude to a centimetre.
    pub points: &'a [EastNorth],
}

impl Zone {
    /// The name, different from all others of the fence.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Keep-in or keep-out zone, and its limits.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        self.kind
    }

    /// How far a sweep must keep from the zone's edge, metres.
    #[must_use]
    pub const fn margin_m(&self) -> f64 {
        self.margin_m
    }

    /// When the zone is valid.
    #[must_use]
    pub const fn window(&self) -> Window {
        self.window
    }

    /// The rings of all the zone's polygons, each outer ring before its holes.
    pub fn rings(&self) -> impl Iterator<Item = Ring<'_>> {
        self.polygons.iter().enumerate().flat_map(|(index, polygon)| {
            polygon.rings().enumerate().map(move |(ring, points)| Ring {
                polygon: index + 1,
                hole: (ring > 0).then_some(ring),
                points,
            })
        })
    }
}

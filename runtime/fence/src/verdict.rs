use core::fmt;
use std::sync::Arc;

use backseat_units::EastNorth;
use serde::{Deserialize, Serialize};

use crate::breach::{EdgePlace, ZoneBreach};
use crate::map::Map;
use crate::window::Span;
use crate::zone::Kind;

/// An edge of a fence, which [`Fence::describe_edge`](crate::Fence::describe_edge) describes.
///
/// An edge that was divided when the fence was read, to follow the straight line of longitude and latitude, has several
/// identifiers and one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeId {
    pub(crate) zone: u32,
    pub(crate) polygon: u32,
    pub(crate) edge: u32,
}

/// An edge in the terms of the fence's file. Everything counts from 1, as in the errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeInfo<'a> {
    /// The name of the zone.
    pub zone: &'a str,
    /// Which polygon of the zone: 1, or more for a `MultiPolygon`.
    pub polygon: usize,
    /// Which hole of the polygon; `None` for the outer ring.
    pub hole: Option<usize>,
    /// The edge from the ring's vertex of this number to the next one.
    pub number: usize,
    /// The two ends of the edge, or of the piece of it that the identifier stands for.
    pub ends: [EastNorth; 2],
}

impl fmt::Display for EdgeInfo<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.polygon > 1 {
            write!(f, "polygon {} ", self.polygon)?;
        }
        if let Some(hole) = self.hole {
            write!(f, "hole {hole} ")?;
        }
        write!(f, "edge {}", self.number)
    }
}

/// A sweep that keeps the fence, and the room that it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Clearance {
    /// How many metres the sweep keeps beyond its own radius and the zone's margin, 0 to 1000; 1000 also stands for
    /// more. This is horizontal. Depth and altitude bands are kept too, but by how much is not reported.
    pub metres: f64,
    /// The edge that is nearest in this sense; `None` if that is more than 1000 m away.
    pub edge: Option<EdgeId>,
}

/// The rule that a request breaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// No keep-in zone contains the whole sweep with the zone's margin.
    KeepIn,
    /// The sweep enters a keep-out zone or its margin.
    KeepOut,
    /// The sweep may come shallower than the keep-in zone allows.
    DepthMin,
    /// The sweep may come deeper than the keep-in zone allows.
    DepthMax,
    /// The sweep may come nearer to the bottom than the keep-in zone allows.
    AltitudeMin,
    /// The vehicle would surface where no keep-in zone that allows it contains the sweep.
    Surfacing,
    /// The only keep-in zones that could contain the sweep are not valid for the whole time of the question.
    Closed,
    /// A number of the request is unusable: not finite, beyond ±1e9, a negative radius, or a range of depths or times
    /// whose ends are the wrong way round.
    NotFinite,
}

/// A breach of the fence. Cheap to make: its text is made when it is printed, from the fence, which it keeps alive.
#[derive(Clone)]
#[must_use]
pub struct Breach {
    /// The rule that is breached.
    pub rule: Rule,
    /// How many metres are missing, over 0; infinite for [`Rule::NotFinite`] and [`Rule::Closed`], and for
    /// [`Rule::Surfacing`] if no zone of the fence allows it.
    ///
    /// For [`Rule::KeepIn`] and [`Rule::Surfacing`]: how far the worst point would have to move inwards, including
    /// margin and radius. Exact for a point, for a sweep that lies inside and is only too near, and for a convex hull
    /// in a convex zone without holes. Otherwise it is a lower bound, taken from the corners of the convex hull, or
    /// from eight points of a rim, and from where the sweep is nearest.
    ///
    /// For [`Rule::KeepOut`]: margin and radius less the distance; or, if the sweep touches the zone, margin and radius
    /// plus the depth of its deepest corner inside, which is a lower bound of how far it would have to move.
    pub metres: f64,
    /// The nearest edge of the zone; `None` if no zone is named.
    pub edge: Option<EdgeId>,
    /// The place on that edge.
    pub at: Option<EastNorth>,
    pub(crate) cause: Cause,
    pub(crate) map: Arc<Map>,
}

/// What the text needs besides the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cause {
    Zone(u32),
    /// The zone, and the time of the question.
    Closed(u32, Option<Span>),
    Number(&'static str),
    /// No zone allows surfacing.
    NoSurfacing,
}

impl Breach {
    /// The zone that is breached, or the keep-in zone whose fault is the smallest; `None` for [`Rule::NotFinite`], and
    /// if the vehicle would surface and no zone allows it.
    #[must_use]
    pub fn zone(&self) -> Option<&str> {
        match self.cause {
            Cause::Zone(zone) | Cause::Closed(zone, _) => Some(self.map.zones[zone as usize].name()),
            Cause::Number(_) | Cause::NoSurfacing => None,
        }
    }
}

impl Breach {
    /// The breach in the terms of the fence's file, as data that does not need the fence.
    #[must_use]
    pub fn report(&self) -> ZoneBreach {
        let mut report = ZoneBreach {
            rule: self.rule,
            zone: self.zone().map(str::to_owned),
            missing_m: self.metres.is_finite().then_some(self.metres),
            bound_m: None,
            margin_m: 0.0,
            edge: None,
            valid: None,
            asked: None,
            number: None,
        };
        let zone = match self.cause {
            Cause::Zone(zone) => &self.map.zones[zone as usize],
            Cause::Closed(zone, span) => {
                report.valid = Some(self.map.zones[zone as usize].window());
                report.asked = span;
                return report;
            }
            Cause::Number(what) => {
                report.number = Some(what.to_owned());
                return report;
            }
            Cause::NoSurfacing => return report,
        };
        report.margin_m = zone.margin_m();
        if let Kind::KeepIn {
            depth, altitude_min_m, ..
        } = zone.kind()
        {
            report.bound_m = match self.rule {
                Rule::DepthMin => Some(depth.min_m),
                Rule::DepthMax => Some(depth.max_m),
                Rule::AltitudeMin => Some(altitude_min_m),
                Rule::KeepIn | Rule::KeepOut | Rule::Surfacing | Rule::Closed | Rule::NotFinite => None,
            };
        }
        if let (Some(edge), Some(at)) = (self.edge, self.at) {
            let info = self.map.describe(edge);
            let position = self.map.frame.to_position(at);
            report.edge = Some(EdgePlace {
                polygon: info.polygon,
                hole: info.hole,
                number: info.number,
                latitude_deg: position.latitude.as_deg(),
                longitude_deg: position.longitude.as_deg(),
            });
        }
        report
    }
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report().fmt(f)
    }
}

impl fmt::Debug for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Breach")
            .field("rule", &self.rule)
            .field("metres", &self.metres)
            .field("edge", &self.edge)
            .field("text", &self.to_string())
            .finish_non_exhaustive()
    }
}

impl PartialEq for Breach {
    /// Compares rule, metres and place, and assumes that the fences are the same.
    fn eq(&self, other: &Self) -> bool {
        (self.rule, self.metres, self.edge, self.at, self.cause)
            == (other.rule, other.metres, other.edge, other.at, other.cause)
    }
}

impl core::error::Error for Breach {}

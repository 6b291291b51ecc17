use core::fmt;
use std::sync::Arc;

use backseat_units::EastNorth;
use serde::{Deserialize, Serialize};

use crate::breach::{EdgePlace, ZoneBreach};
use crate::map::Map;
use crate::window::Span;
use crate::zone::Kind;

/// An edge of a fence. [`Fence::describe_edge`](crate::Fence::describe_edge) tells what it is.
///
/// Edges that were divided at load, to follow the straight line of longitude and latitude, have several identifiers
/// and one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeId {
    pub(crate) zone: u32,
    pub(crate) polygon: u32,
    pub(crate) edge: u32,
}

/// What an [`EdgeId`] stands for, in the terms of the fence's file. Everything counts from 1, as the errors do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeInfo<'a> {
    /// The name of the zone.
    pub zone: &'a str,
    /// Which polygon of the zone: 1, or more for a `MultiPolygon`.
    pub polygon: usize,
    /// Which hole of the polygon; none for the outer ring.
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

/// The fence holds, with this to spare.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct Clearance {
    /// How many metres the sweep keeps beyond its own radius and the zone's margin, 0 to 1000: 1000 where it is more.
    /// Horizontal; depth and altitude bands hold, by how much is not told.
    pub metres: f64,
    /// The edge that is nearest in this sense; none where that is more than 1000 m.
    pub edge: Option<EdgeId>,
}

/// What a request offends against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// The sweep lies wholly inside no keep-in zone and its margin.
    KeepIn,
    /// The sweep comes into a keep-out zone or its margin.
    KeepOut,
    /// The sweep may come shallower than the keep-in zone allows.
    DepthMin,
    /// The sweep may come deeper than the keep-in zone allows.
    DepthMax,
    /// The sweep may come nearer to the bottom than the keep-in zone allows.
    AltitudeMin,
    /// The vehicle would surface where no keep-in zone that allows it holds the sweep.
    Surfacing,
    /// The only keep-in zones that could hold the sweep are not valid for the whole time of the question.
    Closed,
    /// A number of the request is unusable: not finite, beyond ±1e9, a negative radius, or a depth range or
    /// a time that is the wrong way round.
    NotFinite,
}

/// The fence does not hold. Cheap to make; its text is made when it is printed, from the fence that it keeps alive.
#[derive(Clone)]
#[must_use]
pub struct Breach {
    /// What is offended against.
    pub rule: Rule,
    /// How many metres are missing, over 0; infinite for [`Rule::NotFinite`] and [`Rule::Closed`], and for [`Rule::Surfacing`] where no zone of
    /// the fence allows it.
    ///
    /// For [`Rule::KeepIn`] and [`Rule::Surfacing`]: how far the worst point would have to come in, margin and radius
    /// included. Exact for a point, for a sweep that lies inside and only too near, and for a convex hull in a convex
    /// zone without holes; else a lower bound, taken from the convex hull's corners, or from eight points of a rim, and
    /// where the sweep is nearest.
    ///
    /// For [`Rule::KeepOut`]: margin and radius less the distance, or, where the sweep touches the zone, margin and
    /// radius plus the depth of its deepest corner inside: a lower bound of what it would have to move.
    pub metres: f64,
    /// The nearest edge of the zone; none where no zone is named.
    pub edge: Option<EdgeId>,
    /// The place on that edge.
    pub at: Option<EastNorth>,
    pub(crate) cause: Cause,
    pub(crate) map: Arc<Map>,
}

/// What the text needs beside the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cause {
    Zone(u32),
    /// The zone, and the time that was asked for.
    Closed(u32, Option<Span>),
    Number(&'static str),
    /// No zone allows surfacing.
    NoSurfacing,
}

impl Breach {
    /// The zone that is breached, or that came nearest to holding; none for [`Rule::NotFinite`], and where the vehicle would
    /// surface and no zone allows it.
    #[must_use]
    pub fn zone(&self) -> Option<&str> {
        match self.cause {
            Cause::Zone(zone) | Cause::Closed(zone, _) => Some(self.map.zones[zone as usize].name()),
            Cause::Number(_) | Cause::NoSurfacing => None,
        }
    }
}

impl Breach {
    /// What is breached, told in the terms of the fence's file and free of the fence.
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
    /// Same rule, metres and place; the fences are taken to be the same.
    fn eq(&self, other: &Self) -> bool {
        (self.rule, self.metres, self.edge, self.at, self.cause)
            == (other.rule, other.metres, other.edge, other.at, other.cause)
    }
}

impl core::error::Error for Breach {}

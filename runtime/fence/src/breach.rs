//! A breach as data that outlives the fence: what a log keeps, and what a plugin branches on.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::verdict::Rule;
use crate::window::{Span, Window};

/// What a request breaches, in the terms of the fence's file. Its text is made when it is printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZoneBreach {
    /// What is offended against.
    pub rule: Rule,
    /// The zone that is breached, or that came nearest to holding; none where a number is unusable, and where the vehicle
    /// would surface and no zone allows it.
    pub zone: Option<String>,
    /// How many metres are missing, over 0; none where metres are not its measure.
    pub missing_m: Option<f64>,
    /// Of depth and altitude: what the zone allows, metres.
    pub bound_m: Option<f64>,
    /// The zone's margin, metres.
    pub margin_m: f64,
    /// The nearest edge, and the place on it.
    pub edge: Option<EdgePlace>,
    /// Of [`Rule::Closed`]: when the zone is valid.
    pub valid: Option<Window>,
    /// Of [`Rule::Closed`]: the time that was asked for; none where it is unknown.
    pub asked: Option<Span>,
    /// Of [`Rule::NotFinite`]: which number is unusable.
    pub number: Option<String>,
}

/// An edge of a zone, and the place on it that is nearest. All counts begin with 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgePlace {
    /// Which polygon of the zone.
    pub polygon: usize,
    /// Which hole of the polygon; none for the outer ring.
    pub hole: Option<usize>,
    /// The edge from the ring's vertex of this number to the next one.
    pub number: usize,
    /// Where on the edge, degrees north.
    pub latitude_deg: f64,
    /// Where on the edge, degrees east.
    pub longitude_deg: f64,
}

impl ZoneBreach {
    /// What is breached, without the figures that differ from one breach to the next.
    #[must_use]
    pub fn summary(&self) -> String {
        let name = self.zone.as_deref().unwrap_or_default();
        match self.rule {
            Rule::NotFinite => "not a usable number".to_owned(),
            Rule::Closed => format!("keep-in zone '{name}' is not valid then"),
            Rule::Surfacing if self.zone.is_none() => "no keep-in zone allows surfacing".to_owned(),
            Rule::Surfacing => format!("outside keep-in zone '{name}', which allows surfacing"),
            Rule::DepthMin => format!("shallower than keep-in zone '{name}' allows"),
            Rule::DepthMax => format!("deeper than keep-in zone '{name}' allows"),
            Rule::AltitudeMin => format!("below the altitude of keep-in zone '{name}'"),
            Rule::KeepOut => format!("inside keep-out zone '{name}'"),
            Rule::KeepIn => format!("outside keep-in zone '{name}'"),
        }
    }
}

impl fmt::Display for ZoneBreach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.zone.as_deref().unwrap_or_default();
        let metres = Metres(self.missing_m.unwrap_or(f64::INFINITY));
        let bound_m = self.bound_m.unwrap_or(f64::NAN);
        match self.rule {
            Rule::NotFinite => {
                let number = self.number.as_deref().unwrap_or_default();
                return write!(f, "not a usable number: {number}");
            }
            Rule::Closed => {
                let valid = self.valid.unwrap_or_default();
                write!(f, "keep-in zone '{name}' is valid {valid} only, asked for ")?;
                return match self.asked {
                    Some(span) => write!(f, "{span}"),
                    None => write!(f, "an unknown time"),
                };
            }
            Rule::Surfacing if self.zone.is_none() => return write!(f, "no keep-in zone allows surfacing"),
            Rule::DepthMin => return write!(f, "{metres} shallower than the {bound_m} m of keep-in zone '{name}'"),
            Rule::DepthMax => return write!(f, "{metres} deeper than the {bound_m} m of keep-in zone '{name}'"),
            Rule::AltitudeMin => {
                return write!(f, "{metres} below the altitude of {bound_m} m of keep-in zone '{name}'");
            }
            Rule::KeepOut => write!(f, "inside keep-out zone '{name}'")?,
            Rule::Surfacing => write!(f, "outside keep-in zone '{name}', the nearest that allows surfacing,")?,
            Rule::KeepIn => write!(f, "outside keep-in zone '{name}'")?,
        }
        if self.margin_m > 0.0 {
            write!(f, " with its margin of {} m", self.margin_m)?;
        }
        write!(f, " by {metres}")?;
        if let Some(edge) = self.edge {
            let (latitude, longitude) = (edge.latitude_deg, edge.longitude_deg);
            write!(f, " at {edge} (latitude {latitude:.6} longitude {longitude:.6})")?;
        }
        Ok(())
    }
}

impl fmt::Display for EdgePlace {
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

/// A length in a text: to the decimetre, small ones as they are.
struct Metres(f64);

impl fmt::Display for Metres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 >= 0.1 {
            write!(f, "{:.1} m", self.0)
        } else {
            write!(f, "{:.1e} m", self.0)
        }
    }
}

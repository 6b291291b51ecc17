//! A breach as data that outlives the fence. Logs keep it, and plugins decide by it.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::verdict::Rule;
use crate::window::{Span, Window};

/// What a request breaches, in the terms of the fence's file. Its text is made when it is printed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZoneBreach {
    /// The rule that is breached.
    pub rule: Rule,
    /// The zone that is breached, or the keep-in zone whose fault is the smallest; `None` if a number is unusable, and
    /// if the vehicle would surface and no zone allows it.
    pub zone: Option<String>,
    /// How many metres are missing, over 0; `None` if the rule is not measured in metres.
    pub missing_m: Option<f64>,
    /// For rules of depth and altitude: the limit of the zone, metres.
    pub bound_m: Option<f64>,
    /// The zone's margin, metres.
    pub margin_m: f64,
    /// The nearest edge, and the place on it.
    pub edge: Option<EdgePlace>,
    /// For [`Rule::Closed`]: when the zone is valid.
    pub valid: Option<Window>,
    /// For [`Rule::Closed`]: the time of the question; `None` if it is unknown.
    pub asked: Option<Span>,
    /// For [`Rule::NotFinite`]: which number is unusable.
    pub number: Option<String>,
}

/// An edge of a zone, and the nearest place on it. Everything counts from 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgePlace {
    /// Which polygon of the zone.
    pub polygon: usize,
    /// Which hole of the polygon; `None` for the outer ring.
    pub hole: Option<usize>,
    /// The edge from the ring's vertex of this number to the next one.
    pub number: usize,
    /// The place on the edge, degrees north.
    pub latitude_deg: f64,
    /// The place on the edge, degrees east.
    pub longitude_deg: f64,
}

impl ZoneBreach {
    /// The breach without the figures that differ from one breach to the next.
    #[must_use]
    pub fn summary(&self) -> String {
        let name = self.zone.as_deref().unwrap_or_default();
        match self.rule {
            Rule::NotFinite => "not a usable number".to_owned(),
            Rule::Closed => format!("keep-in zone '{name}' is not valid at that time"),
            Rule::Surfacing if self.zone.is_none() => "no keep-in zone allows surfacing".to_owned(),
            Rule::Surfacing => format!("outside keep-in zone '{name}', which allows surfacing"),
            Rule::DepthMin => format!("shallower than keep-in zone '{name}' allows"),
            Rule::DepthMax => format!("deeper than keep-in zone '{name}' allows"),
            Rule::AltitudeMin => format!("too deep for the altitude of keep-in zone '{name}'"),
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
                write!(
                    f,
                    "keep-in zone '{name}' is valid only {valid}, and the request is for "
                )?;
                return match self.asked {
                    Some(span) => write!(f, "{span}"),
                    None => write!(f, "an unknown time"),
                };
            }
            Rule::Surfacing if self.zone.is_none() => return write!(f, "no keep-in zone allows surfacing"),
            Rule::DepthMin => return write!(f, "{metres} shallower than the {bound_m} m of keep-in zone '{name}'"),
            Rule::DepthMax => return write!(f, "{metres} deeper than the {bound_m} m of keep-in zone '{name}'"),
            Rule::AltitudeMin => {
                return write!(
                    f,
                    "{metres} too deep for the altitude of {bound_m} m of keep-in zone '{name}'"
                );
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

/// A length in a text, to the decimetre; smaller lengths to the millimetre.
struct Metres(f64);

impl fmt::Display for Metres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 >= 0.1 {
            write!(f, "{:.1} m", self.0)
        } else if self.0 >= 0.001 {
            write!(f, "{:.3} m", self.0)
        } else {
            f.write_str("less than 1 mm")
        }
    }
}

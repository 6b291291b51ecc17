//! The plan that the operator checked, compared with the one that the vehicle reports (SPI 6.20; safety requirement
//! 001).
//!
//! BFPLN reports places only, so depths and speeds can be checked ashore only. Inserts have an identifier and do not
//! count as a difference.

use backseat_spi::PlanElementKind;
use backseat_units::{LocalFrame, Position};

use crate::refusal::Uncontrolled;
use crate::vehicle::plan::{Element, Plan};

/// A front seat's plan as the operator checked it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpectedPlan {
    /// What BFPLN must list, in order.
    pub elements: Vec<ExpectedElement>,
    /// How far a place may be from the expected one, metres.
    pub tolerance_m: f64,
}

/// A behavior of an [`ExpectedPlan`] that BFPLN reports.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedElement {
    /// Its number in the plan's file, for texts. Vehicles may number behaviors differently.
    pub number: u32,
    /// Where it leads.
    pub path: ExpectedPath,
}

/// Where a behavior leads.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpectedPath {
    /// These places, one after the other: a waypoint, or a line's two ends.
    Points(Vec<Position>),
    /// Places on a circle, any number of them.
    Circle {
        /// Its centre.
        centre: Position,
        /// Its radius, metres.
        radius_m: f64,
    },
    /// One place, anywhere: the end of a behavior that flies a heading, which depends on where it began.
    Anywhere,
}

/// The result of the comparison on this connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Compared {
    /// The vehicle's plan is not known yet.
    #[default]
    NotYet,
    Same,
    Differs,
}

impl Compared {
    /// Why we have no control, if a plan is expected.
    pub(crate) const fn reason(self) -> Option<Uncontrolled> {
        match self {
            Self::Same => None,
            Self::NotYet => Some(Uncontrolled::PlanNotCompared),
            Self::Differs => Some(Uncontrolled::PlanDiffers),
        }
    }
}

impl ExpectedPlan {
    /// The first difference between the vehicle's plan and this one.
    pub(crate) fn difference(&self, plan: &Plan, frame: &LocalFrame) -> Option<String> {
        let mut listed = plan.planned();
        for (index, expected) in self.elements.iter().enumerate() {
            let number = expected.number;
            let Some(element) = listed.next() else {
                let (has, wanted) = (index, self.elements.len());
                return Some(format!(
                    "it has {has} elements, expected {wanted}: element {number} is not in it"
                ));
            };
            if let Some(difference) = expected.difference(element, frame, self.tolerance_m) {
                return Some(format!("element {number}: {difference}"));
            }
        }
        let more = listed.count();
        (more > 0).then(|| {
            let wanted = self.elements.len();
            format!("it has {} elements, expected {wanted}", wanted + more)
        })
    }
}

impl ExpectedElement {
    fn difference(&self, element: &Element, frame: &LocalFrame, tolerance_m: f64) -> Option<String> {
        let off = |distance_m: f64| distance_m.is_nan() || distance_m > tolerance_m;
        match &self.path {
            ExpectedPath::Points(places) => {
                let line = places.len() > 1;
                let kinds = [PlanElementKind::TracklineStart, PlanElementKind::TracklineEnd];
                if element.circles || line != element.kinds.iter().any(|kind| kinds.contains(kind)) {
                    let wanted = if line { "a trackline" } else { "a waypoint" };
                    return Some(format!("it is {}, expected {wanted}", element.kind_name()));
                }
                if element.points.len() != places.len() {
                    let (has, wanted) = (element.points.len(), places.len());
                    return Some(format!("it has {has} places, expected {wanted}"));
                }
                let mut pairs = (1..).zip(element.points.iter().zip(places));
                pairs.find_map(|(at, (point, place))| {
                    let metres = point.distance_m(frame.to_local(*place));
                    off(metres).then(|| format!("its point {at} is {metres:.1} m from the expected one"))
                })
            }
            ExpectedPath::Circle { centre, radius_m } => {
                if !element.circles {
                    return Some(format!("it is {}, expected a trackcircle", element.kind_name()));
                }
                let centre = frame.to_local(*centre);
                let mut points = (1..).zip(&element.points);
                points.find_map(|(at, point)| {
                    let metres = (point.distance_m(centre) - radius_m).abs();
                    off(metres).then(|| format!("its point {at} is {metres:.1} m from the expected circle"))
                })
            }
            ExpectedPath::Anywhere => {
                let single = element.points.len() == 1 && element.kinds == [PlanElementKind::Waypoint];
                (!single).then(|| format!("it is {}, expected a single place", element.kind_name()))
            }
        }
    }
}

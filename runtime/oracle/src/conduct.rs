use std::time::Duration;

use backseat_units::Timestamp;

use crate::area::{Area, Kind, Surroundings, Zone};
use crate::limits::{Activity, Truth};
use crate::plan::Plan;
use crate::plane::{Plane, Point, length_m};
use crate::rule::Rule;
use crate::violation::Findings;

/// How long after our commands the vehicle's whereabouts are still their consequence.
const CONSEQUENCE: Duration = Duration::from_secs(15);
/// How far the true depth may be out of the zone's band, metres.
const DEPTH_SLACK_M: f64 = 1.0;
/// When the vehicle must have forgotten a modify (SPI 7.12), and 100 ms.
const LAPSE: Duration = Duration::from_millis(5100);

/// What the vehicle truly did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Conduct {
    last: Option<(Timestamp, Activity)>,
    commanded_until: Option<Timestamp>,
    surroundings: Surroundings,
    /// Where the surroundings were surveyed.
    surveyed: Option<(Point, Plane)>,
    outside: Excursion,
    depth: Excursion,
    grounded: Excursion,
    outlived: Excursion,
    reports: u64,
    judged: u64,
    insert: Duration,
    modified: Duration,
}

/// A breach that lasts is told once.
#[derive(Clone, Copy, Debug, Default)]
struct Excursion(bool);

/// What else the judgement needs to know.
pub(crate) struct Context<'a> {
    pub(crate) area: &'a Area,
    pub(crate) plan: &'a Plan,
    pub(crate) tracking_error_m: f64,
    pub(crate) link_delay: Duration,
    pub(crate) last_modify: Option<Timestamp>,
}

impl Conduct {
    /// Reports, reports held against the fence, seconds of inserts, seconds of modifies.
    pub(crate) fn counts(&self) -> (u64, u64, f64, f64) {
        (
            self.reports,
            self.judged,
            self.insert.as_secs_f64(),
            self.modified.as_secs_f64(),
        )
    }

    pub(crate) fn judge(&mut self, truth: &Truth, context: &Context<'_>, findings: &mut Findings) {
        let at = truth.at;
        self.reports += 1;
        if let Some((before, activity)) = self.last {
            match activity {
                Activity::Insert(_) => self.insert += at.since(before),
                Activity::Modified => self.modified += at.since(before),
                Activity::Plan | Activity::Other => {}
            }
        }
        self.last = Some((at, truth.activity));

        let modified = truth.activity == Activity::Modified;
        let outlived = modified
            && context
                .last_modify
                .is_none_or(|last| at.since(last) > LAPSE + context.link_delay);
        self.outlived.tell(outlived, findings, at, Rule::ModifyOutlives, || {
            match context.last_modify {
                Some(last) => format!("still modified though the last BPRMB left at {last}"),
                None => "modified without any BPRMB".to_owned(),
            }
        });

        let commanded = match truth.activity {
            Activity::Insert(_) | Activity::Modified => {
                self.commanded_until = Some(at);
                true
            }
            Activity::Plan => {
                let Some(until) = self.commanded_until else { return };
                if at.since(until) > CONSEQUENCE {
                    self.commanded_until = None;
                    return;
                }
                false
            }
            Activity::Other => {
                self.commanded_until = None;
                return;
            }
        };
        self.judged += 1;
        self.judge_whereabouts(truth, commanded, context, findings);
    }

    fn judge_whereabouts(&mut self, truth: &Truth, commanded: bool, context: &Context<'_>, findings: &mut Findings) {
        let point = context.area.point(truth.position);
        self.survey(point, context.area);
        let mut inside = false;
        let mut depth_allowed = false;
        let mut excluded: Option<&Zone> = None;
        for zone in self
            .surroundings
            .zones
            .iter()
            .filter_map(|index| context.area.zone(*index))
        {
            match zone.kind {
                Kind::Inclusion => {
                    inside = true;
                    // What its own plan does with its depth is the vehicle's; only what is too deep can be our doing.
                    let too_shallow = commanded && truth.depth_m < zone.depth_min_m - DEPTH_SLACK_M;
                    depth_allowed |= !too_shallow && truth.depth_m <= zone.depth_max_m + DEPTH_SLACK_M;
                }
                Kind::Exclusion => {
                    let min_m = zone.depth_min_m + DEPTH_SLACK_M;
                    let max_m = zone.depth_max_m - DEPTH_SLACK_M;
                    if min_m <= truth.depth_m && truth.depth_m <= max_m {
                        excluded = Some(zone);
                    }
                }
            }
        }
        let excused = || !commanded && context.plan.passes(point, context.tracking_error_m);
        let out = (!inside || excluded.is_some()) && !excused();
        let edge_m = self.surroundings.edge_m;
        let place = || {
            format!(
                "{:.6} {:.6}, {:.1} m deep, {:?}",
                truth.position.latitude.as_deg(),
                truth.position.longitude.as_deg(),
                truth.depth_m,
                truth.activity
            )
        };
        self.outside
            .tell(out, findings, truth.at, Rule::TruthFence, || match excluded {
                Some(zone) => format!("in exclusion zone {} at {}", zone.name, place()),
                None => format!("in no inclusion zone at {}, about {edge_m:.1} m from an edge", place()),
            });
        let depth = inside && !depth_allowed && !excused();
        self.depth.tell(depth, findings, truth.at, Rule::TruthDepth, || {
            format!("out of the depths of every inclusion zone at {}", place())
        });
        // An altitude which is no number is no clearance.
        let grounded = commanded && (truth.altitude_m <= 0.0 || truth.altitude_m.is_nan());
        self.grounded
            .tell(grounded, findings, truth.at, Rule::TruthGrounded, || {
                format!("altitude {:.2} m at {}", truth.altitude_m, place())
            });
    }

    /// Surveys anew only where an edge could have been crossed since.
    fn survey(&mut self, point: Point, area: &Area) {
        if let Some((_, plane)) = self.surveyed {
            // A metre, and a part of the way, for the error of the plane.
            let moved_m = length_m(plane.vector(point));
            if moved_m < 10_000.0 && moved_m * 1.01 + 1.0 < self.surroundings.edge_m {
                return;
            }
        }
        area.survey(point, &mut self.surroundings);
        self.surveyed = Some((point, Plane::at(point)));
    }
}

impl Excursion {
    fn tell(&mut self, now: bool, findings: &mut Findings, at: Timestamp, rule: Rule, text: impl FnOnce() -> String) {
        if now && !self.0 {
            findings.add(at, rule, text);
        }
        self.0 = now;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FENCE: &str = r#"{ "type": "FeatureCollection", "features": [
        { "type": "Feature", "properties": { "name": "a", "kind": "inclusion" },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.0, 60.0], [5.02, 60.0], [5.03, 60.01], [5.01, 60.005], [5.0, 60.02], [5.0, 60.0]],
            [[5.004, 60.002], [5.006, 60.002], [5.005, 60.004], [5.004, 60.002]] ] } },
        { "type": "Feature", "properties": { "name": "b", "kind": "exclusion" },
          "geometry": { "type": "Polygon", "coordinates": [
            [[5.008, 60.002], [5.012, 60.003], [5.01, 60.0], [5.008, 60.002]] ] } } ] }"#;

    proptest! {
        /// What is remembered of the surroundings is what a survey on the spot would say.
        #[test]
        fn a_remembered_survey_holds(
            start in (-0.01..0.04f64, -0.01..0.03f64),
            steps in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0..4u8), 1..80),
        ) {
            let area = Area::read(FENCE).unwrap();
            let mut conduct = Conduct::default();
            let mut fresh = Surroundings::default();
            let mut point = Point { x: start.0, y: 60.0 + start.1 };
            for (x, y, size) in steps {
                let step = [1e-6, 1e-5, 1e-4, 1e-3][usize::from(size)];
                point = Point { x: point.x + x * step, y: point.y + y * step };
                conduct.survey(point, &area);
                area.survey(point, &mut fresh);
                prop_assert_eq!(&conduct.surroundings.zones, &fresh.zones, "{:?}", point);
            }
        }
    }
}

use std::time::Duration;

use crate::margin::Margin;
use crate::moment::Moment;

use crate::area::Area;
use crate::delivery::Delivery;
use crate::earth::Line;
use crate::limits::{Activity, Truth};
use crate::plan::Plan;
use crate::plane::{Plane, Point};
use crate::rule::Rule;
use crate::surroundings::Survey;
use crate::violation::Findings;
use crate::wire::Fix;
use crate::zone::Kind;

/// For so long after our commands, the vehicle's position is their consequence, whatever it does.
const CONSEQUENCE: Duration = Duration::from_secs(15);
/// And for so long at most while it is on its way back to its plan.
const WAY_BACK: Duration = Duration::from_secs(300);
/// How often the vehicle's estimate of its position is compared with the margins.
const MARGIN_EVERY: Duration = Duration::from_secs(1);
/// How much two frames, the decimals of the sentences and a moment of noise can take from a margin, metres.
const MARGIN_SLACK_M: f64 = 1.0;
/// How much further than the error of its estimate the vehicle's newest position may be from the true one, metres: it may be
/// some seconds old, and a correction may have come since.
const APART_MAX_M: f64 = 500.0;
/// How far the true depth may be outside the zone's band, metres.
const DEPTH_SLACK_M: f64 = 1.0;
/// For so long after a cancel of ours, the vehicle's position is its consequence.
const CANCEL_CONSEQUENCE: Duration = Duration::from_secs(60);
/// When the vehicle must have forgotten a modify (SPI 7.12), and 100 ms.
const LAPSE: Duration = Duration::from_millis(5100);
/// When the vehicle must have resumed its suspended mission (SPI 8.1), and 100 ms.
const STATION_LAPSE: Duration = Duration::from_millis(2100);
/// A vehicle whose estimate was wrong returns to where it should be at least this fast, m/s.
const CORRECTION_MPS: f64 = 0.5;

/// Judges what the vehicle truly did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Conduct {
    last: Option<(Moment, Activity)>,
    commanded_until: Option<Moment>,
    /// Since our last command it has been on its plan, or others have led it elsewhere.
    is_back: bool,
    /// When the vehicle accepted a cancel of ours. After it, the vehicle may be on its way until it is on its plan
    /// again.
    cancelled: Option<Moment>,
    survey: Survey,
    /// How far the vehicle is from its estimated position, metres.
    error_m: f64,
    depth_error_m: f64,
    /// How far the vehicle may be from where it should be, because its estimate is or was wrong, metres.
    astray_m: f64,
    depth_astray_m: f64,
    outside: Excursion,
    depth: Excursion,
    grounded: Excursion,
    margin: Excursion,
    margin_judged: Option<Moment>,
    margins_noted: Option<Moment>,
    outlived: Excursion,
    station_outlived: Excursion,
    reports: u64,
    judged: u64,
    insert: Duration,
    modified: Duration,
}

/// Reports a lasting breach once.
#[derive(Clone, Copy, Debug, Default)]
struct Excursion(bool);

/// What else the judgement needs.
pub(crate) struct Context<'a> {
    pub(crate) area: &'a Area,
    pub(crate) plan: &'a Plan,
    pub(crate) tracking_error_m: f64,
    /// The position that the vehicle reported last, if it is recent.
    pub(crate) believed: Option<Fix>,
    /// What the vehicle has received, and when.
    pub(crate) delivery: &'a Delivery,
    pub(crate) link_delay: Duration,
}

impl Conduct {
    /// The number of reports, the number of them that were compared with the fence, seconds of inserts, seconds of
    /// modifies.
    pub(crate) fn counts(&self) -> (u64, u64, f64, f64) {
        (
            self.reports,
            self.judged,
            self.insert.as_secs_f64(),
            self.modified.as_secs_f64(),
        )
    }

    /// The vehicle accepted a cancel of ours, for what it flew or for what was to come.
    pub(crate) fn cancelled(&mut self, at: Moment) {
        self.cancelled = Some(at);
    }

    /// The vehicle has taken control back, or ends its mission: from now on, what it does is its own doing.
    pub(crate) const fn taken(&mut self) {
        self.is_back = true;
    }

    /// Sets how far the vehicle is from its estimated position and depth, metres.
    pub(crate) fn believed(&mut self, error_m: f64, depth_error_m: f64) {
        (self.error_m, self.depth_error_m) = (error_m, depth_error_m);
    }

    pub(crate) fn judge(&mut self, at: Moment, truth: &Truth, context: &Context<'_>, findings: &mut Findings) {
        self.reports += 1;
        let mut passed = Duration::ZERO;
        if let Some((before, activity)) = self.last {
            passed = at.since(before);
            match activity {
                Activity::Insert(_) => self.insert += passed,
                Activity::Modified => self.modified += passed,
                Activity::Plan | Activity::Suspended | Activity::Other => {}
            }
        }
        self.last = Some((at, truth.activity));
        let corrected_m = CORRECTION_MPS * passed.as_secs_f64();
        self.astray_m = (self.astray_m - corrected_m).max(self.error_m);
        self.depth_astray_m = (self.depth_astray_m - corrected_m).max(self.depth_error_m);
        self.judge_lapses(at, truth, context, findings);

        let commanded = match truth.activity {
            Activity::Insert(_) | Activity::Modified => {
                self.commanded_until = Some(at);
                self.is_back = false;
                true
            }
            Activity::Plan => {
                let since = self.commanded_until.map(|until| at.since(until));
                let follows = since.is_some_and(|since| since <= CONSEQUENCE || since <= WAY_BACK && !self.is_back);
                if !follows {
                    self.commanded_until = None;
                }
                let cancelled = self
                    .cancelled
                    .is_some_and(|since| at.since(since) <= CANCEL_CONSEQUENCE);
                if !cancelled {
                    self.cancelled = None;
                }
                if !follows && !cancelled {
                    return;
                }
                false
            }
            // Hovering is judged by the boxes in the vehicle's own frame: polygons on the chart say little beside a
            // hull.
            Activity::Suspended => return,
            Activity::Other => {
                self.commanded_until = None;
                self.cancelled = None;
                return;
            }
        };
        self.judged += 1;
        self.judge_whereabouts((at, truth), commanded, context, findings);
        if matches!(truth.activity, Activity::Insert(_)) {
            self.judge_margin((at, truth), context, findings);
        }
    }

    /// Judges whether a modify or suspension has lapsed in time by the vehicle's own clock.
    fn judge_lapses(&mut self, at: Moment, truth: &Truth, context: &Context<'_>, findings: &mut Findings) {
        let over = |last: Option<Moment>, lapse: Duration| {
            last.is_none_or(|last| at.since(last) > lapse + context.delivery.delay(context.link_delay))
        };
        match truth.activity {
            Activity::Modified => findings.judge(Rule::ModifyOutlives),
            Activity::Suspended => findings.judge(Rule::StationOutlives),
            Activity::Plan | Activity::Insert(_) | Activity::Other => {}
        }
        let delay = context.delivery.delay(context.link_delay);
        let mut lasts = |margin: Margin, last: Option<Moment>, lapse: Duration| {
            if let Some(last) = last {
                findings.near(margin, at.since(last).as_secs_f64(), (lapse + delay).as_secs_f64());
            }
        };
        match truth.activity {
            Activity::Modified => lasts(Margin::ModifyLasts, context.delivery.last_modify(), LAPSE),
            Activity::Suspended => lasts(Margin::StationLasts, context.delivery.last_station(), STATION_LAPSE),
            Activity::Plan | Activity::Insert(_) | Activity::Other => {}
        }
        let last = context.delivery.last_modify();
        let outlived = truth.activity == Activity::Modified && over(last, LAPSE);
        self.outlived
            .tell(outlived, findings, at, Rule::ModifyOutlives, || match last {
                Some(last) => format!("a modify was still active, although the last BPRMB dates from {last}"),
                None => "a modify was active without any BPRMB".to_owned(),
            });
        let last = context.delivery.last_station();
        let outlived = truth.activity == Activity::Suspended && over(last, STATION_LAPSE);
        self.station_outlived
            .tell(outlived, findings, at, Rule::StationOutlives, || match last {
                Some(last) => format!("a suspension was still active, although the last refresh dates from {last}"),
                None => "a suspension was active without any BPSUS".to_owned(),
            });
    }

    fn judge_whereabouts(
        &mut self,
        (at, truth): (Moment, &Truth),
        commanded: bool,
        context: &Context<'_>,
        findings: &mut Findings,
    ) {
        let point = context.area.point(truth.position);
        self.survey.at(point, context.area);
        let (mut inside, mut depth_allowed, mut excluded) = self.where_it_is(truth, commanded, context.area);
        let mut out = !inside || excluded.is_some();
        // What an error of navigation explains is not a violation.
        if out && self.astray_m > 0.0 {
            self.survey.anew(point, context.area);
            (inside, depth_allowed, excluded) = self.where_it_is(truth, commanded, context.area);
            out = (!inside || excluded.is_some()) && self.survey.spare_m() > self.astray_m;
        }
        let planned = || context.plan.passes(point, context.tracking_error_m + self.astray_m);
        let excused = !commanded && planned();
        if excused {
            // The vehicle is on its own plan again.
            self.cancelled = None;
            self.is_back = true;
        }
        out &= !excused;
        let edge_m = self.survey.spare_m();
        let place = || {
            format!(
                "{:.6} {:.6}, {:.1} m deep, {:?}",
                truth.position.latitude_deg, truth.position.longitude_deg, truth.depth_m, truth.activity
            )
        };
        if commanded {
            self.note_margins(at, (point, truth), context.area, findings);
        }
        let rule = if commanded || self.cancelled.is_none() {
            Rule::TruthFence
        } else {
            Rule::TruthCancel
        };
        for judged in [rule, Rule::TruthDepth] {
            findings.judge(judged);
        }
        if commanded {
            findings.judge(Rule::TruthGrounded);
        }
        let excluded = excluded.and_then(|index| context.area.zone(index));
        self.outside.tell(out, findings, at, rule, || match excluded {
            Some(zone) => format!("in keep-out zone {} at {}", zone.name, place()),
            None => format!("in no keep-in zone at {}, about {edge_m:.1} m from an edge", place()),
        });
        let depth = inside && !depth_allowed && !excused;
        self.depth.tell(depth, findings, at, Rule::TruthDepth, || {
            format!("outside the depths of every keep-in zone at {}", place())
        });
        // An altitude of NaN is no clearance.
        let grounded = commanded && (truth.altitude_m <= 0.0 || truth.altitude_m.is_nan());
        self.grounded.tell(grounded, findings, at, Rule::TruthGrounded, || {
            format!("altitude {:.2} m at {}", truth.altitude_m, place())
        });
    }

    /// Judges the vehicle's estimate of its position while it flies an insert. A correction of navigation moves the
    /// estimate at once, by no more than its error against the truth.
    fn judge_margin(&mut self, (at, truth): (Moment, &Truth), context: &Context<'_>, findings: &mut Findings) {
        let Some(fix) = context.believed else { return };
        let apart_m = Line::between(truth.position, fix.position).length_m();
        if apart_m > self.astray_m + APART_MAX_M {
            // The vehicle believes nothing of the kind: the sentence was damaged so that its checksum is still right.
            return;
        }
        let recent = |judged: Moment| at.since(judged) < MARGIN_EVERY;
        // The true position is no further from the estimate than the error.
        if self.margin_judged.is_some_and(recent)
            || self.survey.spare_m() > context.area.margin_max_m() + self.error_m && !self.outside.0
        {
            return;
        }
        self.margin_judged = Some(at);
        findings.judge(Rule::InsertMargin);
        let plane = Plane::at(context.area.point(fix.position));
        let depths_m = [fix.depth_m - self.depth_astray_m, fix.depth_m + self.depth_astray_m];
        let slack_m = MARGIN_SLACK_M + self.astray_m;
        let zone = context.area.margin_broken(&plane, [0.0, 0.0], &depths_m, slack_m);
        self.margin.tell(zone.is_some(), findings, at, Rule::InsertMargin, || {
            format!(
                "the vehicle estimates that it is at {:.6} {:.6}, {:.1} m deep: over {slack_m:.1} m into the margin of \
                 zone {}",
                fix.position.latitude_deg,
                fix.position.longitude_deg,
                fix.depth_m,
                zone.map_or("", |zone| &zone.name)
            )
        });
    }

    /// How near the vehicle is to what is forbidden. Twice a second is enough: it moves by a metre or two.
    fn note_margins(&mut self, at: Moment, (point, truth): (Point, &Truth), area: &Area, findings: &mut Findings) {
        if self.margins_noted.is_some_and(|noted| at.since(noted) < MARGIN_EVERY) {
            return;
        }
        self.margins_noted = Some(at);
        findings.near(Margin::Altitude, truth.altitude_m, 0.0);
        let known = findings
            .margins()
            .nearest(Margin::Clearance)
            .map_or(f64::INFINITY, |known| known.value);
        let (clearance_m, depth_room_m) = area.room(point, truth.depth_m, self.survey.spare_m() < known);
        findings.near(Margin::DepthRoom, depth_room_m, 0.0);
        findings.near(Margin::Clearance, clearance_m, 0.0);
    }

    /// Returns whether any keep-in zone contains the vehicle, whether one of those allows its depth, and which keep-out
    /// zone contains it.
    fn where_it_is(&self, truth: &Truth, commanded: bool, area: &Area) -> (bool, bool, Option<usize>) {
        let slack_m = DEPTH_SLACK_M + self.depth_astray_m;
        let (mut inside, mut depth_allowed, mut excluded) = (false, false, None);
        for index in &self.survey.surroundings().zones {
            let Some(zone) = area.zone(*index) else { continue };
            match zone.kind {
                Kind::KeepIn => {
                    inside = true;
                    // The depth under the vehicle's own plan is its own doing; only a depth that is too great can be
                    // ours.
                    let too_shallow = commanded && truth.depth_m < zone.depth_min_m - slack_m;
                    depth_allowed |= !too_shallow && truth.depth_m <= zone.depth_max_m + slack_m;
                }
                Kind::KeepOut => {
                    let band = zone.depth_min_m + slack_m..=zone.depth_max_m - slack_m;
                    if !zone.timed && band.contains(&truth.depth_m) {
                        excluded = Some(*index);
                    }
                }
            }
        }
        (inside, depth_allowed, excluded)
    }
}

impl Excursion {
    fn tell(&mut self, now: bool, findings: &mut Findings, at: Moment, rule: Rule, text: impl FnOnce() -> String) {
        if now && !self.0 {
            findings.add(at, rule, text);
        }
        self.0 = now;
    }
}

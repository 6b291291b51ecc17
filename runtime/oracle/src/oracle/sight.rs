use super::Oracle;
use crate::judged::{Judged, Side};
use crate::moment::Moment;
use crate::rule::Rule;
use crate::services::Silence;

/// What a record does not have, and what the oracle can judge without it.
impl Oracle {
    /// There is a gap in the record from one time until another. Everything that depends on it is unknown until the
    /// record shows it again: who has control, which requests are alive, waiting or being flown, the operator's hold,
    /// navigation. The oracle reports no violation that depends on what it does not know. Sentences that were recorded
    /// before the gap still count.
    pub fn gap(&mut self, from_ns: u64, until_ns: u64) {
        let at = Moment::from_nanos(until_ns);
        self.pass_time(Moment::from_nanos(from_ns));
        self.now = self.now.max(at);
        self.blind = true;
        let change = self.control.lose_sight(at);
        self.control_changed(at, change);
        self.lease.forget(at);
        self.station.forget(at);
        self.inserts.forget();
        self.flown = None;
        self.operator.releases();
        self.process.begins(at);
        self.navigation.forget(at);
        self.integrity.cut();
        self.clock.forget();
        self.flaws.clear();
        self.pause.clear();
        self.frame_moved = None;
        self.plan_heard = true;
        self.begin_heard = true;
        self.trigger.forget();
        self.acoustic.forget();
        self.silence = Silence::default();
        self.heartbeat.forget(at);
        self.dive.forget();
        self.from_vehicle.resume();
        self.to_vehicle.resume();
        self.arriving.resume();
    }

    /// A previous run gave the identifiers below this one.
    pub fn identifiers_from(&mut self, first: u32) {
        self.inserts.begin_with(first);
    }

    /// How often each rule was judged and broken until now. Call it before [`Oracle::finish`].
    #[must_use]
    pub fn rules(&self) -> Vec<Judged> {
        let told = Rule::ALL.into_iter().filter(|rule| *rule != Rule::Omitted);
        told.map(|rule| {
            let (judged, broken) = self.findings.of(rule);
            Judged {
                rule: rule.name(),
                requirement: rule.requirement(),
                side: rule.side(),
                judged,
                broken,
                unjudged: (judged == 0).then(|| self.why_unjudged(rule)),
            }
        })
        .collect()
    }

    fn why_unjudged(&self, rule: Rule) -> &'static str {
        let (truths, ..) = self.conduct.counts();
        match (rule, rule.side()) {
            (_, Side::Truth) if truths == 0 => "no true position is recorded",
            (_, Side::Arrived) if !self.delivery.is_told() => {
                "the record does not say when our sentences arrived at the vehicle"
            }
            (Rule::OperatorOnly | Rule::MovesTruth, _) if self.limits.operator_commands => {
                "the mission allows the operator to order them"
            }
            (Rule::RequestBox, _) if self.limits.hull_box.is_none() && self.limits.bottom_box.is_none() => {
                "the mission has no box"
            }
            (Rule::BottomUnknown, _) if self.limits.water_depth_known => "the mission says how deep the water is",
            (Rule::PlanUnknown, _) if !self.plan_heard => "the vehicle reported no plan, and no insert was sent",
            (_, Side::Sent | Side::Heard | Side::Operator | Side::Arrived | Side::Truth) => "no case of it occurred",
        }
    }

    /// Bytes after a gap show that the link is up, even if the record does not have the moment at which it came up.
    pub(super) fn sees_bytes(&mut self, at: Moment) {
        if self.blind && !self.control.is_up() {
            let change = self.control.lose_sight(at);
            self.control_changed(at, change);
            let change = self.control.seems_up(at);
            self.control_changed(at, change);
        }
    }
}

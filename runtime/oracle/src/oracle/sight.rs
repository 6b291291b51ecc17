use super::Oracle;
use crate::judged::{Judged, Side};
use crate::moment::Moment;
use crate::rule::Rule;
use crate::services::Silence;

/// What a run does not tell, and what can be judged all the same.
impl Oracle {
    /// Nobody has written down what was said from one time until another. Whatever hangs on that is unknown until the
    /// run tells it again: whose control is, what is alive, waits or is flown, the operator's hold, navigation. Nothing is
    /// claimed of it. Sentences that were written down before remain what they were.
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

    /// Identifiers below this one were given before the run began, by a previous run.
    pub fn identifiers_from(&mut self, first: u32) {
        self.inserts.begin_with(first);
    }

    /// How each rule fared until now; to be asked before [`Oracle::finish`].
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
            (_, Side::Truth) if truths == 0 => "no truth",
            (_, Side::Arrived) if !self.delivery.is_told() => "when our sentences arrived at the vehicle is not known",
            (Rule::OperatorOnly | Rule::MovesTruth, _) if self.limits.operator_commands => {
                "the mission lets its operator order them"
            }
            (Rule::RequestBox, _) if self.limits.hull_box.is_none() && self.limits.bottom_box.is_none() => {
                "the mission has no box"
            }
            (Rule::BottomUnknown, _) if self.limits.water_depth_known => "the mission says how deep the water is",
            (Rule::PlanUnknown, _) if !self.plan_heard => "no plan was told, and no insert was sent",
            (_, Side::Sent | Side::Heard | Side::Operator | Side::Arrived | Side::Truth) => "it never came to it",
        }
    }

    /// Bytes come or go after a gap: the link is up, though nobody has written down when it came up.
    pub(super) fn sees_bytes(&mut self, at: Moment) {
        if self.blind && !self.control.is_up() {
            let change = self.control.lose_sight(at);
            self.control_changed(at, change);
            let change = self.control.seems_up(at);
            self.control_changed(at, change);
        }
    }
}

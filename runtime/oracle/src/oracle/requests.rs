use std::f64::consts::TAU;
use std::time::Duration;

use super::{Oracle, RECENT, STEADY};
use crate::area::Fault;
use crate::earth::Line;
use crate::inserts::Insert;
use crate::margin::Margin;
use crate::moment::Moment;
use crate::rule::Rule;
use crate::services::Rated;
use crate::time_of_day::TimeOfDay;
use crate::wire::{Modify, Ours, Request, Setpoint, Speed, Trackcircle, Trackline};

/// A stop of the runtime that is longer than this ends every lease: half a second late, plus a second for the wake-up
/// that was due next.
const SLEPT_MAX: Duration = Duration::from_millis(1600);
/// For so long after a bottom lock the depth of the water counts as known.
const LOCK_LASTS: Duration = Duration::from_secs(5);
/// How much the three decimals of a sentence can change a place, metres.
const PLACE_SLACK_M: f64 = 0.001;
/// How much the three decimals of a sentence can change a speed, m/s.
const SPEED_SLACK_MPS: f64 = 0.001;

impl Oracle {
    /// Judges what a sentence of ours asks for. `denied` is true if we certainly do not have control.
    pub(super) fn we_say(&mut self, at: Moment, request: &Request, denied: bool) {
        // Only BPLOG has no time of its own.
        self.heartbeat.we_say(at, request);
        let Some(created) = request.created else { return };
        match &request.asks {
            Ours::Suspend => {
                self.delivery.sent_station(at);
                let (counts, due) = (self.control.is_up() && !denied, self.end_due());
                self.findings.judge(Rule::StationGap);
                self.station.suspend(at, counts, due, &mut self.findings);
            }
            Ours::Continue => self.keep_station(at, denied),
            Ours::HullPosition(place_m) => {
                self.judge_move(at, "BPGHP", self.limits.hull_box, place_m.map(Some));
                self.keep_station(at, denied);
            }
            Ours::BottomPosition { x_m, y_m, vertical } => {
                let depth_m = match vertical {
                    Setpoint::Depth(metres) => Some(*metres),
                    Setpoint::Altitude(_) => None,
                };
                let place_m = [Some(*x_m), Some(*y_m), depth_m];
                self.judge_move(at, "BPGBP", self.limits.bottom_box, place_m);
                self.keep_station(at, denied);
            }
            Ours::Resume => self.station.end(at, &mut self.findings),
            Ours::Modify(modify) => self.judge_modify(at, (created, modify), denied),
            Ours::EndModify => {
                self.counts.end_modifies += 1;
                self.lease.end(at, &mut self.findings);
            }
            Ours::Trackline(line) => self.judge_trackline(at, created, line),
            Ours::Trackcircle(circle) => self.judge_trackcircle(at, created, circle),
            Ours::Cancel { identifier } => {
                let is_ours = self.inserts.is_ours(*identifier);
                if is_ours.is_some() {
                    self.findings.judge(Rule::CancelForeign);
                }
                if is_ours == Some(false) {
                    self.findings.add(at, Rule::CancelForeign, || {
                        format!("BPRCN for insert {identifier}, which was never sent")
                    });
                }
                self.inserts.cancel_sent(created, *identifier);
            }
            Ours::RequestPlan => {
                self.plan.asked();
                self.dive.asked(at, created);
                self.inserts.plan_asked(at, created);
            }
            Ours::FrameMoves => self.frame_moves(at),
            Ours::DvlTrigger { external, triggering } => {
                let heard = self.process.heard_until(at, self.sure());
                self.trigger
                    .we_say(at, *external, *triggering, heard, &mut self.findings);
            }
            Ours::Silent { silent } => self.silence.we_say(at, created, *silent, &mut self.findings),
            Ours::Topside => self.asked(at, Rated::Topside),
            Ours::LogMessage => self.asked(at, Rated::Message),
            Ours::Device => self.asked(at, Rated::Device),
            Ours::Packet => {
                self.acoustic.packet(at, self.sure(), &mut self.findings);
                self.asked(at, Rated::Packet);
            }
            Ours::GpsHit { identifier, position } => {
                let insert = Insert {
                    cancellable: false,
                    ..Insert::new(*b"RGP", at, created, 0.0)
                };
                self.insert_sent(at, *identifier, insert);
                self.findings.judge(Rule::RequestSurfacing);
                if !self.area.may_surface(*position) {
                    self.findings.add(at, Rule::RequestSurfacing, || {
                        format!("BPRGP {identifier} at a place where no zone allows surfacing")
                    });
                }
            }
            Ours::Subscribe { .. } | Ours::Other => {}
        }
    }

    /// Judges a sentence that refreshes a suspension.
    fn keep_station(&mut self, at: Moment, denied: bool) {
        self.delivery.sent_station(at);
        let (counts, due) = (self.control.is_up() && !denied, self.end_due());
        self.findings.judge(Rule::StationGap);
        self.findings.judge(Rule::StationDead);
        if !self.station.keep(at, counts, due, &mut self.findings) && !denied {
            self.findings.add(at, Rule::StationDead, || {
                "a sentence that refreshes a suspension, or moves the vehicle, without a BPSUS before it".to_owned()
            });
        }
    }

    fn asked(&mut self, at: Moment, what: Rated) {
        self.quota.asked(at, what, &self.limits.caps, &mut self.findings);
    }

    fn judge_modify(&mut self, at: Moment, (created, modify): (TimeOfDay, &Modify), denied: bool) {
        self.counts.modifies += 1;
        // If control is just being lost, the lease that this BPRMB opens ends with it.
        let opens = !self.lease.is_alive();
        if opens && !denied {
            self.judge_pause(at);
        }
        let slept = self.process.slept();
        if slept > SLEPT_MAX {
            self.findings.judge(Rule::LeaseAfterStop);
        }
        if opens && self.lease.is_unended() && slept > SLEPT_MAX && !denied {
            self.findings.add(at, Rule::LeaseAfterStop, || {
                format!(
                    "BPRMB continues a lease after the runtime was stopped for {:.1} s",
                    slept.as_secs_f64()
                )
            });
        }
        self.delivery.sent_modify(at, created);
        let unsteady = self.unsteady(at);
        let jump_due = unsteady.map(|jump| self.jump_due(jump.at));
        let due = [self.end_due(), jump_due]
            .into_iter()
            .flatten()
            .min_by_key(|due| due.by);
        let counts = self.control.is_up() && !denied;
        // A fault that is reported for the whole lease is not reported again for each of its sentences.
        if jump_due.is_some() || self.frame_moved.is_some() {
            self.findings.judge(Rule::JumpIgnored);
        }
        let jumped = opens && jump_due.is_some_and(|due| due.is_missed(at));
        if jumped && !denied {
            let steps_m = unsteady.map_or(0.0, |jump| jump.step_m);
            self.findings.add(at, Rule::JumpIgnored, || {
                format!("BPRMB was sent although navigation jumped by {steps_m:.0} m within the last 10 s")
            });
        }
        if let Some(moved) = self.frame_moved
            && !denied
            && at.since(moved) < STEADY
        {
            self.findings.add(at, Rule::JumpIgnored, || {
                format!("BPRMB was sent although we told the vehicle at {moved} that it is elsewhere")
            });
        }
        let counts = counts && !jumped;
        if counts {
            for rule in [Rule::ModifyGap, Rule::ModifyAbandoned, Rule::ModifyUnanswered] {
                self.findings.judge(rule);
            }
        }
        self.findings.judge(Rule::ModifyTooFast);
        self.lease
            .modify(at, created, counts, self.runtime_late, due, &mut self.findings);
        // A modify without control, which the vehicle refuses, is reported once, by the rule for control.
        if denied {
            return;
        }
        self.findings.judge(Rule::StaleNavigation);
        self.findings.judge(Rule::ModifyInherits);
        if let Some(age) = self.navigation_age(at) {
            let allowed = self.navigation_age_allowed();
            self.findings
                .near(Margin::NavigationAge, age.as_secs_f64(), allowed.as_secs_f64());
        }
        if self.is_stale(at, Duration::ZERO) && self.lease.tell_stale() {
            let age = self.navigation_age(at);
            self.findings.add(at, Rule::StaleNavigation, || match age {
                Some(age) => format!("BPRMB was sent while navigation was {:.3} s old", age.as_secs_f64()),
                None => "BPRMB was sent without any navigation on this connection".to_owned(),
            });
        }
        if !modify.complete {
            self.findings.add(at, Rule::ModifyInherits, || {
                "BPRMB leaves heading, vertical, speed or a mode to the current behavior".to_owned()
            });
        }
        if let Some(heading) = modify.heading_deg
            && !(0.0..=360.0).contains(&heading)
        {
            self.findings.add(at, Rule::Malformed, || {
                format!("BPRMB with heading {heading}: expected 0 to 360")
            });
        }
        self.judge_consequence(at, modify, opens);
        if let Some(speed_mps) = modify.speed_mps {
            self.judge_speed(at, "BPRMB", Speed::MetresPerSecond(speed_mps));
        }
        let Some(setpoint) = modify.vertical else { return };
        self.judge_bottom(at, "BPRMB", setpoint);
        self.findings.judge(Rule::RequestVertical);
        let verdict = self.area.judge_setpoint(setpoint);
        self.tell_fault(at, "BPRMB", verdict);
    }

    /// Judges where a BPRMB leads from the position that the vehicle reports.
    fn judge_consequence(&mut self, at: Moment, modify: &Modify, opens: bool) {
        let told = self.navigation.heard_for_sure(at, self.sure());
        let Some(told) = told.filter(|told| at.since(told.at) < RECENT) else {
            return;
        };
        let rule = if opens { Rule::ModifyFence } else { Rule::RefreshFence };
        self.findings.judge(rule);
        self.findings.judge(Rule::ModifyMargin);
        if let Some(text) = self.consequence.judge(modify, &told.fix, &self.area) {
            self.findings
                .add(at, rule, || format!("BPRMB leads out of the fence: {text}"));
            return;
        }
        let newest = self.navigation.newest().unwrap_or(told);
        if let Some(text) = self
            .consequence
            .judge_margin(modify, [&told.fix, &newest.fix], &self.area)
        {
            self.findings
                .add(at, Rule::ModifyMargin, || format!("BPRMB leads into a margin: {text}"));
        }
    }

    fn judge_trackline(&mut self, at: Moment, created: TimeOfDay, line: &Trackline) {
        let length_m = Line::between(line.start, line.end).length_m();
        let insert = Insert {
            interrupts: line.interrupts,
            ..Insert::new(*b"RTK", at, created, self.duration_s(length_m, line.speed))
        };
        self.insert_sent(at, line.identifier, insert);
        let what = format!("BPRTK {}", line.identifier);
        self.judge_speed(at, &what, line.speed);
        self.judge_bottom(at, &what, line.vertical);
        self.judge_shape();
        let verdict = self.area.judge_leg(line.start, line.end, line.vertical);
        self.tell_fault(at, &what, verdict);
    }

    fn judge_trackcircle(&mut self, at: Moment, created: TimeOfDay, circle: &Trackcircle) {
        let length_m = TAU * circle.radius_m.abs() * circle.orbits.abs();
        let insert = Insert {
            interrupts: circle.interrupts,
            ..Insert::new(*b"RTC", at, created, self.duration_s(length_m, circle.speed))
        };
        self.insert_sent(at, circle.identifier, insert);
        let what = format!("BPRTC {}", circle.identifier);
        self.judge_speed(at, &what, circle.speed);
        self.judge_bottom(at, &what, circle.vertical);
        self.judge_shape();
        let verdict = self.area.judge_circle(circle.centre, circle.radius_m, circle.vertical);
        self.tell_fault(at, &what, verdict);
    }

    /// Judges whether a lease begins too soon after the vehicle refused one.
    fn judge_pause(&mut self, at: Moment) {
        if !self.pause.is_any() {
            return;
        }
        self.findings.judge(Rule::PauseIgnored);
        let heard = self.process.heard_until(at, self.sure());
        if let Some((refused, pause)) = self.pause.standing(at, heard) {
            self.findings.add(at, Rule::PauseIgnored, || {
                let pause_s = pause.as_secs_f64();
                format!("a lease began although the vehicle refused one at {refused}, less than {pause_s:.0} s before")
            });
        }
    }

    /// We tell the vehicle that it is elsewhere. Every lease and station keeping, which use the old position, must have
    /// ended before.
    fn frame_moves(&mut self, at: Moment) {
        self.findings.judge(Rule::JumpIgnored);
        if self.lease.is_alive() || self.station.is_alive() {
            self.findings.add(at, Rule::JumpIgnored, || {
                "we told the vehicle that it is elsewhere while a lease or station keeping was alive".to_owned()
            });
        }
        self.frame_moved = Some(at);
    }

    fn insert_sent(&mut self, at: Moment, identifier: u32, insert: Insert) {
        if self.control.is_granted() {
            self.findings.judge(Rule::PlanUnknown);
        }
        if !self.plan_heard && self.control.is_granted() {
            self.findings.add(at, Rule::PlanUnknown, || {
                format!("insert {identifier} was sent although the vehicle has reported no part of its plan")
            });
        }
        self.findings.judge(Rule::BeginUnheard);
        if !self.begin_heard && self.control.is_granted() {
            self.findings.add(at, Rule::BeginUnheard, || {
                format!("insert {identifier} was sent although the vehicle has reported no begin on this connection")
            });
        }
        let total_max = self.limits.inserts_total_max;
        self.inserts.sent(at, identifier, insert, total_max, &mut self.findings);
    }

    /// How long a path takes, seconds. For a speed in turns of the thruster, which says nothing about metres per
    /// second, the slowest speed is used.
    fn duration_s(&self, length_m: f64, speed: Speed) -> f64 {
        let speed_mps = match speed {
            Speed::MetresPerSecond(speed_mps) => speed_mps,
            Speed::Rpm(_) => self.limits.speed_min_mps,
        };
        length_m / speed_mps.max(0.1)
    }

    /// Judges an altitude setpoint: it has a known depth only if the depth of the water is known.
    fn judge_bottom(&mut self, at: Moment, what: &str, setpoint: Setpoint) {
        if self.limits.water_depth_known || !matches!(setpoint, Setpoint::Altitude(_)) {
            return;
        }
        self.findings.judge(Rule::BottomUnknown);
        let heard = self
            .navigation
            .locked()
            .map(|locked| self.process.heard(locked) + self.sure());
        if heard.is_none_or(|heard| at.since(heard) > LOCK_LASTS) {
            self.findings.add(at, Rule::BottomUnknown, || {
                format!("{what}: {setpoint}, but the vehicle has reported no bottom lock for over 5 s")
            });
        }
    }

    /// Judges where a suspended vehicle is sent: each coordinate of the sentence must be within the mission's box.
    fn judge_move(&mut self, at: Moment, name: &str, bounds_m: Option<[[f64; 2]; 3]>, place_m: [Option<f64>; 3]) {
        let Some(bounds_m) = bounds_m else { return };
        self.findings.judge(Rule::RequestBox);
        for ([from_m, to_m], metres) in bounds_m.into_iter().zip(place_m) {
            if let Some(metres) = metres
                && !(from_m - PLACE_SLACK_M..=to_m + PLACE_SLACK_M).contains(&metres)
            {
                self.findings.add(at, Rule::RequestBox, || {
                    format!("{name} to {metres} m: expected {from_m} to {to_m} m")
                });
            }
        }
    }

    /// Judges a speed through the water. A speed in turns of the thruster is not judged, because it says nothing about
    /// metres per second.
    fn judge_speed(&mut self, at: Moment, what: &str, speed: Speed) {
        let Speed::MetresPerSecond(speed_mps) = speed else {
            return;
        };
        self.findings.judge(Rule::RequestSpeed);
        let (min, max) = (self.limits.speed_min_mps, self.limits.speed_max_mps);
        if !(min - SPEED_SLACK_MPS..=max + SPEED_SLACK_MPS).contains(&speed_mps) {
            self.findings.add(at, Rule::RequestSpeed, || {
                format!("{what} at {speed_mps} m/s: expected {min} to {max} m/s")
            });
        }
    }

    fn judge_shape(&mut self) {
        self.findings.judge(Rule::RequestFence);
        self.findings.judge(Rule::RequestVertical);
    }

    fn tell_fault(&mut self, at: Moment, what: &str, verdict: Result<(), Fault>) {
        let (rule, text) = match verdict {
            Ok(()) => return,
            Err(Fault::Horizontal(text)) => (Rule::RequestFence, text),
            Err(Fault::Vertical(text)) => (Rule::RequestVertical, text),
        };
        self.findings.add(at, rule, || format!("{what}: {text}"));
    }
}

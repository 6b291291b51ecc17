use std::time::Duration;

use backseat_spi::{
    HorizontalMode, Interrupt, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode, SpeedMode, ToVehicle, Trackcircle,
    Trackline, VerticalMode, VerticalReference,
};
use backseat_units::Timestamp;

use super::{Oracle, STEADY};
use crate::area::Fault;
use crate::inserts::Insert;
use crate::rule::Rule;
use crate::services::Rated;
use crate::zone::Setpoint;

/// A standstill that is longer ends every lease: half a second late, and a second for the wake-up that was due next.
const SLEPT_MAX: Duration = Duration::from_millis(1600);
/// Navigation that was told so recently says where the vehicle is.
const RECENT: Duration = Duration::from_millis(500);
/// A bottom lock tells the depth of the water for so long.
const LOCK_LASTS: Duration = Duration::from_secs(5);
/// What the wire's three decimals may change of a place, metres.
const PLACE_SLACK_M: f64 = 0.001;
/// What the wire's three decimals may change of a speed, m/s.
const SPEED_SLACK_MPS: f64 = 0.001;

impl Oracle {
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "sentences that no rule is about, those of later versions included"
    )]
    /// Judges what a sentence of ours asks for. `denied` where control surely is not ours.
    pub(super) fn we_say(&mut self, at: Timestamp, message: &ToVehicle, denied: bool) {
        match message {
            ToVehicle::Suspend(_) => {
                self.delivery.sent_hold(at);
                let (counts, due) = (self.control.is_up() && !denied, self.end_due());
                self.hold.suspend(at, counts, due);
            }
            ToVehicle::Continue(_) | ToVehicle::HullPosition(_) | ToVehicle::BottomPosition(_) => {
                self.judge_move(at, message);
                self.delivery.sent_hold(at);
                let (counts, due) = (self.control.is_up() && !denied, self.end_due());
                if !self.hold.keep(at, counts, due) && !denied {
                    self.findings.add(at, Rule::HoldDead, || {
                        "a sentence that keeps a suspension, or moves, without BPSUS before it".to_owned()
                    });
                }
            }
            ToVehicle::Resume(_) => self.hold.end(at),
            ToVehicle::ModifyBehavior(modify) => self.judge_modify(at, modify, denied),
            ToVehicle::EndModify(_) => {
                self.counts.end_modifies += 1;
                self.lease.end(at);
            }
            ToVehicle::Trackline(line) => self.judge_trackline(at, line),
            ToVehicle::Trackcircle(circle) => self.judge_trackcircle(at, circle),
            ToVehicle::CancelBehavior(cancel) => {
                let identifier = cancel.identifier.get();
                if !self.inserts.is_ours(identifier) {
                    self.findings.add(at, Rule::CancelForeign, || {
                        format!("BPRCN for {identifier}, which was never sent")
                    });
                }
                self.inserts.cancel_sent(cancel.created, identifier);
            }
            ToVehicle::RequestPlan(request) => {
                self.plan.asked();
                self.inserts.plan_asked(at, request.created);
            }
            ToVehicle::RelativeReset(_) | ToVehicle::BearingOffset(_) => self.frame_moves(at),
            ToVehicle::DvlTriggerRequest(request) => {
                let (sure, findings) = (self.sure(), &mut self.findings);
                self.trigger
                    .we_say(at, request.external, request.triggering, sure, findings);
            }
            ToVehicle::SilentMode(mode) => {
                self.silence.we_say(at, mode.created, mode.silent, &mut self.findings);
            }
            ToVehicle::TopsideText(_) => {
                let caps = &self.limits.caps;
                self.quota.asked(at, Rated::Topside, caps, &mut self.findings);
            }
            ToVehicle::LogMessage(_) => {
                let caps = &self.limits.caps;
                self.quota.asked(at, Rated::Message, caps, &mut self.findings);
            }
            ToVehicle::SonarAngle(_) | ToVehicle::Camera(_) | ToVehicle::Light(_) => {
                let caps = &self.limits.caps;
                self.quota.asked(at, Rated::Device, caps, &mut self.findings);
            }
            ToVehicle::Packet(_) => {
                self.acoustic.packet(at, self.sure(), &mut self.findings);
                let caps = &self.limits.caps;
                self.quota.asked(at, Rated::Packet, caps, &mut self.findings);
            }
            ToVehicle::GpsHit(hit) => {
                let insert = Insert {
                    cancellable: false,
                    ..Insert::new("RGP", at, hit.created, 0.0)
                };
                self.insert_sent(at, hit.identifier.get(), insert);
                if !self.area.may_surface(hit.position) {
                    self.findings.add(at, Rule::RequestSurfacing, || {
                        format!("BPRGP {} where no zone lets the vehicle surface", hit.identifier.get())
                    });
                }
            }
            _ => {}
        }
    }

    fn judge_modify(&mut self, at: Timestamp, modify: &ModifyBehavior, denied: bool) {
        self.counts.modifies += 1;
        // Where control is just being lost, the lease that this opens ends with it.
        let opens = !self.lease.is_alive();
        let slept = self.process.slept();
        if opens && self.lease.is_unended() && slept > SLEPT_MAX && !denied {
            self.findings.add(at, Rule::LeaseAfterStop, || {
                format!("BPRMB goes on after {:.1} s at a standstill", slept.as_secs_f64())
            });
        }
        self.delivery.sent_modify(at, modify.created);
        let unsteady = self.unsteady(at);
        let jump_due = unsteady.map(|jump| self.jump_due(jump.at));
        let due = [self.end_due(), jump_due]
            .into_iter()
            .flatten()
            .min_by_key(|due| due.by);
        let counts = self.control.is_up() && !denied;
        // What is judged as a whole lease already is not told for each of its sentences.
        let jumped = opens && jump_due.is_some_and(|due| due.is_missed(at));
        if jumped && !denied {
            let steps_m = unsteady.map_or(0.0, |jump| jump.step_m);
            self.findings.add(at, Rule::JumpIgnored, || {
                format!("BPRMB though navigation jumped by {steps_m:.0} m within the last 10 s")
            });
        }
        if let Some(moved) = self.frame_moved
            && !denied
            && at.since(moved) < STEADY
        {
            self.findings.add(at, Rule::JumpIgnored, || {
                format!("BPRMB though the vehicle was told at {moved} that it is elsewhere")
            });
        }
        self.lease
            .modify(at, modify.created, counts && !jumped, due, &mut self.findings);
        // What the vehicle refuses is judged once, as that.
        if denied {
            return;
        }
        if self.is_stale(at, Duration::ZERO) && self.lease.tell_stale() {
            let age = self.navigation.age(at);
            self.findings.add(at, Rule::StaleNavigation, || match age {
                Some(age) => format!("BPRMB while navigation is {:.3} s old", age.as_secs_f64()),
                None => "BPRMB without any navigation on this connection".to_owned(),
            });
        }
        let complete = modify.horizontal.is_some()
            && modify.horizontal_mode.is_some()
            && modify.vertical_m.is_some()
            && modify.vertical_mode.is_some()
            && modify.speed.is_some()
            && modify.speed_mode.is_some();
        if !complete {
            self.findings.add(at, Rule::ModifyInherits, || {
                "BPRMB leaves heading, vertical, speed or a mode to the current behavior".to_owned()
            });
        }
        if modify.horizontal_mode == Some(HorizontalMode::Heading)
            && let Some(heading) = modify.horizontal
            && !(0.0..=360.0).contains(&heading)
        {
            self.findings
                .add(at, Rule::Malformed, || format!("BPRMB with heading {heading}"));
        }
        if let Some(told) = self.navigation.heard_for_sure(at, self.sure())
            && at.since(told.at) < RECENT
            && let Some(text) = self.consequence.judge(modify, &told.fix, &self.area)
        {
            let rule = if opens { Rule::ModifyFence } else { Rule::RefreshFence };
            self.findings
                .add(at, rule, || format!("BPRMB leads out of the fence: {text}"));
        }
        if modify.speed_mode == Some(ModifySpeedMode::MetresPerSecond)
            && let Some(speed) = modify.speed
        {
            self.judge_speed(at, "BPRMB", speed);
        }
        let setpoint = match (modify.vertical_mode, modify.vertical_m) {
            (Some(ModifyVerticalMode::Depth), Some(metres)) => Setpoint::Depth(metres),
            (Some(ModifyVerticalMode::Altitude), Some(metres)) => Setpoint::Altitude(metres),
            (Some(_) | None, Some(_) | None) => return,
        };
        self.judge_bottom(at, "BPRMB", setpoint);
        let verdict = self.area.judge_setpoint(setpoint);
        self.tell_fault(at, "BPRMB", verdict);
    }

    fn judge_trackline(&mut self, at: Timestamp, line: &Trackline) {
        let identifier = line.identifier.get();
        let length_m = self.area.distance_m(line.start, line.end);
        let insert = Insert {
            interrupts: line.interrupt == Interrupt::InterruptCurrent,
            ..Insert::new(
                "RTK",
                at,
                line.created,
                self.duration_s(length_m, line.speed, line.speed_mode),
            )
        };
        self.insert_sent(at, identifier, insert);
        let what = format!("BPRTK {identifier}");
        if line.speed_mode == SpeedMode::MetresPerSecond {
            self.judge_speed(at, &what, line.speed);
        }
        let setpoint = setpoint(line.vertical_mode, line.vertical_m);
        self.judge_bottom(at, &what, setpoint);
        let verdict = self.area.judge_leg(line.start, line.end, setpoint);
        self.tell_fault(at, &what, verdict);
    }

    fn judge_trackcircle(&mut self, at: Timestamp, circle: &Trackcircle) {
        let identifier = circle.identifier.get();
        let length_m = backseat_units::math::TAU * circle.radius_m.abs() * circle.orbits.abs();
        let insert = Insert {
            interrupts: circle.interrupt == Interrupt::InterruptCurrent,
            ..Insert::new(
                "RTC",
                at,
                circle.created,
                self.duration_s(length_m, circle.speed, circle.speed_mode),
            )
        };
        self.insert_sent(at, identifier, insert);
        let what = format!("BPRTC {identifier}");
        if circle.speed_mode == SpeedMode::MetresPerSecond {
            self.judge_speed(at, &what, circle.speed);
        }
        let setpoint = setpoint(circle.vertical_mode, circle.vertical_m);
        self.judge_bottom(at, &what, setpoint);
        let verdict = self.area.judge_circle(circle.centre, circle.radius_m, setpoint);
        self.tell_fault(at, &what, verdict);
    }

    /// We tell the vehicle that it is elsewhere: what steers by where it was has ended before.
    fn frame_moves(&mut self, at: Timestamp) {
        if self.lease.is_alive() || self.hold.is_alive() {
            self.findings.add(at, Rule::JumpIgnored, || {
                "the vehicle is told that it is elsewhere under a lease or a hold".to_owned()
            });
        }
        self.frame_moved = Some(at);
    }

    fn insert_sent(&mut self, at: Timestamp, identifier: u32, insert: Insert) {
        if !self.plan_heard && self.control.is_granted() {
            self.findings.add(at, Rule::PlanUnknown, || {
                format!("insert {identifier} though the vehicle has told nothing of its plan")
            });
        }
        let total_max = self.limits.inserts_total_max;
        self.inserts.sent(at, identifier, insert, total_max, &mut self.findings);
    }

    /// How long a way takes, seconds. What turns make is not known: the slowest speed is taken.
    fn duration_s(&self, length_m: f64, speed: f64, mode: SpeedMode) -> f64 {
        let speed_mps = match mode {
            SpeedMode::MetresPerSecond => speed,
            SpeedMode::Rpm | SpeedMode::Other(_) => self.limits.speed_min_mps,
        };
        length_m / speed_mps.max(0.1)
    }

    /// A height above the seabed is a depth only where the water's is known.
    fn judge_bottom(&mut self, at: Timestamp, what: &str, setpoint: Setpoint) {
        if self.limits.water_depth_known || !matches!(setpoint, Setpoint::Altitude(_)) {
            return;
        }
        let heard = self
            .navigation
            .locked()
            .map(|locked| self.process.heard(locked) + self.sure());
        if heard.is_none_or(|heard| at.since(heard) > LOCK_LASTS) {
            self.findings.add(at, Rule::BottomUnknown, || {
                format!("{what}: {setpoint}, and the vehicle has told of no bottom for over 5 s")
            });
        }
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "sentences that move no vehicle, those of later versions included"
    )]
    /// Where a suspended vehicle is told to go.
    fn judge_move(&mut self, at: Timestamp, message: &ToVehicle) {
        let (name, bounds_m, place_m) = match message {
            ToVehicle::HullPosition(to) => {
                let place_m = [Some(to.horizontal_m), Some(to.vertical_m), Some(to.distance_m)];
                ("BPGHP", self.limits.hull_box, place_m)
            }
            ToVehicle::BottomPosition(to) => {
                let depth_m = (to.reference == VerticalReference::Depth).then_some(to.vertical_m);
                ("BPGBP", self.limits.bottom_box, [Some(to.x_m), Some(to.y_m), depth_m])
            }
            _ => return,
        };
        let Some(bounds_m) = bounds_m else { return };
        for ([from_m, to_m], metres) in bounds_m.into_iter().zip(place_m) {
            if let Some(metres) = metres
                && !(from_m - PLACE_SLACK_M..=to_m + PLACE_SLACK_M).contains(&metres)
            {
                self.findings.add(at, Rule::RequestBox, || {
                    format!("{name} to {metres} m, which is not within {from_m} to {to_m} m")
                });
            }
        }
    }

    fn judge_speed(&mut self, at: Timestamp, what: &str, speed_mps: f64) {
        let (min, max) = (self.limits.speed_min_mps, self.limits.speed_max_mps);
        if !(min - SPEED_SLACK_MPS..=max + SPEED_SLACK_MPS).contains(&speed_mps) {
            self.findings.add(at, Rule::RequestSpeed, || {
                format!("{what}: {speed_mps} m/s is not within {min} to {max}")
            });
        }
    }

    fn tell_fault(&mut self, at: Timestamp, what: &str, verdict: Result<(), Fault>) {
        let (rule, text) = match verdict {
            Ok(()) => return,
            Err(Fault::Horizontal(text)) => (Rule::RequestFence, text),
            Err(Fault::Vertical(text)) => (Rule::RequestVertical, text),
        };
        self.findings.add(at, rule, || format!("{what}: {text}"));
    }
}

fn setpoint(mode: VerticalMode, metres: f64) -> Setpoint {
    match mode {
        VerticalMode::Depth => Setpoint::Depth(metres),
        VerticalMode::Altitude => Setpoint::Altitude(metres),
        VerticalMode::Other(_) => Setpoint::Unknown,
    }
}

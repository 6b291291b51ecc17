use crate::margin::Margin;
use crate::moment::Moment;

use super::{Oracle, RACE};
use crate::rule::Rule;
use crate::wire::{Ours, Request, read_ours};

impl Oracle {
    /// Judges a line of ours: it must be exactly one whole sentence as the specification defines it (SPI 4.2).
    pub(super) fn our_line(&mut self, at: Moment, line: &[u8]) {
        self.counts.sentences_to_vehicle += 1;
        self.findings.looks_at(line);
        self.judge_line(at, line);
        self.findings.passed();
    }

    fn judge_line(&mut self, at: Moment, line: &[u8]) {
        self.findings.judge(Rule::Malformed);
        let request = match read_ours(line) {
            Ok(request) => request,
            Err(fault) => {
                self.findings.add(at, Rule::Malformed, || {
                    let shown: String = String::from_utf8_lossy(line).chars().take(80).collect();
                    format!("{fault}: {}", shown.escape_debug())
                });
                return;
            }
        };
        let name = request.name;
        if let Some(created) = request.created {
            self.findings.judge(Rule::StampRepeated);
            if self.stamps.repeats(name, created) {
                self.findings.add(at, Rule::StampRepeated, || {
                    format!(
                        "{} was sent twice with the time {created}",
                        String::from_utf8_lossy(&name)
                    )
                });
            }
        }
        let mut denied = self.judge_permission(at, &name, &request.asks);
        let is_new = match &name {
            b"BPRTK" | b"BPRTC" | b"BPRGP" => true,
            b"BPRMB" => !self.lease.is_alive() && !self.lease.is_unended(),
            b"BPSUS" => !self.station.is_alive() && !self.station.is_unended(),
            _ => false,
        };
        self.shutdown.we_say(at, &name, is_new, &mut self.findings);
        let due = self.operator_due();
        if due.is_some() && is_dynamic(&name) {
            self.findings.judge(Rule::OperatorHold);
        }
        if !denied && is_dynamic(&name) && due.is_some_and(|due| due.is_missed(at)) {
            self.findings.add(at, Rule::OperatorHold, || {
                format!("{} was sent under the operator's hold", String::from_utf8_lossy(&name))
            });
            denied = true;
        }
        if !denied && is_dynamic(&name) {
            self.judge_answers(at, &request);
        }
        self.we_say(at, &request, denied);
    }

    /// Judges whether a request that steers leaves without proof that the vehicle hears us, or without the plan of the
    /// dive.
    fn judge_answers(&mut self, at: Moment, request: &Request) {
        let name = String::from_utf8_lossy(&request.name);
        self.findings.judge(Rule::Unheard);
        let sure = self.sure();
        let stays = request.asks.is_irrevocable();
        if let Some((left, _)) = self.heartbeat.newest() {
            let (age, allowed) = (at.since(left), self.heartbeat.lasts());
            self.findings
                .near(Margin::RoundTrip, age.as_secs_f64(), allowed.as_secs_f64());
        }
        if !self.heartbeat.is_heard(at) {
            let newest = self.heartbeat.newest();
            self.findings.add(at, Rule::Unheard, || match newest {
                Some((left, _)) => {
                    format!("{name} was sent although the last command that was answered in time left at {left}")
                }
                None => format!("{name} was sent although no command was answered in time on this connection"),
            });
        } else if stays && !self.heartbeat.has_just_answered(at, sure) {
            let newest = self.heartbeat.newest();
            self.findings.add(at, Rule::Unheard, || match newest {
                Some((left, came)) => format!(
                    "{name} cannot be taken back, but the last answer came at {came}, to a command that left at {left}"
                ),
                None => format!("{name} cannot be taken back, but no command was answered"),
            });
        } else if let Some(left) = self.heartbeat.waits().filter(|_| stays) {
            self.findings.add(at, Rule::Unheard, || {
                format!("{name} cannot be taken back, but the BPSTS that left at {left} still waits for its answer")
            });
        }
        self.judge_flaws(at, &name);
        if self.dive.is_named() {
            self.findings.judge(Rule::AnotherDive);
        }
        if let Some(named) = self.dive.unplanned()
            && self.process.heard(named) + sure < at
        {
            self.findings.add(at, Rule::AnotherDive, || {
                format!(
                    "{name} was sent although the vehicle named another dive file at {named} and has not reported \
                     its plan"
                )
            });
        }
    }

    /// Judges whether navigation, and the vehicle's clock, were free of flaws for long enough before a request that
    /// steers.
    fn judge_flaws(&mut self, at: Moment, name: &str) {
        if self.integrity.has_window() {
            self.findings.judge(Rule::NavigationUntrue);
        }
        if self.integrity.has_navigation() {
            self.findings.judge(Rule::VelocityMissing);
        }
        if self.clock.is_known() {
            self.findings.judge(Rule::ClockSet);
        }
        let heard = self.process.heard_until(at, self.sure());
        // A step that is a jump by itself is reported by the rule for jumps.
        let jumped = self.unsteady(at).is_some();
        for flaw in self.flaws.standing(at, heard) {
            if jumped && flaw.what.rule() == Rule::NavigationUntrue {
                continue;
            }
            self.findings.add(at, flaw.what.rule(), || {
                format!("{name} was sent too soon: at {}, {}", flaw.told, flaw.what)
            });
        }
    }

    /// Reports a sentence that needs a permission which we certainly do not have. Returns whether we certainly do not
    /// have control.
    fn judge_permission(&mut self, at: Moment, name: &[u8; 5], asks: &Ours) -> bool {
        if !self.limits.operator_commands {
            self.findings.judge(Rule::OperatorOnly);
            self.findings.judge(Rule::MovesTruth);
            match name {
                b"BPABT" | b"BPKIL" | b"BPRCA" | b"BPRCB" | b"BPRCE" => {
                    self.findings.add(at, Rule::OperatorOnly, || {
                        format!("{} was sent", String::from_utf8_lossy(name))
                    });
                }
                b"BPNPU" | b"BPRNS" | b"BPRBO" | b"BPSEM" => {
                    self.findings.add(at, Rule::MovesTruth, || {
                        format!("{} was sent", String::from_utf8_lossy(name))
                    });
                }
                _ => {}
            }
        }
        match name {
            name if is_dynamic(name) && self.control.is_known() => self.findings.judge(Rule::NoControl),
            b"BPEMB" | b"BPRES" if self.control.is_known() => self.findings.judge(Rule::EndSurplus),
            _ => {}
        }
        let Some(since) = self.control.denied_since() else {
            return false;
        };
        if !is_dynamic(name) {
            self.findings.judge(Rule::NotAllowedWithoutControl);
        }
        if self.process.heard(since) > at - (self.link_delay + RACE) {
            return false;
        }
        let asks_trigger = if let Ours::DvlTrigger { external, .. } = asks {
            self.trigger.asks_anew(*external)
        } else {
            false
        };
        let rule = match name {
            b"BPVER" | b"BPLOG" | b"BPSTS" | b"BPMSG" | b"BPRMP" | b"BPRCN" | b"BPABT" | b"BPKIL" | b"BPTMR" => {
                return true;
            }
            b"BPDVR" if !asks_trigger => return true,
            b"BPEMB" if self.lease.is_unended() => return true,
            b"BPSPD" | b"BPRES" if self.station.is_unended() => return true,
            b"BPEMB" | b"BPRES" => Rule::EndSurplus,
            name if is_dynamic(name) => Rule::NoControl,
            _ => Rule::NotAllowedWithoutControl,
        };
        self.findings.add(at, rule, || {
            format!("{} without control since {since}", String::from_utf8_lossy(name))
        });
        true
    }
}

/// Whether a sentence asks the vehicle to deviate from its plan, or keeps it doing so.
fn is_dynamic(name: &[u8; 5]) -> bool {
    matches!(
        name,
        b"BPRMB" | b"BPRTK" | b"BPRTC" | b"BPRGP" | b"BPSUS" | b"BPCON" | b"BPGHP" | b"BPGBP"
    )
}

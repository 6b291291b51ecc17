use super::Oracle;
use crate::moment::Moment;
use crate::rule::Rule;
use crate::services::Counted;
use crate::wire::{Answer, Fix, Outcome, Said, newest_sentence, read_vehicle};

impl Oracle {
    /// Reads a line of the vehicle. Only its last sentence counts.
    pub(super) fn vehicle_line(&mut self, at: Moment, line: &[u8]) {
        let Some(sentence) = newest_sentence(line) else { return };
        if let Some(said) = read_vehicle(sentence) {
            self.findings.looks_at(sentence);
            self.vehicle_says(at, &said);
            self.findings.passed();
        }
    }

    fn vehicle_says(&mut self, at: Moment, said: &Said<'_>) {
        match said {
            Said::Navigation(fix) => self.navigated(at, *fix),
            Said::Velocities(velocities) => {
                if !self.process.is_stopped()
                    && let Some(flaw) = self.integrity.velocities(velocities)
                {
                    self.flaws.add(flaw);
                }
            }
            Said::Control { granted } => {
                let change = self.control.backseat_control(at, *granted);
                self.control_changed(at, change);
            }
            Said::MissionStatus { dive, running } => {
                self.dive.named_by_status(at, dive);
                let change = self.control.mission_running(at, *running);
                self.control_changed(at, change);
                if !running {
                    self.inserts.all_end();
                }
            }
            Said::MissionCommand(text) => {
                let change = self.control.mission_command(at, text);
                self.control_changed(at, change);
            }
            Said::Shutdown => {
                let heard = self.process.heard(at) + self.sure();
                self.shutdown.said(heard, self.process.is_stopped());
            }
            Said::DvlTriggering { begin } => {
                let heard = self.process.heard(at) + self.link_delay;
                let hears = self.control.is_up() && !self.process.is_stopped();
                self.trigger.vehicle_says(at, *begin, heard, hears);
            }
            Said::Window { created, until } => self.acoustic.window(at, *created, *until),
            Said::Begins {
                dive,
                planned,
                identifier,
            } => {
                self.dive.named_by_behavior(at, dive);
                self.behavior_changed(at);
                self.begin_heard |= *planned || identifier.is_some();
                if let Some(identifier) = identifier {
                    self.inserts.begins(at, *identifier);
                } else if *planned {
                    self.inserts.plan_goes_on(at);
                }
            }
            Said::Ends { identifier } => {
                self.behavior_changed(at);
                if let Some(identifier) = identifier {
                    self.inserts.ends(*identifier);
                }
            }
            Said::Element(element) => {
                self.plan_heard = true;
                let own = element.identifier.is_none();
                self.plan.told(own.then(|| self.area.point(element.position)));
                self.inserts
                    .element(at, (element.number, element.identifier), element.index);
                if self.inserts.take_named() {
                    self.operator.named(at, self.process.is_stopped());
                }
            }
            Said::Answer(answer) => self.answered(at, answer),
        }
    }

    fn navigated(&mut self, at: Moment, fix: Fix) {
        if !self.process.is_stopped()
            && let Some(flaw) = self.integrity.fix(at, fix)
        {
            self.flaws.add(flaw);
        }
        if !self.navigation.heard(at, fix, self.sure()) {
            return;
        }
        self.counts.navigations += 1;
        if let Some(jump) = self.navigation.jump()
            && jump.at == at
        {
            self.lease_must_end(self.jump_due(at));
        }
    }

    /// The vehicle now flies another behavior than the one that was modified.
    fn behavior_changed(&mut self, at: Moment) {
        self.lease_must_end(self.due(at, Rule::LeaseOutlives, "a behavior began or ended"));
    }

    fn answered(&mut self, at: Moment, answer: &Answer) {
        let created = answer.command_created;
        let (command, identifier) = (answer.command, answer.identifier);
        let left = self.heartbeat.answered(at, answer, self.process.is_stopped());
        match left.filter(|_| !self.process.is_stopped()) {
            Some(left) => {
                if let Some(flaw) = self.clock.answered(left, at, answer.created) {
                    self.flaws.add(flaw);
                }
            }
            None => self.clock.unmeasured(at),
        }
        if matches!(&command, b"RMB" | b"NAK") {
            self.lease.answered();
        }
        let taken = match answer.outcome {
            Outcome::Succeeded => true,
            Outcome::Invalid | Outcome::Failed => false,
            Outcome::Pending | Outcome::Other => return,
        };
        let unreadable = answer.outcome == Outcome::Invalid && identifier.is_none() && answer.command_created.is_none();
        let caps = &self.limits.caps;
        match &command {
            b"RTK" | b"RTC" | b"RGP" if unreadable => self.inserts.unreadable(Some(command)),
            b"NAK" if unreadable => self.inserts.unreadable(None),
            b"RMB" if !taken && self.lease.has(created) => {
                if !self.process.is_stopped() {
                    self.pause.refused(at);
                }
                self.lease_must_end(self.due(at, Rule::LeaseOutlives, "the vehicle refused the lease"));
            }
            b"RTK" | b"RTC" | b"RGP" => {
                self.inserts.answered(at, identifier, created, taken);
                if taken {
                    let (open_max, duration_s) = (self.limits.inserts_open_max, self.limits.inserts_duration_max_s);
                    self.inserts.check_open(at, open_max, duration_s, &mut self.findings);
                }
                if taken && command == *b"RGP" {
                    self.quota
                        .taken(at, (Counted::GpsHit, created), caps, &mut self.findings);
                }
            }
            b"RCN" if taken => {
                self.inserts.cancel_done(identifier, created);
                self.conduct.cancelled(at);
            }
            b"RCA" | b"RCB" | b"RCE" if taken => {
                if command == *b"RCA" {
                    self.inserts.all_cancelled();
                }
                self.conduct.cancelled(at);
            }
            b"RMP" => {
                self.plan_heard |= taken;
                if taken {
                    self.dive.planned(created);
                }
                self.inserts.plan_told(created, taken);
            }
            b"TRM" | b"BOY" if taken => self
                .quota
                .taken(at, (Counted::Adjustment, created), caps, &mut self.findings),
            b"SIL" if self.silence.answered(created, taken, caps) => {
                self.quota
                    .taken(at, (Counted::Silence, created), caps, &mut self.findings);
            }
            _ => {}
        }
    }
}

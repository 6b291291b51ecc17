use backseat_spi::ToVehicle;
use backseat_units::Timestamp;

use super::wire::{created_time, our_message};
use super::{Oracle, RACE};
use crate::rule::Rule;

impl Oracle {
    /// A line of ours: it must be a whole sentence as the specification wants it (SPI 4.2), and nothing else.
    pub(super) fn our_line(&mut self, at: Timestamp, line: &[u8]) {
        self.counts.sentences_to_vehicle += 1;
        let message = match our_message(line) {
            Ok(message) => message,
            Err(fault) => {
                self.findings.add(at, Rule::Malformed, || {
                    let shown: String = String::from_utf8_lossy(line).chars().take(80).collect();
                    format!("{fault}: {}", shown.escape_debug())
                });
                return;
            }
        };
        let Some(name) = line.get(1..6).and_then(|name| <[u8; 5]>::try_from(name).ok()) else {
            return;
        };
        let created = if name == *b"BPLOG" { None } else { created_time(line) };
        if let Some(created) = created
            && self.stamps.repeats(name, created)
        {
            self.findings.add(at, Rule::StampRepeated, || {
                format!("{} has the time {created} twice", String::from_utf8_lossy(&name))
            });
        }
        let mut denied = self.judge_permission(at, &name, &message);
        let is_new = match &name {
            b"BPRTK" | b"BPRTC" | b"BPRGP" => true,
            b"BPRMB" => !self.lease.is_alive() && !self.lease.is_unended(),
            b"BPSUS" => !self.hold.is_alive() && !self.hold.is_unended(),
            _ => false,
        };
        self.shutdown.we_say(at, &name, is_new, &mut self.findings);
        let due = self.operator.due(&self.process);
        if !denied && is_dynamic(&name) && due.is_some_and(|due| due.is_missed(at)) {
            self.findings.add(at, Rule::OperatorHold, || {
                format!("{} under the operator's hold", String::from_utf8_lossy(&name))
            });
            denied = true;
        }
        self.we_say(at, &message, denied);
    }

    /// Whether control surely is not ours, after telling so where the sentence needs it.
    fn judge_permission(&mut self, at: Timestamp, name: &[u8; 5], message: &ToVehicle) -> bool {
        if !self.limits.operator_commands {
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
        let Some(since) = self.control.denied_since() else {
            return false;
        };
        if self.process.heard(since) > at - (self.link_delay + RACE) {
            return false;
        }
        let asks_trigger = if let ToVehicle::DvlTriggerRequest(request) = message {
            self.trigger.asks_anew(request.external)
        } else {
            false
        };
        let rule = match name {
            b"BPVER" | b"BPLOG" | b"BPSTS" | b"BPMSG" | b"BPRMP" | b"BPRCN" | b"BPABT" | b"BPKIL" | b"BPTMR" => {
                return true;
            }
            b"BPDVR" if !asks_trigger => return true,
            b"BPEMB" if self.lease.is_unended() => return true,
            b"BPSPD" | b"BPRES" if self.hold.is_unended() => return true,
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

/// Whether a sentence asks the vehicle to move otherwise than by its plan, or keeps it doing so.
fn is_dynamic(name: &[u8; 5]) -> bool {
    matches!(
        name,
        b"BPRMB" | b"BPRTK" | b"BPRTC" | b"BPRGP" | b"BPSUS" | b"BPCON" | b"BPGHP" | b"BPGBP"
    )
}

//! Why the backseat has no control, as its own status (BPSTS) says it once a second.
//!
//! Core reports a loss of control when it happens. Where control does not come in the first place, or not again after a
//! hold, nothing changes that core could report, so the driver prints the reason that stands in the status.

use std::time::Duration;

use backseat_core::Note;
use backseat_core::refusal::Uncontrolled;
use backseat_spi::{Sentence, ToVehicle};
use backseat_units::Timestamp;

/// A reason is printed if it has stood for this long: most reasons pass within the first seconds of a connection.
const STANDS_FOR: Duration = Duration::from_secs(5);
/// The status while requests can be sent.
const GRANTED: [&str; 2] = ["has control", "steering"];

/// Follows the status, and finds what is worth a line.
#[derive(Debug, Default)]
pub(crate) struct Helm {
    /// The reason in the last status, and since when it has stood there.
    reason: Option<(String, Timestamp)>,
    /// The reason that was printed last.
    told: Option<String>,
}

impl Helm {
    /// Follows what core reports, which is printed in any case.
    pub(crate) fn noted(&mut self, note: &Note) {
        match note {
            Note::Control { granted: false, reason } => self.told = reason.map(|reason| reason.text().to_owned()),
            Note::Control { granted: true, .. } | Note::LinkUp | Note::LinkDown { .. } => *self = Self::default(),
            Note::VehicleVersion { .. }
            | Note::Clock { .. }
            | Note::Mission { .. }
            | Note::Request(_)
            | Note::LeaseEnded { .. }
            | Note::Plan { .. }
            | Note::Behavior { .. }
            | Note::Navigation { .. }
            | Note::Malformed { .. }
            | Note::PluginFailed { .. }
            | Note::PluginRestarted { .. }
            | Note::PluginLog { .. }
            | Note::Operator { .. }
            | Note::Recovery { .. }
            | Note::Sonar { .. }
            | Note::Late { .. }
            | Note::Text { .. } => {}
        }
    }

    /// Follows a sentence to the vehicle. Returns the line to print, if its status has a new reason that stands.
    pub(crate) fn sent(&mut self, now: Timestamp, sentence: &[u8]) -> Option<String> {
        if !sentence.starts_with(b"$BPSTS,") {
            return None;
        }
        let text = status_text(sentence)?;
        // What follows the semicolon is about the sonars.
        let reason = text.split(';').next().unwrap_or_default().trim();
        if GRANTED.contains(&reason) {
            *self = Self::default();
            return None;
        }
        match &self.reason {
            Some((stands, since)) if stands == reason => {
                let due = now.since(*since) >= STANDS_FOR && self.told.as_deref() != Some(reason);
                due.then(|| {
                    self.told = Some(reason.to_owned());
                    line(reason)
                })
            }
            Some(_) | None => {
                self.reason = Some((reason.to_owned(), now));
                None
            }
        }
    }
}

fn status_text(sentence: &[u8]) -> Option<String> {
    let line = std::str::from_utf8(sentence).ok()?;
    let sentence = Sentence::parse(line.trim_end()).ok()?;
    let ToVehicle::PayloadStatus(status) = ToVehicle::decode(&sentence).ok()? else {
        return None;
    };
    Some(status.text.as_str().to_owned())
}

fn line(reason: &str) -> String {
    let hint = if reason == Uncontrolled::ControlUnknown.text() {
        "; it may not say so before its next leg"
    } else {
        ""
    };
    format!("no control: {reason}{hint}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(text: &str) -> Vec<u8> {
        let body = format!("BPSTS,081025.987,1,{text}");
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n").into_bytes()
    }

    /// The lines that are printed for one status a second.
    fn told(helm: &mut Helm, since_s: u64, texts: &[&str]) -> Vec<String> {
        let texts = (since_s..).zip(texts);
        texts
            .filter_map(|(at_s, text)| helm.sent(Timestamp::from_millis(1000 * at_s), &sentence(text)))
            .collect()
    }

    #[test]
    fn a_reason_that_stands_is_printed_once() {
        let mut helm = Helm::default();
        let lines = told(&mut helm, 0, &["the mission is not running"; 20]);
        assert_eq!(lines, ["no control: the mission is not running"]);
        let passing = ["navigation is stale", "navigation is stale", "has control", "steering"];
        assert_eq!(told(&mut helm, 20, &passing), [""; 0]);
    }

    #[test]
    fn a_reason_that_core_has_reported_is_not_printed_again_but_the_next_one_is() {
        let mut helm = Helm::default();
        helm.noted(&Note::Control {
            granted: false,
            reason: Some(Uncontrolled::OperatorHolds),
        });
        assert_eq!(told(&mut helm, 0, &["the operator holds"; 20]), [""; 0]);
        let lines = told(
            &mut helm,
            20,
            &["the vehicle has not said who has control; sonar ok"; 20],
        );
        assert_eq!(
            lines,
            ["no control: the vehicle has not said who has control; it may not say so before its next leg"]
        );
    }
}

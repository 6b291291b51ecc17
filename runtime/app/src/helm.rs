//! Why the backseat may not steer, for the operator's screen.
//!
//! Core reports a loss of control when it happens. Where control does not come in the first place, or not again after a
//! hold, nothing changes that core could report. Its own status (BPSTS) has the reason once a second, so the reason on
//! the screen comes from there. It is printed when it changes, and again while it lasts, with what to do about it.

use std::path::PathBuf;
use std::time::Duration;

use backseat_core::Note;
use backseat_core::refusal::Uncontrolled;
use backseat_spi::{Sentence, ToVehicle};
use backseat_units::Timestamp;

/// A reason that lasts is printed again after this time.
const AGAIN_AFTER: Duration = Duration::from_secs(30);
/// Lines are at least this far apart.
const APART: Duration = Duration::from_secs(1);
/// A vehicle that has said nothing for this time after a connection may be none.
const SILENCE: Duration = Duration::from_secs(5);
/// The status while requests can be sent.
const GRANTED: [&str; 2] = ["has control", "steering"];

/// Follows the status, and finds what is worth a line.
#[derive(Debug)]
pub(crate) struct Helm {
    armed: bool,
    /// The file that holds the plugins.
    hold: PathBuf,
    /// How much slower the person who reads lives than the clock.
    times: f64,
    /// The vehicle's clock runs at another rate than ours.
    clock_is_off: bool,
    /// When the connection came, while nothing has been heard on it.
    unheard: Option<Timestamp>,
    /// The reason in the last status.
    reason: Option<String>,
    /// The reason that was printed last, and when.
    told: Option<(String, Timestamp)>,
}

impl Helm {
    /// `hold` is the file of the operator's hold. The clock runs `times` as fast as the reader's.
    pub(crate) const fn new(armed: bool, hold: PathBuf, times: f64) -> Self {
        Self {
            armed,
            hold,
            times,
            clock_is_off: false,
            unheard: None,
            reason: None,
            told: None,
        }
    }

    /// The vehicle has sent something.
    pub(crate) const fn heard(&mut self) {
        self.unheard = None;
    }

    /// Why nothing steers, as the last status said it; `None` if something may.
    #[cfg(any(feature = "simulation", test))]
    pub(crate) fn reason(&self) -> Option<&str> {
        self.reason.as_deref()
    }

    /// Whether the vehicle's clock runs at another rate than ours.
    pub(crate) const fn clock_is_off(&mut self, off: bool) {
        self.clock_is_off = off;
    }

    /// Follows what core reports. Returns the line to print if control was lost.
    pub(crate) fn noted(&mut self, now: Timestamp, note: &Note) -> Option<String> {
        match note {
            Note::Control {
                granted: false,
                reason: Some(reason),
            } => {
                self.reason = Some(reason.text().to_owned());
                let soon = self
                    .told
                    .as_ref()
                    .is_some_and(|(_, at)| now.since(*at) < self.scaled(APART));
                if soon { None } else { self.tell(now, reason.text()) }
            }
            Note::Control { .. } | Note::LinkUp | Note::LinkDown { .. } => {
                if !matches!(note, Note::Control { .. }) {
                    self.unheard = matches!(note, Note::LinkUp).then_some(now);
                }
                (self.reason, self.told) = (None, None);
                None
            }
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
            | Note::PluginSwap { .. }
            | Note::PluginSwapped { .. }
            | Note::PluginNotSwapped { .. }
            | Note::PluginLog { .. }
            | Note::PluginMeasure { .. }
            | Note::Operator { .. }
            | Note::Recovery { .. }
            | Note::Sonar { .. }
            | Note::Late { .. }
            | Note::Text { .. } => None,
        }
    }

    /// Follows a sentence to the vehicle. Returns the line to print, if its status has a reason that is new or has
    /// lasted.
    pub(crate) fn sent(&mut self, now: Timestamp, sentence: &[u8]) -> Option<String> {
        if !sentence.starts_with(b"$BPSTS,") {
            return None;
        }
        if self
            .unheard
            .is_some_and(|since| now.since(since) >= self.scaled(SILENCE))
        {
            self.unheard = None;
            return Some(
                "connected, and nothing heard since: is a vehicle at this address, and does it serve payloads?"
                    .to_owned(),
            );
        }
        let text = status_text(sentence)?;
        // What follows the semicolon is about the sonars.
        let mut reason = text.split(';').next().unwrap_or_default().trim();
        if GRANTED.contains(&reason) {
            if self.armed {
                (self.reason, self.told) = (None, None);
                return None;
            }
            reason = Uncontrolled::NotArmed.text();
        }
        // Many reasons pass within the first seconds of a connection.
        let stands = self.reason.as_deref() == Some(reason);
        self.reason = Some(reason.to_owned());
        let due = match &self.told {
            Some((told, at)) if told == reason => now.since(*at) >= self.scaled(AGAIN_AFTER),
            Some((_, at)) => now.since(*at) >= self.scaled(APART),
            None => true,
        };
        if stands && due { self.tell(now, reason) } else { None }
    }

    fn tell(&mut self, now: Timestamp, reason: &str) -> Option<String> {
        self.told = Some((reason.to_owned(), now));
        let known = Uncontrolled::ALL.iter().find(|known| known.text() == reason);
        let begin = match known {
            // The attempts to connect have lines of their own, and so has the end.
            Some(Uncontrolled::RunEnding) => return None,
            Some(Uncontrolled::NotArmed) => "nothing steers",
            Some(_) | None => "no control",
        };
        let what_to_do = known.and_then(|reason| self.what_to_do(*reason));
        Some(match what_to_do {
            Some(what_to_do) => format!("{begin}: {reason}; {what_to_do}"),
            None => format!("{begin}: {reason}"),
        })
    }

    fn what_to_do(&self, reason: Uncontrolled) -> Option<String> {
        use Uncontrolled as U;
        let what = match reason {
            U::OperatorHolds => {
                return Some(format!("to release, delete {} or send SIGUSR2", self.hold.display()));
            }
            U::ControlUnknown => "it may stay silent about that until its next leg",
            U::VehicleHasControl => "it gives control on the legs of its plan that let a payload steer",
            U::MissionUnknown => "it may stay silent about that until its mission begins or ends",
            U::MissionNotRunning => "start it on the vehicle",
            U::PlanDiffers => "load the checked plan into the vehicle, or check the vehicle's and name it in [plan]",
            U::NotAnsweredInTime => "if this lasts, look for what delays the link (limits.link_delay_max_s)",
            U::NavigationStale | U::NavigationUnsteady if self.clock_is_off => {
                "the vehicle's clock runs at another rate than this computer's"
            }
            U::NavigationStale => "if this lasts, look at the vehicle's BFNVG with `backseat spi connect`",
            U::NavigationUnsteady => "wait until it has been good for some seconds",
            U::NotArmed => "to arm, start with --arm",
            U::LinkDown
            | U::RunEnding
            | U::OperatorEnded
            | U::PlanNotCompared
            | U::DivePlanUnknown
            | U::NotAnsweredYet
            | U::NotSent
            | U::LinkDownTooLong => return None,
        };
        Some(what.to_owned())
    }

    fn scaled(&self, time: Duration) -> Duration {
        time.mul_f64(self.times)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn helm() -> Helm {
        Helm::new(true, PathBuf::from("/state/hold"), 1.0)
    }

    fn sentence(text: &str) -> Vec<u8> {
        let body = format!("BPSTS,081025.987,1,{text}");
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n").into_bytes()
    }

    /// The lines that are printed for one status a second, each with its second.
    fn told(helm: &mut Helm, since_s: u64, texts: &[&str]) -> Vec<(u64, String)> {
        let texts = (since_s..).zip(texts);
        texts
            .filter_map(|(at_s, text)| Some((at_s, helm.sent(Timestamp::from_secs(at_s), &sentence(text))?)))
            .collect()
    }

    #[test]
    fn a_reason_is_printed_when_it_stands_and_every_half_minute() {
        let mut helm = helm();
        let lines = told(&mut helm, 0, &["the mission is not running"; 65]);
        let line = "no control: the mission is not running; start it on the vehicle".to_owned();
        assert_eq!(lines, [(1, line.clone()), (31, line.clone()), (61, line)]);
        let passing = [
            "the vehicle has control",
            "navigation is stale",
            "has control",
            "steering",
        ];
        assert_eq!(told(&mut helm, 65, &passing), []);
        assert_eq!(
            told(&mut helm, 69, &["the mission is not running"; 2]).len(),
            1,
            "it is news again"
        );
    }

    #[test]
    fn each_change_is_printed_once_and_there_is_at_most_one_line_a_second() {
        let mut helm = helm();
        let lost = |reason| Note::Control {
            granted: false,
            reason: Some(reason),
        };
        let line = helm.noted(Timestamp::from_millis(100), &lost(Uncontrolled::OperatorHolds));
        assert_eq!(
            line.as_deref(),
            Some("no control: the operator's hold is set; to release, delete /state/hold or send SIGUSR2")
        );
        assert_eq!(
            helm.noted(Timestamp::from_millis(300), &lost(Uncontrolled::NavigationStale)),
            None
        );
        let lines = told(&mut helm, 1, &["navigation is stale"; 20]);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(
            lines[0].0 == 2 && lines[0].1.contains("navigation is stale; if this lasts"),
            "{lines:?}"
        );
        let lines = told(
            &mut helm,
            21,
            &["the vehicle has not said who has control; sonar ok"; 20],
        );
        let line =
            "no control: the vehicle has not said who has control; it may stay silent about that until its next leg";
        assert_eq!(lines, [(22, line.to_owned())]);
    }

    #[test]
    fn a_runtime_that_is_not_armed_says_so_and_one_that_is_steers_in_silence() {
        let mut calm = Helm::new(false, PathBuf::new(), 1.0);
        let line = "nothing steers: the runtime is not armed; to arm, start with --arm".to_owned();
        assert_eq!(
            told(&mut calm, 0, &["has control"; 40]),
            [(1, line.clone()), (31, line)]
        );
        assert_eq!(told(&mut helm(), 0, &["has control", "steering", "steering"]), []);
        assert_eq!(helm().reason(), None);
    }

    #[test]
    fn a_server_that_says_nothing_may_be_no_vehicle() {
        let silent = |heard: bool| {
            let mut helm = helm();
            helm.noted(Timestamp::from_secs(1), &Note::LinkUp);
            if heard {
                helm.heard();
            }
            let lines = told(&mut helm, 1, &["the mission is not running"; 20]);
            let asked = |(_, line): &&(u64, String)| line.contains("nothing heard since");
            lines.iter().filter(asked).map(|(at_s, _)| *at_s).collect::<Vec<_>>()
        };
        assert_eq!((silent(false), silent(true)), (vec![6], vec![]));
    }

    #[test]
    fn a_clock_of_another_rate_is_named_where_it_is_the_reason() {
        let mut helm = helm();
        helm.clock_is_off(true);
        let lines = told(&mut helm, 0, &["navigation is stale"; 5]);
        assert!(lines.len() == 1 && lines[0].1.contains("at another rate"), "{lines:?}");
    }

    #[test]
    fn a_faster_clock_prints_no_more_lines() {
        let mut fast = Helm::new(true, PathBuf::new(), 20.0);
        assert_eq!(told(&mut fast, 0, &["the mission is not running"; 500]).len(), 1);
    }
}

//! Which status messages we subscribe to, and in which order (SPI 7.1).

use crate::monitor::limits::Grant;
use crate::plugin::Topic;
use crate::settings::PluginSetup;

/// BFACK: the vehicle need not acknowledge what is sent before this subscription.
pub(crate) const ACKNOWLEDGEMENTS: &str = "ACK";

/// BFCTL comes first: real vehicles send it only when control changes, and a late subscription would miss the
/// hand-over. The acknowledgements come next, and BFCTL comes once more, so that its subscription is acknowledged too.
const ALWAYS: [&str; 8] = ["CTL", ACKNOWLEDGEMENTS, "MIS", "CTL", "NVG", "NVR", "MBS", "MBE"];

/// Whether core itself needs the message of this place in the list.
pub(crate) const fn is_always_needed(index: usize) -> bool {
    index < ALWAYS.len()
}

/// The messages that a topic needs. Command messages come without a subscription (SPI 4.3).
const fn of_topic(topic: Topic) -> &'static [&'static str] {
    match topic {
        Topic::MissionCommand | Topic::Behavior | Topic::Logging | Topic::Topside | Topic::Plan => &[],
        Topic::Sidescan | Topic::SubBottom | Topic::Sonar => &[],
        Topic::Ctd => &["CTD"],
        Topic::Acoustic => &["CMA", "CPR"],
        Topic::Telemetry => &["TEL"],
        Topic::SoundVelocity => &["SVS"],
        Topic::Compass => &["RCM"],
        Topic::Pressure => &["RDP"],
        Topic::VehicleSpeed => &["RVL"],
        Topic::Battery => &["RBS"],
        Topic::Surfaces => &["ERC"],
        Topic::Dvl => &["DVL"],
        Topic::DvlBeams => &["DV2"],
        Topic::Imu => &["IMU"],
        Topic::Servo => &["PIT"],
        Topic::Trim => &["TRM"],
        Topic::Buoyancy => &["BOY"],
        Topic::RelativeNavigation => &["RNV", "CNV"],
    }
}

/// The messages that core needs to supervise what a grant allows.
const fn of_grant(grant: Grant) -> &'static [&'static str] {
    match grant {
        Grant::Modify
        | Grant::Insert
        | Grant::Interrupt
        | Grant::Message
        | Grant::Surface
        | Grant::Topside
        | Grant::Dvl
        | Grant::Silent
        | Grant::Devices
        | Grant::Sonar => &[],
        Grant::Trim => &["TRM"],
        Grant::Buoyancy => &["BOY"],
        Grant::Acoustic => &["CMA", "CPS", "CPR"],
        Grant::Station => &["RNV", "CNV"],
    }
}

/// The subscriptions of a run, in the order in which they are sent, and the state of each.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Subscriptions {
    subjects: Vec<&'static str>,
    /// Which of them the vehicle has acknowledged on this connection, or whose message it has sent.
    confirmed: Vec<bool>,
    /// Which of them are confirmed only by an acknowledgement that did not name its message: by its place in the order of
    /// the answers. If an answer is missing, each later one may have been taken for that of the subscription before it.
    by_place: Vec<bool>,
    /// How often each has been sent on this connection without an answer.
    unanswered: Vec<u32>,
    /// How many are not confirmed.
    unconfirmed: usize,
    /// Acknowledgements have been subscribed on this connection.
    acknowledged: bool,
}

impl Subscriptions {
    /// The messages that are always needed, and those that the topics and grants of the plugins and the sonars need.
    pub(crate) fn new(plugins: &[PluginSetup], sonar: bool) -> Self {
        let mut subjects = ALWAYS.to_vec();
        let wanted = plugins.iter().flat_map(|plugin| {
            let topics = plugin.description.topics.iter().flat_map(|topic| of_topic(*topic));
            topics.chain(plugin.grants.iter().flat_map(|grant| of_grant(*grant)))
        });
        let told_to_sonars: &[&str] = if sonar { &["SVS"] } else { &[] };
        for subject in wanted.chain(told_to_sonars) {
            if !subjects.contains(subject) {
                subjects.push(subject);
            }
        }
        Self {
            confirmed: vec![false; subjects.len()],
            by_place: vec![false; subjects.len()],
            unanswered: vec![0; subjects.len()],
            unconfirmed: subjects.len(),
            acknowledged: false,
            subjects,
        }
    }

    /// The messages, in order.
    pub(crate) fn subjects(&self) -> &[&'static str] {
        &self.subjects
    }

    pub(crate) fn len(&self) -> usize {
        self.subjects.len()
    }

    pub(crate) fn subject(&self, index: usize) -> &'static str {
        self.subjects[index]
    }

    /// Whether the vehicle has acknowledged a subscription on this connection, or sent its message.
    pub(crate) fn is_confirmed(&self, index: usize) -> bool {
        self.confirmed[index]
    }

    /// Whether the subscription to a message, such as `CTL`, is confirmed.
    pub(crate) fn has(&self, message: &str) -> bool {
        let mut both = self.subjects.iter().zip(&self.confirmed);
        both.any(|(subject, confirmed)| *subject == message && *confirmed)
    }

    /// A new connection: nothing is subscribed on it.
    pub(crate) fn begin(&mut self) {
        self.acknowledged = false;
        self.doubt_all();
    }

    /// No subscription is confirmed any more.
    pub(crate) fn doubt_all(&mut self) {
        self.confirmed.fill(false);
        self.by_place.fill(false);
        self.unanswered.fill(0);
        self.unconfirmed = self.subjects.len();
    }

    /// The vehicle may not have the subscription to a message, although it seemed to acknowledge it: acknowledgements
    /// of BPLOG do not say which one they answer (SPI 7.1). Returns the subscription's place in the list.
    pub(crate) fn doubt(&mut self, message: &str) -> Option<usize> {
        let index = self.subjects.iter().position(|known| *known == message)?;
        self.unanswered[index] = 0;
        self.unconfirm(index);
        Some(index)
    }

    /// An answer to a subscription is missing: doubts each that is confirmed only by the order of the answers. Returns
    /// their places in the list. How often each was sent still counts, so a vehicle that never answers one of them is
    /// asked at growing intervals.
    pub(crate) fn doubt_by_place(&mut self) -> Vec<usize> {
        let doubtful: Vec<usize> = (0..self.len()).filter(|index| self.by_place[*index]).collect();
        for index in &doubtful {
            self.unconfirm(*index);
        }
        doubtful
    }

    /// Each BPLOG has had its answer and none was missing, so each answer was taken for that of the right one.
    pub(crate) fn trust_places(&mut self) {
        for index in 0..self.len() {
            if core::mem::take(&mut self.by_place[index]) {
                self.unanswered[index] = 0;
            }
        }
    }

    fn unconfirm(&mut self, index: usize) {
        self.by_place[index] = false;
        if core::mem::take(&mut self.confirmed[index]) {
            self.unconfirmed += 1;
        }
    }

    /// A subscription is about to be sent. Returns its message, and how often it was sent before without an answer;
    /// `None` before the subscription to acknowledgements.
    pub(crate) fn asked(&mut self, index: usize) -> (&'static str, Option<u32>) {
        let subject = self.subjects[index];
        self.acknowledged |= subject == ACKNOWLEDGEMENTS;
        let unanswered = self.acknowledged.then(|| {
            let before = self.unanswered[index];
            self.unanswered[index] += 1;
            before
        });
        (subject, unanswered)
    }

    /// A message such as `BFNVG` has come: this confirms its subscription, with or without an acknowledgement.
    pub(crate) fn confirm_by_data(&mut self, message: &str) {
        if self.unconfirmed == 0 && !self.by_place.contains(&true) {
            return;
        }
        for index in 0..self.subjects.len() {
            if message.strip_prefix("BF") == Some(self.subjects[index]) {
                self.confirm(index);
            }
        }
    }

    /// The vehicle surely has this subscription.
    pub(crate) fn confirm(&mut self, index: usize) {
        self.unanswered[index] = 0;
        self.by_place[index] = false;
        self.set_confirmed(index);
    }

    /// An acknowledgement that names no message has come where that of this subscription is due.
    pub(crate) fn confirm_by_place(&mut self, index: usize) {
        self.by_place[index] = !self.confirmed[index] || self.by_place[index];
        self.set_confirmed(index);
    }

    fn set_confirmed(&mut self, index: usize) {
        if !self.confirmed[index] {
            self.confirmed[index] = true;
            self.unconfirmed -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Otherwise core would ask a vehicle that leaves out some answers again and again at short intervals.
    #[test]
    fn what_is_confirmed_only_by_the_order_of_answers_is_asked_for_at_growing_intervals() {
        let mut subscriptions = Subscriptions::new(&[], false);
        let control = 3;
        subscriptions.asked(1);
        for before in 0..4 {
            assert_eq!(subscriptions.asked(control), ("CTL", Some(before)));
            subscriptions.confirm_by_place(control);
            assert!(subscriptions.has("CTL"));
            assert_eq!(subscriptions.doubt_by_place(), [control]);
            assert!(!subscriptions.has("CTL") && subscriptions.doubt_by_place().is_empty());
        }
        // Once all answers have come, or the message has, it is sure.
        for sure in [Subscriptions::trust_places, |all: &mut Subscriptions| {
            all.confirm_by_data("BFCTL")
        }] {
            subscriptions.confirm_by_place(control);
            sure(&mut subscriptions);
            assert!(subscriptions.has("CTL") && subscriptions.doubt_by_place().is_empty());
            assert_eq!(subscriptions.asked(control), ("CTL", Some(0)));
            subscriptions.doubt_all();
        }
    }
}

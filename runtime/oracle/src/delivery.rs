use std::collections::VecDeque;
use std::time::Duration;

use crate::margin::Margin;
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;

use crate::rule::Rule;
use crate::violation::Findings;

/// The steering sentences that were sent, and those that the vehicle has received, if the run reports arrivals.
#[derive(Clone, Debug, Default)]
pub(crate) struct Delivery {
    sent: Newest,
    /// `None` if arrivals are not reported.
    arrived: Option<Newest>,
    /// The newest BPRMB: when they were made, and when they left.
    modifies: VecDeque<(TimeOfDay, Moment)>,
    /// The number of reasons for which the vehicle is deaf, and when it last heard again.
    deaf: u32,
    hears_since: Option<Moment>,
}

/// The last sentences whose effect the vehicle ends by its own clock.
#[derive(Clone, Copy, Debug, Default)]
struct Newest {
    modify: Option<Moment>,
    station: Option<Moment>,
}

impl Delivery {
    /// A BPRMB that arrives so long after it was sent is stale. If a write is not acknowledged for 2 s, the connection
    /// ends and the write is lost; half a second more is the time until that is noticed.
    const STALE: Duration = Duration::from_millis(2500);
    const MODIFIES_MAX: usize = 256;

    pub(crate) fn sent_modify(&mut self, at: Moment, created: TimeOfDay) {
        self.sent.modify = Some(at);
        if self.modifies.len() == Self::MODIFIES_MAX {
            self.modifies.pop_front();
        }
        self.modifies.push_back((created.to_the_millisecond(), at));
    }

    pub(crate) fn sent_station(&mut self, at: Moment) {
        self.sent.station = Some(at);
    }

    /// Whether arrivals are reported.
    pub(crate) const fn is_told(&self) -> bool {
        self.arrived.is_some()
    }

    /// The vehicle stops reading what has arrived, or reads again. If it then reads something old, that is not the
    /// sender's fault.
    pub(crate) fn deaf(&mut self, at: Moment, deaf: bool) {
        if deaf {
            self.deaf += 1;
        } else {
            self.deaf = self.deaf.saturating_sub(1);
            self.hears_since = Some(at);
        }
    }

    /// From now on arrivals are reported.
    pub(crate) fn tells_arrivals(&mut self) {
        self.arrived.get_or_insert_default();
    }

    /// A sentence arrived at the vehicle, perhaps damaged. It counts if it can be read as one that steers: servers
    /// accept sentences without a checksum, or with one that is not padded.
    pub(crate) fn arrived(
        &mut self,
        at: Moment,
        name: [u8; 5],
        created: Option<TimeOfDay>,
        link_delay: Duration,
        findings: &mut Findings,
    ) {
        let newest = self.arrived.get_or_insert_default();
        match &name {
            b"BPRMB" => newest.modify = Some(at),
            b"BPSUS" | b"BPCON" | b"BPGHP" | b"BPGBP" => newest.station = Some(at),
            _ => return,
        }
        let Some(created) = created.map(TimeOfDay::to_the_millisecond) else {
            return;
        };
        let sent = self.modifies.iter().rev().find(|(made, _)| *made == created);
        if name == *b"BPRMB" && sent.is_some() {
            findings.judge(Rule::StaleDelivery);
        }
        if name == *b"BPRMB"
            && let Some((_, sent)) = sent
            && self.deaf == 0
        {
            let since = self.hears_since.map_or(*sent, |since| since.max(*sent));
            findings.near(
                Margin::Delivery,
                at.since(since).as_secs_f64(),
                (Self::STALE + link_delay).as_secs_f64(),
            );
        }
        if name == *b"BPRMB"
            && let Some((_, sent)) = sent
            && self.deaf == 0
            && at.since(self.hears_since.map_or(*sent, |since| since.max(*sent))) > Self::STALE + link_delay
        {
            findings.add(at, Rule::StaleDelivery, || {
                format!("the BPRMB of {sent} came {:.3} s later", at.since(*sent).as_secs_f64())
            });
        }
    }

    /// The last BPRMB that counts.
    pub(crate) fn last_modify(&self) -> Option<Moment> {
        self.arrived.unwrap_or(self.sent).modify
    }

    /// The last sentence that counts and refreshes a suspension.
    pub(crate) fn last_station(&self) -> Option<Moment> {
        self.arrived.unwrap_or(self.sent).station
    }

    /// The time that may pass until the sentence that counts has an effect.
    pub(crate) fn delay(&self, link_delay: Duration) -> Duration {
        if self.arrived.is_some() {
            Duration::ZERO
        } else {
            link_delay
        }
    }
}

use super::Oracle;
use crate::state::State;
use crate::statistics::Statistics;

impl Oracle {
    /// The state of the run. This call costs almost nothing.
    #[must_use]
    pub const fn state(&self) -> State {
        if !self.control.is_up() {
            return State::Down;
        }
        if !self.control.is_granted() {
            return State::NoControl;
        }
        if self.station.is_alive() {
            return State::Station;
        }
        let open = self.inserts.open();
        if self.lease.is_alive() {
            return if open.asked + open.queued + open.flown > 0 {
                State::LeaseInsert
            } else {
                State::Lease
            };
        }
        if open.flown > 0 {
            State::Insert
        } else if open.queued > 0 {
            State::Queued
        } else if open.asked > 0 {
            State::Asked
        } else {
            State::Idle
        }
    }

    /// How much there was to judge until now. Call it before [`Oracle::finish`].
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let [
            inserts_sent,
            inserts_refused,
            inserts_accepted,
            inserts_begun,
            inserts_cancelled,
        ] = self.inserts.counts();
        let (truths, truth_judged, truth_insert_s, truth_modified_s) = self.conduct.counts();
        Statistics {
            control_s: self.control_held_at(self.now).as_secs_f64(),
            leases: self.lease.opened(),
            lease_s: self.lease.alive_s(self.now),
            stations: self.station.opened(),
            station_s: self.station.alive_s(self.now),
            inserts_sent,
            inserts_refused,
            inserts_accepted,
            inserts_begun,
            inserts_cancelled,
            truths,
            truth_insert_s,
            truth_modified_s,
            truth_judged,
            violations: self.findings.count(),
            margins: *self.findings.margins(),
            ..self.counts.clone()
        }
    }
}

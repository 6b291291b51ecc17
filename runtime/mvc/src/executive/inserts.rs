use backseat_spi::BehaviorId;
use backseat_units::{EastNorth, Timestamp};

use super::{Executive, IDENTIFIERS_MAX, Running};
use crate::estimate::Estimate;
use crate::event::{CancelCause, ClientId, EndReason, MvcEventKind, Refusal, Source};
use crate::interpretation::Interpretation;
use crate::plan::insert::Insert;

impl Executive {
    /// Adds an insert to the plan, or returns why not.
    pub(crate) fn insert(&mut self, now: Timestamp, insert: Insert, estimate: &Estimate) -> Result<(), Refusal> {
        if !self.control {
            return Err(Refusal::NotAllowed);
        }
        if self.used.contains(&insert.id) {
            return Err(Refusal::Duplicate);
        }
        insert.within(&self.performance, self.altitude_min_m)?;
        if insert.interrupt && self.in_interruption() {
            return Err(Refusal::InterruptsInterrupt);
        }
        if self.queue.len() >= self.limits.inserts_max as usize || self.used.len() >= IDENTIFIERS_MAX {
            return Err(Refusal::Full(self.queue.len() as u32));
        }
        self.used.insert(insert.id);
        self.log.push(MvcEventKind::InsertAccepted(insert.client, insert.id));
        if insert.interrupt {
            self.interrupt(now, insert, estimate.at);
        } else {
            self.queue.push_back(insert);
            let waits = |running: &Running| running.behavior.source == Source::Empty;
            if self.running.as_ref().is_some_and(waits) {
                self.next(now, estimate.at, EndReason::Relieved);
            }
        }
        Ok(())
    }

    /// Whether an interruption is under way, because "It is not possible to interrupt an interruption" (SPI 7.5).
    /// Depending on the interpretation, that is the whole set of inserts that has interrupted, or only the one insert.
    fn in_interruption(&self) -> bool {
        if self.interpretation.set_interrupts {
            return self.interrupting;
        }
        let inserted = self.running.as_ref().and_then(|running| running.insert.as_ref());
        inserted.is_some_and(|insert| insert.interrupt)
    }

    /// BPRCN: removes a waiting insert from the plan, or returns why not.
    pub(crate) fn cancel(&mut self, client: ClientId, id: BehaviorId) -> Result<(), &'static str> {
        if let Some(at) = self.queue.iter().position(|insert| insert.id == id) {
            let insert = &self.queue[at];
            if insert.is_gps_hit() {
                return Err("a gps hit cannot be cancelled");
            }
            if !self.interpretation.cancel_any && insert.client != client {
                return Err("the behavior is another client's");
            }
            self.queue.remove(at);
            self.log
                .push(MvcEventKind::InsertCancelled(id, CancelCause::Asked(client)));
            return Ok(());
        }
        if self.inserts().any(|insert| insert.id == id) {
            return Err("the behavior has begun");
        }
        Err("no such behavior is waiting")
    }

    /// BPRCA: removes the waiting inserts from the plan. Returns how many.
    pub(crate) fn cancel_all(&mut self, client: ClientId) -> usize {
        let reading = self.interpretation;
        self.drop_queue(CancelCause::Asked(client), |insert| {
            takes_back(&reading, client, insert)
        })
    }

    pub(super) fn interrupt(&mut self, now: Timestamp, insert: Insert, at: EastNorth) {
        self.stop_mission_clock(now);
        if let Some(running) = self.end_running(EndReason::Interrupted)
            && self.interpretation.resume
        {
            self.paused.push((running, now));
        }
        self.interrupting = true;
        self.begin_insert(insert, now, at);
    }

    pub(super) fn drop_queue(&mut self, cause: CancelCause, of: impl Fn(&Insert) -> bool) -> usize {
        let before = self.queue.len();
        let log = &mut self.log;
        self.queue.retain(|insert| {
            let dropped = of(insert);
            if dropped {
                log.push(MvcEventKind::InsertCancelled(insert.id, cause));
            }
            !dropped
        });
        before - self.queue.len()
    }
}

/// Whether a client's BPRCA cancels an insert (SPI 7.9).
pub(super) fn takes_back(reading: &Interpretation, client: ClientId, insert: &Insert) -> bool {
    (reading.cancel_all || insert.client == client) && (reading.cancel_all_gps || !insert.is_gps_hit())
}

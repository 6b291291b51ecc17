use backseat_spi::BehaviorId;
use backseat_units::{EastNorth, Timestamp};

use super::{Executive, IDENTIFIERS_MAX};
use crate::estimate::Estimate;
use crate::event::{CancelCause, ClientId, EndReason, MvcEventKind, Refusal};
use crate::insert::Insert;

impl Executive {
    /// Adds an insert to the plan, or says why not.
    pub(crate) fn insert(&mut self, now: Timestamp, insert: Insert, estimate: &Estimate) -> Result<(), Refusal> {
        if !self.control {
            return Err(Refusal::NotAllowed);
        }
        if self.used.contains(&insert.id) {
            return Err(Refusal::Duplicate);
        }
        insert.within(&self.hull, self.altitude_min_m)?;
        if insert.interrupt && self.interrupting {
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
        }
        Ok(())
    }

    /// BPRCN: takes a waiting insert out of the plan, or says why not.
    pub(crate) fn cancel(&mut self, client: ClientId, id: BehaviorId) -> Result<(), &'static str> {
        if let Some(at) = self.queue.iter().position(|insert| insert.id == id) {
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

    /// BPRCA: takes the waiting inserts out of the plan, and says how many.
    pub(crate) fn cancel_all(&mut self, client: ClientId) -> usize {
        let all = self.interpretation.cancel_all;
        self.drop_queue(CancelCause::Asked(client), |insert| all || insert.client == client)
    }

    pub(super) fn interrupt(&mut self, now: Timestamp, insert: Insert, at: EastNorth) {
        self.stop_mission_clock(now);
        if let Some(running) = self.end_running(EndReason::Interrupted)
            && self.interpretation.resume
        {
            match running.insert {
                None => self.paused = Some((running, now)),
                Some(interrupted) => self.queue.push_back(interrupted),
            }
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

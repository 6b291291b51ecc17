use core::time::Duration;

use backseat_spi::{AckStatus, BehaviorId, Text};
use backseat_units::Timestamp;

use crate::answers::Regarding;
use crate::event::{ClientId, MvcEventKind, Refusal, Status};
use crate::executive::takes_back;
use crate::file::AcknowledgeConfig;
use crate::insert::Insert;
use crate::mvc::Mvc;

/// How many requests may be pending at once, of all clients and of one: no client takes the others' room.
const PENDING_MAX: usize = 1024;
const PENDING_EACH_MAX: usize = 64;

/// A request whose outcome is still to be told (SPI 4.4).
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    due: Timestamp,
    re: Regarding,
    work: Work,
}

#[derive(Clone, Debug)]
pub(crate) enum Work {
    Insert(Insert),
    Cancel(BehaviorId),
    Plan,
    /// A message to the topside.
    Topside(Text),
    /// An insert that BPRCA has taken back meanwhile.
    TakenBack(BehaviorId),
}

impl Mvc {
    /// A connection is gone: what it has asked for is decided all the same, and no longer answered.
    pub(crate) fn mute(&mut self, client: ClientId) {
        self.faults.forget(client);
        for pending in self.pending.iter_mut().filter(|pending| pending.re.client == client) {
            pending.re.muted = true;
        }
        self.silence.mute(client);
        self.dvl_trigger.gone(client);
    }

    /// Tells the outcome of every pending request that is due.
    pub(crate) fn resolve_pending(&mut self, now: Timestamp) {
        while self.pending.front().is_some_and(|pending| pending.due <= now) {
            if let Some(pending) = self.pending.pop_front() {
                self.decide(now, pending.re, pending.work);
                self.settle(now);
            }
        }
    }

    pub(crate) fn insert(&mut self, now: Timestamp, re: Regarding, insert: Result<Insert, String>) {
        match insert {
            Ok(insert) if insert.id.get() == 0 => self.invalid(now, re, "identifier 0: expected 1 or more"),
            Ok(insert) => self.begin(now, re, Work::Insert(insert)),
            Err(text) => self.invalid(now, re, &text),
        }
    }

    /// Starts a request that may be pending.
    pub(crate) fn begin(&mut self, now: Timestamp, re: Regarding, work: Work) {
        match self.acknowledge {
            AcknowledgeConfig::Immediate => self.decide(now, re, work),
            AcknowledgeConfig::Pending => self.begin_pending(now, re, work),
        }
    }

    pub(crate) fn begin_pending(&mut self, now: Timestamp, re: Regarding, work: Work) {
        let own = self.pending.iter().filter(|pending| pending.re.client == re.client);
        if self.pending.len() >= PENDING_MAX || own.count() >= PENDING_EACH_MAX {
            self.acknowledge(now, re, AckStatus::Failed, "too many requests are pending");
            return;
        }
        self.acknowledge(now, re, AckStatus::Pending, "");
        let due = now + Duration::from_secs_f64(self.pending_s.draw(&mut self.delays));
        // Requests are decided in the order in which they came; each still in time, since no delay exceeds the most.
        let due = self.pending.back().map_or(due, |last| last.due.max(due));
        self.pending.push_back(Pending { due, re, work });
    }

    /// Does it, and tells the outcome.
    pub(crate) fn decide(&mut self, now: Timestamp, re: Regarding, work: Work) {
        match work {
            Work::Insert(insert) => match self
                .executive
                .insert(now, insert, &self.sensors.estimate(&self.vehicle))
            {
                Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
                Err(why) => self.refuse(now, re, insert.id, why),
            },
            Work::TakenBack(id) => self.refuse(now, re, id, Refusal::Cancelled),
            Work::Cancel(id) => match self.executive.cancel(re.client, id) {
                Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
                Err(why) => self.acknowledge(now, re, AckStatus::Failed, why),
            },
            Work::Topside(text) => self.queue_topside(now, re, text),
            Work::Plan if re.muted => {}
            // What is executing has a plan, and what is loaded (SPI 7.19: "the currently-executing mission plan").
            Work::Plan => match self.executive.status() {
                Status::Ready | Status::Running => {
                    let count = self.send_plan(now, re.client);
                    self.acknowledge(now, re, AckStatus::Succeeded, &format!("{count} elements"));
                }
                Status::WrappingUp | Status::Aborting | Status::Completed | Status::Aborted | Status::Stopped => {
                    self.acknowledge(now, re, AckStatus::Failed, "no mission is running");
                }
            },
        }
    }

    fn refuse(&mut self, now: Timestamp, re: Regarding, id: BehaviorId, why: Refusal) {
        self.note(now, MvcEventKind::InsertRefused(re.client, id, why));
        self.acknowledge(now, re, AckStatus::Failed, &why.to_string());
    }

    /// BPRCA also reaches the inserts that are still pending.
    pub(crate) fn take_back(&mut self, client: ClientId) -> usize {
        let reading = self.interpretation;
        let mut count = 0;
        for pending in &mut self.pending {
            if let Work::Insert(insert) = &pending.work
                && takes_back(&reading, client, insert)
            {
                pending.work = Work::TakenBack(insert.id);
                count += 1;
            }
        }
        count
    }
}

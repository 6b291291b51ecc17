use core::time::Duration;
use std::collections::VecDeque;

use backseat_spi::{BehaviorId, Text};
use backseat_units::Timestamp;
use backseat_world::{Span, Stream};

use crate::event::ClientId;
use crate::file::{AcknowledgeConfig, SpiConfig};
use crate::plan::insert::Insert;
use crate::server::answers::Regarding;

/// How many requests of all clients together, and of one client, may be pending at once. So no client fills all the
/// room.
const PENDING_MAX: usize = 1024;
const PENDING_EACH_MAX: usize = 64;

/// A request whose outcome the client does not know yet (SPI 4.4).
#[derive(Clone, Debug)]
struct Pending {
    due: Timestamp,
    re: Regarding,
    work: Work,
}

/// What is to be decided, and which part of the vehicle decides it.
#[derive(Clone, Debug)]
pub(crate) enum Work {
    Mission(Asked),
    /// A message to the topside.
    Topside(Text),
}

/// What a payload has asked the mission to do.
#[derive(Clone, Debug)]
pub(crate) enum Asked {
    Insert(Insert),
    Cancel(BehaviorId),
    Plan,
    /// An insert that BPRCA has cancelled while it was pending.
    TakenBack(BehaviorId),
}

impl From<Asked> for Work {
    fn from(asked: Asked) -> Self {
        Self::Mission(asked)
    }
}

impl From<Text> for Work {
    fn from(text: Text) -> Self {
        Self::Topside(text)
    }
}

/// The pending requests, in order of arrival.
#[derive(Debug)]
pub(super) struct Requests {
    pending: VecDeque<Pending>,
    pending_s: Span,
    acknowledge: AcknowledgeConfig,
    delays: Stream,
}

impl Requests {
    pub(super) fn new(config: &SpiConfig, seed: u64) -> Self {
        Self {
            pending: VecDeque::new(),
            pending_s: config.pending_s,
            acknowledge: config.acknowledge,
            delays: Stream::new(seed, "acknowledgement delays"),
        }
    }

    /// Whether requests are decided when they arrive.
    pub(super) fn is_immediate(&self) -> bool {
        match self.acknowledge {
            AcknowledgeConfig::Immediate => true,
            AcknowledgeConfig::Pending => false,
        }
    }

    /// Whether there is no room for one more request of this client.
    pub(super) fn is_full(&self, client: ClientId) -> bool {
        let own = self.pending.iter().filter(|pending| pending.re.client == client);
        self.pending.len() >= PENDING_MAX || own.count() >= PENDING_EACH_MAX
    }

    pub(super) fn push(&mut self, now: Timestamp, re: Regarding, work: Work) {
        let due = now + Duration::from_secs_f64(self.pending_s.draw(&mut self.delays));
        // Requests are decided in order of arrival. Each is still in time, because no delay exceeds the greatest.
        let due = self.pending.back().map_or(due, |last| last.due.max(due));
        self.pending.push_back(Pending { due, re, work });
    }

    pub(super) fn next_due(&mut self, now: Timestamp) -> Option<(Regarding, Work)> {
        let next = self.pending.pop_front_if(|pending| pending.due <= now)?;
        Some((next.re, next.work))
    }

    /// A connection is gone. Its requests are still decided, but no longer answered.
    pub(super) fn mute(&mut self, client: ClientId) {
        for pending in self.pending.iter_mut().filter(|pending| pending.re.client == client) {
            pending.re.muted = true;
        }
    }

    /// Cancels the pending inserts for which `of` is true, and returns how many.
    pub(super) fn take_back(&mut self, of: impl Fn(&Insert) -> bool) -> usize {
        let mut count = 0;
        for pending in &mut self.pending {
            if let Work::Mission(Asked::Insert(insert)) = &pending.work
                && of(insert)
            {
                pending.work = Asked::TakenBack(insert.id).into();
                count += 1;
            }
        }
        count
    }
}

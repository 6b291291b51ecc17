use std::collections::VecDeque;

use crate::counts::Counts;
use crate::event::Event;
use crate::io::Output;
use crate::ping::SonarPing;

/// How many pings wait for the driver. The oldest is dropped for a new one.
pub const PINGS_MAX: usize = 64;
/// How many events wait for the driver. Further ones are dropped, except outcomes.
pub const EVENTS_MAX: usize = 256;
/// How many records of vehicle data wait for the driver. Further ones are dropped.
pub const SENDS_MAX: usize = 64;

/// What waits for the driver, oldest first.
///
/// Each kind has its bound. Only outcomes, commands and what concerns the connection are never dropped: there is at
/// most one outcome for each order, and one command at a time.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    queue: VecDeque<Output>,
    pings: usize,
    events: usize,
    sends: usize,
}

impl Outbox {
    pub(crate) fn ping(&mut self, ping: SonarPing, counts: &mut Counts) {
        if self.pings >= PINGS_MAX {
            let oldest = self.queue.iter().position(|output| matches!(output, Output::Ping(_)));
            if let Some(oldest) = oldest {
                self.queue.remove(oldest);
                self.pings -= 1;
                counts.dropped_pings += 1;
            }
        }
        self.pings += 1;
        self.queue.push_back(Output::Ping(ping));
    }

    pub(crate) fn event(&mut self, event: Event, counts: &mut Counts) {
        if self.events >= EVENTS_MAX && !matches!(event, Event::Outcome { .. }) {
            counts.dropped_events += 1;
            return;
        }
        self.events += 1;
        self.queue.push_back(Output::Event(event));
    }

    /// A record of vehicle data.
    pub(crate) fn data(&mut self, bytes: Vec<u8>, counts: &mut Counts) {
        if self.sends >= SENDS_MAX {
            counts.dropped_sends += 1;
            return;
        }
        self.command(bytes);
    }

    pub(crate) fn command(&mut self, bytes: Vec<u8>) {
        self.sends += 1;
        self.queue.push_back(Output::Send(bytes));
    }

    pub(crate) fn link(&mut self, output: Output) {
        self.queue.push_back(output);
    }

    /// The connection is gone: what waits for it must not go to the next one.
    pub(crate) fn forget_sends(&mut self) {
        self.queue.retain(|output| !matches!(output, Output::Send(_)));
        self.sends = 0;
    }

    pub(crate) fn pop(&mut self) -> Option<Output> {
        let output = self.queue.pop_front()?;
        match &output {
            Output::Ping(_) => self.pings -= 1,
            Output::Event(_) => self.events -= 1,
            Output::Send(_) => self.sends -= 1,
            Output::Connect | Output::Disconnect | Output::Finished => {}
        }
        Some(output)
    }
}

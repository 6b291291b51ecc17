//! The end: the vehicle is about to cut the power (BFSHT, SPI 5.2).

use std::time::Duration;

use super::{Link, Sonar};
use crate::io::{Output, Ticket};
use crate::job::Job;
use crate::order::Outcome;
use crate::timer::Timer;

/// How long a shutdown may take from the order to [`Output::Finished`].
pub const SHUTDOWN_WITHIN: Duration = Duration::from_millis(9500);

impl Sonar {
    /// Stops everything else, then logging, then the controller. Without a connection it makes one.
    pub(super) fn shut_down(&mut self, ticket: Ticket) {
        self.ending = Some(ticket);
        self.timers.set(Timer::Shutdown, self.now + SHUTDOWN_WITHIN);
        self.timers.stop(Timer::Health);
        self.logging.want(false);
        while let Some(waiting) = self.orders.pop_front() {
            self.outcome(waiting.ticket, Outcome::refused("the controller is being shut down"));
        }
        match self.link {
            Link::Up { ready } => {
                self.setup.clear();
                if let Some((job, step, heard)) = self.take_exchange() {
                    self.job_lost(job, &step, heard);
                }
                self.begin(Job::shutdown(&self.config, !ready));
            }
            Link::Waiting => {
                self.timers.stop(Timer::Connect);
                self.connect();
            }
            Link::Connecting | Link::Closing { .. } | Link::Ended => {}
        }
    }

    /// The client's last act.
    pub(super) fn finish(&mut self, outcome: Outcome) {
        if let Some(ticket) = self.ending.take() {
            self.outcome(ticket, outcome);
        }
        match self.link {
            Link::Up { .. } | Link::Connecting => self.outbox.link(Output::Disconnect),
            Link::Waiting | Link::Closing { .. } | Link::Ended => {}
        }
        self.link = Link::Ended;
        let _given_up = self.exchanges.take(self.now);
        self.vehicle.forget_frames();
        self.timers.stop_all();
        self.outbox.link(Output::Finished);
    }
}

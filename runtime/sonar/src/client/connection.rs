//! Connects, notices the loss, connects again.

use std::time::Duration;

use backseat_s7k::StreamReader;

use super::{Due, Link, Sonar};
use crate::event::Event;
use crate::io::Output;
use crate::job::Job;
use crate::timer::Timer;

/// The pause before another attempt to connect during a shutdown, for which there is little time.
const SHUTDOWN_PAUSE: Duration = Duration::from_secs(1);

impl Sonar {
    pub(super) fn connect(&mut self) {
        if self.link == Link::Waiting {
            self.link = Link::Connecting;
            self.outbox.link(Output::Connect);
        }
    }

    pub(super) fn connected(&mut self) {
        if self.link != Link::Connecting {
            self.counts.unexpected_inputs += 1;
            return;
        }
        self.link = Link::Up { ready: false };
        self.controller_ends = false;
        self.reader = StreamReader::new(self.config.frame_limit_bytes);
        self.exchanges.forget();
        self.alarms.begin();
        self.logging.begin();
        self.health.clear();
        self.controller_clock.forget();
        self.due = Due::default();
        self.tell(Event::Connected);
        if self.ending.is_some() {
            self.begin(Job::shutdown(&self.config, true));
        } else {
            self.setup = Job::setup(&self.config);
            self.settings = Job::settings(&self.config);
        }
    }

    /// Everything has been said on the new connection.
    pub(super) fn become_ready(&mut self) {
        self.link = Link::Up { ready: true };
        self.attempts = 0;
        self.due.restore = true;
        self.timers.set(Timer::Health, self.now + self.config.health_period());
        self.tell(Event::Ready);
    }

    pub(super) fn lost(&mut self) {
        let why = match self.link {
            Link::Connecting => "it cannot be reached",
            Link::Up { .. } if self.controller_ends => "it has shut down",
            Link::Up { .. } => "the connection was lost",
            Link::Closing { why } => why,
            Link::Waiting => {
                self.counts.unexpected_inputs += 1;
                return;
            }
            Link::Ended => return,
        };
        let was_up = matches!(self.link, Link::Up { .. });
        self.link = Link::Waiting;
        if was_up {
            self.leave();
        }
        self.pause(why);
    }

    /// Resets the connection.
    pub(super) fn reset(&mut self, why: &'static str) {
        if matches!(self.link, Link::Up { .. }) {
            self.outbox.link(Output::Disconnect);
            self.link = Link::Closing { why };
            self.leave();
        }
    }

    /// Nothing is said or heard on this connection any more.
    fn leave(&mut self) {
        self.outbox.forget_sends();
        self.vehicle.forget_frames();
        self.reader = StreamReader::new(self.config.frame_limit_bytes);
        self.setup.clear();
        self.settings.clear();
        self.rejected.clear();
        self.starting.clear();
        self.not_subscribed = false;
        self.timers.stop(Timer::Health);
        if let Some((job, step, heard)) = self.take_exchange() {
            self.job_lost(job, &step, heard);
        }
    }

    fn pause(&mut self, why: &'static str) {
        if self.link == Link::Ended {
            return;
        }
        self.link = Link::Waiting;
        let pause = if self.ending.is_some() {
            SHUTDOWN_PAUSE
        } else if self.controller_ends {
            self.config.longest_pause()
        } else {
            self.config.pause(self.attempts)
        };
        self.attempts = self.attempts.saturating_add(1);
        self.timers.set(Timer::Connect, self.now + pause);
        self.tell(Event::Disconnected {
            address: format!("{}:{}", self.config.host, self.config.port).into_boxed_str(),
            why,
            retry_s: Some(pause.as_secs_f64()),
        });
    }
}

//! What is said to the controller, and what becomes of it.

use backseat_s7k::Time7k;
use backseat_s7k::plc::{Alarm, CalendarTime, Command, CommandId, Order as Text};

use super::{Link, Sonar};
use crate::event::Event;
use crate::io::Ticket;
use crate::job::{End, Job, Origin, Say, Step, Unset};
use crate::logging::FileDetails;
use crate::order::Outcome;
use crate::timer::Timer;

/// How often a setting of the mission is sent on a connection until the sensor takes it: with the usual health check,
/// for ten minutes.
const SETTING_ATTEMPTS: u32 = 60;
/// A sensor that rejects a setting for longer than this after its first rejection has started, and does not like the
/// value.
const STARTS_WITHIN_S: f64 = 10.0;

impl Sonar {
    /// Says the next thing, if nothing is under way.
    pub(super) fn advance(&mut self) {
        while self.exchanges.is_idle()
            && let Some(job) = self.next_job()
        {
            self.begin(job);
        }
    }

    fn next_job(&mut self) -> Option<Job> {
        let Link::Up { ready } = self.link else {
            return None;
        };
        if self.ending.is_some() {
            return None;
        }
        if !ready {
            if let Some(job) = self.setup.pop_front() {
                return Some(job);
            }
            if let Some(unset) = self.settings.pop_front() {
                return Some(Job::setting(&self.config, unset));
            }
            self.become_ready();
        }
        if let Some(waiting) = self.orders.pop_front() {
            return Job::order(&self.config, waiting.ticket, &waiting.order);
        }
        if core::mem::take(&mut self.due.restore)
            && let Some(on) = self.logging.to_restore()
        {
            return Some(Job::logging(&self.config, on, None));
        }
        if core::mem::take(&mut self.due.time_sync) {
            return Some(Job::time_sync(&self.config));
        }
        if let Some(unset) = self.settings.pop_front() {
            return Some(Job::setting(&self.config, unset));
        }
        core::mem::take(&mut self.due.health).then(|| Job::health(&self.config))
    }

    pub(super) fn health_is_due(&mut self) {
        self.due.health = true;
        self.settings.append(&mut self.rejected);
        self.timers.set(Timer::Health, self.now + self.config.health_period());
    }

    /// Begins a job, or goes on with its next step.
    pub(super) fn begin(&mut self, mut job: Job) {
        while let Some(step) = job.steps.pop_front() {
            let end = match self.say(&step) {
                Ok(()) if self.config.verbose || step.expects.is_some() => {
                    return self.exchanges.begin(self.now, job, step);
                }
                Ok(()) => End::Unconfirmed,
                Err(why) => End::Unwritable(why),
            };
            if !self.step_ended(&mut job, &step, end) {
                break;
            }
        }
        self.job_ended(job);
    }

    fn say(&mut self, step: &Step) -> Result<(), Box<str>> {
        let utc = self.utc();
        let text = match &step.say {
            Say::Text(text) => text.clone(),
            Say::TimeSync => Text::Do(Command::TimeSync {
                time: CalendarTime::from_utc(utc),
            }),
        };
        let bytes = self.writer.command(Time7k::from_utc(utc), step.target, &text)?;
        self.outbox.command(bytes);
        Ok(())
    }

    pub(super) fn say_again(&mut self) {
        let Some(step) = self.exchanges.current().map(|current| current.step.clone()) else {
            return;
        };
        match self.say(&step) {
            Ok(()) => self.exchanges.sent_again(self.now),
            Err(why) => self.end_step(End::Unwritable(why)),
        }
    }

    /// The command under way has ended.
    pub(super) fn end_step(&mut self, end: End) {
        let Some((mut job, step)) = self.exchanges.take(self.now) else {
            return;
        };
        let stalled = end == End::Silent && step.vital;
        let goes_on = self.step_ended(&mut job, &step, end);
        if stalled {
            self.job_ended(job);
            self.reset("it does not answer");
        } else if goes_on {
            self.begin(job);
        } else {
            self.job_ended(job);
        }
    }

    /// The command under way, taken because the connection is gone, and whether the controller has heard it.
    pub(super) fn take_exchange(&mut self) -> Option<(Job, Step, bool)> {
        let heard = self.exchanges.current().is_some_and(|current| current.is_heard());
        let (job, step) = self.exchanges.take(self.now)?;
        Some((job, step, heard))
    }

    /// Notes how a step ended. Returns whether the job goes on.
    fn step_ended(&mut self, job: &mut Job, step: &Step, end: End) -> bool {
        let accepted = matches!(end, End::Accepted | End::Unconfirmed);
        if end == End::Accepted {
            self.follow(step);
        }
        let fails_alone = matches!(
            job.origin,
            Origin::Setup | Origin::Routine | Origin::Restore(_) | Origin::Shutdown
        );
        if !accepted && fails_alone {
            self.tell(Event::CommandFailed {
                command: step.command(),
                sensor: step.subject.unwrap_or(step.target),
                why: Box::from(end.words()),
            });
        }
        if job.origin == Origin::Shutdown {
            // Each step is tried whatever became of the one before; the last one decides.
            job.end = Some(end);
            return true;
        }
        if job.end.is_none() {
            job.end = Some(end);
            return accepted;
        }
        job.incomplete |= !accepted && step.command() == CommandId::Switch;
        true
    }

    /// What follows from a command that the controller has accepted.
    fn follow(&mut self, step: &Step) {
        match &step.say {
            Say::TimeSync => self.controller_clock.forget(),
            Say::Text(Text::Do(Command::Logging { on })) => {
                if let Some(details) = self.logging.acknowledged(*on) {
                    self.report_logging(details);
                }
            }
            Say::Text(_) => {}
        }
    }

    fn job_ended(&mut self, job: Job) {
        match job.origin {
            Origin::Order(ticket, wanted) => {
                let outcome = outcome_of(job, wanted);
                self.outcome(ticket, outcome);
            }
            Origin::Shutdown => {
                let verbose = self.config.verbose;
                self.finish(match job.end {
                    // The status that tells of the shutdown may be lost with the connection.
                    Some(End::NoAnswer) => Outcome::Accepted { details: job.details },
                    Some(End::Silent) if !verbose => Outcome::Unconfirmed,
                    Some(
                        End::Accepted
                        | End::Unconfirmed
                        | End::Rejected
                        | End::Unknown
                        | End::Silent
                        | End::Unwritable(_),
                    )
                    | None => outcome_of(job, None),
                });
            }
            Origin::Setting(unset) => self.setting_ended(unset, job.end),
            Origin::Setup | Origin::Routine | Origin::Restore(_) => {}
        }
    }

    /// Whether a sensor that has rejected a setting so often before may still be starting.
    fn may_be_starting(&self, rejected: u32) -> bool {
        f64::from(rejected) * self.config.health_period_s < STARTS_WITHIN_S
    }

    /// Whether this alarm only says that a sensor which is starting has rejected a setting of the mission.
    pub(super) fn is_of_start(&self, alarm: &Alarm) -> bool {
        let Alarm::SensorCommandFailed { sensor, .. } = alarm else {
            return false;
        };
        let mut unset = self.settings.iter().chain(&self.rejected);
        let current = self.exchanges.current().map(|current| &current.job.origin);
        let is_new = |unset: &Unset, before: u32| unset.sensor == *sensor && self.may_be_starting(before);
        matches!(current, Some(Origin::Setting(unset)) if is_new(unset, unset.rejected))
            || unset.any(|unset| unset.rejected > 0 && is_new(unset, unset.rejected - 1))
    }

    /// A sensor rejects its settings until it has started, so they are tried again.
    fn setting_ended(&mut self, unset: Unset, end: Option<End>) {
        let Some(end) = end.filter(|end| !matches!(end, End::Accepted | End::Unconfirmed)) else {
            return;
        };
        let again = end == End::Rejected && unset.rejected + 1 < SETTING_ATTEMPTS;
        if again && self.may_be_starting(unset.rejected) {
            if self.starting.insert(unset.sensor.0) {
                let again_s = self.config.health_period_s;
                let sensor = unset.sensor;
                self.tell(Event::SensorStarting { sensor, again_s });
            }
        } else if !again || self.may_be_starting(unset.rejected - 1) {
            let mut setting = String::new();
            // What cannot be written has no name here, and `why` says so.
            let _unwritable = unset.setting.write(&mut setting);
            self.tell(Event::SettingFailed {
                sensor: unset.sensor,
                setting: setting.into_boxed_str(),
                why: Box::from(end.words()),
                again,
            });
        }
        if again {
            self.rejected.push_back(Unset {
                rejected: unset.rejected + 1,
                ..unset
            });
        }
    }

    /// The connection is gone in the middle of a job.
    pub(super) fn job_lost(&mut self, job: Job, step: &Step, heard: bool) {
        match job.origin {
            Origin::Order(ticket, _) => {
                let decided = matches!(job.end, Some(End::Accepted | End::Unconfirmed));
                let outcome = if decided { outcome_of(job, None) } else { Outcome::Lost };
                self.outcome(ticket, outcome);
            }
            // Otherwise the client connects once more and begins anew.
            Origin::Shutdown if step.command() == CommandId::Shutdown => self.finish(if heard {
                Outcome::Accepted { details: job.details }
            } else {
                Outcome::Lost
            }),
            Origin::Setup | Origin::Setting(_) | Origin::Routine | Origin::Restore(_) | Origin::Shutdown => {}
        }
    }

    /// Whether the command is under way.
    pub(super) fn is_saying(&self, command: CommandId) -> bool {
        let current = self.exchanges.current();
        current.is_some_and(|current| current.step.command() == command)
    }

    pub(super) fn outcome(&mut self, ticket: Ticket, outcome: Outcome) {
        self.tell(Event::Outcome { ticket, outcome });
    }

    pub(super) fn report_logging(&mut self, details: FileDetails) {
        let missing = self.logging.is_missing();
        self.report(Event::Logging { details, missing });
    }
}

fn outcome_of(job: Job, wanted: Option<bool>) -> Outcome {
    let details = job.details;
    let differs = details
        .as_ref()
        .is_some_and(|details| wanted.is_some_and(|wanted| wanted != details.on));
    match job.end {
        // A status proves what an acknowledgement would have said.
        Some(End::Unconfirmed) if details.is_none() => Outcome::Unconfirmed,
        Some(End::Accepted | End::Unconfirmed) if differs || job.incomplete => Outcome::Incomplete { details },
        Some(End::Accepted | End::Unconfirmed) => Outcome::Accepted { details },
        Some(End::Rejected) => Outcome::Rejected,
        Some(End::Unknown) => Outcome::Unknown,
        Some(End::NoAnswer | End::Silent) => Outcome::TimedOut { sent: true },
        Some(End::Unwritable(why)) => Outcome::Refused { why },
        None => Outcome::refused("there is nothing to say"),
    }
}

//! What is done to a run from outside, between two events.

use std::time::Duration;

use backseat_core::plugin::PluginId;
use backseat_core::{Input, Note, Operator, Output, Start};
use backseat_mvc::{Direction as Way, Fault, FaultKind};
use backseat_plugin_host::Plugin;
use backseat_plugin_loader::Loaded;
use backseat_units::Utc;

use crate::simulation::process::{Answer, Process, Successor};
use crate::simulation::{SimError, Simulation, add};

/// What a connection holds for a process that does not read. Beyond it the vehicle's end gives up.
const PILED_MAX: usize = 1 << 20;
/// What a process reads at once.
const READ: usize = 64 * 1024;

impl Simulation {
    /// Something goes wrong from now on, whatever `fault.at` says, for as long as it lasts: with the vehicle, or with
    /// the link, the connection that is there included. The rest of the run is as if the fault had been in the plan
    /// from the beginning.
    pub fn inject(&mut self, fault: Fault) {
        let fault = Fault { at: self.now, ..fault };
        if let FaultKind::Link(_) = fault.kind {
            if self.connected {
                let (faults, now, client) = (&self.faults, self.now, self.client);
                let link = |way| move || faults.link(now, client, None, way);
                self.to_vehicle.inject(&fault, link(Way::ToVehicle));
                self.to_payload.inject(&fault, link(Way::FromVehicle));
            }
            self.faults.inject(&fault);
        }
        self.mvc.inject(self.now, fault);
        let told = self.look().and_then(|()| self.drain_mvc());
        self.or_later(told);
    }

    /// The runtime's process is killed now, without a last word: the system resets its connection. After `away` another
    /// begins, with `loaded` as its plugins and nothing in memory. What is on the disk it finds: the SPI identifiers that
    /// were reserved, all of which may have been used, and the operator's hold, but not one that was said while the process
    /// was stopped. Its clock's UTC is wrong by `clock_step_ns`, and its attempts to connect are spread by another chance.
    ///
    /// A process that is not there again is not begun before `away` is over.
    pub fn kill(&mut self, away: Duration, loaded: Loaded, clock_step_ns: i64) {
        if self.finished {
            return;
        }
        let told = self.remark("the runtime is killed");
        self.or_later(told);
        self.disconnect();
        self.oracle.runtime_stopped(self.now);
        if let Some(process) = self.process.take() {
            add(&mut self.counts_before, process.core.request_counts());
            // A signal that it has not handled goes with it.
            if process.stopped.is_some_and(|stopped| !stopped.acts.is_empty()) {
                self.oracle.operator(self.now, self.disk.held);
            }
        }
        self.successor = Some(Successor {
            at: self.now + away,
            loaded,
            clock_step_ns,
        });
    }

    /// The runtime's process is stopped (SIGSTOP) for so long: the system keeps its connection and acknowledges what
    /// arrives, up to a mebibyte, beyond which the vehicle gives the connection up; nothing is handled, and no plugin
    /// goes on. Then it handles all of it, late: its timers first, then what the operator has done, then what it reads.
    pub fn stop_for(&mut self, pause: Duration) {
        if self.finished {
            return;
        }
        let until = self.now + pause;
        let Some(process) = &mut self.process else { return };
        process.stop(self.now, until);
        self.oracle.runtime_stopped(self.now);
        let told = self.remark("the runtime is stopped");
        self.or_later(told);
    }

    /// The operator acts. A process that is stopped hears of it when it goes on, and not if it is killed before; while there
    /// is none, a hold or a release is kept for the next one, and the rest is lost. [`Operator::Stop`] ends the run.
    pub fn operate(&mut self, act: Operator) {
        if self.finished {
            return;
        }
        self.tell_oracle(&act);
        match &mut self.process {
            None => self.keep(&act),
            Some(process) => match &mut process.stopped {
                Some(stopped) => stopped.acts.push(act),
                None => {
                    let done = self.feed(Input::Operator(act));
                    self.or_later(done);
                }
            },
        }
    }

    /// From now on a plugin's steps and restarts are those of an understudy; without one, its own again. Core is told
    /// nothing, a step under way still returns, and a killed process takes its understudies along.
    pub fn substitute(&mut self, slot: PluginId, understudy: Option<Plugin>) {
        if let Some(process) = &mut self.process {
            process.substitute(slot, understudy);
        }
    }

    /// Whether SPI identifiers can no longer be reserved, as on a full disk: the runtime's asking is not answered.
    pub fn reserve_fails(&mut self, fails: bool) {
        self.disk.full = fails;
    }

    /// The judge knows the operator's hold from whoever acts: no byte shows it.
    pub(super) fn tell_oracle(&mut self, act: &Operator) {
        match act {
            Operator::Hold => self.oracle.operator(self.now, true),
            Operator::Release => self.oracle.operator(self.now, false),
            Operator::Stop | Operator::Order(_) => {}
        }
    }

    /// Whether there is a process that handles what comes.
    pub(super) fn is_awake(&self) -> bool {
        self.process.as_ref().is_some_and(|process| process.stopped.is_none())
    }

    /// A plugin's answer has come.
    pub(super) fn answer(&mut self) -> Result<(), SimError> {
        let answer = self.process.as_mut().and_then(Process::next_answer);
        match answer {
            Some((plugin, Answer::Returned(returned))) => {
                if let Ok(requests) = &returned.result {
                    self.trace.asked(requests);
                }
                self.feed(Input::Returned(plugin, returned))
            }
            Some((plugin, Answer::Restarted(restarted))) => self.feed(Input::Restarted(plugin, restarted)),
            None => Ok(()),
        }
    }

    /// Core's timers are due, a stopped process goes on, or a new one begins.
    pub(super) fn wake(&mut self) -> Result<(), SimError> {
        match &mut self.process {
            None => self.begin(),
            Some(process) if process.stopped.is_some() => self.go_on(),
            Some(_) => self.feed(Input::Timeout),
        }
    }

    /// Bytes come to a process that does not read. False where there is no more room.
    pub(super) fn pile_up(&mut self, bytes: &[u8]) -> bool {
        let Some(stopped) = self.process.as_mut().and_then(|process| process.stopped.as_mut()) else {
            return true;
        };
        let fits = stopped.piled.len() + bytes.len() <= PILED_MAX;
        if fits {
            stopped.piled.extend_from_slice(bytes);
        }
        fits
    }

    /// The connection of a stopped process has ended.
    pub(super) fn miss_reset(&mut self) {
        if let Some(stopped) = self.process.as_mut().and_then(|process| process.stopped.as_mut()) {
            stopped.reset = true;
        }
    }

    /// Core's timers, the operator, the connection, in the order of the driver at sea; or the connection first, as another
    /// driver may have it.
    fn go_on(&mut self) -> Result<(), SimError> {
        let now = self.now;
        let Some(process) = &mut self.process else {
            return Ok(());
        };
        let Some(mut stopped) = process.stopped.take() else {
            return Ok(());
        };
        let due = process.is_due(now);
        self.oracle.runtime_continued(now);
        self.remark("the runtime goes on")?;
        let connection_first = ((now.as_nanos() / 1_000_000) ^ self.seed) & 1 == 1;
        if due && !connection_first {
            self.feed(Input::Timeout)?;
        }
        if !connection_first {
            for act in stopped.acts.drain(..) {
                self.feed(Input::Operator(act))?;
            }
        }
        for read in stopped.piled.chunks(READ) {
            // It may have reset the connection by itself meanwhile: what waited is thrown away with it.
            if self.is_linked() {
                self.feed(Input::Received(read))?;
            }
        }
        for act in stopped.acts {
            self.feed(Input::Operator(act))?;
        }
        if stopped.reset && self.is_linked() {
            return self.feed(Input::LinkDown);
        }
        Ok(())
    }

    /// Whether the runtime's connection is open, as far as it knows.
    fn is_linked(&self) -> bool {
        self.process.as_ref().is_some_and(|process| process.linked)
    }

    fn begin(&mut self) -> Result<(), SimError> {
        let Some(successor) = self.successor.take() else {
            return Ok(());
        };
        self.restarts += 1;
        let now = self.now;
        let utc = self.utc_at_start + now.since(backseat_units::Timestamp::ZERO);
        let start = Start {
            utc: Utc::from_unix_nanos(utc.as_unix_nanos().saturating_add_signed(successor.clock_step_ns)),
            identifiers: Some(self.disk.identifiers()),
            armed: true,
            held: self.disk.held,
            jitter: self.seed ^ u64::from(self.restarts) << 32,
        };
        if let Some(recorder) = &mut self.recorder {
            let told = recorder.restart(now, &start).map_err(SimError::from);
            self.or_later(told);
        }
        let (settings, envelope) = (self.settings.clone(), self.envelope.clone());
        self.process = Some(Process::new(now, settings, envelope, successor.loaded, start));
        self.oracle.runtime_started(now);
        self.remark("the runtime has begun anew")?;
        self.drain_core()
    }

    /// A line of the run's own in the log.
    fn remark(&mut self, text: &str) -> Result<(), SimError> {
        if let Some(recorder) = &mut self.recorder {
            let text = text.to_owned();
            recorder.output(self.now, &Output::Note(Note::Text { text }))?;
        }
        Ok(())
    }

    /// A failure where none can be returned is that of the next step.
    fn or_later(&mut self, result: Result<(), SimError>) {
        if let Err(failed) = result {
            self.failed.get_or_insert(failed);
        }
    }
}

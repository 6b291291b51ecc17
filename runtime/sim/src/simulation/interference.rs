//! What is done to a run from outside, between two events.

use std::time::Duration;

use backseat_core::plugin::{PluginId, Version};
use backseat_core::{Input, Operator, Start};
use backseat_mvc::{Direction as Way, Fault, FaultKind};
use backseat_plugin_host::Plugin;
use backseat_plugin_loader::Loaded;
use backseat_recorder::Remark;
use backseat_units::Utc;

use crate::simulation::process::{Answer, Process, Successor};
use crate::simulation::{SimError, Simulation};

/// How many bytes a connection holds for a process that does not read. With more than that, the vehicle gives the
/// connection up.
const PILED_MAX: usize = 1 << 20;
/// How many bytes a process reads at once.
const READ: usize = 64 * 1024;

impl Simulation {
    /// Injects a fault of the vehicle or of the link, which begins now, whatever `fault.at` says, and has its own
    /// duration. A fault of the link also affects the connection that is open. The rest of the run is as if the fault
    /// had been in the plan from the beginning.
    pub fn inject(&mut self, fault: Fault) {
        let fault = Fault { at: self.now, ..fault };
        if let FaultKind::Link(_) = fault.kind {
            self.break_link(&fault);
        }
        self.mvc.inject(self.now, fault);
        let told = self.look().and_then(|()| self.drain_mvc());
        self.or_later(told);
    }

    /// Begins a fault of the link, on the connection that is open and on those to come.
    pub(super) fn break_link(&mut self, fault: &Fault) {
        if self.connected {
            let (faults, now, client) = (&self.faults, self.now, self.client);
            let link = |way| move || faults.link(now, client, None, way);
            self.to_vehicle.inject(fault, link(Way::ToVehicle));
            self.to_payload.inject(fault, link(Way::FromVehicle));
        }
        self.faults.inject(fault);
    }

    /// Kills the runtime's process now, without a last message: the operating system resets its connection. After
    /// `away` another process begins, with `loaded` as its plugins and nothing in memory. It finds what is on the disk:
    /// the SPI identifiers that were reserved, all of which may have been used, and the operator's hold, but not a hold
    /// that was ordered while the process was stopped. Its clock's UTC is wrong by `clock_step_ns`, and the random
    /// pauses between its attempts to connect are different.
    ///
    /// If no process runs now, the next one begins when `away` is over, and not earlier.
    pub fn kill(&mut self, away: Duration, loaded: Loaded, clock_step_ns: i64) {
        if self.finished {
            return;
        }
        let told = self.remark(Remark::Killed);
        self.or_later(told);
        self.disconnect();
        self.lose_client();
        self.oracle.runtime_stopped(self.now);
        if let Some(process) = self.process.take() {
            self.counts_before += process.core.request_counts().of_ended_process();
            // An act of the operator that it has not handled is lost with it.
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

    /// Stops the runtime's process (SIGSTOP) for `pause`. The operating system keeps its connection and acknowledges
    /// what arrives, up to a mebibyte; with more than that, the vehicle gives the connection up. Nothing is handled,
    /// and no plugin goes on. After the pause the process handles all of it, late: its timers first, then what the
    /// operator has done, then what it reads. Depending on the time and the seed, it may also begin with what it reads.
    pub fn stop_for(&mut self, pause: Duration) {
        if self.finished {
            return;
        }
        let until = self.now + pause;
        let Some(process) = &mut self.process else { return };
        process.stop(self.now, until);
        self.oracle.runtime_stopped(self.now);
        let told = self.remark(Remark::Stopped);
        self.or_later(told);
    }

    /// Acts as the operator. A stopped process learns of the act when it goes on, and never if it is killed before.
    /// While there is no process, a hold or a release is kept for the next one, and any other act is lost.
    /// [`Operator::Stop`] ends the run.
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

    /// From now on an understudy does a plugin's steps and restarts; with `None`, the plugin does them itself again.
    /// Core does not learn of it, a step that is under way still returns, and a process that is killed loses its
    /// understudies.
    pub fn substitute(&mut self, slot: PluginId, understudy: Option<Plugin>) {
        if let Some(process) = &mut self.process {
            let remark = if understudy.is_some() {
                Remark::Substituted(slot)
            } else {
                Remark::Reinstated(slot)
            };
            process.substitute(slot, understudy);
            let told = self.remark(remark);
            self.or_later(told);
        }
    }

    /// The operator puts another version, which has been started, in a plugin's place. A process that is stopped, or is
    /// not there, does not learn of it, and neither does one in which an understudy answers for the plugin. A log has the
    /// swap, and not the component.
    pub fn swap(&mut self, slot: PluginId, ready: Plugin, version: Version) {
        if self.finished || !self.is_awake() {
            return;
        }
        if let Some(process) = &mut self.process {
            if process.has_understudy(slot) {
                return;
            }
            process.offer(slot, ready, version.clone());
        }
        let told = self.feed(Input::Swap(slot, version));
        self.or_later(told);
    }

    /// Sets whether SPI identifiers can no longer be reserved, as on a full disk: the runtime's requests for them then
    /// get no answer.
    pub fn reserve_fails(&mut self, fails: bool) {
        self.disk.full = fails;
    }

    /// Tells the oracle about the operator's hold, which no byte on the link shows.
    pub(super) fn tell_oracle(&mut self, act: &Operator) {
        match act {
            Operator::Hold => self.oracle.operator(self.now, true),
            Operator::Release => self.oracle.operator(self.now, false),
            Operator::Stop | Operator::Order(_) => {}
        }
    }

    /// Whether there is a process that is not stopped.
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

    /// Bytes come to a process that does not read. Returns false if there is no more room.
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

    /// A stopped process goes on. It handles core's timers, the operator and the connection, in the order of the driver
    /// at sea; or the connection first, as another driver might.
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
        self.remark(Remark::Continues)?;
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
            // The process may have reset the connection by itself in the meantime. What waited is then lost with it.
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
        let utc = start.utc;
        let bridge = self.sonar.as_ref().map(|sonar| sonar.bridge(utc)).transpose()?;
        self.process = Some(Process::new(now, settings, envelope, successor.loaded, start, bridge));
        self.oracle.runtime_started(now);
        self.remark(Remark::StartedAgain)?;
        self.drain_core()?;
        self.drain_client()
    }

    /// Writes what the simulation does to the process into the log.
    fn remark(&mut self, remark: Remark) -> Result<(), SimError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.remark(self.now, remark)?;
        }
        Ok(())
    }

    /// Keeps an error that cannot be returned here for the next step.
    fn or_later(&mut self, result: Result<(), SimError>) {
        if let Err(failed) = result {
            self.failed.get_or_insert(failed);
        }
    }
}

//! The driver of core: hands in its inputs and carries out its outputs.

use backseat_core::plugin::{FaultKind, LogLevel, QUARANTINED, RequestState};
use backseat_core::{Input, Note, Operator, Output};

use crate::digest::Direction;
use crate::report::{FirstFailure, Published};
use crate::simulation::process::Process;
use crate::simulation::{SimError, Simulation};

/// How many different reasons for rejections are reported.
const REASONS_MAX: usize = 20;
/// How the line begins that Rust writes for a panic, and that the SDK logs.
const PANIC: &str = "panicked at ";

impl Simulation {
    /// Ends the run. Also tells the runtime's process to stop, if it is awake.
    pub(super) fn stop(&mut self) -> Result<(), SimError> {
        self.finished = true;
        if self.is_awake() {
            self.feed(Input::Operator(Operator::Stop))?;
        }
        Ok(())
    }

    /// Hands core an input, and carries out what follows, also at the sonars.
    pub(super) fn feed(&mut self, input: Input<'_>) -> Result<(), SimError> {
        self.feed_core(input)?;
        self.drain_client()
    }

    pub(super) fn feed_core(&mut self, input: Input<'_>) -> Result<(), SimError> {
        let Some(process) = &mut self.process else {
            return Ok(());
        };
        if let Some(recorder) = &mut self.recorder {
            recorder.input(self.now, &input)?;
        }
        process.handle(self.now, input);
        if let Some(recorder) = &mut self.recorder
            && let Some(sample) = process.new_navigation()
        {
            recorder.navigation(self.now, sample)?;
        }
        self.drain_core()
    }

    pub(super) fn drain_core(&mut self) -> Result<(), SimError> {
        loop {
            while let Some(process) = &mut self.process
                && let Some(output) = process.core.poll_output()
            {
                if let Some(recorder) = &mut self.recorder {
                    recorder.output(self.now, &output)?;
                }
                self.carry_out(output);
            }
            // An answer that the driver gives at once is an input like any other.
            let Some(process) = &mut self.process else {
                return Ok(());
            };
            let input = if let Some(reservation) = process.reserved.take() {
                Input::Reserved(reservation)
            } else if std::mem::take(&mut process.reset) {
                self.disconnect();
                Input::LinkDown
            } else {
                return Ok(());
            };
            if let Some(recorder) = &mut self.recorder {
                recorder.input(self.now, &input)?;
            }
            if let Some(process) = &mut self.process {
                process.handle(self.now, input);
            }
        }
    }

    fn carry_out(&mut self, output: Output) {
        let now = self.now;
        let Some(process) = &mut self.process else { return };
        match output {
            // Bytes that are written to a connection that is gone go nowhere.
            Output::Send(_) if !self.connected => {}
            Output::Send(bytes) => {
                self.digest.write(Direction::ToVehicle, now, &bytes);
                self.oracle.runtime_writes(now, &bytes);
                self.trace.sent(&bytes);
                self.to_vehicle.write(now, &bytes, |_| {});
            }
            Output::Connect { after } => process.connect_at = Some(now + after),
            Output::ResetLink => process.reset = true,
            Output::Invoke(plugin, input) => process.step(now, plugin, &input),
            Output::Restart(plugin) => process.restart(now, plugin),
            // If nothing can be written, there is no answer: the runtime sends no insert without a reserved identifier.
            Output::Reserve(reservation) if !self.disk.full => {
                self.disk.reservation = reservation;
                process.reserved = Some(reservation);
            }
            Output::Reserve(_) => {}
            Output::Finish => self.finished = true,
            Output::Sonar(wish) => {
                if let Some(client) = &mut process.client {
                    client.wishes.push_back(wish);
                }
            }
            // No external source runs in simulation, so nobody reads this.
            Output::External(..) => {}
            Output::Note(note) => self.note(&note),
        }
    }

    fn note(&mut self, note: &Note) {
        if let Note::Operator { act } = note {
            // This also covers a hold by a policy or a mission command.
            self.tell_oracle(act);
            self.keep(act);
        }
        if let Note::PluginLog { plugin, line } = note
            && line.level == LogLevel::Error
            && let Some(name) = self.names.get(plugin.0)
        {
            let is_first = self.last_words.get(name).is_none_or(|(at, _)| *at != self.now);
            if is_first || line.text.starts_with(PANIC) {
                let text = line.text.lines().collect::<Vec<_>>().join(" ");
                self.last_words.insert(name.clone(), (self.now, text));
            }
        }
        if let Note::PluginFailed { plugin, fault, then } = note
            && let Some(name) = self.names.get(plugin.0)
        {
            let now = self.now;
            // A trap carries no text. The panic or exception that led to it was logged in the same step.
            let said = self
                .last_words
                .get(name)
                .filter(|(at, _)| *at == now && fault.kind == FaultKind::Trap);
            self.first_failures.entry(name.clone()).or_insert_with(|| FirstFailure {
                at_s: now.as_secs_f64(),
                text: match said {
                    Some((_, panic)) if panic.starts_with(PANIC) => panic.clone(),
                    Some((_, line)) => format!("{}; it logged: {line}", fault.text),
                    None => fault.text.clone(),
                },
            });
            *self.plugin_failures.entry(name.clone()).or_default() += 1;
            if *then == QUARANTINED {
                self.quarantines.insert(name.clone(), now.as_secs_f64());
            }
        }
        if let Note::PluginMeasure { plugin, measure } = note
            && let Some(name) = self.names.get(plugin.0)
        {
            let published = Published {
                value: measure.value,
                unit: measure.unit.clone(),
            };
            self.published.insert(format!("{name}.{}", measure.name), published);
        }
        if let Note::Request(transition) = note
            && let RequestState::Rejected(refusal) = &transition.state
        {
            // Reasons that differ only in their figures count as one; the first of them is reported.
            let kind = (refusal.rule(), refusal.summary());
            let full = self.reasons.len() >= REASONS_MAX;
            match self.reasons.get_mut(&kind) {
                Some((count, _)) => *count += 1,
                None if full => {}
                None => {
                    self.reasons.insert(kind, (1, refusal.to_string()));
                }
            }
        }
        let position = self.process.as_ref().and_then(Process::position);
        self.trace.note(self.now, note, position);
    }

    /// A hold and a release outlive the process, whoever ordered them.
    pub(super) fn keep(&mut self, act: &Operator) {
        match act {
            Operator::Hold => self.disk.held = true,
            Operator::Release => self.disk.held = false,
            Operator::Stop | Operator::Order(_) => {}
        }
    }
}

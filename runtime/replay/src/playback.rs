//! A log, message by message: core and plugins do again what they did.

use std::collections::{BTreeMap, VecDeque};

use backseat_core::plugin::PluginId;
use backseat_core::{Core, Note, Output, Owner, Start, Transition};
use backseat_mission::Mission;
use backseat_plugin_host::Host;
use backseat_recorder::{Channel, Encoded, Encoder, LoggedInput, Message, Record, Remark, Run};
use backseat_units::{EastNorth, Timestamp};

use crate::crew::Crew;
use crate::difference::{Difference, OutputDifference, StepDifference, changes};
use crate::drawing::Sketch;
use crate::error::ReplayError;
use crate::member::{Apart, Order, Stepped};
use crate::report::{Refused, Report, rate_name};
use crate::task::{Given, Task, hash};

/// Whether a replay goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// It takes the next message.
    GoesOn,
    /// It is over: nothing after this can be replayed.
    Over,
}

/// A replay in progress.
pub struct Replay {
    host: Host,
    /// The components that were given for those that the log has by their hash alone, and those that the log has attached
    /// after its start, by their SHA-256.
    attached: BTreeMap<String, Vec<u8>>,
    run: Run,
    mission: Mission,
    crew: Crew,
    encoder: Encoder,
    process: Option<Process>,
    /// Outputs that core has produced and the log must have next.
    expected: VecDeque<Encoded>,
    /// The last input.
    input: Option<Message>,
    /// The sequence number that comes next.
    next: Option<u32>,
    newest: Timestamp,
    processes: u64,
    inputs: u64,
    outputs: u64,
    outputs_different: u64,
    first: Option<Difference>,
    refused: Option<Refused>,
    sketch: Sketch,
}

/// A process of the runtime.
struct Process {
    core: Core,
    /// When it began. Its own clock counts from there.
    epoch: Timestamp,
}

impl Replay {
    /// A replay that has not begun. It compiles and starts the plugins: those of the log, except where one is given. Of
    /// each plugin it keeps the first `steps_max` steps that differ.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] if a component is missing or cannot be used.
    pub fn new(task: Task, host: &Host, given: Vec<Given>, steps_max: usize) -> Result<Self, ReplayError> {
        let crew = Crew::new(&task, host, given, steps_max)?;
        let encoder = Encoder::new(task.run.rate, task.names());
        let Task {
            run,
            mission,
            components,
            ..
        } = task;
        Ok(Self {
            host: host.clone(),
            attached: components,
            run,
            mission,
            crew,
            encoder,
            process: None,
            expected: VecDeque::new(),
            input: None,
            next: None,
            newest: Timestamp::ZERO,
            processes: 0,
            inputs: 0,
            outputs: 0,
            outputs_different: 0,
            first: None,
            refused: None,
            sketch: Sketch::default(),
        })
    }

    /// The mission that was flown.
    #[must_use]
    pub const fn mission(&self) -> &Mission {
        &self.mission
    }

    /// Whether the log has named this component so far, as one that flew.
    #[must_use]
    pub fn names(&self, sha256: &str) -> bool {
        self.crew.named.contains(sha256)
    }

    /// Takes a component that the log has attached since its start: a version that is about to take a plugin's place.
    pub fn attach(&mut self, component: &[u8]) {
        self.attached.insert(hash(component), component.to_vec());
    }

    /// Takes the next message of the log.
    ///
    /// # Errors
    ///
    /// [`ReplayError::Message`] and [`ReplayError::NoStart`] if the log is not as it should be.
    pub fn take(&mut self, message: Message) -> Result<Flow, ReplayError> {
        if self.refused.is_some() {
            return Ok(Flow::Over);
        }
        let sequence = message.sequence;
        if let Some(from) = self
            .next
            .replace(sequence.wrapping_add(1))
            .filter(|next| *next != sequence)
        {
            self.refused = Some(Refused::Missing {
                from,
                until: sequence,
                at_s: message.now.as_secs_f64(),
            });
            return Ok(Flow::Over);
        }
        self.newest = self.newest.max(message.now);
        match Channel::from_topic(&message.topic) {
            Some(Channel::FromVehicle | Channel::Input) => self.input(message)?,
            Some(Channel::Notes) => match remark(&message) {
                Some(remark) => self.remark(remark),
                // Core does not know who asked.
                None if is_asked(&message) => {}
                None => self.output(&message),
            },
            Some(Channel::ToVehicle | Channel::Output | Channel::Requests | Channel::Control) => self.output(&message),
            None if message.topic.starts_with("/measures/") => self.output(&message),
            // What follows from other messages, or what only a simulation knows.
            Some(Channel::Navigation | Channel::Truth | Channel::Vehicle) | None => {}
        }
        Ok(if self.refused.is_some() {
            Flow::Over
        } else {
            Flow::GoesOn
        })
    }

    /// What was found. `complete` says whether the log has its end; if not, its last outputs may be missing.
    #[must_use]
    pub fn finish(mut self, complete: bool) -> Report {
        if complete && self.refused.is_none() {
            self.missing();
        }
        let plugins_same = self.crew.members.iter().all(|member| member.report.different == 0);
        let identical = if self.first.is_some() || self.outputs_different > 0 || !plugins_same {
            Some(false)
        } else if self.refused.is_some() || self.crew.members.iter().any(|member| member.report.absent.is_some()) {
            None
        } else {
            Some(true)
        };
        Report {
            mission: self.run.mission,
            seed: self.run.seed,
            version: self.run.version,
            rate: rate_name(self.run.rate),
            seconds: self.newest.as_secs_f64(),
            complete,
            processes: self.processes,
            inputs: self.inputs,
            outputs: self.outputs,
            outputs_different: self.outputs_different,
            stops_played: self.crew.members.iter().map(|member| member.stops_played).sum(),
            plugins: self.crew.members.into_iter().map(|member| member.report).collect(),
            identical,
            first_difference: self.first,
            refused: self.refused,
            drawing: self.sketch.drawing,
        }
    }

    /// What the simulation did to the process.
    fn remark(&mut self, remark: Remark) {
        match remark {
            Remark::Killed => {
                self.missing();
                self.process = None;
            }
            Remark::Substituted(plugin) | Remark::Reinstated(plugin) => {
                if let Some(member) = self.crew.members.get_mut(plugin.0) {
                    member.substituted = matches!(remark, Remark::Substituted(_));
                }
            }
            Remark::Stopped | Remark::Continues | Remark::StartedAgain => {}
        }
    }

    fn input(&mut self, message: Message) -> Result<(), ReplayError> {
        self.missing();
        let record = message.record().map_err(|source| invalid(&message, source))?;
        match record {
            Some(Record::Start(start)) => self.start(start, &message)?,
            Some(Record::Gap { since_s, records }) => {
                self.refused = Some(Refused::Gap {
                    since_s,
                    until_s: message.now.as_secs_f64(),
                    records,
                });
            }
            Some(Record::Input(input)) => self.handle(input, &message)?,
            // Nothing else is on these channels.
            _ => {}
        }
        self.input = Some(message);
        Ok(())
    }

    fn start(&mut self, start: Start, message: &Message) -> Result<(), ReplayError> {
        // In a log of an earlier version no remark says that a process was killed.
        self.processes += 1;
        if self.processes > 1 {
            for member in &mut self.crew.members {
                member.begin(&self.crew.components, &self.mission)?;
            }
        }
        let settings = self.mission.file.session.clone();
        let core = Core::new(settings, self.mission.envelope.clone(), self.crew.setups.clone(), start);
        self.process = Some(Process {
            core,
            epoch: if self.processes > 1 {
                message.now
            } else {
                Timestamp::ZERO
            },
        });
        self.drain(message).map(drop)
    }

    fn handle(&mut self, input: LoggedInput, message: &Message) -> Result<(), ReplayError> {
        if self.process.is_none() {
            return Err(ReplayError::NoStart {
                message: message.sequence,
            });
        }
        self.inputs += 1;
        let mut asked = None;
        let mut apart = None;
        match &input {
            LoggedInput::Returned(plugin, returned) => {
                asked = returned.result.clone().ok().map(|requests| (*plugin, requests));
                apart = self.step(*plugin, returned, message)?;
            }
            LoggedInput::Restarted(plugin, restarted) => {
                if let Some(member) = self.crew.members.get_mut(plugin.0) {
                    let found = member.restarted(restarted, message);
                    if let Some(found) = found.map_err(|source| invalid(message, source))? {
                        self.first.get_or_insert(Difference::Restart(found));
                    }
                }
            }
            LoggedInput::Swap(plugin, version) => {
                let (host, attached) = (&self.host, &self.attached);
                let version = (version.clone(), message.now.as_secs_f64());
                self.crew.swap(host, *plugin, version, attached, &self.mission)?;
            }
            LoggedInput::LinkUp
            | LoggedInput::LinkDown
            | LoggedInput::Received(_)
            | LoggedInput::Operator(_)
            | LoggedInput::External(..)
            | LoggedInput::Sonar(_)
            | LoggedInput::Reserved(_)
            | LoggedInput::UtcSet(_)
            | LoggedInput::Timeout => {}
        }
        if let Some(process) = &mut self.process {
            process
                .core
                .handle(own_time(process.epoch, message.now), input.as_input());
        }
        let transitions = self.drain(message)?;
        if let Some((plugin, requests)) = &asked {
            self.sketch.asked(*plugin, requests, &transitions);
        }
        if let Some((plugin, apart)) = apart {
            self.parted(plugin, *apart, &transitions);
        }
        Ok(())
    }

    /// Does a step again, and returns it if it differs.
    fn step(
        &mut self,
        plugin: PluginId,
        returned: &backseat_core::plugin::Returned,
        message: &Message,
    ) -> Result<Option<(PluginId, Box<Apart>)>, ReplayError> {
        let Some(member) = self.crew.members.get_mut(plugin.0) else {
            return Ok(None);
        };
        let stepped = member
            .returned(returned, message, &self.mission)
            .map_err(|source| invalid(message, source))?;
        match stepped {
            Stepped::Same => Ok(None),
            Stepped::Apart(apart) => Ok(Some((plugin, apart))),
            Stepped::Unasked => {
                // Core has not asked for this step in the replay, so an output has differed before, or the log was
                // changed.
                member.report.different += 1;
                let recorded = String::from_utf8_lossy(&message.data).into_owned();
                self.first.get_or_insert_with(|| {
                    Difference::Output(OutputDifference {
                        at_s: message.now.as_secs_f64(),
                        message: None,
                        input_message: message.sequence,
                        input: recorded,
                        channel: Channel::Output.topic().to_owned(),
                        recorded: Some("the answer to a step".to_owned()),
                        replayed: None,
                        changes: vec!["core has not asked for this step".to_owned()],
                    })
                });
                Ok(None)
            }
        }
    }

    /// Notes a step that differs, with what core made of the recorded one.
    fn parted(&mut self, plugin: PluginId, apart: Apart, transitions: &[Transition]) {
        let Apart {
            difference,
            from,
            recorded,
            now,
        } = apart;
        let own = transitions
            .iter()
            .filter(|transition| transition.owner == Owner::Plugin(plugin));
        let difference = StepDifference {
            judgement: own
                .map(|transition| Note::Request(transition.clone()).to_string())
                .collect(),
            ..difference
        };
        self.sketch.differs(from, &recorded, &now);
        if let Some(member) = self.crew.members.get_mut(plugin.0) {
            member.keep(&difference);
        }
        self.first.get_or_insert(Difference::Step(difference));
    }

    /// Takes what core asks for. Returns what becomes of requests.
    fn drain(&mut self, message: &Message) -> Result<Vec<Transition>, ReplayError> {
        let mut transitions = Vec::new();
        let Some(process) = &mut self.process else {
            return Ok(transitions);
        };
        while let Some(output) = process.core.poll_output() {
            let encoded = self
                .encoder
                .output(&output)
                .map_err(|source| invalid(message, source))?;
            self.expected.extend(encoded);
            match output {
                Output::Invoke(plugin, input) => {
                    self.crew.order(plugin, message.now, Some(Box::new(input)));
                }
                Output::Restart(plugin) => self.crew.order(plugin, message.now, None),
                Output::Note(Note::Request(transition)) => {
                    self.sketch.transition(&transition);
                    transitions.push(transition);
                }
                Output::Send(_)
                | Output::Connect { .. }
                | Output::ResetLink
                | Output::External(..)
                | Output::Sonar(_)
                | Output::Reserve(_)
                | Output::Finish
                | Output::Note(_) => {}
            }
        }
        if let Some(navigation) = process.core.navigation() {
            let local: EastNorth = navigation.local;
            self.sketch.at(message.now, local, process.core.is_steering());
        }
        Ok(transitions)
    }

    /// Compares an output of the log with what core has done.
    fn output(&mut self, message: &Message) {
        self.outputs += 1;
        let replayed = self.expected.pop_front();
        let same = replayed
            .as_ref()
            .is_some_and(|replayed| replayed.topic == *message.topic && replayed.data == message.data);
        if !same {
            self.differs(Some(message), replayed.as_ref());
        }
    }

    /// What core has done and the log does not have.
    fn missing(&mut self) {
        while let Some(replayed) = self.expected.pop_front() {
            self.outputs += 1;
            self.differs(None, Some(&replayed));
        }
    }

    fn differs(&mut self, recorded: Option<&Message>, replayed: Option<&Encoded>) {
        self.outputs_different += 1;
        if self.first.is_some() {
            return;
        }
        let text = |data: &[u8]| String::from_utf8_lossy(data).into_owned();
        let topic = recorded
            .map(|recorded| recorded.topic.to_string())
            .or_else(|| replayed.map(|replayed| replayed.topic.to_string()));
        let changes = match (recorded, replayed) {
            (Some(recorded), Some(replayed)) if replayed.topic == *recorded.topic => {
                changes(&recorded.data, &replayed.data)
            }
            (Some(recorded), Some(replayed)) => {
                vec![format!("channel {} recorded, {} now", recorded.topic, replayed.topic)]
            }
            (_, _) => Vec::new(),
        };
        let input = self.input.as_ref();
        self.first = Some(Difference::Output(OutputDifference {
            at_s: input.map_or(self.newest, |input| input.now).as_secs_f64(),
            message: recorded.map(|recorded| recorded.sequence),
            input_message: input.map_or(0, |input| input.sequence),
            input: input.map_or_else(String::new, |input| text(&input.data)),
            channel: topic.unwrap_or_default(),
            recorded: recorded.map(|recorded| text(&recorded.data)),
            replayed: replayed.map(|replayed| text(&replayed.data)),
            changes,
        }));
    }
}

impl Crew {
    /// Notes what core asks of a plugin.
    fn order(&mut self, plugin: PluginId, at: Timestamp, step: Option<Box<backseat_core::plugin::StepInput>>) {
        if let Some(member) = self.members.get_mut(plugin.0) {
            member.orders.push_back(Order {
                at,
                step,
                unplayed: member.substituted || member.lost,
            });
        }
    }
}

/// A time of the run on the process's own clock.
fn own_time(epoch: Timestamp, now: Timestamp) -> Timestamp {
    Timestamp::ZERO + now.since(epoch)
}

fn invalid(message: &Message, source: serde_json::Error) -> ReplayError {
    ReplayError::Message {
        message: message.sequence,
        channel: message.topic.to_string(),
        source,
    }
}

/// Whether a note is the driver's, about what somebody asked of it.
fn is_asked(message: &Message) -> bool {
    message.data.starts_with(br#"{"note":"asked","#)
}

/// What a simulation did to the process, if this message says so.
fn remark(message: &Message) -> Option<Remark> {
    const MARK: &[u8] = b"\"simulation\":";
    if !message.data.windows(MARK.len()).any(|part| part == MARK) {
        return None;
    }
    Remark::of_note(&serde_json::from_slice(&message.data).ok()?)
}

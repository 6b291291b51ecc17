//! What is said to the controller: jobs of one or more commands, each a step.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Command, CommandId, Generic, Order as Text};

use crate::config::{SensorConfig, ShutdownKind, SonarConfig};
use crate::io::Ticket;
use crate::logging::FileDetails;
use crate::order::Order;

/// The numbers of the statuses that commands solicit (Table 17).
pub(crate) mod status_id {
    pub(crate) const VERSION: i32 = 0;
    pub(crate) const MODULES: i32 = 1;
    pub(crate) const RUN_LIST: i32 = 2;
    pub(crate) const FILE_DETAILS: i32 = 3;
    pub(crate) const SENSOR_REPLY: i32 = 4;
    pub(crate) const LOGGING_SETUP: i32 = 5;
    pub(crate) const HEALTH: i32 = 6;
    pub(crate) const SHUTDOWN: i32 = 7;
}

/// The longest that a step of a shutdown waits for its answer. All steps fit into [`crate::SHUTDOWN_WITHIN`].
const SHUTDOWN_STEP: Duration = Duration::from_millis(1500);

/// Why something is said.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Origin {
    /// A step of every new connection.
    Setup,
    /// A setting of the mission for a sensor, which may not have started yet.
    Setting(Unset),
    /// An order, with the state of logging that it wants.
    Order(Ticket, Option<bool>),
    /// Logging as it was ordered before the connection was lost.
    Restore(bool),
    /// Health, or the time after the clock was set.
    Routine,
    /// The end.
    Shutdown,
}

/// A setting of the mission that a sensor does not have yet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unset {
    pub(crate) sensor: SensorIndex,
    pub(crate) setting: Generic,
    /// How often the controller has rejected it.
    pub(crate) rejected: u32,
}

/// What a command says. The time is written when it is sent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Say {
    Text(Text),
    TimeSync,
}

/// One command and its answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Step {
    pub(crate) say: Say,
    /// Whom the command's record is for.
    pub(crate) target: SensorIndex,
    /// The sensor in its parameters: some controllers may name it in the acknowledgement.
    pub(crate) subject: Option<SensorIndex>,
    /// The status that the command solicits.
    pub(crate) expects: Option<i32>,
    pub(crate) timeout: Duration,
    /// How often it is sent in all.
    pub(crate) sends: u32,
    /// Whether silence means that the controller has stalled.
    pub(crate) vital: bool,
}

/// How a step ended.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum End {
    Accepted,
    /// No acknowledgement is expected.
    Unconfirmed,
    Rejected,
    Unknown,
    /// Acknowledged, but what was solicited did not come.
    NoAnswer,
    /// Neither acknowledged nor answered.
    Silent,
    /// It cannot be written.
    Unwritable(Box<str>),
}

impl End {
    /// For the log.
    pub(crate) fn words(&self) -> &str {
        match self {
            Self::Accepted => "accepted",
            Self::Unconfirmed => "not confirmed",
            Self::Rejected => "rejected",
            Self::Unknown => "unknown to the controller",
            Self::NoAnswer => "acknowledged without an answer",
            Self::Silent => "not answered",
            Self::Unwritable(why) => why,
        }
    }
}

/// Steps that belong together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Job {
    pub(crate) origin: Origin,
    pub(crate) steps: VecDeque<Step>,
    /// How the step ended that decides.
    pub(crate) end: Option<End>,
    /// A step after that one was not accepted.
    pub(crate) incomplete: bool,
    /// The state of logging, if it was asked for.
    pub(crate) details: Option<FileDetails>,
}

impl Step {
    pub(crate) fn command(&self) -> CommandId {
        match &self.say {
            Say::Text(text) => text.command(),
            Say::TimeSync => CommandId::TimeSync,
        }
    }

    fn new(config: &SonarConfig, say: Say, expects: Option<i32>) -> Self {
        Self {
            say,
            target: SensorIndex::PLC,
            subject: None,
            expects,
            timeout: config.command_timeout(),
            sends: config.command_attempts,
            vital: true,
        }
    }

    fn of(config: &SonarConfig, command: Command, expects: Option<i32>) -> Self {
        Self::new(config, Say::Text(Text::Do(command)), expects)
    }

    fn subscribe(config: &SonarConfig, sensor: SensorIndex, record_type: u32) -> Self {
        let command = Command::Subscribe { sensor, record_type };
        Self {
            subject: Some(sensor),
            ..Self::of(config, command, None)
        }
    }

    /// A file must not change twice because an acknowledgement was late: it is sent once, and waits as long as the
    /// others do in all.
    fn switch(config: &SonarConfig, name: &str) -> Self {
        let step = Self::of(config, Command::Switch { name: Box::from(name) }, None);
        Self {
            timeout: step.timeout.saturating_mul(step.sends),
            sends: 1,
            ..step
        }
    }

    fn set(config: &SonarConfig, sensor: SensorIndex, setting: &Generic) -> Self {
        let pulses = matches!(setting, Generic::PulseFiles {}).then_some(status_id::SENSOR_REPLY);
        // A setting that cannot be written is refused when the step is sent.
        let mut text = String::new();
        let written = setting.write(&mut text);
        let text = if written.is_ok() { text } else { String::new() };
        let command = Command::Generic {
            text: text.into_boxed_str(),
        };
        Self {
            target: sensor,
            ..Self::of(config, command, pulses)
        }
    }

    fn in_shutdown(self, sends: u32) -> Self {
        Self {
            timeout: self.timeout.min(SHUTDOWN_STEP),
            sends: sends.min(self.sends),
            vital: false,
            ..self
        }
    }
}

impl Job {
    fn new(origin: Origin, steps: impl IntoIterator<Item = Step>) -> Self {
        Self {
            origin,
            steps: steps.into_iter().collect(),
            end: None,
            incomplete: false,
            details: None,
        }
    }

    /// Everything that is said on a new connection, in order; a job each, because a rejected one does not stop the
    /// others.
    pub(crate) fn setup(config: &SonarConfig) -> VecDeque<Self> {
        use status_id as s;
        let of = |command: Command, expects: Option<i32>| Step::of(config, command, expects);
        let mut steps = vec![of(Command::Verbose { on: config.verbose }, None)];
        if config.time_sync {
            steps.push(Step::new(config, Say::TimeSync, None));
        }
        let on = config.time_messages;
        steps.push(of(Command::TimeMessages { on }, None));
        steps.push(of(Command::Version {}, Some(s::VERSION)));
        steps.push(of(Command::Modules {}, Some(s::MODULES)));
        steps.push(of(Command::RunList {}, Some(s::RUN_LIST)));
        for sensor in &config.sensor {
            let index = SensorIndex(sensor.index);
            steps.extend(
                sensor
                    .records
                    .iter()
                    .map(|record| Step::subscribe(config, index, *record)),
            );
        }
        if let Some(sensor) = config.route_to.map(SensorIndex) {
            steps.push(Step {
                subject: Some(sensor),
                ..of(Command::RouteMessages { sensor }, None)
            });
        }
        if let Some(setup) = config.logging {
            let command = Command::LoggingSetup {
                file_size: setup.file_size,
                overlap: setup.overlap,
            };
            steps.push(of(command, None));
        }
        let get = Say::Text(Text::Get(CommandId::LoggingSetup));
        steps.push(Step::new(config, get, Some(s::LOGGING_SETUP)));
        steps.push(of(Command::ReportLogging {}, Some(s::FILE_DETAILS)));
        steps.push(of(Command::ReportAlarms {}, None));
        steps.push(of(Command::Health {}, Some(s::HEALTH)));
        steps.into_iter().map(|step| Self::new(Origin::Setup, [step])).collect()
    }

    /// The settings of the mission for the sensors, in order.
    pub(crate) fn settings(config: &SonarConfig) -> VecDeque<Unset> {
        let of = |sensor: &SensorConfig| {
            let index = SensorIndex(sensor.index);
            let unset = move |(_, setting)| Unset {
                sensor: index,
                setting,
                rejected: 0,
            };
            sensor.settings().map(unset).collect::<Vec<_>>()
        };
        config.sensor.iter().flat_map(of).collect()
    }

    pub(crate) fn setting(config: &SonarConfig, unset: Unset) -> Self {
        let step = Step::set(config, unset.sensor, &unset.setting);
        Self::new(Origin::Setting(unset), [step])
    }

    pub(crate) fn health(config: &SonarConfig) -> Self {
        let step = Step::of(config, Command::Health {}, Some(status_id::HEALTH));
        Self::new(Origin::Routine, [step])
    }

    pub(crate) fn time_sync(config: &SonarConfig) -> Self {
        Self::new(Origin::Routine, [Step::new(config, Say::TimeSync, None)])
    }

    /// An order that the client sends, and what it says; `None` for a shutdown, which is no job among others.
    pub(crate) fn order(config: &SonarConfig, ticket: Ticket, order: &Order) -> Option<Self> {
        Some(match order {
            Order::Logging { on, file } => Self {
                origin: Origin::Order(ticket, Some(*on)),
                ..Self::logging(config, *on, file.as_deref())
            },
            Order::SwitchFile { file } => {
                let steps = [Step::switch(config, file), Self::report(config)];
                Self::new(Origin::Order(ticket, None), steps)
            }
            Order::Set { sensor, setting } => {
                let step = Step::set(config, *sensor, setting);
                Self::new(Origin::Order(ticket, None), [step])
            }
            Order::Shutdown => return None,
        })
    }

    /// Logging first and its file second: nothing that is logged is lost to a file name.
    pub(crate) fn logging(config: &SonarConfig, on: bool, file: Option<&str>) -> Self {
        let mut steps = vec![Step::of(config, Command::Logging { on }, None)];
        steps.extend(file.map(|file| Step::switch(config, file)));
        steps.push(Self::report(config));
        Self::new(Origin::Restore(on), steps)
    }

    /// Logging is stopped first. On a new connection the controller must be told first to acknowledge at all.
    pub(crate) fn shutdown(config: &SonarConfig, new_connection: bool) -> Self {
        let kind = match config.shutdown {
            ShutdownKind::Controller => 0,
            ShutdownKind::System => 1,
        };
        let of = |command: Command, expects: Option<i32>| Step::of(config, command, expects);
        let mut steps = Vec::new();
        if new_connection {
            steps.push(of(Command::Verbose { on: config.verbose }, None).in_shutdown(1));
        }
        steps.push(of(Command::Logging { on: false }, None).in_shutdown(2));
        steps.push(Self::report(config).in_shutdown(1));
        steps.push(of(Command::Shutdown { kind }, Some(status_id::SHUTDOWN)).in_shutdown(2));
        Self::new(Origin::Shutdown, steps)
    }

    fn report(config: &SonarConfig) -> Step {
        Step::of(config, Command::ReportLogging {}, Some(status_id::FILE_DETAILS))
    }
}

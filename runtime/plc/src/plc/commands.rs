//! One match over the commands of Table 16, and what each of them does.

use core::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Alarm, CalendarTime, Command, CommandId, Generic, Order, Status};
use backseat_s7k::record::{Action, CommandStatus};
use backseat_units::Timestamp;

use super::admission;
use super::{Answer, PENDING_MAX, Pending, Plc, client_number};
use crate::config::{FILE_SIZE_MB, OVERLAP_MAX, is_name, is_plain_text};
use crate::error::PlcError;
use crate::event::{ClientId, LogStop, PlcEventKind};
use crate::faults::FaultKind;
use crate::interpretation::{AcknowledgeOrder, LoadedIndex, ResetReading, SensorStatus};
use crate::logging::is_file_name;
use crate::server::Request;
use crate::sonar::SensorKind;
use crate::suite::{Suite, kind_of, stored};

/// How much of a client's text goes into the log, characters.
const TEXT_SHOWN: usize = 200;

/// The least period of the automatic health check, ms.
const HEALTH_PERIOD_MIN_MS: u32 = 100;

/// The greatest port of a sensor.
const PORT_MAX: i32 = 65_535;

/// What a command leads to at once.
enum Outcome {
    /// It is done, or under way.
    Accepted,
    /// It is done, and this answers it.
    Replies(Status),
    /// It is done, and the active alarms answer it.
    ReportsAlarms,
    /// It is invalid: alarm 14.
    Invalid(String),
    /// The sensor does not do it: alarm 11.
    Refused(SensorIndex, String),
    /// It is not known: alarm 14.
    Unknown,
}

impl Plc {
    /// Does a command, acknowledges it if the client is verbose, and answers.
    pub(super) fn command(&mut self, now: Timestamp, client: ClientId, request: &Request) {
        let was_verbose = self.server.clients.is_verbose(client);
        let outcome = self.outcome(now, client, request);
        let status = match &outcome {
            Outcome::Accepted | Outcome::Replies(_) | Outcome::ReportsAlarms => CommandStatus::Accepted,
            Outcome::Invalid(_) | Outcome::Refused(..) => CommandStatus::Rejected,
            Outcome::Unknown => CommandStatus::Unknown,
        };
        self.server.note(
            now,
            PlcEventKind::Command {
                client,
                command: request.command,
                sensor: request.sensor,
                text: request
                    .text
                    .iter()
                    .flat_map(|text| text.chars())
                    .take(TEXT_SHOWN)
                    .collect(),
                status,
            },
        );
        // The command "verbose" is acknowledged when it switches on and when it switches off.
        let verbose = was_verbose || self.server.clients.is_verbose(client);
        let first = self.reading.acknowledge != AcknowledgeOrder::Last;
        if verbose && first {
            self.server
                .acknowledge(now, client, request.command, request.sensor, status);
        }
        self.answer(now, client, request, outcome);
        if verbose && !first {
            self.server
                .acknowledge(now, client, request.command, request.sensor, status);
        }
    }

    /// Does a command that may be done.
    fn outcome(&mut self, now: Timestamp, client: ClientId, request: &Request) -> Outcome {
        let Request {
            command,
            sensor,
            action,
            text,
        } = request;
        let text = match text {
            Ok(text) => text,
            Err(fault) => return Outcome::Invalid(plain(fault)),
        };
        if admission::is_unknown(*command) {
            return Outcome::Unknown;
        }
        let admitted = admission::header(*command, *sensor, *action)
            .and_then(|()| Order::read(*command, *action, text).map_err(|error| error.to_string()))
            .and_then(|order| admission::text(&order, *sensor, *action).map(|()| order));
        match admitted {
            Ok(order) => self.order(now, client, *sensor, *action, order),
            Err(fault) => Outcome::Invalid(plain(&fault)),
        }
    }

    fn answer(&mut self, now: Timestamp, client: ClientId, request: &Request, outcome: Outcome) {
        let invalid = |description: String| Alarm::InvalidCommand {
            client: client_number(client),
            command: request.command.code().cast_signed(),
            description: description.into_boxed_str(),
        };
        match outcome {
            Outcome::Accepted => {}
            Outcome::Replies(status) => self.server.status(now, client, status),
            Outcome::ReportsAlarms => self.server.report_alarms(now, client),
            Outcome::Invalid(description) => self.server.warn_about(now, client, invalid(description)),
            Outcome::Unknown => {
                let description = "there is no such command".to_owned();
                self.server.warn_about(now, client, invalid(description));
            }
            Outcome::Refused(sensor, description) => {
                let alarm = Alarm::SensorCommandFailed {
                    sensor,
                    client: client_number(client),
                    description: description.into_boxed_str(),
                };
                self.server.warn_about(now, client, alarm);
            }
        }
    }

    fn order(
        &mut self,
        now: Timestamp,
        client: ClientId,
        addressee: SensorIndex,
        action: Action,
        order: Order,
    ) -> Outcome {
        if self.shutdown.is_some() {
            return Outcome::Invalid("the controller is shutting down".to_owned());
        }
        let command = match order {
            Order::Do(command) => command,
            // Table 16 has a status for what this command sets, and for no other.
            Order::Get(CommandId::LoggingSetup) => return Outcome::Replies(self.logging_setup()),
            // The sensor is that of the header (2.5). The controller's own status is retrieved, and not more.
            Order::Get(CommandId::Status) if addressee != SensorIndex::PLC || action == Action::Get => {
                return self.status_of(now, client, addressee);
            }
            Order::Get(CommandId::Status) => {
                return Outcome::Invalid("Status parameter sensor: it is missing".to_owned());
            }
            Order::Get(command) => return Outcome::Invalid(admission::no_answer(command).to_owned()),
            Order::Unknown(_) => return Outcome::Unknown,
        };
        match command {
            Command::Generic { text } => self.generic(now, client, addressee, &text),
            Command::Logging { on } => self.logging(now, on),
            Command::Switch { name } => self.switch(now, &name),
            Command::Path { folder } => self.path(now, &folder),
            Command::Version {} => Outcome::Replies(Status::Version { version: self.version }),
            Command::Load {} => self.load(now),
            Command::Save {} => self.save(),
            Command::Subscribe { sensor, record_type } => self.subscribe(client, sensor, record_type),
            Command::Unsubscribe { sensor, record_type } => {
                if self.server.clients.unsubscribe(client, sensor, record_type) {
                    Outcome::Accepted
                } else {
                    Outcome::Invalid(format!("no subscription to record {record_type} of sensor {sensor}"))
                }
            }
            Command::Alarm { alarm, on } => {
                if self.server.clients.switch_alarm(client, alarm, on) {
                    Outcome::Accepted
                } else {
                    Outcome::Invalid(format!("there is no alarm {alarm}"))
                }
            }
            Command::Status { sensor } => self.status_of(now, client, sensor),
            Command::Verbose { on } => {
                self.server.clients.set_verbose(client, on);
                Outcome::Accepted
            }
            Command::Reset { sensor } => self.reset(now, sensor),
            Command::Shutdown { kind } => {
                self.begin_shutdown(now, kind == 1);
                Outcome::Accepted
            }
            Command::Modules {} => Outcome::Replies(Suite::modules()),
            Command::RunList {} => Outcome::Replies(self.suite.run_list()),
            Command::Add {
                module,
                subsystem,
                port,
                name,
            } => self.add(now, (module, subsystem), port, &name),
            Command::Remove { sensor } => {
                if !self.suite.remove(now, sensor, &mut self.server) {
                    return Outcome::Invalid(no_sensor(sensor));
                }
                self.devices_changed(now);
                Outcome::Accepted
            }
            Command::ReportLogging {} => Outcome::Replies(self.file_details()),
            Command::Reserved19 { .. } | Command::Reserved27 { .. } => Outcome::Unknown,
            Command::TimeSync { time } => self.time_sync(now, time),
            Command::Health {} => {
                self.suite.check_health(now, &self.faults, &mut self.server);
                Outcome::Replies(self.suite.health(None, &self.faults))
            }
            Command::AutoStart { on } => {
                self.auto_start = on;
                self.logger.store("6046.cfg", &settings(on));
                Outcome::Accepted
            }
            Command::AutoHealthCheck { on, period_ms } => {
                if on && period_ms < HEALTH_PERIOD_MIN_MS {
                    return Outcome::Invalid(format!("period {period_ms} ms is below {HEALTH_PERIOD_MIN_MS}"));
                }
                let period = Duration::from_millis(u64::from(period_ms));
                self.health = on.then(|| (now + period, period));
                Outcome::Accepted
            }
            Command::RouteMessages { sensor } => {
                if sensor != SensorIndex::PLC && self.suite.sensor(sensor).is_none() {
                    return Outcome::Invalid(no_sensor(sensor));
                }
                self.suite.set_route(sensor);
                Outcome::Accepted
            }
            Command::ReportAlarms {} => Outcome::ReportsAlarms,
            Command::LoggingSetup { file_size, overlap } => {
                if self.logger.set_up(file_size, overlap) {
                    Outcome::Accepted
                } else {
                    let (least, most) = (FILE_SIZE_MB.start(), FILE_SIZE_MB.end());
                    Outcome::Invalid(format!("expected {least} to {most} MB and 0 to {OVERLAP_MAX} records"))
                }
            }
            Command::TimeMessages { on } => {
                self.time_messages = on.then_some(self.time_messages.unwrap_or(now));
                Outcome::Accepted
            }
        }
    }

    /// Command 0: a sensor does a command of Table 19, says that it cannot, or does not answer.
    fn generic(&mut self, now: Timestamp, client: ClientId, index: SensorIndex, text: &str) -> Outcome {
        let Some((kind, running)) = self
            .suite
            .sensor(index)
            .map(|sensor| (sensor.kind, sensor.is_running()))
        else {
            return Outcome::Invalid(no_sensor(index));
        };
        let command = match Generic::read(text) {
            Ok(command) => command,
            Err(error) => return Outcome::Invalid(plain(&error.to_string())),
        };
        let refused = |fault: &str| Outcome::Refused(index, fault.to_owned());
        if !running {
            return refused("the sensor has not started");
        }
        if self.faults.acts(&FaultKind::SensorDies(kind)) {
            let alarm = Alarm::SensorCommandFailed {
                sensor: index,
                client: client_number(client),
                description: Box::from("no answer"),
            };
            return self.later(now + self.silent_after, client, Answer::Alarm(alarm));
        }
        if self.faults.acts(&FaultKind::CommandsRefused(kind)) {
            return refused("refused by the sensor");
        }
        if matches!(command, Generic::PulseFiles {}) {
            let due = self.reply_at(now);
            return self.later(due, client, Answer::Status(self.suite.pulses(kind)));
        }
        // The vehicle's interface has no settings: it takes what it cannot use, as Table 19 allows.
        if kind == SensorKind::Bluefin {
            return Outcome::Accepted;
        }
        let config = self.suite.config(kind).clone();
        let Some(sensor) = self.suite.sensor_mut(index) else {
            return Outcome::Invalid(no_sensor(index));
        };
        let pinged = sensor.settings.pinging;
        match sensor.settings.apply(&command, &config) {
            Ok(()) => {
                sensor.settings_changed(now, pinged);
                if !sensor.settings.pinging {
                    self.server.clear(now, 8, index);
                }
                Outcome::Accepted
            }
            Err(fault) => refused(&plain(&fault)),
        }
    }

    /// Lets a client wait for an answer.
    fn later(&mut self, due: Timestamp, client: ClientId, answer: Answer) -> Outcome {
        let waiting = self.pending.iter().filter(|pending| pending.client == client).count();
        if waiting >= PENDING_MAX {
            return Outcome::Invalid("too many answers are pending".to_owned());
        }
        self.pending.push_back(Pending { due, client, answer });
        Outcome::Accepted
    }

    fn reply_at(&mut self, now: Timestamp) -> Timestamp {
        now + Duration::from_secs_f64(self.reply_s.draw(&mut self.dice))
    }

    fn logging(&mut self, now: Timestamp, on: bool) -> Outcome {
        if !on {
            self.stop_logging(now, LogStop::Command);
        } else if self.logger.has_room() {
            self.start_logging(now);
        } else {
            return Outcome::Invalid("the disk is full".to_owned());
        }
        Outcome::Accepted
    }

    fn switch(&mut self, now: Timestamp, name: &str) -> Outcome {
        let name = (name != "Auto").then_some(name);
        if name.is_some_and(|name| !is_file_name(name)) {
            return Outcome::Invalid("this is not a file name".to_owned());
        }
        let (utc, devices) = (self.server.clock.utc(now), self.suite.devices());
        if self.logger.switch(name, utc, &devices) {
            Outcome::Accepted
        } else {
            Outcome::Invalid("a file of this name exists".to_owned())
        }
    }

    fn path(&mut self, now: Timestamp, folder: &str) -> Outcome {
        // A comma would begin another parameter (2.5).
        if !is_plain_text(folder) || folder.contains(',') {
            return Outcome::Invalid("a folder has 1 to 200 printable characters and no comma".to_owned());
        }
        let (utc, devices) = (self.server.clock.utc(now), self.suite.devices());
        self.logger.set_folder(folder, utc, &devices);
        Outcome::Accepted
    }

    fn load(&mut self, now: Timestamp) -> Outcome {
        let entries = match self.saved.as_deref().map(stored::parse) {
            None => return Outcome::Invalid("there is no file 6046.sav".to_owned()),
            Some(Err(error)) => return Outcome::Invalid(plain(&error.to_string())),
            Some(Ok(entries)) => entries,
        };
        let restart = self.reading.loaded_index != LoadedIndex::Continue;
        self.suite.load(now, &entries, restart, false, &mut self.server);
        self.devices_changed(now);
        Outcome::Accepted
    }

    fn save(&mut self) -> Outcome {
        let text = self.suite.saved();
        self.logger.store("6046.sav", &text);
        self.saved = Some(text);
        Outcome::Accepted
    }

    fn subscribe(&mut self, client: ClientId, sensor: SensorIndex, record_type: u32) -> Outcome {
        if self.suite.sensor(sensor).is_none() {
            return Outcome::Invalid(no_sensor(sensor));
        }
        // A type that the sensor does not have is accepted: nothing comes of it.
        if self.server.clients.subscribe(client, sensor, record_type) {
            Outcome::Accepted
        } else {
            Outcome::Invalid("too many subscriptions".to_owned())
        }
    }

    fn status_of(&mut self, now: Timestamp, client: ClientId, index: SensorIndex) -> Outcome {
        if index == SensorIndex::PLC {
            return Outcome::Replies(self.suite.health(None, &self.faults));
        }
        let Some((kind, running)) = self
            .suite
            .sensor(index)
            .map(|sensor| (sensor.kind, sensor.is_running()))
        else {
            return Outcome::Invalid(no_sensor(index));
        };
        if !running || self.faults.acts(&FaultKind::SensorDies(kind)) {
            let description = Box::from("no status");
            let alarm = Alarm::SensorStatusFailed {
                sensor: index,
                description,
            };
            return self.later(now + self.silent_after, client, Answer::Alarm(alarm));
        }
        let status = match self.reading.sensor_status {
            SensorStatus::Pulses => self.suite.pulses(kind),
            SensorStatus::Health | SensorStatus::Seed => self.suite.health(Some(index), &self.faults),
        };
        let due = self.reply_at(now);
        self.later(due, client, Answer::Status(status))
    }

    fn reset(&mut self, now: Timestamp, index: SensorIndex) -> Outcome {
        if self.reading.reset == ResetReading::Unknown {
            return Outcome::Unknown;
        }
        let Some(kind) = self.suite.sensor(index).map(|sensor| sensor.kind) else {
            return Outcome::Invalid(no_sensor(index));
        };
        let fails = self.faults.acts(&FaultKind::ResetRefused(kind)) || self.faults.acts(&FaultKind::SensorDies(kind));
        if fails {
            let description = Box::from("reset refused");
            self.server.warn(
                now,
                Alarm::ResetFailed {
                    sensor: index,
                    description,
                },
            );
        } else {
            self.suite.reset(now, index, &mut self.server);
        }
        Outcome::Accepted
    }

    fn add(&mut self, now: Timestamp, (module, subsystem): (i32, i32), port: i32, name: &str) -> Outcome {
        let Some(kind) = kind_of(module, subsystem) else {
            return Outcome::Invalid(format!("there is no module {module} with a subsystem {subsystem}"));
        };
        if !is_name(name) {
            return Outcome::Invalid("a sensor's name has 1 to 64 characters and no comma".to_owned());
        }
        // The vehicle's interface needs no port, and has 0 in the run list.
        let least = i32::from(kind != SensorKind::Bluefin);
        if !(least..=PORT_MAX).contains(&port) {
            return Outcome::Invalid(format!("port {port} is outside {least} to {PORT_MAX}"));
        }
        match self.suite.add(now, kind, name, port, false, &mut self.server) {
            Ok(()) => {
                self.devices_changed(now);
                Outcome::Accepted
            }
            Err(fault) => Outcome::Invalid(fault),
        }
    }

    fn time_sync(&mut self, now: Timestamp, time: CalendarTime) -> Outcome {
        let Some(utc) = time.to_utc() else {
            return Outcome::Invalid("there is no such time".to_owned());
        };
        let before = self.server.clock.utc(now).as_unix_nanos();
        let late = Duration::from_secs_f64(self.sync_delay_s.draw(&mut self.dice));
        self.server.clock.set(now, utc, late);
        let after = self.server.clock.utc(now).as_unix_nanos();
        let by = i64::try_from(i128::from(after) - i128::from(before)).unwrap_or(i64::MAX);
        self.server.note(now, PlcEventKind::ClockSet(by));
        self.suite.set_time(now, &self.faults, &mut self.server);
        Outcome::Accepted
    }

    /// Status 5.
    fn logging_setup(&self) -> Status {
        let (file_size, overlap) = self.logger.setup();
        Status::LoggingSetup {
            file_size,
            overlap,
            folder: self.logger.folder().into_boxed_str(),
        }
    }
}

fn no_sensor(index: SensorIndex) -> String {
    format!("there is no sensor {index} in the run list")
}

/// A text that a status or an alarm can carry: without control characters, spaces at the ends and quotation marks.
fn plain(text: &str) -> String {
    let text: String = text
        .chars()
        .filter(|letter| !letter.is_control() && *letter != '"')
        .take(TEXT_SHOWN)
        .collect();
    text.trim().to_owned()
}

/// The content of the file 6046.cfg. The specification does not describe it; this is the mock's own.
fn settings(auto_start: bool) -> String {
    format!("AutoStart = {}\n", i32::from(auto_start))
}

/// Reads the file 6046.cfg: whether to start logging and pinging.
pub(super) fn parse_settings(text: &str) -> Result<bool, PlcError> {
    match text.trim() {
        "AutoStart = 0" => Ok(false),
        "AutoStart = 1" => Ok(true),
        _ => Err(PlcError::Stored {
            file: "6046.cfg",
            line: 1,
            fault: "expected \"AutoStart = 0\" or \"AutoStart = 1\"".to_owned(),
        }),
    }
}

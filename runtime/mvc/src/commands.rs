use core::time::Duration;

use backseat_spi::{
    AckStatus, Acknowledgement, BackseatControl, BehaviorId, CommandName, ModifyBehavior, Text, ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::event::{ClientId, MvcEventKind, Refusal};
use crate::file::AcknowledgeConfig;
use crate::insert::Insert;
use crate::modify::{self, ModifyFault};
use crate::mvc::Mvc;
use crate::server::{Named, Topic, named};

/// How many requests may be pending at once.
const PENDING_MAX: usize = 256;

/// A request whose outcome is still to be told (SPI 4.4).
#[derive(Clone, Debug)]
pub(crate) struct Pending {
    due: Timestamp,
    re: Regarding,
    work: Work,
}

#[derive(Clone, Debug)]
enum Work {
    Insert(Insert),
    Cancel(BehaviorId),
    Plan,
    /// An insert that BPRCA has taken back meanwhile.
    TakenBack(BehaviorId),
}

/// What an acknowledgement is about.
#[derive(Clone, Copy, Debug)]
struct Regarding {
    client: ClientId,
    command: CommandName,
    created: TimeOfDay,
    behavior: Option<BehaviorId>,
    /// The connection that asked is gone: nobody is told, not even a new connection with the same number.
    muted: bool,
}

impl Mvc {
    /// Does what a client asks.
    pub(crate) fn command(&mut self, now: Timestamp, client: ClientId, command: ToVehicle) {
        let name = CommandName::new(command.name()).unwrap_or(CommandName::NAK);
        let created = command.created().unwrap_or(TimeOfDay::MIDNIGHT);
        let re = Regarding {
            client,
            command: name,
            created,
            behavior: None,
            muted: false,
        };
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "what this mock does not fly is refused by its name"
        )]
        match command {
            ToVehicle::LoggingControl(request) => self.logging(now, re, request.message, request.on),
            ToVehicle::PayloadVersion(message) => {
                self.note(now, MvcEventKind::PayloadVersion(client, message.version));
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::PayloadStatus(message) => {
                self.note(
                    now,
                    MvcEventKind::PayloadStatus {
                        client,
                        ok: message.ok,
                        text: message.text,
                    },
                );
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::LogMessage(message) => {
                self.note(now, MvcEventKind::PayloadMessage(client, message.text));
                self.acknowledge(now, re, AckStatus::Succeeded, "");
            }
            ToVehicle::ModifyBehavior(request) => self.modify(now, re, &request),
            ToVehicle::EndModify(_) => {
                let text = if self.executive.end_modify_asked() {
                    ""
                } else {
                    "no behavior was modified"
                };
                self.acknowledge(now, re, AckStatus::Succeeded, text);
            }
            ToVehicle::Trackline(request) => {
                let insert = Insert::trackline(client, &request, self.frame(), self.vehicle.hull());
                self.insert(
                    now,
                    Regarding {
                        behavior: Some(request.identifier),
                        ..re
                    },
                    insert,
                );
            }
            ToVehicle::Trackcircle(request) => {
                let insert = Insert::trackcircle(client, &request, self.frame(), self.vehicle.hull());
                self.insert(
                    now,
                    Regarding {
                        behavior: Some(request.identifier),
                        ..re
                    },
                    insert,
                );
            }
            ToVehicle::CancelBehavior(request) => {
                let id = request.identifier;
                self.begin(
                    now,
                    Regarding {
                        behavior: Some(id),
                        ..re
                    },
                    Work::Cancel(id),
                );
            }
            ToVehicle::CancelAll(_) => {
                let waiting = self.executive.cancel_all(client) + self.take_back(client);
                self.acknowledge(now, re, AckStatus::Succeeded, &format!("{waiting} cancelled"));
            }
            // Always pending first, whatever the setting (SPI 7.19).
            ToVehicle::RequestPlan(_) => self.begin_pending(now, re, Work::Plan),
            ToVehicle::Unknown(unknown) => self.no_command(now, re, unknown.name()),
            _ => self.invalid(now, re, "not supported by this mock yet"),
        }
    }

    /// A command that does not parse: it is named, its time is not echoed.
    pub(crate) fn malformed(&mut self, now: Timestamp, client: ClientId, command: CommandName, text: Text) {
        let re = Regarding {
            client,
            command,
            created: TimeOfDay::MIDNIGHT,
            behavior: None,
            muted: false,
        };
        self.invalid(now, re, text.as_str());
    }

    /// A connection is gone: what it has asked for is decided all the same, and no longer answered.
    pub(crate) fn mute(&mut self, client: ClientId) {
        for pending in self.pending.iter_mut().filter(|pending| pending.re.client == client) {
            pending.re.muted = true;
        }
    }

    /// Tells the outcome of every pending request that is due.
    pub(crate) fn resolve_pending(&mut self, now: Timestamp) {
        while self.pending.front().is_some_and(|pending| pending.due <= now) {
            if let Some(pending) = self.pending.pop_front() {
                self.finish(now, pending.re, pending.work);
                self.settle(now);
            }
        }
    }

    /// BPLOG (SPI 7.1).
    fn logging(&mut self, now: Timestamp, re: Regarding, message: Text, on: bool) {
        let topics = match named(message.as_str()) {
            Named::Topics(topics) => topics,
            Named::AlwaysOn if on => 0,
            Named::AlwaysOn => {
                self.acknowledge(now, re, AckStatus::Failed, "command messages are always on");
                return;
            }
            Named::Unknown => {
                self.invalid(
                    now,
                    re,
                    &format!("message {message}: expected a message of the vehicle or ALL"),
                );
                return;
            }
        };
        self.server.switch(re.client, topics, on);
        self.note(
            now,
            MvcEventKind::Subscribed {
                client: re.client,
                message,
                on,
            },
        );
        self.acknowledge(now, re, AckStatus::Succeeded, "");
        if on && self.interpretation.control_replay {
            if topics & Topic::Mission.bit() != 0 {
                let message = self.mission_message(now, self.executive.status(), "");
                self.send(now, re.client, message);
            }
            if topics & Topic::Control.bit() != 0 {
                let created = self.stamp(now);
                self.send(
                    now,
                    re.client,
                    BackseatControl {
                        created,
                        granted: self.executive.control(),
                    }
                    .into(),
                );
            }
        }
    }

    /// BPRMB (SPI 7.12).
    fn modify(&mut self, now: Timestamp, re: Regarding, request: &ModifyBehavior) {
        let grid_deg = if self.interpretation.heading_is_grid {
            self.grid_convergence_deg
        } else {
            0.0
        };
        let outcome = match modify::read(request, self.vehicle.hull(), grid_deg) {
            Ok(values) => self.executive.modify(now, re.client, values),
            Err(ModifyFault::Unsupported(why)) => Err(why),
            Err(ModifyFault::Invalid(text)) => return self.invalid(now, re, &text),
        };
        match outcome {
            Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
            Err(why) => self.acknowledge(now, re, AckStatus::Failed, why),
        }
    }

    fn insert(&mut self, now: Timestamp, re: Regarding, insert: Result<Insert, String>) {
        match insert {
            Ok(insert) if insert.id.get() == 0 => self.invalid(now, re, "identifier 0: expected 1 or more"),
            Ok(insert) => self.begin(now, re, Work::Insert(insert)),
            Err(text) => self.invalid(now, re, &text),
        }
    }

    /// Starts a request that may be pending.
    fn begin(&mut self, now: Timestamp, re: Regarding, work: Work) {
        match self.acknowledge {
            AcknowledgeConfig::Immediate => self.finish(now, re, work),
            AcknowledgeConfig::Pending => self.begin_pending(now, re, work),
        }
    }

    fn begin_pending(&mut self, now: Timestamp, re: Regarding, work: Work) {
        if self.pending.len() >= PENDING_MAX {
            self.acknowledge(now, re, AckStatus::Failed, "too many requests are pending");
            return;
        }
        self.acknowledge(now, re, AckStatus::Pending, "");
        let due = now + Duration::from_secs_f64(self.pending_s.draw(&mut self.delays));
        // Requests are decided in the order in which they came; each still in time, since no delay exceeds the most.
        let due = self.pending.back().map_or(due, |last| last.due.max(due));
        self.pending.push_back(Pending { due, re, work });
    }

    fn finish(&mut self, now: Timestamp, re: Regarding, work: Work) {
        match work {
            Work::Insert(insert) => match self.executive.insert(now, insert, &self.vehicle) {
                Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
                Err(why) => self.refuse(now, re, insert.id, why),
            },
            Work::TakenBack(id) => self.refuse(now, re, id, Refusal::Cancelled),
            Work::Cancel(id) => match self.executive.cancel(re.client, id) {
                Ok(()) => self.acknowledge(now, re, AckStatus::Succeeded, ""),
                Err(why) => self.acknowledge(now, re, AckStatus::Failed, why),
            },
            Work::Plan if re.muted => {}
            Work::Plan => {
                let count = self.send_plan(now, re.client);
                self.acknowledge(now, re, AckStatus::Succeeded, &format!("{count} elements"));
            }
        }
    }

    fn refuse(&mut self, now: Timestamp, re: Regarding, id: BehaviorId, why: Refusal) {
        self.note(now, MvcEventKind::InsertRefused(re.client, id, why));
        self.acknowledge(now, re, AckStatus::Failed, &why.to_string());
    }

    /// BPRCA also reaches the inserts that are still pending.
    fn take_back(&mut self, client: ClientId) -> usize {
        let all = self.interpretation.cancel_all;
        let mut count = 0;
        for pending in &mut self.pending {
            if let Work::Insert(insert) = &pending.work
                && (all || insert.client == client)
            {
                pending.work = Work::TakenBack(insert.id);
                count += 1;
            }
        }
        count
    }

    /// No command at all.
    fn no_command(&mut self, now: Timestamp, re: Regarding, name: &str) {
        let text = format!("{} is no command", name.chars().take(20).collect::<String>());
        self.invalid(
            now,
            Regarding {
                command: CommandName::NAK,
                created: TimeOfDay::MIDNIGHT,
                ..re
            },
            &text,
        );
    }

    fn invalid(&mut self, now: Timestamp, re: Regarding, text: &str) {
        self.note(
            now,
            MvcEventKind::CommandInvalid(re.client, re.command, Text::cleaned(text)),
        );
        self.acknowledge(now, re, AckStatus::Invalid, text);
    }

    /// BFACK (SPI 6.21), where the client has asked for acknowledgements.
    fn acknowledge(&mut self, now: Timestamp, re: Regarding, status: AckStatus, text: &str) {
        if re.muted || !self.server.has(re.client, Topic::Acknowledgement) {
            return;
        }
        let message = Acknowledgement {
            created: self.stamp(now),
            command: re.command,
            command_created: re.created,
            // 0 is none on the wire.
            behavior: re.behavior.filter(|id| id.get() != 0),
            status,
            text: Text::cleaned(text),
        };
        self.send(now, re.client, message.into());
    }
}

use backseat_spi::{
    BackseatControl, BehaviorBegin, BehaviorEnd, BehaviorId, FromVehicle, LoggingBegin, LoggingEnd, MissionCommand,
    MissionStatus, Text,
};

use super::mission::Mission;
use crate::context::Context;
use crate::event::{Behavior, ClientId, MissionEvent, MvcEventKind, Source, Status, Told};
use crate::server::topics::Topic;

/// The reports of the mission to the clients.
impl Mission {
    /// Reports to the clients and to the log what the executive has done, and to the log which clients were cut off by
    /// that.
    pub(crate) fn settle(&mut self, ctx: &mut Context<'_>) {
        let mut log = self.executive.take_log();
        for kind in log.drain(..) {
            self.tell(ctx, &kind);
            ctx.note(kind);
        }
        self.executive.recycle_log(log);
        ctx.server.settle(ctx.now);
    }

    /// Sends the present values to a client that has just switched on these topics.
    pub(crate) fn replay(&self, ctx: &mut Context<'_>, client: ClientId, topics: u32) {
        if topics & Topic::Mission.bit() != 0 {
            let message = self.status_message(ctx, self.executive.status(), "");
            ctx.server.send(ctx.now, client, &message);
        }
        if topics & Topic::Control.bit() != 0 {
            let message = BackseatControl {
                created: ctx.stamp(),
                granted: self.executive.control(),
            };
            ctx.server.send(ctx.now, client, &message.into());
        }
    }

    /// Sends the scheduled commands of the mission to payloads (SPI 5.1).
    pub(crate) fn tell_scheduled(&mut self, ctx: &mut Context<'_>) {
        if self.executive.status() != Status::Running {
            return;
        }
        while let Some(command) = self.schedule.due(ctx.now) {
            let (created, text) = (ctx.stamp(), Text::cleaned(&command.text));
            let message = MissionCommand { created, text }.into();
            ctx.server.order(ctx.now, command.role.as_deref(), &message);
        }
    }

    fn tell(&self, ctx: &mut Context<'_>, kind: &MvcEventKind) {
        let created = ctx.stamp();
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "the other events are internal to the vehicle, or acknowledged"
        )]
        match kind {
            MvcEventKind::Control(granted) => {
                ctx.publish(
                    Some(Topic::Control),
                    &BackseatControl {
                        created,
                        granted: *granted,
                    }
                    .into(),
                );
            }
            MvcEventKind::Mission { status, details } => {
                let message = self.status_message(ctx, *status, details.as_str());
                ctx.publish(Some(Topic::Mission), &message);
            }
            MvcEventKind::BehaviorBegan(behavior) => {
                let (dive_file, number, identifier, kind) = self.behavior_fields(*behavior);
                let message = BehaviorBegin {
                    created,
                    dive_file,
                    number,
                    identifier,
                    kind,
                };
                ctx.publish(Some(Topic::BehaviorBegin), &message.into());
            }
            MvcEventKind::BehaviorEnded(behavior, _) => {
                let (dive_file, number, identifier, kind) = self.behavior_fields(*behavior);
                let message = BehaviorEnd {
                    created,
                    dive_file,
                    number,
                    identifier,
                    kind,
                };
                ctx.publish(Some(Topic::BehaviorEnd), &message.into());
            }
            MvcEventKind::Executive(MissionEvent::Told { role, what, text }) => {
                let text = text.clone();
                let message = match what {
                    Told::Command => MissionCommand { created, text }.into(),
                    Told::LoggingBegins => LoggingBegin { created, text }.into(),
                    Told::LoggingEnds => LoggingEnd { created, text }.into(),
                };
                ctx.server.order(ctx.now, role.as_deref(), &message);
            }
            _ => {}
        }
    }

    /// The fields of a behavior in BFMBS and BFMBE (SPI 6.9): an insert has an identifier, an element has a file and a
    /// number.
    fn behavior_fields(&self, behavior: Behavior) -> (Text, Option<u32>, Option<BehaviorId>, Text) {
        let kind = Text::cleaned(behavior.kind);
        match behavior.source {
            Source::Plan(number) => (self.dive_file.clone(), Some(number), None, kind),
            Source::Insert(id) => (Text::default(), None, Some(id), kind),
            Source::Empty => (Text::default(), None, None, kind),
        }
    }

    fn status_message(&self, ctx: &Context<'_>, status: Status, details: &str) -> FromVehicle {
        let text = match status {
            Status::Running if self.executive.is_empty_mission() => self.running_empty.clone(),
            Status::Running => self.running.clone(),
            Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Ready
            | Status::WrappingUp
            | Status::Aborting
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => Text::cleaned(status.name()),
        };
        // An empty mission has no dive file, and neither has a vehicle before its first dive.
        let none = matches!(status, Status::Offline | Status::Waiting);
        let dive_file = if none || self.executive.is_empty_mission() {
            Text::default()
        } else {
            self.dive_file.clone()
        };
        let details = Text::cleaned(details);
        MissionStatus {
            created: ctx.stamp(),
            dive_file,
            status: text,
            details,
        }
        .into()
    }
}

use core::time::Duration;

use backseat_spi::{FromVehicle, MissionCommand, Text};
use backseat_units::Timestamp;

use crate::event::{MvcEventKind, Status};
use crate::file::MissionCommandConfig;
use crate::mvc::Mvc;

/// What the mission tells payloads on its way (SPI 5.1).
#[derive(Debug)]
pub(crate) struct MissionCommands {
    /// In the order of their times.
    commands: Vec<MissionCommandConfig>,
    next: usize,
    started: Option<Timestamp>,
}

impl MissionCommands {
    pub(crate) fn new(commands: &[MissionCommandConfig]) -> Self {
        let mut commands = commands.to_vec();
        commands.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        Self {
            commands,
            next: 0,
            started: None,
        }
    }

    fn due(&mut self, now: Timestamp) -> Option<&MissionCommandConfig> {
        let started = *self.started.get_or_insert(now);
        let command = self.commands.get(self.next)?;
        (started + Duration::from_secs_f64(command.at_s) <= now).then(|| {
            self.next += 1;
            command
        })
    }
}

impl Mvc {
    /// One step of the vehicle.
    pub(crate) fn tick_mission_commands(&mut self, now: Timestamp) {
        if self.executive.status() != Status::Running {
            return;
        }
        while let Some(command) = self.mission_commands.due(now) {
            let (role, text) = (command.role.clone(), Text::cleaned(&command.text));
            let created = self.stamp(now);
            self.command_client(now, role.as_deref(), &MissionCommand { created, text }.into());
        }
    }

    /// Sends a command message (SPI 5) to the client that holds a role, or to all without one.
    pub(crate) fn command_client(&mut self, now: Timestamp, role: Option<&str>, message: &FromVehicle) {
        let Some(role) = role else {
            self.publish(now, None, message);
            return;
        };
        match self.server.holder(role) {
            Some(client) => self.send(now, client, message.clone()),
            None => self.note(
                now,
                MvcEventKind::NobodyHolds {
                    role: role.into(),
                    message: message.name().into(),
                },
            ),
        }
        self.settle(now);
    }
}

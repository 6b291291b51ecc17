use core::time::Duration;

use backseat_units::Timestamp;

use crate::file::MissionCommandConfig;

/// The commands that the mission sends to payloads, with their times (SPI 5.1).
#[derive(Debug)]
pub(super) struct Schedule {
    /// Sorted by time.
    commands: Vec<MissionCommandConfig>,
    next: usize,
    started: Option<Timestamp>,
}

impl Schedule {
    pub(super) fn new(commands: &[MissionCommandConfig]) -> Self {
        let mut commands = commands.to_vec();
        commands.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        Self {
            commands,
            next: 0,
            started: None,
        }
    }

    /// For another mission.
    pub(super) const fn begin_again(&mut self) {
        (self.next, self.started) = (0, None);
    }

    pub(super) fn due(&mut self, now: Timestamp) -> Option<&MissionCommandConfig> {
        let started = *self.started.get_or_insert(now);
        let command = self.commands.get(self.next)?;
        (started + Duration::from_secs_f64(command.at_s) <= now).then(|| {
            self.next += 1;
            command
        })
    }
}

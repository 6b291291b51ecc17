//! What the vehicle tells goes to the controller, and what the sonar does goes to the vehicle.

use backseat_s7k::Time7k;
use backseat_s7k::record::BluefinRecord;
use backseat_units::Timestamp;

use super::{Link, Sonar};
use crate::logging::Logging;
use crate::status::{Condition, cut};
use crate::vehicle::{VehicleNavigation, VehicleSoundSpeed, environment_frame, navigation_frame};

impl Sonar {
    pub(super) fn navigation(&mut self, navigation: &VehicleNavigation) {
        self.vehicle.remember(navigation);
        let angles = [navigation.roll_deg, navigation.pitch_deg];
        let impossible = angles.iter().filter(|angle| !angle.is_finite()).count();
        self.counts.impossible_values += impossible as u64;
        if !self.passes_vehicle_data() {
            return;
        }
        let frame = navigation_frame(navigation, self.config.navigation_times);
        let time = Time7k::from_utc(navigation.solution);
        self.vehicle.navigation.push(self.now, time, frame);
        if self.vehicle.navigation.is_full() {
            self.send_navigation();
        }
    }

    pub(super) fn sound_speed(&mut self, sound_speed: &VehicleSoundSpeed) {
        let mps = sound_speed.sound_speed_mps;
        if !(mps > 0.0 && mps <= 10_000.0) {
            self.counts.impossible_values += 1;
            return;
        }
        self.vehicle.hear(mps);
        if !self.passes_vehicle_data() {
            return;
        }
        let time = Time7k::from_utc(sound_speed.time);
        self.vehicle.environment.push(self.now, time, environment_frame(mps));
        if self.vehicle.environment.is_full() {
            self.send_environment();
        }
    }

    const fn passes_vehicle_data(&self) -> bool {
        self.config.vehicle_data && self.is_ready() && self.ending.is_none()
    }

    pub(super) fn send_navigation(&mut self) {
        self.counts.old_frames += self.vehicle.navigation.drop_old(self.now) as u64;
        if let Some((frames, first)) = self.vehicle.navigation.frames() {
            let checksum = self.config.bluefin_checksum;
            let record = self.writer.vehicle(frames[0].0, |out| {
                let composed = BluefinRecord::compose_navigation(millis(first), frames, checksum, out);
                debug_assert!(composed.is_ok(), "at most 25 frames are gathered");
            });
            self.pass(record);
        }
        self.vehicle.navigation.clear();
    }

    pub(super) fn send_environment(&mut self) {
        self.counts.old_frames += self.vehicle.environment.drop_old(self.now) as u64;
        if let Some((frames, first)) = self.vehicle.environment.frames() {
            let checksum = self.config.bluefin_checksum;
            let record = self.writer.vehicle(frames[0].0, |out| {
                let composed = BluefinRecord::compose_environment(millis(first), frames, checksum, out);
                debug_assert!(composed.is_ok(), "at most 25 frames are gathered");
            });
            self.pass(record);
        }
        self.vehicle.environment.clear();
    }

    fn pass(&mut self, record: Result<Vec<u8>, Box<str>>) {
        match record {
            Ok(bytes) => self.outbox.data(bytes, &mut self.counts),
            Err(_) => self.counts.dropped_sends += 1,
        }
    }

    /// What an operator may count as a fault of the payload, in order.
    pub fn conditions(&self) -> impl Iterator<Item = Condition> {
        let unhealthy = self.health.iter().any(|entry| !entry.healthy);
        [
            (!self.is_ready(), Condition::NotReady),
            (self.alarms.active().len() > 0, Condition::Alarm),
            (unhealthy, Condition::Unhealthy),
            (self.logging.is_missing(), Condition::NotLogging),
        ]
        .into_iter()
        .filter_map(|(holds, condition)| holds.then_some(condition))
    }

    /// The sonar's state for the payload's status (BPSTS, SPI 7.2): at most [`crate::STATUS_CHARS`] characters of
    /// printable ASCII without comma, asterisk and dollar sign. It has no words of the controller's.
    #[must_use]
    pub fn status_text(&self) -> String {
        let mut text = String::from(match self.link {
            Link::Waiting | Link::Closing { .. } => "sonar not connected",
            Link::Connecting => "sonar connecting",
            Link::Up { ready: false } => "sonar starting",
            Link::Up { ready: true } => "sonar ready",
            Link::Ended => "sonar shut down",
        });
        text.push_str(logging_words(&self.logging));
        let alarms = self.alarms.active();
        let more = alarms.len().saturating_sub(1);
        if let Some(first) = self.alarms.active().next() {
            text.push_str("; alarm: ");
            text.push_str(&first.title());
            if more > 0 {
                text.push_str(&format!(" and {more} more"));
            }
        }
        for entry in self.health.iter().filter(|entry| !entry.healthy) {
            text.push_str(&format!("; sensor {} unhealthy", entry.sensor));
            if text.len() > crate::STATUS_CHARS {
                break;
            }
        }
        cut(text)
    }
}

fn logging_words(logging: &Logging) -> &'static str {
    match logging.is_on() {
        _ if logging.is_missing() => "; logging missing",
        Some(true) => "; logging on",
        Some(false) => "; logging off",
        None => "",
    }
}

/// A counter of milliseconds, which begins anew after 49 days.
#[expect(clippy::cast_possible_truncation, reason = "the counter has 32 bits")]
const fn millis(time: Timestamp) -> u32 {
    (time.as_nanos() / 1_000_000) as u32
}

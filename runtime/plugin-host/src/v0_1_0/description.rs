use std::time::Duration;

use backseat_core::plugin as core;

use super::wit;

/// The longest name or version, bytes.
const NAME_BYTES: usize = 64;
/// The shortest step period.
const PERIOD_MIN: Duration = Duration::from_millis(20);
/// The longest step period.
const PERIOD_MAX: Duration = Duration::from_secs(60);

/// A description within its bounds, or what is out of them and what was expected.
pub(crate) fn description(described: wit::Description) -> Result<core::Description, (String, &'static str)> {
    for (what, text) in [("name", &described.name), ("version", &described.version)] {
        if text.is_empty() || text.len() > NAME_BYTES || text.chars().any(char::is_control) {
            return Err((
                format!("a {what} of {} bytes", text.len()),
                "1 to 64 bytes of printable text",
            ));
        }
    }
    let step_period = Duration::from_nanos(described.step_period_ns);
    if !(PERIOD_MIN..=PERIOD_MAX).contains(&step_period) {
        return Err((format!("a step period of {step_period:?}"), "20 ms to 60 s"));
    }
    let mut topics: Vec<core::Topic> = described.topics.into_iter().map(core::Topic::from).collect();
    topics.sort();
    topics.dedup();
    Ok(core::Description {
        name: described.name,
        version: described.version,
        step_period,
        topics,
    })
}

impl From<wit::Topic> for core::Topic {
    fn from(topic: wit::Topic) -> Self {
        match topic {
            wit::Topic::Ctd => Self::Ctd,
            wit::Topic::MissionCommand => Self::MissionCommand,
            wit::Topic::Behavior => Self::Behavior,
            wit::Topic::Logging => Self::Logging,
            wit::Topic::Topside => Self::Topside,
            wit::Topic::Acoustic => Self::Acoustic,
            wit::Topic::Plan => Self::Plan,
            wit::Topic::Telemetry => Self::Telemetry,
            wit::Topic::SoundVelocity => Self::SoundVelocity,
            wit::Topic::Compass => Self::Compass,
            wit::Topic::Pressure => Self::Pressure,
            wit::Topic::VehicleSpeed => Self::VehicleSpeed,
            wit::Topic::Battery => Self::Battery,
            wit::Topic::Surfaces => Self::Surfaces,
            wit::Topic::Dvl => Self::Dvl,
            wit::Topic::DvlBeams => Self::DvlBeams,
            wit::Topic::Imu => Self::Imu,
            wit::Topic::Servo => Self::Servo,
            wit::Topic::RelativeNavigation => Self::RelativeNavigation,
        }
    }
}

use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin as core;

use super::{wit, wit_mission};

/// The longest name or version, bytes.
const NAME_BYTES: usize = 64;
/// The shortest step period.
const PERIOD_MIN: Duration = Duration::from_millis(20);
/// The longest step period.
const PERIOD_MAX: Duration = Duration::from_secs(60);

/// What a plugin says about itself.
pub(crate) struct Described {
    /// For core.
    pub(crate) description: core::Description,
    /// The grants that it needs, each once.
    pub(crate) needs: Vec<Grant>,
}

/// Converts a description that is within its bounds.
///
/// # Errors
///
/// What is out of bounds, and what was expected.
pub(crate) fn description(described: wit_mission::Description) -> Result<Described, (String, &'static str)> {
    for (what, text) in [("name", &described.name), ("version", &described.version)] {
        let found = if text.is_empty() || text.len() > NAME_BYTES {
            format!("a {what} of {} bytes", text.len())
        } else if text.chars().any(char::is_control) {
            format!("the {what} {text:?}")
        } else {
            continue;
        };
        return Err((found, "1 to 64 bytes of printable text"));
    }
    let step_period = Duration::from_nanos(described.step_period_ns);
    if !(PERIOD_MIN..=PERIOD_MAX).contains(&step_period) {
        return Err((format!("a step period of {step_period:?}"), "20 ms to 60 s"));
    }
    let mut topics: Vec<core::Topic> = described.topics.into_iter().map(core::Topic::from).collect();
    topics.sort();
    topics.dedup();
    let mut needs: Vec<Grant> = described.grants.into_iter().map(Grant::from).collect();
    needs.sort();
    needs.dedup();
    Ok(Described {
        description: core::Description {
            name: described.name,
            version: described.version,
            step_period,
            topics,
        },
        needs,
    })
}

impl From<wit_mission::Grant> for Grant {
    fn from(grant: wit_mission::Grant) -> Self {
        match grant {
            wit_mission::Grant::Modify => Self::Modify,
            wit_mission::Grant::Insert => Self::Insert,
            wit_mission::Grant::Interrupt => Self::Interrupt,
            wit_mission::Grant::Message => Self::Message,
            wit_mission::Grant::Surface => Self::Surface,
            wit_mission::Grant::Topside => Self::Topside,
            wit_mission::Grant::Dvl => Self::Dvl,
            wit_mission::Grant::Silent => Self::Silent,
            wit_mission::Grant::Trim => Self::Trim,
            wit_mission::Grant::Buoyancy => Self::Buoyancy,
            wit_mission::Grant::Acoustic => Self::Acoustic,
            wit_mission::Grant::Station => Self::Station,
            wit_mission::Grant::Devices => Self::Devices,
            wit_mission::Grant::Sonar => Self::Sonar,
        }
    }
}

impl From<Grant> for wit_mission::Grant {
    fn from(grant: Grant) -> Self {
        match grant {
            Grant::Modify => Self::Modify,
            Grant::Insert => Self::Insert,
            Grant::Interrupt => Self::Interrupt,
            Grant::Message => Self::Message,
            Grant::Surface => Self::Surface,
            Grant::Topside => Self::Topside,
            Grant::Dvl => Self::Dvl,
            Grant::Silent => Self::Silent,
            Grant::Trim => Self::Trim,
            Grant::Buoyancy => Self::Buoyancy,
            Grant::Acoustic => Self::Acoustic,
            Grant::Station => Self::Station,
            Grant::Devices => Self::Devices,
            Grant::Sonar => Self::Sonar,
        }
    }
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
            wit::Topic::Trim => Self::Trim,
            wit::Topic::Buoyancy => Self::Buoyancy,
            wit::Topic::RelativeNavigation => Self::RelativeNavigation,
            wit::Topic::Sidescan => Self::Sidescan,
            wit::Topic::SubBottom => Self::SubBottom,
            wit::Topic::Sonar => Self::Sonar,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the order of the interface.
    const TOPICS: [wit::Topic; 24] = [
        wit::Topic::Ctd,
        wit::Topic::MissionCommand,
        wit::Topic::Behavior,
        wit::Topic::Logging,
        wit::Topic::Topside,
        wit::Topic::Acoustic,
        wit::Topic::Plan,
        wit::Topic::Telemetry,
        wit::Topic::SoundVelocity,
        wit::Topic::Compass,
        wit::Topic::Pressure,
        wit::Topic::VehicleSpeed,
        wit::Topic::Battery,
        wit::Topic::Surfaces,
        wit::Topic::Dvl,
        wit::Topic::DvlBeams,
        wit::Topic::Imu,
        wit::Topic::Servo,
        wit::Topic::Trim,
        wit::Topic::Buoyancy,
        wit::Topic::RelativeNavigation,
        wit::Topic::Sidescan,
        wit::Topic::SubBottom,
        wit::Topic::Sonar,
    ];

    /// In the order of the interface.
    const GRANTS: [wit_mission::Grant; 14] = [
        wit_mission::Grant::Modify,
        wit_mission::Grant::Insert,
        wit_mission::Grant::Interrupt,
        wit_mission::Grant::Message,
        wit_mission::Grant::Surface,
        wit_mission::Grant::Topside,
        wit_mission::Grant::Dvl,
        wit_mission::Grant::Silent,
        wit_mission::Grant::Trim,
        wit_mission::Grant::Buoyancy,
        wit_mission::Grant::Acoustic,
        wit_mission::Grant::Station,
        wit_mission::Grant::Devices,
        wit_mission::Grant::Sonar,
    ];

    #[test]
    fn a_grant_is_the_one_of_its_name() {
        for wanted in GRANTS {
            let grant = Grant::from(wanted);
            assert_eq!(format!("{wanted:?}").to_lowercase(), format!("grant::{}", grant.name()));
            assert_eq!(wit_mission::Grant::from(grant), wanted);
        }
    }

    #[test]
    fn a_topic_is_the_one_of_its_name() {
        for topic in TOPICS {
            let name = format!("{topic:?}").replace("Topic::", "");
            assert_eq!(format!("{:?}", core::Topic::from(topic)), name);
        }
    }

    #[test]
    fn a_name_that_cannot_be_printed_is_told_with_what_it_has() {
        let refused = |name: &str| {
            let described = wit_mission::Description {
                name: name.to_owned(),
                version: "1".to_owned(),
                step_period_ns: 20_000_000,
                topics: Vec::new(),
                grants: Vec::new(),
            };
            description(described).err().map(|(found, _)| found)
        };
        assert_eq!(refused("a\u{1b}b").as_deref(), Some("the name \"a\\u{1b}b\""));
        assert_eq!(refused(&"a".repeat(65)).as_deref(), Some("a name of 65 bytes"));
        assert_eq!(refused("").as_deref(), Some("a name of 0 bytes"));
        assert_eq!(refused("a b"), None);
    }

    #[test]
    fn topics_are_in_order_and_none_is_there_twice() {
        let described = wit_mission::Description {
            name: "a".to_owned(),
            version: "1".to_owned(),
            step_period_ns: 20_000_000,
            topics: TOPICS.into_iter().rev().chain(TOPICS).collect(),
            grants: GRANTS.into_iter().rev().chain(GRANTS).collect(),
        };
        let described = description(described).unwrap();
        let topics = described.description.topics;
        assert_eq!(topics.len(), TOPICS.len());
        assert!(topics.is_sorted());
        assert_eq!(described.needs.len(), GRANTS.len());
        assert!(described.needs.is_sorted());
    }
}

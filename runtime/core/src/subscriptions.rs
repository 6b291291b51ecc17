//! Which status messages are asked for, and in which order (SPI 7.1).

use crate::conductor::Slot;
use crate::limits::Grant;
use crate::plugin::Topic;

/// BFACK: what is sent before this subscription is not acknowledged.
pub(crate) const ACKNOWLEDGEMENTS: &str = "ACK";

/// BFCTL before all: real vehicles send it only on the transition, and who subscribes late misses the hand-over. The
/// acknowledgements next, and BFCTL once more, so that it is acknowledged too.
const ALWAYS: [&str; 8] = ["CTL", ACKNOWLEDGEMENTS, "MIS", "CTL", "NVG", "NVR", "MBS", "MBE"];

/// What a topic needs. Command messages come unasked (SPI 4.3).
const fn of_topic(topic: Topic) -> &'static [&'static str] {
    match topic {
        Topic::MissionCommand | Topic::Behavior | Topic::Logging | Topic::Topside | Topic::Plan => &[],
        Topic::Ctd => &["CTD"],
        Topic::Acoustic => &["CMA", "CPR"],
        Topic::Telemetry => &["TEL"],
        Topic::SoundVelocity => &["SVS"],
        Topic::Compass => &["RCM"],
        Topic::Pressure => &["RDP"],
        Topic::VehicleSpeed => &["RVL"],
        Topic::Battery => &["RBS"],
        Topic::Surfaces => &["ERC"],
        Topic::Dvl => &["DVL"],
        Topic::DvlBeams => &["DV2"],
        Topic::Imu => &["IMU"],
        Topic::Servo => &["PIT"],
        Topic::Trim => &["TRM"],
        Topic::Buoyancy => &["BOY"],
        Topic::RelativeNavigation => &["RNV", "CNV"],
    }
}

/// What a grant needs to be watched over.
const fn of_grant(grant: Grant) -> &'static [&'static str] {
    match grant {
        Grant::Modify
        | Grant::Insert
        | Grant::Interrupt
        | Grant::Message
        | Grant::Surface
        | Grant::Topside
        | Grant::Dvl
        | Grant::Silent
        | Grant::Devices => &[],
        Grant::Trim => &["TRM"],
        Grant::Buoyancy => &["BOY"],
        Grant::Acoustic => &["CMA", "CPS", "CPR"],
        Grant::Hull => &["RNV", "CNV"],
    }
}

/// The subscriptions of a run, in the order that they are sent.
pub(crate) fn of(plugins: &[Slot]) -> Vec<&'static str> {
    let mut list = ALWAYS.to_vec();
    let wanted = plugins.iter().flat_map(|slot| {
        let topics = slot.topics().iter().flat_map(|topic| of_topic(*topic));
        topics.chain(slot.grants().iter().flat_map(|grant| of_grant(*grant)))
    });
    for name in wanted {
        if !list.contains(name) {
            list.push(name);
        }
    }
    list
}

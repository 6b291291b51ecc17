//! The last check of a message before it is encoded (safety requirements 001, 012, 014, 016 and 017): what each message
//! needs.
//!
//! The code that asks for a message has already checked all that the message needs. The gate checks it once more, in
//! case some of that code forgets it.

use backseat_spi::{HullSpeedLimit, ToVehicle};
use backseat_units::Timestamp;

use crate::mutations::{Check, is_on};
use crate::owner::Owner;

/// What a message needs before it may leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needs {
    /// Only the link: the message is on the list of what may be sent without control (014).
    Link,
    /// The insert that the message cancels must be one that this runtime has sent, in this run or in a previous one
    /// (014).
    OwnInsert,
    /// An armed runtime with control (001). The message must not be an external source's.
    Control,
    /// An armed runtime with control. The message must be the operator's.
    OperatorWithControl,
    /// An armed runtime with control. The message must be an external source's or the operator's, because it changes
    /// where the vehicle believes itself to be.
    ExternalWithControl,
    /// An armed runtime. The message must be the operator's: abort and kill (012).
    OperatorArmed,
    /// An armed runtime, no hold of the operator, a run that is not ending, and a vehicle that has reported that no
    /// mission runs. The message must be the operator's.
    NoMission,
    /// An armed runtime. The message must be an external source's: it relays what the topside has said (014).
    External,
    /// An armed runtime with control, in a window of the acoustic modem (016).
    Window,
    /// An armed runtime with control, and the vehicle's permission to trigger the DVL (017).
    Handshake,
    /// The message never leaves.
    Never,
}

const fn needs(message: &ToVehicle) -> Needs {
    use ToVehicle as M;
    match message {
        M::PayloadVersion(_)
        | M::LoggingControl(_)
        | M::PayloadStatus(_)
        | M::LogMessage(_)
        | M::EndModify(_)
        | M::RequestPlan(_) => Needs::Link,
        M::CancelBehavior(_) => Needs::OwnInsert,
        M::DvlTriggerRequest(request) => {
            // A message that ends the triggering is a reply in the handshake. One that asks to begin needs control, and
            // one that says that the payload triggers needs the vehicle's permission.
            if request.triggering {
                Needs::Handshake
            } else if request.external {
                Needs::Control
            } else {
                Needs::Link
            }
        }
        M::ModifyBehavior(_)
        | M::Trackline(_)
        | M::Trackcircle(_)
        | M::GpsHit(_)
        | M::TopsideText(_)
        | M::SilentMode(_)
        | M::TrimAdjustment(_)
        | M::BuoyancyAdjustment(_)
        | M::Suspend(_)
        | M::Continue(_)
        | M::HullSpeedLimit(_)
        | M::HullPosition(_)
        | M::BottomPosition(_)
        | M::SonarAngle(_)
        | M::Camera(_)
        | M::Light(_) => Needs::Control,
        M::CancelAll(_) | M::CancelCurrent(_) | M::CancelElement(_) => Needs::OperatorWithControl,
        M::PositionFix(_) | M::PayloadCtd(_) | M::RelativeReset(_) | M::BearingOffset(_) => Needs::ExternalWithControl,
        M::Abort(_) | M::Kill(_) => Needs::OperatorArmed,
        M::StartEmptyMission(_) => Needs::NoMission,
        M::TopsideRelay(_) => Needs::External,
        M::Packet(_) => Needs::Window,
        // This leaves only at the end of station keeping, see `Gate::ends_station`.
        M::Resume(_) => Needs::Never,
        // The runtime has no reason to send an unknown message.
        M::Unknown(_) => Needs::Never,
    }
}

/// Whether a message takes the vehicle elsewhere, or stops it from going on.
const fn steers(message: &ToVehicle) -> bool {
    use ToVehicle as M;
    matches!(
        message,
        M::ModifyBehavior(_)
            | M::Trackline(_)
            | M::Trackcircle(_)
            | M::GpsHit(_)
            | M::Suspend(_)
            | M::Continue(_)
            | M::HullSpeedLimit(_)
            | M::HullPosition(_)
            | M::BottomPosition(_)
    )
}

/// What the vehicle has permitted, and whether the end of station keeping is on its way.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Permits {
    /// An acoustic packet may leave before this time, so that it arrives before the end of the window (016).
    pub(crate) window_until: Option<Timestamp>,
    /// The payload may say that it triggers the DVL (017).
    pub(crate) may_trigger: bool,
    /// The messages that end station keeping are on their way through the gate.
    pub(crate) station_ends: bool,
}

impl Permits {
    /// Whether a packet may leave now.
    pub(crate) fn window_is_open(&self, now: Timestamp) -> bool {
        self.window_until.is_some_and(|until| now < until)
    }
}

/// What is known when a message is about to leave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gate<'a> {
    pub(crate) now: Timestamp,
    /// The link is up.
    pub(crate) is_up: bool,
    /// The operator allows this process to send messages that steer.
    pub(crate) is_armed: bool,
    /// Control is ours.
    pub(crate) has_control: bool,
    /// No mission runs, the operator does not hold, and the run is not ending.
    pub(crate) may_start_mission: bool,
    /// The message cancels an insert that this runtime has sent, in this run or in a previous one.
    pub(crate) is_own_insert: bool,
    pub(crate) permits: &'a Permits,
    /// The vehicle's own speed limit, m/s.
    pub(crate) speed_default_mps: Option<f64>,
}

impl Gate<'_> {
    /// Whether a message of this owner may leave now. `None` is the runtime itself.
    pub(crate) fn lets_through(&self, owner: Option<Owner>, message: &ToVehicle) -> bool {
        self.is_up && (self.ends_station(message) || self.may_leave(owner, message))
    }

    fn may_leave(&self, owner: Option<Owner>, message: &ToVehicle) -> bool {
        let operator = owner == Some(Owner::Operator);
        let external = matches!(owner, Some(Owner::External(_)));
        let armed = self.is_armed;
        let control = armed && self.has_control;
        match needs(message) {
            Needs::Link => true,
            Needs::OwnInsert => self.is_own_insert,
            Needs::Control => !external && (control || armed && !is_on(Check::ListWithoutControl) && !steers(message)),
            Needs::OperatorWithControl => operator && control,
            Needs::ExternalWithControl => (operator || external) && control,
            Needs::OperatorArmed => operator && armed,
            Needs::NoMission => operator && armed && self.may_start_mission,
            Needs::External => external && armed,
            Needs::Window => control && (self.permits.window_is_open(self.now) || !is_on(Check::ModemWindow)),
            Needs::Handshake => control && (self.permits.may_trigger || !is_on(Check::DvlLeave)),
            Needs::Never => false,
        }
    }

    /// Whether a message belongs to the end of station keeping that is on its way. Such a message needs no control
    /// (safety requirement 014).
    fn ends_station(&self, message: &ToVehicle) -> bool {
        let restores = |limit: &HullSpeedLimit| self.speed_default_mps == Some(limit.speed_mps);
        self.permits.station_ends
            && (matches!(message, ToVehicle::Resume(_))
                || matches!(message, ToVehicle::HullSpeedLimit(limit) if restores(limit)))
    }
}

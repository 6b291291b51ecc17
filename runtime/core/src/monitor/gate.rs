//! The last place before the wire (safety requirements 001, 012, 014, 016 and 017): what each message needs.
//!
//! Who asks for a message has checked all that it needs; this is checked once more here, for the day when one forgets.

use backseat_spi::{HullSpeedLimit, ToVehicle};
use backseat_units::Timestamp;

use crate::mutations::{Check, is_on};
use crate::owner::Owner;

/// What a message needs before it may leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needs {
    /// Nothing but the link: it is on the list of what may be sent without control (014).
    Link,
    /// That the insert which it takes back is one that this runtime has sent (014).
    OwnInsert,
    /// An armed runtime with control (001), and that it is no external source's.
    Control,
    /// An armed runtime with control, and that it is the operator's.
    OperatorWithControl,
    /// The same, and that it is an external source's or the operator's: it moves the vehicle's idea of where it is.
    ExternalWithControl,
    /// That it is the operator's, and an armed runtime: abort and kill (012).
    OperatorArmed,
    /// The same, no hold of the operator's, and that the vehicle has said that no mission runs.
    NoMission,
    /// That it is an external source's: what it relays is the topside's word (014).
    External,
    /// An armed runtime with control, in a window of the acoustic modem (016).
    Window,
    /// An armed runtime with control, where the vehicle has allowed the DVL's triggering (017).
    Handshake,
    /// It never leaves.
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
            // What ends the triggering is a reply of the handshake; what begins it is not.
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
        // Only as the end of station keeping, see `Gate::ends_station`.
        M::Resume(_) => Needs::Never,
        // What is unknown is not ours.
        M::Unknown(_) => Needs::Never,
    }
}

/// Whether a message takes the vehicle elsewhere, or keeps it from going on.
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

/// What the vehicle has permitted, and which of our own ends is on its way.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Permits {
    /// An acoustic packet may leave before this, to arrive before the window's end (016).
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
    /// The operator lets this process send what steers.
    pub(crate) is_armed: bool,
    /// Control is ours.
    pub(crate) has_control: bool,
    /// No mission runs, and the operator neither holds nor ends the run.
    pub(crate) may_start_mission: bool,
    /// An insert that is taken back is one that this runtime has sent.
    pub(crate) is_own_insert: bool,
    pub(crate) permits: &'a Permits,
    /// The vehicle's own speed limit, m/s.
    pub(crate) speed_default_mps: Option<f64>,
}

impl Gate<'_> {
    /// Whether a message of this owner may leave now; of the runtime itself where there is none.
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

    /// Whether a message ends the station keeping that is being ended: that needs no control (safety requirement 014).
    fn ends_station(&self, message: &ToVehicle) -> bool {
        let restores = |limit: &HullSpeedLimit| self.speed_default_mps == Some(limit.speed_mps);
        self.permits.station_ends
            && (matches!(message, ToVehicle::Resume(_))
                || matches!(message, ToVehicle::HullSpeedLimit(limit) if restores(limit)))
    }
}

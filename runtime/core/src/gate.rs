//! The last place before the wire (safety requirements 001, 012, 014 and 016): what each message needs.

use backseat_spi::ToVehicle;

use crate::commands::Command;
use crate::io::{Note, Output};
use crate::machine::Core;
use crate::owner::Owner;

/// What a message needs before it may leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Needs {
    /// Nothing but the link: it is on the list of what may be sent without control (014).
    Link,
    /// An armed runtime with control (001).
    Control,
    /// The same, and that it is the operator's.
    OperatorWithControl,
    /// The same, and that it is a configured driver's or the operator's: it moves the vehicle's idea of where it is.
    DriverWithControl,
    /// That it is the operator's, and an armed runtime: abort and kill (012), and what starts a mission.
    OperatorArmed,
    /// That it is a configured driver's: what it relays is the topside's word (014).
    Driver,
    /// An armed runtime with control, in a window of the acoustic modem (016).
    Window,
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
        | M::CancelBehavior(_)
        | M::RequestPlan(_)
        | M::Resume(_) => Needs::Link,
        M::DvlTriggerRequest(request) => {
            // What ends the triggering is a reply of the handshake; what begins it is not.
            if request.external || request.triggering {
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
        M::PositionFix(_) | M::PayloadCtd(_) | M::RelativeReset(_) | M::BearingOffset(_) => Needs::DriverWithControl,
        M::Abort(_) | M::Kill(_) | M::StartEmptyMission(_) => Needs::OperatorArmed,
        M::TopsideRelay(_) => Needs::Driver,
        M::Packet(_) => Needs::Window,
        // What is unknown is not ours.
        M::Unknown(_) => Needs::Never,
    }
}

impl Core {
    /// Sends a message of the runtime's own.
    pub(crate) fn transmit(&mut self, message: &ToVehicle, command: Option<Command>) -> bool {
        self.pass(None, message, command)
    }

    /// Sends a message for the owner of a request.
    pub(crate) fn transmit_for(&mut self, owner: Owner, message: &ToVehicle, command: Option<Command>) -> bool {
        self.pass(Some(owner), message, command)
    }

    fn pass(&mut self, owner: Option<Owner>, message: &ToVehicle, command: Option<Command>) -> bool {
        if !self.session.is_up() || !self.may_leave(owner, needs(message)) {
            return false;
        }
        let mut bytes = Vec::with_capacity(96);
        if let Err(error) = message.encode(&mut bytes) {
            self.note(Note::Text {
                text: format!("{} was not sent: {error}", message.name()),
            });
            return false;
        }
        if let Some(command) = command {
            // A command that is given up for want of room was sent long ago and its answer is overdue anyway.
            let _given_up = self.commands.push(command);
        }
        self.outputs.push_back(Output::Send(bytes));
        true
    }

    fn may_leave(&self, owner: Option<Owner>, needs: Needs) -> bool {
        let operator = owner == Some(Owner::Operator);
        let driver = matches!(owner, Some(Owner::Driver(_)));
        let armed = self.start.armed;
        let control = || armed && self.lost_because().is_none();
        match needs {
            Needs::Link => true,
            Needs::Control => control(),
            Needs::OperatorWithControl => operator && control(),
            Needs::DriverWithControl => (operator || driver) && control(),
            Needs::OperatorArmed => operator && armed,
            Needs::Driver => driver && armed,
            Needs::Window => control() && self.acoustic.is_open(self.now),
            Needs::Never => false,
        }
    }
}

//! Passes the vehicle's answers to what they are for (SPI 4.4, 6.21). An acknowledgement never counts as navigation.

use backseat_spi::{AckStatus, Acknowledgement};

use super::Core;
use crate::io::Note;
use crate::session::commands::{Answer, Command, Found, Purpose};
use crate::session::name;

impl Core {
    pub(crate) fn acknowledged(&mut self, ack: &Acknowledgement) {
        self.cx.heard(ack.created);
        self.round_trip(ack);
        if let AckStatus::Other(code) = ack.status {
            // Such a status neither accepts nor refuses, so the command stays unanswered. If it counted as a refusal,
            // an insert that the vehicle flies would count as over.
            if let Some(count) = self.session.malformed() {
                let text = format!("BFACK of {}: status {code} is not defined", ack.command.as_str());
                self.cx.note(Note::Malformed { text, count });
            }
            return;
        }
        let subscriptions = self.cx.link.subscriptions.subjects();
        let Some((command, found)) = self.cx.link.commands.answer(ack, self.cx.now, subscriptions) else {
            if ack.command == name("RMB") && matches!(ack.status, AckStatus::Invalid | AckStatus::Failed) {
                let (echo, text) = (ack.command_created, ack.text.as_str());
                self.capabilities.modify.refused_again(&mut self.cx, echo, text);
            }
            return;
        };
        let named = match found {
            Found::Settled { named } => named,
            Found::NotSettled => return self.answered(command, Answer::Pending, true),
            Found::NotUnderstood => return self.not_understood(&command, ack.text.as_str()),
            Found::AfterRefusal => {
                if let Purpose::Insert(request) = command.purpose {
                    self.capabilities.inserts.accepted_after_refusal(&mut self.cx, request);
                }
                return;
            }
        };
        let answer = match ack.status {
            AckStatus::Pending => Answer::Pending,
            AckStatus::Succeeded => Answer::Done,
            AckStatus::Invalid | AckStatus::Failed | AckStatus::Other(_) => Answer::Refused(ack.text.as_str()),
        };
        self.answered(command, answer, named);
    }

    /// The vehicle may not have understood a command that core sends again, or cancels, if it is not answered in time.
    fn not_understood(&mut self, command: &Command, text: &str) {
        if let Purpose::Subscription(index) = command.purpose {
            return self.session.tell_of_refused_subscription(&mut self.cx, index, text);
        }
        let command = command.name.as_str();
        self.cx.note_of_vehicle(Note::Text {
            text: format!("the vehicle did not understand {command} or another command: {text}"),
        });
    }

    /// Passes an answer, or its absence, to the part that sent the command.
    /// `named` is whether the acknowledgement named the command.
    pub(crate) fn answered(&mut self, command: Command, answer: Answer<'_>, named: bool) {
        match command.purpose {
            // Its answer shows only that this vehicle answers early commands.
            Purpose::Early => {}
            // Otherwise only its round trip counts.
            Purpose::Beat => self.session.log_answered(&mut self.cx, answer),
            Purpose::Subscription(index) => self.session.subscription_answered(&mut self.cx, index, answer, named),
            Purpose::Plan => self.plan_answered(answer),
            Purpose::Lease(request) => self.capabilities.modify.answered(&mut self.cx, request, answer),
            Purpose::Insert(request) => self.capabilities.inserts.answered(&mut self.cx, request, answer),
            Purpose::Cancel { cancel, insert } => {
                self.capabilities
                    .inserts
                    .cancel_answered(&mut self.cx, cancel, insert, answer)
            }
            Purpose::Request(request) => self.cx.request_answered(request, answer),
            Purpose::Topside(request) => self.capabilities.topside.answered(&mut self.cx, request, answer),
            Purpose::Silent(request) => self.capabilities.silent.answered(&mut self.cx, request, answer),
            Purpose::Adjustment(request) => self.capabilities.adjustments.answered(&mut self.cx, request, answer),
            Purpose::Packet(request) => self.capabilities.acoustic.answered(&mut self.cx, request, answer),
            Purpose::DvlTrigger(request) => self.capabilities.dvl.answered(&mut self.cx, request, answer),
            Purpose::Station(request) => {
                self.capabilities
                    .station
                    .answered(&mut self.cx, request, command.name, answer)
            }
            Purpose::CancelAll(request) => {
                if self.orders.cancel_all_answered(&mut self.cx, request, answer) {
                    self.session.ask_for_plan(&mut self.cx);
                }
            }
            Purpose::Ending(request) => {
                self.orders
                    .ending_answered(&mut self.cx, &mut self.capabilities, request, answer)
            }
            Purpose::EmptyMission(request) => self.orders.empty_answered(&mut self.cx, request, answer),
            Purpose::SpeedRestored(request) => self.capabilities.station.speed_restored(&mut self.cx, request, answer),
            Purpose::Courtesy => {
                if command.name == name("LOG") {
                    self.session.log_answered(&mut self.cx, answer);
                }
                if command.name == name("RMB") && matches!(answer, Answer::Missing | Answer::Refused(_)) {
                    self.capabilities.modify.failed_after_its_end(&mut self.cx, answer);
                }
                if let Answer::Refused(text) = answer {
                    self.cx.note(Note::Text {
                        text: format!("the vehicle refused {}: {text}", command.name.as_str()),
                    });
                }
            }
        }
    }
}

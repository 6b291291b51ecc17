//! A request changes its state: its owner and the log learn of it.

use super::Context;
use crate::ended::{EndCause, Failure};
use crate::io::Note;
use crate::ledger::Transition;
use crate::owner::Owner;
use crate::plugin::{Event, RequestState};
use crate::session::commands::Answer;

impl Context {
    /// Changes a request's state, and reports it to its owner and the log.
    pub(crate) fn transition(&mut self, request: u64, to: RequestState) {
        if let Some(transition) = self.transition_unnoted(request, to) {
            self.note(Note::Request(transition));
        }
    }

    /// As [`Context::transition`], but only for the owner: the log has a count.
    pub(crate) fn transition_unnoted(&mut self, request: u64, to: RequestState) -> Option<Transition> {
        let transition = self.ledger.transition(request, to)?;
        match transition.owner {
            Owner::Plugin(plugin) => {
                let (tag, state) = (transition.tag, transition.state.clone());
                self.plugins.tell(plugin, Event::Outcome { tag, state });
            }
            Owner::External(source) => {
                let utc = self.stamper.utc(self.now);
                self.externals.tell(&mut self.outbox, utc, source, &transition);
            }
            Owner::Operator => {}
        }
        Some(transition)
    }

    /// As [`Context::transition`], but only for the log: the plugin replaced its own request under the same tag.
    pub(crate) fn transition_quietly(&mut self, request: u64, to: RequestState) {
        if let Some(transition) = self.ledger.transition(request, to) {
            self.note(Note::Request(transition));
        }
    }

    /// Handles the answer to a request that ends with it.
    pub(crate) fn request_answered(&mut self, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => self.transition(request, RequestState::Pending),
            Answer::Done => {
                self.transition(request, RequestState::Accepted);
                self.transition(request, RequestState::Ended(EndCause::Done.into()));
            }
            Answer::Refused(text) => self.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned()))),
            Answer::Missing => self.transition(request, RequestState::TimedOut),
        }
    }

    /// The link is gone, so every request on which the vehicle has not decided is in doubt. An insert has an identifier
    /// that can resolve its state later. Any other request has none, and times out.
    pub(crate) fn doubt_undecided(&mut self) {
        let undecided: Vec<(u64, RequestState)> = self
            .ledger
            .iter()
            .filter(|(_, entry)| matches!(entry.state, RequestState::Sent | RequestState::Pending))
            .filter(|(_, entry)| !entry.kind.is_of_sonar())
            .map(|(request, entry)| {
                let insert = entry.is_open_insert();
                (
                    request,
                    if insert {
                        RequestState::Unknown
                    } else {
                        RequestState::TimedOut
                    },
                )
            })
            .collect();
        for (request, to) in undecided {
            self.transition(request, to);
        }
    }
}

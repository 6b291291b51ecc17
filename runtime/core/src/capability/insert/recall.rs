//! Inserts that the runtime cancels by itself (BPRCN, SPI 7.8): for the operator's hold, for a fail action, for
//! recovery, because the vehicle did not answer the insert, or because the insert is no longer safe.
//!
//! A plugin can ask again if its cancel is not answered; here nobody would. So the runtime sends an unanswered cancel
//! again after a delay that doubles each time, five times in all on one connection. When a lost link is back, it begins
//! anew. An insert that has begun or has ended meanwhile needs no further cancel (7.8).

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::Timestamp;

use crate::capability::insert::Inserts;
use crate::context::Context;
use crate::io::Note;
use crate::monitor::envelope::Insert;
use crate::plugin::{PluginId, RequestState};
use crate::session::commands::Answer;
use crate::timer::Timer;

/// How often a cancel that is not answered is sent on one connection.
const SENT_MAX: u32 = 5;
/// How often core begins anew with the cancels of one insert on one connection, while the plan names it under the hold.
const ROUNDS_MAX: u32 = 3;
/// How long core waits with the second cancel after it found the first one unanswered.
const AGAIN_AFTER: Duration = Duration::from_secs(1);

/// An insert that the runtime is cancelling.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Recall {
    identifier: BehaviorId,
    /// How often its cancel was sent on this connection.
    sent: u32,
    /// When it is sent again; `None` while it waits for its answer or for the link.
    due: Option<Timestamp>,
    /// The vehicle has refused it, or was sent it often enough. It is sent again on a new connection, or if there is a new
    /// reason.
    given_up: bool,
    /// How often that was, and the operator's hold or the plan made core begin again.
    rounds: u32,
}

/// The inserts that the runtime is cancelling, by their requests.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Recalls {
    open: BTreeMap<u64, Recall>,
}

impl Inserts {
    /// Cancels every insert that has not begun, of one plugin or of all. It cancels them one by one by their
    /// identifiers and never sends BPRCA, which may cancel another payload's inserts too. No way is judged, because the
    /// operator wants it so.
    pub(crate) fn take_back_all(&mut self, cx: &mut Context, plugin: Option<PluginId>) {
        for (insert, _, _) in self.waiting_inserts(cx, plugin) {
            if !self.is_kept_gps_hit(cx, insert) {
                self.recall(cx, insert);
            }
        }
        self.recall_doubtful(cx, plugin);
    }

    /// As [`Self::take_back_all`], but cancels only where the way that remains is inside the fence (safety requirement
    /// 020). It goes from the last insert to the first, and judges each with what is left of the others. False if one
    /// could not be cancelled because of its way.
    pub(crate) fn take_back_judged(&mut self, cx: &mut Context, plugin: Option<PluginId>) -> bool {
        let mut left = cx.outlook().chain();
        let mut all = true;
        for (insert, _, _) in self.waiting_inserts(cx, plugin).into_iter().rev() {
            if self.is_kept_gps_hit(cx, insert) {
                continue;
            }
            if let Err(refusal) = cx.outlook().judge_cancel(&left, insert) {
                all = false;
                cx.note(Note::Text {
                    text: format!(
                        "insert {insert} is not cancelled, because the way without it would be refused: {}",
                        refusal.detail()
                    ),
                });
                continue;
            }
            left.retain(|(request, _, _)| *request != insert);
            self.recall(cx, insert);
        }
        // Each judgement of a way allows for a vehicle that does not have the doubtful inserts, so they may be
        // cancelled without one of their own. But none of them may be flown: core must know what the vehicle flies.
        if cx.vehicle.courses.current().is_some() {
            self.recall_doubtful(cx, plugin);
        }
        all
    }

    /// Cancels the inserts that timed out: they may still be in the vehicle's plan.
    fn recall_doubtful(&mut self, cx: &mut Context, plugin: Option<PluginId>) {
        let doubtful: Vec<(u64, BehaviorId)> = cx
            .ledger
            .doubtful_requests()
            .filter(|(_, entry)| plugin.is_none_or(|plugin| entry.owner == plugin))
            .filter(|(_, entry)| entry.insert.is_some_and(|insert| !insert.surfaces()))
            .filter_map(|(request, entry)| Some((request, entry.identifier?)))
            .collect();
        for (insert, identifier) in doubtful {
            self.recall_as(cx, insert, identifier);
        }
    }

    /// Our open inserts that have not begun.
    fn waiting_inserts(&self, cx: &Context, plugin: Option<PluginId>) -> Vec<(u64, Insert, bool)> {
        let mut waiting = cx.outlook().chain();
        waiting.retain(|(request, _, begun)| {
            let of = cx.ledger.get(*request).map(|entry| entry.owner);
            !begun && plugin.is_none_or(|plugin| of.is_some_and(|owner| owner == plugin))
        });
        waiting
    }

    fn is_kept_gps_hit(&mut self, cx: &mut Context, insert: u64) -> bool {
        let kept = cx.ledger.is_gps_hit(Some(insert));
        if kept {
            cx.note(Note::Text {
                text: format!("GPS hit {insert} may still be flown: it cannot be cancelled (SPI 7.8)"),
            });
        }
        kept
    }

    /// Cancels an insert, and repeats that if the vehicle does not answer.
    pub(crate) fn recall(&mut self, cx: &mut Context, insert: u64) {
        if let Some(identifier) = cx.ledger.get(insert).and_then(|entry| entry.identifier) {
            self.recall_as(cx, insert, identifier);
        }
    }

    pub(super) fn recall_as(&mut self, cx: &mut Context, insert: u64, identifier: BehaviorId) {
        if self.recalls.open.get(&insert).is_some_and(|recall| !recall.given_up) {
            return;
        }
        let rounds = self.recalls.open.get(&insert).map_or(0, |recall| recall.rounds + 1);
        let recall = Recall {
            identifier,
            sent: 0,
            due: None,
            given_up: false,
            rounds,
        };
        self.recalls.open.insert(insert, recall);
        cx.ledger.set_recalled(insert, true);
        self.send_recall(cx, insert);
    }

    fn send_recall(&mut self, cx: &mut Context, insert: u64) {
        let Some(recall) = self.recalls.open.get_mut(&insert) else {
            return;
        };
        recall.due = None;
        let identifier = recall.identifier;
        if !cx.link.is_up() {
            // It is sent when the link is back.
            return;
        }
        recall.sent += 1;
        if !cx.send_cancel(None, insert, identifier) {
            self.again_later(cx, insert);
        }
        self.set_recall_timer(cx);
    }

    /// The vehicle's answer to a cancel of the runtime's own, or the lack of one.
    pub(crate) fn recall_answered(&mut self, cx: &mut Context, insert: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Missing => self.again_later(cx, insert),
            Answer::Done => {
                self.forget_recall(cx, insert);
            }
            // The vehicle had not decided on the insert yet, and may still accept it.
            Answer::Refused(_) if self.is_undecided(cx, insert) => self.again_later(cx, insert),
            Answer::Refused(text) => {
                if self.give_up_recall(cx, insert) {
                    cx.note(Note::Text {
                        text: format!("insert {insert} was not cancelled: {text}"),
                    });
                }
            }
        }
        self.set_recall_timer(cx);
    }

    fn is_undecided(&self, cx: &Context, insert: u64) -> bool {
        let open = cx.ledger.get(insert);
        open.is_some_and(|entry| {
            matches!(
                entry.state,
                RequestState::Sent | RequestState::Pending | RequestState::Unknown
            )
        }) || cx.ledger.may_wait(insert)
    }

    fn again_later(&mut self, cx: &mut Context, insert: u64) {
        let Some(recall) = self.recalls.open.get_mut(&insert) else {
            return;
        };
        if recall.sent < SENT_MAX {
            recall.due = Some(cx.now + AGAIN_AFTER * (1 << recall.sent.saturating_sub(1)));
        } else {
            self.give_up_recall(cx, insert);
            cx.note(Note::Text {
                text: format!(
                    "insert {insert} may still be flown: the vehicle has carried out none of {SENT_MAX} cancels"
                ),
            });
        }
    }

    /// Sends the unanswered cancels that are due again.
    pub(crate) fn recalls_timed_out(&mut self, cx: &mut Context) {
        let now = cx.now;
        self.send_recalls(cx, |recall| recall.due.is_some_and(|due| due <= now));
        self.set_recall_timer(cx);
    }

    /// The link is lost, and the answers with it.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        for recall in self.recalls.open.values_mut() {
            recall.due = None;
        }
        self.set_recall_timer(cx);
    }

    /// The link is back: sends the cancels again.
    pub(crate) fn link_up(&mut self, cx: &mut Context) {
        for recall in self.recalls.open.values_mut() {
            recall.sent = 0;
            recall.given_up = false;
            recall.rounds = 0;
        }
        self.send_recalls(cx, |_| true);
    }

    fn send_recalls(&mut self, cx: &mut Context, due: impl Fn(&Recall) -> bool) {
        let due: Vec<u64> = self
            .recalls
            .open
            .iter()
            .filter(|(_, recall)| due(recall))
            .map(|(insert, _)| *insert)
            .collect();
        for insert in due {
            if self.may_be_recalled(cx, insert) {
                self.send_recall(cx, insert);
            } else {
                self.forget_recall(cx, insert);
            }
        }
    }

    /// The operator holds, and the plan is complete: cancels again what it names although its cancels did not succeed.
    pub(crate) fn take_back_named(&mut self, cx: &mut Context) {
        let again =
            |recall: &Recall| recall.given_up && recall.rounds < ROUNDS_MAX && cx.vehicle.plan.has(recall.identifier);
        let open = self.recalls.open.iter();
        let again = open.filter(|(_, recall)| again(recall));
        let again: Vec<(u64, BehaviorId)> = again.map(|(insert, recall)| (*insert, recall.identifier)).collect();
        for (insert, identifier) in again {
            if self.may_be_recalled(cx, insert) {
                self.recall_as(cx, insert, identifier);
            }
        }
    }

    /// The cancel of an insert did not succeed. While the insert waits, no other cancel of it is sent for the same reason.
    /// Returns whether it was being cancelled until now.
    fn give_up_recall(&mut self, cx: &mut Context, insert: u64) -> bool {
        if !self.may_be_recalled(cx, insert) {
            return self.forget_recall(cx, insert);
        }
        let Some(recall) = self.recalls.open.get_mut(&insert) else {
            return false;
        };
        recall.due = None;
        !std::mem::replace(&mut recall.given_up, true)
    }

    /// The runtime no longer cancels an insert. True if it did so until now.
    fn forget_recall(&mut self, cx: &mut Context, insert: u64) -> bool {
        cx.ledger.set_recalled(insert, false);
        self.recalls.open.remove(&insert).is_some()
    }

    /// Whether the vehicle may still have an insert that it has not begun.
    fn may_be_recalled(&self, cx: &Context, insert: u64) -> bool {
        match cx.ledger.get(insert) {
            Some(entry) => entry.state != RequestState::Started,
            None => cx.ledger.is_doubtful(insert),
        }
    }

    fn set_recall_timer(&mut self, cx: &mut Context) {
        let first = self.recalls.open.values().filter_map(|recall| recall.due).min();
        cx.timers.set_or_stop(Timer::Recall, first);
    }
}

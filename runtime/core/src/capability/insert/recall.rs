//! Inserts that the runtime takes back by itself (BPRCN, SPI 7.8): for the operator's hold, for a fail action, for
//! recovery, or because the vehicle did not answer for one.
//!
//! A plugin asks again where its cancel was not answered; here nobody would. So one that is not answered is sent again
//! after a while that doubles each time, five times in all on a connection, and once more as soon as a lost link is back.
//! An insert that has begun or has ended meanwhile needs no more (7.8).

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

/// How often a cancel is sent on a connection while it is not answered.
const SENT_MAX: u32 = 5;
/// How long the second sending waits after the first was found to be unanswered.
const AGAIN_AFTER: Duration = Duration::from_secs(1);

/// An insert that is being taken back.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Recall {
    identifier: BehaviorId,
    /// How often its cancel was sent on this connection.
    sent: u32,
    /// When it is sent again; `None` while its answer is awaited, or the link.
    due: Option<Timestamp>,
}

/// The inserts that are being taken back, by their requests.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Recalls {
    open: BTreeMap<u64, Recall>,
}

impl Inserts {
    /// Cancels every insert that has not begun, of one plugin or of all: one by one by identifier, never BPRCA, which may
    /// take another payload's too. The operator's word: no way is judged.
    pub(crate) fn take_back_all(&mut self, cx: &mut Context, plugin: Option<PluginId>) {
        for (insert, _, _) in self.waiting_inserts(cx, plugin) {
            if !self.is_kept_gps_hit(cx, insert) {
                self.recall(cx, insert);
            }
        }
        self.recall_doubtful(cx, plugin);
    }

    /// As [`Self::take_back_all`], where the way that remains holds (safety requirement 020): from the last insert to the
    /// first, each judged with what is left of the others. False where one had to be left to the vehicle because of its
    /// way.
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
                        "insert {insert} is not cancelled, what would remain is worse: {}",
                        refusal.detail()
                    ),
                });
                continue;
            }
            left.retain(|(request, _, _)| *request != insert);
            self.recall(cx, insert);
        }
        // The ways without them are judged whenever one is: the vehicle may not have them. But none may be flown.
        if cx.vehicle.courses.current().is_some() {
            self.recall_doubtful(cx, plugin);
        }
        all
    }

    /// What ended without the vehicle's word may be in its plan all the same.
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
                text: format!("GPS hit {insert} may be flown yet: it cannot be cancelled (SPI 7.8)"),
            });
        }
        kept
    }

    /// Takes an insert back, and sees to it that the vehicle answers.
    pub(crate) fn recall(&mut self, cx: &mut Context, insert: u64) {
        if let Some(identifier) = cx.ledger.get(insert).and_then(|entry| entry.identifier) {
            self.recall_as(cx, insert, identifier);
        }
    }

    fn recall_as(&mut self, cx: &mut Context, insert: u64, identifier: BehaviorId) {
        if cx.ledger.is_recalled(insert) {
            return;
        }
        let recall = Recall {
            identifier,
            sent: 0,
            due: None,
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
            // It is sent once the link is back.
            return;
        }
        recall.sent += 1;
        if !cx.send_cancel(None, insert, identifier) {
            self.again_later(cx, insert);
        }
        self.set_recall_timer(cx);
    }

    /// The vehicle's answer to a cancel of the runtime's own, or that there was none.
    pub(crate) fn recall_answered(&mut self, cx: &mut Context, insert: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Missing => self.again_later(cx, insert),
            Answer::Done => {
                self.forget_recall(cx, insert);
            }
            // The vehicle had not decided on the insert, and may yet accept it.
            Answer::Refused(_) if self.is_undecided(cx, insert) => self.again_later(cx, insert),
            Answer::Refused(text) => {
                if self.forget_recall(cx, insert) {
                    cx.note(Note::Text {
                        text: format!("insert {insert} was not taken back: {text}"),
                    });
                }
            }
        }
        self.set_recall_timer(cx);
    }

    fn is_undecided(&self, cx: &Context, insert: u64) -> bool {
        cx.ledger.get(insert).is_some_and(|entry| {
            matches!(
                entry.state,
                RequestState::Sent | RequestState::Pending | RequestState::Unknown
            )
        })
    }

    fn again_later(&mut self, cx: &mut Context, insert: u64) {
        let Some(recall) = self.recalls.open.get_mut(&insert) else {
            return;
        };
        if recall.sent < SENT_MAX {
            recall.due = Some(cx.now + AGAIN_AFTER * (1 << recall.sent.saturating_sub(1)));
        } else {
            self.forget_recall(cx, insert);
            cx.note(Note::Text {
                text: format!("insert {insert} may be flown yet: its cancel was not answered {SENT_MAX} times"),
            });
        }
    }

    /// Cancels that were not answered are due again.
    pub(crate) fn recalls_timed_out(&mut self, cx: &mut Context) {
        let now = cx.now;
        self.send_recalls(cx, |recall| recall.due.is_some_and(|due| due <= now));
        self.set_recall_timer(cx);
    }

    /// The link is gone, and the answers with it.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        for recall in self.recalls.open.values_mut() {
            recall.due = None;
        }
        self.set_recall_timer(cx);
    }

    /// The link is back: what was to be taken back is.
    pub(crate) fn link_up(&mut self, cx: &mut Context) {
        for recall in self.recalls.open.values_mut() {
            recall.sent = 0;
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

    /// An insert is not taken back any more; whether it was.
    fn forget_recall(&mut self, cx: &mut Context, insert: u64) -> bool {
        cx.ledger.set_recalled(insert, false);
        self.recalls.open.remove(&insert).is_some()
    }

    /// Whether the vehicle may have an insert yet that it has not begun.
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

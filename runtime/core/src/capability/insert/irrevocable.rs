//! Requests that nothing takes back: GPS hits, and inserts that interrupt what is flown (SPI 7.8; safety requirement
//! 023).
//!
//! A vehicle that has stopped reading finds such a request when it reads again, however old it is by then. So the
//! request leaves only if the vehicle has just answered a heartbeat. Otherwise it waits one second for such an answer.

use std::time::Duration;

use backseat_units::Timestamp;

use crate::capability::insert::Inserts;
use crate::context::Context;
use crate::monitor::envelope::Insert;
use crate::mutations::{Check, is_on};
use crate::plugin::{PluginId, RequestState};
use crate::refusal::{Figure, Reason, Uncontrolled};
use crate::timer::Timer;

/// How long a request waits for the vehicle's answer.
const ANSWERED_WITHIN: Duration = Duration::from_secs(1);
/// The most inserts that wait at once.
const WAITING_MAX: usize = 8;

/// An insert that waits for an answer of the vehicle.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Waiting {
    pub(crate) request: u64,
    pub(crate) plugin: PluginId,
    pub(crate) tag: u64,
    pub(crate) insert: Insert,
    until: Timestamp,
}

impl Inserts {
    /// Whether an insert must wait for the vehicle to answer.
    pub(crate) fn waits_for_answer(&self, cx: &Context, insert: &Insert) -> bool {
        (insert.interrupt || insert.surfaces()) && !has_answered(cx) && is_on(Check::IrrevocableAnswered)
    }

    /// Sends a heartbeat unless one is under way, and keeps the insert until it is answered.
    pub(crate) fn wait_for_answer(
        &mut self,
        cx: &mut Context,
        request: u64,
        plugin: PluginId,
        tag: u64,
        insert: Insert,
    ) {
        if self.waiting.len() >= WAITING_MAX {
            let most = WAITING_MAX as f64;
            return cx.reject(request, Figure::WaitingInserts.over(most + 1.0, most));
        }
        self.waiting.push(Waiting {
            request,
            plugin,
            tag,
            insert,
            until: cx.now + ANSWERED_WITHIN,
        });
        if !cx.link.heartbeat.beat_is_under_way(cx.now) {
            cx.link.wants_beat = true;
        }
    }

    /// Whether a plugin's insert with this tag waits.
    pub(crate) fn is_waiting(&self, plugin: PluginId, tag: u64) -> bool {
        self.waiting
            .iter()
            .any(|waiting| waiting.plugin == plugin && waiting.tag == tag)
    }

    /// A plugin has failed: rejects its inserts that wait.
    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        let (failed, others) = self.waiting.drain(..).partition(|waiting| waiting.plugin == plugin);
        self.waiting = others;
        let failed: Vec<Waiting> = failed;
        for waiting in failed {
            cx.reject(waiting.request, Reason::PluginFailed.into());
        }
    }

    /// Control is lost, or the operator holds: rejects every insert that waits. What was asked for before that must not
    /// leave after it, even if control is back before the vehicle answers.
    pub(crate) fn reject_waiting(&mut self, cx: &mut Context, reason: Uncontrolled) {
        for waiting in core::mem::take(&mut self.waiting) {
            cx.reject(waiting.request, reason.into());
        }
        cx.timers.stop(Timer::Irrevocable);
    }

    /// Takes the oldest insert that waits, if the vehicle has answered by now and the insert has not waited too long.
    pub(crate) fn take_answered(&mut self, cx: &Context) -> Option<Waiting> {
        let in_time = |waiting: &Waiting| cx.now < waiting.until;
        let index = self.waiting.iter().position(in_time)?;
        has_answered(cx).then(|| self.waiting.remove(index))
    }

    /// Rejects the inserts that have waited for too long.
    pub(crate) fn reject_unanswered(&mut self, cx: &mut Context) {
        let now = cx.now;
        let over = |waiting: &Waiting| waiting.until <= now;
        while let Some(index) = self.waiting.iter().position(over) {
            let waiting = self.waiting.remove(index);
            cx.reject(waiting.request, Reason::NotAnswered.into());
        }
        let next = self.waiting.iter().map(|waiting| waiting.until).min();
        cx.timers.set_or_stop(Timer::Irrevocable, next);
    }
}

/// Whether the vehicle has just answered, and has answered every insert before this one. A beat that is sent after an
/// insert shows only that the vehicle has read the insert, and not what it makes of it.
fn has_answered(cx: &Context) -> bool {
    let mut inserts = cx.ledger.iter().filter(|(_, entry)| entry.is_open_insert());
    cx.link.heartbeat.has_just_answered(cx.now) && !inserts.any(|(_, entry)| entry.state == RequestState::Sent)
}

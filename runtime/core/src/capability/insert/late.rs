//! Inserts that have not begun in time (safety requirement 002). Core cancels such an insert if a zone opens or closes
//! before its new latest end.

use super::Inserts;
use crate::context::Context;
use crate::io::Note;
use crate::ledger::schedule::Schedule;
use crate::monitor::limits::seconds;
use crate::plugin::RequestState;

impl Inserts {
    /// Cancels each insert that has not begun in time, if a zone opens or closes between the latest end for which it
    /// was judged and the new latest end, or if core cannot compute the new one.
    pub(crate) fn watch_schedules(&mut self, cx: &mut Context) {
        let now = cx.now;
        let waiting = cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.state != RequestState::Started);
        let late: Vec<(u64, Schedule)> = waiting
            .filter_map(|(request, entry)| Some((request, entry.schedule?)))
            .filter(|(_, schedule)| schedule.begins_by < now)
            .collect();
        if late.is_empty() {
            return;
        }
        // Only older inserts come before it, and they take no longer than all open ones together.
        let before_s = cx.outlook().before_insert_s(false);
        for (request, schedule) in late {
            let anew = Schedule {
                begins_by: now + seconds(before_s),
                ends_by: now + seconds(before_s + schedule.lasts_s),
                ..schedule
            };
            let holds = before_s.is_finite() && !cx.outlook().changes_between(schedule.ends_by, anew.ends_by);
            if let Some(entry) = cx.ledger.get_mut(request) {
                entry.schedule = holds.then_some(anew);
            }
            if !holds {
                self.call_back(
                    cx,
                    request,
                    "it has not begun in the time for which its zones were judged",
                );
            }
        }
    }

    /// Cancels an insert if that is possible, and says why.
    pub(crate) fn call_back(&mut self, cx: &mut Context, request: u64, why: &str) {
        if cx.ledger.is_gps_hit(Some(request)) {
            let text = format!("GPS hit {request}: {why}, and it cannot be cancelled (SPI 7.8)");
            return cx.note(Note::Text { text });
        }
        let text = format!("insert {request} is cancelled: {why}");
        cx.note(Note::Text { text });
        self.recall(cx, request);
    }
}

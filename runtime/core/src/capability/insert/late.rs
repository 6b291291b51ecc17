//! Inserts that have not begun in time (safety requirement 002): each is judged by the new time, and called back where that
//! does not hold.

use super::Inserts;
use crate::context::Context;
use crate::io::Note;
use crate::ledger::schedule::Schedule;
use crate::monitor::limits::seconds;
use crate::plugin::RequestState;

impl Inserts {
    /// Calls back what has not begun in time and whose zones change by when it may be flown now.
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
        // Its elders alone come before it. All that is open takes no less.
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
                    "it has not begun in the time that its zones were judged for",
                );
            }
        }
    }

    /// Takes an insert back, where that can be done, and says why.
    pub(crate) fn call_back(&mut self, cx: &mut Context, request: u64, why: &str) {
        if cx.ledger.is_gps_hit(Some(request)) {
            let text = format!("GPS hit {request}: {why}, and it cannot be cancelled (SPI 7.8)");
            return cx.note(Note::Text { text });
        }
        let text = format!("insert {request} is called back: {why}");
        cx.note(Note::Text { text });
        self.recall(cx, request);
    }
}

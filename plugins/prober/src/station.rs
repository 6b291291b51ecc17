//! Station keeping of a hovering vehicle: it keeps its station or moves for some seconds, and is then released.

use backseat_sdk::{BottomPosition, HullPosition, Request, State, Station, StationTarget};
use serde::{Deserialize, Serialize};

use crate::asking::Asking;
use crate::config::Kind;

/// Whether the plugin lets the vehicle keep its station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Keeping {
    /// The tag of the station keeping that lasts, or is requested.
    tag: Option<u64>,
    /// When the next request is due.
    next_ns: u64,
    /// When station keeping has lasted long enough.
    until_ns: u64,
    /// Rejections since a request was last accepted.
    refused: u32,
}

impl Keeping {
    pub(crate) fn step(&mut self, asking: &mut Asking<'_>) {
        if asking.now_ns < self.next_ns || !asking.config.asks_for(Kind::Station) {
            return;
        }
        if self.tag.is_some() && asking.now_ns >= self.until_ns {
            self.tag = None;
            self.rest(asking);
            if asking.random.chance(0.6) {
                // Otherwise it lapses.
                asking.ask(Request::EndStation);
            }
            return;
        }
        if self.tag.is_none() {
            self.until_ns = asking.now_ns + asking.random.nanos(3.0, 40.0);
        }
        self.ask(asking);
    }

    /// Takes in the outcome of a request.
    pub(crate) fn hear(&mut self, tag: u64, state: &State, asking: &mut Asking<'_>) {
        if self.tag != Some(tag) {
            return;
        }
        match state {
            State::Sent | State::Pending | State::Started => {}
            State::Accepted => self.refused = 0,
            State::Rejected(_)
            | State::Failed(_)
            | State::TimedOut
            | State::Unknown
            | State::Ended(_)
            | State::Cancelled => {
                self.tag = None;
                self.refused += u32::from(matches!(state, State::Rejected(_)));
                if asking.is_bold() {
                    self.next_ns = asking.now_ns;
                } else {
                    self.rest(asking);
                }
            }
        }
    }

    /// A new instance does not know what was open.
    pub(crate) const fn restart(&mut self) {
        self.tag = None;
    }

    fn rest(&mut self, asking: &mut Asking<'_>) {
        self.next_ns = asking.now_ns + asking.random.nanos(2.0, 40.0);
    }

    fn ask(&mut self, asking: &mut Asking<'_>) {
        let bold = self.refused.is_multiple_of(2) && asking.is_bold();
        // After each refusal the move is smaller, and finally there is none.
        let reach_m = if bold { 12.0 } else { 2.0 / f64::from(self.refused + 1) };
        let target = self.target(reach_m, bold, asking);
        let moves = !matches!(target, StationTarget::Here);
        let most_s = if asking.dares(0.05) { 90.0 } else { 20.0 };
        let duration_ns = asking.random.nanos(2.0, most_s);
        let tag = match self.tag {
            Some(tag) if asking.random.chance(0.5) => tag,
            Some(_) | None => asking.next_tag(),
        };
        self.tag = Some(tag);
        self.next_ns = asking.now_ns + (duration_ns as f64 * asking.random.within(0.2, 1.1)) as u64;
        let speed_mps = asking.random.within(0.05, if bold { 0.6 } else { 0.25 });
        let inherited = asking.dares(0.1);
        asking.ask(Request::Station(Station {
            tag,
            target,
            speed: (moves && !inherited).then_some(speed_mps),
            duration_ns,
        }));
    }

    fn target(&self, reach_m: f64, bold: bool, asking: &mut Asking<'_>) -> StationTarget {
        if self.refused >= 3 || asking.random.chance(0.25) {
            return StationTarget::Here;
        }
        let mut near = |metres: f64| metres + asking.random.within(-reach_m, reach_m);
        match (asking.fix.hull_m, asking.fix.bottom_m) {
            (Some([horizontal, vertical, distance]), _) => StationTarget::Hull(HullPosition {
                horizontal: near(horizontal),
                vertical: near(vertical),
                distance: near(distance).max(0.0),
            }),
            (None, Some([x, y])) => {
                let (x, y) = (near(x), near(y));
                let vertical = if bold { asking.vertical(true) } else { asking.level() };
                StationTarget::Bottom(BottomPosition { x, y, vertical })
            }
            (None, None) => StationTarget::Here,
        }
    }
}

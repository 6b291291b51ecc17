//! Recovery: what the monitor does if the vehicle is outside the fence although everything that was sent had been
//! judged (safety requirements 002, 019 and 020).
//!
//! Navigation can jump, and a current can be stronger than the mission's worst. The place of each sample, widened by
//! the error of navigation, is compared with the fence, and its depth and altitude with the bands of the zone. An
//! unknown altitude does not count as too low. A vehicle counts as outside once it has been so for `outside_for_s`, and
//! as inside again once it has been inside by `back_by_m` for `back_for_s`.
//!
//! If the backseat has steered the vehicle there, or may have, recovery takes steps, each once and after its own time
//! outside: leases end; our inserts that have not begun are cancelled, if the way that remains is inside the fence; the
//! topside is told; the mission is aborted, if the operator's table allows it. Until the vehicle is inside again, no
//! plugin's request is accepted. If nothing of ours is active, the way is the front seat's own: recovery reports it and
//! does nothing.

use std::time::Duration;

use backseat_spi::{LogMessage, Text, ToVehicle, TopsideText, Transport};
use backseat_units::Timestamp;

use crate::capability::Capabilities;
use crate::context::Context;
use crate::ended::EndCause;
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::monitor::envelope::{Good, MODIFY_TIMEOUT};
use crate::monitor::limits::seconds;
use crate::operator::Orders;
use crate::order::Order;
use crate::plugin::{NavigationSample, Refusal};
use crate::session::commands::Purpose;
use crate::session::dispatch::Dispatch;
use crate::settings::recovery::Recovery;
use crate::timer::Timer;

/// The steps of recovery, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Step {
    Leases,
    Inserts,
    Tell,
    Abort,
}

impl Step {
    /// After how long outside the step is taken; `None` if never.
    fn after(self, table: &Recovery) -> Option<Duration> {
        match self {
            Self::Leases => Some(seconds(table.outside_for_s)),
            Self::Inserts => Some(seconds(table.cancel_after_s)),
            Self::Tell => Some(seconds(table.tell_after_s)),
            Self::Abort => table.abort_after_s.map(seconds),
        }
    }

    const fn next(self) -> Option<Self> {
        match self {
            Self::Leases => Some(Self::Inserts),
            Self::Inserts => Some(Self::Tell),
            Self::Tell => Some(Self::Abort),
            Self::Abort => None,
        }
    }
}

/// Where the vehicle is in relation to the fence.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Whereabouts {
    /// The last place that was judged and is inside, with the surroundings for which that judgement holds.
    good: Option<Good>,
    /// When something of ours was last active.
    active: Option<Timestamp>,
    excursion: Option<Excursion>,
}

/// A time in which the vehicle is outside, as far as core knows.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Excursion {
    /// Since when. Each time inside moves it later, so that it does not count.
    since: Timestamp,
    /// `outside_for_s` have passed.
    confirmed: bool,
    /// The backseat has steered the vehicle there, or may have.
    ours: bool,
    /// The next step; `None` after the last.
    step: Option<Step>,
    /// Since when the newest samples have been inside.
    inside: Option<Timestamp>,
    /// Since when they have been inside by `back_by_m`.
    back: Option<Timestamp>,
    /// The topside must still be told: without control nothing can be sent to it (safety requirement 014).
    untold: bool,
    /// Why the newest place outside is refused.
    refusal: Refusal,
}

impl Whereabouts {
    /// Whether recovery takes its steps. Meanwhile no plugin's request is accepted.
    fn recovers(&self) -> bool {
        self.excursion
            .as_ref()
            .is_some_and(|excursion| excursion.confirmed && excursion.ours)
    }
}

impl Whereabouts {
    /// Judges a new position, and does what follows from it.
    pub(crate) fn watch_place(&mut self, cx: &mut Context, capabilities: &mut Capabilities, orders: &mut Orders) {
        if cx.control.running == Some(false) {
            return self.forget_excursion(cx);
        }
        let Some(navigation) = cx.vehicle.navigation.newest().copied() else {
            return;
        };
        if cx.outlook().is_active() {
            self.active = Some(cx.now);
        }
        match self.judge_place(cx, &navigation) {
            Ok(()) => self.is_inside(cx, &navigation),
            Err(refusal) => self.is_outside(cx, refusal),
        }
        self.climb(cx, capabilities, orders);
        let untold = |excursion: &&Excursion| excursion.untold && excursion.inside.is_none();
        if let Some(refusal) = self
            .excursion
            .as_ref()
            .filter(untold)
            .map(|excursion| excursion.refusal.clone())
        {
            self.tell_topside(cx, capabilities, &refusal);
        }
    }

    fn judge_place(&mut self, cx: &mut Context, navigation: &NavigationSample) -> Result<(), Refusal> {
        if self.good.is_some_and(|good| good.covers(navigation)) {
            return Ok(());
        }
        let utc = cx.zone_utc(cx.now);
        self.good = None;
        self.good = cx.monitor.envelope.judge_place(navigation, utc)?;
        Ok(())
    }

    /// Whether the vehicle may be where it is because of us: what we sent last may carry it on for as long as it keeps
    /// a modify, plus the delay of the link, the age of the navigation by which it was sent, and half a turn from its
    /// first sign to its end.
    fn is_ours(&self, cx: &mut Context) -> bool {
        let limits = cx.monitor.limits();
        let turns_s = limits.turn_lag_s + 180.0 / limits.turn_rate_dps;
        let late_s = limits.link_delay_max_s + limits.navigation_age_max_s;
        let lasts_s = MODIFY_TIMEOUT.as_secs_f64() + late_s + turns_s;
        self.active
            .is_some_and(|active| cx.now.since(active) <= seconds(lasts_s))
    }

    fn is_outside(&mut self, cx: &mut Context, refusal: Refusal) {
        let (now, ours) = (cx.now, self.is_ours(cx));
        let excursion = self.excursion.get_or_insert_with(|| Excursion {
            since: now,
            confirmed: false,
            ours,
            step: Some(Step::Leases),
            inside: None,
            back: None,
            untold: false,
            refusal: refusal.clone(),
        });
        excursion.refusal = refusal;
        excursion.back = None;
        if let Some(inside) = excursion.inside.take() {
            excursion.since = excursion.since + now.since(inside);
        }
        if ours && !excursion.ours {
            // Until now the way was the front seat's own.
            excursion.ours = true;
            excursion.confirmed = false;
            excursion.since = now;
        }
        cx.control.recovering = self.recovers();
    }

    fn is_inside(&mut self, cx: &mut Context, navigation: &NavigationSample) {
        let Some(excursion) = &self.excursion else {
            return;
        };
        if !excursion.confirmed {
            return self.forget_excursion(cx);
        }
        let (utc, room_m) = (cx.zone_utc(cx.now), cx.settings.recovery.back_by_m);
        let well = cx.monitor.envelope.is_well_inside(navigation, room_m, utc);
        let now = cx.now;
        let back_for = seconds(cx.settings.recovery.back_for_s);
        let Some(excursion) = &mut self.excursion else {
            return;
        };
        excursion.inside.get_or_insert(now);
        if !well {
            excursion.back = None;
        } else if now.since(*excursion.back.get_or_insert(now)) >= back_for {
            self.forget_excursion(cx);
            note(cx, "the vehicle is inside the fence again".to_owned());
        }
    }

    fn forget_excursion(&mut self, cx: &mut Context) {
        self.excursion = None;
        cx.control.recovering = false;
        cx.timers.stop(Timer::Recovery);
    }

    /// Takes the steps that are due, and sets the timer for the next one.
    pub(crate) fn climb(&mut self, cx: &mut Context, capabilities: &mut Capabilities, orders: &mut Orders) {
        loop {
            let Some(excursion) = &self.excursion else {
                return;
            };
            // Without the link nothing can be sent, so no step is taken. While the vehicle is inside, no step is due.
            if excursion.inside.is_some() || !cx.link.is_up() {
                return cx.timers.stop(Timer::Recovery);
            }
            let step = excursion.step;
            let after = match (excursion.confirmed, excursion.ours) {
                (false, _) => Step::Leases.after(&cx.settings.recovery),
                (true, true) => step.and_then(|step| step.after(&cx.settings.recovery)),
                (true, false) => None,
            };
            let due = after.map(|after| excursion.since + after);
            if due.is_none_or(|due| due > cx.now) {
                return cx.timers.set_or_stop(Timer::Recovery, due);
            }
            self.take_step(cx, capabilities, orders);
        }
    }

    fn take_step(&mut self, cx: &mut Context, capabilities: &mut Capabilities, orders: &mut Orders) {
        let Some(excursion) = &mut self.excursion else {
            return;
        };
        let refusal = excursion.refusal.clone();
        if !excursion.confirmed {
            excursion.confirmed = true;
            cx.control.recovering = excursion.ours;
            if !excursion.ours {
                let text = format!(
                    "the vehicle is outside: {}; nothing of ours is active, so recovery does nothing",
                    refusal.detail()
                );
                return note(cx, text);
            }
        }
        let Some(step) = excursion.step else { return };
        excursion.step = step.next();
        match step {
            Step::Leases => {
                note(cx, format!("the vehicle is outside: {}; leases end", refusal.detail()));
                capabilities.modify.end(cx, EndCause::OutsideFence);
                capabilities.station.end(cx, EndCause::OutsideFence);
            }
            Step::Inserts => {
                note(cx, "still outside: inserts are cancelled".to_owned());
                if !self.cancel_for_recovery(cx, capabilities, orders) {
                    note(
                        cx,
                        "an insert is kept, because the way without it would be refused: the recovery goes on with its next step".to_owned(),
                    );
                    self.take_step(cx, capabilities, orders);
                }
            }
            Step::Tell => {
                note(cx, "still outside: the topside is told".to_owned());
                self.tell_of_excursion(cx, capabilities, &refusal);
            }
            Step::Abort => {
                note(cx, "still outside: the mission is aborted".to_owned());
                orders.order_in_advance(
                    cx,
                    capabilities,
                    &Order::Abort {
                        text: "outside the fence".to_owned(),
                        errors: true,
                    },
                );
            }
        }
    }

    /// Cancels our inserts that have not begun, and orders the end of the one that is flown if the table says so.
    /// Returns false if an insert was left to the vehicle because the way without it was refused.
    fn cancel_for_recovery(&mut self, cx: &mut Context, capabilities: &mut Capabilities, orders: &mut Orders) -> bool {
        let all = capabilities.inserts.take_back_judged(cx, None);
        let begun = cx.outlook().chain().iter().any(|(_, _, begun)| *begun);
        if !begun {
            return all;
        }
        if cx.settings.recovery.cancel_current {
            // That order is judged as if the operator gave it now.
            orders.order_in_advance(cx, capabilities, &Order::CancelCurrent);
        } else {
            note(
                cx,
                "the current insert continues: `cancel_current` is not set".to_owned(),
            );
        }
        all
    }

    fn tell_of_excursion(&mut self, cx: &mut Context, capabilities: &mut Capabilities, refusal: &Refusal) {
        let text = self.text_of(cx, refusal);
        let created = cx.stamper.stamp(cx.now, "MSG");
        let command = cx.courtesy("MSG", Some(created));
        cx.transmit(&ToVehicle::LogMessage(LogMessage { created, text }), Some(command));
        if cx.settings.recovery.tell_topside {
            self.tell_topside(cx, capabilities, refusal);
        }
    }

    /// Tells the topside, or keeps the message until control is back.
    fn tell_topside(&mut self, cx: &mut Context, capabilities: &mut Capabilities, refusal: &Refusal) {
        let control = cx.control.armed && cx.lost_because().is_none();
        if let Some(excursion) = &mut self.excursion {
            excursion.untold = !control;
        }
        if !control {
            return;
        }
        let text = self.text_of(cx, refusal);
        let request = cx.ledger.propose_order(RequestKind::Topside);
        let message = ToVehicle::TopsideText(TopsideText {
            created: cx.stamper.stamp(cx.now, "TOP"),
            // From under water nothing faster gets through.
            slowest: Transport::AcousticModem,
            text,
        });
        if cx.send_request(request, &Dispatch::new("TOP", message, Purpose::Topside(request))) {
            capabilities.topside.count(cx.now);
        }
    }

    /// By how much the vehicle is outside, and where it is. In lower case, because some vehicles take a sentence for
    /// the command whose name its text contains.
    fn text_of(&self, cx: &mut Context, refusal: &Refusal) -> Text {
        let place = cx.vehicle.navigation.newest().map_or_else(String::new, |navigation| {
            format!(
                " at {:.5} {:.5} depth {:.1} m",
                navigation.position.latitude.as_deg(),
                navigation.position.longitude.as_deg(),
                navigation.depth.as_m()
            )
        });
        Text::cleaned(
            &format!(
                "outside the fence by {:.1} m ({}){place}",
                refusal.missing_m().unwrap_or(0.0),
                refusal.rule()
            )
            .to_lowercase(),
        )
    }
}

fn note(cx: &mut Context, text: String) {
    cx.note(Note::Recovery { text });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_recovery_table_is_named() {
        type Spoil = fn(&mut Recovery);
        assert_eq!(Recovery::default().validate(), Ok(()));
        let cases: [(&str, Spoil); 7] = [
            ("outside_for_s", |ladder| ladder.outside_for_s = f64::NAN),
            ("outside_for_s", |ladder| ladder.outside_for_s = -1.0),
            ("back_for_s", |ladder| ladder.back_for_s = 1e9),
            ("back_by_m", |ladder| ladder.back_by_m = f64::INFINITY),
            ("cancel_after_s", |ladder| ladder.cancel_after_s = 1.0),
            ("tell_after_s", |ladder| ladder.tell_after_s = 3.0),
            ("abort_after_s", |ladder| ladder.abort_after_s = Some(9.0)),
        ];
        for (key, spoil) in cases {
            let mut ladder = Recovery::default();
            spoil(&mut ladder);
            assert_eq!(ladder.validate().unwrap_err().key, key);
        }
    }
}

//! The behaviors that the vehicle begins and ends (SPI 6.9, 6.10), and what follows from that.

use backseat_spi::{BehaviorBegin, BehaviorEnd, BehaviorId, Text};

use super::{Core, course};
use crate::ended::EndCause;
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::owner::Owner;
use crate::plugin::slots::Plugins;
use crate::plugin::{Behavior, Event, RequestState, Topic};
use crate::vehicle::HeardBehavior;
use crate::vehicle::course::Flown;
use crate::vehicle::dive::NamedBy;

/// Where a BFMBS or BFMBE stands among those that came before it.
enum Place {
    /// After all of them.
    Newest,
    /// It is the newest of them, once more, and says nothing new.
    Repeated,
    /// Before one of them, or it may be.
    Unknown,
}

impl Core {
    pub(super) fn behavior_began(&mut self, message: BehaviorBegin) {
        let heard = HeardBehavior {
            created: message.created,
            began: true,
            number: message.number,
            identifier: message.identifier,
        };
        let place = self.place_of(heard, &message.dive_file);
        // This comes first, because the behavior belongs to the dive that the message names. If it is late, it may be of
        // another dive all the same.
        self.dive_named(NamedBy::Behavior, message.created, &message.dive_file);
        match place {
            Place::Newest => {}
            Place::Repeated => return,
            Place::Unknown => return self.out_of_order(heard),
        }
        // A behavior with neither number nor identifier (an adjustment) runs beside what is flown and says nothing
        // about it.
        let is_flown = message.number.is_some() || message.identifier.is_some();
        if is_flown {
            let still_flown_after_end = message
                .identifier
                .filter(|identifier| self.cx.identifiers.is_ours(*identifier))
                .filter(|identifier| self.cx.ledger.by_identifier(*identifier).is_none());
            self.cx
                .vehicle
                .previous_run
                .heard_begin(message.identifier, message.kind.as_str(), still_flown_after_end);
            course::began(&mut self.cx, message.number, message.identifier);
        }
        self.cx.heard(message.created);
        self.cx.note_of_vehicle(Note::Behavior {
            began: true,
            number: message.number,
            identifier: message.identifier.map(|identifier| identifier.get()),
            kind: message.kind.as_str().to_owned(),
        });
        if is_on(Check::LeaseEndsWithBehavior) {
            // The modify belonged to another behavior (SPI 7.12).
            self.capabilities.modify.end(&mut self.cx, EndCause::BehaviorBegan);
        }
        // A suspended mission begins no behavior, so the vehicle has taken its mission up again. An end does not show
        // this: the vehicle may report the end of the behavior that is suspended (SPI 8.1 leaves this open), and
        // station keeping, unlike a modify, does not belong to a behavior.
        self.capabilities.station.end(&mut self.cx, EndCause::MissionGoesOn);
        self.cx.vehicle.mission_goes_on();
        if is_flown {
            self.end_overtaken(message.identifier);
            self.cx.vehicle.named_insert.began(message.identifier);
        }
        let mut own = None;
        match (message.identifier, message.number) {
            (Some(identifier), _) => {
                self.cx.vehicle.plan.left_for_insert();
                if let Some(request) = self.cx.ledger.by_identifier(identifier) {
                    own = self.cx.ledger.get(request).map(|entry| (entry.owner, entry.tag));
                    if let Some(entry) = self.cx.ledger.get_mut(request) {
                        entry.interrupted = false;
                    }
                    self.cx.transition(request, RequestState::Started);
                } else {
                    if !self.cx.vehicle.plan.has(identifier) {
                        // It may be another payload's, inserted after we asked for the plan.
                        self.session.want_plan(&mut self.cx);
                    }
                    // It may have interrupted what was flown. The vehicle then takes that up again after all waiting
                    // inserts.
                    self.capabilities.inserts.judge_waiting(&mut self.cx);
                }
            }
            (None, Some(number)) => {
                if !self.cx.vehicle.plan.began(number) {
                    self.cx.vehicle.plan.invalidate();
                    self.session.want_plan(&mut self.cx);
                }
                // An insert that the vehicle has not answered for is not flown now. If it is not queued either, it is
                // over.
                self.cx
                    .ledger
                    .settle_doubt_if(|entry| entry.not_queued && entry.insert.is_some_and(|insert| !insert.surfaces()));
                for (request, cancelled) in self.cx.ledger.over_unheard() {
                    let over = if cancelled {
                        RequestState::Cancelled
                    } else {
                        RequestState::Ended(EndCause::Overtaken.into())
                    };
                    self.cx.transition(request, over);
                }
                let vehicle = &mut self.cx.vehicle;
                vehicle.previous_run.plan_goes_on(&vehicle.plan);
                self.capabilities.inserts.judge_waiting(&mut self.cx);
            }
            (None, None) => self
                .capabilities
                .adjustments
                .behavior(&mut self.cx, true, message.kind.as_str()),
        }
        tell_of_behavior(&mut self.cx.plugins, true, own, message.kind.as_str());
    }

    pub(super) fn behavior_ended(&mut self, message: BehaviorEnd) {
        let heard = HeardBehavior {
            created: message.created,
            began: false,
            number: message.number,
            identifier: message.identifier,
        };
        match self.place_of(heard, &message.dive_file) {
            Place::Newest => {}
            Place::Repeated => return,
            Place::Unknown => return self.out_of_order(heard),
        }
        self.cx.heard(message.created);
        self.cx.note_of_vehicle(Note::Behavior {
            began: false,
            number: message.number,
            identifier: message.identifier.map(|identifier| identifier.get()),
            kind: message.kind.as_str().to_owned(),
        });
        if is_on(Check::LeaseEndsWithBehavior) {
            self.capabilities.modify.end(&mut self.cx, EndCause::BehaviorEnded);
        }
        self.cx.vehicle.named_insert.finished(message.identifier);
        self.cx.vehicle.previous_run.heard_end(message.identifier);
        if let Some(identifier) = message.identifier {
            self.cx.vehicle.plan.ended(identifier);
            self.cx.ledger.settle_doubt_of(identifier);
        } else if let Some(number) = message.number {
            self.cx.vehicle.plan.finished(number);
        } else {
            self.capabilities
                .adjustments
                .behavior(&mut self.cx, false, message.kind.as_str());
        }
        let mut own = None;
        if let Some(request) = message
            .identifier
            .and_then(|identifier| self.cx.ledger.by_identifier(identifier))
        {
            own = self.cx.ledger.get(request).map(|entry| (entry.owner, entry.tag));
            let interrupted = self.cx.ledger.awaits_interrupter(request);
            match self.cx.ledger.get_mut(request) {
                Some(entry) if interrupted && entry.state == RequestState::Started => entry.interrupted = true,
                _ => {
                    self.cx.ledger.flown(request);
                    self.cx.transition(request, RequestState::Ended(EndCause::Flown.into()));
                }
            }
        }
        course::ended(&mut self.cx, message.number, message.identifier);
        tell_of_behavior(&mut self.cx.plugins, false, own, message.kind.as_str());
    }

    /// A BFMBS or BFMBE was made before a newer one, or before the vehicle named another dive. It is late, or the vehicle's
    /// clock was set. Nobody can tell which, so it is unknown what is flown.
    fn out_of_order(&mut self, heard: HeardBehavior) {
        self.cx.heard(heard.created);
        self.cx.note_of_vehicle(Note::Text {
            text: "a behavior began or ended before one that was heard of: it is unknown what is flown".to_owned(),
        });
        if let Some(identifier) = heard.identifier {
            course::may_have_begun(&mut self.cx, identifier);
        }
        self.invalidate_after_loss();
    }

    /// Where a BFMBS or BFMBE that comes now stands among those that came before it.
    fn place_of(&mut self, heard: HeardBehavior, dive_file: &Text) -> Place {
        let now = self.cx.now;
        let vehicle = &mut self.cx.vehicle;
        // Two adjustments may begin at once.
        let is_flown = heard.number.is_some() || heard.identifier.is_some();
        if is_flown && vehicle.heard_last == Some(heard) {
            // The same message again. What it says may have ended since, unheard.
            let inserted = heard.identifier.map(Flown::Inserted);
            let says = inserted.or(heard.number.map(Flown::Planned)).filter(|_| heard.began);
            let is_known = vehicle.courses.current() == says;
            return if is_known { Place::Repeated } else { Place::Unknown };
        }
        let is_before_dive = vehicle.dive.is_before(now, heard.created, dive_file);
        if is_before_dive || vehicle.behaviors.is_after(now, heard.created) {
            return Place::Unknown;
        }
        vehicle.behaviors.hear(now, heard.created);
        vehicle.heard_last = Some(heard);
        Place::Newest
    }

    /// Ends the inserts that had begun before this behavior. The vehicle flies one behavior at a time, so they are over
    /// when another one begins, even if their BFMBE was lost with a connection. But an insert that was or may have been
    /// interrupted is not over until the plan goes on: the vehicle may first fly all inserts that wait, and then return
    /// to the interrupted one (SPI 7.5).
    fn end_overtaken(&mut self, begun: Option<BehaviorId>) {
        if let Some(begun) = begun {
            let ledger = &mut self.cx.ledger;
            // An insert that this process does not know may interrupt too.
            if ledger
                .sent(begun)
                .is_none_or(|entry| entry.insert.is_none_or(|insert| insert.interrupt))
            {
                ledger.interrupt_all_but(begun);
                return;
            }
            ledger.interrupt_where_an_interrupter_waits(begun);
        }
        let overtaken: Vec<(u64, EndCause)> = self
            .cx
            .ledger
            .iter()
            .filter(|(_, entry)| entry.is_open_insert() && entry.state == RequestState::Started)
            .filter(|(_, entry)| entry.identifier != begun)
            .filter_map(|(request, entry)| match (entry.interrupted, begun) {
                (true, Some(_)) => None,
                (true, None) => Some((request, EndCause::Interrupted)),
                (false, _) => Some((request, EndCause::Overtaken)),
            })
            .collect();
        for (request, why) in overtaken {
            if let Some(identifier) = self.cx.ledger.get(request).and_then(|entry| entry.identifier) {
                self.cx.vehicle.plan.ended(identifier);
            }
            self.cx.transition(request, RequestState::Ended(why.into()));
        }
    }
}

/// Gives the event to the plugins that asked for the vehicle's behaviors.
fn tell_of_behavior(plugins: &mut Plugins, began: bool, own: Option<(Owner, u64)>, kind: &str) {
    for plugin in plugins.ids() {
        if plugins.wants(plugin, Topic::Behavior) {
            let behavior = Behavior {
                kind: kind.to_owned(),
                tag: own.filter(|(owner, _)| *owner == plugin).map(|(_, tag)| tag),
            };
            let event = if began {
                Event::BehaviorBegan(behavior)
            } else {
                Event::BehaviorEnded(behavior)
            };
            plugins.tell(plugin, event);
        }
    }
}

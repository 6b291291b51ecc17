//! What the vehicle may do next, as far as core can know: from what core believes of the vehicle, and from what it has
//! asked for. The monitor judges the ways that are listed here (safety requirement 002).

mod duration;
mod flown;
mod judgement;
mod route;
mod tracks;

use std::time::Duration;

use backseat_spi::BehaviorId;
use backseat_units::Timestamp;

use crate::arbiter::Arbiter;
use crate::identifiers::Identifiers;
use crate::ledger::{Entry, Ledger};
use crate::monitor::Monitor;
use crate::monitor::envelope::{Clocks, Insert};
use crate::plugin::{PluginId, RequestState};
use crate::stamp::Stamper;
use crate::vehicle::Vehicle;
use crate::vehicle::plan::Element;

/// A read-only view of everything that this depends on.
#[derive(Clone, Copy)]
pub(crate) struct Outlook<'a> {
    pub(crate) now: Timestamp,
    pub(crate) stamper: &'a Stamper,
    pub(crate) vehicle: &'a Vehicle,
    pub(crate) monitor: &'a Monitor,
    pub(crate) arbiter: &'a Arbiter,
    pub(crate) identifiers: &'a Identifiers,
    pub(crate) ledger: &'a Ledger,
}

impl<'a> Outlook<'a> {
    /// Inserts of the vehicle's plan whose way core does not know: another payload's, a previous run's, or one of ours that
    /// core believed to be over.
    pub(crate) fn others(&self) -> impl Iterator<Item = (BehaviorId, &'a Element)> + use<'a> {
        let ledger = self.ledger;
        self.vehicle.plan.others(|identifier| ledger.sent(identifier).is_some())
    }

    /// Our open inserts in the order in which they are flown, each with its request and whether it has begun.
    pub(crate) fn chain(&self) -> Vec<(u64, Insert, bool)> {
        self.ledger
            .iter()
            .filter_map(|(request, entry)| Some((request, entry.insert?, entry.state == RequestState::Started)))
            .collect()
    }

    pub(crate) fn open_insert(&self, plugin: PluginId, tag: u64) -> Option<u64> {
        self.ledger
            .iter()
            .find(|(_, entry)| entry.is_open_insert() && entry.owner == plugin && entry.tag == tag)
            .map(|(request, _)| request)
    }

    /// Whether a lease is active, or the vehicle flies or may fly an insert of ours.
    pub(crate) fn is_active(&self) -> bool {
        let flown = |entry: &Entry| {
            entry.is_open_insert() && matches!(entry.state, RequestState::Started | RequestState::Unknown)
        };
        self.arbiter.is_steering()
            || self.ledger.iter().any(|(_, entry)| flown(entry))
            || self.ledger.doubtful().next().is_some()
    }

    /// Whether the vehicle will surely fly a waiting insert: it has accepted the insert, nothing suggests that it has
    /// dropped it since, and we have not tried to cancel it.
    pub(crate) fn is_surely_flown(&self, request: u64) -> bool {
        let waits = |entry: &Entry| entry.state == RequestState::Accepted && entry.may_be_gone.is_none();
        self.ledger.get(request).is_some_and(waits) && !self.ledger.is_recalled(request)
    }

    /// Our UTC, and how far the vehicle's differs from it.
    pub(crate) fn clocks(&self) -> Clocks {
        Clocks {
            utc: self.stamper.zone_utc(self.now),
            apart: self.clocks_apart(),
        }
    }

    /// By how much our clock and the vehicle's differ; `None` if that is not known, or too much to trust either.
    pub(crate) fn clocks_apart(&self) -> Option<Duration> {
        self.vehicle.navigation.clocks_apart(self.now, self.stamper.set_nanos())
    }
}

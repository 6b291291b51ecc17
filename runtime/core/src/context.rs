mod admission;
mod control;
mod ledger;
mod send;

use std::sync::Arc;

use backseat_spi::ToVehicle;
use backseat_units::{TimeOfDay, Timestamp, Utc};

use crate::arbiter::Arbiter;
use crate::control::Control;
use crate::external::Externals;
use crate::identifiers::Identifiers;
use crate::io::{Note, Start};
use crate::ledger::Ledger;
use crate::monitor::Monitor;
use crate::monitor::envelope::Envelope;
use crate::monitor::gate::Gate;
use crate::mutations::{Check, is_on};
use crate::outbox::Outbox;
use crate::outlook::Outlook;
use crate::plugin::slots::Plugins;
use crate::session::link::Link;
use crate::session::subscriptions::Subscriptions;
use crate::settings::{PluginSetup, Settings};
use crate::sonars::Sonars;
use crate::stamp::Stamper;
use crate::timer::Timers;
use crate::vehicle::Vehicle;
use crate::vehicle::phase::Phase;

/// What every capability receives, instead of `Core`: the time, what core believes of the vehicle, the monitor, the
/// ledger and the outputs.
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Context {
    pub(crate) now: Timestamp,
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) settings: Settings,
    pub(crate) stamper: Stamper,
    pub(crate) vehicle: Vehicle,
    pub(crate) control: Control,
    pub(crate) link: Link,
    pub(crate) monitor: Monitor,
    pub(crate) arbiter: Arbiter,
    pub(crate) identifiers: Identifiers,
    pub(crate) ledger: Ledger,
    pub(crate) outbox: Outbox,
    pub(crate) timers: Timers,
    pub(crate) plugins: Plugins,
    pub(crate) externals: Externals,
    pub(crate) sonars: Sonars,
}

impl Context {
    pub(crate) fn new(settings: Settings, envelope: Arc<Envelope>, plugins: Vec<PluginSetup>, start: Start) -> Self {
        let limits = envelope.limits();
        Self {
            now: Timestamp::ZERO,
            stamper: Stamper::new(start.utc),
            vehicle: Vehicle::new(*envelope.fence().frame(), limits, start.identifiers),
            control: Control::new(start.armed, start.held && is_on(Check::OperatorHold)),
            link: Link::new(
                Subscriptions::new(&plugins, settings.sonar.is_some()),
                limits.link_delay_max(),
            ),
            arbiter: Arbiter::new(plugins.len()),
            identifiers: Identifiers::new(start.identifiers),
            ledger: Ledger::default(),
            outbox: Outbox::default(),
            timers: Timers::default(),
            plugins: Plugins::new(plugins),
            externals: Externals::new(&settings.externals),
            sonars: Sonars::default(),
            monitor: Monitor::new(envelope),
            settings,
        }
    }

    /// What the vehicle may do next, as far as core can know.
    pub(crate) const fn outlook(&self) -> Outlook<'_> {
        Outlook {
            now: self.now,
            stamper: &self.stamper,
            vehicle: &self.vehicle,
            monitor: &self.monitor,
            arbiter: &self.arbiter,
            identifiers: &self.identifiers,
            ledger: &self.ledger,
        }
    }

    pub(crate) fn note(&mut self, note: Note) {
        self.outbox.note(note);
    }

    /// As [`Context::note`], for what the vehicle has said: so many a second; the rest is only counted.
    pub(crate) fn note_of_vehicle(&mut self, note: Note) {
        self.outbox.note_of_vehicle(self.now, note);
    }

    /// Our UTC now, by the clock of the start: for stamps, and for what core measures with them.
    pub(crate) fn utc(&self) -> Utc {
        self.stamper.utc(self.now)
    }

    /// Our UTC at a time, by the computer's clock as it is set now: for zones that are valid for a limited time.
    pub(crate) fn zone_utc(&self, at: Timestamp) -> Utc {
        self.stamper.zone_utc(at)
    }

    pub(crate) fn heard(&mut self, created: TimeOfDay) {
        let utc = self.utc();
        self.vehicle.navigation.heard(self.now, utc, created);
        self.vehicle.latest.hear(self.now, created);
    }

    /// Converts a time on the vehicle's clock to ours; never later than now.
    pub(crate) fn when(&self, written: TimeOfDay) -> Timestamp {
        let age = self.vehicle.navigation.clock().age(self.now, self.utc(), written);
        self.now - age.unwrap_or_default()
    }

    /// What the gate needs to decide whether a message may be sent.
    fn gate(&self, message: &ToVehicle) -> Gate<'_> {
        let is_own =
            |identifier| self.identifiers.is_ours(identifier) || self.vehicle.previous_run.includes(identifier);
        Gate {
            now: self.now,
            is_up: self.link.is_up(),
            is_armed: self.control.armed,
            has_control: self.lost_because().is_none(),
            may_start_mission: !self.control.held && !self.control.stopping && self.vehicle.phase == Phase::Over,
            is_own_insert: matches!(message, ToVehicle::CancelBehavior(cancel) if is_own(cancel.identifier)),
            permits: &self.monitor.permits,
            speed_default_mps: self.monitor.limits().speed_default_mps(),
        }
    }
}

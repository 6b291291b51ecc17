use std::collections::VecDeque;
use std::sync::Arc;

use backseat_units::Timestamp;

use crate::arbiter::Arbiter;
use crate::conductor::Slot;
use crate::control::Control;
use crate::drivers::Drivers;
use crate::envelope::Envelope;
use crate::identifiers::Identifiers;
use crate::io::Start;
use crate::ledger::Ledger;
use crate::link::Link;
use crate::monitor::Monitor;
use crate::outbox::Outbox;
use crate::plugin::{PluginFault, PluginId};
use crate::settings::{PluginSetup, Settings};
use crate::stamp::Stamper;
use crate::subscriptions::Subscriptions;
use crate::switches::{Check, is_on};
use crate::timer::Timers;
use crate::vehicle::Vehicle;

/// What every capability is given, and never `Core`: the time, what is known of the vehicle, the monitor, the ledger and
/// the ways out.
pub(crate) struct Context {
    pub(crate) now: Timestamp,
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
    pub(crate) plugins: Vec<Slot>,
    /// Plugins that have failed while something else was being done, which is finished first.
    pub(crate) failures: VecDeque<(PluginId, PluginFault)>,
    pub(crate) drivers: Drivers,
}

impl Context {
    pub(crate) fn new(settings: Settings, envelope: Arc<Envelope>, plugins: Vec<PluginSetup>, start: Start) -> Self {
        let limits = envelope.limits();
        Self {
            now: Timestamp::ZERO,
            stamper: Stamper::new(start.utc),
            vehicle: Vehicle::new(*envelope.fence().frame(), limits, start.identifiers),
            control: Control {
                armed: start.armed,
                held: start.held && is_on(Check::OperatorHold),
                ..Control::default()
            },
            link: Link::new(Subscriptions::new(&plugins), limits.link_delay_max()),
            arbiter: Arbiter::new(plugins.len()),
            identifiers: Identifiers::new(start.identifiers),
            ledger: Ledger::default(),
            outbox: Outbox::default(),
            timers: Timers::default(),
            plugins: plugins.into_iter().map(Slot::new).collect(),
            failures: VecDeque::new(),
            drivers: Drivers::new(&settings.drivers),
            monitor: Monitor::new(envelope),
            settings,
        }
    }
}

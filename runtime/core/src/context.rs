use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use backseat_spi::{BehaviorId, Framer, Policy};
use backseat_units::Timestamp;

use crate::arbiter::Arbiter;
use crate::budget::LineBudget;
use crate::commands::Commands;
use crate::conductor::Slot;
use crate::course::Courses;
use crate::dive::Dive;
use crate::drivers::Drivers;
use crate::envelope::{Envelope, Suspended};
use crate::expected::Compared;
use crate::former::Former;
use crate::gate::Permits;
use crate::heartbeat::Heartbeat;
use crate::hull::Track;
use crate::io::{Output, Start};
use crate::ledger::Ledger;
use crate::named_insert::NamedInsert;
use crate::navigation::Tracker;
use crate::phase::Phase;
use crate::plan::Plan;
use crate::plugin::{CartesianSample, PluginFault, PluginId, RelativeSample};
use crate::quota::LastMinute;
use crate::session::Session;
use crate::settings::{PluginSetup, Settings};
use crate::stamp::Stamper;
use crate::switches::{Check, is_on};
use crate::timer::Timers;

/// What every capability is given, and never `Core`: the time, what is known of the vehicle, the monitor, the ledger and
/// the ways out.
pub(crate) struct Context {
    pub(crate) settings: Settings,
    pub(crate) envelope: Arc<Envelope>,
    pub(crate) now: Timestamp,
    pub(crate) outputs: VecDeque<Output>,
    pub(crate) timers: Timers,
    pub(crate) framer: Framer,
    pub(crate) stamper: Stamper,
    pub(crate) session: Session,
    pub(crate) commands: Commands,
    pub(crate) heartbeat: Heartbeat,
    pub(crate) tracker: Tracker,
    pub(crate) plan: Plan,
    pub(crate) dive: Dive,
    /// When the vehicle's words have had us ask for its plan.
    pub(crate) plan_asks: LastMinute,
    pub(crate) compared: Compared,
    pub(crate) ledger: Ledger,
    pub(crate) plugins: Vec<Slot>,
    pub(crate) start: Start,
    /// By how much our computer's clock was set since then, nanoseconds.
    pub(crate) utc_set_nanos: i64,
    /// Backseat control as the configured hook last said.
    pub(crate) handed_over: Option<bool>,
    /// BFMIS begins with `Running`.
    pub(crate) running: Option<bool>,
    pub(crate) held: bool,
    pub(crate) stopping: bool,
    pub(crate) granted: bool,
    /// Lines about what the vehicle says.
    pub(crate) vehicle_lines: LineBudget,
    pub(crate) inserts_sent: u32,
    pub(crate) gps_hits_sent: u32,
    /// Of this process; the mission caps their number.
    pub(crate) sent_identifiers: BTreeSet<BehaviorId>,
    pub(crate) reserve_asked: Option<Timestamp>,
    pub(crate) former: Former,
    pub(crate) courses: Courses,
    pub(crate) drivers: Drivers,
    /// The insert that is flown, as the vehicle names it.
    pub(crate) named_insert: NamedInsert,
    /// How far the vehicle's mission is.
    pub(crate) phase: Phase,
    /// The operator has ended the mission: whatever comes of the order, plugins steer no more until the mission is over or
    /// the operator releases them.
    pub(crate) mission_ended: bool,
    /// The vehicle is outside the fence because of us: no plugin's request is accepted.
    pub(crate) recovering: bool,
    /// Where the mission was suspended by station keeping that is over: it may not have gone on yet, for the vehicle may
    /// return there first, and one that is suspended meanwhile stands where it stood (8.3).
    pub(crate) suspended: Vec<Suspended>,
    /// A plugin counts on the vehicle's silence.
    pub(crate) silent: bool,
    pub(crate) permits: Permits,
    pub(crate) arbiter: Arbiter,
    pub(crate) relative: Track<RelativeSample>,
    pub(crate) cartesian: Track<CartesianSample>,
    /// Plugins that have failed while something else was being done, which is finished first.
    pub(crate) failures: VecDeque<(PluginId, PluginFault)>,
}

impl Context {
    pub(crate) fn new(settings: Settings, envelope: Arc<Envelope>, plugins: Vec<PluginSetup>, start: Start) -> Self {
        let slots: Vec<Slot> = plugins.into_iter().map(Slot::new).collect();
        let hull = envelope.limits().hull.as_ref();
        Self {
            now: Timestamp::ZERO,
            outputs: VecDeque::new(),
            timers: Timers::default(),
            framer: Framer::new(Policy::FromVehicle),
            stamper: Stamper::new(start.utc),
            session: Session::new(&slots),
            commands: Commands::default(),
            heartbeat: Heartbeat::new(envelope.limits().link_delay_max()),
            tracker: Tracker::new(*envelope.fence().frame(), envelope.limits()),
            plan: Plan::default(),
            dive: Dive::default(),
            plan_asks: LastMinute::default(),
            compared: Compared::default(),
            ledger: Ledger::default(),
            start,
            utc_set_nanos: 0,
            handed_over: None,
            running: None,
            held: start.held && is_on(Check::OperatorHold),
            stopping: false,
            granted: false,
            vehicle_lines: LineBudget::default(),
            inserts_sent: start.identifiers.map_or(0, |identifiers| identifiers.inserts),
            gps_hits_sent: start.identifiers.map_or(0, |identifiers| identifiers.gps_hits),
            sent_identifiers: BTreeSet::new(),
            reserve_asked: None,
            former: Former::new(start.identifiers),
            courses: Courses::default(),
            drivers: Drivers::new(&settings.drivers),
            failures: VecDeque::new(),
            named_insert: NamedInsert::default(),
            phase: Phase::default(),
            mission_ended: false,
            recovering: false,
            suspended: Vec::new(),
            silent: false,
            permits: Permits::default(),
            arbiter: Arbiter::new(slots.len()),
            relative: Track::new(envelope.limits(), hull.is_some_and(|hull| hull.hull_box.is_some())),
            cartesian: Track::new(envelope.limits(), hull.is_some_and(|hull| hull.bottom_box.is_some())),
            settings,
            plugins: slots,
            envelope,
        }
    }
}

mod answer;
mod behavior;
mod connection;
mod course;
mod external;
mod hear;
mod navigation;
mod request;
mod samples;
mod step;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use backseat_units::Timestamp;

use crate::capability::Capabilities;
use crate::context::Context;
use crate::ended::EndCause;
use crate::io::{Input, Note, Output, Reservation, Start};
use crate::ledger::RequestCounts;
use crate::monitor::envelope::{Envelope, LeaseReach};
use crate::mutations::{Check, is_on};
use crate::operator::Orders;
use crate::plugin::Event;
use crate::recovery::Whereabouts;
use crate::refusal::Uncontrolled;
use crate::session::Session;
use crate::session::commands::Answer;
use crate::settings::{PluginSetup, Settings};
use crate::timer::Timer;

/// If core is called later than this after the time of [`Core::poll_timeout`], it ends every lease before it does
/// anything else: what it knows of the vehicle is old, and so is what the vehicle knows of us.
const LATE: Duration = Duration::from_millis(500);

/// The backseat's state machine.
///
/// Hand it what happens with [`Core::handle`], then drain [`Core::poll_output`] until it is empty, then call again at
/// [`Core::poll_timeout`] or when something happens, whichever is first.
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub struct Core {
    cx: Context,
    capabilities: Capabilities,
    orders: Orders,
    session: Session,
    late_count: u64,
    /// The flaw of navigation that was last reported, and when.
    flaw_told: Option<(EndCause, Timestamp)>,
    whereabouts: Whereabouts,
    /// Navigation has come by which the modify and the station keeping have not been judged yet.
    unjudged: bool,
}

impl Core {
    /// A core that has received no input yet. Its first output asks for a connection.
    #[must_use]
    pub fn new(settings: Settings, envelope: Arc<Envelope>, plugins: Vec<PluginSetup>, start: Start) -> Self {
        let mut core = Self {
            session: Session::new(start.jitter),
            cx: Context::new(settings, envelope, plugins, start),
            capabilities: Capabilities::new(),
            orders: Orders::default(),
            late_count: 0,
            flaw_told: None,
            whereabouts: Whereabouts::default(),
            unjudged: false,
        };
        core.cx.outbox.push(Output::Connect { after: Duration::ZERO });
        core.cx.reserve();
        core.settle();
        core
    }

    /// Handles something that has happened. If `now` is earlier than at the last call, core takes the last call's.
    pub fn handle(&mut self, now: Timestamp, input: Input<'_>) {
        let promised = self.cx.timers.next();
        self.cx.now = self.cx.now.max(now);
        if let Some(promised) = promised
            && self.cx.now.since(promised) > LATE
            && is_on(Check::LateWake)
        {
            self.late_count += 1;
            self.cx.note(Note::Late {
                seconds: self.cx.now.since(promised).as_secs_f64(),
            });
            self.capabilities.end_leases(&mut self.cx, EndCause::WokeLate);
        }
        self.lose_what_has_lapsed();
        match input {
            Input::LinkUp => self.link_up(),
            Input::LinkDown => self.link_down(),
            Input::Received(bytes) => self.receive(bytes),
            Input::Returned(plugin, returned) => self.returned(plugin, returned),
            Input::Restarted(plugin, restarted) => self.restarted(plugin, restarted),
            Input::Swap(plugin, version) => self.swap(plugin, version),
            Input::Operator(act) => self.orders.act(&mut self.cx, &mut self.capabilities, act),
            Input::External(source, bytes) => external::received(&mut self.cx, &mut self.capabilities, source, bytes),
            Input::Sonar(report) => self.capabilities.sonar.reported(&mut self.cx, report),
            Input::Reserved(reservation) => self.cx.identifiers.reserved(reservation),
            Input::UtcSet(by_nanos) => self.utc_set(by_nanos),
            Input::Timeout => {}
        }
        self.fail_plugins();
        while let Some(timer) = self.cx.timers.expired(self.cx.now) {
            self.expired(timer);
            self.fail_plugins();
        }
        self.settle();
    }

    /// The next thing that the driver has to do, oldest first; `None` if there is nothing until the next input.
    #[must_use]
    pub fn poll_output(&mut self) -> Option<Output> {
        self.cx.outbox.pop()
    }

    /// When to call [`Core::handle`] with [`Input::Timeout`] if nothing happens before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Timestamp> {
        self.cx.timers.next()
    }

    /// How many requests have reached which state.
    #[must_use]
    pub fn request_counts(&self) -> RequestCounts {
        self.cx.ledger.counts()
    }

    /// Why no request can be sent now; `None` if control is ours.
    #[must_use]
    pub fn uncontrolled(&self) -> Option<Uncontrolled> {
        if self.has_control() {
            return None;
        }
        // Control is judged anew at the next input. Until then a reason may be gone that still holds.
        Some(self.cx.lost_because().unwrap_or(Uncontrolled::NavigationUnsteady))
    }

    /// Whether requests can be sent now.
    #[must_use]
    pub const fn has_control(&self) -> bool {
        self.cx.control.granted
    }

    /// The newest navigation, however old.
    #[must_use]
    pub fn navigation(&self) -> Option<&crate::plugin::NavigationSample> {
        self.cx.vehicle.navigation.newest()
    }

    /// Whether a lease is active: a modify or station keeping.
    #[must_use]
    pub fn is_steering(&self) -> bool {
        self.cx.arbiter.is_steering()
    }

    /// Where the live modify can lead, as it is judged at each refresh; `None` without one, or without fresh navigation.
    #[must_use]
    pub fn reach(&self) -> Option<LeaseReach> {
        self.capabilities.modify.reach(&self.cx)
    }

    /// How many requests have not ended.
    #[must_use]
    pub fn open_requests(&self) -> usize {
        self.cx.ledger.iter().count()
    }

    /// The requests that have not ended, each in words.
    #[must_use]
    pub fn open_request_states(&self) -> Vec<String> {
        self.cx
            .ledger
            .iter()
            .map(|(request, entry)| format!("{:?} {request} is {:?}", entry.kind, entry.state))
            .collect()
    }

    /// How much of the reservations was used. After an orderly end, the next process continues from there. `None` if
    /// nothing was reserved.
    #[must_use]
    pub fn used(&self) -> Option<Reservation> {
        self.cx.identifiers.used()
    }

    /// How often core was called more than half a second late.
    #[must_use]
    pub const fn late_count(&self) -> u64 {
        self.late_count
    }

    /// This computer's clock was set. Stamps stay on the clock of the start, because answers would otherwise seem to
    /// come from another time. Zones that are valid for a limited time follow the new clock.
    fn utc_set(&mut self, by_nanos: i64) {
        let step_s = self.cx.stamper.set(by_nanos);
        self.cx.note(Note::Text {
            text: format!("this computer's clock was set by {step_s:+.3} s: zones with times follow it"),
        });
        self.capabilities.inserts.judge_waiting(&mut self.cx);
        self.unjudged = true;
    }

    /// Updates what follows from the state: control, the inserts that wait, and the timers.
    fn settle(&mut self) {
        self.settle_control();
        self.follow_navigation();
        self.settle_waiting();
        self.orders.watch_staleness(&mut self.cx);
        let navigation = match self.cx.vehicle.navigation.stale_at().filter(|at| *at > self.cx.now) {
            Some(stale) if self.cx.vehicle.navigation.steady(self.cx.now) => Some(stale),
            Some(stale) => Some(stale.min(self.cx.now + Duration::from_millis(500))),
            None => None,
        };
        self.cx.timers.set_or_stop(Timer::Navigation, navigation);
        self.cx
            .timers
            .set_or_stop(Timer::Acknowledgement, self.cx.link.commands.next_deadline());
        self.session.settle_heartbeat(&mut self.cx);
        // A step that was due while its plugin was busy or away is due now. With a time in the past, core would find
        // itself called late.
        let plugins = self.cx.plugins.wakes_at().map(|due| due.max(self.cx.now));
        self.cx.timers.set_or_stop(Timer::Plugins, plugins);
    }

    /// Core may be called somewhat late, and with an input that brings new navigation. What has lapsed by now is lost
    /// before that input is handled, as if core had been called in time (safety requirement 008). Nothing is gained
    /// here: the input may be what takes control away.
    fn lose_what_has_lapsed(&mut self) {
        self.unsettle_stale_navigation();
        if self.cx.control.granted {
            self.settle_control();
        }
    }

    fn unsettle_stale_navigation(&mut self) {
        if self.cx.vehicle.navigation.fresh(self.cx.now).is_none() {
            self.cx.vehicle.navigation.unsettle();
        }
    }

    /// Gains or loses control by what core knows now. Reports the change, and ends what needs control if control is
    /// lost.
    pub(crate) fn settle_control(&mut self) {
        self.unsettle_stale_navigation();
        let lost = self.cx.lost_because();
        let granted = lost.is_none();
        if granted != self.cx.control.granted {
            self.cx.control.granted = granted;
            if let Some(reason) = lost
                && is_on(Check::ControlLossEndsLease)
            {
                self.capabilities.end_controlled(&mut self.cx, reason);
            }
            if granted {
                self.capabilities.station.control_granted(&mut self.cx);
            }
            self.session.tell_of_control(&mut self.cx, lost);
            self.cx.plugins.tell_all(&Event::Control(granted));
            self.fail_plugins();
        }
    }

    fn expired(&mut self, timer: Timer) {
        match timer {
            Timer::Refresh => self.capabilities.modify.refresh(&mut self.cx),
            Timer::Term => self.capabilities.modify.end(&mut self.cx, EndCause::TermOver),
            // `settle` acts on the age of navigation.
            Timer::Navigation => {}
            Timer::Acknowledgement => {
                while let Some(command) = self.cx.link.commands.late(self.cx.now) {
                    self.answered(command, Answer::Missing, false);
                }
            }
            Timer::Silence => self.session.silence(&mut self.cx),
            Timer::Plan => self.session.ask_for_plan(&mut self.cx),
            Timer::Status => self.session.beat(&mut self.cx),
            // `settle` handles what waits.
            Timer::Irrevocable => {}
            // `settle` takes control away if no recent round trip is left.
            Timer::Heartbeat => self.session.remedy(&mut self.cx),
            Timer::StationTerm => self.capabilities.station.end(&mut self.cx, EndCause::TermOver),
            Timer::Station => self.capabilities.station.refresh(&mut self.cx),
            Timer::Relative => self.capabilities.station.timed_out(&mut self.cx),
            Timer::Silent => self.capabilities.silent.timed_out(&mut self.cx),
            Timer::Adjustment => self.capabilities.adjustments.timed_out(&mut self.cx),
            Timer::Acoustic => self.capabilities.acoustic.timed_out(&mut self.cx),
            Timer::Dvl => self.capabilities.dvl.timed_out(&mut self.cx),
            Timer::Order => self.orders.timed_out(&mut self.cx),
            Timer::Policy => self.orders.policies_due(&mut self.cx, &mut self.capabilities),
            Timer::Recall => self.capabilities.inserts.recalls_timed_out(&mut self.cx),
            Timer::Recovery => self
                .whereabouts
                .climb(&mut self.cx, &mut self.capabilities, &mut self.orders),
            Timer::Sonar => self.capabilities.sonar.timed_out(&mut self.cx),
            Timer::Plugins => self.step_due(false),
            Timer::Shutdown => {
                self.cx.timers.stop_all();
                self.cx.outbox.push(Output::Finish);
            }
        }
    }
}

//! The capabilities: a type for each kind of request to the vehicle. Each has private state, and hooks through which
//! the rest of core reports answers, time, a lost link, lost control and a failed plugin.

pub(crate) mod acoustic;
pub(crate) mod adjustment;
pub(crate) mod device;
pub(crate) mod dvl;
pub(crate) mod insert;
pub(crate) mod modify;
pub(crate) mod silent;
pub(crate) mod sonar;
pub(crate) mod station;
pub(crate) mod topside;

use backseat_spi::ToVehicle;

use crate::arbiter::LeaseKind;
use crate::capability::acoustic::Acoustic;
use crate::capability::adjustment::{Adjustments, Adjusts};
use crate::capability::dvl::DvlTrigger;
use crate::capability::insert::{Admitted, Inserts};
use crate::capability::modify::Modify;
use crate::capability::silent::Silent;
use crate::capability::sonar::Sonar;
use crate::capability::station::Station;
use crate::capability::topside::Topside;
use crate::context::Context;
use crate::ended::Ended;
use crate::io::SonarOrder;
use crate::monitor::envelope::{Hover, Insert, Setpoint};
use crate::mutations::{Check, is_on};
use crate::plugin::{
    GpsHitRequest, ModifyRequest, PluginId, Refusal, Request, StationRequest, TrackcircleRequest, TracklineRequest,
};
use crate::refusal::Reason;
use crate::session::dispatch::Dispatch;

/// A request that has passed every check.
#[derive(Debug)]
pub(crate) enum Checked<'a> {
    /// A modify, with what its refreshes send.
    Modify(&'a ModifyRequest, Setpoint),
    /// Station keeping, with what it sends.
    Station(&'a StationRequest, Hover),
    /// An insert that may leave now.
    Insert(Dispatch, Insert, Admitted),
    /// An insert that may leave once the vehicle has answered, with its tag.
    Waits(u64, Insert),
    /// A request that is one command.
    Command(Dispatch),
    /// An order to the sonars.
    Sonar(SonarOrder),
}

/// All capabilities.
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Capabilities {
    pub(crate) modify: Modify,
    pub(crate) station: Station,
    pub(crate) inserts: Inserts,
    pub(crate) silent: Silent,
    pub(crate) adjustments: Adjustments,
    pub(crate) acoustic: Acoustic,
    pub(crate) dvl: DvlTrigger,
    pub(crate) topside: Topside,
    pub(crate) sonar: Sonar,
}

impl Capabilities {
    pub(crate) fn new() -> Self {
        Self {
            modify: Modify::default(),
            station: Station::new(),
            inserts: Inserts::default(),
            silent: Silent::default(),
            adjustments: Adjustments::default(),
            acoustic: Acoustic::default(),
            dvl: DvlTrigger::default(),
            topside: Topside::default(),
            sonar: Sonar::default(),
        }
    }

    /// Ends the leases: the modify and the station keeping.
    pub(crate) fn end_leases(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        let end = end.into();
        self.modify.end(cx, end.clone());
        self.station.end(cx, end);
    }

    /// Ends everything that needs control: the leases, the inserts that wait to be sent, and the triggering of the DVL.
    pub(crate) fn end_controlled(&mut self, cx: &mut Context, end: impl Into<Ended>) {
        let end = end.into();
        self.end_leases(cx, end.clone());
        // Any other end is followed by a loss of control before anything that waits can leave.
        if let Ended::Uncontrolled(reason) = end {
            self.inserts.reject_waiting(cx, reason);
        }
        self.dvl.end(cx, end);
    }

    /// The connection is lost. The caller has already ended the leases.
    pub(crate) fn link_lost(&mut self, cx: &mut Context) {
        self.station.reset();
        self.silent.link_lost(cx);
        self.adjustments.link_lost(cx);
        self.acoustic.link_lost(cx);
        self.dvl.link_lost(cx);
        self.sonar.link_lost();
    }

    /// A plugin has failed: ends its leases and its triggering of the DVL, and rejects its inserts that wait to be
    /// sent.
    pub(crate) fn plugin_failed(&mut self, cx: &mut Context, plugin: PluginId) {
        if is_on(Check::PluginFailure) {
            self.modify.plugin_failed(cx, plugin);
            self.station.plugin_failed(cx, plugin);
        }
        self.dvl.plugin_failed(cx, plugin);
        self.inserts.plugin_failed(cx, plugin);
    }

    /// Whether a plugin may steer: only one does at a time.
    ///
    /// # Errors
    /// If a plugin of higher priority steers, or during the pause after a BPRMB that the vehicle refused or did not
    /// answer.
    pub(crate) fn arbitrate(&self, cx: &Context, plugin: PluginId, asked: &Request) -> Result<(), Refusal> {
        let kind = match asked {
            Request::Modify(_) => {
                self.modify.may_begin(cx)?;
                LeaseKind::Modify
            }
            Request::Station(_) => LeaseKind::Station,
            Request::EndModify
            | Request::Trackline(_)
            | Request::Trackcircle(_)
            | Request::GpsHit(_)
            | Request::Cancel(_)
            | Request::Message(_)
            | Request::Topside(_)
            | Request::DvlTrigger(_)
            | Request::Silent(_)
            | Request::Trim(_)
            | Request::Buoyancy(_)
            | Request::Packet(_)
            | Request::EndStation
            | Request::SonarAngle(_)
            | Request::Camera(_)
            | Request::Light(_)
            | Request::SonarSet(_)
            | Request::SonarLog(_)
            | Request::Timer { .. } => return Ok(()),
        };
        cx.arbiter.arbitrate(plugin, kind)
    }

    /// Checks the state that a request needs, its figures, and its whole geometry against the fence.
    ///
    /// # Errors
    /// The first of these checks that fails.
    pub(crate) fn check<'a>(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &'a Request,
        shape: Option<Insert>,
    ) -> Result<Checked<'a>, Refusal> {
        let dispatch = match asked {
            Request::Modify(asked) => return Ok(Checked::Modify(asked, self.modify.check(cx, plugin, asked)?)),
            Request::Station(asked) => return Ok(Checked::Station(asked, self.station.check(cx, plugin, asked)?)),
            Request::Trackline(TracklineRequest { tag, .. })
            | Request::Trackcircle(TrackcircleRequest { tag, .. })
            | Request::GpsHit(GpsHitRequest { tag, .. }) => {
                let Some(insert) = shape else { return Err(not_asked()) };
                return self.check_insert(cx, plugin, *tag, request, insert);
            }
            Request::SonarSet(asked) => return Ok(Checked::Sonar(self.sonar.check_set(cx, asked)?)),
            Request::SonarLog(asked) => return Ok(Checked::Sonar(self.sonar.check_log(cx, asked)?)),
            Request::Cancel(tag) => self.inserts.check_cancel(cx, plugin, request, *tag),
            Request::Topside(asked) => self.topside.check(cx, request, asked),
            Request::DvlTrigger(asked) => self.dvl.check(cx, plugin, request, asked),
            Request::Silent(asked) => self.silent.check(cx, plugin, request, asked),
            Request::Trim(_) => self.adjustments.check(cx, request, Adjusts::Trim),
            Request::Buoyancy(_) => self.adjustments.check(cx, request, Adjusts::Buoyancy),
            Request::Packet(asked) => self.acoustic.check(cx, request, asked),
            Request::SonarAngle(asked) => device::sonar_angle(cx, request, asked),
            Request::Camera(asked) => device::camera(cx, request, asked),
            Request::Light(asked) => device::light(cx, request, asked),
            Request::EndModify | Request::EndStation | Request::Message(_) | Request::Timer { .. } => Err(not_asked()),
        };
        dispatch.map(Checked::Command)
    }

    /// Does the same for an insert: when it is requested, and again after it has waited for the vehicle's answer.
    pub(crate) fn check_insert(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        tag: u64,
        request: u64,
        insert: Insert,
    ) -> Result<Checked<'static>, Refusal> {
        let admitted = self.inserts.check(cx, plugin, tag, &insert)?;
        if self.inserts.waits_for_answer(cx, &insert) {
            return Ok(Checked::Waits(tag, insert));
        }
        let dispatch = self.inserts.dispatch(cx, request, &insert).ok_or_else(not_asked)?;
        Ok(Checked::Insert(dispatch, insert, admitted))
    }

    /// A request's command was sent.
    pub(crate) fn sent(
        &mut self,
        cx: &mut Context,
        plugin: PluginId,
        request: u64,
        asked: &Request,
        message: &ToVehicle,
    ) {
        match (asked, message) {
            (Request::Topside(_), _) => self.topside.count(cx.now),
            (Request::DvlTrigger(asked), _) => self.dvl.sent(cx, plugin, request, asked),
            (Request::Silent(asked), _) => self.silent.sent(cx, plugin, request, asked),
            (Request::Trim(_), _) => self.adjustments.sent(request, Adjusts::Trim),
            (Request::Buoyancy(_), _) => self.adjustments.sent(request, Adjusts::Buoyancy),
            (Request::Packet(_), ToVehicle::Packet(packet)) => self.acoustic.sent(cx, request, packet.request),
            _ => {}
        }
    }
}

/// The refusal of a request that is handled elsewhere, and so never reaches the check.
fn not_asked() -> Refusal {
    Reason::NotOfItsOwn.into()
}

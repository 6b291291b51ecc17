//! The way of every request that a plugin makes, from its step to the link.

use backseat_spi::{LogMessage, Text, ToVehicle};

use super::Core;
use crate::capability::Checked;
use crate::capability::insert::irrevocable::Waiting;
use crate::capability::insert::{Admitted, grant_of};
use crate::ended::EndCause;
use crate::io::Note;
use crate::ledger::RequestKind;
use crate::monitor::envelope::Insert;
use crate::monitor::limits::Grant;
use crate::mutations::{Check, is_on};
use crate::plugin::slots::TIMERS_MAX;
use crate::plugin::{DvlTriggerRequest, LogLevel, LogLine, PluginId, Refusal, Request, RequestState};
use crate::session::dispatch::Dispatch;

const MESSAGE_CHARS_MAX: usize = 200;

/// The tag and kind of a request in the ledger, and the grant that it needs.
struct Asked {
    tag: u64,
    kind: RequestKind,
    grant: Grant,
}

impl Asked {
    /// `None` for a request that has no entry in the ledger.
    fn of(request: &Request) -> Option<Self> {
        let (kind, grant) = match request {
            Request::Modify(_) => (RequestKind::Modify, Grant::Modify),
            Request::Trackline(_) => (RequestKind::Trackline, Grant::Insert),
            Request::Trackcircle(_) => (RequestKind::Trackcircle, Grant::Insert),
            Request::GpsHit(_) => (RequestKind::GpsHit, Grant::Surface),
            Request::Cancel(_) => (RequestKind::Cancel, Grant::Insert),
            Request::Topside(_) => (RequestKind::Topside, Grant::Topside),
            Request::DvlTrigger(_) => (RequestKind::DvlTrigger, Grant::Dvl),
            Request::Silent(_) => (RequestKind::Silent, Grant::Silent),
            Request::Trim(_) => (RequestKind::Trim, Grant::Trim),
            Request::Buoyancy(_) => (RequestKind::Buoyancy, Grant::Buoyancy),
            Request::Packet(_) => (RequestKind::Packet, Grant::Acoustic),
            Request::Station(_) => (RequestKind::Station, Grant::Station),
            Request::SonarAngle(_) => (RequestKind::SonarAngle, Grant::Devices),
            Request::Camera(_) => (RequestKind::Camera, Grant::Devices),
            Request::Light(_) => (RequestKind::Light, Grant::Devices),
            Request::SonarSet(_) => (RequestKind::SonarSet, Grant::Sonar),
            Request::SonarLog(_) => (RequestKind::SonarLog, Grant::Sonar),
            Request::EndModify | Request::EndStation | Request::Message(_) | Request::Timer { .. } => return None,
        };
        Some(Self {
            tag: request.tag()?,
            kind,
            grant,
        })
    }
}

impl Core {
    /// Proposes, admits, arbitrates and checks a request, and sends it through the gate; or rejects it.
    pub(super) fn ask(&mut self, plugin: PluginId, request: &Request) {
        let Some(asked) = Asked::of(request) else {
            return self.ask_aside(plugin, request);
        };
        if let Request::DvlTrigger(step) = request
            && self.capabilities.dvl.continues(&mut self.cx, plugin, step.tag)
        {
            return self.step_dvl(plugin, step);
        }
        let number = self.cx.ledger.propose(plugin, asked.tag, asked.kind);
        match self.check(plugin, number, request, asked.grant) {
            Ok(checked) => self.send(plugin, number, request, checked),
            Err(refusal) => self.cx.reject(number, refusal),
        }
    }

    fn check<'a>(
        &mut self,
        plugin: PluginId,
        number: u64,
        request: &'a Request,
        grant: Grant,
    ) -> Result<Checked<'a>, Refusal> {
        let Self { cx, capabilities, .. } = self;
        let shape = capabilities.inserts.shape(cx, request).transpose()?;
        cx.admit(plugin, grant)?;
        if shape.is_some_and(|insert| insert.interrupt) {
            cx.admit_interrupt(plugin)?;
        }
        capabilities.arbitrate(cx, plugin, request)?;
        capabilities.check(cx, plugin, number, request, shape)
    }

    fn send(&mut self, plugin: PluginId, number: u64, request: &Request, checked: Checked<'_>) {
        let Self { cx, capabilities, .. } = self;
        match checked {
            Checked::Modify(asked, setpoint) => {
                let changed = capabilities.modify.adopt(cx, plugin, number, asked, setpoint);
                // BPRES comes before BPRMB.
                capabilities.station.end(cx, EndCause::ModifyBegan);
                capabilities.modify.begin(cx, changed);
            }
            Checked::Station(asked, hover) => {
                let before = capabilities.station.adopt(cx, plugin, number, asked, hover);
                // BPEMB comes before BPSUS.
                capabilities.modify.end(cx, EndCause::StationBegan);
                capabilities.station.begin(cx, before);
            }
            Checked::Waits(tag, insert) => capabilities.inserts.wait_for_answer(cx, number, plugin, tag, insert),
            Checked::Insert(dispatch, insert, admitted) => self.send_insert(number, &dispatch, insert, admitted),
            Checked::Sonar(order) => capabilities.sonar.send(cx, number, order),
            Checked::Command(dispatch) => {
                if cx.send(number, &dispatch) {
                    capabilities.sent(cx, plugin, number, request, dispatch.message());
                    cx.transition(number, RequestState::Sent);
                }
            }
        }
    }

    fn send_insert(&mut self, number: u64, dispatch: &Dispatch, insert: Insert, admitted: Admitted) {
        let Self { cx, capabilities, .. } = self;
        if cx.send(number, dispatch) {
            capabilities.inserts.sent(cx, number, dispatch, insert, admitted);
            cx.transition(number, RequestState::Sent);
        }
    }

    /// Checks the inserts again that wait for an answer of the vehicle, if it has come, and sends them. Rejects those
    /// that have waited too long.
    pub(super) fn settle_waiting(&mut self) {
        while let Some(Waiting {
            request: number,
            plugin,
            tag,
            insert,
            ..
        }) = self.capabilities.inserts.take_answered(&self.cx)
        {
            let Self { cx, capabilities, .. } = self;
            let checked = cx
                .admit_standing(grant_of(&insert))
                .and_then(|()| capabilities.check_insert(cx, plugin, tag, number, insert));
            match checked {
                Ok(Checked::Insert(dispatch, insert, admitted)) => {
                    self.send_insert(number, &dispatch, insert, admitted)
                }
                Ok(
                    Checked::Waits(..)
                    | Checked::Modify(..)
                    | Checked::Station(..)
                    | Checked::Command(_)
                    | Checked::Sonar(_),
                ) => {}
                Err(refusal) => self.cx.reject(number, refusal),
            }
        }
        self.capabilities.inserts.reject_unanswered(&mut self.cx);
    }

    /// Handles the next step of an open DVL request. The step has no entry in the ledger, unless it is refused.
    fn step_dvl(&mut self, plugin: PluginId, asked: &DvlTriggerRequest) {
        let Self { cx, capabilities, .. } = self;
        if !asked.external && !asked.triggering {
            return capabilities.dvl.asked_end(cx);
        }
        let stepped = cx
            .admit(plugin, Grant::Dvl)
            .and_then(|()| capabilities.dvl.step(cx, asked));
        if let Err(refusal) = stepped {
            let number = cx.ledger.propose(plugin, asked.tag, RequestKind::DvlTrigger);
            cx.reject(number, refusal);
        }
    }

    /// Handles what has no entry in the ledger: the ends of leases, timers, lines for the vehicle's log.
    fn ask_aside(&mut self, plugin: PluginId, request: &Request) {
        let Self { cx, capabilities, .. } = self;
        match request {
            Request::EndModify => capabilities.modify.asked_end(cx, plugin),
            Request::EndStation => capabilities.station.asked_end(cx, plugin),
            Request::Message(text) => self.log_message(plugin, text),
            Request::Timer { id, after } => {
                if !cx.plugins.set_timer(cx.now, plugin, *id, *after) {
                    let line = LogLine {
                        level: LogLevel::Warn,
                        text: format!("a timer was dropped: {TIMERS_MAX} are set already"),
                    };
                    cx.note(Note::PluginLog { plugin, line });
                }
            }
            Request::Modify(_)
            | Request::Trackline(_)
            | Request::Trackcircle(_)
            | Request::GpsHit(_)
            | Request::Cancel(_)
            | Request::Topside(_)
            | Request::DvlTrigger(_)
            | Request::Silent(_)
            | Request::Trim(_)
            | Request::Buoyancy(_)
            | Request::Packet(_)
            | Request::Station(_)
            | Request::SonarAngle(_)
            | Request::Camera(_)
            | Request::Light(_)
            | Request::SonarSet(_)
            | Request::SonarLog(_) => {}
        }
    }

    /// Sends a line for the vehicle's log (BPMSG, SPI 7.18). Drops it if it comes too soon after the last one, and says so
    /// if the plugin lacks the grant.
    fn log_message(&mut self, plugin: PluginId, text: &str) {
        let cx = &mut self.cx;
        let in_time = cx.plugins.take_message(cx.now, plugin) || !is_on(Check::MessageRate);
        if !in_time {
            return;
        }
        if !cx.plugins.grants(plugin).contains(&Grant::Message) {
            let line = LogLine {
                level: LogLevel::Warn,
                text: format!(
                    "a line for the vehicle's log was dropped: {}",
                    Refusal::NotGranted(Grant::Message)
                ),
            };
            return cx.note(Note::PluginLog { plugin, line });
        }
        let created = cx.stamper.stamp(cx.now, "MSG");
        let cut: String = text.chars().take(MESSAGE_CHARS_MAX).collect();
        // In lower case, because some vehicles take a sentence for another one if its text contains that one's name.
        let text = Text::cleaned(&cut.to_lowercase());
        let command = cx.courtesy("MSG", Some(created));
        cx.transmit(&ToVehicle::LogMessage(LogMessage { created, text }), Some(command));
    }
}

//! The vehicle's speed limit, which outlives station keeping and connections (BPSPD, SPI 8.4).

use backseat_spi::{HullSpeedLimit, ToVehicle};

use super::Station;
use crate::context::Context;
use crate::io::Note;
use crate::session::commands::{Answer, Command, Purpose};

/// What core knows of the vehicle's speed limit (BPSPD), which outlives station keeping and connections.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(super) struct SpeedLimit {
    /// The limit, if the vehicle has acknowledged it and nothing was sent since.
    pub(super) known_mps: Option<f64>,
    /// The limit may not be the vehicle's own.
    pub(super) changed: bool,
    /// The request at whose end core asked for the vehicle's own limit again, until that is answered.
    pub(super) restoring: Option<u64>,
}

impl Station {
    /// Gives the vehicle its own speed limit back if station keeping has changed it.
    pub(super) fn restore_speed(&mut self, cx: &mut Context, request: u64) {
        if !self.limit.changed {
            return;
        }
        let Some(speed_mps) = cx.monitor.limits().speed_default_mps() else {
            return;
        };
        let created = cx.stamper.stamp(cx.now, "SPD");
        let command = Command {
            purpose: Purpose::SpeedRestored(request),
            ..cx.courtesy("SPD", Some(created))
        };
        let limit = ToVehicle::HullSpeedLimit(HullSpeedLimit { created, speed_mps });
        if cx.transmit(&limit, Some(command)) {
            self.limit.known_mps = None;
            self.limit.restoring = Some(request);
        }
    }

    /// Control was gained. Restores a limit that station keeping left changed because the link was lost. Core does not
    /// do this earlier: without control nothing moves by the limit, and little may be sent (safety requirement 014).
    pub(crate) fn control_granted(&mut self, cx: &mut Context) {
        if self.keeping.is_none() && self.limit.restoring.is_none() {
            self.restore_speed(cx, 0);
        }
    }

    pub(crate) fn speed_restored(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        if self.limit.restoring != Some(request) {
            return;
        }
        match answer {
            Answer::Pending => return,
            Answer::Done => {
                self.limit = SpeedLimit {
                    known_mps: cx.monitor.limits().speed_default_mps(),
                    ..SpeedLimit::default()
                };
            }
            // The limit stays changed. The next end of station keeping, and the next gain of control, try again.
            Answer::Refused(_) | Answer::Missing => cx.note(Note::Text {
                text: "the vehicle did not accept its own speed limit again (BPSPD)".to_owned(),
            }),
        }
        self.limit.restoring = None;
    }
}

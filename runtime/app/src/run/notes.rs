//! What the operator's screen shows of core's notes.

use backseat_core::plugin::PluginId;
use backseat_core::refusal::Uncontrolled;
use backseat_core::{Note, Operator, RequestKind};
use backseat_units::Timestamp;
use tracing::{debug, info, warn};

use super::driver::Driver;

/// Clocks that are further apart are worth a warning: zones with a time window are then closed (`monitor::envelope`).
const CLOCKS_APART_S: f64 = 60.0;
/// Core's words for a vehicle's clock that was set.
const CLOCK_SET: &str = "the vehicle's clock was set";
/// How core's texts begin that somebody should see who reads warnings alone.
const WORTH_A_LOOK: [&str; 4] = [
    CLOCK_SET,
    "the vehicle shuts our power off",
    "the vehicle does not answer within",
    "navigation jumped",
];

impl Driver {
    fn swap_ended(&mut self, plugin: PluginId, failed: Option<&str>) {
        if let Some(swaps) = &mut self.swaps {
            swaps.ended(plugin, &self.names[plugin.0], failed);
        }
    }

    pub(super) fn tell(&mut self, now: Timestamp, note: &Note) {
        let lost = self.helm.noted(now, note);
        if let Note::PluginSwapped { plugin } = note {
            self.swap_ended(*plugin, None);
        } else if let Note::PluginNotSwapped { plugin, text } = note {
            self.swap_ended(*plugin, Some(text));
        }
        if let Note::LeaseEnded { .. } = note {
            self.steering = None;
        }
        let told = note.describe(&self.names);
        match note {
            Note::LinkDown { retry_s, .. } => match self.link_lost.take() {
                Some(why) => warn!("{why}; next attempt in {retry_s:.1} s"),
                None => warn!("{told}"),
            },
            Note::PluginFailed { .. }
            | Note::PluginNotSwapped { .. }
            | Note::Recovery { .. }
            | Note::Late { .. }
            | Note::Malformed { .. } => {
                warn!("{told}");
            }
            Note::Clock { offset_s, .. } if offset_s.abs() >= CLOCKS_APART_S && !self.rate.is_off() => {
                warn!("{told}: set the clock of this computer");
            }
            // One line says that the clock runs at another rate; another one each second says no more.
            Note::Clock { .. } if self.rate.is_off() => {}
            Note::Text { text } | Note::Navigation { text } if self.rate.is_off() && text.starts_with(CLOCK_SET) => {}
            Note::Text { text } | Note::Navigation { text }
                if WORTH_A_LOOK.iter().any(|begin| text.starts_with(begin)) =>
            {
                warn!("{told}");
            }
            Note::Clock { .. } => info!("{told}"),
            Note::Control {
                granted: false,
                reason: Some(_),
            } => {
                if let Some(line) = lost {
                    warn!("{line}");
                }
            }
            Note::Request(transition) => {
                use backseat_core::plugin::{EndKind, RequestState};
                if matches!(transition.kind, RequestKind::Modify)
                    && matches!(transition.state, RequestState::Accepted | RequestState::Unknown)
                    && let Some(plugin) = transition.owner.plugin()
                    && self.steering.replace(plugin) != Some(plugin)
                {
                    info!("{} steers", self.names[plugin.0]);
                }
                match &transition.state {
                    // A plugin that repeats a refused request is reported once.
                    RequestState::Rejected(refusal) => {
                        let kind = Some((refusal.rule(), refusal.summary()));
                        if self.last_refusal != kind {
                            self.last_refusal = kind;
                            warn!("{told}");
                        }
                    }
                    RequestState::Ended(ended) if ended.kind() == EndKind::Replaced => {}
                    RequestState::Sent | RequestState::Pending => {}
                    RequestState::Accepted if transition.identifier.is_none() => {}
                    RequestState::Accepted
                    | RequestState::Failed(_)
                    | RequestState::TimedOut
                    | RequestState::Unknown
                    | RequestState::Started
                    | RequestState::Ended(_)
                    | RequestState::Cancelled => info!("{told}"),
                }
            }
            Note::LinkUp
            | Note::VehicleVersion { .. }
            | Note::Mission { .. }
            | Note::Control { .. }
            | Note::LeaseEnded { .. }
            | Note::Plan { .. }
            | Note::Behavior { .. }
            | Note::Navigation { .. }
            | Note::PluginRestarted { .. }
            | Note::PluginSwap { .. }
            | Note::PluginSwapped { .. }
            | Note::PluginLog { .. }
            | Note::Sonar { .. } => info!("{told}"),
            Note::Operator { act } => match act {
                Operator::Hold => warn!("operator: hold"),
                Operator::Release => info!("operator: release"),
                Operator::Stop => info!("operator: stop"),
                Operator::Order(order) => info!("operator: {order}"),
            },
            Note::PluginMeasure { .. } => debug!("{told}"),
            Note::Text { text } if text.starts_with(Uncontrolled::PlanDiffers.text()) => warn!("{told}"),
            Note::Text { .. } => info!("{told}"),
        }
    }
}

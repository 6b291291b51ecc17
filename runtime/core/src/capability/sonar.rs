//! The sonars: requests to their payload controller, what it reports, and what it is told of the vehicle.
//!
//! The sonars do not steer, so a request needs neither control nor navigation, only its grant, its rate, and a
//! connection to the payload controller. The client of the controller decides on the outcome. Core waits a minute for
//! it, in case that the client is gone.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_spi::{SoundVelocity, VelocityAndRates};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::ended::{EndCause, Failure};
use crate::io::{FromSonar, Note, Output, SonarOrder, SonarOutcome, SonarRates, ToSonar};
use crate::plugin::{
    Event, NavigationSample, PluginId, Refusal, RequestState, SonarEvent, SonarLogRequest, SonarPing, SonarSetRequest,
    SonarSetting, Topic,
};
use crate::refusal::{Figure, Reason};
use crate::timer::Timer;

/// The client gives each request its outcome well before this with the settings that a mission has by default.
const OUTCOME_WITHIN: Duration = Duration::from_secs(60);
/// How many requests may be open at once: as many as the client keeps.
const OPEN_MAX: usize = 32;
/// Ranges, in metres, and periods, in milliseconds, that the format can write.
const FIGURE_MAX: f64 = 1e6;

/// The requests to the sonars, and what they have not been told yet.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Sonar {
    /// The requests without an outcome, and when each times out.
    open: BTreeMap<u64, Timestamp>,
    /// A solution that the controller has not been told yet, because its velocities have not come.
    untold: Option<NavigationSample>,
}

impl Sonar {
    /// Checks a request for a setting and returns the order.
    pub(crate) fn check_set(&self, cx: &Context, asked: &SonarSetRequest) -> Result<SonarOrder, Refusal> {
        self.may_ask(cx)?;
        let sensors = cx.settings.sonar.as_ref().map(|sonar| &sonar.sensors);
        if !sensors.is_some_and(|sensors| sensors.contains(&asked.sensor)) {
            return Err(Reason::SensorUnknown.into());
        }
        let positive = |figure: Figure, value: f64| {
            if value > 0.0 && value < FIGURE_MAX {
                Ok(())
            } else {
                Err(figure.not_within(value, 0.0, FIGURE_MAX))
            }
        };
        match asked.setting {
            SonarSetting::RangeM(range_m) => positive(Figure::SonarRange, range_m)?,
            SonarSetting::PeriodMs(period_ms) => positive(Figure::SonarPeriod, period_ms)?,
            SonarSetting::PowerPercent(percent) if !(0.0..=100.0).contains(&percent) => {
                return Err(Figure::SonarPower.not_within(percent, 0.0, 100.0));
            }
            SonarSetting::PowerPercent(_)
            | SonarSetting::Pulse(_)
            | SonarSetting::Ping(_)
            | SonarSetting::Gain(_)
            | SonarSetting::DefaultState => {}
        }
        Ok(SonarOrder::Set {
            sensor: asked.sensor,
            setting: asked.setting.clone(),
        })
    }

    /// Checks a request for the log and returns the order.
    pub(crate) fn check_log(&self, cx: &Context, asked: &SonarLogRequest) -> Result<SonarOrder, Refusal> {
        self.may_ask(cx)?;
        Ok(SonarOrder::Log {
            on: asked.on,
            file: asked.file.clone(),
        })
    }

    fn may_ask(&self, cx: &Context) -> Result<(), Refusal> {
        if cx.settings.sonar.is_none() {
            return Err(Reason::NoSonar.into());
        }
        if cx.control.stopping {
            return Err(Reason::PowerGoing.into());
        }
        if !cx.sonars.ready {
            return Err(Reason::SonarNotReady.into());
        }
        if self.open.len() >= OPEN_MAX {
            return Err(Reason::SonarBusy.into());
        }
        Ok(())
    }

    /// Passes a request on to the client.
    pub(crate) fn send(&mut self, cx: &mut Context, request: u64, order: SonarOrder) {
        self.open.insert(request, cx.now + OUTCOME_WITHIN);
        cx.timers.set_unless_set(Timer::Sonar, cx.now + OUTCOME_WITHIN);
        cx.outbox.push(Output::Sonar(ToSonar::Order { request, order }));
        cx.transition(request, RequestState::Sent);
    }

    /// Handles what the client reports.
    pub(crate) fn reported(&mut self, cx: &mut Context, report: FromSonar) {
        match report {
            FromSonar::Ping(plugin, ping) => pinged(cx, plugin, ping),
            FromSonar::Event(event) => {
                if let SonarEvent::Ready(ready) = event {
                    cx.sonars.ready = ready;
                }
                cx.plugins.tell_wanting(Topic::Sonar, &Event::Sonar(event));
            }
            FromSonar::Outcome { request, outcome } => self.ended(cx, request, outcome),
            FromSonar::Status { text, conditions } => cx.sonars.report(text, conditions),
            FromSonar::Line(text) => cx.note(Note::Sonar { text }),
        }
    }

    fn ended(&mut self, cx: &mut Context, request: u64, outcome: SonarOutcome) {
        if self.open.remove(&request).is_none() {
            return;
        }
        match outcome {
            SonarOutcome::Accepted => {
                cx.transition(request, RequestState::Accepted);
                cx.transition(request, RequestState::Ended(EndCause::Done.into()));
            }
            SonarOutcome::Unconfirmed => {
                cx.transition(request, RequestState::Ended(EndCause::Unconfirmed.into()));
            }
            SonarOutcome::Failed(text) => cx.transition(request, RequestState::Failed(Failure::Sonar(text))),
            SonarOutcome::TimedOut => cx.transition(request, RequestState::TimedOut),
            SonarOutcome::Lost => cx.transition(request, RequestState::Ended(EndCause::SonarLost.into())),
        }
        self.set_timer(cx);
    }

    /// The requests that have waited for too long for an outcome.
    pub(crate) fn timed_out(&mut self, cx: &mut Context) {
        let late: Vec<u64> = self
            .open
            .iter()
            .filter(|(_, until)| **until <= cx.now)
            .map(|(request, _)| *request)
            .collect();
        for request in late {
            self.open.remove(&request);
            cx.transition(request, RequestState::TimedOut);
        }
        self.set_timer(cx);
    }

    fn set_timer(&self, cx: &mut Context) {
        cx.timers.set_or_stop(Timer::Sonar, self.open.values().min().copied());
    }

    /// BFBDL, BFSDL.
    pub(crate) fn vehicle_logs(&self, cx: &mut Context, on: bool) {
        if cx.settings.sonar.as_ref().is_some_and(|sonar| sonar.log_with_vehicle) && cx.control.armed {
            cx.outbox.push(Output::Sonar(ToSonar::VehicleLogs(on)));
        }
    }

    /// BFSHT.
    pub(crate) fn shutdown(&self, cx: &mut Context) {
        if cx.settings.sonar.is_some() && cx.control.armed {
            cx.outbox.push(Output::Sonar(ToSonar::Shutdown));
        }
    }

    /// BFNVG. The controller gets it together with its BFNVR; without it if there is none before the next BFNVG.
    pub(crate) fn navigated(&mut self, cx: &mut Context) {
        if cx.settings.sonar.is_none() {
            return;
        }
        let newest = cx.vehicle.navigation.newest().copied();
        if let Some(untold) = core::mem::replace(&mut self.untold, newest) {
            cx.outbox.push(Output::Sonar(ToSonar::Navigation(untold, None)));
        }
    }

    /// The BFNVR of the newest BFNVG.
    pub(crate) fn velocity(&mut self, cx: &mut Context, message: &VelocityAndRates) {
        let newest = cx.vehicle.navigation.newest().copied();
        if let Some(sample) = self.untold.take().and(newest) {
            let rates = SonarRates {
                roll_rate_dps: message.roll_rate_dps,
                pitch_rate_dps: message.pitch_rate_dps,
            };
            cx.outbox.push(Output::Sonar(ToSonar::Navigation(sample, Some(rates))));
        }
    }

    /// The connection to the vehicle is lost: the velocities of the last solution will not come.
    pub(crate) const fn link_lost(&mut self) {
        self.untold = None;
    }

    /// BFSVS.
    pub(crate) fn sound_velocity(&self, cx: &mut Context, message: &SoundVelocity) {
        let sound_speed_mps = message.sound_velocity_mps;
        if cx.settings.sonar.is_some() && sound_speed_mps > 0.0 && sound_speed_mps < 10_000.0 {
            let measured = cx.when(message.created);
            cx.outbox.push(Output::Sonar(ToSonar::SoundSpeed {
                measured,
                sound_speed_mps,
            }));
        }
    }
}

fn pinged(cx: &mut Context, plugin: PluginId, ping: SonarPing) {
    let topic = if ping.sub_bottom {
        Topic::SubBottom
    } else {
        Topic::Sidescan
    };
    if cx.plugins.includes(plugin) && cx.plugins.wants(plugin, topic) {
        cx.plugins.tell_ping(plugin, ping);
    }
}

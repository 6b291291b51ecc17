//! `wit/v0.1.0` on the host's side: its imports, and the conversions between its types and core's.

use std::time::Duration;

use backseat_core::plugin as core;
use wasmtime::StoreContextMut;
use wasmtime::component::{Linker, WasmStr};

use crate::instance::{FENCE_FUEL, LOG_FUEL, State, TEXT_BYTES, charge, cut};

#[allow(
    missing_docs,
    unreachable_pub,
    clippy::all,
    clippy::wildcard_enum_match_arm,
    reason = "generated"
)]
pub(crate) mod bindings {
    wasmtime::component::bindgen!({ path: "../../wit/v0.1.0", world: "plugin" });
}

use bindings::backseat::plugin::fence::Breach;
use bindings::backseat::plugin::log::Level;
use bindings::backseat::plugin::types as wit;

/// What this file speaks.
pub(crate) const INTERFACE: &str = "backseat:plugin@0.1.0";
/// What a plugin may import. `types` are names only.
pub(crate) const IMPORTS: [&str; 3] = [
    "backseat:plugin/types@0.1.0",
    "backseat:plugin/log@0.1.0",
    "backseat:plugin/fence@0.1.0",
];
/// The same, for people.
pub(crate) const IMPORTS_TEXT: &str = "log and fence of backseat:plugin@0.1.0";
/// What a plugin exports.
pub(crate) const EXPORTS: [&str; 5] = ["describe", "init", "step", "snapshot", "restore"];

/// Requests of one step.
const REQUESTS: usize = 256;
/// The longest name or version in a description, bytes.
const NAME_BYTES: usize = 64;
/// The shortest step period.
const PERIOD_MIN: Duration = Duration::from_millis(20);
/// The longest step period.
const PERIOD_MAX: Duration = Duration::from_secs(60);

/// Defines the imports.
pub(crate) fn link(linker: &mut Linker<State>) -> wasmtime::Result<()> {
    linker.instance(IMPORTS[0])?;
    linker.instance(IMPORTS[1])?.func_wrap("write", write)?;
    linker.instance(IMPORTS[2])?.func_wrap("check", check)
}

/// `log.write`. The text stays in the plugin's memory until it is known to be wanted.
fn write(mut store: StoreContextMut<'_, State>, (level, text): (Level, WasmStr)) -> wasmtime::Result<()> {
    charge(&mut store, LOG_FUEL)?;
    if !store.data_mut().admit_line() {
        return Ok(());
    }
    let (line, bytes) = {
        let text = text.to_str(&store)?;
        (cut(&text).to_owned(), text.len())
    };
    charge(&mut store, bytes as u64)?;
    let level = match level {
        Level::Debug => core::LogLevel::Debug,
        Level::Info => core::LogLevel::Info,
        Level::Warn => core::LogLevel::Warn,
        Level::Error => core::LogLevel::Error,
    };
    store.data_mut().write_line(level, line);
    Ok(())
}

/// `fence.check`.
fn check(
    mut store: StoreContextMut<'_, State>,
    (request,): (wit::Request,),
) -> wasmtime::Result<(Result<f64, Breach>,)> {
    charge(&mut store, FENCE_FUEL)?;
    let state = store.data();
    let Some(step) = state.step() else {
        let text = "the fence answers only within a step".to_owned();
        return Ok((Err(Breach {
            rule: "limit".to_owned(),
            metres: 0.0,
            text,
        }),));
    };
    Ok((state
        .judge()
        .judge(&core::Request::from(request), step)
        .map_err(|refusal| Breach {
            rule: refusal.rule.to_owned(),
            metres: refusal.metres,
            text: refusal.text,
        }),))
}

/// A step's input as the guest gets it.
pub(crate) struct Input(wit::StepInput);

impl Default for Input {
    fn default() -> Self {
        Self(wit::StepInput {
            now_ns: 0,
            utc_ns: 0,
            navigation: None,
            control: false,
            events: Vec::new(),
        })
    }
}

impl Input {
    /// Takes the place of the input before, in its allocations.
    pub(crate) fn fill(&mut self, input: &core::StepInput) -> &wit::StepInput {
        self.0.now_ns = input.now.as_nanos();
        self.0.utc_ns = input.utc.as_unix_nanos();
        self.0.control = input.control;
        self.0.navigation = input.navigation.as_ref().map(|sample| navigation(sample, input));
        self.0.events.clear();
        self.0
            .events
            .extend(input.events.iter().map(|happened| event(happened, input)));
        &self.0
    }
}

fn navigation(sample: &core::NavigationSample, input: &core::StepInput) -> wit::Navigation {
    wit::Navigation {
        age_ns: nanos(input.now.since(sample.solution)),
        position: wit::Position {
            latitude: sample.position.latitude.as_deg(),
            longitude: sample.position.longitude.as_deg(),
        },
        east: sample.local.east_m,
        north: sample.local.north_m,
        depth: sample.depth.as_m(),
        altitude: sample.altitude.map(backseat_units::Altitude::as_m),
        heading: sample.heading.as_deg(),
        roll: sample.roll_deg,
        pitch: sample.pitch_deg,
        velocity_east: sample.east_mps,
        velocity_north: sample.north_mps,
        velocity_down: sample.down_mps,
        yaw_rate: sample.yaw_rate_dps,
        gps: sample.gps,
    }
}

fn event(happened: &core::Event, input: &core::StepInput) -> wit::Event {
    match happened {
        core::Event::Control(held) => wit::Event::Control(*held),
        core::Event::Outcome { tag, state } => wit::Event::Outcome(wit::Outcome {
            tag: *tag,
            state: state.into(),
        }),
        core::Event::Ctd(sample) => wit::Event::Ctd(wit::Ctd {
            age_ns: nanos(input.now.since(sample.measured)),
            conductivity: sample.conductivity_us_per_cm,
            temperature: sample.temperature_c,
            pressure: sample.pressure_kpa,
        }),
        core::Event::MissionCommand(text) => wit::Event::MissionCommand(text.clone()),
        core::Event::BehaviorBegan(behavior) => wit::Event::BehaviorBegan(behavior.into()),
        core::Event::BehaviorEnded(behavior) => wit::Event::BehaviorEnded(behavior.into()),
        core::Event::Timer(id) => wit::Event::Timer(*id),
        core::Event::Restored { lost_steps, open } => wit::Event::Restored(wit::Restored {
            lost_steps: *lost_steps,
            open: open.clone(),
        }),
        core::Event::Shutdown => wit::Event::Shutdown,
    }
}

impl From<&core::RequestState> for wit::State {
    fn from(state: &core::RequestState) -> Self {
        match state {
            core::RequestState::Rejected(text) => Self::Rejected(text.clone()),
            core::RequestState::Sent => Self::Sent,
            core::RequestState::Pending => Self::Pending,
            core::RequestState::Accepted => Self::Accepted,
            core::RequestState::Failed(text) => Self::Failed(text.clone()),
            core::RequestState::TimedOut => Self::TimedOut,
            core::RequestState::Unknown => Self::Unknown,
            core::RequestState::Started => Self::Started,
            core::RequestState::Ended(text) => Self::Ended(text.clone()),
            core::RequestState::Cancelled => Self::Cancelled,
        }
    }
}

impl From<&core::Behavior> for wit::Behavior {
    fn from(behavior: &core::Behavior) -> Self {
        Self {
            kind: behavior.kind.clone(),
            tag: behavior.tag,
        }
    }
}

/// A step's requests, where they are within their bounds.
pub(crate) fn requests(requests: Vec<wit::Request>) -> Result<Vec<core::Request>, core::PluginFault> {
    let too_much = |text| {
        Err(core::PluginFault {
            kind: core::FaultKind::TooMuch,
            text,
        })
    };
    if requests.len() > REQUESTS {
        return too_much(format!(
            "{} requests in a step, expected at most {REQUESTS}",
            requests.len()
        ));
    }
    for request in &requests {
        if let wit::Request::Message(text) = request
            && text.len() > TEXT_BYTES
        {
            return too_much(format!(
                "a message of {} bytes, expected at most {TEXT_BYTES}",
                text.len()
            ));
        }
    }
    Ok(requests.into_iter().map(core::Request::from).collect())
}

impl From<wit::Request> for core::Request {
    fn from(request: wit::Request) -> Self {
        match request {
            wit::Request::Modify(modify) => Self::Modify(core::ModifyRequest {
                tag: modify.tag,
                heading_deg: modify.heading,
                vertical: modify.vertical.into(),
                speed_mps: modify.speed,
                duration: Duration::from_nanos(modify.duration_ns),
            }),
            wit::Request::EndModify => Self::EndModify,
            wit::Request::Trackline(line) => Self::Trackline(core::TracklineRequest {
                tag: line.tag,
                start: line.start.into(),
                end: line.end.into(),
                vertical: line.vertical.into(),
                speed_mps: line.speed,
                interrupt: line.interrupt,
            }),
            wit::Request::Trackcircle(circle) => Self::Trackcircle(core::TrackcircleRequest {
                tag: circle.tag,
                centre: circle.centre.into(),
                radius_m: circle.radius,
                orbits: circle.orbits,
                vertical: circle.vertical.into(),
                speed_mps: circle.speed,
                entry_angle_deg: circle.entry_angle,
                interrupt: circle.interrupt,
            }),
            wit::Request::Cancel(tag) => Self::Cancel(tag),
            wit::Request::Message(text) => Self::Message(text),
            wit::Request::Timer(timer) => Self::Timer {
                id: timer.id,
                after: Duration::from_nanos(timer.after_ns),
            },
        }
    }
}

impl From<wit::Vertical> for core::VerticalRequest {
    fn from(vertical: wit::Vertical) -> Self {
        match vertical {
            wit::Vertical::Depth(metres) => Self::DepthM(metres),
            wit::Vertical::Altitude(metres) => Self::AltitudeM(metres),
        }
    }
}

impl From<wit::Position> for core::PositionRequest {
    fn from(position: wit::Position) -> Self {
        Self {
            latitude_deg: position.latitude,
            longitude_deg: position.longitude,
        }
    }
}

/// A description within its bounds, or what is out of them and what was expected.
pub(crate) fn description(described: wit::Description) -> Result<core::Description, (String, &'static str)> {
    for (what, text) in [("name", &described.name), ("version", &described.version)] {
        if text.is_empty() || text.len() > NAME_BYTES || text.chars().any(char::is_control) {
            return Err((
                format!("a {what} of {} bytes", text.len()),
                "1 to 64 bytes of printable text",
            ));
        }
    }
    let step_period = Duration::from_nanos(described.step_period_ns);
    if !(PERIOD_MIN..=PERIOD_MAX).contains(&step_period) {
        return Err((format!("a step period of {step_period:?}"), "20 ms to 60 s"));
    }
    let mut topics: Vec<core::Topic> = described
        .topics
        .into_iter()
        .map(|topic| match topic {
            wit::Topic::Ctd => core::Topic::Ctd,
            wit::Topic::MissionCommand => core::Topic::MissionCommand,
            wit::Topic::Behavior => core::Topic::Behavior,
        })
        .collect();
    topics.sort();
    topics.dedup();
    Ok(core::Description {
        name: described.name,
        version: described.version,
        step_period,
        topics,
    })
}

/// Nanoseconds of a duration between two timestamps, which always fits.
fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

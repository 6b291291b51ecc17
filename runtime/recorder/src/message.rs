//! The JSON channels' messages. Their schemas are in [`crate::Channel::schema`].

use backseat_core::plugin::{
    EndKind, NavigationSample, PluginId, Refusal, RequestState, Returned, Rule, StepInput, Version,
};
use backseat_core::{
    ExternalId, FromSonar, Input, Note, Operator, Owner, RequestKind, Reservation, Restarted, Start, ToSonar,
    Transition,
};
use serde::Serialize;

use crate::remark::Remark;

/// An input of core as logged, which can be given to core again.
#[derive(Clone, Debug, PartialEq)]
pub enum LoggedInput {
    /// The connection to the vehicle was established.
    LinkUp,
    /// The connection was lost.
    LinkDown,
    /// Bytes from the vehicle.
    Received(Vec<u8>),
    /// A plugin's step returned.
    Returned(PluginId, Returned),
    /// A plugin was restarted, or could not be.
    Restarted(PluginId, Restarted),
    /// The operator put another version in a plugin's place.
    Swap(PluginId, Version),
    /// The operator acted.
    Operator(Operator),
    /// Bytes from an external source.
    External(ExternalId, Vec<u8>),
    /// The client of the sonars reported.
    Sonar(FromSonar),
    /// Identifiers and inserts were reserved.
    Reserved(Reservation),
    /// How far the computer's clock has been set since the start in total, nanoseconds.
    UtcSet(i64),
    /// The time that core had requested was reached.
    Timeout,
}

impl LoggedInput {
    /// The input for core.
    #[must_use]
    pub fn as_input(&self) -> Input<'_> {
        match self {
            Self::LinkUp => Input::LinkUp,
            Self::LinkDown => Input::LinkDown,
            Self::Received(bytes) => Input::Received(bytes),
            Self::Returned(plugin, returned) => Input::Returned(*plugin, returned.clone()),
            Self::Restarted(plugin, restarted) => Input::Restarted(*plugin, restarted.clone()),
            Self::Swap(plugin, version) => Input::Swap(*plugin, version.clone()),
            Self::Operator(act) => Input::Operator(act.clone()),
            Self::External(external, bytes) => Input::External(*external, bytes),
            Self::Sonar(report) => Input::Sonar(report.clone()),
            Self::Reserved(reservation) => Input::Reserved(*reservation),
            Self::UtcSet(by_nanos) => Input::UtcSet(*by_nanos),
            Self::Timeout => Input::Timeout,
        }
    }
}

/// A message of `/core/input`, for writing. `timeout` and `external` are written without it.
#[derive(Serialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub(crate) enum InputRef<'a> {
    Start {
        start: &'a Start,
    },
    LinkUp,
    LinkDown,
    Returned {
        plugin: PluginId,
        returned: &'a Returned,
    },
    Restarted {
        plugin: PluginId,
        restarted: &'a Restarted,
    },
    Swap {
        plugin: PluginId,
        version: &'a Version,
    },
    Operator {
        act: &'a Operator,
    },
    Sonar {
        report: &'a FromSonar,
    },
    Reserved {
        #[serde(flatten)]
        reservation: Reservation,
    },
    UtcSet {
        by_nanos: i64,
    },
    Gap {
        since_s: f64,
        records: u64,
    },
}

/// A message of `/core/output`, for writing. `external` is written without it.
#[derive(Serialize)]
#[serde(tag = "output", rename_all = "kebab-case")]
pub(crate) enum OutputRef<'a> {
    Connect {
        after_s: f64,
    },
    ResetLink,
    Invoke {
        plugin: PluginId,
        step: &'a StepInput,
    },
    Sonar {
        order: &'a ToSonar,
    },
    Restart {
        plugin: PluginId,
    },
    Reserve {
        #[serde(flatten)]
        reservation: Reservation,
    },
    Finish,
}

/// A message of `/notes`, for writing.
#[derive(Serialize)]
pub(crate) struct NoteRef<'a> {
    /// `None` for a note that has a text of its own.
    text: Option<&'a str>,
    #[serde(flatten)]
    note: &'a Note,
}

impl<'a> NoteRef<'a> {
    pub(crate) fn new(text: &'a str, note: &'a Note) -> Self {
        let has_text = matches!(
            note,
            Note::Navigation { .. }
                | Note::Malformed { .. }
                | Note::Recovery { .. }
                | Note::Sonar { .. }
                | Note::Text { .. }
        );
        Self {
            text: (!has_text).then_some(text),
            note,
        }
    }
}

/// A message of `/notes` that is not core's, for writing.
#[derive(Serialize)]
pub(crate) struct RemarkRef<'a> {
    note: &'static str,
    text: &'a str,
    simulation: &'static str,
    plugin: Option<PluginId>,
}

impl<'a> RemarkRef<'a> {
    pub(crate) const fn new(text: &'a str, remark: Remark) -> Self {
        Self {
            note: "text",
            text,
            simulation: remark.name(),
            plugin: remark.plugin(),
        }
    }
}

/// A message of `/notes` about what somebody asked of the driver, for writing.
#[derive(Serialize)]
pub(crate) struct AskedRef<'a> {
    pub(crate) note: &'static str,
    pub(crate) text: &'a str,
}

/// A message of `/control`, for writing.
#[derive(Serialize)]
pub(crate) struct ControlRef<'a> {
    pub(crate) text: &'a str,
    pub(crate) granted: bool,
    pub(crate) reason: &'a str,
    pub(crate) cause: Option<&'static str>,
}

/// A message of `/requests`, for writing.
#[derive(Serialize)]
pub(crate) struct RequestRef<'a> {
    text: &'a str,
    request: u64,
    owner: &'static str,
    plugin: Option<PluginId>,
    external: Option<ExternalId>,
    tag: u64,
    kind: RequestKind,
    identifier: Option<u32>,
    state: &'static str,
    reason: Option<String>,
    /// The exact reason, for programs.
    why: Option<Why<'a>>,
}

/// Why a request was refused, has failed or has ended.
#[derive(Serialize)]
#[serde(untagged)]
enum Why<'a> {
    Refused {
        rule: Rule,
        cause: &'static str,
        #[serde(flatten)]
        refusal: &'a Refusal,
    },
    Failed {
        cause: &'static str,
    },
    Ended {
        kind: EndKind,
        cause: &'static str,
    },
}

impl<'a> RequestRef<'a> {
    pub(crate) fn new(text: &'a str, transition: &'a Transition) -> Self {
        let (state, reason) = described(&transition.state);
        let why = match &transition.state {
            RequestState::Rejected(refusal) => Some(Why::Refused {
                rule: refusal.rule(),
                cause: refusal.cause(),
                refusal,
            }),
            RequestState::Failed(failure) => Some(Why::Failed { cause: failure.name() }),
            RequestState::Ended(ended) => Some(Why::Ended {
                kind: ended.kind(),
                cause: ended.cause(),
            }),
            RequestState::Sent
            | RequestState::Pending
            | RequestState::Accepted
            | RequestState::TimedOut
            | RequestState::Unknown
            | RequestState::Started
            | RequestState::Cancelled => None,
        };
        let (owner, plugin, external) = match transition.owner {
            Owner::Plugin(plugin) => ("plugin", Some(plugin), None),
            Owner::Operator => ("operator", None, None),
            Owner::External(external) => ("external", None, Some(external)),
        };
        Self {
            text,
            request: transition.request,
            owner,
            plugin,
            external,
            tag: transition.tag,
            kind: transition.kind,
            identifier: transition.identifier,
            state,
            reason,
            why,
        }
    }
}

/// The name of a request's state, and why it was rejected, has failed or has ended.
#[must_use]
pub fn described(state: &RequestState) -> (&'static str, Option<String>) {
    match state {
        RequestState::Rejected(refusal) => ("rejected", Some(refusal.to_string())),
        RequestState::Sent => ("sent", None),
        RequestState::Pending => ("pending", None),
        RequestState::Accepted => ("accepted", None),
        RequestState::Failed(failure) => ("failed", Some(failure.to_string())),
        RequestState::TimedOut => ("timed-out", None),
        RequestState::Unknown => ("unknown", None),
        RequestState::Started => ("started", None),
        RequestState::Ended(ended) => ("ended", Some(ended.to_string())),
        RequestState::Cancelled => ("cancelled", None),
    }
}

/// A message of `/navigation`, for writing.
#[derive(Serialize)]
pub(crate) struct NavigationRow {
    time_s: f64,
    latitude_deg: f64,
    longitude_deg: f64,
    east_m: f64,
    north_m: f64,
    depth_m: f64,
    altitude_m: Option<f64>,
    heading_deg: f64,
    roll_deg: f64,
    pitch_deg: f64,
    east_mps: f64,
    north_mps: f64,
    down_mps: f64,
    yaw_rate_dps: f64,
    gps: bool,
}

impl From<&NavigationSample> for NavigationRow {
    fn from(sample: &NavigationSample) -> Self {
        Self {
            time_s: sample.solution.as_secs_f64(),
            latitude_deg: sample.position.latitude.as_deg(),
            longitude_deg: sample.position.longitude.as_deg(),
            east_m: sample.local.east_m,
            north_m: sample.local.north_m,
            depth_m: sample.depth.as_m(),
            altitude_m: sample.altitude.map(|altitude| altitude.as_m()),
            heading_deg: sample.heading.as_deg(),
            roll_deg: sample.roll_deg,
            pitch_deg: sample.pitch_deg,
            east_mps: sample.east_mps,
            north_mps: sample.north_mps,
            down_mps: sample.down_mps,
            yaw_rate_dps: sample.yaw_rate_dps,
            gps: sample.gps,
        }
    }
}

/// A message of `/vehicle`.
#[derive(Serialize)]
pub(crate) struct Line<'a> {
    pub(crate) text: &'a str,
}

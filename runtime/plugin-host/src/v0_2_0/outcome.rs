//! Why a request was refused, has failed or has ended, as the guest receives it.

use backseat_core::plugin as core;

use super::wit;

impl From<core::Rule> for wit::Rule {
    fn from(rule: core::Rule) -> Self {
        match rule {
            core::Rule::KeepIn => Self::KeepIn,
            core::Rule::KeepOut => Self::KeepOut,
            core::Rule::Depth => Self::Depth,
            core::Rule::Altitude => Self::Altitude,
            core::Rule::Surfacing => Self::Surfacing,
            core::Rule::Time => Self::Time,
            core::Rule::Station => Self::Station,
            core::Rule::Limit => Self::Limit,
            core::Rule::Grant => Self::Grant,
            core::Rule::Control => Self::Control,
            core::Rule::Recovery => Self::Recovery,
            core::Rule::Navigation => Self::Navigation,
            core::Rule::Plan => Self::Plan,
            core::Rule::Priority => Self::Priority,
            core::Rule::Rate => Self::Rate,
            core::Rule::Cap => Self::Cap,
            core::Rule::Tag => Self::Tag,
            core::Rule::Interrupt => Self::Interrupt,
            core::Rule::Identifier => Self::Identifier,
            core::Rule::Doubt => Self::Doubt,
            core::Rule::GpsHit => Self::GpsHit,
            core::Rule::Window => Self::Window,
            core::Rule::Text => Self::Text,
            core::Rule::Pause => Self::Pause,
            core::Rule::Heard => Self::Heard,
            core::Rule::Layout => Self::Layout,
            core::Rule::Plugin => Self::Plugin,
            core::Rule::State => Self::State,
        }
    }
}

impl From<&core::Refusal> for wit::Refusal {
    fn from(refusal: &core::Refusal) -> Self {
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let edge = refusal.edge().map(|edge| wit::Edge {
            polygon: count(edge.polygon),
            hole: edge.hole.map(count),
            number: count(edge.number),
            at: wit::Position {
                latitude: edge.latitude_deg,
                longitude: edge.longitude_deg,
            },
        });
        Self {
            rule: refusal.rule().into(),
            cause: refusal.cause().to_owned(),
            zone: refusal.zone().map(str::to_owned),
            edge,
            missing_m: refusal.missing_m(),
            value: refusal.value(),
            least: refusal.least(),
            most: refusal.most(),
            text: refusal.to_string(),
        }
    }
}

impl From<&core::Failure> for wit::Failure {
    fn from(failure: &core::Failure) -> Self {
        match failure {
            core::Failure::Vehicle(text) => Self::Vehicle(text.clone()),
            core::Failure::NotInPlan => Self::NotInPlan,
            core::Failure::Sonar(text) => Self::Sonar(text.clone()),
        }
    }
}

impl From<core::EndKind> for wit::EndKind {
    fn from(kind: core::EndKind) -> Self {
        match kind {
            core::EndKind::Done => Self::Done,
            core::EndKind::Asked => Self::Asked,
            core::EndKind::Replaced => Self::Replaced,
            core::EndKind::Term => Self::Term,
            core::EndKind::Refused => Self::Refused,
            core::EndKind::NotAnswered => Self::NotAnswered,
            core::EndKind::Late => Self::Late,
            core::EndKind::Link => Self::Link,
            core::EndKind::Control => Self::Control,
            core::EndKind::Refusal => Self::Refusal,
            core::EndKind::Fence => Self::Fence,
            core::EndKind::Navigation => Self::Navigation,
            core::EndKind::Behavior => Self::Behavior,
            core::EndKind::Mission => Self::Mission,
            core::EndKind::Plugin => Self::Plugin,
        }
    }
}

impl From<core::FrameOutcome> for wit::FrameOutcome {
    fn from(frame: core::FrameOutcome) -> Self {
        match frame {
            core::FrameOutcome::Unset => Self::Unset,
            core::FrameOutcome::Unacknowledged => Self::Unacknowledged,
            core::FrameOutcome::Acked => Self::Acked,
            core::FrameOutcome::FailedToSend => Self::FailedToSend,
            core::FrameOutcome::Other(code) => Self::Other(code),
        }
    }
}

impl From<&core::Ended> for wit::Ended {
    fn from(ended: &core::Ended) -> Self {
        Self {
            kind: ended.kind().into(),
            cause: ended.cause().to_owned(),
            frames: ended.frames().iter().copied().map(wit::FrameOutcome::from).collect(),
            text: ended.to_string(),
        }
    }
}

//! Why a request that was sent has ended, as data that ledger, log and plugins carry whole.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::refusal::{Refusal, Uncontrolled};

/// A row for each cause: its name in logs, its kind, its text.
macro_rules! causes {
    ($($cause:ident $name:literal $kind:ident $text:literal;)*) => {
        /// What has ended a request.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum EndCause {
            $(#[doc = $text] $cause,)*
        }

        impl EndCause {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$cause),*];

            /// Its name in logs and for plugins, in lower case with hyphens.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$cause => $name,)* }
            }

            /// The kind of this end.
            #[must_use]
            pub const fn kind(self) -> EndKind {
                match self { $(Self::$cause => EndKind::$kind,)* }
            }

            /// The cause in one line.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self { $(Self::$cause => $text,)* }
            }
        }
    };
}

causes! {
    Done "done" Done "done";
    Flown "flown" Done "flown";
    Queued "queued" Done "queued";
    Runs "runs" Done "it runs";
    NormalAgain "normal-again" Done "normal again";
    Completed "completed" Done "completed";
    Idle "idle" Done "the vehicle is idle";
    Reported "reported" Done "reported";
    Unconfirmed "unconfirmed" Done "sent; the payload controller does not acknowledge commands by the mission's setting";
    PluginEnded "plugin-ended" Asked "its plugin ended it";
    Replaced "replaced" Replaced "replaced";
    OtherModify "other-modify" Replaced "another modify took its place";
    OtherStation "other-station" Replaced "other station keeping took its place";
    ModifyBegan "modify-began" Replaced "a modify took its place";
    StationBegan "station-began" Replaced "station keeping took its place";
    KillOrdered "kill-ordered" Replaced "a kill took its place before it could be sent";
    TermOver "term-over" Term "its term is over";
    Lapsed "lapsed" Term "lapsed";
    VehicleRefused "vehicle-refused" Refused "the vehicle refused it";
    VehicleStopped "vehicle-stopped" Refused "the vehicle stopped it";
    NotAcknowledged "not-acknowledged" NotAnswered "the vehicle did not acknowledge it";
    NotAllowed "not-allowed" NotAnswered "the vehicle did not allow it within 300 s";
    NotStopped "not-stopped" NotAnswered "the vehicle did not stop it within 5 s";
    NotNormal "not-normal" NotAnswered "the vehicle has not said whether it is normal again";
    NotRefreshed "not-refreshed" Late "it was not refreshed in time";
    NotTriggered "not-triggered" Late "not triggered within 5 s";
    NotGoingOn "not-going-on" Late "its plugin did not confirm within 5 s that it still triggers";
    NotCeased "not-ceased" Late "the vehicle stopped it, and its plugin did not answer within 1 s";
    WokeLate "woke-late" Late "the runtime woke late";
    NotSent "not-sent" Link "it could not be sent";
    SonarLost "sonar-lost" Link "the connection to the payload controller was lost before the answer";
    PluginFailed "plugin-failed" Plugin "its plugin failed";
    NavigationJumped "navigation-jumped" Navigation "navigation jumped";
    NavigationStale "navigation-stale" Navigation "navigation is stale";
    VelocityTooHigh "velocity-too-high" Navigation "the velocity is higher than any vehicle's";
    VerticalVelocityTooHigh "vertical-velocity-too-high" Navigation "the vertical velocity is higher than any vehicle's";
    PositionFrozen "position-frozen" Navigation "the position is frozen";
    PositionAgainstVelocity "position-against-velocity" Navigation "position and velocity disagree";
    PositionTooFast "position-too-fast" Navigation "the position moves faster than any vehicle";
    DepthTooFast "depth-too-fast" Navigation "the depth changes faster than that of any vehicle";
    DepthAgainstVelocity "depth-against-velocity" Navigation "depth and vertical velocity disagree";
    HeadingAgainstYawRate "heading-against-yaw-rate" Navigation "heading and yaw rate disagree";
    SeabedJumps "seabed-jumps" Navigation "the seabed, as depth plus altitude, jumps";
    VelocitiesMissing "velocities-missing" Navigation "navigation comes without velocities";
    NavigationReset "navigation-reset" Navigation "an external source resets the vehicle's navigation";
    ClockSet "clock-set" Navigation "the vehicle's clock was set";
    OutsideFence "outside-fence" Fence "recovery: the vehicle is outside the fence";
    BehaviorBegan "behavior-began" Behavior "a behavior began during it";
    BehaviorEnded "behavior-ended" Behavior "a behavior ended during it";
    MissionGoesOn "mission-goes-on" Behavior "a behavior began: the mission goes on";
    Overtaken "overtaken" Behavior "another behavior has begun";
    Interrupted "interrupted" Behavior "interrupted and not resumed";
    OtherDive "other-dive" Mission "the vehicle flies another dive";
    MissionNotRunning "mission-not-running" Mission "the mission is not running";
    MissionOver "mission-over" Mission "the mission is over";
    MissionIs "mission-is" Mission "the mission is";
    OperatorEndsMission "operator-ends-mission" Mission "the operator ends the mission";
    EmptyMission "empty-mission" Mission "the operator starts an empty mission";
    PowerGoes "power-goes" Mission "the power is being switched off";
}

/// The kind of an end. Plugins branch on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndKind {
    /// It was completed.
    Done,
    /// Its plugin ended it.
    Asked,
    /// Another request replaced it.
    Replaced,
    /// Its term is over.
    Term,
    /// The vehicle refused it, or stopped it.
    Refused,
    /// The vehicle did not answer.
    NotAnswered,
    /// The runtime or the plugin was too late.
    Late,
    /// It could not be sent.
    Link,
    /// The backseat no longer has control.
    Control,
    /// It is no longer allowed by the fence, the limits, or the state of the vehicle or of the runtime.
    Refusal,
    /// The vehicle is outside the fence.
    Fence,
    /// Navigation is stale, has jumped, or cannot be true.
    Navigation,
    /// The vehicle has gone on to another behavior.
    Behavior,
    /// The mission has ended or was replaced.
    Mission,
    /// Its plugin failed.
    Plugin,
}

/// Why a request has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// By this cause.
    By(EndCause),
    /// By this cause, with the vehicle's words or a figure.
    Said(EndCause, String),
    /// It is no longer allowed.
    Refusal(Box<Refusal>),
    /// The backseat no longer has control.
    Uncontrolled(Uncontrolled),
    /// The vehicle has reported what happened to each frame of a packet (BFCPS, SPI 9.4).
    Frames(Vec<FrameOutcome>),
}

/// What happened to a frame of a packet (SPI 9.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameOutcome {
    /// The vehicle does not say.
    Unset,
    /// Sent, and not acknowledged.
    Unacknowledged,
    /// Sent and acknowledged by its receiver.
    Acked,
    /// Not sent.
    FailedToSend,
    /// A status that the specification does not define.
    Other(i64),
}

impl Ended {
    /// The kind of this end.
    #[must_use]
    pub const fn kind(&self) -> EndKind {
        match self {
            Self::By(cause) | Self::Said(cause, _) => cause.kind(),
            Self::Refusal(_) => EndKind::Refusal,
            Self::Uncontrolled(_) => EndKind::Control,
            Self::Frames(_) => EndKind::Done,
        }
    }

    /// The exact cause: the name of an [`EndCause`] (`term-over`), or of what refuses the request now (`keep-out`,
    /// `link-down`).
    #[must_use]
    pub fn cause(&self) -> &'static str {
        match self {
            Self::By(cause) | Self::Said(cause, _) => cause.name(),
            Self::Refusal(refusal) => refusal.cause(),
            Self::Uncontrolled(reason) => reason.name(),
            Self::Frames(_) => EndCause::Reported.name(),
        }
    }

    /// What happened to each frame of a packet.
    #[must_use]
    pub fn frames(&self) -> &[FrameOutcome] {
        match self {
            Self::Frames(frames) => frames,
            Self::By(_) | Self::Said(..) | Self::Refusal(_) | Self::Uncontrolled(_) => &[],
        }
    }
}

impl From<EndCause> for Ended {
    fn from(cause: EndCause) -> Self {
        Self::By(cause)
    }
}

impl From<Uncontrolled> for Ended {
    fn from(reason: Uncontrolled) -> Self {
        Self::Uncontrolled(reason)
    }
}

impl From<Refusal> for Ended {
    fn from(refusal: Refusal) -> Self {
        Self::Refusal(Box::new(refusal))
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::By(cause) => f.write_str(cause.text()),
            Self::Said(cause @ (EndCause::Lapsed | EndCause::MissionIs), text) => write!(f, "{} {text}", cause.text()),
            Self::Said(cause, text) => write!(f, "{}: {text}", cause.text()),
            Self::Refusal(refusal) => refusal.fmt(f),
            Self::Uncontrolled(reason) => f.write_str(reason.text()),
            Self::Frames(frames) => write_frames(f, frames),
        }
    }
}

fn write_frames(f: &mut fmt::Formatter<'_>, frames: &[FrameOutcome]) -> fmt::Result {
    match frames.len() {
        0 => return f.write_str("no frame was sent"),
        1 => f.write_str("1 frame")?,
        count => write!(f, "{count} frames")?,
    }
    let failed = frames
        .iter()
        .filter(|frame| **frame == FrameOutcome::FailedToSend)
        .count();
    if failed > 0 {
        write!(f, ", {failed} not sent")?;
    }
    for (index, frame) in frames.iter().enumerate() {
        f.write_str(if index == 0 { ": " } else { ", " })?;
        fmt::Display::fmt(frame, f)?;
    }
    Ok(())
}

impl fmt::Display for FrameOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unset => f.write_str("unset"),
            Self::Unacknowledged => f.write_str("unacknowledged"),
            Self::Acked => f.write_str("acked"),
            Self::FailedToSend => f.write_str("failed to send"),
            Self::Other(code) => write!(f, "status {code}"),
        }
    }
}

/// Why a request failed after it was sent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Failure {
    /// The vehicle refused it, or reported that it failed, in these words.
    Vehicle(String),
    /// The vehicle's plan does not name it, and core asked for that plan after the vehicle must have decided on it.
    NotInPlan,
    /// The sonars' payload controller or its client refused it, or did not do all of it, in these words.
    Sonar(String),
}

impl Failure {
    /// Its name in logs and for plugins.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Vehicle(_) => "vehicle",
            Self::NotInPlan => "not-in-plan",
            Self::Sonar(_) => "sonar",
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vehicle(text) | Self::Sonar(text) => f.write_str(text),
            Self::NotInPlan => f.write_str("it is not in the vehicle's plan"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_the_same_in_the_log() {
        for cause in EndCause::ALL {
            assert_eq!(serde_json::to_value(cause).unwrap(), cause.name());
            let same = EndCause::ALL.iter().filter(|other| other.name() == cause.name());
            assert_eq!(same.count(), 1);
        }
    }
}

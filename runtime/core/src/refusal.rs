//! Why a request is refused before it is sent: data that ledger, log and plugins carry whole. Its line of text is made
//! where people read it.

mod boxes;
mod figure;
mod reason;

use std::fmt;

pub use backseat_fence::{EdgePlace, Rule as ZoneRule, ZoneBreach};
use serde::{Deserialize, Serialize};

pub use boxes::{BoxBreach, BoxEdge, Stretch};
pub use figure::{Figure, FigureBreach};
pub use reason::{Reason, Uncontrolled};

use crate::monitor::limits::Grant;

/// Why a request is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// Its geometry breaches a zone of the fence.
    Zone(Box<ZoneBreach>),
    /// Its geometry leaves a box of the mission's limits for vehicles that hover, or comes into one.
    Box(Box<BoxBreach>),
    /// A figure is out of its range: of the request, of the mission's limits, or of what is left of a cap or a rate.
    Figure(FigureBreach),
    /// There is no control.
    Uncontrolled(Uncontrolled),
    /// The mission does not grant it.
    NotGranted(Grant),
    /// The state of things does not allow it.
    State(Reason),
    /// The state of things does not allow it for so much longer.
    Until {
        /// What does not.
        reason: Reason,
        /// For how long, seconds.
        left_s: f64,
    },
    /// A text holds a command's name in capitals, which some vehicles act on wherever it stands.
    CommandInText {
        /// The name's letters: `RMB`.
        letters: String,
        /// Where it begins, bytes from the text's start.
        at: usize,
    },
    /// What is asked for cannot be written as a sentence; why.
    Unwritable(String),
    /// It would delay this request of an insert into a time for which that was not judged.
    Delays {
        /// The request's number in this run.
        request: u64,
    },
    /// The way back from an insert that waits, onto what this request would interrupt, does not hold.
    WayBack(Box<Refusal>),
}

/// Which rule of the safety monitor refuses a request: what a plugin branches on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// It would leave the fence's keep-in zones.
    KeepIn,
    /// It would come into a keep-out zone.
    KeepOut,
    /// It would be shallower or deeper than a keep-in zone allows.
    Depth,
    /// It would be nearer to the bottom than a keep-in zone allows.
    Altitude,
    /// The vehicle would surface where no zone allows it.
    Surfacing,
    /// A zone is not valid for the whole of the time.
    Time,
    /// It would leave the box of a vehicle that hovers, or come into one to be kept out of.
    Station,
    /// A figure is out of its range.
    Limit,
    /// The mission does not grant it.
    Grant,
    /// There is no control.
    Control,
    /// The vehicle is outside the fence, and recovers.
    Recovery,
    /// Navigation is stale, unsteady or missing.
    Navigation,
    /// The vehicle's plan, or what it flies of it, is not known.
    Plan,
    /// Another plugin comes before this one.
    Priority,
    /// Requests come too often.
    Rate,
    /// The most of a mission, a plugin or a time is used up.
    Cap,
    /// The tag names another request, or none.
    Tag,
    /// What is flown may not be interrupted.
    Interrupt,
    /// No SPI identifier is reserved on disk.
    Identifier,
    /// The vehicle has not answered for an earlier insert.
    Doubt,
    /// A GPS hit is flown.
    GpsHit,
    /// No acoustic window is open.
    Window,
    /// A text cannot be sent.
    Text,
    /// The vehicle has just refused a modify, or not answered one.
    Pause,
    /// The vehicle does not answer, and what is asked for cannot be taken back.
    Heard,
    /// The mission does not say how the vehicle reads a sentence.
    Layout,
    /// Its plugin has failed.
    Plugin,
    /// The state of the vehicle or of an earlier request does not allow it.
    State,
}

impl Rule {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::KeepIn,
        Self::KeepOut,
        Self::Depth,
        Self::Altitude,
        Self::Surfacing,
        Self::Time,
        Self::Station,
        Self::Limit,
        Self::Grant,
        Self::Control,
        Self::Recovery,
        Self::Navigation,
        Self::Plan,
        Self::Priority,
        Self::Rate,
        Self::Cap,
        Self::Tag,
        Self::Interrupt,
        Self::Identifier,
        Self::Doubt,
        Self::GpsHit,
        Self::Window,
        Self::Text,
        Self::Pause,
        Self::Heard,
        Self::Layout,
        Self::Plugin,
        Self::State,
    ];

    /// As logs and texts name it: `gps-hit`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::KeepIn => "keep-in",
            Self::KeepOut => "keep-out",
            Self::Depth => "depth",
            Self::Altitude => "altitude",
            Self::Surfacing => "surfacing",
            Self::Time => "time",
            Self::Station => "station",
            Self::Limit => "limit",
            Self::Grant => "grant",
            Self::Control => "control",
            Self::Recovery => "recovery",
            Self::Navigation => "navigation",
            Self::Plan => "plan",
            Self::Priority => "priority",
            Self::Rate => "rate",
            Self::Cap => "cap",
            Self::Tag => "tag",
            Self::Interrupt => "interrupt",
            Self::Identifier => "identifier",
            Self::Doubt => "doubt",
            Self::GpsHit => "gps-hit",
            Self::Window => "window",
            Self::Text => "text",
            Self::Pause => "pause",
            Self::Heard => "heard",
            Self::Layout => "layout",
            Self::Plugin => "plugin",
            Self::State => "state",
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Refusal {
    /// The rule that refuses.
    #[must_use]
    pub fn rule(&self) -> Rule {
        match self {
            Self::Zone(breach) => match breach.rule {
                ZoneRule::KeepIn => Rule::KeepIn,
                ZoneRule::KeepOut => Rule::KeepOut,
                ZoneRule::DepthMin | ZoneRule::DepthMax => Rule::Depth,
                ZoneRule::AltitudeMin => Rule::Altitude,
                ZoneRule::Surfacing => Rule::Surfacing,
                ZoneRule::Closed => Rule::Time,
                ZoneRule::NotFinite => Rule::Limit,
            },
            Self::Box(_) => Rule::Station,
            Self::Figure(breach) => breach.figure.rule(),
            Self::Uncontrolled(_) => Rule::Control,
            Self::NotGranted(_) => Rule::Grant,
            Self::State(reason) | Self::Until { reason, .. } => reason.rule(),
            Self::CommandInText { .. } | Self::Unwritable(_) => Rule::Text,
            Self::Delays { .. } => Rule::Time,
            Self::WayBack(refusal) => refusal.rule(),
        }
    }

    /// The name of what exactly refuses, for logs and for plugins that branch on more than the rule: a figure's
    /// (`speed`), a state's (`plan-unknown`), else the rule's.
    #[must_use]
    pub fn cause(&self) -> &'static str {
        match self {
            Self::Figure(breach) => breach.figure.name(),
            Self::Uncontrolled(reason) => reason.name(),
            Self::State(reason) | Self::Until { reason, .. } => reason.name(),
            Self::CommandInText { .. } => "command-in-text",
            Self::Unwritable(_) => "unwritable",
            Self::Delays { .. } => "delays",
            Self::WayBack(refusal) => refusal.cause(),
            Self::Zone(_) | Self::Box(_) | Self::NotGranted(_) => self.rule().name(),
        }
    }

    /// The zone, or the box, that is breached.
    #[must_use]
    pub fn zone(&self) -> Option<&str> {
        if let Self::Box(breach) = self.innermost() {
            Some(&breach.name)
        } else {
            self.zone_breach().and_then(|breach| breach.zone.as_deref())
        }
    }

    /// The breach of a fence's zone.
    #[must_use]
    pub fn zone_breach(&self) -> Option<&ZoneBreach> {
        if let Self::Zone(breach) = self.innermost() {
            Some(breach)
        } else {
            None
        }
    }

    /// The figure that is out of its range.
    #[must_use]
    pub fn figure_breach(&self) -> Option<&FigureBreach> {
        if let Self::Figure(breach) = self.innermost() {
            Some(breach)
        } else {
            None
        }
    }

    /// The nearest edge of the fence's zone that is breached.
    #[must_use]
    pub fn edge(&self) -> Option<EdgePlace> {
        self.zone_breach().and_then(|breach| breach.edge)
    }

    /// Of a figure: what it is, or would be.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.figure_breach().and_then(|breach| breach.value)
    }

    /// The least that is allowed: of a figure, of a zone's depth or altitude.
    #[must_use]
    pub fn least(&self) -> Option<f64> {
        self.bound(&[ZoneRule::DepthMin, ZoneRule::AltitudeMin])
            .or_else(|| self.figure_breach().and_then(|breach| breach.least))
    }

    /// The most that is allowed: of a figure, of a zone's depth.
    #[must_use]
    pub fn most(&self) -> Option<f64> {
        self.bound(&[ZoneRule::DepthMax])
            .or_else(|| self.figure_breach().and_then(|breach| breach.most))
    }

    fn bound(&self, of: &[ZoneRule]) -> Option<f64> {
        let breach = self.zone_breach().filter(|breach| of.contains(&breach.rule))?;
        breach.bound_m
    }

    /// How many metres are missing; `None` where metres are not its measure.
    #[must_use]
    pub fn missing_m(&self) -> Option<f64> {
        if let Self::Box(breach) = self.innermost() {
            breach.missing_m
        } else {
            self.zone_breach().and_then(|breach| breach.missing_m)
        }
    }

    /// What refuses, without the figures that differ from one refusal to the next: refusals of one summary are of one kind.
    #[must_use]
    pub fn summary(&self) -> String {
        match self.innermost() {
            Self::Zone(breach) => breach.summary(),
            Self::Box(breach) => format!("beyond {}", breach.name),
            Self::Figure(breach) => format!("{} out of its range", breach.figure.name()),
            Self::Until { reason, .. } => reason.text().to_owned(),
            Self::CommandInText { .. } => "a command's name in the text".to_owned(),
            Self::Unwritable(_) => "it cannot be written as a sentence".to_owned(),
            Self::Delays { .. } => "it would delay an insert".to_owned(),
            Self::Uncontrolled(_) | Self::NotGranted(_) | Self::State(_) | Self::WayBack(_) => {
                self.detail().to_string()
            }
        }
    }

    fn innermost(&self) -> &Self {
        if let Self::WayBack(refusal) = self {
            refusal.innermost()
        } else {
            self
        }
    }
}

/// Rule, a colon, then place and figures in one line.
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.rule(), self.detail())
    }
}

impl Refusal {
    /// Place and figures in one line, without the rule.
    #[must_use]
    pub const fn detail(&self) -> Detail<'_> {
        Detail(self)
    }
}

/// A refusal's text without its rule.
#[derive(Clone, Copy, Debug)]
pub struct Detail<'a>(&'a Refusal);

impl fmt::Display for Detail<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Refusal::Zone(breach) => breach.fmt(f),
            Refusal::Box(breach) => breach.fmt(f),
            Refusal::Figure(breach) => breach.fmt(f),
            Refusal::Uncontrolled(reason) => f.write_str(reason.text()),
            Refusal::NotGranted(grant) => write!(f, "the mission does not grant `{}`", grant.name()),
            Refusal::State(reason) => f.write_str(reason.text()),
            Refusal::Until { reason, left_s } => write!(f, "{}, for {left_s:.1} s more", reason.text()),
            Refusal::CommandInText { letters, at } => write!(
                f,
                "{letters} at byte {at} is a command's name, which some vehicles act on: write it in lower case"
            ),
            Refusal::Unwritable(why) => f.write_str(why),
            Refusal::Delays { request } => {
                write!(
                    f,
                    "it would delay insert {request} into a time for which that was not judged"
                )
            }
            Refusal::WayBack(refusal) => write!(f, "on the way back from an insert that waits: {}", refusal.detail()),
        }
    }
}

impl From<Reason> for Refusal {
    fn from(reason: Reason) -> Self {
        Self::State(reason)
    }
}

impl From<Uncontrolled> for Refusal {
    fn from(reason: Uncontrolled) -> Self {
        Self::Uncontrolled(reason)
    }
}

impl From<FigureBreach> for Refusal {
    fn from(breach: FigureBreach) -> Self {
        Self::Figure(breach)
    }
}

impl From<BoxBreach> for Refusal {
    fn from(breach: BoxBreach) -> Self {
        Self::Box(Box::new(breach))
    }
}

impl From<backseat_fence::Breach> for Refusal {
    fn from(breach: backseat_fence::Breach) -> Self {
        Self::Zone(Box::new(breach.report()))
    }
}

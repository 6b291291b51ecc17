//! Why a request is refused before it is sent, as data that ledger, log and plugins carry whole. Its line of text is
//! made where people read it.

mod boxes;
mod figure;
mod reason;

use std::fmt;

pub use backseat_fence::{EdgePlace, Rule as ZoneRule, ZoneBreach};
use serde::{Deserialize, Serialize};

pub use boxes::{BoxBreach, BoxEdge, Stretch};
pub use figure::{Figure, FigureBreach, NotFinite};
pub use reason::{Reason, Uncontrolled};

use crate::monitor::limits::Grant;

/// Why a request is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refusal {
    /// Its geometry breaches a zone of the fence.
    Zone(Box<ZoneBreach>),
    /// Its geometry leaves an allowed box of a hovering vehicle, or enters a forbidden one.
    Box(Box<BoxBreach>),
    /// A figure is out of its range: a figure of the request, one of the mission's limits, or what is left of a cap or
    /// a rate.
    Figure(FigureBreach),
    /// The backseat does not have control.
    Uncontrolled(Uncontrolled),
    /// The mission does not grant it.
    NotGranted(Grant),
    /// The state of the vehicle, of the runtime or of an earlier request does not allow it.
    State(Reason),
    /// Such a state does not allow it for this much longer.
    Until {
        /// The state.
        reason: Reason,
        /// For how much longer, seconds.
        left_s: f64,
    },
    /// A text contains the name of a command in capitals. Some vehicles act on such a name anywhere in a sentence.
    CommandInText {
        /// The name's letters: `RMB`.
        letters: String,
        /// Where the name begins, in bytes from the start of the text.
        at: usize,
    },
    /// The request cannot be written as a sentence, for this reason.
    Unwritable(String),
    /// It would delay this insert into a time for which the insert was not judged.
    Delays {
        /// The number of the insert's request in this run.
        request: u64,
    },
    /// The way back from a waiting insert onto what this request would interrupt is refused.
    WayBack(Box<Refusal>),
    /// The way to the request's geometry is refused.
    WayTo(Box<Refusal>),
    /// The way from the request's geometry back to the plan is refused.
    WayOn(Box<Refusal>),
}

/// The rule of the safety monitor that refuses a request. Plugins branch on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// It would leave the fence's keep-in zones.
    KeepIn,
    /// It would enter a keep-out zone.
    KeepOut,
    /// It would be shallower or deeper than a keep-in zone allows.
    Depth,
    /// It would be closer to the bottom than a keep-in zone allows.
    Altitude,
    /// The vehicle would surface where no zone allows it.
    Surfacing,
    /// A zone is not valid for all of the time that the request needs.
    Time,
    /// It would leave the allowed box of a hovering vehicle, or enter a forbidden one.
    Station,
    /// A figure is out of its range.
    Limit,
    /// The mission does not grant it.
    Grant,
    /// The backseat does not have control.
    Control,
    /// The vehicle is outside the fence and is being recovered.
    Recovery,
    /// Navigation is stale, unsteady or missing.
    Navigation,
    /// The vehicle's plan, or its current behavior, is unknown.
    Plan,
    /// Another plugin steers with higher priority, or already uses what is asked for.
    Priority,
    /// Requests come too often.
    Rate,
    /// A limit of the mission, the plugin or the time is used up.
    Cap,
    /// The tag belongs to another request, or to none.
    Tag,
    /// The current behavior may not be interrupted.
    Interrupt,
    /// No SPI identifier is reserved on disk.
    Identifier,
    /// It is unknown whether the vehicle has an earlier insert.
    Doubt,
    /// A GPS hit may be in progress.
    GpsHit,
    /// No acoustic window is open.
    Window,
    /// A text cannot be sent.
    Text,
    /// The vehicle has just refused a modify, or left one unanswered.
    Pause,
    /// The vehicle does not answer, and the request could not be taken back.
    Heard,
    /// The mission does not say which form of a sentence the vehicle understands.
    Layout,
    /// The plugin has failed.
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

    /// Its name in logs and texts: `gps-hit`.
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
            Self::WayBack(refusal) | Self::WayTo(refusal) | Self::WayOn(refusal) => refusal.rule(),
        }
    }

    /// The exact cause, for logs and for plugins that branch on more than the rule: the name of a figure (`speed`) or
    /// of a state (`plan-unknown`), otherwise the name of the rule.
    #[must_use]
    pub fn cause(&self) -> &'static str {
        match self {
            Self::Figure(breach) => breach.figure.name(),
            Self::Uncontrolled(reason) => reason.name(),
            Self::State(reason) | Self::Until { reason, .. } => reason.name(),
            Self::CommandInText { .. } => "command-in-text",
            Self::Unwritable(_) => "unwritable",
            Self::Delays { .. } => "delays",
            Self::WayBack(refusal) | Self::WayTo(refusal) | Self::WayOn(refusal) => refusal.cause(),
            Self::Zone(_) | Self::Box(_) | Self::NotGranted(_) => self.rule().name(),
        }
    }

    /// The zone or the box that the request breaches.
    #[must_use]
    pub fn zone(&self) -> Option<&str> {
        if let Self::Box(breach) = self.innermost() {
            Some(&breach.name)
        } else {
            self.zone_breach().and_then(|breach| breach.zone.as_deref())
        }
    }

    /// The breach of a zone of the fence.
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

    /// The nearest edge of the zone that the request breaches.
    #[must_use]
    pub fn edge(&self) -> Option<EdgePlace> {
        self.zone_breach().and_then(|breach| breach.edge)
    }

    /// The value of the figure, or what it would be.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        self.figure_breach().and_then(|breach| breach.value)
    }

    /// The least allowed value: of a figure, or of a zone's depth or altitude.
    #[must_use]
    pub fn least(&self) -> Option<f64> {
        self.bound(&[ZoneRule::DepthMin, ZoneRule::AltitudeMin])
            .or_else(|| self.figure_breach().and_then(|breach| breach.least))
    }

    /// The greatest allowed value: of a figure, or of a zone's depth.
    #[must_use]
    pub fn most(&self) -> Option<f64> {
        self.bound(&[ZoneRule::DepthMax])
            .or_else(|| self.figure_breach().and_then(|breach| breach.most))
    }

    fn bound(&self, of: &[ZoneRule]) -> Option<f64> {
        let breach = self.zone_breach().filter(|breach| of.contains(&breach.rule))?;
        breach.bound_m
    }

    /// How many metres are missing; `None` if the cause is not a distance.
    #[must_use]
    pub fn missing_m(&self) -> Option<f64> {
        if let Self::Box(breach) = self.innermost() {
            breach.missing_m
        } else {
            self.zone_breach().and_then(|breach| breach.missing_m)
        }
    }

    /// The cause without the figures that differ from one refusal to the next. Refusals of one kind have the same
    /// summary.
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
            Self::Uncontrolled(_)
            | Self::NotGranted(_)
            | Self::State(_)
            | Self::WayBack(_)
            | Self::WayTo(_)
            | Self::WayOn(_) => self.detail().to_string(),
        }
    }

    fn innermost(&self) -> &Self {
        if let Self::WayBack(refusal) | Self::WayTo(refusal) | Self::WayOn(refusal) = self {
            refusal.innermost()
        } else {
            self
        }
    }

    pub(crate) fn on_the_way_to(self) -> Self {
        Self::WayTo(Box::new(self))
    }

    pub(crate) fn on_the_way_on(self) -> Self {
        Self::WayOn(Box::new(self))
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
                    "it would delay insert {request} into a time for which that insert was not judged"
                )
            }
            Refusal::WayBack(refusal) => write!(f, "on the way back from a waiting insert: {}", refusal.detail()),
            Refusal::WayTo(refusal) => write!(f, "on the way to it: {}", refusal.detail()),
            Refusal::WayOn(refusal) => write!(f, "on the way back to the plan: {}", refusal.detail()),
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

use crate::{EndKind, Ended, Failure, Refusal, Rule, State};

impl State {
    /// Why the request was refused, has failed or has ended, in one line for people. To branch on the reason, use the
    /// state's own fields.
    #[must_use]
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Rejected(refusal) => Some(&refusal.text),
            Self::Failed(Failure::Vehicle(text) | Failure::Sonar(text)) => Some(text),
            Self::Failed(Failure::NotInPlan) => Some("the vehicle's plan does not name it"),
            Self::Ended(ended) => Some(&ended.text),
            Self::Sent
            | Self::Pending
            | Self::Accepted
            | Self::TimedOut
            | Self::Unknown
            | Self::Started
            | Self::Cancelled => None,
        }
    }
}

impl Refusal {
    /// A refusal by a rule without further values, for a plugin's own tests.
    #[must_use]
    pub fn new(rule: Rule, text: &str) -> Self {
        Self {
            rule,
            cause: String::new(),
            zone: None,
            edge: None,
            missing_m: None,
            value: None,
            least: None,
            most: None,
            text: text.to_owned(),
        }
    }
}

impl Ended {
    /// An end, for a plugin's own tests.
    #[must_use]
    pub fn new(kind: EndKind, text: &str) -> Self {
        Self {
            kind,
            cause: String::new(),
            frames: Vec::new(),
            text: text.to_owned(),
        }
    }
}

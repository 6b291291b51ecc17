use std::sync::LazyLock;

use crate::schema;

/// A channel of the log that [`crate::read`] reads. The log also has channels that are derived from these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// The bytes of one read from the link.
    FromVehicle,
    /// The bytes of one write to the link.
    ToVehicle,
    /// Every other input of core.
    Input,
    /// Every other output of core.
    Output,
    /// Notes other than those of the next two channels.
    Notes,
    /// New states of requests.
    Requests,
    /// Control gained and lost.
    Control,
    /// Navigation as the safety monitor uses it.
    Navigation,
    /// Values that only the simulation knows.
    Truth,
    /// Lines of the simulated vehicle's own log.
    Vehicle,
}

impl Channel {
    /// All channels, in the order of their MCAP identifiers.
    pub const ALL: [Self; 10] = [
        Self::FromVehicle,
        Self::ToVehicle,
        Self::Input,
        Self::Output,
        Self::Notes,
        Self::Requests,
        Self::Control,
        Self::Navigation,
        Self::Truth,
        Self::Vehicle,
    ];

    /// The channel's MCAP topic.
    #[must_use]
    pub const fn topic(self) -> &'static str {
        match self {
            Self::FromVehicle => "/link/from_vehicle",
            Self::ToVehicle => "/link/to_vehicle",
            Self::Input => "/core/input",
            Self::Output => "/core/output",
            Self::Notes => "/notes",
            Self::Requests => "/requests",
            Self::Control => "/control",
            Self::Navigation => "/navigation",
            Self::Truth => "/truth",
            Self::Vehicle => "/vehicle",
        }
    }

    /// The channel with this topic.
    #[must_use]
    pub fn from_topic(topic: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.topic() == topic)
    }

    /// The name and the text of the channel's JSON schema.
    #[must_use]
    pub fn schema(self) -> (&'static str, &'static str) {
        static TEXTS: LazyLock<[String; Channel::ALL.len()]> =
            LazyLock::new(|| Channel::ALL.map(|channel| channel.new_schema().to_string()));
        (self.schema_name(), &TEXTS[self as usize])
    }

    const fn schema_name(self) -> &'static str {
        match self {
            Self::FromVehicle | Self::ToVehicle => "backseat.Bytes",
            Self::Input => "backseat.Input",
            Self::Output => "backseat.Output",
            Self::Notes => "backseat.Note",
            Self::Requests => "backseat.Request",
            Self::Control => "backseat.Control",
            Self::Navigation => "backseat.Navigation",
            Self::Truth => "backseat.Truth",
            Self::Vehicle => "backseat.Vehicle",
        }
    }

    fn new_schema(self) -> serde_json::Value {
        match self {
            Self::FromVehicle | Self::ToVehicle => schema::bytes(),
            Self::Input => schema::input(),
            Self::Output => schema::output(),
            Self::Notes => schema::note(),
            Self::Requests => schema::request(),
            Self::Control => schema::control(),
            Self::Navigation => schema::navigation(),
            Self::Truth => schema::truth(),
            Self::Vehicle => schema::vehicle(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_distinct() {
        for channel in Channel::ALL {
            assert_eq!(Channel::from_topic(channel.topic()), Some(channel));
        }
        assert_eq!(Channel::from_topic("/position"), None, "derived channels are not read");
    }
}

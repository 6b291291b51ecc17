/// A channel of the log.
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

    /// The channel's MCAP message encoding.
    #[must_use]
    pub const fn encoding(self) -> &'static str {
        match self.schema() {
            Some(_) => "json",
            None => "application/octet-stream",
        }
    }

    /// The name and the text of the channel's JSON schema; `None` for raw bytes.
    #[must_use]
    pub const fn schema(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::FromVehicle | Self::ToVehicle => None,
            Self::Input => Some(("backseat.Input", INPUT)),
            Self::Output => Some(("backseat.Output", OUTPUT)),
            Self::Notes => Some(("backseat.Note", NOTE)),
            Self::Requests => Some(("backseat.Request", REQUEST)),
            Self::Control => Some(("backseat.Control", CONTROL)),
            Self::Navigation => Some(("backseat.Navigation", NAVIGATION)),
            Self::Truth => Some(("backseat.Truth", TRUTH)),
            Self::Vehicle => Some(("backseat.Vehicle", VEHICLE)),
        }
    }
}

const INPUT: &str = r#"{
  "type": "object",
  "description": "An input of core that is not bytes of the link.",
  "required": ["input"],
  "properties": {
    "input": {"enum": ["start", "link-up", "link-down", "returned", "restarted", "operator", "external", "reserved", "timeout", "gap"]},
    "plugin": {"type": "integer", "description": "Place in priority order, 0 first (returned, restarted)."},
    "returned": {"type": "object", "description": "Fuel, log lines, and requests or fault of a step."},
    "restarted": {"type": "object", "description": "Fuel, lost steps, and fault, if any, of a restart."},
    "act": {
      "type": ["string", "object"],
      "description": "What the operator did: hold, release, stop; or {\"order\": ...} for requests that no plugin may make."
    },
    "external": {"type": "integer", "description": "Place in the mission file, 0 first (external)."},
    "bytes": {"type": ["string", "array"], "description": "As text if they are UTF-8, else as numbers (external)."},
    "below": {"type": "integer", "description": "All SPI identifiers below this are reserved (reserved)."},
    "since_s": {"type": "number", "description": "Since when records are missing, seconds of the run (gap)."},
    "records": {"type": "integer", "description": "How many are missing (gap)."},
    "start": {"type": "object", "description": "What core was started with: UTC in ns, identifiers, armed, held, jitter."}
  }
}"#;

const OUTPUT: &str = r#"{
  "type": "object",
  "description": "An output of core that is neither bytes of the link nor a note.",
  "required": ["output"],
  "properties": {
    "output": {"enum": ["connect", "reset-link", "invoke", "external", "restart", "reserve", "finish"]},
    "plugin": {"type": "integer", "description": "Place in priority order, 0 first (invoke, restart)."},
    "step": {"type": "object", "description": "The step's whole input (invoke in a deployed log)."},
    "external": {"type": "integer", "description": "Place in the mission file, 0 first (external)."},
    "bytes": {"type": ["string", "array"], "description": "As text if they are UTF-8, else as numbers (external)."},
    "after_s": {"type": "number", "description": "Back-off, seconds (connect)."},
    "below": {"type": "integer", "description": "Reserve all SPI identifiers below this (reserve)."}
  }
}"#;

const NOTE: &str = r#"{
  "type": "object",
  "description": "An event of the run.",
  "required": ["text", "note"],
  "properties": {
    "text": {"type": "string", "description": "All of it in one line."},
    "note": {"type": "string", "description": "The kind of note; its own fields follow."}
  }
}"#;

const REQUEST: &str = r#"{
  "type": "object",
  "description": "A request of a plugin, the operator or an external source has a new state.",
  "required": ["text", "request", "owner", "tag", "kind", "state"],
  "properties": {
    "text": {"type": "string", "description": "All of it in one line."},
    "request": {"type": "integer", "description": "Its number in this run."},
    "owner": {"enum": ["plugin", "operator", "external"], "description": "Who made the request."},
    "plugin": {"type": "integer", "description": "Place in priority order, 0 first; only for a plugin."},
    "external": {"type": "integer", "description": "Place in the mission file, 0 first; only for an external source."},
    "tag": {"type": "integer", "description": "The number by which its owner knows it."},
    "kind": {"enum": [
      "modify", "trackline", "trackcircle", "cancel", "gps-hit", "cancel-all", "cancel-current", "cancel-element",
      "abort", "kill", "start-empty-mission", "topside", "relay", "dvl-trigger", "silent", "trim", "buoyancy", "packet",
      "station", "sonar-angle", "camera", "light", "position-fix", "payload-ctd", "relative-reset", "bearing-offset"
    ]},
    "identifier": {"type": ["integer", "null"], "description": "SPI identifier of an insert."},
    "state": {"enum": ["rejected", "sent", "pending", "accepted", "failed", "timed-out", "unknown", "started", "ended", "cancelled"]},
    "reason": {"type": ["string", "null"], "description": "Why it was rejected, failed or ended, in one line."},
    "why": {
      "type": "object",
      "description": "The same for programs. A rejected request also has zone, edge, value and range.",
      "properties": {
        "rule": {"type": "string", "description": "The rule of the monitor that rejected it."},
        "kind": {"type": "string", "description": "The way in which it ended."},
        "cause": {"type": "string", "description": "The name of the exact cause."}
      }
    }
  }
}"#;

const CONTROL: &str = r#"{
  "type": "object",
  "description": "Control of the vehicle was gained or lost.",
  "required": ["text", "granted", "reason"],
  "properties": {
    "text": {"type": "string"},
    "granted": {"type": "boolean", "description": "Requests can be sent."},
    "reason": {"type": "string", "description": "Why it was lost."},
    "cause": {"type": "string", "description": "The name of the reason, such as vehicle-has-control."}
  }
}"#;

const NAVIGATION: &str = r#"{
  "type": "object",
  "description": "Navigation as the safety monitor uses it (SPI 6.1, 6.2).",
  "properties": {
    "time_s": {"type": "number", "description": "When the solution was computed, since the start of the run."},
    "latitude_deg": {"type": "number"},
    "longitude_deg": {"type": "number"},
    "east_m": {"type": "number", "description": "In the fence's frame."},
    "north_m": {"type": "number", "description": "In the fence's frame."},
    "depth_m": {"type": "number"},
    "altitude_m": {"type": ["number", "null"], "description": "Null without bottom lock."},
    "heading_deg": {"type": "number", "description": "True."},
    "roll_deg": {"type": "number", "description": "Starboard down positive."},
    "pitch_deg": {"type": "number", "description": "Nose up positive."},
    "east_mps": {"type": "number", "description": "Over the ground."},
    "north_mps": {"type": "number", "description": "Over the ground."},
    "down_mps": {"type": "number"},
    "yaw_rate_dps": {"type": "number", "description": "Clockwise positive."},
    "gps": {"type": "boolean", "description": "The solution includes GPS."}
  }
}"#;

const TRUTH: &str = r#"{
  "type": "object",
  "description": "Values that only the simulation knows; the simulation defines the fields."
}"#;

const VEHICLE: &str = r#"{
  "type": "object",
  "description": "A line of the simulated vehicle's own log.",
  "required": ["text"],
  "properties": {"text": {"type": "string"}}
}"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemas_are_json_and_topics_are_distinct() {
        for channel in Channel::ALL {
            if let Some((_, schema)) = channel.schema() {
                let schema: serde_json::Value = serde_json::from_str(schema).unwrap();
                assert_eq!(schema["type"], "object", "{channel:?}");
            }
            assert_eq!(Channel::from_topic(channel.topic()), Some(channel));
        }
        assert_eq!(Channel::from_topic("/tf"), None);
    }
}

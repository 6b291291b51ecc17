use serde::{Deserialize, Serialize};

/// What the client could not use or had to drop, since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Bytes of the stream that belong to no record.
    pub skipped_bytes: u64,
    /// Records that are not what their type says, and texts that do not have their form.
    pub malformed: u64,
    /// Records whose checksum is claimed and wrong. The setting `checksum` says whether they were used.
    pub wrong_checksums: u64,
    /// Records of a type or a device that is not subscribed to.
    pub unsubscribed: u64,
    /// Imagery in the layout of the header that is not expected.
    pub other_layouts: u64,
    /// Channels of imagery whose samples have a form that is not read, or that are too many.
    pub unread_channels: u64,
    /// Acknowledgements that answer no command that waits.
    pub late_acknowledgements: u64,
    /// Statuses and alarms whose number the specification does not have.
    pub unknown_messages: u64,
    /// Pings that were dropped because the driver had not taken the earlier ones.
    pub dropped_pings: u64,
    /// Events that were dropped because there were too many.
    pub dropped_events: u64,
    /// Records of vehicle data that were dropped because the driver had not taken the earlier ones.
    pub dropped_sends: u64,
    /// Frames of vehicle data that were over a second old when they could be sent.
    pub old_frames: u64,
    /// Values of the vehicle that cannot be: not finite, or outside their range.
    pub impossible_values: u64,
    /// Inputs at which the driver did not follow the order of connections.
    pub unexpected_inputs: u64,
}

impl Counts {
    /// Every count with its meaning, in order.
    fn rows(&self) -> [(u64, &'static str); 14] {
        [
            (self.skipped_bytes, "bytes skipped"),
            (self.malformed, "malformed"),
            (self.wrong_checksums, "wrong checksums"),
            (self.unsubscribed, "unsubscribed"),
            (self.other_layouts, "in another layout"),
            (self.unread_channels, "unread channels"),
            (self.late_acknowledgements, "late acknowledgements"),
            (self.unknown_messages, "unknown messages"),
            (self.dropped_pings, "pings dropped"),
            (self.dropped_events, "events dropped"),
            (self.dropped_sends, "sends dropped"),
            (self.old_frames, "frames too old"),
            (self.impossible_values, "impossible values"),
            (self.unexpected_inputs, "unexpected inputs"),
        ]
    }
}

impl std::fmt::Display for Counts {
    /// `3 malformed, 12 unsubscribed`: what is not zero.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut first = true;
        for (count, meaning) in self.rows().into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{}{count} {meaning}", if first { "" } else { ", " })?;
            first = false;
        }
        if first { f.write_str("nothing") } else { Ok(()) }
    }
}

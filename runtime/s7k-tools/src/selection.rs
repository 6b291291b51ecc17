use backseat_s7k::FrameHeader;

use crate::moment::Moment;

/// Which records a command works on. An empty list, or no time, leaves none out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Record types.
    pub types: Vec<u32>,
    /// Device identifiers.
    pub devices: Vec<u32>,
    /// The first instant. A record without a time is left out if this or `to` is set.
    pub from: Option<Moment>,
    /// The instant before which the last record is.
    pub to: Option<Moment>,
}

impl Selection {
    /// Whether the record with this header is meant.
    #[must_use]
    pub fn contains(&self, header: &FrameHeader) -> bool {
        let listed = |list: &[u32], value: u32| list.is_empty() || list.contains(&value);
        listed(&self.types, header.record_type)
            && listed(&self.devices, header.device.0)
            && self.contains_time(Moment::of(&header.time))
    }

    /// Whether an instant is inside the limits of time.
    pub(crate) fn contains_time(&self, time: Option<Moment>) -> bool {
        match time {
            Some(time) => self.from.is_none_or(|from| time >= from) && self.to.is_none_or(|to| time < to),
            None => self.from.is_none() && self.to.is_none(),
        }
    }
}

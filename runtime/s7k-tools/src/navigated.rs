use backseat_s7k::FrameHeader;
use backseat_s7k::record::{BluefinData, NavigationField, Record};

use crate::moment::Moment;

/// When a recording has pings, and when it has positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Navigated {
    pings: Span,
    positions: Span,
}

type Span = Option<(Moment, Moment)>;

impl Navigated {
    pub(crate) fn add(&mut self, header: &FrameHeader, record: &Record<'_>) {
        match record {
            Record::SideScan(_) | Record::SubBottom(_) => widen(&mut self.pings, Moment::of(&header.time)),
            Record::Bluefin(record) => {
                for frame in record.frames() {
                    if let BluefinData::Navigation(navigation) = frame.data
                        && navigation.quality.contains(NavigationField::Latitude)
                        && navigation.quality.contains(NavigationField::Longitude)
                    {
                        let time = Moment::of(&frame.header.time).or_else(|| Moment::of(&header.time));
                        widen(&mut self.positions, time);
                    }
                }
            }
            Record::FileHeader(_)
            | Record::Catalog(_)
            | Record::Time(..)
            | Record::Command(_)
            | Record::Acknowledge(..)
            | Record::Message(_)
            | Record::Other(_) => {}
        }
    }

    /// Why no ping of the recording can be placed on a map, if so.
    pub(crate) fn warning(&self) -> Option<String> {
        let (first, last) = self.pings?;
        let Some((from, to)) = self.positions else {
            return Some("the pings have no navigation: no record 3100 has a valid position".to_owned());
        };
        (to < first || last < from).then(|| {
            format!(
                "navigation and pings do not overlap in time: positions from {from} to {to}, pings from {first} to \
                 {last}; compare the clocks"
            )
        })
    }
}

fn widen(span: &mut Span, time: Option<Moment>) {
    if let Some(time) = time {
        let (first, last) = span.unwrap_or((time, time));
        *span = Some((first.min(time), last.max(time)));
    }
}

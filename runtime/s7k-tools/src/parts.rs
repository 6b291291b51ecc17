//! The fixed parts of a record with their places, to say where a value is that is outside its range.

use backseat_s7k::record::{BluefinData, BluefinRecord, CatalogHeader, FileHeader, Imagery, Record, SegyHeader};
use backseat_s7k::record::{
    BluefinFrameHeader, BluefinHeader, CatalogEntry, ChannelHeader, FileDevice, SideScanHeader,
};
use backseat_s7k::{FieldFault, Frame, layouts};

/// A value outside its range, and its place in bytes from the frame's start.
pub(crate) type PlacedFault = (usize, FieldFault);

/// The values of a frame and its record that are outside their ranges.
pub(crate) fn faults(frame: &Frame<'_>, record: &Record<'_>) -> Vec<PlacedFault> {
    let mut found = Vec::new();
    add(&mut found, 0, frame.header().faults());
    let Ok(body) = frame.body() else {
        return found;
    };
    let at = |part: &[u8]| part.as_ptr().addr().saturating_sub(frame.bytes().as_ptr().addr());
    let body_at = at(body);
    match record {
        Record::SideScan(imagery) | Record::SubBottom(imagery) => {
            add(&mut found, body_at, imagery.header.faults());
            for channel in imagery.channels() {
                add(
                    &mut found,
                    at(channel.bytes) - ChannelHeader::SIZE,
                    channel.header.faults(),
                );
            }
            if let Some(optional) = imagery.optional() {
                edgetech(&mut found, at(optional.bytes), imagery);
            }
        }
        Record::Bluefin(record) => bluefin(&mut found, body_at, record),
        Record::FileHeader(record) => {
            add(&mut found, body_at, record.header.faults());
            for (index, device) in record.devices().enumerate() {
                add(
                    &mut found,
                    body_at + FileHeader::SIZE + index * FileDevice::SIZE,
                    device.faults(),
                );
            }
        }
        Record::Catalog(record) => {
            add(&mut found, body_at, record.header.faults());
            for (index, entry) in record.entries().enumerate() {
                add(
                    &mut found,
                    body_at + CatalogHeader::SIZE + index * CatalogEntry::SIZE,
                    entry.faults(),
                );
            }
        }
        Record::Time(time, _) => add(&mut found, body_at, time.faults()),
        Record::Command(record) => add(&mut found, body_at, record.header.faults()),
        Record::Acknowledge(acknowledge, _) => add(&mut found, body_at, acknowledge.faults()),
        Record::Message(record) => add(&mut found, body_at, record.header.faults()),
        Record::Other(_) => {}
    }
    found
}

fn edgetech(found: &mut Vec<PlacedFault>, at: usize, imagery: &Imagery<'_>) {
    for (index, header) in imagery.side_scan_headers().enumerate() {
        add(found, at + index * SideScanHeader::SIZE, header.faults());
    }
    for (index, header) in imagery.segy_headers().enumerate() {
        add(found, at + index * SegyHeader::SIZE, header.faults());
    }
}

fn bluefin(found: &mut Vec<PlacedFault>, at: usize, record: &BluefinRecord<'_>) {
    add(found, at, record.header.faults());
    for (index, frame) in record.frames().enumerate() {
        let frame_at = at + BluefinHeader::SIZE + index * record.header.frame_size as usize;
        add(found, frame_at, frame.header.faults());
        let data_at = frame_at + usize::from(frame.header.offset).max(BluefinFrameHeader::SIZE);
        match frame.data {
            BluefinData::Navigation(navigation) => add(found, data_at, navigation.faults()),
            BluefinData::Environment(environment) => add(found, data_at, environment.faults()),
            BluefinData::Other(_) => {}
        }
    }
}

fn add(found: &mut Vec<PlacedFault>, at: usize, faults: Vec<FieldFault>) {
    found.extend(faults.into_iter().map(|fault| (at + offset(&fault), fault)));
}

/// Where the field lies in its part.
fn offset(fault: &FieldFault) -> usize {
    layouts()
        .find(|layout| layout.name == fault.layout)
        .and_then(|layout| {
            layout
                .offsets()
                .find(|(_, field)| field.name == fault.field)
                .map(|(at, _)| at)
        })
        .unwrap_or(0)
}

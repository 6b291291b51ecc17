//! The fields of a record, as `dump` writes them.

use backseat_s7k::Frame;
use backseat_s7k::record::{
    Acknowledge, BluefinData, BluefinFrameHeader, BluefinHeader, BluefinRecord, CatalogEntry, CatalogHeader,
    CatalogLocation, ChannelHeader, CommandHeader, EnvironmentFrame, FileDevice, FileHeader, HeaderLayout, Imagery,
    ImageryHeader, MessageHeader, NavigationFrame, Record, Samples, SegyHeader, SideScanHeader, TimeMessage,
};
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

/// A record's fields.
#[derive(Serialize)]
#[serde(untagged)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack until its line is written"
)]
pub(super) enum Content<'a> {
    Imagery {
        header: ImageryHeader,
        layout: HeaderLayout,
        channels: Vec<Channel<'a>>,
        optional: Option<Optional<'a>>,
    },
    Bluefin {
        header: BluefinHeader,
        frames: Vec<BluefinFrame<'a>>,
    },
    FileHeader {
        header: FileHeader,
        devices: Vec<FileDevice>,
        catalog: Option<CatalogLocation>,
    },
    Catalog {
        header: CatalogHeader,
        entries: Vec<CatalogEntry>,
    },
    Time {
        header: TimeMessage,
    },
    Command {
        header: CommandHeader,
        text: std::borrow::Cow<'a, str>,
    },
    Acknowledge {
        header: Acknowledge,
    },
    Message {
        header: MessageHeader,
        text: std::borrow::Cow<'a, str>,
    },
    Other {
        data: Hex<'a>,
        optional: Option<Hex<'a>>,
    },
}

#[derive(Serialize)]
pub(super) struct Channel<'a> {
    header: ChannelHeader,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<Numbers<'a>>,
}

/// EdgeTech's headers, or other optional data.
#[derive(Serialize)]
pub(super) struct Optional<'a> {
    id: u32,
    #[serde(flatten)]
    content: OptionalContent<'a>,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum OptionalContent<'a> {
    SideScan(Vec<SideScanHeader>),
    Segy(Vec<SegyHeader>),
    Data(Hex<'a>),
}

#[derive(Serialize)]
pub(super) struct BluefinFrame<'a> {
    header: BluefinFrameHeader,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality_bits: Option<u32>,
    #[serde(flatten)]
    data: BluefinContent<'a>,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum BluefinContent<'a> {
    Navigation(NavigationFrame),
    Environment(EnvironmentFrame),
    Data(Hex<'a>),
}

/// Bytes as hexadecimal digits.
pub(super) struct Hex<'a>(&'a [u8]);

impl Serialize for Hex<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let digits: String = self.0.iter().map(|byte| format!("{byte:02x}")).collect();
        serializer.serialize_str(&digits)
    }
}

/// Samples as numbers, or as pairs of in-phase and quadrature.
pub(super) struct Numbers<'a>(Samples<'a>);

impl Serialize for Numbers<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.len()))?;
        match self.0 {
            Samples::U8(samples) => samples.iter().try_for_each(|sample| list.serialize_element(sample)),
            Samples::I8(samples) => samples
                .iter()
                .try_for_each(|sample| list.serialize_element(&sample.cast_signed())),
            Samples::U16(samples) => samples
                .iter()
                .try_for_each(|sample| list.serialize_element(&u16::from_le_bytes(*sample))),
            Samples::I16(samples) => samples
                .iter()
                .try_for_each(|sample| list.serialize_element(&i16::from_le_bytes(*sample))),
            Samples::U32(samples) => samples
                .iter()
                .try_for_each(|sample| list.serialize_element(&u32::from_le_bytes(*sample))),
            Samples::I32(samples) => samples
                .iter()
                .try_for_each(|sample| list.serialize_element(&i32::from_le_bytes(*sample))),
            Samples::Complex16(_) => self.0.complex().try_for_each(|pair| list.serialize_element(&pair)),
            Samples::Raw {
                bytes_per_sample,
                bytes,
            } => bytes
                .chunks(usize::from(bytes_per_sample.max(1)))
                .try_for_each(|sample| list.serialize_element(&Hex(sample))),
        }?;
        list.end()
    }
}

/// The fields of a record.
pub(super) fn content<'a>(record: &Record<'a>, frame: &Frame<'a>, samples: bool) -> Content<'a> {
    match record {
        Record::SideScan(imagery) | Record::SubBottom(imagery) => self::imagery(imagery, samples),
        Record::Bluefin(record) => bluefin(record),
        Record::FileHeader(record) => Content::FileHeader {
            header: record.header,
            devices: record.devices().collect(),
            catalog: record.catalog(),
        },
        Record::Catalog(record) => Content::Catalog {
            header: record.header,
            entries: record.entries().collect(),
        },
        Record::Time(time, _) => Content::Time { header: *time },
        Record::Command(record) => Content::Command {
            header: record.header,
            text: record.text(),
        },
        Record::Acknowledge(acknowledge, _) => Content::Acknowledge { header: *acknowledge },
        Record::Message(record) => Content::Message {
            header: record.header,
            text: record.text(),
        },
        Record::Other(body) => Content::Other {
            data: Hex(body),
            optional: frame.optional().ok().flatten().map(|optional| Hex(optional.bytes)),
        },
    }
}

fn imagery<'a>(imagery: &Imagery<'a>, samples: bool) -> Content<'a> {
    let optional = imagery.optional().map(|optional| Optional {
        id: optional.id,
        content: match optional.id {
            SideScanHeader::OPTIONAL_ID => OptionalContent::SideScan(imagery.side_scan_headers().collect()),
            SegyHeader::OPTIONAL_ID => OptionalContent::Segy(imagery.segy_headers().collect()),
            _ => OptionalContent::Data(Hex(optional.bytes)),
        },
    });
    let channels = imagery.channels().map(|channel| Channel {
        header: channel.header,
        samples: samples.then(|| Numbers(imagery.samples(&channel))),
    });
    Content::Imagery {
        header: imagery.header,
        layout: imagery.layout(),
        channels: channels.collect(),
        optional,
    }
}

fn bluefin<'a>(record: &BluefinRecord<'a>) -> Content<'a> {
    let frames = record.frames().map(|frame| BluefinFrame {
        header: frame.header,
        quality_bits: match &frame.data {
            BluefinData::Navigation(navigation) => Some(navigation.quality.0),
            BluefinData::Environment(environment) => Some(environment.quality.0),
            BluefinData::Other(_) => None,
        },
        data: match frame.data {
            BluefinData::Navigation(navigation) => BluefinContent::Navigation(navigation),
            BluefinData::Environment(environment) => BluefinContent::Environment(environment),
            BluefinData::Other(data) => BluefinContent::Data(Hex(data)),
        },
    });
    Content::Bluefin {
        header: record.header,
        frames: frames.collect(),
    }
}

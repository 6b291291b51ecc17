//! Sidescan (3000) and sub-bottom (3001) records: channels of samples (2.2, 2.3).

use super::edgetech::{SegyHeader, SideScanHeader};
use super::samples::Samples;
use super::{RecordError, RecordFault};
use crate::frame::Optional;
use crate::layout::{Range, layouts};
use crate::wire::{Chars, Reserved, codes};

codes! {
    /// What a sample of imagery is.
    pub enum SampleFormat: u32 {
        /// The envelope: one number a sample.
        0 Envelope,
        /// In-phase and quadrature: two numbers a sample.
        1 Complex,
    }

    /// The side that a channel looks to.
    pub enum ChannelSide: u8 {
        /// Port.
        0 Port,
        /// Starboard.
        1 Starboard,
    }

    /// What a channel's samples are spaced along.
    pub enum RangeKind: u8 {
        /// Slant range: along the ray.
        0 Slant,
        /// Ground range: along the seabed.
        1 Ground,
    }

    /// Whether samples have a sign.
    pub enum Polarity: u8 {
        /// They have.
        0 Bipolar,
        /// They have none.
        1 Unipolar,
    }
}

layouts! {
    /// The record type header of imagery.
    "Volume III, Tables 3 and 5" ImageryHeader imagery_header {
        /// A millisecond counter.
        time_ms: u32, "ms", Range::ANY;
        /// The ping's number, by the sonar.
        ping: u32, "count", Range::ANY;
        /// Number of channels that follow: usually 2 for sidescan, 1 for sub-bottom.
        channels: u32, "count", Range::ANY;
        /// Bytes that follow this header: channels with their headers, and optional data.
        channel_bytes: u32, "bytes", Range::ANY;
        /// What a sample is.
        data_format: SampleFormat, "code", Range::new(0.0, 1.0);
    }

    /// The header of each channel.
    "Volume III, Tables 4 and 6" ChannelHeader channel_header {
        /// The channel's number, from 0.
        number: u8, "index", Range::ANY;
        /// The side that it looks to.
        side: ChannelSide, "code", Range::new(0.0, 1.0);
        /// What its samples are spaced along.
        range_kind: RangeKind, "code", Range::new(0.0, 1.0);
        /// Whether samples have a sign.
        polarity: Polarity, "code", Range::new(0.0, 1.0);
        /// Bytes of each sample.
        bytes_per_sample: u8, "bytes", Range::new(1.0, 8.0);
        /// Reserved.
        reserved_1: Reserved<3>, "reserved", Range::ANY;
        /// Number of samples.
        samples: u32, "samples", Range::ANY;
        /// Time of the first sample after the ping.
        start_us: u32, "us", Range::ANY;
        /// Time between samples.
        sample_interval_us: u32, "us", Range::ANY;
        /// Slant range or ground range of the last sample.
        range_m: f32, "m", Range::new(0.0, f64::MAX);
        /// Full scale of the analogue signal; -1 if it is not used.
        full_scale_v: f32, "V", Range::new(-1.0, f64::MAX);
        /// The channel's name.
        name: Chars<16>, "text", Range::ANY;
        /// Reserved.
        reserved_2: Reserved<20>, "reserved", Range::ANY;
    }
}

/// How long the record type header of imagery is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HeaderLayout {
    /// 20 bytes, as in Volume III.
    #[default]
    Spec,
    /// 32 bytes: 12 more, unspecified, as the best-known public reader expects since 2004.
    Padded,
}

impl HeaderLayout {
    /// How many bytes follow the fields of the header.
    #[must_use]
    pub const fn padding(self) -> usize {
        match self {
            Self::Spec => 0,
            Self::Padded => 12,
        }
    }
}

/// Imagery, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imagery<'a> {
    /// The record type header.
    pub header: ImageryHeader,
    /// What follows the header's fields: nothing, or twelve bytes.
    padding: &'a [u8],
    channels: &'a [u8],
    optional: Option<Optional<'a>>,
}

/// One channel of imagery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel<'a> {
    /// Its header.
    pub header: ChannelHeader,
    /// Its samples as they lie in the record.
    pub bytes: &'a [u8],
}

impl<'a> Imagery<'a> {
    pub(super) fn read(record_type: u32, body: &'a [u8], optional: Option<Optional<'a>>) -> Result<Self, RecordError> {
        let fail = |at: usize, fault: RecordFault| RecordError { record_type, at, fault };
        let header = ImageryHeader::read(body).map_err(|error| fail(0, error.into()))?;
        let behind = &body[ImageryHeader::SIZE..];
        // The layout is the one in which the channels end where the record does.
        let mut first_fault = None;
        for layout in [HeaderLayout::Spec, HeaderLayout::Padded] {
            let Some((padding, channels)) = behind.split_at_checked(layout.padding()) else {
                continue;
            };
            match walk(header.channels, channels) {
                Ok(()) => {
                    return Ok(Self {
                        header,
                        padding,
                        channels,
                        optional,
                    });
                }
                Err((at, fault)) => first_fault = first_fault.or(Some((ImageryHeader::SIZE + at, fault))),
            }
        }
        let (at, fault) = first_fault.unwrap_or((0, RecordFault::Rest { bytes: behind.len() }));
        Err(fail(at, fault))
    }

    /// How long the record type header is.
    #[must_use]
    pub const fn layout(&self) -> HeaderLayout {
        if self.padding.is_empty() {
            HeaderLayout::Spec
        } else {
            HeaderLayout::Padded
        }
    }

    /// The channels, in order.
    pub fn channels(&self) -> impl Iterator<Item = Channel<'a>> + Clone + use<'a> {
        let mut rest = self.channels;
        core::iter::from_fn(move || {
            // `read` has walked over all of them.
            let header = ChannelHeader::read(rest).ok()?;
            let (bytes, behind) = rest[ChannelHeader::SIZE..].split_at_checked(header.sample_bytes()?)?;
            rest = behind;
            Some(Channel { header, bytes })
        })
    }

    /// A channel with its samples in the form that the record says.
    #[must_use]
    pub fn samples(&self, channel: &Channel<'a>) -> Samples<'a> {
        Samples::of(self.header.data_format, &channel.header, channel.bytes)
    }

    /// The optional data.
    #[must_use]
    pub const fn optional(&self) -> Option<Optional<'a>> {
        self.optional
    }

    /// EdgeTech's sidescan headers, one a channel; none if the optional data are of another kind.
    pub fn side_scan_headers(&self) -> impl Iterator<Item = SideScanHeader> + use<'a> {
        let bytes = self
            .optional
            .filter(|optional| optional.id == SideScanHeader::OPTIONAL_ID);
        let bytes = bytes.map_or(&[][..], |optional| optional.bytes);
        bytes
            .chunks(SideScanHeader::SIZE)
            .filter_map(|header| SideScanHeader::read(header).ok())
    }

    /// EdgeTech's SEG-Y headers, one a channel; none if the optional data are of another kind.
    pub fn segy_headers(&self) -> impl Iterator<Item = SegyHeader> + use<'a> {
        let bytes = self.optional.filter(|optional| optional.id == SegyHeader::OPTIONAL_ID);
        let bytes = bytes.map_or(&[][..], |optional| optional.bytes);
        bytes
            .chunks(SegyHeader::SIZE)
            .filter_map(|header| SegyHeader::read(header).ok())
    }

    /// Appends the record as it was read.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.padding);
        out.extend_from_slice(self.channels);
    }

    /// Appends a record of these channels. The header's count of channels and of bytes are filled in; the samples'
    /// number is the caller's.
    ///
    /// # Errors
    /// [`RecordFault::Samples`] if a channel's bytes are not its number of samples.
    pub fn compose(
        header: ImageryHeader,
        layout: HeaderLayout,
        channels: &[Channel<'_>],
        optional_bytes: usize,
        out: &mut Vec<u8>,
    ) -> Result<(), RecordFault> {
        let count = |number: usize| u32::try_from(number).map_err(|_| RecordFault::Rest { bytes: number });
        for (index, channel) in channels.iter().enumerate() {
            if channel.header.sample_bytes() != Some(channel.bytes.len()) {
                return Err(RecordFault::samples(index, &channel.header, channel.bytes.len()));
            }
        }
        let bytes: usize = channels
            .iter()
            .map(|channel| ChannelHeader::SIZE + channel.bytes.len())
            .sum();
        let channel_bytes = count(bytes + optional_bytes)?;
        ImageryHeader {
            channels: count(channels.len())?,
            channel_bytes,
            ..header
        }
        .write(out);
        out.resize(out.len() + layout.padding(), 0);
        for channel in channels {
            channel.header.write(out);
            out.extend_from_slice(channel.bytes);
        }
        Ok(())
    }
}

impl ChannelHeader {
    /// Bytes of the samples; `None` if the product does not fit.
    fn sample_bytes(&self) -> Option<usize> {
        usize::try_from(self.samples)
            .ok()?
            .checked_mul(usize::from(self.bytes_per_sample))
    }
}

impl RecordFault {
    fn samples(channel: usize, header: &ChannelHeader, found: usize) -> Self {
        Self::Samples {
            channel,
            samples: header.samples,
            bytes_per_sample: header.bytes_per_sample,
            found,
        }
    }
}

/// Goes over so many channels, which must end where the bytes do.
fn walk(count: u32, bytes: &[u8]) -> Result<(), (usize, RecordFault)> {
    let mut rest = bytes;
    let mut index = 0_usize;
    while u32::try_from(index).is_ok_and(|index| index < count) {
        let at = bytes.len() - rest.len();
        let header = ChannelHeader::read(rest).map_err(|error| (at, error.into()))?;
        let behind = &rest[ChannelHeader::SIZE..];
        let samples = header.sample_bytes().and_then(|length| behind.get(length..));
        rest = samples.ok_or_else(|| (at, RecordFault::samples(index, &header, behind.len())))?;
        index += 1;
    }
    if rest.is_empty() {
        Ok(())
    } else {
        Err((bytes.len() - rest.len(), RecordFault::Rest { bytes: rest.len() }))
    }
}
